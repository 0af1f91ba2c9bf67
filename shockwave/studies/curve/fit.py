"""Adaptive fit of a piecewise Chebyshev series to a function that is dear to evaluate.

On every piece the nodes are Leja's: the next is where the product of the distances to all before is greatest, so the
polynomial through those before is checked there where it is least known, and no evaluation is lost (Reichel, "Newton
interpolation at Leja points", BIT 30, 1990). A piece whose checks do not get better is halved, and its halves
use what was evaluated before.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from attrs import define, evolve, field
from numpy.polynomial import chebyshev

from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray
from shockwave.studies.curve.series import Piece, Series

__all__ = ["fitted"]

# Where the first pieces join, over the range. A shock that ends abruptly gives ripples of one period in time: in its
# logarithm they crowd together at the end.
_JOINTS = (0.0, 0.4, 0.7, 1.0)
# The fewest nodes of a polynomial, those after which one that is far off is given up, and the most.
_LEAST, _PATIENT, _MOST = 7, 18, 24
# So many checks in a row must be within this share of the tolerance; further off than so many times that is far. Below
# the tight tolerance weak kinks show, as where a contact opens: polynomials get better slowly, and more checks are due.
_CHECKS, _SHARE, _FAR = 3, 0.32, 5.0
_MORE_CHECKS, _TIGHT = 6, 5e-5
# A value from before is as good as a new one where the product of distances is this share of the greatest.
_NEAR = 0.5
_FINE = np.cos(np.linspace(np.pi, 0.0, 401))
# A kink or a jump is shut in so narrowly, and told by the error of its piece.
_NARROWEST = 1e-3
# What takes more evaluations is too rough for polynomials; the roughest of 95 curves to 1e-6 took 203.
_BUDGET = 1000


@define
class _Values:
    """The function, with what was evaluated kept."""

    function: Callable[[float], float]
    known: dict[float, float] = field(factory=dict)

    def __call__(self, x: float) -> float:
        if x not in self.known:
            if len(self.known) >= _BUDGET:
                raise NumericalError(
                    f"{_BUDGET} simulations do not make it smooth enough (allow a greater error, or narrow the range)"
                )
            self.known[x] = self.function(x)
        return self.known[x]


def fitted(function: Callable[[float], float], begin: float, end: float, tolerance: float) -> Series:
    """The series of ``function`` on [begin, end], refined until checks agree to ``tolerance``.

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
    Series
        The error of a piece is the greatest that its last checks have shown. It is above the tolerance only where the
        function jumps or is as good as that: such a piece is narrower than a thousandth.

    Raises
    ------
    NumericalError
        When too many evaluations would be needed.
    """
    values = _Values(function)
    edges = [*(begin + (end - begin) * share for share in _JOINTS[:-1]), end]
    left = list(pairwise(edges))[::-1]
    done: list[Piece] = []
    while left:
        low, high = left.pop()
        piece = _piece(values, low, high, _SHARE * tolerance, _MORE_CHECKS if tolerance < _TIGHT else _CHECKS)
        if piece is not None:
            done.append(piece)
        else:
            middle = (low + high) / 2
            left += [(middle, high), (low, middle)]
    return Series(tuple(done))


def _piece(values: _Values, begin: float, end: float, allowed: float, demanded: int) -> Piece | None:
    """The polynomial between ``begin`` and ``end`` that the last checks demanded allow, or None to halve the piece."""
    spare = [x for x in values.known if begin < x < end]
    nodes, checks = [begin, end], [np.inf]
    shares, heights = np.array([-1.0, 1.0]), np.array([values(begin), values(end)])
    narrow = end - begin < _NARROWEST
    while True:
        new = _next(shares, spare, begin, end)
        share = np.array((2 * new - begin - end) / (end - begin))
        height = values(new)
        checks.append(abs(float(chebyshev.chebval(share, _through(shares, heights))) - height))
        nodes.append(new)
        shares, heights = np.append(shares, share), np.append(heights, height)
        worst = max(checks[-demanded:])
        hopeless = len(nodes) >= _MOST or (len(nodes) >= _PATIENT and max(checks[-2:]) > _FAR * allowed)
        if len(nodes) >= _LEAST and (worst <= allowed or (narrow and hopeless)):
            coefficients = _through(shares, heights)
            piece = Piece(begin, end, tuple(coefficients.tolist()), worst)
            unused = np.array(spare)
            off = np.abs(piece(unused) - [values(x) for x in spare]).max(initial=0.0)
            # these are many, and the last checks few
            if narrow or off <= 2 * allowed:
                return evolve(piece, error=max(worst, float(off) / 2))
        if hopeless:
            return None


def _through(shares: FloatArray, heights: FloatArray) -> FloatArray:
    """Coefficients of the polynomial through these points."""
    return np.asarray(np.linalg.solve(chebyshev.chebvander(shares, len(shares) - 1), heights), dtype=float)


def _next(shares: FloatArray, spare: list[float], begin: float, end: float) -> float:
    """The next node; one of ``spare``, which it then leaves, if that is about as good."""

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
