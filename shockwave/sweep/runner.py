"""Execution of a sweep: batches are sent to workers, and their points are written to the journal; its dry run."""

from __future__ import annotations

import os
import random
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from datetime import timedelta
from functools import partial
from typing import Any

from attrs import define, evolve, field

from shockwave.base.errors import InvalidValueError, UsageError, message_of
from shockwave.base.files import replace_file
from shockwave.base.progress import logger
from shockwave.base.quantity_fields import Declaration
from shockwave.base.text import facts, limits, strong
from shockwave.scenario.scenario import Scenario, load_scenario
from shockwave.sweep.definition import DEFINITION, SweepDefinition, folder_path
from shockwave.sweep.fork_server import start_server
from shockwave.sweep.journal import FAILED, NOT_RUN, Entry, Journal, write_tables
from shockwave.sweep.point_evaluation import Points, content_of
from shockwave.sweep.progress_text import SweepInterrupt, SweepReport
from shockwave.sweep.workers import LostError, Workers, check_workers, cores, workers_of

# Most points in a batch.
_MOST_IN_BATCH = 2048
# Batches sent to each worker at a time, so that no worker waits for the client.
_AHEAD = 2
# Time between two checks of the number of workers [s].
_CHECK_INTERVAL = 5
# Time that the current batches have to end when the sweep is stopped [s].
_LAST = 1.5
_TIMEOUT = Declaration("s", "time limit of a point", above=0, optional=True)
_CRASH = "its process terminated (a crash, or out of memory)"


def points_of(scenario: Scenario | str | os.PathLike[str]) -> Points:
    """Return the points of a scenario with a sweep, or of a scenario file.

    Raises
    ------
    InvalidValueError
        If the scenario has no sweep.
    """
    base = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
    if base.sweep is None:
        problem = "must be given (got nothing; a mapping of grid, zip or points)"
        raise InvalidValueError.of("sweep", problem, str(base.path or ""))
    if base.path is not None:  # workers may run in other folders
        base = evolve(base, path=base.path.absolute())
    elif base.document is not None:
        base = evolve(base, document=evolve(base.document, folder=base.folder.absolute()))
    return Points(base)


def run_sweep(
    scenario: Scenario | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    executor: Executor | None = None,
    *,
    workers: int | None = None,
    timeout: float | str | None = None,
    fail_fast: bool = False,
    retry_failed: bool = False,
    accept_versions: bool = False,
    progress: Callable[[SweepReport], None] | None = None,
) -> SweepReport:
    """Run all unfinished points of a sweep, and write the results.

    Each finished point is a row of the journal in ``folder``. A second call resumes the sweep, however the first one
    ended. Without an executor, worker processes import the main program again: in a script, call this function under
    ``if __name__ == "__main__":``.

    Parameters
    ----------
    scenario : Scenario or path-like
        A scenario with a ``sweep`` block.
    folder : path-like
        Folder of the journal and the results: a new one, or that of the same sweep.
    executor : concurrent.futures.Executor, optional
        An executor, such as that of a cluster; default: processes on this machine.
    workers : int, optional
        Number of workers; default: that of the executor, or the number of cores.
    timeout : float or str, optional
        Time limit of a point [s], or text with a unit. A point that exceeds it is stopped and recorded as failed. For
        processes only.
    fail_fast : bool
        Stop at the first point that fails.
    retry_failed : bool
        Run points again that failed or crashed in earlier runs.
    accept_versions : bool
        Resume although the versions differ from those of earlier runs.
    progress : callable, optional
        Called with a `SweepReport` whenever points are finished.

    Returns
    -------
    SweepReport
        The outcome. The results are in ``folder``.

    Raises
    ------
    ScenarioError, InvalidValueError
        If the scenario is invalid, has no sweep, or differs from that of ``folder``; if ``timeout`` is out of range.
    FileAccessError
        If a file cannot be read or written. The message names the file; finished points are kept.
    UsageError, ShockwaveError
        If the executor is not available or breaks down.
    SweepInterrupt
        A KeyboardInterrupt, raised after the finished points have been saved.
    """
    begin = time.perf_counter()
    place, limit = folder_path(folder), _TIMEOUT.check("timeout", timeout)
    check_workers(executor, workers, limit)
    if executor is None:
        start_server()
    points = points_of(scenario)
    journal = Journal(place, len(points.sweep))
    with journal.lock():
        definition = _definition(journal, points, accept_versions)
        journal.begin(retry_failed)
        before = journal.points - journal.count(NOT_RUN)
        report = partial(_report, journal, before, begin, definition.version_notes)
        if before < journal.points:
            content = content_of(points)
            try:
                with workers_of(executor, workers, limit) as crew:
                    logger.info("sweep %s: %d of %d points to run", folder, journal.points - before, journal.points)
                    _Dispatch(content, journal, crew, fail_fast, lambda: progress and progress(report())).run()
            except KeyboardInterrupt:
                raise SweepInterrupt(report()) from None
            _definition(journal, points, accept_versions)  # writes again what others deleted meanwhile
        files, warned = write_tables(definition, journal)
        outcome = evolve(report(), files=files, warned=warned)
        counts = (outcome.done, outcome.points, outcome.failed, outcome.crashed, outcome.seconds)
        logger.info("sweep %s: %d of %d points done, %d failed, %d crashed, in %.1f s", folder, *counts)
        return outcome


