"""Run of a chain of mixed granules by the compiled code or by NumPy."""

from __future__ import annotations

from functools import cache
from types import ModuleType

import numpy as np

from shockwave.engine import chain_forces as forces
from shockwave.engine import chain_run as steps
from shockwave.engine.chain_arrays import LARGEST, Job
from shockwave.engine.chain_peaks import MOST_TURNS, NEAR, NUDGE
from shockwave.engine.chain_record import NO_RECORD
from shockwave.engine.time_limit import expired

# Work on a stage besides that on the contacts, in evaluations of a contact force.
_COMPILED_STEP = 32
# Number of contact forces between two checks of the time limit: tens of milliseconds.
_INTERVAL = 2e6


def run(job: Job, compiled: ModuleType | None) -> None:
    """Integrate to the end, in place."""
    if compiled is None:
        # a step that is too long may overflow
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            steps.March(job).run()
        if job.record:
            job.record.read_spans()
        return
    path = None if job.problem is None else job.problem.path
    tables = (np.empty(0), np.empty(0)) if path is None else (path.rows, path.coefficients)
    progress, constants = job.progress.numbers, _constants(job.method.adaptive)
    numbers = np.array([*job.settings, job.window, *constants, *progress], dtype=float)
    progress_so_far = numbers[-len(progress) :]

    def ends() -> bool:
        _status, time, *_, steps, evaluations = progress_so_far[:6].tolist()
        job.forecast.check(time, evaluations * (job.table.shape[1] + _COMPILED_STEP), steps)
        return expired()

    buffers = job.stops, job.times, job.watched, job.impulses, numbers, job.table, job.samples, job.plastic, job.curves
    record = NO_RECORD if job.record is None else job.record.buffers(job.bodies)
    compiled.run(job.method.packed, *tables, *buffers, *record, ends)
    job.progress.update(progress_so_far)
    if job.record:
        job.record.read(record[0])


@cache
def _constants(adaptive: bool) -> list[float]:
    """Constants for the compiled code, in its order."""
    max_factor, min_first = steps.limits(adaptive)
    window = forces.FAR, LARGEST, forces.MIN_OVERLAP, steps.GROWTH, steps.MARGIN, steps.AT_REST
    control = steps.SAFETY, steps.MIN_FACTOR, max_factor, forces.MIN_STEP, min_first, _COMPILED_STEP, _INTERVAL
    contacts = (forces.LOCATED, forces.ROUNDING, forces.ELASTIC * adaptive, forces.VISCOUS)
    kinks = steps.SOON, forces.KINK, forces.KINK_SHARE, steps.MOST_CUTS, *contacts
    arrival = forces.PASSED, forces.WAVE, forces.NOISE, forces.INSTANT
    peaks = steps.NEARLY, steps.HOPELESS, MOST_TURNS, NEAR, steps.AT_END, NUDGE, *arrival
    modes = forces.PARTS, forces.SHARP, forces.FINER, forces.FASTEST
    return [*window, *control, *kinks, *peaks, *modes]
