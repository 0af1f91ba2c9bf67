"""The impact: a striker in place of a force pulse."""

from __future__ import annotations

from attrs import field, frozen

from shockwave.base.quantity_fields import SIZES, Number, Value, quantity, radius_of
from shockwave.scene.material import Material, check_material, material_of


@frozen(kw_only=True, init=False)
class Impact(Value):
    """A sphere that strikes the first granule of a finite chain.

    Parameters
    ----------
    velocity : float
        Velocity of the striker towards the chain [m/s], from 1e-20 to the speed of light.
    radius, diameter : float, optional
        Size of the striker [m], at most one of them; by default that of the chain.
    material : Material or str, optional
        Material of the striker, or its name; by default that of the chain.

    Raises
    ------
    InvalidValueError
        If a value is out of range, or both sizes are given.

    Examples
    --------
    >>> import shockwave as sw
    >>> row = sw.Chain(material="ptfe", diameter="9.5 mm", granules=20)
    >>> striker = sw.Impact(velocity="0.2 m/s", material="nylon-66")
    >>> result = sw.simulate(striker, row, contacts=[10])
    >>> f"{result.contacts[0].peak_force:.3f} N"
    '1.185 N'
    """

    # up to the speed of light, from far below any that is measured, so that forces and times are floats
    velocity: float = quantity("m/s", "velocity of the striker", at_least=1e-20, at_most=299_792_458.0)
    radius: float | None = quantity("m", "radius of the striker", within=SIZES, default=None)
    material: Material | None = field(default=None, converter=material_of, validator=check_material)

    def __init__(
        self,
        *,
        velocity: Number,
        radius: Number | None = None,
        diameter: Number | None = None,
        material: Material | str | None = None,
    ) -> None:
        size = radius_of(radius, diameter)
        self.__attrs_init__(velocity=velocity, radius=size, material=material)  # type: ignore[arg-type]
