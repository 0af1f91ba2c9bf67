"""Running of a sweep: batches to workers, and lines to the journal."""

from __future__ import annotations

import json
import os
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from pathlib import Path
from typing import Any

from attrs import define, evolve, field

from shockwave.errors import InvalidValueError, UsageError
from shockwave.files import read_text, replacing
from shockwave.scenario.loader import load_scenario
from shockwave.scenario.scenario import Scenario
from shockwave.sweep.definition import DEFINITION, SweepDefinition
from shockwave.sweep.journal import NOT_RUN, Journal, line_of
from shockwave.sweep.point_evaluation import Points, content_of, error_text
from shockwave.sweep.report import SweepInterrupt, SweepReport
from shockwave.sweep.tables import write_tables
from shockwave.sweep.workers import LostError, Workers, workers_of

# Most points in a batch: a worker answers after a while with those that are finished.
_MOST = 512
# Batches under way for each worker, so that none waits for the client.
_AHEAD = 2
# Longest time between two looks at the number of workers [s].
_LOOK = 5
# Seconds that batches under way have to end when the sweep is stopped.
_LAST = 1.5
# Most bytes of a scenario that are copied; the reader of scenarios has its own limit.
_MOST_SCENARIO = 2**24
_CRASH = "the process that ran it has ended (a crash, or too little memory)"


def points_of(scenario: Scenario | str | os.PathLike[str]) -> Points:
    """The points of a scenario with a sweep, or of one in a file.

    Raises
    ------
    InvalidValueError
        When it has no sweep.
    """
    found = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
    if found.sweep is None:
        problem = "must be given (got nothing; a mapping of grid, zip or points)"
        raise InvalidValueError.of(f"{found.path}: sweep" if found.path else "sweep", problem)
    if found.path is not None:  # workers have folders of their own
        found = evolve(found, path=found.path.absolute())
    return Points(found)


def run_sweep(
    scenario: Scenario | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    executor: Executor | str | None = None,
    *,
    workers: int | None = None,
    timeout: float | None = None,
    fail_fast: bool = False,
    retry_failed: bool = False,
    accept_versions: bool = False,
    progress: Callable[[SweepReport], None] | None = None,
) -> SweepReport:
    """Run every point of a sweep that is not finished, and write the results.

    Each finished point is a line of the journal in ``folder``. Run again, a sweep resumes where it was, however it
    ended.

    Parameters
    ----------
    scenario : Scenario or path-like
        With a block ``sweep``.
    folder : path-like
        Where it is kept: new, or of the same sweep.
    executor : concurrent.futures.Executor or str, optional
        What runs it: one that is there, or ``processes``, ``dask``, ``dask=ADDRESS``. Left out: processes.
    workers : int, optional
        How many; left out, as many as the executor has, or as there are cores.
    timeout : float, optional
        Longest time of one point [s]: a point that takes longer is stopped and noted as failed. For processes only.
    fail_fast : bool
        Stop at the first point that fails.
    retry_failed : bool
        Run points again that failed or crashed before.
    accept_versions : bool
        Resume though versions differ from those that the sweep was begun with.
    progress : callable, optional
        Called with a report again and again.

    Returns
    -------
    SweepReport
        How it ended. The results stand in ``folder``.

    Raises
    ------
    ScenarioError, InvalidValueError
        When the scenario is not valid, has no sweep, or is not the one that ``folder`` is of.
    FileAccessError
        When a file cannot be read or written; the message names it, and what was finished is kept.
    UsageError, ShockwaveError
        When the executor is not available or breaks down.
    SweepInterrupt
        A KeyboardInterrupt, after what was finished was written.
    """
    begin = time.perf_counter()
    points = points_of(scenario)
    journal = Journal(Path(folder), len(points.sweep))
    with journal.locked():
        definition = _definition(journal, points, accept_versions)
        notes = [*journal.read(definition.columns), *definition.version_notes]
        if retry_failed:
            journal.reopen()
        before = journal.points - journal.count(NOT_RUN)

        def report() -> SweepReport:
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

        if before < journal.points:
            content = content_of(points)
            try:
                with workers_of(executor, workers, timeout) as crew:
                    _Dispatch(content, journal, crew, fail_fast, lambda: progress and progress(report())).run()
            except KeyboardInterrupt:
                raise SweepInterrupt(report()) from None
        return evolve(report(), files=write_tables(definition, journal))


