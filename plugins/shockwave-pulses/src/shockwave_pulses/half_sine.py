"""The half-sine pulse of shock testing, with its integrals in closed form."""

from __future__ import annotations

import math

import attrs
import numpy as np
from attrs import frozen
from shockwave.profiles.base import ShockProfile
from shockwave.quadrature import FloatArray

from shockwave_pulses.sines import less_sine

__all__ = ["HalfSine"]


@frozen
class HalfSine(ShockProfile):
    """F1 = F2 = sin(pi s/2) on 0 <= s <= 2, symmetric about the peak: n = 2, and no parameter.

    Notes
    -----
    Areas are a1 = a2 = 2/pi. Of the conditions (3) it meets two and breaks the third:

    ===============  ===========================
    condition        margin
    ===============  ===========================
    a2 >= a1         0: holds, with equality
    a1 >= 1/2        2/pi - 1/2 = 0.137: holds
    a2 <= (n-1)/2    1/2 - 2/pi = -0.137: fails
    ===============  ===========================

    So section 4 answers outside its assumptions: a prediction has a warning in place of an expected error.

    References
    ----------
    IEC 60068-2-27:2008. Environmental testing - Part 2-27: Tests - Test Ea and guidance: Shock.

    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.3. CRC Press.
    """

    duration_ratio: float = attrs.field(init=False, default=2.0)

    def rise(self, s: FloatArray) -> FloatArray:
        return np.asarray(np.sin(math.pi / 2 * s))

    def decay(self, s: FloatArray) -> FloatArray:
        # Seen from its end the decay is the rise: the last values keep their digits, and the very last is 0.
        return self.rise(2.0 - s)

    def closed_areas(self) -> tuple[float, float]:
        return 2 / math.pi, 2 / math.pi

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        # (2/pi) (1 - cos(pi s/2)), without its difference of near-equal numbers.
        return np.asarray(4 / math.pi * np.sin(math.pi / 4 * s) ** 2)

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        return np.asarray(4 / math.pi**2 * less_sine(math.pi / 2 * s))
