"""Progress and log of long work: whoever does it reports, and whoever called it may show what is reported."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

#: Called with the name of the work, how much is done and, where it is known, how much there is.
Show = Callable[[str, int, int | None], None]

_Item = TypeVar("_Item")
_show: ContextVar[Show | None] = ContextVar("show", default=None)

#: The logger of long jobs, which writes nothing unless the user's program configures logging.
logger = logging.getLogger("shockwave")
# otherwise Python would print warnings by itself
logger.addHandler(logging.NullHandler())


def report_progress(work: str, done: int, total: int | None = None) -> None:
    """Report that ``done`` of ``total`` parts of ``work`` are done."""
    if (show := _show.get()) is not None:
        show(work, done, total)


def track(work: str, items: Sequence[_Item]) -> Iterator[_Item]:
    """Yield the items, with a report of progress before each one and at the end, however it is reached."""
    try:
        for done, item in enumerate(items):
            report_progress(work, done, len(items))
            yield item
    finally:
        report_progress(work, len(items), len(items))


@contextmanager
def show_progress(show: Show | None) -> Iterator[None]:
    """Meanwhile, call ``show`` at every report; None shows nothing."""
    token = _show.set(show)
    try:
        yield
    finally:
        _show.reset(token)
