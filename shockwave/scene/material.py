"""An isotropic elastic material, and sizes of bodies."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs
from attrs import frozen

from shockwave.base.errors import InvalidValueError, UnknownNameError
from shockwave.base.quantity_fields import (
    MAGNITUDES,
    SI,
    Converted,
    Declaration,
    Number,
    Value,
    declaration_of,
    plain_text,
    quantity,
    text_of,
)
from shockwave.registry.registry import load

#: Names of walls that are not materials.
WALLS = ("same", "rigid")


@frozen(kw_only=True)
class Material(Value):
    """The material of a granule: elastic constants and density.

    Parameters
    ----------
    youngs_modulus : float
        Young's modulus E [Pa], above 0.
    poisson_ratio : float
        Poisson's ratio nu, between -1 and 0.5, both excluded.
    density : float
        Density rho [kg/m^3], above 0.
    yield_strength : float, optional
        Yield strength [Pa], above 0, at which contacts begin to deform plastically; by default unknown.
    rate_constant : float
        Rate constant K, default 0: the strength is ``1 + K ln(rate / 0.001 s^-1)`` times the yield strength, for the
        strain rate of an elastic-plastic contact.
    name, source : str, optional
        Name of the material, and source of its values.

    Raises
    ------
    InvalidValueError
        If a value is out of range.

    Examples
    --------
    >>> import shockwave as sw
    >>> steel = sw.Material(
    ...     youngs_modulus="193 GPa", poisson_ratio=0.3, density="7.86 g/cm^3"
    ... )
    >>> f"{steel.density:g} kg/m^3"
    '7860 kg/m^3'
    """

    youngs_modulus: SI[float] = quantity("Pa", "Young's modulus E", within=MAGNITUDES)
    poisson_ratio: SI[float] = quantity("", "Poisson's ratio nu", above=-1, below=0.5)
    density: SI[float] = quantity("kg/m**3", "density rho", within=MAGNITUDES)
    yield_strength: SI[float | None] = quantity("Pa", "yield strength", within=MAGNITUDES, default=None)
    rate_constant: SI[float] = quantity(
        "", "increase of the yield strength with the logarithm of the strain rate", at_least=0, at_most=1, default=0.0
    )
    name: str = plain_text(default="")
    source: str = plain_text(default="")

    @property
    def compliance(self) -> float:
        """(1 - nu^2)/E [1/Pa]."""
        return (1 - self.poisson_ratio**2) / self.youngs_modulus


#: Types of fields with a material, which may be given by its name.
MaterialField: TypeAlias = Converted[Material, Material | str]
OptionalMaterial: TypeAlias = Converted[Material | None, Material | str | None]


def material(name: str) -> Material:
    """The material of this name from the library or from a plugin.

    Raises
    ------
    UnknownNameError
        If no material has the name.
    PluginError
        If the plugin that registers it is faulty.

    Examples
    --------
    >>> import shockwave as sw
    >>> sw.material("ptfe").youngs_modulus
    1460000000.0
    """
    found: Material = load("materials", name)
    return found


def material_of(value: Material | str | None) -> Any:
    """Return the material named ``value``; return any other value unchanged."""
    try:
        return material(value) if isinstance(value, str) else value
    except UnknownNameError as error:
        raise UnknownNameError(*(fault.below("material") for fault in error.faults)) from None


def check_material(_: object, attribute: Any, value: Any) -> None:
    """Validator of an attrs field that holds a `Material`, or None if that is its default."""
    if not (isinstance(value, Material) or (value is None and attribute.default is None)):
        raise InvalidValueError.of(attribute.name, f"must be a Material or the name of one (got {text_of(value)})")


# ---------------------------------------------------------------- sizes

#: Range of sizes in chains of different granules [m], so that their masses and stiffnesses are floats.
SIZES: dict[str, Any] = {"at_least": 1e-12, "at_most": 1e6}
#: Diameter of granules, which can be given instead of the radius.
DIAMETER = Declaration("m", "diameter 2 R of the granules", above=0)
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
    spec = declaration_of(attrs.fields(type(part)).radius)
    object.__setattr__(part, "radius", spec.check("radius", radius) if spec and isinstance(radius, float) else radius)
    object.__setattr__(part, "_diameter", None)
