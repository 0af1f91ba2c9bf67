"""Integration of the whole chain in stretches, with a log of the force maxima: compiled, or step by step."""

from __future__ import annotations

import abc
from types import ModuleType
from typing import cast, final

import numpy as np

from shockwave.errors import NumericalError
from shockwave.measurement.peak_log import PeakLog
from shockwave.progress import progressed
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.march import FIRST_WINDOW, Span, Stretch, march, overdue
from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.problem import ChainProblem, Status
from shockwave.simulation.time_limit import expired

# Largest number of steps of a stretch.
_MOST_STEPS = 256
# Number of granules by which the front may advance in a stretch.
_ROOM = 128
# Least number of peaks for which the log has room at the beginning of a stretch.
_PEAKS = 1024
# Columns of the state of the compiled code; see `_compiled.c`.
_COLUMNS = (
    "now", "size", "until", "stop", "granules", "flying", "flown", "age", "steps", "kept", "evaluations", "peaks",
    "strongest", "ended", "target", "rise_time", "peak_force", "duration", "length", "tolerance",
)  # fmt: skip


class Course(abc.ABC):
    """A chain from rest onwards; ``now`` is the present time, and ``steps`` the number of steps so far."""

    def __init__(self, problem: ChainProblem, integrator: Integrator) -> None:
        self.problem, self.integrator = problem, integrator
        self.log = PeakLog(integrator.tolerance)
        self.now, self.steps = 0.0, 0
        self.stretch = Stretch((), *np.zeros((3, 1, 1)))

    @staticmethod
    def of(problem: ChainProblem, integrator: Integrator, kept: bool = True) -> Course:
        """Course by compiled code if the integrator has it; unless ``kept``, its stretches may omit all but the end."""
        if isinstance(integrator, Nystroem) and integrator.compiled is not None:
            return _Compiled(problem, integrator, kept)
        return _StepByStep(problem, integrator)

    @abc.abstractmethod
    def advance(self, until: float) -> Stretch:
        """Integrate to the end of the first step at or after ``until`` or, in a long stretch, less far."""

    @final
    def advance_to(self, until: float, label: str, total: float) -> Stretch:
        """Integrate to the end of the first step at or after ``until``, and report progress; the last stretch."""
        while self.now < until:
            self.stretch = self.advance(until)
            progressed(label, int(self.now), int(total) + 1)
        return self.stretch


class _StepByStep(Course):
    """Course by any integrator."""

    def __init__(self, problem: ChainProblem, integrator: Integrator) -> None:
        super().__init__(problem, integrator)
        self._spans = march(problem, integrator)

    def advance(self, until: float) -> Stretch:
        spans: list[Span] = []
        while not spans or (spans[-1].end < until and len(spans) < _MOST_STEPS):
            spans.append(next(self._spans))
        stretch = Stretch.of(*spans)
        self.log.observe(stretch)
        self.now, self.steps = stretch.end, self.steps + len(spans)
        return stretch


class _Compiled(Course):
    """Course by compiled code, which takes all steps of a stretch in one call."""

    def __init__(self, problem: ChainProblem, integrator: Nystroem, kept: bool) -> None:
        super().__init__(problem, integrator)
        self._state = dict.fromkeys(_COLUMNS, 0.0) | {
            "size": integrator.first_size(problem.stops[0], None),
            "until": problem.stops[0],
            "granules": min(FIRST_WINDOW, problem.granules or FIRST_WINDOW),
            "rise_time": problem.rise_time,
            "peak_force": problem.peak_force,
            "duration": problem.duration,
            "length": problem.granules or 0,
            "tolerance": integrator.tolerance,
        }
        self._chain = np.zeros((3, 0))
        self._stops = np.array(problem.stops)
        self._rows = _MOST_STEPS + 1 if kept else 0

    def advance(self, until: float) -> Stretch:
        state, log, path = self._state, self.log, self.problem.path
        if self._chain.shape[1] < state["granules"] + _ROOM:
            self._chain = np.concatenate((self._chain, np.zeros((3, 2 * _ROOM))), axis=1)
        capacity = self._chain.shape[1]
        log.reserve(max(_PEAKS, 4 * capacity), capacity)
        times, states = np.empty(self._rows), np.empty((2, self._rows, capacity))
        begin = state["now"]
        numbers = np.array(list((state | {"target": until, "peaks": log.count, "strongest": log.strongest}).values()))
        method = cast(Nystroem, self.integrator)
        tables = method.tableau.packed, path.rows, path.coefficients, self._stops
        compiled = cast(ModuleType, method.compiled)
        compiled.march(*tables, numbers, self._chain, times, *states, log.table, log.last, expired)
        self._state = state = dict(zip(_COLUMNS, numbers.tolist(), strict=True))
        log.count, log.strongest = int(state["peaks"]), state["strongest"]
        self.now, self.steps, method.evaluations = state["now"], int(state["steps"]), int(state["evaluations"])
        if state["ended"] == Status.RUNNING:
            raise overdue(self.now)
        if state["ended"] == Status.FAILED:
            raise NumericalError(f"{method.name} cannot step beyond t = {self.now:g} T0")
        kept, granules = int(state["kept"]), int(state["granules"])
        if kept:
            return Stretch((), times[:kept], *states[:, :kept, :granules])
        return Stretch((), np.array([begin, self.now]), *self._chain[:2, None, :granules])
