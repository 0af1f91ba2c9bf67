"""The quadratures: areas compared with closed forms, error bounds, bounded work."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from attrs import frozen

from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.quadrature import Integral, Integrand, Quadrature
from shockwave.profiles.quadrature.gauss_legendre import GaussLegendre
from shockwave.profiles.quadrature.quadpack import Quadpack
from shockwave.profiles.quadrature.tanh_sinh import TanhSinh
from shockwave.profiles.shock_profile import ShockProfile

# Accuracy of the areas in units of the interval, for integrands of at most 1.
TOLERANCE = 1e-12

ETAS = (1e-8, 1e-5, 1e-3, 0.1, 0.5, 1.0, 5.0, 50.0)
RATIOS = (1.0001, 2.0, 10.0, 1e3)
RATES = (1e-9, 1.0, 300.0)


@pytest.fixture(params=[GaussLegendre, TanhSinh, Quadpack], ids=lambda cls: cls.name)
def quadrature(request: pytest.FixtureRequest) -> Quadrature:
    made: Quadrature = request.param()
    return made


@frozen(eq=False)
class Case:
    """An integrand and its area over [lower, upper]."""

    name: str
    integrand: Integrand
    area: float
    lower: float = 0.0
    upper: float = 1.0


def cases_of(profile: ShockProfile) -> list[Case]:
    """Rise and decay of a profile, whose closed forms are tested with 200 digits."""
    (rise, decay), n = profile.closed_areas() or (math.nan, math.nan), profile.duration_ratio
    return [Case(f"rise of {profile!r}", profile.rise, rise), Case(f"{profile!r}", profile.decay, decay, 1.0, n)]


def jumps(*places: float) -> Case:
    """Jumps by 1."""
    return Case(f"jumps-at-{places}", lambda s: sum(1.0 * (s >= at) for at in places), len(places) - sum(places))


POWERS = [PowerLaw(rise_exponent=eta, decay_exponent=eta, duration_ratio=n) for n in RATIOS for eta in ETAS]
EXPONENTIALS = [Exponential(rise_rate=k, decay_rate=k, duration_ratio=n) for n in RATIOS for k in RATES]
# Layers at an end that are narrower than the distance of the first nodes of a simple rule.
LAYERS = [
    PowerLaw(rise_exponent=1e6, decay_exponent=1, duration_ratio=10),
    Exponential(rise_rate=1e6, decay_rate=1e6, duration_ratio=10),
]
SMOOTH = [case for profile in (*POWERS, *EXPONENTIALS, *LAYERS) for case in cases_of(profile)]
# An arbitrary point, and the gaps between the nodes and the ends or the middle of an interval.
JUMPS = [jumps(at) for at in (1e-3, 0.123456789, 0.5, 0.5 + 1e-9, 0.5 - 1e-4, 0.7501, 0.999)]
# One of the jumps is between a node and the end of an interval, and only another division of the intervals shows it.
JUMPS.append(jumps(0.5293121601967704, 0.7857857007138075))


@cache
def integrated(cls: type[Quadrature], case: Case) -> Integral:
    return cls().integrate(case.integrand, (case.lower, case.upper))


def wrong(quadrature: Quadrature, cases: list[Case], right: Callable[[Case, Integral], bool]) -> list[str]:
    """Names of the cases that violate a condition."""
    return [case.name for case in cases if not right(case, integrated(type(quadrature), case))]


def test_area_agrees_with_the_closed_form(quadrature: Quadrature) -> None:
    def right(case: Case, it: Integral) -> bool:
        return abs(it.value - case.area) <= TOLERANCE * (case.upper - case.lower)

    assert wrong(quadrature, SMOOTH, right) == []


def test_error_bounds_the_true_error(quadrature: Quadrature) -> None:
    assert wrong(quadrature, [*SMOOTH, *JUMPS], lambda case, it: abs(it.value - case.area) <= it.error) == []


def test_error_estimate_is_not_much_too_large(quadrature: Quadrature) -> None:
    def right(case: Case, result: Integral) -> bool:
        # Nodes next to n are rounded to multiples of eps n, which moves the area by as much where the integrand
        # falls by 1. The estimate may see it in several ways at once.
        spacing = float(np.finfo(float).eps) * case.upper
        return result.error <= TOLERANCE * (case.upper - case.lower) + 5 * spacing

    assert wrong(quadrature, SMOOTH, right) == []


@pytest.mark.parametrize(
    ("jump", "points"), [(0.3, (0.0, 0.3, 1.0)), (0.0, (0.0, 1.0))], ids=["at-a-point", "at-the-very-end"]
)
def test_jump_at_a_given_point_is_integrated_accurately(
    quadrature: Quadrature, jump: float, points: tuple[float, ...]
) -> None:
    result = quadrature.integrate(lambda s: np.where(s <= jump, 0.0, 1.0), points)
    assert abs(result.value - (1 - jump)) <= TOLERANCE


@pytest.mark.parametrize("points", [(0.5, 0.5), (1.0, 0.0), ()], ids=["empty", "reversed", "no-point"])
def test_empty_interval_gives_zero(quadrature: Quadrature, points: tuple[float, ...]) -> None:
    result = quadrature.integrate(np.ones_like, points)
    assert (result.value, result.error, result.evaluations) == (0.0, 0.0, 0)


@pytest.mark.parametrize("upper", [math.nextafter(1.0, 2.0), 1.0 + 1e-15], ids=["one-spacing", "few-spacings"])
def test_interval_of_a_few_floats_is_integrated(quadrature: Quadrature, upper: float) -> None:
    result = quadrature.integrate(lambda s: np.full_like(s, 0.75), (1.0, upper))
    assert abs(result.value - 0.75 * (upper - 1.0)) <= result.error
