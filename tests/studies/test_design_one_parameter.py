"""Design of one parameter: closed forms, all solutions, intervals, materials and whole numbers, wrong input."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave import cli, pictures
from shockwave.base.progress import show_progress
from shockwave.base.quantities import Quantity
from shockwave.pictures.studies import ranking_size
from shockwave.scenario.variations import Family
from shockwave.studies.design_one_parameter import _meets_target, search_interval
from shockwave.studies.design_options import DesignScenes
from shockwave.studies.design_result import Option, VariedParameter
from shockwave.studies.quantities import Requirement, split_requirement
from support.command_line import unwrapped
from support.pages import ROOT
from support.scenes import CASE_A, CHAIN, POWER, UNITS

FILE = str(ROOT / "profiles" / "examples" / "protector.yaml")
SHORT = sw.Shock(profile=POWER, peak_force=100.0, rise_time=1e-3 * UNITS.time)
#: A chain with a wall, whose force has a maximum and a minimum along the size of its soft layer.
SCENE = """
name: two layers
chain:
  material: paper-steel
  diameter: 8 mm
  granules: [{count: 3}, {count: 3, material: ptfe}]
  end: {wall: same}
shock: {profile: triangular, peak_force: 100 N, rise_time: 20 us, duration_ratio: 3}
"""
SIZE, COUNT, WALL_FORCE = "chain.granules[1].diameter", "chain.granules[1].count", "transmitted.peak_force"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def design(target: Any, vary: str = "chain.radius", between: Any = (2e-3, 2e-2), **settings: Any) -> sw.Design:
    """A design of CASE_A on the paper's beads."""
    return sw.design(CASE_A, CHAIN, vary=vary, between=between, target=target, **settings)


# ---------------------------------------------------------------- closed forms


@pytest.mark.parametrize(
    ("name", "power"),
    [("chain.radius", -8 / 5), ("chain.material.density", -3 / 5), ("shock.rise_time", 6 / 5)],
    ids=["radius", "density", "rise time"],
)
def test_a_short_shock_has_the_solution_of_the_scaling_law(name: str, power: float) -> None:
    """The peak force of an impulse scales as R^-1.6, rho^-0.6 and I^1.2."""
    value = {"chain.radius": CHAIN.radius, "shock.rise_time": SHORT.rise_time}.get(name, CHAIN.material.density)
    force = sw.simulate(SHORT, CHAIN, rtol=1e-9).peak_force
    result = sw.design(SHORT, CHAIN, vary=name, between=(value / 4, value * 3), target={"peak_force": 1.5 * force})
    (option,) = result.solutions
    # the impulse limit is approached as (t0/T0)^2, and the solution meets the target within a hundredth of 1e-4
    assert option.value == pytest.approx(value * 1.5 ** (1 / power), rel=1e-5)


def test_a_collision_has_the_solution_of_the_closed_form() -> None:
    """The peak force of two equal spheres scales as v^(6/5)."""
    chain = sw.Chain(material="stainless-steel-302", diameter="9.5 mm", granules=1)
    force = sw.simulate(sw.Impact(velocity=0.5), chain, rtol=1e-9).greatest_force.peak_force
    target = f"greatest_force.peak_force = {2 * force} N"
    result = sw.design(sw.Impact(velocity=0.5), chain, vary="impact.velocity", between=(0.1, 2), target=target)
    (option,) = result.solutions
    # at the default tolerance the search stops within 1e-6 of the target
    assert option.value == pytest.approx(0.5 * 2 ** (5 / 6), rel=1e-6)
    assert option.value == pytest.approx(0.5 * 2 ** (5 / 6), abs=2 * option.value_error)


@pytest.mark.parametrize("target", ["momentum", "energy", "speed", "width", "granule_velocity"])
def test_properties_of_the_leading_wave_are_those_of_the_simulation(target: str) -> None:
    wave = sw.simulate(CASE_A, CHAIN, rtol=1e-8).waves[0]
    value = 1.1 * getattr(wave, target)
    (option,) = design({target: value}, "shock.peak_force", (1.0, 1e3)).solutions
    shock = attrs.evolve(CASE_A, peak_force=float(option.value))
    reached = getattr(sw.simulate(shock, CHAIN, rtol=1e-8).waves[0], target)
    # properties are at most of the second power of the force, which is found within 1e-6
    assert reached == pytest.approx(value, rel=5e-6)


# ---------------------------------------------------------------- all solutions


