"""The waveform of a blast: a short straight rise and the decay of Friedlander, in closed form."""

from __future__ import annotations

import numpy as np
from shockwave import ShockProfile
from shockwave.hooks import FloatArray

__all__ = ["BlastWaveform", "decay_area"]

# Below this argument moments are computed by their series, because the recurrence cancels.
_SMALL = 2.0
# Terms of this series, for an error below rounding at x = _SMALL.
_TERMS = 30


class BlastWaveform(ShockProfile):
    """F1 = s, F2 = (1 - u) exp(-b u) with u = (s - 1)/(n - 1).

    A subclass defines ``decay_coefficient``, b >= 0, and ``duration_ratio``, n.
    """

    decay_coefficient: float

    def rise(self, s: FloatArray) -> FloatArray:
        return np.asarray(1.0 * s)

    def decay(self, s: FloatArray) -> FloatArray:
        left = (self.duration_ratio - s) / (self.duration_ratio - 1)
        return np.asarray(left * np.exp(-self.decay_coefficient * self._share(s)))

    def closed_areas(self) -> tuple[float, float]:
        return 0.5, (self.duration_ratio - 1) * decay_area(self.decay_coefficient)

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        return np.asarray(np.minimum(s, 1.0) ** 2 / 2 + (self.duration_ratio - 1) * self._decayed(s, 1))

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        decay_time = self.duration_ratio - 1
        after = np.maximum(s - 1.0, 0.0)
        return np.asarray(np.minimum(s, 1.0) ** 3 / 6 + after / 2 + decay_time**2 * self._decayed(s, 2))

    def _share(self, s: FloatArray) -> FloatArray:
        """Fraction u of the decay that has passed, 0 before the peak."""
        return np.asarray(np.clip((s - 1.0) / (self.duration_ratio - 1), 0.0, 1.0))

    def _decayed(self, s: FloatArray, times: int) -> FloatArray:
        """The decay integrated once or twice from 0 to u, as a sum of non-negative terms.

        With v = u t, 1 - v = (1 - u) + u (1 - t).
        """
        u = self._share(s)
        x = self.decay_coefficient * u
        return np.asarray(u**times * ((1.0 - u) * _moment(x, times - 1) + u * _moment(x, times)))


def decay_area(decay_coefficient: float) -> float:
    """Integral of (1 - u) exp(-b u) over 0 <= u <= 1, which is (b - 1 + exp(-b))/b^2.

    Parameters
    ----------
    decay_coefficient : float
        b, at least 0. The area decreases from 1/2 at b = 0, as 1/b for large b.
    """
    return float(_moment(np.asarray(float(decay_coefficient)), 1))


def _moment(x: FloatArray, order: int) -> FloatArray:
    """Integral of (1 - t)^k exp(-x t) over 0 <= t <= 1, for x >= 0 and k = 0, 1, 2, without cancellation.

    The series is k! sum over j of (-x)^j/(j + k + 1)!; by parts, M_k = (1 - k M_(k-1))/x.
    """
    near = np.minimum(x, _SMALL)
    series = np.zeros_like(near)
    for j in reversed(range(_TERMS)):
        series = (1.0 - near * series) / (j + 1 + order)
    far = np.maximum(x, _SMALL)
    closed = -np.expm1(-far) / far
    for k in range(1, order + 1):
        closed = (1.0 - k * closed) / far
    return np.where(x < _SMALL, series, closed)
