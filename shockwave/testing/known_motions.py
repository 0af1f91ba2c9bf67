"""Motions with known solutions, on which integrators are tried."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import islice
from typing import Any

import numpy as np
from attrs import define, field

from shockwave.measurement.chain_run import ChainRun
from shockwave.profiles.triangular import Triangular
from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Acceleration, Integrator, Step
from shockwave.simulation.nystroem import Rkn1210
from shockwave.simulation.one_step import OneStep
from shockwave.simulation.problem import ChainProblem

_PHASES = np.arange(5) * 0.7
# How long a motion is followed to measure the order of its error.
_SPAN = 6.0
# Runs begin at several times: their mean error is not the accident of one.
_BEGINS = (0.0, 0.9, 2.3, 3.1, 4.7, 5.6)
# Numbers of steps in a run, each the double of one before.
_COUNTS = (4, 5, 6, 7, 8, 10, 12, 14, 16, 24, 32, 64, 128, 256)
# The fewest that show a slope.
_FEWEST = 8
# No method takes so many steps for what is asked of it here.
_MOST_STEPS = 200_000
# An error as small is rounding in part.
_LEAST = 2e-13
#: Granules at rest that the first one strikes: positions and velocities.
STRUCK = (np.zeros(5), np.array([1.0, 0.0, 0.0, 0.0, 0.0]))
#: How long it takes them to come apart.
STRUCK_UNTIL = 12.0


def path(time: Any) -> tuple[FloatArray, FloatArray]:
    """A motion chosen beforehand: positions and velocities, shape (granules,) and that of ``time``."""
    angle = time + _PHASES.reshape(-1, *[1] * np.ndim(time))
    return np.asarray(np.cos(angle) + 0.3 * np.sin(2 * angle)), np.asarray(0.6 * np.cos(2 * angle) - np.sin(angle))


def _between_neighbours(x: FloatArray) -> FloatArray:
    """A smooth force between neighbours."""
    return np.asarray(-np.diff(np.sin(x[:-1] - x[1:]), axis=0, prepend=0.0, append=0.0))


def coupled(time: Any, x: FloatArray) -> FloatArray:
    """The acceleration of a chain that is driven so that it takes the path."""
    angle = time + _PHASES.reshape(-1, *[1] * (x.ndim - 1))
    driven = np.cos(angle) + 1.2 * np.sin(2 * angle)
    return np.asarray(_between_neighbours(x) - _between_neighbours(path(time)[0]) - driven)


def hertz(_: Any, x: FloatArray) -> FloatArray:
    """Eq. (1) without a force: contacts that open."""
    force = np.maximum(x[:-1] - x[1:], 0.0) ** 1.5
    return np.asarray(-np.diff(force, prepend=0.0, append=0.0))


def broken(since: float, value: float) -> Acceleration:
    """An acceleration that is ``value`` from a time on."""
    return lambda time, x: coupled(time, x) if time < since else np.full_like(x, value)


@define
class Watched:
    """An acceleration that keeps the times and shapes it was called with."""

    acceleration: Acceleration
    times: list[float] = field(factory=list)
    shapes: list[tuple[int, ...]] = field(factory=list)

    def __call__(self, time: Any, x: FloatArray) -> FloatArray:
        self.times.append(float(time))
        self.shapes.append(np.shape(x))
        return self.acceleration(time, np.ravel(x))  # a wrong shape is found by its record, not by the motion

    def check_within(self, begin: float, end: float) -> None:
        """Fail unless it was called at times from ``begin`` to ``end`` only."""
        first, last = min(self.times), max(self.times)
        assert begin <= first <= last <= end, f"a stage lies at t = {first!r} or {last!r}; mind rounding"


# ---------------------------------------------------------------- runs


def taken(
    method: Integrator,
    acceleration: Acceleration = coupled,
    until: float = 3.0,
    state: tuple[FloatArray, FloatArray] | None = None,
    begin: float = 0.0,
) -> list[Step]:
    """All steps of a run; without a state, of the smooth motion."""
    x, v = path(begin) if state is None else state
    steps = list(islice(method.steps(acceleration, begin, until, x.copy(), v.copy(), None), _MOST_STEPS))
    assert len(steps) < _MOST_STEPS, f"steps does not end: {_MOST_STEPS} up to t = {steps[-1].end!r}"
    return steps


def distance(state: Any, other: Any) -> float:
    """The greatest difference of two states."""
    return float(np.max(np.abs(np.subtract(state, other))))


def off(step: Step) -> float:
    """How far the end of a step is off the smooth motion."""
    return distance((step.x, step.v), path(step.end))


# ---------------------------------------------------------------- order


def slope(integrator: type[Integrator]) -> float:
    """The power of the step with which the error of the smooth motion scales."""
    if issubclass(integrator, OneStep):
        return _power(lambda size: _error_of_attempts(integrator(), size))
    if not integrator.adaptive:
        return _power(lambda size: off(taken(integrator(size=size), until=_SPAN)[-1]))
    loose, tight = (taken(integrator(tolerance=tolerance), until=20.0) for tolerance in (1e-6, 1e-9))
    return math.log(off(loose[-1]) / off(tight[-1])) / math.log(max(len(tight) / len(loose), 1.001))


def slope_of_estimate(integrator: type[OneStep]) -> float:
    """The power of the step with which the error estimate of one attempt scales."""

    def estimate(size: float) -> float:
        states = ((begin, *path(begin)) for begin in _BEGINS)
        return float(np.mean([integrator().attempt(coupled, t, size, x, v, coupled(t, x)).error for t, x, v in states]))

    return _power(estimate)


def _power(error: Callable[[float], float]) -> float:
    """The power of the step with which ``error`` scales: from the two last, one half the other, above rounding."""
    errors: dict[int, float] = {}
    for count in _COUNTS:
        errors[count] = error(_SPAN / count)
        if count > _FEWEST and not errors[count] > _LEAST:
            break
    fine = max((count for count in errors if count // 2 in errors and errors[count] > _LEAST), default=_FEWEST)
    before, last = errors[fine // 2], errors[fine]
    return math.log2(before / last) if last > 0 and before > 0 else math.nan


def _error_of_attempts(method: OneStep, size: float) -> float:
    """Error of the path after equal attempts, root mean square over the runs."""
    count, squares = round(_SPAN / size), []
    for begin in _BEGINS:
        (x, v), a = path(begin), coupled(begin, path(begin)[0])
        for index in range(count):
            x, v, a, _ = method.attempt(coupled, begin + index * size, size, x, v, a)
        squares.append(np.mean(np.subtract((x, v), path(begin + count * size)) ** 2))
    return float(np.sqrt(np.mean(squares)))


# ---------------------------------------------------------------- chains


def struck() -> tuple[FloatArray, FloatArray]:
    """Positions and velocities of the granules that were struck, by the method of the highest order."""
    last = taken(Rkn1210(tolerance=1e-13), hertz, STRUCK_UNTIL, STRUCK)[-1]
    return last.x, last.v


def peak_with(method: Integrator) -> float:
    """Peak force of the primary behind a triangular shock of three characteristic times, over that of the shock."""
    problem = ChainProblem(Triangular(duration_ratio=3), rise_time=1.0, peak_force=1.0)
    found = ChainRun(problem, method, wave_threshold=0.05, primary_doubt=1e-4, later_doubt=1e-2, most_contacts=200)
    return max(wave.peak_force for wave in found.finished().waves)
