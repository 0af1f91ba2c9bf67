"""Standard shock-test pulses: contract, shape, digits, conditions (3), limits, and the same pulse as a record."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

import shockwave as sw
from shockwave.testing import ProfileContract
from support.scenario_texts import load, schema_faults
from support.scenes import CHAIN, FORCE, lasting

R, F = 0.25, 0.125
#: Pulses of straight lines, with their corners: times over the total duration, and the forces there.
LINES: dict[str, tuple[sw.ShockProfile, list[float], list[float]]] = {
    "trapezoid": (sw.Trapezoid(), [0, 0.1, 0.9, 1], [0, 1, 1, 0]),
    "uneven trapezoid": (sw.Trapezoid(rise_fraction=R, fall_fraction=F), [0, R, 1 - F, 1], [0, 1, 1, 0]),
    "jump at the end": (sw.Trapezoid(rise_fraction=0.2, fall_fraction=0), [0, 0.2, 1], [0, 1, 1]),
    "no plateau": (sw.Trapezoid(rise_fraction=0.3, fall_fraction=0.7), [0, 0.3, 1], [0, 1, 0]),
    "rectangular": (sw.Rectangular(), [0, 0.01, 0.99, 1], [0, 1, 1, 0]),
    "ideal rectangle": (sw.Rectangular(rise_fraction=1e-6, fall_fraction=0), [0, 1e-6, 1], [0, 1, 1]),
    "initial-peak-sawtooth": (sw.InitialPeakSawtooth(), [0, 0.05, 1], [0, 1, 0]),
    "ideal initial peak": (sw.InitialPeakSawtooth(rise_fraction=1e-6), [0, 1e-6, 1], [0, 1, 0]),
    "final-peak-sawtooth": (sw.FinalPeakSawtooth(), [0, 0.95, 1], [0, 1, 0]),
    "ideal final peak": (sw.FinalPeakSawtooth(fall_fraction=1e-6), [0, 1 - 1e-6, 1], [0, 1, 0]),
}
STRAIGHT = pytest.mark.parametrize(("profile", "times", "forces"), LINES.values(), ids=LINES)
SINES: dict[str, sw.ShockProfile] = {"half-sine": sw.HalfSine(), "haversine": sw.Haversine()}
BLASTS = {
    "friedlander": sw.Friedlander(),
    "straight decay": sw.Friedlander(decay_coefficient=0, rise_fraction=1e-6),
    "fast decay": sw.Friedlander(decay_coefficient=100, rise_fraction=0.5),
    "series": sw.Friedlander(decay_coefficient=1.999, rise_fraction=0.1),
}
CURVES: dict[str, sw.ShockProfile] = SINES | BLASTS
PULSES = CURVES | {name: profile for name, (profile, *_) in LINES.items()}
EACH = pytest.mark.parametrize("profile", PULSES.values(), ids=PULSES)


class TestContract(ProfileContract):
    profiles = tuple(PULSES.values())


# ---------------------------------------------------------------- shape


@STRAIGHT
def test_the_force_is_linear_between_its_corners(profile: Any, times: list[float], forces: list[float]) -> None:
    n = profile.duration_ratio
    np.testing.assert_allclose(np.array(profile.breakpoints) / n, times, rtol=4e-16)
    shares = np.array(times)[:, None] + np.linspace(0, 1, 20, endpoint=False) * np.diff(times, append=1)[:, None]
    # A rounding of the time, 1e-16, is multiplied by the steepest slope, 1e6.
    np.testing.assert_allclose(profile.force(shares * n), np.interp(shares, times, forces), rtol=0, atol=1e-9)


@pytest.mark.parametrize("rise", [0.1, 0.3, 0.7, 0.9, 1 / 3, 1e-6])
def test_rounding_makes_no_plateau(rise: float) -> None:
    assert sw.Trapezoid(rise_fraction=rise, fall_fraction=1 - rise).breakpoints == (0.0, 1.0, 1 / rise)


@pytest.mark.parametrize(
    ("make", "force", "path"),
    [
        (sw.HalfSine, mpmath.sin, lambda x: (x - mpmath.sin(x)) * 4 / mpmath.pi**2),
        (sw.Haversine, lambda x: mpmath.sin(x) ** 2, lambda x: (x**2 - mpmath.sin(x) ** 2) / mpmath.pi**2),
    ],
    ids=SINES,
)
def test_sines_keep_their_digits(make: Any, force: Any, path: Any) -> None:
    profile, s = make(), [1e-50, 1e-9, 1e-3, 0.3, 1.0, 1.4, 1.999, 2.0]
    with mpmath.workdps(250):
        x = [mpmath.pi / 2 * mpmath.mpf(each) for each in s]
        forces, paths = ([float(function(each)) for each in x] for function in (force, path))
        impulses = [float(mpmath.diff(lambda t: path(mpmath.pi / 2 * t), mpmath.mpf(each), h=1e-90)) for each in s]
    # Of the peak, as the decay is close to zero at its end; the integrals relatively, however small.
    np.testing.assert_allclose(profile.force(s), forces, rtol=0, atol=2e-16)
    np.testing.assert_allclose(profile.running_impulse(s), impulses, rtol=4e-15)
    check_paths(profile, s, paths)


def check_paths(profile: sw.ShockProfile, s: list[float], paths: list[float]) -> None:
    """The displacements are exact to the stated error, of a few roundings of the last one."""
    table = profile.free_path()
    assert table.error < 5e-14
    np.testing.assert_allclose([table.at(each)[0] for each in s], paths, rtol=0, atol=table.error * paths[-1])


@pytest.mark.parametrize("profile", BLASTS.values(), ids=BLASTS)
def test_a_blast_keeps_its_digits(profile: Any) -> None:
    n, b, shares = profile.duration_ratio, mpmath.mpf(profile.decay_coefficient), (1e-9, 1e-4, 0.1, 0.4, 0.999, 1.0)
    s = np.array([1 + share * (n - 1) for share in shares])
    forces, impulses, paths = [], [], []
    for time in s.tolist():
        with mpmath.workdps(40):
            u, width = (mpmath.mpf(time) - 1) / (mpmath.mpf(n) - 1), mpmath.mpf(n) - 1
            impulse, path = (
                mpmath.quad(lambda v: (u - v) ** k * (1 - v) * mpmath.exp(-b * v), [0, u / 9, u])  # noqa: B023
                for k in (0, 1)
            )
            forces.append(float((1 - u) * mpmath.exp(-b * u)))
            impulses.append(float(mpmath.mpf(1) / 2 + width * impulse))
            paths.append(float(mpmath.mpf(1) / 6 + width * u / 2 + width**2 * path))
    # A rounding of u is multiplied by b; the force is also rounded in units of its peak.
    np.testing.assert_allclose(profile.force(s), forces, rtol=3e-14, atol=1e-16)
    np.testing.assert_allclose(profile.running_impulse(s), impulses, rtol=4e-15)
    check_paths(profile, s.tolist(), paths)


@pytest.mark.parametrize(
    ("make", "values", "message"),
    [
        (sw.Trapezoid, {"rise_fraction": 0}, "rise_fraction: must be >= 1e-06 and < 1 (got 0)"),
        (sw.Trapezoid, {"rise_fraction": 0.6, "fall_fraction": 0.5}, "fall_fraction: must be <= 0.4, the time after"),
        (sw.Rectangular, {"fall_fraction": 0.2}, "fall_fraction: must be >= 0 and <= 0.1 (got 0.2)"),
        (sw.InitialPeakSawtooth, {"rise_fraction": 0.6}, "rise_fraction: must be >= 1e-06 and <= 0.5 (got 0.6)"),
        (sw.FinalPeakSawtooth, {"fall_fraction": 0.5}, "fall_fraction: must be >= 1e-06 and < 0.5 (got 0.5)"),
        (sw.HalfSine, {"duration_ratio": 3}, "duration_ratio: unknown argument"),
        (sw.Trapezoid, {"duration_ratio": 3}, "duration_ratio: unknown argument"),
    ],
    ids=lambda value: ", ".join(value) if isinstance(value, dict) else "",
)
def test_a_wrong_parameter_of_a_pulse_is_named(make: Any, values: dict[str, float], message: str) -> None:
    with pytest.raises(sw.InvalidValueError) as caught:
        make(**values)
    assert str(caught.value).startswith(message)


# ---------------------------------------------------------------- simulation


@EACH
def test_a_simulation_agrees_with_the_same_pulse_as_a_record(profile: sw.ShockProfile) -> None:
    shock, curved = lasting(profile, 3.0), profile in CURVES.values()
    n = profile.duration_ratio
    s = np.append(np.linspace(0, 1, 2001), np.linspace(1, n, 2001)[1:]) if curved else np.array(profile.breakpoints)
    # A record ends at zero, so a jump at the end takes it 1e-9 of the duration.
    times, forces = np.append(s, s[-1] * (1 + 1e-9)), np.append(profile.force(s), 0.0)
    record = sw.Shock(profile=sw.Tabulated(times=shock.rise_time * times, forces=FORCE * forces))
    found, expected = (sw.simulate(each, CHAIN, rtol=1e-8).peak_force for each in (shock, record))
    # 2000 chords lie beside a curve by 2e-7 of the impulse at most, and by 2e-4 where it decays by e^100.
    assert found == pytest.approx(expected, rel=(3e-4 if profile is BLASTS["fast decay"] else 3e-7) if curved else 3e-8)


def test_a_long_rectangle_drives_the_first_wave_of_a_step() -> None:
    # A force that is switched on for ever makes a first wave of 2.33 times its value.
    result = sw.simulate(lasting(sw.Rectangular(), 40.0), CHAIN, waves="primary")
    assert result.amplification == pytest.approx(2.33, rel=5e-3)


# ---------------------------------------------------------------- scenarios

PARAMETERS = {
    "half-sine": ("{}", sw.HalfSine()),
    "haversine": ("{}", sw.Haversine()),
    "trapezoid": ("{rise_fraction: 20 %, fall_fraction: 0}", sw.Trapezoid(rise_fraction=0.2, fall_fraction=0)),
    "rectangular": ("{rise_fraction: 0.02}", sw.Rectangular(rise_fraction=0.02)),
    "initial-peak-sawtooth": ("{rise_fraction: 0.1}", sw.InitialPeakSawtooth(rise_fraction=0.1)),
    "final-peak-sawtooth": ("{fall_fraction: 0.1}", sw.FinalPeakSawtooth(fall_fraction=0.1)),
    "friedlander": ("{decay_coefficient: 2}", sw.Friedlander(decay_coefficient=2.0)),
}
STEEL = "chain: {material: bearing-steel-52100, diameter: 9.5 mm}"


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_scenario_with_peak_and_duration_is_the_shock_in_python(name: str, tmp_path: Path) -> None:
    parameters, profile = PARAMETERS[name]
    text = f"{STEEL}\nshock: {{profile: {name}, peak_force: 30 N, duration: 60 us, parameters: {parameters}}}\n"
    assert load(tmp_path, text).shock == sw.Shock(profile=profile, peak_force=30.0, duration=60e-6)
    assert schema_faults(text) == []


# ---------------------------------------------------------------- a plugin with the same names
