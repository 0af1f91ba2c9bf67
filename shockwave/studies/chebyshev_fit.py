"""Adaptive fit of piecewise Chebyshev polynomials to a function that is expensive to evaluate.

The nodes of each piece are Leja points: each new node maximises the product of the distances to the previous nodes. So
the polynomial through the previous nodes is checked where it is least certain, and every evaluation is used (Reichel,
"Newton interpolation at Leja points", BIT 30, 1990). A piece whose checks do not converge is halved, and the halves
reuse its evaluations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np
from attrs import frozen
from numpy.polynomial import Chebyshev, chebyshev

from shockwave.errors import NumericalError
from shockwave.progress import progressed
from shockwave.quadrature import FloatArray

# Imaginary parts of roots below this fraction of the width of the piece are rounding errors.
_REAL = 5e-8
# Factor of the slope error over error * degree / width of the polynomial; at most 3.6 was measured, on four shapes at
# rtol 1e-3 to 1e-5.
_SLOPE_SAFETY = 4.0
# Edges of the first pieces, as fractions of the range. A shock that ends abruptly causes ripples with one period in
# time; as a function of the logarithm of time they are densest at the end.
_EDGES = (0.0, 0.4, 0.7, 1.0)
# Smallest number of nodes of a polynomial.
_FEWEST_NODES = 7
# Number of nodes from which a piece is halved if its last checks exceed the allowed error by the factor below.
_NODES_BEFORE_HALVING = 18
_FAR = 5.0
# Greatest number of nodes of a polynomial.
_MOST_NODES = 24
# Number of consecutive checks that must be within the allowed error.
_CHECKS = 3
# The same for tolerances below `_TIGHT`, where weak kinks are significant, such as where a contact opens: there
# polynomials converge slowly.
_MORE_CHECKS = 6
_TIGHT = 5e-5
# Allowed error of the checks, over the tolerance.
_ALLOWED = 0.32
# A known evaluation becomes the next node if its product of distances is at least this fraction of the maximum.
_NEAR_MAXIMUM = 0.5
# Candidates for the next node, on [-1, 1].
_CANDIDATES = np.cos(np.linspace(np.pi, 0.0, 401))
# Width to which pieces with a kink or a jump are halved; the error of such a piece includes the jump.
_NARROWEST = 1e-3
# Greatest number of evaluations; the roughest of 95 curves to 1e-6 took 203.
_BUDGET = 1000
# Name of the work whose progress is reported.
_WORK = "simulations of the fit"


@frozen
class Piece:
    """A polynomial on [begin, end].

    Attributes
    ----------
    begin, end : float
        Interval of the piece.
    coefficients : tuple of float
        Coefficients of the Chebyshev polynomials of u = (2 x - begin - end)/(end - begin), lowest degree first.
    error : float
        Bound on the difference from the function, from the checks.
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
        return _SLOPE_SAFETY * self.error * (len(self.coefficients) - 1) / (self.end - self.begin)

    def turns(self, slope: float) -> list[float]:
        """Extrema of the polynomial plus ``slope`` x inside the interval, ascending."""
        roots = (self.polynomial.deriv() + slope).trim().roots()
        inside = (self.begin < roots.real) & (roots.real < self.end)
        real = np.abs(roots.imag) < _REAL * (self.end - self.begin)
        return sorted(roots.real[inside & real].tolist())


def evaluated(pieces: Sequence[Piece], x: FloatArray) -> FloatArray:
    """Values of adjoining pieces at ``x``, an array of any shape within their range."""
    where = np.searchsorted([piece.end for piece in pieces[:-1]], x)
    return np.piecewise(x, [where == k for k in range(len(pieces))], [piece.polynomial for piece in pieces])


