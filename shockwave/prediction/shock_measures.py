"""Integrals of a shock: its measures, and a few impulses with the same lowest moments."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from attrs import frozen

from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.prediction.model_interface import ScaledShock
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.conditions import reversal
from shockwave.profiles.guard import kept
from shockwave.quadrature import FloatArray

# Number of times that pieces of a smooth part are halved towards its ends, for infinite slopes and steep decays.
_HALVINGS = 36
# Most parts of a smooth profile; a profile with more parts is a record, whose pieces need no halving.
_SMOOTH_PARTS = 16
# Least number of pieces of a record: its wide parts are divided, as high moments need many instants.
_LEAST_PIECES = 256
# Most parts of a record of which every sample is used.
_MOST_PARTS = 2048
# Pieces wider than this fraction of a part lie in its middle.
_MIDDLE = 0.05
# Largest fraction of the impulse that the points may miss; if they miss more, the pulse is too fine for them.
_MOST_MISSED = 1e-3
# (longest duration, number of impulses) that represent a pulse; durations are in times of its wave.
_INSTANTS = ((0.5, 8), (1.5, 12), (3.0, 16), (10.0, 32), (35.0, 64), (math.inf, 128))
# Longest pulse, in times of its wave, that is represented as a whole; a longer one by the section around its strongest
# blow, the impulse within so many of these times.
_LONGEST = 50.0
_BLOW = 6.0
# Cells per blow, and most cells at once.
_FINE = 96
_MOST_CELLS = 100_000
# Smallest fall and rise of the force, over its peak, that counts as a second peak; less is noise.
_TURNS = 0.05
# Amplification of a step force, accurate to one per cent.
_HIGHEST = 2.36
# Norm of a Lanczos vector below which the recurrence has terminated.
_ROUNDING = 1e-14


@frozen
class Measures:
    """Integrals of a shock on which the laws for simulated peak forces depend.

    Attributes
    ----------
    strength : float
        S, impulse over that of a wave of the shock's peak force, L / (A F0^(5/6)) with the exact A.
    spread : float
        tau, standard deviation of the force as a density in time, over A F0^(-1/6) S^(-1/5), the passage time of a wave
        with the impulse of the shock.
    skewness : float
        Skewness of that density.
    mean_force, cubic_mean_force : float
        Mean and cubic mean of the force over F0, weighted with the impulse: int F^2 / int F, and the cube root of
        int F^4 / int F.
    duration : float
        n t0/T0.
    """

    strength: float
    spread: float
    skewness: float
    mean_force: float
    cubic_mean_force: float
    duration: float

    def logarithms(self) -> FloatArray:
        """Logarithms of strength, mean force and cubic mean force, shape (3,)."""
        return np.log([self.strength, self.mean_force, self.cubic_mean_force])


def measures(shock: ScaledShock) -> Measures | None:
    """Measures of ``shock``; None if they cannot be computed to three digits because it is too fine or too extreme."""
    s, weights = points(shock.profile)
    force = shock.profile.force(s)
    with np.errstate(all="ignore"):
        density = weights * force
        total = float(density.sum())
        if not abs(total / shock.areas.total - 1) <= _MOST_MISSED:
            return None
        off = s - float((density * s).sum()) / total
        means = [float((density * each).sum()) / total for each in (off**2, off**3, force, force**3)]
        variance, third_moment, mean_force, cubed_force = means
        strength = shock.impulse / MOMENTUM
        spread = math.sqrt(variance) * shock.rise_time / MOMENTUM * strength**0.2
        skewness = third_moment / variance**1.5
        found = Measures(strength, spread, skewness, mean_force, cubed_force ** (1 / 3), shock.duration)
        numbers = (found.spread, found.skewness, *found.logarithms())
    return found if np.isfinite(numbers).all() else None


def points(
    profile: ShockProfile, halvings: int = _HALVINGS, middle: int = 4, outer: int = 4
) -> tuple[FloatArray, FloatArray]:
    """Points s and weights for integrals over a whole profile.

    Parameters
    ----------
    profile : ShockProfile
        The profile; its breakpoints are the ends of the parts.
    halvings : int
        Number of times that the pieces of a smooth part are halved towards both its ends.
    middle, outer : int
        Number of Gauss-Legendre nodes on the wide pieces in the middle of a smooth part, and on the other pieces.

    Returns
    -------
    numpy.ndarray, shape (points,)
        Points s.
    numpy.ndarray, shape (points,)
        Weights.
    """
    breakpoints = profile.breakpoints
    parts = len(breakpoints) - 1
    if parts > _MOST_PARTS:
        breakpoints = (*breakpoints[: -1 : -(-parts // _MOST_PARTS)], breakpoints[-1])
    edges = np.array(breakpoints, dtype=float)
    if parts <= _SMOOTH_PARTS:
        nodes, weights = gauss_legendre(halvings, middle, outer)
    else:
        # Between the samples of a record the force is linear, so three nodes are exact for its fourth power.
        edges = _divided(edges, (edges[-1] - edges[0]) / _LEAST_PIECES)
        nodes, weights = gauss_legendre(0, 3, 3)
    widths = np.diff(edges)[:, None]
    return (edges[:-1, None] + widths * nodes).ravel(), (widths * weights).ravel()


def _divided(edges: FloatArray, width: float) -> FloatArray:
    """``edges`` and equally spaced ones between those that are farther apart than ``width``."""
    counts = np.ceil(np.diff(edges) / width).astype(int)
    first = np.repeat(edges[:-1], counts)
    share = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.append(first + share * np.repeat(np.diff(edges) / counts, counts), edges[-1])


@cache
def gauss_legendre(halvings: int, middle: int, outer: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on the `pieces` of [0, 1], ``middle`` on wide pieces and ``outer`` on others."""
    edges = pieces(halvings)
    rule = cache(np.polynomial.legendre.leggauss)
    nodes, weights = [], []
    for begin, width in zip(edges[:-1], np.diff(edges), strict=True):
        x, own = rule(middle if width > _MIDDLE else outer)
        nodes.append(begin + width * (1 + x) / 2)
        weights.append(width * own / 2)
    return np.concatenate(nodes), np.concatenate(weights)


