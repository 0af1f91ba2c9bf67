"""Quadratures: error of areas and impulse against evaluations and time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from attrs import frozen

from shockwave.benchmark.rows import Problem, Row, setting_text, worst
from shockwave.benchmark.timing import Clock, Limits, tried
from shockwave.errors import NumericalError
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.tabulated import Tabulated
from shockwave.profiles.triangular import Triangular
from shockwave.quadrature import Integral, Integrand
from shockwave.registry import entries, load
from shockwave.scenario.scenario import Scenario

__all__ = ["NAMED", "Areas", "of_scenario", "rows"]

_QUANTITIES = ("areas", "impulse")
_LADDER = tuple(10.0**-power for power in range(2, 15, 2))
_QUICK = (1e-3, 1e-6, 1e-9, 1e-12)
_TIGHTEST = 1e-15
_DIGITS = 2e-16
# Values as near as this are the same but for rounding.
_ROUNDING = 1e-14


@frozen(eq=False)
class Areas:
    """Integrals whose values are known: integrands, the points that are told to the quadrature, and values.

    The impulse is the sum of all.
    """

    name: str
    description: str
    integrands: tuple[Integrand, ...]
    points: tuple[tuple[float, ...], ...]
    values: tuple[float, ...]
    reference: str
    reference_error: float = _DIGITS

    @property
    def problem(self) -> Problem:
        """The problem in words."""
        return Problem(
            family="quadratures",
            name=self.name,
            description=self.description,
            quantities=_QUANTITIES,
            reference=self.reference,
            reference_error=self.reference_error,
        )

    def errors(self, found: Sequence[Integral]) -> dict[str, float | None]:
        """Relative errors: the worst of the areas, and that of their sum."""
        values = [float(integral.value) for integral in found]
        # Not by fsum, which raises where two infinite areas cancel.
        return {"areas": _apart(values, self.values), "impulse": abs(sum(values) / math.fsum(self.values) - 1)}


def _of_profile(name: str, description: str, profile: ShockProfile, values: tuple[float, float], source: str) -> Areas:
    return Areas(name, description, (profile.rise, profile.decay), _points(profile), values, source)


def _points(profile: ShockProfile) -> tuple[tuple[float, ...], tuple[float, ...]]:
    points = profile.breakpoints
    return tuple(p for p in points if p <= 1), tuple(p for p in points if p >= 1)


_KNOTS = (0.0, 0.1, 0.25, 0.3, 0.55, 0.6, 0.8, 1.1, 1.15, 1.6, 1.9, 2.0)
_HEIGHTS = (0.0, 0.3, 0.2, 0.7, 0.65, 1.0, 0.6, 0.7, 0.35, 0.3, 0.1, 0.0)


def _kinked() -> Areas:
    profile = Tabulated(times=_KNOTS, forces=_HEIGHTS)
    trapezoids = [
        (right - left) * (low + high) / 2
        for (left, right), (low, high) in zip(pairwise(_KNOTS), pairwise(_HEIGHTS), strict=True)
    ]
    top = _HEIGHTS.index(1.0)
    values = math.fsum(trapezoids[:top]) / _KNOTS[top], math.fsum(trapezoids[top:]) / _KNOTS[top]
    description = "a record of 12 samples, its kinks told"
    # A dozen roundings of the samples, as multiples of the rise time.
    return Areas(
        "kinked", description, (profile.rise, profile.decay), _points(profile), values, "sum of trapezoids", 1e-15
    )


def _untold() -> Areas:
    triangle = Triangular(duration_ratio=3.0)
    description = "a triangle, n = 3, over its whole length: its kink is not told"
    return Areas("kink untold", description, (triangle.force,), ((0.0, 3.0),), (1.5,), "closed form")


def _named() -> tuple[Areas, ...]:
    return (
        _of_profile(
            "smooth",
            "exponential, rates 2 and 3, n = 4",
            Exponential(rise_rate=2.0, decay_rate=3.0, duration_ratio=4.0),
            (0.6565176427496656518, 0.8428129105262321441),
            "closed form in 40 digits",
        ),
        _kinked(),
        _untold(),
        _of_profile(
            "singular ends",
            "power law, eta 0.1 and 0.3, n = 3: infinite slope at both ends",
            PowerLaw(rise_exponent=0.1, decay_exponent=0.3, duration_ratio=3.0),
            (1 / 1.1, 2 / 1.3),
            "closed form",
        ),
        _of_profile(
            "nearly a jump",
            "power law, eta 0.001 and 1, n = 3: the rise is all but a jump",
            PowerLaw(rise_exponent=1e-3, decay_exponent=1.0, duration_ratio=3.0),
            (1 / 1.001, 1.0),
            "closed form",
        ),
    )


#: The named problems.
NAMED = _named()


def of_scenario(scenario: Scenario) -> Areas:
    """Rise and decay of the profile of a scenario.

    Raises
    ------
    NumericalError
        When their areas are not finite.
    """
    profile = scenario.shock.profile
    description, points = type(profile).__name__, _points(profile)
    integrands = partial(_values, profile, "rise"), partial(_values, profile, "decay")
    closed = profile.closed_areas()
    values, source, apart = _integrated(integrands, points) if closed is None else _checked(closed, integrands, points)
    if not all(math.isfinite(number) for number in (*values, apart)):
        raise NumericalError("the areas of the profile are not finite")
    return Areas(scenario.name, description, integrands, points, values, source, max(apart, _DIGITS))


_Points = tuple[tuple[float, ...], tuple[float, ...]]


def _integrated(integrands: tuple[Integrand, Integrand], points: _Points) -> tuple[tuple[float, ...], str, float]:
    """Areas, where they are from, and how far a second quadrature is from them."""
    best, other = (_tightest(name, integrands, points) for name in ("gauss-legendre", "tanh-sinh"))
    source = f"gauss-legendre at a tolerance of {_TIGHTEST:g}, cross-checked by tanh-sinh"
    return best, source, _apart(other, best)


def _checked(
    closed: tuple[float, float], integrands: tuple[Integrand, Integrand], points: _Points
) -> tuple[tuple[float, ...], str, float]:
    """The closed form, which may be anybody's, where it is from, and how far a quadrature is from it.

    Where Gauss-Legendre is not near, as at an infinite slope, tanh-sinh may be.
    """
    name, apart = "gauss-legendre", _apart(_tightest("gauss-legendre", integrands, points), closed)
    if not apart <= _ROUNDING:
        second = _apart(_tightest("tanh-sinh", integrands, points), closed)
        if not apart <= second:
            name, apart = "tanh-sinh", second
    return tuple(map(float, closed)), f"closed form of the profile, cross-checked by {name}", apart


def _tightest(name: str, integrands: tuple[Integrand, Integrand], points: _Points) -> tuple[float, ...]:
    method = load("quadratures", name)()
    return tuple(float(method.integrate(f, p, _TIGHTEST).value) for f, p in zip(integrands, points, strict=True))


def _apart(found: Sequence[float], values: Sequence[float]) -> float:
    """The greatest relative difference."""
    return worst(*(abs(one / value - 1) for one, value in zip(found, values, strict=True)))


def _values(profile: ShockProfile, name: str, s: np.ndarray) -> np.ndarray:
    return np.asarray(getattr(profile, name)(s))


def rows(areas: Areas, limits: Limits, quick: bool) -> Iterator[Row]:
    """A row for every registered quadrature at every tolerance."""
    for entry in entries("quadratures"):

        def run(tolerance: float, _: Clock, name: str = entry.name) -> list[Integral]:
            quadrature = load("quadratures", name)()
            pairs = zip(areas.integrands, areas.points, strict=True)
            return [quadrature.integrate(integrand, points, tolerance) for integrand, points in pairs]

        for found in tried(_QUICK if quick else _LADDER, run, limits):
            told: dict[str, Any] = {}
            if found.result is not None:
                told = {"errors": areas.errors(found.result), "evaluations": sum(i.evaluations for i in found.result)}
            yield Row.of(
                areas.problem, entry.name, setting_text("tolerance", found.setting), found, found.setting, **told
            )
