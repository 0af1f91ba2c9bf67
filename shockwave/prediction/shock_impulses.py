"""A shock as a few impulses: with the same lowest moments, or in cells if it is long."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, TypeGuard

import numpy as np
from attrs import frozen

from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM, wave_law
from shockwave.prediction.gauss_impulses import gauss
from shockwave.prediction.model_interface import Indices, ScaledShock, Shocks
from shockwave.prediction.pulse_cells import LONGEST, cells_of, cells_of_powers, strongest_section
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.conditions import reversal
from shockwave.profiles.guard import is_value, kept, trusted
from shockwave.profiles.power_law import ManyPowers, Powers, power
from shockwave.quadrature import FloatArray

# Number of times that pieces of a smooth part are halved towards its ends, for infinite slopes and steep decays.
_HALVINGS = 12
# Nodes on each wide piece in the middle of a smooth part and on each other piece; the latter are fewer for many parts.
_MIDDLE_NODES = 16
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
# Upper limits of durations, in passage times t_A (F/F0)^(-1/6) of the leading wave, and the number of impulses up to
# each; they have the same lowest moments as the force.
_LIMITS = np.array([0.5, 1.5, 3.0, 5.0, 6.0])
_COUNTS = np.array([8, 12, 16, 24, 32])
# In a longer pulse these impulses would be too far apart, so that it is divided into cells of equal width with two
# impulses each. A force is concentrated if this multiple of its standard deviation in time is within the last limit. It
# keeps the last number of impulses, because the stated error is so small that cells would be too coarse.
_WIDTHS = 8.0
# Number of impulses in a passage time and, so that shocks of one shape share cells, the least number and the number of
# which all are multiples.
_DENSITY = 2.8
_FEWEST = 36
_MULTIPLE = 4
# Smallest fall and rise of the force, over its peak, that counts as a second peak; less is noise.
_TURNS = 0.05
# Most pulses that are reduced together: more would leave the processor's cache.
_AT_ONCE = 32
# Most rules that are kept.
_MOST_KNOWN = 4096
# Time, over that of the wave, over which the force is averaged where peaks are counted, and number of cells.
_AVERAGED = 0.3
_CELLS = 512
# Amplification of a lasting force in the kernel of the law.
_HIGHEST = 2.36
#: Simulated amplification of a lasting force, which that of a long, smooth shock with one peak approaches.
LASTING = 2.33


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


def pulse_of(shock: ScaledShock) -> Pulse:
    """Pulse of a scaled shock, in units with the exact A, independent of ``momentum_parameter``."""
    return pulses_of(shock.alone)[0]


def pulses_of(shocks: Shocks) -> list[Pulse]:
    """Pulses of many shocks; those with equally many impulses are computed together."""
    profiles, shapes, unit = shocks.profiles, shocks.shapes, shocks.rise_times / MOMENTUM
    areas = np.array([each.total for each in shocks.areas])[shapes]
    strength = areas * unit
    ratios = np.array([float(profile.duration_ratio) for profile in profiles])[shapes]
    lengths = ratios * unit * np.minimum(IMPULSE_LIMIT * strength**1.2, _HIGHEST) ** (1 / 6)
    counts = _counts(profiles, shapes, lengths, lengths / ratios)
    single = [_has_one_peak(profile) for profile in profiles]
    found: dict[int, Pulse] = {}
    for count in sorted(set(counts.tolist())):
        where = (counts == count).nonzero()[0]
        if count < 0:
            own = [profiles[shape] for shape in shapes[where]]
            cells = map(strongest_section, own, lengths[where].tolist(), [-count] * len(own))
            s, parts = map(np.array, zip(*cells, strict=True))
            parts *= unit[where, None]
            moments = np.array([_moments(profile) for profile in own])
        else:
            s, parts, moments = _rules(profiles, shapes[where], count)
            parts = parts * (strength[where] / parts.sum(axis=1))[:, None]
        mean, deviation, total = moments.T
        times = (s - mean[:, None]) * unit[where, None]
        spread = deviation * unit[where] * strength[where] ** 0.2
        known = np.abs(total / areas[where] - 1) <= _MOST_MISSED
        several = [
            not single[shape] and turns(shocks.shock(index))
            for index, shape in zip(where.tolist(), shapes[where].tolist(), strict=True)
        ]
        found.update(
            zip(where.tolist(), map(Pulse, times, parts, spread.tolist(), known.tolist(), several), strict=True)
        )
    return [found[index] for index in range(len(shocks))]


def _counts(profiles: Sequence[ShockProfile], shapes: Indices, lengths: FloatArray, times: FloatArray) -> Indices:
    """Numbers of impulses that represent pulses of these durations, negative where they represent only a section.

    ``lengths`` are the durations and ``times`` the rise times, in passage times.
    """
    found: Indices = _COUNTS.take(_LIMITS.searchsorted(lengths), mode="clip")
    longer = (lengths > _LIMITS[-1]).nonzero()[0]
    if longer.size:
        used, back = np.unique(shapes[longer], return_inverse=True)
        deviations = _moments_together([profiles[shape] for shape in used])[back, 1] * times[longer]
        own = lengths[longer]
        cells = _MULTIPLE * np.ceil(np.minimum(own, LONGEST) * (_DENSITY / _MULTIPLE)).astype(int)
        cells = np.maximum(cells, _FEWEST) * np.where(own > LONGEST, -1, 1)
        found[longer] = np.where(_WIDTHS * deviations <= _LIMITS[-1], _COUNTS[-1], cells)
    return found


_Rules = tuple[FloatArray, FloatArray, FloatArray]
# Cache of rules by profile and number of impulses, because the batches of a sweep share shapes.
_rule_cache: dict[Any, Any] = {}


def _rules(profiles: Sequence[ShockProfile], shapes: Indices, count: int) -> _Rules:
    """Instants s and impulses of pulses, shape (pulses, ``count``) each, and their moments, shape (pulses, 3).

    ``shapes`` are the indices of their profiles. If there is only one profile, the arrays have a single row for all.
    """
    if len(profiles) == 1:
        s, parts, moments = _rule(profiles[0], count)
        return s[None], parts[None], moments[None]
    used, back = np.unique(shapes, return_inverse=True)
    own = [profiles[shape] for shape in used.tolist()]
    keys = [(profile, count) if is_value(profile) else None for profile in own]
    rules = [_rule_cache.get(key) for key in keys]
    new = [index for index, rule in enumerate(rules) if rule is None]
    for index, *rule in zip(new, *_rules_together([own[index] for index in new], count), strict=True):
        rules[index] = rule
    if len(_rule_cache) + len(new) > _MOST_KNOWN:
        _rule_cache.clear()
    _rule_cache.update((keys[index], rules[index]) for index in new if keys[index] is not None)
    s, parts, moments = map(np.array, zip(*rules, strict=True))
    return s[back], parts[back], moments[back]


def _rules_together(profiles: Sequence[ShockProfile], count: int) -> _Rules:
    """Instants s, impulses and moments of shapes, a row for each profile, computed without the cache."""
    s, parts = np.empty((2, len(profiles), count))
    groups, left = _groups_of(profiles)
    if count >= _FEWEST:
        for group, laws in groups:
            s[group], parts[group] = cells_of_powers(laws, count)
        for index in left:
            s[index], parts[index] = cells_of(profiles[index], count, 0.0, float(profiles[index].duration_ratio))
        return s, parts, _moments_together(profiles)
    for group, laws in groups:
        s[group], parts[group] = gauss(*_fine_impulses_of_powers(laws), count)
    for among, times, impulses in _together([_fine_impulses(profiles[index]) for index in left]):
        where = np.array(left)[among]
        s[where], parts[where] = gauss(times, impulses, count)
    return s, parts, _moments_together(profiles)


def _moments_together(profiles: Sequence[ShockProfile]) -> FloatArray:
    """`_moments` of several profiles, shape (profiles, 3)."""
    if len(profiles) == 1:
        return _moments(profiles[0])[None]
    moments = np.empty((len(profiles), 3))
    groups, left = _groups_of(profiles)
    for group, laws in groups:
        moments[group] = _moments_of_powers(ManyPowers(laws))
    moments[left] = np.reshape([_moments(profiles[index]) for index in left], (-1, 3))
    return moments


def _groups_of(profiles: Sequence[ShockProfile]) -> tuple[list[tuple[list[int], list[Powers]]], list[int]]:
    """Indices of smooth power laws in groups that are computed together, with the laws; indices of the others."""
    powers: list[tuple[int, Powers]] = []
    left: list[int] = []
    for index, profile in enumerate(profiles):
        if _is_smooth_law(profile):
            powers.append((index, profile))
        else:
            left.append(index)
    shares = [powers[begin : begin + _AT_ONCE] for begin in range(0, len(powers), _AT_ONCE)]
    return [([index for index, _ in share], [law for _, law in share]) for share in shares], left


@kept
def _rule(profile: ShockProfile, count: int) -> _Rules:
    if count < _FEWEST:
        return *gauss(*_fine_impulses(profile), count), _moments(profile)
    s, parts, moments = _rules_together([profile], count)
    return s[0], parts[0], moments[0]


def _together(jobs: Sequence[tuple[FloatArray, FloatArray]]) -> Iterator[tuple[Indices, FloatArray, FloatArray]]:
    """Yield pulses of many impulses in groups: their indices, and as rows of arrays their instants and impulses."""
    order = np.argsort([s.size for s, _ in jobs], kind="stable")
    for begin in range(0, len(order), _AT_ONCE):
        group = order[begin : begin + _AT_ONCE]
        times, impulses = np.zeros((2, len(group), jobs[group[-1]][0].size))
        for row, index in enumerate(group):
            s, parts = jobs[index]
            times[row], times[row, : s.size], impulses[row, : s.size] = s[-1], s, parts
        yield group, times, impulses


def spread_of(shock: ScaledShock) -> float:
    """Spread tau of the pulse of a shock; see `Pulse`."""
    _, deviation, _ = _moments(shock.profile)
    p, unit = shock.exponent, wave_law(shock.exponent).momentum
    return float(deviation * shock.rise_time / unit * (shock.impulse / unit) ** ((p - 1) / (p + 1)))


def _length(shock: ScaledShock) -> float:
    """Duration over the time of the leading wave."""
    force = min(IMPULSE_LIMIT * (shock.impulse / MOMENTUM) ** 1.2, _HIGHEST)
    return float(shock.duration / MOMENTUM * force ** (1 / 6))


@kept
def _moments(profile: ShockProfile) -> FloatArray:
    """Mean and standard deviation of s, weighted by the force, and the impulse; shape (3,)."""
    if _is_smooth_law(profile):
        return _moments_of_powers(profile)
    s, impulses = _fine_impulses(profile)
    total = impulses.sum()
    mean = (impulses * s).sum() / total
    return np.array((mean, np.sqrt((impulses * (s - mean) ** 2).sum() / total), total))


def _moments_of_powers(law: Powers) -> FloatArray:
    """`_moments` of a power law, in closed form; shape (3,), or (laws, 3) for `ManyPowers`."""
    eta1, eta2, width = law.rise_exponent, law.decay_exponent, law.duration_ratio - 1
    rise, decay = law.closed_areas()
    first, last = (1 + eta1) / (2 + eta1), 1 + width / (2 + eta2)
    total = rise + decay
    mean = (rise * first + decay * last) / total
    of_rise = first / ((2 + eta1) * (3 + eta1)) + (first - mean) ** 2
    of_decay = width**2 * (1 + eta2) / ((2 + eta2) ** 2 * (3 + eta2)) + (last - mean) ** 2
    return np.array((mean, np.sqrt((rise * of_rise + decay * of_decay) / total), total)).T


def turns(shock: ScaledShock) -> bool:
    """Whether a shock has several peaks: of the force, or of its average over a fraction of the wave's time.

    The average has several peaks if the highest force lasts too briefly to matter.
    """
    profile = shock.profile
    if _has_one_peak(profile):
        return False
    return _turns(profile, round(min(max(_AVERAGED / _length(shock), 1 / _CELLS), 1) * _CELLS))


def _has_one_peak(profile: ShockProfile) -> bool:
    """Whether the class of the profile allows one peak only."""
    return trusted(profile) and type(profile).__name__ != "Tabulated"


@kept
def _turns(profile: ShockProfile, cells: int) -> bool:
    """Whether the force, or its average over a number of ``cells``, has several peaks."""
    impulse = profile.running_impulse(np.linspace(0, profile.duration_ratio, _CELLS + 1))
    around = np.concatenate((np.zeros(cells), impulse, np.full(cells, impulse[-1])))
    blows = around[cells:] - around[:-cells]
    rise, decay = np.split(blows, [np.argmax(blows)])
    falls, climbs = np.maximum.accumulate(rise) - rise, decay - np.minimum.accumulate(decay)
    return max(falls.max(initial=0.0), climbs.max()) > _TURNS * blows.max() or reversal(profile) > _TURNS


@kept
def _fine_impulses(profile: ShockProfile) -> tuple[FloatArray, FloatArray]:
    """Many instants s and impulses of a profile; of one with very many parts, exact impulses of equal intervals."""
    if _is_smooth_law(profile):
        times, impulses = _fine_impulses_of_powers([profile])
        return times[0], impulses[0]
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


def _is_smooth_law(profile: ShockProfile) -> TypeGuard[Powers]:
    return isinstance(profile, Powers) and trusted(profile) and profile.is_smooth


def _fine_impulses_of_powers(laws: Sequence[Powers]) -> tuple[FloatArray, FloatArray]:
    """`_fine_impulses` for several smooth power laws, one in each row."""
    # at least two, because NumPy may round a power differently if there is only one exponent
    several = laws if len(laws) > 1 else [*laws, *laws]
    rise, decay, n = np.array([(law.rise_exponent, law.decay_exponent, law.duration_ratio) for law in several]).T
    nodes, weights = (each[:, None] for each in gauss_legendre(_HALVINGS, _MIDDLE_NODES, _OUTER_NODES))
    width = n - 1
    s = np.concatenate((np.repeat(nodes, n.size, axis=1), 1 + width * nodes))
    left = np.minimum((n - s[nodes.size :]) / width, 1.0)
    parts = np.concatenate((weights * power(s[: nodes.size], rise), width * weights * power(left, decay)))
    own = slice(len(laws))
    return np.ascontiguousarray(s.T[own]), np.ascontiguousarray(parts.T[own])


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
    for size in sorted(set(sizes[sizes > 0].tolist())):
        where = np.flatnonzero(sizes == size)
        together = max(1, most // size)
        yield from (where[begin : begin + together] for begin in range(0, len(where), together))
