"""The half-sine pulse of shock tests."""

from __future__ import annotations

import math

from attrs import frozen

from shockwave.base.numerics import FloatArray, elementwise
from shockwave.base.quantity_fields import Value
from shockwave.profiles.shock_profile import ShockProfile


@frozen
class HalfSine(ShockProfile, Value):
    r"""Half a period of a sine; n = 2, no parameters.

    .. math:: F_1 = F_2 = \sin(\pi s/2)

    The areas are a1 = a2 = 2/pi. The third of the conditions (3) fails by 2/pi - 1/2 rise times, so section 4 is
    applied outside its assumptions.

    References
    ----------
    IEC 60068-2-27:2008. Environmental testing - Part 2-27: Tests - Test Ea and guidance: Shock.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.HalfSine()
    >>> profile.force([0.5, 1.0, 1.5]).round(3).tolist()
    [0.707, 1.0, 0.707]
    """

    duration_ratio = 2.0

    def rise(self, s: FloatArray) -> FloatArray:
        return elementwise(math.sin, math.pi / 2 * s)

    def decay(self, s: FloatArray) -> FloatArray:
        # Reversed in time, the decay is the rise; this avoids cancellation near the end.
        return self.rise(2.0 - s)

    def closed_areas(self) -> tuple[float, float]:
        return 2 / math.pi, 2 / math.pi

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        # (2/pi) (1 - cos(pi s/2)) without cancellation
        return 4 / math.pi * elementwise(math.sin, math.pi / 4 * s) ** 2
