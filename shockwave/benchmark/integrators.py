"""Integrators: every registered one, the simulation as it is called, and codes made elsewhere, on one problem."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from shockwave.benchmark import outside
from shockwave.benchmark.chains import Case, Reading, by_search, method_of, read_front
from shockwave.benchmark.predictors import SIMULATION
from shockwave.benchmark.rows import Problem, Row, setting_text
from shockwave.benchmark.timing import Clock, Limits, Tried, tried
from shockwave.errors import PluginError
from shockwave.measurement.simulate import simulate
from shockwave.registry import entries, load
from shockwave.simulation.integrator import Integrator

__all__ = ["problem", "rows"]

_QUANTITIES = ("peak force", "arrival time", "energy")
_RTOLS = tuple(10.0**-power for power in range(2, 13))
_QUICK_RTOLS = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
_TOLERANCES = tuple(10.0**-power for power in range(2, 13))
_QUICK_TOLERANCES = (1e-3, 1e-6, 1e-9)
_STEPS = tuple(0.2 / 2**power for power in range(9))
_QUICK_STEPS = (0.2, 0.1, 0.05)


def problem(case: Case) -> Problem:
    """The problem in words.

    Raises
    ------
    ShockwaveError
        When its reference cannot be had.
    """
    return Problem(
        family="integrators",
        name=case.name,
        description=case.description,
        quantities=_QUANTITIES,
        reference=case.reference.source,
        reference_error=case.reference.error,
    )


def rows(case: Case, limits: Limits, quick: bool) -> Iterator[Row]:
    """A row for each setting of each method."""
    about = problem(case)
    yield from _of_simulation(about, case, limits, quick)
    for entry in entries("integrators"):
        try:
            method: type[Integrator] = load("integrators", entry.name)
        except PluginError as error:
            yield Row(
                family=about.family, case=case.name, method=entry.name, setting="-", value=None, problem=str(error)
            )
            continue
        yield from _of_method(about, case, method, limits, quick)
    for code in outside.CODES:
        for found in outside.ladder(code, case, case.reference.time, limits, quick):
            yield _row(about, case, code.name, setting_text(code.setting, found.setting), found)


def _of_simulation(about: Problem, case: Case, limits: Limits, quick: bool) -> Iterator[Row]:
    def run(rtol: float, _: Clock) -> Reading:
        return by_search(case, simulate(case.shock, case.chain, rtol=rtol, waves="primary", contacts=(case.contact,)))

    for found in tried(_QUICK_RTOLS if quick else _RTOLS, run, limits):
        yield _row(about, case, SIMULATION, setting_text("rtol", found.setting), found)


def _of_method(about: Problem, case: Case, method: type[Integrator], limits: Limits, quick: bool) -> Iterator[Row]:
    def run(setting: float, clock: Clock) -> Reading:
        return read_front(case, method_of(method, setting), clock)

    if method.adaptive:
        what, settings = "tolerance", _QUICK_TOLERANCES if quick else _TOLERANCES
    else:
        what, settings = "step", _QUICK_STEPS if quick else _STEPS
    for found in tried(settings, run, limits):
        yield _row(about, case, method.name, setting_text(what, found.setting), found)


def _row(about: Problem, case: Case, method: str, setting: str, found: Tried[Any, Reading]) -> Row:
    told: dict[str, Any] = {}
    if found.result is not None:
        reading = found.result
        told = {"errors": case.errors(reading), "evaluations": reading.evaluations, "steps": reading.steps}
    return Row.of(about, method, setting, found, found.setting, **told)
