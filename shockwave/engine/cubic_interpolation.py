"""Cubic interpolation within a step, from values and slopes at its ends."""

import math
from collections.abc import Sequence

import numpy as np

from shockwave.base.numerics import FloatArray


def root(y0: float, b0: float, y1: float, b1: float) -> float:
    """Root in (0, 1) of the cubic with values y0, y1 of opposite signs and slopes b0, b1 at 0 and 1.

    Newton's method starts from the root of the parabola that ignores b1.
    """
    c, e = 3 * (y1 - y0) - 2 * b0 - b1, b0 + b1 - 2 * (y1 - y0)
    slope = math.copysign(math.sqrt((b0 + 2 * y0) * (b0 + 2 * y0) - 4 * y0 * y1), y0) - b0
    at = 2 * y0 / slope if slope else math.inf
    for _ in range(3):
        slope = b0 + at * (2 * c + at * 3 * e)
        at = at - (y0 + at * (b0 + at * (c + at * e))) / slope if slope else math.inf
    return at if 0.0 < at < 1.0 or y0 == y1 else y0 / (y0 - y1)


def top(r0: float, r1: float, rise: float) -> float:
    """Position of the maximum in (0, 1) of a cubic that rises by ``rise``, with slopes r0 > 0, r1 <= 0 at its ends."""
    at = root(r0, 6 * rise - 4 * r0 - 2 * r1, r1, 2 * r0 + 4 * r1 - 6 * rise)
    return at if at < 1.0 else 0.5


def top_between(begin: Sequence[float], end: Sequence[float]) -> float:
    """Place of the maximum of a cubic between two places, from place, value and slope there."""
    span = end[0] - begin[0]
    return begin[0] + span * top(span * begin[2], span * end[2], end[1] - begin[1])


def around_tops(f: FloatArray, r: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Intervals around the maxima of cubics, from values and slopes at 0 and 1, both of shape (2, cubics).

    Returns place, value and slope at the beginnings and at the ends of the intervals, shape (3, cubics), and upper
    bounds on the maxima. A cubic with slopes of the same sign may have a maximum and a minimum, on both sides of its
    point of inflection, where the interval begins or ends. Without a maximum above both values the slope at the
    beginning is not positive, or that at the end is, or the bound is not above them.
    """
    rise = f[1] - f[0]
    c, e = 3 * rise - 2 * r[0] - r[1], r[0] + r[1] - 2 * rise
    low, high = np.array((np.zeros(len(rise)), *f[:1], *r[:1])), np.array((np.ones(len(rise)), *f[1:], *r[1:]))
    with np.errstate(all="ignore"):
        at = -c / (3 * e)
        bends = (at > 0) & (at < 1) & ((r[0] > 0) == (r[1] > 0))
        if bends.any():
            middle = np.array([at, f[0] + at * (r[0] + at * (c + at * e)), r[0] + at * (2 * c + at * 3 * e)])
            low = np.where(bends & (r[0] <= 0), middle, low)
            high = np.where(bends & (r[0] > 0), middle, high)
    return low, high, np.maximum(low[1], high[1]) + 0.25 * (high[0] - low[0]) * (low[2] - high[2])
