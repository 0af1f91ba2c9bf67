"""Cubic interpolation within a step, from values and slopes at its ends."""

import math


def root(d0: float, d1: float, m0: float, m1: float) -> float:
    """Root in [0, 1] of the cubic with values d0, d1 of opposite signs and slopes m0, m1 at the ends."""
    c, e = 3 * (d1 - d0) - 2 * m0 - m1, m0 + m1 - 2 * (d1 - d0)
    low, high, at = 0.0, 1.0, d0 / (d0 - d1)
    for _ in range(6):
        value = d0 + at * (m0 + at * (c + at * e))
        slope = m0 + at * (2 * c + at * 3 * e)
        low, high = (at, high) if value * d0 > 0 else (low, at)
        at = at - value / slope if slope else -1.0
        if not low <= at <= high:
            at = (low + high) / 2
    return at


def top(r0: float, r1: float, rise: float) -> float:
    """Place in (0, 1) of the maximum of a cubic that rises by ``rise``, with slopes r0 > 0 and r1 <= 0 at its ends."""
    b, c = 6 * rise - 4 * r0 - 2 * r1, 3 * (r0 + r1) - 6 * rise
    square = b * b - 4 * c * r0
    at = 2 * r0 / (math.sqrt(square) - b) if square > 0 and math.sqrt(square) > b else r0 / (r0 - r1)
    return at if 0.0 < at < 1.0 else 0.5
