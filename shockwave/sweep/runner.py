"""Running a sweep: batches to workers, lines to the journal, and suspects run alone."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import BrokenExecutor, Executor, Future, wait
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

from attrs import define, evolve, field

from shockwave.errors import InvalidValueError, UsageError
from shockwave.files import read_bytes
from shockwave.scenario.scenario import Scenario
from shockwave.sweep.executors import Crew, LostError, crew_of
from shockwave.sweep.header import EARLIER, header_of, plugins_of, settle
from shockwave.sweep.journal import COPY, CRASHED, DONE, FAILED, OPEN, Journal, written
from shockwave.sweep.opening import opened
from shockwave.sweep.points import Done, Order, Points, Refused, line_of, told, versions_of
from shockwave.sweep.report import SweepInterrupt, SweepReport
from shockwave.sweep.table import write_all

__all__ = ["notes_on", "points_of", "run_sweep"]

# Seconds of work in a batch, which is what a killed client loses; points in the first one, and in any.
_BATCH, _FIRST, _MOST = 0.5, 8, 2048
# Batches under way for each worker, so that none waits for the client.
_AHEAD = 2
# Seconds that batches under way have to end when the sweep is stopped.
_LAST = 1.5
# Most bytes of a scenario that are copied; the reader of scenarios has its own limit.
_MOST_SCENARIO = 2**24
_CRASHED = '"error": "the process that ran it has ended (a crash, or too little memory)"'


def points_of(scenario: Scenario | str | os.PathLike[str], apart: bool = False) -> Points:
    """The points of a scenario with a sweep, or of one in a file, whose scene is tried in a process ``apart``.

    Raises
    ------
    InvalidValueError
        When it has no sweep.
    """
    found = scenario if isinstance(scenario, Scenario) else opened(scenario, apart)
    sweep = found.sweep
    if sweep is None:
        problem = "must be given (got nothing; a mapping of grid, zip or points)"
        raise InvalidValueError.of(f"{found.path}: sweep" if found.path else "sweep", problem)
    if found.path is not None:  # workers have folders of their own
        found = evolve(found, path=found.path.absolute())
    given = found.document.data.get("simulate") if found.document is not None else None
    explicit = isinstance(given, dict) and given.get("waves") == "train"
    train = explicit or any(variable.name == "simulate.waves" for variable in sweep.variables)
    return Points(found, versions_of(plugins_of(found)), train)


def notes_on(points: Points) -> list[str]:
    """What of the scenario a sweep leaves out."""
    options = points.scenario.simulate
    given = [name for name in ("contacts", "record") if getattr(options, name)]
    return [f"simulate.{name} is left out: a sweep keeps no passages and no histories" for name in given]


def run_sweep(
    scenario: Scenario | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    executor: Executor | str | None = None,
    *,
    workers: int | None = None,
    fail_fast: bool = False,
    retry_failed: bool = False,
    accept_versions: bool = False,
    progress: Callable[[SweepReport], None] | None = None,
) -> SweepReport:
    """Run every point of a sweep that is not finished, and write the results.

    Each finished point is a line of the journal in ``folder``. Run again, a sweep goes on where it was, however it
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
    fail_fast : bool
        Stop at the first point that fails.
    retry_failed : bool
        Run points again that failed or crashed before.
    accept_versions : bool
        Go on though versions differ from those that the sweep was begun with.
    progress : callable, optional
        Is told how far it is, again and again.

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
        When the executor cannot be had or breaks down.
    SweepInterrupt
        A KeyboardInterrupt, after what was finished was written.
    """
    begin = time.perf_counter()
    points = points_of(scenario, apart=isinstance(executor, str | None))
    header: Mapping[str, Any] = header_of(points)
    journal = Journal.opened(Path(folder), len(points.sweep))
    try:
        header = settle(journal.folder, header, accept_versions)
        journal.begin()
        notes = (*journal.notes, *notes_on(points), *_check_keys(journal, points, header))
        _copy(points.scenario, journal.folder)
        if retry_failed:
            journal.reopen()
        before = len(points.sweep) - journal.count(OPEN)

        def report() -> SweepReport:
            return _report(journal, before, time.perf_counter() - begin, notes)

        work: _Work | None = None
        if journal.count(OPEN):
            try:
                with _working(executor, workers, points) as (crew, order):
                    tell = (lambda: progress(report())) if progress is not None else lambda: None
                    work = _Work(points, journal, crew, order, fail_fast, tell)
                    work.run()
            except KeyboardInterrupt:
                raise SweepInterrupt(report()) from None
        files = write_all(journal.folder)
        batches, overhead = (work.batches, work.overhead) if work is not None else (0, 0.0)
        return evolve(report(), files=tuple(files), batches=batches, overhead=overhead)
    finally:
        journal.close()


def _report(journal: Journal, before: int, seconds: float, notes: tuple[str, ...]) -> SweepReport:
    return SweepReport(
        folder=journal.folder,
        points=len(journal.states),
        done=journal.count(DONE),
        failed=journal.count(FAILED),
        crashed=journal.count(CRASHED),
        before=before,
        seconds=seconds,
        notes=notes,
    )


def _check_keys(journal: Journal, points: Points, header: Mapping[str, Any]) -> list[str]:
    """Hold the first and the last result against their points, as a journal may be of another folder; what is told."""
    if EARLIER in header:
        others = "; ".join(", ".join(f"{name} {version}" for name, version in one.items()) for one in header[EARLIER])
        return [f"points may have been run with other versions than those in use ({others})"]
    for index, there in journal.ends:
        if points.key(index) != there:
            problem = f"must be of this sweep (got another key for point {index}; choose another folder)"
            raise InvalidValueError.of(str(journal.path), problem)
    return []


def _copy(scenario: Scenario, folder: Path) -> None:
    """Put the scenario file beside the results, for people."""
    if scenario.path is None or (folder / COPY).exists():
        return
    written(folder / COPY, read_bytes(scenario.path, _MOST_SCENARIO))


@contextmanager
def _working(executor: Executor | str | None, workers: int | None, points: Points) -> Iterator[tuple[Crew, Order]]:
    """The crew and its order; at the end the workers are ended, at once if something went wrong."""
    try:
        order = Order.of(points)
    except Exception as error:  # whatever pickle raises
        got = f"got {type(error).__name__}: {error}; define its profile in a module"
        raise UsageError(f"a scenario must be one that can be sent to other processes ({got})") from error
    crew = crew_of(executor, workers)
    try:
        crew.check(order)
        yield crew, order
    finally:
        crew.close()


@define(eq=False)
class _Work:
    """Sends batches of open points until none is left, or until one fails if ``fail_fast``."""

    points: Points
    journal: Journal
    crew: Crew
    order: Order
    fail_fast: bool
    tell: Callable[[], None]
    size: int = _FIRST
    unsent: int = field(init=False)
    flying: dict[Future[Any], list[int]] = field(factory=dict, init=False)
    suspects: list[list[int]] = field(factory=list, init=False)
    stopped: bool = field(default=False, init=False)
    batches: int = field(default=0, init=False)
    worked: float = field(default=0.0, init=False)
    #: Seconds of a worker for each batch that were not spent on its points.
    overhead: float = field(default=0.0, init=False)

    def run(self) -> None:
        begin = time.perf_counter()
        self.unsent = self.journal.count(OPEN)
        left = self.journal.open_points()
        try:
            while not self.stopped:
                if self.suspects and not self.flying:
                    self._run_alone()
                self._fill(left)
                if self.flying:
                    self._take(self.crew.wait(self.flying))
                elif not self.suspects:
                    break
        except KeyboardInterrupt:
            self._end(_LAST)
            raise
        seconds = time.perf_counter() - begin
        self.overhead = max(seconds * self.crew.workers - self.worked, 0.0) / max(self.batches, 1)
        self._end(0.0)

    def _fill(self, left: Iterator[int]) -> None:
        """Send batches, smaller ones towards the end, so that all workers end together."""
        wanted = _AHEAD * self.crew.workers
        while len(self.flying) < wanted and not self.suspects:
            share = -(-self.unsent // wanted)
            batch = list(islice(left, max(1, min(self.size, share))))
            if not batch:
                return
            self.unsent -= len(batch)
            self._send(batch, self.order._replace(content=None))

    def _send(self, batch: list[int], order: Order) -> None:
        try:
            self.flying[self.crew.submit(order, batch)] = batch
        except BrokenExecutor:
            self.suspects.append(batch)
        except RuntimeError as error:  # it was shut down
            raise _lost(error) from error

    def _take(self, ready: Iterable[Future[Any]]) -> None:
        broken = not ready
        for future in ready:
            batch = self.flying.pop(future)
            try:
                answer = future.result()
            except KeyboardInterrupt:
                raise
            except BaseException as error:
                self.suspects.append(batch)
                if not _ends_worker(error):
                    raise _lost(error) from error
                broken |= isinstance(error, BrokenExecutor)
                continue
            if answer is None:
                self._send(batch, self.order)
            elif rest := self._record(batch, answer):
                self._send(rest, self.order._replace(content=None))
        if broken:
            # what has not come by now will not come
            late = wait(self.flying, timeout=_LAST if ready else 0).done
            self.suspects += [batch for future, batch in self.flying.items() if future not in late]
            self.flying = {future: self.flying[future] for future in late}
            if late:
                self._take(late)

    def _record(self, batch: list[int], answer: Done | Refused) -> list[int]:
        """Note what was answered; what is left of the batch."""
        if isinstance(answer, Refused):
            raise UsageError(answer.reason)
        self.journal.add(answer.lines)
        self.batches += 1
        self.worked += answer.seconds
        lines = answer.lines.splitlines()
        for index, line in zip(batch, lines, strict=False):
            self.journal.states[index] = FAILED if '"status": "failed"' in line else DONE
        wanted = int(_BATCH * len(lines) / max(answer.seconds, 1e-9))
        self.size = max(1, min(wanted, 4 * self.size, _MOST))
        self.stopped |= self.fail_fast and answer.failed > 0
        self.tell()
        return batch[len(lines) :]

    # ------------------------------------------------------------ suspects

    def _run_alone(self) -> None:
        """Run batches alone whose worker has died, in halves while it dies again: the guilty point is left."""
        if not self.crew.isolates:
            self.crew.renew(self.crew.workers)
        self.crew.renew(1)
        while self.suspects and not self.stopped:
            batch = self.suspects.pop()
            # somebody else may have ended the process: a point alone is tried twice
            tries = 2 if len(batch) == 1 else 1
            if any(self._survives(batch) for _ in range(tries)):
                continue
            if len(batch) > 1:
                middle = len(batch) // 2
                self.suspects += [batch[middle:], batch[:middle]]
                continue
            self.journal.add(line_of(batch[0], self.points.key_of_values(batch[0]), "crashed", _CRASHED))
            self.journal.states[batch[0]] = CRASHED
            self.stopped |= self.fail_fast
            self.tell()
        self.crew.renew(self.crew.workers)

    def _survives(self, batch: list[int]) -> bool:
        try:
            (future,) = self.crew.wait([self.crew.submit(self.order, batch)]) or (None,)
            answer = future.result() if future is not None else None
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            if not _ends_worker(error):
                raise _lost(error) from error
            answer = None
        if answer is None:
            self.crew.renew(1)
            return False
        if rest := self._record(batch, answer):
            self.suspects.append(rest)
        return True

    def _end(self, patience: float) -> None:
        """Write what still comes, in some seconds, of the batches under way."""
        for future in self.flying:
            future.cancel()
        for future in wait(self.flying, timeout=patience).done:
            if not future.cancelled() and future.exception() is None and isinstance(future.result(), Done):
                self._record(self.flying[future], future.result())


def _ends_worker(error: BaseException) -> bool:
    """Whether it says that the process has ended that ran a batch."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"


def _lost(error: BaseException) -> LostError:
    got = f"got {told(error)}; run it again: what is finished is kept"
    return LostError(f"the executor must go on running batches ({got})")
