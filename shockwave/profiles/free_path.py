"""Free-particle displacement: the motion of a free granule under the shock, as a table of polynomials and powers.

For profiles with closed forms the table is exact; for any other force it is fitted.
"""

from __future__ import annotations

import functools
import math
import operator
from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from attrs import define, frozen
from numpy.polynomial import chebyshev, polynomial

from shockwave.base.numerics import FloatArray, elementwise, product, running_sums
from shockwave.profiles.quadrature import Integrand

_EPSILON = float(np.finfo(float).eps)
# Rounding error of the evaluation of a piece, relative to the largest value.
_ROUNDING = 8 * _EPSILON
# Rounding error of (n - s)/(n - 1) in machine epsilons: two differences and a quotient, half a unit each.
_SHARE_ROUNDINGS = 1.5
# Number of tables of power laws that are kept: series of scenes often share a few shapes.
_MOST_KEPT = 256
# Exponents of the displacement for which a polynomial is faster than a power.
_POLYNOMIALS = range(2, 7)

# Chebyshev coefficients in z of 1, y, y^2 and y^3, y = (1 + z)/2.
_POWERS = np.array([[32, 0, 0, 0], [16, 16, 0, 0], [12, 16, 4, 0], [10, 15, 6, 1]]) / 32
# Degree of the fitted polynomials.
_DEGREE = 32
# Number of last coefficients that estimate the truncation error. A jump changes all of them; by symmetry some can
# vanish.
_TAIL = 6
# Allowed error of a piece, relative to impulse and displacement at the end of rise or decay.
_TOLERANCE = 1e-15
# Coefficients below this fraction of the same scale are dropped.
_DROPPED = 5e-17
# Largest number of pieces of rise or decay, in addition to those between breakpoints.
_MOST_PIECES = 2048
# After this number of unsuccessful halvings a piece next to a breakpoint probably has an infinite slope there.
_PATIENCE = 2
# Number of further halvings towards that breakpoint that are then made at once.
_GRADES = 8
# Least width of a piece, in units of the spacing of floats, that has room for distinct nodes.
_NARROWEST = 32.0
# Coefficients below this fraction of the force are rounding errors, which shorter pieces do not reduce.
_NOISE = 2 * _EPSILON
# Rounding error of one value of the force, in machine epsilons.
_ROUNDINGS = 4.0


#: A function of an array of places.
Function: TypeAlias = Callable[[FloatArray], FloatArray]


