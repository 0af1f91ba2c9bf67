"""The trapezoidal pulse used in shock testing."""

from __future__ import annotations

from attrs import frozen
from shockwave import InvalidValueError, quantity

from shockwave_pulses.straight_lines import STEEPEST, StraightLines

__all__ = ["Trapezoid"]

# Rounding error of the sum of two fractions.
_ROUNDING = 1e-15


@frozen(kw_only=True)
class Trapezoid(StraightLines):
    """A linear rise, a plateau and a linear fall; n = 1/rise_fraction.

    Parameters
    ----------
    rise_fraction : float
        Rise time over the total duration, 1e-6 to below 1; default 0.1.
    fall_fraction : float
        Time of the fall over the total duration, 0 to 1 - rise_fraction; default 0.1. With 0 the
        force jumps to zero at the end.

    Raises
    ------
    InvalidValueError
        When a value is out of range, or rise and fall last longer than the pulse.

    Notes
    -----
    With r and f for the fractions, a1 = 1/2 and a2 = (1 - r - f/2)/r. Conditions (3), in rise times:

    ===============  ====================  =========================
    condition        margin                at r = f = 0.1
    ===============  ====================  =========================
    a2 >= a1         (1 - 3 r/2 - f/2)/r   8: holds
    a1 >= 1/2        0                     0: holds, with equality
    a2 <= (n-1)/2    -(1 - r - f)/(2 r)    -4: fails
    ===============  ====================  =========================

    With a plateau the third condition fails, by half its length. Without one, r + f = 1, it holds with
    equality, and the first one fails if the rise is longer than the fall.

    Standards require short rises and falls within a tolerance band; 10 % each is the choice of this class.

    References
    ----------
    IEC 60068-2-27:2008. Environmental testing - Part 2-27: Tests - Test Ea and guidance: Shock.

    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.6. CRC Press.
    """

    rise_fraction: float = quantity(
        "", "rise time over the total duration", at_least=STEEPEST, below=1, default=0.1
    )
    fall_fraction: float = quantity(
        "", "time of the fall over the total duration", at_least=0, below=1, default=0.1
    )

    def __attrs_post_init__(self) -> None:
        most = 1 - self.rise_fraction
        if self.fall_fraction > most + _ROUNDING:
            problem = f"must be <= {most:g}, the rest after the rise (got {self.fall_fraction:g})"
            raise InvalidValueError.of("fall_fraction", problem)
        StraightLines.__attrs_post_init__(self)

    @property
    def shares(self) -> tuple[float, float]:
        return self.rise_fraction, self.fall_fraction
