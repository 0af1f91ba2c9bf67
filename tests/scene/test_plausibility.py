"""Unusual quantities: a warning where a wrong unit is likely, in every answer; never an error."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import shockwave as sw
from shockwave import cli
from shockwave.report.page_results import Findings
from shockwave.scene.plausibility import unusual, unusual_warnings
from support.pages import ROOT
from support.scenes import CASE_A, CHAIN, STEEL

SLIP = """\
chain: {material: {youngs_modulus: 193 GPa, poisson_ratio: 0.3, density: 7.958}, diameter: 9.5, granules: 3}
impact: {velocity: 0.5 m/s}
"""
TAPER = sw.Segment(count=3, diameter=sw.Taper(first=9.5, last=5e-3))
LIGHT = sw.Segment(material=sw.Material(youngs_modulus=1e9, poisson_ratio=0.3, density=2.2))
#: Scene -> the paths that are unusual.
SCENES: dict[str, tuple[Any, sw.Chain, list[str]]] = {
    "usual": (CASE_A, CHAIN, []),
    "beads of 9.5 m": (CASE_A, evolve(CHAIN, radius=4.75), ["chain.diameter"]),
    "rise of 10 s": (evolve(CASE_A, rise_time=10.0), CHAIN, ["shock.rise_time"]),
    "ends of the ranges": (evolve(CASE_A, rise_time=1.0, peak_force=1e-9), CHAIN, []),
    "force in kN twice": (evolve(CASE_A, peak_force=1e11), CHAIN, ["shock.peak_force"]),
    "density in g/cm3": (CASE_A, evolve(CHAIN, material=evolve(STEEL, density=7.958)), ["chain.material.density"]),
    "modulus in GPa": (
        CASE_A,
        evolve(CHAIN, material=evolve(STEEL, youngs_modulus=193.0)),
        ["chain.material.youngs_modulus"],
    ),
    "striker in mm/s": (sw.Impact(velocity=5e4, diameter=5.0), CHAIN, ["impact.velocity", "impact.diameter"]),
    "wall in GPa": (
        CASE_A,
        evolve(CHAIN, granules=9, end=sw.Wall(material=evolve(STEEL, youngs_modulus=193.0))),
        ["chain.end.wall.youngs_modulus"],
    ),
    "segments": (
        CASE_A,
        sw.Chain(material=STEEL, radius=4.75e-3, granules=[TAPER, sw.Cell(repeat=2, cell=[LIGHT])]),
        ["chain.granules[0].diameter", "chain.granules[1].cell[0].material.density"],
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_each_unusual_value_is_named_with_its_path(name: str) -> None:
    excitation, chain, paths = SCENES[name]
    assert [fault.path for fault in unusual(excitation, chain)] == paths


def test_answers_of_all_kinds_warn() -> None:
    chain = evolve(CHAIN, radius=4.75)
    (warning,) = unusual_warnings(CASE_A, chain)
    assert warning.startswith("chain.diameter is 9.5 m; usual values are 1 um to 1 m (")
    assert warning.endswith("). Check the unit.")
    for model in ("best", "section-4"):
        assert warning in sw.predict(CASE_A, chain, model=model).warnings
    (outcome,) = sw.Predictor().predict_many([CASE_A], chain)
    assert isinstance(outcome, sw.Outcome)
    assert warning in outcome.warnings
    assert warning in sw.compare(CASE_A, chain, rtol=1e-3).warnings
    assert warning in sw.simulate(CASE_A, chain, rtol=1e-3).warnings
    walled = evolve(chain, granules=3, end=sw.Wall())
    assert warning in sw.simulate(CASE_A, walled, rtol=1e-3).warnings
    assert warning in sw.predict(sw.Impact(velocity=1.0), evolve(chain, granules=40)).warnings


def test_validation_locates_unusual_values_and_succeeds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "slip.yaml"
    file.write_text(SLIP, encoding="utf-8")
    assert cli.main(["validate", "--json", str(file)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["valid"] is True
    assert [warning.partition("; usual values")[0] for warning in found["warnings"]] == [
        f"{file}:1:82: chain.diameter: is 9.5 m",
        f"{file}:1:65: chain.material.density: is 7.958 kg/m**3",
    ]


def test_a_simulation_that_fails_names_the_unusual_value(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "slow.yaml"
    shock = "shock: {profile: triangular, peak_force: 1 N, rise_time: 15, duration_ratio: 2}"
    file.write_text(f"chain: {{material: ptfe, diameter: 9.5 mm}}\n{shock}\n", encoding="utf-8")
    assert cli.main(["simulate", "--json", str(file)]) == 1
    shown = capsys.readouterr()
    (warning,) = json.loads(shown.out)["warnings"]
    assert warning.startswith("shock.rise_time is 15 s; usual values are")
    assert "\n  ! shock.rise_time is 15 s" in shown.err
    nothing = dict.fromkeys(("predicted", "simulated", "comparison"))
    found = Findings(scenario=sw.load_scenario(file), passages=(), failures=(), text="", **nothing)
    assert found.warnings == (warning,)


def test_an_extreme_force_is_reported_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "strong.yaml"
    shock = "shock: {profile: triangular, peak_force: 1e308 N, rise_time: 15 us, duration_ratio: 2}"
    file.write_text(f"chain: {{material: ptfe, diameter: 9.5 mm, granules: 9, end: {{wall: same}}}}\n{shock}\n")
    assert cli.main(["simulate", str(file)]) == 3
    assert capsys.readouterr().err.startswith(f"{file}:2:30: shock.peak_force: must give a rise time of 1e-30 to 1e+12")


@pytest.mark.parametrize("file", sorted((ROOT / "profiles").rglob("*.yaml")), ids=lambda file: file.stem)
def test_no_example_is_unusual(file: Path) -> None:
    scenario = sw.load_scenario(file)
    assert unusual(scenario.excitation, scenario.chain) == []


@pytest.mark.parametrize(
    "material",
    [
        entry["name"]
        for entry in json.loads((Path(sw.__file__).parent / "scene" / "library.json").read_text(encoding="utf-8"))
    ],
)
def test_no_material_of_the_library_is_unusual(material: str) -> None:
    assert unusual(CASE_A, evolve(CHAIN, material=sw.material(material))) == []
