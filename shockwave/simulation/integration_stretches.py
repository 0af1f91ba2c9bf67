"""Integration of the whole chain in stretches, with a log of the force maxima: compiled, or step by step."""

from __future__ import annotations

import abc
import math
from array import array
from functools import partial
from operator import itemgetter
from types import ModuleType
from typing import cast, final

import numpy as np

from shockwave.base.errors import NumericalError
from shockwave.base.progress import report_progress
from shockwave.engine.equal_chain_run import FIRST_WINDOW, March, Span, Stretch, overdue
from shockwave.engine.integrator import Integrator
from shockwave.engine.nystroem_integrators import Nystroem
from shockwave.engine.scaled_problem import ChainProblem, Status
from shockwave.engine.time_limit import expired
from shockwave.simulation.peak_log import PeakLog

# Largest number of steps of a stretch.
_MOST_STEPS = 256
# Number of granules by which the window may grow in a stretch: a constant, and a number for each characteristic time,
# of at most so many. The states at all steps have this number of granules, so more of them take time.
_ROOM = 32
_ROOM_RATE = 1.1
_ROOM_TIME = 200.0
# The state of the compiled code; see `_train.h`.
_COLUMNS = (
    "now", "size", "until", "stop", "granules", "flying", "flown", "age", "steps", "kept", "evaluations", "peaks",
    "strongest", "ended", "target", "rise_time", "peak_force", "duration", "length", "tolerance", "kept_since",
)  # fmt: skip
_PLACES = {name: place for place, name in enumerate(_COLUMNS)}
# Values that are read after a stretch: three floats, then five whole numbers.
_READ = ("now", "strongest", "ended", "steps", "evaluations", "peaks", "kept", "granules")
_read = itemgetter(*(_PLACES[name] for name in _READ))


class Course(abc.ABC):
    """A chain from rest onwards; ``now`` is the present time, and ``steps`` the number of steps so far."""

    def __init__(self, problem: ChainProblem, integrator: Integrator) -> None:
        self.problem, self.integrator = problem, integrator
        self.log = PeakLog(integrator.tolerance, problem.wave)
        self.now, self.steps = 0.0, 0
        self.stretch = Stretch((), *np.zeros((3, 1, 1)))

    @staticmethod
    def of(problem: ChainProblem, integrator: Integrator, kept: bool = True) -> Course:
        """Course by compiled code, if it chooses the steps; unless ``kept``, stretches may omit all but the end."""
        if isinstance(integrator, Nystroem) and integrator.adaptive and integrator.compiled is not None:
            return _Compiled(problem, integrator, kept)
        return _StepByStep(problem, integrator)

    @abc.abstractmethod
    def advance(self, until: float, since: float = 0.0) -> Stretch:
        """Integrate to the end of the first step at or after ``until`` or, in a long stretch, less far.

        The stretch may omit the states before ``since``.
        """

    @abc.abstractmethod
    def shorten(self, granules: int) -> float:
        """Remove all granules beyond these, after the force has ended; the place of the last one, the new origin.

        Ahead of it the chain is at rest.
        """

    @final
    def advance_to(self, until: float, label: str, total: float) -> Stretch:
        """Integrate to the end of the first step at or after ``until``, and report progress; the last stretch."""
        while self.now < until:
            self.stretch = self.advance(until)
            report_progress(label, int(self.now), int(total) + 1)
        return self.stretch


class _StepByStep(Course):
    """Course by any integrator."""

    def __init__(self, problem: ChainProblem, integrator: Integrator) -> None:
        super().__init__(problem, integrator)
        self._march = March.of(problem, integrator)
        self._spans = self._march.run(math.inf)

    def advance(self, until: float, since: float = 0.0) -> Stretch:
        spans: list[Span] = []
        while not spans or (spans[-1].end < until and len(spans) < _MOST_STEPS):
            spans.append(next(self._spans))
        stretch = Stretch.of(*spans)
        self.log.observe(stretch)
        self.now, self.steps = stretch.end, self.steps + len(spans)
        return stretch

    def shorten(self, granules: int) -> float:
        self._spans = self._march.run(math.inf)
        return self._march.shorten(granules)


class _Compiled(Course):
    """Course by compiled code, which takes all steps of a stretch in one call."""

    def __init__(self, problem: ChainProblem, integrator: Nystroem, kept: bool) -> None:
        super().__init__(problem, integrator)
        stops = array("d", problem.stops)
        self._state = array("d", bytes(8 * len(_COLUMNS)))
        self._granules = min(FIRST_WINDOW, problem.granules or FIRST_WINDOW)
        self._set(size=integrator.first_size(stops[0], None), until=stops[0], granules=self._granules)
        self._set(rise_time=problem.rise_time, peak_force=problem.peak_force, duration=problem.duration)
        self._set(length=problem.granules or 0, tolerance=integrator.tolerance)
        tables = integrator.tableau.packed_for(problem.exponent), problem.path.rows, problem.path.coefficients, stops
        self._continue = partial(cast(ModuleType, integrator.compiled).march, *tables, self._state)
        self._chain = np.zeros((3, self._granules))
        self._rows = _MOST_STEPS + 1 if kept else 0

    def advance(self, until: float, since: float = 0.0) -> Stretch:
        if expired():
            raise overdue(self.now)
        log, granules = self.log, self._granules
        capacity = granules + _ROOM + int(_ROOM_RATE * min(until - self.now, _ROOM_TIME))
        chain = np.zeros((3, capacity))
        chain[:, :granules] = self._chain[:, :granules]
        self._chain = chain
        log.reserve(4 * capacity, capacity)
        times, (xs, vs) = np.empty(self._rows), np.empty((2, self._rows, capacity))
        self._set(target=until, kept_since=since, peaks=log.count, strongest=log.strongest)
        self._continue(chain, times, xs, vs, log.table, log.last, expired)
        self.now, log.strongest, ended, *counts = _read(self._state)
        self.steps, self.integrator.evaluations, log.count, kept, self._granules = map(int, counts)
        if ended == Status.RUNNING:
            raise overdue(self.now)
        if ended == Status.FAILED:
            raise NumericalError(f"{self.integrator.name} cannot step beyond t = {self.now:g} T0")
        granules = self._granules
        if kept:
            return Stretch((), times[:kept], xs[:kept, :granules], vs[:kept, :granules])
        return Stretch((), np.array([self.now]), *self._chain[:2, None, :granules])

    def shorten(self, granules: int) -> float:
        origin = self._chain.item(0, granules - 1)
        self._chain[:, granules:] = 0.0
        self._chain[0, :granules] -= origin
        if granules - self._state[_PLACES["flying"]] < 2:  # granules in free flight remain, and are integrated again
            self._set(flying=0)
            self._chain[2] = 0.0
        self._granules = granules
        self._set(granules=granules, until=self.now)
        return float(origin)

    def _set(self, **values: float) -> None:
        for name, value in values.items():
            self._state[_PLACES[name]] = value
