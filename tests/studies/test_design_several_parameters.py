"""Design of several parameters: the best option, budgets, materials, the Pareto front, and requirements."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave import cli
from shockwave.scenario.variations import Family
from shockwave.scene.layout import mass_and_length
from shockwave.studies import design_several_parameters as design_best
from shockwave.studies.design_options import DesignScenes
from shockwave.studies.design_result import Design, Option
from shockwave.studies.quantities import Requirement, find_target, split_requirement
from support.command_line import unwrapped

# Small beads in front of large ones: the wall force depends on both sizes.
SCENE = """
name: two layers
chain:
  material: paper-steel
  diameter: 8 mm
  granules: [{count: 2}, {count: 2, material: ptfe}]
  end: {wall: same}
shock: {profile: triangular, peak_force: 100 N, rise_time: 20 us, duration_ratio: 3}
"""
SIZE, OTHER = "chain.granules[1].diameter", "chain.granules[0].diameter"
COUNT, MATERIAL, FORCE = "chain.granules[1].count", "chain.granules[1].material", "transmitted.peak_force"
SIZES = {SIZE: ("4 mm", "12 mm"), OTHER: ("4 mm", "12 mm")}


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("design") / "scene.yaml"
    file.write_text(SCENE, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def force(file: Path) -> float:
    """Wall force of the scene [N]."""
    reached: float = sw.simulate(file).transmitted.peak_force
    return reached


def test_the_answer_meets_the_inequality_and_no_scanned_scene_is_better(file: Path, force: float) -> None:
    result = sw.design(file, vary=SIZES, target=f"{FORCE} <= {force} N")
    assert result.best.verified
    family = Family(sw.load_scenario(file))
    scene = family.scenario(dict(zip((SIZE, OTHER), result.best.values, strict=True)))
    assert sw.simulate(scene, rtol=1e-9).transmitted.peak_force <= force
    sizes = [4e-3 + 8e-3 * share / 8 for share in range(9)]
    scenes = [family.scenario({SIZE: size, OTHER: other}) for size in sizes for other in sizes]
    results = sw.simulate_many([each.excitation for each in scenes], [each.chain for each in scenes], rtol=1e-5)
    pairs = zip(scenes, results, strict=True)
    masses = [mass_and_length(each.chain)[0] for each, known in pairs if known.transmitted.peak_force <= force]
    # the scan has the scene itself, which the search improves by far
    assert result.best.quantities["chain.mass"] <= min(masses)


def test_an_optimum_with_a_closed_form_is_found() -> None:
    """The least mass of two layers of a given length: the lighter one as long as it may be."""
    steel, layers = sw.material("paper-steel"), [sw.Segment(count=1, radius=4e-3), sw.Segment(count=1, material="ptfe")]
    chain = sw.Chain(material=steel, radius=4e-3, granules=layers, end=sw.Wall())
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=100.0, rise_time=20e-6)
    result = sw.design(
        shock, chain, vary={"chain.radius": (2e-3, 6e-3)}, target="chain.length >= 20 mm", least="chain.mass"
    )
    # the length of the first bead is 8 mm; the last box is a few 1e-5 of the interval wide
    assert result.best.values[0] == pytest.approx(6e-3, abs=4e-3 * 1e-4)


@pytest.mark.slow
def test_an_equality_is_met_by_the_lightest_chain(tmp_path: Path) -> None:
    """The wall force of the lightest chain below a limit is the limit."""
    file = tmp_path / "three layers.yaml"
    file.write_text(SCENE.replace("ptfe}", "ptfe}, {count: 2, material: brass-260}"), encoding="utf-8")
    below, equal = (sw.design(file, vary=SIZES, target=f"{FORCE} {sign} 60 N").best for sign in ("<=", "="))
    # a force within a thousandth of the limit changes the mass by 2e-4
    assert equal.quantities["chain.mass"] == pytest.approx(below.quantities["chain.mass"], rel=1e-3)


def test_a_design_is_the_same_in_every_run(file: Path) -> None:
    runs = [
        sw.design(file, vary=SIZE, between=(4e-3, 9e-3), target="chain.length >= 29 mm", least="chain.mass", seed=seed)
        for seed in (3, 3, 4)
    ]
    assert runs[0] == runs[1]
    assert runs[0].tried != runs[2].tried


def test_an_infeasible_requirement_is_reported_with_the_nearest_option(file: Path) -> None:
    result = sw.design(file, vary={COUNT: (1, 4)}, target=f"{FORCE} <= 0.1 N", least="chain.mass")
    assert (result.best, result.solutions) == (None, ())
    assert result.why.startswith("no option meets wall force <= 100 mN; the nearest misses by ")
    least = min(option.quantities[FORCE] for option in result.tried)
    assert result.nearest.quantities[FORCE] == pytest.approx(least, rel=1e-6)
    assert str(result).startswith("two layers: no option meets wall force")


def test_a_budget_restricts_the_options(file: Path) -> None:
    given: dict[str, Any] = {"vary": COUNT, "between": (1, 4), "target": f"{FORCE} <= 1 kN", "least": "chain.mass"}
    free, restricted = (sw.design(file, **given, budget=budget) for budget in ((), "chain.length >= 39 mm"))
    # two beads of 8 mm in front of one, or of three
    assert [each.solutions[0].values for each in (free, restricted)] == [(1.0,), (3.0,)]
    assert restricted.requirements[1].kind == "budget"


def test_an_answer_must_hold_in_its_verification(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An option that a more accurate simulation puts 0.5 % above the limit is passed over."""
    options = DesignScenes.options

    def verified_worse(scenes: DesignScenes, values: Any, rtol: float, margin: float = 0.0) -> Any:
        made = options(scenes, values, rtol, margin)
        worse = rtol <= 1e-8 and values[0] == ("ptfe",)
        return [attrs.evolve(each, violation=5e-3) if worse else each for each in made]

    monkeypatch.setattr(DesignScenes, "options", verified_worse)
    vary = {MATERIAL: ["ptfe", "brass-260"]}
    result = sw.design(file, vary=vary, target=f"{FORCE} <= 1 kN", least="chain.mass")
    assert [option.values for option in result.table] == [("ptfe",), ("brass-260",)]
    assert result.solutions[0].values == ("brass-260",)


