"""One run of the whole chain, from the shock until all waves have been read."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from attrs import define, field, frozen

from shockwave.measurement.peaks import Peak, PeakLog, characteristic_time
from shockwave.measurement.result import MeasuredWave
from shockwave.measurement.wave_limits import Settling, settling
from shockwave.measurement.wave_reading import Probe
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
# Waves are followed to a free end as far away as this from where they were read.
_FARTHEST = 2000


@frozen
class Demand:
    """Demands on a run.

    ``wave_threshold`` is the weakest wave that counts, over the primary; ``primary`` and ``later`` are the doubts
    allowed in their peaks, relative to each; ``most_contacts`` the longest chain.
    """

    wave_threshold: float
    primary: float
    later: float
    most_contacts: int

    def doubt_allowed(self, head: Peak, strongest: float) -> float:
        """For the wave at ``head``: weak waves are less sure, as rounding and step errors weigh more."""
        if head.force >= strongest:
            return self.primary
        return self.later * math.sqrt(strongest / head.force)


@frozen(eq=False)
class Run:
    """Result of one run, in scaled units.

    ``waves`` are in the order in which they pass; their ``error_estimate`` bounds how far the peak is from its limit
    along the chain (where the chain ends its answer is the peak itself, doubted by the error allowed in a step).
    ``recoils`` are the velocities of the rebounding granules, first granule first, and ``unfinished_recoil`` the
    momentum of those that may still meet others. ``spalls`` are the velocities of the granules that fly off the free
    end faster than `EJECTED` times the granules in the waves, last granule first, as far as they have come free by the
    end of the run; None where the waves were not followed there. ``strongest`` is the greatest contact force anywhere.
    ``momentum`` and ``energy`` are those of the chain when the waves are read, ``work`` its energy when the force
    ended: what is lost since then, the integration has lost. ``settled`` is False when the chain's limit came first.
    """

    waves: tuple[MeasuredWave, ...]
    recoils: tuple[float, ...]
    unfinished_recoil: float
    spalls: tuple[float, ...] | None
    strongest: Peak
    momentum: float
    energy: float
    work: float
    settled: bool
    reached_end: bool
    steps: int
    evaluations: int


def run(problem: ChainProblem, integrator: Integrator, demand: Demand) -> Run:
    """March until the waves are known, each passing a probe, and on until those of a finite chain have left it.

    Raises
    ------
    NumericalError
        When the integrator fails.
    """
    watch = _Watch(problem, demand, integrator.tolerance)
    stretches = _stretches(march(problem, integrator), problem.duration)
    for stretch in stretches:
        watch.observe(stretch)
        if watch.has_seen_all(stretch):
            break
    waves = watch.waves()
    fastest = max((wave.granule_velocity for wave in waves), default=0.0)
    # Rounding grows as weak waves meet: all but what leaves the free end is read at once.
    x, v = stretch.x[-1], stretch.v[-1]
    recoils, unfinished = _recoils(x, v, fastest)
    spalls = None
    if watch.end_is_near:
        while not watch.is_spent(stretch):
            stretch = next(stretches)
            watch.steps += len(stretch.spans)
        spalls = _spalls(stretch.x[-1], stretch.v[-1], fastest)
    return Run(
        waves=waves,
        recoils=recoils,
        unfinished_recoil=unfinished,
        spalls=spalls,
        strongest=watch.log.top(),
        momentum=float(np.sum(v)),
        energy=chain_energy(x, v),
        work=watch.work,
        settled=watch.settled,
        reached_end=watch.end_is_felt,
        steps=watch.steps,
        evaluations=integrator.evaluations,
    )


def _stretches(spans: Iterator[Span], duration: float) -> Iterator[Stretch]:
    """Spans that are looked at together; none goes on across the end of the force."""
    together: list[Span] = []
    for span in spans:
        together.append(span)
        long = span.end - together[0].begin >= _INTERVAL
        if long or span.end == duration or len(together) == _MOST_SPANS:
            yield Stretch.of(*together)
            together = []


@define
class _Reading:
    """A wave that is known: its last peak then, the probe set before it, the doubt left in its peak."""

    head: Peak
    probe: Probe
    doubt: float
    passed: bool = False
    wave: MeasuredWave | None = None

    def observe(self, stretch: Stretch, log: PeakLog) -> None:
        """Take note, and read off the wave once it has passed the probe."""
        self.probe.observe(stretch)
        peak = log.arrival(self.head, self.probe.contact)
        if peak is None:  # it should have come; waiting for ever would hang
            self.passed = stretch.end - self.head.time > 10 * _AHEAD * characteristic_time(self.head.force)
        elif stretch.end - peak.time > _PASSED * characteristic_time(peak.force):
            self.passed = True
            self.wave = self.probe.wave(peak, log, self.doubt)


@define
class _Watch:
    """State of a run: the peaks, and the waves as far as they are known."""

    problem: ChainProblem
    demand: Demand
    tolerance: float
    log: PeakLog = field(init=False)
    free_end: Probe | None = None
    readings: list[_Reading] = field(factory=list)
    steps: int = 0
    work: float = 0.0
    settled: bool = True
    _judged: float = 0.0
    _all_known: bool = False

    def __attrs_post_init__(self) -> None:
        self.log = PeakLog(tolerance=self.tolerance)
        if self.problem.granules is not None:
            last = self.problem.granules - 2
            self.free_end = Probe(max(last - _REACH, last // 2), self.problem)

    def observe(self, stretch: Stretch) -> None:
        """Take in ``stretch``."""
        self.steps += len(stretch.spans)
        self.log.observe(stretch)
        for reading in self.readings:
            if not reading.passed:
                reading.observe(stretch, self.log)
        if self.free_end is not None:
            self.free_end.observe(stretch)
        if stretch.end == self.problem.duration:
            self.work = chain_energy(stretch.x[-1], stretch.v[-1])

    def has_seen_all(self, stretch: Stretch) -> bool:
        """Whether the waves are known, now that ``stretch`` has been taken in."""
        if stretch.end < self.problem.duration:
            return False
        if self.end_is_felt:
            return self.is_spent(stretch)
        if self._all_known:
            return all(reading.passed for reading in self.readings)
        if stretch.end - self._judged >= _INTERVAL:
            self._judged = stretch.end
            threshold, noise = self.demand.wave_threshold, _NOISE * self.tolerance
            self._all_known = self._judge(
                settling(self.log, stretch.end, stretch.x[-1], stretch.v[-1], threshold, noise)
            )
        return False

    def _judge(self, state: Settling) -> bool:
        """Set a probe before each wave that is known now; True once every wave has one."""
        if not state.heads:
            return False
        strongest = max(head.force for head in state.heads)
        front = state.heads[0].contact
        budget = _BUDGET + _BUDGET_RATE * self.problem.duration
        for index, (head, doubt) in enumerate(zip(state.heads, state.doubts, strict=True)):
            # The primary is worth any length of chain; the others get what it needed, or a fair share.
            late = front > (self.demand.most_contacts if head.force >= strongest else budget)
            # In order: behind a wave that has not settled, a peak may linger at a value that is not its last.
            next_in_line = index == len(self.readings)
            if next_in_line and (late or doubt <= self.demand.doubt_allowed(head, strongest)):
                self.readings.append(_Reading(head, Probe(head.contact + _AHEAD, self.problem), doubt))
        if len(self.readings) < len(state.heads):
            return False
        self.settled = state.complete or front <= budget
        return state.complete or not self.settled

    @property
    def end_is_felt(self) -> bool:
        """Whether the front came so near to the free end that it may feel it before the waves are known."""
        granules = self.problem.granules
        return granules is not None and self._front() >= granules - 1 - _REACH

    @property
    def end_is_near(self) -> bool:
        """Whether there is a free end within reach of the front."""
        granules = self.problem.granules
        return granules is not None and granules - self._front() <= _FARTHEST

    def is_spent(self, stretch: Stretch) -> bool:
        """Whether nothing more can leave a finite chain: its granules fly apart, or they had time to."""
        x, v = stretch.x[-1], stretch.v[-1]
        first, last = free_granules(x, v), len(x) - _flown(x, v)
        slow = EJECTED * float(np.abs(v).max())
        if first >= last or chain_energy(x[first:last], v[first:last]) < 0.5 * slow**2:
            return True
        return stretch.end > self.problem.duration + 4.0 * (self.problem.granules or 0) + 50.0

    def waves(self) -> tuple[MeasuredWave, ...]:
        """The waves that have been read."""
        if self.free_end is None or not self.end_is_felt:
            return tuple(reading.wave for reading in self.readings if reading.wave is not None)
        peaks = self.log.peaks.get(self.free_end.contact, [])
        least = self.demand.wave_threshold * max((peak.force for peak in peaks), default=0.0)
        # The peak is the answer itself, and a slow force may hold both runs to their longest step: alike, they do not
        # show by how much they err.
        return tuple(self.free_end.wave(peak, self.log, self.tolerance) for peak in peaks if peak.force >= least)

    def _front(self) -> int:
        return max(self.log.peaks, default=0)


def _recoils(x: FloatArray, v: FloatArray, fastest: float) -> tuple[tuple[float, ...], float]:
    """Velocities of the rebounding granules, and the momentum of those that may still meet others.

    They reach from the loaded end to the last granule that was ejected, and those that follow it backwards: further on,
    granules that drift backwards are stirred by waves that pass.
    """
    ejected = np.nonzero(v < -EJECTED * fastest)[0]
    end = int(ejected[-1]) if len(ejected) else 0
    forward = np.nonzero(v[end:] >= 0)[0]
    region = v[: end + int(forward[0]) if len(forward) else len(v)]
    still = region[free_granules(x, v) :]
    return tuple(region[region < 0].tolist()), float(-still[still < 0].sum())


def _flown(x: FloatArray, v: FloatArray) -> int:
    """How many granules have flown off the free end: out of contact, and no two of them closing in."""
    return free_granules(-x[::-1], -v[::-1])


def _spalls(x: FloatArray, v: FloatArray, fastest: float) -> tuple[float, ...]:
    """Velocities of the granules that have flown off the free end, last granule first."""
    return tuple(velocity for velocity in v[::-1][: _flown(x, v)].tolist() if velocity > EJECTED * fastest)
