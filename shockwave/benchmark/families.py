"""The families of the bench: their problems with references, and the methods that are run on them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from itertools import product
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from shockwave.benchmark import chain_problems
from shockwave.benchmark.chain_problems import Case, at_setting, read_front
from shockwave.benchmark.timed_runs import Answer, Clock, Experiment, Method
from shockwave.benchmark.work_precision import Order, Problem, Row, observed_order
from shockwave.errors import NumericalError, PluginError
from shockwave.measurement.simulate import scaled, simulate
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.tabulated import Tabulated
from shockwave.profiles.triangular import Triangular
from shockwave.quadrature import FloatArray, Integrand
from shockwave.registry import entries, load
from shockwave.scenario.scenario import Scenario
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.nystroem import Rkn86, Rkn1210

_TOLERANCES = tuple(10.0**-power for power in range(2, 13))
_STEPS = tuple(0.2 / 2**power for power in range(9))
_ROUNDING = 2e-16

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


def profiles() -> dict[str, ShockProfile]:
    """Profiles by description, which begins with the name of the problem."""
    return {
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
    """Rise and decay of a profile; a closed form, which may be a plugin's, is checked by quadrature.

    Raises
    ------
    NumericalError
        When the areas are not finite.
    """
    rising = [point for point in profile.breakpoints if point <= 1]
    decaying = [point for point in profile.breakpoints if point >= 1]
    pieces = ((profile.rise, rising), (profile.decay, decaying))
    found = {name: _integrated(pieces, name, _TIGHTEST_AREA)[0] for name in ("gauss-legendre", "tanh-sinh")}
    closed = profile.closed_areas()
    if closed is None:
        values, source = found.pop("gauss-legendre"), f"gauss-legendre at a tolerance of {_TIGHTEST_AREA:g}"
    else:
        values, source = np.array(closed, dtype=float), "closed form of the profile"
    # At an infinite slope tanh-sinh is the more accurate, at a kink Gauss-Legendre.
    difference, nearest = min((_greatest(other, values), name) for name, other in found.items())
    if not np.isfinite([*values, difference]).all():
        raise NumericalError("the areas of the profile are not finite")
    return Areas(pieces, values, f"{source}, cross-checked by {nearest}", max(difference, _ROUNDING))


def _integrated(pieces: _Pieces, quadrature: str, tolerance: float) -> tuple[FloatArray, int]:
    """The integrals by a registered quadrature, and its evaluations."""
    method = load("quadratures", quadrature)()
    found = [method.integrate(integrand, points, tolerance) for integrand, points in pieces]
    values = np.array([float(integral.value) for integral in found])
    return values, int(sum(integral.evaluations for integral in found))


def _greatest(found: FloatArray, values: FloatArray) -> float:
    """The greatest relative error; NaN if any is."""
    return float(np.max(np.abs(found / values - 1)))


def _kink_not_given() -> Experiment:
    triangle = Triangular(duration_ratio=3)
    areas = Areas([(triangle.force, (0.0, 3.0))], np.array([1.5]), "closed form", _ROUNDING)
    return quadratures("kink not given", "a triangle, n = 3, over its whole length: its kink is not given", areas)


def quadratures(name: str, description: str, areas: Areas) -> Experiment:
    """Every registered quadrature on these areas."""

    def run(quadrature: str, tolerance: float, _: Clock) -> Answer:
        found, evaluations = _integrated(areas.pieces, quadrature, tolerance)
        impulse = abs(found.sum() / areas.values.sum() - 1)
        return Answer({"areas": _greatest(found, areas.values), "impulse": float(impulse)}, evaluations)

    problem = Problem("quadratures", name, description, ("areas", "impulse"), areas.source, areas.error)
    names = [entry.name for entry in entries("quadratures")]
    return problem, [Method(each, partial(run, each), "tolerance", _AREA_TOLERANCES) for each in names]


# ---------------------------------------------------------------- predictors: the peak force far along the chain

# Integrators and tolerances of references.
_REFERENCES = (("rkn1210", 1e-12), ("rkn86", 1e-11))


def predictors(case: Case) -> Experiment:
    """Formulae and simulation, on one scale of error of the primary's peak force."""
    best, other = (
        simulate(case.shock, case.chain, rtol=rtol, integrator=name, waves="primary") for name, rtol in _REFERENCES
    )
    source = f"simulation at rtol {best.rtol:g} by {best.integrator}"
    source = f"{source}, cross-checked by {other.integrator} at {other.rtol:g}"
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
    best = chain_problems.reference(case)
    _, scales = scaled(case.shock, case.chain)

    def simulated(rtol: float, _: Clock) -> Answer:
        result = simulate(case.shock, case.chain, rtol=rtol, waves="primary", contacts=(case.contact,))
        passage = result.passage(case.contact)
        errors = best.errors(passage.peak_force / scales.force, passage.arrival_time / scales.time)
        errors["energy"] = result.energy_defect
        return Answer(errors, result.cost.force_evaluations, result.cost.steps)

    def integrated(integrator: Integrator, clock: Clock) -> Answer:
        reading = read_front(case, integrator, clock)
        errors = best.errors(reading.force, reading.time) | {"energy": reading.drift}
        return Answer(errors, integrator.evaluations, reading.steps)

    description = f"{case.description}, read at contact {case.contact}"
    quantities = ("peak force", "arrival time", "energy")
    problem = Problem("integrators", case.name, description, quantities, best.source, best.error)
    simulation = Method("simulate", simulated, "rtol", _TOLERANCES)
    return problem, [simulation, *_registered(integrated, _STEPS, _TOLERANCES)]


