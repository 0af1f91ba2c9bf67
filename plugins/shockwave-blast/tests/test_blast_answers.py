"""Prediction and simulation with the profiles, from scenario files and from Python."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import shockwave as sw
from shockwave import Predictor, ScenarioError, load_scenario

FILES = sorted((Path(__file__).parent.parent / "profiles").glob("*.yaml"))

each_file = pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)


def test_the_scenarios_are_there() -> None:
    assert [file.stem for file in FILES] == ["microcharge", "nylon-balls"]


@each_file
@pytest.mark.parametrize("question", [sw.predict, sw.simulate, sw.compare])
def test_scenarios_run(file: Path, question: Callable[..., sw.Outcome]) -> None:
    assert question(file, waves="primary").to_dict()


@each_file
def test_scenarios_last_less_than_30_natural_times(file: Path) -> None:
    scenario = load_scenario(file)
    unit = scenario.chain.time_at_unit_force / scenario.shock.peak_force ** (1 / 6)
    assert scenario.shock.duration < 30 * unit


@each_file
def test_scenarios_meet_the_conditions(file: Path) -> None:
    scenario = load_scenario(file)
    assert Predictor().section4(scenario.shock, scenario.chain).holds


def test_a_prediction_states_its_assumptions() -> None:
    scenario = load_scenario(next(file for file in FILES if file.stem == "microcharge"))
    assert Predictor().predict(scenario.shock, scenario.chain).notes == scenario.shock.profile.notes != ()


def test_a_standoff_out_of_range_is_located_in_the_file(tmp_path: Path) -> None:
    text = next(file for file in FILES if file.stem == "microcharge").read_text(encoding="utf-8")
    file = tmp_path / "near.yaml"
    file.write_text(text.replace("standoff: 20 cm", "standoff: 1 cm"), encoding="utf-8")
    with pytest.raises(
        ScenarioError, match=r"near\.yaml:\d+:\d+: shock\.parameters\.standoff: must be 0\.0147 m"
    ):
        load_scenario(file)
