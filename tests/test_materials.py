"""The library of materials and what is registered of it."""

from __future__ import annotations

import attrs
import pytest

from shockwave.chain import library
from shockwave.chain.material import Material
from shockwave.hooks import Entry
from shockwave.registry import entries, load

ENTRIES = [entry for entry in entries("materials") if entry.distribution == "granular-shockwave"]
DEFINED = {key: value for key, value in vars(library).items() if isinstance(value, Material)}

# Materials whose modulus depends on strain rate: the source must say so.
POLYMERS = ("ptfe", "nylon-66", "delrin", "pmma", "polycarbonate", "homalite-100")


def _material(name: str) -> Material:
    material = load("materials", name)
    assert isinstance(material, Material)
    return material


def test_every_material_of_the_library_is_registered_once_in_the_order_of_the_library() -> None:
    assert len({entry.name for entry in ENTRIES}) == len(ENTRIES)
    assert [entry.address for entry in ENTRIES] == [f"shockwave.chain.library:{key}" for key in DEFINED]


def test_the_library_exports_what_it_defines() -> None:
    assert sorted(library.__all__) == library.__all__
    assert set(library.__all__) == set(DEFINED)


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
def test_entry_matches_the_material_it_names(entry: Entry) -> None:
    material = _material(entry.name)
    gigapascals = material.youngs_modulus / 1e9
    assert material.name == entry.name
    assert entry.address.endswith(":" + entry.name.upper().replace("-", "_"))
    assert entry.summary == f"E {gigapascals:g} GPa, nu {material.poisson_ratio:.2f}, {material.density:g} kg/m^3"


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
def test_figures_are_plausible_and_have_a_source(entry: Entry) -> None:
    material = _material(entry.name)
    assert 0.1e9 <= material.youngs_modulus <= 800e9
    assert 0 < material.poisson_ratio < 0.5
    assert 800 <= material.density <= 20000
    # A thin rod carries sound at 0.5 to 15 km/s: a slip of a power of ten in E or in the density shows here.
    assert 500 <= (material.youngs_modulus / material.density) ** 0.5 <= 15000
    assert len(material.source.strip()) >= 15
    assert "  " not in material.source


@pytest.mark.parametrize("name", POLYMERS)
def test_polymers_tell_that_the_modulus_depends_on_the_rate(name: str) -> None:
    source = _material(name).source
    assert "strain rate" in source or "dynamic" in source
    assert "GPa" in source


def test_beads_of_the_paper() -> None:
    beads = library.PAPER_STEEL
    assert (beads.youngs_modulus, beads.poisson_ratio, beads.density) == (193e9, 0.3, 7958.0)


def test_library_materials_cannot_be_changed() -> None:
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        library.COPPER.density = 1.0  # type: ignore[misc]
