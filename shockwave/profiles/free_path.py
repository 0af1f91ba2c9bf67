"""The path of a free granule under a shock as a table, to be read without the profile's own code."""

from __future__ import annotations

import functools
import math
from bisect import bisect_right
from collections.abc import Iterable
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import astuple, frozen
from numpy.polynomial import chebyshev

from shockwave.errors import NumericalError
from shockwave.numerics import elementwise, product
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import guarded, is_value
from shockwave.quadrature import FloatArray

__all__ = ["FreePath", "of_powers", "of_samples"]

_EPSILON = float(np.finfo(float).eps)
# What evaluating a piece loses to rounding, of the greatest value.
_ROUNDING = 8 * _EPSILON
# Roundings of (n - s)/(n - 1), in units of the machine epsilon: two differences and a quotient, half a unit each.
_SHARE_ROUNDINGS = 1.5
# Up to this exponent of the path a polynomial takes less time than a power.
_HIGHEST_POLYNOMIAL = 6
# Pieces of a long record, of which a shock reads but a few.
_MANY = 10_000

_DEGREE = 32
# So many of the last coefficients tell what is missing. A jump moves each of them; fewer may vanish by symmetry.
_TAIL = 6
# What a piece may err by, and what may be dropped of it, as shares of the impulse and path at the end of rise or decay.
_TOLERANCE, _DROPPED = 1e-15, 5e-17
# Cuts of a piece in all, and one after the other: a rough force ends here.
_MOST_CUTS, _LEVELS = 1024, 60
# Narrower pieces, in units of the spacing of numbers, have no room for distinct nodes.
_NARROWEST = 32.0
# A piece next to an infinite slope is halved towards it so many times more at once; next to a breakpoint, too, once it
# did not fit so often.
_GRADES, _PATIENCE = 8, 2
# Coefficients that have come down to such a share of the force are rounding, and stay so on shorter pieces.
_NOISE = 2 * _EPSILON
# Roundings of one value of the force, in units of the machine epsilon.
_ROUNDINGS = 4.0


@frozen(slots=False, eq=False)
class FreePath:
    """Running impulse and path of a free granule of unit mass under a shock of unit peak force and rise time.

    The force is integrated once (impulse) and twice (path), on 0 <= s <= n. On one piece, begin <= s <= end, with
    z = (2 s - begin - end)/(end - begin) and u = abs(s - anchor)/scale::

        path    = sum_k c_k T_k(z) + amplitude u**exponent
        impulse = sum_k d_k T_k(z) +- (amplitude exponent/scale) u**(exponent - 1)

    where the sign is + if anchor <= begin, else -, and T_k are Chebyshev's polynomials.

    Attributes
    ----------
    rows : array of float, shape (m, 8)
        Of each piece: begin, end, offset, count, amplitude, exponent, anchor, scale. Pieces ascend and join; the
        piece of s is the last with begin <= s. Its polynomials are ``coefficients[offset : offset + count]``.
        Where amplitude is 0 there is no power.
    coefficients : array of float, shape (K, 2)
        c_k and d_k of all pieces.
    error : float
        Estimate of the error, meant to bound it: the greater of the errors of path and impulse, each over its
        value at n. Pieces in closed form have a rounding.
    """

    rows: FloatArray
    coefficients: FloatArray
    error: float

    @classmethod
    def of(cls, profile: ShockProfile) -> FreePath:
        """The table of a profile: its own, else one fitted to its force.

        Raises
        ------
        NumericalError
            When the force is not finite somewhere.
        """
        closed = profile.closed_free_path()
        if closed is not None:
            return closed
        return _fitted(profile) if is_value(profile) else _fitted.__wrapped__(profile)

    def at(self, s: float) -> tuple[float, float]:
        """(path, impulse) at one s, 0 <= s <= n."""
        begins, rows, paths, impulses = self._plain
        begin, end, start, count, amplitude, exponent, anchor, scale = rows[bisect_right(begins, s) - 1]
        # Differences of neighbours are exact: narrow pieces far from 0 keep their digits.
        z = ((s - begin) - (end - s)) / (end - begin)
        path = impulse = 0.0
        if count:
            first = int(start)
            twice = 2.0 * z
            path_after = impulse_after = 0.0
            for k in range(first + int(count) - 1, first, -1):  # Clenshaw's recurrence
                path, path_after = paths[k] + twice * path - path_after, path
                impulse, impulse_after = impulses[k] + twice * impulse - impulse_after, impulse
            path = paths[first] + z * path - path_after
            impulse = impulses[first] + z * impulse - impulse_after
        if amplitude:
            u = abs(s - anchor) / scale
            power = amplitude * u ** (exponent - 1.0)
            path += power * u
            impulse += (power if anchor <= begin else -power) * exponent / scale
        return path, impulse

    @cached_property
    def _plain(self) -> tuple[Any, ...]:
        """Begins, rows, c_k and d_k as lists, which Python reads faster than arrays; but making them takes time too."""
        columns = (self.rows[:, 0], self.rows, *self.coefficients.T)
        return columns if len(self.rows) > _MANY else tuple(part.tolist() for part in columns)


