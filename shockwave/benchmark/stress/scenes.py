"""Scenes of the catalogue: shocks in natural times of the paper's beads at 100 N, which stand for all others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
from attrs import evolve

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.material import Material
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.shock import Shock
from shockwave.profiles.tabulated import Tabulated

__all__ = ["BEADS", "FORCE", "UNITS", "Make", "Scene", "exponential", "of", "power", "record", "sized"]

Scene: TypeAlias = tuple[Shock, Chain]
#: Scenes are made when they are needed: a list of cases must not cost a million samples.
Make: TypeAlias = Callable[[], Scene]

#: Peak force [N] and chain of the paper's tables.
FORCE = 100.0
BEADS = Chain(material=Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0), radius=4.75e-3)
#: Their natural units.
UNITS = Scales.of(BEADS, FORCE)


def of(profile: ShockProfile, rise_time: float, granules: int | None = None) -> Scene:
    """A shock of 100 N on the beads, its rise time over the natural time."""
    shock = Shock(profile=profile, peak_force=FORCE, rise_time=rise_time * UNITS.time)
    return shock, evolve(BEADS, granules=granules)


def power(rise: float, decay: float, ratio: float, rise_time: float, granules: int | None = None) -> Make:
    """A power law of these exponents; ``rise_time`` over the natural time."""
    return lambda: of(PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=ratio), rise_time, granules)


def exponential(rise: float, decay: float, ratio: float, rise_time: float) -> Make:
    """Exponentials of these rates."""
    return lambda: of(Exponential(rise_rate=rise, decay_rate=decay, duration_ratio=ratio), rise_time)


def record(times: Sequence[float], shares: Sequence[float]) -> Make:
    """Samples at ``times`` over the natural time, in shares of 100 N."""

    def make() -> Scene:
        forces = FORCE * np.asarray(shares, dtype=float)
        return Shock(profile=Tabulated(times=np.asarray(times, dtype=float) * UNITS.time, forces=forces)), BEADS

    return make


def sized(
    force: float = FORCE,
    radius: float = BEADS.radius,
    modulus: float = BEADS.material.youngs_modulus,
    ratio: float = BEADS.material.poisson_ratio,
    density: float = BEADS.material.density,
    rise_time: float = 2.0,
) -> Scene:
    """One shape and one t0/T0 on a chain of any size: by the scaling law the same problem as on the beads."""
    chain = Chain(material=Material(youngs_modulus=modulus, poisson_ratio=ratio, density=density), radius=radius)
    profile = PowerLaw(rise_exponent=0.5, decay_exponent=1.0, duration_ratio=3.0)
    return Shock(profile=profile, peak_force=force, rise_time=rise_time * Scales.of(chain, force).time), chain
