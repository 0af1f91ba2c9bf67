"""Where a function is not smooth: jumps, kinks and unbounded slopes are told from what is merely steep."""

from __future__ import annotations

import functools
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.quadrature import FloatArray, Integrand

__all__ = ["Roughness", "roughness", "steepening"]

Flags: TypeAlias = npt.NDArray[np.bool_]

_DEGREE = 32
# So many of the last coefficients tell what a polynomial misses. A jump moves each; fewer may vanish by symmetry.
_TAIL = 6
# What is missing counts above this share of 1, and above so many roundings of values and of abscissae.
_LEAST, _ROUNDINGS = 1e-12, 100.0
# Panels are divided so often at most, and are wider than so many spacings of numbers.
_LEVELS, _NARROWEST = 40, 4096.0
# Rough panels that are followed, the worst first.
_FOLLOWED = 64
# No simple fractions: a corner in the middle of a piece shall not fall between two panels; nor in both of two searches.
_CUTS = (0.4563, 0.5311)
# A smooth function's tail plunges once a panel is as narrow as its layer, ever faster from panel to panel; that of a
# jump stays, that of a kink halves, that of a jump of derivative p falls as 2^-p. So many panels in a row tell.
_PLUNGE, _ROW = 2.0**-4.5, 4
# Slopes next to a breakpoint: widths halve so often; over four of them in a row the slope of s^0.96 grows by 1.117.
_HALVINGS, _GROWTH, _PERSISTENT = 34, 1.1, 0.6

_EPSILON = float(np.finfo(float).eps)


@frozen
class Roughness:
    """A place where a function is not smooth: ``at`` in ``begin`` to ``end``, and what it seems to be."""

    at: float
    begin: float
    end: float
    kind: str


@frozen
class _Panels:
    """Panels (k,), and for each what its ancestors' polynomials missed, the nearest first, shape (k, levels)."""

    begin: FloatArray
    end: FloatArray
    missing: FloatArray


@functools.cache
def _rule() -> tuple[FloatArray, FloatArray]:
    """Chebyshev's nodes of the first kind, which leave out the ends, and what takes values to the last coefficients."""
    j = np.arange(_DEGREE + 1)
    angles = np.pi * (j + 0.5) / (_DEGREE + 1)
    tail = np.arange(_DEGREE + 1 - _TAIL, _DEGREE + 1)
    return -np.cos(angles), 2 / (_DEGREE + 1) * np.cos(np.outer(np.pi - angles, tail))


def roughness(function: Integrand, points: tuple[float, ...]) -> Roughness | None:
    """A place between ``points`` where ``function``, of order 1, is not smooth; None where none is found.

    Panels are divided where the function is no polynomial of degree 32, and their tails compared from one to the next.
    Panels that touch one of the points are divided, too, and not judged.
    """
    edges = np.array(points)
    return next((found for cut in _CUTS if (found := _searched(function, edges, cut)) is not None), None)


def _searched(function: Integrand, edges: FloatArray, cut: float) -> Roughness | None:
    panels = _Panels(edges[:-1], edges[1:], np.empty((edges.size - 1, 0)))
    for level in range(_LEVELS + 1):
        missing, floor = _missing(function, panels)
        rows = np.column_stack((missing, panels.missing))
        inner = ~(np.isin(panels.begin, edges) | np.isin(panels.end, edges))
        wide = panels.end - panels.begin > _NARROWEST * np.spacing(np.abs(panels.end))
        rough = missing > floor
        last = rough & inner & (~wide | (level == _LEVELS))
        # Where both parts fit, their whole was the last rough panel of its line.
        ended = _with_sibling(inner & ~rough)
        suspects = np.flatnonzero((last & _slow(rows)) | (ended & _slow(rows[:, 1:])))
        if suspects.size:
            return _found(panels, rows, int(suspects[0]), bool(rough[suspects[0]]))
        follow = np.flatnonzero(rough & wide)
        if not follow.size:
            return None
        follow = follow[np.argsort(-missing[follow], kind="stable")[:_FOLLOWED]]
        panels = _divided(panels, rows, follow, cut)
    return None


def _missing(function: Integrand, panels: _Panels) -> tuple[FloatArray, FloatArray]:
    """What the polynomial of each panel misses, and how much of that may be rounding."""
    nodes, tail = _rule()
    half = 0.5 * (panels.end - panels.begin)
    s = (panels.begin + half)[:, None] + half[:, None] * nodes
    values = np.asarray(function(s.ravel()), dtype=float).reshape(s.shape)
    variation = np.abs(np.diff(values, axis=1)).sum(axis=1)
    rounding = _EPSILON * np.abs(values).max(axis=1) + np.spacing(np.abs(panels.end)) * variation / half
    return np.abs(values @ tail).sum(axis=1), np.maximum(_LEAST, _ROUNDINGS * rounding)


def _with_sibling(each: Flags) -> Flags:
    """For panels that stand in pairs: whether it holds for both; an odd number of them was not divided yet."""
    return each if each.size % 2 else np.repeat(each.reshape(-1, 2).all(axis=1), 2)


def _slow(rows: FloatArray) -> Flags:
    """Whether what is missing has fallen no faster than next to a jump of a derivative, time after time."""
    if rows.shape[1] <= _ROW:
        return np.zeros(len(rows), dtype=bool)
    kept = rows[:, :_ROW] >= _PLUNGE * rows[:, 1 : _ROW + 1]
    return np.asarray(kept.all(axis=1))


def _divided(panels: _Panels, rows: FloatArray, which: npt.NDArray[np.intp], cut: float) -> _Panels:
    """Both parts of the panels of those indices, next to each other."""
    begin, end = panels.begin[which], panels.end[which]
    between = begin + cut * (end - begin)
    both = np.column_stack((begin, between)).ravel(), np.column_stack((between, end)).ravel()
    return _Panels(*both, np.repeat(rows[which], 2, axis=0))


def _found(panels: _Panels, rows: FloatArray, index: int, rough: bool) -> Roughness:
    history = rows[index] if rough else rows[index, 1:]
    begin, end = float(panels.begin[index]), float(panels.end[index])
    if not rough:  # the place is anywhere in the parent
        first = index - index % 2
        begin, end = float(panels.begin[first]), float(panels.end[first + 1])
    fall = float(np.log2(history[_ROW] / history[0])) / _ROW
    kind = "a jump" if fall < 0.5 else "a kink" if fall < 1.5 else "a jump of a higher derivative"
    return Roughness((begin + end) / 2, begin, end, kind)


def steepening(function: Integrand, point: float, other: float) -> float | None:
    """The slope of ``function`` next to ``point``, towards ``other``, if it grows without end; else None."""
    least = max(2.0**-_HALVINGS, _NARROWEST * float(np.spacing(abs(point))) / abs(other - point))
    shares = 0.5 ** np.arange(1, int(-np.log2(least)) + 1)
    values = np.asarray(function(point + (other - point) * np.concatenate((shares, [shares[-1] / 2]))), dtype=float)
    rises = np.abs(np.diff(values))
    if rises.size < 9 or min(rises[-9:]) <= 10 * _ROUNDINGS * _EPSILON * np.abs(values).max():
        return None
    slopes = rises / (abs(other - point) * shares / 2)
    last, before = slopes[-1] / slopes[-5], slopes[-5] / slopes[-9]
    # The slope of a layer that is merely steep grows ever less as its width is passed.
    endless = last >= _GROWTH and np.log(last) >= _PERSISTENT * np.log(before)
    return float(slopes[-1]) if endless else None
