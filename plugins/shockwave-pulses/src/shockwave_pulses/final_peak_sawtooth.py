"""The final-peak or terminal-peak sawtooth used in shock testing."""

from __future__ import annotations

from attrs import frozen
from shockwave import quantity

from shockwave_pulses.straight_lines import STEEPEST, StraightLines

__all__ = ["FinalPeakSawtooth"]


@frozen(kw_only=True)
class FinalPeakSawtooth(StraightLines):
    """A linear rise over nearly the total duration and a steep linear fall; n = 1/(1 - fall_fraction).

    Parameters
    ----------
    fall_fraction : float
        Time of the fall over the total duration, 1e-6 to below 0.5; default 0.05.

    Raises
    ------
    InvalidValueError
        When the value is out of range.

    Notes
    -----
    Areas are a1 = 1/2 and a2 = (n - 1)/2. The first of the conditions (3) fails; margins in rise times:

    ===============  ==========  ====================================
    condition        margin      at fall_fraction 0.05, n = 1.053
    ===============  ==========  ====================================
    a2 >= a1         (n - 2)/2   -0.474: fails
    a1 >= 1/2        0           0: holds, with equality
    a2 <= (n-1)/2    0           0: holds, with equality
    ===============  ==========  ====================================

    The ideal sawtooth falls instantaneously. A shock of eq. (2) has n > 1, so the fall takes time here: 5 %
    is the choice of this class. The area is half that of the rectangle for every fraction.

    References
    ----------
    MIL-STD-810H (2019). Method 516.8, Shock: the terminal-peak sawtooth of figure 516.8-3 and table 516.8-IV.
    Department of Defense.

    IEC 60068-2-27:2008. Environmental testing - Part 2-27: Tests - Test Ea and guidance: Shock.

    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.5. CRC Press.
    """

    fall_fraction: float = quantity(
        "", "time of the fall over the total duration", at_least=STEEPEST, below=0.5, default=0.05
    )

    @property
    def shares(self) -> tuple[float, float]:
        return 1 - self.fall_fraction, self.fall_fraction
