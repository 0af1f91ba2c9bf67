"""Executors: what runs the batches of a sweep, on this machine or on many."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from multiprocessing import connection
from typing import Any, Protocol

from attrs import define, field

from shockwave.errors import ShockwaveError, UsageError
from shockwave.sweep.points import Order, do, ready

__all__ = ["Crew", "LostError", "Passed", "Processes", "check_name", "cores", "crew_of", "safe_path", "uninterrupted"]

# Times that workers may fail to start, one after the other.
_STARTS = 3
# Seconds after which it is looked whether workers are alive.
_CHECK = 1.0
# Variable that keeps Python from importing modules from the current folder.
_SAFE_PATH = "PYTHONSAFEPATH"


class LostError(ShockwaveError):
    """The executor has broken down, and not because of a point."""


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def safe_path() -> Iterator[None]:
    """Keep Python processes that start meanwhile from importing modules from the current folder.

    Processes of multiprocessing start with that folder on their path, and adopt the path of this process only after the
    first imports: a ``numpy.py`` in that folder would be run.
    """
    before = os.environ.get(_SAFE_PATH)
    os.environ[_SAFE_PATH] = "1"
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(_SAFE_PATH, None)
        else:
            os.environ[_SAFE_PATH] = before


@contextmanager
def uninterrupted() -> Iterator[None]:
    """An interrupt is raised at the end; processes that are begun meanwhile leave interrupts to this one for ever.

    These processes also run with `safe_path`.
    """
    masks = hasattr(signal, "pthread_sigmask")
    if masks:
        from multiprocessing import resource_tracker

        # begun later, it would take the mask off
        with safe_path():
            resource_tracker.ensure_running()
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    main, came = threading.current_thread() is threading.main_thread(), list[int]()
    if main:  # another thread may be told of it, mask or not
        handler = signal.signal(signal.SIGINT, lambda number, _: came.append(number))
    try:
        with safe_path():
            yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if main:
            signal.signal(signal.SIGINT, handler)
        if came:
            raise KeyboardInterrupt


class Crew(Protocol):
    """Workers.

    ``isolates`` says that a batch that ends its worker can be told from others, by running it alone after `renew`.
    """

    isolates: bool

    @property
    def workers(self) -> int:
        """How many there are."""

    def submit(self, order: Order, indices: list[int]) -> Future[Any]:
        """Have some points run."""

    def wait(self, futures: Iterable[Future[Any]]) -> set[Future[Any]]:
        """Wait for one of ``futures``: those that are done; none if none will be, as workers have ended."""

    def renew(self, workers: int) -> None:
        """New workers in place of those that have ended."""

    def check(self, order: Order) -> None:
        """Refuse workers that would not do, if they can be asked before the first batch."""

    def close(self) -> None:
        """End the workers that are this crew's own, even if they are at work."""


@define(eq=False)
class Passed:
    """An executor that somebody else has made, and will end."""

    executor: Executor
    workers: int
    isolates: bool = field(default=False, init=False)

    def submit(self, order: Order, indices: list[int]) -> Future[Any]:
        return self.executor.submit(do, order, indices)

    def wait(self, futures: Iterable[Future[Any]]) -> set[Future[Any]]:
        return wait(futures, return_when=FIRST_COMPLETED).done

    def renew(self, workers: int) -> None:
        raise LostError("the executor has broken down: make a new one and run again; what is finished is kept")

    def check(self, order: Order) -> None:
        pass

    def close(self) -> None:
        pass


class _Context:
    """A way to start processes that copies no threads and no locks of this one, and that knows its children."""

    def __init__(self) -> None:
        known = multiprocessing.get_all_start_methods()
        self.own = multiprocessing.get_context("forkserver" if "forkserver" in known else "spawn")
        if "forkserver" in known:
            self.own.set_forkserver_preload(["shockwave.sweep.points"])
            from multiprocessing import forkserver

            with uninterrupted():
                forkserver.ensure_running()
        self._children: list[Any] = []
        self._results: Any = None

    def Process(self, *arguments: Any, **named: Any) -> Any:  # noqa: N802
        """As that of multiprocessing; noted, since a pool begins its processes one by one, as it needs them."""
        child = self.own.Process(*arguments, **named)  # type: ignore[attr-defined]
        self._children.append(child)
        return child

    def SimpleQueue(self) -> Any:  # noqa: N802
        """As that of multiprocessing; noted, as the one that results come back through."""
        self._results = self.own.SimpleQueue()
        return self._results

    def lacks(self) -> bool:
        """Whether one of the processes has ended."""
        return bool(connection.wait([child.sentinel for child in self._begun()], timeout=0))

    def kill(self) -> None:
        """End all processes."""
        for child in self._begun():
            child.kill()

    def cut(self) -> None:
        """Let whoever waits for the rest of a message know that there will be none."""
        if self._results is not None:
            self._results.close()

    def _begun(self) -> list[Any]:
        # an interrupt may have kept one from beginning
        return [child for child in self._children if child.pid is not None]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.own, name)


