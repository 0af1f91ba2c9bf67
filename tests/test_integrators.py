"""The built-in integrators: the contract, their coefficients, sizes and costs of steps, and accuracy."""

from __future__ import annotations

import json
import re
from fractions import Fraction
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from shockwave.errors import NumericalError
from shockwave.registry import entries, load
from shockwave.simulation import nystroem
from shockwave.simulation.dop853 import Dop853
from shockwave.simulation.fixed_step import Pefrl, Rk4, Verlet
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.nystroem import Nystroem, Rkn64, Rkn86, Rkn1210
from shockwave.simulation.one_step import OneStep
from shockwave.testing import IntegratorContract
from shockwave.testing.known_motions import Watched, coupled, off, path, taken

ENTRIES = {entry.name: entry for entry in entries("integrators") if entry.distribution == "granular-shockwave"}
METHODS = {name: load("integrators", name) for name in ENTRIES}
PAIRS = [Rkn64, Rkn86, Rkn1210]
FIXED = [Verlet, Pefrl, Rk4]
every = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
each_pair = pytest.mark.parametrize("method", PAIRS, ids=lambda method: method.name)
EXACT = json.loads(Path(nystroem.__file__).with_name("tableaux.json").read_text(encoding="utf-8"))


class TestBuiltIn(IntegratorContract):
    """Order, joined steps, counted evaluations, interpolation, errors: every clause of the contract."""

    integrators: ClassVar = list(METHODS.values())


@every
def test_summary_states_order_and_traits(method: type[Integrator]) -> None:
    summary = ENTRIES[method.name].summary
    order = re.search(r"\b(?:order )?(\d+)(?:\(|,)", summary)
    assert order is not None
    assert int(order[1]) == method.order
    assert ("symplectic" in summary, "fixed" in summary) == (method.symplectic, not method.adaptive)


@every
def test_no_stage_lies_outside_the_interval(method: type[Integrator]) -> None:
    watched = Watched(coupled)
    # 0.7 + (2.82 - 0.7) is a rounding error beyond 2.82
    for step in taken(method(size=3.0), watched, 2.82, begin=0.7):
        step.interpolate(step.end)
    assert (min(watched.times), max(watched.times)) == (0.7, 2.82)


@pytest.mark.parametrize("method", [*PAIRS, Dop853], ids=lambda method: method.name)
@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-11])
def test_error_follows_the_tolerance(method: type[Integrator], tolerance: float) -> None:
    last = taken(method(tolerance=tolerance))[-1]
    # the errors of some ten steps add up
    assert off(last) < 10 * tolerance


# ---------------------------------------------------------------- sizes of steps


@pytest.mark.parametrize("method", FIXED, ids=lambda method: method.name)
@pytest.mark.parametrize(("until", "count"), [(1.1, 11), (2.99, 30), (3.01, 31), (0.01, 1)])
def test_fixed_steps_are_equal_and_no_longer_than_the_size(method: type[OneStep], until: float, count: int) -> None:
    sizes = [step.end - step.begin for step in taken(method(size=0.1), until=until)]
    assert sizes == pytest.approx([until / count] * count, rel=1e-12)


@each_pair
def test_adaptive_steps_leave_no_sliver(method: type[OneStep]) -> None:
    for until in np.linspace(2.0, 3.0, 11):
        sizes = [step.end - step.begin for step in taken(method(), until=float(until))]
        # two halves at the worst, and what step-size control takes from the second
        assert sizes[-1] > 0.2 * sizes[-2]


@each_pair
def test_steps_of_a_chain_at_rest_grow_to_the_unit_of_time(method: type[OneStep]) -> None:
    steps = taken(method(), lambda _, x: np.zeros_like(x), 40.0)
    assert max(step.end - step.begin for step in steps) == pytest.approx(1.0, rel=1e-12)


@each_pair
def test_a_tolerance_that_rounding_denies_is_an_error(method: type[OneStep]) -> None:
    with pytest.raises(NumericalError, match="its error stays above the tolerance"):
        taken(method(tolerance=1e-40))


COST = {Rkn64: 5, Rkn86: 8, Rkn1210: 17, Verlet: 1, Pefrl: 5, Rk4: 4}


@pytest.mark.parametrize("method", COST, ids=lambda method: method.name)
def test_a_step_costs_what_its_method_states(method: type[OneStep]) -> None:
    integrator = method(tolerance=1.0)
    assert len(list(integrator.steps(coupled, 0.0, 0.04, *path(0.0), 0.04))) == 1
    # and one for the acceleration at the beginning
    assert integrator.evaluations == 1 + COST[method]


# ---------------------------------------------------------------- the methods


def fractions(method: type[Nystroem], name: str) -> list[Fraction]:
    """Weights or nodes as they were published."""
    return list(map(Fraction, EXACT[method.name][name]))


def moments(method: type[Nystroem], weights: str, count: int) -> list[Fraction]:
    """Sums of the weights times the first powers of the nodes."""
    pairs = list(zip(fractions(method, weights), fractions(method, "c"), strict=True))
    return [sum((weight * node**power for weight, node in pairs), Fraction(0)) for power in range(count)]


@each_pair
def test_weights_integrate_powers_exactly(method: type[Nystroem]) -> None:
    assert moments(method, "b_prime", method.order) == [Fraction(1, k + 1) for k in range(method.order)]


@each_pair
def test_error_weights_see_the_power_that_the_embedded_method_misses(method: type[Nystroem]) -> None:
    *nothing, missed = moments(method, "error_b_prime", method.error_order + 1)
    assert not any(nothing)
    assert missed != 0


@each_pair
def test_stages_are_consistent(method: type[Nystroem]) -> None:
    for node, row in zip(fractions(method, "c"), EXACT[method.name]["a"], strict=True):
        # the published fractions of order 12 are cut at some fifty digits
        assert abs(sum(map(Fraction, row), Fraction(0)) - node**2 / 2) < Fraction(1, 10**50)
