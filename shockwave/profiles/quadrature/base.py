"""Base class of quadratures: definite integrals with an error estimate and the number of evaluations."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray

Integrand: TypeAlias = Callable[[FloatArray], FloatArray]

EPSILON = float(np.finfo(float).eps)
# Rounding error of a value and of its product with a weight, in units of the machine epsilon.
ROUNDINGS = 4.0


@frozen
class Integral:
    """Value and absolute error of a definite integral.

    ``error`` is an estimate that is intended as a bound; ``evaluations`` is the number of points at which the integrand
    was evaluated, and ``method`` the name of the quadrature.
    """

    value: float
    error: float
    evaluations: int
    method: str


class Quadrature(abc.ABC):
    """Base class of quadratures; callers use `integrate`.

    Contract for implementers
    -------------------------
    1. ``name`` is the registered name of the class.
    2. ``_piece(integrand, lower, upper, tolerance)`` integrates over one interval with ``lower < upper``. The integrand
       is bounded, and smooth inside the interval; its derivatives may be unbounded at the ends.
    3. The integrand is vectorised: it takes a one-dimensional array and returns an array of the same shape. Abscissae
       outside ``(lower, upper)`` are moved inside.
    4. ``tolerance`` is the requested absolute error. The returned error estimate bounds the true error, including
       rounding, even if the tolerance was not reached.
    5. The work is bounded: a piece ends after a fixed number of refinements and returns the error that was reached. It
       has no state between calls.
    """

    name: str

    def integrate(self, integrand: Integrand, points: Sequence[float], tolerance: float = 1e-14) -> Integral:
        """Integrate over ``[points[0], points[-1]]``, piece by piece between the points.

        Parameters
        ----------
        integrand : callable
            Maps an array of abscissae, shape (k,), to values, shape (k,).
        points : sequence of float
            The two limits and, between them, all kinks and jumps of the integrand, in ascending order.
        tolerance : float
            Requested absolute error, for an integrand of order one.

        Returns
        -------
        Integral
            Zero for an empty or reversed interval.
        """
        pieces = [
            self._piece(_keep_inside(integrand, lower, upper), float(lower), float(upper), tolerance)
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
        """Integrate over one smooth piece; see the contract."""


def _keep_inside(integrand: Integrand, lower: float, upper: float) -> Integrand:
    # The integrand may jump at the ends: 0**eta is 0 for any eta > 0.
    first, last = math.nextafter(lower, upper), math.nextafter(upper, lower)
    return lambda s: np.asarray(integrand(np.clip(s, first, last)), dtype=float)
