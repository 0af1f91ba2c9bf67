"""The haversine or versed-sine pulse of shock tests."""

from __future__ import annotations

import math

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray, elementwise
from shockwave.base.quantity_fields import Value
from shockwave.profiles.shock_profile import ShockProfile

# Coefficients of (x - sin x)/x^3 in x^2, highest power first; the remainder at x = 2 pi is below the rounding error.
_SERIES = [(-1) ** k / math.factorial(2 * k + 3) for k in reversed(range(20))]


@frozen
class Haversine(ShockProfile, Value):
    r"""Square of half a period of a sine; n = 2, no parameters.

    .. math:: F_1 = F_2 = \sin^2(\pi s/2)

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
        x = math.pi * s  # (x - sin x)/(2 pi) without cancellation
        return np.asarray(x**3 * np.polyval(_SERIES, x**2) / (2 * math.pi))
