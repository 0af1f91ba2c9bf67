"""Blocks of chains beyond equal spheres: keys, dotted names, and what commands for equal spheres refuse."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave.base.errors import NotCoveredError, ScenarioError
from shockwave.cli import main
from shockwave.scenario.dotted_names import variables
from shockwave.scenario.scene_hash import scene_hash
from shockwave.scenario.variations import Family
from shockwave.scene.description import plain
from support.scenario_texts import EVERY_FEATURE, IMPACT, SHOCK, finite, load, schema_faults

STEEL, PTFE, BRASS = (sw.material(name) for name in ("stainless-steel-302", "ptfe", "brass-260"))


@pytest.fixture
def whole(tmp_path: Path) -> sw.Scenario:
    """A scenario with every key."""
    return load(tmp_path, EVERY_FEATURE)


# ---------------------------------------------------------------- keys


def test_every_key_has_its_meaning(whole: sw.Scenario) -> None:
    soft = sw.Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1e3)
    assert whole.chain == sw.Chain(
        material=STEEL,
        diameter=9.5e-3,
        granules=[
            sw.Segment(count=20),
            sw.Segment(count=10, material=PTFE),
            sw.Segment(count=5, diameter=sw.Taper(first=9.5e-3, last=5e-3, spacing="geometric")),
            sw.Cell(repeat=3, cell=[sw.Segment(material=BRASS), sw.Segment(diameter=5e-3, count=2)]),
            sw.Segment(count=3, radius=sw.Taper(first=1e-3, last=2e-3), material=soft),
        ],
        end=sw.Wall(mass=2.0, stiffness=1e6, damping=50.0),
        precompression=2.0,
        gravity=9.81,
        damping=sw.KuwabaraKono(time=2e-6),
        contact=sw.PowerContact(exponent=1.5, stiffness=1e7),
    )
    assert whole.excitation == whole.impact == sw.Impact(velocity=0.5, diameter=16e-3, material=STEEL)
    assert (whole.shock, whole.simulate.contacts, whole.files) == (None, (0, 5, 20), (whole.path,))
    assert schema_faults(EVERY_FEATURE) == []


FEATURES: dict[str, Any] = {
    "end: free": None,
    "end: {wall: rigid}": sw.Wall(material="rigid"),
    "end: {wall: ptfe}": sw.Wall(material=PTFE),
    "damping:": None,
    "damping: {model: dashpot, coefficient: 6 N*s/m}": sw.Dashpot(coefficient=6.0),
    "damping: {model: tsuji, restitution: 90 %}": sw.Tsuji(restitution=0.9),
    "contact: {model: hertz}": None,
    "contact: {model: power-law, exponent: 2, stiffness: 1e7}": sw.PowerContact(exponent=2, stiffness=1e7),
    "precompression: 200 gf": 1.96133,
}


@pytest.mark.parametrize("text", FEATURES)
def test_further_features_are_read(tmp_path: Path, text: str) -> None:
    assert getattr(load(tmp_path, finite(f", {text}")).chain, text.partition(":")[0]) == FEATURES[text]
    assert schema_faults(finite(f", {text}")) == []


def test_segments_are_written_as_they_are_read(tmp_path: Path, whole: sw.Scenario) -> None:
    again = load(tmp_path, json.dumps({"chain": plain(whole.chain), "impact": plain(whole.excitation)}))
    assert (again.chain, again.impact) == (whole.chain, whole.impact)


def test_contacts_are_numbers_or_text(tmp_path: Path) -> None:
    scene = load(tmp_path, finite(", end: {wall: same}") + "simulate: {contacts: ['3', 1]}\n")
    assert scene.simulate.contacts == (1, 3)


# ---------------------------------------------------------------- sweeps and uncertainty

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
    "chain.diameter": (5e-3, lambda scene: 2 * scene.chain.radius),
    "impact.velocity": (2.0, lambda scene: scene.impact.velocity),
    "impact.diameter": (5e-3, lambda scene: 2 * scene.impact.radius),
}


@pytest.mark.parametrize("name", VALUES)
def test_values_have_dotted_names(whole: sw.Scenario, name: str) -> None:
    value, of = VALUES[name]
    assert whole.document is not None
    assert name in variables(whole.document.data)
    assert of(Family(whole).scenario({name: value})) == pytest.approx(value, rel=1e-15)


def test_features_made_in_python_have_no_names(whole: sw.Scenario) -> None:
    with pytest.raises(sw.InvalidValueError, match="must be values of a scenario file") as caught:
        Family(attrs.evolve(whole, document=None)).scenario({"chain.end.mass": 3.0, "chain.damping.time": 1e-6})
    assert [fault.path for fault in caught.value.faults] == ["chain.end.mass", "chain.damping.time"]


def test_materials_have_dotted_names(whole: sw.Scenario) -> None:
    base = Family(whole)
    other = base.scenario({"chain.granules[0].material": "ptfe", "chain.granules[0].material.density": 1e3}).chain
    assert other.granules[0].material == attrs.evolve(PTFE, density=1e3, name="", source="")  # type: ignore[index,union-attr]
    rigid = base.scenario({"chain.end.wall": "rigid"}).chain.end
    assert rigid == sw.Wall(material="rigid", mass=2.0, stiffness=1e6, damping=50.0)
    with pytest.raises(ScenarioError, match=r": chain\.end\.mass: must be >= 1e-30 and <= 1e\+30 kg"):
        base.scenario({"chain.end.mass": 0.0})


SWEEP = """\
sweep:
  run: simulate
  grid:
    chain.granules[1].diameter: [8 mm, 0.4 cm]
    chain.end.wall: [same, rigid, ptfe]
  zip:
    chain.damping.time: [1 us, 2 us]
    impact.velocity: {linspace: [0.5 m/s, 1 m/s, 2]}
