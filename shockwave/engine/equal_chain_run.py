"""Integration of a shock on a chain: steps that end on kinks, on a window that grows with the front."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from attrs import define, field, frozen

from shockwave.base.errors import NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.engine.integrator import LONGEST_STEP, Integrator, Step
from shockwave.engine.scaled_problem import ChainAcceleration, ChainProblem, overlaps
from shockwave.engine.time_limit import expired
from shockwave.registry.registry import blame

#: First number of granules in the window.
FIRST_WINDOW = 12
# Number of granules by which it grows.
_GROWTH = 16
# Number of granules at the end of the window that must be at rest. From granule to granule the displacement decreases
# at least to its power 3/2, so the last one has moved by at most 1e-36.
_MARGIN = 4
# Largest scaled displacement and velocity of a granule at rest.
_AT_REST = 1e-16
# Interval between the ends of integrations after the force has ended, in characteristic times.
_STRETCH = 50.0
# Number of steps between the checks for granules in free flight.
_PARTING = 16


@frozen(eq=False)
class Span:
    """One step of the chain in true positions, with the free-particle displacement of the first granule added.

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


def march(problem: ChainProblem, integrator: Integrator, until: float | None = None) -> Iterator[Span]:
    """Yield the steps of the chain from rest to ``until``, or without end.

    Granules ahead of the front are exactly at rest, so the window needs to extend only slightly beyond the front; it
    never exceeds ``problem.granules``. After the force has ended, granules at the loaded end that have lost contact
    move at constant velocity, and only the others are integrated.

    Raises
    ------
    NumericalError
        If the integrator fails.
    """
    return March.of(problem, integrator).run(math.inf if until is None else until)


def free_granules(x: FloatArray, v: FloatArray) -> int:
    """Number of granules in free flight at the loaded end: out of contact, and not approaching one another."""
    apart = (overlaps(x) <= 0) & (v[:-1] <= v[1:])
    return int(np.argmin(apart)) if not apart.all() else len(x)


def overdue(time: float) -> NumericalError:
    """Error for an integration that has come to ``time`` when the time limit is reached."""
    at = f"at {time:.4g} characteristic times of the wave"
    return NumericalError(
        f"the time limit was reached {at} (allow more, loosen the tolerance, or shorten the simulated time)"
    )


