"""A pulse as a few impulses with the same first moments, the input of the law of moments."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from attrs import frozen

from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.prediction.model_interface import ScaledShock
from shockwave.prediction.shock_measures import points
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import kept
from shockwave.quadrature import FloatArray

# Instants for pulses that last up to so many times of their wave.
_INSTANTS = ((0.5, 8), (1.5, 12), (3.0, 16), (10.0, 32), (35.0, 64), (math.inf, 128))
# Longer ones, in times of their wave, are cut to the strongest stretch.
_LONGEST = 50.0
# That stretch is looked for on so many cells.
_CELLS = 400
_HIGHEST = 2.36  # amplification, but for a per cent
_ROUNDING = 1e-14
# Points of a pulse by quadrature may miss this share of its impulse; more is a pulse too fine for them.
_MOST_MISSED = 1e-3


@frozen(eq=False)
class Pulse:
    """A pulse as a few impulses: instants, shape (k,), over A F0^(-1/6), and impulses, over those of a wave of F0.

    ``spread`` is tau, the standard deviation of the force in time over A F0^(-1/6) S^(-1/5); ``known`` says whether
    its points missed nothing, and nothing was cut off it.
    """

    times: FloatArray
    impulses: FloatArray
    spread: float
    known: bool

    def stretched(self, factor: float) -> Pulse:
        """The pulse ``factor`` times as long, of the same peak force."""
        return Pulse(self.times * factor, self.impulses * factor, self.spread * factor**1.2, self.known)


def gauss(times: FloatArray, impulses: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """The at most ``count`` instants and impulses with the same first 2 ``count`` moments, by Lanczos' recurrence.

    Parameters
    ----------
    times, impulses : numpy.ndarray, shape (points,)
        A pulse as many impulses; those that are not above zero are left out.
    count : int
        How many to make of them.
    """
    times, impulses = times[impulses > 0], impulses[impulses > 0]
    total = impulses.sum()
    mean = float((impulses * times).sum()) / total
    scale = float(np.max(np.abs(times - mean))) or 1.0
    position, vector = (times - mean) / scale, np.sqrt(impulses / total)
    vectors = np.zeros((count, len(times)))
    diagonal, beside = np.zeros(count), np.zeros(count)
    for row in range(count):
        vectors[row] = vector
        following = position * vector
        diagonal[row] = vector @ following
        for _ in range(2):  # once more, against rounding
            following -= (vectors[: row + 1] @ following) @ vectors[: row + 1]
        beside[row] = np.linalg.norm(following)
        if beside[row] < _ROUNDING:
            count = row + 1
            break
        vector = following / beside[row]
    jacobi = np.diag(diagonal[:count]) + np.diag(beside[: count - 1], 1) + np.diag(beside[: count - 1], -1)
    instants, turn = np.linalg.eigh(jacobi)
    return mean + scale * instants, total * turn[0] ** 2


def pulse_of(shock: ScaledShock) -> Pulse:
    """The pulse of a scaled shock; the exact A, whatever its ``momentum_parameter``."""
    unit, strength = shock.rise_time / MOMENTUM, shock.impulse / MOMENTUM
    force = min(IMPULSE_LIMIT * strength**1.2, _HIGHEST)
    length = shock.duration / MOMENTUM * force ** (1 / 6)
    mean, deviation, known = _width(shock.profile, shock.areas.total)
    spread = deviation * unit * strength**0.2
    count = next(count for limit, count in _INSTANTS if length <= limit)
    if length > _LONGEST:
        s, parts = _strongest(shock, _LONGEST * shock.duration / length / shock.rise_time)
        known = known and float(parts.sum()) >= (1 - _MOST_MISSED) * shock.areas.total
        s, parts = gauss(s, parts, count)
        return Pulse((s - mean) * unit, parts * unit, spread, known)
    s, parts = _instants(shock.profile, count)
    return Pulse((s - mean) * unit, parts * (strength / parts.sum()), spread, known)


def _strongest(shock: ScaledShock, length: float) -> tuple[FloatArray, FloatArray]:
    """Instants s and impulses of the stretch of about this length, in s, that holds the largest impulse."""
    begin, end = 0.0, float(shock.profile.duration_ratio)
    while True:
        edges = np.linspace(begin, end, _CELLS + 1)
        impulses = np.diff(shock.profile.running_impulse(edges))
        cell = (end - begin) / _CELLS
        if end - begin <= 1.2 * length:
            return (edges[:-1] + edges[1:]) / 2, impulses
        held = max(1, math.ceil(length / cell))
        sums = np.convolve(impulses, np.ones(held), mode="valid")
        first = int(np.argmax(sums))
        begin, end = edges[max(first - 1, 0)], edges[min(first + held + 1, _CELLS)]


def _fine(profile: ShockProfile) -> tuple[FloatArray, FloatArray]:
    """Many points s of a profile and their impulses."""
    few = len(profile.breakpoints) <= 5
    s, weights = points(profile, halvings=12, middle=24 if few else 12, outer=6 if few else 4)
    return s, weights * profile.force(s)


@kept
def _instants(profile: ShockProfile, count: int) -> tuple[FloatArray, FloatArray]:
    return gauss(*_fine(profile), count)


@kept
def _width(profile: ShockProfile, area: float) -> tuple[float, float, bool]:
    """Mean and standard deviation in s, and whether the points miss no impulse."""
    s, density = _fine(profile)
    total = float(density.sum())
    mean = float((density * s).sum()) / total
    deviation = math.sqrt(max(float((density * (s - mean) ** 2).sum()) / total, 0.0))
    return mean, deviation, abs(total / area - 1) <= _MOST_MISSED


def padded(pulses: Sequence[Pulse]) -> tuple[FloatArray, FloatArray]:
    """Instants and impulses of pulses, shape (pulses, k) both; what is added to the shorter ones has no impulse."""
    most = max(len(pulse.times) for pulse in pulses)
    times, impulses = np.empty((len(pulses), most)), np.zeros((len(pulses), most))
    for row, pulse in enumerate(pulses):
        own = len(pulse.times)
        times[row, :own], times[row, own:], impulses[row, :own] = pulse.times, pulse.times[-1], pulse.impulses
    return times, impulses
