"""A dask cluster on this machine to which nobody else can connect."""

from __future__ import annotations

import logging
from importlib import import_module
from typing import Any

__all__ = ["local_cluster"]

# Neither is needed for the types of the package to be checked.
dask: Any = import_module("dask")
distributed: Any = import_module("distributed")

# This machine alone; that leaves its other users, whom certificates keep out.
_HOST = "127.0.0.1"


class _Unserved:
    """No web server, which dask starts even without a dashboard, and to which every local user can connect."""

    def start_http_server(self, *arguments: Any, **named: Any) -> None:
        """Start nothing."""


class LocalScheduler(_Unserved, distributed.Scheduler):  # type: ignore[misc]
    """A scheduler without a web server."""


class LocalWorker(_Unserved, distributed.Worker):  # type: ignore[misc]
    """A worker without a web server."""


def local_cluster(workers: int) -> Any:
    """Processes of one thread each, connected by TLS with certificates made for this cluster."""
    security = distributed.Security.temporary()
    shared = {"host": _HOST, "protocol": "tls://", "security": security}
    worker = {
        "cls": distributed.Nanny,
        "options": {
            **shared,
            "worker_class": LocalWorker,
            "nthreads": 1,
            "memory_limit": 1 / workers,
            "silence_logs": logging.CRITICAL,
        },
    }
    # a batch whose worker dies is run again by the sweep, not by dask
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}):
        return distributed.SpecCluster(
            workers=dict.fromkeys(range(workers), worker),
            scheduler={"cls": LocalScheduler, "options": {**shared, "port": 0, "dashboard": False}},
            security=security,
            silence_logs=logging.CRITICAL,
        )
