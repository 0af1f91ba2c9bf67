"""Designs of several parameters, inequalities and budgets."""

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave import cli
from shockwave.chain.layout import mass_and_length
from shockwave.scenario.scene_family import Family
from shockwave.studies.quantities import Quantity, Requirement, parts_of

pytestmark = pytest.mark.numerical

# Small beads in front of large ones: the wall force depends on both sizes.
SCENE = """
name: two layers
chain:
  material: paper-steel
  diameter: 8 mm
  granules:
    - {count: 3}
    - {count: 3, material: ptfe}
  end: {wall: same}
shock: {profile: triangular, peak_force: 100 N, rise_time: 20 us, duration_ratio: 3}
"""
SIZE, OTHER = "chain.granules[1].diameter", "chain.granules[0].diameter"
FORCE = "transmitted.peak_force"


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("design") / "scene.yaml"
    file.write_text(SCENE, encoding="utf-8")
    return file


@cache
def best(file: Path, *targets: str, **settings: Any) -> sw.OptimalDesign:
    ends = {SIZE: ("4 mm", "12 mm"), OTHER: ("4 mm", "12 mm")}
    return sw.optimal_design(sw.load_scenario(file), vary=ends, targets=targets, **settings)


@pytest.fixture(scope="module")
def force(file: Path) -> float:
    """Wall force of the scene [N]."""
    found: float = sw.simulate(file).transmitted.peak_force
    return found


def test_the_answer_meets_the_inequality_and_no_scanned_scene_is_better(file: Path, force: float) -> None:
    found = best(file, f"{FORCE} <= {force} N")
    assert found.best is not None
    assert found.best.verified
    family = Family(sw.load_scenario(file))
    scene = family.scenario(dict(zip((SIZE, OTHER), found.best.values, strict=True)))
    assert sw.simulate(scene, rtol=1e-9).transmitted.peak_force <= force
    sizes = [4e-3 + 8e-3 * share / 8 for share in range(9)]
    scenes = [family.scenario({SIZE: one, OTHER: other}) for one in sizes for other in sizes]
    masses = [mass_and_length(scene.chain)[0] for scene in scenes if sw.simulate(scene).transmitted.peak_force <= force]
    assert found.best.least <= 1.01 * min(masses)


def test_a_design_is_the_same_in_every_run(file: Path, force: float) -> None:
    vary = {"chain.granules[1].count": (1, 9), "chain.granules[0].count": (1, 9)}
    runs = [sw.optimal_design(sw.load_scenario(file), vary=vary, targets=[f"{FORCE} <= {force} N"]) for _ in range(2)]
    assert runs[0] == runs[1]


def test_one_requirement_need_not_be_a_list(file: Path, force: float) -> None:
    text = f"{FORCE} <= {force} N"
    ends = {SIZE: ("4 mm", "12 mm"), OTHER: ("4 mm", "12 mm")}
    assert sw.optimal_design(sw.load_scenario(file), vary=ends, targets=text) == best(file, text)


@pytest.mark.slow
def test_an_infeasible_requirement_is_reported_with_the_nearest_option(file: Path) -> None:
    found = best(file, f"{FORCE} <= 0.1 N")
    assert found.best is None
    assert found.nearest is not None
    assert found.why.startswith("no option meets wall force <= 100 mN; the nearest misses by ")
    least = min(option.quantities[FORCE] for option in found.tried)
    assert found.nearest.quantities[FORCE] == pytest.approx(least, rel=1e-6)


@pytest.mark.slow
def test_a_budget_restricts_the_options(file: Path, force: float) -> None:
    found = best(file, f"{FORCE} <= {force} N", budgets=("chain.length >= 50 mm",))
    assert found.best is not None
    assert found.best.quantities["chain.length"] >= 0.05


def test_the_distance_from_an_equality_includes_its_tolerance(file: Path) -> None:
    vary = {"chain.granules[1].count": (3, 4)}
    found = sw.optimal_design(file, vary=vary, targets="chain.length = 40 mm", least=FORCE)
    # six beads of 8 mm
    assert found.why.endswith("the nearest misses by 20.0%")
    assert "minimised         wall force" in str(found)


