"""Summary of a scene: the numbers that a result was computed for, in SI units, and their two lines of text."""

from __future__ import annotations

from attrs import frozen

from shockwave.chain.chain import Chain
from shockwave.profiles.shock import Shock
from shockwave.text import si


@frozen(kw_only=True)
class Scene:
    """Shock and chain, as numbers.

    Attributes
    ----------
    profile : str
        Class of the shock's profile.
    peak_force, rise_time, duration_ratio : float
        F0 [N], t0 [s], n; read off the record where there is one.
    radius, youngs_modulus, poisson_ratio, density : float
        R [m], E [Pa], nu, rho [kg/m^3].
    granules : int or None
        None for a chain as long as the answer needs.
    """

    profile: str
    peak_force: float
    rise_time: float
    duration_ratio: float
    radius: float
    youngs_modulus: float
    poisson_ratio: float
    density: float
    granules: int | None

    @classmethod
    def of(cls, shock: Shock, chain: Chain) -> Scene:
        """The scene of ``shock`` on ``chain``."""
        return cls(
            profile=type(shock.profile).__name__,
            peak_force=shock.peak_force,
            rise_time=shock.rise_time,
            duration_ratio=float(shock.profile.duration_ratio),
            radius=chain.radius,
            youngs_modulus=chain.material.youngs_modulus,
            poisson_ratio=chain.material.poisson_ratio,
            density=chain.material.density,
            granules=chain.granules,
        )

    def lines(self) -> list[str]:
        """Two lines for people."""
        length = "as long as the answer needs" if self.granules is None else f"{self.granules} granules"
        return [
            f"  shock             {self.profile}, peak {si(self.peak_force, 'N')}, rise {si(self.rise_time, 's')}, "
            f"duration {self.duration_ratio:.5g} times that",
            f"  chain             R {si(self.radius, 'm')}, E {si(self.youngs_modulus, 'Pa')}, "
            f"nu {self.poisson_ratio:.4g}, rho {self.density:.5g} kg/m^3, {length}",
        ]
