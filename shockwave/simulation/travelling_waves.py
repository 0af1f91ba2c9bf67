"""Travelling waves in a run of the chain, and when they have settled."""

from __future__ import annotations

import math
from bisect import bisect
from itertools import pairwise
from operator import neg

from shockwave.base.numerics import FloatArray
from shockwave.engine.peak_log import Peak, PeakLog, Trail
from shockwave.engine.scaled_problem import contact_energies
from shockwave.engine.stretch import free_granules
from shockwave.scene.solitary_wave import WIDTH, WaveLaw

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
# the extrapolation is enlarged; checked by research/check/check_estimates.py, as are the three numbers that follow.
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
        Peak force of the weakest wave that counts: ``threshold`` times that of the strongest wave.
    """

    def __init__(self, log: PeakLog, now: float, threshold: float, noise: float = 0.0) -> None:
        self._log, self._now, self._noise = log, now, noise
        self.heads = log.heads(now, _FOLLOWED * threshold)
        self.strongest = max((head.force for head in self.heads), default=0.0)
        self.strongest = max(self.strongest, log.removed[2])
        self.least = threshold * self.strongest
        self._trails: dict[int, Trail] = {}
        self._length: dict[int, int] = {}
        self._bounds: dict[int, float] = {}

    def settled_trail(self, wave: int) -> Trail:
        """The peaks of a wave from the foremost contact through which all of it has passed, if there is one."""
        if wave not in self._trails:
            trail = self._log.trail(self.heads[wave], 2 * _STRIDE + _STEP + int(PASSING * self._log.wave.spread))
            self._length[wave] = len(trail.rows)
            latest = self._now - passage_time(self._log.wave, self.heads[wave].force)
            first = bisect(trail.times, -latest, key=neg)
            self._trails[wave] = Trail(trail.rows[first:], trail.times[first:], trail.forces[first:])
        return self._trails[wave]

    def bound(self, wave: int) -> float:
        """Bound on the relative deviation of a wave from its limit, at the first peak of `settled_trail`.

        It is infinite for a wave that will collide with another one, or is followed by one that may still become
        stronger.
        """
        if wave not in self._bounds:
            self._bounds[wave] = self._bound(wave)
        return self._bounds[wave]

    def _bound(self, wave: int) -> float:
        force = self.heads[wave].force
        if any(_TALLER * head.force < force for head in self.heads[:wave]):
            return math.inf
        for behind in range(wave + 1, len(self.heads)):
            other, most = self.heads[behind].force, _TALLER * force
            if (
                2 * other > most
                and other * (1 + min(_doubt(self.settled_trail(behind).forces, self._noise), 1.0)) > most
            ):
                return math.inf
        return _doubt(self.settled_trail(wave).forces, self._noise)

    def wait(self, wave: int, allowed: float) -> float:
        """Least time until the bound of a wave decreases to ``allowed``; 0 if it is not known."""
        trail = self.settled_trail(wave)
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
        return _is_complete(x, v, rearmost, self.least, self._log.wave)


def _doubt(forces: list[float], noise: float) -> float:
    """Bound on the relative deviation of a wave's peak force from its limit, from its last peak forces.

    Far from other waves the deviation decreases geometrically, so that it follows from the variation of the peak force
    over the last contacts and over the preceding ones. The variation must also decrease within the last contacts, to
    exclude waves whose peak force is constant only for a while.
    """
    if len(forces) <= 2 * _STRIDE:
        return math.inf
    half = _STRIDE // 2
    recent, older = forces[: half + 1], forces[half : _STRIDE + 1]
    high, higher, low, lower = max(recent), max(older), min(recent), min(older)
    last = max(high, higher) - min(low, lower)
    if last <= noise:
        return last / forces[0]
    previous = _span(forces[_STRIDE : 2 * _STRIDE + 1])
    ratio = min(max(_ratio(last, previous), _ratio(high - low, higher - lower) ** 2), _SLOWEST)
    return last * max(ratio / (1 - ratio), 0.1) / forces[0]


def distance_from_limit(peak: Peak, log: PeakLog) -> float:
    """Estimate of the relative distance from its limit of a wave that is measured at ``peak``.

    `_doubt` decides when a wave is measured. Here the deviation from the limit is a power of the number of contacts,
    since the approach is slower than geometric where waves separate slowly; the differences over the last two strides
    give the exponent. If the peaks do not change uniformly, the wave has collided with others or its change reverses:
    it may change again as much as on the last third of its way.
    """
    forces = log.trail(peak, max(_FAR, peak.contact // 3)).forces
    total = _span(forces) / peak.force
    if len(forces) <= 2 * _STRIDE:
        return total
    near = _span(forces[: _STRIDE + 1]) / peak.force
    if near * peak.force <= log.tolerance:
        return near * max(3.0, _HIDDEN * peak.contact)
    last, before = (new - old for new, old in pairwise(forces[: 2 * _STRIDE + 1 : _STRIDE]))
    halves = [new - old for new, old in pairwise(forces[: 2 * _STRIDE : _STRIDE // 2])]
    changes = (*halves, before, forces[0] - forces[2], forces[2 * _STRIDE] - forces[:_FAR][-1])
    turning = halves[0] * halves[2] < _TURNING * halves[1] ** 2
    if any(change * last < 0 for change in changes) or turning or abs(last) >= abs(before):
        return min(total, _MOST_CHANGE * near)
    exponent = math.log(before / last) / math.log((peak.contact - 0.5 * _STRIDE) / (peak.contact - 1.5 * _STRIDE)) - 1
    return _MARGIN * abs(last) * peak.contact / (_STRIDE * max(exponent, 1.0)) / peak.force


def _span(values: list[float]) -> float:
    return max(values) - min(values)


def _ratio(later: float, earlier: float) -> float:
    return later / earlier if earlier > 0 else math.inf


def _is_complete(x: FloatArray, v: FloatArray, rearmost: int, least_force: float, wave: WaveLaw) -> bool:
    """Whether the energy behind the rearmost wave is too small to form a wave of ``least_force``."""
    first, last = free_granules(x, v), max(rearmost - int(_BACK * wave.spread), 0)
    if first >= last:
        return True
    energy = 0.5 * v[first:last] ** 2 + contact_energies(x[first : last + 1], wave.exponent)
    # The energy of all granules counts, because distant granules may still collide.
    return float(energy.sum()) < wave.energy * math.pow(least_force, wave.of_energy)