class Curve:
    """Scenes whose quantity is a function of the share of the interval from 0 to 1, in place of simulations."""

    def __init__(self, height: Callable[[float], float], sign: Any = "=", value: float = 1.0) -> None:
        quantity = Quantity("peak_force", "N")
        parameter = VariedParameter(name="chain.radius", unit="m", between=(0.0, 1.0))
        self.count = 0

        def options(_: Any, values: Any, rtol: float, margin: float = 0.0) -> list[Option]:
            self.count += len(values)
            made = [(each, height(each[0])) for each in values]
            figures: dict[str, Any] = {"errors": {"peak_force": 0.0}, "violation": 0.0, "verified": rtol <= 1e-8}
            return [Option(values=each, quantities={"peak_force": reached}, **figures) for each, reached in made]

        scenes = DesignScenes(None, (parameter,), (Requirement(quantity, sign, value),), (quantity,), None)  # type: ignore[arg-type]
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(DesignScenes, "options", options)
            self.answer = search_interval(scenes, 9, 1e-4)

    @property
    def values(self) -> list[float]:
        return [option.value for option in self.answer["solutions"]]


@pytest.mark.parametrize("gap", [1e-2, 1e-4, -1e-4], ids=["wide", "close", "none"])
@pytest.mark.parametrize("top", [0.313, 0.99, 0.004], ids=["inside", "end", "beginning"])
def test_two_solutions_beside_an_extremum_are_found(gap: float, top: float) -> None:
    curve = Curve(lambda x: 1 + 4 * gap - (x - top) ** 2)
    roots = [] if gap < 0 else [top - 2 * math.sqrt(gap), top + 2 * math.sqrt(gap)]
    # the search stops within 1e-6 of the target; with the least slope 0.04 that is 2.5e-5
    assert curve.values == pytest.approx([root for root in roots if 0 <= root <= 1], abs=3e-5)


def test_a_double_root_is_a_solution_that_states_what_it_reaches() -> None:
    curve = Curve(lambda x: 1 - 5e-5 - (x - 0.313) ** 2)
    # the extremum is known within the square root of the tolerance
    assert curve.values == pytest.approx([0.313], abs=1e-2)
    (solution,) = curve.answer["solutions"]
    assert solution.reached == pytest.approx(1 - 5e-5, abs=1e-6)
    assert solution.value_error > 1e-4


def test_all_crossings_of_a_wave_are_found_with_few_simulations() -> None:
    curve = Curve(lambda x: 1.2 + math.sin(17 * x))
    roots = [(math.pi + math.asin(0.2)) / 17, (2 * math.pi - math.asin(0.2)) / 17]
    roots = sorted(
        root + 2 * math.pi * turn / 17 for root in roots for turn in range(3) if root + 2 * math.pi * turn / 17 < 1
    )
    assert curve.values == pytest.approx(roots, abs=1e-6)
    # 33 on the grid, 12 a round about the least and the greatest value, at most eight for a crossing
    assert curve.count < 150


def test_teeth_of_a_long_shock_on_a_wall_are_resolved_with_the_fewest_rows_of_the_table() -> None:
    chain = sw.Chain(material="bearing-steel-52100", diameter="1 in", granules=10, end=sw.Wall(material="same"))
    shock = sw.Shock(profile="final-peak-sawtooth", peak_force="100 N", duration="11 ms")
    sizes = np.geomspace(6.35e-3, 101.6e-3, 201)
    chains = [attrs.evolve(chain, radius=size / 2) for size in sizes.tolist()]
    results: Any = sw.simulate_many([shock] * len(chains), chains)
    forces = np.array([each.transmitted.peak_force for each in results])
    ends, limit = tuple(sizes[[0, -1]].tolist()), 120.102
    target = f"{WALL_FORCE} <= {limit} N"
    result = sw.design(shock, chain, vary="chain.diameter", between=ends, target=target, points=2)
    inside = [any(low <= size <= high for low, high in result.intervals) for size in sizes]
    # at the others the force is within the tolerance of the limit
    clear = np.abs(forces / limit - 1) > 2e-4
    assert len(result.intervals) == 10
    np.testing.assert_array_equal(np.array(inside)[clear], (forces <= limit)[clear])


def test_a_quantity_that_is_not_resolved_is_reported() -> None:
    curve = Curve(lambda x: 1 + 0.1 * math.sin(1e4 * x * x))
    assert "peak_force varies too fast between " in curve.answer["warnings"][0]
    assert "varies too fast" not in "".join(Curve(lambda x: 1 + 0.1 * math.sin(20 * x)).answer["warnings"])


