"""Trapezoid, rectangle and sawteeth: shapes, closed forms, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid
from shockwave import InvalidValueError, PowerLaw
from shockwave.hooks import FloatArray

from shockwave_pulses.final_peak_sawtooth import FinalPeakSawtooth
from shockwave_pulses.initial_peak_sawtooth import InitialPeakSawtooth
from shockwave_pulses.rectangular import Rectangular
from shockwave_pulses.straight_lines import StraightLines
from shockwave_pulses.trapezoid import Trapezoid

# Each with its corners: times over the total duration, and the forces there.
SHAPES = {
    "trapezoid": (Trapezoid(), [0, 0.1, 0.9, 1], [0, 1, 1, 0]),
    "uneven trapezoid": (
        Trapezoid(rise_fraction=0.25, fall_fraction=0.125),
        [0, 0.25, 0.875, 1],
        [0, 1, 1, 0],
    ),
    "jump at the end": (Trapezoid(rise_fraction=0.2, fall_fraction=0), [0, 0.2, 1], [0, 1, 1]),
    "no plateau": (Trapezoid(rise_fraction=0.3, fall_fraction=0.7), [0, 0.3, 1], [0, 1, 0]),
    "rectangular": (Rectangular(), [0, 0.01, 0.99, 1], [0, 1, 1, 0]),
    "initial-peak": (InitialPeakSawtooth(), [0, 0.05, 1], [0, 1, 0]),
    "final-peak": (FinalPeakSawtooth(), [0, 0.95, 1], [0, 1, 0]),
}
EACH = pytest.mark.parametrize(("profile", "times", "forces"), SHAPES.values(), ids=SHAPES)


def _ends(profile: StraightLines) -> FloatArray:
    """s in rise, plateau and fall, close to the corners, and at both ends."""
    n = profile.duration_ratio
    shares = np.array([1e-9, 1e-3, 0.01, 0.1, 0.25, 0.5, 0.77, 0.875, 0.96, 0.999, 1])
    return np.unique(np.concatenate((profile.breakpoints[1:], [0.3, 1 + 1e-7], n * shares)))


@EACH
def test_the_corners_are_the_breakpoints(
    profile: StraightLines, times: list[float], forces: list[float]
) -> None:
    found = np.array(profile.breakpoints) / profile.duration_ratio
    np.testing.assert_allclose(found, times, rtol=4e-16, atol=0)
    np.testing.assert_array_equal(profile.force(profile.breakpoints), forces)


@EACH
def test_the_force_is_linear_between_the_corners(
    profile: StraightLines, times: list[float], forces: list[float]
) -> None:
    shares = np.linspace(0, 1, 401)
    expected = np.interp(shares, times, forces)
    # A rounding of the share counts as often as the steepest line rises by, a hundredfold at most.
    found = profile.force(shares * profile.duration_ratio)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)


@EACH
def test_areas_are_those_of_trapezoids(
    profile: StraightLines, times: list[float], forces: list[float]
) -> None:
    areas = profile.areas()
    assert areas.rise.method == areas.decay.method == "closed form"
    assert areas.rise.value == 0.5
    total = trapezoid(forces, times) * profile.duration_ratio
    assert areas.total == pytest.approx(total, rel=1e-15)


@EACH
@pytest.mark.parametrize("kind", ["running_impulse", "double_integral"])
def test_integrals_agree_with_quadrature(
    profile: StraightLines, times: list[float], forces: list[float], kind: str
) -> None:
    s = _ends(profile)
    integral = getattr(profile, kind)
    # Polynomials between the breakpoints: the rule is exact, and both are known to roundings.
    np.testing.assert_allclose(integral(s), integral(s, "gauss-legendre"), rtol=1e-14, atol=0)


@EACH
def test_the_table_for_simulations_agrees_with_the_integrals(
    profile: StraightLines, times: list[float], forces: list[float]
) -> None:
    table, s = profile.free_path(), _ends(profile)
    found = np.array([table.at(end) for end in s.tolist()]).T
    expected = np.stack((profile.double_integral(s), profile.running_impulse(s)))
    errors = np.abs(found - expected) / expected[:, -1:]
    assert errors.max() <= table.error < 1e-14


@pytest.mark.parametrize(
    "profile", [InitialPeakSawtooth(rise_fraction=0.2), FinalPeakSawtooth(fall_fraction=0.4)], ids=repr
)
def test_a_sawtooth_is_a_triangle_of_power_one(profile: StraightLines) -> None:
    triangle = PowerLaw(rise_exponent=1, decay_exponent=1, duration_ratio=profile.duration_ratio)
    s = np.linspace(0, profile.duration_ratio, 301)
    # Both impulses are known to a few roundings of the whole.
    np.testing.assert_array_equal(profile.force(s), triangle.force(s))
    np.testing.assert_allclose(profile.running_impulse(s), triangle.running_impulse(s), rtol=0, atol=2e-15)


def test_a_rectangle_is_a_trapezoid() -> None:
    steep = Rectangular(rise_fraction=0.02, fall_fraction=0)
    same = Trapezoid(rise_fraction=0.02, fall_fraction=0)
    s = np.linspace(0, 50, 101)
    np.testing.assert_array_equal(steep.force(s), same.force(s))


@pytest.mark.parametrize("rise", [0.1, 0.3, 0.7, 0.9, 1 / 3, 1e-6])
def test_without_a_plateau_rounding_makes_none(rise: float) -> None:
    profile = Trapezoid(rise_fraction=rise, fall_fraction=1 - rise)
    assert profile.breakpoints == (0.0, 1.0, 1 / rise)


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        (Trapezoid, {"rise_fraction": 0}, "rise_fraction: must be >= 1e-06 and < 1 (got 0)"),
        (Trapezoid, {"rise_fraction": 1}, "rise_fraction: must be >= 1e-06 and < 1 (got 1)"),
        (Trapezoid, {"fall_fraction": -0.1}, "fall_fraction: must be >= 0 and < 1 (got -0.1)"),
        (
            Trapezoid,
            {"rise_fraction": 0.6, "fall_fraction": 0.5},
            "fall_fraction: must be <= 0.4, the rest after the rise (got 0.5)",
        ),
        (Rectangular, {"rise_fraction": 0.2}, "rise_fraction: must be >= 1e-06 and <= 0.1 (got 0.2)"),
        (Rectangular, {"rise_fraction": 0}, "rise_fraction: must be >= 1e-06 and <= 0.1 (got 0)"),
        (InitialPeakSawtooth, {"rise_fraction": 0.6}, "rise_fraction: must be >= 1e-06 and <= 0.5 (got 0.6)"),
        (FinalPeakSawtooth, {"fall_fraction": 0}, "fall_fraction: must be >= 1e-06 and < 0.5 (got 0)"),
        (FinalPeakSawtooth, {"fall_fraction": 0.5}, "fall_fraction: must be >= 1e-06 and < 0.5 (got 0.5)"),
    ],
)
def test_what_is_no_such_pulse_is_refused(
    kind: type[StraightLines], values: dict[str, float], message: str
) -> None:
    with pytest.raises(InvalidValueError) as caught:
        kind(**values)
    assert str(caught.value) == message
