"""Design: simulations confirm the solutions, none is missed, and an unreachable target is reported."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import shockwave as sw
from pages import ROOT
from scenes import CASE_A, CHAIN, FORCE, POWER, UNITS
from selection import keeping, thinned
from shockwave import cli, pictures
from shockwave.progress import progress_shown
from shockwave.scenario.scene_family import Family
from shockwave.studies.design_result import Target
from shockwave.studies.quantities import TARGETS
from shockwave.studies.scaling_exponents import POWERS
from shockwave.studies.varied_scenes import curve_of, duration_of, exponents_of, scenario_of, value_of

pytestmark = pytest.mark.numerical

SCENE = scenario_of(CASE_A, CHAIN)
FILE = str(ROOT / "profiles" / "examples" / "protector.yaml")
#: Parameter -> an interval that contains its value.
INTERVALS: dict[str, tuple[float, float]] = {
    "chain.radius": (2e-3, 2e-2),
    "chain.diameter": (4e-3, 4e-2),
    "chain.material.youngs_modulus": (1e9, 1e12),
    "chain.material.density": (1e3, 2e4),
    "chain.material.poisson_ratio": (-0.7, 0.4),
    "shock.peak_force": (1.0, 1e4),
    "shock.rise_time": (1e-6, 1e-4),
    "shock.duration": (3e-6, 3e-4),
}
SHAPES: dict[str, tuple[float, float]] = {
    "shock.duration_ratio": (1.1, 30.0),
    "shock.parameters.rise_exponent": (0.0, 5.0),
    "shock.parameters.decay_exponent": (0.2, 5.0),
}


def design(vary: str = "chain.radius", between: Any = None, **wanted: Any) -> sw.Design:
    """A design of CASE_A on the paper's beads."""
    interval = between if between is not None else {**INTERVALS, **SHAPES}.get(vary)
    return sw.design(CASE_A, CHAIN, vary=vary, target=wanted, between=interval)


@pytest.mark.parametrize("quantity", TARGETS)
@pytest.mark.parametrize("name", thinned([*INTERVALS, *SHAPES], 5))
def test_simulations_of_solutions_meet_the_target(name: str, quantity: str) -> None:
    draw = np.random.default_rng([list(TARGETS).index(quantity), len(name)])
    reachable = design(name, **{quantity: 1.0})
    least, most = reachable.least.reached, reachable.most.reached
    if most / least < 1 + 1e-9:  # the property hardly depends on this parameter
        pytest.skip("nothing to solve")
    wanted = least * (most / least) ** float(draw.uniform(0.05, 0.95))
    found = design(name, **{quantity: wanted})
    assert found.solutions
    for option in found.solutions:
        assert option.simulated is not None
        # a property that scales as a power of the peak force above 1 has a greater error
        power = max(Target(quantity, 1.0).power(SCENE), 1.0)
        assert option.simulated.reached == pytest.approx(wanted, rel=1e-4 * power)


@pytest.mark.parametrize("sign", ["<=", ">="])
def test_an_inequality_that_only_an_end_meets(sign: Any) -> None:
    extremes = design(peak_force=60.0)
    option = extremes.least if sign == "<=" else extremes.most
    target = {"peak_force": option.reached}
    found = sw.design(CASE_A, CHAIN, vary="chain.radius", target=target, between=(2e-3, 2e-2), sign=sign)
    assert found.intervals == ((option.value, option.value),)
    beyond = {"peak_force": option.reached * (0.9 if sign == "<=" else 1.1)}
    missed = sw.design(CASE_A, CHAIN, vary="chain.radius", target=beyond, between=(2e-3, 2e-2), sign=sign)
    assert f"is out of reach: the {'minimum' if sign == '<=' else 'maximum'} is " in missed.why


def test_an_unknown_relation_is_refused() -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^sign: must be <=, >= or = \(got '<'\)"):
        sw.design(CASE_A, CHAIN, vary="chain.radius", target={"peak_force": 60}, between=(2e-3, 2e-2), sign="<")  # type: ignore[arg-type]


