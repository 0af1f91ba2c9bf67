"""One run of the chain, from the shock to the waves."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from attrs import define, field, frozen

from shockwave.measurement.peaks import Peak, PeakLog, natural_time
from shockwave.measurement.probe import PassingWave, Probe
from shockwave.measurement.settle import Settling, settling
from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.march import Span, Stretch, free_granules, march
from shockwave.simulation.problem import ChainProblem, contact_forces, overlaps

__all__ = ["EJECTED", "Books", "Demand", "Run", "run"]

#: A granule is thrown back when it flies backwards faster than this share of the granules in the primary.
EJECTED = 1e-3
# How often, in units of time, the waves are judged; and how many steps are looked at together, at most.
_INTERVAL = 4.0
_MOST_SPANS = 64
# A probe is set this far ahead of a wave's last peak, so that the whole wave passes it.
_AHEAD = 4
# The foot of a wave has passed after this many of its widths; 1.56 is the width at peak force 1.
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
    """What a run must find.

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


@frozen
class Books:
    """Momentum in the chain when the waves are read, against the impulse; energy then, and when the force ended.

    The momentum closes to rounding. What the energy has lost since the force ended, the integration has lost.
    """

    impulse: float
    momentum: float
    held: float
    energy: float


@frozen(eq=False)
class Run:
    """What one run found, in scaled units.

    ``waves`` are in the order in which they pass; ``doubts`` bound how far each peak is from its limit along
    the chain (where the chain ends its answer is the peak itself, doubted by the error allowed in a step).
    ``recoils`` are the velocities of the granules thrown back, first granule first, and ``unfinished_recoil`` the
    momentum of those that may still meet others. ``spalls`` are the velocities of the granules that fly off the free
    end faster than `EJECTED` times the granules in the waves, last granule first, as far as they have come free by the
    end of the run; None where the waves were not followed there. ``strongest`` is the greatest contact force anywhere.
    ``settled`` is False when the chain's limit came first.
    """

    waves: tuple[PassingWave, ...]
    doubts: tuple[float, ...]
    recoils: tuple[float, ...]
    unfinished_recoil: float
    spalls: tuple[float, ...] | None
    strongest: Peak
    books: Books
    settled: bool
    reached_end: bool
    steps: int
    evaluations: int


@frozen
class _Reading:
    """A wave that is known: its last peak then, the probe set before it, the doubt left in its peak."""

    head: Peak
    probe: Probe
    doubt: float


