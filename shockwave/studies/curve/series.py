"""Piecewise Chebyshev series of a function of one variable."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from attrs import frozen
from numpy.polynomial import chebyshev

from shockwave.numerics import bracketed_root
from shockwave.quadrature import FloatArray

__all__ = ["Piece", "Series"]

# Values that are worked on at once: they stay in the cache of a core.
_BLOCK = 8192
# A root of a derivative is real if its imaginary part is rounding.
_REAL = 1e-7
# A slope errs by so many times the error of the polynomial, over its width and times its degree: measured on four
# shapes at rtol 1e-3 to 1e-5, 3.6 at the most.
_SLOPE_CAUTION = 4.0


@frozen
class Piece:
    """A polynomial on [begin, end], and how far off it may be.

    Attributes
    ----------
    begin, end : float
        Where it holds.
    coefficients : tuple of float
        Of the Chebyshev polynomials of u = (2 x - begin - end)/(end - begin), lowest first.
    error : float
        Bound on its distance from the function, as checked.
    """

    begin: float
    end: float
    coefficients: tuple[float, ...]
    error: float

    def shares(self, x: FloatArray) -> FloatArray:
        """Where ``x`` lies, -1 to 1."""
        return (2 * x - (self.begin + self.end)) / (self.end - self.begin)

    def __call__(self, x: FloatArray) -> FloatArray:
        return np.asarray(chebyshev.chebval(self.shares(x), self.coefficients))

    def slope(self, x: FloatArray) -> FloatArray:
        """Derivative at ``x``."""
        scale = 2 / (self.end - self.begin)
        return np.asarray(
            scale * chebyshev.chebval(self.shares(x), chebyshev.chebder(np.array([*self.coefficients, 0.0])))
        )

    def turns(self, slope: float) -> list[float]:
        """Ascending x within, at which ``slope`` x and this polynomial together turn."""
        derivative = chebyshev.chebder(np.array([*self.coefficients, 0.0]))
        derivative[0] += slope * (self.end - self.begin) / 2
        roots = chebyshev.chebroots(np.trim_zeros(derivative, "b"))
        shares = np.sort(roots.real[(np.abs(roots.imag) < _REAL) & (np.abs(roots.real) < 1)])
        return [float(self.begin + (1 + share) / 2 * (self.end - self.begin)) for share in shares]


@frozen
class Series:
    """Polynomials that join without gaps, one or more, ascending."""

    pieces: tuple[Piece, ...]

    @property
    def begin(self) -> float:
        """Where it begins."""
        return self.pieces[0].begin

    @property
    def end(self) -> float:
        """Where it ends."""
        return self.pieces[-1].end

    def __call__(self, x: FloatArray) -> FloatArray:
        """Values at ``x``, of any shape, within the range."""
        return self._by_piece(x, Piece.__call__)

    def slope(self, x: FloatArray) -> FloatArray:
        """Derivatives at ``x``, of any shape, within the range."""
        return self._by_piece(x, Piece.slope)

    def _by_piece(self, x: FloatArray, evaluate: Callable[[Piece, FloatArray], FloatArray]) -> FloatArray:
        flat = x.ravel()
        result = np.empty_like(flat)
        for begin in range(0, flat.size, _BLOCK):
            block = flat[begin : begin + _BLOCK]
            where = self._where(block)
            values = np.empty_like(block)
            for index in np.unique(where):
                chosen = where == index
                values[chosen] = evaluate(self.pieces[index], block[chosen])
            result[begin : begin + _BLOCK] = values
        return result.reshape(x.shape)

    def error(self, x: FloatArray) -> FloatArray:
        """Bounds on the errors of the values at ``x``."""
        return np.asarray(np.array([piece.error for piece in self.pieces])[self._where(x)])

    def slope_error(self, x: FloatArray) -> FloatArray:
        """Estimates of the errors of the slopes at ``x``."""
        scale = [_SLOPE_CAUTION * p.error * (len(p.coefficients) - 1) / (p.end - p.begin) for p in self.pieces]
        return np.asarray(np.array(scale)[self._where(x)])

    def _where(self, x: FloatArray) -> np.ndarray:
        return np.searchsorted([piece.end for piece in self.pieces[:-1]], x)

    def landmarks(self, slope: float) -> list[tuple[float, float]]:
        """Ends and turning points of ``slope`` x and the series together, as (x, value); monotone between them."""
        points = [self.begin]
        for piece in self.pieces:
            points += [*piece.turns(slope), piece.end]
        values = slope * np.array(points) + self(np.array(points))
        return list(zip(points, values.tolist(), strict=True))

    def solve(self, value: float, slope: float) -> list[float]:
        """All x after the beginning, ascending, at which ``slope`` x and the series together have this value."""
        found = []
        for (begin, low), (end, high) in pairwise(self.landmarks(slope)):
            if high == value:
                found.append(end)
            elif (low - value) * (high - value) < 0:

                def off(x: float) -> float:
                    return slope * x + float(self(np.array([x]))[0]) - value

                # rounding may put the value at an end on the other side
                if off(begin) * off(end) <= 0:
                    found.append(bracketed_root(off, begin, end, "point of the curve"))
        return found
