"""The exponential profile: exponential rise and decay of finite duration."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from attrs import frozen

from shockwave.fields import quantity
from shockwave.numerics import elementwise
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.boundary_layers import edges
from shockwave.quadrature import FloatArray

# Argument below which the Taylor series is used, because the closed form suffers from cancellation.
_SMALL = 2.0
# Terms of that series: the remainder at _SMALL is below the rounding error.
_TERMS = 30
# Values kept for the ends of rise and decay, at which each profile is evaluated again and again.
_MOST_KEPT = 256


@frozen(kw_only=True)
class Exponential(ShockProfile):
    """F1 = (1 - e^(-k1 s))/(1 - e^(-k1)), F2 = (e^(-k2 u) - e^(-k2))/(1 - e^(-k2)), u = (s - 1)/(n - 1).

    Parameters
    ----------
    rise_rate, decay_rate : float
        Rates k1 and k2, at least -700 and at most 1e6; with both 0 the profile is a triangle.
    duration_ratio : float
        n, total duration over rise time, above 1.
    """

    rise_rate: float = quantity("", "k1, rate of the rise", at_least=-700, at_most=1e6)
    decay_rate: float = quantity("", "k2, rate of the decay", at_least=-700, at_most=1e6)
    duration_ratio: float = quantity("", "n, total duration over rise time", above=1, at_most=1e12)

    def rise(self, s: FloatArray) -> FloatArray:
        return _ramp(self.rise_rate, s, 0)

    def decay(self, s: FloatArray) -> FloatArray:
        # Reversed in time, the decay is a rise with the opposite rate; this avoids cancellation near n.
        return _ramp(-self.decay_rate, 1.0 - self._share(s), 0)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        n = self.duration_ratio
        return (0.0, *edges(0.0, 1.0, self.rise_rate, n), 1.0, *edges(1.0, n, self.decay_rate, n), n)

    def closed_areas(self) -> tuple[float, float]:
        one = np.ones(())
        fading = float(_ramp(-self.decay_rate, one, 1))
        return float(_ramp(self.rise_rate, one, 1)), (self.duration_ratio - 1) * fading

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        remaining = (self.duration_ratio - 1) * _ramp(-self.decay_rate, 1.0 - self._share(s), 1)
        # Exactly zero during the rise: the rounding error of a difference would exceed the small impulse at first.
        decayed = np.where(s > 1, self.closed_areas()[1] - remaining, 0.0)
        return np.asarray(_ramp(self.rise_rate, np.minimum(s, 1.0), 1) + decayed)

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        rising = _ramp(self.rise_rate, np.minimum(s, 1.0), 2)
        whole = float(_ramp(-self.decay_rate, np.ones(()), 2))
        passed = whole - _ramp(-self.decay_rate, 1.0 - self._share(s), 2)
        decaying = sum(self.closed_areas()) * (s - 1.0) - (self.duration_ratio - 1) ** 2 * passed
        return np.asarray(rising + np.where(s > 1, decaying, 0.0))

    def closed_at(self, s: float) -> tuple[float, float]:
        if s <= 1:
            return _ramp_at(self.rise_rate, s)
        left = _ramp_at(-self.decay_rate, 1 - (s - 1) / (self.duration_ratio - 1))
        whole = _ramp_at(-self.decay_rate, 1.0)[0]
        return _ramp_at(self.rise_rate, 1.0)[0] + (self.duration_ratio - 1) * (whole - left[0]), left[1]

    def _share(self, s: FloatArray) -> FloatArray:
        """Elapsed fraction of the decay, 0 before the peak."""
        return np.asarray(np.clip((s - 1.0) / (self.duration_ratio - 1), 0.0, 1.0))


def _ramp(rate: float, s: FloatArray, integrals: int) -> FloatArray:
    """expm1(-k s)/expm1(-k) on [0, 1] with k = ``rate``, integrated 0, 1 or 2 times from 0 to s."""
    power = math.prod([s] * (1 + integrals))
    shape = power * _phi(rate * s, integrals) / _phi(np.asarray(rate), 0)
    return np.asarray(shape if rate >= 0 else shape * elementwise(math.exp, rate * (1 - s)))


@lru_cache(maxsize=_MOST_KEPT)
def _ramp_at(rate: float, s: float) -> tuple[float, float]:
    """`_ramp` at one s, integrated once and not at all."""
    x, size = rate * s, abs(rate * s)
    scale = s * math.exp(min(rate - x, 0.0)) / (-math.expm1(-abs(rate)) / abs(rate) if rate else 1.0)
    force = -math.expm1(-size) / size if size else 1.0
    if size >= _SMALL:
        return scale * s * (math.exp(min(x, 0.0)) - force) / x, scale * force
    series = 0.0
    for j in reversed(range(_TERMS)):
        series = (1.0 - x * series) / (j + 2)
    return scale * s * series * math.exp(min(x, 0.0)), scale * force


def _phi(x: FloatArray, order: int) -> FloatArray:
    """Sum of (-x)^j / (j + 1 + order)! over j >= 0, multiplied by e^x for negative x to prevent overflow."""
    if order == 0:  # no cancellation
        size = np.where(x == 0, 1.0, np.abs(x))
        return np.asarray(np.where(x == 0, 1.0, -elementwise(math.expm1, -size) / size))
    small = np.abs(x) < _SMALL
    fading = elementwise(math.exp, np.minimum(x, 0.0))
    near = np.where(small, x, 0.0)
    series = np.zeros_like(near)
    for j in reversed(range(_TERMS)):
        series = (1.0 - near * series) / (j + 1 + order)
    far = np.where(small, _SMALL, x)
    closed = -elementwise(math.expm1, -np.abs(far)) / np.abs(far)
    for j in range(1, order + 1):
        closed = (fading / math.factorial(j) - closed) / far
    return np.where(small, series * fading / math.factorial(order), closed)
