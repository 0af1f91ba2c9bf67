"""Integration of a whole chain of equal granules in stretches of time, with a log of the force maxima."""

from __future__ import annotations

import math
from importlib import import_module

import numpy as np

from shockwave.base.errors import NumericalError
from shockwave.base.progress import report_progress
from shockwave.engine.chain_arrays import KINK_TOLERANCE, LARGEST, ROWS, Job, Progress, Settings, Status
from shockwave.engine.chain_backend import run
from shockwave.engine.chain_forces import FAR
from shockwave.engine.chain_record import Record
from shockwave.engine.integrator import LONGEST_STEP, Integrator
from shockwave.engine.nystroem_integrators import Rkn86
from shockwave.engine.peak_log import PeakLog
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.stretch import Stretch

# First number of granules in the window.
_FIRST_WINDOW = 12
# Number of granules by which the window may grow in a stretch: a constant, and a number for each characteristic time,
# of at most so many. The states at all steps have this number of granules, so more of them take time.
_ROOM = 16
_ROOM_RATE = 1.1
_ROOM_TIME = 200.0
# Least number of granules in the arrays of an endless chain: sufficient for most trains of one wave.
_LEAST = 96
# Scale of the errors: those of two neighbours, each within the tolerance, differ by up to twice as much.
_SCALE = 2.0


class WholeChain:
    """Run of a chain of equal granules, which is at rest at first.

    ``now`` is the present time, ``steps`` the number of steps so far, ``log`` has the peaks. Unless ``kept``, stretches
    may omit all states but that at the end.
    """

    def __init__(self, problem: ScaledProblem, integrator: Integrator, kept: bool = True) -> None:
        self.problem, self.integrator = problem, integrator
        self.log = PeakLog(integrator.tolerance if integrator.adaptive else KINK_TOLERANCE, problem.wave)
        self.now, self.steps = 0.0, 0
        compiled = getattr(integrator, "compiled", None)
        self._compiled = compiled and import_module("shockwave.engine._chains")
        window = min(_FIRST_WINDOW, problem.granules or _FIRST_WINDOW)
        self._record = Record(self.log, problem.granules is not None, window, kept)
        first = integrator.first_size(problem.stops[0], None) if integrator.adaptive else integrator.size
        self._progress = Progress(size=first)
        self._job: Job | None = None

    def advance(self, until: float, since: float = 0.0) -> Stretch:
        """Integrate to ``until`` or, in a long stretch, less far; the stretch may omit the states before ``since``.

        Raises
        ------
        NumericalError
            If the integrator fails, or the time limit is reached.
        """
        record, room = self._record, _ROOM + int(_ROOM_RATE * min(until - self.now, _ROOM_TIME))
        job = self._job
        if job is None or (record.continues and record.bodies + room > job.bodies):
            job = self._job = self._make_job(max(record.bodies + room, _LEAST), job)
        record.since = since
        job.settings = job.settings._replace(until=until)
        run(job, self._compiled)
        status, self.now = self._progress.status, self._progress.time
        if status == Status.RUNNING:
            raise NumericalError(
                f"the time limit was reached at {self.now:.4g} characteristic times of the wave (allow more, loosen the"
                " tolerance, or shorten the simulated time)"
            )
        if status == Status.FAILED:
            remedy = "loosen the tolerance" if self.integrator.adaptive else "use a smaller step"
            raise NumericalError(f"{self.integrator.name} cannot step beyond t = {self.now:g} T0 ({remedy})")
        self.steps, self.integrator.evaluations = int(self._progress.steps), int(self._progress.evaluations)
        if record.stretch is not None:
            return record.stretch
        x, v = job.x[: record.bodies], job.v[: record.bodies]
        return Stretch((), np.array([self.now]), x[None].copy(), v[None].copy())

    def advance_to(self, until: float, label: str, total: float) -> Stretch:
        """Integrate to ``until``, and report progress; the last stretch."""
        while self.now < until:
            self.stretch = self.advance(until)
            report_progress(label, math.ceil(self.now), math.ceil(total))
        return self.stretch

    def shorten(self, granules: int) -> float:
        """Remove all granules beyond these, after the force has ended; the place of the last one, the new origin.

        Ahead of it the chain is at rest.
        """
        assert self._job
        x, v = self._job.x, self._job.v
        origin = x.item(granules - 1)
        x[:granules] -= origin
        x[granules:] = v[granules:] = 0.0
        self._record.bodies = granules
        return origin

    def _make_job(self, bodies: int, before: Job | None) -> Job:
        """Arrays of a run of so many granules, or all, after the run ``before``; a chain is at rest beyond them."""
        problem, integrator = self.problem, self.integrator
        bodies = min(bodies, problem.granules or bodies)
        self._record.continues, last = bodies != problem.granules, bodies - 1
        method = integrator.coefficients()
        longest = LONGEST_STEP if problem.granules is None else min(LONGEST_STEP, problem.duration)
        longest = longest if integrator.adaptive else integrator.size
        settings = Settings(
            tolerance=self.log.tolerance,
            until=0.0,
            duration=problem.duration,
            rise_time=problem.rise_time,
            peak_force=problem.peak_force,
            first=self._progress.size,
            longest=longest,
            contacts=last,
        )
        job = Job(
            method=method or Rkn86.tableau,
            integrator=integrator if method is None else None,
            problem=problem,
            law=None,
            by_law=np.zeros(bodies, dtype=bool),
            settings=settings,
            stops=np.array(problem.stops),
            times=np.empty(0),
            samples=np.empty((0, 4, 0)),
            watched=np.array([0, last - 1]),
            impulses=np.zeros(2),
            progress=self._progress,
            table=np.zeros((ROWS, bodies + 1)),
            record=self._record,
        )
        job.chain[:2], job.scales[:], job.exponents[0] = 1.0, _SCALE, problem.exponent
        job.switches[0] = 2.0
        # beyond the last granule there is nothing, or a granule at rest
        job.chain[1:3, last], job.scales[:, last] = [0.0, -FAR], LARGEST
        if before:
            job.x[: before.bodies], job.v[: before.bodies] = before.x[:-1], before.v[:-1]
        return job
