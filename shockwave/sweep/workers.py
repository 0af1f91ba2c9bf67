"""Workers of a sweep: processes on this machine, or an executor of the caller."""

from __future__ import annotations

import gc
import multiprocessing
import os
import threading
import time
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import closing, contextmanager
from multiprocessing import connection
from typing import Any

from pebble import ProcessExpired, ProcessPool

from shockwave.base.errors import ShockwaveError, UsageError, message_of
from shockwave.base.quantity_fields import Declaration
from shockwave.sweep.fork_server import FORK_SERVER, SPAWN, start_server
from shockwave.sweep.point_evaluation import GROWTH, SLICE, run_batch


class LostError(ShockwaveError):
    """The executor has broken down, not because of a point."""


class Workers:
    """An executor of the caller, who also shuts it down.

    Parameters
    ----------
    executor : concurrent.futures.Executor
        Runs the batches.
    count : int
        Number of workers.
    """

    #: Exceptions of a batch whose worker has terminated.
    deaths: tuple[type[BaseException], ...] = ()
    #: Exceptions after which the executor is started again.
    renewed: tuple[type[BaseException], ...] = ()
    #: Whether only the batch itself can have terminated its worker.
    isolates = False
    #: Time limit of a point [s].
    timeout: float | None = None

    def __init__(self, executor: Executor, count: int) -> None:
        self.executor = executor
        self.count = count

    def submit(self, content: bytes, indices: list[int]) -> Future[Any]:
        """Submit points of a sweep."""
        return self.executor.submit(run_batch, content, indices)


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


_COUNT = Declaration("", "number of workers", at_least=1, whole=True, optional=True)


def check_workers(executor: object, count: object, timeout: float | None) -> None:
    """Raise a `UsageError` if `workers_of` cannot take these arguments."""
    if problem := _COUNT.problem(count):
        raise UsageError(f"workers: {problem}")
    if not (executor is None or isinstance(executor, Executor)):
        hint = "; its get_executor() is one" if hasattr(executor, "get_executor") else ""
        raise UsageError(f"executor: must be a concurrent.futures.Executor (got {executor!r}{hint})")
    if timeout is not None and executor is not None:
        reason = "only processes on this machine can be stopped; omit the timeout or the executor"
        raise UsageError(f"timeout: must be omitted with an executor (got {executor!r}; {reason})")


@contextmanager
def workers_of(executor: Executor | None, count: int | None, timeout: float | None = None) -> Iterator[Workers]:
    """Start processes on this machine, or use ``executor``; processes started here are terminated at the end.

    Threads that start processes wait for each other. The arguments must have passed `check_workers`.

    Parameters
    ----------
    executor : concurrent.futures.Executor, optional
        An executor; default: processes on this machine.
    count : int, optional
        Number of workers; default: that of the executor, or the number of cores.
    timeout : float, optional
        Time limit of a point [s]; for processes only.

    Raises
    ------
    LostError
        If no worker starts.
    """
    if executor is None:
        with _ONE_AT_A_TIME, closing(Processes(count or cores(), timeout)) as own:
            yield own
    else:
        yield Workers(executor, count or getattr(executor, "_max_workers", None) or cores())


# ---------------------------------------------------------------- processes on this machine

# The library of processes may confuse the ends of processes of different threads, so only one thread uses it.
_ONE_AT_A_TIME = threading.RLock()
# Open files of the client, and those of each worker, with a margin.
_FILES = 24
_FILES_EACH = 3
# Most times that the pool is started again.
_RENEWALS = 20
# Time after which the end of a process is reported [s].
_LATE = 0.3


class _Late:
    """A process whose end is reported late, so that the pool first reads which batch the process had started."""

    _end: float | None = None

    def is_alive(self) -> bool:
        """Return whether the process runs, or ended less than `_LATE` ago."""
        alive: bool = super().is_alive()  # type: ignore[misc]
        if alive:
            return True
        self._end = self._end or time.monotonic()
        return time.monotonic() - self._end < _LATE


class _Forked(_Late, FORK_SERVER.Process):  # type: ignore[misc]
    pass


class _Spawned(_Late, SPAWN.Process):  # type: ignore[misc]
    pass


class Processes(Workers):
    """Processes on this machine. One that crashes or exceeds the time limit affects only its own batch."""

    deaths = (ProcessExpired, TimeoutError)
    renewed = (BrokenExecutor,)
    isolates = True

    def __init__(self, count: int, timeout: float | None = None) -> None:
        self.count = count
        self.timeout = timeout
        self.renewals = _RENEWALS
        _check_start(count)
        self.pool = self._start()

    def _start(self) -> ProcessPool:
        start = start_server()
        context = type(start)()
        context.Process = _Spawned if start is SPAWN else _Forked
        return ProcessPool(self.count, initializer=_begin, context=context)

    def submit(self, content: bytes, indices: list[int]) -> Future[Any]:
        if not self.pool.active and self.renewals:  # the pool breaks down when an idle process is killed
            self.close()
            self.renewals -= 1
            self.pool = self._start()
        # the points before the one that hangs take a slice, those in the same call GROWTH times as long
        extra = (1 + GROWTH) * SLICE if len(indices) > 1 else 0.0
        limit = self.timeout and self.timeout + extra
        return self.pool.schedule(run_batch, (content, indices), timeout=limit)

    def close(self) -> None:
        """Terminate the processes."""
        self.pool.stop()  # type: ignore[no-untyped-call]
        self.pool.join()


def _check_start(count: int) -> None:
    """Raise a `LostError` if ``count`` processes cannot start."""
    least, most = _FILES + _FILES_EACH * count, os.sysconf("SC_OPEN_MAX") if hasattr(os, "sysconf") else -1
    if 0 <= most < least:  # -1 stands for no limit
        raise LostError(f"the limit of open files must be at least {least} (got {most}; use `ulimit -n {least}`)")
    remedy = "call run_sweep from a program in a file, under `if __name__ == '__main__':`"
    first = start_server().Process(target=cores)
    try:
        first.start()
        first.join()
        got = f"status {first.exitcode}" if first.exitcode else ""
    except (OSError, EOFError) as error:  # as without memory or files for another process
        got, remedy = message_of(error), "use fewer workers"
    if got:
        raise LostError(f"worker processes must start (got {got}; {remedy})")


def _begin() -> None:
    """Prepare a process: it does not write to the output of the client, and ends with the client."""
    os.dup2(2, 1)
    gc.freeze()  # the modules stay: each collection would visit them
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)
