"""Prediction and simulation with the plugged-in profiles, from Python."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from shockwave import Chain, Material, Predictor, Shock, ShockProfile, Tabulated, simulate

from shockwave_pulses.final_peak_sawtooth import FinalPeakSawtooth
from shockwave_pulses.half_sine import HalfSine
from shockwave_pulses.haversine import Haversine
from shockwave_pulses.hertz_impact import HertzImpact
from shockwave_pulses.initial_peak_sawtooth import InitialPeakSawtooth
from shockwave_pulses.rectangular import Rectangular
from shockwave_pulses.trapezoid import Trapezoid

PROFILES: dict[str, ShockProfile] = {
    "half-sine": HalfSine(),
    "haversine": Haversine(),
    "trapezoid": Trapezoid(),
    "initial-peak-sawtooth": InitialPeakSawtooth(),
    "final-peak-sawtooth": FinalPeakSawtooth(),
    "rectangular": Rectangular(),
    "hertz-impact": HertzImpact(),
}
EACH = pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
# Of equal rise and decay, and smooth.
BOTH = pytest.mark.parametrize("profile", [HalfSine(), Haversine()], ids=["half-sine", "haversine"])
PEAK_FORCE, RATIO = 100.0, 1.5
# Momentum of a solitary wave in units of its peak force and of the chain's unit of time.
MOMENTUM = 1.652066518648
SECTION_4 = Predictor(model="section-4")

ShockMaker = Callable[[ShockProfile, float], Shock]


@pytest.fixture
def chain() -> Chain:
    """Steel beads of 9.5 mm, as in the paper."""
    steel = Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
    return Chain(material=steel, radius=4.75e-3)


@pytest.fixture
def unit(chain: Chain) -> float:
    """Characteristic time [s]."""
    return chain.time_at_unit_force / PEAK_FORCE ** (1 / 6)


@pytest.fixture
def shock_of(unit: float) -> ShockMaker:
    """Shocks from a profile and half a duration in the chain's unit of time."""
    return lambda profile, ratio: Shock(profile=profile, peak_force=PEAK_FORCE, duration=2 * ratio * unit)


def test_half_sine_as_a_single_wave_by_5f(chain: Chain, shock_of: ShockMaker) -> None:
    outcome = SECTION_4.predict(shock_of(HalfSine(), RATIO), chain)
    assert outcome.regime == "single"
    expected = PEAK_FORCE * (RATIO * 4 / math.pi / MOMENTUM) ** 1.2
    assert outcome.peak_force == pytest.approx(expected, rel=1e-12)


def test_half_sine_is_answered_by_section_4_with_a_warning(chain: Chain, shock_of: ShockMaker) -> None:
    outcome = SECTION_4.predict(shock_of(HalfSine(), RATIO), chain)
    assert any("fails conditions (3)" in warning for warning in outcome.warnings)


def test_haversine_as_an_ejection_by_5h(chain: Chain, shock_of: ShockMaker) -> None:
    outcome = SECTION_4.predict(shock_of(Haversine(), RATIO), chain)
    assert outcome.regime == "ejection"
    # (5g): with a1 + a2 = 1 the virtual rise time is A F0^(-1/6), scaled MOMENTUM.
    # (5h) adds the window's impulse.
    share = RATIO / MOMENTUM
    window = 1 - share
    added = window - math.sin(math.pi * window) / math.pi
    assert outcome.peak_force == pytest.approx(PEAK_FORCE * (share + added) ** 1.2, rel=1e-12)


def test_haversine_is_answered_by_section_4_without_a_warning(chain: Chain, shock_of: ShockMaker) -> None:
    assert SECTION_4.predict(shock_of(Haversine(), RATIO), chain).warnings == ()


@BOTH
def test_a_long_pulse_makes_a_train(profile: ShockProfile, chain: Chain, shock_of: ShockMaker) -> None:
    outcome = SECTION_4.predict(shock_of(profile, 4.0), chain)
    assert outcome.regime == "train"
    assert len(outcome.waves) > 1


@EACH
def test_a_short_pulse_is_simulated_as_an_impulse(
    profile: ShockProfile, chain: Chain, shock_of: ShockMaker, unit: float
) -> None:
    shock = shock_of(profile, 0.01)
    result = simulate(shock, chain, rtol=1e-6)
    # In the limit of no duration only the impulse counts, whatever the shape; at 0.01 that holds to 1e-6.
    impulse = profile.areas().total * shock.rise_time / unit
    assert result.amplification == pytest.approx(1.1681817 * (impulse / MOMENTUM) ** 1.2, rel=2e-6)
    assert len(result.waves) == 1


@EACH
def test_simulation_agrees_with_the_same_pulse_as_a_record(
    profile: ShockProfile, chain: Chain, shock_of: ShockMaker
) -> None:
    shock = shock_of(profile, RATIO)
    n = profile.duration_ratio
    s = np.unique(np.concatenate((np.linspace(0, n, 4001), profile.breakpoints)))
    record = Tabulated(times=shock.rise_time * s, forces=PEAK_FORCE * profile.force(s))
    result = simulate(shock, chain, rtol=1e-6)
    recorded = simulate(Shock(profile=record), chain, rtol=1e-6)
    # Chords of 1/4000 lie below a curve by 1e-7 of the impulse at most; each run is good to 1e-6.
    assert result.peak_force == pytest.approx(recorded.peak_force, rel=2e-6)


@EACH
def test_simulation_conserves_momentum_and_energy(
    profile: ShockProfile, chain: Chain, shock_of: ShockMaker
) -> None:
    shock = shock_of(profile, RATIO)
    result = simulate(shock, chain, rtol=1e-6)
    impulse = profile.areas().total * PEAK_FORCE * shock.rise_time
    assert result.applied_momentum == pytest.approx(impulse, rel=1e-12)
    assert result.momentum_defect < 1e-12
    assert result.energy_defect < 1e-6
    assert result.error_estimate <= 1e-6
    assert result.warnings == ()
