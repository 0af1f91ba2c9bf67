"""The two sawtooth pulses of shock tests: triangles given by the fraction of the duration of their short side."""

from __future__ import annotations

from attrs import frozen

from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.profiles.power_law import Powers


@frozen(kw_only=True)
class InitialPeakSawtooth(Powers, Value):
    """A short linear rise and a long linear decay; n = 1/rise_fraction.

    The areas are a1 = 1/2 and a2 = (n - 1)/2: all conditions (3) hold. It is a `Triangular` profile; the ideal sawtooth
    rises instantaneously, but a shock of eq. (2) has a rise.

    Parameters
    ----------
    rise_fraction : float
        Rise time over total duration, 1e-6 to 0.5.

    References
    ----------
    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.5. CRC Press.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.InitialPeakSawtooth()
    >>> profile.force([0.5, 1.0, 10.0]).round(3).tolist()
    [0.5, 1.0, 0.526]
    """

    rise_exponent = decay_exponent = 1.0
    rise_fraction: SI[float] = quantity("", "rise time over total duration", at_least=1e-6, at_most=0.5, default=0.05)

    @property
    def duration_ratio(self) -> float:
        return 1 / self.rise_fraction


@frozen(kw_only=True)
class FinalPeakSawtooth(Powers, Value):
    """The final-peak or terminal-peak sawtooth: a long linear rise and a short linear fall; n = 1/(1 - fall_fraction).

    The areas are a1 = 1/2 and a2 = (n - 1)/2. The first of the conditions (3) fails by 1 - n/2 rise times, so section 4
    is applied outside its assumptions.

    Parameters
    ----------
    fall_fraction : float
        Fall time over total duration, 1e-6 to below 0.5.

    References
    ----------
    IEC 60068-2-27:2008. Environmental testing - Part 2-27: Tests - Test Ea and guidance: Shock.

    MIL-STD-810H (2019). Method 516.8, Shock: figure 516.8-3 and table 516.8-IV. Department of Defense.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.FinalPeakSawtooth()
    >>> profile.force([0.5, 1.0, 1.1]).round(3).tolist()
    [0.5, 1.0, 0.0]
    """

    rise_exponent = decay_exponent = 1.0
    fall_fraction: SI[float] = quantity("", "fall time over total duration", at_least=1e-6, below=0.5, default=0.05)

    @property
    def duration_ratio(self) -> float:
        return 1 / (1 - self.fall_fraction)
