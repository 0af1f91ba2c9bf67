"""The initial-peak sawtooth used in shock testing."""

from __future__ import annotations

from attrs import frozen
from shockwave import quantity

from shockwave_pulses.straight_lines import STEEPEST, StraightLines

__all__ = ["InitialPeakSawtooth"]


@frozen(kw_only=True)
class InitialPeakSawtooth(StraightLines):
    """A steep linear rise and a linear decay over the rest of the duration; n = 1/rise_fraction.

    Parameters
    ----------
    rise_fraction : float
        Rise time over the total duration, 1e-6 to 0.5; default 0.05.

    Raises
    ------
    InvalidValueError
        When the value is out of range.

    Notes
    -----
    Areas are a1 = 1/2 and a2 = (n - 1)/2, so all conditions (3) hold; margins in rise times:

    ===============  ==========  ====================================
    condition        margin      at rise_fraction 0.05, n = 20
    ===============  ==========  ====================================
    a2 >= a1         (n - 2)/2   9: holds
    a1 >= 1/2        0           0: holds, with equality
    a2 <= (n-1)/2    0           0: holds, with equality
    ===============  ==========  ====================================

    It is the built-in profile ``triangular``, given by its duration. The ideal sawtooth rises
    instantaneously, but a shock of eq. (2) has a rise: 5 % is the choice of this class.
    """

    rise_fraction: float = quantity(
        "", "rise time over the total duration", at_least=STEEPEST, at_most=0.5, default=0.05
    )

    @property
    def shares(self) -> tuple[float, float]:
        return self.rise_fraction, 1 - self.rise_fraction
