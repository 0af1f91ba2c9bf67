"""The distribution as shockwave sees it, and its scenario."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
import shockwave as sw

FILE = Path(__file__).parent.parent / "profiles" / "hertz-impact.yaml"


def test_the_distribution_is_listed_without_a_problem(tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", "-m", "shockwave", "list", "plugins", "--check", "--json"]
    printed = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60).stdout
    (row,) = [row for row in json.loads(printed) if row["name"] == "shockwave-pulses"]
    assert row["entries"] == [{"kind": "profiles", "name": "hertz-impact"}]
    assert row["problem"] is None


def test_the_scenario_is_compared() -> None:
    comparison = sw.compare(FILE)
    assert comparison.predicted is not None
    assert comparison.simulated.error_estimate <= 1e-6


def test_missing_values_of_a_ball_are_reported_at_their_place(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    text = FILE.read_text(encoding="utf-8")
    file.write_text(text.replace("    ball_speed: 0.5 m/s\n", ""), encoding="utf-8")
    with pytest.raises(sw.ScenarioError, match=r"shock\.parameters\.ball_speed: must be given with "):
        sw.predict(file)


def test_an_impact_without_ball_and_force_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    scene = "chain: {material: ptfe, diameter: 9.5 mm}\nshock: {profile: hertz-impact}\n"
    file.write_text(scene, encoding="utf-8")
    with pytest.raises(sw.ScenarioError, match=r"shock\.peak_force: must be given"):
        sw.predict(file)
