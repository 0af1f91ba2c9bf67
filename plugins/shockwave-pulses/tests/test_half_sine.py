"""The half-sine: closed forms, and where it stands to the conditions (3)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shockwave import Chain, Material, Predictor, Shock

from shockwave_pulses.half_sine import HalfSine

PROFILE = HalfSine()
ENDS = np.array([0.0, 1e-6, 1e-3, 0.1, 0.5, 0.636, 0.637, 0.9, 1.0, 1.1, 1.5, 1.9, 1.999, 2.0])


def test_the_force_is_half_a_sine() -> None:
    expected = [0.5, math.sqrt(0.5), 1.0, math.sqrt(0.5), 0.5]
    np.testing.assert_allclose(PROFILE.force([1 / 3, 0.5, 1.0, 1.5, 5 / 3]), expected, rtol=4e-16)


def test_areas_are_closed_forms() -> None:
    areas = PROFILE.areas()
    assert [areas.rise.value, areas.decay.value] == [2 / math.pi, 2 / math.pi]
    assert areas.rise.method == areas.decay.method == "closed form"
    assert areas.rise.evaluations == areas.decay.evaluations == 0


@pytest.mark.parametrize("quadrature", ["gauss-legendre", "tanh-sinh"])
def test_running_impulse_agrees_with_quadrature(quadrature: str) -> None:
    expected = PROFILE.running_impulse(ENDS, quadrature)
    np.testing.assert_allclose(PROFILE.running_impulse(ENDS), expected, rtol=1e-12, atol=0)


@pytest.mark.parametrize("quadrature", ["gauss-legendre", "tanh-sinh"])
def test_double_integral_agrees_with_quadrature(quadrature: str) -> None:
    expected = PROFILE.double_integral(ENDS, quadrature)
    np.testing.assert_allclose(PROFILE.double_integral(ENDS), expected, rtol=1e-12, atol=0)


def test_integrals_keep_their_digits_near_the_beginning() -> None:
    s = np.array([1e-100, 1e-10, 1e-6])
    # What the series leave out is below (pi s/2)^4, here 1e-23.
    square = (math.pi * s / 2) ** 2
    np.testing.assert_allclose(
        PROFILE.running_impulse(s), math.pi / 4 * s**2 * (1 - square / 12), rtol=2e-15, atol=0
    )
    np.testing.assert_allclose(
        PROFILE.double_integral(s), math.pi / 12 * s**3 * (1 - square / 20), rtol=2e-15, atol=0
    )


def test_series_and_formula_of_the_double_integral_meet() -> None:
    s = 2 / math.pi * np.array([1 - 1e-9, 1.0, 1 + 1e-9])
    slope = PROFILE.running_impulse(s[1])
    steps = np.diff(PROFILE.double_integral(s))
    # A jump between the two would show: the steps are 4e-10 and known to the rounding of the integral.
    np.testing.assert_allclose(steps, slope * np.diff(s), atol=2e-16, rtol=1e-8)


def test_it_breaks_the_third_of_the_conditions_alone() -> None:
    steel = Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
    shock = Shock(profile=PROFILE, peak_force=100.0, rise_time=1e-5)
    found = Predictor().section4(shock, Chain(material=steel, radius=4.75e-3)).conditions
    assert [condition.statement for condition in found] == ["a2 >= a1", "a1 >= 1/2", "a2 <= (n-1)/2"]
    assert [condition.holds for condition in found] == [True, True, False]
    margins = [condition.margin for condition in found]
    np.testing.assert_allclose(margins, [0, 2 / math.pi - 0.5, 0.5 - 2 / math.pi], rtol=1e-15)
    assert margins[2] == pytest.approx(-0.137, abs=5e-4)  # as the docstring says
