"""Tanh-sinh quadrature, a double exponential rule (Takahasi & Mori 1974)."""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt

from shockwave.base.numerics import FloatArray
from shockwave.profiles.quadrature.base import EPSILON, ROUNDINGS, Integral, Integrand, Quadrature

# Distance of the outermost nodes from the ends, in units of the piece; the rest is smaller than rounding errors.
_OUTERMOST = 1e-22
# First step in t.
_COARSEST_STEP = 0.5
# Largest number of times that the step is halved; about 7000 points.
_HALVINGS = 9
# Number of last changes whose maximum is the error estimate if the sum has not converged.
_CHANGES = 5


@functools.cache
def _level(halvings: int) -> tuple[FloatArray, npt.NDArray[np.bool_], FloatArray]:
    """The nodes that are added when the step is halved, in ascending order.

    Returns their distances from the nearer end in units of the piece, whether that is the upper end, and their weights
    times the step.
    """
    step = _COARSEST_STEP / 2**halvings
    last = math.asinh(-math.log(_OUTERMOST) / math.pi)
    half = np.arange(step, last, step if halvings == 0 else 2 * step)
    t = np.concatenate((-half[::-1], [0.0] if halvings == 0 else [], half))
    # (1 + tanh(pi/2 sinh t))/2 as a distance from the nearer end, which avoids cancellation.
    small = np.exp(-math.pi * np.sinh(np.abs(t)))
    return small / (1 + small), t > 0, step * math.pi * np.cosh(t) * small / (1 + small) ** 2


class TanhSinh(Quadrature):
    """Trapezoidal rule in t with s = (1 + tanh(pi/2 sinh t))/2; the step is halved until the sum converges.

    The nodes cluster double exponentially at both ends, so that unbounded derivatives there are integrated accurately.
    Every halving doubles the number of correct digits, so two consecutive small changes bound the remaining error. If
    the sum does not converge, as with a jump inside, the error decreases only linearly with the step. The estimate is
    then the largest of the last changes, because a single one may vanish by chance. `scipy.integrate.tanhsinh`
    underestimates the error in this case.

    References
    ----------
    Takahasi, H., & Mori, M. (1974). Double exponential formulas for numerical integration. Publications of
    the Research Institute for Mathematical Sciences, 9, 721-741.
    """

    name = "tanh-sinh"

    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        width = upper - lower
        # Rounding error of the nodes and of their distances from the ends, which the integrand may use.
        spacing = EPSILON * max(abs(lower), abs(upper))
        value = magnitude = 0.0
        evaluations = 0
        changes: list[float] = []
        for halvings in range(_HALVINGS + 1):
            distances, mirrored, weights = _level(halvings)
            s = np.where(mirrored, upper - width * distances, lower + width * distances)
            values = integrand(s)
            added = width * float((weights * values).sum())
            changes.append(abs(added - value / 2))
            value = value / 2 + added
            magnitude = magnitude / 2 + width * float((weights * np.abs(values)).sum())
            evaluations += s.size
            rounding = ROUNDINGS * EPSILON * magnitude + spacing * float(np.abs(np.diff(values)).sum())
            if max(changes[-2:]) <= max(tolerance * min(1.0, width), rounding):
                return Integral(value, 2 * changes[-1] + rounding, evaluations, self.name)
        return Integral(value, 2 * max(changes[-_CHANGES:]) + rounding, evaluations, self.name)
