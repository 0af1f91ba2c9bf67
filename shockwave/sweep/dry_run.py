"""The dry run of a sweep: what there is to do, and about how long it takes."""

from __future__ import annotations

import json
import math
import os
import random
import statistics
import time
from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path
from typing import Any

from attrs import asdict, frozen

from shockwave.scenario.scenario import Scenario
from shockwave.sweep.definition import DEFINITION, SweepDefinition
from shockwave.sweep.journal import NOT_RUN, Journal
from shockwave.sweep.runner import points_of
from shockwave.sweep.workers import cores
from shockwave.text import notes

# Points that are run, and seconds after which no more are begun.
_MOST = 64
_LIMIT = 3.0
# Points that are run side by side.
_GROUP = 8
# Seconds that start and tables add.
_START = 1.0


@frozen(kw_only=True)
class SweepPlan:
    """What a sweep would do.

    Attributes
    ----------
    run : str
        What every point does.
    axes : dict of str to int
        Names of the variables of each axis, and how many values it has.
    points, finished : int
        All points; those that the folder has already.
    measured, failed : int
        Points that were run for the estimate; those of them that failed.
    problem : str or None
        The error of the first of these.
    workers : int
        How many the estimate is for.
    seconds : (float, float)
        Estimate of the wall time: two standard errors of the mean below and above.
    """

    run: str
    axes: dict[str, int]
    points: int
    finished: int
    measured: int
    failed: int
    problem: str | None
    workers: int
    seconds: tuple[float, float]

    def to_dict(self) -> dict[str, Any]:
        """The document that ``sweep --dry-run --json`` prints."""
        return asdict(self)

    def __str__(self) -> str:
        shape = ", ".join(f"{length} of {names}" for names, length in self.axes.items())
        low, high = (timedelta(seconds=math.ceil(seconds)) for seconds in self.seconds)
        estimate = f"{low} to {high} on {self.workers} workers, measured on {self.measured} points"
        lines = [
            f"{self.points} points, {self.run}: {shape}",
            f"  finished     {self.finished}",
            f"  time         {estimate if self.measured else 'nothing to do'}",
        ]
        remark = f"{self.failed} of these {self.measured} points failed: {self.problem}"
        return "\n".join(lines + notes([remark] if self.failed else []))


def plan_sweep(
    scenario: Scenario | str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    *,
    workers: int | None = None,
    retry_failed: bool = False,
    accept_versions: bool = False,
) -> SweepPlan:
    """The work that `run_sweep` would do, with an estimate from some points that are run; nothing is written.

    Parameters
    ----------
    scenario, folder, workers, retry_failed, accept_versions
        As of `run_sweep`; the points are run in this process.

    Raises
    ------
    ScenarioError, InvalidValueError
        When the scenario is not valid, has no sweep, or is not the one that ``folder`` is of.
    FileAccessError
        When the journal cannot be read.
    """
    points = points_of(scenario)
    count = len(points.sweep)
    journal = Journal(Path(folder or ""), count)
    if folder is not None and (journal.folder / DEFINITION).exists():
        points.definition.resumed(SweepDefinition.read(journal.folder), journal.folder, accept_versions)
        journal.read(points.definition.columns)
    if retry_failed:
        journal.reopen()
    left = journal.count(NOT_RUN)
    # spread over the sweep, the same each time
    sample = random.Random(0).sample(range(count), min(count, _MOST)) if left else []
    points.lines(sample[:1])  # loads the code
    begin = now = time.perf_counter()
    lines = ""
    measured = 0
    times = []
    size = 1  # until it is known how long a point takes
    while measured < len(sample) and now - begin < _LIMIT:
        group = sample[measured : measured + size]
        lines += points.lines(group)
        measured += len(group)
        before, now = now, time.perf_counter()
        times.append((now - before) / len(group))
        size = _GROUP if times[-1] < _LIMIT / _GROUP else 1
    entries = [json.loads(line) for line in lines.splitlines()]
    errors = [entry["error"] for entry in entries if "error" in entry]
    workers = workers or cores()
    return SweepPlan(
        run=points.sweep.run,
        axes={", ".join(axis.names): len(axis) for axis in points.sweep.axes},
        points=count,
        finished=count - left,
        measured=measured,
        failed=len(errors),
        problem=errors[0] if errors else None,
        workers=workers,
        seconds=_span(times, left / workers),
    )


def _span(times: Sequence[float], rounds: float) -> tuple[float, float]:
    """The wall times between which so many points, one after the other, will take."""
    if not times:
        return 0.0, 0.0
    mean = statistics.fmean(times)
    error = statistics.stdev(times) / len(times) ** 0.5 if len(times) > 1 else mean / 2
    return _START + max(mean - 2 * error, 0.0) * rounds, _START + (mean + 2 * error) * rounds
