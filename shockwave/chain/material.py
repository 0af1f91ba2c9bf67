"""An isotropic elastic material."""

from __future__ import annotations

from attrs import field, frozen

from shockwave.fields import quantity


@frozen(kw_only=True)
class Material:
    """The material of a granule: elastic constants and density.

    Parameters
    ----------
    youngs_modulus : float
        Young's modulus E [Pa], above 0.
    poisson_ratio : float
        Poisson's ratio nu, between -1 and 0.5, both excluded.
    density : float
        Density rho [kg/m^3], above 0.
    name, source : str, optional
        Name of the material, and source of its values.

    Raises
    ------
    InvalidValueError
        If a value is out of range.
    """

    youngs_modulus: float = quantity("Pa", "Young's modulus E", above=0)
    poisson_ratio: float = quantity("", "Poisson's ratio nu", above=-1, below=0.5)
    density: float = quantity("kg/m**3", "density rho", above=0)
    name: str = field(default="")
    source: str = field(default="")