@pytest.mark.slow
def test_another_quantity_is_minimised(file: Path) -> None:
    found = best(file, "chain.mass <= 5 g", least=FORCE)
    assert found.best is not None
    assert found.best.quantities["chain.mass"] <= 5e-3
    assert found.best.least == found.best.quantities[FORCE]


@pytest.mark.slow
def test_the_front_is_surpassed_by_no_option(file: Path, force: float) -> None:
    found = best(file, f"{FORCE} <= {force} N")
    front = found.front(found.requirements[0])
    masses, forces = zip(*((one.least, one.quantities[FORCE]) for one in front), strict=True)
    assert list(masses) == sorted(masses)
    assert list(forces) == sorted(forces, reverse=True)
    assert not [one for one in found.tried if one.least < masses[0]]


def test_materials_are_ranked(file: Path) -> None:
    vary = {"chain.granules[1].material": ["ptfe", "brass-260", "lead"]}
    found = sw.optimal_design(sw.load_scenario(file), vary=vary, targets=[f"{FORCE} <= 1 kN"])
    assert [one.values for one in found.ranking] == [("ptfe",), ("brass-260",), ("lead",)]
    assert "meets all" in str(found)


def test_whole_numbers_stay_whole(file: Path) -> None:
    vary = {"chain.granules[1].count": (1, 6)}
    found = sw.optimal_design(sw.load_scenario(file), vary=vary, targets=[f"{FORCE} <= 1 kN"])
    assert found.best is not None
    assert found.best.values == (1.0,)


@pytest.mark.parametrize(
    ("sign", "value", "error", "holds"),
    [
        *[("<=", 60.0, 0.0, True), ("<=", 60.0, 1e-6, False), (">=", 60.0, 0.0, True), (">=", 59.9, 0.0, False)],
        *[("=", 60.05, 0.0, True), ("=", 60.07, 0.0, False)],
    ],
)
def test_a_requirement_holds_with_the_error_of_its_quantity(sign: Any, value: float, error: float, holds: bool) -> None:
    requirement = Requirement(Quantity(FORCE, "N", "wall force"), sign, 60.0)
    assert (requirement.violation(value, error) <= 0) is holds


@pytest.mark.parametrize(
    "text",
    [
        "transmitted.peak_force",
        "peak_force < 60 N",
        "peak_force => 60 N",
        "peak_force == 60 N",
        "<= 60 N",
        "peak_force <=",
    ],
)
def test_a_requirement_of_another_form_is_refused(text: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^target: must be a quantity, <=, >= or =, and a value"):
        parts_of(text, "target")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"targets": ["transmitted.force <= 1 N"]}, "target: must be a property of the result .*did you mean"),
        ({"targets": [f"{FORCE} <= 1 mm"]}, f"target.{FORCE}: must be a force"),
        ({"targets": [f"{FORCE} <= -1 N"]}, f"target.{FORCE}: must be > 0 N"),
        ({"targets": []}, "target: must be given"),
        ({"targets": ["chain.mass <= 1 g"], "least": "mass"}, "^least: must be a property of the result"),
        ({"targets": ["chain.mass <= 1 g"], "vary": SIZE}, "^vary: must be a mapping of names"),
        ({"targets": ["chain.mass <= 1 g"], "vary": {}}, "^vary: must be a mapping of names"),
        ({"targets": ["chain.mass <= 1 g"], "least": "amplification"}, "^least: must be a quantity that"),
        ({"targets": [f"{FORCE} <= 1 kN"], "budgets": "amplification <= 2"}, "^budget: must be a quantity that"),
        ({"targets": ["chain.mass <= 1 g"], "vary": {"chain.granules[1].material": 5}}, "^among: must be names of"),
        ({"targets": ["chain.mass <= 1 g"], "vary": {"chain.granules[1].material": [5]}}, "material"),
        ({"targets": ["chain.mass <= 1 g"], "vary": {SIZE: None}}, "between: must be the lower and the upper end"),
        ({"targets": ["chain.mass <= 1 g"], "vary": {SIZE: (2, 1)}}, "between: must ascend"),
        ({"targets": ["chain.mass <= 1 g"], "vary": {"chain.end.wall": ["none"]}}, "unknown material"),
    ],
)
def test_wrong_input_is_refused(file: Path, settings: dict[str, Any], message: str) -> None:
    with pytest.raises(sw.ShockwaveError, match=message):
        sw.optimal_design(sw.load_scenario(file), **{"vary": {SIZE: (4e-3, 12e-3)}, **settings})


