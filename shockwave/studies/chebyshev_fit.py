"""Adaptive fit of piecewise Chebyshev polynomials to a function that is expensive to evaluate.

On every piece the nodes are Leja's: the next is where the product of the distances to all before is greatest, so the
polynomial through those before is checked where it is least certain, and no evaluation is lost (Reichel, "Newton
interpolation at Leja points", BIT 30, 1990). A piece whose checks do not improve is halved, and its halves use the
evaluations made before.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np
from attrs import evolve, frozen
from numpy.polynomial import Chebyshev, chebyshev

from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray

# A root of a derivative is real if its imaginary part, over the width of the piece, is rounding.
_REAL = 5e-8
# The error of a slope is this times the error of the polynomial, over its width and times its degree: on four shapes at
# rtol 1e-3 to 1e-5 the factor was at most 3.6.
_SLOPE_CAUTION = 4.0
# Where the first pieces join, over the range. A shock that ends abruptly gives ripples of one period in time: in its
# logarithm they crowd together at the end.
_JOINTS = (0.0, 0.4, 0.7, 1.0)
# The fewest nodes of a polynomial,
_LEAST = 7
# those after which one whose last checks exceed the allowed error by this factor is given up,
_PATIENT = 18
_FAR = 5.0
# and the most.
_MOST = 24
# So many checks in a row must be within this share of the tolerance. Below the tight tolerance weak kinks show, as
# where a contact opens: polynomials improve slowly, and more checks are due.
_CHECKS = 3
_MORE_CHECKS = 6
_TIGHT = 5e-5
_SHARE = 0.32
# An earlier evaluation serves as the next node where its product of distances is this share of the greatest.
_NEAR = 0.5
_FINE = np.cos(np.linspace(np.pi, 0.0, 401))
# Width to which a kink or a jump is enclosed; the error of that piece covers it.
_NARROWEST = 1e-3
# What takes more evaluations is too rough for polynomials; the roughest of 95 curves to 1e-6 took 203.
_BUDGET = 1000


@frozen
class Piece:
    """A polynomial on [begin, end].

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

    @cached_property
    def polynomial(self) -> Chebyshev:
        """The polynomial as a function of x."""
        return Chebyshev(self.coefficients, domain=(self.begin, self.end))

    @property
    def slope_error(self) -> float:
        """Estimate of the error of the polynomial's derivative."""
        return _SLOPE_CAUTION * self.error * (len(self.coefficients) - 1) / (self.end - self.begin)

    def turns(self, slope: float) -> list[float]:
        """Ascending x inside, at which ``slope`` x and this polynomial together turn."""
        roots = (self.polynomial.deriv() + slope).trim().roots()
        inside = (self.begin < roots.real) & (roots.real < self.end)
        real = np.abs(roots.imag) < _REAL * (self.end - self.begin)
        return sorted(roots.real[inside & real].tolist())


def evaluated(pieces: Sequence[Piece], x: FloatArray) -> FloatArray:
    """Values of adjoining pieces at ``x``, of any shape, within their range."""
    where = np.searchsorted([piece.end for piece in pieces[:-1]], x)
    return np.piecewise(x, [where == k for k in range(len(pieces))], [piece.polynomial for piece in pieces])


def fitted(function: Callable[[float], float], begin: float, end: float, tolerance: float) -> tuple[Piece, ...]:
    """Adjoining pieces that follow ``function`` on [begin, end], refined until checks agree to ``tolerance``.

    Parameters
    ----------
    function : callable
        Of a number; it is called once for each x.
    begin, end : float
        The range, in order.
    tolerance : float
        Absolute, above 0.

    Returns
    -------
    tuple of Piece
        The error of a piece is the greatest that its last checks have shown. It exceeds the tolerance only where the
        function jumps or nearly does: such a piece is narrower than a thousandth.

    Raises
    ------
    NumericalError
        When too many evaluations would be needed.
    """
    known: dict[float, float] = {}

    def value(x: float) -> float:
        if x not in known:
            if len(known) >= _BUDGET:
                raise NumericalError(
                    f"{_BUDGET} simulations do not make it smooth enough (allow a greater error, or narrow the range)"
                )
            known[x] = function(x)
        return known[x]

    demanded = _MORE_CHECKS if tolerance < _TIGHT else _CHECKS
    edges = [*(begin + (end - begin) * share for share in _JOINTS[:-1]), end]
    left = list(pairwise(edges))[::-1]
    done: list[Piece] = []
    while left:
        low, high = left.pop()
        spare = [x for x in known if low < x < high]
        piece = _piece(value, low, high, spare, _SHARE * tolerance, demanded)
        if piece is not None:
            done.append(piece)
        else:
            middle = (low + high) / 2
            left += [(middle, high), (low, middle)]
    return tuple(done)


def _piece(
    value: Callable[[float], float], begin: float, end: float, spare: list[float], allowed: float, demanded: int
) -> Piece | None:
    """The polynomial whose last checks are within ``allowed``, or None where the piece must be halved."""
    nodes, heights, checks = [begin, end], [value(begin), value(end)], [np.inf]
    piece = _through(nodes, heights)
    narrow = end - begin < _NARROWEST
    while True:
        new = _next(nodes, spare)
        nodes.append(new)
        heights.append(value(new))
        checks.append(abs(float(piece.polynomial(new)) - heights[-1]))
        piece = _through(nodes, heights)
        worst = max(checks[-demanded:])
        hopeless = len(nodes) >= _MOST or (len(nodes) >= _PATIENT and max(checks[-2:]) > _FAR * allowed)
        if len(nodes) >= _LEAST and (worst <= allowed or (narrow and hopeless)):
            unused = np.array([value(x) for x in spare])
            off = float(np.abs(piece.polynomial(np.array(spare)) - unused).max(initial=0.0))
            # these are many, and the last checks few
            if narrow or off <= 2 * allowed:
                return evolve(piece, error=max(worst, off / 2))
        if hopeless:
            return None


def _through(nodes: Sequence[float], heights: Sequence[float]) -> Piece:
    """The polynomial through these points, of which the first two are the ends."""
    coefficients = np.linalg.solve(chebyshev.chebvander(_shares(nodes), len(nodes) - 1), heights)
    return Piece(nodes[0], nodes[1], tuple(coefficients.tolist()), np.inf)


def _shares(nodes: Sequence[float]) -> FloatArray:
    """Where the nodes lie between the first two, -1 to 1."""
    begin, end = nodes[:2]
    shares = (2 * np.array(nodes) - begin - end) / (end - begin)
    # exactly, as rounding would decide between two places that are equally far
    shares[:2] = -1.0, 1.0
    return shares


def _next(nodes: Sequence[float], spare: list[float]) -> float:
    """The next node; one of ``spare``, which it then leaves, if that is about as good."""
    begin, end = nodes[:2]
    shares = _shares(nodes)

    def remoteness(at: FloatArray) -> FloatArray:
        # twice the distances, for their product neither vanishes nor overflows on an interval of length 2
        return np.asarray(np.abs(2 * (at[:, None] - shares)).prod(axis=1))

    fine = remoteness(_FINE)
    best = int(fine.argmax())
    if spare:
        known = remoteness((2 * np.array(spare) - begin - end) / (end - begin))
        index = int(known.argmax())
        if known[index] >= _NEAR * fine[best]:
            return spare.pop(index)
    return float(begin + (1 + _FINE[best]) / 2 * (end - begin))
