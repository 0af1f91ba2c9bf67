"""Every integrator: the order that it declares, and the contract that it signs."""

from __future__ import annotations

import re
import subprocess
import sys
from fractions import Fraction
from typing import ClassVar

import numpy as np
import pytest
from attrs import define

from shockwave.errors import NumericalError
from shockwave.hooks import Entry
from shockwave.registry import entries, load
from shockwave.simulation.integrator import Acceleration, Integrator, Step
from shockwave.simulation.nystroem import Nystroem, Rkn64, Rkn86, Rkn1210
from shockwave.simulation.one_step import Attempt, OneStep
from shockwave.simulation.pefrl import Pefrl
from shockwave.simulation.rk4 import Rk4
from shockwave.simulation.scipy_solver import ScipySolver
from shockwave.simulation.tableaux import RKN64, RKN86, RKN1210, Fractions
from shockwave.simulation.verlet import Verlet


@define
class Midpoint(OneStep):
    """What a plugin may bring: the midpoint rule, two evaluations a step."""

    name: ClassVar[str] = "midpoint"
    order: ClassVar[int] = 2
    adaptive: ClassVar[bool] = False
    symplectic: ClassVar[bool] = False

    def attempt(self, acceleration, time, size, x, v, a):  # type: ignore[no-untyped-def]
        middle = acceleration(time + size / 2, x + size / 2 * v)
        x, v = x + size * v + size**2 / 2 * middle, v + size * middle
        return Attempt(x, v, acceleration(time + size, x), 0.0)


BUILT_IN = [entry for entry in entries("integrators") if entry.distribution == "granular-shockwave"]
METHODS = [*(load("integrators", entry.name) for entry in BUILT_IN), Midpoint]
ONE_STEP = [method for method in METHODS if issubclass(method, OneStep)]
PAIRS = [method for method in ONE_STEP if method.adaptive]
FIXED = [method for method in ONE_STEP if not method.adaptive]
SOLVERS = [method for method in METHODS if issubclass(method, ScipySolver)]


def name_of(method: type[Integrator]) -> str:
    return method.name


every = pytest.mark.parametrize("method", METHODS, ids=name_of)

GRANULES = 5
PHASES = np.arange(GRANULES) * 0.7


def path(time: float) -> tuple[np.ndarray, np.ndarray]:
    """A solution chosen beforehand, and its velocity."""
    angle = time + PHASES.reshape(-1, *[1] * np.ndim(time))
    return np.cos(angle) + 0.3 * np.sin(2 * angle), 0.6 * np.cos(2 * angle) - np.sin(angle)


def between_neighbours(x: np.ndarray) -> np.ndarray:
    """A smooth force between neighbours, with the momentum kept."""
    force = np.sin(x[:-1] - x[1:])
    nothing = np.zeros_like(x[:1])
    return np.concatenate((nothing, force)) - np.concatenate((force, nothing))


def coupled(time: float, x: np.ndarray) -> np.ndarray:
    """A chain driven so that it takes the path."""
    angle = time + PHASES.reshape(-1, *[1] * (x.ndim - 1))
    return between_neighbours(x) - between_neighbours(path(time)[0]) - np.cos(angle) - 1.2 * np.sin(2 * angle)


def hertz(_: float, x: np.ndarray) -> np.ndarray:
    """Eq. (1) without a force."""
    force = np.maximum(x[:-1] - x[1:], 0.0) ** 1.5
    return np.append(0.0, force) - np.append(force, 0.0)


def steps(method: Integrator, until: float = 3.0, acceleration: Acceleration = coupled) -> list[Step]:
    return list(method.steps(acceleration, 0.0, until, *path(0.0), None))


def off(step: Step) -> float:
    return float(np.max(np.abs(np.subtract((step.x, step.v), path(step.end)))))


#: When the runs of a batch begin: their mean error is not the accident of one.
BEGINS = np.linspace(0.0, 6.0, 25)
SPAN = 8.0


def error_of(method: OneStep, count: int) -> float:
    """Error after so many equal attempts, root mean square over a batch."""
    (x, v), a, size = path(BEGINS), coupled(BEGINS, path(BEGINS)[0]), SPAN / count
    for index in range(count):
        x, v, a, _ = method.attempt(coupled, BEGINS + index * size, size, x, v, a)
    return float(np.sqrt(np.mean(np.subtract((x, v), path(BEGINS + SPAN)) ** 2)))


# --- order -----------------------------------------------------------------------------------------------------------

# Steps short enough for the leading term of the error and long enough for it to stand above rounding.
COUNTS = {2: 256, 4: 128, 6: 64, 8: 24, 12: 4}


