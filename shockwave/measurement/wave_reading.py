"""Reading a wave off the history of the contact that it passes."""

from __future__ import annotations

import math

import numpy as np
from attrs import define, field

from shockwave.measurement.peaks import Peak, PeakLog, force_rates, history, powers_between
from shockwave.measurement.result import MeasuredWave
from shockwave.numerics import product
from shockwave.quadrature import FloatArray
from shockwave.simulation.march import Stretch
from shockwave.simulation.problem import ChainProblem

# Gauss nodes of a step and their weights, as shares of it; the powers 0 to 7 and their slopes there.
_LEGENDRE = np.polynomial.legendre.leggauss(8)
_NODES = (1 + _LEGENDRE[0]) / 2
_WEIGHTS = _LEGENDRE[1] / 2
_VALUES = np.vander(_NODES, 8, increasing=True)
_SLOPES = np.pad(_VALUES[:, :-1] * np.arange(1, 8), ((0, 0), (1, 0)))
# Samples on each side of a crossing or a maximum that its polynomial goes through.
_NEIGHBOURS = 4
# Over how many contacts the speed is taken.
_SPEED_BASE = 4


@define
class Probe:
    """History of ``contact``: where its granules and their neighbours are at the ends of steps."""

    contact: int
    problem: ChainProblem
    _times: list[FloatArray] = field(factory=list)
    _states: list[FloatArray] = field(factory=list)

    def observe(self, stretch: Stretch) -> None:
        """Take note of ``stretch``, unless the contact has not been reached."""
        if self.contact + 1 >= stretch.x.shape[1] or not stretch.x[-1, self.contact]:
            return
        # An end of the chain is doubled: there is no force between the two.
        near = np.clip(np.arange(self.contact - 1, self.contact + 3), 0, stretch.x.shape[1] - 1)
        known = 1 if self._times else 0
        self._times.append(stretch.times[known:])
        self._states.append(np.array((stretch.x[known:, near], stretch.v[known:, near])))

    def wave(self, peak: Peak, log: PeakLog, doubt: float) -> MeasuredWave:
        """The wave whose maximum at this contact is ``peak``: from the least force before it to the least after.

        It is in scaled units; ``doubt`` of its peak is its error estimate so far.
        """
        others = [other.time for other in log.peaks[self.contact] if other.force > 0]
        before = max((t for t in others if t < peak.time), default=-math.inf)
        after = min((t for t in others if t > peak.time), default=math.inf)
        time, force, velocity, weight = self._samples(before, after)
        top = int(np.argmin(np.abs(time - peak.time)))
        left, right = int(np.searchsorted(time, before)), int(np.searchsorted(time, after))
        begin = left + int(np.argmin(force[left : top + 1]))
        end = top + int(np.argmin(force[top : max(right, top + 1)]))
        inside = slice(begin, end + 1)
        rise = _crossing(time[begin : top + 1], force[begin : top + 1], peak.force / 2)
        fall = _crossing(time[top : end + 1][::-1], force[top : end + 1][::-1], peak.force / 2)
        trail = history(peak, _SPEED_BASE)
        passed = len(trail) - 1
        return MeasuredWave(
            peak_force=peak.force,
            momentum=float((weight[inside] * force[inside]).sum()),
            energy=float((weight[inside] * force[inside] * velocity[inside]).sum()),
            speed=passed / (peak.time - trail[-1].time) if passed else None,
            width=fall - rise,
            granule_velocity=_maximum(time[inside], velocity[inside]),
            contact=self.contact,
            arrival_time=peak.time,
            error_estimate=doubt,
            foot=float(max(force[begin], force[end])) / peak.force,
        )

    def _samples(self, begin: float, end: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Times, forces, velocities of the granule behind the contact, and weights: at Gauss nodes of every step."""
        times, states = np.concatenate(self._times), np.concatenate(self._states, axis=1)
        used = slice(max(int(np.searchsorted(times, begin, "right")) - 1, 0), int(np.searchsorted(times, end)) + 1)
        times, (x, v) = times[used], states[:, used]
        forces, rates = force_rates(-np.diff(x), -np.diff(v))
        jets = np.array((x[:, 1:3], v[:, 1:3], -np.diff(forces), -np.diff(rates)))
        if self.contact == 0:  # only what the chain does to it is smooth
            jets[:2, :, 0] -= self._driven(times)
        size = np.diff(times)
        powers = powers_between(jets[:, :-1], jets[:, 1:], size)
        nodes = (times[:-1, None] + size[:, None] * _NODES).ravel()
        # from shape (nodes, steps, 2) to one row for each granule, in the order of time
        positions = product(_VALUES, powers.reshape(8, -1)).reshape(powers.shape).T.reshape(2, -1)
        velocity = product(_SLOPES, powers[..., 1]).T / size[:, None]
        if self.contact == 0:
            positions[0] += self._driven(nodes)[0]
        force, _ = force_rates(positions[0] - positions[1], np.zeros_like(nodes))
        return nodes, force, velocity.ravel(), (size[:, None] * _WEIGHTS).ravel()

    def _driven(self, times: FloatArray) -> FloatArray:
        """Path and velocity of a granule that only the shock drives, shape (2, times)."""
        return np.array([self.problem.free(time) for time in times.tolist()]).T


def _crossing(time: FloatArray, force: FloatArray, level: float) -> float:
    """Time at which the rising samples pass ``level``, by inverse interpolation."""
    last = len(force) - int(np.argmax(force[::-1] < level)) if np.any(force < level) else 0
    if last in (0, len(force)):
        return float(time[0])  # the force jumps past the level between two samples
    near = slice(max(last - _NEIGHBOURS, 0), last + _NEIGHBOURS)
    ordinates, abscissae = force[near], time[near] - time[last]
    # Lagrange's polynomial of time as a function of force.
    values = [
        abscissa * np.prod([(level - other) / (own - other) for other in ordinates if other != own])
        for own, abscissa in zip(ordinates, abscissae, strict=True)
    ]
    return float(time[last] + np.sum(values))


def _maximum(time: FloatArray, values: FloatArray) -> float:
    """Greatest value of a smooth function, from a polynomial through the samples around the greatest."""
    top = int(np.argmax(values))
    near = slice(max(top - _NEIGHBOURS, 0), top + _NEIGHBOURS + 1)
    if len(values[near]) < 2 * _NEIGHBOURS + 1:
        return float(values[top])
    origin, scale = time[top], time[near][-1] - time[near][0]
    fit = np.polynomial.Polynomial.fit((time[near] - origin) / scale, values[near], 2 * _NEIGHBOURS - 2)
    roots = [root.real for root in fit.deriv().roots() if abs(root.imag) < 1e-9 and abs(root.real) <= 1]
    return float(max((fit(root) for root in roots), default=values[top]))
