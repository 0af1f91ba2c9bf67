"""The bench: its families of problems, the methods that are run on them, and where it was run."""

from __future__ import annotations

import os
import platform
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import scipy
from attrs import evolve

from shockwave import __version__
from shockwave.benchmark.chain_problems import CASES, Case, at_setting, case_of, read_front, reference
from shockwave.benchmark.work_precision import (
    Answer,
    Clock,
    Experiment,
    Limits,
    Method,
    Problem,
    Row,
    WorkPrecision,
    measured,
)
from shockwave.errors import ShockwaveError
from shockwave.measurement.simulate import scaled, simulate
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.tabulated import Tabulated
from shockwave.profiles.triangular import Triangular
from shockwave.progress import progressed
from shockwave.quadrature import FloatArray, Integrand
from shockwave.registry import entries, load, plugins
from shockwave.scenario.scenario import Scenario
from shockwave.simulation.backend import compiled

FAMILIES = ("quadratures", "predictors", "integrators")
_QUICK = Limits(run=0.5, repetitions=0.08, repeats=5, every=2)
_FULL = Limits(run=4.0, repetitions=0.4, repeats=15)
_TOLERANCES = tuple(10.0**-power for power in range(2, 13))
_STEPS = tuple(0.2 / 2**power for power in range(9))
_ROUNDING = 2e-16


def run(
    scenarios: Sequence[Scenario] = (),
    families: Sequence[str] = (),
    quick: bool = False,
    longest: float | None = None,
) -> WorkPrecision:
    """Run the families on the named problems, or on the scenes of scenarios.

    Parameters
    ----------
    scenarios : sequence of Scenario
        Scenes that take the place of the named problems.
    families : sequence of "quadratures", "predictors", "integrators"
        All of them if left out.
    quick : bool
        Fewer problems, settings and repetitions; ends within a minute.
    longest : float, optional
        The longest that one run may take [s]; what would take longer is left out with a row that says so.
    """
    limits = _QUICK if quick else _FULL
    if longest is not None:
        limits = evolve(limits, run=longest, repetitions=min(limits.repetitions, longest))
    problems: list[Problem] = []
    rows: list[Row] = []
    for family in FAMILIES:
        if families and family not in families:
            continue
        experiments = of_scenarios(family, scenarios) if scenarios else named(family, quick)
        for problem, methods in experiments:
            progressed(f"{family}: {problem.name}", 0)
            problems.append(problem)
            for method in methods:
                rows.extend(measured(problem, method, limits))
    return WorkPrecision(
        provenance=_provenance(quick, limits),
        problems=tuple(problems),
        rows=tuple(rows),
    )


def named(family: str, quick: bool) -> Iterator[Experiment]:
    """The named problems of a family."""
    if family == "quadratures":
        for text, profile in PROFILES.items():
            name, _, description = text.partition(": ")
            yield quadratures(name, description, areas_of(profile))
        triangle = Triangular(duration_ratio=3)
        areas = Areas([(triangle.force, (0.0, 3.0))], np.array([1.5]), "closed form", _ROUNDING)
        yield quadratures("kink not given", "a triangle, n = 3, over its whole length: its kink is not given", areas)
    elif family == "predictors":
        for name in ("short", "A", "B") if quick else ("short", "A", "B", "slow"):
            yield predictors(CASES[name])
    else:
        for name in ("A",) if quick else ("A", "B", "slow"):
            yield integrators(CASES[name])


def of_scenarios(family: str, scenarios: Sequence[Scenario]) -> Iterator[Experiment]:
    """The problems of a family that scenarios make; one without a reference has a single row, which says why."""
    count = Counter[str]()
    for scenario in scenarios:
        count[scenario.name] += 1
        if count[scenario.name] > 1:  # rows are distinguished by the name
            scenario = evolve(scenario, name=f"{scenario.name} ({count[scenario.name]})")
        try:
            experiment = _of_scenario(family, scenario)
        except ShockwaveError as error:
            problem = Problem(family, scenario.name, "there is no reference", ("peak force",), "none", 1.0)
            experiment = problem, [Method("reference", partial(_raise, error))]
        yield experiment


