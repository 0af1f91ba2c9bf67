"""Integrators: every registered one, and the simulation as it is called, on the front at one contact."""

from __future__ import annotations

from collections.abc import Iterator

from shockwave.benchmark import chain_problems, convergence_order
from shockwave.benchmark.chain_problems import Case, Reference, at_setting, read_front
from shockwave.benchmark.timed_runs import Answer, Clock, Experiment, Limits, Method
from shockwave.benchmark.work_precision import Problem
from shockwave.errors import PluginError
from shockwave.measurement.simulate import scaled, simulate
from shockwave.registry import entries, load
from shockwave.scenario.scenario import Scenario
from shockwave.simulation.integrator import Integrator

_LADDER = tuple(10.0**-power for power in range(2, 13))
_QUICK_RTOLS = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
_QUICK_TOLERANCES = (1e-3, 1e-6, 1e-9)
_STEPS = tuple(0.2 / 2**power for power in range(9))
_QUICK_STEPS = (0.2, 0.1, 0.05)


def named(limits: Limits, quick: bool) -> Iterator[Experiment]:
    """The problem of the orders, and the named problems."""
    yield convergence_order.experiment(quick)
    for name in ("A",) if quick else ("A", "B", "slow"):
        yield _experiment(chain_problems.named(name), limits, quick)


def of_scenario(scenario: Scenario, limits: Limits, quick: bool) -> Experiment:
    """The scene of a scenario.

    Raises
    ------
    ShockwaveError
        When there is no reference.
    """
    return _experiment(chain_problems.case_of(scenario), limits, quick)


def _experiment(case: Case, limits: Limits, quick: bool) -> Experiment:
    answer = chain_problems.reference(case, chain_problems.patience(limits))
    description = f"{case.description}, read at contact {case.contact}"
    quantities = ("peak force", "arrival time", "energy")
    problem = Problem("integrators", case.name, description, quantities, answer.source, answer.error)
    return problem, _methods(case, answer, quick)


def _methods(case: Case, reference: Reference, quick: bool) -> Iterator[Method]:
    yield _simulation(case, reference, quick)
    for entry in entries("integrators"):
        try:
            method: type[Integrator] = load("integrators", entry.name)
        except PluginError as error:
            yield Method.broken(entry.name, error)
        else:
            yield _integrator(case, reference, method, quick)


def _simulation(case: Case, reference: Reference, quick: bool) -> Method:
    _, scales = scaled(case.shock, case.chain)

    def run(rtol: float, _: Clock) -> Answer:
        result = simulate(case.shock, case.chain, rtol=rtol, waves="primary", contacts=(case.contact,))
        passage, cost = result.passage(case.contact), result.cost
        errors = reference.errors(passage.peak_force / scales.force, passage.arrival_time / scales.time)
        return Answer({**errors, "energy": result.energy_defect}, cost.force_evaluations, cost.steps)

    return Method("simulate", run, "rtol", _QUICK_RTOLS if quick else _LADDER)


def _integrator(case: Case, reference: Reference, method: type[Integrator], quick: bool) -> Method:
    def run(setting: float, clock: Clock) -> Answer:
        reading = read_front(case, at_setting(method, setting), clock)
        errors = reference.errors(reading.force, reading.time)
        return Answer({**errors, "energy": reading.drift}, reading.evaluations, reading.steps)

    if method.adaptive:
        return Method(method.name, run, "tolerance", _QUICK_TOLERANCES if quick else _LADDER)
    return Method(method.name, run, "step", _QUICK_STEPS if quick else _STEPS)
