"""Predictors: formulae, simulation and a code made elsewhere on one scale of error of the primary's peak force."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

from attrs import frozen

from shockwave.benchmark import outside
from shockwave.benchmark.chains import Case, patience
from shockwave.benchmark.rows import Problem, Row, setting_text, worst
from shockwave.benchmark.timing import Clock, Limits, tried
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.predictor import Predictor
from shockwave.registry import entries

__all__ = ["SIMULATION", "rows"]

#: What the product's own simulation is called beside others.
SIMULATION = "simulate"

_LADDER = tuple(10.0**-power for power in range(2, 10))
_QUICK = (1e-2, 1e-4, 1e-6, 1e-8)
# The reference: from loose to tight, each with how many times as long as the one before it may take at the worst: a
# search cannot be stopped midway, and that by rkn1210 is done again and again on some long trains.
_REFERENCES = (("rkn86", 1e-6, 0.0), ("rkn86", 1e-8, 2.0), ("rkn86", 1e-11, 20.0), ("rkn1210", 1e-12, 5.0))
# The limit of the primary is read by others where the simulation has found it, unless that is farther than this.
_FARTHEST = 400
# What the others' chain may lack of the limit.
_LIMIT_RTOL = 1e-9


class _Reading(NamedTuple):
    alpha: Literal["constant", "literal"]
    coefficient: str


_SECTION_4 = "section-4"
_READINGS = tuple(_Reading(alpha, which) for alpha in ("constant", "literal") for which in ("exact", "paper"))


@frozen(eq=False)
class _Limit:
    """The peak force of the primary far along the chain, and where and when others may read it."""

    problem: Problem
    peak_force: float
    place: Case
    time: float

    def error(self, peak_force: float) -> float:
        return abs(peak_force / self.peak_force - 1)


def _limit(case: Case, limits: Limits) -> _Limit:
    found: list[tuple[str, float, SimulationResult]] = []
    seconds = 0.0
    for name, rtol, growth in _REFERENCES:
        if growth * seconds > patience(limits).run:
            break
        begin = time.perf_counter()
        found.append((name, rtol, simulate(case.shock, case.chain, rtol=rtol, integrator=name, waves="primary")))
        seconds = time.perf_counter() - begin
    name, rtol, best = found[-1]
    source, error = f"simulation at rtol {rtol:g} by {name}", best.error_estimate
    if len(found) > 1:
        second, looser, other = found[-2]
        source += f", cross-checked by {second}" + (f" at {looser:g}" if second == name else "")
        error = worst(error, abs(other.peak_force / best.peak_force - 1))
    whole = len(found) == len(_REFERENCES)
    near = simulate(case.shock, case.chain, _LIMIT_RTOL, waves="primary").found if whole else best.found
    problem = Problem(
        family="predictors",
        name=case.name,
        description=case.description.partition(", read at")[0] + ": the limit of the primary's peak force",
        quantities=("peak force",),
        reference=source,
        reference_error=error,
    )
    place = Case(case.name, case.description, case.shock, case.chain, int(near.contact))
    return _Limit(problem, best.peak_force, place, near.time)


def rows(case: Case, limits: Limits, quick: bool) -> tuple[Problem, Iterator[Row]]:
    """The problem, and a row for every reading of every model, every tolerance of the simulation, and SciPy's.

    Raises
    ------
    ShockwaveError
        When the problem cannot be simulated, so that there is nothing to compare with.
    """
    limit = _limit(case, limits)
    return limit.problem, _rows(case, limit, limits, quick)


def _rows(case: Case, limit: _Limit, limits: Limits, quick: bool) -> Iterator[Row]:
    for model in (entry.name for entry in entries("models")):
        yield from _of_model(model, case, limit, limits)
    yield from _of_simulation(case, limit, limits, quick)
    if limit.place.contact > _FARTHEST:
        problem = f"left out: the limit is reached at contact {limit.place.contact} only"
        yield Row(
            family="predictors", case=case.name, method=outside.SCIPY.name, setting="-", value=None, problem=problem
        )
        return
    for found in outside.ladder(outside.SCIPY, limit.place, limit.time, limits, quick):
        told: dict[str, Any] = {}
        if found.result is not None:
            peak_force = found.result.force * case.scaled[1].force
            told = {"errors": {"peak force": limit.error(peak_force)}, "evaluations": found.result.evaluations}
        setting = setting_text(outside.SCIPY.setting, found.setting)
        yield Row.of(limit.problem, outside.SCIPY.name, setting, found, found.setting, **told)


def _of_model(model: str, case: Case, limit: _Limit, limits: Limits) -> Iterator[Row]:
    def run(reading: _Reading, _: Clock) -> Outcome:
        predictor = Predictor(model=model, alpha=reading.alpha, momentum_coefficient=reading.coefficient)
        return predictor.predict(case.shock, case.chain)

    # Only section 4 is read in several ways.
    several = model == _SECTION_4
    for found in tried(_READINGS if several else _READINGS[:1], run, limits):
        setting = f"alpha {found.setting.alpha}, {found.setting.coefficient} A" if several else "-"
        told: dict[str, Any] = {}
        if found.result is not None:
            told = {"errors": {"peak force": limit.error(found.result.peak_force)}}
        name = f"{model}, {found.setting.alpha}" if several else model
        yield Row.of(limit.problem, name, setting, found, **told)


def _of_simulation(case: Case, limit: _Limit, limits: Limits, quick: bool) -> Iterator[Row]:
    def run(rtol: float, _: Clock) -> SimulationResult:
        return simulate(case.shock, case.chain, rtol=rtol, waves="primary")

    for found in tried(_QUICK if quick else _LADDER, run, limits):
        told: dict[str, Any] = {}
        if found.result is not None:
            errors, cost = {"peak force": limit.error(found.result.peak_force)}, found.result.cost
            told = {"errors": errors, "evaluations": cost.force_evaluations, "steps": cost.steps}
        yield Row.of(limit.problem, SIMULATION, setting_text("rtol", found.setting), found, found.setting, **told)
