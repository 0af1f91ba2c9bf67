"""A run of the whole chain, from the beginning of the shock until all waves have been measured."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from attrs import define, field

from shockwave.measurement.peak_log import Peak, PeakLog, characteristic_time
from shockwave.measurement.result import MeasuredWave
from shockwave.measurement.waves import Probe, distance_from_limit, settling
from shockwave.progress import progressed
from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.march import Span, Stretch, free_granules, march
from shockwave.simulation.problem import ChainProblem, chain_energy

#: Least backward velocity of an ejected granule, over the peak velocity of the granules in the leading wave.
EJECTED = 1e-3
# Interval at which the waves are examined, in characteristic times.
_INTERVAL = 4.0
# Largest number of steps that are analysed together.
_MOST_SPANS = 64
# Distance in contacts from the last peak of a wave to the probe ahead of it, so that the whole wave passes the probe.
_AHEAD = 4
# Time in which the tail of a wave of peak force 1 passes: 3.5 widths of 1.56 characteristic times.
_PASSED = 3.5 * 1.56
# Contacts that the front may pass before waves other than the leading one are measured even if they have not settled:
# a constant, and a number for each characteristic time of the duration of the shock.
_BUDGET = 150.0
_BUDGET_RATE = 6.0
# Scatter of peak forces over the error tolerance of a step.
_NOISE = 30.0
# Distance in granules at which a free end affects a wave.
_REACH = 8
# Largest number of steps after the shock in which the granules of a finite chain can separate: a constant, and a number
# for each granule.
_PARTING = 500
_PARTING_RATE = 20
# Number of granules of a short chain, and the smallest relative velocity in it that is followed to a collision, over
# the largest velocity: slower granules would travel so far that rounding affects their overlaps.
_SHORT = 50
_SLOWEST = 1e-6
# Contributions to the error of the rebound momentum, measured by docs/check_waves.py: its change over the last third of
# the time after the shock, the momentum that other granules carry backwards, and the momentum of the granules behind
# the waves, some of which rebound late.
_LATE = 1 / 3
_CHANGE_SHARE = 2.0
_BACKWARD_SHARE = 4.0
_REMAINING_SHARE = 3e-3
# Largest distance in granules to a free end up to which waves are followed after they have been measured.
_FARTHEST = 2000


@define
class _Reading:
    """A wave that has settled: its last peak at that time, the probe ahead of it, and the bound on its deviation.

    ``first`` is the wave at the front. It meets no other, so that its deviation decreases geometrically.
    """

    head: Peak
    probe: Probe
    doubt: float
    first: bool
    passed: bool = False
    wave: MeasuredWave | None = None

    def observe(self, stretch: Stretch, log: PeakLog) -> None:
        """Record the stretch, and measure the wave once it has passed the probe."""
        if self.passed:
            return
        self.probe.observe(stretch)
        peak = log.arrival(self.head, self.probe.contact)
        if peak is None:  # stop waiting for a peak that should have arrived long ago
            self.passed = stretch.end - self.head.time > 10 * _AHEAD * characteristic_time(self.head.force)
        elif stretch.end - peak.time > _PASSED * characteristic_time(peak.force):
            self.passed = True
            # without a bound the wave may still collide with others
            distance = self.doubt
            if math.isfinite(distance) and not self.first:
                distance = distance_from_limit(peak, log.tolerance)
            self.wave = self.probe.wave(peak, log, distance)


@define(eq=False)
class ChainRun:
    """A run and its results, in scaled units.

    Attributes
    ----------
    wave_threshold : float
        Least peak force of a wave, over that of the leading wave.
    primary_doubt, later_doubt : float
        Allowed relative deviation of a peak force from its limit, for the leading wave and for later waves; that of
        weak later waves may be larger.
    most_contacts : int
        Largest number of contacts that the front passes.
    label : str
        Name of the run in reports of progress.
    expected_end : float or None
        Time at which the run is expected to end, for the estimate of the time left.
    waves : tuple of MeasuredWave
        Waves in the order of their arrival. Their ``error_estimate`` bounds the relative deviation of the peak force
        from its limit along the chain. At the end of a finite chain the peak itself is the result, and the estimate is
        the error tolerance of a step.
    unread : int
        Number of settled waves that could not be measured, since their peak was not found at the probe.
    recoils : tuple of float
        Velocities of the rebounding granules, first granule first.
    unfinished_recoil : float
        Bound on the momentum that the rebounding granules may still gain or lose.
    spalls : tuple of float or None
        Velocities of the granules that leave the free end faster than `EJECTED` times the granules in the waves, last
        granule first; None if the waves were not followed to the free end.
    momentum, energy : float
        Momentum and energy of the chain when the waves are measured.
    work : float
        Energy of the chain at the end of the force; later changes are errors of the integration.
    settled : bool
        False if the allowed number of contacts was passed before all waves had settled.
    unfollowed_force : float
        Bound on the contact forces of collisions in a finite chain after the end of the run.
    steps, end : int, float
        Number of steps, and the time at which the run ended.
    """

    problem: ChainProblem
    integrator: Integrator
    wave_threshold: float
    primary_doubt: float
    later_doubt: float
    most_contacts: int
    label: str = "wave train"
    expected_end: float | None = None
    log: PeakLog = field(init=False)
    waves: tuple[MeasuredWave, ...] = ()
    unread: int = 0
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
    end: float = 0.0
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
        """Integrate until each wave has passed a probe and, in a finite chain, until the waves have left the chain.

        Raises
        ------
        NumericalError
            If the integrator fails.
        """
        stretches = self._stretches()
        for stretch in stretches:
            self._observe(stretch)
            if self._has_seen_all(stretch):
                break
        # Rounding errors grow when weak waves collide, so everything but the spall is measured now.
        x, v = stretch.x[-1], stretch.v[-1]
        self.waves = self._waves()
        self.unread = 0 if self.reached_end else sum(reading.wave is None for reading in self._readings)
        self.momentum = float(np.sum(v))
        self.energy = chain_energy(x, v)
        ejected = EJECTED * max((wave.granule_velocity for wave in self.waves), default=0.0)
        self.recoils, loose = _recoils(v, ejected)
        late = [sum(self.recoils)]
        since = stretch.end - _LATE * (stretch.end - self.problem.duration)
        late += [recoil for time, recoil in self._recoiled if time > since]
        rear = min((reading.head.contact for reading in self._readings), default=0)
        remaining = float(np.abs(v[free_granules(x, v) : rear]).sum())
        self.unfinished_recoil = (
            _CHANGE_SHARE * float(np.ptp(late)) + _BACKWARD_SHARE * loose + _REMAINING_SHARE * remaining
        )
        granules = self.problem.granules
        if granules is not None and granules - self._front <= _FARTHEST:
            while not self._is_spent(stretch):
                stretch = next(stretches)
                self.steps += len(stretch.spans)
                self.log.observe(stretch)
            x, v = stretch.x[-1], stretch.v[-1]
            # granules that hardly move relative to one another depart, though some will exchange their velocities
            departed = v[::-1] if self.unfollowed_force == 0 else v[::-1][: _departed(x, v)]
            self.spalls = tuple(departed[departed > ejected].tolist())
        self.end = stretch.end
        progressed(self.label, math.ceil(self.end), math.ceil(self.end))
        return self

    @property
    def reached_end(self) -> bool:
        """Whether the free end may affect the front before the waves are known."""
        granules = self.problem.granules
        return granules is not None and self._front >= granules - 1 - _REACH

    @property
    def _front(self) -> int:
        return max(self.log.peaks, default=0)

    def _stretches(self) -> Iterator[Stretch]:
        """Yield steps that are analysed together; none extends across the end of the force."""
        total = None if self.expected_end is None else math.ceil(self.expected_end)
        together: list[Span] = []
        for span in march(self.problem, self.integrator):
            together.append(span)
            long = span.end - together[0].begin >= _INTERVAL
            if long or span.end == self.problem.duration or len(together) == _MOST_SPANS:
                progressed(self.label, int(span.end), total)
                yield Stretch.of(*together)
                together = []

    def _observe(self, stretch: Stretch) -> None:
        self.steps += len(stretch.spans)
        self.log.observe(stretch)
        for reading in self._readings:
            reading.observe(stretch, self.log)
        if self._free_end is not None:
            self._free_end.observe(stretch)
        if stretch.end >= self.problem.duration:
            ejected = EJECTED * self.log.strongest ** (5 / 6)  # approximate granule velocity
            self._recoiled.append((stretch.end, sum(_recoils(stretch.v[-1], ejected)[0])))
        if stretch.end == self.problem.duration:
            self.work = chain_energy(stretch.x[-1], stretch.v[-1])
            self._driven_steps = self.steps

    def _has_seen_all(self, stretch: Stretch) -> bool:
        """Whether the waves are known after ``stretch``."""
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
        """Set a probe ahead of each wave that has settled; True once every wave has one."""
        x, v = stretch.x[-1], stretch.v[-1]
        noise = _NOISE * self.integrator.tolerance
        waves, complete = settling(self.log, stretch.end, x, v, self.wave_threshold, noise)
        if not waves:
            return False
        strongest = max(head.force for head, _ in waves)
        front = waves[0][0].contact
        budget = _BUDGET + _BUDGET_RATE * self.problem.duration
        # In order of position: behind a wave that has not settled, a peak can remain constant for a while.
        for head, doubt in waves[len(self._readings) :]:
            # The leading wave may use the longest chain; later waves get the length it needed, or the budget.
            most, allowed = float(self.most_contacts), self.primary_doubt
            if head.force < strongest:
                # rounding and step errors are larger relative to weak waves
                most, allowed = budget, self.later_doubt * math.sqrt(strongest / head.force)
            if front <= most and doubt > allowed:
                return False
            self._readings.append(_Reading(head, Probe(head.contact + _AHEAD, self.problem), doubt, not self._readings))
        self.settled = complete or front <= budget
        return complete or not self.settled

    def _is_spent(self, stretch: Stretch) -> bool:
        """Whether nothing more can leave a finite chain: its granules move apart, or have had enough steps to."""
        x, v = stretch.x[-1], stretch.v[-1]
        first, last = free_granules(x, v), len(x) - _departed(x, v)
        self.unfollowed_force = 0.0
        if first >= last:
            return True
        # energy of their relative motion, which bounds the forces of later collisions
        energy = chain_energy(x[first:last], v[first:last] - v[first:last].mean())
        slow = EJECTED if len(x) > _SHORT else _SLOWEST
        if energy < 0.5 * (slow * float(np.abs(v).max())) ** 2:
            return True
        self.unfollowed_force = (2.5 * energy) ** 0.6
        return self.steps - self._driven_steps > _PARTING + _PARTING_RATE * (self.problem.granules or 0)

    def _waves(self) -> tuple[MeasuredWave, ...]:
        """Waves that have been measured."""
        end = self._free_end
        if end is None or not self.reached_end:
            return tuple(reading.wave for reading in self._readings if reading.wave is not None)
        peaks = self.log.peaks.get(end.contact, [])
        least = self.wave_threshold * max((peak.force for peak in peaks), default=0.0)
        # The peak itself is the result. A slow force can limit both runs to the longest step, so that their difference
        # does not show the step error.
        doubt = self.integrator.tolerance
        return tuple(end.wave(peak, self.log, doubt) for peak in peaks if peak.force >= least)


def _recoils(v: FloatArray, ejected: float) -> tuple[tuple[float, ...], float]:
    """Velocities of the rebounding granules, and the momentum that they may still exchange with others.

    They extend from the loaded end to the last ejected granule and the granules that follow it backwards. Further on,
    a backward drift is caused by passing waves.
    """
    last = max(np.flatnonzero(v < -ejected), default=0)
    forward = np.flatnonzero(v[last:] >= 0)
    end = last + int(forward[0]) if len(forward) else len(v)
    region, beyond = v[:end], v[end:]
    loose = float(region[region > 0].sum() - beyond[beyond < 0].sum())
    return tuple(region[region < 0].tolist()), loose


def _departed(x: FloatArray, v: FloatArray) -> int:
    """Number of granules that have left the free end: out of contact, and no two of them approaching each other."""
    return free_granules(-x[::-1], -v[::-1])