@frozen(eq=False)
class _Frame:
    """Conversion to true positions: adds the free-particle displacement, or the granules in free flight.

    ``problem`` is None after the force has ended; ``x`` are the positions at ``time`` and ``v`` the velocities of the
    granules in free flight.
    """

    problem: ChainProblem | None = None
    time: float = 0.0
    x: FloatArray = field(factory=lambda: np.zeros(0))
    v: FloatArray = field(factory=lambda: np.zeros(0))

    def true(self, time: float, y: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
        if self.problem is None and not len(self.x):
            return y, w
        if self.problem is None:
            return np.concatenate((self.x + (time - self.time) * self.v, y)), np.concatenate((self.v, w))
        x, v = y.copy(), w.copy()
        path, impulse = self.problem.free(time)
        x[0] += path
        v[0] += impulse
        return x, v

    def meets(self, step: Step, before: float) -> bool:
        """Whether the last granule in free flight may be hit by the next, which had velocity ``before``."""
        if not len(self.x):
            return False
        gap = step.x[0] - self.x[-1] - (step.end - self.time) * self.v[-1]
        return bool(gap < (step.end - step.begin) * max(self.v[-1] - min(before, step.v[0]), 0.0))


@define
class March:
    """Current state: ``y``, ``w`` are the integrated positions and velocities."""

    problem: ChainProblem
    integrator: Integrator
    y: FloatArray
    w: FloatArray
    frame: _Frame
    time: float = 0.0
    size: float | None = None

    @classmethod
    def of(cls, problem: ChainProblem, integrator: Integrator) -> March:
        """The chain at rest."""
        window = min(FIRST_WINDOW, problem.granules or FIRST_WINDOW)
        return cls(problem, integrator, np.zeros(window), np.zeros(window), _Frame(problem))

    def run(self, until: float) -> Iterator[Span]:
        """Steps up to ``until``."""
        for stop in self.problem.stops:
            yield from self.spans(min(stop, until))
        if self.frame.problem is not None:
            self.release()
        while self.time < until:
            yield from self.coast(until)
            yield from self.spans(min(self.time + _STRETCH, until))

    def shorten(self, granules: int) -> float:
        """Remove all granules beyond these, after the force has ended; the place of the last one, the new origin.

        Ahead of it the chain is at rest. A new `run` is necessary.
        """
        if granules - len(self.frame.x) < 2:  # granules in free flight remain
            self.release()
        left = granules - len(self.frame.x)
        origin = self.y.item(left - 1)
        self.y, self.w = self.y[:left] - origin, self.w[:left]
        self.frame = _Frame(None, self.frame.time, self.frame.x - origin, self.frame.v)
        return origin

    def release(self) -> None:
        """Integrate true positions from now on: the force has ended, or a granule in free flight has been hit."""
        self.y, self.w = self.frame.true(self.time, self.y, self.w)
        self.frame = _Frame()

    def spans(self, until: float) -> Iterator[Span]:
        """Steps up to ``until``."""
        while self.time < until:
            yield from self._some(until)
            if room := self._room():
                self.y, self.w = np.append(self.y, np.zeros(room)), np.append(self.w, np.zeros(room))

    def coast(self, until: float) -> Iterator[Span]:
        """One span of exact free flight, to the next contact or to ``until``, if no contact of the chain is closed."""
        x, v = self.frame.true(self.time, self.y, self.w)
        gaps, closing = -overlaps(x), v[:-1] - v[1:]
        meets = closing > 0
        if len(x) != self.problem.granules or gaps.min() < 0 or not meets.any():
            return
        end = min(self.time + float((gaps[meets] / closing[meets]).min()), until)
        if end - self.time <= LONGEST_STEP:  # as for a gap due to rounding
            return
        self.release()
        self.y, self.w, begin, self.time = x + (end - self.time) * v, v, self.time, end
        yield Span(begin, end, x, v, self.y, v, lambda time: (x + (time - begin) * v, v))

    def _some(self, until: float) -> Iterator[Span]:
        """Steps until the set of integrated granules changes."""
        frame = self.frame
        x, v = frame.true(self.time, self.y, self.w)
        acceleration = ChainAcceleration(self.problem, frame.problem is not None)
        # errors in the steps of a plugin are reported as errors of the plugin
        with blame("integrators", type(self.integrator)):
            steps = self.integrator.steps(acceleration, self.time, until, self.y, self.w, self.size)
            for count, step in enumerate(steps, start=1):
                if expired():
                    raise overdue(self.time)
                if frame.meets(step, self.w[0]):
                    self.size = step.end - step.begin
                    self.release()
                    return
                x0, v0 = x, v
                x, v = frame.true(step.end, step.x, step.v)
                self.y, self.w, self.time, self.size = step.x, step.v, step.end, step.next_size
                yield Span(step.begin, step.end, x0, v0, x, v, partial(_within, frame, step, self.integrator))
                if count == _PARTING and frame.problem is None:
                    self._part(x, v)
                    return
                if self._room():
                    return

    def _room(self) -> int:
        """Number of granules by which the window must grow: none while those near its end are at rest."""
        last = -min(_MARGIN, len(self.y))
        if not max(abs(self.y[last]), abs(self.w[last])) > _AT_REST:
            return 0
        granules = self.problem.granules
        return _GROWTH if granules is None else min(_GROWTH, granules - len(self.frame.x) - len(self.y))

    def _part(self, x: FloatArray, v: FloatArray) -> None:
        """Remove granules in free flight from the integration, of which at least two remain."""
        free = min(free_granules(x, v), len(x) - 2)
        if free > len(self.frame.x):
            self.frame = _Frame(None, self.time, x[:free], v[:free])
            self.y, self.w = x[free:], v[free:]


def _within(frame: _Frame, step: Step, integrator: Integrator, time: float) -> tuple[FloatArray, FloatArray]:
    with blame("integrators", type(integrator)):
        x, v = step.interpolate(time)
    return frame.true(time, x, v)
