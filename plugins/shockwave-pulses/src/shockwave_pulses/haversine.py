"""The haversine pulse of shock testing, which leaves its integrals to quadrature."""

from __future__ import annotations

import math

import attrs
import numpy as np
from attrs import frozen
from shockwave.profiles.base import ShockProfile
from shockwave.quadrature import FloatArray

__all__ = ["Haversine"]


@frozen
class Haversine(ShockProfile):
    """F1 = F2 = sin^2(pi s/2) on 0 <= s <= 2, symmetric about the peak: n = 2, and no parameter.

    It is (1 - cos(pi s))/2, half a versed sine, and is also called versed-sine pulse.

    Notes
    -----
    Areas are a1 = a2 = 1/2, so all of the conditions (3) are met with equality:

    ===============  ========
    condition        margin
    ===============  ========
    a2 >= a1         0: holds
    a1 >= 1/2        0: holds
    a2 <= (n-1)/2    0: holds
    ===============  ========

    The integrals have closed forms, which are left out here: a profile that gives none is integrated by the
    quadrature in use. Margins are then zero to rounding, which the tolerance of the conditions allows for.

    References
    ----------
    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.4. CRC Press.
    """

    duration_ratio: float = attrs.field(init=False, default=2.0)

    def rise(self, s: FloatArray) -> FloatArray:
        return np.asarray(np.sin(math.pi / 2 * s) ** 2)

    def decay(self, s: FloatArray) -> FloatArray:
        # Seen from its end the decay is the rise: the last values keep their digits, and the very last is 0.
        return self.rise(2.0 - s)
