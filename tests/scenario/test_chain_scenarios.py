"""Scenarios of chains beyond equal spheres: keys, errors, schema, sweeps, hashes and what other commands refuse."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest
import yaml
from jsonschema import Draft7Validator

import shockwave as sw
from shockwave.base.errors import NotCoveredError, ScenarioError
from shockwave.cli import main
from shockwave.registry.registry import load
from shockwave.scenario.dotted_names import variables
from shockwave.scenario.loader import scenario_of
from shockwave.scenario.scene_hash import scene_hash
from shockwave.scenario.schema import schema
from shockwave.scenario.variations import Family
from shockwave.scenario.yaml_document import Document, parse_document
from shockwave.scene.description import plain
from shockwave.scene.layout import Layout
from support.pages import ROOT

TRUTH: dict[str, dict[str, Any]] = json.loads((ROOT / "tests" / "data" / "chains.json").read_text())
SHOCK = "shock: {profile: triangular, peak_force: 50 N, rise_time: 10 us, duration_ratio: 3}\n"
IMPACT = "impact: {velocity: 0.5 m/s}\n"
ENDLESS = f"chain: {{material: copper, radius: 1, %s}}\n{SHOCK}"
#: Every key.
WHOLE = """\
chain:
  material: stainless-steel-302
  diameter: 9.5 mm
  granules:
    - {count: 20}
    - {count: 10, material: ptfe, gap: 0 mm}
    - {count: 5, diameter: {from: 9.5 mm, to: 5 mm, spacing: geometric}}
    - {repeat: 3, cell: [{material: brass-260}, {diameter: 5 mm, count: 2}]}
    - {radius: {from: 1 mm, to: 2 mm}, count: 3, material: {youngs_modulus: 1 GPa, poisson_ratio: 0.3, density: 1e3}}
  end: {wall: same, mass: 2 kg, stiffness: 1e6 N/m, damping: 50 N*s/m}
  precompression: 2 N
  gravity: 9.81 m/s**2
  damping: {model: kuwabara-kono, time: 2 us}
  contact: {exponent: 1.5, stiffness: 1.0e7}
impact: {velocity: 0.5 m/s, diameter: 16 mm, material: stainless-steel-302}
simulate: {contacts: [0, 5, 20], until: 2 ms}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Callable[[str], sw.Scenario]:
    def made(text: str) -> sw.Scenario:
        path = tmp_path / "scene.yaml"
        path.write_text(text, encoding="utf-8")
        return sw.load_scenario(path)

    return made


def finite(more: str = "", excitation: str = SHOCK) -> str:
    """A scenario of four granules with further keys of its chain."""
    return f"chain: {{material: copper, radius: 1 mm, granules: [{{count: 4}}]{more}}}\n{excitation}"


Scene = Callable[[str], sw.Scenario]

# ---------------------------------------------------------------- keys


@pytest.mark.parametrize("name", TRUTH)
def test_reference_scenarios_are_read(scene: Scene, name: str) -> None:
    case = TRUTH[name]
    found = scene(case["scenario"])
    written = yaml.safe_load(case["scenario"])
    layout = Layout.of(found.chain, found.excitation)
    sizes = [part["diameter"] / 2 for part in written["chain"]["granules"] for _ in range(part["count"])]
    struck = [written["impact"]["diameter"] / 2] if "impact" in written else []
    assert layout.radii.tolist() == [*struck, *sizes]
    contacts = len(layout.masses) - ("transmitted" not in case)
    assert len(layout.pairs.stiffnesses) == contacts
    assert layout.static_forces.tolist() == [float(written["chain"].get("precompression", 0))] * contacts
    assert found.simulate.contacts == tuple(contact["contact"] for contact in case["contacts"])
    assert list(_validator().iter_errors(parse_document(case["scenario"], "scene").data)) == []


def _validator() -> Draft7Validator:
    return Draft7Validator(schema())