@pytest.mark.parametrize("method", ONE_STEP, ids=name_of)
def test_halved_steps_show_the_declared_order(method: type[OneStep]) -> None:
    count = COUNTS[method.order]
    slope = np.log2(error_of(method(), count) / error_of(method(), 2 * count))
    # Order 12 sinks into rounding before the next term of its error is gone.
    assert slope == pytest.approx(method.order, abs=0.5 if method.order == 12 else 0.1)


@pytest.mark.parametrize("method", SOLVERS, ids=name_of)
def test_steps_taken_show_the_declared_order(method: type[ScipySolver]) -> None:
    loose, tight = (steps(method(tolerance=tolerance), 20.0) for tolerance in (1e-6, 1e-9))
    slope = np.log(off(loose[-1]) / off(tight[-1])) / np.log(len(tight) / len(loose))
    # the steps are of different lengths, chosen by an estimate whose order is not the error's
    assert slope == pytest.approx(method.order, abs=0.5)


def batch_attempt(method: OneStep, size: float) -> Attempt:
    x, v = path(BEGINS)
    return method.attempt(coupled, BEGINS, size, x, v, coupled(BEGINS, x))


@pytest.mark.parametrize("method", PAIRS, ids=name_of)
def test_error_estimates_show_the_order_of_the_embedded_method(method: type[OneStep]) -> None:
    size = SPAN / COUNTS[method.order]
    long, short = (np.mean(batch_attempt(method(), h).error) for h in (size, size / 2))
    # what the next order adds at these steps
    assert np.log2(long / short) == pytest.approx(method.error_order + 1, abs=0.1)


@pytest.mark.parametrize("method", PAIRS, ids=name_of)
def test_error_estimates_exceed_the_error(method: type[OneStep]) -> None:
    size = SPAN / COUNTS[method.order]
    *state, _, error = batch_attempt(method(), size)
    assert np.all(np.max(np.abs(np.subtract(state, path(BEGINS + size))), axis=(0, 1)) < error)


@pytest.mark.parametrize("entry", BUILT_IN, ids=lambda entry: entry.name)
def test_summary_tells_order_and_trait(entry: Entry) -> None:
    method = load("integrators", entry.name)
    order = re.search(r"\b(?:order )?(\d+)(?:\(|,)", entry.summary)
    assert order is not None
    assert (entry.name, int(order[1])) == (method.name, method.order)
    assert all(trait in entry.summary for trait in method.trait().split(", "))
    assert ("symplectic" in entry.summary, "fixed" in entry.summary) == (method.symplectic, not method.adaptive)


# --- the contract ----------------------------------------------------------------------------------------------------


@every
def test_steps_join_and_end_exactly_on_the_end(method: type[Integrator]) -> None:
    # a length that is no multiple of any step
    taken = list(method().steps(coupled, 0.1, 2.0 + 1 / 3, *path(0.1), None))
    ends = [step.end for step in taken]
    assert [step.begin for step in taken] == [0.1, *ends[:-1]]
    assert ends[-1] == 2.0 + 1 / 3


@every
def test_no_stage_lies_outside_the_interval(method: type[Integrator]) -> None:
    seen = []

    def watched(time: float, x: np.ndarray) -> np.ndarray:
        seen.append(time)
        return coupled(time, x)

    # 0.7 + (2.82 - 0.7) is a rounding error beyond 2.82
    for step in method(size=3.0).steps(watched, 0.7, 2.82, *path(0.7), None):
        step.interpolate(step.end)
    assert (min(seen), max(seen)) == (0.7, 2.82)


@every
def test_evaluations_are_counted_exactly(method: type[Integrator]) -> None:
    calls = 0

    def watched(time: float, x: np.ndarray) -> np.ndarray:
        nonlocal calls
        calls += 1
        return coupled(time, x)

    integrator = method()
    for step in steps(integrator, 1.0, watched):
        step.interpolate((step.begin + step.end) / 2)
    assert integrator.evaluations == calls > 0


@every
def test_arrays_given_and_yielded_stay_as_they_were(method: type[Integrator]) -> None:
    x, v = path(0.0)
    kept = []
    for step in method().steps(coupled, 0.0, 1.0, x, v, None):
        step.interpolate((step.begin + step.end) / 2)
        kept.append((step, step.x.copy(), step.v.copy(), step.a.copy()))
    assert np.array_equal((x, v), path(0.0))
    assert all(np.array_equal((step.x, step.v, step.a), state) for step, *state in kept)


