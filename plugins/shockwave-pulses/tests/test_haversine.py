"""The haversine: closed forms, and where it stands to the conditions (3)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shockwave import Chain, Material, Predictor, Shock

from shockwave_pulses.haversine import Haversine

PROFILE = Haversine()
ENDS = np.array([0.0, 1e-3, 0.1, 0.5, 0.9, 1.0, 1.1, 1.5, 1.9, 1.999, 2.0])


def test_the_force_is_half_a_versed_sine() -> None:
    s = np.linspace(0, 2, 101)
    np.testing.assert_allclose(PROFILE.force(s), (1 - np.cos(math.pi * s)) / 2, rtol=0, atol=4e-16)


def test_areas_are_closed_forms() -> None:
    areas = PROFILE.areas()
    assert [areas.rise.value, areas.decay.value] == [0.5, 0.5]
    assert areas.rise.method == areas.decay.method == "closed form"


def test_integrals_keep_their_digits_near_the_beginning() -> None:
    s = np.array([1e-100, 1e-10, 1e-6])
    # What the series leave out is below (pi s)^4, here 1e-22.
    square = (math.pi * s) ** 2
    np.testing.assert_allclose(
        PROFILE.running_impulse(s), math.pi**2 / 12 * s**3 * (1 - square / 20), rtol=2e-15, atol=0
    )
    expected = math.pi**2 / 48 * s[1:] ** 4 * (1 - square[1:] / 30)
    np.testing.assert_allclose(PROFILE.double_integral(s[1:]), expected, rtol=2e-15, atol=0)


@pytest.mark.parametrize("quadrature", [None, "tanh-sinh", "quadpack"])
def test_running_impulse_is_right(quadrature: str | None) -> None:
    expected = ENDS / 2 - np.sin(math.pi * ENDS) / (2 * math.pi)
    np.testing.assert_allclose(PROFILE.running_impulse(ENDS, quadrature), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("quadrature", [None, "tanh-sinh", "quadpack"])
def test_double_integral_is_right(quadrature: str | None) -> None:
    expected = ENDS**2 / 4 - (1 - np.cos(math.pi * ENDS)) / (2 * math.pi**2)
    np.testing.assert_allclose(PROFILE.double_integral(ENDS, quadrature), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("quadrature", [None, "tanh-sinh", "quadpack"])
def test_it_meets_all_conditions_with_equality(quadrature: str | None) -> None:
    steel = Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
    shock = Shock(profile=PROFILE, peak_force=100.0, rise_time=1e-5)
    found = Predictor(quadrature=quadrature).section4(shock, Chain(material=steel, radius=4.75e-3)).conditions
    assert [condition.holds for condition in found] == [True, True, True]
    np.testing.assert_allclose([condition.margin for condition in found], np.zeros(3), atol=1e-13)
