"""Batches of points, as workers run them."""

from __future__ import annotations

import pickle
import threading
import time
from collections.abc import Sequence
from typing import NamedTuple

from shockwave.errors import UsageError
from shockwave.sweep.points import Points, error_text, named_here, versions_here

#: Seconds after which a worker answers, whatever is left of its batch.
SLICE = 1.0
# Points that a worker runs side by side: at first, and at most.
_FEW = 8
_MANY = 128


class Done(NamedTuple):
    """The first points of a batch: their lines of the journal, and how many seconds they took."""

    lines: str
    seconds: float


# Of each thread: what a sweep keeps between batches is not made for several at once.
_known = threading.local()


def run_batch(content: bytes, indices: Sequence[int]) -> Done:
    """Run the first of some points of a sweep, for about a second.

    The time that points take may change from one to the next, and what is not answered can be lost.

    Raises
    ------
    UsageError
        When this worker cannot take part.
    """
    if getattr(_known, "content", None) != content:
        _known.points = understood(content)
        _known.content = content
    begin = now = time.perf_counter()
    lines, at, size = "", 0, _FEW
    while at < len(indices) and now - begin < SLICE:
        lines += _known.points.lines(indices[at : at + size])
        at += size
        before, now = now, time.perf_counter()
        fit = int(size * SLICE / 4 / max(now - before, 1e-9))
        size = max(1, min(4 * size, _MANY, fit))
    return Done(lines, now - begin)


def content_of(points: Points) -> bytes:
    """A sweep as workers get it; raises whatever pickle raises for a scene made in Python that cannot be sent."""
    return pickle.dumps((points.scenario, points.versions, points.named))


def understood(content: bytes) -> Points:
    """The points of a sweep, if this worker has all that they need, in the same versions.

    Raises
    ------
    UsageError
        When it has not.
    """
    try:
        scenario, versions, named = pickle.loads(content)
    except (Exception, SystemExit) as error:  # of a plugin, maybe
        got = f"got {error_text(error)}; install there what is installed here"
        raise UsageError(f"workers must be able to read the scenario ({got})") from None
    here = versions_here(name for name in versions if name not in ("python", "backend"))
    if differ := [f"{name} {here[name]}, not {versions[name]}" for name in here if here[name] != versions[name]]:
        got = f"got a worker with {', '.join(differ)}; install the same"
        raise UsageError(f"workers must have the versions of the client ({got})")
    here = named_here(scenario)
    if differ := [name for name in named if here[name] != named[name]]:
        got = f"got another content of {', '.join(differ)}; copy it anew"
        raise UsageError(f"workers must read what the client has read ({got})")
    return Points(scenario, versions, named)