def test_a_jump_over_the_target_is_no_solution() -> None:
    curve = Curve(lambda x: 0.9 if x < 0.4 else 1.1)
    assert curve.values == []
    assert curve.answer["nearest"] is not None
    assert Curve(lambda x: 0.9 if x < 0.4 else 1.1, "<=").answer["intervals"] == (pytest.approx((0, 0.4), abs=1e-9),)


@pytest.mark.parametrize(
    ("sign", "lift", "intervals"),
    [("<=", 0, [(0, 0.2), (0.7, 1)]), (">=", 0, [(0.2, 0.7)]), (">=", 1, [(0, 1)]), ("<=", 1, [])],
    ids=["below", "above", "everywhere", "nowhere"],
)
def test_an_inequality_holds_in_intervals(sign: Any, lift: float, intervals: list[tuple[float, float]]) -> None:
    curve = Curve(lambda x: 1 + lift - (x - 0.2) * (x - 0.7), sign)
    assert curve.answer["intervals"] == tuple(pytest.approx(each, abs=1e-5) for each in intervals)


@pytest.mark.parametrize("sign", ["<=", ">="])
def test_an_inequality_that_only_an_end_meets(sign: Any) -> None:
    slope = 1.0 if sign == "<=" else -1.0
    assert Curve(lambda x: 1 + slope * x, sign).answer["intervals"] == ((0.0, 0.0),)
    assert Curve(lambda x: 1 + slope * (x + 0.1), sign).answer["intervals"] == ()


def test_poissons_ratio_has_two_solutions_about_zero() -> None:
    chain = attrs.evolve(CHAIN, material=attrs.evolve(CHAIN.material, poisson_ratio=0.25))
    force = sw.simulate(CASE_A, chain, rtol=1e-9).peak_force
    result = design({"peak_force": force}, "chain.material.poisson_ratio", (-0.7, 0.4))
    assert [option.value for option in result.solutions] == pytest.approx([-0.25, 0.25], rel=1e-4)
    # the minimum is known within the root of a tenth of the tolerance
    assert result.lowest.value == pytest.approx(0, abs=4e-3)


def test_the_error_of_a_solution_is_that_of_the_target_over_the_slope() -> None:
    (option,) = design({"peak_force": 60.0}).solutions
    value = float(option.value)
    low, high = (
        sw.simulate(CASE_A, attrs.evolve(CHAIN, radius=value * factor), rtol=1e-9).peak_force
        for factor in (0.999, 1.001)
    )
    slope = abs(math.log(high / low)) / (2e-3 * value)
    error = abs(option.reached / 60 - 1) + option.reached_error
    # the slope of the search is a secant over at least a hundred errors
    assert option.value_error == pytest.approx(error / slope, rel=0.1)
    assert abs(option.reached / 60 - 1) < 1e-6
    assert option.verified


# ---------------------------------------------------------------- materials and whole numbers


def test_all_whole_numbers_that_meet_a_target_are_found(file: Path) -> None:
    family = Family(sw.load_scenario(file))
    forces = {count: sw.simulate(family.scenario({COUNT: count})).transmitted.peak_force for count in range(1, 6)}
    limit = sorted(forces.values())[2] * (1 + 1e-4)
    result = sw.design(file, vary=COUNT, between=(1, 5), target=f"{WALL_FORCE} <= {limit} N")
    assert [option.value for option in result.solutions] == [count for count, force in forces.items() if force <= limit]
    assert [option.value for option in result.table] == [*forces]


def test_consecutive_whole_numbers_are_printed_as_a_range(file: Path) -> None:
    text = " ".join(str(sw.design(file, vary=COUNT, between=(1, 5), target=f"{WALL_FORCE} >= 1 N")).split())
    assert re.match(r"count 1 to 5 gives a wall force >= 1 N.* \(simulated [\d.]+ N to [\d.]+ N\)", text)


def test_a_material_meets_an_equality_within_the_tolerance() -> None:
    given: dict[str, Any] = {"vary": "chain.material", "between": None, "among": ["ptfe", "brass-260"]}
    forces = sorted(option.reached for option in design({"peak_force": 60}, **given).table)
    met = design({"peak_force": forces[1] * (1 + 3e-5)}, **given)
    assert [option.value for option in met.solutions] == [met.table[0].value]
    missed = design({"peak_force": sum(forces) / 2}, **given)
    assert (missed.solutions, missed.nearest) == ((), missed.table[0])
    assert "no material gives" in missed.why


