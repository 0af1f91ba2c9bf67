"""Steps of an integration of the whole chain, and the states at their ends."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.scaled_problem import overlaps


@frozen(eq=False)
class Span:
    """One step of the chain.

    ``x0, v0`` and ``x1, v1`` are positions and velocities at its ends, shape (granules,); ``at(time)`` returns them
    within the step, as accurately as the integrator.
    """

    begin: float
    end: float
    x0: FloatArray
    v0: FloatArray
    x1: FloatArray
    v1: FloatArray
    at: Callable[[float], tuple[FloatArray, FloatArray]]


@frozen(eq=False)
class Stretch:
    """Consecutive spans, as arrays of the states at their ends.

    ``times`` has shape (spans + 1,), ``x`` and ``v`` (spans + 1, granules); granules outside an earlier window are at
    rest. Compiled code makes no ``spans``.
    """

    spans: tuple[Span, ...]
    times: FloatArray
    x: FloatArray
    v: FloatArray

    @classmethod
    def of(cls, *spans: Span) -> Stretch:
        """The stretch of one or more spans."""
        first, last = spans[0], spans[-1]
        x, v = np.zeros((2, len(spans) + 1, len(last.x1)))
        x[0, : len(first.x0)], v[0, : len(first.x0)] = first.x0, first.v0
        for row, span in enumerate(spans, start=1):
            x[row, : len(span.x1)], v[row, : len(span.x1)] = span.x1, span.v1
        return cls(spans, np.array([first.begin, *(span.end for span in spans)]), x, v)

    @property
    def end(self) -> float:
        """End of the last span."""
        return float(self.times[-1])


def free_granules(x: FloatArray, v: FloatArray) -> int:
    """Number of granules in free flight at the loaded end: out of contact, and not approaching one another."""
    apart = (overlaps(x) <= 0) & (v[:-1] <= v[1:])
    first = int(apart.argmin())
    return len(x) if apart[first] else first
