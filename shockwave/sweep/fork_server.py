"""The server from which worker processes are forked: it loads their modules once, and while the client goes on."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Sequence
from typing import Any

#: Contexts in which workers start: forked from the server, or each with its own interpreter.
SPAWN: Any = multiprocessing.get_context("spawn")
FORK_SERVER: Any = multiprocessing.get_context("forkserver") if sys.platform != "win32" else SPAWN
#: Modules that the workers of a sweep need.
WORKERS = ("shockwave.sweep.workers",)
# Loaded first, before the libraries of linear algebra.
_ENVIRONMENT = "shockwave.sweep.server_environment"


def start_server(modules: Sequence[str] = WORKERS) -> Any:
    """Start the server, which loads ``modules``, unless it is running; return the context of workers without waiting.

    Without a server, which needs a socket with a short path in the folder for temporary files, workers are spawned.
    """
    if FORK_SERVER is SPAWN:
        return SPAWN
    from multiprocessing import forkserver

    FORK_SERVER.set_forkserver_preload([_ENVIRONMENT, *modules])
    try:
        forkserver.ensure_running()
    except OSError:
        return SPAWN
    return FORK_SERVER
