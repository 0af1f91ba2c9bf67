"""Dry run of a sweep: number of points and estimated run time."""

from __future__ import annotations

import json
import os
import random
import time
from collections.abc import Sequence
from datetime import timedelta

from shockwave.base.text import facts, limits, strong
from shockwave.scenario.scenario import Scenario
from shockwave.sweep.definition import DEFINITION, SweepDefinition, folder_path
from shockwave.sweep.journal import NOT_RUN, Journal
from shockwave.sweep.point_evaluation import Points
from shockwave.sweep.runner import points_of
from shockwave.sweep.workers import cores

# Most points that are run for the estimate.
_MOST_MEASURED = 64
# Time after which no further point is run [s].
_TIME_LIMIT = 3.0
# Time to start the workers and to write the tables [s].
_OVERHEAD = 1.0


def dry_run(
    scenario: Scenario | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    workers: int | None = None,
    retry_failed: bool = False,
    accept_versions: bool = False,
) -> str:
    """Report the points of a sweep and the estimated run time of `run_sweep`, without writing anything.

    The arguments are those of `run_sweep`, and so are the errors. Some points are run in this process.
    """
    points = points_of(scenario)
    count = len(points.sweep)
    journal = Journal(folder_path(folder), count)
    if os.path.exists(journal.folder / DEFINITION):  # false also where the folder cannot be searched
        points.definition.resume(SweepDefinition.read(journal.folder), journal.folder, accept_versions)
        journal.read(points.definition.columns)
    if retry_failed:
        journal.reopen()
    remaining = journal.count(NOT_RUN)
    estimate = ""
    failures: list[str] = []
    if remaining:
        # a reproducible sample of the whole sweep
        sample = random.Random(0).sample(range(count), min(count, _MOST_MEASURED))
        seconds, failures = _measure(points, sample)
        workers = workers or cores()
        plural = "" if workers == 1 else "s"
        span = timedelta(seconds=round(_OVERHEAD + seconds * remaining / workers))
        estimate = f", about {span} on {workers} worker{plural}"
    axes = ", ".join(f"{len(axis)} values of {', '.join(axis.names)}" for axis in points.sweep.axes)
    answer = strong(f"{remaining} of {count} points to run{estimate}")
    return "\n".join([answer, *limits(failures[:1]), *facts([("task", points.sweep.run), ("axes", axes)])])


def _measure(points: Points, sample: Sequence[int]) -> tuple[float, list[str]]:
    """Mean time of a point of the sample [s], and the errors of its points."""
    points.lines(sample[:1])  # loads the code
    begin = time.perf_counter()
    evaluated, elapsed, lines = 0, 0.0, ""
    while evaluated < len(sample) and elapsed < _TIME_LIMIT:
        reached = min(2 * evaluated + 1, len(sample))
        lines += points.lines(sample[evaluated:reached])
        evaluated = reached
        elapsed = time.perf_counter() - begin
    entries = map(json.loads, lines.splitlines())
    return elapsed / evaluated, [f"a measured point failed: {entry['error']}" for entry in entries if "error" in entry]
