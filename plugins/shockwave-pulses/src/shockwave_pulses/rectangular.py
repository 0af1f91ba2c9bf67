"""The rectangular pulse, with steep ends."""

from __future__ import annotations

from attrs import frozen
from shockwave import quantity

from shockwave_pulses.straight_lines import STEEPEST, StraightLines

__all__ = ["Rectangular"]


@frozen(kw_only=True)
class Rectangular(StraightLines):
    """A constant force with a steep rise and a steep fall, or a jump at its end; n = 1/rise_fraction.

    The ideal rectangle has no rise, but a shock of eq. (2) has one, which is short here.

    Parameters
    ----------
    rise_fraction : float
        Rise time over the total duration, 1e-6 to 0.1; default 0.01.
    fall_fraction : float
        Time of the fall over the total duration, 0 to 0.1; default 0.01. With 0 the force jumps to zero.

    Raises
    ------
    InvalidValueError
        When a value is out of range.

    Notes
    -----
    With r and f for the fractions, a1 = 1/2 and a2 = (1 - r - f/2)/r. Conditions (3), in rise times:

    ===============  ====================  =========================
    condition        margin                at r = f = 0.01
    ===============  ====================  =========================
    a2 >= a1         (1 - 3 r/2 - f/2)/r   98: holds
    a1 >= 1/2        0                     0: holds, with equality
    a2 <= (n-1)/2    -(1 - r - f)/(2 r)    -49: fails
    ===============  ====================  =========================

    It is `Trapezoid` with other defaults and bounds; ends of 1 % are the choice of this class.

    References
    ----------
    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.6. CRC Press.
    """

    rise_fraction: float = quantity(
        "", "rise time over the total duration", at_least=STEEPEST, at_most=0.1, default=0.01
    )
    fall_fraction: float = quantity(
        "", "time of the fall over the total duration", at_least=0, at_most=0.1, default=0.01
    )

    @property
    def shares(self) -> tuple[float, float]:
        return self.rise_fraction, self.fall_fraction
