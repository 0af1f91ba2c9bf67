"""First pulses by their definition, from samples of a signal."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, minimize_scalar

from shockwave.base.numerics import FloatArray


class SampledPulse:
    """The first pulse of a dynamic signal, in SI units; within it, times are in tens of microseconds."""

    unit = 1e-5

    def __init__(self, times: FloatArray, values: FloatArray) -> None:
        self.grid, self.values = times / self.unit, values
        self.at = CubicSpline(self.grid, values)
        self.find()

    def value(self, time: float) -> float:
        return float(self.at(time))

    def find(self) -> None:
        """Follow the definition from sample to sample."""
        grid, values = self.grid, self.values
        tops = 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))
        peaks = {int(index): self.extreme(int(index), 1.0) for index in tops if values[index] > 0.01 * values.max()}
        level = 0.02 * max(value for _, value in peaks.values())
        start = int(np.argmax(values > level))
        self.peak = top = 0.0
        for end in range(start, len(grid)):
            if end in peaks and peaks[end][1] > self.peak:
                top, self.peak = peaks[end]
            if values[end] <= max(self.peak, values[start : end + 1].max()) / 2:
                break
        inner = values[start:end]
        self.merged = bool(((inner[1:-1] < inner[:-2]) & (inner[1:-1] <= inner[2:])).any())
        half = self.peak / 2
        (before,) = np.flatnonzero((values[:-1] < half) & (values[1:] >= half) & (grid[1:] <= top + 1e-9))[-1:]
        arrival, fall = self.crossing(int(before), half), self.crossing(end - 1, half)
        low = next(i for i in range(end, len(grid) - 1) if values[i + 1] >= values[i] or values[i + 1] <= 0)
        stop = self.extreme(low, -1.0)[0] if values[low + 1] > 0 else float(grid[low + 1])
        stop = self.crossing(low, 0.0) if values[low + 1] < 0 else stop
        self.impulse = self.integral(self.crossing(start - 1, level), stop) * self.unit
        self.time, self.arrival, self.width = (each * self.unit for each in (top, arrival, fall - arrival))

    def crossing(self, place: int, level: float) -> float:
        """Time at which the signal crosses a level behind a sample."""
        return float(brentq(lambda time: self.value(time) - level, *self.grid[place : place + 2], xtol=1e-14))

    def extreme(self, place: int, sign: float) -> tuple[float, float]:
        """Time and value of a maximum, or with the other sign a minimum, next to a sample."""
        bounds = self.grid[place - 1], self.grid[place + 1]
        control = {"xatol": 1e-12}
        best = minimize_scalar(lambda time: -sign * self.value(time), bounds=bounds, method="bounded", options=control)
        return float(best.x), float(-sign * best.fun)

    def integral(self, begin: float, stop: float) -> float:
        """Integral, by Gauss's rule between the samples."""
        nodes, weights = np.polynomial.legendre.leggauss(8)
        points = np.unique([begin, stop, *self.grid[(self.grid > begin) & (self.grid < stop)]])
        middles = [((a + b) / 2, (b - a) / 2) for a, b in pairwise(points)]
        return float(sum(half * weights @ self.at(at + half * nodes) for at, half in middles))
