"""The test kit for plugins finds broken quadratures by the clause that they break."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import pytest

from shockwave.quadrature import Integral
from shockwave.quadrature.gauss_legendre import GaussLegendre
from shockwave.testing import QuadratureContract
from shockwave.testing import quadrature as kit


def rule(change: Callable[..., Any], **parts: Any) -> type[Any]:
    """Gauss-Legendre, of which what it returns is changed."""

    def piece(self: Any, integrand: Any, lower: float, upper: float, tolerance: float) -> Integral:
        found = GaussLegendre._piece(self, integrand, lower, upper, tolerance)
        return change(self, found, integrand, lower, upper)

    return type("Broken", (GaussLegendre,), {"_piece": piece, **parts})


def off(**factors: float) -> type[Any]:
    """Gauss-Legendre with parts of its result multiplied."""
    return rule(lambda _, found, *__: attrs.evolve(found, **{k: getattr(found, k) * f for k, f in factors.items()}))


def outside(_: Any, found: Integral, integrand: Any, lower: float, upper: float) -> Integral:
    with np.errstate(invalid="ignore"):
        integrand(np.array([lower - 1e-9]))
    return attrs.evolve(found, evaluations=found.evaluations + 1)


def endless(_: Any, found: Integral, integrand: Any, lower: float, upper: float) -> Integral:
    while found.error > 1e-6:
        integrand(np.linspace(lower, upper, 100_001)[1:-1])
    return found


def remembering(self: Any, found: Integral, *_: Any) -> Integral:
    self.sum = getattr(self, "sum", 0.0) + 1e-16
    return attrs.evolve(found, error=found.error + self.sum)


QUADRATURES: dict[str, tuple[type[Any], int, str]] = {
    "outside": (rule(outside), 3, "it is called at s = "),
    "sure": (off(error=1e-3), 4, "the estimate is"),
    "miscounted": (off(evaluations=2), 5, "points were taken"),
    "remembering": (rule(remembering), 5, "first Integral(value="),
    "endless": (rule(endless), 4, "clause 5: more than 2000000 points are taken"),
}


def failures(method: type[Any], clause: int) -> list[str]:
    """Messages of the tests of a clause that fail for the method."""
    found = []
    (name,) = (name for name in dir(QuadratureContract) if name.startswith(f"test_clause_{clause}_"))
    cases = (*kit._SMOOTH_CASES, *kit._SINGULAR_CASES, *(kit._ROUGH_CASES if clause > 3 else ()))
    for case in cases:
        try:
            getattr(QuadratureContract(), name)(method, case, *([1e-4] if clause == 4 else []))
        except (pytest.fail.Exception, Exception) as failure:
            found.append(str(failure))
    return found


@pytest.mark.parametrize(("method", "clause", "message"), QUADRATURES.values(), ids=QUADRATURES)
def test_a_broken_quadrature_fails_the_test_of_its_clause(method: type[Any], clause: int, message: str) -> None:
    assert message in " ".join(failures(method, clause))


def test_a_quadrature_that_is_not_registered_is_found() -> None:
    with pytest.raises(AssertionError, match="'gauss-legendre' is registered for another class"):
        QuadratureContract().test_clause_1_name_is_the_one_registered(off())
