"""The quadratures: areas compared with closed forms, error bounds, bounded work."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from shockwave.base.numerics import FloatArray
from shockwave.profiles.quadrature import Integral, Integrand, Quadrature
from shockwave.profiles.quadrature.gauss_legendre import GaussLegendre
from shockwave.profiles.quadrature.quadpack import Quadpack
from shockwave.profiles.quadrature.tanh_sinh import TanhSinh

# Accuracy of the areas in units of the interval, for integrands of at most 1.
TOLERANCE = 1e-12

ETAS = (1e-8, 1e-5, 1e-3, 0.1, 0.5, 1.0, 5.0, 50.0)
RATIOS = (1.0001, 2.0, 10.0, 1e3)
RATES = (1e-9, 1.0, 300.0)


@pytest.fixture(params=[GaussLegendre, TanhSinh, Quadpack], ids=lambda cls: cls.name)
def quadrature(request: pytest.FixtureRequest) -> Quadrature:
    made: Quadrature = request.param()
    return made


class Case:
    """An integrand and its area over [lower, upper]."""

    def __init__(self, name: str, integrand: Integrand, lower: float, upper: float, area: float) -> None:
        self.name, self.integrand, self.area = name, integrand, area
        self.points = (lower, upper)
        self.width = upper - lower


def _power_rise(eta: float) -> Case:
    return Case(f"s^{eta:g}", lambda s: s**eta, 0.0, 1.0, 1 / (1 + eta))


def _power_decay(eta: float, n: float) -> Case:
    return Case(f"((n-s)/(n-1))^{eta:g},n={n:g}", lambda s: ((n - s) / (n - 1)) ** eta, 1.0, n, (n - 1) / (1 + eta))


def _exponential_rise(k: float) -> Case:
    # 1/(1 - e^-k) - 1/k cancels for small k; the next term of its series is k^3/720.
    area = 0.5 + k / 12 if k < 1e-6 else -1 / math.expm1(-k) - 1 / k
    return Case(f"rise,k={k:g}", lambda s: np.expm1(-k * s) / math.expm1(-k), 0.0, 1.0, area)


def _exponential_decay(k: float, n: float) -> Case:
    area = 0.5 - k / 12 if k < 1e-6 else 1 / k + math.exp(-k) / math.expm1(-k)

    def integrand(s: FloatArray) -> FloatArray:
        # (e^(-k u) - e^-k)/(1 - e^-k), u = (s - 1)/(n - 1), without the difference: for k = 1e-9 it would
        # leave 7 digits of the integrand itself.
        past, left = (s - 1) / (n - 1), (n - s) / (n - 1)
        return np.asarray(np.exp(-k * past) * np.expm1(-k * left) / math.expm1(-k))

    return Case(f"decay,k={k:g},n={n:g}", integrand, 1.0, n, (n - 1) * area)


def _jump(at: float) -> Case:
    return Case(f"jump-at-{at!r}", lambda s: np.where(s < at, 0.0, 1.0), 0.0, 1.0, 1 - at)


def _two_jumps(first: float, last: float) -> Case:
    """Jumps from 0 to 1 and to 2."""
    return Case(f"jumps-at-{first!r}-{last!r}", lambda s: 1.0 * (s >= first) + (s >= last), 0.0, 1.0, 2 - first - last)


SMOOTH = [
    *(_power_rise(eta) for eta in ETAS),
    *(_power_decay(eta, n) for n in RATIOS for eta in ETAS),
    *(_exponential_rise(k) for k in RATES),
    *(_exponential_decay(k, n) for n in RATIOS for k in RATES),
    Case("sin(pi*s)", lambda s: np.sin(np.pi * s), 0.0, 1.0, 2 / math.pi),
    # Layers at an end that are narrower than the distance of the first nodes of a simple rule.
    _power_rise(1e6),
    _exponential_rise(1e6),
    _exponential_decay(1e6, 10.0),
]
# An arbitrary point, and the gaps between the nodes and the ends or the middle of an interval.
JUMPS = [_jump(at) for at in (1e-3, 0.123456789, 0.3, 0.5, 0.5 + 1e-9, 0.5 - 1e-4, 0.7501, 0.999)]
# One of the jumps is between a node and the end of an interval, and only another division of the intervals shows it.
JUMPS.append(_two_jumps(0.5293121601967704, 0.7857857007138075))
EVERY = [*SMOOTH, *JUMPS]


@cache
def integrated(cls: type[Quadrature], case: Case) -> Integral:
    return cls().integrate(case.integrand, case.points)


def wrong(quadrature: Quadrature, cases: list[Case], right: Callable[[Case, Integral], bool]) -> list[str]:
    """Names of the cases that violate a condition."""
    return [case.name for case in cases if not right(case, integrated(type(quadrature), case))]


def test_area_agrees_with_the_closed_form(quadrature: Quadrature) -> None:
    assert wrong(quadrature, SMOOTH, lambda case, it: abs(it.value - case.area) <= TOLERANCE * case.width) == []


def test_error_bounds_the_true_error(quadrature: Quadrature) -> None:
    assert wrong(quadrature, EVERY, lambda case, it: abs(it.value - case.area) <= it.error) == []


def test_error_estimate_is_not_much_too_large(quadrature: Quadrature) -> None:
    def right(case: Case, result: Integral) -> bool:
        # Nodes next to n are rounded to multiples of eps n, which moves the area by as much where the integrand
        # falls by 1. The estimate may see it in several ways at once.
        spacing = float(np.finfo(float).eps) * case.points[1]
        return result.error <= TOLERANCE * case.width + 5 * spacing

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
