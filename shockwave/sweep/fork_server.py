"""The server from which worker processes are forked: it loads their modules while the client plans the sweep."""

from __future__ import annotations

import multiprocessing
import sys
from typing import Any

#: Context in which workers start.
START: Any = multiprocessing.get_context("forkserver" if sys.platform != "win32" else "spawn")


def start_server(executor: object = None) -> None:
    """Start the server, unless it runs already or ``executor`` needs none; do not wait for it."""
    if sys.platform != "win32" and executor in (None, "processes"):
        from multiprocessing import forkserver

        START.set_forkserver_preload(["shockwave.sweep.workers"])
        forkserver.ensure_running()