def test_materials_of_a_chain_that_must_be_elastic_are_left_out_with_a_warning() -> None:
    steel = sw.material("bearing-steel-52100")
    chain = sw.Chain(material=steel, radius=4.75e-3, elastic_only=True)
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=40.0, rise_time=20e-6)
    names = ["bearing-steel-52100", "ptfe"]
    result = sw.design(shock, chain, vary="chain.material", target="peak_force <= 1 kN", among=names)
    assert [option.value for option in result.table] == names[:1]
    assert result.warnings[-1].endswith("a yield strength is not known: ptfe")
    with pytest.raises(sw.InvalidValueError, match=r"elastic_only: must be left out"):
        sw.design(shock, chain, vary="chain.material", target="peak_force <= 1 kN", among="ptfe")


# ---------------------------------------------------------------- answers


def test_an_unreachable_target_is_reported_with_the_range() -> None:
    result = design({"peak_force": 1000.0})
    assert (result.solutions, result.reachable, result.best) == ((), False, None)
    assert result.nearest.value == 2e-3
    assert result.why.startswith("1 kN is out of reach: the greatest value found is 1")
    assert str(result).startswith("no radius gives a peak force of 1 kN; nearest 2 mm (simulated 1")


def test_the_text_has_the_answer_first_and_at_most_ten_rows() -> None:
    result = design("peak_force = 60 N", points=40)
    lines = str(result).splitlines()
    assert lines[0].startswith("radius ")
    assert max(map(len, lines)) <= 80
    rule = next(index for index, line in enumerate(lines) if line.startswith("  ---"))
    assert len([line for line in lines[rule + 1 :] if " N" in line]) == 10
    assert lines[-1] == "  (31 more rows; --wide shows all)"


def test_a_mapping_is_an_equality_and_a_mapping_of_one_parameter_its_interval() -> None:
    expected = design("peak_force = 60 N")
    assert design({"peak_force": "60 N"}) == expected
    mapped = sw.design(CASE_A, CHAIN, vary={"chain.radius": np.array([2e-3, 2e-2])}, target=["peak_force = 60 N"])
    assert mapped == expected


def test_progress_is_reported() -> None:
    reports: list[tuple[str, int, int | None]] = []
    with show_progress(lambda *report: reports.append(report)):
        design({"peak_force": 60})
    assert reports[-1][0] == "simulations"


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "vary-unknown": ({"vary": "chain.radios"}, "vary: must be the dotted name of a key .* did you mean"),
    "vary-known": ({"vary": "radius"}, r"vary: .*known: chain.material, chain.diameter, (?!.*predict)"),
    "vary-list": ({"vary": ["chain.radius"]}, "vary: must be a name, or a mapping of names"),
    "vary-setting": ({"vary": "simulate.rtol"}, "vary: must be a number or a material of the chain or the shock"),
    "vary-of-file": ({"vary": "chain.damping.time"}, r"vary: .*made in Python.* \(got chain\.damping\.time;"),
    "target-unknown": ({"target": {"peak_fource": 1}}, "target: .* did you mean 'peak_force'"),
    "target-column": ({"target": {"transmitted_force": 1}}, "target: .*got transmitted.peak_force, which is null"),
    "target-label": ({"target": {"wall_force": 1}}, "target: .* did you mean 'transmitted.peak_force'"),
    "target-unit": ({"target": {"peak_force": "3 mm"}}, "target: peak_force must be a force"),
    "target-zero": ({"target": {"peak_force": 0}}, "target: peak_force must be > 0 N"),
    "target-two": ({"target": {"peak_force": 1, "speed": 1}}, "target: must be one property and its value"),
    "target-number": ({"target": 5}, r"target: must be a quantity, .* \(got 5\)"),
    "target-nothing": ({"target": None}, "target: must be given"),
    "target-null": ({"target": "restitution >= 0.5"}, r"target: must be a quantity that the .* known: peak_force"),
    "between-lacking": ({"between": None}, "between: must be the lower and the upper end"),
    "between-material": ({"vary": "chain.material"}, "between: must be omitted for chain.material"),
    "between-mapping": ({"vary": {"chain.radius": (1e-3, 2e-3)}}, "between: must be omitted for chain.radius"),
    "between-order": ({"between": (2e-2, 1e-3)}, "between: must ascend"),
    "between-range": ({"between": (-1.0, 1.0)}, "between: must be > 0 m"),
    "between-long": (
        {"vary": "shock.rise_time", "between": (1e-5, 1.0)},
        r"between: must contain only valid cases \(shock: must last at most 1000 characteristic times",
    ),
    "among": ({"among": ["ptfe"]}, "among: must be omitted"),
    "among-empty": ({"vary": "chain.material", "between": None, "among": []}, r"among: must be names of .* \(got \["),
    "points": ({"points": 1}, "points: must be a whole number >= 2"),
    "rtol": ({"rtol": 0.5}, "rtol: must be >= 1e-07 and <= 0.01"),
    "seed": ({"seed": -1}, "seed: must be a whole number >= 0"),
    "least": ({"least": "mass"}, "least: must be a property of the result"),
    "endless": ({"least": "chain.mass"}, "chain.granules: must be given for its mass .*--least"),
}


