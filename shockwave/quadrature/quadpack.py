"""QAGS of QUADPACK through SciPy (Piessens et al. 1983), both ends smoothed."""

from __future__ import annotations

import itertools
import math

import numpy as np
import scipy.integrate

from shockwave.quadrature.base import EPSILON, ROUNDINGS, Integral, Integrand, Quadrature

# Intervals that QAGS may divide a piece into.
_INTERVALS = 200
# Where the second run is cut: at no binary fraction, so that it shares no interval with the first.
_CUT = (3 - math.sqrt(5)) / 2


class Quadpack(Quadrature):
    """QUADPACK's QAGS: Gauss-Kronrod 10-21 on intervals, the worst of which is halved time and again.

    The integral is taken over x, s = lower + (upper - lower) (10 x^3 - 15 x^4 + 6 x^5), counted from the nearer end:
    at both ends ds/dx vanishes as the square of the distance, and with it any unbounded derivative.

    The sum over the intervals is taken, not what QAGS extrapolates from it: with both ends smoothed it is
    as good, and its error is known interval by interval, whatever made QAGS stop. A jump between an end of
    an interval and the first node is not seen by either rule; where one interval did not do, a second run
    on other intervals shows it, and the difference is part of the estimate.

    References
    ----------
    Piessens, R., de Doncker-Kapenga, E., Ueberhuber, C. W., & Kahaner, D. K. (1983). QUADPACK: a Subroutine
    Package for Automatic Integration. Springer.
    """

    name = "quadpack"

    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        width = upper - lower
        seen: list[tuple[float, float]] = []

        def smoothed(x: float) -> float:
            near = min(x, 1.0 - x)
            distance = width * near**3 * (10 - 15 * near + 6 * near**2)
            s = lower + distance if x < 0.5 else upper - distance
            seen.append((s, float(integrand(np.array([s]))[0])))
            return seen[-1][1] * width * 30 * (near * (1 - near)) ** 2

        def integrated(*edges: float) -> tuple[float, float, int]:
            """Sum over the intervals that QAGS ends with, of their errors, and the number of intervals."""
            intervals, target = [], max(tolerance * min(1.0, width), float(np.finfo(float).tiny))
            for begin, end in itertools.pairwise(edges):
                # With full_output SciPy returns its complaints in place of warning; they add nothing to the errors.
                found = scipy.integrate.quad(
                    smoothed, begin, end, epsabs=target, epsrel=0.0, limit=_INTERVALS, full_output=1
                )[2]
                intervals += list(zip(found["rlist"], found["elist"], strict=True))[: int(found["last"])]
            values, errors = zip(*intervals, strict=True)
            return math.fsum(values), math.fsum(errors), len(intervals)

        value, error, count = integrated(0.0, 1.0)
        if count > 1:
            other = integrated(0.0, _CUT, 1.0)
            difference = abs(other[0] - value)
            # The run with the larger error is the one that may have seen what the other has not.
            value, error, _ = max((value, error, count), other, key=lambda run: run[1])
            error += 2 * difference
        # Nodes, and their distances from the ends that the integrand may make use of, are off by the spacing.
        variation = math.fsum(abs(b[1] - a[1]) for a, b in itertools.pairwise(sorted(seen)))
        rounding = ROUNDINGS * EPSILON * abs(value) + EPSILON * max(abs(lower), abs(upper)) * variation
        return Integral(value, error + rounding, len(seen), self.name)