# ---------------------------------------------------------------- one parameter


def test_all_intervals_that_meet_an_inequality_are_found(file: Path, force: float) -> None:
    found = sw.design(
        sw.load_scenario(file), vary=SIZE, target={FORCE: force}, between=("4 mm", "12 mm"), sign="<=", rtol=1e-3
    )
    assert found.intervals
    family = Family(sw.load_scenario(file))
    for share in range(21):
        size = 4e-3 + 8e-3 * share / 20
        inside = any(low <= size <= high for low, high in found.intervals)
        reached = sw.simulate(family.scenario({SIZE: size})).transmitted.peak_force
        if abs(reached / force - 1) > 2e-3:
            assert inside is (reached <= force)


@pytest.mark.parametrize(("sign", "intervals"), [("<=", 1), (">=", 0)])
def test_an_inequality_that_holds_everywhere_or_nowhere(file: Path, sign: Any, intervals: int) -> None:
    scene = sw.load_scenario(file)
    found = sw.design(scene, vary=SIZE, target={FORCE: 1e6}, between=("4 mm", "12 mm"), sign=sign, points=2, rtol=1e-2)
    assert found.intervals == ((4e-3, 12e-3),) * intervals
    assert bool(found.why) is not bool(intervals)


# ---------------------------------------------------------------- the command


