"""The plan of a sweep: what there is to do, and about how long it takes."""

from __future__ import annotations

import os
import random
import statistics
import time
from concurrent.futures import BrokenExecutor
from pathlib import Path
from typing import NamedTuple

from shockwave.scenario.scenario import Scenario
from shockwave.sweep.header import HEADER, Header
from shockwave.sweep.journal import DONE, OPEN, Journal
from shockwave.sweep.points import Points, content_of, error_text, understood
from shockwave.sweep.report import SweepPlan
from shockwave.sweep.runner import points_of
from shockwave.sweep.workers import check_name, cores, processes

# Points whose scene is built.
_MOST_BUILT = 20_000
# Groups that are run, and seconds for all of them.
_GROUPS = 8
_LIMIT = 4.0
# Points of a group of simulations, which run side by side, and of others.
_SIMULATIONS = 16
_OTHERS = 2
# Seconds that start, journal and tables add, and add for each point.
_START = 0.7
_EACH = 1e-4


class _Trial(NamedTuple):
    """Points whose scene was built, those of which none can be and why, those that were run, and seconds a point."""

    tried: int = 0
    unbuilt: int = 0
    problem: str | None = None
    measured: int = 0
    times: tuple[float, ...] = ()


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
        points.header.continued(Header.read(journal.folder), journal.folder, accept_versions)
        journal.read()
    finished = journal.count(DONE) if retry_failed else count - journal.count(OPEN)
    notes = points.notes
    trial = _timed_apart(points)
    if trial is None:
        notes.append("a point ends the process that runs it: it will be noted as crashed, and time is not known")
        trial = _Trial()
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
        seconds=_span(trial.times, count - finished, workers),
        notes=tuple(notes),
    )


def _span(times: tuple[float, ...], count: int, workers: int) -> tuple[float, float] | None:
    """Wall times between which ``count`` points will take: two standard errors each way, and what is added."""
    if not (count and times):
        return None
    mean = statistics.fmean(times)
    error = statistics.stdev(times) / len(times) ** 0.5 if len(times) > 1 else mean / 2
    low = max(mean - 2 * error, 0.0) * count / workers
    high = (mean + 2 * error) * count / workers
    return low + _START, high + _START + _EACH * count


def _timed_apart(points: Points) -> _Trial | None:
    """Try points in a process of their own; None if one of them ends it."""
    with processes(1) as own:
        try:
            trial: _Trial = own.schedule(_timed, (content_of(points),)).result()
        except (*own.deaths, BrokenExecutor):
            return None
    return trial


def _timed(content: bytes) -> _Trial:
    """Build scenes of points spread over the sweep, the same each time, and run some of them in groups."""
    points = understood(content)
    indices = random.Random(0).sample(range(len(points.sweep)), min(len(points.sweep), _MOST_BUILT))
    sound, problem = [], None
    for index in indices:
        try:
            points.scene(index)
            sound.append(index)
        except (Exception, SystemExit) as error:
            problem = problem or error_text(error)
    size = _SIMULATIONS if points.sweep.run == "simulate" and not points.train else _OTHERS
    points.lines(sound[:size])  # the first group also loads the code
    measured = 0
    times: list[float] = []
    begin = now = time.perf_counter()
    while measured < min(len(sound), _GROUPS * size) and (len(times) < 2 or now - begin < _LIMIT):
        group = sound[measured : measured + size]
        points.lines(group)
        before, now = now, time.perf_counter()
        times.append((now - before) / len(group))
        measured += len(group)
    return _Trial(len(indices), len(indices) - len(sound), problem, measured, tuple(times))
