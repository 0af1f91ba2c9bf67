"""The ``sweep`` block: which scenes it stands for, and every fault of it at its place."""

import time
import tracemalloc
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import shockwave as sw
from shockwave.base.errors import ScenarioError
from shockwave.scenario.sweep_block import SWEEP, Sweep
from shockwave.scenario.variations import Family
from support.pages import table
from support.scenario_texts import load, schema_faults

HEAD = """\
chain: {material: copper, radius: 1 mm}
shock: {profile: power-law, peak_force: 1 N, rise_time: 1 us, duration_ratio: 2, parameters: {rise_exponent: 1, decay_exponent: 1}}
"""  # noqa: E501


def swept(folder: Path, block: str, head: str = HEAD) -> Sweep:
    sweep = load(folder, f"{head}sweep: {block}\n").sweep
    assert sweep is not None
    return sweep


def scenes(folder: Path, block: str, head: str = HEAD) -> list[sw.Scenario]:
    """The scenes of all points."""
    scenario = load(folder, f"{head}sweep: {block}\n")
    assert scenario.sweep is not None
    return [Family(scenario).scenario(scenario.sweep.point(index)) for index in range(len(scenario.sweep))]


# ---------------------------------------------------------------- which scenes


def test_the_last_axis_of_a_grid_varies_fastest(tmp_path: Path) -> None:
    found = swept(tmp_path, "{grid: {shock.duration_ratio: [2, 4], shock.rise_time: [1 us, 5 us, 2 us]}}")
    assert found.shape == (2, 3)
    points = [tuple(found.point(index).values()) for index in range(len(found))]
    assert points == [(2, 1e-6), (2, 5e-6), (2, 2e-6), (4, 1e-6), (4, 5e-6), (4, 2e-6)]
    assert list(found.point(0)) == ["shock.duration_ratio", "shock.rise_time"]


def test_parts_make_a_product_in_the_order_of_the_file(tmp_path: Path) -> None:
    block = """
  zip: {shock.rise_time: [1 us, 2 us], shock.peak_force: [1, 2]}
  grid: {chain.material: [copper, lead], shock.duration_ratio: [2, 3, 4]}
  points: [{predict.alpha: literal, chain.granules: 50}, {chain.granules: 60, predict.alpha: constant}]"""
    found = swept(tmp_path, block)
    assert found.shape == (2, 2, 3, 2)
    assert found.point(23) == {
        "shock.rise_time": 2e-6,
        "shock.peak_force": 2.0,
        "chain.material": "lead",
        "shock.duration_ratio": 4.0,
        "predict.alpha": "constant",
        "chain.granules": 60,
    }


@pytest.mark.parametrize(
    ("name", "values", "expected"),
    [
        ("shock.rise_time", "{linspace: [5 us, 50 us, 10]}", np.linspace(5e-6, 50e-6, 10).tolist()),
        ("shock.rise_time", "{logspace: [1 us, 0.1 ms, 5]}", np.geomspace(1e-6, 1e-4, 5).tolist()),
        ("shock.rise_time", "{linspace: [9 us, 1 us, 3]}", [9e-6, 5e-6, 1e-6]),
        ("shock.rise_time", "{linspace: [9 us, 9 us, 1]}", [9e-6]),
        ("chain.granules", "{linspace: [10, 30, 3]}", [10, 20, 30]),
        ("chain.material", "[lead, copper]", ["lead", "copper"]),
        ("simulate.contacts", "[[1, 2], [3]]", [[1, 2], [3]]),
    ],
    ids=["linear", "logarithmic", "downwards", "one", "whole", "names", "lists"],
)
def test_values_are_lists_or_ranges_with_units_and_both_ends(
    tmp_path: Path, name: str, values: str, expected: list[Any]
) -> None:
    found = [value for (value,) in swept(tmp_path, f"{{grid: {{{name}: {values}}}}}").axes[0].values]
    assert found == expected
    assert [type(value) for value in found] == [type(value) for value in expected]


@pytest.mark.parametrize("part", ["{grid: {chain.material: [lead, %s]}}", "{points: [{chain.material: %s}]}"])
def test_materials_are_swept_by_name_or_as_mappings(tmp_path: Path, part: str) -> None:
    own = "{youngs_modulus: 1 GPa, poisson_ratio: 0.3, density: 1 g/cm**3, name: foam}"
    scene = scenes(tmp_path, part % own)[-1]
    assert scene.chain.material == sw.Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1000.0, name="foam")
    with pytest.raises(ScenarioError, match=r"sweep\..*'chain\.material'.*\.density: must be >= 1e-30"):
        scenes(tmp_path, part % own.replace("1 g", "-1 g"))


