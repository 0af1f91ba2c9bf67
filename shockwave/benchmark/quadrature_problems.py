"""Quadratures: areas and impulses of pulses with known values, integrated by every registered quadrature."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from attrs import evolve, frozen

from shockwave.benchmark.timed_runs import Answer, Clock, Experiment, Limits, Method
from shockwave.benchmark.work_precision import Problem, greatest
from shockwave.errors import NumericalError
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.tabulated import Tabulated
from shockwave.profiles.triangular import Triangular
from shockwave.quadrature import Integral, Integrand
from shockwave.registry import entries, load
from shockwave.scenario.scenario import Scenario

_LADDER = tuple(10.0**-power for power in range(2, 15, 2))
_QUICK = (1e-3, 1e-6, 1e-9, 1e-12)
_TIGHTEST = 1e-15
_ROUNDING = 2e-16
# Times and forces of a record with many kinks.
_KINKED = (
    (0.0, 0.1, 0.25, 0.3, 0.55, 0.6, 0.8, 1.1, 1.15, 1.6, 1.9, 2.0),
    (0.0, 0.3, 0.2, 0.7, 0.65, 1.0, 0.6, 0.7, 0.35, 0.3, 0.1, 0.0),
)


@frozen(eq=False)
class Areas:
    """Integrals of known ``values``: integrands, and for each the ``points`` between which it is smooth.

    The impulse is the sum of all.
    """

    name: str
    description: str
    integrands: tuple[Integrand, ...]
    points: tuple[Sequence[float], ...]
    values: Sequence[float]
    reference: str = "closed form"
    reference_error: float = _ROUNDING

    def integrals(self, quadrature: str, tolerance: float) -> list[Integral]:
        """All by a registered quadrature."""
        method = load("quadratures", quadrature)()
        pairs = zip(self.integrands, self.points, strict=True)
        return [method.integrate(integrand, points, tolerance) for integrand, points in pairs]

    def answer(self, found: Sequence[Integral]) -> Answer:
        """The greatest error of the areas, the error of their sum, and the cost."""
        values = [float(integral.value) for integral in found]
        impulse = abs(sum(values) / sum(self.values) - 1)
        errors = {"areas": _difference(values, self.values), "impulse": impulse}
        return Answer(errors, sum(integral.evaluations for integral in found))


def _difference(found: Sequence[float], values: Sequence[float]) -> float:
    """The greatest relative difference."""
    return greatest(abs(one / value - 1) for one, value in zip(found, values, strict=True))


def areas_of(name: str, profile: ShockProfile, description: str) -> Areas:
    """Rise and decay of a profile; a closed form, which may be a plugin's, is checked by quadrature.

    Raises
    ------
    NumericalError
        When the areas are not finite.
    """
    rising = [point for point in profile.breakpoints if point <= 1]
    decaying = [point for point in profile.breakpoints if point >= 1]
    areas = Areas(name, description, (profile.rise, profile.decay), (rising, decaying), ())
    found = {
        method: [float(integral.value) for integral in areas.integrals(method, _TIGHTEST)]
        for method in ("gauss-legendre", "tanh-sinh")
    }
    closed = profile.closed_areas()
    if closed is None:
        values, source = found.pop("gauss-legendre"), f"gauss-legendre at a tolerance of {_TIGHTEST:g}"
    else:
        values, source = [float(area) for area in closed], "closed form of the profile"
    # At an infinite slope tanh-sinh is the more accurate, at a kink Gauss-Legendre.
    difference, nearest = min((_difference(other, values), method) for method, other in found.items())
    if not all(map(math.isfinite, (*values, difference))):
        raise NumericalError("the areas of the profile are not finite")
    source = f"{source}, cross-checked by {nearest}"
    return evolve(areas, values=values, reference=source, reference_error=max(difference, _ROUNDING))


def named_areas() -> Iterator[Areas]:
    """The named problems."""
    smooth = Exponential(rise_rate=2.0, decay_rate=3.0, duration_ratio=4.0)
    singular = PowerLaw(rise_exponent=0.1, decay_exponent=0.3, duration_ratio=3.0)
    steep = PowerLaw(rise_exponent=1e-3, decay_exponent=1.0, duration_ratio=3.0)
    kinked = Tabulated(times=_KINKED[0], forces=_KINKED[1])
    triangle = Triangular(duration_ratio=3.0)
    yield areas_of("smooth", smooth, "exponential, rates 2 and 3, n = 4")
    yield areas_of("kinked", kinked, "a record of 12 samples, its kinks given")
    description = "a triangle, n = 3, over its whole length: its kink is not given"
    yield Areas("kink not given", description, (triangle.force,), ((0.0, 3.0),), (1.5,))
    yield areas_of("singular ends", singular, "power law, eta 0.1 and 0.3, n = 3: infinite slope at both ends")
    yield areas_of("nearly a jump", steep, "power law, eta 0.001 and 1, n = 3: the rise is nearly a jump")


def named(_: Limits, quick: bool) -> Iterator[Experiment]:
    """The named problems and their methods."""
    return (_experiment(areas, quick) for areas in named_areas())


def of_scenario(scenario: Scenario, _: Limits, quick: bool) -> Experiment:
    """The areas of a scenario's profile and their methods."""
    profile = scenario.shock.profile
    return _experiment(areas_of(scenario.name, profile, type(profile).__name__), quick)


def _experiment(areas: Areas, quick: bool) -> Experiment:
    quantities = ("areas", "impulse")
    about = areas.name, areas.description, quantities, areas.reference, areas.reference_error
    return Problem("quadratures", *about), _methods(areas, quick)


def _methods(areas: Areas, quick: bool) -> Iterator[Method]:
    for entry in entries("quadratures"):

        def run(tolerance: float, _: Clock, name: str = entry.name) -> Answer:
            return areas.answer(areas.integrals(name, tolerance))

        yield Method(entry.name, run, "tolerance", _QUICK if quick else _LADDER)