# ---------------------------------------------------------------- closed forms


def of_powers(rise_exponent: float, decay_exponent: float, n: float) -> FreePath:
    """The table of F1 = s^eta1, F2 = ((n - s)/(n - 1))^eta2: a power and, in the decay, a line; or a polynomial."""
    a1, decay, p, q = 1 / (1 + rise_exponent), n - 1, 2 + rise_exponent, 2 + decay_exponent
    a2 = decay / (1 + decay_exponent)
    rise_amplitude, fall_amplitude = a1 / p, a2 * decay / q
    coefficients = []
    rise_power = fall_power = 0.0
    if p in _POWERS:
        coefficients = [[rise_amplitude * c, a1 * d] for c, d in _POWERS[p]]
    else:
        rise_power = rise_amplitude
    count, half = len(coefficients), (a1 + a2) * decay / 2
    if q in _POWERS:
        # Seen from its end the decay is a rise: odd polynomials change sign.
        signs = (1, -1, 1, -1, 1, -1, 1)
        falling = zip(signs, _POWERS[q], strict=False)
        coefficients += [[fall_amplitude * sign * c, -a2 * sign * d] for sign, (c, d) in falling]
    else:
        fall_power = fall_amplitude
        coefficients += [[0.0, 0.0], [0.0, 0.0]]
    line = coefficients[count], coefficients[count + 1]
    line[0][0] += rise_amplitude - fall_amplitude + half
    line[0][1] += a1 + a2
    line[1][0] += half
    rows = [
        [0.0, 1.0, 0.0, count, rise_power, p, 0.0, 1.0],
        [1.0, n, count, len(coefficients) - count, fall_power, q, n, decay],
    ]
    # The share of the decay that is left is rounded, and its high powers multiply that.
    rounding = _ROUNDING + _SHARE_ROUNDINGS * _EPSILON * decay / (a1 + a2)
    return FreePath(np.array(rows), np.array(coefficients), rounding)


def of_samples(knots: FloatArray, forces: FloatArray, impulses: FloatArray, paths: FloatArray) -> FreePath:
    """The table of a force that is linear between its knots, given force, impulse and path at each; all (k,)."""
    widths, left, rise = np.diff(knots), forces[:-1], np.diff(forces)
    gain, square = 0.5 * widths * impulses[:-1], widths**2
    rows = np.zeros((widths.size, 8))
    rows[:, 0], rows[:, 1] = knots[:-1], knots[1:]
    rows[:, 2], rows[:, 3] = 4 * np.arange(widths.size), 4
    rows[:, 5], rows[:, 7] = 1, 1
    # I + w (f y + r y^2/2) and its integral in Chebyshev's polynomials of z, where y = (1 + z)/2.
    coefficients = np.zeros((widths.size, 4, 2))
    coefficients[:, 0, 0] = paths[:-1] + gain + square * (3 / 16 * left + 5 / 96 * rise)
    coefficients[:, 1, 0] = gain + square * (left / 4 + 5 / 64 * rise)
    coefficients[:, 2, 0] = square * (left / 16 + rise / 32)
    coefficients[:, 3, 0] = square * (rise / 192)
    coefficients[:, 0, 1] = impulses[:-1] + widths * (left / 2 + 3 / 16 * rise)
    coefficients[:, 1, 1] = widths * (left / 2 + rise / 4)
    coefficients[:, 2, 1] = widths * (rise / 16)
    return FreePath(rows, coefficients.reshape(-1, 2), _ROUNDING)