def test_profiles_are_swept_with_the_parameters_of_all(tmp_path: Path) -> None:
    head = HEAD.replace("power-law", "triangular").replace(", parameters: {rise_exponent: 1, decay_exponent: 1}", "")
    block = "{zip: {shock.profile: [exponential], shock.parameters.rise_rate: [1], shock.parameters.decay_rate: [2]}}"
    (scene,) = scenes(tmp_path, block, head)
    assert scene.shock.profile == sw.Exponential(rise_rate=1, decay_rate=2, duration_ratio=2)
    # an exponential needs rates, which this family does not have: the point fails, the file is sound
    with pytest.raises(ScenarioError, match="rise_rate"):
        scenes(tmp_path, "{grid: {shock.profile: [triangular, exponential]}}", head)


def test_the_first_point_is_the_scenario_and_adds_missing_values(tmp_path: Path) -> None:
    head = HEAD.replace("rise_time: 1 us, ", "").replace(", radius: 1 mm", "")
    block = "{zip: {shock.rise_time: [3 us, 4 us], chain.diameter: [4 mm, 6 mm]}}"
    scenario = load(tmp_path, f"{head}sweep: {block}\n")
    assert (scenario.shock.rise_time, scenario.chain.radius) == (3e-6, 2e-3)
    assert [scene.chain.radius for scene in scenes(tmp_path, block, head)] == [2e-3, 3e-3]


@pytest.mark.parametrize("blocks", ["", "predict: {}", "simulate: {}", "predict: {}\nsimulate: {}"])
def test_the_command_follows_from_the_blocks(tmp_path: Path, blocks: str) -> None:
    run = {"predict: {}": "predict", "simulate: {}": "simulate"}.get(blocks, "compare")
    assert swept(tmp_path, "{grid: {shock.rise_time: [1 us]}}", f"{blocks}\n{HEAD}").run == run
    assert swept(tmp_path, "{run: predict, grid: {shock.rise_time: [1 us]}}", f"{blocks}\n{HEAD}").run == "predict"


# ---------------------------------------------------------------- faults

# block with a mark before the fault, its path below sweep, a part of its problem
TIME, EQUAL = "grid.'shock.rise_time'", "grid.'predict.equal_tolerance'"
_FIVE = ("peak_force", "rise_time", "duration_ratio", "parameters.rise_exponent", "parameters.decay_exponent")
MANY = ", ".join(f"shock.{name}: {{linspace: [2, 3, 41]}}" for name in _FIVE)
FAULTS = {
    "unknown-name": ("{grid: {|shock.duration_rati: [2, 4]}}", "grid.'shock.duration_rati'", "did you mean"),
    "name-without-block": ("{grid: {|rise_time: [1]}}", "grid.rise_time", "unknown key"),
    "range": ("{grid: {shock.rise_time: [1 us, |-2 us]}}", f"{TIME}[1]", "must be > 0 s"),
    "no-values": ("{grid: {shock.rise_time: |[]}}", TIME, "must be a list of 1 to"),
    "too-many": ("{grid: {shock.rise_time: {linspace: [1, 2, |10000001]}}}", f"{TIME}.linspace[2]", "<= 1e+06"),
    "spacing": ("{grid: {shock.rise_time: |{geomspace: [1, 2, 3]}}}", TIME, "{linspace:"),
    "through-zero": ("{grid: {predict.equal_tolerance: {logspace: |[0, 0.5, 3]}}}", f"{EQUAL}.logspace", "same sign"),
    "range-of-names": (
        "{grid: {chain.material: |{linspace: [lead, copper, 3]}}}",
        "grid.'chain.material'",
        "for numbers",
    ),
    "material": ("{grid: {chain.material: [copper, |leed]}}", "grid.'chain.material'[1]", "did you mean 'lead'"),
    "twice": ("{grid: {shock.rise_time: [1]}, zip: {|shock.rise_time: [2]}}", "zip.'shock.rise_time'", "varied once"),
    "lengths": ("{zip: |{shock.rise_time: [1, 2], shock.peak_force: [1]}}", "zip", "2 of shock.rise_time, 1 of"),
    "run": ("{run: |guess, grid: {shock.rise_time: [1]}}", "run", "'predict', 'simulate' or 'compare'"),
    "list": ("|[1]", "", "must be a mapping of run, grid, zip, points"),
    "other-point": ("{points: [{shock.rise_time: 1}, |{shock.peak_force: 1}]}", "points[1]", "as the first point"),
    "value-of-a-point": (
        "{points: [{shock.rise_time: 1}, {shock.rise_time: |-1}]}",
        "points[1].'shock.rise_time'",
        "must be > 0 s",
    ),
    "no-points": ("{points: |[]}", "points", "must be a list of mappings"),
    "1e7-points": (f"|{{grid: {{{MANY}}}}}", "", "got 115856201"),
    "1e15-points": (f"|{{grid: {{{MANY.replace('41', '9999')}}}}}", "", "1 to 1e+07 cases in all (got more than 1e15)"),
}


