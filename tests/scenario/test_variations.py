"""Scenes that differ from that of a scenario in values given by their dotted names."""

from pathlib import Path
from typing import Any

import attrs
import pytest
from test_sweep_block import HEAD

import shockwave as sw
from shockwave.base.errors import InvalidValueError, ScenarioError
from shockwave.scenario.dotted_names import variable
from shockwave.scenario.variations import Family
from support.scenario_texts import load

CHANGES: dict[str, dict[str, Any]] = {
    "rise-time": {"shock.rise_time": 7e-6},
    "duration": {"shock.duration": 8e-6},
    "force-and-radius": {"shock.peak_force": 30.0, "chain.radius": 2e-3},
    "diameter": {"chain.diameter": 5e-3},
    "granules": {"chain.granules": 40},
    "ratio": {"shock.duration_ratio": 5.0},
    "shape-and-time": {"shock.parameters.decay_exponent": 3.0, "shock.rise_time": 2e-6},
    "material": {"chain.material": "lead"},
    "settings": {"predict.alpha": "literal", "simulate.rtol": 1e-3, "predict.momentum_coefficient": "paper"},
}


def by_file(folder: Path, changes: dict[str, Any]) -> sw.Scenario:
    """The scene as the document of a sweep of one point has it."""
    head = HEAD
    for name, other in (("shock.duration", "rise_time: 1 us, "), ("chain.diameter", ", radius: 1 mm")):
        head = head.replace(other, "") if name in changes else head
    values = ", ".join(f"{name}: [{value}]" for name, value in changes.items())
    return load(folder, f"{head}sweep: {{zip: {{{values}}}}}\n" if changes else head)


def parts(scene: sw.Scenario) -> tuple[object, ...]:
    return scene.shock, scene.chain, scene.predictor, scene.simulate


@pytest.mark.parametrize("name", CHANGES)
def test_a_scene_of_a_family_is_that_of_a_file_of_its_own(tmp_path: Path, name: str) -> None:
    base, alone = by_file(tmp_path, {}), by_file(tmp_path, CHANGES[name])
    found = Family(base).scenario(CHANGES[name])
    assert parts(found) == parts(alone) != parts(base)


def test_with_both_times_a_sweep_of_one_changes_the_ratio(tmp_path: Path) -> None:
    base = load(tmp_path, HEAD.replace("duration_ratio: 2", "duration: 5 us"))
    shock = Family(base).scenario({"shock.rise_time": 2e-6}).shock
    assert (shock.rise_time, shock.profile.duration_ratio) == pytest.approx((2e-6, 2.5), rel=1e-15)


def test_values_of_a_material_of_the_library_make_one_without_a_name(tmp_path: Path) -> None:
    found = Family(by_file(tmp_path, {})).scenario({"chain.material.density": 5000.0}).chain.material
    assert (found.density, found.name, found.source) == (5000.0, "", "")
    copper = by_file(tmp_path, {}).chain.material
    assert (found.youngs_modulus, found.poisson_ratio) == (copper.youngs_modulus, copper.poisson_ratio)


@pytest.mark.parametrize("name", ["rise-time", "shape-and-time", "material", "settings"])
def test_a_scene_made_in_python_has_a_family(tmp_path: Path, name: str) -> None:
    read = by_file(tmp_path, {})
    made = attrs.evolve(read, path=None, document=None)
    changes = {key: value for key, value in CHANGES[name].items() if key != "predict.momentum_coefficient"}
    assert parts(Family(made).scenario(changes)) == parts(Family(read).scenario(changes))
    with pytest.raises(InvalidValueError, match="load a scenario from a file"):
        Family(made).scenario({"shock.profile": "triangular"})


@pytest.mark.parametrize("name", ["shock.rise_time", "shock.parameters.rise_exponent", "chain.radius"])
def test_values_out_of_range_are_refused_by_their_names(tmp_path: Path, name: str) -> None:
    with pytest.raises((InvalidValueError, ScenarioError)) as caught:
        Family(by_file(tmp_path, {})).scenario({name: -1.0})
    assert [fault.path for fault in caught.value.faults] == [name]


def test_a_variable_has_unit_and_range(tmp_path: Path) -> None:
    document = by_file(tmp_path, {}).document
    assert document is not None
    diameter = variable("chain.diameter", document.data)
    assert (diameter.unit, diameter.convert("5 mm")) == ("m", 0.005)
    assert variable("chain.material", document.data).unit is None
    with pytest.raises(ValueError, match=r"must be > 0 m"):
        diameter.convert(0)
    with pytest.raises(InvalidValueError, match=r"must be the dotted name of a key .* did you mean"):
        variable("chain.diametre", document.data)
