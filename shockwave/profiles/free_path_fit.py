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
# Narrower pieces, in units of the spacing of numbers, have no room for distinct nodes.
_NARROWEST = 32.0
# Coefficients that have come down to such a share of the force are rounding, and stay so on shorter pieces.
_NOISE = 2 * _EPSILON
# Roundings of one value of the force, in units of the machine epsilon.
_ROUNDINGS = 4.0


@functools.cache
def _rule() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Chebyshev's points with both ends, the matrix from values there to coefficients, and Clenshaw-Curtis weights."""
    k = np.arange(_DEGREE + 1)
    nodes = elementwise(math.sin, np.pi / (2 * _DEGREE) * (2 * k - _DEGREE))
    # Whole multiples of the angle, taken back to one turn: no digits are lost in large arguments.
    cosines = elementwise(math.cos, np.pi / _DEGREE * (np.outer(_DEGREE - k, k) % (2 * _DEGREE)))
    ends = np.where((k == 0) | (k == _DEGREE), 0.5, 1.0)
    to_coefficients = cosines * np.outer(ends, ends) * (2 / _DEGREE)
    # The integral of T_k over [-1, 1].
    areas = np.where(k % 2 == 0, 2.0 / (1.0 - k**2.0 + (k == 1)), 0.0)
    return nodes, to_coefficients, (to_coefficients * areas).sum(axis=1)


@define
class _Piece:
    """The force on one piece.

    ``area`` and ``moment`` are integrals of F and (stop - s) F, ``stop`` being the end of rise or decay; ``missing`` is
    the error of the impulse by the limited degree, ``rounding`` that by rounded values and nodes, and ``scale`` what
    they are to be small against.
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
    impulse = sum(piece.area for piece in rising)
    path = sum(piece.moment for piece in rising) + impulse * (n - 1)
    decaying = _fit(decay, [point for point in breakpoints if point >= 1], impulse, path)
    return _assembled([*rising, *decaying])


def _fit(force: Integrand, edges: Sequence[float], impulse: float = 0.0, path: float = 0.0) -> list[_Piece]:
    """Ascending pieces that fit the rise, or the decay, before which there are an ``impulse`` and its ``path``."""
    stop = edges[-1]
    waiting = [_sampled(force, begin, end, stop) for begin, end in pairwise(edges)][::-1]
    impulse += sum(piece.area for piece in waiting)
    path += sum(piece.moment for piece in waiting)
    most = len(waiting) + _MOST_PIECES
    done: list[_Piece] = []
    while waiting:
        piece = waiting.pop()
        piece.scale = min(impulse, path / (stop - piece.begin))
        fits = piece.missing <= max(_TOLERANCE * piece.scale, _NOISE * piece.area)
        narrow = piece.end - piece.begin <= _NARROWEST * _EPSILON * piece.end
        if fits or narrow or len(done) + len(waiting) >= most:
            done.append(piece)
        else:
            middle = piece.begin + 0.5 * (piece.end - piece.begin)
            waiting.append(_sampled(force, middle, piece.end, stop))
            waiting.append(_sampled(force, piece.begin, middle, stop))
    return done


def _sampled(force: Integrand, begin: float, end: float, stop: float) -> _Piece:
    nodes, to_coefficients, weights = _rule()
    half = 0.5 * (end - begin)
    s = (begin + half) + half * nodes
    # At the very ends the force may jump: 0**eta is 0, however small eta.
    s = np.clip(s, math.nextafter(begin, end), math.nextafter(end, begin))
    values = force(s)
    coefficients = product(values[None], to_coefficients)[0]
    weighted = half * values * weights
    area = float(weighted.sum())
    moment = float(((stop - s) * weighted).sum())
    missing = half * float(np.abs(coefficients[-_TAIL:]).sum())
    # Nodes moved by a spacing move the integral by the variation times the spacing; a decay that is seen from its end
    # has the spacing of n everywhere.
    variation = float(np.abs(np.diff(values)).sum())
    rounding = _EPSILON * (_ROUNDINGS * area + stop * variation)
    return _Piece(begin, end, coefficients, area, moment, missing, rounding)


def _assembled(pieces: Sequence[_Piece]) -> FreePath:
    n = pieces[-1].end
    rows = []
    series = []
    areas = []
    moments = []
    error = error_of_path = 0.0
    for piece in pieces:
        half = 0.5 * (piece.end - piece.begin)
        # What the rest of the series after each coefficient can add, of which the negligible is dropped.
        rest = half * np.abs(piece.coefficients[::-1]).cumsum()[::-1]
        count = max(2, int((rest > _DROPPED * piece.scale).sum()))
        dropped = float(rest[count]) if count < rest.size else 0.0
        lost = piece.missing + piece.rounding + dropped
        error += lost
        error_of_path += lost * (n - piece.begin)
        path = half**2 * chebyshev.chebint(piece.coefficients[:count], m=2, lbnd=-1)
        impulse = np.append(half * chebyshev.chebint(piece.coefficients[:count], lbnd=-1), 0.0)
        rows.append([piece.begin, piece.end, 0, count + 2, 0, 1, 0, 1])
        series.append(np.column_stack((path, impulse)))
        areas.append(impulse.sum())
        moments.append(path.sum())
    table = np.array(rows, dtype=float)
    table[1:, 2] = table[:-1, 3].cumsum()
    widths = table[:, 1] - table[:, 0]
    impulses = running_sums(np.array(areas))
    gained = np.column_stack((impulses[:-1] * widths, moments))
    paths = running_sums(gained.ravel())[::2]
    for index, half in enumerate(0.5 * widths):
        series[index][:2, 0] += impulses[index] * half
        series[index][0] += paths[index], impulses[index]
    # A force of zero, against the contract, has the errors of zero.
    share = max(error / (impulses[-1] or 1.0), error_of_path / (paths[-1] or 1.0))
    return FreePath(table, np.concatenate(series), float(share) + ROUNDING)
