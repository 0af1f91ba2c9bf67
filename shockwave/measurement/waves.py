"""Waves in a run of the chain: when they have settled, and their properties at the contact that they pass."""

from __future__ import annotations

import math
from bisect import bisect
from itertools import accumulate, pairwise
from operator import neg

import numpy as np
from attrs import define, field, frozen

from shockwave.chain.solitary_wave import WIDTH, WaveLaw
from shockwave.measurement.measured_wave import MeasuredWave
from shockwave.measurement.peak_log import POWERS, Peak, PeakLog, Trail, force_rates, hermite_data
from shockwave.numerics import product
from shockwave.quadrature import FloatArray
from shockwave.simulation.march import Stretch, free_granules
from shockwave.simulation.problem import ChainProblem, contact_energies, power_force

# Number of contacts between the peaks whose differences give the rate of approach to the limit.
_STRIDE = 10
# Number of contacts that give the rate at which a bound decreases.
_STEP = 5
# Largest fraction of the contacts passed so far for which the decrease of a bound is extrapolated.
_AHEAD = 0.4
#: Number of contacts, from its head backwards, that a wave may still be passing; more if waves are wider than Hertz's.
PASSING = 10
# Time in which the tail of a wave of peak force 1 passes: 3.5 widths of 1.56 characteristic times.
_PASSED = 3.5 * 1.56
# Number of granules behind its peak over which a wave extends.
_BACK = 3
# Waves are followed down to this fraction of the threshold.
_FOLLOWED = 0.3
# A wave whose peak force exceeds that of a wave ahead by this factor will overtake it.
_TALLER = 1.001
# Number of contacts over which the approach to the limit must be uniform to be extrapolated, and the factor by which
# the extrapolation is enlarged; measured by docs/check_waves.py, as are the three numbers that follow.
_FAR = 40
_MARGIN = 1.5
# If the ratio of successive changes falls by more than this factor, the changes are about to reverse their sign.
_TURNING = 0.5
# Largest expected change of such a wave, over its change in the last stride.
_MOST_CHANGE = 30.0
# Distance from the limit over a change per stride that is hidden by noise, for each contact passed: of the slowest
# approach, as the power -7.5 of the number of contacts.
_HIDDEN = _MARGIN / (7.5 * _STRIDE)
# Slowest decrease of the deviation from the limit, per stride, that can be distinguished from noise.
_SLOWEST = 0.97
# Gauss nodes and weights of a step, as fractions of it; powers 0 to 7 and their derivatives at the nodes.
_LEGENDRE = np.polynomial.legendre.leggauss(8)
_NODES = (1 + _LEGENDRE[0]) / 2
_WEIGHTS = _LEGENDRE[1] / 2
_VALUES = np.vander(_NODES, 8, increasing=True)
_SLOPES = np.pad(_VALUES[:, :-1] * np.arange(1, 8), ((0, 0), (1, 0)))
# The same from the `hermite_data`.
_VALUES_BETWEEN, _SLOPES_BETWEEN = product(_VALUES, POWERS), product(_SLOPES, POWERS)
# Number of waves that are measured together, and the largest number of values for which `product` is faster.
_TOGETHER = 16
_FEW = 2048
# Number of samples on each side of a crossing or a maximum that its polynomial interpolates.
_NEIGHBOURS = 4
# Number of Newton steps to a maximum, and how far it may be from its step, over the size of the step.
_CORRECTIONS = 3
_EDGE = 0.1
# Number of contacts over which the speed is measured.
_SPEED_BASE = 4


# ---------------------------------------------------------------- limits


def passage_time(wave: WaveLaw, force: float) -> float:
    """Time in which the tail of a wave of this peak force passes a contact."""
    return _PASSED * (wave.width / WIDTH) * wave.time(force)


