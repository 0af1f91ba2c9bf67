"""The library of materials."""

from __future__ import annotations

import re
from typing import Any

import pytest
from attrs import evolve

import shockwave as sw
from shockwave.registry import built_ins
from shockwave.registry.registry import load
from shockwave.scene import material_library as library
from shockwave.scene.material import Material
from shockwave.scene.plausibility import unusual
from support.scenes import CASE_A, CHAIN

ENTRIES = {entry.name: entry for entry in built_ins.ENTRIES["materials"]}
MATERIALS: dict[str, Material] = {name: load("materials", name) for name in ENTRIES}
# Materials whose modulus depends on strain rate: the source must say so.
POLYMERS = ("ptfe", "nylon-66", "delrin", "pmma", "polycarbonate", "homalite-100")


def test_beads_of_the_paper() -> None:
    beads = library.PAPER_STEEL
    assert (beads.youngs_modulus, beads.poisson_ratio, beads.density) == (193e9, 0.3, 7958.0)
    assert ENTRIES["paper-steel"].summary == "E 193 GPa, nu 0.30, 7958 kg/m^3, no yield strength"
    assert MATERIALS["paper-steel"] is beads


@pytest.mark.parametrize("name", ENTRIES)
def test_values_are_plausible_and_have_a_source(name: str) -> None:
    material = MATERIALS[name]
    assert material.name == name
    assert 0.1e9 <= material.youngs_modulus <= 800e9
    assert 0 < material.poisson_ratio < 0.5
    assert 800 <= material.density <= 20000
    # A thin rod carries sound at 0.5 to 15 km/s: a slip of a power of ten in E or in the density shows here.
    assert 500 <= (material.youngs_modulus / material.density) ** 0.5 <= 15000
    assert len(material.source.strip()) >= 15
    assert name not in POLYMERS or re.search("strain rate|dynamic", material.source)
    assert unusual(CASE_A, evolve(CHAIN, material=material)) == []


def test_every_yield_strength_states_its_source() -> None:
    strengths = {name: each.yield_strength for name, each in MATERIALS.items() if each.yield_strength is not None}
    assert len(strengths) >= 10
    assert [
        name for name in MATERIALS if name not in strengths and "no yield strength" not in MATERIALS[name].source
    ] == []
    for name, strength in strengths.items():
        assert "yield strength of" in MATERIALS[name].source
        # metals and polymers yield at strains of 1e-4 to 3e-2: a slip of a power of ten shows here
        assert 1e-4 < strength / MATERIALS[name].youngs_modulus < 3e-2


@pytest.mark.parametrize(
    ("part", "values"),
    [(sw.Chain, {"radius": 1e-3}), (sw.Segment, {}), (sw.Impact, {"velocity": 1.0}), (sw.Wall, {})],
    ids=["chain", "segment", "striker", "wall"],
)
def test_a_name_stands_for_its_material(part: Any, values: dict[str, float]) -> None:
    assert part(material="PTFE", **values) == part(material=sw.material("ptfe"), **values)
    with pytest.raises(sw.UnknownNameError, match="did you mean 'ptfe'"):
        part(material="ptfee", **values)
    with pytest.raises(sw.InvalidValueError, match=r"material: must be .*the name of one \(got 3\)"):
        part(material=3, **values)


def test_a_part_of_a_name_proposes_all_names_with_it_at_its_place() -> None:
    with pytest.raises(sw.UnknownNameError, match=r"^material: .*did you mean 'bearing-steel-52100', "):
        evolve(CHAIN, material="steel")


@pytest.mark.parametrize(
    ("name", "proposal"),
    [
        ("aluminum", "aluminium-6061-t6"),
        ("aluminum-6061", "aluminium-6061-t6"),
        ("steel-302", "stainless-steel-302"),
        ("52100", "bearing-steel-52100"),
        ("teflon", "ptfe"),
        ("acetal", "delrin"),
        ("POM", "delrin"),
    ],
)
def test_usual_names_lead_to_those_of_the_library(name: str, proposal: str) -> None:
    file = f"chain: {{material: {name}, diameter: 9 mm}}\nimpact: {{velocity: 1 m/s}}"
    with pytest.raises(sw.ScenarioError, match=rf"unknown material \(got '{name}'; did you mean '{proposal}'"):
        sw.Scenario.from_yaml(file)


def test_materials_are_listed_in_alphabetical_order_and_others_are_stated_by_values() -> None:
    assert [*ENTRIES] == sorted(ENTRIES)
    with pytest.raises(sw.UnknownNameError, match=r"others by values such as youngs_modulus"):
        sw.material("rubber")
