"""Free path of a force without closed form: polynomials on pieces, which are halved until they fit."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from attrs import define
from numpy.polynomial import chebyshev

from shockwave.numerics import elementwise, product, running_sums
from shockwave.profiles.free_path import ROUNDING, FreePath
from shockwave.quadrature import FloatArray, Integrand

_EPSILON = float(np.finfo(float).eps)

_DEGREE = 32
# So many of the last coefficients show what is missing. A jump moves each of them; fewer may vanish by symmetry.
_TAIL = 6
# What a piece may err by, as a share of the impulse and path at the end of rise or decay.
_TOLERANCE = 1e-15
# What may be dropped of it, as such a share.
_DROPPED = 5e-17
# Pieces of rise or decay that a rough force is cut into at most, beside those between breakpoints.
_MOST_PIECES = 2048
# A piece next to a breakpoint that did not fit so often has, it seems, an infinite slope there.
_PATIENCE = 2
# It is halved towards the breakpoint so many times more at once.
_GRADES = 8
# Narrower pieces, in units of the spacing of numbers, have no room for distinct nodes.
_NARROWEST = 32.0
# Coefficients that have come down to such a share of the force are rounding, and stay so on shorter pieces.
_NOISE = 2 * _EPSILON
# Roundings of one value of the force, in units of the machine epsilon.
_ROUNDINGS = 4.0


@functools.cache
def _rule() -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Chebyshev's points of [-1, 1], and what takes values at them to coefficients and integrals.

    The points; the matrix from values to coefficients; weights that integrate over [-1, 1] (Clenshaw & Curtis, 1960);
    the matrices from coefficients to those of the integral and double integral from -1.
    """
    k = np.arange(_DEGREE + 1)
    nodes = elementwise(math.sin, np.pi / (2 * _DEGREE) * (2 * k - _DEGREE))
    # Whole multiples of the angle, taken back to one turn: no digits are lost in large arguments.
    cosines = elementwise(math.cos, np.pi / _DEGREE * (np.outer(_DEGREE - k, k) % (2 * _DEGREE)))
    ends = np.where((k == 0) | (k == _DEGREE), 0.5, 1.0)
    to_coefficients = cosines * np.outer(ends, ends) * (2 / _DEGREE)
    once, twice = (np.asarray(chebyshev.chebint(np.eye(_DEGREE + 1), m, lbnd=-1).T, dtype=float) for m in (1, 2))
    return nodes, to_coefficients, (to_coefficients * once.sum(axis=1)).sum(axis=1), once, twice


@define
class _Piece:
    """The force on one piece.

    ``area`` and ``moment`` are integrals of abs(F) and (stop - s) abs(F), ``stop`` being the end of rise or decay;
    ``missing`` is the error of the impulse by the limited degree, ``rounding`` that by rounded values and nodes, and
    ``scale`` what they are to be small against.
    """

    begin: float
    end: float
    coefficients: FloatArray
    area: float
    moment: float
    missing: float
    rounding: float
    scale: float = 0.0


def fitted(rise: Integrand, decay: Integrand, breakpoints: Sequence[float]) -> FreePath:
    """The table of impulse and path from values of the force alone.

    Parameters
    ----------
    rise, decay : callable
        The force on 0 <= s <= 1 and on 1 <= s <= n.
    breakpoints : sequence of float
        As of `ShockProfile`.
    """
    n = breakpoints[-1]
    rising = _fit(rise, [point for point in breakpoints if point <= 1])
    impulse, path = (sum(getattr(piece, name) for piece in rising) for name in ("area", "moment"))
    decaying = _fit(decay, [point for point in breakpoints if point >= 1], impulse, path + impulse * (n - 1))
    return _assembled([*rising, *decaying])


