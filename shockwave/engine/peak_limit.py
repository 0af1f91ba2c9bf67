"""Peak of a contact force within a step, and limit of the peaks of a wave far along the chain."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.engine.force_law import power_force

#: Number of contacts between the peaks that are used for the limit.
STRIDE = 4
#: Number of peaks that are used for the limit.
KEPT = 5
# Largest ratio of consecutive differences; slower convergence cannot be distinguished from noise.
_MAX_RATIO = 0.98
# Largest number of terms of the extrapolated series.
_MAX_TERMS = 100
# Apparent growth of the ratio that counts as noise.
_STEADY = 1.002
#: Fraction of the permitted uncertainty below which alternating differences count as noise.
NOISE = 0.2
# Longest time in which a wave passes from one contact to the next.
_RECENT = 6.0
# Number of contacts over which the growth of a wave is measured; over a single one it is mostly noise.
_TREND = 4
# Assumed sum of a slowly converging series, in units of its last term.
_SLOW = 200


def limit(peaks: Sequence[float], allowed: float) -> tuple[float, float]:
    """Limit of the last `KEPT` peaks, `STRIDE` contacts apart, and its extrapolation uncertainty.

    Far from other waves the peaks converge geometrically, with a slowly decreasing ratio. The uncertainty is the sum of
    half the change of the limit by the last peak, half the change by a constant ratio, and a hundredth of the remaining
    distance. ``allowed`` is the permitted uncertainty. The uncertainty is infinite if the peaks do not converge.
    """
    p = peaks[-KEPT:]
    first, second, last = p[2] - p[1], p[3] - p[2], p[4] - p[3]
    doubt = abs(last) + abs(second)
    if not (first * second > 0 and second * last > 0):
        return p[4], doubt if doubt <= NOISE * allowed else math.inf
    if not last / second < _MAX_RATIO:
        return p[4], _SLOW * abs(last)
    left = _rest(p[1:], bends=True)
    doubt = 0.5 * abs(last + left - _rest(p[:4], bends=True))
    doubt = doubt + 0.5 * abs(left - _rest(p[1:], bends=False)) + 0.01 * abs(left)
    if last * first > _STEADY * second * second:
        doubt += abs(left)  # the ratio has not yet settled
    return (p[4] + left, doubt) if math.isfinite(doubt) else (p[4], math.inf)


def _rest(p: Sequence[float], bends: bool) -> float:
    """Distance to the limit of four peaks with geometric differences, whose ratio decreases if it ``bends``."""
    first, second, last = p[1] - p[0], p[2] - p[1], p[3] - p[2]
    if first == 0 or second == 0:
        return math.inf
    older, newer = second / first, last / second
    if not (older > 0 and 0 < newer < _MAX_RATIO):
        return math.inf
    fall = newer / older if bends and newer < older else 1.0
    total, term, ratio = 0.0, last, newer
    for _ in range(_MAX_TERMS):
        if abs(term) <= 1e-17:
            break
        ratio *= fall
        term *= ratio
        total += term
    return total


def find_crossing(
    v0: FloatArray, v1: FloatArray, slope0: FloatArray, slope1: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Fraction of a step at which each contact stops closing, and its closure up to then, over the size of the step.

    The velocity is interpolated by the cubic through values and slopes at both ends.
    """
    c, d = 3 * (v1 - v0) - 2 * slope0 - slope1, slope0 + slope1 - 2 * (v1 - v0)
    share, low, high = v0 / (v0 - v1), np.zeros_like(v0), np.ones_like(v0)
    for _ in range(2):
        v = v0 + share * (slope0 + share * (c + share * d))
        slope = slope0 + share * (2 * c + share * 3 * d)
        low, high = np.where(v > 0, share, low), np.where(v > 0, high, share)
        share = np.where(slope == 0, -1.0, share - v / np.where(slope == 0, 1.0, slope))
        share = np.where((low < share) & (share < high), share, (low + high) / 2)
    return share, share * (v0 + share * (slope0 / 2 + share * (c / 3 + share * d / 4)))


def growth_since(late: FloatArray, since: FloatArray, now: float, growing: float) -> FloatArray:
    """Largest peak forces that waves may reach, from forces and times of the last peak at each contact.

    They follow from the change over the last contacts; a decrease feeds another wave. ``growing`` is the number of such
    changes that may follow.
    """
    front = len(late)
    change, same = np.zeros(front), np.ones(front, dtype=bool)
    for back in range(1, min(_TREND, front - 1) + 1):
        same[back:] &= (since[:-back] < since[1 : front - back + 1]) & (late[:-back] > 0)
        same[:back] = False
        np.copyto(change[back:], np.abs(late[back:] - late[:-back]) / back, where=same[back:])
    return np.where(now - since < _RECENT, late + np.minimum(growing * change, late), 0.0)


def window_energy(x: FloatArray, v: FloatArray, exponent: float) -> float:
    """Energy of granules with velocities v and of their contacts; x contains one more granule."""
    closed = np.maximum(x[:-1] - x[1:], 0.0)
    return math.fsum((0.5 * v * v + 1 / (exponent + 1) * closed * power_force(closed, exponent)).tolist())
