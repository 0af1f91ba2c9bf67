"""Base class of profiles that are linear between corners, with their integrals in closed form."""

from __future__ import annotations

import abc
from bisect import bisect_right
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from shockwave.base.numerics import FloatArray, running_sums
from shockwave.profiles.shock_profile import ShockProfile

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath


class PiecewiseLinear(ShockProfile):
    """A force that is linear between its corners; a subclass defines `corners` and n."""

    @property
    @abc.abstractmethod
    def corners(self) -> tuple[FloatArray, FloatArray]:
        """Times s of the corners, from 0 to n in ascending order, and the forces there, each of shape (k,)."""

    @cached_property
    def breakpoints(self) -> tuple[float, ...]:
        return tuple(self.corners[0].tolist())

    def rise(self, s: FloatArray) -> FloatArray:
        times, forces = self.corners
        before = np.clip(np.searchsorted(times, s, side="right") - 1, 0, times.size - 2)
        # A fraction of the interval instead of a slope, which could overflow for close corners.
        share = (s - times[before]) / (times[before + 1] - times[before])
        return np.asarray(forces[before] + share * (forces[before + 1] - forces[before]))

    def decay(self, s: FloatArray) -> FloatArray:
        return self.rise(s)

    def closed_areas(self) -> tuple[float, float]:
        return self._sums[2]

    def closed_at(self, s: float) -> tuple[float, float]:
        before = min(bisect_right(self.breakpoints, s), len(self.breakpoints) - 1) - 1
        begin, end = self.breakpoints[before : before + 2]
        left, right = self.corners[1][before : before + 2].tolist()
        force = left + (s - begin) / (end - begin) * (right - left)
        return float(self._sums[0][before]) + 0.5 * (s - begin) * (left + force), force

    def closed_free_path(self) -> FreePath:
        from shockwave.profiles.free_path import FreePath

        return FreePath.of_samples(*self.corners, *self._sums[:2])

    @cached_property
    def _sums(self) -> tuple[FloatArray, FloatArray, tuple[float, float]]:
        """Running impulse and double integral at the corners; a1 and a2."""
        times, forces = self.corners
        widths, left, right = np.diff(times), forces[:-1], forces[1:]
        areas = 0.5 * widths * (left + right)
        impulses = running_sums(areas)
        paths = running_sums(widths * (impulses[:-1] + widths * (2.0 * left + right) / 6.0))
        peak = int(np.argmax(forces))
        # The decay is summed separately: a difference of two sums would lose digits of a short decay.
        return impulses, paths, (float(impulses[peak]), float(running_sums(areas[peak:])[-1]))
