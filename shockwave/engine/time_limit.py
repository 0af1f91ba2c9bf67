"""The time limit of a computation, at which its loops look."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Event

_expired: ContextVar[Callable[[], bool]] = ContextVar("expired", default=lambda: False)
_limited: ContextVar[bool] = ContextVar("limited", default=False)


def is_limited() -> bool:
    """Whether there is a time limit."""
    return _limited.get()


def expired() -> bool:
    """Whether the time is up.

    Raises
    ------
    KeyboardInterrupt
        When the threads that compute together were interrupted.
    """
    return _expired.get()()


@contextmanager
def time_limit(seconds: float | None, interrupted: Event | None = None) -> Iterator[None]:
    """Limit the time of what is computed inside; None for no limit. ``interrupted`` is set to stop it from outside."""
    end = math.inf if seconds is None else time.monotonic() + seconds

    def is_over() -> bool:
        if interrupted is not None and interrupted.is_set():
            raise KeyboardInterrupt
        return time.monotonic() > end

    token, limited = _expired.set(is_over), _limited.set(seconds is not None)
    try:
        yield
    finally:
        _expired.reset(token)
        _limited.reset(limited)
