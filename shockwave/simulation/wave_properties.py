"""Reading of waves: their properties at a contact, from the motion of its granules and their neighbours."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_right
from typing import Any

import numpy as np
from attrs import define, field, frozen

from shockwave.base.numerics import FloatArray, product
from shockwave.engine.force_law import power_force
from shockwave.engine.peak_log import POWERS, Peak, PeakLog, force_rates, hermite_data
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.stretch import Stretch
from shockwave.simulation.result_parts import MeasuredWave
from shockwave.simulation.travelling_waves import passage_time

# Gauss nodes and weights of a step, as fractions of it; powers 0 to 7 and their derivatives at the nodes.
_LEGENDRE = np.polynomial.legendre.leggauss(8)
_NODES = (1 + _LEGENDRE[0]) / 2
_WEIGHTS = _LEGENDRE[1] / 2
_VALUES = np.vander(_NODES, 8, increasing=True)
_SLOPES = np.pad(_VALUES[:, :-1] * np.arange(1, 8), ((0, 0), (1, 0)))
# The same from the `hermite_data`.
_VALUES_BETWEEN, _SLOPES_BETWEEN = product(_VALUES, POWERS), product(_SLOPES, POWERS)
# Number of samples on each side of a crossing or a maximum that its polynomial interpolates.
_NEIGHBOURS = 4
# Number of Newton steps to a maximum, and how far it may be from its step, over the size of the step.
_CORRECTIONS = 3
_EDGE = 0.1
# Number of contacts over which the speed is measured.
_SPEED_BASE = 4


@frozen(eq=False)
class Transit:
    """A wave at a contact: its peak, and the motion there between the force minima before and after it.

    The minima lie between the times ``begin`` and ``end``. ``times`` are the ends of steps, shape (n,), and ``states``
    the positions and velocities of the granules of the contact and their neighbours, shape (2, n, 4). ``doubt`` is the
    bound on the relative deviation of its peak force from the limit.
    """

    peak: Peak
    begin: float
    end: float
    times: FloatArray
    states: FloatArray
    speed: float | None
    doubt: float


@define
class Probe:
    """History at ``contact``: positions and velocities of its granules and their neighbours at the ends of steps."""

    contact: int
    _times: list[FloatArray] = field(factory=list)
    _states: list[FloatArray] = field(factory=list)

    def observe(self, stretch: Stretch, origin: float = 0.0) -> None:
        """Record ``stretch``, with positions relative to ``origin``, unless the front has not reached the contact."""
        if self.contact + 1 >= stretch.x.shape[1] or not stretch.x[-1, self.contact]:
            return
        # At an end of the chain a granule is repeated, without force between the two.
        first, last = self.contact - 1, self.contact + 3
        skipped = 1 if self._times else 0
        states = np.array((stretch.x[skipped:, max(first, 0) : last], stretch.v[skipped:, max(first, 0) : last]))
        if states.shape[2] < 4:
            states = states[:, :, np.clip(np.arange(first, last), 0, stretch.x.shape[1] - 1) - max(first, 0)]
        states[0] -= origin
        self._times.append(stretch.times[skipped:])
        self._states.append(states)

    def transit(self, peak: Peak, log: PeakLog, doubt: float) -> Transit:
        """The wave with the maximum ``peak``; ``doubt`` is the bound on its distance from the limit."""
        reach = 2 * passage_time(log.wave, peak.force)
        begin = max(log.peak(peak.previous).time if peak.previous >= 0 else 0.0, peak.time - reach)
        end = min(log.next_time(peak), peak.time + reach)
        # of a long history only the end matters
        first = max(bisect_right(self._times, begin, key=lambda times: times.item(0)) - 1, 0)
        times, states = np.concatenate(self._times[first:]), np.concatenate(self._states[first:], axis=1)
        used = slice(max(int(times.searchsorted(begin, "right")) - 1, 0), int(times.searchsorted(end)) + 1)
        arrivals = log.trail(peak, _SPEED_BASE).times
        passed = len(arrivals) - 1
        speed = passed / (peak.time - arrivals[-1]) if passed else None
        return Transit(peak, begin, end, times[used], states[:, used], speed, doubt)


def measure_wave(transit: Transit, problem: ScaledProblem, compiled: Any = None) -> MeasuredWave:
    """Measure a wave, in scaled units; ``compiled`` is the compiled module, or None for NumPy."""
    # the motion of the first contact is smooth only relative to the free-particle displacement
    if compiled is None or not transit.peak.contact:
        return _measure(transit, *_samples(transit, problem))
    wave = array("d", (transit.begin, transit.end, transit.peak.time, transit.peak.force, 0, 0, 0, 0, 0))
    compiled.read(transit.times, np.ascontiguousarray(transit.states), wave)
    return _wave(transit, *wave[4:])


def _samples(transit: Transit, problem: ScaledProblem) -> tuple[FloatArray, ...]:
    """Motion at the Gauss nodes of the steps of a wave.

    Times, forces, velocities of the second granule of the contact, and weights of sums over the time, each of shape
    (steps, nodes); and the position of that granule, as in `hermite_data`, shape (steps, 8).
    """
    times, (x, v), driven = transit.times, transit.states, transit.peak.contact == 0
    forces, rates = force_rates(x[:, :-1] - x[:, 1:], v[:, :-1] - v[:, 1:], problem.exponent)
    jets = np.array((x[:, 1:3], v[:, 1:3], forces[:, :-1] - forces[:, 1:], rates[:, :-1] - rates[:, 1:]))
    if driven:
        jets[:2, :, 0] -= _free(problem, times)
    size = np.diff(times)[:, None]
    jets_between = hermite_data(jets[:, :-1], jets[:, 1:], size[:, 0])
    nodes = times[:-1, None] + size * _NODES
    positions = _interpolate(_VALUES_BETWEEN, jets_between)
    if driven:
        positions[..., 0] += _free(problem, nodes.T.ravel())[0].reshape(len(_NODES), -1)
    force = np.maximum(positions[..., 0] - positions[..., 1], 0.0).T
    velocity = _interpolate(_SLOPES_BETWEEN, jets_between[..., 1]).T / size
    return nodes, power_force(force, problem.exponent), velocity, size * _WEIGHTS, jets_between[..., 1].T


def _interpolate(weights: FloatArray, known: FloatArray) -> FloatArray:
    """Weighted sums of the rows of ``known``, with less memory than `product`, in the same order."""
    sums = np.zeros(known.shape)
    for column, row in zip(weights.T, known, strict=True):
        sums += np.multiply.outer(column, row)
    return sums


def _free(problem: ScaledProblem, times: FloatArray) -> FloatArray:
    """Displacement and velocity of a free granule under the shock, shape (2, times)."""
    return np.array([problem.free(time) for time in times.tolist()]).T


def _measure(
    transit: Transit, time: FloatArray, force: FloatArray, velocity: FloatArray, weight: FloatArray, slopes: FloatArray
) -> MeasuredWave:
    """Measure a wave, from the `_samples` of its steps."""
    time, force, velocity, weight = time.ravel(), force.ravel(), velocity.ravel(), weight.ravel()
    peak = transit.peak
    top = int(np.abs(time - peak.time).argmin())
    left, right = time.searchsorted((transit.begin, transit.end)).tolist()
    begin = left + int(force[left : top + 1].argmin())
    end = top + int(force[top : max(right, top + 1)].argmin())
    inside = slice(begin, end + 1)
    pushed = weight[inside] * force[inside]
    rise = _find_crossing(time[begin : top + 1], force[begin : top + 1], peak.force / 2)
    fall = _find_crossing(time[top : end + 1][::-1], force[top : end + 1][::-1], peak.force / 2)
    fastest = begin + int(velocity[inside].argmax())
    step, node = divmod(fastest, len(_NODES))
    size = transit.times.item(step + 1) - transit.times.item(step)
    return _wave(
        transit,
        float(pushed.sum()),
        float((pushed * velocity[inside]).sum()),
        fall - rise,
        max(velocity.item(fastest), _fastest(slopes[step], _NODES.item(node)) / size),
        max(force.item(begin), force.item(end)) / peak.force,
    )


def _wave(
    transit: Transit, momentum: float, energy: float, width: float, granule_velocity: float, foot: float
) -> MeasuredWave:
    return MeasuredWave(
        peak_force=transit.peak.force,
        momentum=momentum,
        energy=energy,
        speed=transit.speed,
        width=width,
        granule_velocity=granule_velocity,
        contact=transit.peak.contact,
        arrival_time=transit.peak.time,
        error_estimate=transit.doubt,
        foot=foot,
    )


def _find_crossing(time: FloatArray, force: FloatArray, level: float) -> float:
    """Time at which the rising samples pass ``level``, by inverse interpolation."""
    below = (force < level).nonzero()[0]
    last = below.item(-1) + 1 if len(below) else 0
    if last in (0, len(force)):
        return float(time[0])  # the force jumps across the level between two samples
    near = slice(max(last - _NEIGHBOURS, 0), last + _NEIGHBOURS)
    ordinates, abscissae = force[near].tolist(), (time[near] - time[last]).tolist()
    # Lagrange polynomial of the time as a function of the force.
    values = [
        abscissa * math.prod([(level - other) / (ordinate - other) for other in ordinates if other != ordinate])
        for ordinate, abscissa in zip(ordinates, abscissae, strict=True)
    ]
    return float(time[last] + math.fsum(values))


def _fastest(known: FloatArray, share: float) -> float:
    """Maximum of the rate of change given by `hermite_data` near ``share`` of a step; 0 if it is outside."""
    powers = product(POWERS, known[:, None])[::-1, 0].tolist()
    slope = 0.0
    for _ in range(_CORRECTIONS):
        value, slope, bend, curve = 0.0, 0.0, 0.0, 0.0
        for power in powers:
            value, slope, bend, curve = (
                value * share + power, slope * share + value, bend * share + slope, curve * share + bend
            )  # fmt: skip
        if not curve < 0:
            break
        share -= bend / (3 * curve)
    return slope if -_EDGE < share < 1 + _EDGE else 0.0
