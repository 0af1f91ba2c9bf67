"""Waves in a run of the chain: when they are at their limits, and their figures from the contact that they pass."""

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

# Contacts between the peaks whose differences show how fast a wave nears its limit.
_STRIDE = 10
# A wave and the force behind it reach this many granules back.
_BACK = 3
# Waves are followed down to this share of the threshold.
_FOLLOWED = 0.3
# A wave this much taller than one before it will overtake it.
_TALLER = 1.001
# Contacts over which the approach of a wave that has been read must look the same, and the margin of its extrapolation
# (measured, docs/check_waves.py).
_FAR = 40
_MARGIN = 1.5
# Where the ratio of successive changes falls by more than to this share, they are about to change their sign; how often
# its change over a stride may follow then at most.
_TURNING = 0.5
_COURSE = 30.0
# What may follow a change over a stride that noise hides, for each contact passed: of the slowest approach seen, whose
# exponent is 7.5.
_HIDDEN = _MARGIN / (7.5 * _STRIDE)
# Slower approaches than this, per stride, cannot be distinguished from noise.
_SLOWEST = 0.97
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


# ---------------------------------------------------------------- limits


def settling(
    log: PeakLog, now: float, x: FloatArray, v: FloatArray, threshold: float, noise: float = 0.0
) -> tuple[list[tuple[Peak, float]], bool]:
    """Judge the state of the chain after the force has ended.

    Parameters
    ----------
    log : PeakLog
        All peaks up to ``now``.
    x, v : FloatArray
        Positions and velocities at ``now``, shape (granules,).
    threshold : float
        Peak force, over the strongest wave's, above which a wave counts.
    noise : float
        Error of a peak force due to step errors: differences below it are not significant.

    Returns
    -------
    list of (Peak, float)
        The foremost peak of each wave, front first, and a bound on how far it may still be from its limit, relatively;
        infinite for a wave with a collision ahead of it or behind it, or followed by one that may yet outgrow it.
    bool
        Whether nothing behind them can become another wave.
    """
    # Weaker waves are followed too: one may still grow, and its energy is accounted for.
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
    """Bound on the relative distance of a wave's peak from its limit, from its last peaks.

    Far from the others a wave nears its limit geometrically: what is left follows from how much the peak varied
    over the last contacts and over those before. It must also slow down within the last ones, lest it lingers.
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


def distance_from_limit(peak: Peak, noise: float) -> float:
    """Estimate of the relative distance of a wave that is read at ``peak`` from its limit.

    `_doubt` decides when to read a wave. Here the approach counts as a power of the contact's number, for it is slower
    than geometric where waves part slowly: the differences over the last two strides give its exponent. Where the peaks
    do not fall into line, the wave has met others or is about to turn: what it changed on the last third of its way may
    follow.
    """
    forces = np.array([passed.force for passed in history(peak, max(_FAR, peak.contact // 3))])
    whole = float(np.ptp(forces)) / peak.force
    if len(forces) <= 2 * _STRIDE:
        return whole
    near = float(np.ptp(forces[: _STRIDE + 1])) / peak.force
    if near * peak.force <= noise:
        return near * max(3.0, _HIDDEN * peak.contact)
    last, before = -np.diff(forces[: 2 * _STRIDE + 1 : _STRIDE])
    halves = -np.diff(forces[: 2 * _STRIDE : _STRIDE // 2])
    onwards = np.append(halves, (before, forces[0] - forces[2], forces[2 * _STRIDE] - forces[:_FAR][-1])) * last >= 0
    turning = halves[0] * halves[2] < _TURNING * halves[1] ** 2
    if not onwards.all() or turning or abs(last) >= abs(before):
        return min(whole, _COURSE * near)
    ways = peak.contact - _STRIDE * np.array([0.5, 1.5])
    exponent = math.log(before / last) / math.log(float(ways[0] / ways[1])) - 1
    return _MARGIN * abs(float(last)) * peak.contact / (_STRIDE * max(exponent, 1.0)) / peak.force


def _ratio(later: float, earlier: float) -> float:
    return later / earlier if earlier > 0 else math.inf


def _nothing_to_come(x: FloatArray, v: FloatArray, rearmost: int, least_force: float) -> bool:
    """Whether what lies behind the rearmost wave is too weak to form a wave of ``least_force``."""
    first, last = free_granules(x, v), max(rearmost - _BACK, 0)
    if first >= last:
        return True
    energy = 0.5 * v[first:last] ** 2 + contact_energies(x)[first:last]
    # All of it counts: granules far apart may still drive one another together.
    return float(energy.sum()) < ENERGY * math.pow(least_force, 5 / 3)


# ---------------------------------------------------------------- figures


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
