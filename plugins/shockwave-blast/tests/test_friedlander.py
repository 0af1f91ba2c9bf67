"""The Friedlander pulse: closed forms against high precision, and where it stands to the conditions (3)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf
from shockwave import Chain, InvalidValueError, Material, Predictor, Shock, ShockProfile
from shockwave.hooks import FloatArray

from shockwave_blast.friedlander import Friedlander
from shockwave_blast.waveform import decay_area

DECAYS = [0.0, 1e-12, 1e-6, 0.1, 1.0, 1.999, 2.0, 5.0, 50.0, 100.0]
SHARES = np.array([1e-9, 1e-4, 0.01, 0.1, 0.4, 0.9, 0.999, 1.0])
each_decay = pytest.mark.parametrize("b", DECAYS)
each_rise = pytest.mark.parametrize("rise_fraction", [1e-6, 1e-3, 0.5])


def conditions(profile: ShockProfile) -> Sequence[Any]:
    """The three conditions (3), which do not depend on the chain."""
    steel = Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
    shock = Shock(profile=profile, peak_force=100.0, rise_time=1e-5)
    return Predictor().section4(shock, Chain(material=steel, radius=4.75e-3)).conditions


def exact(profile: Friedlander, s: FloatArray, times: int) -> list[float]:
    """The force integrated once or twice from 0 to each s in the decay, in 30 digits."""
    decay_time, b = mpf(profile.duration_ratio) - 1, mpf(profile.decay_coefficient)
    results = []
    with mp.workdps(30):
        for end in s.tolist():
            u = (mpf(end) - 1) / decay_time
            after = mp.quad(lambda v, u=u: (u - v) ** (times - 1) * (1 - v) * mp.exp(-b * v), [0, u])
            rise = mpf(1) / 2 if times == 1 else mpf(1) / 6 + decay_time * u / 2
            results.append(float(rise + decay_time**times * after))
    return results


@each_decay
def test_the_decay_is_friedlanders(b: float) -> None:
    profile = Friedlander(decay_coefficient=b, rise_fraction=0.01)
    u = np.array([0.0, 0.2, 0.5, 0.75, 1.0])
    expected = [(1 - share) * math.exp(-b * share) for share in u]
    # n - s is rounded in units of n, u in the same; b multiplies the latter.
    np.testing.assert_allclose(profile.decay(1 + 99 * u), expected, rtol=1e-14 * (1 + b), atol=0)


def test_the_rise_is_straight() -> None:
    np.testing.assert_array_equal(Friedlander().force([0.0, 0.25, 1.0]), [0.0, 0.25, 1.0])


@each_decay
@each_rise
def test_running_impulse_is_exact(b: float, rise_fraction: float) -> None:
    profile = Friedlander(decay_coefficient=b, rise_fraction=rise_fraction)
    s = 1 + SHARES * (profile.duration_ratio - 1)
    # Measured: 3e-16. The formula with 1/b^2 would lose all digits at b = 1e-12.
    np.testing.assert_allclose(profile.running_impulse(s), exact(profile, s, 1), rtol=1e-15, atol=0)


@each_decay
@each_rise
def test_double_integral_is_exact(b: float, rise_fraction: float) -> None:
    profile = Friedlander(decay_coefficient=b, rise_fraction=rise_fraction)
    s = 1 + SHARES * (profile.duration_ratio - 1)
    np.testing.assert_allclose(profile.double_integral(s), exact(profile, s, 2), rtol=1e-15, atol=0)


def test_integrals_of_the_rise_keep_their_digits_near_the_beginning() -> None:
    s = np.array([1e-100, 1e-8, 0.5, 1.0])
    np.testing.assert_allclose(Friedlander().running_impulse(s), s**2 / 2, rtol=1e-15, atol=0)
    np.testing.assert_allclose(Friedlander().double_integral(s), s**3 / 6, rtol=1e-15, atol=0)


@each_decay
def test_the_fitted_path_is_known_to_rounding(b: float) -> None:
    # The simulator reads it. Measured: up to 3e-14, at b = 100, where the force falls to exp(-100).
    assert Friedlander(decay_coefficient=b).free_path().error < 5e-14


@pytest.mark.parametrize(("b", "area"), [(0.0, 1 / 2), (1.0, math.exp(-1)), (2.0, (1 + math.exp(-2)) / 4)])
def test_area_of_the_decay_has_its_closed_form(b: float, area: float) -> None:
    assert decay_area(b) == pytest.approx(area, rel=2e-16)


@pytest.mark.parametrize("b", [0.0, 1e-12, 1e-6, 1e-3])
def test_area_of_a_slow_decay_is_that_of_its_series(b: float) -> None:
    assert decay_area(b) == pytest.approx(1 / 2 - b / 6 + b**2 / 24 - b**3 / 120, rel=1e-14)


def test_the_duration_ratio_comes_from_the_rise_fraction() -> None:
    assert Friedlander(rise_fraction=0.125).duration_ratio == 8.0
    assert Friedlander().duration_ratio == 1000.0
    with pytest.raises(InvalidValueError, match=r"^duration_ratio: must be left out"):
        Friedlander(duration_ratio=3.0)  # type: ignore[call-arg]


def test_a_shock_takes_peak_and_duration() -> None:
    shock = Shock(profile=Friedlander(rise_fraction=0.01), peak_force=50.0, duration=2e-3)
    assert shock.rise_time == pytest.approx(2e-5, rel=1e-15)


@each_decay
def test_the_default_rise_meets_all_conditions(b: float) -> None:
    profile = Friedlander(decay_coefficient=b)
    found = conditions(profile)
    assert [condition.holds for condition in found] == [True, True, True]
    area = decay_area(b)
    # By the docstring's table; 999/2 - 999 area is a difference of hundreds.
    # Equality within 1e-9 n is a margin of 0.
    last = 999 * (0.5 - area)
    assert [c.margin for c in found] == pytest.approx(
        [999 * area - 0.5, 0.0, last if last > 1e-6 else 0.0], abs=1e-12
    )
    assert found[0].margin > 9.39


@pytest.mark.parametrize(
    ("b", "ratio", "holds"),
    [
        (0.0, 2.0, True),
        (1.0, 2.3591, False),
        (1.0, 2.3592, True),
        (5.0, 4.1197, False),
        (5.0, 4.1198, True),
        (100.0, 51.504, False),
        (100.0, 51.506, True),
    ],
)
def test_a_long_rise_breaks_the_first_condition_below_the_stated_ratio(
    b: float, ratio: float, holds: bool
) -> None:
    found = conditions(Friedlander(decay_coefficient=b, rise_fraction=1 / ratio))
    assert [condition.holds for condition in found] == [holds, True, True]


def test_a_straight_decay_meets_two_conditions_with_equality() -> None:
    found = conditions(Friedlander(decay_coefficient=0))
    assert [condition.margin for condition in found][1:] == [0.0, 0.0]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"decay_coefficient": -0.1}, r"decay_coefficient: must be >= 0 and <= 100 \(got -0.1\)"),
        ({"decay_coefficient": 101}, r"decay_coefficient: must be >= 0 and <= 100 \(got 101\)"),
        ({"rise_fraction": 0}, r"rise_fraction: must be >= 1e-06 and <= 0.5 \(got 0\)"),
        ({"rise_fraction": 0.6}, r"rise_fraction: must be >= 1e-06 and <= 0.5 \(got 0.6\)"),
    ],
    ids=["growing", "too fast", "no rise", "too long a rise"],
)
def test_values_out_of_range_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValueError, match=message):
        Friedlander(**given)