@pytest.mark.parametrize(("other", "message"), REFUSED.values(), ids=REFUSED)
def test_wrong_arguments_are_refused(other: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"vary": "chain.radius", "target": {"peak_force": 60}, "between": (1e-3, 2e-2)}
    with pytest.raises(sw.InvalidValueError, match=f"^{message}"):
        sw.design(CASE_A, CHAIN, **given | other)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"vary": COUNT, "between": (1, 300)}, r"^between: must have at most 200 whole numbers \(got 300;"),
        ({"vary": COUNT, "between": (1, 2), "target": "amplification <= 1"}, r"amplification, which is null .* known:"),
        (
            {"target": "contacts[9].peak_force <= 1 N"},
            r"reported contacts.* \(got 'contacts\[9\]\.peak_force'; the list",
        ),
    ],
    ids=["numbers", "null", "contact"],
)
def test_what_a_chain_does_not_have_is_refused(file: Path, settings: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"vary": SIZE, "between": ("4 mm", "12 mm"), "target": f"{WALL_FORCE} <= 30 N"}
    with pytest.raises(sw.InvalidValueError, match=message):
        sw.design(file, **given | settings)


def test_a_force_that_has_not_arrived_meets_no_target(file: Path) -> None:
    file.write_text(f"{SCENE}simulate: {{until: 50 us}}\n")
    message = r"simulate\.until: must be later than .*too early where chain\.granules\[1\]\.diameter is 0\.0"
    with pytest.raises(sw.InvalidValueError, match=message):
        sw.design(file, vary=SIZE, between=("4 mm", "12 mm"), target=f"{WALL_FORCE} <= 30 N")


# ---------------------------------------------------------------- the command


def test_the_command_ranks_materials_whose_range_has_the_target(capsys: pytest.CaptureFixture[str]) -> None:
    for force, status in (("20 N", 0), ("9 kN", 1)):
        arguments = [
            "--vary",
            "chain.material",
            "--among",
            "delrin,bearing-steel-52100",
            "--target",
            f"peak_force={force}",
        ]
        assert cli.main(["design", FILE, *arguments]) == status
        printed = capsys.readouterr()
        assert printed.out.startswith("no material gives a peak force of ")
        assert unwrapped(printed.out).count("is out of reach") == status  # a status of 1 has one reason
        assert printed.err == ""
        assert max(map(len, printed.out.splitlines())) <= 80


def test_an_end_of_a_taper_is_named_with_its_size() -> None:
    assert VariedParameter(name="chain.granules[1].diameter.from").label == "diameter from"
    assert VariedParameter(name="chain.precompression").label == "precompression"