def _report(journal: Journal, before: int, begin: float, notes: Sequence[str]) -> SweepReport:
    """Progress of a sweep that began at the time ``begin``, when ``before`` points had been finished."""
    return SweepReport(
        folder=journal.folder,
        points=journal.points,
        done=journal.count("done"),
        failed=journal.count("failed"),
        crashed=journal.count("crashed"),
        before=before,
        seconds=time.perf_counter() - begin,
        notes=tuple(notes),
    )


def _definition(journal: Journal, points: Points, accept_versions: bool) -> SweepDefinition:
    """Definition of the sweep; it is written to the folder, with a copy of the scenario."""
    folder = journal.folder
    earlier = SweepDefinition.read(folder) if (folder / DEFINITION).exists() else None
    definition = points.definition.resume(earlier, folder, accept_versions) if earlier else points.definition
    if definition is not earlier:
        definition.save(folder)
    copy = folder / "scenario.yaml"
    document = points.scenario.document
    if document is not None and document.text and not copy.exists():
        with replace_file(copy) as file:  # a link of this name is not followed
            file.write(document.text)
    return definition


@define(eq=False)
class _Dispatch:
    """Sends batches of unfinished points to workers until all are finished, or one fails and ``fail_fast`` is set."""

    content: bytes
    journal: Journal
    workers: Workers
    fail_fast: bool
    show: Callable[[], object]
    queue: deque[int] = field(init=False)
    #: Unfinished points of batches that have terminated their worker.
    suspects: set[int] = field(factory=set)
    #: Suspects that are still to be run alone.
    alone: deque[int] = field(factory=deque)
    #: Batches that have been sent.
    pending: dict[Future[Any], list[int]] = field(factory=dict)

    def run(self) -> None:
        self.queue = deque(self.journal.open_points())
        failed = self.journal.count(*FAILED)
        try:
            while self._send():
                for future in wait(self.pending, _CHECK_INTERVAL, FIRST_COMPLETED).done:
                    self._receive(future)
                if self.fail_fast and self.journal.count(*FAILED) > failed:
                    break
        finally:
            self._end()

    def _send(self) -> bool:
        """Send batches until every worker has enough, and return whether any are pending."""
        try:
            ahead = _AHEAD * self.workers.count
            while len(self.pending) < ahead and (self.queue or self.alone):
                batch = self._batch(ahead)
                self.pending[self.workers.submit(self.content, batch)] = batch
        except (OSError, EOFError, RuntimeError) as error:  # the executor was shut down or has broken down
            raise _lost_executor(error) from error
        return bool(self.pending)

    def _batch(self, ahead: int) -> list[int]:
        """Next batch; batches shrink towards the end, so that all workers finish together."""
        if self.alone:
            return [self.alone.popleft()]
        share = -(-self.journal.count(NOT_RUN) // (2 * ahead))
        return [self.queue.popleft() for _ in range(min(share, _MOST_IN_BATCH, len(self.queue)))]

    def _receive(self, future: Future[Any]) -> None:
        batch = self.pending.pop(future)
        try:
            entries = future.result()
        except UsageError:  # the worker differs from the client
            raise
        except self.workers.renewed:
            self.queue.extendleft(reversed(batch))
        except self.workers.deaths as error:
            self._blame(batch, isinstance(error, TimeoutError))
        except Exception as error:
            raise _lost_executor(error) from error
        else:
            self._record(batch, entries)
            self.queue.extendleft(reversed(batch[len(entries) :]))

    def _record(self, batch: list[int], entries: list[Entry]) -> None:
        self.journal.add(entries)
        logger.debug("points recorded: %d from %d", len(batch), batch[0])
        self.suspects.difference_update(batch)
        self.show()

    def _blame(self, batch: list[int], late: bool) -> None:
        """Run the points of a batch that terminated its worker one by one; record one that does so again."""
        error = _CRASH
        if late:
            limit = f"{self.workers.timeout:g} s"
            error = f"must take at most {limit} (was stopped; increase --timeout)"
        if len(batch) == 1 and (late or batch[0] in self.suspects):
            status = "failed" if late else "crashed"
            self._record(batch, [(batch[0], status, None, error)])
        else:  # the first time, another point may be the cause
            self.suspects.update(batch)
            self.alone.extend(batch)

    def _end(self) -> None:
        """Record the pending batches that end in time."""
        if not self.workers.isolates:  # otherwise cancelling terminates the worker
            for future in self.pending:
                future.cancel()
        for future in wait(self.pending, timeout=_LAST).done:
            if not future.cancelled() and future.exception() is None:
                self.journal.add(future.result())


def _lost_executor(error: BaseException) -> LostError:
    got = f"got {message_of(error)}; finished points are kept: run the sweep again"
    return LostError(f"the executor must keep running ({got})")


# ---------------------------------------------------------------- dry run

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
        journal.read()
    remaining = journal.count(NOT_RUN, *(FAILED if retry_failed else ()))
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
    points.evaluate(sample[:1])  # loads the code
    begin = time.perf_counter()
    entries: list[Entry] = []
    elapsed = 0.0
    while len(entries) < len(sample) and elapsed < _TIME_LIMIT:
        entries += points.evaluate(sample[len(entries) : 2 * len(entries) + 1])
        elapsed = time.perf_counter() - begin
    return elapsed / len(entries), [f"a measured point failed: {problem}" for *_, problem in entries if problem]
