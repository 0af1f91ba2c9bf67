"""The march of a shock into the chain: steps that end on kinks, on a window that grows with the front."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from attrs import define, field, frozen

from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray
from shockwave.registry import blame
from shockwave.simulation.integrator import Integrator, Step
from shockwave.simulation.problem import ChainAcceleration, ChainProblem, overlaps
from shockwave.simulation.time_limit import expired

_FIRST_WINDOW = 12
_GROWTH = 16
# A granule this near to the window's end must still be at rest. The displacement ahead of it falls off as the power
# 3/2 of itself from granule to granule, or faster: the last one has moved by 1e-36 at most.
_MARGIN = 4
_AT_REST = 1e-16
# How far to integrate at a stretch once the force has ended.
_STRETCH = 50.0
# After so many steps it is seen which granules have come free.
_PARTING = 16


@frozen(eq=False)
class Span:
    """One step of the chain, in true positions (the free path of the first granule put back).

    ``x0, v0`` and ``x1, v1`` are positions and velocities at its ends, shape (granules,); ``at(time)`` gives them
    within, as exactly as the integrator does.
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
    """Spans that follow one another, as arrays of the states where they meet.

    ``times`` has shape (spans + 1,), ``x`` and ``v`` (spans + 1, granules); granules that a window did not hold yet
    are at rest.
    """

    spans: tuple[Span, ...]
    times: FloatArray
    x: FloatArray
    v: FloatArray

    @classmethod
    def of(cls, *spans: Span) -> Stretch:
        """The stretch of these spans, one at least."""
        first, last = spans[0], spans[-1]
        x, v = np.zeros((2, len(spans) + 1, len(last.x1)))
        x[0, : len(first.x0)], v[0, : len(first.x0)] = first.x0, first.v0
        for row, span in enumerate(spans, start=1):
            x[row, : len(span.x1)], v[row, : len(span.x1)] = span.x1, span.v1
        return cls(spans, np.array([first.begin, *(span.end for span in spans)]), x, v)

    @property
    def end(self) -> float:
        """When the last span ends."""
        return self.spans[-1].end


def march(problem: ChainProblem, integrator: Integrator, until: float | None = None) -> Iterator[Span]:
    """Steps of the chain from rest, up to ``until`` or without end: the caller stops when it knows enough.

    Granules ahead of the front are at rest exactly, so the chain is only as long as the front needs; with
    ``problem.granules`` it never grows beyond them. Once the force has ended, granules that have come free at the
    loaded end fly on at constant velocity, and only the others are integrated.

    Raises
    ------
    NumericalError
        When the integrator cannot go on.
    """
    window = min(_FIRST_WINDOW, problem.granules or _FIRST_WINDOW)
    course = _Course(problem, integrator, np.zeros(window), np.zeros(window), _Frame(problem))
    last = math.inf if until is None else until
    for stop in problem.stops:
        yield from course.spans(min(stop, last))
    course.release()
    while course.time < last:
        yield from course.spans(min(course.time + _STRETCH, last))


def free_granules(x: FloatArray, v: FloatArray) -> int:
    """How many granules at the loaded end fly free: out of contact, and no two of them closing in."""
    apart = (overlaps(x) <= 0) & (v[:-1] <= v[1:])
    return int(np.argmin(apart)) if not apart.all() else len(x)


@frozen(eq=False)
class _Frame:
    """Conversion to true positions: by the shock's free-particle displacement, or the granules that have flown off.

    ``problem`` is None once the force has ended; ``x`` and ``v`` are positions at ``time`` and velocities of those that
    fly.
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
        """Whether the last granule that flies may have been met, which had velocity ``before`` behind it."""
        if not len(self.x):
            return False
        gap = step.x[0] - self.x[-1] - (step.end - self.time) * self.v[-1]
        return bool(gap < (step.end - step.begin) * max(self.v[-1] - min(before, step.v[0]), 0.0))


@define
class _Course:
    """Where the march has come to: ``y``, ``w`` are positions and velocities as they are integrated."""

    problem: ChainProblem
    integrator: Integrator
    y: FloatArray
    w: FloatArray
    frame: _Frame
    time: float = 0.0
    size: float | None = None

    def release(self) -> None:
        """Follow the first granule in its true position from here on: the force has ended, or it has been met."""
        self.y, self.w = self.frame.true(self.time, self.y, self.w)
        self.frame = _Frame()

    def spans(self, until: float) -> Iterator[Span]:
        """Steps up to ``until``."""
        while self.time < until:
            yield from self._some(until)
            if room := self._room():
                self.y, self.w = np.append(self.y, np.zeros(room)), np.append(self.w, np.zeros(room))

    def _some(self, until: float) -> Iterator[Span]:
        """Steps until the granules to be integrated are others."""
        frame = self.frame
        x, v = frame.true(self.time, self.y, self.w)
        acceleration = ChainAcceleration(self.problem, frame.problem is not None)
        # what goes wrong with the steps of a plugin is its own fault
        with blame("integrators", type(self.integrator)):
            steps = self.integrator.steps(acceleration, self.time, until, self.y, self.w, self.size)
            for count, step in enumerate(steps, start=1):
                if expired():
                    at = f"at {self.time:.4g} characteristic times of the wave"
                    raise NumericalError(f"the time limit was reached {at} (allow more, or loosen the tolerance)")
                if frame.meets(step, self.w[0]):
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
        """How many granules the window lacks: none while those near its end are at rest."""
        last = -min(_MARGIN, len(self.y))
        if not max(abs(self.y[last]), abs(self.w[last])) > _AT_REST:
            return 0
        granules = self.problem.granules
        return _GROWTH if granules is None else min(_GROWTH, granules - len(self.frame.x) - len(self.y))

    def _part(self, x: FloatArray, v: FloatArray) -> None:
        """Let granules fly that have come free; two are left to be integrated."""
        free = min(free_granules(x, v), len(x) - 2)
        if free > len(self.frame.x):
            self.frame = _Frame(None, self.time, x[:free], v[:free])
            self.y, self.w = x[free:], v[free:]


def _within(frame: _Frame, step: Step, integrator: Integrator, time: float) -> tuple[FloatArray, FloatArray]:
    with blame("integrators", type(integrator)):
        x, v = step.interpolate(time)
    return frame.true(time, x, v)