"""


def test_a_sweep_varies_features(tmp_path: Path) -> None:
    scene = load(tmp_path, EVERY_FEATURE + SWEEP)
    assert scene.sweep is not None
    assert scene.sweep.shape == (2, 3, 2)
    assert schema_faults(EVERY_FEATURE + SWEEP) == []
    # the scene of the document is that of the first point
    assert scene.chain == Family(scene).scenario(scene.sweep.point(0)).chain
    last = Family(scene).scenario(scene.sweep.point(11))
    assert last.chain.granules[1].radius == 2e-3  # type: ignore[index,union-attr]
    assert last.chain.end == sw.Wall(material=PTFE, mass=2.0, stiffness=1e6, damping=50.0)
    assert last.impact == sw.Impact(velocity=1.0, diameter=16e-3, material=STEEL)


def test_a_sweep_may_fill_in_what_is_missing(tmp_path: Path) -> None:
    text = finite(", damping: {model: dashpot}") + "sweep: {grid: {chain.damping.coefficient: [1, 2]}}"
    assert load(tmp_path, text).chain.damping == sw.Dashpot(coefficient=1.0)
    assert schema_faults(text) == []


def test_features_have_uncertainties(tmp_path: Path) -> None:
    block = (
        "uncertainty:\n"
        "  chain.granules[1].diameter: 5 %\n"
        "  chain.damping.time: {factor: 1.5}\n"
        "  impact.velocity: {between: [0.4 m/s, 0.6 m/s]}\n"
        "  chain.precompression: {sd: 0.1 N}\n"
    )
    names = ["chain.granules[1].diameter", "chain.damping.time", "impact.velocity", "chain.precompression"]
    assert [spread.name for spread in load(tmp_path, EVERY_FEATURE + block).uncertainty] == names
    with pytest.raises(ScenarioError, match=r"'chain\.granules\[0\]\.count': must be a continuous value"):
        load(tmp_path, EVERY_FEATURE + "uncertainty: {'chain.granules[0].count': 5 %}\n")
    both = "{'chain.granules[1].diameter': 5 %, 'chain.granules[1].radius': 5 %}"
    with pytest.raises(ScenarioError, match=r"must be left out if chain\.granules\[1\]\.radius is given"):
        load(tmp_path, EVERY_FEATURE + f"uncertainty: {both}\n")


# ---------------------------------------------------------------- hash and summary


def test_the_hash_is_that_of_the_scene(tmp_path: Path, whole: sw.Scenario) -> None:
    def changed(old: str, new: str) -> str:
        assert old in EVERY_FEATURE
        return scene_hash(load(tmp_path, EVERY_FEATURE.replace(old, new)))

    assert changed("2 us", "2000 ns") == changed("diameter: 16 mm", "radius: 8e-3") == scene_hash(whole)
    for old, new in (("2 us", "3 us"), ("count: 20", "count: 21"), ("0.5 m/s", "0.6 m/s"), ("same", "rigid")):
        assert changed(old, new) != scene_hash(whole)


def test_segments_of_equal_granules_are_the_same_scene(tmp_path: Path) -> None:
    segments, number = (load(tmp_path, text) for text in (finite(), finite().replace("[{count: 4}]", "4")))
    assert scene_hash(segments) == scene_hash(number)
    assert sw.predict(segments).to_dict() == sw.predict(number).to_dict()


def test_the_summary_lists_every_feature(whole: sw.Scenario) -> None:
    summary = whole.scene.summary()
    assert summary.numbers["chain"] == plain(whole.chain)
    assert summary.numbers["granules"] == 20 + 10 + 5 + 9 + 3
    facts = dict(summary.lines)
    assert facts["impact"] == "velocity 500 mm/s, diameter 16 mm, material stainless-steel-302"
    assert facts["end"] == "wall of the same material, mass 2 kg, stiffness 1 MN/m, damping 50 N*s/m"
    assert facts["damping"] == "kuwabara-kono, time 2 us"


# ---------------------------------------------------------------- what equal granules alone are for


def test_commands_for_equal_granules_refuse_other_chains(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = load(tmp_path, finite(", end: {wall: same, mass: 1 kg}")).path
    assert main(["curve", str(path)]) == 3
    out, error = capsys.readouterr()
    assert error.startswith(f"{path}:1:65: chain.end: must be left out for ")
    assert error.endswith("which covers only shocks on chains of equal granules with free ends (got a wall)\n")
    assert out == ""


@pytest.mark.parametrize(
    ("more", "excitation", "place", "reason"),
    [
        (", end: {wall: same, mass: 1 kg}", SHOCK, "1:65", "chain.end (a wall)"),
        ("", IMPACT, "2:1", "impact (a striker)"),
    ],
    ids=["wall", "striker"],
)
def test_predict_answers_for_chains_that_section_4_does_not_cover(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: str, excitation: str, place: str, reason: str
) -> None:
    scene = load(tmp_path, finite(more, excitation))
    assert main(["predict", str(scene.path)]) == 0
    text = capsys.readouterr().out
    assert text.startswith("scene: force on the wall " if "wall" in more else "scene: greatest force ")
    assert f"  section 4         does not apply, because of {reason}\n" in text
    document = sw.predict(scene).to_dict()
    assert document["greatest_force"] == sw.simulate(scene).to_dict()["greatest_force"] is not None
    assert (document["section4"], document["method"]) == (None, "simulation")
    assert document["section4_reason"].startswith(f"{scene.path}:{place}")


def test_a_refusal_names_all_features(whole: sw.Scenario) -> None:
    with pytest.raises(NotCoveredError) as caught:
        whole.scene.covered_chain("a test")
    faults = map(whole.scene.place_fault, caught.value.faults)
    assert [(fault.path, fault.location.rpartition("scene.yaml")[2]) for fault in faults] == [
        ("chain.granules[1]", ":6:7"),
        ("chain.end", ":10:3"),
        ("chain.precompression", ":11:3"),
        ("chain.gravity", ":12:3"),
        ("chain.damping", ":13:3"),
        ("chain.contact", ":14:3"),
        ("impact", ":15:1"),
    ]
