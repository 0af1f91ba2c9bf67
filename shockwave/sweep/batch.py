"""Batches of points, as workers run them."""

from __future__ import annotations

import hashlib
import pickle
import threading
import time
from collections.abc import Sequence
from typing import NamedTuple

from shockwave.sweep.points import Points, error_text, versions_here

#: Seconds after which a worker answers, whatever is left of its batch.
SLICE = 1.0
# Points that a worker runs side by side: at first, and at most.
_FEW = 8
_MANY = 128


class Order(NamedTuple):
    """A sweep as workers know it: its name, and its content for workers that do not know it yet."""

    name: str
    content: bytes | None

    @classmethod
    def of(cls, points: Points) -> Order:
        """The order to run ``points``.

        Raises
        ------
        Exception
            Whatever pickle raises for a scene made in Python that cannot be sent.
        """
        content = pickle.dumps((points.scenario, dict(points.versions), dict(points.named)))
        return cls(hashlib.sha256(content).hexdigest(), content)


class Done(NamedTuple):
    """The first points of a batch: their lines of the journal, and how many seconds they took."""

    lines: str
    seconds: float


class Refused(NamedTuple):
    """Why a worker cannot take part."""

    reason: str


# Of each thread: what a sweep keeps between batches is not made for several at once.
_known = threading.local()


def run_batch(order: Order, indices: Sequence[int]) -> Done | Refused | None:
    """Run the first of some points, for about a second; None if the sweep is not known here, and must be sent whole.

    The time that points take may change from one to the next, and what is not answered can be lost.
    """
    if getattr(_known, "name", None) != order.name:
        if order.content is None:
            return None
        points = understood(order.content)
        if isinstance(points, Refused):
            return points
        _known.name, _known.points = order.name, points
    begin = now = time.perf_counter()
    lines, at, size = "", 0, _FEW
    while at < len(indices) and now - begin < SLICE:
        lines += _known.points.lines(indices[at : at + size])
        at += size
        before, now = now, time.perf_counter()
        size = max(1, min(4 * size, _MANY, int(size * SLICE / 4 / max(now - before, 1e-9))))
    return Done(lines, now - begin)


def understood(content: bytes) -> Points | Refused:
    """The points of an order, if this worker has all that they need, in the same versions."""
    try:
        scenario, versions, named = pickle.loads(content)
    except (Exception, SystemExit) as error:  # of a plugin, maybe
        got = f"got {error_text(error)}; install there what is installed here"
        return Refused(f"workers must be able to read the scenario ({got})")
    here = versions_here(name for name in versions if name not in ("python", "backend"))
    if here == versions:
        return Points(scenario, versions, named)
    differ = ", ".join(f"{name} {here[name]}, not {versions[name]}" for name in here if here[name] != versions[name])
    return Refused(f"workers must have the versions of the client (got a worker with {differ}; install the same)")
