"""Progress of long work: whoever does it reports, and whoever called it may show what is reported."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

#: Called with the name of the work, how much is done and, where it is known, how much there is.
Show = Callable[[str, int, int | None], None]

_show: ContextVar[Show | None] = ContextVar("show", default=None)


def progressed(work: str, done: int, total: int | None = None) -> None:
    """Report that ``done`` of ``total`` parts of ``work`` are done."""
    if (show := _show.get()) is not None:
        show(work, done, total)


@contextmanager
def progress_shown(show: Show | None) -> Iterator[None]:
    """Meanwhile, call ``show`` at every report; None shows nothing."""
    token = _show.set(show)
    try:
        yield
    finally:
        _show.reset(token)