def test_the_command_prints_the_best_option(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    vary = ["--vary", "chain.granules[1].count", "--between", "1", "6", "--vary", "chain.granules[1].material"]
    given = [*vary, "--among", "ptfe,brass-260", "--target", f"{FORCE} <= 1 kN", "--budget", "chain.length <= 1 m"]
    assert cli.main(["design", str(file), *given, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["best"]["values"] == [1, "ptfe"]
    assert cli.main(["design", str(file), *given]) == 0
    assert capsys.readouterr().out.startswith("two layers: mass ")


def test_the_command_draws_the_front(file: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    picture = tmp_path / "front.svg"
    vary = ["--vary", "chain.granules[1].count", "--between", "1", "6"]
    given = [*vary, "--target", f"{FORCE} <= 1 kN", "--least", "chain.length", "-o", str(picture)]
    assert cli.main(["design", str(file), *given]) == 0
    assert "Pareto" not in picture.read_text()  # text is written as paths
    assert picture.stat().st_size > 1000


def test_the_command_draws_the_ranking_beside_the_front(file: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    picture = tmp_path / "ranking.png"
    vary = ["--vary", "chain.granules[1].material", "--among", "ptfe,nylon-66"]
    given = [*vary, "--target", f"{FORCE} <= 1 kN", "--least", "chain.mass"]
    assert cli.main(["design", str(file), *given, "-o", str(picture)]) == 0
    width, height = (int.from_bytes(picture.read_bytes()[at : at + 4], "big") for at in (16, 20))
    assert width > 4 * height  # two axes side by side


def test_a_search_without_a_simulation_states_the_first_reason(file: Path) -> None:
    scene = sw.load_scenario(file)
    scene = attrs.evolve(scene, chain=attrs.evolve(scene.chain, elastic_only=True), document=None)
    with pytest.raises(sw.NumericalError, match=r"could be simulated; the first: chain.elastic_only: must be left out"):
        sw.optimal_design(scene, vary={"chain.material": ["ptfe"]}, targets=[f"{FORCE} <= 1 kN"])


@pytest.mark.parametrize("target", ["chain.length <= 32 mm", "chain.length >= 32 mm"])
def test_a_design_may_meet_a_budget_exactly(file: Path, target: str) -> None:
    # four beads of 8 mm, three of which the second segment has
    scene = sw.load_scenario(file)
    least = FORCE if "<=" in target else "chain.mass"
    found = sw.optimal_design(scene, vary={"chain.granules[0].count": (1, 9)}, targets=target, least=least)
    assert found.best is not None
    assert found.best.quantities["chain.length"] == pytest.approx(32e-3, rel=1e-12)


def test_one_material_need_not_be_a_list(file: Path) -> None:
    vary = {"chain.granules[1].material": "ptfe"}
    found = sw.optimal_design(file, vary=vary, targets=f"{FORCE} <= 1 kN", budgets=None)  # type: ignore[arg-type]
    assert [option.values for option in found.ranking] == [("ptfe",)]


def test_a_force_that_has_not_arrived_meets_no_target(file: Path, tmp_path: Path) -> None:
    early = tmp_path / "early.yaml"
    early.write_text(f"{SCENE}simulate: {{until: 50 us}}\n")
    with pytest.raises(sw.InvalidValueError, match=r"simulate\.until: must be later than the arrival of the wave"):
        sw.optimal_design(early, vary={"chain.granules[1].material": ["ptfe"]}, targets=f"{FORCE} <= 1 kN")
    with pytest.raises(sw.InvalidValueError, match=r"too early where chain\.granules\[1\]\.diameter is 0\.0"):
        sw.design(early, vary=SIZE, between=("4 mm", "12 mm"), target=f"{FORCE} <= 30 N")


def test_an_infeasible_design_ends_with_status_1(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["--vary", "chain.granules[1].material", "--target", "chain.mass <= 1e-9 kg", "--least", "chain.length"]
    assert cli.main(["design", str(file), *given]) == 1
    assert "no option meets chain mass <= " in capsys.readouterr().err


def test_a_target_that_no_scene_has_is_refused_with_those_that_it_has(file: Path) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"\(got amplification, which is null .* known: greatest_force"):
        sw.optimal_design(file, vary={"chain.granules[1].material": ["ptfe"]}, targets=["amplification <= 1"])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["--vary", SIZE], "--between must be given once for each number that varies (got 0 for"),
        (["--vary", SIZE, "--between", "1 mm", "2 mm", "--vary", OTHER], "(got 1 for"),
        (["--vary", SIZE, *["--between", "1 mm", "2 mm"] * 2, "--vary", SIZE], "--vary must name different parameters"),
        (["--vary", SIZE, "--vary", OTHER, *["--between", "1 mm", "2 mm"] * 2, "--among", "ptfe"], "--among must be"),
    ],
)
def test_wrong_options_are_a_wrong_usage(
    file: Path, given: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["design", str(file), *given, "--target", "chain.mass <= 1 g"]) == 2
    assert message in capsys.readouterr().err


def test_mass_and_length_are_those_of_the_granules() -> None:
    steel = sw.material("paper-steel")
    chain = sw.Chain(material=steel, radius=1e-3, granules=[sw.Segment(count=2, gap=1e-4), sw.Segment(radius=2e-3)])
    mass, length = mass_and_length(chain)
    assert mass == pytest.approx(4 / 3 * math.pi * steel.density * (2 * 1e-9 + 8e-9), rel=1e-14)
    assert length == pytest.approx(8e-3 + 2e-4, rel=1e-14)


# ---------------------------------------------------------------- whole numbers and quantities of the chain


def test_all_whole_numbers_that_meet_a_target_are_found(file: Path) -> None:
    count = "chain.granules[1].count"
    family = Family(sw.load_scenario(file))
    forces = {one: sw.simulate(family.scenario({count: one})).transmitted.peak_force for one in range(1, 6)}
    limit = sorted(forces.values())[2] * (1 + 1e-4)
    found = sw.design(file, vary=count, between=(1, 5), target=f"{FORCE} <= {limit} N")
    assert [one.value for one in found.solutions] == [one for one, reached in forces.items() if reached <= limit]
    assert [one.value for one in found.table] == [*forces]
    with pytest.raises(sw.InvalidValueError, match=r"^between: must have at most 200 whole numbers \(got 300;"):
        sw.design(file, vary=count, between=(1, 300), target=f"{FORCE} <= 1 N")


def test_the_command_draws_whole_numbers(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    picture = tmp_path / "counts.svg"
    vary = ["--vary", "chain.granules[1].count", "--between", "1", "2"]
    assert cli.main(["design", str(file), *vary, "--target", f"{FORCE} <= 1 kN", "-o", str(picture)]) == 0
    assert capsys.readouterr().out.startswith("count 1 or 2 gives a wall force <= 1 kN")
    assert picture.stat().st_size > 1000


def test_one_number_can_restrict_the_length_and_the_mass(file: Path) -> None:
    # six beads
    found = sw.design(file, vary="chain.diameter", between=("2 mm", "20 mm"), target="chain.length <= 30 mm", points=2)
    assert found.intervals[0] == pytest.approx((2e-3, 5e-3), rel=1e-6)
    mass, _ = mass_and_length(sw.load_scenario(file).chain)
    found = sw.design(file, vary="chain.diameter", between=(2e-3, 2e-2), target={"chain.mass": mass}, points=2)
    assert found.solutions[0].value == pytest.approx(8e-3, rel=1e-6)


def test_an_endless_chain_has_no_length(tmp_path: Path) -> None:
    endless = tmp_path / "endless.yaml"
    shock = SCENE[SCENE.index("shock:") :]
    endless.write_text(f"chain: {{material: paper-steel, diameter: 8 mm}}\n{shock}")
    with pytest.raises(sw.InvalidValueError, match=r"^chain.granules: must be given for its mass and length"):
        sw.design(endless, vary="chain.diameter", between=(2e-3, 2e-2), target="chain.length <= 30 mm")


def test_contacts_are_those_that_are_reported(file: Path) -> None:
    vary, names = "chain.granules[1].material", ["ptfe"]
    last, wall = (
        sw.design(file, vary=vary, among=names, target=f"{name} <= 1 kN").table[0].reached
        for name in ("contacts[5].peak_force", FORCE)
    )
    assert last == wall
    with pytest.raises(sw.InvalidValueError, match=r"reported contacts.* \(got 'contacts\[6\]\.peak_force'; the list"):
        sw.design(file, vary=vary, among=names, target="contacts[6].peak_force <= 1 kN")


def test_the_ratio_to_first_yield_can_be_required(tmp_path: Path) -> None:
    hard = tmp_path / "hard.yaml"
    hard.write_text(SCENE.replace("paper-steel", "bearing-steel-52100").replace(", material: ptfe", ""))
    found = sw.design(
        hard, vary="shock.peak_force", between=("50 N", "100 N"), target="yield.peak_ratio <= 1", points=2
    )
    ratio = sw.simulate(hard).yielding.peak_ratio
    assert found.most.reached == pytest.approx(ratio, rel=1e-6)


def test_the_properties_of_the_leading_wave_are_those_of_the_simulation(tmp_path: Path) -> None:
    equal = tmp_path / "equal.yaml"
    equal.write_text(
        f"chain: {{material: paper-steel, diameter: 8 mm, granules: 30}}\n{SCENE[SCENE.index('shock:') :]}"
    )
    vary = {"chain.material": ["paper-steel"]}
    found = sw.optimal_design(equal, vary=vary, targets=["speed >= 1 m/s", "energy >= 1 uJ"], least="width")
    wave = sw.simulate(equal, waves="primary", rtol=1e-8).waves[0]
    assert found.best is not None
    assert found.best.quantities["speed"] == pytest.approx(wave.speed, rel=1e-4)
    assert found.best.least == pytest.approx(wave.width, rel=1e-4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"targets": 5}, r"^target: must be a quantity, .* \(got 5\)"),
        ({"targets": None}, "^target: must be given"),
        ({"least": ["chain.mass"]}, "^least: must be a property of the result"),
        ({"seed": -1}, "^seed: must be a whole number >= 0"),
    ],
    ids=["targets", "nothing", "least", "seed"],
)
def test_arguments_of_other_types_are_refused(file: Path, given: dict[str, Any], message: str) -> None:
    settings: dict[str, Any] = {"vary": {SIZE: (4e-3, 12e-3)}, "targets": "chain.mass <= 1 kg"}
    with pytest.raises(sw.InvalidValueError, match=message):
        sw.optimal_design(file, **settings | given)


def test_a_later_collision_that_may_exceed_a_target_is_noted() -> None:
    layers = [sw.Segment(count=6), sw.Segment(count=5, material="ptfe"), sw.Segment(count=2)]
    chain = sw.Chain(material="bearing-steel-52100", diameter=9.5e-3, granules=layers, end=sw.Wall(material="same"))
    impact = sw.Impact(velocity=0.3, diameter=25e-3)
    vary = {"impact.velocity": (0.29, 0.3)}
    found = sw.optimal_design(impact, chain, vary=vary, targets="transmitted.peak_force <= 120 N")
    assert found.best is not None
    assert found.warnings[0].startswith("After the simulated time up to ")
    assert sw.optimal_design(impact, chain, vary=vary, targets="transmitted.peak_force <= 5 kN").warnings == ()