def _of_scenario(family: str, scenario: Scenario) -> Experiment:
    profile = scenario.shock.profile
    if family == "quadratures":
        return quadratures(scenario.name, type(profile).__name__, areas_of(profile))
    return (predictors if family == "predictors" else integrators)(case_of(scenario))


def _raise(error: ShockwaveError, *_: object) -> Answer:
    raise error


def _provenance(quick: bool, limits: Limits) -> dict[str, str]:
    found = {
        "shockwave": __version__,
        "backend": "numpy" if compiled is None else "compiled",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "round": "quick" if quick else "full",
        "longest run": f"{limits.run:g} s",
        "clock": f"time.perf_counter, {time.get_clock_info('perf_counter').resolution:g} s",
    }
    others = ", ".join(f"{p.distribution} {p.version}" for p in plugins() if not p.disabled and not p.problem)
    return {**found, "plugins": others} if others else found


# ---------------------------------------------------------------- quadratures: areas and impulse of pulses

_AREA_TOLERANCES = tuple(10.0**-power for power in range(2, 15, 2))
_TIGHTEST_AREA = 1e-15
# Of a record with many kinks.
_TIMES = (0.0, 0.1, 0.25, 0.3, 0.55, 0.6, 0.8, 1.1, 1.15, 1.6, 1.9, 2.0)
_FORCES = (0.0, 0.3, 0.2, 0.7, 0.65, 1.0, 0.6, 0.7, 0.35, 0.3, 0.1, 0.0)
# Integrands, each with the points between which it is smooth.
_Pieces: TypeAlias = Sequence[tuple[Integrand, Sequence[float]]]


class Areas(NamedTuple):
    """Integrals of known ``values``, how these were obtained, and their relative error; the impulse is their sum."""

    pieces: _Pieces
    values: FloatArray
    source: str
    error: float


#: Profiles by description, which begins with the name of the problem.
PROFILES = {
    "smooth: exponential, rates 2 and 3, n = 4": Exponential(rise_rate=2, decay_rate=3, duration_ratio=4),
    "kinked: a record of 12 samples, its kinks given": Tabulated(times=_TIMES, forces=_FORCES),
    "singular ends: power law, eta 0.1 and 0.3, n = 3: infinite slope at both ends": PowerLaw(
        rise_exponent=0.1, decay_exponent=0.3, duration_ratio=3
    ),
    "nearly a jump: power law, eta 0.001 and 1, n = 3: the rise is nearly a jump": PowerLaw(
        rise_exponent=1e-3, decay_exponent=1, duration_ratio=3
    ),
}


def areas_of(profile: ShockProfile) -> Areas:
    """Rise and decay of a profile; a closed form, which may be a plugin's, is checked by quadrature."""
    rising = [point for point in profile.breakpoints if point <= 1]
    decaying = [point for point in profile.breakpoints if point >= 1]
    pieces = ((profile.rise, rising), (profile.decay, decaying))
    gauss, _ = _integrated(pieces, "gauss-legendre", _TIGHTEST_AREA)
    tanh_sinh, _ = _integrated(pieces, "tanh-sinh", _TIGHTEST_AREA)
    closed = profile.closed_areas()
    if closed is None:
        error = max(_greatest(tanh_sinh, gauss), _ROUNDING)
        source = f"gauss-legendre at a tolerance of {_TIGHTEST_AREA:g}, cross-checked by tanh-sinh"
        return Areas(pieces, gauss, source, error)
    values = np.array(closed, dtype=float)
    # At an infinite slope tanh-sinh is the more accurate, at a kink Gauss-Legendre.
    error = min(_greatest(gauss, values), _greatest(tanh_sinh, values))
    source = "closed form of the profile, cross-checked by quadrature"
    return Areas(pieces, values, source, max(error, _ROUNDING))


def _integrated(pieces: _Pieces, quadrature: str, tolerance: float) -> tuple[FloatArray, int]:
    """The integrals by a registered quadrature, and its evaluations."""
    method = load("quadratures", quadrature)()
    found = [method.integrate(integrand, points, tolerance) for integrand, points in pieces]
    values = np.array([float(integral.value) for integral in found])
    return values, int(sum(integral.evaluations for integral in found))


def _greatest(found: FloatArray, values: FloatArray) -> float:
    """The greatest relative error; NaN if any is."""
    return float(np.max(np.abs(found / values - 1)))


