"""Short shocks: how the primary of any shape comes from its impulse, and what the duration first takes off.

A shock much shorter than its wave hands its impulse to the first granule. What differs from a blow of no duration is
the momentum that the first contact passes on meanwhile: with g the path of a free granule under the force, v its last
velocity and tm the centroid of the force, the contact feels g^(3/2) instead of (v (t - tm))^(3/2). So

    F = IMPULSE_LIMIT F0 S^(6/5) exp(-CORRECTION sqrt(v) D),   D = int_0^(n t0) (g/v)^(3/2) - max(t - tm, 0)^(3/2) dt,

in units of mass, contact stiffness and F0. For one shape sqrt(v) D is (t0/T0)^3 times a number, that of `correction`:
the leading correction goes with the cube of the duration.
"""

from __future__ import annotations

import math

import numpy as np

from shockwave.profiles.base import ShockProfile

__all__ = ["CORRECTION", "IMPULSE_LIMIT", "correction"]

#: As of `shockwave.chain.solitary_wave`, to all digits that simulation at rtol 1e-12 gives, for seven shapes.
IMPULSE_LIMIT = 1.168181738
#: Simulated at rtol 1e-12 for sixteen shapes that last a tenth of T0: 1.14440 to 1.14455.
CORRECTION = 1.1445

# The integrand has the slopes of powers at the breakpoints: pieces halve towards both ends of each smooth part, unless
# there are so many parts that each is short.
_HALVINGS, _SMOOTH_PARTS, _NODES = 20, 8, 8


def correction(profile: ShockProfile) -> float:
    """How much momentum the first contact passes on early: sqrt(v) D over (t0/T0)^3, without a unit.

    Parameters
    ----------
    profile : ShockProfile
        The shape.
    """
    n, area = float(profile.duration_ratio), profile.areas().total
    whole = float(profile.double_integral(n))
    # The time from the centroid of the force to its end; the path after the end is a straight line from there.
    after = whole / area
    edges = _edges(np.array(profile.breakpoints, dtype=float))
    x, weights = np.polynomial.legendre.leggauss(_NODES)
    widths = np.diff(edges)[:, None]
    s = (edges[:-1, None] + widths * (1 + x) / 2).ravel()
    path = profile.free_path()
    # rounding may put a path of nothing below it
    paths = np.maximum([path.at(float(point))[0] for point in s], 0.0) / area
    held = float((widths * weights / 2).ravel() @ paths**1.5)
    return math.sqrt(area) * (held - math.sqrt(after) * after**2 / 2.5)


def _edges(breakpoints: np.ndarray) -> np.ndarray:
    if len(breakpoints) - 1 > _SMOOTH_PARTS:
        return breakpoints
    towards = np.append(0.0, 0.5 ** np.arange(_HALVINGS, 0, -1))
    shares = np.concatenate((towards, 1 - towards[-2::-1]))
    inner = breakpoints[:-1, None] + np.diff(breakpoints)[:, None] * shares[:-1]
    return np.append(inner.ravel(), breakpoints[-1])
