"""The haversine or versed-sine pulse of shock tests."""

from __future__ import annotations

import math

from attrs import frozen

from shockwave.base.numerics import FloatArray, elementwise
from shockwave.base.quantity_fields import Value
from shockwave.profiles.half_sine import subtract_sine
from shockwave.profiles.shock_profile import ShockProfile


@frozen
class Haversine(ShockProfile, Value):
    """F1 = F2 = sin^2(pi s/2) = (1 - cos(pi s))/2 on 0 <= s <= 2, symmetric about the peak; n = 2, no parameters.

    The areas are a1 = a2 = 1/2: all conditions (3) hold, with equality.

    References
    ----------
    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.4. CRC Press.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.Haversine()
    >>> profile.force([0.5, 1.0, 1.5]).round(3).tolist()
    [0.5, 1.0, 0.5]
    """

    duration_ratio = 2.0

    def rise(self, s: FloatArray) -> FloatArray:
        return elementwise(math.sin, math.pi / 2 * s) ** 2

    def decay(self, s: FloatArray) -> FloatArray:
        # Reversed in time, the decay is the rise; this avoids cancellation near the end.
        return self.rise(2.0 - s)

    def closed_areas(self) -> tuple[float, float]:
        return 0.5, 0.5

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        return subtract_sine(math.pi * s) / (2 * math.pi)

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        # (x^2 - sin^2 x)/pi^2 as a product, without cancellation
        x = math.pi / 2 * s
        return subtract_sine(x) * (x + elementwise(math.sin, x)) / math.pi**2
