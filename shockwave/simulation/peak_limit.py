"""The peak of a contact force within a step, and the limit to which the peaks of a wave tend along the chain."""

from __future__ import annotations

import math
from collections.abc import Sequence

#: Contacts from one peak to the next, and how many peaks it takes.
STRIDE, KEPT = 4, 5
# Slower approaches cannot be distinguished from noise.
_MOST_RATIO = 0.98
_MOST_TERMS = 100
# By how much the ratio of the differences may seem to rise.
_STEADY = 1.002
#: Share of the doubt allowed below which peaks that rise and fall are at their limit; and of that where the work ends.
NOISE = 0.2
# Differences that hardly fall may add up to so many of the last.
_SLOW = 200


def limit(peaks: Sequence[float], allowed: float) -> tuple[float, float]:
    """Limit of the last `KEPT` peaks, `STRIDE` contacts apart, and a bound on its error.

    Far from other waves the peaks approach their limit geometrically, by a ratio that falls slowly itself. The bound,
    the doubt, is half of what the last peak has changed, half of what the bend of the ratio makes, and a hundredth of
    the way that is left. ``allowed`` is the doubt that would do. The doubt is infinite where no limit shows.
    """
    p = peaks[-KEPT:]
    first, second, last = p[2] - p[1], p[3] - p[2], p[4] - p[3]
    doubt = abs(last) + abs(second)
    if not (first * second > 0 and second * last > 0):
        return p[4], doubt if doubt <= NOISE * allowed else math.inf
    if not last / second < _MOST_RATIO:
        return p[4], _SLOW * abs(last)
    left = _rest(p[1:], bends=True)
    doubt = 0.5 * abs(last + left - _rest(p[:4], bends=True))
    doubt = doubt + 0.5 * abs(left - _rest(p[1:], bends=False)) + 0.01 * abs(left)
    if last * first > _STEADY * second * second:
        doubt += abs(left)  # a ratio that rises is on its way to another
    return (p[4] + left, doubt) if math.isfinite(doubt) else (p[4], math.inf)


def _rest(p: Sequence[float], bends: bool) -> float:
    """Distance to the limit of four peaks whose differences fall by a ratio, which falls itself if it ``bends``."""
    first, second, last = p[1] - p[0], p[2] - p[1], p[3] - p[2]
    if first == 0 or second == 0:
        return math.inf
    older, newer = second / first, last / second
    if not (older > 0 and 0 < newer < _MOST_RATIO):
        return math.inf
    fall = newer / older if bends and newer < older else 1.0
    total, term, ratio = 0.0, last, newer
    for _ in range(_MOST_TERMS):
        if abs(term) <= 1e-17:
            break
        ratio *= fall
        term *= ratio
        total += term
    return total


def crossing(v0: float, v1: float, slope0: float, slope1: float) -> tuple[float, float]:
    """Where in a step, as a share of it, a contact stops closing, and how far it has closed till then.

    Its velocity is taken as the cubic through velocities and slopes at both ends.
    """
    c, d = 3 * (v1 - v0) - 2 * slope0 - slope1, slope0 + slope1 - 2 * (v1 - v0)
    share, low, high = v0 / (v0 - v1), 0.0, 1.0
    for _ in range(2):
        v = v0 + share * (slope0 + share * (c + share * d))
        slope = slope0 + share * (2 * c + share * 3 * d)
        if v > 0:
            low = share
        else:
            high = share
        share = share - v / slope if slope else -1.0
        if not low < share < high:
            share = (low + high) / 2
    return share, share * (v0 + share * (slope0 / 2 + share * (c / 3 + share * d / 4)))


def hertz(overlap: float) -> float:
    """Contact force."""
    return overlap * math.sqrt(overlap) if overlap > 0 else 0.0
