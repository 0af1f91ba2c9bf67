"""A shock as a few impulses with the same lowest moments."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache

import numpy as np
from attrs import frozen

from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.prediction.model_interface import Indices, ScaledShock
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.conditions import reversal
from shockwave.profiles.guard import kept
from shockwave.quadrature import FloatArray

# Number of times that pieces of a smooth part are halved towards its ends, for infinite slopes and steep decays.
_HALVINGS = 12
# Nodes on the wide pieces in the middle of a smooth part and on the other pieces, which are fewer for many parts.
_MIDDLE_NODES = 24
_OUTER_NODES = 6
_FEWER_NODES = 4
# Most parts of a profile with the larger number of nodes.
_FEW_PARTS = 4
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
# Longest pulse, in times of its wave, whose moments suffice; a longer one is divided into equal cells, so that the
# instants do not depend on its breakpoints.
_MOMENTS = 10.0
# Longest pulse, in times of its wave, that is represented as a whole; a longer one by the section around its strongest
# blow, the impulse within so many of these times.
_LONGEST = 50.0
_BLOW = 6.0
# Cells per blow, and most cells at once.
_FINE = 96
_MOST_CELLS = 100_000
# Blows that differ by less, relatively, are equal but for rounding errors.
_EQUAL = 1e-9
# Smallest fall and rise of the force, over its peak, that counts as a second peak; less is noise.
_TURNS = 0.05
# Steps of Lanczos' recurrence after which two vectors are made orthogonal to all earlier ones again.
_ORTHOGONAL = 16
# Time, over that of the wave, over which the force is averaged where peaks are counted, and number of cells.
_AVERAGED = 0.3
_CELLS = 512
#: Upper bound of the amplification of a shock with one peak: that of a lasting force is 2.33.
HIGHEST = 2.36
# Norm of a Lanczos vector below which the recurrence has terminated.
_ROUNDING = 1e-14


@frozen(eq=False)
class Pulse:
    """A pulse as a few impulses.

    Attributes
    ----------
    times : numpy.ndarray, shape (k,)
        Instants after the centroid, over A F0^(-1/6).
    impulses : numpy.ndarray, shape (k,)
        Impulses over that of a wave of the shock's peak force; their sum is S = L / (A F0^(5/6)).
    spread : float
        tau, standard deviation of the force as a density in time, over A F0^(-1/6) S^(-1/5), the passage time of a wave
        with the impulse of the shock.
    known : bool
        Whether the impulses represent the pulse accurately.
    turns : bool
        Whether the pulse has several peaks.
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
    position, vector, last = (times - mean) / scale, np.sqrt(impulses / total), np.zeros(len(times))
    vectors, diagonal, beside = np.zeros((count, len(times))), np.zeros(count), np.zeros(count + 1)
    for row in range(count):
        vectors[row] = vector
        following = position * vector
        diagonal[row] = (vector * following).sum()
        following -= diagonal[row] * vector
        following -= beside[row] * last
        if row % _ORTHOGONAL < 2:
            earlier = vectors[: row + 1]
            following -= np.einsum("ij,i->j", earlier, np.einsum("ij,j->i", earlier, following))
        beside[row + 1] = math.sqrt((following * following).sum())
        if beside[row + 1] < _ROUNDING:
            count = row + 1
            break
        last, vector = vector, following / beside[row + 1]
    jacobi = np.diag(diagonal[:count])
    jacobi[np.arange(1, count), np.arange(count - 1)] = beside[1:count]
    instants, turn = np.linalg.eigh(jacobi)
    return mean + scale * instants, total * turn[0] ** 2


def pulse_of(shock: ScaledShock) -> Pulse:
    """Pulse of a scaled shock, in units with the exact A, independent of ``momentum_parameter``."""
    unit, strength, length = shock.rise_time / MOMENTUM, shock.impulse / MOMENTUM, _length(shock)
    count = next(count for limit, count in _INSTANTS if length <= limit)
    short = length <= _MOMENTS
    s, parts, mean, deviation, known = _discrete(shock.profile, shock.areas.total, count if short else 1)
    if short:
        parts = parts * (strength / parts.sum())
    else:
        s, parts = gauss(*_strongest(shock.profile, length), count)
        parts = parts * unit
    return Pulse((s - mean) * unit, parts, deviation * unit * strength**0.2, known, turns(shock))


