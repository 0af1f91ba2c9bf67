"""Running of a sweep: batches to workers, and lines to the journal."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import BrokenExecutor, Executor, Future, wait
from itertools import islice
from pathlib import Path
from typing import Any

from attrs import define, evolve, field

from shockwave import OWN_DISTRIBUTION
from shockwave.errors import InvalidValueError, PluginError, ShockwaveError, UsageError
from shockwave.files import read_text, replacing
from shockwave.registry import find
from shockwave.scenario.loader import load_scenario, scenario_of
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.yaml_document import read_document
from shockwave.sweep.header import HEADER, Header
from shockwave.sweep.journal import CRASHED, DONE, FAILED, OPEN, SCENARIO_COPY, Journal, line_of
from shockwave.sweep.points import Done, Points, content_of, error_text
from shockwave.sweep.report import SweepInterrupt, SweepReport
from shockwave.sweep.tables import write_tables
from shockwave.sweep.workers import LostError, Workers, processes, workers_of

# Seconds of work in a batch, which is what a killed client loses.
_BATCH = 0.5
# Points in the first batches, and in any.
_FIRST = 8
_MOST = 2048
# Batches under way for each worker, so that none waits for the client.
_AHEAD = 2
# Seconds that batches under way have to end when the sweep is stopped.
_LAST = 1.5
# Times that a point may end its process: the first time may be somebody else's fault.
_TRIES = 2
# Most bytes of a scenario that are copied; the reader of scenarios has its own limit.
_MOST_SCENARIO = 2**24
_CRASHED = '"error": "the process that ran it has ended (a crash, or too little memory)"'
# Points whose scene may end the process that builds it, before the sweep is refused.
_MOST_ENDED = 8


# ---------------------------------------------------------------- the scenario


def points_of(scenario: Scenario | str | os.PathLike[str], apart: bool = False, timeout: float | None = None) -> Points:
    """The points of a scenario with a sweep, or of one in a file.

    Parameters
    ----------
    scenario : Scenario or path-like
        The scenario.
    apart : bool
        Whether a scene of a file whose profile may be a plugin's is tried in a process of its own.
    timeout : float, optional
        Longest time of that [s].

    Raises
    ------
    InvalidValueError
        When it has no sweep.
    PluginError
        When each of the first points ends its process, or takes longer than ``timeout``.
    """
    if isinstance(scenario, Scenario):
        found = scenario
    else:
        found = _loaded_apart(Path(scenario), timeout) if apart else load_scenario(scenario)
    if found.sweep is None:
        problem = "must be given (got nothing; a mapping of grid or zip)"
        raise InvalidValueError.of(f"{found.path}: sweep" if found.path else "sweep", problem)
    if found.path is not None:  # workers have folders of their own
        found = evolve(found, path=found.path.absolute())
    return Points(found)


def _loaded_apart(path: Path, timeout: float | None) -> Scenario:
    """The scenario in a file, as `load_scenario` gives it, begun with a point whose scene ends no process."""
    document = read_document(path)
    begin = _first_sound(path.absolute(), timeout) if _has_plugin(document.data) else 0
    return scenario_of(document, path, slice(begin, None))


def _has_plugin(data: Mapping[str, Any]) -> bool:
    """Whether the profile may be that of a plugin."""
    if "'shock.profile'" in repr(data.get("sweep")):
        return True
    try:
        return find("profiles", data["shock"]["profile"]).distribution != OWN_DISTRIBUTION
    except (ShockwaveError, KeyError, TypeError):  # reported where the scene is built
        return False


def _first_sound(path: Path, timeout: float | None) -> int:
    with processes(1) as own:
        for attempt in range(_MOST_ENDED):
            try:
                own.schedule(_build, (path, attempt), timeout).result()
                return attempt
            except (*own.deaths, BrokenExecutor):
                continue
    got = f"got {_MOST_ENDED} points that end the process that builds their scene; mend the plugin"
    raise PluginError(f"{path}: the profile must take some values of the sweep ({got})")


def _build(path: Path, attempt: int) -> None:
    try:
        scenario_of(read_document(path), path, slice(attempt, attempt + 1))
    except (Exception, SystemExit):  # reported by the client
        return


# ---------------------------------------------------------------- the sweep


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
    points = points_of(scenario, apart=executor is None or isinstance(executor, str), timeout=timeout)
    journal = Journal(Path(folder), bytearray(len(points.sweep)))
    journal.lock()
    try:
        notes = (*points.notes, *_open(journal, points, accept_versions))
        if retry_failed:
            journal.reopen()
        before = len(points.sweep) - journal.count(OPEN)

        def report() -> SweepReport:
            return SweepReport(
                folder=journal.folder,
                points=len(points.sweep),
                done=journal.count(DONE),
                failed=journal.count(FAILED),
                crashed=journal.count(CRASHED),
                before=before,
                seconds=time.perf_counter() - begin,
                notes=notes,
            )

        batches, overhead = 0, 0.0
        if journal.count(OPEN):
            content = _content(points)
            try:
                with workers_of(executor, workers, timeout) as crew:
                    work = _Work(points, journal, crew, content, fail_fast, lambda: progress and progress(report()))
                    work.run()
                    batches, overhead = work.batches, work.overhead
            except KeyboardInterrupt:
                raise SweepInterrupt(report()) from None
        files = write_tables(journal.folder)
        return evolve(report(), files=tuple(files), batches=batches, overhead=overhead)
    finally:
        journal.close()


def _open(journal: Journal, points: Points, accept_versions: bool) -> list[str]:
    """Read what the folder has of this sweep and make ready for more; notes on what was found."""
    header = points.header
    there = Header.read(journal.folder) if (journal.folder / HEADER).exists() else None
    settled = header.continued(there, journal.folder, accept_versions) if there else header
    if settled is not there:
        settled.write(journal.folder)
    journal.read(mend=True)
    for index, key in () if settled.earlier_versions else journal.ends:
        if points.key(index) != key:
            problem = f"must be of this sweep (got another key for point {index}; choose another folder)"
            raise InvalidValueError.of(str(journal.path), problem)
    copy = journal.folder / SCENARIO_COPY
    if points.scenario.path is not None and not copy.exists():
        with replacing(copy) as file:
            file.write(read_text(points.scenario.path, _MOST_SCENARIO))
    return [*journal.notes, *([settled.version_note] if settled.version_note else [])]


def _content(points: Points) -> bytes:
    try:
        return content_of(points)
    except Exception as error:  # whatever pickle raises
        got = f"got {type(error).__name__}: {error}; define its profile in a module"
        raise UsageError(f"a scenario must be one that can be sent to other processes ({got})") from error


@define(eq=False)
class _Work:
    """Sends batches of open points until none is left, or until one fails if ``fail_fast``."""

    points: Points
    journal: Journal
    workers: Workers
    content: bytes
    fail_fast: bool
    tell: Callable[[], object]
    size: int = _FIRST
    flying: dict[Future[Any], list[int]] = field(factory=dict)
    #: Batches to be sent before others: what is left of one, and points whose batch has ended its worker.
    again: deque[list[int]] = field(factory=deque)
    #: How often each of these points has ended its worker alone.
    suspects: dict[int, int] = field(factory=dict)
    stopped: bool = False
    batches: int = 0
    worked: float = 0.0
    #: Seconds of a worker for each batch that were not spent on its points.
    overhead: float = 0.0

    def run(self) -> None:
        begin = time.perf_counter()
        left = self.journal.open_points()
        try:
            while not self.stopped:
                self._fill(left)
                if not self.flying:
                    break
                for future in self.workers.wait(self.flying):
                    self._take(future)
        except KeyboardInterrupt:
            self._end(_LAST)
            raise
        seconds = time.perf_counter() - begin
        self.overhead = max(seconds * self.workers.count - self.worked, 0.0) / max(self.batches, 1)
        self._end(0.0)

    def _fill(self, left: Iterator[int]) -> None:
        """Send batches, smaller ones towards the end, so that all workers end together."""
        ahead = _AHEAD * self.workers.count
        # suspects run alone where their end could be the fault of others
        most = 1 if self.suspects and not self.workers.isolates else ahead
        while len(self.flying) < most:
            share = -(-self.journal.count(OPEN) // ahead)
            size = max(1, min(self.size, share))
            batch = self.again.popleft() if self.again else list(islice(left, size))
            if not batch:
                return
            try:
                self.flying[self.workers.submit(self.content, batch)] = batch
            except RuntimeError as error:  # it was shut down, or has broken down
                raise _lost(error) from error

    def _take(self, future: Future[Any]) -> None:
        batch = self.flying.pop(future)
        try:
            answer = future.result()
        except UsageError:  # the worker cannot take part
            raise
        except self.workers.deaths as error:
            self._blame(batch, isinstance(error, TimeoutError))
        except Exception as error:
            if not (self.workers.isolates and isinstance(error, BrokenExecutor)):
                raise _lost(error) from error
            self.again.append(batch)
        else:
            self._record(batch, answer)

    def _record(self, batch: list[int], answer: Done) -> None:
        """Note what was answered; what is left of the batch is sent again."""
        done = answer.lines.count("\n")
        self.batches += 1
        self.worked += answer.seconds
        fit = int(_BATCH * done / max(answer.seconds, 1e-9))
        self.size = max(1, min(fit, 4 * self.size, _MOST))
        self._note(batch[:done], answer.lines)
        if batch[done:]:
            self.again.append(batch[done:])

    def _note(self, indices: Iterable[int], lines: str) -> None:
        before = self.journal.count(FAILED, CRASHED)
        self.journal.add(lines)
        for index in indices:
            self.suspects.pop(index, None)
        self.stopped |= self.fail_fast and self.journal.count(FAILED, CRASHED) > before
        self.tell()

    def _blame(self, batch: list[int], late: bool) -> None:
        """Have the points of a batch that has ended its worker run one by one, until one does so alone."""
        if len(batch) > 1:
            self.suspects |= dict.fromkeys(batch, 0)
            self.again += [[index] for index in batch]
            return
        (index,) = batch
        self.suspects[index] = self.suspects.get(index, 0) + 1
        key = self.points.key(index)
        if late:
            problem = f"must take at most {self.workers.timeout:g} s (was stopped; a greater --timeout allows more)"
            self._note(batch, line_of(index, key, "failed", f'"error": "{problem}"'))
        elif self.suspects[index] < _TRIES:
            self.again.append(batch)
        else:
            self._note(batch, line_of(index, key, "crashed", _CRASHED))

    def _end(self, patience: float) -> None:
        """Write what still comes, in some seconds, of the batches under way."""
        if not self.workers.isolates:  # to cancel would end the worker
            for future in self.flying:
                future.cancel()
        for future in wait(self.flying, timeout=patience).done:
            if not future.cancelled() and future.exception() is None and isinstance(future.result(), Done):
                self._record(self.flying[future], future.result())


def _lost(error: BaseException) -> LostError:
    got = f"got {error_text(error)}; run it again: what is finished is kept"
    return LostError(f"the executor must go on running batches ({got})")
