"""Profiles of formulas without closed forms, and integrals of power laws and exponentials in 200 digits."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import mpmath
import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.quadrature import Integrand
from shockwave.profiles.shock_profile import ShockProfile

# 40 are kept: a rise at rate -300 loses 130 to cancellation, one at rate 1e-9 and s = 1e-12 loses 60.
WORKING_DIGITS = 200


class Formula(ShockProfile):
    """A minimal profile: rise and decay, whose evaluations are counted."""

    def __init__(self, rise: Integrand, decay: Integrand, n: float = 2.0, jumps: Iterable[float] = ()) -> None:
        self._rise, self._decay, self.duration_ratio, self.jumps = rise, decay, n, tuple(jumps)
        self.points = 0

    def rise(self, s: FloatArray) -> FloatArray:
        self.points += s.size
        return self._rise(s)

    def decay(self, s: FloatArray) -> FloatArray:
        self.points += s.size
        return self._decay(s)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        return tuple(sorted({0.0, 1.0, self.duration_ratio, *self.jumps}))


def sine(power: float = 1.0) -> Formula:
    """A symmetric pulse, a power of a sine."""

    def force(s: FloatArray) -> FloatArray:
        return np.asarray(np.sin(math.pi / 2 * s) ** power)

    return Formula(force, force)


def _rise(profile: ShockProfile, integrals: int, s: Any) -> Any:
    """Rise integrated from 0 to s none, once or twice."""
    if isinstance(profile, Exponential):
        return _ramp(mpmath.mpf(profile.rise_rate), s, integrals)
    return _power(mpmath.mpf(profile.rise_exponent), s, integrals)


def _fade(profile: ShockProfile, integrals: int, left: Any) -> Any:
    """The decay as a function of its remaining fraction; integrated in the same way."""
    if isinstance(profile, Exponential):
        return _ramp(-mpmath.mpf(profile.decay_rate), left, integrals)
    return _power(mpmath.mpf(profile.decay_exponent), left, integrals)


def _power(exponent: Any, s: Any, integrals: int) -> Any:
    factor = mpmath.mpf(1)
    for j in range(1, integrals + 1):
        factor /= exponent + j
    return factor * s ** (exponent + integrals)


def _ramp(rate: Any, s: Any, integrals: int) -> Any:
    """(1 - e^(-k s)) / (1 - e^(-k)), integrated term by term."""
    ends = -mpmath.expm1(-rate)
    once = s + mpmath.expm1(-rate * s) / rate
    return [-mpmath.expm1(-rate * s), once, s**2 / 2 - once / rate][integrals] / ends


def exact_integral(profile: ShockProfile, integrals: int, s: float) -> float:
    """Impulse, or with two integrals the path, from 0 to s."""
    with mpmath.workdps(WORKING_DIGITS):
        time, n = mpmath.mpf(s), mpmath.mpf(profile.duration_ratio)
        if time <= 1:
            return float(_rise(profile, integrals, time))
        after, decay = time - 1, n - 1
        left = 1 - after / decay
        a1 = _rise(profile, 1, mpmath.mpf(1))
        whole = _fade(profile, 1, mpmath.mpf(1))
        if integrals == 1:
            return float(a1 + decay * (whole - _fade(profile, 1, left)))
        lost = _fade(profile, 2, mpmath.mpf(1)) - _fade(profile, 2, left)
        start = _rise(profile, 2, mpmath.mpf(1))
        return float(start + (a1 + decay * whole) * after - decay**2 * lost)


def exact_areas(profile: ShockProfile) -> tuple[Any, Any]:
    """Areas under rise and decay."""
    with mpmath.workdps(WORKING_DIGITS):
        one = mpmath.mpf(1)
        return _rise(profile, 1, one), (mpmath.mpf(profile.duration_ratio) - 1) * _fade(profile, 1, one)