def _powers() -> dict[float, list[tuple[float, float]]]:
    """Chebyshev coefficients in z of y^m and y^(m - 1), y = (1 + z)/2, for each exponent m of a path."""
    powers, half = [[1.0]], [0.5, 0.5]
    for _ in range(_HIGHEST_POLYNOMIAL):
        powers.append(chebyshev.chebmul(powers[-1], half).tolist())
    return {float(m): list(zip(powers[m], [*powers[m - 1], 0.0], strict=True)) for m in range(2, len(powers))}


_POWERS = _powers()

# ---------------------------------------------------------------- fitted to the force


@frozen
class _Rule:
    """Chebyshev's points of [-1, 1], and what takes values at them to coefficients and integrals.

    ``weights`` integrate over [-1, 1] (Clenshaw & Curtis, 1960); ``once`` and ``twice`` take coefficients to those of
    the integrals from -1.
    """

    nodes: FloatArray
    to_coefficients: FloatArray
    weights: FloatArray
    once: FloatArray
    twice: FloatArray


@functools.cache
def _rule() -> _Rule:
    k = np.arange(_DEGREE + 1)
    nodes = elementwise(math.sin, np.pi / (2 * _DEGREE) * (2 * k - _DEGREE))
    # Whole multiples of the angle, taken back to one turn: no digits are lost in large arguments.
    cosines = elementwise(math.cos, np.pi / _DEGREE * (np.outer(_DEGREE - k, k) % (2 * _DEGREE)))
    ends = np.where((k == 0) | (k == _DEGREE), 0.5, 1.0)
    to_coefficients = cosines * np.outer(ends, ends) * (2 / _DEGREE)
    once, twice = (np.asarray(chebyshev.chebint(np.eye(_DEGREE + 1), m, lbnd=-1).T, dtype=float) for m in (1, 2))
    return _Rule(nodes, to_coefficients, (to_coefficients * once.sum(axis=1)).sum(axis=1), once, twice)


@frozen
class _Pieces:
    """Pieces of the fit, all arrays of shape (k,) but ``coefficients`` of the force, (k, degree + 1).

    ``area`` and ``moment`` are integrals of abs(F) and (stop - s) abs(F), ``stop`` being 1 in the rise and n in the
    decay; ``missing`` is what the impulse may err by as the polynomial is none of higher degree, ``rounding`` as
    values and nodes are rounded.
    """

    begin: FloatArray
    end: FloatArray
    stop: FloatArray
    coefficients: FloatArray
    area: FloatArray
    moment: FloatArray
    missing: FloatArray
    rounding: FloatArray

    def __getitem__(self, which: npt.NDArray[np.intp] | npt.NDArray[np.bool_]) -> _Pieces:
        return _Pieces(*(column[which] for column in self.columns))

    @property
    def columns(self) -> tuple[FloatArray, ...]:
        """The arrays, in their order."""
        return astuple(self, recurse=False)

    @classmethod
    def joined(cls, parts: Iterable[_Pieces]) -> _Pieces:
        """All pieces of the parts, ascending."""
        columns = [np.concatenate(column) for column in zip(*(part.columns for part in parts), strict=True)]
        return cls(*columns)[np.argsort(columns[0])]