def test_a_target_can_be_text() -> None:
    as_text = sw.design(CASE_A, CHAIN, vary="chain.radius", target="peak_force = 60 N", between=np.array([2e-3, 2e-2]))
    assert as_text == design(peak_force="60 N")
    below = sw.design(CASE_A, CHAIN, vary="chain.radius", target="peak_force <= 60 N", between=(2e-3, 2e-2))
    assert below.target.sign == "<="


def at_a_quarter() -> float:
    """Peak force for Poisson's ratio 0.25."""
    scene = Family(SCENE).scenario({"chain.material.poisson_ratio": 0.25})
    return curve_of(POWER, 1e-4, 50.0).answer(scene.shock, scene.chain).peak_force


def test_poissons_ratio_has_two_solutions_about_zero() -> None:
    found = design("chain.material.poisson_ratio", peak_force=at_a_quarter())
    assert [option.value for option in found.solutions] == pytest.approx([-0.25, 0.25], rel=1e-9)


def test_a_response_with_a_maximum_gives_both_solutions(tmp_path: Path) -> None:
    """Among triangles of one duration and impulse, the strongest is neither the steepest nor the symmetric one."""
    file = tmp_path / "triangle.yaml"
    shock = "{profile: triangular, peak_force: 100, duration: 60 us, duration_ratio: 2}"
    file.write_text(f"chain: {{material: paper-steel, radius: 4.75 mm}}\nshock: {shock}\n")
    scenario = sw.load_scenario(file)
    values = np.geomspace(1.05, 60.0, 200)
    shocks = [
        sw.Shock.of_duration(profile=sw.Triangular(duration_ratio=float(n)), peak_force=100.0, duration=60e-6)
        for n in values
    ]
    results = sw.simulate_many(shocks, scenario.chain, rtol=1e-6, waves="primary")
    forces = np.array([result.peak_force for result in results if isinstance(result, sw.SimulationResult)])
    for wanted in (108.0, 111.0, 115.0):
        found = sw.design(
            scenario, vary="shock.duration_ratio", target={"peak_force": wanted}, between=(1.05, 60.0), points=2
        )
        places = np.flatnonzero(np.sign(forces[1:] - wanted) != np.sign(forces[:-1] - wanted))
        assert len(found.solutions) == len(places)
        assert all(values[k] < float(one.value) < values[k + 1] for k, one in zip(places, found.solutions, strict=True))
        # the maximum of a grid has a second-order error
        assert found.most.reached == pytest.approx(forces.max(), rel=3e-4)
    assert len(places) == 2


@pytest.mark.parametrize("quantity", ["momentum", "width", "speed"])
@pytest.mark.parametrize("name", thinned(INTERVALS, 4))
def test_no_solution_is_missed(name: str, quantity: str) -> None:
    """A dense scan finds the same number of solutions."""
    given: dict[str, Any] = {"vary": name, "between": INTERVALS[name]}
    scan = sw.design(CASE_A, CHAIN, **given, target={quantity: 1.0}, points=1000)
    reached = np.array([option.reached for option in scan.table])
    wanted = float(np.quantile(reached, 0.7))
    count = int(((reached[1:] > wanted) != (reached[:-1] > wanted)).sum())
    assert len(sw.design(CASE_A, CHAIN, **given, target={quantity: wanted}).solutions) == count


@pytest.mark.parametrize("name", [name for name in POWERS if name not in ("chain.diameter", "shock.duration")])
@pytest.mark.parametrize("stretch", keeping([0.05, 1.0, 6.0], 1.0))
def test_exponents_agree_with_two_simulations(name: str, stretch: float) -> None:
    shock = sw.Shock(profile=POWER, peak_force=FORCE, rise_time=2.0 * stretch * UNITS.time)
    scenario = scenario_of(shock, CHAIN)
    found = exponents_of(scenario, curve_of(POWER, 1e-6, duration_of(scenario)))
    value, family = value_of(scenario, name), Family(scenario)
    ends = [family.scenario({name: value * factor}) for factor in (0.999, 1.001)]
    chains = [scene.chain for scene in ends]
    low, high = sw.simulate_many([scene.shock for scene in ends], chains, rtol=1e-11, waves="primary")
    assert isinstance(low, sw.SimulationResult)
    assert isinstance(high, sw.SimulationResult)
    known = math.log(high.peak_force / low.peak_force) / math.log(1.001 / 0.999)
    # the error of a difference over 0.2 % is of second order
    assert found.at(name) == pytest.approx(known, abs=found.error + 1e-5)