@frozen(slots=False, eq=False)
class FreePath:
    """Running impulse and displacement of a free granule of unit mass, for unit peak force and rise time.

    ``impulse`` is the integral of the force on 0 <= s <= n, and ``path``, the free-particle displacement, is the
    integral of the impulse. On one piece, begin <= s <= end, with z = (2 s - begin - end)/(end - begin) and
    u = abs(s - anchor)/scale::

        path    = sum_k c_k T_k(z) + amplitude u**exponent
        impulse = sum_k d_k T_k(z) +- (amplitude exponent/scale) u**(exponent - 1)

    where the sign is + if anchor <= begin, else -, and T_k are the Chebyshev polynomials.

    Attributes
    ----------
    rows : array of float, shape (m, 8)
        For each piece: begin, end, offset, count, amplitude, exponent, anchor, scale. Pieces are contiguous and in
        ascending order; the piece of s is the last one with begin <= s. Its coefficients are
        ``coefficients[offset : offset + count]``. The amplitude is 0 if the piece has no power.
    coefficients : array of float, shape (K, 2)
        c_k and d_k of all pieces.
    error : float
        Conservative error estimate: the larger of the errors of path and impulse, each relative to its value at n.
        For closed forms it is the rounding error.
    """

    rows: FloatArray
    coefficients: FloatArray
    error: float

    @classmethod
    def of_samples(cls, knots: FloatArray, forces: FloatArray, impulses: FloatArray, paths: FloatArray) -> FreePath:
        """Table of a force that is linear between its knots, from force, impulse and path there, each of shape (k,)."""
        widths, left, rise = np.diff(knots), forces[:-1], np.diff(forces)
        square = widths**2
        # coefficients of the powers of y = (s - begin)/width
        path = paths[:-1], widths * impulses[:-1], square * left / 2, square * rise / 6
        impulse = impulses[:-1], widths * left, widths * rise / 2, np.zeros_like(widths)
        terms = (np.array(pair).T[:, None] * row[:, None] for *pair, row in zip(path, impulse, _POWERS, strict=True))
        rows = _make_rows(knots[:-1], knots[1:], np.full(widths.size, 4))
        return cls(rows, np.asarray(sum(terms)).reshape(-1, 2), _ROUNDING)

    @classmethod
    def of_polynomials(cls, edges: FloatArray, path: Function, impulse: Function, degree: int) -> FreePath:
        """Table of functions that are polynomials of at most this ``degree`` between the edges, of shape (k,)."""
        nodes, halves = chebyshev.chebpts1(degree + 1), np.diff(edges) / 2
        points = (edges[:-1] + halves)[:, None] + halves[:, None] * nodes
        series = [chebyshev.chebfit(nodes, function(points).T, degree).T for function in (path, impulse)]
        rows = _make_rows(edges[:-1], edges[1:], np.full(halves.size, degree + 1))
        return cls(rows, np.stack(series, axis=-1).reshape(-1, 2).astype(float), _ROUNDING)

    def check(self) -> None:
        """Raise ValueError if compiled code cannot read the table: type, shape or a row of it is not as described."""
        rows, terms = self.rows, len(self.coefficients)
        for key, array, shape in (("rows", rows, (len(rows), 8)), ("coefficients", self.coefficients, (terms, 2))):
            if array.dtype != np.float64 or array.shape != shape or not array.flags.c_contiguous:
                raise ValueError(f"{key} must be contiguous float64 {shape} (got {array.dtype} {array.shape})")
        begin, end, offset, count, scale = rows[:, [0, 1, 2, 3, 7]].T
        whole = (np.floor(offset) == offset) & (np.floor(count) == count)
        rules = {
            "be finite, with scale > 0": np.isfinite(rows).all(axis=1) & (scale > 0),
            "end where the next one begins": (begin < end) & (end == np.append(begin[1:], end[-1])),
            f"use the {terms} coefficients": whole & (offset >= 0) & (count >= 0) & (offset + count <= terms),
        }
        for rule, holds in rules.items():
            if not holds.all():
                raise ValueError(f"rows[{holds.argmin()}] must {rule} (got {rows[holds.argmin()].tolist()})")

    def at(self, s: float) -> tuple[float, float]:
        """(path, impulse) at one s, 0 <= s <= n."""
        begins, pieces = self._used
        index = bisect_right(begins, s) - 1
        begin, end, higher, lowest, amplitude, exponent, anchor, scale = pieces.get(index) or self._use(index)
        # Differences of close numbers are exact, so narrow pieces far from 0 lose no digits.
        z = ((s - begin) - (end - s)) / (end - begin)
        path = impulse = 0.0
        if lowest:
            twice = 2.0 * z
            path_after = impulse_after = 0.0
            for c, d in higher:  # Clenshaw's recurrence
                path, path_after = c + twice * path - path_after, path
                impulse, impulse_after = d + twice * impulse - impulse_after, impulse
            path = lowest[0] + z * path - path_after
            impulse = lowest[1] + z * impulse - impulse_after
        if amplitude:
            u = abs(s - anchor) / scale
            power = amplitude * u ** (exponent - 1.0)
            path += power * u
            impulse += (power if anchor <= begin else -power) * exponent / scale
        return path, impulse

    @functools.cached_property
    def _used(self) -> tuple[list[float], dict[int, tuple[Any, ...]]]:
        """Begins of all pieces, and the pieces used so far as plain numbers, which are faster than arrays."""
        return self.rows[:, 0].tolist(), {}

    def _use(self, index: int) -> tuple[Any, ...]:
        """A piece as plain numbers: of a record of many samples, few pieces are used."""
        begin, end, first, count, *power = self.rows[index].tolist()
        lowest, *higher = self.coefficients[int(first) : int(first + count)].tolist() or [()]
        piece = self._used[1][index] = (begin, end, higher[::-1], lowest, *power)
        return piece


