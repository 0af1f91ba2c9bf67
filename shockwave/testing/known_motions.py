"""Motions with known solutions for the tests of integrators."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from itertools import islice
from typing import Any

import numpy as np
from attrs import define, field

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_assembly import Assembly
from shockwave.engine.chain_motion import integrate
from shockwave.engine.integrator import Acceleration, Integrator, Step
from shockwave.engine.nystroem_integrators import Rkn1210
from shockwave.engine.one_step import OneStep
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.profiles.triangular import Triangular
from shockwave.simulation.wave_train_run import ChainRun

# Phases of the granules in the smooth motion.
_PHASES = np.arange(5) * 0.7
# Duration of a run that measures the order.
_SPAN = 6.0
# Initial times of these runs, over which the error is averaged.
_BEGINS = (0.0, 0.9, 2.3, 3.1, 4.7, 5.6)
# Numbers of steps in a run; most are twice another one.
_COUNTS = (4, 5, 6, 7, 8, 10, 12, 14, 16, 24, 32, 64, 128)
# Smallest number of steps that shows a slope.
_MIN_COUNT = 8
# Largest number of steps of a run.
_MAX_STEPS = 200_000
# A triangular shock of three characteristic times.
_PULSE = ScaledProblem(Triangular(duration_ratio=3), rise_time=1.0, peak_force=1.0)
# Smallest error that is not dominated by rounding.
_MIN_ERROR = 2e-13
#: Positions and velocities of a chain at rest that the first granule strikes.
STRUCK = (np.zeros(5), np.array([1.0, 0.0, 0.0, 0.0, 0.0]))
# Times at which mixed chains are compared, and tolerances and steps between which their errors show an order.
_MIXED_TIMES = np.linspace(7.5, 30.0, 30)
_MIXED_TOLERANCES = (1e-5, 1e-8)
_MIXED_STEPS = (0.2, 0.1)
# End of the shock on a mixed chain and of the collisions that follow.
_MIXED_UNTIL = 20.0


def smooth_motion(time: Any) -> tuple[FloatArray, FloatArray]:
    """The smooth motion: positions and velocities, shape (granules,) and that of ``time``."""
    angle = time + _PHASES.reshape(-1, *[1] * np.ndim(time))
    return np.asarray(np.cos(angle) + 0.3 * np.sin(2 * angle)), np.asarray(0.6 * np.cos(2 * angle) - np.sin(angle))


def _neighbour_accelerations(x: FloatArray) -> FloatArray:
    """Accelerations by a smooth force between neighbours."""
    return np.asarray(-np.diff(np.sin(x[:-1] - x[1:]), axis=0, prepend=0.0, append=0.0))


def smooth_force(time: Any, x: FloatArray) -> FloatArray:
    """Acceleration of a driven chain, of which the smooth motion is the solution."""
    angle = time + _PHASES.reshape(-1, *[1] * (x.ndim - 1))
    driven = np.cos(angle) + 1.2 * np.sin(2 * angle)
    return np.asarray(_neighbour_accelerations(x) - _neighbour_accelerations(smooth_motion(time)[0]) - driven)


def hertz(_: Any, x: FloatArray) -> FloatArray:
    """Accelerations of eq. (1) without an applied force; contacts can open."""
    force = np.maximum(x[:-1] - x[1:], 0.0) ** 1.5
    return np.asarray(-np.diff(force, prepend=0.0, append=0.0))


def broken_acceleration(since: float, value: float) -> Acceleration:
    """An acceleration that equals ``value`` after the time ``since``."""
    return lambda time, x: smooth_force(time, x) if time < since else np.full_like(x, value)


@define
class Watched:
    """An acceleration that records the times and shapes of its arguments."""

    acceleration: Acceleration
    times: list[float] = field(factory=list)
    shapes: list[tuple[int, ...]] = field(factory=list)

    def __call__(self, time: Any, x: FloatArray) -> FloatArray:
        self.times.append(float(time))
        self.shapes.append(np.shape(x))
        return self.acceleration(time, np.ravel(x))  # the record shows a wrong shape

    def check_within(self, begin: float, end: float) -> None:
        """Fail if it was called at times outside ``begin`` to ``end``."""
        first, last = min(self.times), max(self.times)
        assert begin <= first <= last <= end, f"a stage lies at t = {first!r} or {last!r} (check for rounding)"


# ---------------------------------------------------------------- runs


def all_steps(
    method: Integrator,
    acceleration: Acceleration = smooth_force,
    until: float = 3.0,
    state: tuple[FloatArray, FloatArray] | None = None,
    begin: float = 0.0,
) -> list[Step]:
    """All steps of a run, by default of the smooth motion."""
    x, v = smooth_motion(begin) if state is None else state
    steps = list(islice(method.steps(acceleration, begin, until, x.copy(), v.copy(), None), _MAX_STEPS))
    assert len(steps) < _MAX_STEPS, f"steps does not end: {_MAX_STEPS} steps until t = {steps[-1].end!r}"
    return steps


def distance(state: Any, other: Any) -> float:
    """Largest difference between two states."""
    return float(np.max(np.abs(np.subtract(state, other))))


def step_error(step: Step) -> float:
    """Error of the smooth motion at the end of a step."""
    return distance((step.x, step.v), smooth_motion(step.end))


# ---------------------------------------------------------------- order


def slope(integrator: type[Integrator]) -> float:
    """Exponent of the step size with which the error of the smooth motion scales."""
    if issubclass(integrator, OneStep):
        return _power(lambda size: _error_of_attempts(integrator(), size))
    if not integrator.adaptive:
        return _power(lambda size: step_error(all_steps(integrator(size=size), until=_SPAN)[-1]))
    loose, tight = (all_steps(integrator(tolerance=tolerance), until=20.0) for tolerance in (1e-6, 1e-9))
    return math.log(step_error(loose[-1]) / step_error(tight[-1])) / math.log(max(len(tight) / len(loose), 1.001))


def slope_of_estimate(integrator: type[OneStep]) -> float:
    """Exponent of the step size with which the error estimate of one attempt scales."""

    def estimate(size: float) -> float:
        states = ((begin, *smooth_motion(begin)) for begin in _BEGINS)
        return float(
            np.mean([integrator().attempt(smooth_force, t, size, x, v, smooth_force(t, x)).error for t, x, v in states])
        )

    return _power(estimate)


def _power(error: Callable[[float], float]) -> float:
    """Exponent of the step size with which ``error`` scales, from the smallest step above rounding and its double."""
    errors: dict[int, float] = {}
    for count in _COUNTS:
        errors[count] = error(_SPAN / count)
        if count > _MIN_COUNT and not errors[count] > _MIN_ERROR:
            break
    fine = max((count for count in errors if count // 2 in errors and errors[count] > _MIN_ERROR), default=_MIN_COUNT)
    before, last = errors[fine // 2], errors[fine]
    return math.log2(before / last) if last > 0 and before > 0 else math.nan


def _error_of_attempts(method: OneStep, size: float) -> float:
    """Error of the smooth motion after steps of equal size, root mean square over the runs."""
    count, squares = round(_SPAN / size), []
    for begin in _BEGINS:
        (x, v), a = smooth_motion(begin), smooth_force(begin, smooth_motion(begin)[0])
        for index in range(count):
            x, v, a, _ = method.attempt(smooth_force, begin + index * size, size, x, v, a)
        squares.append(np.mean(np.subtract((x, v), smooth_motion(begin + count * size)) ** 2))
    return float(np.sqrt(np.mean(squares)))


# ---------------------------------------------------------------- chains


def mixed_shares(granules: int) -> FloatArray:
    """Numbers from 0 to 1 in irregular order, by which granules differ."""
    return np.array([0.618 * index % 1 for index in range(granules)])


def _mixed_chain(granules: int, loaded: bool) -> Assembly:
    """Different granules before a wall: with gaps under a shock, or struck and so loaded that no contact opens."""
    share, ones = mixed_shares(granules), np.ones(granules)
    stiffnesses = np.array(2 - share)
    return Assembly(
        inverse_masses=1 / (0.5 + 1.5 * share),
        stiffnesses=stiffnesses,
        overlaps=np.array(stiffnesses ** (-2 / 3) if loaded else -0.1 * share),
        exponents=1.5 * ones,
        fixed_wall=True,
        damping=0 * ones,
        damping_powers=0 * ones,
        force=None if loaded else _PULSE,
        velocity=0.5 * loaded,
    )


@cache
def mixed_forces(integrator: type[Integrator], granules: int, accuracy: float) -> FloatArray:
    """Greatest contact forces of a mixed chain with gaps under a shock, with a tolerance or a step."""
    return integrate(_mixed_chain(granules, loaded=False), accuracy, until=_MIXED_UNTIL, integrator=integrator).forces


@cache
def _integrate_loaded_chain(integrator: type[Integrator], granules: int, accuracy: float) -> tuple[FloatArray, int]:
    """Positions and velocities of a mixed chain under a static load, and the number of steps."""
    until = float(_MIXED_TIMES[-1])
    motion = integrate(
        _mixed_chain(granules, loaded=True), accuracy, until=until, times=_MIXED_TIMES, integrator=integrator
    )
    return np.array((motion.samples.x, motion.samples.v)), motion.steps


def mixed_slope(integrator: type[Integrator], granules: int) -> float:
    """Exponent of the step size with which the error of a mixed chain under a static load scales."""
    exact, _ = _integrate_loaded_chain(Rkn1210, granules, 1e-14)
    accuracies = _MIXED_TOLERANCES if integrator.adaptive else _MIXED_STEPS
    (coarse, few), (fine, many) = (_integrate_loaded_chain(integrator, granules, accuracy) for accuracy in accuracies)
    ratio = float(np.linalg.norm(coarse - exact) / np.linalg.norm(fine - exact))
    return math.log(ratio) / math.log(max(many / few, 1.001))


@cache
def best_peak() -> float:
    """The peak force of `peak_with` by the method of the highest order."""
    return peak_with(Rkn1210(tolerance=1e-10))


def peak_with(method: Integrator) -> float:
    """Peak force of the leading wave of a triangular shock of three characteristic times, over that of the shock."""
    found = ChainRun(_PULSE, method, wave_threshold=0.05, primary_doubt=1e-4, later_doubt=1e-2, most_contacts=200)
    return max(wave.peak_force for wave in found.finish().waves)
