"""Scenarios from text and from mappings: the same as from a file, with located errors."""

from pathlib import Path
from typing import Any

import numpy as np
import pint
import pytest
import yaml

import shockwave as sw

DATA: dict[str, Any] = {
    "name": "blow",
    "chain": {"material": "ptfe", "diameter": "9.5 mm", "granules": [{"count": 20}, {"count": 5, "diameter": "5 mm"}]},
    "shock": {"profile": "tabulated", "parameters": {"file": "pulse.csv", "negative": "zero"}},
    "simulate": {"contacts": [0, 5]},
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "pulse.csv").write_text("time [us],force [N]\n0,0\n1,5\n3,0\n", encoding="utf-8")
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(DATA), encoding="utf-8")
    return tmp_path


def test_text_and_mappings_give_the_scenario_of_the_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = sw.load_scenario(folder / "scene.yaml").scene
    assert sw.Scenario.from_yaml(yaml.safe_dump(DATA), folder=folder).scene == scene
    assert sw.Scenario.from_dict(DATA, folder=str(folder)).scene == scene
    monkeypatch.chdir(folder)
    assert sw.Scenario.from_dict(DATA).scene == scene


def test_parameters_of_a_mapping_can_vary(folder: Path) -> None:
    """The record is found again."""
    scenario = sw.Scenario.from_dict({**DATA, "uncertainty": {"shock.peak_force": "1 %"}}, folder=folder)
    result = sw.design(scenario, vary="chain.granules[1].count", between=(5, 6), target="chain.length <= 1 m")
    assert result.best is not None


def test_values_of_a_mapping_may_be_arrays_and_quantities() -> None:
    parameters = {"times": np.array([0.0, 1e-6, 3e-6]), "forces": (0, np.float32(5), 0)}
    chain = {"material": sw.material("ptfe").name, "diameter": pint.Quantity(9.5, "mm")}
    scenario = sw.Scenario.from_dict({"chain": chain, "shock": {"profile": "tabulated", "parameters": parameters}})
    assert (scenario.shock.peak_force, scenario.chain.radius) == (5, pytest.approx(4.75e-3, rel=1e-15))


def test_errors_of_text_have_its_lines() -> None:
    with pytest.raises(sw.ScenarioError, match=r"(?m)^text:2:3: shock\.profil: unknown key .*did you mean 'profile'"):
        sw.Scenario.from_yaml("shock:\n  profil: triangular\nchain: {material: ptfe, diameter: 9 mm}\n")


def test_errors_of_a_mapping_have_the_paths_of_its_values() -> None:
    chain = {"material": "ptfe", "diameter": "9 mm", "granules": [{"cuont": 3}]}
    with pytest.raises(sw.ScenarioError) as caught:
        sw.Scenario.from_dict({"chain": chain, "shock": {"profile": "triangular"}})
    paths = {str(fault).partition(": ")[0] for fault in caught.value.faults}
    assert paths == {"chain.granules[0].cuont", "shock.peak_force", "shock.rise_time", "shock.duration_ratio"}
    with pytest.raises(sw.ScenarioError, match=r"^must be a mapping of blocks .got 'a'"):
        sw.Scenario.from_dict("a")  # type: ignore[arg-type]


def test_text_must_be_text() -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^text: must be text in YAML \(got b'"):
        sw.Scenario.from_yaml(b"chain: {}")  # type: ignore[arg-type]
