"""One run of the whole chain, from the shock until all waves have been read."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from attrs import define, field

from shockwave.measurement.peak_log import Peak, PeakLog, characteristic_time
from shockwave.measurement.result import MeasuredWave
from shockwave.measurement.waves import Probe, distance_from_limit, settling
from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.march import Span, Stretch, free_granules, march
from shockwave.simulation.problem import ChainProblem, chain_energy

#: A granule is ejected when it flies backwards faster than this share of the granules in the primary.
EJECTED = 1e-3
# How often, in units of time, the waves are judged; and how many steps are looked at together, at most.
_INTERVAL = 4.0
_MOST_SPANS = 64
# A probe is set this far ahead of a wave's last peak, so that the whole wave passes it.
_AHEAD = 4
# The tail of a wave has passed after this many of its widths; 1.56 is the width at peak force 1.
_PASSED = 3.5 * 1.56
# Contacts that the front may pass before waves other than the primary are read as they are: this many, and so
# many for each unit of time that the force lasts.
_BUDGET = 150.0
_BUDGET_RATE = 6.0
# Peaks scatter by so many times the error allowed in a step.
_NOISE = 30.0
# Free ends are felt this many granules away.
_REACH = 8
# Steps after the shock, and for each granule, that the granules of a finite chain are given to fly apart.
_PARTING = 500
_PARTING_RATE = 20
# What may yet become of the momentum of rebounding granules (measured, docs/check_waves.py): this often what it changed
# over the last share of the time after the shock, this often what other granules carry backwards, and this share of
# what is left of motion behind the waves, for a granule may rebound late from the next.
_GOING_ON = 2.0
_LATE = 1 / 3
_JOINING = 4.0
_TURNING = 3e-3
# Waves are followed to a free end as far away as this from where they were read.
_FARTHEST = 2000


@define
class _Reading:
    """A wave at its limit: its last peak then, the probe set before it, the bound on its distance from the limit."""

    head: Peak
    probe: Probe
    doubt: float
    passed: bool = False
    wave: MeasuredWave | None = None

    def observe(self, stretch: Stretch, log: PeakLog) -> None:
        """Take note, and read off the wave once it has passed the probe."""
        if self.passed:
            return
        self.probe.observe(stretch)
        peak = log.arrival(self.head, self.probe.contact)
        if peak is None:  # it should have come; waiting for ever would hang
            self.passed = stretch.end - self.head.time > 10 * _AHEAD * characteristic_time(self.head.force)
        elif stretch.end - peak.time > _PASSED * characteristic_time(peak.force):
            self.passed = True
            # it may be on a course to meet others
            known = math.isfinite(self.doubt)
            self.wave = self.probe.wave(peak, log, distance_from_limit(peak, log.tolerance) if known else math.inf)


@define(eq=False)
class ChainRun:
    """A run and its result, in scaled units.

    Attributes
    ----------
    wave_threshold : float
        Weakest wave that counts, over the primary.
    primary_doubt, later_doubt : float
        Bounds asked of the distance of peaks from their limits, relative to each; weak later waves may have more.
    most_contacts : int
        Length of the longest chain.
    waves : tuple of MeasuredWave
        In the order in which they pass; their ``error_estimate`` bounds how far the peak is from its limit along the
        chain (where the chain ends its answer is the peak itself, with the error allowed in a step).
    recoils : tuple of float
        Velocities of the rebounding granules, first granule first.
    unfinished_recoil : float
        Momentum that others may still add to theirs, or take from it.
    spalls : tuple of float or None
        Velocities of the granules that fly off the free end faster than `EJECTED` times the granules in the waves, last
        granule first, as far as they have come free by the end of the run; None where the waves were not followed
        there.
    momentum, energy : float
        Of the chain when the waves are read.
    work : float
        Its energy when the force ended: what is lost since then, the integration has lost.
    settled : bool
        False when the chain's limit came first.
    unfollowed_force : float
        Bound on the contact forces of collisions in a finite chain after the end of the run.
    """

    problem: ChainProblem
    integrator: Integrator
    wave_threshold: float
    primary_doubt: float
    later_doubt: float
    most_contacts: int
    log: PeakLog = field(init=False)
    waves: tuple[MeasuredWave, ...] = ()
    recoils: tuple[float, ...] = ()
    unfinished_recoil: float = 0.0
    spalls: tuple[float, ...] | None = None
    momentum: float = 0.0
    energy: float = 0.0
    work: float = 0.0
    settled: bool = True
    unfollowed_force: float = 0.0
    steps: int = 0
    _driven_steps: int = 0
    _free_end: Probe | None = None
    _readings: list[_Reading] = field(factory=list)
    _judged: float = 0.0
    _recoiled: list[tuple[float, float]] = field(factory=list)
    _all_known: bool = False

    def __attrs_post_init__(self) -> None:
        self.log = PeakLog(self.integrator.tolerance)
        if self.problem.granules is not None:
            last = self.problem.granules - 2
            self._free_end = Probe(max(last - _REACH, last // 2), self.problem)

    def finished(self) -> ChainRun:
        """March until the waves are known, each passing a probe, and on until those of a finite chain have left it.

        Raises
        ------
        NumericalError
            When the integrator fails.
        """
        duration = self.problem.duration
        stretches = _stretches(march(self.problem, self.integrator), duration)
        for stretch in stretches:
            self._observe(stretch)
            if self._has_seen_all(stretch):
                break
        # Rounding grows as weak waves meet: all but what leaves the free end is read at once.
        x, v = stretch.x[-1], stretch.v[-1]
        self.waves = self._waves()
        self.momentum = float(np.sum(v))
        self.energy = chain_energy(x, v)
        ejected = EJECTED * max((wave.granule_velocity for wave in self.waves), default=0.0)
        self.recoils, loose = _recoils(v, ejected)
        late = [sum(self.recoils)]
        late += [recoil for time, recoil in self._recoiled if time > stretch.end - _LATE * (stretch.end - duration)]
        rear = min((reading.head.contact for reading in self._readings), default=0)
        stirred = float(np.abs(v[free_granules(x, v) : rear]).sum())
        self.unfinished_recoil = _GOING_ON * float(np.ptp(late)) + _JOINING * loose + _TURNING * stirred
        granules = self.problem.granules
        if granules is not None and granules - self._front <= _FARTHEST:
            while not self._is_spent(stretch):
                stretch = next(stretches)
                self.steps += len(stretch.spans)
                self.log.observe(stretch)
            x, v = stretch.x[-1], stretch.v[-1]
            flown = v[::-1][: _flown(x, v)]
            self.spalls = tuple(flown[flown > ejected].tolist())
        return self

    @property
    def reached_end(self) -> bool:
        """Whether the front came so near to the free end that it may feel it before the waves are known."""
        granules = self.problem.granules
        return granules is not None and self._front >= granules - 1 - _REACH

    @property
    def _front(self) -> int:
        return max(self.log.peaks, default=0)

    def _observe(self, stretch: Stretch) -> None:
        self.steps += len(stretch.spans)
        self.log.observe(stretch)
        for reading in self._readings:
            reading.observe(stretch, self.log)
        if self._free_end is not None:
            self._free_end.observe(stretch)
        if stretch.end >= self.problem.duration:
            ejected = EJECTED * self.log.strongest ** (5 / 6)  # about the velocity of granules in the strongest wave
            self._recoiled.append((stretch.end, sum(_recoils(stretch.v[-1], ejected)[0])))
        if stretch.end == self.problem.duration:
            self.work = chain_energy(stretch.x[-1], stretch.v[-1])
            self._driven_steps = self.steps

    def _has_seen_all(self, stretch: Stretch) -> bool:
        """Whether the waves are known, now that ``stretch`` has been taken in."""
        if stretch.end < self.problem.duration:
            return False
        if self.reached_end:
            return self._is_spent(stretch)
        if self._all_known:
            return all(reading.passed for reading in self._readings)
        if stretch.end - self._judged >= _INTERVAL:
            self._judged = stretch.end
            self._all_known = self._judge(stretch)
        return False

    def _judge(self, stretch: Stretch) -> bool:
        """Set a probe before each wave that is known now; True once every wave has one."""
        x, v = stretch.x[-1], stretch.v[-1]
        noise = _NOISE * self.integrator.tolerance
        waves, complete = settling(self.log, stretch.end, x, v, self.wave_threshold, noise)
        if not waves:
            return False
        strongest = max(head.force for head, _ in waves)
        front = waves[0][0].contact
        budget = _BUDGET + _BUDGET_RATE * self.problem.duration
        # In order: behind a wave that has not settled, a peak may linger at a value that is not its last.
        for head, doubt in waves[len(self._readings) :]:
            # The primary is worth any length of chain; the others get what it needed, or a fair share.
            most, allowed = float(self.most_contacts), self.primary_doubt
            if head.force < strongest:
                # weak waves are less sure, as rounding and step errors weigh more
                most, allowed = budget, self.later_doubt * math.sqrt(strongest / head.force)
            if front <= most and doubt > allowed:
                return False
            self._readings.append(_Reading(head, Probe(head.contact + _AHEAD, self.problem), doubt))
        self.settled = complete or front <= budget
        return complete or not self.settled

    def _is_spent(self, stretch: Stretch) -> bool:
        """Whether nothing more can leave a finite chain: its granules fly apart, or they had steps enough to."""
        x, v = stretch.x[-1], stretch.v[-1]
        first, last = free_granules(x, v), len(x) - _flown(x, v)
        self.unfollowed_force = 0.0
        if first >= last:
            return True
        # what is left of their motion against one another
        energy = chain_energy(x[first:last], v[first:last] - v[first:last].mean())
        if energy < 0.5 * (EJECTED * float(np.abs(v).max())) ** 2:
            return True
        self.unfollowed_force = (2.5 * energy) ** 0.6  # were all of it in one contact
        return self.steps - self._driven_steps > _PARTING + _PARTING_RATE * (self.problem.granules or 0)

    def _waves(self) -> tuple[MeasuredWave, ...]:
        """The waves that have been read."""
        end = self._free_end
        if end is None or not self.reached_end:
            return tuple(reading.wave for reading in self._readings if reading.wave is not None)
        peaks = self.log.peaks.get(end.contact, [])
        least = self.wave_threshold * max((peak.force for peak in peaks), default=0.0)
        # The peak is the answer itself, and a slow force may hold both runs to their longest step: alike, they do not
        # show by how much they err.
        doubt = self.integrator.tolerance
        return tuple(end.wave(peak, self.log, doubt) for peak in peaks if peak.force >= least)


def _stretches(spans: Iterator[Span], duration: float) -> Iterator[Stretch]:
    """Spans that are looked at together; none goes on across the end of the force."""
    together: list[Span] = []
    for span in spans:
        together.append(span)
        long = span.end - together[0].begin >= _INTERVAL
        if long or span.end == duration or len(together) == _MOST_SPANS:
            yield Stretch.of(*together)
            together = []


def _recoils(v: FloatArray, ejected: float) -> tuple[tuple[float, ...], float]:
    """Velocities of the rebounding granules, and the momentum that others may add to theirs or take from it.

    They reach from the loaded end to the last granule that was ejected, and those that follow it backwards: further on,
    granules that drift backwards are stirred by waves that pass.
    """
    last = max(np.flatnonzero(v < -ejected), default=0)
    forward = np.flatnonzero(v[last:] >= 0)
    end = last + int(forward[0]) if len(forward) else len(v)
    region, beyond = v[:end], v[end:]
    loose = float(region[region > 0].sum() - beyond[beyond < 0].sum())
    return tuple(region[region < 0].tolist()), loose


def _flown(x: FloatArray, v: FloatArray) -> int:
    """How many granules have flown off the free end: out of contact, and no two of them closing in."""
    return free_granules(-x[::-1], -v[::-1])
