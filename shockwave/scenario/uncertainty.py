"""Uncertainties: the block of a scenario that says how well its values are known."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final, Literal

from attrs import frozen

from shockwave.errors import nearest
from shockwave.fields import Quantity, text_of
from shockwave.scenario.block_keys import Key
from shockwave.scenario.dotted_names import Variable, variables
from shockwave.scenario.value_conversion import Wrong, WrongsError, converted, gathered, items
from shockwave.text import si

Kind = Literal["relative", "sd", "factor", "between"]

_RELATIVE = Key("relative", spec=Quantity("", "standard deviation over the value", above=0, at_most=1))
_FACTOR = Key("factor", spec=Quantity("", "factor within which two thirds of the values lie", above=1, at_most=100))
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
        One number, for ``between`` two.
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


def read(given: Any, data: Mapping[str, Any]) -> tuple[Spread, ...]:
    """The spreads of a block.

    Parameters
    ----------
    given : object
        What the block holds.
    data : mapping
        What the document holds.

    Raises
    ------
    WrongsError
        With everything that is wrong.
    """
    if not isinstance(given, Mapping) or not given:
        problem = f"must be a mapping of dotted names to how well they are known (got {text_of(given)})"
        raise WrongsError([Wrong((), problem)])
    twins = [
        Wrong((one,), f"must be left out where {other} is given (got both; delete one)", at_key=True)
        for one, other in TWINS
        if one in given and other in given
    ]
    converters = {name: partial(_spread, of) for name, of in variables(data).items()}
    return tuple(gathered(given.items(), converters, twins).values())


def _spread(of: Variable, given: Any) -> Spread:
    if of.unit is None or of.whole or not of.name.startswith(("chain.", "shock.")):
        problem = f"must be a value of the chain or the shock that can lie anywhere in a range (got {of.name})"
        raise WrongsError([Wrong((), problem, at_key=True)])
    if isinstance(given, str) and given.strip().endswith("%"):
        return Spread(of, "relative", (converted(_RELATIVE, given),))
    forms: dict[str, Callable[[Any], Any]] = {
        "sd": partial(converted, Key("sd", spec=Quantity(of.unit, "standard deviation", above=0))),
        "factor": partial(converted, _FACTOR),
        "between": partial(_ends, of),
    }
    if not isinstance(given, Mapping) or len(given) != 1 or not given.keys() <= forms.keys():
        hint = nearest(str(next(iter(given), "")), FORMS).strip() if isinstance(given, Mapping) else ""
        raise ValueError(f"{_RULE} (got {text_of(given)}{'; ' if hint else ''}{hint})")
    ((kind, numbers),) = gathered(given.items(), forms).items()
    return Spread(of, kind, numbers if kind == "between" else (numbers,))


def _ends(of: Variable, given: Any) -> tuple[float, ...]:
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise ValueError(f"must be a list of the least and the greatest value (got {text_of(given)})")
    ends = items(given, of.converted)
    if not ends[0] < ends[1]:
        raise ValueError(f"must ascend (got {text_of(given)})")
    return tuple(ends)