def test_an_unreachable_target_is_reported_with_the_range() -> None:
    found = design(peak_force=1000.0)
    assert found.solutions == ()
    assert not found.reachable
    assert found.nearest is not None
    assert found.nearest.value == 2e-3
    assert re.fullmatch(r"1 kN is out of reach: the maximum is 1\d\d\.\d+ N at 2 mm", found.why)
    assert re.match(r"no radius gives a peak force of 1 kN; nearest 2 mm \(simulated 1\d\d\.\d+ N\)\n", str(found))
    inside = design("chain.material.poisson_ratio", peak_force=1.0)
    assert inside.least.value == 0.0
    assert inside.why.endswith("at 0")


def of_granules(granules: int) -> sw.Design:
    chain = sw.Chain(material=CHAIN.material, radius=CHAIN.radius, granules=granules)
    return sw.design(CASE_A, chain, vary="chain.radius", target={"peak_force": 60}, between=(2e-3, 2e-2))


def test_a_finite_chain_is_treated_as_endless_and_simulated_with_its_granules() -> None:
    found = of_granules(60)
    (option,) = found.solutions
    assert max(map(len, str(found).splitlines())) <= 80
    assert option.chain_mass == pytest.approx(60 * option.granule_mass)
    assert any("60 granules" in warning for warning in found.warnings)
    assert option.simulated is not None
    assert option.simulated.peak_force == pytest.approx(60, rel=1e-3)


def test_a_chain_too_short_for_the_search_has_no_solution() -> None:
    found = of_granules(3)
    assert (found.solutions, found.reachable) == ((), False)
    assert found.nearest is not None
    assert found.nearest.simulated is not None
    # with three granules the peak force differs by more than 1 %
    assert abs(found.nearest.simulated.reached / 60 - 1) > 1e-2
    simulated = re.search(r"60 N needs an endless chain; .* its simulation gives ([\d.]+) N at ", found.why)
    assert simulated
    assert float(simulated[1]) == pytest.approx(found.nearest.simulated.reached, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "between"),
    [("shock.rise_time", (1e-5, 1.0)), ("shock.duration_ratio", (2, 1e4)), ("chain.radius", (1e-7, 1e-2))],
)
def test_an_interval_with_shocks_too_long_for_curves_is_refused(name: str, between: tuple[float, float]) -> None:
    match = r"^between: must contain only valid cases \(shock: must last at most 1000 characteristic times"
    with pytest.raises(sw.InvalidValueError, match=match):
        design(name, between, peak_force=60.0)


@pytest.mark.parametrize(
    "name", keeping(["chain.radius", "chain.material.poisson_ratio", "shock.duration_ratio"], "chain.radius")
)
def test_the_error_of_a_solution_moves_the_target_by_its_error(name: str) -> None:
    wanted = {"chain.radius": 60.0, "shock.duration_ratio": 150.0}.get(name) or at_a_quarter()
    option = design(name, peak_force=wanted).solutions[-1]
    assert option.value_error is not None
    family = Family(SCENE)
    value = float(option.value)
    ends = [family.scenario({name: value + sign * 1e-3 * value}) for sign in (-1, 1)]
    forces = [curve_of(end.shock.profile, 1e-6, 50.0).answer(end.shock, end.chain).peak_force for end in ends]
    slope = abs(math.log(forces[1] / forces[0])) / (2e-3 * value)
    # for parameters of the shape, the error is the tolerance of each simulation; for others, the bound of the curve
    error = max(option.reached_error, 1e-4) if name == "shock.duration_ratio" else option.reached_error
    assert option.value_error == pytest.approx(error / slope, rel=0.02)


def test_a_target_met_only_within_the_error_has_a_warning() -> None:
    most = design(peak_force=1000.0).most
    found = design(peak_force=most.reached * (1 + 3e-5))
    assert [option.value for option in found.solutions] == [2e-3]
    (warning,) = found.warnings
    assert warning.startswith("2 mm is an end or an extremum: it misses the target by -3e-05")
    assert design(peak_force=most.reached * (1 - 3e-5)).warnings == ()