@frozen
class _Totals:
    """Integrals of abs(F) and (stop - s) abs(F) over the rise and over the decay, columns of ``sums``."""

    sums: FloatArray
    n: float

    @classmethod
    def of(cls, pieces: _Pieces, n: float) -> _Totals:
        rising = pieces.stop == 1
        return cls(product(np.stack((pieces.area, pieces.moment)), np.array((rising, ~rising), dtype=float).T), n)

    def __add__(self, other: _Totals) -> _Totals:
        return _Totals(self.sums + other.sums, self.n)

    @property
    def ends(self) -> tuple[float, float, float, float]:
        """Impulse and path at the peak, and at n."""
        (a1, a2), (p1, p2) = self.sums.tolist()
        return a1, p1, a1 + a2, p1 + a1 * (self.n - 1) + p2

    def scale(self, pieces: _Pieces) -> FloatArray:
        """What an error of the impulse within each piece is to be small against, for impulse and path alike."""
        a1, p1, a, p = self.ends
        rising = pieces.stop == 1
        return np.minimum(np.where(rising, a1, a), np.where(rising, p1, p) / (pieces.stop - pieces.begin))


# Scenes of one shape come in series.
@functools.lru_cache(maxsize=64)
def _fitted(profile: ShockProfile) -> FreePath:
    """The table from values of the force alone: polynomials on pieces, cut where they do not fit."""
    n = profile.duration_ratio
    edges = np.array(sorted({0.0, 1.0, n, *(point for point in profile.breakpoints if 0 < point < n)}))
    steep = np.array(profile.singular_points)
    begin, end = edges[:-1], edges[1:]
    if steep.size:
        begin, end = _cut(begin, end, steep, whole=True)
    done: list[_Pieces] = []
    totals = _Totals(np.zeros((2, 2)), n)
    level, room = 0, _MOST_CUTS
    while True:
        pieces = _sampled(profile, begin, end)
        scale = (totals + _Totals.of(pieces, n)).scale(pieces)
        fits = pieces.missing <= np.maximum(_TOLERANCE * scale, _NOISE * pieces.area)
        fits |= end - begin <= _NARROWEST * _EPSILON * end
        rough = np.flatnonzero(~fits)
        if rough.size > room or level == _LEVELS:
            # The worst first, as far as there is room.
            rough = rough[np.argsort(-pieces.missing[rough] / scale[rough])][: room if level < _LEVELS else 0]
        fits[:] = True
        fits[rough] = False
        done.append(pieces[fits])
        totals += _Totals.of(done[-1], n)
        if not rough.size:
            return _assembled(_Pieces.joined(done), totals)
        # What touches a breakpoint and does not fit after some cuts has, it seems, an infinite slope there.
        begin, end = _cut(begin[rough], end[rough], steep if level < _PATIENCE else edges)
        level, room = level + 1, room - rough.size


def _sampled(profile: ShockProfile, begin: FloatArray, end: FloatArray) -> _Pieces:
    """The force on pieces, in at most one call of its rise and one of its decay."""
    rule = _rule()
    half = 0.5 * (end - begin)
    s = (begin + half)[:, None] + half[:, None] * rule.nodes
    # At the very ends the force may jump: 0**eta is 0, however small eta.
    s[:, 0], s[:, -1] = np.nextafter(begin, end), np.nextafter(end, begin)
    values = np.empty_like(s)
    rising = begin < 1
    for which, name in ((rising, "rise"), (~rising, "decay")):
        if which.any():
            values[which] = guarded(profile, name, s[which].ravel()).reshape(-1, s.shape[1])
    if not np.isfinite(values).all():
        worst = np.flatnonzero(~np.isfinite(values))[0]
        got = f"got {values.flat[worst]:g} at s = {s.flat[worst]:.17g}"
        raise NumericalError(f"{type(profile).__name__}: force over peak force must be finite ({got})")
    stop = np.where(rising, 1.0, profile.duration_ratio)
    coefficients, weighted = product(values, rule.to_coefficients), np.abs(values) * rule.weights
    area = half * weighted.sum(axis=1)
    moment = half * ((stop[:, None] - s) * weighted).sum(axis=1)
    missing = half * np.abs(coefficients[:, -_TAIL:]).sum(axis=1)
    # Nodes moved by a spacing move the integral by the variation times the spacing; a decay that is seen from its end
    # has the spacing of n everywhere.
    variation = np.abs(np.diff(values, axis=1)).sum(axis=1)
    rounding = _EPSILON * (_ROUNDINGS * area + stop * variation)
    return _Pieces(begin, end, stop, coefficients, area, moment, missing, rounding)


