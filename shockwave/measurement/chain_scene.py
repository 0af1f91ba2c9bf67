"""Summary of a scene beyond equal spheres: the numbers that a result was computed for, in SI units, and their text."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import Any

from attrs import asdict, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.impact import Impact
from shockwave.chain.layout import Layout
from shockwave.chain.material import Material
from shockwave.profiles.shock import Shock
from shockwave.scene_summary import shock_text
from shockwave.text import si

# Most parts of a chain that are listed.
_MOST_PARTS = 6


@frozen(kw_only=True)
class ChainScene:
    """Excitation and chain, as numbers.

    Attributes
    ----------
    profile : str or None
        Class of the shock's profile; like the next three None for a striker.
    peak_force, rise_time, duration_ratio : float or None
        F0 [N], t0 [s], n of the shock.
    impact_velocity, striker_radius : float or None
        Velocity [m/s] and radius [m] of a striker; None for a shock.
    radius, youngs_modulus, poisson_ratio, density : float
        Defaults of the chain: R [m], E [Pa], nu, rho [kg/m^3].
    granules, contacts : int
        Numbers of granules and contacts, with the striker and the wall.
    mass, length : float
        Mass of the chain [kg] and sum of its diameters [m], without the striker.
    end : str
        ``free``, ``fixed wall`` or ``movable wall``.
    precompression, gravity : float
        Static force [N], acceleration [m/s^2].
    exponent : float
        p of the contact force k d^p.
    damping, contact : str or None
        Classes of damping and contact law; None without damping, and for Hertz's law.
    parts : tuple of str
        Descriptions of the granules, the end and the other features.
    notes : tuple of str
        Changes that were made to the given record.
    """

    profile: str | None
    peak_force: float | None
    rise_time: float | None
    duration_ratio: float | None
    impact_velocity: float | None
    striker_radius: float | None
    radius: float
    youngs_modulus: float
    poisson_ratio: float
    density: float
    granules: int
    contacts: int
    mass: float
    length: float
    end: str
    precompression: float
    gravity: float
    exponent: float
    damping: str | None
    contact: str | None
    parts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, excitation: Shock | Impact, chain: Chain, layout: Layout) -> ChainScene:
        """The scene of ``excitation`` on ``chain``, which has this ``layout``."""
        shock = excitation if isinstance(excitation, Shock) else None
        own = slice(1 if layout.striker else 0, None)
        wall = layout.wall
        return cls(
            profile=type(shock.profile).__name__ if shock else None,
            peak_force=shock.peak_force if shock else None,
            rise_time=shock.rise_time if shock else None,
            duration_ratio=float(shock.profile.duration_ratio) if shock else None,
            impact_velocity=layout.velocity if layout.striker else None,
            striker_radius=float(layout.radii[0]) if layout.striker else None,
            radius=chain.radius,
            youngs_modulus=chain.material.youngs_modulus,
            poisson_ratio=chain.material.poisson_ratio,
            density=chain.material.density,
            granules=len(layout.masses),
            contacts=len(layout.stiffnesses),
            mass=float(layout.masses[own].sum()),
            length=2 * float(layout.radii[own].sum()),
            end="free" if wall is None else "fixed wall" if wall.mass is None else "movable wall",
            precompression=chain.precompression,
            gravity=chain.gravity,
            exponent=layout.exponent,
            damping=None if chain.damping is None else type(chain.damping).__name__,
            contact=None if chain.contact is None else type(chain.contact).__name__,
            parts=(*_granules(layout), *_features(chain, layout)),
            notes=tuple(shock.profile.notes) if shock else (),
        )

    def to_dict(self) -> dict[str, Any]:
        """The numbers; the notes stand among the warnings of the result."""
        return asdict(self, filter=lambda attribute, _: attribute.name not in ("notes", "parts"))

    def facts(self) -> list[tuple[str, str]]:
        """Label and text of the excitation and of the chain."""
        if self.profile is None:
            size = si(2 * (self.striker_radius or 0.0), "m")
            excitation = "striker", f"granule 0, diameter {size}, {si(self.impact_velocity or 0.0, 'm/s')}"
        else:
            numbers = self.peak_force or 0.0, self.rise_time or 0.0, self.duration_ratio or 0.0
            excitation = "shock", shock_text(self.profile, *numbers)
        total = f"{self.granules} granules, {si(1e3 * self.mass, 'g')}, {si(self.length, 'm')}"
        return [excitation, ("chain", f"{total}: {'; '.join(self.parts)}")]


def _granules(layout: Layout) -> Iterator[str]:
    """Descriptions of runs of equal or evenly changing granules."""
    rows = [
        (segment, material_text(material), radius)
        for segment, material, radius in zip(layout.segments, layout.materials, layout.radii.tolist(), strict=True)
    ][1 if layout.striker else 0 :]
    runs = [list(run) for _, run in groupby(rows, key=lambda row: row[:2])]
    for run in runs[:_MOST_PARTS]:
        first, last = 2 * run[0][2], 2 * run[-1][2]
        size = si(first, "m") if first == last else f"{si(first, 'm')} to {si(last, 'm')}"
        yield f"{len(run)} of {run[0][1]}, diameter {size}"
    if len(runs) > _MOST_PARTS:
        yield f"and {len(runs) - _MOST_PARTS} more parts"


def _features(chain: Chain, layout: Layout) -> Iterator[str]:
    wall = layout.wall
    if wall is not None:
        material = "rigid" if not isinstance(wall.material, Material) else f"of {material_text(wall.material)}"
        movable = "" if wall.mass is None else f", {si(1e3 * wall.mass, 'g')} on {si(wall.stiffness, 'N/m')}"
        yield f"wall {material}{movable}"
    if chain.precompression:
        yield f"precompression {si(chain.precompression, 'N')}"
    if chain.gravity:
        yield f"gravity {chain.gravity:.5g} m/s^2"
    if chain.damping is not None:
        yield f"damping {type(chain.damping).__name__}"
    if chain.contact is not None:
        yield f"contact law {type(chain.contact).__name__}"


def material_text(material: Material) -> str:
    """Name of a material, or its modulus and density."""
    return material.name or f"E {si(material.youngs_modulus, 'Pa')}, {material.density:.5g} kg/m^3"
