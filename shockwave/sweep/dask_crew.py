"""Workers of a dask scheduler, through the executor that dask brings."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import ExitStack
from importlib import import_module
from typing import Any

from attrs import define, field

from shockwave import OWN_DISTRIBUTION
from shockwave.errors import UsageError
from shockwave.sweep.executors import LostError, cores, safe_path, uninterrupted
from shockwave.sweep.points import Order, check, do

__all__ = ["DaskCrew"]

_INSTALL = f"python -m pip install '{OWN_DISTRIBUTION}[dask]'"
# Seconds for a scheduler, and its first worker, to answer.
_PATIENCE = 30
# Seconds after which workers are counted anew, after which it is told that there are none, and given up.
_COUNT, _TELL, _GIVE_UP = 1.0, 5.0, 60.0
_log = logging.getLogger(__name__)


@define(eq=False)
class DaskCrew:
    """Workers of a scheduler, who are sent to and heard through ``client``.

    ``ending`` closes the client, and the cluster if the sweep started it on this machine.
    ``asked`` says how many workers to keep busy; None for as many as there are.
    """

    client: Any
    ending: ExitStack
    asked: int | None
    isolates: bool = field(default=True, init=False)
    _executor: Executor = field(init=False)
    _threads: int = field(default=1, init=False)
    _counted: float = field(default=0.0, init=False)
    _seen: float = field(factory=time.monotonic, init=False)
    _told: bool = field(default=False, init=False)

    def __attrs_post_init__(self) -> None:
        self._executor = self.client.get_executor(pure=False)

    @classmethod
    def of(cls, address: str, workers: int | None) -> DaskCrew:
        """The crew at ``address``, such as ``tcp://host:8786`` or ``tls://host:8786``; empty for one on this machine.

        Raises
        ------
        UsageError
            When dask is not installed or, for a cluster on this machine, cryptography is not.
        LostError
            When nothing answers at the address.
        """
        try:
            distributed: Any = import_module("distributed")
            if not address:
                import_module("cryptography")
        except ImportError as error:
            raise UsageError(f"executor dask must be installed (got {error}; {_INSTALL})") from None
        if address.startswith("tls:"):
            _check_certificates(distributed)
        with ExitStack() as stack:
            cluster = None if address else _begun(workers or cores(), stack)
            try:
                client = distributed.Client(cluster or address, timeout=_PATIENCE, set_as_default=False)
                stack.callback(client.close)
                client.wait_for_workers(1, timeout=_PATIENCE)
            except (OSError, TimeoutError, ValueError, TypeError) as error:
                name = address or "the local cluster"
                raise LostError(f"dask: {name} must answer and have a worker (got {error})") from None
            return cls(client, stack.pop_all(), workers)

    @property
    def workers(self) -> int:
        """How many there are, each thread of a process being one; others may come and go while the sweep runs."""
        self._count()
        return self.asked or max(self._threads, 1)

    def _count(self) -> None:
        now = time.monotonic()
        if now - self._counted < _COUNT:
            return
        self._counted = now
        try:
            self._threads = sum(self.client.nthreads().values())
        except (OSError, TimeoutError, RuntimeError, ValueError):  # of a scheduler that is lost: its batches tell
            return
        if self._threads:
            self._seen, self._told = time.monotonic(), False

    def _check_workers(self) -> None:
        """Say, and after a while raise, that there are no workers left."""
        self._count()
        without = 0.0 if self._threads else time.monotonic() - self._seen
        if without > _GIVE_UP:
            got = f"got none for {_GIVE_UP:g} s; begin one and run it again: what is finished is kept"
            raise LostError(f"dask: the scheduler must have workers ({got})")
        if without > _TELL and not self._told:
            self._told = True
            _log.warning("dask: the scheduler has no workers left; waiting for another")

    def submit(self, order: Order, indices: list[int]) -> Future[Any]:
        return self._executor.submit(do, order, indices)

    def wait(self, futures: Iterable[Future[Any]]) -> set[Future[Any]]:
        known = list(futures)
        while not (done := wait(known, timeout=_COUNT, return_when=FIRST_COMPLETED).done):
            self._check_workers()
        return done

    def renew(self, workers: int) -> None:
        """Nothing: a scheduler sees to its workers."""

    def check(self, order: Order) -> None:
        """Ask every worker whether it has what the sweep needs, in the same versions."""
        for worker, told in self.client.run(check, order, on_error="return").items():
            if isinstance(told, Exception):
                got = f"got {type(told).__name__}: {told}; install what is installed here"
                raise UsageError(f"{worker}: workers must have shockwave ({got})")
            if told is not None:
                raise UsageError(f"{worker}: {told}")

    def close(self) -> None:
        self.ending.close()


def _begun(workers: int, ending: ExitStack) -> Any:
    """Start a cluster on this machine, which ``ending`` closes."""
    from shockwave.sweep.dask_local import local_cluster

    # while the cluster runs, it restarts workers that die
    ending.enter_context(safe_path())
    with uninterrupted():
        cluster = local_cluster(workers)
    ending.callback(cluster.close)
    return cluster


def _check_certificates(distributed: Any) -> None:
    """Refuse an address with TLS where there are no certificates, for which dask would wait without end."""
    try:
        known = distributed.Security().get_connection_args("client").get("ssl_context") is not None
        got = "got no certificates"
    except OSError as error:
        known, got = False, f"got {error}"
    if not known:
        remedy = "name them in dask's configuration, distributed.comm.tls"
        raise UsageError(f"executor dask=tls:// must have certificates ({got}; {remedy})")
