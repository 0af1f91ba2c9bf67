"""The ``uncertainty`` block of a scenario, with probability distributions of its values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final, Literal

from attrs import frozen

from shockwave.base.errors import Fault, InvalidValueError
from shockwave.base.quantity_fields import Declaration, text_of
from shockwave.base.text import si
from shockwave.scenario.block_keys import Key
from shockwave.scenario.dotted_names import Variable, variables
from shockwave.scenario.value_conversion import convert, gather, items

SpreadKind = Literal["relative", "sd", "factor", "between"]

_RELATIVE = Key("relative", spec=Declaration("", "relative standard deviation", above=0, at_most=1))
# Factor of the nominal value within which two thirds of the values lie.
_FACTOR = Key("factor", spec=Declaration("", "factor", above=1, at_most=100))
_RULE = "must be a percentage such as 5 %, or a mapping {sd: ...}, {between: [..., ...]} or {factor: ...}"
#: Pairs of names for one value.
TWINS: Final = (("chain.diameter", "chain.radius"), ("shock.duration", "shock.rise_time"))


@frozen
class Spread:
    """Probability distribution of a value.

    Attributes
    ----------
    variable : Variable
        The value.
    kind : "relative", "sd", "factor" or "between"
        Normal with a relative standard deviation, normal with one in SI units, lognormal, or uniform.
    numbers : tuple of float
        One number; two for ``between``.
    """

    variable: Variable
    kind: SpreadKind
    numbers: tuple[float, ...]

    @property
    def name(self) -> str:
        """Dotted name of the value."""
        return self.variable.name

    def __str__(self) -> str:
        if self.kind == "relative":
            return f"sd {100 * self.numbers[0]:g} %"
        if self.kind == "factor":
            return f"factor {self.numbers[0]:g}"
        unit = self.variable.unit
        shown = [si(number, unit) if unit else f"{number:g}" for number in self.numbers]
        return f"sd {shown[0]}" if self.kind == "sd" else " to ".join(shown)


def read(content: Any, data: Mapping[str, Any]) -> tuple[Spread, ...]:
    """Distributions of the ``uncertainty`` block.

    Parameters
    ----------
    content : object
        Content of the block; None if there is no block.
    data : mapping
        Content of the document.

    Raises
    ------
    InvalidValueError
        When the block is not valid; it contains all errors.
    """
    if content is None:
        return ()
    if not isinstance(content, Mapping) or not content:
        raise InvalidValueError(f"must be a mapping of dotted names to distributions (got {text_of(content)})")
    twins = [
        Fault((name,), f"must be left out if {other} is given (got both; delete one)", at_key=True)
        for name, other in dict.fromkeys((*TWINS, *((name, name.replace("diameter", "radius")) for name in content)))
        if name != other and name in content and other in content
    ]
    converters = {name: partial(_spread, of) for name, of in variables(data).items()}
    return tuple(gather(content.items(), converters, twins).values())


def _spread(of: Variable, content: Any) -> Spread:
    if of.unit is None or of.whole or not of.name.startswith(("chain.", "shock.", "impact.", "motion.")):
        problem = f"must be a continuous value of the chain or its excitation (got {of.name})"
        raise InvalidValueError(Fault((), problem, at_key=True))
    if isinstance(content, str) and content.strip().endswith("%"):
        return Spread(of, "relative", (convert(_RELATIVE, content),))
    forms: dict[str, Callable[[Any], Any]] = {
        "sd": partial(convert, Key("sd", spec=Declaration(of.unit or "", "standard deviation", above=0))),
        "factor": partial(convert, _FACTOR),
        "between": partial(ends_of, of),
    }
    if not isinstance(content, Mapping) or len(content) != 1:
        raise InvalidValueError(f"{_RULE} (got {text_of(content)})")
    ((kind, numbers),) = gather(content.items(), forms).items()
    return Spread(of, kind, numbers if kind == "between" else (numbers,))


def ends_of(of: Variable, interval: Any) -> tuple[float, ...]:
    """Lower and upper end of an interval.

    Raises
    ------
    InvalidValueError
        When it is not a pair of values in ascending order.
    """
    interval = interval.tolist() if hasattr(interval, "tolist") else interval  # an array
    if not isinstance(interval, list | tuple) or len(interval) != 2 or None in interval:
        raise InvalidValueError(
            f"must be a list of two values, the lower and the upper limit (got {text_of(interval)})"
        )
    ends = items(interval, of.convert)
    if not ends[0] < ends[1]:
        raise InvalidValueError(f"must ascend (got {text_of(interval)})")
    return tuple(ends)
