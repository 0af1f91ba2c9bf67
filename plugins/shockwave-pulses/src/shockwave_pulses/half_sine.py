"""The half-sine pulse used in shock testing, with its integrals in closed form."""

from __future__ import annotations

import math

import attrs
import numpy as np
from attrs import frozen
from shockwave import ShockProfile
from shockwave.hooks import FloatArray

from shockwave_pulses.sines import less_sine

__all__ = ["HalfSine"]


@frozen
class HalfSine(ShockProfile):
    """F1 = F2 = sin(pi s/2) on 0 <= s <= 2, symmetric about the peak; n = 2, no parameters.

    Notes
    -----
    Areas are a1 = a2 = 2/pi. The third of the conditions (3) fails:

    ===============  ===========================
    condition        margin
    ===============  ===========================
    a2 >= a1         0: holds, with equality
    a1 >= 1/2        2/pi - 1/2 = 0.137: holds
    a2 <= (n-1)/2    1/2 - 2/pi = -0.137: fails
    ===============  ===========================

    Section 4 is therefore applied outside its assumptions: its error is not known.

    References
    ----------
    IEC 60068-2-27:2008. Environmental testing - Part 2-27: Tests - Test Ea and guidance: Shock.

    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.3. CRC Press.
    """

    duration_ratio: float = attrs.field(init=False, default=2.0)

    def rise(self, s: FloatArray) -> FloatArray:
        return np.asarray(np.sin(math.pi / 2 * s))

    def decay(self, s: FloatArray) -> FloatArray:
        # seen from its end, the decay is the rise: no digits are lost near the end, and the last value is 0
        return self.rise(2.0 - s)

    def closed_areas(self) -> tuple[float, float]:
        return 2 / math.pi, 2 / math.pi

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        # (2/pi) (1 - cos(pi s/2)), without cancellation
        return np.asarray(4 / math.pi * np.sin(math.pi / 4 * s) ** 2)

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        return np.asarray(4 / math.pi**2 * less_sine(math.pi / 2 * s))
