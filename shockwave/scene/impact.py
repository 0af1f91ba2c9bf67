"""The impact: a striker in place of a force pulse."""

from __future__ import annotations

import math
from typing import Any

from attrs import field, frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.base.units import STANDARD_GRAVITY
from shockwave.scene.material import SIZES, Diameter, OptionalMaterial, check_material, halve, material_of, set_radius

# Up to the speed of light, from far below any that is measured, so that forces and times are floats.
_VELOCITIES = {"at_least": 1e-20, "at_most": 299_792_458.0}
_HEIGHTS = {"at_least": 1e-40, "at_most": 1e9}


@frozen(kw_only=True)
class Impact(Value):
    """A sphere that strikes the first granule of a finite chain.

    Parameters
    ----------
    velocity : float, optional
        Velocity of the striker towards the chain [m/s], from 1e-20 to the speed of light.
    drop_height : float, optional
        Height of its fall [m], instead of the velocity: ``sqrt(2 g h)``, with g of the chain or, without gravity along
        the chain, 9.80665 m/s^2. Exactly one of the two must be given.
    radius, diameter : float, optional
        Size of the striker [m], at most one of them; by default that of the chain.
    material : Material or str, optional
        Material of the striker, or its name; by default that of the chain.

    Raises
    ------
    InvalidValueError
        If a value is out of range, both sizes are given, or not exactly one of velocity and drop height.

    Examples
    --------
    >>> import shockwave as sw
    >>> row = sw.Chain(material="delrin", diameter="9.5 mm", granules=20)
    >>> striker = sw.Impact(velocity="0.2 m/s", material="pmma")
    >>> result = sw.simulate(striker, row, contacts=[10])
    >>> f"{result.contacts[0].peak_force:.3f} N"
    '1.651 N'
    """

    velocity: SI[float | Any] = quantity("m/s", "velocity of the striker", within=_VELOCITIES, default=None)
    drop_height: SI[float | None] = quantity("m", "height of the fall of the striker", within=_HEIGHTS, default=None)
    radius: SI[float | None] = quantity("m", "radius of the striker", within=SIZES, default=None)
    _diameter: Diameter = field(default=None, alias="diameter", converter=halve, eq=False, repr=False)
    material: OptionalMaterial = field(default=None, converter=material_of, validator=check_material)

    def __attrs_post_init__(self) -> None:
        set_radius(self)
        if (self.velocity is None) == (self.drop_height is None):
            got = "nothing" if self.velocity is None else "both"
            raise InvalidValueError.of("velocity", f"must be given, or drop_height, but not both (got {got})")

    def speed(self, gravity: float) -> float:
        """Velocity towards a chain with this gravity along it [m/s]."""
        if self.drop_height is None:
            return float(self.velocity)
        return math.sqrt(2 * (gravity or STANDARD_GRAVITY) * self.drop_height)