@define
class _Reader:
    """Sets a probe before each wave as soon as the wave is known, and says when all have been read."""

    problem: ChainProblem
    demand: Demand
    budget: float
    readings: dict[int, _Reading] = field(factory=dict)
    passed: dict[int, PassingWave | None] = field(factory=dict)
    settled: bool = True

    def judge(self, state: Settling) -> bool:
        """Take up the waves that are known now; True once every wave is taken up."""
        if not state.heads:
            return False
        strongest = max(head.force for head in state.heads)
        front = state.heads[0].contact
        for index, (head, doubt) in enumerate(zip(state.heads, state.doubts, strict=True)):
            # The primary is worth any length of chain; the others get what it needed, or a fair share.
            late = front > (self.demand.most_contacts if head.force >= strongest else self.budget)
            # In order: behind a wave that has not settled, a peak may linger at a value that is not its last.
            next_in_line = index == len(self.readings)
            if next_in_line and (late or doubt <= self.demand.doubt_allowed(head, strongest)):
                self.readings[index] = _Reading(head, Probe(head.contact + _AHEAD, self.problem), doubt)
        done = len(self.readings) >= len(state.heads)
        if done and not state.complete and front > self.budget:
            self.settled = False
            return True
        return done and state.complete

    def observe(self, stretch: Stretch, log: PeakLog) -> None:
        """Let the probes take note; read off the waves that have passed theirs."""
        for index, reading in self.readings.items():
            if index in self.passed:
                continue
            reading.probe.observe(stretch)
            if _has_passed(log, reading, stretch.end):
                peak = log.arrival(reading.head, reading.probe.contact)
                self.passed[index] = None if peak is None else reading.probe.wave(peak, log)

    @property
    def finished(self) -> bool:
        """Whether every wave that was taken up has left its probe behind."""
        return len(self.passed) == len(self.readings)

    def waves(self) -> tuple[tuple[PassingWave, ...], tuple[float, ...]]:
        """The waves, and the doubts in their peaks."""
        found = [(wave, self.readings[index].doubt) for index, wave in sorted(self.passed.items()) if wave]
        return tuple(wave for wave, _ in found), tuple(doubt for _, doubt in found)


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
    waves, doubts = watch.waves()
    fastest = max((wave.granule_velocity for wave in waves), default=0.0)
    # Rounding grows as weak waves meet: all but what leaves the free end is read at once.
    books = watch.books(stretch)
    recoils, unfinished = _recoils(stretch.x[-1], stretch.v[-1], fastest)
    spalls = None
    if watch.end_is_near:
        while not watch.is_spent(stretch):
            stretch = next(stretches)
            watch.steps += len(stretch.spans)
        spalls = _spalls(stretch.x[-1], stretch.v[-1], fastest)
    return Run(
        waves=waves,
        doubts=doubts,
        recoils=recoils,
        unfinished_recoil=unfinished,
        spalls=spalls,
        strongest=watch.log.top(),
        books=books,
        settled=watch.reader.settled,
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
    if together:
        yield Stretch.of(*together)


@define
class _Watch:
    """What is kept of the march: the peaks, the waves as far as they are known, the books."""

    problem: ChainProblem
    demand: Demand
    tolerance: float
    log: PeakLog = field(init=False)
    reader: _Reader = field(init=False)
    free_end: Probe | None = None
    steps: int = 0
    _held: float = 0.0
    _judged: float = 0.0
    _all_known: bool = False

    def __attrs_post_init__(self) -> None:
        self.log = PeakLog(tolerance=self.tolerance)
        self.reader = _Reader(self.problem, self.demand, _BUDGET + _BUDGET_RATE * self.problem.duration)
        if self.problem.granules is not None:
            last = self.problem.granules - 2
            self.free_end = Probe(max(last - _REACH, last // 2), self.problem)

    def observe(self, stretch: Stretch) -> None:
        """Take in ``stretch``."""
        self.steps += len(stretch.spans)
        self.log.observe(stretch)
        self.reader.observe(stretch, self.log)
        if self.free_end is not None:
            self.free_end.observe(stretch)
        if stretch.end == self.problem.duration:
            self._held = _energy(stretch.x[-1], stretch.v[-1])

    def has_seen_all(self, stretch: Stretch) -> bool:
        """Whether the waves are known, now that ``stretch`` has been taken in."""
        if stretch.end < self.problem.duration:
            return False
        if self.end_is_felt:
            return self.is_spent(stretch)
        if self._all_known:
            return self.reader.finished
        if stretch.end - self._judged >= _INTERVAL:
            self._judged = stretch.end
            x, v = stretch.x[-1], stretch.v[-1]
            noise = _NOISE * self.tolerance
            state = settling(self.log, stretch.end, x, v, self.demand.wave_threshold, noise)
            self._all_known = self.reader.judge(state)
        return False

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
        """Whether a finite chain has nothing more to tell: its granules fly apart, or they had time to."""
        x, v = stretch.x[-1], stretch.v[-1]
        first, last = free_granules(x, v), len(x) - _flown(x, v)
        slow = EJECTED * float(np.abs(v).max())
        if first >= last or _energy(x[first:last], v[first:last]) < 0.5 * slow**2:
            return True
        return stretch.end > self.problem.duration + 4.0 * (self.problem.granules or 0) + 50.0

    def waves(self) -> tuple[tuple[PassingWave, ...], tuple[float, ...]]:
        """The waves, and the doubts in their peaks."""
        if self.free_end is None or not self.end_is_felt:
            return self.reader.waves()
        peaks = self.log.peaks.get(self.free_end.contact, [])
        least = self.demand.wave_threshold * max((peak.force for peak in peaks), default=0.0)
        waves = tuple(self.free_end.wave(peak, self.log) for peak in peaks if peak.force >= least)
        # The peak is the answer itself, and a slow force may hold both runs to their longest step: alike, they do not
        # tell by how much they err.
        return waves, (self.tolerance,) * len(waves)

    def books(self, stretch: Stretch) -> Books:
        """The books at the end of ``stretch``."""
        return Books(
            impulse=self.problem.impulse(self.problem.duration),
            momentum=float(np.sum(stretch.v[-1])),
            held=self._held,
            energy=_energy(stretch.x[-1], stretch.v[-1]),
        )

    def _front(self) -> int:
        return max(self.log.peaks, default=0)


def _has_passed(log: PeakLog, reading: _Reading, now: float) -> bool:
    peak = log.arrival(reading.head, reading.probe.contact)
    if peak is None:  # it should have come; waiting for ever would hang
        return now - reading.head.time > 10 * _AHEAD * natural_time(reading.head.force)
    return now - peak.time > _PASSED * natural_time(peak.force)


def _recoiling(v: FloatArray, fastest: float) -> FloatArray:
    """Velocities from the loaded end to the last granule thrown back, and to those that follow it backwards.

    Further on, granules that drift backwards are stirred by waves that pass, not thrown back.
    """
    thrown = np.nonzero(v < -EJECTED * fastest)[0]
    end = int(thrown[-1]) if len(thrown) else 0
    forward = np.nonzero(v[end:] >= 0)[0]
    return v[: end + int(forward[0]) if len(forward) else len(v)]


def _recoils(x: FloatArray, v: FloatArray, fastest: float) -> tuple[tuple[float, ...], float]:
    """Velocities of the granules that fly backwards, and the momentum of those that may still meet others."""
    region = _recoiling(v, fastest)
    still = region[free_granules(x, v) :]
    return tuple(float(velocity) for velocity in region[region < 0]), float(-still[still < 0].sum())


def _flown(x: FloatArray, v: FloatArray) -> int:
    """How many granules have flown off the free end: out of contact, and no two of them closing in."""
    return free_granules(-x[::-1], -v[::-1])


def _spalls(x: FloatArray, v: FloatArray, fastest: float) -> tuple[float, ...]:
    """Velocities of the granules that have flown off the free end, last granule first."""
    return tuple(velocity for velocity in v[::-1][: _flown(x, v)].tolist() if velocity > EJECTED * fastest)


def _energy(x: FloatArray, v: FloatArray) -> float:
    stored = 0.4 * contact_forces(x) * np.maximum(overlaps(x), 0.0)
    return float(0.5 * np.sum(v * v) + np.sum(stored))
