"""Pulses of straight lines: rise, optional plateau and fall, with their integrals in closed form."""

from __future__ import annotations

import abc

import attrs
import numpy as np
from attrs import frozen
from shockwave import ShockProfile
from shockwave.hooks import FloatArray, FreePath

__all__ = ["STEEPEST", "StraightLines"]

#: The shortest rise as a fraction of the total duration; its inverse n is small enough not to lose digits.
STEEPEST = 1e-6
# Fractions whose sum differs from 1 by less leave no plateau; the difference is rounding.
_ROUNDING = 4 * float(np.finfo(float).eps)


@frozen(kw_only=True)
class StraightLines(ShockProfile):
    """F1 = s; F2 = 1 up to the end p of the plateau, then (n - s)/(n - p); p = n is a jump at the end.

    A subclass defines the fractions of the total duration for rise and fall. The areas are a1 = 1/2 and
    a2 = (n + p)/2 - 1. The margins of the conditions (3) are (n + p - 3)/2, 0 and -(p - 1)/2: with a plateau
    the third one fails.
    """

    duration_ratio: float = attrs.field(init=False, repr=False)
    _plateau_end: float = attrs.field(init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        rise, fall = self.shares
        n = 1 / rise
        end = n * (1 - fall) if 1 - rise - fall > _ROUNDING else 1.0
        object.__setattr__(self, "duration_ratio", n)
        object.__setattr__(self, "_plateau_end", end)

    @property
    @abc.abstractmethod
    def shares(self) -> tuple[float, float]:
        """Rise time and time of the fall over the total duration."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        n, end = self.duration_ratio, self._plateau_end
        return (0.0, 1.0, end, n) if 1 < end < n else (0.0, 1.0, n)

    def rise(self, s: FloatArray) -> FloatArray:
        return np.array(s, dtype=float)

    def decay(self, s: FloatArray) -> FloatArray:
        n, fall = self.duration_ratio, self.duration_ratio - self._plateau_end
        return np.asarray(np.minimum((n - s) / fall, 1.0) if fall > 0 else np.ones_like(s))

    def closed_areas(self) -> tuple[float, float]:
        plateau, fall = self._plateau_end - 1, self.duration_ratio - self._plateau_end
        return 0.5, plateau + fall / 2

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        rising, level, falling, share = self._parts(s)
        # every term grows with s, so nothing cancels
        return np.asarray(rising**2 / 2 + level + falling * (1 - share / 2))

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        rising, level, falling, share = self._parts(s)
        reached = 0.5 + (self._plateau_end - 1)
        fading = falling**2 / 2 * (1 - share / 3)
        return np.asarray(rising**3 / 6 + level / 2 + level**2 / 2 + reached * falling + fading)

    def closed_free_path(self) -> FreePath:
        knots = np.array(self.breakpoints)
        impulses, paths = self.closed_running_impulse(knots), self.closed_double_integral(knots)
        forces = np.ones_like(knots)
        forces[0] = 0.0
        forces[-1] = 0.0 if self._plateau_end < self.duration_ratio else 1.0
        return FreePath.of_samples(knots, forces, impulses, paths)

    def _parts(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Times up to ``s`` in rise, plateau and fall, and the fraction of the fall that has passed."""
        end = self._plateau_end
        fall = self.duration_ratio - end
        rising = np.minimum(s, 1.0)
        level = np.clip(s - 1.0, 0.0, end - 1.0)
        falling = np.maximum(s - end, 0.0)
        return rising, level, falling, falling / fall if fall > 0 else np.zeros_like(falling)