# ---------------------------------------------------------------- closed forms


@functools.lru_cache(maxsize=_MOST_KEPT)
def tabulate_powers(rise_exponent: float, decay_exponent: float, n: float) -> FreePath:
    """Table of F1 = s^eta1, F2 = ((n - s)/(n - 1))^eta2.

    The rise is a power, and the decay a power and a line; low integer powers become polynomials.
    """
    a1, decay, p, q = 1 / (1 + rise_exponent), n - 1, 2 + rise_exponent, 2 + decay_exponent
    a2 = decay / (1 + decay_exponent)
    rise_power, fall_power = a1 / p, a2 * decay / q
    # The line to which the power of the decay is added.
    half = (a1 + a2) * decay / 2
    line = [rise_power - fall_power + half, a1 + a2, half, 0.0]
    rising: list[float] = []
    if p in _POLYNOMIALS:
        rising = [term for c, d in _expand_power(int(p), 0.5) for term in (c * rise_power, d * a1)]
        rise_power = 0.0
    falling = line
    if q in _POLYNOMIALS:
        falling = [term for c, d in _expand_power(int(q), -0.5) for term in (c * fall_power, -d * a2)]
        falling[:4] = map(operator.add, falling, line)
        fall_power = 0.0
    count = len(rising) // 2
    rise = 0.0, 1.0, 0.0, count, rise_power, p, 0.0, 1.0
    fall = 1.0, n, count, len(falling) // 2, fall_power, q, n, decay
    rows, coefficients = np.array((*rise, *fall)).reshape(2, -1), np.array(rising + falling).reshape(-1, 2)
    # High powers amplify the rounding error of the remaining fraction of the decay.
    rounding = _ROUNDING + _SHARE_ROUNDINGS * _EPSILON * decay / (a1 + a2)
    return FreePath(rows, coefficients, rounding)


def _make_rows(begin: FloatArray, end: FloatArray, count: npt.NDArray[np.int64]) -> FloatArray:
    """Rows of pieces without powers; ``count`` has the number of coefficients of each piece."""
    zeros, ones = np.zeros_like(begin), np.ones_like(begin)
    return np.column_stack((begin, end, count.cumsum() - count, count, zeros, ones, zeros, ones))


@functools.cache
def _expand_power(exponent: int, slope: float) -> list[list[float]]:
    """Chebyshev coefficients in z of y^m and y^(m - 1), y = 1/2 + slope z: m + 1 pairs."""
    path, impulse = (chebyshev.poly2cheb(polynomial.polypow([0.5, slope], m)) for m in (exponent, exponent - 1))
    pairs: list[list[float]] = np.column_stack((path, np.append(impulse, 0.0))).tolist()
    return pairs


# ---------------------------------------------------------------- fit


