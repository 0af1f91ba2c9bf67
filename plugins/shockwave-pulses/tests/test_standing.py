"""Where each pulse stands to the conditions (3), as its docstring and the README say."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from shockwave import Chain, Material, Predictor, Shock, ShockProfile

from shockwave_pulses.final_peak_sawtooth import FinalPeakSawtooth
from shockwave_pulses.half_sine import HalfSine
from shockwave_pulses.haversine import Haversine
from shockwave_pulses.hertz_impact import HertzImpact
from shockwave_pulses.initial_peak_sawtooth import InitialPeakSawtooth
from shockwave_pulses.rectangular import Rectangular
from shockwave_pulses.trapezoid import Trapezoid

SECTION_4 = Predictor(model="section-4")
NAMES = ["a2 >= a1", "a1 >= 1/2", "a2 <= (n-1)/2"]
HERTZ = 0.8 / 1.471637592162352328690894
R, F = 0.25, 0.125

# Margins in rise times, by the formulas of the docstrings; those that are negative fail.
STANDING: dict[str, tuple[ShockProfile, list[float]]] = {
    "half-sine": (HalfSine(), [0, 2 / math.pi - 1 / 2, 1 / 2 - 2 / math.pi]),
    "haversine": (Haversine(), [0, 0, 0]),
    "trapezoid": (Trapezoid(), [8, 0, -4]),
    "other trapezoid": (
        Trapezoid(rise_fraction=R, fall_fraction=F),
        [(1 - 1.5 * R - F / 2) / R, 0, -(1 - R - F) / (2 * R)],
    ),
    "trapezoid without a plateau": (Trapezoid(rise_fraction=0.75, fall_fraction=0.25), [-1 / 3, 0, 0]),
    "initial-peak-sawtooth": (InitialPeakSawtooth(), [9, 0, 0]),
    "isosceles": (InitialPeakSawtooth(rise_fraction=0.5), [0, 0, 0]),
    "final-peak-sawtooth": (FinalPeakSawtooth(), [(1 / 0.95 - 2) / 2, 0, 0]),
    "rectangular": (Rectangular(), [98, 0, -49]),
    "hertz-impact": (HertzImpact(), [0, HERTZ - 0.5, 0.5 - HERTZ]),
}
NOT_MET = {
    "half-sine": "a2 <= (n-1)/2 fails by 0.137",
    "trapezoid": "a2 <= (n-1)/2 fails by 4",
    "final-peak-sawtooth": "a2 >= a1 fails by 0.474",
    "rectangular": "a2 <= (n-1)/2 fails by 49",
    "hertz-impact": "a2 <= (n-1)/2 fails by 0.0436",
}
README = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")


@pytest.fixture
def chain() -> Chain:
    """Steel beads of 9.5 mm, as in the paper."""
    steel = Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
    return Chain(material=steel, radius=4.75e-3)


@pytest.mark.parametrize(("profile", "margins"), STANDING.values(), ids=STANDING)
def test_margins_are_those_of_the_formulas(profile: ShockProfile, margins: list[float], chain: Chain) -> None:
    found = SECTION_4.predict(Shock(profile=profile, peak_force=100.0, rise_time=2e-5), chain).conditions
    assert [condition.statement for condition in found] == NAMES
    # Roundings of areas and n, the greatest of which is 100.
    assert [condition.margin for condition in found] == pytest.approx(margins, rel=1e-13, abs=1e-13)
    assert [condition.holds for condition in found] == [margin >= 0 for margin in margins]


@pytest.mark.parametrize("name", NOT_MET)
def test_a_prediction_states_what_fails_and_by_how_much(name: str, chain: Chain) -> None:
    outcome = SECTION_4.predict(Shock(profile=STANDING[name][0], peak_force=100.0, rise_time=2e-5), chain)
    (failing,) = [condition for condition in outcome.conditions if not condition.holds]
    assert f"{failing.statement} fails by {-failing.margin:.3g}" == NOT_MET[name]
    assert any("fails conditions (3)" in warning for warning in outcome.warnings)


@pytest.mark.parametrize("name", ["haversine", "initial-peak-sawtooth"])
def test_a_prediction_finds_no_fault_with_what_meets_all(name: str, chain: Chain) -> None:
    outcome = SECTION_4.predict(Shock(profile=STANDING[name][0], peak_force=100.0, rise_time=2e-5), chain)
    assert not any("fails" in warning for warning in outcome.warnings)


@pytest.mark.parametrize("name", [*NOT_MET, "haversine", "initial-peak-sawtooth"])
def test_the_readme_says_the_same(name: str) -> None:
    (row,) = [line for line in README.splitlines() if line.startswith(f"| `{name}` |")]
    assert NOT_MET.get(name, "meets all") in row
