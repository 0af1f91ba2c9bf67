"""Predictors: formulae and simulation on one scale of error of the primary's peak force."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

from shockwave.benchmark import chain_problems
from shockwave.benchmark.chain_problems import Case, patience
from shockwave.benchmark.timed_runs import Answer, Clock, Experiment, Limits, Method
from shockwave.benchmark.work_precision import Problem, greatest
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate
from shockwave.prediction.predictor import Predictor
from shockwave.registry import entries
from shockwave.scenario.scenario import Scenario

_LADDER = tuple(10.0**-power for power in range(2, 10))
_QUICK = (1e-2, 1e-4, 1e-6, 1e-8)
# References, each with how many times as long as the one before it may take: a search cannot be stopped midway.
_REFERENCES = (("rkn86", 1e-6, 0.0), ("rkn86", 1e-8, 2.0), ("rkn86", 1e-11, 20.0), ("rkn1210", 1e-12, 5.0))
# Readings of section 4: alpha, and the coefficient A.
_READINGS = (("constant", "exact"), ("constant", "paper"), ("literal", "exact"), ("literal", "paper"))

Run = Callable[[Any, Clock], Answer]


def named(limits: Limits, quick: bool) -> Iterator[Experiment]:
    """The named problems."""
    names = ("short", "A", "B") if quick else ("short", "A", "B", "slow")
    return (_experiment(chain_problems.named(name), limits, quick) for name in names)


def of_scenario(scenario: Scenario, limits: Limits, quick: bool) -> Experiment:
    """The scene of a scenario.

    Raises
    ------
    ShockwaveError
        When it cannot be simulated, so that there is no reference.
    """
    shock, chain = scenario.shock, scenario.chain
    return _experiment(Case(scenario.name, type(shock.profile).__name__, shock, chain, 0), limits, quick)


def _experiment(case: Case, limits: Limits, quick: bool) -> Experiment:
    best, source, error = _limit(case, patience(limits))
    description = f"{case.description}: the limit of the primary's peak force"
    problem = Problem("predictors", case.name, description, ("peak force",), source, error)
    return problem, _methods(case, best.peak_force, quick)


def _limit(case: Case, seconds: float) -> tuple[SimulationResult, str, float]:
    """The tightest simulation in time, how it was obtained, and the relative error of its peak force."""
    found: list[SimulationResult] = []
    last = 0.0
    for name, rtol, growth in _REFERENCES:
        if growth * last > seconds:
            break
        begin = time.perf_counter()
        found.append(simulate(case.shock, case.chain, rtol=rtol, integrator=name, waves="primary"))
        last = time.perf_counter() - begin
    best = found[-1]
    source, error = f"simulation at rtol {best.rtol:g} by {best.integrator}", best.error_estimate
    if len(found) > 1:
        other = found[-2]
        source += f", cross-checked by {other.integrator} at {other.rtol:g}"
        error = greatest((error, abs(other.peak_force / best.peak_force - 1)))
    return best, source, error


def _methods(case: Case, peak_force: float, quick: bool) -> Iterator[Method]:
    for entry in entries("models"):
        if entry.name == "section-4":
            for alpha, coefficient in _READINGS:
                yield _section_4(case, peak_force, alpha, coefficient)
        else:
            yield Method(entry.name, _prediction(case, peak_force, model=entry.name))
    yield Method("simulate", _simulation(case, peak_force), "rtol", _QUICK if quick else _LADDER)


def _section_4(case: Case, peak_force: float, alpha: str, coefficient: str) -> Method:
    run = _prediction(case, peak_force, model="section-4", alpha=alpha, momentum_coefficient=coefficient)
    return Method(f"section-4, {alpha}", run, f"alpha {alpha}, {coefficient} A")


def _prediction(case: Case, peak_force: float, **settings: Any) -> Run:
    def run(_: None, __: Clock) -> Answer:
        found = Predictor(**settings).predict(case.shock, case.chain)
        return Answer({"peak force": abs(found.peak_force / peak_force - 1)})

    return run


def _simulation(case: Case, peak_force: float) -> Run:
    def run(rtol: float, _: Clock) -> Answer:
        found = simulate(case.shock, case.chain, rtol=rtol, waves="primary")
        error = abs(found.peak_force / peak_force - 1)
        return Answer({"peak force": error}, found.cost.force_evaluations, found.cost.steps)

    return run
