"""The tanh-sinh quadrature, a double exponential rule (Takahasi & Mori 1974)."""

from __future__ import annotations

import functools
import math

import numpy as np
from attrs import frozen

from shockwave.quadrature.base import FloatArray, Integral, Integrand, Quadrature

__all__ = ["TanhSinh"]

# The outermost nodes are this far from the ends, in units of the piece: what lies beyond is below rounding.
_OUTERMOST = 1e-22
_COARSEST_STEP = 0.5
# With 9 halvings a piece is seen at some 7000 points at most.
_HALVINGS = 9
# Two sums may agree by chance, though not if the change falls by this much at once; nor if the one before has
# fallen by that much already, a sign of digits that double. Else the next sum must agree as well.
_PLUNGE = 1e-8
_DOUBLING = 1e-3
# Roundings of one value and of its product with a weight, in units of the machine epsilon.
_ROUNDINGS = 4.0
# Where halving has not settled the sum, the largest of so many last changes is taken for the error.
_CHANGES = 5

_EPSILON = float(np.finfo(float).eps)


@frozen
class _Level:
    """The nodes that one halving of the step adds.

    ``distances`` are from the nearer end, in units of the piece; ``mirrored`` tells which are from the upper
    end; ``weights`` include the step. The nodes ascend.
    """

    distances: FloatArray
    mirrored: FloatArray
    weights: FloatArray


@functools.cache
def _level(halvings: int) -> _Level:
    step = _COARSEST_STEP / 2**halvings
    last = math.asinh(-math.log(_OUTERMOST) / math.pi)
    if halvings == 0:
        t = step * np.arange(-math.floor(last / step), math.floor(last / step) + 1)
    else:
        half = np.arange(step, last, 2 * step)
        t = np.concatenate((-half[::-1], half))
    # (1 + tanh(pi/2 sinh t))/2, written for the end that t points to: no difference of near-equal numbers.
    small = np.exp(-math.pi * np.sinh(np.abs(t)))
    weights = step * math.pi * np.cosh(t) * small / (1 + small) ** 2
    return _Level(small / (1 + small), t > 0, weights)


@frozen
class _Sum:
    """What one level adds: the sum of weights times values, that of their magnitudes, the variation."""

    value: float
    magnitude: float
    variation: float
    points: int


class TanhSinh(Quadrature):
    """Trapezoidal rule in t, s being (1 + tanh(pi/2 sinh t))/2 of a piece; steps halve till the sum settles.

    Nodes gather at both ends double exponentially, so that unbounded derivatives there do no harm. Every
    halving doubles the digits, so that a change is a safe estimate of what is left of the error. Where the
    sum does not settle, as with a jump inside, the error falls with the step only: there the largest of the
    last changes is taken, as a single one may vanish by chance.

    References
    ----------
    Takahasi, H., & Mori, M. (1974). Double exponential formulas for numerical integration. Publications of
    the Research Institute for Mathematical Sciences, 9, 721-741.
    """

    name = "tanh-sinh"

    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        target = tolerance * min(1.0, upper - lower)
        # Nodes, and their distances from the ends that the integrand may make use of, are off by the spacing.
        spacing = _EPSILON * max(abs(lower), abs(upper))
        added = _add(integrand, lower, upper, 0)
        value, magnitude, evaluations = added.value, added.magnitude, added.points
        changes = [magnitude]
        for halvings in range(1, _HALVINGS + 1):
            added = _add(integrand, lower, upper, halvings)
            changes.append(abs(added.value - value / 2))
            value, magnitude = value / 2 + added.value, magnitude / 2 + added.magnitude
            evaluations += added.points
            rounding = _ROUNDINGS * _EPSILON * magnitude + spacing * added.variation
            unsettled = _unsettled(changes, target, rounding)
            if unsettled == 0:
                break
        return Integral(value, 2 * max(changes[-1], unsettled) + rounding, evaluations, self.name)


def _unsettled(changes: list[float], target: float, rounding: float) -> float:
    """Error to expect from sums with these changes: 0 where they have settled."""
    small = max(target, rounding)
    # A change within the rounding may well be 0: how far it fell is not known better than that.
    plunging = max(changes[-1], rounding) <= _PLUNGE * changes[-2]
    doubling = len(changes) > 2 and changes[-2] <= _DOUBLING * changes[-3]
    if changes[-1] <= small and (plunging or doubling or changes[-2] <= small):
        return 0.0
    return max(changes[-_CHANGES:])


def _add(integrand: Integrand, lower: float, upper: float, halvings: int) -> _Sum:
    level = _level(halvings)
    width = upper - lower
    distances = width * level.distances
    s = np.where(level.mirrored, upper - distances, lower + distances)
    # At the very ends the integrand may jump: 0**eta is 0, however small eta.
    s = np.minimum(np.maximum(s, math.nextafter(lower, upper)), math.nextafter(upper, lower))
    values = np.asarray(integrand(s), dtype=float)
    weighted = level.weights * values
    value, magnitude = (width * float(part.sum()) for part in (weighted, np.abs(weighted)))
    return _Sum(value, magnitude, float(np.abs(np.diff(values)).sum()), s.size)