def test_the_command_prints_what_python_gives(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--vary", "chain.radius", "--between", "8 mm", "25 mm", "--target", "peak_force <= 12 N"]
    assert cli.main(["design", FILE, *arguments, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    result = sw.design(FILE, vary="chain.radius", between=("8 mm", "25 mm"), target="peak_force <= 12 N")
    assert document == json.loads(json.dumps(result.to_dict()))
    assert document["requirements"] == [{"quantity": "peak_force", "unit": "N", "sign": "<=", "value": 12.0}]
    assert document["solutions"][0]["quantities"]["peak_force"] == pytest.approx(12, rel=1e-6)
    assert [each["values"] for each in document["solutions"]] == [[document["intervals"][0][0]]]


@pytest.mark.parametrize(
    "arguments",
    [
        ["--vary", "chain.radius", "--between", "8 mm", "25 mm"],
        ["--vary", "chain.material", "--among", "delrin,bearing-steel-52100"],
    ],
    ids=["interval", "ranking"],
)
def test_the_command_draws_a_picture(arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "design.svg"
    assert cli.main(["design", FILE, *arguments, "--target", "peak_force <= 17 N", "-o", str(picture)]) == 0
    assert "<svg" in picture.read_text()
    assert capsys.readouterr().err == f"{picture}: written\n"


def test_a_picture_ranks_materials_from_the_top_and_marks_those_that_meet_the_target() -> None:
    names = ["bearing-steel-52100", "delrin", "nylon-66"]
    result = sw.design(FILE, vary="chain.material", among=names, target="peak_force <= 17 N")
    _, (ax,) = pictures.figure()
    pictures.materials(result, ax=ax)
    shown = [label.get_text() for label in ax.get_yticklabels()]
    assert shown == [option.value for option in result.table]
    assert ax.get_ylim()[0] > ax.get_ylim()[1]
    met = next(line for line in ax.get_lines() if line.get_label() == "meets it")
    assert {shown[int(place)] for place in met.get_ydata()} == {"delrin"}
    rows = [
        ranking_size(sw.design(FILE, vary="chain.material", among=some, target="peak_force <= 17 N"))[1]
        for some in (names[:2], names)
    ]
    assert rows[0] < rows[1]


VARIED = ["--vary", "chain.radius", "--between", "1 mm", "2 mm"]
#: Arguments of a design for a peak force, and what the error message contains.
WRONG = {
    "order": (["--vary", "chain.radius", "--between", "20 mm", "1 mm"], "--between"),
    "material": (["--vary", "chain.material", "--among", "ptef"], "--among"),
    "form": ([*VARIED, "--target", "peak_force"], "--target"),
    "unknown": ([*VARIED, "--target", "sped=9"], "--target"),
    "ending": ([*VARIED, "-o", "design.gif"], "--output: must end in"),
    "none": (["--vary", "chain.radius"], "--between must be given once for each number that varies (got 0 for"),
    "one": ([*VARIED, "--vary", "shock.peak_force"], "(got 1 for"),
    "twice": ([*VARIED, *VARIED], "--vary must name different parameters"),
    "among": ([*VARIED, "--among", "ptfe"], "--among must be"),
}


@pytest.mark.parametrize(("arguments", "message"), WRONG.values(), ids=WRONG)
def test_a_wrong_argument_is_refused(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    target = [] if "--target" in arguments else ["--target", "peak_force=60 N"]
    assert cli.main(["design", FILE, *target, *arguments]) == 2
    printed = capsys.readouterr()
    assert message in printed.err
    assert printed.out == ""


@pytest.mark.parametrize(("miss", "error", "equal"), [(5e-5, 0.0, True), (2e-4, 0.0, False), (2e-4, 1.5e-4, True)])
def test_a_value_equals_the_target_within_the_tolerance_and_its_error(miss: float, error: float, equal: bool) -> None:
    target = Requirement(Quantity("peak_force", "N"), "=", 60.0)
    quantities, errors = {"peak_force": 60.0 * (1 + miss)}, {"peak_force": error}
    option = Option(values=(1.0,), quantities=quantities, errors=errors, violation=miss)
    assert _meets_target(target, option, 1e-4) is equal


@pytest.mark.parametrize("layer", ["ptfe", "bearing-steel-52100"], ids=["later collision", "no later collision"])
def test_the_answer_concerns_the_simulated_time_where_a_force_may_be_greater_later(layer: str) -> None:
    # the soft beads hold back the heavy striker
    granules = [sw.Segment(count=6), sw.Segment(count=5, material=layer), sw.Segment(count=2)]
    chain = sw.Chain(material="bearing-steel-52100", diameter=9.5e-3, granules=granules, end=sw.Wall())
    impact = sw.Impact(velocity=0.3, diameter=25e-3 if layer == "ptfe" else 9.5e-3)
    target = "transmitted.peak_force <= 50 N"
    found = sw.design(impact, chain, target=target, vary="impact.velocity", between=(0.1, 1.0))
    answer = " ".join(str(found).partition("\n  !")[0].split())
    assert ("<= 50 N within the simulated time (" in answer) == (layer == "ptfe")


def test_a_printed_name_is_a_target_and_a_wrong_unit_names_the_argument() -> None:
    names = "wall force <= 50 N", "transmitted.peak_force <= 50 N"
    assert len({Requirement.of(*split_requirement(name, "target"), (), "target") for name in names}) == 1
    with pytest.raises(sw.InvalidValueError, match=r"^target: transmitted\.peak_force must be a force"):
        Requirement.of(*split_requirement("transmitted.peak_force <= 50 s", "target"), (), "target")