def quadratures(name: str, description: str, areas: Areas) -> Experiment:
    """Every registered quadrature on these areas."""

    def run(quadrature: str, tolerance: float, _: Clock) -> Answer:
        found, evaluations = _integrated(areas.pieces, quadrature, tolerance)
        errors: dict[str, float | None] = {
            "areas": _greatest(found, areas.values),
            "impulse": float(abs(found.sum() / areas.values.sum() - 1)),
        }
        return Answer(errors, evaluations)

    problem = Problem("quadratures", name, description, ("areas", "impulse"), areas.source, areas.error)
    names = [entry.name for entry in entries("quadratures")]
    return problem, [Method(each, partial(run, each), "tolerance", _AREA_TOLERANCES) for each in names]


# ---------------------------------------------------------------- predictors: the peak force far along the chain


def predictors(case: Case) -> Experiment:
    """Formulae and simulation, on one scale of error of the primary's peak force."""
    best = simulate(case.shock, case.chain, rtol=1e-12, integrator="rkn1210", waves="primary")
    other = simulate(case.shock, case.chain, rtol=1e-11, integrator="rkn86", waves="primary")
    source = "simulation at rtol 1e-12 by rkn1210, cross-checked by rkn86 at 1e-11"
    error = max(best.error_estimate, abs(other.peak_force / best.peak_force - 1))
    description = f"{case.description}: the limit of the primary's peak force"
    problem = Problem("predictors", case.name, description, ("peak force",), source, error)
    return problem, _predictor_methods(case, best.peak_force)


def _predictor_methods(case: Case, limit: float) -> Iterator[Method]:
    def predicted(settings: dict[str, Any], _: None, __: Clock) -> Answer:
        found = Predictor(**settings).predict(case.shock, case.chain)
        return Answer({"peak force": abs(found.peak_force / limit - 1)})

    def simulated(rtol: float, _: Clock) -> Answer:
        found = simulate(case.shock, case.chain, rtol=rtol, waves="primary")
        error = abs(found.peak_force / limit - 1)
        return Answer({"peak force": error}, found.cost.force_evaluations, found.cost.steps)

    for alpha, coefficient in product(("constant", "literal"), ("exact", "paper")):
        reading = {"alpha": alpha, "momentum_coefficient": coefficient}
        yield Method(f"section-4, {alpha}", partial(predicted, reading), f"alpha {alpha}, {coefficient} A")
    for entry in entries("models"):
        if entry.name != "section-4":
            yield Method(entry.name, partial(predicted, {"model": entry.name}))
    yield Method("simulate", simulated, "rtol", _TOLERANCES[:8])


# ---------------------------------------------------------------- integrators: the front at one contact


def integrators(case: Case) -> Experiment:
    """The simulation as it is called, and every registered integrator on a window that grows with the front."""
    best = reference(case)
    _, scales = scaled(case.shock, case.chain)

    def simulated(rtol: float, _: Clock) -> Answer:
        result = simulate(case.shock, case.chain, rtol=rtol, waves="primary", contacts=(case.contact,))
        passage = result.passage(case.contact)
        errors = best.errors(passage.peak_force / scales.force, passage.arrival_time / scales.time)
        errors["energy"] = result.energy_defect
        return Answer(errors, result.cost.force_evaluations, result.cost.steps)

    def integrated(name: str, setting: float, clock: Clock) -> Answer:
        integrator = at_setting(load("integrators", name), setting)
        reading = read_front(case, integrator, clock)
        errors = best.errors(reading.force, reading.time) | {"energy": reading.drift}
        return Answer(errors, integrator.evaluations, reading.steps)

    description = f"{case.description}, read at contact {case.contact}"
    quantities = ("peak force", "arrival time", "energy")
    problem = Problem("integrators", case.name, description, quantities, best.source, best.error)
    methods = [Method("simulate", simulated, "rtol", _TOLERANCES)]
    for entry in entries("integrators"):
        setting, values = ("step", _STEPS) if entry.takes == "step" else ("tolerance", _TOLERANCES)
        methods.append(Method(entry.name, partial(integrated, entry.name), setting, values))
    return problem, methods
