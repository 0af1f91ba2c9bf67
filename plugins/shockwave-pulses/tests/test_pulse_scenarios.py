"""The scenarios of the distribution, predicted, simulated and compared."""

from __future__ import annotations

from pathlib import Path

import pytest
from shockwave import ScenarioError, compare, predict, simulate

FOLDER = Path(__file__).parent.parent / "profiles"
NAMES = [
    "final-peak-sawtooth",
    "half-sine",
    "haversine",
    "hertz-impact",
    "initial-peak-sawtooth",
    "rectangular",
    "trapezoid",
]

each = pytest.mark.parametrize("name", NAMES)


def file_of(name: str) -> Path:
    return FOLDER / f"{name}.yaml"


def test_there_is_a_scenario_for_each_pulse() -> None:
    assert sorted(file.stem for file in FOLDER.glob("*.yaml")) == NAMES


@each
def test_it_is_predicted(name: str) -> None:
    outcome = predict(file_of(name))
    assert outcome.scenario == name
    assert outcome.peak_force is not None
    assert outcome.peak_force > 0


@each
def test_prediction_and_simulation_are_compared(name: str) -> None:
    comparison = compare(file_of(name))
    assert comparison.predicted is not None
    # trains end with waves that are distinguished or not; both have a leading wave
    assert min(comparison.predicted.peak_force, comparison.simulated.peak_force) > 0


@each
def test_it_is_simulated(name: str) -> None:
    assert simulate(file_of(name), waves="primary").error_estimate <= 1e-6


@pytest.mark.parametrize("name", [name for name in NAMES if name != "hertz-impact"])
def test_a_pulse_needs_peak_and_duration_alone(name: str, tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    shock = f"{{profile: {name}, peak_force: 100 N, duration: 60 us}}"
    file.write_text(f"chain: {{material: paper-steel, diameter: 9.5 mm}}\nshock: {shock}\n", encoding="utf-8")
    assert predict(file).applied_momentum > 0


def test_missing_values_of_a_ball_are_reported_at_their_place(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    text = file_of("hertz-impact").read_text(encoding="utf-8")
    file.write_text(text.replace("    ball_speed: 2 m/s\n", ""), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"shock\.parameters\.ball_speed: must be given with "):
        predict(file)


def test_an_impact_without_ball_and_force_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    scene = "chain: {material: ptfe, diameter: 9.5 mm}\nshock: {profile: hertz-impact}\n"
    file.write_text(scene, encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"shock\.peak_force: must be given"):
        predict(file)
