"""The rectangular pulse of shock tests."""

from __future__ import annotations

from attrs import frozen

from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.profiles.trapezoid import Plateau


@frozen(kw_only=True)
class Rectangular(Plateau, Value):
    """A constant force with short linear ends; n = 1/rise_fraction.

    The ideal rectangle rises instantaneously, but a shock of eq. (2) has a rise. Areas and conditions (3) are those of
    `Trapezoid`.

    Parameters
    ----------
    rise_fraction : float
        Rise time over total duration, 1e-6 to 0.1.
    fall_fraction : float
        Fall time over total duration, 0 to 0.1; with 0 the force jumps to zero.

    References
    ----------
    de Silva, C. W. (Ed.) (2005). Vibration and Shock Handbook, section 12.1.6. CRC Press.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.Rectangular()
    >>> profile.force([0.5, 50, 99.5]).round(3).tolist()
    [0.5, 1.0, 0.5]
    """

    rise_fraction: SI[float] = quantity("", "rise time over total duration", at_least=1e-6, at_most=0.1, default=0.01)
    fall_fraction: SI[float] = quantity("", "fall time over total duration", at_least=0, at_most=0.1, default=0.01)