def _fit(force: Integrand, edges: Sequence[float], impulse: float = 0.0, path: float = 0.0) -> list[_Piece]:
    """Ascending pieces that fit the rise, or the decay, before which there are an ``impulse`` and its ``path``."""
    waiting = [(_sampled(force, begin, end, edges[-1]), 0) for begin, end in pairwise(edges)][::-1]
    impulse += sum(piece.area for piece, _ in waiting)
    path += sum(piece.moment for piece, _ in waiting)
    most = len(waiting) + _MOST_PIECES
    done: list[_Piece] = []
    while waiting:
        piece, cuts = waiting.pop()
        piece.scale = min(impulse, path / (edges[-1] - piece.begin))
        fits = piece.missing <= max(_TOLERANCE * piece.scale, _NOISE * piece.area)
        if fits or piece.end - piece.begin <= _NARROWEST * _EPSILON * piece.end or len(done) + len(waiting) >= most:
            done.append(piece)
        else:
            points = _cut(piece.begin, piece.end, edges if cuts >= _PATIENCE else [])
            waiting += [(_sampled(force, *ends, edges[-1]), cuts + 1) for ends in pairwise(points)][::-1]
    return done


def _cut(begin: float, end: float, steep: Sequence[float]) -> list[float]:
    """Edges of the halves of a piece, next to a point of ``steep`` halved many times towards it."""
    half = 0.5 * (end - begin)
    wide = half > _NARROWEST * 2**_GRADES * _EPSILON * end
    shrink = [half * 0.5**grade for grade in range(1, _GRADES + 1)] if wide else []
    near = [begin + width for width in reversed(shrink)] if begin in steep else []
    far = [end - width for width in shrink] if end in steep else []
    return [begin, *near, begin + half, *far, end]


def _sampled(force: Integrand, begin: float, end: float, stop: float) -> _Piece:
    nodes, to_coefficients, weights, *_ = _rule()
    half = 0.5 * (end - begin)
    s = (begin + half) + half * nodes
    # At the very ends the force may jump: 0**eta is 0, however small eta.
    s[0], s[-1] = math.nextafter(begin, end), math.nextafter(end, begin)
    values = force(s)
    coefficients, weighted = product(values[None], to_coefficients)[0], half * np.abs(values) * weights
    area, moment = float(weighted.sum()), float(((stop - s) * weighted).sum())
    missing = half * float(np.abs(coefficients[-_TAIL:]).sum())
    # Nodes moved by a spacing move the integral by the variation times the spacing; a decay that is seen from its end
    # has the spacing of n everywhere.
    rounding = _EPSILON * (_ROUNDINGS * area + stop * float(np.abs(np.diff(values)).sum()))
    return _Piece(begin, end, coefficients, area, moment, missing, rounding)


def _assembled(pieces: Sequence[_Piece]) -> FreePath:
    *_, once, twice = _rule()
    n = pieces[-1].end
    begin, end = (np.array([getattr(piece, name) for piece in pieces]) for name in ("begin", "end"))
    series = np.array([piece.coefficients for piece in pieces])
    error = np.array([piece.missing + piece.rounding for piece in pieces])
    scales = np.array([piece.scale for piece in pieces])
    width = end - begin
    half = 0.5 * width
    # What the rest of the series after each coefficient can add, of which the negligible is dropped.
    rest = half[:, None] * np.abs(series[:, ::-1]).cumsum(axis=1)[:, ::-1]
    kept = rest > _DROPPED * scales[:, None]
    error += np.where(kept, 0.0, rest).max(axis=1)
    force = np.where(kept, series, 0.0) * half[:, None]
    path = product(force, twice) * half[:, None]
    impulse = np.zeros_like(path)
    impulse[:, :-1] = product(force, once)
    impulses = running_sums(impulse.sum(axis=1))
    starts = impulses[:-1]
    paths = running_sums(np.column_stack((starts * width, path.sum(axis=1))).ravel())[::2]
    path[:, 0] += paths[:-1] + starts * half
    path[:, 1] += starts * half
    impulse[:, 0] += starts
    count = kept.sum(axis=1) + 2
    rows = np.zeros((half.size, 8))
    rows[:, 0], rows[:, 1] = begin, end
    rows[1:, 2], rows[:, 3] = count.cumsum()[:-1], count
    rows[:, 5], rows[:, 7] = 1, 1
    used = np.arange(path.shape[1]) < count[:, None]
    coefficients = np.stack((path[used], impulse[used]), axis=1)
    # A force of zero, against the contract, has the errors of zero.
    shares = error.sum() / (impulses[-1] or 1.0), (error * (n - begin)).sum() / (paths[-1] or 1.0)
    return FreePath(rows, coefficients, float(max(shares)) + ROUNDING)