def _registered(
    answer: Callable[[Integrator, Clock], Answer], steps: tuple[float, ...], tolerances: tuple[float, ...] = ()
) -> Iterator[Method]:
    """Every registered integrator; one that cannot be loaded is a method that says so."""
    for entry in entries("integrators"):
        try:
            cls: type[Integrator] = load("integrators", entry.name)
        except PluginError as error:
            yield Method.broken(entry.name, error)
            continue

        def run(setting: float, clock: Clock, cls: type[Integrator] = cls) -> Answer:
            return answer(at_setting(cls, setting), clock)

        setting, values = ("tolerance", tolerances) if cls.adaptive else ("step", steps)
        yield Method(entry.name, run, setting, values)


# ---------------------------------------------------------------- orders, on a chain whose contacts never open

SMOOTH = "closed contacts"
_GRANULES = 8
_UNTIL = 6.0  # characteristic times
# Each three quarters of the one before: steps enough in the convergent range of a method of any order.
_SMOOTH_STEPS = tuple(_UNTIL / count for count in (8, 11, 15, 20, 27, 36, 48, 64, 85, 113, 151, 201, 268))
_TIGHTEST_STATE = 1e-14


def smooth() -> Experiment:
    """Granules pressed together between walls, and the registered methods of fixed step."""

    def integrated(integrator: Integrator, clock: Clock) -> Answer:
        state = _final_state(integrator, clock)
        return Answer({"state": _distance(state, _smooth_reference()[0])}, integrator.evaluations)

    description = f"{_GRANULES} granules pressed together between walls, let go: the state after {_UNTIL:g} T0"
    source = f"rkn1210 at a step tolerance of {_TIGHTEST_STATE:g}, cross-checked by rkn86"
    problem = Problem("integrators", SMOOTH, description, ("state",), source, _smooth_reference()[1])
    return problem, _registered(integrated, _SMOOTH_STEPS)


def _final_state(method: Integrator, clock: Clock) -> FloatArray:
    """Positions and velocities at the end."""
    places = np.arange(1, _GRANULES + 1)
    x, v = 0.1 * np.sin(0.9 * places), 0.2 * np.cos(1.7 * places)
    for step in method.steps(_acceleration, 0.0, _UNTIL, x, v, None):
        clock.check()
        x, v = step.x, step.v
    return np.concatenate((x, v))


def _acceleration(_: float, x: FloatArray) -> FloatArray:
    """Eq. (1) between two walls that press the granules together by the unit of overlap."""
    force = (1.0 - np.diff(x, prepend=0.0, append=0.0)) ** 1.5
    return np.asarray(force[:-1] - force[1:])


@cache
def _smooth_reference() -> tuple[FloatArray, float]:
    best, other = (_final_state(method(tolerance=_TIGHTEST_STATE), Clock()) for method in (Rkn1210, Rkn86))
    return best, _distance(other, best)


def _distance(state: FloatArray, best: FloatArray) -> float:
    return float(np.linalg.norm(state - best) / np.linalg.norm(best))


def orders(rows: Sequence[Row]) -> tuple[Order, ...]:
    """The order of each method of fixed step, from its rows of the smooth problem."""
    own = [row for row in rows if row.case == SMOOTH and row.value is not None]
    found = []
    for name in dict.fromkeys(row.method for row in own):
        observed = observed_order([row for row in own if row.method == name])
        found.append(Order(name, load("integrators", name).order, observed))
    return tuple(found)


# ---------------------------------------------------------------- problems

FAMILIES = ("quadratures", "predictors", "integrators")


def named(family: str, quick: bool) -> Iterator[Experiment]:
    """The named problems of a family."""
    if family == "quadratures":
        for text, profile in profiles().items():
            name, _, description = text.partition(": ")
            yield quadratures(name, description, areas_of(profile))
        yield _kink_not_given()
    elif family == "predictors":
        for name in ("short", "A", "B") if quick else ("short", "A", "B", "slow"):
            yield predictors(chain_problems.named(name))
    else:
        yield smooth()
        for name in ("A",) if quick else ("A", "B", "slow"):
            yield integrators(chain_problems.named(name))


def of_scenario(family: str, scenario: Scenario) -> Experiment:
    """The problem of a family that a scenario makes.

    Raises
    ------
    ShockwaveError
        When there is no reference.
    """
    if family == "quadratures":
        profile = scenario.shock.profile
        return quadratures(scenario.name, type(profile).__name__, areas_of(profile))
    case = chain_problems.case_of(scenario)
    return predictors(case) if family == "predictors" else integrators(case)
