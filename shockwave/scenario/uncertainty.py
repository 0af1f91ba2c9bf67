"""Uncertainties: the block of a scenario that says how well its values are known."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, Literal

from attrs import frozen

from shockwave.errors import InvalidValueError, nearest
from shockwave.fields import Quantity, text_of
from shockwave.scenario.units import to_si
from shockwave.scenario.variable import Variable, variable
from shockwave.scenario.yaml_document import Steps
from shockwave.text import si

__all__ = ["FORMS", "TWINS", "Add", "Spread", "read"]

Kind = Literal["relative", "sd", "factor", "between"]
#: Adds a fault: where below the block, what is wrong, and whether the key is.
Add = Callable[[Steps, str, bool], None]

_RELATIVE = Quantity("", "standard deviation over the value", above=0, at_most=1)
_FACTOR = Quantity("", "factor within which two thirds of the values lie", above=1, at_most=100)
#: Mappings that a value may be -> what they mean.
FORMS: Final = {
    "sd": "standard deviation of a normal distribution, in the unit of the value",
    "between": "least and greatest, between which all values are as likely",
    "factor": "e to the standard deviation of the logarithm, of a lognormal distribution",
}
_RULE = "must be a percentage such as 5 %, or a mapping {sd: ...}, {between: [..., ...]} or {factor: ...}"
#: Names of which one scene has one.
TWINS: Final = (("chain.diameter", "chain.radius"), ("shock.duration", "shock.rise_time"))


@frozen
class Spread:
    """How a value is distributed about that of the scenario.

    Attributes
    ----------
    variable : Variable
        Which.
    kind : "relative", "sd", "factor" or "between"
        Normal with a standard deviation over the value, or with one in SI units; lognormal; uniform.
    numbers : tuple of float
        The one that goes with it, for ``between`` two.
    """

    variable: Variable
    kind: Kind
    numbers: tuple[float, ...]

    @property
    def name(self) -> str:
        """Dotted name of the value."""
        return self.variable.name

    def __str__(self) -> str:
        first, unit = self.numbers[0], self.variable.unit or ""
        if self.kind == "relative":
            return f"sd {100 * first:g} %"
        if self.kind == "factor":
            return f"factor {first:g}"
        shown = [si(number, unit).rstrip() if unit else f"{number:g}" for number in self.numbers]
        return f"sd {shown[0]}" if self.kind == "sd" else f"{shown[0]} to {shown[1]}"


def read(given: Any, data: Mapping[str, Any], add: Add) -> tuple[Spread, ...]:
    """The spreads of a block.

    Parameters
    ----------
    given : object
        What the block holds.
    data : mapping
        What the document holds.
    add : callable
        Takes up what is wrong.
    """
    if not isinstance(given, Mapping) or not given:
        add((), f"must be a mapping of dotted names to how well they are known (got {text_of(given)})", False)
        return ()
    for pair in TWINS:
        if all(name in given for name in pair):
            add((pair[0],), f"must be left out where {pair[1]} is given (got both; delete one)", True)
    found = (_spread(name, one, data, add) for name, one in given.items())
    return tuple(spread for spread in found if spread is not None)


def _spread(name: Any, given: Any, data: Mapping[str, Any], add: Add) -> Spread | None:
    try:
        of = variable(name, data)
    except InvalidValueError as error:
        add((name,), error.faults[0].problem, True)
        return None
    block = name.partition(".")[0]
    if of.unit is None or block not in ("chain", "shock") or (of.key.spec is not None and of.key.spec.whole):
        add((name,), f"must be a value of the chain or the shock that can lie anywhere in a range (got {name})", True)
        return None
    kind, wanted = _form(given)
    if kind is None:
        hint = nearest(str(next(iter(given), "")), FORMS) if isinstance(given, Mapping) else ""
        add((name,), f"{_RULE} (got {text_of(given)}{f'; {hint.strip()}' if hint else ''})", False)
        return None
    steps: Steps = (name,) if kind == "relative" else (name, kind)
    numbers = _between(steps, of, wanted, add) if kind == "between" else _one(steps, of, kind, wanted, add)
    return Spread(of, kind, numbers) if numbers else None


def _form(given: Any) -> tuple[Kind | None, Any]:
    if isinstance(given, str) and given.strip().endswith("%"):
        return "relative", given
    if isinstance(given, Mapping) and len(given) == 1:
        for kind in ("sd", "between", "factor"):
            if kind in given:
                return kind, given[kind]
    return None, None


def _one(steps: Steps, of: Variable, kind: Kind, given: Any, add: Add) -> tuple[float, ...]:
    """The number, or nothing where it is at fault."""
    unit = of.unit or ""
    specs = {"relative": _RELATIVE, "factor": _FACTOR, "sd": Quantity(unit, "standard deviation", above=0)}
    spec = specs[kind]
    try:
        number = to_si(given, spec.unit)
    except ValueError as error:
        add(steps, str(error), False)
        return ()
    if spec.problem(number) is not None:
        rule = "above 0 % and at most 100 %" if kind == "relative" else spec.rule
        add(steps, f"must be {rule} (got {text_of(given)})", False)
        return ()
    return (number,)


def _between(steps: Steps, of: Variable, given: Any, add: Add) -> tuple[float, ...]:
    if not isinstance(given, list | tuple) or len(given) != 2:
        add(steps, f"must be a list of the least and the greatest value (got {text_of(given)})", False)
        return ()
    ends: list[float] = []
    for index, one in enumerate(given):
        try:
            ends.append(of.value(one))
        except InvalidValueError as error:
            add((*steps, index), error.faults[0].problem, False)
    if len(ends) < 2:
        return ()
    if not ends[0] < ends[1]:
        add(steps, f"must ascend (got {text_of(given)})", False)
        return ()
    return tuple(ends)
