"""Predictors: formulae, simulation and a code made elsewhere on one scale of error of the primary's peak force."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

from attrs import frozen

from shockwave.benchmark import outside
from shockwave.benchmark.chains import Case
from shockwave.benchmark.rows import Problem, Row, setting_text
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
_TIGHTEST, _SECOND = 1e-12, 1e-11
# The limit of the primary is read by others where the simulation has found it, unless that is farther than this.
_FARTHEST = 400
# What the others' chain may lack of the limit.
_LIMIT_RTOL = 1e-9


class _Reading(NamedTuple):
    alpha: Literal["constant", "literal"]
    coefficient: str


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


def _limit(case: Case) -> _Limit:
    best, other = (
        simulate(case.shock, case.chain, rtol=rtol, integrator=name, waves="primary")
        for name, rtol in (("rkn1210", _TIGHTEST), ("rkn86", _SECOND))
    )
    near = simulate(case.shock, case.chain, rtol=_LIMIT_RTOL, waves="primary").found
    problem = Problem(
        family="predictors",
        name=case.name,
        description=case.description.partition(", read at")[0] + ": the limit of the primary's peak force",
        quantities=("peak force",),
        reference=f"simulation at rtol {_TIGHTEST:g} by rkn1210, cross-checked by rkn86",
        reference_error=max(best.error_estimate, abs(other.peak_force / best.peak_force - 1)),
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
    limit = _limit(case)
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

    for found in tried(_READINGS, run, limits):
        setting = f"alpha {found.setting.alpha}, {found.setting.coefficient} A"
        told: dict[str, Any] = {}
        if found.result is not None:
            told = {"errors": {"peak force": limit.error(found.result.peak_force)}}
        yield Row.of(limit.problem, f"{model}, {found.setting.alpha}", setting, found, **told)


def _of_simulation(case: Case, limit: _Limit, limits: Limits, quick: bool) -> Iterator[Row]:
    def run(rtol: float, _: Clock) -> SimulationResult:
        return simulate(case.shock, case.chain, rtol=rtol, waves="primary")

    for found in tried(_QUICK if quick else _LADDER, run, limits):
        told: dict[str, Any] = {}
        if found.result is not None:
            errors, cost = {"peak force": limit.error(found.result.peak_force)}, found.result.cost
            told = {"errors": errors, "evaluations": cost.force_evaluations, "steps": cost.steps}
        yield Row.of(limit.problem, SIMULATION, setting_text("rtol", found.setting), found, found.setting, **told)