def fitted(function: Callable[[float], float], begin: float, end: float, tolerance: float) -> tuple[Piece, ...]:
    """Fit adjoining pieces to ``function`` on [begin, end], refined until the checks agree to ``tolerance``.

    Parameters
    ----------
    function : callable
        Function of one number; it is evaluated once at each x.
    begin, end : float
        The interval, with ``begin < end``.
    tolerance : float
        Allowed absolute error, above 0.

    Returns
    -------
    tuple of Piece
        The error of a piece is the greatest error of its last checks. It exceeds the tolerance only at a jump or near
        jump of the function; such a piece is narrower than 1e-3.

    Raises
    ------
    NumericalError
        If more than 1000 evaluations are required.
    """
    known: dict[float, float] = {}

    def value(x: float) -> float:
        if x not in known:
            if len(known) >= _BUDGET:
                remedy = "increase rtol or narrow the interval"
                raise NumericalError(f"the fit does not converge within {_BUDGET} simulations ({remedy})")
            progressed(_WORK, len(known))
            known[x] = function(x)
        return known[x]

    checks = _MORE_CHECKS if tolerance < _TIGHT else _CHECKS
    edges = [*(begin + (end - begin) * fraction for fraction in _EDGES[:-1]), end]
    left = list(pairwise(edges))[::-1]
    done: list[Piece] = []
    while left:
        low, high = left.pop()
        inside = [x for x in known if low < x < high]
        piece = _piece(value, low, high, inside, _ALLOWED * tolerance, checks)
        if piece is not None:
            done.append(piece)
        else:
            middle = (low + high) / 2
            left += [(middle, high), (low, middle)]
    progressed(_WORK, len(known), len(known))
    return tuple(done)


def _piece(
    value: Callable[[float], float], begin: float, end: float, known: list[float], allowed: float, checks: int
) -> Piece | None:
    """Fit a polynomial whose last ``checks`` are within ``allowed``; None if the piece must be halved.

    ``known`` are places where the function has been evaluated before; those that become nodes are removed from it.
    """
    nodes = [begin, end]
    heights = [value(begin), value(end)]
    errors = [np.inf]
    narrow = end - begin < _NARROWEST
    while True:
        matrix = chebyshev.chebvander(_places(nodes), len(nodes) - 1)
        polynomial = Chebyshev(np.linalg.solve(matrix, heights), domain=(begin, end))
        worst = max(errors[-checks:])
        slow = len(nodes) >= _NODES_BEFORE_HALVING and max(errors[-2:]) > _FAR * allowed
        hopeless = slow or len(nodes) >= _MOST_NODES
        if len(nodes) >= _FEWEST_NODES and (worst <= allowed or (narrow and hopeless)):
            unused = np.array([value(x) for x in known])
            unused_error = float(np.abs(polynomial(np.array(known)) - unused).max(initial=0.0))
            # twice the limit: these points are more numerous than the last checks
            if narrow or unused_error <= 2 * allowed:
                return Piece(begin, end, tuple(polynomial.coef.tolist()), max(worst, unused_error / 2))
        if hopeless:
            return None
        nodes.append(_next(nodes, known))
        heights.append(value(nodes[-1]))
        errors.append(abs(float(polynomial(nodes[-1])) - heights[-1]))


def _places(nodes: Sequence[float]) -> FloatArray:
    """Positions of the nodes on [-1, 1], where the first two nodes are the ends."""
    begin, end = nodes[:2]
    places = (2 * np.array(nodes) - begin - end) / (end - begin)
    # exact values: otherwise rounding would decide between two equally distant candidates
    places[:2] = -1.0, 1.0
    return places


def _next(nodes: Sequence[float], known: list[float]) -> float:
    """The next node; a point of ``known`` if its product of distances is near the maximum, which is removed from it."""
    begin, end = nodes[:2]
    places = _places(nodes)

    def products(at: FloatArray) -> FloatArray:
        # twice the distances: on an interval of length 2 their product neither underflows nor overflows
        return np.asarray(np.abs(2 * (at[:, None] - places)).prod(axis=1))

    new = products(_CANDIDATES)
    best = int(new.argmax())
    if known:
        old = products((2 * np.array(known) - begin - end) / (end - begin))
        index = int(old.argmax())
        if old[index] >= _NEAR_MAXIMUM * new[best]:
            return known.pop(index)
    return float(begin + (1 + _CANDIDATES[best]) / 2 * (end - begin))
