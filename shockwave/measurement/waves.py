"""Waves in a run of the chain: when they have settled, and their properties at the contact that they pass."""

from __future__ import annotations

import math
from itertools import accumulate

import numpy as np
from attrs import define, field

from shockwave.chain.solitary_wave import ENERGY
from shockwave.measurement.peak_log import Peak, PeakLog, force_rates, history, powers_between
from shockwave.measurement.result import MeasuredWave
from shockwave.numerics import product
from shockwave.quadrature import FloatArray
from shockwave.simulation.march import Stretch, free_granules
from shockwave.simulation.problem import ChainProblem, contact_energies

# Number of contacts between the peaks whose differences give the rate of approach to the limit.
_STRIDE = 10
# Number of granules behind its peak over which a wave extends.
_BACK = 3
# Waves are followed down to this fraction of the threshold.
_FOLLOWED = 0.3
# A wave whose peak force exceeds that of a wave ahead by this factor will overtake it.
_TALLER = 1.001
# Slowest decrease of the deviation from the limit, per stride, that can be distinguished from noise.
_SLOWEST = 0.97
# Gauss nodes and weights of a step, as fractions of it; powers 0 to 7 and their derivatives at the nodes.
_LEGENDRE = np.polynomial.legendre.leggauss(8)
_NODES = (1 + _LEGENDRE[0]) / 2
_WEIGHTS = _LEGENDRE[1] / 2
_VALUES = np.vander(_NODES, 8, increasing=True)
_SLOPES = np.pad(_VALUES[:, :-1] * np.arange(1, 8), ((0, 0), (1, 0)))
# Number of samples on each side of a crossing or a maximum that its polynomial interpolates.
_NEIGHBOURS = 4
# Number of contacts over which the speed is measured.
_SPEED_BASE = 4


# ---------------------------------------------------------------- limits


def settling(
    log: PeakLog, now: float, x: FloatArray, v: FloatArray, threshold: float, noise: float = 0.0
) -> tuple[list[tuple[Peak, float]], bool]:
    """Examine whether the waves have settled, after the force has ended.

    Parameters
    ----------
    log : PeakLog
        All peaks up to ``now``.
    now : float
        Present time.
    x, v : FloatArray
        Positions and velocities at ``now``, shape (granules,).
    threshold : float
        Least peak force of a wave, over that of the strongest wave.
    noise : float
        Error of a peak force due to step errors: smaller differences are not significant.

    Returns
    -------
    list of (Peak, float)
        The foremost peak of each wave, front first, with a bound on its relative deviation from its limit. The bound is
        infinite for a wave that will collide with another one, or is followed by one that may still become stronger.
    bool
        Whether nothing behind these waves can form another wave.
    """
    # Weaker waves are followed, too: they may still grow, and their energy is taken into account.
    followed = log.heads(now, _FOLLOWED * threshold)
    if not followed:
        return [], False
    forces = [head.force for head in followed]
    least = threshold * max(forces)
    doubts = [_doubt(history(head, 2 * _STRIDE), noise) for head in followed]
    tallest = [force * (1 + min(doubt, 1.0)) for force, doubt in zip(forces, doubts, strict=True)]
    weakest_ahead = [math.inf, *accumulate(forces, min)]
    tallest_behind = list(accumulate([0.0, *reversed(tallest[1:])], max))[::-1]
    for i, force in enumerate(forces):
        if _TALLER * weakest_ahead[i] < force or tallest_behind[i] > _TALLER * force:
            doubts[i] = math.inf
    waves = list(zip(followed, doubts, strict=True))
    may_grow = any(head.force < least <= head.force * (1 + doubt) for head, doubt in waves)
    complete = not may_grow and _nothing_to_come(x, v, followed[-1].contact, least)
    return [(head, doubt) for head, doubt in waves if head.force >= least], complete


def _doubt(trail: list[Peak], noise: float) -> float:
    """Bound on the relative deviation of a wave's peak force from its limit, from its last peaks.

    Far from other waves the deviation decreases geometrically, so that it follows from the variation of the peak force
    over the last contacts and over the preceding ones. The variation must also decrease within the last contacts, to
    exclude waves whose peak force is constant only for a while.
    """
    if len(trail) <= 2 * _STRIDE:
        return math.inf
    half = _STRIDE // 2
    forces = np.array([peak.force for peak in trail])
    recent = float(np.ptp(forces[: half + 1]))
    older = float(np.ptp(forces[half : _STRIDE + 1]))
    last = float(np.ptp(forces[: _STRIDE + 1]))
    previous = float(np.ptp(forces[_STRIDE : 2 * _STRIDE + 1]))
    if last <= noise:
        return last / trail[0].force
    ratio = min(max(_ratio(last, previous), _ratio(recent, older) ** 2), _SLOWEST)
    return last * max(ratio / (1 - ratio), 0.1) / trail[0].force