@every
def test_steps_tell_the_acceleration_at_their_end(method: type[Integrator]) -> None:
    for step in steps(method(), 1.0):
        # the same function of the same numbers, up to the rounding of the time
        assert step.a == pytest.approx(coupled(step.end, step.x), abs=1e-14)


@every
def test_interpolation_meets_both_ends(method: type[Integrator]) -> None:
    before = path(0.0)
    for step in steps(method()):
        # rounding
        assert np.allclose(step.interpolate(step.begin), before, rtol=0, atol=1e-13)
        assert np.allclose(step.interpolate(step.end), (step.x, step.v), rtol=0, atol=1e-13)
        before = step.x, step.v


@every
def test_interpolation_is_as_good_as_the_steps(method: type[Integrator]) -> None:
    taken = steps(method(tolerance=1e-7, size=0.02))
    times = [step.begin + share * (step.end - step.begin) for step in taken for share in (0.2, 0.5, 0.8)]
    worst = max(
        np.max(np.abs(np.subtract(step.interpolate(time), path(time))))
        for step, time in zip(np.repeat(taken, 3), times, strict=True)
    )
    # a dense output of lower order may be some ten times worse than the steps
    assert worst < 10 * max(1e-7, *map(off, taken))


@pytest.mark.parametrize("method", [method for method in METHODS if method.adaptive], ids=name_of)
@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-11])
def test_error_follows_the_tolerance(method: type[Integrator], tolerance: float) -> None:
    # the errors of some ten steps add up
    assert off(steps(method(tolerance=tolerance))[-1]) < 10 * tolerance


@every
@pytest.mark.parametrize("since", [0.0, 1.0])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_an_error(method: type[Integrator], since: float, value: float) -> None:
    def broken(time: float, x: np.ndarray) -> np.ndarray:
        return coupled(time, x) if time < since else np.full_like(x, value)

    reached = []
    with pytest.raises(NumericalError, match=rf"{method.name} cannot step beyond t = [\d.]+ T0"):
        reached.extend(step.end for step in method().steps(broken, 0.0, 3.0, *path(0.0), None))
    assert all(end <= since for end in reached)


@every
def test_an_integrator_left_halfway_starts_again_with_other_arrays(method: type[Integrator]) -> None:
    used = method()
    x, v = np.ones(12), np.ones(12)
    left = next(used.steps(hertz, 0.0, 3.0, x, v, None))
    x[:] = v[:] = 0
    again, fresh = steps(used), steps(method())
    assert [[step.end, *step.x] for step in again] == [[step.end, *step.x] for step in fresh]
    assert np.allclose(left.interpolate(left.end), (left.x, left.v), rtol=0, atol=1e-13)


@every
def test_momentum_is_kept_to_rounding(method: type[Integrator]) -> None:
    v = np.zeros(12)
    v[0] = 1.0
    for step in method(tolerance=1e-6).steps(hertz, 0.0, 8.0, np.zeros(12), v, None):
        assert np.sum(step.v) == pytest.approx(1.0, abs=1e-13)


# --- sizes of steps --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", FIXED, ids=name_of)
@pytest.mark.parametrize(("until", "count"), [(1.1, 11), (2.99, 30), (3.01, 31), (0.01, 1)])
def test_fixed_steps_are_equal_and_no_longer_than_the_size(method: type[OneStep], until: float, count: int) -> None:
    sizes = [step.end - step.begin for step in steps(method(size=0.1), until)]
    assert sizes == pytest.approx([until / count] * count, rel=1e-12)


@pytest.mark.parametrize("method", PAIRS, ids=name_of)
def test_adaptive_steps_leave_no_sliver(method: type[OneStep]) -> None:
    for until in np.linspace(2.0, 3.0, 11):
        sizes = [step.end - step.begin for step in steps(method(), float(until))]
        # two halves at the worst, and what step-size control takes from the second
        assert sizes[-1] > 0.2 * sizes[-2]


@pytest.mark.parametrize("method", PAIRS, ids=name_of)
def test_steps_of_a_chain_at_rest_grow_to_the_unit_of_time(method: type[OneStep]) -> None:
    taken = steps(method(), 40.0, lambda _, x: np.zeros_like(x))
    assert max(step.end - step.begin for step in taken) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("method", PAIRS, ids=name_of)
def test_a_first_size_is_taken(method: type[OneStep]) -> None:
    first = next(method(tolerance=1.0).steps(coupled, 0.0, 3.0, *path(0.0), 0.25))
    assert first.end == 0.25


