"""The triangular profile, from which the paper derives alpha, eq. (5b)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen

from shockwave.fields import quantity
from shockwave.profiles.base import ShockProfile
from shockwave.quadrature import FloatArray

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath


@frozen(kw_only=True)
class Triangular(ShockProfile):
    """Linear rise, linear decay.

    Parameters
    ----------
    duration_ratio : float
        n, above 1.
    """

    duration_ratio: float = quantity("", "n, whole duration over rise time", above=1, at_most=1e12)

    def rise(self, s: FloatArray) -> FloatArray:
        return np.asarray(1.0 * s)

    def decay(self, s: FloatArray) -> FloatArray:
        return 1.0 - self._share(s)

    def closed_areas(self) -> tuple[float, float]:
        return 0.5, (self.duration_ratio - 1) / 2

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        share = self._share(s)
        return np.asarray(np.minimum(s, 1.0) ** 2 / 2 + (self.duration_ratio - 1) * share * (1 - share / 2))

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        share, decay_time = self._share(s), self.duration_ratio - 1
        after = decay_time * share
        return np.asarray(np.minimum(s, 1.0) ** 3 / 6 + after / 2 + after**2 * (0.5 - share / 6))

    def closed_free_path(self) -> FreePath:
        from shockwave.profiles.free_path import of_powers

        return of_powers(1.0, 1.0, self.duration_ratio)

    def _share(self, s: FloatArray) -> FloatArray:
        """Share of the decay that has passed, 0 before the peak."""
        return np.asarray(np.clip((s - 1.0) / (self.duration_ratio - 1), 0.0, 1.0))
