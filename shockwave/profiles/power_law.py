"""The power-law profile of the paper's Tables 1 and 2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.profiles.steep_edges import edges

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath


def power(base: FloatArray, exponent: Any) -> FloatArray:
    """Power of ``base`` by a number or by an array of exponents, with equal results for both to the last bit.

    NumPy computes roots and squares as such for a single exponent, but not for an array of them.
    """
    found = np.asarray(base**exponent)
    if np.ndim(exponent):
        for special, function in ((0.5, np.sqrt), (2.0, np.square)):
            if (exponent == special).any():
                found = np.where(exponent == special, function(base), found)
    return found


class Powers(ShockProfile):
    """F1 = s^eta1 and F2 = ((n - s)/(n - 1))^eta2; a subclass defines eta1, eta2 and n."""

    rise_exponent: float
    decay_exponent: float

    def rise(self, s: FloatArray) -> FloatArray:
        return power(s, self.rise_exponent)

    def decay(self, s: FloatArray) -> FloatArray:
        return power(self._left(s), self.decay_exponent)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        n = self.duration_ratio
        # close to its peak a high power is nearly an exponential
        return (0.0, *edges(0.0, 1.0, -self.rise_exponent, n), 1.0, *edges(1.0, n, self.decay_exponent, n), n)

    def closed_areas(self) -> tuple[float, float]:
        return 1 / (1 + self.rise_exponent), (self.duration_ratio - 1) / (1 + self.decay_exponent)

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        a1, a2 = self.closed_areas()
        rising = a1 * power(np.minimum(s, 1.0), 1 + self.rise_exponent)
        return np.asarray(rising + a2 * (1 - power(self._left(s), 1 + self.decay_exponent)))

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        a1, a2 = self.closed_areas()
        rising = a1 * power(np.minimum(s, 1.0), 2 + self.rise_exponent) / (2 + self.rise_exponent)
        fading = (self.duration_ratio - 1) * (1 - power(self._left(s), 2 + self.decay_exponent))
        after = np.maximum(s - 1.0, 0.0)
        return np.asarray(rising + (a1 + a2) * after - a2 * fading / (2 + self.decay_exponent))

    def closed_at(self, s: float) -> tuple[float, float]:
        if s <= 1:
            force = s**self.rise_exponent
            return s * force / (1 + self.rise_exponent), force
        a1, a2 = self.closed_areas()
        left = (self.duration_ratio - s) / (self.duration_ratio - 1)
        force = left**self.decay_exponent
        return a1 + a2 * (1 - left * force), force

    def closed_free_path(self) -> FreePath:
        from shockwave.profiles.free_path import of_powers

        return of_powers(self.rise_exponent, self.decay_exponent, self.duration_ratio)

    def _left(self, s: FloatArray) -> FloatArray:
        """Remaining fraction of the decay, 1 before the peak."""
        n = self.duration_ratio
        return np.asarray(np.clip((n - s) / (n - 1), 0.0, 1.0))


class ManyPowers(Powers):
    """Power laws of many shapes, with parameters of shape (shapes,); the methods take one s for each shape."""

    rise_exponent: Any
    decay_exponent: Any
    duration_ratio: Any

    def __init__(self, profiles: Sequence[Powers]) -> None:
        for name in ("rise_exponent", "decay_exponent", "duration_ratio"):
            setattr(self, name, np.array([getattr(profile, name) for profile in profiles], dtype=float))

    def free_paths(self) -> list[FreePath]:
        """Table of each shape; see `ShockProfile.free_path`."""
        from shockwave.profiles.free_path import of_many_powers

        return of_many_powers(self.rise_exponent, self.decay_exponent, self.duration_ratio)

    def forces(self, s: FloatArray) -> FloatArray:
        """Force at one s of each shape, 0 <= s <= n; shape (shapes,)."""
        rise, decay = power(np.minimum(s, 1.0), self.rise_exponent), power(self._left(s), self.decay_exponent)
        return np.where(s <= 1, rise, decay)


@frozen(kw_only=True)
class PowerLaw(Powers, Value):
    """F1 = s^eta1 and F2 = ((n - s)/(n - 1))^eta2, as in the caption of Table 1.

    Parameters
    ----------
    rise_exponent, decay_exponent : float
        Exponents eta1 and eta2, 0 to 1e6. With the exponent 0 the force is constant and jumps at the beginning of the
        rise or at the end of the decay.
    duration_ratio : float
        n, total duration over rise time, above 1.
    """

    rise_exponent: SI[float] = quantity("", "eta1, exponent of the rise", at_least=0, at_most=1e6)
    decay_exponent: SI[float] = quantity("", "eta2, exponent of the decay", at_least=0, at_most=1e6)
    duration_ratio: SI[float] = quantity("", "n, total duration over rise time", above=1, at_most=1e12, example="4")
