"""Unusual quantities: a warning where a wrong unit is likely, in every answer; never an error."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import shockwave as sw
from shockwave.report.page_results import PageResults
from shockwave.scene.plausibility import unusual, unusual_warnings
from support.command_line import scenario, shockwave
from support.pages import ROOT
from support.scenes import CASE_A, CHAIN, STEEL

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
    "striker in mm/s": (sw.Impact(velocity=5e4, diameter=5.0), CHAIN, ["impact.velocity", "impact.diameter"]),
    "wall in GPa": (
        CASE_A,
        evolve(CHAIN, granules=9, end=sw.Wall(material=evolve(STEEL, youngs_modulus=193.0))),
        ["chain.end.wall.youngs_modulus"],
    ),
    "elastic, of unknown strength": (CASE_A, evolve(CHAIN, elastic_only=True), ["chain.elastic_only"]),
    "elastic, wall of unknown strength": (
        CASE_A,
        evolve(
            CHAIN,
            material=sw.material("bearing-steel-52100"),
            granules=9,
            end=sw.Wall(material=STEEL),
            elastic_only=True,
        ),
        ["chain.elastic_only"],
    ),
    "elastic, rigid wall": (
        CASE_A,
        evolve(
            CHAIN,
            material=sw.material("bearing-steel-52100"),
            granules=9,
            end=sw.Wall(material="rigid"),
            elastic_only=True,
        ),
        [],
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
    answers = [
        *(sw.predict(CASE_A, chain, model=model) for model in ("best", "section-4")),
        *sw.Predictor().predict_many([CASE_A], chain),
        sw.compare(CASE_A, chain, rtol=1e-3),
        sw.simulate(CASE_A, chain, rtol=1e-3),
        sw.simulate(CASE_A, evolve(chain, granules=3, end=sw.Wall()), rtol=1e-3),
        sw.predict(sw.Impact(velocity=1.0), evolve(chain, granules=40)),
    ]
    assert all(warning in answer.warnings for answer in answers)


def test_validation_locates_unusual_values_and_succeeds(tmp_path: Path) -> None:
    slip = "{material: {youngs_modulus: 193 GPa, poisson_ratio: 0.3, density: 7.958}, diameter: 9.5, granules: 3}"
    file = scenario(tmp_path, f"chain: {slip}", "impact: {velocity: 0.5 m/s}")
    answer = shockwave("validate", "--json", file)
    assert (answer.status, answer.document["valid"]) == (0, True)
    assert [warning.partition("; usual values")[0] for warning in answer.document["warnings"]] == [
        f"{file}:1:82: chain.diameter: is 9.5 m",
        f"{file}:1:65: chain.material.density: is 7.958 kg/m^3",
    ]


SHOCK = "shock: {{profile: triangular, peak_force: {}, rise_time: {}, duration_ratio: 2}}"


def test_a_simulation_that_fails_names_the_unusual_value(tmp_path: Path) -> None:
    file = scenario(tmp_path, "chain: {material: ptfe, diameter: 9.5 mm}", SHOCK.format("1 N", 15))
    answer = shockwave("simulate", "--json", file)
    assert answer.status == 1
    (warning,) = answer.document["warnings"]
    assert warning.startswith("shock.rise_time is 15 s; usual values are")
    assert "\n  ! shock.rise_time is 15 s" in answer.err
    nothing = dict.fromkeys(("predicted", "simulated", "comparison"))
    found = PageResults(scenario=sw.load_scenario(file), passages=(), failures=(), text="", **nothing)
    assert found.warnings == (warning,)


def test_an_extreme_force_is_reported_as_such(tmp_path: Path) -> None:
    chain = "chain: {material: ptfe, diameter: 9.5 mm, granules: 9, end: {wall: same}}"
    file = scenario(tmp_path, chain, SHOCK.format("1e308 N", "15 us"))
    answer = shockwave("simulate", file)
    assert answer.status == 3
    assert answer.err.startswith(f"{file}:2:30: shock.peak_force: must give a rise time of 1e-30 to 1e+12")


@pytest.mark.parametrize("file", sorted((ROOT / "profiles").rglob("*.yaml")), ids=lambda file: file.stem)
def test_no_example_is_unusual(file: Path) -> None:
    scenario = sw.load_scenario(file)
    assert unusual(scenario.excitation, scenario.chain) == []
