"""The trapezoidal pulse of shock tests."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from attrs import frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.profiles.piecewise_linear import PiecewiseLinear

# Bound on the rounding error of the sum of two fractions.
_ROUNDING = 1e-15


class Plateau(PiecewiseLinear):
    """F1 = s; F2 = 1, then a line down to 0 or a jump; a subclass defines the fractions of rise and fall."""

    rise_fraction: float
    fall_fraction: float

    @property
    def duration_ratio(self) -> float:
        return 1 / self.rise_fraction

    @cached_property
    def corners(self) -> tuple[FloatArray, FloatArray]:
        n, end = self.duration_ratio, (1 - self.fall_fraction) / self.rise_fraction
        fall = ([end, n], [1.0, 0.0]) if 1 + _ROUNDING * n < end < n else ([n], [float(end == n)])
        return np.array([0.0, 1.0, *fall[0]]), np.array([0.0, 1.0, *fall[1]])


@frozen(kw_only=True)
class Trapezoid(Plateau, Value):
    """A linear rise, a plateau and a linear fall; n = 1/rise_fraction.

    With r and f for the fractions, the areas are a1 = 1/2 and a2 = (1 - r - f/2)/r. The third of the conditions (3)
    fails by half the plateau, (1 - r - f)/(2 r) rise times, so section 4 is applied outside its assumptions.

    Parameters
    ----------
    rise_fraction : float
        Rise time over total duration, 1e-6 to below 1.
    fall_fraction : float
        Fall time over total duration, at most 1 - rise_fraction; with 0 the force jumps to zero.

    References
    ----------
    IEC 60068-2-27:2008. Environmental testing - Part 2-27: Tests - Test Ea and guidance: Shock.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.Trapezoid(rise_fraction=0.2, fall_fraction=0.2)
    >>> profile.force([0.5, 2.0, 4.5]).round(3).tolist()
    [0.5, 1.0, 0.5]
    """

    rise_fraction: SI[float] = quantity("", "rise time over total duration", at_least=1e-6, below=1, default=0.1)
    fall_fraction: SI[float] = quantity("", "fall time over total duration", at_least=0, below=1, default=0.1)

    def __attrs_post_init__(self) -> None:
        rest = 1 - self.rise_fraction
        if self.fall_fraction > rest + _ROUNDING:
            got = f"got {self.fall_fraction:g}"
            raise InvalidValueError.of("fall_fraction", f"must be <= {rest:g}, the time after the rise ({got})")
