"""How a profile is looked at: its two functions, where they are sampled, their integrals, the scene it is tried in."""

from __future__ import annotations

from collections.abc import Callable
from numbers import Real

import numpy as np

from shockwave.chain import Chain, Material
from shockwave.chain.chain import Scales
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray, Integral
from shockwave.quadrature.gauss_legendre import GaussLegendre
from shockwave.scenario.units import to_si

__all__ = ["CHAIN", "MANY", "are_numbers", "branches", "integral", "is_unit", "sampled", "shock"]

#: A profile of more breakpoints than this is looked at less closely.
MANY = 50
_UNIFORM, _HALVINGS = 2001, 50
_GRADES = 16.0 ** -np.arange(1, 8)

# The scene in which a profile is tried: steel beads of 9.5 mm, a shock of 100 N that lasts three natural times.
_FORCE, _DURATION = 100.0, 3.0
_STEEL = Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
CHAIN = Chain(material=_STEEL, radius=4.75e-3)


def branches(profile: ShockProfile) -> tuple[tuple[str, Callable[[FloatArray], FloatArray], float, float], ...]:
    """Name, function and range of rise and decay."""
    return ("rise", profile.rise, 0.0, 1.0), ("decay", profile.decay, 1.0, float(profile.duration_ratio))


def are_numbers(values: object) -> bool:
    """Whether ``values`` is a tuple or a list of numbers."""
    return isinstance(values, tuple | list) and all(isinstance(value, Real) for value in values)


def is_unit(unit: str) -> bool:
    """Whether there is a unit of that symbol."""
    try:
        return to_si(f"1 {unit}".rstrip(), unit) == 1
    except (TypeError, ValueError):
        return False


def sampled(profile: ShockProfile, lower: float, upper: float) -> FloatArray:
    """Where values are looked at: evenly, ever closer to both ends, and on either side of breakpoints."""
    width, near = upper - lower, 0.5 ** np.arange(1, _HALVINGS)
    points = np.array([point for point in profile.breakpoints if lower < point < upper], dtype=float)
    sides = np.concatenate((np.nextafter(points, lower), points, np.nextafter(points, upper)))
    even = np.linspace(lower, upper, _UNIFORM)
    return np.unique(np.clip(np.concatenate((even, lower + width * near, upper - width * near, sides)), lower, upper))


def integral(profile: ShockProfile, begin: float, end: float, moment: bool = False) -> Integral:
    """The force from ``begin`` to ``end`` by quadrature, or (end - s) times the force; 1 is a breakpoint."""
    points = sorted({begin, *(point for point in (1.0, *profile.breakpoints) if begin < point < end), end})
    if len(points) <= MANY:
        # A layer that is narrow and, for its weight, low would pass unseen between the nodes of a wide panel.
        widths = np.diff(points)[:, None] * _GRADES
        first, last = np.array(points[:-1])[:, None], np.array(points[1:])[:, None]
        points = np.unique(np.concatenate(((first + widths).ravel(), (last - widths).ravel(), points))).tolist()

    def weighted(s: FloatArray) -> FloatArray:
        # All of a piece lies on one side of the peak.
        force = profile.rise(s.copy()) if s[0] < 1 else profile.decay(s.copy())
        return np.asarray((end - s) * force if moment else force)

    return GaussLegendre().integrate(weighted, points)


def shock(profile: ShockProfile) -> Shock:
    """The shock in which a profile is tried."""
    rise_time = _DURATION * Scales.of(CHAIN, _FORCE).time / float(profile.duration_ratio)
    return Shock(profile=profile, peak_force=_FORCE, rise_time=rise_time)
