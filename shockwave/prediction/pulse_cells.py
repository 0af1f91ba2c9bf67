"""Long shocks as impulses in cells of equal width."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from shockwave.profiles.base import ShockProfile
from shockwave.profiles.power_law import ManyPowers, Powers
from shockwave.quadrature import FloatArray

#: Longest pulse, in passage times of its wave, that is represented as a whole; of a longer one only sections of this
#: length in all are used.
LONGEST = 50.0
# Lengths of the windows whose largest impulses are sought, in the same times: a lasting force forms its wave in the
# longest one, a short blow within the shortest.
_BLOWS = (6.0, 3.0, 2.0, 1.2)
# Number of pieces of a cell, from which its moments are computed.
_PIECES = 8
# Cells in such a time where the strongest blow is sought, and most cells at once.
_FINE = 16
_MOST_CELLS = 100_000
# Blows that differ by less, relatively, are equal but for rounding errors.
_EQUAL = 1e-9


def cells_of(profile: ShockProfile, count: int, begin: float, end: float) -> tuple[FloatArray, FloatArray]:
    """Instants s and impulses, two in each of ``count`` / 2 cells of equal width between two s."""
    edges = np.linspace(begin, end, count // 2 * _PIECES + 1)
    return _pairs(edges, np.diff(profile.running_impulse(edges)))


def cells_of_powers(powers: Sequence[Powers], count: int) -> tuple[FloatArray, FloatArray]:
    """`cells_of` for several power laws over all their duration, one in each row."""
    laws, pieces = ManyPowers(powers), count // 2 * _PIECES
    edges = np.minimum(laws.duration_ratio / pieces * np.arange(pieces + 1)[:, None], laws.duration_ratio)
    return _pairs(edges.T, np.diff(laws.closed_running_impulse(edges), axis=0).T)


def _pairs(edges: FloatArray, impulses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two instants and impulses for each cell with its four lowest moments, from pieces, shape (..., pieces)."""
    shape = (*impulses.shape[:-1], -1, _PIECES)
    parts = np.maximum(np.ascontiguousarray(impulses).reshape(shape), 0.0)  # rounding errors may be negative
    total = parts.sum(axis=-1)
    parts = np.where(total[..., None] > 0, parts, 1.0)
    parts /= parts.sum(axis=-1, keepdims=True)
    middle = np.ascontiguousarray(edges[..., :-1] + edges[..., 1:]).reshape(shape) / 2
    mean = (parts * middle).sum(axis=-1, keepdims=True)
    off = middle - mean
    own = (middle[..., 1] - middle[..., 0]) ** 2 / 12  # variance within a piece
    variance = (parts * off**2).sum(axis=-1) + own
    half = (parts * off**3).sum(axis=-1) / (2 * variance)
    root = np.sqrt(half**2 + variance)
    offsets = np.stack((half - root, half + root), axis=-1)
    shares = np.stack((0.5 + half / (2 * root), 0.5 - half / (2 * root)), axis=-1)
    pulses = (*impulses.shape[:-1], -1)
    return (mean + offsets).reshape(pulses), (total[..., None] * shares).reshape(pulses)


def strongest_section(profile: ShockProfile, length: float, count: int) -> tuple[FloatArray, FloatArray]:
    """Cells around the strongest blows of a pulse: one section, or several shorter ones if the blows are far apart.

    The whole pulse takes ``length`` passage times. The leading wave of a long shock forms within a few of its own
    times, where the force is strongest.
    """
    n = float(profile.duration_ratio)
    whole = LONGEST * n / length
    groups = [[middle] for middle in sorted(_strongest(profile, round(_FINE * blow), whole) for blow in _BLOWS)]
    # sections that would overlap are one
    while near := next((i for i in range(1, len(groups)) if groups[i][0] - groups[i - 1][-1] < whole / len(groups)), 0):
        groups[near - 1] += groups.pop(near)
    cells = np.array_split(np.arange(count // 2), len(groups))
    half = whole / len(groups) / 2
    parts = []
    for group, own in zip(groups, cells, strict=True):
        middle = (group[0] + group[-1]) / 2
        parts.append(cells_of(profile, 2 * own.size, max(middle - half, 0.0), min(middle + half, n)))
    s, impulses = zip(*parts, strict=True)
    return np.concatenate(s), np.concatenate(impulses)


def _strongest(profile: ShockProfile, cells: int, section: float) -> float:
    """Middle of the window of largest impulse, of so many cells; ``section`` is the length of `LONGEST` in s."""
    cell = section / LONGEST / _FINE
    begin, end = 0.0, float(profile.duration_ratio)
    while True:
        number = math.ceil((end - begin) / cell)
        resolved = number <= _MOST_CELLS
        edges = np.linspace(begin, end, min(number, _MOST_CELLS) + 1)
        running = profile.running_impulse(edges)
        index = np.arange(len(edges) - 1)
        held = cells if resolved else 1
        blows = running[np.minimum(index + (held + 1) // 2, index.size)] - running[np.maximum(index - held // 2, 0)]
        first = int(np.argmax(blows >= (1 - _EQUAL) * blows.max()))
        middle = float(edges[first] + edges[first + 1]) / 2
        if resolved:
            return middle
        half = max(section / 2, 2 * float(edges[1] - edges[0]))
        begin, end = max(middle - half, 0.0), min(middle + half, float(profile.duration_ratio))
