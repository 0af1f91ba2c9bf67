"""The tanh-sinh quadrature, a double exponential rule (Takahasi & Mori 1974)."""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt

from shockwave.quadrature.base import EPSILON, ROUNDINGS, FloatArray, Integral, Integrand, Quadrature

# The outermost nodes are this far from the ends, in units of the piece: what lies beyond is below rounding.
_OUTERMOST = 1e-22
_COARSEST_STEP = 0.5
# With 9 halvings a piece is seen at some 7000 points at most.
_HALVINGS = 9
# Where halving has not settled the sum, the largest of so many last changes is taken for the error.
_CHANGES = 5


@functools.cache
def _level(halvings: int) -> tuple[FloatArray, npt.NDArray[np.bool_], FloatArray]:
    """The nodes that one halving of the step adds, ascending.

    Distances from the nearer end, in units of the piece; which are from the upper end; weights, with the step.
    """
    step = _COARSEST_STEP / 2**halvings
    last = math.asinh(-math.log(_OUTERMOST) / math.pi)
    half = np.arange(step, last, step if halvings == 0 else 2 * step)
    t = np.concatenate((-half[::-1], [0.0] if halvings == 0 else [], half))
    # (1 + tanh(pi/2 sinh t))/2, written for the end that t points to: no difference of near-equal numbers.
    small = np.exp(-math.pi * np.sinh(np.abs(t)))
    return small / (1 + small), t > 0, step * math.pi * np.cosh(t) * small / (1 + small) ** 2


class TanhSinh(Quadrature):
    """Trapezoidal rule in t, s being (1 + tanh(pi/2 sinh t))/2 of a piece; steps halve till the sum settles.

    Nodes gather at both ends double exponentially, so that unbounded derivatives there do no harm. Every
    halving doubles the digits, so that a change is a safe estimate of the remaining error, if the one before agrees.
    Where the sum does not settle, as with a jump inside, the error falls with the step only: there the largest of the
    last changes is taken, as a single one may vanish by chance. `scipy.integrate.tanhsinh` estimates less than the
    error there.

    References
    ----------
    Takahasi, H., & Mori, M. (1974). Double exponential formulas for numerical integration. Publications of
    the Research Institute for Mathematical Sciences, 9, 721-741.
    """

    name = "tanh-sinh"

    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        width = upper - lower
        # Nodes, and their distances from the ends that the integrand may make use of, are off by the spacing.
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