@define(eq=False)
class Processes:
    """Processes of this machine, begun anew when one of them dies."""

    workers: int
    isolates: bool = field(default=True, init=False)
    _pool: ProcessPoolExecutor | None = field(default=None, init=False)
    _context: _Context = field(factory=_Context, init=False)

    def submit(self, order: Order, indices: list[int]) -> Future[Any]:
        return self.call(do, order, indices)

    def call(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Have a function run."""
        if self._pool is None:
            self.renew(self.workers)
        assert self._pool is not None
        # it may begin a process, which would be left half begun
        with uninterrupted():
            return self._pool.submit(function, *arguments)

    def wait(self, futures: Iterable[Future[Any]]) -> set[Future[Any]]:
        known, dead = list(futures), False
        while True:
            done = wait(known, timeout=_CHECK, return_when=FIRST_COMPLETED).done
            before, dead = dead, self._context.lacks()
            # a pool tells that a worker has ended, but not if it ended within a message, for whose rest the pool waits
            if done or (before and dead):
                return done

    def renew(self, workers: int) -> None:
        for _ in range(_STARTS):
            self.close()
            self._context = _Context()
            context: Any = self._context
            self._pool = ProcessPoolExecutor(
                workers, mp_context=context, initializer=_begin, initargs=(dict(os.environ),)
            )
            # until a worker has answered, no point is to blame for its end
            if any(future.exception() is None for future in self.wait([self.call(ready)])):
                return
        remedy = "a program that calls run_sweep is a file, and does so under `if __name__ == '__main__':`"
        raise LostError(f"worker processes must start (got {_STARTS} that ended at once; {remedy})")

    def check(self, order: Order) -> None:
        pass

    def close(self) -> None:
        if self._pool is None:
            return
        self._context.kill()
        end = threading.Thread(target=_shut, args=(self._pool,), daemon=True)
        end.start()
        end.join(_CHECK)
        if end.is_alive():
            self._context.cut()
            end.join(_CHECK)
        self._pool = None


def _shut(pool: ProcessPoolExecutor) -> None:
    with suppress(OSError):  # its connection may be closed meanwhile
        pool.shutdown(cancel_futures=True)


def _begin(environment: dict[str, str]) -> None:
    """What a worker does first: leave interrupts to the client, end with it, and keep off its output.

    The environment is that of the client, not the one in which the server of processes was begun.
    """
    os.environ.clear()
    os.environ.update(environment)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.dup2(2, 1)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)


def check_name(executor: str | None) -> str:
    """The name of an executor, ``processes`` if none is given; a UsageError if it is none."""
    name = "processes" if executor is None else executor
    if name not in ("processes", "dask") and not name.startswith("dask="):
        raise UsageError(f"executor must be processes, dask or dask=ADDRESS (got {executor!r})")
    return name


def crew_of(executor: Executor | str | None, workers: int | None) -> Crew:
    """The crew that ``executor`` stands for.

    Parameters
    ----------
    executor : concurrent.futures.Executor or str, optional
        One that is there; or ``processes``, ``dask``, ``dask=ADDRESS``. Left out: processes.
    workers : int, optional
        How many. Left out, as many as there are cores, or as the executor has.

    Raises
    ------
    UsageError
        When it is none of these, or what it needs is not installed.
    """
    if workers is not None and not (type(workers) is int and workers > 0):
        raise UsageError(f"workers must be a whole number > 0 (got {workers!r})")
    if isinstance(executor, str | None):
        name, _, address = check_name(executor).partition("=")
        if name == "processes":
            return Processes(workers or cores())
        from shockwave.sweep.dask_crew import DaskCrew

        return DaskCrew.of(address, workers)
    if not callable(getattr(executor, "submit", None)):
        raise UsageError(f"executor must have the method submit of concurrent.futures.Executor (got {executor!r})")
    known = workers or getattr(executor, "_max_workers", None) or cores()
    return Passed(executor, int(known))