def test_every_key_has_its_meaning(scene: Scene) -> None:
    found = scene(WHOLE)
    steel, ptfe, brass = (load("materials", name) for name in ("stainless-steel-302", "ptfe", "brass-260"))
    soft = sw.Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1e3)
    assert found.chain == sw.Chain(
        material=steel,
        diameter=9.5e-3,
        granules=[
            sw.Segment(count=20),
            sw.Segment(count=10, material=ptfe),
            sw.Segment(count=5, diameter=sw.Taper(first=9.5e-3, last=5e-3, spacing="geometric")),
            sw.Cell(repeat=3, cell=[sw.Segment(material=brass), sw.Segment(diameter=5e-3, count=2)]),
            sw.Segment(count=3, radius=sw.Taper(first=1e-3, last=2e-3), material=soft),
        ],
        end=sw.Wall(mass=2.0, stiffness=1e6, damping=50.0),
        precompression=2.0,
        gravity=9.81,
        damping=sw.KuwabaraKono(time=2e-6),
        contact=sw.PowerContact(exponent=1.5, stiffness=1e7),
    )
    assert found.excitation == found.impact == sw.Impact(velocity=0.5, diameter=16e-3, material=steel)
    assert found.shock is None
    assert found.files == (found.path,)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("end: free", {"end": None}),
        ("end: {wall: rigid}", {"end": sw.Wall(material="rigid")}),
        ("end: {wall: ptfe}", {"end": sw.Wall(material=load("materials", "ptfe"))}),
        ("end: {wall: same, mass: 2 kg}", {"end": sw.Wall(mass=2.0)}),
        ("damping:", {"damping": None}),
        ("damping: {model: dashpot, coefficient: 6 N*s/m}", {"damping": sw.Dashpot(coefficient=6.0)}),
        ("damping: {model: tsuji, restitution: 90 %}", {"damping": sw.Tsuji(restitution=0.9)}),
        ("contact: {model: hertz}", {"contact": None}),
        (
            "contact: {model: power-law, exponent: 2, stiffness: 1e7}",
            {"contact": sw.PowerContact(exponent=2, stiffness=1e7)},
        ),
        ("precompression: 200 gf", {"precompression": 1.96133}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_further_features_are_read(scene: Scene, given: str, expected: dict[str, Any]) -> None:
    text = finite(f", {given}")
    chain = scene(text).chain
    assert {name: getattr(chain, name) for name in expected} == expected
    assert list(_validator().iter_errors(parse_document(text, "scene").data)) == []


def test_segments_are_written_as_they_are_read(scene: Scene) -> None:
    first = scene(WHOLE)
    assert first.impact is not None
    again = scene(json.dumps({"chain": plain(first.chain), "impact": plain(first.impact)}))
    assert (again.chain, again.impact) == (first.chain, first.impact)


# ---------------------------------------------------------------- errors

# text with a mark before the first fault, its path, a part of its problem
MARKED = {
    "unknown-key-of-a-segment": (
        "chain: {material: copper, radius: 1, granules: [{count: 2}, {|size: 1}]}\n" + SHOCK,
        "chain.granules[1].size", "unknown key (got 'size'; known: count, material, diameter, radius, gap)",
    ),
    "both-sizes": (finite(", damping: }").replace("count: 4", "diameter: 1, |radius: 1").replace(", damping: }", ""),
        "chain.granules[0].radius", "must be left out if diameter is given"),
    "taper-without-end": (finite().replace("count: 4", "count: 4, diameter: {from: 1 mm|}").replace("|", ""),
        "chain.granules[0].diameter.to", "must be given"),
    "taper-of-one": (finite().replace("count: 4", "count: |1, diameter: {from: 1 mm, to: 2 mm}"),
        "chain.granules[0].count", "must be >= 2 for a taper"),
    "unknown-material": (finite().replace("count: 4", "count: 4, material: |coper"),
        "chain.granules[0].material", "did you mean 'copper'?"),
    "wrong-unit": (finite().replace("count: 4", "count: 4, diameter: |2 kg"), "chain.granules[0].diameter", "a length"),
    "cell-without-repeat": (finite().replace("{count: 4}", "|{cell: [{count: 1}]}"),
        "chain.granules[0].repeat", "must be given"),
    "empty-cell": (finite().replace("{count: 4}", "{repeat: 2, cell: |[]}"), "chain.granules[0].cell", "one or more"),
    "error-in-a-cell": (finite().replace("{count: 4}", "{repeat: 2, cell: [{count: 1}, {count: |0}]}"),
        "chain.granules[0].cell[1].count", ">= 1"),
    "no-segment": (finite().replace("[{count: 4}]", "|[]"), "chain.granules", "one or more segments"),
    "nothing-as-a-segment": (finite().replace("[{count: 4}]", "[{count: 4}, |null]"),
        "chain.granules[1]", "must be a mapping of count, material, diameter, radius, gap (got nothing)"),
    "end-of-text": (finite(", end: |wall"),
        "chain.end", "must be free, or a mapping of wall, mass, stiffness, damping"),
    "free-end-with-stiffness": (finite(", |end: {stiffness: 1}"), "chain.end.wall", "must be given"),
    "stiff-fixed-wall": (finite(", end: {wall: same, stiffness: |1e6 N/m}"),
        "chain.end.stiffness", "must be left out for a fixed wall (got 1e+06; give the mass of the wall)"),
    "unknown-wall": (finite(", end: {wall: |rigidd}"), "chain.end.wall", "unknown material (got 'rigidd'"),
    "wall-of-an-endless-chain": (ENDLESS % "end: |{wall: same}",
        "chain.end", "must be left out for an endless chain (give the number of granules)"),
    "damped-endless-chain": (ENDLESS % "damping: |{model: dashpot, coefficient: 1}",
        "chain.damping", "endless"),
    "linear-endless-chain": (ENDLESS % "contact: {exponent: |1, stiffness: 1}",
        "chain.contact.exponent", "must be >= 1.05 and <= 6 for the waves of an endless chain"),
    "stiff-endless-chain": (ENDLESS % "contact: {exponent: |6.5, stiffness: 1}",
        "chain.contact.exponent", "(got 6.5; give the number of granules)"),
    "gravity-without-a-wall": (finite(", gravity: |9.81 m/s**2"), "chain.gravity", "give a wall as end"),
    "gap-under-precompression": (finite(", precompression: 1 N").replace("count: 4", "count: 4, gap: |1 um"),
        "chain.granules[0].gap", "must be 0 under precompression"),
    "unknown-damping": (finite(", damping: {model: |tsuij, restitution: 0.9}"),
        "chain.damping.model", "did you mean 'tsuji'"),
    "damping-without-model": (finite(", |damping: {time: 1 us}"), "chain.damping.model", "must be given"),
    "law-as-damping": (finite(", damping: {model: |hertz}"), "chain.damping.model",
        "must be kuwabara-kono, dashpot or tsuji (got 'hertz')"),
    "damping-as-law": (finite(", contact: {model: |dashpot, coefficient: 1}"), "chain.contact.model", "must be hertz"),
    "parameter-of-another-damping": (finite(", damping: {model: dashpot, coefficient: 1, |time: 1 us}"),
        "chain.damping.time", "unknown key (got 'time'; known: model, coefficient)"),
    "no-restitution": (finite(", damping: {model: tsuji, restitution: |0}"),
        "chain.damping.restitution", "> 0 and <= 1"),
    "tsuji-without-hertz": (
        finite(", damping: {model: |tsuji, restitution: 0.9}, contact: {exponent: 2, stiffness: 1}"),
        "chain.damping.model", "must be dashpot or kuwabara-kono for a contact exponent other than 1.5"),
    "contact-without-stiffness": (finite(", |contact: {exponent: 2}"), "chain.contact.stiffness", "must be given"),
    "shock-and-impact": (finite() + "|impact: {velocity: 1}\n", "impact", "must be left out if shock is given"),
    "neither": ("|" + finite("", ""), "shock", "must be given (got nothing; a mapping of profile"),
    "impact-without-velocity": (finite("", "|impact: {diameter: 1 mm}\n"), "impact.velocity", "must be given"),
    "impact-on-an-endless-chain": ("|chain: {material: copper, radius: 1}\n" + IMPACT,
        "chain.granules", "must be given, because a striker needs a finite chain"),
    "single-granule": (finite().replace("[{count: 4}]", "|[{count: 1}]"),
        "chain.granules", "must give a contact (got 1 granule; add granules, a wall or a striker)"),
    "single-granule-by-number": (finite().replace("[{count: 4}]", "|1"),
        "chain.granules", "must give a contact (got 1 granule; add granules, a wall or a striker)"),
    "contact-beyond-the-wall": (finite(", end: {wall: same}") + "simulate: {contacts: [3, |4]}\n",
        "simulate.contacts[1]", "must be at most 3, the last contact of this chain (got 4)"),
    "integrator-of-equal-granules": (finite(", end: {wall: same}") + "simulate: {integrator: |verlet}\n",
        "simulate.integrator", "must be rkn64, rkn86, rkn1210 or dop853 for a chain other than equal"),
    "integrator-of-equal-granules-by-number": (finite() + "simulate: {integrator: |verlet}\n",
        "simulate.integrator", "for a chain other than equal granules, given by their number, with free ends"),
    "contact-as-text": (finite(", contact: |hertz"), "chain.contact", "must be a mapping such as {model: hertz}"),
    "damping-as-text": (finite(", damping: |tsuji"), "chain.damping", "a mapping such as {model: kuwabara-kono}"),
    "contact-without-name": (finite(", contact: {model:| }"), "chain.contact.model", "must be text (got nothing)"),
    "list-as-model": (finite(", contact: {model: |[hertz]}"), "chain.contact.model", "must be text (got ['hertz'])"),
    "contact-as-text-beyond-the-wall": (finite(", end: {wall: same}") + "simulate: {contacts: ['3', |'4']}\n",
        "simulate.contacts[1]", "must be at most 3, the last contact of this chain (got 4)"),
    "integrator-without-damping": (finite(", damping: {model: dashpot, coefficient: 1}")
        + "simulate: {integrator: |rkn86}\n", "simulate.integrator", "must be dop853 for a chain with damping"),
    "integrator-without-damping-of-a-wall": (finite(", end: {wall: same, mass: 2 kg, damping: 50 N*s/m}")
        + "simulate: {integrator: |rkn86}\n", "simulate.integrator", "must be dop853 for a chain with damping"),
    "unit-of-a-stiffness": (finite(", contact: {exponent: 2, stiffness: |5e7 N/m}"),
        "chain.contact.stiffness", "must be a bare number, in N/m^p (got '5e7 N/m')"),
    "interval-without-record": (finite() + "simulate: {interval: |1 us}\n",
        "simulate.interval", "must be left out without record (got 1e-06 s; list what to record)"),
    "too-many": (finite(", end: {wall: same}").replace("[{count: 4}]", "|5000000"),
        "chain.granules", "must be <= 1000000 for a chain with end"),
    "weightless": (finite().replace("count: 4", "count: 4, diameter: |1e-200"),
        "chain.granules[0].diameter", ">= 1e-12"),
    "sweep-of-a-missing-segment": (finite() + "sweep: {grid: {|'chain.granules[3].radius': [1, 2]}}\n",
        "sweep.grid.'chain.granules[3].radius'", "did you mean 'chain.granules[0].radius'?"),
}  # fmt: skip
#: Errors on several values and missing keys, which a schema does not see.
UNSEEN = {
    "both-sizes", "taper-without-end", "cell-without-repeat", "free-end-with-stiffness", "damping-without-model",
    "contact-without-stiffness", "shock-and-impact", "neither", "impact-without-velocity",
    "stiff-fixed-wall", "taper-of-one", "wall-of-an-endless-chain", "damped-endless-chain",
    "linear-endless-chain", "stiff-endless-chain",
    "gravity-without-a-wall", "gap-under-precompression", "tsuji-without-hertz",
    "impact-on-an-endless-chain", "single-granule", "single-granule-by-number", "too-many",
    "sweep-of-a-missing-segment", "contact-beyond-the-wall", "integrator-of-equal-granules",
    "integrator-of-equal-granules-by-number", "contact-as-text-beyond-the-wall",
    "integrator-without-damping",
    "integrator-without-damping-of-a-wall", "unit-of-a-stiffness", "interval-without-record",
    "wrong-unit",
}  # fmt: skip


@pytest.mark.parametrize("name", MARKED)
def test_a_wrong_scenario_is_refused_in_its_place(scene: Scene, tmp_path: Path, name: str) -> None:
    marked, where, part = MARKED[name]
    text = marked.replace("|", "")
    with pytest.raises(ScenarioError) as caught:
        scene(text)
    first = str(caught.value).split("\n")[0]
    assert f": {where}: " in first
    assert part in first
    if "|" in marked:
        before = marked.partition("|")[0]
        place = f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"
        assert first.startswith(f"{tmp_path / 'scene.yaml'}:{place}: ")
    assert (list(_validator().iter_errors(parse_document(text, "scene").data)) == []) is (name in UNSEEN)


@pytest.mark.parametrize(
    ("block", "message"),
    [
        ("contact: {law: hertz}", "unknown key (got 'law'; known: model, exponent, stiffness)"),
        (
            "contact: {}",
            "exponent: must be given (got nothing; exponent p of F = k d^p, >= 1 and <= 10; or give model)",
        ),
    ],
    ids=["law", "nothing"],
)
def test_a_contact_law_without_a_name_lists_the_key_of_the_name(scene: Scene, block: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        scene(finite(f", {block}"))
    assert message in str(caught.value)


def test_a_damping_without_a_name_has_one_error(scene: Scene) -> None:
    with pytest.raises(ScenarioError) as caught:
        scene(finite(", damping: {time: 1 us}"))
    assert [fault.path for fault in caught.value.faults] == ["chain.damping.model"]


#: Values whose powers are no floating-point numbers.
BEYOND_FLOATS = {
    "modulus": ("material: {youngs_modulus: 1e160, poisson_ratio: 0.3, density: 8e3, yield_strength: 5e8}", "", ""),
    "strength": ("material: {youngs_modulus: 1e11, poisson_ratio: 0.3, density: 8e3, yield_strength: 1e200}", "", ""),
    "wall": ("material: copper", ", end: {wall: same, mass: 1.7e308}", ""),
    "gap": ("material: copper", "", "gap: 1.7e308"),
    "damping": ("material: copper", ", damping: {model: kuwabara-kono, time: 1e300}", ""),
    "contact": ("material: copper", ", contact: {exponent: 2, stiffness: 1e-320}", ""),
}


@pytest.mark.parametrize("name", BEYOND_FLOATS)
def test_values_beyond_floating_point_numbers_are_refused(scene: Scene, name: str) -> None:
    material, chain, segment = BEYOND_FLOATS[name]
    granules = f"[{{count: 4, {segment}}}]" if segment else "[{count: 4}]"
    with pytest.raises(ScenarioError, match=r"must be >= .* and <= 1e\+"):
        scene(f"chain: {{{material}, radius: 1 mm, granules: {granules}{chain}}}\n{SHOCK}")


def test_contacts_are_numbers_or_text(scene: Scene) -> None:
    found = scene(finite(", end: {wall: same}") + "simulate: {contacts: ['3', 1]}\n")
    assert found.simulate.contacts == (1, 3)


def test_all_errors_are_reported_together(scene: Scene) -> None:
    with pytest.raises(ScenarioError) as caught:
        scene(
            "chain:\n"
            "  material: copper\n"
            "  diameter: 1 kg\n"
            "  granules:\n"
            "    - {count: 0, material: no}\n"
            "    - {repeat: 2, cell: [{gap: -1}]}\n"
            "  end: {wall: no, mass: 0}\n"
            "  precompression: -1\n"
            "  damping: {model: tsuji}\n"
            "impact: {velocity: 1 m, size: 2}\n"
        )
    assert [fault.path for fault in caught.value.faults] == [
        "chain.diameter",
        "chain.granules[0].count",
        "chain.granules[0].material",
        "chain.granules[1].cell[0].gap",
        "chain.end.wall",
        "chain.end.mass",
        "chain.precompression",
        "chain.damping.restitution",
        "impact.velocity",
        "impact.size",
    ]


# ---------------------------------------------------------------- sweeps, families, uncertainty

VALUES: dict[str, tuple[Any, Callable[[sw.Scenario], Any]]] = {
    "chain.granules[1].diameter": (8e-3, lambda scene: 2 * scene.chain.granules[1].radius),
    "chain.granules[0].count": (7, lambda scene: scene.chain.granules[0].count),
    "chain.granules[2].diameter.to": (4e-3, lambda scene: 2 * scene.chain.granules[2].radius.last),
    "chain.granules[3].repeat": (5, lambda scene: scene.chain.granules[3].repeat),
    "chain.granules[3].cell[1].diameter": (2e-3, lambda scene: 2 * scene.chain.granules[3].cell[1].radius),
    "chain.granules[1].material.density": (999.0, lambda scene: scene.chain.granules[1].material.density),
    "chain.granules[0].material.density": (999.0, lambda scene: scene.chain.granules[0].material.density),
    "chain.end.mass": (3.0, lambda scene: scene.chain.end.mass),
    "chain.damping.time": (1e-6, lambda scene: scene.chain.damping.time),
    "chain.contact.stiffness": (2e7, lambda scene: scene.chain.contact.stiffness),
    "chain.precompression": (3.0, lambda scene: scene.chain.precompression),
    "chain.gravity": (1.0, lambda scene: scene.chain.gravity),
    "chain.diameter": (5e-3, lambda scene: 2 * scene.chain.radius),
    "impact.velocity": (2.0, lambda scene: scene.impact.velocity),
    "impact.diameter": (5e-3, lambda scene: 2 * scene.impact.radius),
}


@pytest.mark.parametrize("name", VALUES)
def test_values_have_dotted_names(scene: Scene, name: str) -> None:
    value, of = VALUES[name]
    base = scene(WHOLE)
    assert base.document is not None
    assert name in variables(base.document.data)
    assert of(Family(base).scenario({name: value})) == pytest.approx(value, rel=1e-15)


def test_features_made_in_python_have_no_names(scene: Scene) -> None:
    base = attrs.evolve(scene(WHOLE), document=None)
    with pytest.raises(sw.InvalidValueError, match="must be values of a scenario file"):
        Family(base).scenario({"chain.end.mass": 3.0})


def test_materials_have_dotted_names(scene: Scene) -> None:
    base = Family(scene(WHOLE))
    other = base.scenario({"chain.granules[0].material": "ptfe", "chain.granules[0].material.density": 1e3}).chain
    assert other.granules[0].material == sw.Material(  # type: ignore[index,union-attr]
        **{**_constants("ptfe"), "density": 1e3}, name="", source=""
    )
    assert base.scenario({"chain.end.wall": "rigid"}).chain.end == sw.Wall(
        material="rigid", mass=2.0, stiffness=1e6, damping=50.0
    )
    with pytest.raises(ScenarioError, match=r": chain\.end\.mass: must be >= 1e-30 and <= 1e\+30 kg"):
        base.scenario({"chain.end.mass": 0.0})


def _constants(name: str) -> dict[str, float]:
    material = load("materials", name)
    return {key: getattr(material, key) for key in ("youngs_modulus", "poisson_ratio", "density")}


SWEEP = """\
sweep:
  run: simulate
  grid:
    chain.granules[1].diameter: [8 mm, {half}]
    chain.end.wall: [same, rigid, ptfe]
  zip:
    chain.damping.time: [1 us, 2 us]
    impact.velocity: {{linspace: [0.5 m/s, 1 m/s, 2]}}
"""


def test_a_sweep_varies_features(scene: Scene) -> None:
    found = scene(WHOLE + SWEEP.format(half="0.4 cm"))
    assert found.sweep is not None
    assert found.sweep.shape == (2, 3, 2)
    assert list(_validator().iter_errors(parse_document(WHOLE + SWEEP.format(half="4 mm"), "scene").data)) == []
    # the scene of the document is that of the first point
    assert found.chain == Family(found).scenario(found.sweep.point(0)).chain
    last = Family(found).scenario(found.sweep.point(11))
    assert last.chain.granules[1].radius == 2e-3  # type: ignore[index,union-attr]
    assert last.chain.end is not None
    assert (last.chain.end.material, last.impact) == (load("materials", "ptfe"), sw.Impact(
        velocity=1.0, diameter=16e-3, material=load("materials", "stainless-steel-302")
    ))  # fmt: skip


def test_a_sweep_may_fill_in_what_is_missing(scene: Scene) -> None:
    text = finite(", damping: {model: dashpot}") + "sweep: {grid: {chain.damping.coefficient: [1, 2]}}"
    assert scene(text).chain.damping == sw.Dashpot(coefficient=1.0)
    assert list(_validator().iter_errors(parse_document(text, "scene").data)) == []


def test_a_sweep_of_chains_measures_forces_at_contacts(scene: Scene, tmp_path: Path) -> None:
    text = finite(", end: {wall: same}") + (
        "simulate: {contacts: [1], rtol: 1e-4}\n"
        "sweep: {run: compare, grid: {chain.end.wall: [same, rigid], 'chain.granules[0].count': [3, 4]}}\n"
    )
    report = sw.run_sweep(scene(text), tmp_path / "out", workers=1)
    assert (report.done, report.failed) == (4, 0)
    results = sw.load_sweep(tmp_path / "out")
    points = [sw.simulate(one.shock, one.chain, rtol=1e-4, contacts=[1]) for one in _points(scene(text))]
    expected = [
        (one.greatest_force.peak_force, one.contacts[0].peak_force, one.transmitted.peak_force) for one in points
    ]  # type: ignore[union-attr]
    columns = [results.values(name).ravel() for name in ("greatest_force", "force_1", "transmitted_force")]
    assert np.array(columns).T.tolist() == [pytest.approx(row, rel=1e-12) for row in expected]
    # a sweep could leave out what varies, but no point of this one does
    assert np.isnan(results.values("section4_peak_force")).all()


@pytest.mark.parametrize("excitation", [SHOCK, IMPACT], ids=["shock", "striker"])
def test_a_sweep_of_chains_predicts_forces_at_contacts(scene: Scene, tmp_path: Path, excitation: str) -> None:
    text = finite(", end: {wall: same}", excitation) + (
        "simulate: {contacts: [1], rtol: 1e-4}\n"
        "sweep: {run: predict, grid: {chain.end.wall: [same, rigid], 'chain.granules[0].count': [3, 4]}}\n"
    )
    report = sw.run_sweep(scene(text), tmp_path / "out", workers=1)
    assert (report.done, report.failed) == (4, 0)
    results = sw.load_sweep(tmp_path / "out")
    columns = [results.values(name).ravel() for name in ("greatest_force", "force_1", "transmitted_force")]
    for index, one in enumerate(_points(scene(text))):
        outcome = sw.predict(one.excitation, one.chain, rtol=1e-4, contacts=[1])
        forces = [outcome.greatest_force, outcome.contacts[0], outcome.transmitted]
        assert [column[index] for column in columns] == pytest.approx([each.peak_force for each in forces], rel=1e-12)  # type: ignore[union-attr]


def _points(base: sw.Scenario) -> list[sw.Scenario]:
    assert base.sweep is not None
    return [Family(base).scenario(base.sweep.point(index)) for index in range(len(base.sweep))]


def test_features_have_uncertainties(scene: Scene) -> None:
    block = (
        "uncertainty:\n"
        "  chain.granules[1].diameter: 5 %\n"
        "  chain.damping.time: {factor: 1.5}\n"
        "  impact.velocity: {between: [0.4 m/s, 0.6 m/s]}\n"
        "  chain.precompression: {sd: 0.1 N}\n"
    )
    assert [spread.name for spread in scene(WHOLE + block).uncertainty] == [
        "chain.granules[1].diameter", "chain.damping.time", "impact.velocity", "chain.precompression",
    ]  # fmt: skip
    with pytest.raises(ScenarioError, match=r"'chain\.granules\[0\]\.count': must be a continuous value"):
        scene(WHOLE + "uncertainty: {'chain.granules[0].count': 5 %}\n")
    both = "{'chain.granules[1].diameter': 5 %, 'chain.granules[1].radius': 5 %}"
    with pytest.raises(ScenarioError, match=r"must be left out if chain\.granules\[1\]\.radius is given"):
        scene(WHOLE + f"uncertainty: {both}\n")


# ---------------------------------------------------------------- hash and summary


def test_the_hash_is_that_of_the_scene(scene: Scene) -> None:
    whole = scene_hash(scene(WHOLE))
    assert whole == scene_hash(scene(WHOLE.replace("2 us", "2000 ns").replace("diameter: 16 mm", "radius: 8e-3")))
    for old, new in (
        ("2 us", "3 us"),
        ("count: 20", "count: 21"),
        ("0.5 m/s", "0.6 m/s"),
        ("wall: same", "wall: rigid"),
    ):
        assert scene_hash(scene(WHOLE.replace(old, new))) != whole
    equal = finite()
    assert scene_hash(scene(equal)) == scene_hash(scene(equal.replace("[{count: 4}]", "4")))


def test_the_summary_lists_every_feature(scene: Scene) -> None:
    found = scene(WHOLE)
    summary = found.scene.summary()
    assert summary.to_dict()["chain"] == plain(found.chain)
    assert summary.granules == 20 + 10 + 5 + 9 + 3
    facts = dict(summary.facts())
    assert facts["impact"] == "velocity 500 mm/s, radius 8 mm, material stainless-steel-302"
    assert facts["end"] == "wall same, mass 2 kg, stiffness 1 MN/m, damping 50 N*s/m"
    assert facts["damping"] == "kuwabara-kono, time 2 us"


# ---------------------------------------------------------------- what equal granules alone are for


@pytest.mark.parametrize("command", ["predict --model section-4", "curve"])
def test_commands_for_equal_granules_refuse_other_chains(
    scene: Scene, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    path = str(scene(finite(", end: {wall: same, mass: 1 kg}")).path)
    assert main([*command.split(), path]) == 3
    out, error = capsys.readouterr()
    assert error.startswith(f"{path}:1:65: chain.end: must be left out for ")
    assert error.endswith("which covers only shocks on chains of equal granules with free ends (got a wall)\n")
    assert out == ""


@pytest.mark.parametrize(
    ("more", "excitation", "reason"),
    [
        (", end: {wall: same, mass: 1 kg}", SHOCK, "chain.end (a wall)"),
        (", damping: {model: dashpot, coefficient: 1}", SHOCK, "chain.damping (damping)"),
        ("", IMPACT, "impact (a striker)"),
    ],
    ids=["wall", "damping", "striker"],
)
def test_predict_answers_for_chains_that_section_4_does_not_cover(
    scene: Scene, capsys: pytest.CaptureFixture[str], more: str, excitation: str, reason: str
) -> None:
    found = scene(finite(more, excitation))
    assert main(["predict", str(found.path)]) == 0
    text = capsys.readouterr().out
    assert text.startswith("scene: force on the wall " if "wall" in more else "scene: greatest force ")
    assert f"  section 4         does not apply, because of {reason}\n" in text
    assert main(["predict", "--json", str(found.path)]) == 0
    document = json.loads(capsys.readouterr().out)
    known = sw.simulate(found).to_dict()
    assert document["greatest_force"] == known["greatest_force"] is not None
    assert (document["section4"], document["method"]) == (None, "simulation")
    place = "1:" if more else "2:1"
    assert document["section4_reason"].startswith(f"{found.path}:{place}")


def test_a_refusal_names_all_features(scene: Scene) -> None:
    scenario = scene(WHOLE)
    with pytest.raises(NotCoveredError) as caught:
        scenario.scene.covered("a test")
    faults = map(scenario.scene.placed, caught.value.faults)
    assert [(fault.path, fault.location.rpartition("scene.yaml")[2]) for fault in faults] == [
        ("chain.granules[1]", ":6:7"),
        ("chain.end", ":10:3"),
        ("chain.precompression", ":11:3"),
        ("chain.gravity", ":12:3"),
        ("chain.damping", ":13:3"),
        ("chain.contact", ":14:3"),
        ("impact", ":15:1"),
    ]


def test_segments_of_equal_granules_keep_their_commands(scene: Scene, capsys: pytest.CaptureFixture[str]) -> None:
    answers = []
    for text in (finite(), finite().replace("[{count: 4}]", "4")):
        assert main(["predict", "--json", str(scene(text).path)]) == 0
        answers.append(json.loads(capsys.readouterr().out))
    assert answers[0] == answers[1]


def test_contact_laws_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "contacts", "--json"]) == 0
    names = [row["name"] for row in json.loads(capsys.readouterr().out)]
    assert names[:5] == ["hertz", "power-law", "kuwabara-kono", "dashpot", "tsuji"]


_VALUES = [
    *(None, {}, [], 0, 1, 2.0, 0.5, -1, True, "", "same", "rigid", "free", "ptfe", "hertz", "tsuji", "dashpot", "5 %"),
    *("1 mm", "2 kg", "3 m/s", [{"count": 2}], {"wall": "same"}, {"from": 1, "to": 2}, {"repeat": 2, "cell": [{}]}),
    *({"model": "dashpot", "coefficient": 1}, {"exponent": 2, "stiffness": 1}, {"count": 3, "gap": 0}),
    {"youngs_modulus": 1e9, "poisson_ratio": 0.3, "density": 1e3},
]


def test_the_schema_accepts_what_the_loader_accepts() -> None:
    draw, validator, admitted = random.Random(0), _validator(), 0
    document = parse_document(WHOLE, "scene")
    paths = [path for path in document.values if path]
    for _ in range(1000):
        changes = {draw.choice(paths): draw.choice(_VALUES) for _ in range(draw.choice([1, 1, 2]))}
        data = document.having(changes).data
        try:
            scenario_of(Document("scene", data), None)
        except sw.ShockwaveError:
            continue
        assert list(validator.iter_errors(data)) == [], changes
        admitted += 1
    assert admitted > 30
