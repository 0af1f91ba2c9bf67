"""QAGS of QUADPACK from SciPy (Piessens et al. 1983), with smoothed ends."""

from __future__ import annotations

import itertools
import math

import numpy as np
import scipy.integrate

from shockwave.profiles.quadrature.base import EPSILON, ROUNDINGS, Integral, Integrand, Quadrature

# Largest number of intervals of a piece.
_INTERVALS = 200
# Point that divides the second run; not a binary fraction, so that both runs have no interval in common.
_CUT = (3 - math.sqrt(5)) / 2


class Quadpack(Quadrature):
    """QAGS of QUADPACK: Gauss-Kronrod 10-21 with bisection of the interval with the largest error.

    The integration variable is x, with s = lower + (upper - lower) (10 x^3 - 15 x^4 + 6 x^5), computed from the nearer
    end. At both ends ds/dx vanishes as the square of the distance, which removes unbounded derivatives.

    The result is the sum over the intervals, not the extrapolation of QAGS. With smoothed ends the sum is as accurate,
    and its error is known for each interval, whatever made QAGS stop. Neither rule detects a jump between the end of an
    interval and the first node. If more than one interval was needed, a second run with other intervals is made, and
    the difference is part of the error estimate.

    References
    ----------
    Piessens, R., de Doncker-Kapenga, E., Ueberhuber, C. W., & Kahaner, D. K. (1983). QUADPACK: a Subroutine
    Package for Automatic Integration. Springer.
    """

    name = "quadpack"

    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        width = upper - lower
        seen: list[tuple[float, float]] = []

        def smooth(x: float) -> float:
            near = min(x, 1.0 - x)
            distance = width * near**3 * (10 - 15 * near + 6 * near**2)
            s = lower + distance if x < 0.5 else upper - distance
            seen.append((s, float(integrand(np.array([s]))[0])))
            return seen[-1][1] * width * 30 * (near * (1 - near)) ** 2

        def integrate_between(*edges: float) -> tuple[float, float, int]:
            """Sum of the final intervals of QAGS, sum of their errors, and number of intervals."""
            intervals, target = [], max(tolerance * min(1.0, width), float(np.finfo(float).tiny))
            for begin, end in itertools.pairwise(edges):
                # full_output suppresses the warnings of SciPy, which are contained in the errors.
                details = scipy.integrate.quad(
                    smooth, begin, end, epsabs=target, epsrel=0.0, limit=_INTERVALS, full_output=1
                )[2]
                intervals += list(zip(details["rlist"], details["elist"], strict=True))[: int(details["last"])]
            values, errors = zip(*intervals, strict=True)
            return math.fsum(values), math.fsum(errors), len(intervals)

        value, error, count = integrate_between(0.0, 1.0)
        if count > 1:
            other = integrate_between(0.0, _CUT, 1.0)
            difference = abs(other[0] - value)
            # The run with the larger error may have detected what the other has missed.
            value, error, _ = max((value, error, count), other, key=lambda run: run[1])
            error += 2 * difference
        # Rounding error of the nodes and of their distances from the ends, which the integrand may use.
        variation = math.fsum(abs(b[1] - a[1]) for a, b in itertools.pairwise(sorted(seen)))
        rounding = ROUNDINGS * EPSILON * abs(value) + EPSILON * max(abs(lower), abs(upper)) * variation
        return Integral(value, error + rounding, len(seen), self.name)
