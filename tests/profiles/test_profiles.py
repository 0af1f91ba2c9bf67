"""Profiles: force, areas and running impulse; closed forms against 40 digits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from shockwave.profiles.exponential import Exponential
from shockwave.profiles.half_sine import HalfSine
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.profiles.steep_edges import find_edges
from shockwave.profiles.tabulated import Tabulated
from shockwave.profiles.triangular import Triangular
from support.profile_references import exact_areas, exact_integral, sine

QUADRATURES = ("gauss-legendre", "tanh-sinh", "quadpack")


EXACT_CASES: dict[str, ShockProfile] = {
    "triangle-1.1": Triangular(duration_ratio=1.1),
    "triangle-30": Triangular(duration_ratio=30),
    "power-1e-5-5": PowerLaw(rise_exponent=1e-5, decay_exponent=5, duration_ratio=2),
    "power-0.5-0.5": PowerLaw(rise_exponent=0.5, decay_exponent=0.5, duration_ratio=1.1),
    "power-5-1e-5": PowerLaw(rise_exponent=5, decay_exponent=1e-5, duration_ratio=30),
    "exponential-1e-9-1": Exponential(rise_rate=1e-9, decay_rate=1, duration_ratio=2),
    "exponential-1-1e-9": Exponential(rise_rate=1, decay_rate=1e-9, duration_ratio=30),
    "exponential-300-300": Exponential(rise_rate=300, decay_rate=300, duration_ratio=1.1),
    "exponential--300-2": Exponential(rise_rate=-300, decay_rate=2, duration_ratio=2),
    "exponential--1--300": Exponential(rise_rate=-1, decay_rate=-300, duration_ratio=30),
    "exponential-0.03--0.03": Exponential(rise_rate=0.03, decay_rate=-0.03, duration_ratio=2),
    # Either side of where a series takes over from the closed form.
    "exponential-1.99--2.01": Exponential(rise_rate=1.99, decay_rate=-2.01, duration_ratio=2),
    "exponential--1.99-2.01": Exponential(rise_rate=-1.99, decay_rate=2.01, duration_ratio=2),
}
SMOOTH = [
    Triangular(duration_ratio=3),
    PowerLaw(rise_exponent=0.5, decay_exponent=5, duration_ratio=10),
    Exponential(rise_rate=2, decay_rate=-1, duration_ratio=4),
    sine(),
    Tabulated([0.0, 1.0, 2.0, 5.0], [0.0, 1.0, 2.0, 0.0]),
]
ONE_OF_EACH = [pytest.param(profile, id=type(profile).__name__) for profile in SMOOTH]


# ---------------------------------------------------------------- force


STEP = PowerLaw(rise_exponent=0, decay_exponent=0, duration_ratio=3)
POWERS = PowerLaw(rise_exponent=2, decay_exponent=3, duration_ratio=3)
FORCES = {
    "triangle-rise": (Triangular(duration_ratio=3), 0.25, 0.25),
    "triangle-decay": (Triangular(duration_ratio=3), 1.5, 0.75),
    "power-rise": (POWERS, 0.5, 0.25),
    "power-decay": (POWERS, 2, 0.125),
    "step-rise": (STEP, 0.5, 1.0),
    "step-end": (STEP, 3.0, 1.0),
    "exponential-rise": (Exponential(rise_rate=2, decay_rate=1, duration_ratio=3), 0.5, 1 / (1 + math.exp(-1))),
    "exponential-decay": (Exponential(rise_rate=1, decay_rate=2, duration_ratio=3), 2, 1 / (1 + math.exp(1))),
    "exponential-slow-rise": (Exponential(rise_rate=-2, decay_rate=1, duration_ratio=3), 0.5, 1 / (1 + math.exp(1))),
    "exponential-late-decay": (Exponential(rise_rate=1, decay_rate=-2, duration_ratio=3), 2, 1 / (1 + math.exp(-1))),
}


@pytest.mark.parametrize(("profile", "s", "force"), FORCES.values(), ids=FORCES)
def test_force_is_that_of_the_formula(profile: ShockProfile, s: float, force: float) -> None:
    # A few roundings of the exponential.
    assert float(profile.force(s)) == pytest.approx(force, rel=1e-15, abs=0)


@pytest.mark.parametrize("s", [-math.inf, -1e-300, 3.0 + 1e-15, math.inf])
@pytest.mark.parametrize("profile", [STEP, sine()], ids=["step", "half-sine"])
def test_force_is_zero_outside_the_shock(profile: ShockProfile, s: float) -> None:
    assert float(profile.force(s)) == 0.0


@pytest.mark.parametrize(
    ("rate", "layer"),
    [(200.0, [1.02, 1.08, 1.36]), (-200.0, [2.64, 2.92, 2.98]), (99.0, []), (0.0, []), (1e10, [])],
)
def test_a_steep_force_has_a_layer_in_which_steps_and_quadratures_end(rate: float, layer: list[float]) -> None:
    # 2, 8 and 36 times 1/200 of a decay that lasts twice the rise; a thinner one is a discontinuity
    assert find_edges(1.0, 3.0, rate, 3.0) == pytest.approx(layer, rel=1e-12)


# ---------------------------------------------------------------- integrals


@pytest.mark.parametrize("profile", ONE_OF_EACH)
def test_the_impulse_is_zero_before_the_shock_and_constant_after_it(profile: ShockProfile) -> None:
    n = profile.duration_ratio
    assert profile.running_impulse([-5.0, 0.0]).tolist() == [0.0, 0.0]
    assert len(set(profile.running_impulse([n, n + 1e-9, 1e6]).tolist())) == 1


@pytest.mark.parametrize("method", ["force", "running_impulse"])
def test_exponential_without_rates_is_the_triangle(method: str) -> None:
    s = np.linspace(-0.5, 5.5, 61)
    exponential = Exponential(rise_rate=0, decay_rate=0, duration_ratio=5)
    triangle = Triangular(duration_ratio=5)
    # The two sum differently: a few roundings of numbers up to 10.
    np.testing.assert_allclose(getattr(exponential, method)(s), getattr(triangle, method)(s), atol=1e-14)


# ---------------------------------------------------------------- a profile of a third party


@pytest.mark.parametrize("quadrature", QUADRATURES)
def test_integrals_of_a_profile_without_closed_forms(quadrature: str) -> None:
    areas = sine().areas(quadrature)
    assert abs(areas.rise.value - 2 / math.pi) <= areas.rise.error <= 1e-12
    assert min(areas.rise.evaluations, areas.decay.evaluations) > 0
    assert {areas.rise.method, areas.decay.method} == {quadrature}
    s = np.array([0.0, 1e-6, 0.5, 1.0, 1.5, 2.0])
    impulse = 4 / math.pi * np.sin(math.pi * s / 4) ** 2
    np.testing.assert_allclose(sine().running_impulse(s, quadrature), impulse, rtol=1e-12)


# ---------------------------------------------------------------- against 40 digits

RISING = (1e-12, 1e-6, 1e-3, 0.5, 1.0)
#: Shares of the decay.
FADING = (1e-6, 0.3, 0.9, 1 - 1e-6, 1.0)


@pytest.mark.parametrize("profile", EXACT_CASES.values(), ids=EXACT_CASES)
def test_the_impulse_keeps_its_digits(profile: ShockProfile) -> None:
    impulse, n = profile.running_impulse, profile.duration_ratio
    for s in RISING:
        # Relative, however small: a rounding of s is multiplied by a rate of 300.
        assert float(impulse(s)) == pytest.approx(exact_integral(profile, 1, s), rel=1e-13, abs=0)
    for share in FADING:
        s, whole = 1 + share * (n - 1), float(impulse(n))
        # Of the whole, as sums over the whole are subtracted.
        assert float(impulse(s)) == pytest.approx(exact_integral(profile, 1, s), rel=1e-15, abs=1e-15 * whole)


@pytest.mark.parametrize("profile", EXACT_CASES.values(), ids=EXACT_CASES)
def test_the_force_of_one_time_is_that_of_an_array(profile: ShockProfile) -> None:
    s = [*np.linspace(0.01, 1, 9).tolist(), *np.linspace(1, profile.duration_ratio, 9)[1:].tolist()]
    # a rounding of s is multiplied by rates and exponents of some hundred
    np.testing.assert_allclose([profile.closed_at(each)[1] for each in s], profile.force(s), rtol=1e-12)  # type: ignore[index]


@pytest.mark.parametrize("profile", EXACT_CASES.values(), ids=EXACT_CASES)
def test_areas_are_within_their_errors(profile: ShockProfile) -> None:
    rise, decay = exact_areas(profile)
    areas = profile.areas()
    assert abs(areas.rise.value - rise) <= areas.rise.error
    assert abs(areas.decay.value - decay) <= areas.decay.error


@pytest.mark.parametrize("profile", [Triangular(duration_ratio=3), HalfSine()], ids=["triangular", "half-sine"])
def test_the_force_at_no_time_is_no_number(profile: ShockProfile) -> None:
    np.testing.assert_array_equal(profile.force([math.nan, -1.0, 1.0]), [math.nan, 0.0, 1.0])
