"""Convergence orders of methods of fixed step, on a smooth problem: a chain whose contacts never open."""

from __future__ import annotations

from contextlib import suppress
from functools import cache

import numpy as np

from shockwave.benchmark.timed_runs import Answer, Clock, Experiment, Method
from shockwave.benchmark.work_precision import Order, Problem, Row, observed_order
from shockwave.errors import PluginError
from shockwave.quadrature import FloatArray
from shockwave.registry import entries, load
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.nystroem import Rkn86, Rkn1210

#: The name of the problem.
NAME = "closed contacts"

_GRANULES = 8
_UNTIL = 6.0  # characteristic times
# Each three quarters of the one before: steps enough in the convergent range of a method of any order.
_STEPS = tuple(_UNTIL / count for count in (8, 11, 15, 20, 27, 36, 48, 64, 85, 113, 151, 201, 268))
_QUICK = _STEPS[:11]
_TIGHTEST = 1e-14


def _acceleration(_: float, x: FloatArray) -> FloatArray:
    """Eq. (1) between two walls that press the granules together by the unit of overlap."""
    force = (1.0 - np.diff(x, prepend=0.0, append=0.0)) ** 1.5
    return np.asarray(force[:-1] - force[1:])


def _final_state(method: Integrator, clock: Clock) -> FloatArray:
    """Positions and velocities at the end."""
    places = np.arange(1, _GRANULES + 1)
    x, v = 0.1 * np.sin(0.9 * places), 0.2 * np.cos(1.7 * places)
    for step in method.steps(_acceleration, 0.0, _UNTIL, x, v, None):
        clock.check()
        x, v = step.x, step.v
    return np.concatenate((x, v))


@cache
def _reference() -> tuple[FloatArray, float]:
    best, other = (_final_state(method(tolerance=_TIGHTEST), Clock()) for method in (Rkn1210, Rkn86))
    return best, _difference(best, other)


def _difference(best: FloatArray, other: FloatArray) -> float:
    return float(np.linalg.norm(other - best) / np.linalg.norm(best))


def experiment(quick: bool) -> Experiment:
    """The problem, and the registered methods of fixed step."""
    description = f"{_GRANULES} granules pressed together between walls, let go: the state after {_UNTIL:g} T0"
    source = f"rkn1210 at a step tolerance of {_TIGHTEST:g}, cross-checked by rkn86"
    problem = Problem("integrators", NAME, description, ("state",), source, _reference()[1])
    return problem, (_method(name, method, quick) for name, method in _fixed_step().items())


def _fixed_step() -> dict[str, type[Integrator]]:
    """By name; a plugin at fault is reported with the other problems."""
    found: dict[str, type[Integrator]] = {}
    for entry in entries("integrators"):
        with suppress(PluginError):
            found[entry.name] = load("integrators", entry.name)
    return {name: method for name, method in found.items() if not method.adaptive}


def _method(name: str, method: type[Integrator], quick: bool) -> Method:
    def run(size: float, clock: Clock) -> Answer:
        integrator = method(size=size)
        state = _final_state(integrator, clock)
        return Answer({"state": _difference(_reference()[0], state)}, integrator.evaluations)

    return Method(name, run, "step", _QUICK if quick else _STEPS)


def orders(rows: list[Row]) -> tuple[Order, ...]:
    """The order of each method, from the rows of this problem."""
    found = []
    for name, method in _fixed_step().items():
        own = [row for row in rows if (row.case, row.method) == (NAME, name)]
        if own:
            found.append(Order(name, method.order, observed_order(own)))
    return tuple(found)
