"""The end of a chain: a flat wall, fixed or movable, or a long bar."""

from __future__ import annotations

import math
from typing import Any, Literal

from attrs import field, frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.quantity_fields import MAGNITUDES, SI, Converted, Value, quantity, text_of
from shockwave.scene.material import (
    SIZES,
    WALLS,
    Diameter,
    Material,
    MaterialField,
    check_material,
    halve,
    material_of,
    set_radius,
)


def _convert_material(value: Material | str) -> Any:
    return value.lower() if isinstance(value, str) and value.lower() in WALLS else material_of(value)


def _wall(_: object, attribute: Any, value: object) -> None:
    if not (isinstance(value, Material) or value in WALLS):
        problem = f"must be 'same', 'rigid', a Material or the name of one (got {text_of(value)})"
        raise InvalidValueError.of(attribute.name, problem)


@frozen(kw_only=True)
class Wall(Value):
    """A flat wall at the end of a chain; it is fixed unless it has a mass.

    Parameters
    ----------
    material : Material, str, "same" or "rigid"
        Material of the wall or its name: ``same`` (default) is that of the last granule, and ``rigid`` does not
        deform.
    mass : float, optional
        Mass of a movable wall [kg].
    stiffness, damping : float
        Spring [N/m] and dashpot [N s/m] between a movable wall and the ground, default 0. A constant force on the wall
        balances the static load of the chain, so that the spring acts on displacements only.

    Raises
    ------
    InvalidValueError
        If a value is out of range, or a stiffness or a damping is given without a mass.

    Examples
    --------
    >>> import shockwave as sw
    >>> wall = sw.Wall(material="aluminium-6061-t6")
    >>> row = sw.Chain(material="delrin", diameter="9.5 mm", granules=20, end=wall)
    >>> result = sw.simulate(sw.Impact(velocity="0.2 m/s"), row)
    >>> f"{result.transmitted.peak_force:.3f} N"
    '4.107 N'
    """

    material: Converted[Material | Literal["same", "rigid"], Material | str] = field(
        default="same", converter=_convert_material, validator=_wall
    )
    mass: SI[float | None] = quantity("kg", "mass of a movable wall", within=MAGNITUDES, default=None)
    stiffness: SI[float] = quantity(
        "N/m", "stiffness of the spring behind a movable wall", at_least=0, at_most=1e30, default=0.0
    )
    damping: SI[float] = quantity(
        "N*s/m", "coefficient of the dashpot behind a movable wall", at_least=0, at_most=1e30, default=0.0
    )

    #: What it is in texts.
    word = "wall"

    def stiffness_ratio(self, granules: Material) -> float:
        """Stiffness of the contact of a granule with the wall over that of two equal granules, at most 2 sqrt(2)."""
        own = granules if self.material == "same" else self.material
        share = own.compliance / granules.compliance if isinstance(own, Material) else 0.0
        return 2 * math.sqrt(2) / (1 + share)

    def __attrs_post_init__(self) -> None:
        for name in ("stiffness", "damping"):
            if self.mass is None and getattr(self, name):
                got = f"got {getattr(self, name):g}; give the mass of the wall"
                raise InvalidValueError.of(name, f"must be left out for a fixed wall ({got})")


@frozen(kw_only=True)
class Bar(Value):
    """The flat, massless end of a long bar, which yields to the force F with the velocity F/Z.

    Z is ``A rho c``, with the speed ``c = sqrt(E/rho)`` of the waves in the bar. Nothing is reflected: the result holds
    until a wave returns from its far end. The contact is that with a wall of the same material.

    Parameters
    ----------
    material : Material or str
        Material of the bar, or its name.
    radius, diameter : float, optional
        Size of the bar [m], at most one of them.
    impedance : float, optional
        Z [N s/m], in place of a size.

    Raises
    ------
    InvalidValueError
        If a value is out of range, or not exactly one of size and impedance is given.

    Examples
    --------
    >>> import shockwave as sw
    >>> bar = sw.Bar(material="steel-4340", diameter="19 mm")
    >>> f"{bar.resistance:.0f} N s/m"
    '11429 N s/m'
    """

    material: MaterialField = field(converter=material_of, validator=check_material)
    radius: SI[float | None] = quantity("m", "radius of the bar", within=SIZES, default=None)
    _diameter: Diameter = field(default=None, alias="diameter", converter=halve, eq=False, repr=False)
    impedance: SI[float | None] = quantity("N*s/m", "impedance of the bar", within=MAGNITUDES, default=None)

    #: What it is in texts.
    word = "bar"
    # as a wall that is fixed
    mass = None
    stiffness = damping = 0.0

    def __attrs_post_init__(self) -> None:
        set_radius(self)
        if (self.radius is None) == (self.impedance is None):
            got = "nothing" if self.radius is None else "both"
            raise InvalidValueError.of("impedance", f"must be given, or the diameter, but not both (got {got})")

    @property
    def resistance(self) -> float:
        """Z [N s/m]: the given impedance, or that of its section."""
        if self.radius is None:
            return float(self.impedance or 0.0)
        return math.pi * self.radius**2 * math.sqrt(self.material.youngs_modulus * self.material.density)
