"""The benchmark: families of problems, the methods that are run on them, and the software and machine."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import product
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from attrs import evolve

from shockwave.base.numerics import FloatArray
from shockwave.base.progress import track
from shockwave.benchmark.chain_problems import CASES, ChainCase, case_of, reference
from shockwave.benchmark.work_precision import Answer, Experiment, Limits, Method, Problem, WorkPrecision, measure
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.quadrature import Integrand
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.profiles.tabulated import Tabulated
from shockwave.profiles.triangular import Triangular
from shockwave.registry.registry import entries, load, plugins
from shockwave.scenario.scenario import Scenario
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.simulate import simulate_scene
from shockwave.sweep.point_evaluation import software

FAMILIES = ("quadratures", "predictors", "integrators")
# Limits of a quick and of a full run, times in seconds.
_QUICK = Limits(run=0.5, repetitions=0.08, repeats=5, every=2)
_FULL = Limits(run=4.0, repetitions=0.4, repeats=15)
# Tolerances, and step sizes in characteristic times.
_TOLERANCES = tuple(10.0**-power for power in range(2, 13))
_STEPS = tuple(0.2 / 2**power for power in range(9))
# Relative rounding error of a number.
_ROUNDING = 2e-16


def run(
    scenarios: Sequence[Scenario] = (), families: Sequence[str] = (), quick: bool = False, longest: float | None = None
) -> WorkPrecision:
    """Run the families on the named problems, or on scenarios.

    Parameters
    ----------
    scenarios : sequence of Scenario
        Scenarios that replace the named problems.
    families : sequence of "quadratures", "predictors", "integrators"
        Default: all of them.
    quick : bool
        Use fewer problems, settings and repetitions; takes less than a minute.
    longest : float, optional
        Time limit of one run [s]. Runs that would exceed it are left out; their rows state this.
    """
    limits = _QUICK if quick else _FULL
    if longest is not None:
        limits = evolve(limits, run=longest, repetitions=min(limits.repetitions, longest))
    problems = []
    rows: list[Any] = []
    experiments: list[Callable[[], Experiment]] = []
    for family in sorted(families or FAMILIES, key=FAMILIES.index):
        experiments += [partial(_scenario_problem, family, each) for each in scenarios] or list_problems(family, quick)
    for experiment in track("bench", experiments):
        problem, methods = experiment()
        problems.append(problem)
        for method in methods:
            rows.extend(measure(problem, method, limits))
    return WorkPrecision(provenance=_provenance(quick, limits), problems=tuple(problems), rows=tuple(rows))


def list_problems(family: str, quick: bool) -> Iterator[Callable[[], Experiment]]:
    """The named problems of a family; each is set up, with its reference, when it is called."""
    if family == "quadratures":
        for text, profile in PROFILES.items():
            name, _, description = text.partition(": ")
            yield partial(quadratures, name, description, areas_of(profile))
        triangle = Triangular(duration_ratio=3)
        areas = ReferenceAreas([(triangle.force, (0.0, 3.0))], np.array([1.5]), "closed form", _ROUNDING)
        yield partial(quadratures, "kink not given", "triangle, n = 3, integrated across its kink", areas)
    elif family == "predictors":
        for name in ("short", "A", "B") if quick else ("short", "A", "B", "slow"):
            yield partial(predictors, CASES[name])
    else:
        for name in ("A", "wall") if quick else ("A", "B", "slow", "wall"):
            yield partial(integrators, CASES[name])


def _scenario_problem(family: str, scenario: Scenario) -> Experiment:
    with scenario.scene.locate_errors():
        scenario.scene.covered_chain("bench", laws=True)
    if family == "quadratures":
        profile = scenario.shock.profile
        return quadratures(scenario.name, type(profile).__name__, areas_of(profile))
    return (predictors if family == "predictors" else integrators)(case_of(scenario))


def _provenance(quick: bool, limits: Limits) -> dict[str, str]:
    provenance = software() | {
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "round": "quick" if quick else "full",
        "longest run": f"{limits.run:g} s",
        "clock": f"time.perf_counter, {time.get_clock_info('perf_counter').resolution:g} s",
    }
    others = ", ".join(f"{p.distribution} {p.version}" for p in plugins() if not p.disabled and not p.problem)
    return provenance | ({"plugins": others} if others else {})


# ---------------------------------------------------------------- quadratures: areas and impulse of pulses

# Tolerances of the quadratures, and that of the reference.
_AREA_TOLERANCES = tuple(10.0**-power for power in range(2, 15, 2))
_TIGHTEST_AREA = 1e-15
# A record with many kinks: times and forces, both in arbitrary units.
_TIMES = (0.0, 0.1, 0.25, 0.3, 0.55, 0.6, 0.8, 1.1, 1.15, 1.6, 1.9, 2.0)
_FORCES = (0.0, 0.3, 0.2, 0.7, 0.65, 1.0, 0.6, 0.7, 0.35, 0.3, 0.1, 0.0)
# Integrands, each with the points that separate its smooth pieces.
_Pieces: TypeAlias = Sequence[tuple[Integrand, Sequence[float]]]


class ReferenceAreas(NamedTuple):
    """Integrals, their reference values, and source and relative error of these; the impulse is the sum."""

    pieces: _Pieces
    values: FloatArray
    source: str
    error: float


#: Profiles of the named problems, by "name: description".
PROFILES = {
    "smooth: exponential, rates 2 and 3, n = 4": Exponential(rise_rate=2, decay_rate=3, duration_ratio=4),
    "kinked: record of 12 samples, integrated between its kinks": Tabulated(times=_TIMES, forces=_FORCES),
    "singular ends: power law, eta 0.1 and 0.3, n = 3, infinite slope at both ends": PowerLaw(
        rise_exponent=0.1, decay_exponent=0.3, duration_ratio=3
    ),
    "nearly a jump: power law, eta 0.001 and 1, n = 3, rise is nearly a jump": PowerLaw(
        rise_exponent=1e-3, decay_exponent=1, duration_ratio=3
    ),
}


def areas_of(profile: ShockProfile) -> ReferenceAreas:
    """Areas of the rise and the decay of a profile; closed forms, also of plugins, are checked by quadrature."""
    rising = [point for point in profile.breakpoints if point <= 1]
    decaying = [point for point in profile.breakpoints if point >= 1]
    pieces = ((profile.rise, rising), (profile.decay, decaying))
    gauss, _ = _integrate(pieces, "gauss-legendre", _TIGHTEST_AREA)
    tanh_sinh, _ = _integrate(pieces, "tanh-sinh", _TIGHTEST_AREA)
    closed = profile.closed_areas()
    if closed is None:
        error = max(_greatest_error(tanh_sinh, gauss), _ROUNDING)
        source = f"gauss-legendre at a tolerance of {_TIGHTEST_AREA:g}, checked by tanh-sinh"
        return ReferenceAreas(pieces, gauss, source, error)
    values = np.array(closed, dtype=float)
    # tanh-sinh is more accurate at an infinite slope, Gauss-Legendre at a kink.
    error = min(_greatest_error(gauss, values), _greatest_error(tanh_sinh, values))
    source = "closed form of the profile, checked by quadrature"
    return ReferenceAreas(pieces, values, source, max(error, _ROUNDING))


def _integrate(pieces: _Pieces, quadrature: str, tolerance: float) -> tuple[FloatArray, int]:
    """The integrals by a registered quadrature, and the number of evaluations."""
    method = load("quadratures", quadrature)()
    found = [method.integrate(integrand, points, tolerance) for integrand, points in pieces]
    values = np.array([float(integral.value) for integral in found])
    return values, int(sum(integral.evaluations for integral in found))


def _greatest_error(found: FloatArray, values: FloatArray) -> float:
    """Largest relative error; NaN if any error is NaN."""
    return float(np.max(np.abs(found / values - 1)))


def quadratures(name: str, description: str, areas: ReferenceAreas) -> Experiment:
    """Every registered quadrature, applied to these areas."""

    def run(quadrature: str, tolerance: float) -> Answer:
        found, evaluations = _integrate(areas.pieces, quadrature, tolerance)
        impulse = float(abs(found.sum() / areas.values.sum() - 1))
        return Answer({"areas": _greatest_error(found, areas.values), "impulse": impulse}, evaluations)

    problem = Problem("quadratures", name, description, ("areas", "impulse"), areas.source, areas.error)
    methods = entries("quadratures")
    return problem, [Method(each.name, partial(run, each.name), "tolerance", _AREA_TOLERANCES) for each in methods]


# ---------------------------------------------------------------- predictors: the peak force far along the chain


def predictors(case: ChainCase) -> Experiment:
    """Section 4 and simulation, by their errors in the peak force of the leading wave far along the chain."""
    best = simulate_scene(case.scene, SimulateOptions(rtol=1e-12, integrator="rkn1210", waves="primary"))
    other = simulate_scene(case.scene, SimulateOptions(rtol=1e-11, integrator="rkn86", waves="primary"))
    source = "simulation by rkn1210 at rtol 1e-12, checked by rkn86 at 1e-11"
    error = max(best.error_estimate, abs(other.peak_force / best.peak_force - 1))

    def predict(reading: dict[str, Any], _: None) -> Answer:
        outcome: Any = Predictor(model="section-4", **reading).predict_scene(case.scene)
        return Answer({"peak force": abs(outcome.peak_force / best.peak_force - 1)})

    def simulate(rtol: float) -> Answer:
        result = simulate_scene(case.scene, SimulateOptions(rtol=rtol, waves="primary"))
        difference = abs(result.peak_force / best.peak_force - 1)
        return Answer({"peak force": difference}, result.cost.force_evaluations, result.cost.steps)

    methods = []
    for alpha, coefficient in product(("constant", "literal"), ("exact", "paper")):
        run = partial(predict, {"alpha": alpha, "momentum_coefficient": coefficient})
        methods.append(Method(f"section-4, {alpha}", run, f"alpha {alpha}, {coefficient} A"))
    methods.append(Method("simulate", simulate, "rtol", _TOLERANCES[:8]))
    description = f"{case.description}: peak force of the leading wave far along the chain"
    return Problem("predictors", case.name, description, ("peak force",), source, error), methods


# ---------------------------------------------------------------- integrators: the front at one contact


def integrators(case: ChainCase) -> Experiment:
    """The function simulate, and every registered integrator, on the chain as far as the contact."""
    best, scales = reference(case), case.setup.scales

    def simulate(rtol: float) -> Answer:
        force, time, defect, cost = case.simulate(rtol)
        errors = best.errors(force / scales.force, time / scales.time) | {"energy": defect}
        return Answer(errors, cost.force_evaluations, cost.steps)

    def integrate(name: str, setting: float) -> Answer:
        motion = case.run(load("integrators", name), setting)
        energy = abs(motion.energy_balance) / (motion.work + motion.initial_energy)
        return Answer(best.errors(*case.front(motion)) | {"energy": energy}, motion.evaluations, motion.steps)

    description = f"{case.description}: front at {'the ' * (case.contact is None)}{case.place}"
    quantities = ("peak force", "arrival time", "energy")
    problem = Problem("integrators", case.name, description, quantities, best.source, best.error)
    methods = [Method("simulate", simulate, "rtol", _TOLERANCES)]
    for entry in entries("integrators"):
        setting, values = ("step", _STEPS) if "step" in entry.takes.split() else ("tolerance", _TOLERANCES)
        methods.append(Method(entry.name, partial(integrate, entry.name), setting, values))
    return problem, methods