class Outlook:
    """The travelling waves at a time after the force has ended, and whether they have settled.

    Parameters
    ----------
    log : PeakLog
        All peaks up to ``now``.
    now : float
        Present time.
    threshold : float
        Least peak force of a wave, over that of the strongest wave.
    noise : float
        Error of a peak force due to step errors: smaller differences are not significant.

    Attributes
    ----------
    heads : list of Peak
        The foremost peak of each wave, front first. Weaker waves are followed, too: they may still grow, and their
        energy is taken into account.
    least : float
        Least peak force of a wave.
    """

    def __init__(self, log: PeakLog, now: float, threshold: float, noise: float = 0.0) -> None:
        self._log, self._now, self._noise = log, now, noise
        self.heads = log.heads(now, _FOLLOWED * threshold)
        self.strongest = max((head.force for head in self.heads), default=0.0)
        self.strongest = max(self.strongest, log.removed[2])
        self.least = threshold * self.strongest
        self._trails: dict[int, Trail] = {}
        self._length: dict[int, int] = {}

    def passed(self, wave: int) -> Trail:
        """The peaks of a wave from the foremost contact through which all of it has passed, if there is one."""
        if wave not in self._trails:
            trail = self._log.trail(self.heads[wave], 2 * _STRIDE + _STEP + int(PASSING * self._log.wave.spread))
            self._length[wave] = len(trail.rows)
            latest = self._now - passage_time(self._log.wave, self.heads[wave].force)
            first = bisect(trail.times, -latest, key=neg)
            self._trails[wave] = Trail(trail.rows[first:], trail.times[first:], trail.forces[first:])
        return self._trails[wave]

    def bound(self, wave: int) -> float:
        """Bound on the deviation of a wave from its limit, at the peak that has `passed`.

        It is infinite for a wave that will collide with another one, or is followed by one that may still become
        stronger.
        """
        force = self.heads[wave].force
        if any(_TALLER * head.force < force for head in self.heads[:wave]):
            return math.inf
        for behind in range(wave + 1, len(self.heads)):
            other, most = self.heads[behind].force, _TALLER * force
            if 2 * other > most and other * (1 + min(_doubt(self.passed(behind).forces, self._noise), 1.0)) > most:
                return math.inf
        return _doubt(self.passed(wave).forces, self._noise)

    def wait(self, wave: int, allowed: float) -> float:
        """Time that passes at least before the bound of a wave decreases to ``allowed``; 0 if it is not known."""
        trail = self.passed(wave)
        contacts = 2 * _STRIDE + _STEP + 1 - float(len(trail.rows))
        if not trail.rows:  # all of the wave passes a contact later
            contacts += passage_time(self._log.wave, 1.0) * self._log.wave.speed - self._length.get(wave, 0)
        if contacts <= 0:
            doubt, before = _doubt(trail.forces, self._noise), _doubt(trail.forces[_STEP:], self._noise)
            if not allowed < doubt < before < math.inf:
                return 0.0
            contacts = _STEP * math.log(doubt / allowed) / math.log(before / doubt)
            contacts = min(contacts, max(_STRIDE, _AHEAD * self.heads[wave].contact))
        return contacts * self._log.wave.time(self.heads[wave].force) / self._log.wave.speed

    def is_complete(self, x: FloatArray, v: FloatArray) -> bool:
        """Whether nothing behind these waves can form another wave; ``x`` and ``v`` are the present state."""
        weak = (wave for wave, head in enumerate(self.heads) if head.force < self.least)
        if any(self.least <= self.heads[wave].force * (1 + self.bound(wave)) for wave in weak):
            return False
        rearmost = self.heads[-1].contact if self.heads else self._log.removed[0]
        return _nothing_to_come(x, v, rearmost, self.least, self._log.wave)


def _doubt(forces: list[float], noise: float) -> float:
    """Bound on the relative deviation of a wave's peak force from its limit, from its last peak forces.

    Far from other waves the deviation decreases geometrically, so that it follows from the variation of the peak force
    over the last contacts and over the preceding ones. The variation must also decrease within the last contacts, to
    exclude waves whose peak force is constant only for a while.
    """
    if len(forces) <= 2 * _STRIDE:
        return math.inf
    half = _STRIDE // 2
    recent = _span(forces[: half + 1])
    older = _span(forces[half : _STRIDE + 1])
    last = _span(forces[: _STRIDE + 1])
    previous = _span(forces[_STRIDE : 2 * _STRIDE + 1])
    if last <= noise:
        return last / forces[0]
    ratio = min(max(_ratio(last, previous), _ratio(recent, older) ** 2), _SLOWEST)
    return last * max(ratio / (1 - ratio), 0.1) / forces[0]


