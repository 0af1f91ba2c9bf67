"""One run of the chain, from the shock to the waves."""

from __future__ import annotations

import math

import numpy as np
from attrs import define, field, frozen

from shockwave.measurement.peaks import Peak, PeakLog, natural_time
from shockwave.measurement.probe import PassingWave, Probe
from shockwave.measurement.settle import Settling, free_granules, settling
from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.march import Span, march
from shockwave.simulation.problem import ChainProblem, contact_forces, overlaps

__all__ = ["EJECTED", "Books", "Demand", "Run", "run"]

#: A granule is thrown back when it flies backwards faster than this share of the granules in the primary.
EJECTED = 1e-3
# How often, in units of time, the waves are judged.
_INTERVAL = 4.0
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
    """Momentum and energy in the chain at the end, against what the force has put in."""

    impulse: float
    momentum: float
    work: float
    energy: float


@frozen(eq=False)
class Run:
    """What one run found, in scaled units.

    ``waves`` are in the order in which they pass; ``doubts`` bound how far each peak is from its limit along
    the chain (zero where the chain ends: its answer is the peak itself). ``recoils`` are the velocities of the
    granules thrown back, first granule first, and ``unfinished_recoil`` the momentum of those that may still meet
    others. ``strongest`` is the greatest contact force anywhere. ``settled`` is False when the chain's limit came
    first.
    """

    waves: tuple[PassingWave, ...]
    doubts: tuple[float, ...]
    recoils: tuple[float, ...]
    unfinished_recoil: float
    strongest: Peak
    books: Books
    settled: bool
    reached_end: bool
    steps: int
    evaluations: int


@define
class _Work:
    """Work of the force, integral of F v1, by parts: I u1 + I^2/2 + integral of I f, smooth where F is not."""

    problem: ChainProblem
    _gathered: float = 0.0
    value: float = field(default=0.0, init=False)

    def observe(self, span: Span) -> None:
        if span.begin >= self.problem.duration:
            return
        samples = span.samples
        force = np.maximum(samples.x[:, 0] - samples.x[:, 1], 0.0) ** 1.5
        impulses = [self.problem.impulse(float(time)) for time in samples.times]
        self._gathered += float(samples.weights @ (force * impulses))
        impulse = self.problem.impulse(span.end)
        self.value = impulse * (float(span.v1[0]) - impulse / 2) + self._gathered


@frozen
class _Reading:
    """A wave that is known: its last peak then, the probe set before it, the doubt left in its peak."""

    head: Peak
    probe: Probe
    doubt: float


@define
class _Reader:
    """Sets a probe before each wave as soon as the wave is known, and says when all have been read."""

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
                self.readings[index] = _Reading(head, Probe(head.contact + _AHEAD), doubt)
        done = len(self.readings) >= len(state.heads)
        if done and not state.complete and front > self.budget:
            self.settled = False
            return True
        return done and state.complete

    def observe(self, span: Span, log: PeakLog) -> None:
        """Let the probes take their samples; read off the waves that have passed theirs."""
        for index, reading in self.readings.items():
            if index in self.passed:
                continue
            reading.probe.observe(span)
            if _has_passed(log, reading, span.end):
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
    """March until the waves are known, each passing a probe.

    Raises
    ------
    NumericalError
        When the integrator fails.
    """
    log, work = PeakLog(), _Work(problem)
    reader = _Reader(demand, _BUDGET + _BUDGET_RATE * problem.duration)
    free_end = None if problem.granules is None else _FreeEnd(problem.granules)
    judged, steps, all_known = 0.0, 0, False
    for span in march(problem, integrator):
        steps += 1
        log.observe(span)
        work.observe(span)
        reader.observe(span, log)
        if free_end is not None:
            free_end.probe.observe(span)
        if span.end < problem.duration:
            continue
        if free_end is not None and free_end.is_felt(log):
            if free_end.is_spent(span, problem):
                break
        elif all_known:
            if reader.finished:
                break
        elif span.end - judged >= _INTERVAL:
            judged = span.end
            all_known = reader.judge(
                settling(log, span.end, span.x1, span.v1, demand.wave_threshold, _NOISE * integrator.tolerance)
            )
    return _found(problem, integrator, demand, log, work, reader, free_end, span, steps)


@define
class _FreeEnd:
    """The free end of a chain of ``granules``, and the contact at which waves are read before they feel it."""

    granules: int
    probe: Probe = field(init=False)

    def __attrs_post_init__(self) -> None:
        self.probe = Probe(max(self.granules - 2 - _REACH, (self.granules - 2) // 2))

    def is_felt(self, log: PeakLog) -> bool:
        """Whether the front is so near the end that it may feel it."""
        return max(log.peaks, default=0) >= self.granules - 1 - _REACH

    def is_spent(self, span: Span, problem: ChainProblem) -> bool:
        """Whether the chain has nothing more to tell: its granules fly apart, or they had time to."""
        if free_granules(span.x1, span.v1) == len(span.x1):
            return True
        return span.end > problem.duration + 4.0 * self.granules + 50.0

    def waves(self, log: PeakLog, threshold: float) -> tuple[PassingWave, ...]:
        """Everything above the threshold that passed the probe, in order."""
        peaks = log.peaks.get(self.probe.contact, [])
        strongest = max((peak.force for peak in peaks), default=0.0)
        return tuple(self.probe.wave(peak, log) for peak in peaks if peak.force >= threshold * strongest)


def _found(
    problem: ChainProblem,
    integrator: Integrator,
    demand: Demand,
    log: PeakLog,
    work: _Work,
    reader: _Reader,
    free_end: _FreeEnd | None,
    span: Span,
    steps: int,
) -> Run:
    """What is known at the end of the march, with ``span`` its last step."""
    felt = free_end is not None and free_end.is_felt(log)
    if free_end is not None and felt:
        waves = free_end.waves(log, demand.wave_threshold)
        doubts: tuple[float, ...] = (0.0,) * len(waves)
    else:
        waves, doubts = reader.waves()
    books = _books(problem, work, span)
    fastest = max((wave.granule_velocity for wave in waves), default=0.0)
    recoils, unfinished = _recoils(span.x1, span.v1, fastest)
    return Run(
        waves=waves,
        doubts=doubts,
        recoils=recoils,
        unfinished_recoil=unfinished,
        strongest=log.top(),
        books=books,
        settled=reader.settled,
        reached_end=felt,
        steps=steps,
        evaluations=integrator.evaluations,
    )


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


def _books(problem: ChainProblem, work: _Work, span: Span) -> Books:
    stored = 0.4 * contact_forces(span.x1) * np.maximum(overlaps(span.x1), 0.0)
    return Books(
        impulse=problem.impulse(problem.duration),
        momentum=float(np.sum(span.v1)),
        work=work.value,
        energy=float(0.5 * np.sum(span.v1**2) + np.sum(stored)),
    )
