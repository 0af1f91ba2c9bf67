"""The path of a free granule under a shock as a table, to be read without the profile's own code."""

from __future__ import annotations

from bisect import bisect_right
from functools import cached_property
from typing import Any

import numpy as np
from attrs import frozen
from numpy.polynomial import chebyshev

from shockwave.quadrature import FloatArray

_EPSILON = float(np.finfo(float).eps)
#: What evaluating a piece loses to rounding, of the greatest value.
ROUNDING = 8 * _EPSILON
# Roundings of (n - s)/(n - 1), in units of the machine epsilon: two differences and a quotient, half a unit each.
_SHARE_ROUNDINGS = 1.5
# Up to this exponent of the path a polynomial takes less time than a power.
_HIGHEST_POLYNOMIAL = 6


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
        """Begins, rows, c_k and d_k as lists, which Python reads faster than arrays."""
        columns = (self.rows[:, 0], self.rows, *self.coefficients.T)
        return tuple(column.tolist() for column in columns)


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
    rounding = ROUNDING + _SHARE_ROUNDINGS * _EPSILON * decay / (a1 + a2)
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
    return FreePath(rows, coefficients.reshape(-1, 2), ROUNDING)


def _powers() -> dict[float, list[tuple[float, float]]]:
    """Chebyshev coefficients in z of y^m and y^(m - 1), y = (1 + z)/2, for each exponent m of a path."""
    powers, half = [[1.0]], [0.5, 0.5]
    for _ in range(_HIGHEST_POLYNOMIAL):
        powers.append(chebyshev.chebmul(powers[-1], half).tolist())
    return {float(m): list(zip(powers[m], [*powers[m - 1], 0.0], strict=True)) for m in range(2, len(powers))}


_POWERS = _powers()
