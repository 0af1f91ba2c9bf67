"""Base class of quadratures: definite integrals with an error estimate and a count of evaluations."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from attrs import frozen

FloatArray: TypeAlias = npt.NDArray[np.float64]
Integrand: TypeAlias = Callable[[FloatArray], FloatArray]

EPSILON = float(np.finfo(float).eps)
# Roundings of one value and of its product with a weight, in units of the machine epsilon.
ROUNDINGS = 4.0


@frozen
class Integral:
    """The value of a definite integral and how far to trust it.

    ``error`` is an estimate of the absolute error that is meant to bound it; ``evaluations`` counts
    the points at which the integrand was taken; ``method`` names the quadrature.
    """

    value: float
    error: float
    evaluations: int
    method: str


class Quadrature(abc.ABC):
    """Base class of quadratures; `integrate` is what callers use.

    Contract for implementers
    -------------------------
    1. ``name`` is the name under which the class is registered.
    2. ``_piece(integrand, lower, upper, tolerance)`` integrates over one interval with
       ``lower < upper``, inside which the integrand is smooth. At the two ends its derivatives may be
       unbounded; the integrand itself is bounded.
    3. The integrand is vectorised: it takes a one-dimensional array and returns one of equal shape.
       Abscissae outside ``(lower, upper)`` are moved inside.
    4. ``tolerance`` is the absolute error to aim at. The returned error estimate bounds the true
       error, rounding included, whether or not the tolerance was reached.
    5. The work is bounded: a piece ends after a fixed number of refinements and states what it has
       reached. It keeps no state between calls.
    """

    name: str

    def integrate(self, integrand: Integrand, points: Sequence[float], tolerance: float = 1e-14) -> Integral:
        """The integral over ``[points[0], points[-1]]``, taken piece by piece between the points.

        Parameters
        ----------
        integrand : callable
            Maps an array of abscissae, shape (k,), to values, shape (k,).
        points : sequence of float
            Ascending: the two limits and, between them, every kink or jump of the integrand.
        tolerance : float
            Absolute error to aim at, relative to an integrand of order one.

        Returns
        -------
        Integral
            An empty or reversed interval gives zero.
        """
        pieces = [
            self._piece(_inside(integrand, lower, upper), float(lower), float(upper), tolerance)
            for lower, upper in pairwise(points)
            if upper > lower
        ]
        return Integral(
            math.fsum(piece.value for piece in pieces),
            math.fsum(piece.error for piece in pieces),
            sum(piece.evaluations for piece in pieces),
            self.name,
        )

    @abc.abstractmethod
    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        """The integral over one smooth piece; see the contract."""


def _inside(integrand: Integrand, lower: float, upper: float) -> Integrand:
    # At the very ends the integrand may jump: 0**eta is 0, however small eta.
    first, last = math.nextafter(lower, upper), math.nextafter(upper, lower)
    return lambda s: np.asarray(integrand(np.clip(s, first, last)), dtype=float)
