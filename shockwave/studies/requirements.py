"""Requirements of a design: a quantity, a relation and a value."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Literal, cast

from attrs import frozen

from shockwave.errors import InvalidValueError
from shockwave.fields import text_of
from shockwave.studies.simulated_quantities import Quantity
from shockwave.text import si
from shockwave.units import to_si

#: Properties of the leading wave that can be the target -> SI unit.
TARGETS = {
    "peak_force": "N",
    "amplification": "",
    "momentum": "N*s",
    "energy": "J",
    "speed": "m/s",
    "width": "s",
    "granule_velocity": "m/s",
}
Sign = Literal["<=", ">=", "="]
_REQUIREMENT = re.compile(r"\s*([\w.\[\]]+)\s*(<=|>=|=)\s*(.*\S)\s*")
# Relative width of an equality.
_EQUAL = 1e-3


def parts_of(text: object, kind: str) -> tuple[str, Sign, str]:
    """Name, sign and value of text such as ``transmitted.peak_force <= 60 N``; ``kind`` names it in messages.

    Raises
    ------
    InvalidValueError
        If it has another form.
    """
    parts = _REQUIREMENT.fullmatch(str(text))
    if parts is None:
        rule = "must be a quantity, <=, >= or =, and a value, such as 'transmitted.peak_force <= 60 N'"
        raise InvalidValueError.of(kind, f"{rule} (got {text_of(text)})")
    name, sign, value = parts.groups()
    return name, cast(Sign, sign), value


@frozen
class Requirement:
    """A quantity that must be below or above a value, or equal to it within a thousandth.

    Attributes
    ----------
    quantity : Quantity
        The quantity.
    sign : "<=", ">=" or "="
        The relation.
    value : float
        The value [SI unit of the quantity], above 0.
    """

    quantity: Quantity
    sign: Sign
    value: float

    @classmethod
    def of(cls, text: str, kind: str, quantity: Callable[[str], Quantity]) -> Requirement:
        """Convert text such as ``transmitted.peak_force <= 60 N``; ``kind`` names the argument in messages.

        Raises
        ------
        InvalidValueError
            If it has another form, the quantity is unknown, or the value is not above 0.
        """
        name, sign, given = parts_of(text, kind)
        found = quantity(name)
        try:
            value = to_si(given, found.unit)
        except ValueError as error:
            raise InvalidValueError.of(f"{kind}.{name}", str(error)) from None
        if not value > 0:
            raise InvalidValueError.of(f"{kind}.{name}", f"must be > 0 {found.unit} (got {given})")
        return cls(found, sign, value)

    def violation(self, value: float, error: float, margin: float = 0.0) -> float:
        """Relative violation by a ``value`` of this relative ``error``; the requirement holds if it is not above 0."""
        ratio = value / self.value
        if self.sign == "<=":
            return ratio * (1 + error + margin) - 1
        if self.sign == ">=":
            return 1 - ratio * (1 - error - margin)
        return abs(ratio - 1) + error + margin - _EQUAL

    @property
    def bound(self) -> str:
        """The relation and the value in printed form."""
        return f"{self.sign} {si(self.value, self.quantity.unit.replace('*', ' '))}"

    def __str__(self) -> str:
        return f"{self.quantity.label} {self.bound}"
