"""The scenarios of the distribution, through predict, simulate and compare from the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from shockwave.cli import main
from shockwave.registry.registry import entries

FOLDER = Path(__file__).parent.parent / "profiles"
FILES = sorted(FOLDER.glob("*.yaml"))
OWN = [entry.name for entry in entries("profiles") if entry.distribution == "shockwave-pulses"]

EACH = pytest.mark.parametrize("file", FILES, ids=[file.stem for file in FILES])


def _answer(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    assert main([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_there_is_a_scenario_for_each_pulse() -> None:
    assert [file.stem for file in FILES] == sorted(OWN)


@EACH
def test_it_is_predicted(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer = _answer(capsys, "predict", str(file))
    assert answer["scenario"] == file.stem
    assert answer["peak_force"] > 0


@EACH
def test_prediction_and_simulation_are_compared(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer = _answer(capsys, "compare", str(file))
    assert answer["predicted"]["scenario"] == answer["simulated"]["scenario"] == file.stem
    # Trains end with waves that are distinguished or not; the primary is there in either column.
    assert min(answer["predicted"]["peak_force"], answer["simulated"]["peak_force"]) > 0


@EACH
def test_it_is_simulated(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer = _answer(capsys, "simulate", "--primary", str(file))
    assert answer["error_estimate"] <= 1e-6


@pytest.mark.parametrize("name", [name for name in OWN if name != "hertz-impact"])
def test_a_pulse_needs_peak_and_duration_alone(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "scene.yaml"
    shock = f"{{profile: {name}, peak_force: 100 N, duration: 60 us}}"
    file.write_text(f"chain: {{material: paper-steel, diameter: 9.5 mm}}\nshock: {shock}\n", encoding="utf-8")
    answer = _answer(capsys, "predict", str(file))
    assert answer["applied_momentum"] > 0


def test_missing_values_of_a_ball_are_reported_at_their_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "scene.yaml"
    text = (FOLDER / "hertz-impact.yaml").read_text(encoding="utf-8")
    file.write_text(text.replace("    ball_speed: 2 m/s\n", ""), encoding="utf-8")
    assert main(["predict", str(file)]) == 3
    assert "shock.parameters.ball_speed: must be given with " in capsys.readouterr().err


def test_an_impact_without_ball_and_force_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(
        "chain: {material: ptfe, diameter: 9.5 mm}\nshock: {profile: hertz-impact}\n", encoding="utf-8"
    )
    assert main(["predict", str(file)]) == 3
    assert "shock.peak_force: must be given" in capsys.readouterr().err