def test_materials_within_the_error_are_solutions() -> None:
    given: dict[str, Any] = {"vary": "chain.material", "among": ["ptfe", "brass-260"]}
    low, high = sorted(option.reached for option in sw.design(CASE_A, CHAIN, target={"peak_force": 60}, **given).table)
    met = sw.design(CASE_A, CHAIN, target={"peak_force": high * (1 + 3e-5)}, **given)
    assert [option.value for option in met.solutions] == [met.table[0].value]
    assert met.solutions[0].simulated is not None
    assert met.reachable
    missed = sw.design(CASE_A, CHAIN, target={"peak_force": (low + high) / 2}, **given)
    assert missed.solutions == ()
    assert "no material gives" in missed.why


def test_progress_is_reported_for_each_material() -> None:
    reports: list[tuple[str, int, int | None]] = []
    with progress_shown(lambda *report: reports.append(report)):
        sw.design(CASE_A, CHAIN, vary="chain.material", among=["ptfe", "brass-260"], target={"peak_force": 60})
    assert [report for report in reports if report[0] == "materials"] == [("materials", k, 2) for k in range(3)]


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "vary-unknown": ({"vary": "chain.radios"}, "vary: must be the dotted name of a key .* did you mean"),
    "vary-known": ({"vary": "radius"}, r"vary: .*known: chain.material, chain.diameter, (?!.*predict)"),
    "vary-setting": (
        {"vary": "simulate.rtol"},
        "vary: must be a number or a material of the chain or the shock",
    ),
    "target-unknown": ({"target": {"peak_fource": 1}}, "target: .* did you mean 'peak_force'"),
    "target-unit": ({"target": {"peak_force": "3 mm"}}, "target.peak_force: must be a force"),
    "target-zero": ({"target": {"peak_force": 0}}, "target.peak_force: must be > 0 N"),
    "between-lacking": ({"between": None}, "between: must be the lower and the upper end"),
    "materials-between": ({"vary": "chain.material"}, "between: must be omitted for chain.material"),
    "between-order": ({"between": (2e-2, 1e-3)}, "between: must ascend"),
    "between-range": ({"between": (-1.0, 1.0)}, "between: must be > 0 m"),
    "among": ({"among": ["ptfe"]}, "among: must be omitted"),
    "points": ({"points": 1}, "points: must be a whole number >= 2"),
    "rtol": ({"rtol": 0.5}, "rtol: must be >= 1e-07 and <= 0.01"),
    "chain": ({"chain": None}, "scene: must be a scenario or its file alone, or a shock"),
}


@pytest.mark.parametrize(("other", "message"), REFUSED.values(), ids=REFUSED)
def test_wrong_arguments_are_refused(other: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"vary": "chain.radius", "target": {"peak_force": 60}, "between": (1e-3, 2e-2)}
    call = {"chain": CHAIN, **given, **other}
    with pytest.raises(sw.InvalidValueError, match=message):
        sw.design(CASE_A, call.pop("chain"), **call)


def test_the_command_ranks_materials_whose_range_has_the_target(capsys: pytest.CaptureFixture[str]) -> None:
    for force, status, sentence in (("110 N", 0, ""), ("9 kN", 1, "is out of reach")):
        arguments = ["--vary", "chain.material", "--among", "ptfe,brass-260", "--target", f"peak_force={force}"]
        assert cli.main(["design", FILE, *arguments]) == status
        printed = capsys.readouterr()
        assert printed.out.startswith("no material gives a peak force of ")
        assert sentence in printed.err


def test_the_command_draws_a_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "design.svg"
    arguments = ["--vary", "chain.radius", "--target", "peak_force=60 N", "--between", "1 mm", "20 mm"]
    assert cli.main(["design", FILE, *arguments, "-o", str(picture)]) == 0
    assert "<svg" in picture.read_text()
    assert capsys.readouterr().err == f"{picture}: written\n"


def test_the_command_draws_a_ranking_of_materials(tmp_path: Path) -> None:
    picture = tmp_path / "ranking.svg"
    arguments = ["--vary", "chain.material", "--among", "ptfe,brass-260", "--target", "peak_force=110 N"]
    assert cli.main(["design", FILE, *arguments, "-o", str(picture)]) == 0
    assert "<svg" in picture.read_text()


