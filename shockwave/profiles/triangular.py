"""The triangular profile, for which the paper derives alpha, eq. (5b)."""

from __future__ import annotations

from attrs import frozen

from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.profiles.power_law import Powers


@frozen(kw_only=True)
class Triangular(Powers, Value):
    """Linear rise and linear decay.

    Parameters
    ----------
    duration_ratio : float
        n, total duration over rise time, above 1.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.Triangular(duration_ratio=3)
    >>> profile.force([0.5, 1.0, 1.5]).round(3).tolist()
    [0.5, 1.0, 0.75]
    """

    rise_exponent = decay_exponent = 1.0
    duration_ratio: SI[float] = quantity("", "n, total duration over rise time", above=1, at_most=1e12, example="4")
