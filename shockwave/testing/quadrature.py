"""The contract of a quadrature, clause by clause."""

from __future__ import annotations

import inspect
import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from attrs import define, field, frozen

from shockwave.quadrature import FloatArray, Integral, Integrand, Quadrature
from shockwave.testing.contract import Contract, after
from shockwave.testing.faults import told

__all__ = ["QuadratureContract"]

# Digits to expect of smooth integrands, and of those with unbounded derivatives at an end; of the interval.
_SMOOTH, _SINGULAR = 1e-12, 1e-6
_TOLERANCES = (1e-14, 1e-8, 1e-4)
# More points than any fixed number of refinements needs.
_MOST_POINTS = 2_000_000


@frozen
class _Case:
    """An integrand with its area over [lower, upper], and how many digits of it are to be expected."""

    text: str
    integrand: Integrand
    area: float
    upper: float = 1.0
    lower: float = 0.0
    error: float = _SMOOTH

    @property
    def points(self) -> tuple[float, float]:
        return self.lower, self.upper


def _power(exponent: float) -> _Case:
    # Unbounded at 0 are the slope, the second derivative, or none.
    error = _SMOOTH if exponent >= 2 else _SINGULAR
    return _Case(f"s**{exponent:g}", lambda s: np.asarray(s**exponent), 1 / (1 + exponent), error=error)


def _fall(exponent: float, n: float) -> _Case:
    text = f"((n - s)/(n - 1))**{exponent:g}, n = {n:g}"
    area = (n - 1) / (1 + exponent)
    return _Case(text, lambda s: np.asarray(((n - s) / (n - 1)) ** exponent), area, n, 1.0, _SINGULAR)


_SMOOTH_ONES = (
    _Case("1 + s", lambda s: 1 + s, 1.5),
    _Case("-s**2", lambda s: -(s**2), -2 / 3, lower=-1.0),
    _Case("exp(-s)", lambda s: np.exp(-s), -math.expm1(-30.0), 30.0),
    _Case("sin(pi s)", lambda s: np.sin(np.pi * s), 2 / math.pi),
    _Case("cos(40 s)", lambda s: np.cos(40 * s), math.sin(40.0) / 40),
    _power(50.0),
)
_SINGULAR_ONES = (
    _power(1e-3),
    _power(0.5),
    _power(1.5),
    _Case("sqrt(s (1 - s))", lambda s: np.sqrt(s * (1 - s)), math.pi / 8, error=_SINGULAR),
    _fall(0.1, 3.0),
    _fall(0.5, 1e3),
)
# What no profile should be; an estimate must hold even so.
_ROUGH_ONES = (
    _Case("s < 0.3", lambda s: np.where(s < 0.3, 1.0, 0.0), 0.3),
    _Case("s < 0.123456789", lambda s: np.where(s < 0.123456789, 1.0, 0.0), 0.123456789),
    _Case("abs(s - 0.7)", lambda s: np.abs(s - 0.7), 0.29),
    # The area of a saw with 500 whole teeth.
    _Case("a saw, (500 s) % 1", lambda s: (500 * s) % 1.0, 0.5),
)


@define
class _Watched:
    """An integrand that keeps the points and shapes it was called with, and ends what does not end."""

    integrand: Integrand
    least: float = math.inf
    most: float = -math.inf
    count: int = 0
    dimensions: set[int] = field(factory=set)

    def __call__(self, s: FloatArray) -> FloatArray:
        self.dimensions.add(np.ndim(s))
        self.count += np.size(s)
        if np.size(s):
            self.least, self.most = min(self.least, float(np.min(s))), max(self.most, float(np.max(s)))
        if self.count > _MOST_POINTS:
            raise _EndlessError
        return self.integrand(s)


class _EndlessError(Exception):
    """More points were asked for than there can be need of."""


