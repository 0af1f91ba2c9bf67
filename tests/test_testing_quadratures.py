"""The test kit for plugins finds broken quadratures, each by the clause that it breaks alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import pytest

from shockwave.quadrature import Integral
from shockwave.quadrature.gauss_legendre import GaussLegendre
from shockwave.testing import QuadratureContract
from test_testing_broken import _nothing_known, broken_clauses, check, outcomes  # noqa: F401
from test_testing_methods import other, raising
from test_testing_methods import registered as _registered

registered = _registered


def rule(change: Callable[..., Any], **parts: Any) -> type[Any]:
    """Gauss-Legendre, of which what it returns is changed."""

    def piece(self: Any, integrand: Any, lower: float, upper: float, tolerance: float) -> Integral:
        found = GaussLegendre._piece(self, integrand, lower, upper, tolerance)
        return change(self, found, integrand, lower, upper)

    return type("Broken", (GaussLegendre,), {"_piece": piece, **parts})


def outside(_: Any, found: Integral, integrand: Any, lower: float, upper: float) -> Integral:
    with np.errstate(invalid="ignore"):
        integrand(np.array([lower - 1e-9]))
    return attrs.evolve(found, evaluations=found.evaluations + 1)


def columns(_: Any, found: Integral, integrand: Any, lower: float, upper: float) -> Integral:
    integrand(np.full((1, 1), (lower + upper) / 2))
    return attrs.evolve(found, evaluations=found.evaluations + 1)


def endless(_: Any, found: Integral, integrand: Any, lower: float, upper: float) -> Integral:
    while found.error > 1e-6:
        integrand(np.linspace(lower, upper, 100_001)[1:-1])
    return found


def remembering(self: Any, found: Integral, *_: Any) -> Integral:
    self.sum = getattr(self, "sum", 0.0) + 1e-16
    return attrs.evolve(found, error=found.error + self.sum)


QUADRATURES: dict[str, tuple[type[Any], str, str]] = {
    "no-name": (rule(lambda _, found, *__: found, name=7), "1", "name is 7"),
    "rough": (
        rule(lambda _, found, *__: attrs.evolve(found, value=found.value + 1e-9, error=found.error + 1e-8)),
        "2",
        "the integral of 1 + s from 0 to 1 is 1.500000001, off by 1.0e-09",
    ),
    "outside": (rule(outside), "3", "it is called at s = -1e-09 or"),
    "columns": (rule(columns), "3", "it is called with an s of 2 dimensions"),
    "sure": (rule(lambda _, found, *__: attrs.evolve(found, error=found.error / 1e3)), "4", "the estimate is"),
    "miscounted": (
        rule(lambda _, found, *__: attrs.evolve(found, evaluations=1)),
        "5",
        "the integral of 1 + s from 0 to 1: evaluations is 1,",
    ),
    "remembering": (rule(remembering), "5", "by the same object"),
}


def test_a_quadrature_that_keeps_its_contract_breaks_no_clause() -> None:
    assert broken_clauses(QuadratureContract, GaussLegendre) == {}


@pytest.mark.parametrize(("method", "clause", "message"), QUADRATURES.values(), ids=QUADRATURES)
def test_a_broken_quadrature_is_found_by_its_clause_alone(
    method: type[Any], clause: str, message: str, registered: Any
) -> None:
    registered(method)
    check(QuadratureContract, method, f"does not hold for {method.__name__} ", clause, message)


def test_work_without_end_is_found_once(registered: Any) -> None:
    method = rule(endless)
    registered(method)
    failed, skipped = outcomes(QuadratureContract, method)
    assert list(failed) == ["test_clause_4_the_estimate_bounds_the_error"]
    assert "clause 5 of the contract of Quadrature does not hold" in failed.popitem()[1]
    assert list(skipped) == ["test_clause_5_work_is_bounded_and_no_state_is_kept"]


@pytest.mark.parametrize(
    ("piece", "message"),
    [
        (lambda *_: math.nan, "is nan to mend: return an Integral"),
        (raising, "ZeroDivisionError('division by zero') (in test_testing_methods.py, line"),
    ],
    ids=["number", "raising"],
)
def test_a_quadrature_that_returns_no_integral_breaks_one_clause(piece: Any, message: str, registered: Any) -> None:
    method = other(GaussLegendre, integrate=piece)
    registered(method)
    check(QuadratureContract, method, "does not hold for Broken ", "2", message)
