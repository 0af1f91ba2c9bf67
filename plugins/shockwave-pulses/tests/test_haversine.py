"""The haversine: integrals by quadrature, and where it stands to the conditions (3)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shockwave.profiles.conditions import conditions

from shockwave_pulses.haversine import Haversine

PROFILE = Haversine()
ENDS = np.array([0.0, 1e-3, 0.1, 0.5, 0.9, 1.0, 1.1, 1.5, 1.9, 1.999, 2.0])


def test_the_force_is_half_a_versed_sine() -> None:
    s = np.linspace(0, 2, 101)
    np.testing.assert_allclose(PROFILE.force(s), (1 - np.cos(math.pi * s)) / 2, rtol=0, atol=4e-16)


def test_it_gives_no_closed_form() -> None:
    assert PROFILE.closed_areas() is None
    assert PROFILE.closed_running_impulse(ENDS) is None
    assert PROFILE.closed_double_integral(ENDS) is None


def test_areas_come_by_the_default_quadrature() -> None:
    areas = PROFILE.areas()
    assert areas.rise.method == areas.decay.method == "gauss-legendre"
    assert areas.rise.value == pytest.approx(0.5, rel=1e-12)
    assert areas.decay.value == pytest.approx(0.5, rel=1e-12)


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
    found = conditions(PROFILE.areas(quadrature), PROFILE.duration_ratio)
    assert [condition.holds for condition in found] == [True, True, True]
    np.testing.assert_allclose([condition.margin for condition in found], np.zeros(3), atol=1e-13)