def pieces(halvings: int) -> FloatArray:
    """Edges of pieces of [0, 1] that are halved ``halvings`` times towards both ends."""
    if not halvings:
        return np.array([0.0, 1.0])
    towards = np.append(0.0, 0.5 ** np.arange(halvings, 0, -1))
    return np.concatenate((towards, 1 - towards[-2::-1]))


# ---------------------------------------------------------------- a pulse as a few impulses


@frozen(eq=False)
class Pulse:
    """A pulse as a few impulses.

    ``times``, over A F0^(-1/6), and ``impulses``, over that of a wave of peak force F0, have shape (k,). ``spread`` is
    tau of `Measures`. ``known`` is True if they represent the pulse accurately, ``turns`` if it has several peaks.
    """

    times: FloatArray
    impulses: FloatArray
    spread: float
    known: bool
    turns: bool

    def stretched(self, factor: float) -> Pulse:
        """Pulse with ``factor`` times the duration and the same peak force."""
        return Pulse(self.times * factor, self.impulses * factor, self.spread * factor**1.2, self.known, self.turns)


def gauss(times: FloatArray, impulses: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Instants and impulses, at most ``count``, with the same 2 ``count`` lowest moments, by Lanczos' recurrence.

    Parameters
    ----------
    times, impulses : numpy.ndarray, shape (points,)
        A pulse as many impulses; impulses that are not positive are ignored.
    count : int
        Number of impulses to compute.
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
        for _ in range(2):  # twice, because of rounding errors
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
    """Pulse of a scaled shock, in units with the exact A, independent of ``momentum_parameter``."""
    unit, strength = shock.rise_time / MOMENTUM, shock.impulse / MOMENTUM
    force = min(IMPULSE_LIMIT * strength**1.2, _HIGHEST)
    length = shock.duration / MOMENTUM * force ** (1 / 6)
    count = next(count for limit, count in _INSTANTS if length <= limit)
    s, parts, mean, deviation, known, several = _discrete(shock.profile, shock.areas.total, count)
    parts = parts * (strength / parts.sum())
    if length > _LONGEST:
        s, parts = gauss(*_strongest(shock.profile, length), count)
        parts = parts * unit
    return Pulse((s - mean) * unit, parts, deviation * unit * strength**0.2, known, several)


def _strongest(profile: ShockProfile, length: float) -> tuple[FloatArray, FloatArray]:
    """Instants s and impulses of the section around the strongest blow; the whole takes ``length`` times of its wave.

    The leading wave of a long shock forms within a few of its own times, where the force is strongest.
    """
    n = float(profile.duration_ratio)
    time = n / length
    begin, end = 0.0, n
    while True:
        cells = math.ceil((end - begin) / (_BLOW * time) * _FINE)
        resolved = cells <= _MOST_CELLS
        edges = np.linspace(begin, end, min(cells, _MOST_CELLS) + 1)
        impulses = np.diff(profile.running_impulse(edges))
        centres = (edges[:-1] + edges[1:]) / 2
        if resolved and end - begin <= 1.01 * _LONGEST * time:
            return centres, impulses
        held = min(_FINE if resolved else 1, len(impulses))
        middle = centres[np.argmax(np.convolve(impulses, np.ones(held), mode="same"))]
        half = max(_LONGEST * time / 2, 0.0 if resolved else 2 * (edges[1] - edges[0]))
        begin, end = max(middle - half, 0.0), min(middle + half, n)


@kept
def _discrete(
    profile: ShockProfile, area: float, count: int
) -> tuple[FloatArray, FloatArray, float, float, bool, bool]:
    """Instants s, impulses, mean and standard deviation in s, whether no impulse is missed, and whether peaks follow.

    Only the number of impulses depends on the duration of the shock, so the result is cached.
    """
    s, impulses = _fine_impulses(profile)
    total = float(impulses.sum())
    mean = float((impulses * s).sum()) / total
    deviation = math.sqrt(max(float((impulses * (s - mean) ** 2).sum()) / total, 0.0))
    known = abs(total / area - 1) <= _MOST_MISSED
    return *gauss(s, impulses, count), mean, deviation, known, turns(profile)


@kept
def turns(profile: ShockProfile) -> bool:
    """Whether a profile has several peaks."""
    return reversal(profile) > _TURNS


def _fine_impulses(profile: ShockProfile) -> tuple[FloatArray, FloatArray]:
    """Many instants s and impulses of a profile; of one with very many parts, exact impulses of equal intervals."""
    if len(profile.breakpoints) - 1 > _MOST_PARTS:
        edges = np.linspace(0.0, float(profile.duration_ratio), _MOST_PARTS + 1)
        return (edges[:-1] + edges[1:]) / 2, np.diff(profile.running_impulse(edges))
    few = len(profile.breakpoints) <= 5
    s, weights = points(profile, halvings=12, middle=24, outer=6 if few else 4)
    return s, weights * profile.force(s)
