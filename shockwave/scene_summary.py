"""Summary of a scene: the numbers that a result was computed for, in SI units, and their text."""

from __future__ import annotations

from typing import Any

from attrs import asdict, frozen

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
        None for a semi-infinite chain.
    notes : tuple of str
        Changes that were made to the given record.
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
    notes: tuple[str, ...] = ()

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
            granules=chain.count,
            notes=tuple(shock.profile.notes),
        )

    def to_dict(self) -> dict[str, Any]:
        """The numbers; the notes stand among the warnings of the result."""
        return asdict(self, filter=lambda attribute, _: attribute.name != "notes")

    def facts(self) -> list[tuple[str, str]]:
        """Label and text of the shock and of the chain."""
        length = "semi-infinite" if self.granules is None else f"{self.granules} granules"
        stiffness = f"E {si(self.youngs_modulus, 'Pa')}, nu {self.poisson_ratio:.4g}"
        chain = f"R {si(self.radius, 'm')}, {stiffness}, rho {self.density:.5g} kg/m^3, {length}"
        shock = shock_text(self.profile, self.peak_force, self.rise_time, self.duration_ratio)
        return [("shock", shock), ("chain", chain)]


def shock_text(profile: str, peak_force: float, rise_time: float, duration_ratio: float) -> str:
    """Profile and numbers of a shock."""
    duration = f"{si(rise_time * duration_ratio, 's')} (n = {duration_ratio:.5g})"
    return f"{profile}, peak {si(peak_force, 'N')}, rise {si(rise_time, 's')}, duration {duration}"