class QuadratureContract(Contract):
    """Tests of quadratures against the contract of `Quadrature`; a subclass lists them.

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
        Clauses that are left out, each with the reason: ``{"clause 2": "for smooth integrands only"}``. They are
        shown as skipped.
    """

    quadratures: ClassVar[Sequence[type[Quadrature]]]

    _list = "quadratures"
    _member = "quadrature"
    _example = "quadratures = [MyRule]"
    _signed: ClassVar[dict[str, type]] = {"": Quadrature}

    def _problem(self, member: object) -> str:
        if not (isinstance(member, type) and issubclass(member, Quadrature)):
            return "a class, a subclass of Quadrature"
        missing = ", ".join(sorted(member.__abstractmethods__)) if inspect.isabstract(member) else ""
        return f"a class that writes {missing}" if missing else ""

    def _shown(self, member: Any) -> str:
        return str(member.__name__)

    # ---------------------------------------------------------------- the clauses

    @after()
    def test_clause_1_name_is_the_one_registered(self, quadrature: type[Quadrature]) -> None:
        self._check_name(quadrature)
        self._check_registered("quadratures", quadrature)

    @after()
    def test_clause_2_smooth_pieces_with_singular_ends_are_integrated(self, quadrature: type[Quadrature]) -> None:
        for case in (*_SMOOTH_ONES, *_SINGULAR_ONES):
            found = self._integrated("clause 2", quadrature, case)
            off, allowed = abs(found.value - case.area), case.error * (case.upper - case.lower)
            if not off <= allowed:
                what = f"{_told(case)} is {found.value:.12g}, off by {off:.1e}; {allowed:.1e} is allowed"
                mend = "refine towards the ends, where derivatives may be unbounded, and check the weights"
                self._broken("clause 2", quadrature, what, mend)

    @after("clause_2")
    def test_clause_3_the_integrand_is_called_inside_with_arrays(self, quadrature: type[Quadrature]) -> None:
        for case in (*_SMOOTH_ONES, *_SINGULAR_ONES):
            watched = _Watched(case.integrand)
            with np.errstate(all="ignore"):  # outside a power may be NaN
                self._integrated("clause 3", quadrature, case, watched)
            if watched.dimensions - {1}:
                what = f"{_told(case)}: it is called with an s of {max(watched.dimensions - {1})} dimensions"
                self._broken("clause 3", quadrature, what, "call it with one-dimensional arrays")
            if not case.lower <= watched.least <= watched.most <= case.upper:
                what = f"{_told(case)}: it is called at s = {watched.least!r} or {watched.most!r}"
                mend = "keep nodes within [lower, upper], whatever the rounding (numpy.clip)"
                self._broken("clause 3", quadrature, what, mend)

    @after("clause_2")
    def test_clause_4_the_estimate_bounds_the_error(self, quadrature: type[Quadrature]) -> None:
        for tolerance in _TOLERANCES:
            for case in (*_SMOOTH_ONES, *_SINGULAR_ONES, *_ROUGH_ONES):
                found = self._integrated("clause 4", quadrature, case, tolerance=tolerance)
                # The area itself is a float.
                off = abs(found.value - case.area) - 2 * math.ulp(case.area)
                if not off <= found.error < math.inf:
                    what = (
                        f"{_told(case)}, with tolerance {tolerance:g}: off by {off:.2e}, the estimate is"
                        f" {found.error:.2e}"
                    )
                    mend = "compare two rules, take the greater difference, and add what rounding does"
                    self._broken("clause 4", quadrature, what, mend)

    @after("clause_2", "clause_4")
    def test_clause_5_work_is_bounded_and_no_state_is_kept(self, quadrature: type[Quadrature]) -> None:
        rule, results = quadrature(), []
        for case in (*_SMOOTH_ONES[:2], *_SINGULAR_ONES[:2], *_ROUGH_ONES):
            watched = _Watched(case.integrand)
            found = self._integrated("clause 5", rule, case, watched, tolerance=0.0)
            results.append((case, found))
            if found.evaluations != watched.count:
                what = f"{_told(case)}: evaluations is {found.evaluations}, {watched.count} points were taken"
                self._broken("clause 5", quadrature, what, "return the number of all points in the Integral")
        for case, before in reversed(results):
            for which, other in (("the same object", rule), ("a new one", quadrature())):
                again = other.integrate(case.integrand, case.points, 0.0)
                if again != before:
                    what = f"{_told(case)}: first {before!r}, then {again!r} by {which}"
                    self._broken("clause 5", quadrature, what, "keep nothing in self between calls")

    # ---------------------------------------------------------------- for the clauses

    def _integrated(
        self,
        label: str,
        rule: type[Quadrature] | Quadrature,
        case: _Case,
        watched: _Watched | None = None,
        tolerance: float = 1e-14,
    ) -> Integral:
        cls = rule if isinstance(rule, type) else type(rule)
        made = rule() if isinstance(rule, type) else rule
        try:
            found = made.integrate(watched or _Watched(case.integrand), case.points, tolerance)
        except _EndlessError:
            # Whichever clause was looked at: the fifth is the one that this breaks.
            what = f"{_told(case)}, with tolerance {tolerance:g}: more than {_MOST_POINTS} points are taken"
            self._broken("clause 5", cls, what, "end after a fixed number of refinements, and tell what was reached")
        except Exception as error:
            mend = "see to that line; the integrand returns an array of the shape of s"
            self._broken(label, cls, f"{_told(case)}: {told(error)} is raised", mend)
        if not isinstance(found, Integral):
            self._broken(
                label, cls, f"{_told(case)} is {found!r}", "return an Integral with value, error and evaluations"
            )
        return found


def _told(case: _Case) -> str:
    return f"the integral of {case.text} from {case.lower:g} to {case.upper:g}"
