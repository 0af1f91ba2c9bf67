"""The order of methods of fixed step, on a problem that is smooth: a chain whose contacts never open."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from shockwave.benchmark.rows import Order, Problem, Row, order, setting_text
from shockwave.benchmark.timing import Clock, Limits, tried
from shockwave.errors import PluginError
from shockwave.quadrature import FloatArray
from shockwave.registry import entries, load
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.nystroem import Rkn86, Rkn1210

__all__ = ["NAME", "names", "orders", "problem", "rows"]

#: The name of the problem.
NAME = "closed contacts"

_GRANULES, _UNTIL = 8, 6.0
# Each three quarters of the one before: steps enough in the convergent range of a method of any order.
_STEPS = tuple(_UNTIL / count for count in (8, 11, 15, 20, 27, 36, 48, 64, 85, 113, 151, 201, 268))
_QUICK = _STEPS[:11]
_TIGHTEST = 1e-14


def _acceleration(_: float, x: FloatArray) -> FloatArray:
    """Eq. (1) between two walls that press the granules together by the unit of overlap."""
    force = (1.0 - np.diff(x, prepend=0.0, append=0.0)) ** 1.5
    return np.asarray(force[:-1] - force[1:])


def _begin() -> tuple[FloatArray, FloatArray]:
    places = np.arange(1, _GRANULES + 1)
    return 0.1 * np.sin(0.9 * places), 0.2 * np.cos(1.7 * places)


def _end(method: Integrator, clock: Clock | None = None) -> FloatArray:
    """Positions and velocities at the end."""
    x, v = _begin()
    for step in method.steps(_acceleration, 0.0, _UNTIL, x, v, None):
        if clock is not None:
            clock.check()
        x, v = step.x, step.v
    return np.concatenate((x, v))


@cache
def _reference() -> tuple[FloatArray, float]:
    best, other = (_end(method(tolerance=_TIGHTEST)) for method in (Rkn1210, Rkn86))
    return best, _off(best, other)


def _off(best: FloatArray, other: FloatArray) -> float:
    return float(np.linalg.norm(other - best) / np.linalg.norm(best))


def problem() -> Problem:
    """The problem in words."""
    return Problem(
        family="integrators",
        name=NAME,
        description=f"{_GRANULES} granules pressed together between walls, let go: the state after {_UNTIL:g} T0",
        quantities=("state",),
        reference=f"rkn1210 at a step tolerance of {_TIGHTEST:g}, cross-checked by rkn86",
        reference_error=_reference()[1],
    )


def rows(name: str, limits: Limits, quick: bool) -> Iterator[Row]:
    """A row for each step of the method of fixed step that is registered as ``name``."""
    method: type[Integrator] = load("integrators", name)

    def run(size: float, clock: Clock) -> tuple[FloatArray, int]:
        integrator = method(size=size)
        return _end(integrator, clock), integrator.evaluations

    for found in tried(_QUICK if quick else _STEPS, run, limits):
        told: dict[str, Any] = {}
        if found.result is not None:
            state, evaluations = found.result
            told = {"errors": {"state": _off(_reference()[0], state)}, "evaluations": evaluations}
        yield Row.of(problem(), name, setting_text("step", found.setting), found, found.setting, **told)


def names() -> list[str]:
    """The registered methods of fixed step; those of a plugin at fault are told of with the other problems."""
    found = []
    for entry in entries("integrators"):
        try:
            method: type[Integrator] = load("integrators", entry.name)
        except PluginError:
            continue
        if not method.adaptive:
            found.append(entry.name)
    return found


def orders(found: list[Row]) -> tuple[Order, ...]:
    """The order of each method, from its rows on this problem."""
    methods = dict.fromkeys(row.method for row in found)
    return tuple(
        Order(
            method=name,
            declared=load("integrators", name).order,
            fitted=order(row for row in found if row.method == name),
        )
        for name in methods
    )
