"""The plan of a sweep: what there is to do, and about how long it takes."""

from __future__ import annotations

import os
from pathlib import Path

from shockwave.scenario.scenario import Scenario
from shockwave.sweep.header import HEADER, Header
from shockwave.sweep.journal import DONE, OPEN, Journal
from shockwave.sweep.report import SweepPlan
from shockwave.sweep.runner import notes_on, points_of
from shockwave.sweep.trial import Trial, timed_apart
from shockwave.sweep.workers import check_name, cores


def plan_sweep(
    scenario: Scenario | str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    executor: str | None = None,
    *,
    workers: int | None = None,
    retry_failed: bool = False,
    accept_versions: bool = False,
    timeout: float | None = None,
) -> SweepPlan:
    """The work that `run_sweep` would do, with an estimate from some points that are run; nothing is written.

    Parameters
    ----------
    scenario, folder, executor, workers, retry_failed, accept_versions, timeout
        As of `run_sweep`; the points are run on this machine, whatever the executor.

    Raises
    ------
    ScenarioError, InvalidValueError
        When the scenario is not valid, has no sweep, or is not the one that ``folder`` is of.
    FileAccessError
        When the journal cannot be read.
    UsageError
        When there is no such executor.
    """
    check_name(executor or "processes")
    points = points_of(scenario, apart=True, timeout=timeout)
    count = len(points.sweep)
    journal = Journal(Path(folder or ""), bytearray(count))
    if folder is not None and (journal.folder / HEADER).exists():
        points.header().continued(Header.read(journal.folder), journal.folder, accept_versions)
        journal.read()
    finished = journal.count(DONE) if retry_failed else count - journal.count(OPEN)
    notes = notes_on(points)
    trial = timed_apart(points)
    if trial is None:
        notes.append("a point ends the process that runs it: it will be noted as crashed, and time is not known")
        trial = Trial()
    workers = workers or cores()
    return SweepPlan(
        run=points.sweep.run,
        axes={", ".join(axis.names): len(axis) for axis in points.sweep.axes},
        points=count,
        finished=finished,
        tried=trial.tried,
        unbuilt=trial.unbuilt,
        problem=trial.problem,
        workers=workers,
        measured=trial.measured,
        seconds=trial.range_of(count - finished, workers),
        notes=tuple(notes),
    )
