"""Both profiles against the numbered contract of `ShockProfile`."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from shockwave.profiles.base import ShockProfile
from shockwave.quadrature import FloatArray

from shockwave_pulses.half_sine import HalfSine
from shockwave_pulses.haversine import Haversine

RISE, DECAY = np.linspace(0, 1, 401), np.linspace(1, 2, 401)

pytestmark = pytest.mark.parametrize("profile", [HalfSine(), Haversine()], ids=["half-sine", "haversine"])


def test_the_decay_lasts_as_long_as_the_rise(profile: ShockProfile) -> None:
    assert profile.duration_ratio == 2.0
    assert isinstance(profile.duration_ratio, float)


def test_the_duration_ratio_is_not_for_the_user_to_choose(profile: ShockProfile) -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'duration_ratio'"):
        type(profile)(duration_ratio=3.0)  # type: ignore[call-arg]
    with pytest.raises(AttributeError):
        profile.duration_ratio = 3.0


@pytest.mark.parametrize("shape", [(), (0,), (5,), (2, 3)], ids=str)
def test_shapes_are_kept(profile: ShockProfile, shape: tuple[int, ...]) -> None:
    results = (
        profile.rise(np.full(shape, 0.5)),
        profile.decay(np.full(shape, 1.5)),
        profile.force(np.full(shape, 0.5)),
        profile.running_impulse(np.full(shape, 0.5)),
        profile.double_integral(np.full(shape, 0.5)),
    )
    assert [result.shape for result in results] == [shape] * len(results)
    assert all(isinstance(result, np.ndarray) and result.dtype == float for result in results)


def test_values_are_finite_and_between_0_and_1(profile: ShockProfile) -> None:
    values = np.concatenate((profile.rise(RISE), profile.decay(DECAY)))
    assert np.isfinite(values).all()
    assert values.min() >= 0
    assert values.max() <= 1


def test_the_peak_is_1_from_both_sides(profile: ShockProfile) -> None:
    assert profile.rise(np.ones(1))[0] == 1
    assert profile.decay(np.ones(1))[0] == 1
    assert profile.force(1.0) == 1


def test_the_force_begins_and_ends_at_0(profile: ShockProfile) -> None:
    np.testing.assert_array_equal(profile.force([0.0, 2.0]), [0.0, 0.0])


def test_the_force_is_0_outside(profile: ShockProfile) -> None:
    outside = [-1e9, -1.0, -1e-300, np.nextafter(2.0, 3.0), 3.0, 1e9]
    np.testing.assert_array_equal(profile.force(outside), np.zeros(6))


def test_the_force_rises_and_then_decays(profile: ShockProfile) -> None:
    assert (np.diff(profile.rise(RISE)) > 0).all()
    assert (np.diff(profile.decay(DECAY)) < 0).all()


def test_the_pulse_is_symmetric(profile: ShockProfile) -> None:
    # 2 - s is exact on [1, 2], so nothing is lost.
    np.testing.assert_array_equal(profile.decay(DECAY), profile.rise(2.0 - DECAY))


def test_the_same_s_gives_the_same_value(profile: ShockProfile) -> None:
    given = RISE.copy()
    first, other = profile.rise(given), pickle.loads(pickle.dumps(profile))
    np.testing.assert_array_equal(given, RISE)
    np.testing.assert_array_equal(profile.rise(given), first)
    np.testing.assert_array_equal(other.rise(given), first)
    np.testing.assert_array_equal([float(profile.rise(s[None])[0]) for s in given], first)
    assert other == profile
    assert hash(other) == hash(profile)


def test_the_force_is_smooth_between_the_breakpoints(profile: ShockProfile) -> None:
    assert profile.breakpoints == (0.0, 1.0, 2.0)
    assert profile.singular_points == ()
    # The slope of either is at most pi/2, so a larger step would be a jump.
    for values in (profile.rise(RISE), profile.decay(DECAY)):
        assert np.abs(np.diff(values)).max() <= np.pi / 2 / 400 * (1 + 1e-9)


def test_there_is_no_record_behind_it(profile: ShockProfile) -> None:
    assert profile.recorded_peak_force is None
    assert profile.recorded_rise_time is None
    assert profile.notes == ()


@pytest.mark.parametrize("quadrature", ["gauss-legendre", "tanh-sinh", "quadpack"])
def test_areas_by_quadrature_agree_within_their_errors(profile: ShockProfile, quadrature: str) -> None:
    exact = 2 / np.pi if isinstance(profile, HalfSine) else 0.5
    areas = profile.areas(quadrature)
    for area in (areas.rise, areas.decay):
        assert area.method == quadrature
        assert area.evaluations > 0
        assert abs(area.value - exact) <= area.error < 1e-12


def test_nothing_changes_after_the_end(profile: ShockProfile) -> None:
    late: FloatArray = np.array([2.0, 2.5, 100.0])
    whole = profile.areas().total
    np.testing.assert_allclose(profile.running_impulse(late), whole, rtol=1e-14)
    # By symmetry the mean time of the force is 1, so a free granule moves as if all came at once then.
    np.testing.assert_allclose(profile.double_integral(late), whole * (late - 1), rtol=1e-13)