def _length(shock: ScaledShock) -> float:
    """Duration over the time of the leading wave."""
    force = min(IMPULSE_LIMIT * (shock.impulse / MOMENTUM) ** 1.2, HIGHEST)
    return float(shock.duration / MOMENTUM * force ** (1 / 6))


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
        blows = np.convolve(impulses, np.ones(held), mode="same")
        middle = centres[np.argmax(blows >= (1 - _EQUAL) * blows.max())]
        half = max(_LONGEST * time / 2, 0.0 if resolved else 2 * (edges[1] - edges[0]))
        begin, end = max(middle - half, 0.0), min(middle + half, n)


@kept
def _discrete(profile: ShockProfile, area: float, count: int) -> tuple[FloatArray, FloatArray, float, float, bool]:
    """Instants s, impulses, mean and standard deviation in s, and whether no impulse is missed.

    Only the number of impulses depends on the duration of the shock, so the result is cached.
    """
    s, impulses = _fine_impulses(profile)
    total = float(impulses.sum())
    mean = float((impulses * s).sum()) / total
    deviation = math.sqrt(max(float((impulses * (s - mean) ** 2).sum()) / total, 0.0))
    known = abs(total / area - 1) <= _MOST_MISSED
    return *gauss(s, impulses, count), mean, deviation, known


def turns(shock: ScaledShock) -> bool:
    """Whether a shock has several peaks, be it of the force or of its average over a fraction of the wave's time.

    The average decides where the highest force lasts too briefly to matter.
    """
    return _turns(shock.profile, round(min(max(_AVERAGED / _length(shock), 1 / _CELLS), 1) * _CELLS))


@kept
def _turns(profile: ShockProfile, cells: int) -> bool:
    """Whether the force, or its average over a number of ``cells``, has several peaks."""
    impulse = profile.running_impulse(np.linspace(0, profile.duration_ratio, _CELLS + 1))
    around = np.concatenate((np.zeros(cells), impulse, np.full(cells, impulse[-1])))
    blows = around[cells:] - around[:-cells]
    rise, decay = np.split(blows, [np.argmax(blows)])
    falls, climbs = np.maximum.accumulate(rise) - rise, decay - np.minimum.accumulate(decay)
    return max(falls.max(initial=0.0), climbs.max()) > _TURNS * blows.max() or reversal(profile) > _TURNS


def _fine_impulses(profile: ShockProfile) -> tuple[FloatArray, FloatArray]:
    """Many instants s and impulses of a profile; of one with very many parts, exact impulses of equal intervals."""
    edges = np.array(profile.breakpoints, dtype=float)
    parts = len(edges) - 1
    if parts > _MOST_PARTS:
        edges = np.linspace(0.0, float(profile.duration_ratio), _MOST_PARTS + 1)
        return (edges[:-1] + edges[1:]) / 2, np.diff(profile.running_impulse(edges))
    if parts <= _SMOOTH_PARTS:
        nodes, weights = gauss_legendre(_HALVINGS, _MIDDLE_NODES, _OUTER_NODES if parts <= _FEW_PARTS else _FEWER_NODES)
    else:
        # Between the samples of a record the force is linear, so three nodes are exact for its fourth moment.
        edges = _divided(edges, (edges[-1] - edges[0]) / _LEAST_PIECES)
        nodes, weights = gauss_legendre(0, 3, 3)
    widths = np.diff(edges)[:, None]
    s = (edges[:-1, None] + widths * nodes).ravel()
    return s, (widths * weights).ravel() * profile.force(s)


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


def alike(sizes: Indices, most: int) -> Iterator[Indices]:
    """Yield the indices of items of equal size above zero, in groups of about ``most`` elements."""
    for size in np.unique(sizes[sizes > 0]).tolist():
        where = np.flatnonzero(sizes == size)
        together = max(1, most // size)
        yield from (where[begin : begin + together] for begin in range(0, len(where), together))
