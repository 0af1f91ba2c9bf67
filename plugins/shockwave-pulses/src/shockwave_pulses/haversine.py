"""The haversine pulse used in shock testing, with its integrals in closed form."""

from __future__ import annotations

import math

import attrs
import numpy as np
from attrs import frozen
from shockwave import ShockProfile
from shockwave.hooks import FloatArray

from shockwave_pulses.sines import less_sine

__all__ = ["Haversine"]


@frozen
class Haversine(ShockProfile):
    """F1 = F2 = sin^2(pi s/2) on 0 <= s <= 2, symmetric about the peak; n = 2, no parameters.

    It is (1 - cos(pi s))/2, half a versed sine, and is also called the versed-sine pulse.

    Notes
    -----
    Areas are a1 = a2 = 1/2, so all conditions (3) hold with equality:

    ===============  ========
    condition        margin
    ===============  ========
    a2 >= a1         0: holds
    a1 >= 1/2        0: holds
    a2 <= (n-1)/2    0: holds
    ===============  ========

    References
    ----------
    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.4. CRC Press.
    """

    duration_ratio: float = attrs.field(init=False, default=2.0)

    def rise(self, s: FloatArray) -> FloatArray:
        return np.asarray(np.sin(math.pi / 2 * s) ** 2)

    def decay(self, s: FloatArray) -> FloatArray:
        # seen from its end, the decay is the rise: no digits are lost near the end, and the last value is 0
        return self.rise(2.0 - s)

    def closed_areas(self) -> tuple[float, float]:
        return 0.5, 0.5

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        # s/2 - sin(pi s)/(2 pi)
        return np.asarray(less_sine(math.pi * s) / (2 * math.pi))

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        # (x^2 - sin(x)^2)/pi^2 as a product, without cancellation near 0
        x = math.pi / 2 * s
        return np.asarray(less_sine(x) * (x + np.sin(x)) / math.pi**2)
