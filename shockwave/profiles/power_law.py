"""The power-law profile of the paper's Tables 1 and 2."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.profiles.steep_edges import find_edges

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath


class Powers(ShockProfile):
    """F1 = s^eta1 and F2 = ((n - s)/(n - 1))^eta2; a subclass defines eta1, eta2 and n."""

    rise_exponent: float
    decay_exponent: float

    def rise(self, s: FloatArray) -> FloatArray:
        return np.asarray(s**self.rise_exponent)

    def decay(self, s: FloatArray) -> FloatArray:
        n = self.duration_ratio
        return np.asarray(np.clip((n - s) / (n - 1), 0.0, 1.0) ** self.decay_exponent)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        n = self.duration_ratio
        # close to its peak a high power is nearly an exponential
        return (0.0, *find_edges(0.0, 1.0, -self.rise_exponent, n), 1.0, *find_edges(1.0, n, self.decay_exponent, n), n)

    def closed_areas(self) -> tuple[float, float]:
        return 1 / (1 + self.rise_exponent), (self.duration_ratio - 1) / (1 + self.decay_exponent)

    def closed_at(self, s: float) -> tuple[float, float]:
        if s <= 1:
            force = s**self.rise_exponent
            return s * force / (1 + self.rise_exponent), force
        a1, a2 = self.closed_areas()
        left = (self.duration_ratio - s) / (self.duration_ratio - 1)
        force = left**self.decay_exponent
        return a1 + a2 * (1 - left * force), force

    def closed_free_path(self) -> FreePath:
        from shockwave.profiles.free_path import tabulate_powers

        return tabulate_powers(self.rise_exponent, self.decay_exponent, self.duration_ratio)


@frozen(kw_only=True)
class PowerLaw(Powers, Value):
    r"""Powers of the time that has passed and of the time that is left, as in the caption of Table 1.

    .. math:: F_1 = s^{\eta_1}, \quad F_2 = ((n - s)/(n - 1))^{\eta_2}

    Parameters
    ----------
    rise_exponent : float
        Exponent eta1 of the rise, 0 to 1e6; with 0 the force jumps to its peak.
    decay_exponent : float
        Exponent eta2 of the decay, 0 to 1e6; with 0 the force stays at its peak and jumps to zero at the end.
    duration_ratio : float
        n, total duration over rise time, above 1.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.PowerLaw(rise_exponent=0.5, decay_exponent=2, duration_ratio=4)
    >>> profile.force([0.5, 1.0, 1.5]).round(3).tolist()
    [0.707, 1.0, 0.694]
    """

    rise_exponent: SI[float] = quantity("", "eta1, exponent of the rise", at_least=0, at_most=1e6)
    decay_exponent: SI[float] = quantity("", "eta2, exponent of the decay", at_least=0, at_most=1e6)
    duration_ratio: SI[float] = quantity("", "n, total duration over rise time", above=1, at_most=1e12, example="4")
