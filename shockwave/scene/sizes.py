"""Sizes of bodies, each given by its radius or its diameter."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs

from shockwave.base.errors import InvalidValueError
from shockwave.base.quantity_fields import Converted, Number, Quantity, quantity_of

#: Range of sizes in chains of different granules [m], so that their masses and stiffnesses are floats.
SIZES: dict[str, Any] = {"at_least": 1e-12, "at_most": 1e6}
#: Diameter of granules, which can be given instead of the radius.
DIAMETER = Quantity("m", "diameter 2 R of the granules", above=0)
#: Type of a field ``_diameter``, the argument in place of ``radius``; see `set_radius`.
Diameter: TypeAlias = Converted[None, Number | Any | None]


def halve(diameter: Any) -> Any:
    """Radius of a diameter; of a taper of diameters, the taper of radii."""
    if diameter is None or hasattr(diameter, "half"):
        return diameter and diameter.half
    return DIAMETER.check("diameter", diameter) / 2


def set_radius(part: Any) -> None:
    """Set the radius of an object that is being made, if its diameter was given, which then is None.

    Raises
    ------
    InvalidValueError
        If both are given, or the radius is out of range.
    """
    radius = part._diameter
    if radius is None:
        return
    if part.radius is not None:
        raise InvalidValueError.of("diameter", "must be left out if radius is given (got both; delete one)")
    spec = quantity_of(attrs.fields(type(part)).radius)
    object.__setattr__(part, "radius", spec.check("radius", radius) if spec and isinstance(radius, float) else radius)
    object.__setattr__(part, "_diameter", None)
