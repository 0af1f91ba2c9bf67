"""Dry run of a sweep: number of points and estimated run time."""

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

from shockwave.progress import progressed
from shockwave.result_base import VERSION
from shockwave.scenario.scenario import Scenario
from shockwave.sweep.definition import DEFINITION, SweepDefinition
from shockwave.sweep.journal import NOT_RUN, Journal
from shockwave.sweep.runner import points_of
from shockwave.sweep.workers import cores
from shockwave.text import facts, limits, strong

# Most points that are run for the estimate.
_MOST_MEASURED = 64
# Time after which no further point is run [s].
_TIME_LIMIT = 3.0
# Points that are run in one call.
_GROUP = 8
# Time to start the workers and to write the tables [s].
_OVERHEAD = 1.0
# Longest time that is printed in seconds [s].
_LONGEST_IN_SECONDS = 120


@frozen(kw_only=True)
class SweepPlan:
    """Work of a sweep, with an estimate of the run time.

    Attributes
    ----------
    run : str
        Task at every point: ``predict``, ``simulate`` or ``compare``.
    axes : dict of str to int
        Number of values of each axis, by the names of its variables.
    points : int
        Number of points of the sweep.
    finished : int
        Points that earlier runs have finished.
    measured : int
        Points that were run for the estimate.
    failed : int
        Measured points that failed.
    problem : str or None
        Error of the first of these.
    workers : int
        Number of workers assumed.
    seconds : (float, float)
        Estimated wall time [s]: two standard errors of the mean below and above the estimate.
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
        """Return the document that ``sweep --dry-run --json`` prints."""
        return VERSION | asdict(self)

    def __str__(self) -> str:
        workers = "1 worker" if self.workers == 1 else f"{self.workers} workers"
        estimate = f", estimated time {self._time()} on {workers}" if self.measured else ""
        answer = f"{self.points - self.finished} of {self.points} points to run{estimate}"
        failure = f"{self.failed} of the {self.measured} measured points failed: {self.problem}"
        details = [
            ("task", self.run),
            ("axes", ", ".join(f"{length} values of {names}" for names, length in self.axes.items())),
            ("estimated from", f"{self.measured} points"),
        ]
        return "\n".join([strong(answer), *limits([failure] if self.failed else []), *facts(details)])

    def _time(self) -> str:
        """The range of the estimated time, in seconds or as hours:minutes:seconds."""
        low, high = (math.ceil(seconds) for seconds in self.seconds)
        if high <= _LONGEST_IN_SECONDS:
            return f"{low} to {high} s" if low < high else f"about {high} s"
        return f"{timedelta(seconds=low)} to {timedelta(seconds=high)} h"


def plan_sweep(
    scenario: Scenario | str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    *,
    workers: int | None = None,
    retry_failed: bool = False,
    accept_versions: bool = False,
) -> SweepPlan:
    """Estimate the run time of `run_sweep` from some points, without writing anything.

    Parameters
    ----------
    scenario, folder, workers, retry_failed, accept_versions
        As for `run_sweep`. The points are run in this process.

    Raises
    ------
    ScenarioError, InvalidValueError
        If the scenario is invalid, has no sweep, or differs from that of ``folder``.
    FileAccessError
        If the journal cannot be read.
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
    # a reproducible sample of the whole sweep
    sample = random.Random(0).sample(range(count), min(count, _MOST_MEASURED)) if left else []
    progressed("measuring points", 0, len(sample))
    points.lines(sample[:1])  # loads the code
    begin = now = time.perf_counter()
    lines = ""
    measured = 0
    times = []
    size = 1  # until the time of a point is known
    while measured < len(sample) and now - begin < _TIME_LIMIT:
        group = sample[measured : measured + size]
        lines += points.lines(group)
        measured += len(group)
        progressed("measuring points", measured, len(sample))
        before, now = now, time.perf_counter()
        times.append((now - before) / len(group))
        size = _GROUP if times[-1] < _TIME_LIMIT / _GROUP else 1
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
        seconds=_wall_time(times, left / workers),
    )


def _wall_time(times: Sequence[float], rounds: float) -> tuple[float, float]:
    """Bounds of the wall time of ``rounds`` points in sequence [s]."""
    if not times:
        return 0.0, 0.0
    mean = statistics.fmean(times)
    error = statistics.stdev(times) / len(times) ** 0.5 if len(times) > 1 else mean / 2
    return _OVERHEAD + max(mean - 2 * error, 0.0) * rounds, _OVERHEAD + (mean + 2 * error) * rounds