def _definition(journal: Journal, points: Points, accept_versions: bool) -> SweepDefinition:
    """The definition of the sweep, which is written to the folder beside a copy of the scenario."""
    folder = journal.folder
    there = SweepDefinition.read(folder) if (folder / DEFINITION).exists() else None
    definition = points.definition.resumed(there, folder, accept_versions) if there else points.definition
    if definition is not there:
        definition.write(folder)
    copy = folder / "scenario.yaml"
    if points.scenario.path is not None and not copy.exists():
        with replacing(copy) as file:
            file.write(read_text(points.scenario.path, _MOST_SCENARIO))
    return definition


@define(eq=False)
class _Dispatch:
    """Sends batches of open points to workers until none is left, or until one fails if ``fail_fast``."""

    content: bytes
    journal: Journal
    workers: Workers
    fail_fast: bool
    show: Callable[[], object]
    queue: deque[int] = field(init=False)
    #: Points whose batch has ended its worker, until they are finished; and those of them that are to run alone.
    suspects: set[int] = field(factory=set)
    alone: deque[int] = field(factory=deque)
    flying: dict[Future[Any], list[int]] = field(factory=dict)

    def run(self) -> None:
        self.queue = deque(self.journal.open_points())
        failed = self.journal.count("failed", "crashed")
        try:
            while self._send():
                for future in wait(self.flying, _LOOK, FIRST_COMPLETED).done:
                    self._take(future)
                if self.fail_fast and self.journal.count("failed", "crashed") > failed:
                    break
        finally:
            self._end()

    def _send(self) -> bool:
        """Send batches until every worker has enough; whether any are under way."""
        try:
            ahead = _AHEAD * self.workers.count
            # a suspect runs alone where its end could be the fault of others
            most = 1 if self.suspects and not self.workers.isolates else ahead
            while len(self.flying) < most and (self.queue or self.alone):
                batch = self._batch(ahead)
                self.flying[self.workers.submit(self.content, batch)] = batch
        except (OSError, RuntimeError) as error:  # it was shut down, or has broken down
            raise _lost(error) from error
        return bool(self.flying)

    def _batch(self, ahead: int) -> list[int]:
        """The next points; fewer towards the end, so that all workers end together."""
        if self.alone:
            return [self.alone.popleft()]
        share = -(-self.journal.count(NOT_RUN) // (2 * ahead))
        return [self.queue.popleft() for _ in range(min(share, _MOST, len(self.queue)))]

    def _take(self, future: Future[Any]) -> None:
        batch = self.flying.pop(future)
        try:
            lines = future.result()
        except UsageError:  # the worker cannot take part
            raise
        except self.workers.renewed:
            self.queue.extendleft(reversed(batch))
        except self.workers.deaths as error:
            self._blame(batch, isinstance(error, TimeoutError))
        except Exception as error:
            raise _lost(error) from error
        else:
            self._record(batch, lines)
            self.queue.extendleft(reversed(batch[lines.count("\n") :]))

    def _record(self, batch: list[int], lines: str) -> None:
        self.journal.add(lines)
        self.suspects.difference_update(batch)
        self.show()

    def _blame(self, batch: list[int], late: bool) -> None:
        """Have the points of a batch that has ended its worker run one by one; note one that does so again."""
        error = _CRASH
        if late:
            limit = f"{self.workers.timeout:g} s"
            error = f"must take at most {limit} (was stopped; a greater --timeout allows more)"
        if len(batch) == 1 and (late or batch[0] in self.suspects):
            status = "failed" if late else "crashed"
            self._record(batch, line_of(batch[0], status, f'"error": {json.dumps(error)}'))
        else:  # the first time may be somebody else's fault
            self.suspects.update(batch)
            self.alone.extend(batch)

    def _end(self) -> None:
        """Write what still comes, in some seconds, of the batches under way."""
        if not self.workers.isolates:  # to cancel would end the worker
            for future in self.flying:
                future.cancel()
        for future in wait(self.flying, timeout=_LAST).done:
            if not future.cancelled() and future.exception() is None:
                self.journal.add(future.result())


def _lost(error: BaseException) -> LostError:
    got = f"got {error_text(error)}; run it again: what is finished is kept"
    return LostError(f"the executor must go on running batches ({got})")