def distance_from_limit(peak: Peak, log: PeakLog) -> float:
    """Estimate of the relative distance from its limit of a wave that is measured at ``peak``.

    `_doubt` decides when a wave is measured. Here the deviation from the limit is a power of the number of contacts,
    since the approach is slower than geometric where waves separate slowly; the differences over the last two strides
    give the exponent. If the peaks do not change uniformly, the wave has collided with others or its change reverses:
    it may change again as much as on the last third of its way.
    """
    forces = log.trail(peak, max(_FAR, peak.contact // 3)).forces
    whole = _span(forces) / peak.force
    if len(forces) <= 2 * _STRIDE:
        return whole
    near = _span(forces[: _STRIDE + 1]) / peak.force
    if near * peak.force <= log.tolerance:
        return near * max(3.0, _HIDDEN * peak.contact)
    last, before = (new - old for new, old in pairwise(forces[: 2 * _STRIDE + 1 : _STRIDE]))
    halves = [new - old for new, old in pairwise(forces[: 2 * _STRIDE : _STRIDE // 2])]
    changes = (*halves, before, forces[0] - forces[2], forces[2 * _STRIDE] - forces[:_FAR][-1])
    turning = halves[0] * halves[2] < _TURNING * halves[1] ** 2
    if any(change * last < 0 for change in changes) or turning or abs(last) >= abs(before):
        return min(whole, _MOST_CHANGE * near)
    exponent = math.log(before / last) / math.log((peak.contact - 0.5 * _STRIDE) / (peak.contact - 1.5 * _STRIDE)) - 1
    return _MARGIN * abs(last) * peak.contact / (_STRIDE * max(exponent, 1.0)) / peak.force


def _span(values: list[float]) -> float:
    return max(values) - min(values)


def _ratio(later: float, earlier: float) -> float:
    return later / earlier if earlier > 0 else math.inf


def _nothing_to_come(x: FloatArray, v: FloatArray, rearmost: int, least_force: float, wave: WaveLaw) -> bool:
    """Whether the energy behind the rearmost wave is too small to form a wave of ``least_force``."""
    first, last = free_granules(x, v), max(rearmost - int(_BACK * wave.spread), 0)
    if first >= last:
        return True
    energy = 0.5 * v[first:last] ** 2 + contact_energies(x, wave.exponent)[first:last]
    # The energy of all granules counts, because distant granules may still collide.
    return float(energy.sum()) < wave.energy * math.pow(least_force, wave.of_energy)


# ---------------------------------------------------------------- properties


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
        known = 1 if self._times else 0
        states = np.array((stretch.x[known:, max(first, 0) : last], stretch.v[known:, max(first, 0) : last]))
        if states.shape[2] < 4:
            states = states[:, :, np.clip(np.arange(first, last), 0, stretch.x.shape[1] - 1) - max(first, 0)]
        states[0] -= origin
        self._times.append(stretch.times[known:])
        self._states.append(states)

    def transit(self, peak: Peak, log: PeakLog, doubt: float) -> Transit:
        """The wave with the maximum ``peak``; ``doubt`` is the bound on its distance from the limit."""
        reach = 2 * passage_time(log.wave, peak.force)
        begin = max(log.peak(peak.previous).time if peak.previous >= 0 else 0.0, peak.time - reach)
        end = min(log.following(peak), peak.time + reach)
        times, states = np.concatenate(self._times), np.concatenate(self._states, axis=1)
        used = slice(max(int(times.searchsorted(begin, "right")) - 1, 0), int(times.searchsorted(end)) + 1)
        arrivals = log.trail(peak, _SPEED_BASE).times
        passed = len(arrivals) - 1
        speed = passed / (peak.time - arrivals[-1]) if passed else None
        return Transit(peak, begin, end, times[used], states[:, used], speed, doubt)


def measured(transits: list[Transit], problem: ChainProblem) -> tuple[MeasuredWave, ...]:
    """Measure waves, in scaled units."""
    waves: list[MeasuredWave] = []
    for first in range(0, len(transits), _TOGETHER):
        together = transits[first : first + _TOGETHER]
        samples = _samples(together, problem)
        step = 0
        for transit in together:
            steps = slice(step, step + len(transit.times) - 1)
            waves.append(_measured(transit, *(part[..., steps, :] for part in samples)))
            step = steps.stop
    return tuple(waves)


def _samples(transits: list[Transit], problem: ChainProblem) -> tuple[FloatArray, ...]:
    """Motion at the Gauss nodes of the steps of all waves, in the order of the waves.

    Times, forces, velocities of the second granule of the contact, and weights of sums over the time, each of shape
    (steps, nodes); and the position of that granule, as in `hermite_data`, shape (steps, 8).
    """
    ends = [0, *accumulate(len(transit.times) for transit in transits)]
    times = np.concatenate([transit.times for transit in transits])
    x, v = np.concatenate([transit.states for transit in transits], axis=1)
    forces, rates = force_rates(x[:, :-1] - x[:, 1:], v[:, :-1] - v[:, 1:], problem.exponent)
    jets = np.array((x[:, 1:3], v[:, 1:3], forces[:, :-1] - forces[:, 1:], rates[:, :-1] - rates[:, 1:]))
    within = np.ones(len(times) - 1, bool)
    within[[end - 1 for end in ends[1:-1]]] = False  # no step leads from one wave to the next
    begin = within.nonzero()[0]
    driven = np.zeros(len(times), bool)
    for transit, first, last in zip(transits, ends[:-1], ends[1:], strict=True):
        if transit.peak.contact == 0:  # only the motion relative to the free-particle displacement is smooth
            driven[first:last] = True
            jets[:2, first:last, 0] -= _free(problem, transit.times)
    size = (times[begin + 1] - times[begin])[:, None]
    known = hermite_data(jets[:, begin], jets[:, begin + 1], size[:, 0])
    nodes = times[begin, None] + size * _NODES
    positions = _between(_VALUES_BETWEEN, known)
    if driven.any():
        steps = driven[begin]
        positions[:, steps, 0] += _free(problem, nodes[steps].T.ravel())[0].reshape(len(_NODES), -1)
    force = np.maximum(positions[..., 0] - positions[..., 1], 0.0).T
    velocity = _between(_SLOPES_BETWEEN, known[..., 1]).T / size
    return nodes, power_force(force, problem.exponent), velocity, size * _WEIGHTS, known[..., 1].T


def _between(weights: FloatArray, known: FloatArray) -> FloatArray:
    """Weighted sums of the rows of ``known``; of many columns with less memory than `product`, in the same order."""
    if known.size < _FEW:
        return product(weights, known.reshape(8, -1)).reshape(known.shape)
    sums = np.zeros(known.shape)
    for column, row in zip(weights.T, known, strict=True):
        sums += np.multiply.outer(column, row)
    return sums


def _free(problem: ChainProblem, times: FloatArray) -> FloatArray:
    """Displacement and velocity of a free granule under the shock, shape (2, times)."""
    return np.array([problem.free(time) for time in times.tolist()]).T


def _measured(
    transit: Transit, time: FloatArray, force: FloatArray, velocity: FloatArray, weight: FloatArray, known: FloatArray
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
    rise = _crossing(time[begin : top + 1], force[begin : top + 1], peak.force / 2)
    fall = _crossing(time[top : end + 1][::-1], force[top : end + 1][::-1], peak.force / 2)
    fastest = begin + int(velocity[inside].argmax())
    step, node = divmod(fastest, len(_NODES))
    size = transit.times.item(step + 1) - transit.times.item(step)
    return MeasuredWave(
        peak_force=peak.force,
        momentum=float(pushed.sum()),
        energy=float((pushed * velocity[inside]).sum()),
        speed=transit.speed,
        width=fall - rise,
        granule_velocity=max(velocity.item(fastest), _fastest(known[step], _NODES.item(node)) / size),
        contact=peak.contact,
        arrival_time=peak.time,
        error_estimate=transit.doubt,
        foot=max(force.item(begin), force.item(end)) / peak.force,
    )


def _crossing(time: FloatArray, force: FloatArray, level: float) -> float:
    """Time at which the rising samples pass ``level``, by inverse interpolation."""
    below = (force < level).nonzero()[0]
    last = below.item(-1) + 1 if len(below) else 0
    if last in (0, len(force)):
        return float(time[0])  # the force jumps across the level between two samples
    near = slice(max(last - _NEIGHBOURS, 0), last + _NEIGHBOURS)
    ordinates, abscissae = force[near].tolist(), (time[near] - time[last]).tolist()
    # Lagrange polynomial of the time as a function of the force.
    values = [
        abscissa * math.prod([(level - other) / (own - other) for other in ordinates if other != own])
        for own, abscissa in zip(ordinates, abscissae, strict=True)
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