def _cut(begin: FloatArray, end: FloatArray, steep: FloatArray, whole: bool = False) -> tuple[FloatArray, FloatArray]:
    """Pieces cut in half, or many times towards a point of ``steep``; ``whole`` leaves those without one alone."""
    middle, half = begin + 0.5 * (end - begin), 0.5 * (end - begin)
    wide = half > _NARROWEST * 2**_GRADES * _EPSILON * end
    low, high = wide & np.isin(begin, steep), wide & np.isin(end, steep)
    halved = np.flatnonzero(~(low | high)) if whole else np.empty(0, dtype=np.intp)
    # Edges of every piece in a row; those that a piece does not need fall on its middle.
    shrink = 0.5 ** np.arange(_GRADES, 0, -1)
    near = np.where(low[:, None], begin[:, None] + half[:, None] * shrink, middle[:, None])
    far = np.where(high[:, None], end[:, None] - half[:, None] * shrink[::-1], middle[:, None])
    edges = np.column_stack((begin, near, middle, far, end))
    edges[halved, 1:-1] = begin[halved, None]
    some = edges[:, 1:] > edges[:, :-1]
    return edges[:, :-1][some], edges[:, 1:][some]


def _assembled(pieces: _Pieces, totals: _Totals) -> FreePath:
    rule, n = _rule(), float(pieces.end[-1])
    half, width = 0.5 * (pieces.end - pieces.begin), pieces.end - pieces.begin
    # What is left of the series after each coefficient, of which the negligible is dropped.
    left = half[:, None] * np.abs(pieces.coefficients[:, ::-1]).cumsum(axis=1)[:, ::-1]
    kept = left > _DROPPED * totals.scale(pieces)[:, None]
    doubt = pieces.missing + pieces.rounding + np.where(kept, 0.0, left).max(axis=1)
    force = np.where(kept, pieces.coefficients, 0.0) * half[:, None]
    path = product(force, rule.twice) * half[:, None]
    impulse = np.zeros_like(path)
    impulse[:, :-1] = product(force, rule.once)
    impulses = _sums(impulse.sum(axis=1).tolist())
    starts = np.array(impulses[:-1])
    paths = _sums((starts * width).tolist(), path.sum(axis=1).tolist())
    path[:, 0] += np.array(paths[:-1]) + starts * half
    path[:, 1] += starts * half
    impulse[:, 0] += starts
    count = kept.sum(axis=1) + 2
    rows = np.zeros((half.size, 8))
    rows[:, 0], rows[:, 1] = pieces.begin, pieces.end
    rows[1:, 2], rows[:, 3] = count.cumsum()[:-1], count
    rows[:, 5], rows[:, 7] = 1, 1
    used = np.arange(path.shape[1]) < count[:, None]
    coefficients = np.stack((path[used], impulse[used]), axis=1)
    _, _, whole_impulse, whole_path = totals.ends
    # A force of zero, against the contract, has the errors of zero.
    shares = doubt.sum() / (whole_impulse or 1.0), (doubt * (n - pieces.begin)).sum() / (whole_path or 1.0)
    return FreePath(rows, coefficients, float(max(shares)) + _ROUNDING)


def _sums(*terms: list[float]) -> list[float]:
    """Sums of the first 0, 1, 2, ... terms, each good to the last digits (Neumaier, 1974)."""
    total = lost = 0.0
    sums = [0.0]
    for several in zip(*terms, strict=True):
        for term in several:
            after = total + term
            lost += (total - after) + term if abs(total) >= abs(term) else (term - after) + total
            total = after
        sums.append(total + lost)
    return sums