@functools.cache
def _rule() -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Chebyshev points of [-1, 1], and matrices that convert values at them to coefficients and integrals.

    Returns the points; the matrix from values to coefficients; the weights of the integral over [-1, 1] (Clenshaw &
    Curtis, 1960); and the matrices from coefficients to those of the integral and the double integral from -1.
    """
    k = np.arange(_DEGREE + 1)
    nodes = elementwise(math.sin, np.pi / (2 * _DEGREE) * (2 * k - _DEGREE))
    # Multiples of the angle are reduced to one period, so that large arguments lose no digits.
    cosines = elementwise(math.cos, np.pi / _DEGREE * (np.outer(_DEGREE - k, k) % (2 * _DEGREE)))
    ends = np.where((k == 0) | (k == _DEGREE), 0.5, 1.0)
    to_coefficients = cosines * np.outer(ends, ends) * (2 / _DEGREE)
    once, twice = (np.asarray(chebyshev.chebint(np.eye(_DEGREE + 1), m, lbnd=-1).T, dtype=float) for m in (1, 2))
    return nodes, to_coefficients, (to_coefficients * once.sum(axis=1)).sum(axis=1), once, twice


@define
class _Piece:
    """The force on one piece.

    ``area`` and ``moment`` are the integrals of abs(F) and (stop - s) abs(F), where ``stop`` is the end of rise or
    decay. ``missing`` and ``rounding`` are the truncation error and the rounding error of the impulse; ``scale`` is the
    impulse to which they are compared.
    """

    begin: float
    end: float
    coefficients: FloatArray
    area: float
    moment: float
    missing: float
    rounding: float
    scale: float = 0.0


def fit_free_path(force: Integrand, breakpoints: Sequence[float]) -> FreePath:
    """Fit the table of impulse and displacement to values of the force on 0 <= s <= n."""
    n = breakpoints[-1]
    rising = _fit_pieces(force, [point for point in breakpoints if point <= 1])
    impulse = sum(piece.area for piece in rising)
    path = sum(piece.moment for piece in rising)
    decaying = _fit_pieces(force, [point for point in breakpoints if point >= 1], impulse, path + impulse * (n - 1))
    return _assemble([*rising, *decaying])


def _fit_pieces(force: Integrand, edges: Sequence[float], impulse: float = 0.0, path: float = 0.0) -> list[_Piece]:
    """Pieces that fit the rise or the decay; ``impulse`` and ``path`` are those of what precedes it."""
    waiting = [(_sample(force, begin, end, edges[-1]), 0) for begin, end in pairwise(edges)][::-1]
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
            waiting += [(_sample(force, *ends, edges[-1]), cuts + 1) for ends in pairwise(points)][::-1]
    return done


def _cut(begin: float, end: float, steep: Sequence[float]) -> list[float]:
    """Edges of the halves of a piece; a half next to a point of ``steep`` is halved repeatedly towards that point."""
    half = 0.5 * (end - begin)
    wide = half > _NARROWEST * 2**_GRADES * _EPSILON * end
    shrink = [half * 0.5**grade for grade in range(1, _GRADES + 1)] if wide else []
    near = [begin + width for width in reversed(shrink)] if begin in steep else []
    far = [end - width for width in shrink] if end in steep else []
    return [begin, *near, begin + half, *far, end]


def _sample(force: Integrand, begin: float, end: float, stop: float) -> _Piece:
    nodes, to_coefficients, weights, *_ = _rule()
    half = 0.5 * (end - begin)
    s = (begin + half) + half * nodes
    # The force may be discontinuous at the ends of a piece: 0**eta is 0 for every eta > 0.
    s[0], s[-1] = math.nextafter(begin, end), math.nextafter(end, begin)
    values = force(s)
    coefficients, weighted = product(values[None], to_coefficients)[0], half * np.abs(values) * weights
    area, moment = float(weighted.sum()), float(((stop - s) * weighted).sum())
    missing = half * float(np.abs(coefficients[-_TAIL:]).sum())
    # Rounding a node changes the integral by the spacing of floats times the variation of the force. A decay computed
    # from n - s has the spacing of n everywhere.
    rounding = _EPSILON * (_ROUNDINGS * area + stop * float(np.abs(np.diff(values)).sum()))
    return _Piece(begin, end, coefficients, area, moment, missing, rounding)


def _assemble(pieces: Sequence[_Piece]) -> FreePath:
    *_, once, twice = _rule()
    n = pieces[-1].end
    begin, end = (np.array([getattr(piece, name) for piece in pieces]) for name in ("begin", "end"))
    series = np.array([piece.coefficients for piece in pieces])
    error = np.array([piece.missing + piece.rounding for piece in pieces])
    scales = np.array([piece.scale for piece in pieces])
    width = end - begin
    half = 0.5 * width
    # Bound on the remainder of the series after each coefficient; negligible remainders are dropped.
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
    used = np.arange(path.shape[1]) < count[:, None]
    coefficients = np.stack((path[used], impulse[used]), axis=1)
    shares = error.sum() / impulses[-1], (error * (n - begin)).sum() / paths[-1]
    return FreePath(_make_rows(begin, end, count), coefficients, float(max(shares)) + _ROUNDING)
