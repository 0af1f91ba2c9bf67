"""A dask cluster on this machine to which no other user can connect."""

from __future__ import annotations

import logging
from importlib import import_module
from typing import Any

__all__ = ["local_cluster"]

# Typed as Any, so that checking the types of the package does not need dask.
dask: Any = import_module("dask")
distributed: Any = import_module("distributed")

# Only this machine can connect; certificates keep out its other users.
_HOST = "127.0.0.1"


class _Unserved:
    """Disable the web server, which dask starts even without a dashboard and to which every local user can connect."""

    def start_http_server(self, *arguments: Any, **named: Any) -> None:
        """Start nothing."""


class LocalScheduler(_Unserved, distributed.Scheduler):  # type: ignore[misc]
    """A scheduler without a web server."""


class LocalWorker(_Unserved, distributed.Worker):  # type: ignore[misc]
    """A worker without a web server."""


def local_cluster(workers: int) -> Any:
    """Single-threaded worker processes, connected by TLS with certificates created for this cluster."""
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
    # the sweep, not dask, repeats a batch whose worker dies
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}):
        return distributed.SpecCluster(
            workers=dict.fromkeys(range(workers), worker),
            scheduler={"cls": LocalScheduler, "options": {**shared, "port": 0, "dashboard": False}},
            security=security,
            silence_logs=logging.CRITICAL,
        )
