"""What all pulses share beyond the contract of `ShockProfile`."""

from __future__ import annotations

import numpy as np
import pytest
from shockwave import InvalidValueError, ShockProfile

from shockwave_pulses.final_peak_sawtooth import FinalPeakSawtooth
from shockwave_pulses.half_sine import HalfSine
from shockwave_pulses.haversine import Haversine
from shockwave_pulses.hertz_impact import HertzImpact
from shockwave_pulses.initial_peak_sawtooth import InitialPeakSawtooth
from shockwave_pulses.rectangular import Rectangular
from shockwave_pulses.trapezoid import Trapezoid

PROFILES = {
    "half-sine": HalfSine(),
    "haversine": Haversine(),
    "trapezoid": Trapezoid(),
    "trapezoid with a jump": Trapezoid(fall_fraction=0),
    "initial-peak-sawtooth": InitialPeakSawtooth(),
    "final-peak-sawtooth": FinalPeakSawtooth(),
    "rectangular": Rectangular(),
    "hertz-impact": HertzImpact(),
}

pytestmark = pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)


def test_the_duration_ratio_is_not_for_the_user_to_choose(profile: ShockProfile) -> None:
    with pytest.raises(InvalidValueError, match=r"^duration_ratio: must be left out"):
        type(profile)(duration_ratio=3.0)  # type: ignore[call-arg]
    with pytest.raises(AttributeError):
        profile.duration_ratio = 3.0


def test_the_force_begins_at_0_and_ends_there_or_in_a_jump(profile: ShockProfile) -> None:
    jumps = profile == PROFILES["trapezoid with a jump"]
    np.testing.assert_array_equal(profile.force([0.0, profile.duration_ratio]), [0.0, float(jumps)])


def test_the_peak_is_1_to_the_last_digit(profile: ShockProfile) -> None:
    assert profile.rise(np.ones(1))[0] == profile.decay(np.ones(1))[0] == 1


def test_the_force_rises_and_then_decays(profile: ShockProfile) -> None:
    assert (np.diff(profile.rise(np.linspace(0, 1, 401))) > 0).all()
    assert (np.diff(profile.decay(np.linspace(1, profile.duration_ratio, 401))) <= 0).all()


def test_what_is_returned_is_the_callers_own(profile: ShockProfile) -> None:
    given = np.linspace(0, 1, 11)
    profile.rise(given)[:] = 7.0
    np.testing.assert_array_equal(given, np.linspace(0, 1, 11))


@pytest.mark.parametrize("quadrature", ["gauss-legendre", "tanh-sinh", "quadpack"])
def test_closed_areas_are_those_of_quadrature_within_its_errors(
    profile: ShockProfile, quadrature: str
) -> None:
    exact, areas = profile.areas(), profile.areas(quadrature)
    for closed, area in ((exact.rise, areas.rise), (exact.decay, areas.decay)):
        assert closed.method == "closed form"
        assert area.evaluations > 0
        # The quadrature's error, and a rounding of what it sums.
        assert abs(area.value - closed.value) <= area.error + 4e-16 * profile.duration_ratio
        assert area.error < 1e-10 * profile.duration_ratio


def test_after_the_end_the_path_is_a_line(profile: ShockProfile) -> None:
    n = profile.duration_ratio
    late = np.array([n, 1.5 * n, 100 * n])
    whole = profile.areas().total
    np.testing.assert_allclose(profile.running_impulse(late), whole, rtol=1e-14)
    steps = np.diff(profile.double_integral(late))
    np.testing.assert_allclose(steps, whole * np.diff(late), rtol=1e-12)
