"""The chain of equal spheres, and the scales that take its units off and put them back (eq. (1))."""

from __future__ import annotations

import math

from attrs import frozen

from shockwave.chain.material import Material
from shockwave.errors import InvalidValueError
from shockwave.fields import quantity, text_of

_LOOK_UP = "shockwave.registry.load('materials', 'ptfe') gives one of the library"
# Room for what follows from them: the weakest wave and the square of its velocity, the longest double integral.
_ENERGIES = 1e-200, 1e250
_RATIOS = 1e-30, 1e12


@frozen(kw_only=True)
class Chain:
    """Equal elastic spheres in a row, in contact but not compressed, both ends free.

    Parameters
    ----------
    material : Material
        The material of every granule.
    radius : float
        R [m], above 0.
    granules : int, optional
        Their number, at least 2. Left out, the chain is as long as the answer needs.

    Raises
    ------
    InvalidValueError
        When a value is out of range, or the chain's mass or stiffness leaves the range of a float.
    """

    material: Material
    radius: float = quantity("m", "radius R of the granules", above=0)
    granules: int | None = quantity(
        "", "number of granules", at_least=2, at_most=1e9, whole=True, optional=True, default=None
    )

    def __attrs_post_init__(self) -> None:
        if not isinstance(self.material, Material):
            raise InvalidValueError.of("material", f"must be a Material (got {text_of(self.material)}; {_LOOK_UP})")
        for name, value in (("mass", self.granule_mass), ("stiffness", self.contact_stiffness)):
            if not (math.isfinite(value) and value > 0):
                problem = f"must give granules a {name} that a floating-point number can hold (got {value:g})"
                raise InvalidValueError.of("radius", problem)

    @property
    def granule_mass(self) -> float:
        """Mass of one granule, m = 4/3 pi R^3 rho [kg]."""
        # A product overflows to infinity, which is reported; a power would raise.
        return 4 / 3 * math.pi * self.material.density * self.radius * self.radius * self.radius

    @property
    def plane_strain_modulus(self) -> float:
        """E / (1 - nu^2) [Pa], the modulus that contacts feel."""
        return self.material.youngs_modulus / (1 - self.material.poisson_ratio**2)

    @property
    def contact_stiffness(self) -> float:
        """k of Hertz's law F = k d^(3/2) between equal spheres, sqrt(2 R) E / (3 (1 - nu^2)) [N/m^1.5]."""
        return math.sqrt(2 * self.radius) * self.plane_strain_modulus / 3

    def momentum_parameter(self, coefficient: float) -> float:
        """A of eq. (4c): a solitary wave of peak force F carries the momentum A F^(5/6).

        ``coefficient`` is its leading number: 13/3 in the paper, 4.344507853978653 exactly. The result
        is in N^(1/6) s.
        """
        # Factor by factor, so that no intermediate power leaves the range of a float.
        density, radius = self.material.density, self.radius
        per_size = math.cbrt(density / self.plane_strain_modulus) * math.pow(density, 1 / 6)
        return coefficient * per_size * radius * math.cbrt(radius)


@frozen
class Scales:
    """Units in which the chain has mass 1, contact stiffness 1, and a chosen force is 1.

    Eq. (1) keeps its form under x -> l x, t -> l^(-1/4) t, F -> l^(3/2) F, so one scaled problem serves
    every chain. Attributes are the SI values of the scaled units.
    """

    force: float
    time: float
    mass: float
    granule_spacing: float

    @classmethod
    def of(cls, chain: Chain, force: float) -> Scales:
        """Scales of ``chain`` with ``force`` [N] as the unit: T0 = sqrt(m) k^(-1/3) F0^(-1/6)."""
        time = math.sqrt(chain.granule_mass) / math.cbrt(chain.contact_stiffness) / force ** (1 / 6)
        scales = cls(force, time, chain.granule_mass, 2 * chain.radius)
        if not _ENERGIES[0] < scales.energy < _ENERGIES[1]:
            problem = f"must give waves an energy that a floating-point number can hold (got {force:g} N)"
            raise InvalidValueError.of("peak_force", problem)
        return scales

    def rise_time(self, seconds: float) -> float:
        """t0/T0 of a rise time [s].

        Raises
        ------
        InvalidValueError
            When it is beyond 1e-30 to 1e12, where squares and sixth powers leave the range of a float.
        """
        ratio = seconds / self.time
        least, most = _RATIOS
        if not least <= ratio <= most:
            limits = f"{least:g} to {most:g} times {self.time:g} s, the characteristic time of the chain"
            raise InvalidValueError.of("rise_time", f"must be {limits} (got {seconds:g} s)")
        return ratio

    @property
    def momentum(self) -> float:
        """Unit of momentum [N s]."""
        return self.force * self.time

    @property
    def velocity(self) -> float:
        """Unit of granule velocity [m/s]."""
        return self.momentum / self.mass

    @property
    def energy(self) -> float:
        """Unit of energy [J]."""
        return self.momentum * self.velocity

    @property
    def wave_speed(self) -> float:
        """SI value of one granule a unit of time [m/s]."""
        return self.granule_spacing / self.time