def test_a_picture_ranks_materials_from_the_top_and_marks_those_that_meet_the_target() -> None:
    names, target = ["brass-260", "ptfe", "nylon-66"], {"peak_force": "110 N"}
    found = sw.design(FILE, vary="chain.material", among=names, target=target, sign="<=")
    _, (ax,) = pictures.ranked_figure(len(names))
    pictures.materials(ax, found)
    shown = [label.get_text() for label in ax.get_yticklabels()]
    assert shown == [option.value for option in found.table]
    assert ax.get_ylim()[0] > ax.get_ylim()[1]
    met = next(line for line in ax.get_lines() if line.get_label() == "meets all")
    assert {shown[int(place)] for place in met.get_ydata()} == {"ptfe"}


def test_a_varied_peak_force_has_a_column_beside_that_of_the_wave() -> None:
    interval = {"between": ("50 N", "150 N"), "points": 2}
    found = sw.design(FILE, vary="shock.peak_force", target={"peak_force": 80.0}, **interval)
    assert str(found).startswith(f"shock peak force {found.solutions[0].value:.3g}"[:-1])
    header = next(line for line in str(found).splitlines() if "+-" in line and "error" in line)
    assert header.split("  +-")[0].strip() == "shock peak force"


def test_materials_meet_an_inequality() -> None:
    names, target = ["brass-260", "ptfe", "nylon-66"], {"peak_force": "120 N"}
    found = sw.design(FILE, vary="chain.material", among=names, target=target, sign="<=")
    assert {option.value for option in found.solutions} == {"ptfe", "nylon-66"}
    assert found.reachable
    assert str(found).startswith("material nylon-66 or ptfe gives a peak force <= 120 N")


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (["--between", "20 mm", "1 mm"], "--between"),
        (["--vary", "chain.material", "--among", "ptef"], "--among"),
        (["--target", "peak_force"], "--target"),
        (["--target", "sped=9"], "--target"),
        (["-o", "design.gif"], "--output: must end in"),
    ],
    ids=["order", "material", "form", "two", "ending"],
)
def test_a_wrong_argument_is_refused(arguments: list[str], error: str, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["--target", "peak_force=60 N"] + ([] if "--vary" in arguments else ["--vary", "chain.radius"])
    between = [] if {"--vary", "--between"} & set(arguments) else ["--between", "1 mm", "2 mm"]
    assert cli.main(["design", FILE, *given, *between, *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith(error)
    assert printed.out == ""


def test_the_command_lists_all_materials_that_meet_an_inequality(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "endless.yaml"
    shock = "{profile: triangular, peak_force: 100 N, rise_time: 20 us, duration_ratio: 3}"
    file.write_text(f"chain: {{material: paper-steel, diameter: 8 mm}}\nshock: {shock}\n")
    arguments = ["--vary", "chain.material", "--among", "ptfe,brass-260,nylon-66", "--target", "peak_force <= 100 N"]
    assert cli.main(["design", str(file), *arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [one["value"] for one in found["solutions"]] == ["nylon-66", "ptfe"]
    several = [*arguments, "--target", "amplification <= 2", "--least"]
    assert cli.main(["design", str(file), *several, "speed"]) == 0
    assert "minimised         speed" in capsys.readouterr().out
    assert cli.main(["design", str(file), *several[:-1]]) == 3
    assert "or state another quantity to minimise, --least" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("among", "message"),
    [([], r".* \(got \[\]"), ([sw.material("ptfe")], r".* \(got \[Material"), (5, r".* \(got 5")],
    ids=["none", "object", "number"],
)
def test_materials_to_compare_are_names(among: Any, message: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=f"^among: must be names of materials{message}"):
        sw.design(CASE_A, CHAIN, vary="chain.material", among=among, target={"peak_force": 60})


def test_one_material_to_compare_need_not_be_a_list() -> None:
    found = sw.design(CASE_A, CHAIN, vary="chain.material", among="ptfe", target="peak_force <= 1 kN")
    assert [one.value for one in found.table] == ["ptfe"]