#: Faults that the schema sees.
SEEN = {"name-without-block", "run", "list", "no-points"}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_reported_at_their_place(tmp_path: Path, name: str) -> None:
    marked, path, part = FAULTS[name]
    text = f"{HEAD}sweep: {marked.replace('|', '')}\n"
    with pytest.raises(ScenarioError) as caught:
        load(tmp_path, text)
    fault = caught.value.faults[0]
    assert fault.location.endswith(f"scene.yaml:3:{len('sweep: ') + marked.index('|') + 1}")
    assert fault.path == ".".join(step for step in ("sweep", path) if step)
    assert part in fault.problem
    assert bool(schema_faults(text)) is (name in SEEN)


def test_all_faults_are_reported_together(tmp_path: Path) -> None:
    block = "{grid: {shock.rise_time: [1 m, 2 m], chain.radus: [1]}, zip: {predict.alpha: [wrong]}}"
    with pytest.raises(ScenarioError) as caught:
        load(tmp_path, f"{HEAD.replace('1 N', '-1 N')}sweep: {block}\n")
    assert [fault.path.partition(".")[0] for fault in caught.value.faults] == ["shock", *["sweep"] * 4]


def test_the_page_has_every_key_of_the_block() -> None:
    assert [row[0] for row in table("docs/scenarios.md", "sweep")] == [f"`{key.name}`" for key in SWEEP]


@pytest.mark.parametrize("order", [1, -1], ids=["before", "behind"])
def test_constants_of_a_material_may_be_varied_before_or_after_it(tmp_path: Path, order: int) -> None:
    names = ["chain.material: [lead, copper]", "chain.material.density: [5000, 6000]"][::order]
    head, block = HEAD.replace("material: copper, ", ""), f"{{grid: {{{', '.join(names)}}}}}"
    assert load(tmp_path, f"{head}sweep: {block}\n").chain.material.density == 5000
    materials = [scene.chain.material for scene in scenes(tmp_path, block, head)]
    moduli = [sw.material(name).youngs_modulus for name in ("lead", "copper")]
    assert {(material.density, material.youngs_modulus) for material in materials} == {*product((5000, 6000), moduli)}


def test_a_sweep_does_not_hide_errors_of_the_block_that_it_varies(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="simulate: must be a mapping"):
        load(tmp_path, f"{HEAD}simulate: fast\nsweep: {{grid: {{simulate.rtol: [1e-3]}}}}\n")


def test_too_many_values_are_refused_before_they_are_made(tmp_path: Path) -> None:
    names = [f"'chain.granules[{index}].diameter': {{linspace: [1 mm, 2 mm, 1000000]}}" for index in range(13)]
    granules = f"granules: [{', '.join(['{diameter: 1 mm}'] * 13)}]"
    head, block = HEAD.replace("radius: 1 mm", granules), f"{{grid: {{{', '.join(names)}}}}}"
    tracemalloc.start()
    try:
        with pytest.raises(ScenarioError, match=r"sweep: must have at most 1000000 values in all \(got 13000000\)"):
            swept(tmp_path, block, head)
        assert tracemalloc.get_traced_memory()[1] < 20e6  # bytes; one of the variables alone has 8 MB
    finally:
        tracemalloc.stop()


#: Errors of which each takes long to describe, in a file of 24 to 48 kB.
MANY_ERRORS = {
    "distributions": "requires: [" + ", ".join(f"no-such-distribution-{i}" for i in range(2500)) + "]",
    "spreads": "uncertainty: {" + ", ".join(f"chain.diamete{i}: {{sd: 1 um}}" for i in range(800)) + "}",
    "keys": "\n".join(f"unknown_{i}: 1" for i in range(3000)),
    "contacts": "simulate: {contacts: [" + ", ".join(str(i) for i in range(8000)) + "]}",
}


@pytest.mark.parametrize("text", MANY_ERRORS.values(), ids=MANY_ERRORS)
def test_many_errors_are_not_searched_again_at_every_point(tmp_path: Path, text: str) -> None:
    head = HEAD.replace("radius: 1 mm", "radius: 1 mm, granules: 9") + text + "\n"
    begin = time.process_time()
    with pytest.raises(ScenarioError, match="more errors"):
        swept(tmp_path, "{grid: {shock.rise_time: {linspace: [1 us, 2 us, 200]}}}", head)
    # several times what it takes; with a search at each of a hundred points it is at least 10 s
    assert time.process_time() - begin < 5