def _ratio(later: float, earlier: float) -> float:
    return later / earlier if earlier > 0 else math.inf


def _nothing_to_come(x: FloatArray, v: FloatArray, rearmost: int, least_force: float) -> bool:
    """Whether the energy behind the rearmost wave is too small to form a wave of ``least_force``."""
    first, last = free_granules(x, v), max(rearmost - _BACK, 0)
    if first >= last:
        return True
    energy = 0.5 * v[first:last] ** 2 + contact_energies(x)[first:last]
    # The energy of all granules counts, because distant granules may still collide.
    return float(energy.sum()) < ENERGY * math.pow(least_force, 5 / 3)


# ---------------------------------------------------------------- properties


@define
class Probe:
    """History at ``contact``: positions and velocities of its granules and their neighbours at the ends of steps."""

    contact: int
    problem: ChainProblem
    _times: list[FloatArray] = field(factory=list)
    _states: list[FloatArray] = field(factory=list)

    def observe(self, stretch: Stretch) -> None:
        """Record ``stretch``, unless the front has not reached the contact."""
        if self.contact + 1 >= stretch.x.shape[1] or not stretch.x[-1, self.contact]:
            return
        # At an end of the chain a granule is repeated, without force between the two.
        near = np.clip(np.arange(self.contact - 1, self.contact + 3), 0, stretch.x.shape[1] - 1)
        known = 1 if self._times else 0
        self._times.append(stretch.times[known:])
        self._states.append(np.array((stretch.x[known:, near], stretch.v[known:, near])))

    def wave(self, peak: Peak, log: PeakLog, doubt: float) -> MeasuredWave:
        """Measure the wave with the maximum ``peak``, between the force minima before and after it, in scaled units.

        ``doubt`` is the bound on the relative deviation of its peak force from the limit.
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
        """Times, forces, velocities of the granule behind the contact, and weights, at the Gauss nodes of each step."""
        times, states = np.concatenate(self._times), np.concatenate(self._states, axis=1)
        used = slice(max(int(np.searchsorted(times, begin, "right")) - 1, 0), int(np.searchsorted(times, end)) + 1)
        times, (x, v) = times[used], states[:, used]
        forces, rates = force_rates(-np.diff(x), -np.diff(v))
        jets = np.array((x[:, 1:3], v[:, 1:3], -np.diff(forces), -np.diff(rates)))
        if self.contact == 0:  # only the motion relative to the free-particle displacement is smooth
            jets[:2, :, 0] -= self._driven(times)
        size = np.diff(times)
        powers = powers_between(jets[:, :-1], jets[:, 1:], size)
        nodes = (times[:-1, None] + size[:, None] * _NODES).ravel()
        # from shape (nodes, steps, 2) to one row per granule, in the order of time
        positions = product(_VALUES, powers.reshape(8, -1)).reshape(powers.shape).T.reshape(2, -1)
        velocity = product(_SLOPES, powers[..., 1]).T / size[:, None]
        if self.contact == 0:
            positions[0] += self._driven(nodes)[0]
        force, _ = force_rates(positions[0] - positions[1], np.zeros_like(nodes))
        return nodes, force, velocity.ravel(), (size[:, None] * _WEIGHTS).ravel()

    def _driven(self, times: FloatArray) -> FloatArray:
        """Displacement and velocity of a free granule under the shock, shape (2, times)."""
        return np.array([self.problem.free(time) for time in times.tolist()]).T


def _crossing(time: FloatArray, force: FloatArray, level: float) -> float:
    """Time at which the rising samples pass ``level``, by inverse interpolation."""
    last = len(force) - int(np.argmax(force[::-1] < level)) if np.any(force < level) else 0
    if last in (0, len(force)):
        return float(time[0])  # the force jumps across the level between two samples
    near = slice(max(last - _NEIGHBOURS, 0), last + _NEIGHBOURS)
    ordinates, abscissae = force[near], time[near] - time[last]
    # Lagrange polynomial of the time as a function of the force.
    values = [
        abscissa * np.prod([(level - other) / (own - other) for other in ordinates if other != own])
        for own, abscissa in zip(ordinates, abscissae, strict=True)
    ]
    return float(time[last] + np.sum(values))


def _maximum(time: FloatArray, values: FloatArray) -> float:
    """Maximum of a smooth function, from a polynomial through the samples around the largest one."""
    top = int(np.argmax(values))
    near = slice(max(top - _NEIGHBOURS, 0), top + _NEIGHBOURS + 1)
    if len(values[near]) < 2 * _NEIGHBOURS + 1:
        return float(values[top])
    origin, scale = time[top], time[near][-1] - time[near][0]
    fit = np.polynomial.Polynomial.fit((time[near] - origin) / scale, values[near], 2 * _NEIGHBOURS - 2)
    roots = [root.real for root in fit.deriv().roots() if abs(root.imag) < 1e-9 and abs(root.real) <= 1]
    return float(max((fit(root) for root in roots), default=values[top]))
