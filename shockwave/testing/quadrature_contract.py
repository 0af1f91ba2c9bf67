"""Tests of quadratures against each clause of their contract."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import pytest
from attrs import define, field, frozen

from shockwave.base.numerics import FloatArray
from shockwave.profiles.quadrature import Integral, Integrand, Quadrature
from shockwave.testing.contract import Contract, check_registered

# Largest error for smooth integrands, in units of the interval.
_SMOOTH = 1e-12
# The same for integrands with unbounded derivatives at an end.
_SINGULAR = 1e-6
_TOLERANCES = (1e-14, 1e-8, 1e-4)
# Largest number of points of a quadrature.
_MAX_POINTS = 2_000_000


@frozen
class _Case:
    """An integrand, its integral over [lower, upper], and the permitted error."""

    text: str
    integrand: Integrand
    area: float
    lower: float = 0.0
    upper: float = 1.0
    error: float = _SMOOTH

    def __str__(self) -> str:
        return f"{self.text} from {self.lower:g} to {self.upper:g}"


_SMOOTH_CASES = (
    _Case("1 + s", lambda s: 1 + s, 1.5),
    _Case("-s**2", lambda s: -(s**2), -2 / 3, lower=-1.0),
    _Case("exp(-s)", lambda s: np.exp(-s), -math.expm1(-30.0), upper=30.0),
    _Case("cos(40 s)", lambda s: np.cos(40 * s), math.sin(40.0) / 40),
    _Case("s**50", lambda s: s**50, 1 / 51),
)
_SINGULAR_CASES = (
    _Case("s**0.001", lambda s: s**1e-3, 1 / 1.001, error=_SINGULAR),
    _Case("sqrt(s (1 - s))", lambda s: np.sqrt(s * (1 - s)), math.pi / 8, error=_SINGULAR),
    _Case("((3 - s)/2)**0.1", lambda s: ((3 - s) / 2) ** 0.1, 2 / 1.1, 1.0, 3.0, _SINGULAR),
    _Case("((1000 - s)/999)**0.5", lambda s: ((1000 - s) / 999) ** 0.5, 666.0, 1.0, 1000.0, _SINGULAR),
)
# Rougher than any profile; the error estimate must still be a bound.
_ROUGH_CASES = (
    _Case("s < 0.3", lambda s: np.where(s < 0.3, 1.0, 0.0), 0.3),
    _Case("s < 0.123456789", lambda s: np.where(s < 0.123456789, 1.0, 0.0), 0.123456789),
    _Case("abs(s - 0.7)", lambda s: np.abs(s - 0.7), 0.29),
    _Case("a sawtooth of 500 periods", lambda s: (500 * s) % 1.0, 0.5),
)
_each_case = pytest.mark.parametrize("case", [*_SMOOTH_CASES, *_SINGULAR_CASES], ids=str)


@define
class _Watched:
    """An integrand that counts its points and limits their number."""

    integrand: Integrand
    dimensions: set[int] = field(factory=set)
    count: int = 0

    def __call__(self, s: FloatArray) -> FloatArray:
        self.dimensions.add(np.ndim(s))
        self.count += np.size(s)
        assert self.count <= _MAX_POINTS, f"clause 5: more than {_MAX_POINTS} points are evaluated"
        return self.integrand(s)


class QuadratureContract(Contract):
    """Tests of quadratures against the contract of `Quadrature`; a subclass lists the quadratures.

    ::

        from shockwave.testing import QuadratureContract
        from my_rules.romberg import Romberg

        class TestRomberg(QuadratureContract):
            quadratures = [Romberg]

    Attributes
    ----------
    quadratures : list of type
        Classes, registered by an installed distribution.
    leave_out : dict of str
        Omitted clauses, with the reasons: ``{"clause 2": "for smooth integrands only"}``. They are shown as skipped.
    """

    quadratures: ClassVar[Sequence[type[Quadrature]]]

    _member = "quadrature"

    def test_clause_1_name_is_the_one_registered(self, quadrature: type[Quadrature]) -> None:
        check_registered("quadratures", quadrature)

    @_each_case
    def test_clause_2_smooth_pieces_with_singular_ends_are_integrated(
        self, quadrature: type[Quadrature], case: _Case
    ) -> None:
        found, _ = _integrate(quadrature(), case)
        error, allowed = abs(found.value - case.area), case.error * (case.upper - case.lower)
        assert error <= allowed, f"{case} is {found.value:.12g}, with an error of {error:.1e} (limit {allowed:.1e})"

    @_each_case
    def test_clause_3_the_integrand_is_called_with_arrays(self, quadrature: type[Quadrature], case: _Case) -> None:
        _, watched = _integrate(quadrature(), case)
        assert watched.dimensions == {1}, f"{case}: s must have one dimension (got {watched.dimensions})"

    @pytest.mark.parametrize("tolerance", _TOLERANCES)
    @pytest.mark.parametrize("case", [*_SMOOTH_CASES, *_SINGULAR_CASES, *_ROUGH_CASES], ids=str)
    def test_clause_4_the_estimate_bounds_the_error(
        self, quadrature: type[Quadrature], case: _Case, tolerance: float
    ) -> None:
        found, _ = _integrate(quadrature(), case, tolerance)
        # Rounding error of the exact value.
        error = abs(found.value - case.area) - 2 * math.ulp(case.area)
        assert error <= found.error < math.inf, f"{case}: the error is {error:.2e}, its estimate {found.error:.2e}"

    @pytest.mark.parametrize("case", [*_SMOOTH_CASES[:2], *_SINGULAR_CASES[:2], *_ROUGH_CASES], ids=str)
    def test_clause_5_work_is_bounded_and_no_state_is_kept(self, quadrature: type[Quadrature], case: _Case) -> None:
        rule = quadrature()
        found, watched = _integrate(rule, case, 0.0)
        message = f"{case}: evaluations is {found.evaluations}, but {watched.count} points were evaluated"
        assert found.evaluations == watched.count, message
        again, _ = _integrate(rule, case, 0.0)
        assert again == found, f"{case}: {found!r} at first, and {again!r} when repeated"


def _integrate(rule: Quadrature, case: _Case, tolerance: float = 1e-14) -> tuple[Integral, _Watched]:
    watched = _Watched(case.integrand)
    integral = rule.integrate(watched, (case.lower, case.upper), tolerance)
    assert isinstance(integral, Integral), f"{case}: must be an Integral (got {integral!r})"
    return integral, watched
