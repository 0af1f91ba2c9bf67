"""The built-in integrators: contract, coefficients, step sizes, cost and accuracy."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from shockwave.base.errors import NumericalError
from shockwave.engine import nystroem_integrators as nystroem
from shockwave.engine.nystroem_integrators import Nystroem, Pefrl, Rk4, Rkn64, Rkn86, Rkn1210, Verlet
from shockwave.engine.one_step import OneStep
from shockwave.registry.registry import entries, load
from shockwave.testing import IntegratorContract
from shockwave.testing.known_motions import all_steps, smooth_force, smooth_motion

BUILT_IN = [entry.name for entry in entries("integrators") if entry.distribution == "granular-shockwave"]
PAIRS = [Rkn64, Rkn86, Rkn1210]
each_pair = pytest.mark.parametrize("method", PAIRS, ids=lambda method: method.name)
EXACT = json.loads(Path(nystroem.__file__).with_name("tableaux.json").read_text(encoding="utf-8"))


class TestBuiltIn(IntegratorContract):
    """All clauses of the contract."""

    integrators: ClassVar = [load("integrators", name) for name in BUILT_IN]


# ---------------------------------------------------------------- step sizes


def test_adaptive_steps_avoid_a_short_last_step_and_grow_to_the_unit_of_time() -> None:
    for until in np.linspace(2.0, 3.0, 11):
        sizes = [step.end - step.begin for step in all_steps(Rkn86(), until=float(until))]
        # at worst two halves, and a reduction of the second by the step-size control
        assert sizes[-1] > 0.2 * sizes[-2]
    at_rest = all_steps(Rkn86(), lambda _, x: np.zeros_like(x), 40.0)
    assert max(step.end - step.begin for step in at_rest) == pytest.approx(1.0, rel=1e-12)


@each_pair
def test_tolerance_below_rounding_is_an_error(method: type[OneStep]) -> None:
    with pytest.raises(NumericalError, match="the error remains above the tolerance"):
        all_steps(method(tolerance=1e-40))


@pytest.mark.parametrize(("method", "cost"), [(Rkn64, 5), (Rkn86, 8), (Rkn1210, 17), (Verlet, 1), (Pefrl, 5), (Rk4, 4)])
def test_cost_of_a_step_is_as_documented(method: type[OneStep], cost: int) -> None:
    integrator = method(tolerance=1.0)
    assert len(list(integrator.steps(smooth_force, 0.0, 0.04, *smooth_motion(0.0), 0.04))) == 1
    # and one evaluation for the acceleration at the beginning
    assert integrator.evaluations == 1 + cost


# ---------------------------------------------------------------- coefficients


def moments(method: type[Nystroem], weights: str, count: int) -> list[Fraction]:
    """Sums of the published weights times the first powers of the nodes."""
    exact = EXACT[method.name]
    pairs = [(Fraction(weight), Fraction(node)) for weight, node in zip(exact[weights], exact["c"], strict=True)]
    return [sum((weight * node**power for weight, node in pairs), Fraction(0)) for power in range(count)]


@each_pair
def test_weights_integrate_powers_up_to_the_orders_of_both_methods(method: type[Nystroem]) -> None:
    assert moments(method, "b_prime", method.order) == [Fraction(1, k + 1) for k in range(method.order)]
    *nothing, missed = moments(method, "error_b_prime", method.error_order + 1)
    assert not any(nothing)
    assert missed != 0


@each_pair
def test_stages_are_consistent(method: type[Nystroem]) -> None:
    for node, row in zip(EXACT[method.name]["c"], EXACT[method.name]["a"], strict=True):
        # the published fractions of order 12 have about fifty digits
        assert abs(sum(map(Fraction, row), Fraction(0)) - Fraction(node) ** 2 / 2) < Fraction(1, 10**50)