def test_the_distance_from_an_equality_includes_its_tolerance(file: Path) -> None:
    result = sw.design(file, vary={COUNT: (2, 3)}, target="chain.length = 33.333 mm", least=FORCE)
    # four beads of 8 mm are 32 mm long, five 40 mm
    assert result.why.endswith("the nearest misses by 4 %")
    assert "minimised         wall force" in str(result)


@pytest.mark.parametrize("target", ["chain.length <= 32 mm", "chain.length >= 32 mm"])
def test_a_design_may_meet_a_budget_exactly(file: Path, target: str) -> None:
    # four beads of 8 mm, two of which the second segment has
    least = FORCE if "<=" in target else "chain.mass"
    result = sw.design(file, vary={"chain.granules[0].count": (1, 9)}, target=target, least=least)
    assert result.best.quantities["chain.length"] == pytest.approx(32e-3, rel=1e-12)


@pytest.mark.parametrize(("sign", "masses"), [("<=", [1.0, 2.0]), (">=", [1.0, 3.0])])
def test_the_front_trades_the_mass_for_what_is_required(sign: Any, masses: list[float]) -> None:
    pairs = [(3.0, 9.0), (1.0, 5.0), (2.0, 4.0)]
    options = tuple(
        Option(values=(mass,), quantities={"chain.mass": mass, FORCE: force}, errors={}, violation=0.0)
        for mass, force in pairs
    )
    nothing: dict[str, Any] = dict.fromkeys(("parameters", "quantities", "solutions", "table", "warnings"), ())
    requirement = Requirement(find_target(FORCE, (), "target"), sign, 6.0)
    result = Design(
        scenario="", requirements=(requirement,), least="chain.mass", nearest=None, tried=options, **nothing
    )
    assert [option.quantities["chain.mass"] for option in result.front(requirement)] == masses


def test_materials_are_ranked(file: Path) -> None:
    vary = {MATERIAL: ["ptfe", "brass-260", "lead"], COUNT: (1, 2)}
    result = sw.design(file, vary=vary, target=f"{FORCE} <= 1 kN")
    assert [each.values for each in result.table] == [("ptfe", 1), ("brass-260", 1), ("lead", 1)]
    assert str(result).count("meets all") == 3


