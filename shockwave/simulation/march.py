"""The march of a shock into the chain: steps that end on kinks, on a window that grows with the front."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import NamedTuple

import numpy as np
from attrs import define

from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Integrator, Step
from shockwave.simulation.problem import ChainProblem

__all__ = ["Samples", "Span", "march"]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_FIRST_WINDOW = 12
_GROWTH = 16
# A granule this near to the window's end must still be at rest, to within the least number that matters.
_MARGIN = 4
_AT_REST = 1e-40
# How far to integrate at a stretch once the force has ended.
_STRETCH = 50.0


class Samples(NamedTuple):
    """A step at its Gauss nodes: times and weights, shape (nodes,); positions and velocities, (nodes, granules)."""

    times: FloatArray
    weights: FloatArray
    x: FloatArray
    v: FloatArray


@define(eq=False, slots=False)
class Span:
    """One step of the chain, in true positions (the free path of the first granule put back).

    ``x0, v0`` and ``x1, v1`` are positions and velocities at its ends, shape (granules,); ``at(time)`` gives them
    within.
    """

    begin: float
    end: float
    x0: FloatArray
    v0: FloatArray
    x1: FloatArray
    v1: FloatArray
    at: Callable[[float], tuple[FloatArray, FloatArray]]

    @cached_property
    def samples(self) -> Samples:
        """The step at the nodes of a Gauss rule, taken once for all who ask."""
        half = (self.end - self.begin) / 2
        times = self.begin + half * (1 + _NODES)
        states = [self.at(float(time)) for time in times]
        return Samples(times, half * _WEIGHTS, np.array([x for x, _ in states]), np.array([v for _, v in states]))


def march(problem: ChainProblem, integrator: Integrator) -> Iterator[Span]:
    """Steps of the chain from rest, without end: the caller stops when it knows enough.

    Granules ahead of the front are at rest exactly, so the chain is only as long as the front needs; with
    ``problem.granules`` it never grows beyond them.

    Raises
    ------
    NumericalError
        When the integrator cannot go on.
    """
    limit = problem.granules
    window = _FIRST_WINDOW if limit is None else min(_FIRST_WINDOW, limit)
    y, w = np.zeros(window), np.zeros(window)
    time, size = 0.0, None
    stops = iter(problem.stops)
    driven = True
    until = next(stops)
    while True:
        for step in integrator.steps(_acceleration(problem, driven), time, until, y, w, size):
            yield _span(problem, driven, step, y, w)
            y, w, time, size = step.x, step.v, step.end, step.next_size
            if (limit is None or len(y) < limit) and _front_near_end(y, w):
                more = _GROWTH if limit is None else min(_GROWTH, limit - len(y))
                y, w = np.append(y, np.zeros(more)), np.append(w, np.zeros(more))
                break
        if time < until:
            continue
        if driven and time >= problem.duration:
            # The force is over: from here on the first granule is followed in its true position.
            y, w = _true(problem, driven, time, y, w)
            driven = False
        until = next(stops, time + _STRETCH)


def _acceleration(problem: ChainProblem, driven: bool) -> Callable[[float, FloatArray], FloatArray]:
    return lambda time, y: problem.acceleration(time, y, driven)


def _front_near_end(y: FloatArray, w: FloatArray) -> bool:
    last = -min(_MARGIN, len(y))
    return bool(max(abs(y[last]), abs(w[last])) > _AT_REST)


def _true(
    problem: ChainProblem, driven: bool, time: float, y: FloatArray, w: FloatArray
) -> tuple[FloatArray, FloatArray]:
    if not driven:
        return y, w
    x, v = y.copy(), w.copy()
    x[0] += problem.free_path(time)
    v[0] += problem.impulse(time)
    return x, v


def _span(problem: ChainProblem, driven: bool, step: Step, y: FloatArray, w: FloatArray) -> Span:
    def at(time: float) -> tuple[FloatArray, FloatArray]:
        return _true(problem, driven, time, *step.interpolate(time))

    x0, v0 = _true(problem, driven, step.begin, y, w)
    x1, v1 = _true(problem, driven, step.end, step.x, step.v)
    return Span(step.begin, step.end, x0, v0, x1, v1, at)
