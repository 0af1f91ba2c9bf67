"""The exponential profile: exponential rise and decay of finite duration."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray, elementwise
from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.profiles.steep_edges import find_edges

# Argument below which the Taylor series is used, because the closed form suffers from cancellation.
_SMALL = 2.0
# Terms of that series: the remainder at _SMALL is below the rounding error.
_TERMS = 24
# Rate below which the force is linear: its exponentials could underflow.
_SMALLEST = 1e-200
# Values kept for the ends of rise and decay, at which each profile is evaluated again and again.
_MOST_KEPT = 256


@frozen(kw_only=True)
class Exponential(ShockProfile, Value):
    r"""Exponential rise and decay of finite duration.

    .. math:: F_1 = (1 - e^{-k_1 s})/(1 - e^{-k_1}), \quad F_2 = (e^{-k_2 u} - e^{-k_2})/(1 - e^{-k_2})

    with u = (s - 1)/(n - 1).

    Parameters
    ----------
    rise_rate : float
        Rate k1 of the rise, -700 to 1e6; with 0 the rise is linear.
    decay_rate : float
        Rate k2 of the decay, -700 to 1e6; with 0 the decay is linear.
    duration_ratio : float
        n, total duration over rise time, above 1.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.Exponential(rise_rate=2, decay_rate=3, duration_ratio=5)
    >>> profile.force([0.5, 1.0, 1.5]).round(3).tolist()
    [0.731, 1.0, 0.671]
    """

    rise_rate: SI[float] = quantity("", "k1, rate of the rise", at_least=-700, at_most=1e6)
    decay_rate: SI[float] = quantity("", "k2, rate of the decay", at_least=-700, at_most=1e6)
    duration_ratio: SI[float] = quantity("", "n, total duration over rise time", above=1, at_most=1e12, example="4")

    def rise(self, s: FloatArray) -> FloatArray:
        return _ramp(self.rise_rate, s)

    def decay(self, s: FloatArray) -> FloatArray:
        # Reversed in time, the decay is a rise with the opposite rate; this avoids cancellation near n.
        return _ramp(-self.decay_rate, np.clip(1.0 - (s - 1.0) / (self.duration_ratio - 1), 0.0, 1.0))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        n = self.duration_ratio
        return (0.0, *find_edges(0.0, 1.0, self.rise_rate, n), 1.0, *find_edges(1.0, n, self.decay_rate, n), n)

    def closed_areas(self) -> tuple[float, float]:
        return _ramp_at(self.rise_rate, 1.0, 1), (self.duration_ratio - 1) * _ramp_at(-self.decay_rate, 1.0, 1)

    def closed_at(self, s: float) -> tuple[float, float]:
        if s <= 1:
            return _ramp_at(self.rise_rate, s, 1), _ramp_at(self.rise_rate, s, 0)
        (a1, a2), rate = self.closed_areas(), -self.decay_rate
        left = min(max(1 - (s - 1) / (self.duration_ratio - 1), 0.0), 1.0)  # fraction of the decay
        return a1 + (a2 - (self.duration_ratio - 1) * _ramp_at(rate, left, 1)), _ramp_at(rate, left, 0)


def _ramp(rate: float, s: FloatArray) -> FloatArray:
    """expm1(-k s)/expm1(-k) on [0, 1] with k = ``rate``."""
    if abs(rate) < _SMALLEST:
        return s
    shape = elementwise(math.expm1, -abs(rate) * s) / math.expm1(-abs(rate))
    return shape if rate > 0 else shape * elementwise(math.exp, rate * (1 - s))


@lru_cache(maxsize=_MOST_KEPT)
def _ramp_at(rate: float, s: float, integrals: int) -> float:
    """`_ramp` at one s, integrated 0 or 1 times from 0 to s."""
    shape = s ** (1 + integrals) * (phi(rate * s, integrals) / phi(rate, 0))
    return shape * math.exp(min(rate, 0.0) - min(rate * s, 0.0))  # last, as it may be near underflow


def phi(x: float, order: int) -> float:
    """Sum of (-x)^j / (j + 1 + order)! over j >= 0, multiplied by e^x for negative x to prevent overflow.

    Multiplied by order!, it is the integral of (1 - t)^order e^(-x t) over 0 <= t <= 1.
    """
    size, fading = abs(x), math.exp(min(x, 0.0))
    if order and size < _SMALL:
        series = 0.0
        for j in reversed(range(_TERMS)):
            series = (1.0 - x * series) / (j + 1 + order)
        return series * fading / math.factorial(order)
    value = -math.expm1(-size) / size if size else 1.0  # no cancellation
    for j in range(1, order + 1):
        value = (fading / math.factorial(j) - value) / x
    return value
