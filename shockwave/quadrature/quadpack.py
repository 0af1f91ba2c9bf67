"""QAGS of QUADPACK through SciPy (Piessens et al. 1983), both ends smoothed."""

from __future__ import annotations

import itertools
import math

import numpy as np
import scipy.integrate

from shockwave.quadrature.base import Integral, Integrand, Quadrature

__all__ = ["Quadpack"]

# Intervals that QAGS may divide a piece into.
_INTERVALS = 200
# Where the second run is cut: at no binary fraction, so that it shares no interval with the first.
_CUT = (3 - math.sqrt(5)) / 2
# Roundings of one value and of its product with a weight, in units of the machine epsilon.
_ROUNDINGS = 4.0

_EPSILON = float(np.finfo(float).eps)
# QAGS refuses a tolerance of zero.
_LEAST_TOLERANCE = float(np.finfo(float).tiny)


class _Smoothed:
    """The integrand times ds/dx on 0 <= x <= 1, one value at a time; it keeps what it has seen.

    s = lower + (upper - lower) (10 x^3 - 15 x^4 + 6 x^5), and so, counted from the other end, for 1 - x: at
    both ends ds/dx vanishes as the square of the distance, and with it any unbounded derivative.
    """

    def __init__(self, integrand: Integrand, lower: float, upper: float) -> None:
        self._integrand = integrand
        self._lower, self._upper = lower, upper
        self._first, self._last = math.nextafter(lower, upper), math.nextafter(upper, lower)
        self.seen: list[tuple[float, float]] = []

    def __call__(self, x: float) -> float:
        near = min(x, 1.0 - x)
        width = self._upper - self._lower
        distance = width * near**3 * (10 - 15 * near + 6 * near**2)
        s = self._lower + distance if x < 0.5 else self._upper - distance
        # At the very ends the integrand may jump: 0**eta is 0, however small eta.
        s = min(max(s, self._first), self._last)
        value = float(self._integrand(np.array([s]))[0])
        self.seen.append((s, value))
        return value * width * 30 * (near * (1 - near)) ** 2

    def variation(self) -> float:
        """Sum of the steps between the values seen, in the order of their points."""
        values = [value for _, value in sorted(self.seen)]
        return math.fsum(abs(b - a) for a, b in itertools.pairwise(values))


class Quadpack(Quadrature):
    """QUADPACK's QAGS: Gauss-Kronrod 10-21 on intervals, the worst of which is halved time and again.

    The sum over the intervals is taken, not what QAGS extrapolates from it: with both ends smoothed it is
    as good, and its error is known interval by interval, whatever made QAGS stop. A jump between an end of
    an interval and the first node is not seen by either rule; where one interval did not do, a second run
    on other intervals tells, and the difference is part of the estimate.

    References
    ----------
    Piessens, R., de Doncker-Kapenga, E., Ueberhuber, C. W., & Kahaner, D. K. (1983). QUADPACK: a Subroutine
    Package for Automatic Integration. Springer.
    """

    name = "quadpack"

    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        smoothed = _Smoothed(integrand, lower, upper)
        target = max(tolerance * min(1.0, upper - lower), _LEAST_TOLERANCE)
        value, error, intervals = _qags(smoothed, 0.0, 1.0, target)
        if intervals > 1:
            before, after = _qags(smoothed, 0.0, _CUT, target), _qags(smoothed, _CUT, 1.0, target)
            other = (before[0] + after[0], before[1] + after[1])
            difference = abs(other[0] - value)
            # The run with the larger error is the one that may have seen what the other has not.
            value, error = max((value, error), other, key=lambda run: run[1])
            error += 2 * difference
        # Nodes, and their distances from the ends that the integrand may make use of, are off by the spacing.
        spacing = _EPSILON * max(abs(lower), abs(upper))
        rounding = _ROUNDINGS * _EPSILON * abs(value) + spacing * smoothed.variation()
        return Integral(value, error + rounding, len(smoothed.seen), self.name)


def _qags(smoothed: _Smoothed, begin: float, end: float, target: float) -> tuple[float, float, int]:
    """Sum over the intervals that QAGS ends with, of their errors, and the number of intervals."""
    # With full_output SciPy returns its complaints in place of warning; they add nothing to the errors.
    output = scipy.integrate.quad(smoothed, begin, end, epsabs=target, epsrel=0.0, limit=_INTERVALS, full_output=1)
    details = output[2]
    intervals = int(details["last"])
    return math.fsum(details["rlist"][:intervals]), math.fsum(details["elist"][:intervals]), intervals
