"""What a sweep would do, and about how long it would take."""

from __future__ import annotations

import math
import os
import random
import statistics
import time
from concurrent.futures import BrokenExecutor
from pathlib import Path

from attrs import frozen

from shockwave.scenario.scenario import Scenario
from shockwave.sweep.executors import Processes, check_name, cores
from shockwave.sweep.header import header_of, settled
from shockwave.sweep.journal import DONE, OPEN, Journal, header_in
from shockwave.sweep.points import Order, Points, let_through, told, understood
from shockwave.sweep.report import SweepPlan
from shockwave.sweep.runner import notes_on, points_of

__all__ = ["plan_sweep"]

# Points of which the scene is made; groups that are run, of how many points each, and for how many seconds at most.
_TRIED, _GROUPS, _GROUP, _LIMIT = 20_000, 8, 16, 4.0
# What start, journal and tables add: seconds, and seconds for each point.
_START, _EACH = 0.7, 1e-4


def plan_sweep(
    scenario: Scenario | str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    executor: str | None = None,
    *,
    workers: int | None = None,
    retry_failed: bool = False,
    accept_versions: bool = False,
) -> SweepPlan:
    """What `run_sweep` would do, with an estimate from some points that are run; nothing is written.

    Parameters
    ----------
    scenario, folder, executor, workers, retry_failed, accept_versions
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
    check_name(executor)
    points = points_of(scenario, apart=True)
    count = len(points.sweep)
    journal = Journal(Path(folder or ""), bytearray(count), [], [], None)
    if folder is not None and (there := header_in(journal.folder)) is not None:
        settled(there, header_of(points), journal.folder, accept_versions)
        journal.read(mend=False)
    finished = journal.count(DONE) if retry_failed else count - journal.count(OPEN)
    notes = notes_on(points)
    # a point may end the process that runs it
    crew = Processes(1)
    try:
        trial: Trial = crew.call(tried, Order.of(points)).result()
    except BrokenExecutor:
        trial = Trial()
        notes.append("a point ends the process that runs it: it will be told as crashed, and time is not known")
    finally:
        crew.close()
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


@frozen
class Trial:
    """What a trial of some points has shown.

    Attributes
    ----------
    tried, unbuilt : int
        Points of which the scene was to be made, and of which none can be.
    problem : str or None
        What is wrong with the first of these.
    measured : int
        Points that were run.
    mean, error : float
        Seconds a point, and the standard error of that.
    """

    tried: int = 0
    unbuilt: int = 0
    problem: str | None = None
    measured: int = 0
    mean: float = 0.0
    error: float = 0.0

    def range_of(self, count: int, workers: int) -> tuple[float, float] | None:
        """Wall times between which ``count`` points will take: two standard errors each way, and what is added."""
        if not (count and self.measured):
            return None
        low, high = (max(self.mean + side * self.error, 0.0) * count / workers for side in (-2, 2))
        return low + _START, high + _START + _EACH * count


def tried(order: Order) -> Trial:
    """Make scenes of points spread over the sweep, the same each time, and run some of them."""
    points = understood(order.content or b"")
    assert isinstance(points, Points)
    count = len(points.sweep)
    indices = random.Random(0).sample(range(count), min(count, _TRIED))
    sound, problem = [], None
    for index in indices:
        try:
            points.scene(index)
            sound.append(index)
        except BaseException as error:
            let_through(error)
            problem = problem or told(error)
    unbuilt = len(indices) - len(sound)
    # the first group also loads the code
    size = min(_GROUP if points.sweep.run == "simulate" and not points.train else 2, max(len(sound), 1))
    points.lines(sound[:size])
    times: list[float] = []
    begin = time.perf_counter()
    for at in range(0, min(len(sound), _GROUPS * size), size):
        before = time.perf_counter()
        group = sound[at : at + size]
        points.lines(group)
        times.append((time.perf_counter() - before) / len(group))
        if len(times) > 1 and time.perf_counter() - begin > _LIMIT:
            break
    if not times:
        return Trial(len(indices), unbuilt, problem)
    doubt = statistics.stdev(times) / math.sqrt(len(times)) if len(times) > 1 else times[0] / 2
    measured = min(len(sound), size * len(times))
    return Trial(len(indices), unbuilt, problem, measured, statistics.fmean(times), doubt)