def test_the_ratio_to_first_yield_can_be_required(tmp_path: Path) -> None:
    hard = tmp_path / "hard.yaml"
    hard.write_text(SCENE.replace("paper-steel", "bearing-steel-52100").replace(", material: ptfe", ""))
    target = ["yield.peak_ratio <= 10", "chain.mass <= 1 kg"]
    result = sw.design(hard, vary="shock.peak_force", between=("99 N", "100 N"), target=target, least=FORCE)
    assert result.highest.reached == pytest.approx(sw.simulate(hard).yielding.peak_ratio, rel=1e-3)


def test_a_later_collision_that_may_exceed_a_target_is_noted() -> None:
    layers = [sw.Segment(count=6), sw.Segment(count=5, material="ptfe"), sw.Segment(count=2)]
    chain = sw.Chain(material="bearing-steel-52100", diameter=9.5e-3, granules=layers, end=sw.Wall(material="same"))
    impact = sw.Impact(velocity=0.3, diameter=25e-3)
    result = sw.design(impact, chain, vary="chain.material", among="bearing-steel-52100", target=f"{FORCE} <= 120 N")
    assert any(each.startswith("A later collision may exert a greater force on the wall") for each in result.warnings)


def test_a_search_without_a_simulation_states_the_first_reason(file: Path) -> None:
    scene = sw.load_scenario(file)
    scene = attrs.evolve(scene, chain=attrs.evolve(scene.chain, elastic_only=True), document=None)
    with pytest.raises(sw.NumericalError, match=r"could be simulated; the first: chain.elastic_only: must be left out"):
        sw.design(scene, vary={"chain.material": ["ptfe"]}, target=f"{FORCE} <= 1 kN", least="chain.mass")


# ---------------------------------------------------------------- requirements


@pytest.mark.parametrize(
    ("sign", "value", "error", "holds"),
    [
        *[("<=", 60.0, 0.0, True), ("<=", 60.0, 1e-6, False), (">=", 60.0, 0.0, True), (">=", 59.9, 0.0, False)],
        *[("=", 60.05, 0.0, True), ("=", 60.07, 0.0, False)],
    ],
)
def test_a_requirement_holds_with_the_error_of_its_quantity(sign: Any, value: float, error: float, holds: bool) -> None:
    requirement = Requirement(find_target(FORCE, (), "target"), sign, 60.0)
    assert (requirement.violation(value, error) <= 0) is holds


@pytest.mark.parametrize(
    "text",
    [FORCE, "peak_force < 60 N", "peak_force => 60 N", "peak_force == 60 N", "<= 60 N", "peak_force <="],
)
def test_a_requirement_of_another_form_is_refused(text: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^target: must be a quantity, <=, >= or =, and a value"):
        split_requirement(text, "target")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"target": ["transmitted.force <= 1 N"]}, "target: must be a property of the result .*did you mean"),
        ({"target": []}, "target: must be given"),
        ({"least": ["chain.mass"]}, "^least: must be a property of the result"),
        ({"vary": {COUNT: (1, 2)}, "least": "amplification"}, "^least: must be a quantity that"),
        ({"vary": {COUNT: (1, 2)}, "budget": "amplification <= 2"}, "^budget: must be a quantity that"),
        ({"vary": {MATERIAL: [5]}}, "^among: must be names of"),
        ({"vary": {"chain.end.wall": ["none"]}}, "unknown material"),
    ],
)
def test_wrong_input_is_refused(file: Path, settings: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"vary": SIZES, "target": "chain.mass <= 1 kg"}
    with pytest.raises(sw.ShockwaveError, match=message):
        sw.design(file, **given | settings)


def test_too_many_combinations_are_refused(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(design_best, "_COMBINATIONS", 3)
    vary = {"chain.material": ["ptfe", "lead"], MATERIAL: ["ptfe", "lead"]}
    with pytest.raises(
        sw.InvalidValueError, match=r"^among: must have at most 3 combinations .* \(got 4; name fewer\)$"
    ):
        sw.design(file, vary=vary, target="chain.mass <= 1 kg")


# ---------------------------------------------------------------- the command


def test_an_infeasible_design_ends_with_status_1(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["--vary", MATERIAL, "--target", "chain.mass <= 1e-9 kg", "--least", "chain.length"]
    assert cli.main(["design", str(file), *given]) == 1
    printed = capsys.readouterr()
    assert unwrapped(printed.out).count("no option meets chain mass <= ") == 1
    assert printed.err == ""
