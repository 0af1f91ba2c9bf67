"""The server from which worker processes are forked: it loads their modules once, and while the client goes on."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Sequence
from typing import Any

#: Context in which workers start.
START: Any = multiprocessing.get_context("forkserver" if sys.platform != "win32" else "spawn")
#: Modules that the workers of a sweep need.
WORKERS = ("shockwave.sweep.workers",)
# Numbers of threads of the libraries of linear algebra: one, because there is a worker for each core.
_THREADS = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")


def start_server(executor: object = None, modules: Sequence[str] = WORKERS) -> None:
    """Start the server, which loads ``modules``, unless it runs already or ``executor`` needs none; do not wait."""
    if sys.platform != "win32" and executor is None:
        from multiprocessing import forkserver

        START.set_forkserver_preload(list(modules))
        added = _THREADS.keys() - os.environ.keys()
        os.environ.update({name: _THREADS[name] for name in added})
        try:
            forkserver.ensure_running()
        finally:
            for name in added:
                del os.environ[name]
