"""Workers of a sweep: processes of this machine, those of a dask scheduler, or an executor of the caller."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import connection
from typing import Any

from pebble import ProcessExpired, ProcessPool

from shockwave import OWN_DISTRIBUTION
from shockwave.errors import ShockwaveError, UsageError
from shockwave.sweep.point_evaluation import SLICE, run_batch

# Seconds for a scheduler, and its first worker, to answer.
_PATIENCE = 30
# Seconds that a cluster may be without workers.
_LONELY = 60


class LostError(ShockwaveError):
    """The executor has broken down, and not because of a point."""


class Workers:
    """An executor that somebody else has made, and will end.

    Parameters
    ----------
    executor : object with the method ``submit`` of concurrent.futures.Executor
        Runs the batches.
    count : int
        The number of workers.
    """

    #: Raised by the future of a batch whose worker has ended.
    deaths: tuple[type[BaseException], ...] = ()
    #: Raised where the executor broke down, and has been started anew.
    renewed: tuple[type[BaseException], ...] = ()
    #: Whether a death is the fault of this batch, not of another one that the same worker had.
    isolates = False
    #: Longest time of a point [s].
    timeout: float | None = None

    def __init__(self, executor: Any, count: int) -> None:
        self.executor = executor
        self.count = count

    def submit(self, content: bytes, indices: list[int]) -> Future[Any]:
        """Have some points of a sweep run."""
        found: Future[Any] = self.executor.submit(run_batch, content, indices)
        return found


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def check_executor(name: str) -> None:
    """Refuse the name of an executor that there is not, with a `UsageError`."""
    if name != "processes" and name.partition("=")[0] != "dask":
        raise UsageError(f"executor must be processes, dask or dask=ADDRESS (got {name!r})")


@contextmanager
def workers_of(executor: Executor | str | None, count: int | None, timeout: float | None = None) -> Iterator[Workers]:
    """The workers that ``executor`` stands for; those started here are ended, even if they are at work.

    Parameters
    ----------
    executor : concurrent.futures.Executor or str, optional
        One that is there; or ``processes``, ``dask``, ``dask=ADDRESS``. Left out: processes.
    count : int, optional
        The number of workers. Left out, as many as there are cores, or as the executor has.
    timeout : float, optional
        Longest time of a point [s]; for processes only.

    Raises
    ------
    UsageError
        When it is none of these, or what it needs is not installed.
    LostError
        When no worker starts.
    """
    if count is not None and count < 1:
        raise UsageError(f"workers must be a whole number >= 1 (got {count!r})")
    if timeout is not None and not timeout > 0:
        raise UsageError(f"timeout must be a number of seconds > 0 (got {timeout!r})")
    if executor is None or executor == "processes":
        _check_start()
        own = Processes(count or cores(), timeout)
        try:
            yield own
        finally:
            own.close()
    elif timeout is not None:
        problem = "only processes of this machine can be ended; leave it, or the executor, out"
        raise UsageError(f"timeout must be left out with an executor (got {executor!r}; {problem})")
    elif isinstance(executor, str):
        check_executor(executor)
        with _dask(executor.partition("=")[2], count) as remote:
            yield remote
    else:
        yield Workers(executor, count or getattr(executor, "_max_workers", None) or cores())


# ---------------------------------------------------------------- processes of this machine

_START: Any = multiprocessing.get_context("forkserver" if sys.platform != "win32" else "spawn")
# Times that the pool is begun anew.
_RENEWALS = 20
# Seconds after which the end of a process is reported.
_LATE = 0.3


class _Process(_START.Process):  # type: ignore[misc]
    """A process whose end the pool cannot miss, even if it ends before the pool has read which batch it has begun."""

    _end: float | None = None

    def is_alive(self) -> bool:
        """Whether the process runs, or has only just ended."""
        if super().is_alive():
            return True
        self._end = self._end or time.monotonic()
        return time.monotonic() - self._end < _LATE


class Processes(Workers):
    """Processes of this machine. One that dies or exceeds the time limit costs its batch alone."""

    deaths = (ProcessExpired, TimeoutError)
    renewed = (BrokenExecutor,)
    isolates = True

    def __init__(self, count: int, timeout: float | None = None) -> None:
        self.count = count
        self.timeout = timeout
        self.renewals = _RENEWALS
        self.pool = self._start()

    def _start(self) -> ProcessPool:
        context = type(_START)()
        context.Process = _Process
        return ProcessPool(self.count, initializer=_begin, context=context)

    def submit(self, content: bytes, indices: list[int]) -> Future[Any]:
        if not self.pool.active and self.renewals:  # it breaks down when an idle process is killed
            self.close()
            self.renewals -= 1
            self.pool = self._start()
        # points before the one that hangs take a slice, and those beside it twice as long
        extra = 3 * SLICE if len(indices) > 1 else 0.0
        limit = self.timeout and self.timeout + extra
        return self.pool.schedule(run_batch, (content, indices), timeout=limit)

    def close(self) -> None:
        """End the processes."""
        self.pool.stop()  # type: ignore[no-untyped-call]
        self.pool.join()


def _check_start() -> None:
    """Raise a LostError if no process starts."""
    if sys.platform != "win32":
        _START.set_forkserver_preload(["shockwave.sweep.point_evaluation"])
    first = _START.Process(target=cores)
    first.start()
    first.join()
    if first.exitcode != 0:
        remedy = "a program that calls run_sweep is a file, and does so under `if __name__ == '__main__':`"
        raise LostError(f"worker processes must start (got status {first.exitcode}; {remedy})")


def _begin() -> None:
    """Prepare a process: keep off the output of the client, and end with it."""
    os.dup2(2, 1)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)


# ---------------------------------------------------------------- dask


class DaskWorkers(Workers):
    """Workers of a dask scheduler, each thread of a process being one; others may come and go meanwhile."""

    def __init__(self, client: Any, asked: int | None, killed: type[BaseException]) -> None:
        self.executor = client.get_executor(pure=False)
        self.client = client
        self.asked = asked
        self.deaths = (killed,)
        self.seen = time.monotonic()

    @property
    def count(self) -> int:  # type: ignore[override]
        """The number of workers to keep busy; raises a LostError when there has been none for a minute."""
        there = sum(self.client.nthreads().values())
        if there:
            self.seen = time.monotonic()
        elif time.monotonic() - self.seen > _LONELY:
            remedy = "run the sweep again: what is finished is kept"
            raise LostError(f"dask: a worker must be there (got none for {_LONELY} s; {remedy})")
        return self.asked or max(there, 1)


@contextmanager
def _dask(address: str, count: int | None) -> Iterator[Workers]:
    """The workers at ``address``, such as ``tcp://host:8786``; those of a cluster on this machine if it is empty."""
    try:
        distributed: Any = import_module("distributed")
        cluster = None if address else _local_cluster(distributed, count or cores())
    except ImportError as error:
        remedy = f"python -m pip install '{OWN_DISTRIBUTION}[dask]'"
        raise UsageError(f"executor dask must be installed (got {error}; {remedy})") from None
    client: Any = None
    try:
        client = distributed.Client(cluster or address, timeout=_PATIENCE, set_as_default=False)
        client.wait_for_workers(1, timeout=_PATIENCE)
        if cluster:  # interrupts of the terminal are for the client
            client.run(_ignore_interrupts)
    except (OSError, ValueError, TypeError) as error:
        name = address or "the local cluster"
        raise LostError(f"dask: {name} must answer and have a worker (got {error})") from None
    else:
        yield DaskWorkers(client, count, distributed.KilledWorker)
    finally:
        for one in filter(None, (client, cluster)):
            one.close()


def _ignore_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _local_cluster(distributed: Any, count: int) -> Any:
    """A cluster that only processes with its certificates can connect to, from this machine alone."""
    dask: Any = import_module("dask")
    # the sweep, not dask, repeats a batch whose worker dies
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}):
        return distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            host="127.0.0.1",
            security=distributed.Security.temporary(),
            dashboard_address=None,
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
        )
