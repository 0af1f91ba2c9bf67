"""Declaration of quantities: unit, range and meaning of a field, and its check.

The same declaration serves a Python constructor and the loader of scenario files, which report all wrong values, and
the templates that ``shockwave new`` writes.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, SupportsFloat, TypeAlias, TypeVar, dataclass_transform

import attrs
from attrs import frozen

from shockwave.base.arguments import Explained
from shockwave.base.errors import InvalidValueError, below
from shockwave.base.errors import text_of as text_of
from shockwave.base.units import to_si

_Value = TypeVar("_Value")
_Argument = TypeVar("_Argument", contravariant=True)
#: Argument for a quantity: a number in SI units, text with a unit, or a quantity of pint.
Number: TypeAlias = SupportsFloat | str


class Converted(Generic[_Value, _Argument]):
    """Type of a field with a converter: of its value, and of the argument that the converter takes."""

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: type | None = None) -> _Value: ...
        def __set__(self, instance: object, value: _Argument) -> None: ...


#: Type of a field that `quantity` declares, such as ``SI[float]`` or ``SI[float | None]``.
SI: TypeAlias = Converted[_Value, _Value | Number]

_KEY = "shockwave"
#: Key of the metadata of a field whose text is never the name of a file.
PLAIN = "shockwave_plain_text"
# Items of a tuple that are all shown, and length of the repr of one.
_MOST_ITEMS = 8
_LONGEST_ITEM = 200
_SIGNS = {">": operator.gt, ">=": operator.ge, "<": operator.lt, "<=": operator.le}


@frozen
class Declaration(Explained):
    """Declaration of a number: SI ``unit`` ("" if it is dimensionless), ``meaning``, range.

    ``above`` and ``below`` exclude their bound, ``at_least`` and ``at_most`` include it. ``whole`` requires an integer,
    ``optional`` allows None. ``samples`` marks a sequence of numbers. Templates show ``example`` in place of a default.
    """

    unit: str
    meaning: str
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    whole: bool = False
    optional: bool = False
    samples: bool = False
    example: str = ""

    @cached_property
    def bounds(self) -> list[tuple[str, float]]:
        """Signs and bounds of the range."""
        pairs = ((">", self.above), (">=", self.at_least), ("<", self.below), ("<=", self.at_most))
        return [(sign, bound) for sign, bound in pairs if bound is not None]

    @cached_property
    def rule(self) -> str:
        """The range in words, such as ``> 0 Pa`` or ``> -1 and < 0.5``."""
        parts = [f"{sign} {bound:g}" for sign, bound in self.bounds]
        finite = "a finite number of" if self.unit else "a finite number"
        kind = "a whole number" if self.whole else "" if parts else finite
        return " ".join(filter(None, (kind, " and ".join(parts), self.unit)))

    @property
    def metadata(self) -> dict[str, Declaration]:
        """Metadata of an attrs field with a converter of its own, whose numbers have this declaration."""
        return {_KEY: self}

    def problem(self, value: object) -> str | None:
        """The error of ``value``, or None."""
        if value is None:
            return None if self.optional else f"must be {self.rule} (got nothing)"
        try:
            number = math.nan if isinstance(value, bool | str) else float(value)  # type: ignore[arg-type]
        except OverflowError:
            number = math.inf
        except (TypeError, ValueError):
            number = math.nan
        inside = not math.isnan(number)
        for sign, bound in self.bounds:
            inside = inside and _SIGNS[sign](number, bound)
        if inside and math.isinf(number):
            return f"must be finite (got {text_of(value)})"
        fits = inside and (not self.whole or number == int(number))
        return None if fits else f"must be {self.rule} (got {text_of(value)})"

    def check(self, name: str, value: Any) -> Any:
        """``value`` of ``name`` as a float or int; raises `InvalidValueError` if it is wrong.

        A value may also be text with a unit or a quantity of pint.
        """
        if value is None and self.optional:
            return None
        if value is not None and (
            isinstance(value, bool | str) or hasattr(value, "to_base_units") or not hasattr(value, "__float__")
        ):
            with below(name):
                value = to_si(value, self.unit)
        problem = self.problem(value)
        if problem is not None:
            raise InvalidValueError.of(name, problem)
        return int(value) if self.whole else float(value)


# one for all fields, because attrs inspects the signature of each converter
_CONVERTER: Any = attrs.Converter(lambda value, field: field.metadata[_KEY].check(field.name, value), takes_field=True)


def quantity(
    unit: str, meaning: str, *, default: Any = attrs.NOTHING, within: Mapping[str, Any] | None = None, **declared: Any
) -> Any:
    """An attrs field that holds a checked number.

    Parameters
    ----------
    unit : str
        SI unit; an empty string for a dimensionless number.
    meaning : str
        Description in one line, shown in templates and in the schema.
    default : float, optional
        Without a default, the field is required; None makes it optional.
    within : mapping, optional
        Bounds that several fields share, such as `SIZES`.
    **declared
        Attributes of `Declaration`: above, at_least, below, at_most, whole, optional, example.

    Raises
    ------
    InvalidValueError
        Raised by the constructor of the class, when a value is out of range.

    Examples
    --------
    >>> import shockwave as sw
    >>> from attrs import frozen
    >>> @frozen(kw_only=True)
    ... class Foam:
    ...     thickness: float = sw.quantity("m", "thickness of the layer", above=0)
    ...
    >>> Foam(thickness="5 mm").thickness
    0.005
    """
    spec = Declaration(unit, meaning, **{"optional": default is None, **(within or {}), **declared})
    return attrs.field(default=default, converter=_CONVERTER, metadata={_KEY: spec})


def tuple_repr(values: Any) -> str:
    """Repr of a value; for a tuple, of its items, or of the first and the last with their number, each shortened."""
    if not isinstance(values, tuple):
        return repr(values)
    if len(values) > _MOST_ITEMS:
        first, last = (text_of(values[end], _LONGEST_ITEM) for end in (0, -1))
        return f"({first}, ..., {last}; {len(values)} in all)"
    return f"({', '.join(text_of(each, _LONGEST_ITEM) for each in values)}{',' * (len(values) == 1)})"


def plain_text(default: Any = attrs.NOTHING) -> Any:
    """An attrs field for text that is shown or compared, and is never the name of a file."""
    return attrs.field(default=default, metadata={PLAIN: True})


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(quantity, plain_text, attrs.field))
class Value(Explained):
    """Base class of attrs classes with fields that `quantity` declares, which type checkers read from it.

    ``kw_only`` states that of the attrs class to them.
    """

    __slots__ = ()

    def __init_subclass__(cls, *, kw_only: bool = True) -> None:
        super().__init_subclass__()


def is_plain_text(attribute: attrs.Attribute[Any]) -> bool:
    """Whether the attribute was declared by `plain_text`."""
    return PLAIN in attribute.metadata


def one_of(*choices: object) -> Any:
    """Validator of an attrs field that holds one of the ``choices``."""

    def check(_: object, attribute: attrs.Attribute[Any], value: object) -> None:
        if value not in choices:
            raise InvalidValueError.of(attribute.name, f"must be {join(choices)} (got {text_of(value)})")

    return check


#: Range of properties of materials and walls [SI units], so that powers of them are floats.
MAGNITUDES: dict[str, Any] = {"at_least": 1e-30, "at_most": 1e30}


def declaration_of(attribute: attrs.Attribute[Any]) -> Declaration | None:
    """Declaration of an attrs attribute, if it has one."""
    spec = attribute.metadata.get(_KEY)
    return spec if isinstance(spec, Declaration) else None


def join(names: Iterable[object], conjunction: str = "or") -> str:
    """``names`` for a sentence, such as ``a, b or c``."""
    *most, last = map(str, names)
    return f"{', '.join(most)} {conjunction} {last}" if most else last