@pytest.mark.parametrize("method", PAIRS, ids=name_of)
def test_a_tolerance_that_rounding_denies_is_an_error(method: type[OneStep]) -> None:
    with pytest.raises(NumericalError, match="its error stays above the tolerance"):
        steps(method(tolerance=1e-40))


COST = {Rkn64: 5, Rkn86: 8, Rkn1210: 17, Verlet: 1, Pefrl: 5, Rk4: 4, Midpoint: 2}


@pytest.mark.parametrize("method", ONE_STEP, ids=name_of)
def test_a_step_costs_what_its_method_says(method: type[OneStep]) -> None:
    integrator = method(tolerance=1.0)
    assert len(list(integrator.steps(coupled, 0.0, 0.04, *path(0.0), 0.04))) == 1
    # and one for the acceleration at the beginning
    assert integrator.evaluations == 1 + COST[method]


# --- the methods -----------------------------------------------------------------------------------------------------


def drift(method: Integrator) -> float:
    """Change of a pendulum's mean energy from the first hundred units of time to the last of a thousand."""
    states = list(method.steps(lambda _, x: -np.sin(x), 0.0, 1000.0, np.array([2.0]), np.zeros(1), None))
    energies = np.array([step.v[0] ** 2 / 2 - np.cos(step.x[0]) for step in states])
    tenth = len(states) // 10
    return abs(float(np.mean(energies[-tenth:]) - np.mean(energies[:tenth])))


@pytest.mark.parametrize("method", [method for method in METHODS if method.symplectic], ids=name_of)
def test_energy_does_not_drift_in_symplectic_methods(method: type[Integrator]) -> None:
    # what the swing within a period leaves in the mean over periods that are not complete
    assert drift(method(size=0.2)) < 1e-5


def test_energy_drifts_in_others() -> None:
    assert drift(Rk4(size=0.2)) > 1e-3


@pytest.mark.parametrize("method", ONE_STEP, ids=name_of)
def test_a_batch_is_its_chains_side_by_side(method: type[OneStep]) -> None:
    times, sizes = np.array([0.0, 0.3, 1.1]), np.array([0.1, 0.25, 0.0])
    x, v = path(times)
    batch = method().attempt(coupled, times, sizes, x, v, coupled(times, x))
    for lane, (time, size) in enumerate(zip(times, sizes, strict=True)):
        x, v = path(time)
        single = method().attempt(coupled, float(time), float(size), x, v, coupled(time, x))
        # sums are taken in another order
        assert np.allclose([row[:, lane] for row in batch[:3]], single[:3], rtol=0, atol=1e-14)
        assert np.broadcast_to(batch.error, 3)[lane] == pytest.approx(single.error, rel=1e-6, abs=1e-15)


def fractions(text: str) -> list[Fraction]:
    return list(map(Fraction, text.split()))


def moment(weights: str, nodes: str, power: int) -> Fraction:
    return sum(w * c**power for w, c in zip(fractions(weights), fractions(nodes), strict=True)) + Fraction(0)


tableaux = pytest.mark.parametrize(
    ("method", "exact"), [(Rkn64, RKN64), (Rkn86, RKN86), (Rkn1210, RKN1210)], ids=["rkn64", "rkn86", "rkn1210"]
)


@tableaux
def test_weights_integrate_powers_exactly(method: type[Nystroem], exact: Fractions) -> None:
    for k in range(method.order):
        assert moment(exact.b_prime, exact.c, k) == Fraction(1, k + 1)
    for k in range(method.order - 1):
        assert moment(exact.b, exact.c, k) == Fraction(1, (k + 1) * (k + 2))


@tableaux
def test_error_weights_see_the_power_that_the_embedded_method_misses(method: type[Nystroem], exact: Fractions) -> None:
    velocity = [moment(exact.error_b_prime, exact.c, k) != 0 for k in range(method.error_order + 1)]
    position = [moment(exact.error_b, exact.c, k) != 0 for k in range(method.error_order)]
    assert velocity == [False] * method.error_order + [True]
    assert position == [False] * (method.error_order - 1) + [True]


@tableaux
def test_stages_are_consistent(method: type[Nystroem], exact: Fractions) -> None:
    for node, row in zip(fractions(exact.c), exact.a, strict=True):
        # the published fractions of order 12 are cut at some fifty digits
        assert abs(sum(fractions(row), Fraction(0)) - node**2 / 2) < Fraction(1, 10**50)


def test_a_nystroem_method_loads_no_scipy() -> None:
    program = "from shockwave.registry import load; load('integrators', 'rkn86'); import sys; print(*sys.modules)"
    modules = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert {name for name in modules.split() if name.split(".")[0] == "scipy"} == set()
