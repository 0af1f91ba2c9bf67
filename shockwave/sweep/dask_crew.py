"""Workers of a dask scheduler, through the executor that dask brings."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from importlib import import_module
from typing import Any

from attrs import define, field

from shockwave.errors import UsageError
from shockwave.sweep.executors import LostError, cores, uninterrupted
from shockwave.sweep.points import Order, check, do

__all__ = ["DaskCrew"]

_INSTALL = "python -m pip install 'shockwave[dask]'"
# Seconds for a scheduler, and its first worker, to answer.
_PATIENCE = 30


@define(eq=False)
class DaskCrew:
    """Workers of a scheduler, who are sent to and heard through ``client``.

    ``cluster`` is one that was made for the sweep on this machine, and ends with it; None for one that was there.
    """

    client: Any
    cluster: Any
    workers: int
    isolates: bool = field(default=True, init=False)
    _executor: Executor = field(init=False)

    def __attrs_post_init__(self) -> None:
        self._executor = self.client.get_executor(pure=False)

    @classmethod
    def of(cls, address: str, workers: int | None) -> DaskCrew:
        """The crew at ``address``, such as ``tcp://host:8786`` or ``tls://host:8786``; empty for one on this machine.

        Raises
        ------
        UsageError
            When dask is not installed.
        LostError
            When nothing answers at the address.
        """
        try:
            dask: Any = import_module("dask")
            distributed: Any = import_module("distributed")
        except ImportError as error:
            raise UsageError(f"executor dask must be installed (got {error}; {_INSTALL})") from None
        cluster = None
        if not address:
            # this machine alone may connect; a batch whose worker dies is run again by the sweep, not by dask
            with dask.config.set({"distributed.scheduler.allowed-failures": 0}), uninterrupted():
                cluster = distributed.LocalCluster(
                    host="127.0.0.1",
                    n_workers=workers or cores(),
                    threads_per_worker=1,
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                )
        try:
            client = distributed.Client(cluster or address, timeout=_PATIENCE, set_as_default=False)
            try:
                client.wait_for_workers(1, timeout=_PATIENCE)
                threads = sum(client.nthreads().values())
            except BaseException:
                client.close()
                raise
        except (OSError, TimeoutError, ValueError, TypeError) as error:
            if cluster is not None:
                cluster.close()
            name = address or "the local cluster"
            raise LostError(f"dask: {name} must answer and have a worker (got {error})") from None
        return cls(client, cluster, workers or threads)

    def submit(self, order: Order, indices: list[int]) -> Future[Any]:
        return self._executor.submit(do, order, indices)

    def wait(self, futures: Iterable[Future[Any]]) -> set[Future[Any]]:
        return wait(futures, return_when=FIRST_COMPLETED).done

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

    def close(self, at_once: bool) -> None:
        self.client.close()
        if self.cluster is not None:
            self.cluster.close()
