"""Limits of the transmitted force: which force is judged, the decision, and where it is shown."""

import json
import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import shockwave as sw
from shockwave import cli
from shockwave.scene.force_limit import LeavingForce, verdict
from shockwave.studies.quasi_monte_carlo import exceedance
from shockwave.sweep.runner import run_sweep

STEEL = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
SHOCK = sw.Shock(profile=sw.Triangular(duration_ratio=3.0), peak_force=100.0, rise_time=10e-6)
SCENE = """
chain: {{material: paper-steel, diameter: 9.5 mm{chain}}}
shock: {{profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}}
{more}
"""


def chain(**features: Any) -> sw.Chain:
    return sw.Chain(material=STEEL, radius=4.75e-3, **features)


def written(folder: Path, chain: str = "", more: str = "") -> str:
    file = folder / "scene.yaml"
    file.write_text(SCENE.format(chain=chain, more=more), encoding="utf-8")
    return str(file)


@pytest.mark.parametrize(
    ("low", "high", "decision"),
    [
        pytest.param(50.0, 59.9, "below", id="below"),
        pytest.param(60.1, 70.0, "above", id="above"),
        pytest.param(59.0, 61.0, "undecided", id="inside"),
        pytest.param(50.0, 60.0, "undecided", id="reaches-the-limit"),
        pytest.param(60.0, 60.0, "above", id="equals-the-limit"),
        pytest.param(50.0, None, "undecided", id="no-upper-end"),
        pytest.param(61.0, None, "above", id="no-upper-end-above"),
        pytest.param(None, None, "undecided", id="not-known"),
    ],
)
def test_a_verdict_is_decided_by_the_whole_range(low: float | None, high: float | None, decision: str) -> None:
    found = verdict(sw.Limit(force=60.0), LeavingForce(name="force", value=60.0, low=low, high=high, remedy="simulate"))
    assert found.decision == decision
    assert found.remedy == ("simulate" if decision == "undecided" else None)


@pytest.mark.parametrize(("limit", "decision"), [(30.0, "above"), (60.0, "undecided"), (80.0, "below")])
def test_a_greater_later_force_is_the_upper_end_of_the_range(limit: float, decision: str) -> None:
    force = LeavingForce(name="force", value=50.0, low=49.0, high=51.0, later=70.0)
    found = verdict(sw.Limit(force=limit), force)
    assert (found.high, found.decision) == (70.0, decision)
    assert found.remedy == ("simulate to a later end" if decision == "undecided" else None)


@pytest.mark.parametrize("error", [50.0, 60.0])
def test_a_force_of_unknown_error_decides_nothing(error: float) -> None:
    found = verdict(sw.Limit(force=60.0), LeavingForce.measured("force", 50.0, error))
    assert (found.low, found.high, found.decision) == (None, None, "undecided")


def test_a_semi_infinite_chain_is_judged_by_its_leading_wave() -> None:
    result = sw.simulate(SHOCK, chain())
    found = sw.Limit(force=1000.0).verdict(result)
    assert (found.value, found.decision) == (result.peak_force, "below")
    assert sw.Limit(force=1.0).verdict(result).decision == "above"


def test_a_prediction_is_judged_by_the_range_of_its_peak_force() -> None:
    outcome = sw.Predictor().predict(SHOCK, chain())
    found = sw.Limit(force=outcome.peak_force).verdict(outcome)
    assert (found.value, found.low, found.high) == (outcome.peak_force, outcome.low, outcome.high)
    assert found.low < found.value < found.high
    assert found.decision == "undecided"


def test_a_finite_chain_is_judged_by_its_last_contact_whatever_contacts_are_reported() -> None:
    whole = sw.simulate(SHOCK, chain(granules=20))
    last = whole.contacts[-1]
    assert last.contact == 18
    few = sw.simulate(SHOCK, chain(granules=20), contacts=[3])
    # the same run, whose error estimate covers the same contacts
    assert sw.Limit(force=1.0).verdict(few).value == pytest.approx(last.peak_force, rel=1e-12)


def test_a_wall_is_judged_by_the_force_on_it() -> None:
    result = sw.simulate(SHOCK, chain(granules=20, end=sw.Wall(material="same")))
    assert sw.Limit(force=1.0).verdict(result).value == result.transmitted.peak_force


def test_a_free_end_of_different_granules_is_judged_by_the_last_contact() -> None:
    segments = [sw.Segment(count=10), sw.Segment(count=5, radius=4e-3)]
    result = sw.simulate(SHOCK, chain(granules=segments))
    assert sw.Limit(force=1.0).verdict(result).value == result.contacts[-1].peak_force


def test_before_the_wave_arrives_no_force_is_below_the_limit() -> None:
    result = sw.simulate(SHOCK, chain(granules=20, end=sw.Wall(material="same")), until=50e-6)
    found = sw.Limit(force=1000.0).verdict(result)
    assert (found.decision, found.high) == ("undecided", None)


@pytest.mark.parametrize("features", [{"granules": 20}, {"granules": 20, "end": sw.Wall()}], ids=["free end", "wall"])
def test_a_prediction_for_a_finite_chain_is_judged_like_its_simulation(features: dict[str, Any]) -> None:
    for limit in (1.0, 1000.0):
        outcome, result = (run(SHOCK, chain(**features), limit=limit) for run in (sw.predict, sw.simulate))
        assert outcome.verdict == result.verdict
        assert outcome.verdict.decision == ("above" if limit == 1.0 else "below")


@pytest.mark.parametrize(
    ("features", "force"),
    [
        ({}, "peak force of the leading wave"),
        ({"granules": 200}, "force at the last contact"),
    ],
    ids=["endless", "finite"],
)
def test_section_4_alone_decides_no_limit(features: dict[str, Any], force: str) -> None:
    found = sw.predict(SHOCK, chain(**features), model="section-4", limit=1000.0).verdict
    assert (found.decision, found.value, found.high) == ("undecided", None, None)
    assert (found.force, found.remedy) == (force, "simulate")


def test_a_prediction_without_an_answer_states_what_would_decide_its_limit() -> None:
    found = sw.predict(SHOCK, chain(granules=20, end=sw.Wall()), timeout=1e-6, limit=1000.0).verdict
    assert (found.decision, found.value, found.force) == ("undecided", None, "force on the wall")
    assert found.remedy == "simulate with a longer timeout or a larger rtol"


@pytest.mark.parametrize("command", ["predict", "simulate", "compare"])
def test_commands_print_the_verdict_of_the_block(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, more="limit: {force: 1 kN}")
    assert cli.main([command, file, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["verdict"]
    assert (found["limit"], found["decision"]) == (1000.0, "below")
    assert cli.main([command, file]) == 0
    assert "below the limit of 1 kN" in capsys.readouterr().out.splitlines()[1]


def test_the_option_overrides_the_block(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, ", granules: 20, end: {wall: rigid}", "limit: {force: 1 kN}")
    assert cli.main(["simulate", file, "--json", "--limit", "10 N"]) == 0
    found = json.loads(capsys.readouterr().out)["verdict"]
    assert (found["limit"], found["decision"], found["force"]) == (10.0, "above", "force on the wall")


def test_without_a_limit_there_is_no_verdict(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["predict", written(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] is None


def test_a_table_of_several_files_shows_the_decisions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path)
    assert cli.main(["simulate", file, file, "--limit", "10 N"]) == 0
    header, _, *rows = capsys.readouterr().out.splitlines()
    assert header.split()[1] == "verdict"
    assert [row.split()[1] for row in rows[:2]] == ["above", "above"]


@pytest.mark.parametrize(
    ("run", "settings", "decisions"),
    [
        ("predict", "", ["below", "above"]),
        ("simulate", "", ["below", "above"]),
        ("compare", "", ["below", "above"]),
        ("predict", "predict: {model: section-4}\n", ["undecided", "undecided"]),
        ("predict", "simulate: {timeout: 1e-6}\n", ["undecided", "undecided"]),
    ],
    ids=["predict", "simulate", "compare", "section-4", "no answer"],
)
@pytest.mark.parametrize("features", ["", ", granules: 5, end: {wall: same}"], ids=["endless", "wall"])
def test_sweeps_have_a_column_of_decisions(
    features: str, run: str, settings: str, decisions: list[str], tmp_path: Path
) -> None:
    grid = f"limit: {{force: 60 N}}\nsweep: {{run: {run}, grid: {{shock.peak_force: [1 N, 1 kN]}}}}"
    file = written(tmp_path, features, settings + grid)
    with ThreadPoolExecutor(1) as executor:
        if features and "section-4" in settings:
            with pytest.raises(sw.NotCoveredError, match=r"chain\.end: must be left out"):
                run_sweep(file, tmp_path / "out", executor)
            return
        run_sweep(file, tmp_path / "out", executor)
    rows = [json.loads(line) for line in (tmp_path / "out" / "results.jsonl").read_text().splitlines()]
    assert [row["verdict"] for row in rows] == decisions


def test_a_report_states_the_verdict(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    page = tmp_path / "page.html"
    assert cli.main(["report", written(tmp_path), "--limit", "10 N", "-o", str(page)]) == 0
    assert "Verdict: <strong>above the limit of 10 N: " in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("given", ["-3 N", "3 s", "much"])
def test_a_limit_that_is_no_force_is_a_wrong_usage(
    given: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        cli.main(["predict", written(tmp_path), f"--limit={given}"])
    assert stop.value.code == 2
    assert "--limit: must be " in capsys.readouterr().err


def test_errors_of_the_block_are_located(tmp_path: Path) -> None:
    with pytest.raises(sw.ScenarioError, match=r"scene.yaml:4:16: limit.force: must be > 0 N \(got '-1 N'"):
        sw.load_scenario(written(tmp_path, more="limit: {force: -1 N}"))


# ---------------------------------------------------------------- probability of exceedance

UNCERTAIN = "uncertainty: {shock.peak_force: 10 %, chain.diameter: {between: [9 mm, 10 mm]}}"


def test_the_probability_of_exceedance_is_that_of_the_quantiles(tmp_path: Path) -> None:
    scene = sw.load_scenario(written(tmp_path, more=UNCERTAIN))
    quantile = sw.uncertainty(scene, draws=1024).peak_force.quantiles[0.75]
    found = sw.uncertainty(scene, draws=1024, limit=sw.Limit(force=quantile.value)).exceedance
    assert found is not None
    assert found.low < 0.25 < found.high
    assert found.probability == pytest.approx(0.25, abs=1 / 1024)


def test_the_interval_of_a_probability_includes_the_error_of_each_force() -> None:
    forces = np.linspace(0.0, 1.0, 1600).reshape(100, 16).T
    exact, _ = exceedance(sw.Limit(force=0.5), "force", forces, 0.0)
    coarse, _ = exceedance(sw.Limit(force=0.5), "force", forces, 0.1)
    assert exact.probability == coarse.probability == 0.5
    # forces from 0.5 / 1.1 to 0.5 / 0.9 may or may not reach the limit
    assert coarse.low == pytest.approx(exact.low - (0.5 / 0.9 - 0.5), abs=3e-3)
    assert coarse.high == pytest.approx(exact.high + (0.5 - 0.5 / 1.1), abs=3e-3)


def test_a_probability_without_any_exceedance_is_not_known_to_be_zero() -> None:
    found, judged = exceedance(sw.Limit(force=2.0), "force", np.full((16, 64), 1.0), 1e-4)
    assert (found.probability, found.low) == (0.0, 0.0)
    assert found.high == pytest.approx(3 / 1024)
    assert judged.decision == "below"


def test_scenes_without_a_known_bound_are_undecided_and_counted() -> None:
    forces = np.linspace(0.0, 1.0, 1600).reshape(100, 16).T
    # a quarter of the scenes may be struck harder later, half of them by less than the limit
    later = np.where(forces < 0.125, math.inf, np.where(forces < 0.25, 0.4, 0.0))
    found, judged = exceedance(sw.Limit(force=0.5), "force", forces, 0.0, later)
    assert (found.probability, found.draws, found.undecided) == (0.5, 1600, 200)
    assert 0.5 + 0.125 < found.high < 0.5 + 0.125 + 0.01
    assert str(found).endswith("; 200 of 1600 scenes are undecided")
    assert judged.decision == "undecided"
    # a force that is not known, too
    unknown, _ = exceedance(sw.Limit(force=0.5), "force", np.where(forces > 0.75, math.nan, forces), 0.0)
    assert unknown.undecided == pytest.approx(400, abs=1)


def test_uncertain_finite_chains_are_judged_by_the_force_that_leaves_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for more, force in (("", "force at the last contact"), (", end: {wall: same}", "force on the wall")):
        file = written(tmp_path, f", granules: 6{more}", "uncertainty: {shock.peak_force: 10 %}")
        assert cli.main(["uncertainty", file, "--draws", "256", "--limit", "1 N", "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        expected = {"limit": 1.0, "probability": 1.0, "low": 1 - 3 / 256, "high": 1.0, "draws": 256, "undecided": 0}
        assert found["exceedance"] == expected
        assert (found["verdict"]["decision"], found["verdict"]["force"]) == ("above", force)


def test_the_probability_is_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, more=f"{UNCERTAIN}\nlimit: {{force: 1 kN}}")
    assert cli.main(["uncertainty", file, "--draws", "1024"]) == 0
    assert "exceedance        probability 0 %, between 0 % and 0.29 %\n" in capsys.readouterr().out


# ---------------------------------------------------------------- scenes beyond one row of equal spheres


def test_uncertainties_of_a_packing_are_those_of_its_contacts(tmp_path: Path) -> None:
    file = written(tmp_path, ", packing: hexagonal", "uncertainty: {shock.peak_force: 5 %}")
    peak_force = sw.uncertainty(sw.load_scenario(file), draws=256).peak_force
    assert peak_force is not None
    assert peak_force.nominal == pytest.approx(sw.simulate(file).peak_force, rel=1e-4)


def test_a_force_without_a_limit_along_the_chain_leaves_the_verdict_open(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # one parameter and one quantity, too
    more = "simulate: {contacts: [0]}\nuncertainty: {shock.peak_force: 5 %}"
    file = written(tmp_path, ", precompression: 2 N", more)
    assert cli.main(["uncertainty", file, "--draws", "256", "--json", "--limit", "60 N"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["exceedance"] is None
    assert (found["verdict"]["decision"], found["verdict"]["value"]) == ("undecided", None)


def test_a_wave_that_has_not_arrived_leaves_the_verdict_open(tmp_path: Path) -> None:
    more = "simulate: {until: 15 us}\nuncertainty: {shock.peak_force: 5 %, shock.rise_time: 5 %}"
    scene = sw.load_scenario(written(tmp_path, ", granules: 8, end: {wall: same}", more))
    found = sw.uncertainty(scene, draws=256, limit=sw.Limit(force=60.0))
    assert found.verdict is not None
    assert found.verdict.decision == "undecided"
    assert "undecided for the limit of 60 N" in str(found)


def test_gravity_leaves_a_comparison_without_prediction(tmp_path: Path) -> None:
    file = written(tmp_path, ", granules: 10, gravity: 9.81, end: {wall: rigid}")
    assert sw.compare(file).predicted is None
    with pytest.raises(sw.NotCoveredError, match=r"scene.yaml:2:\d+: chain.gravity: must be left out"):
        sw.predict(file, model="section-4")


@pytest.mark.parametrize("result", [3, "text", None], ids=["number", "text", "nothing"])
def test_a_verdict_needs_a_result(result: object) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^result: must be the result of a prediction or a simulation"):
        sw.Limit(force=3.0).verdict(result)


def test_the_verdict_of_a_comparison_is_that_of_its_simulation() -> None:
    both = sw.compare(SHOCK, chain(), limit=60.0)
    assert both.verdict == sw.simulate(SHOCK, chain(), limit=60.0).verdict is not None
    with pytest.raises(sw.InvalidValueError, match=r"^result: must be the result of a prediction or a simulation"):
        sw.Limit(force=60.0).verdict(both)


def test_a_later_collision_that_may_reach_the_limit_leaves_the_verdict_open(tmp_path: Path) -> None:
    # the soft beads hold back the heavy striker, and the wall is pushed most when they let it go
    granules = ", granules: [{count: 6}, {count: 5, material: ptfe}, {count: 2}], end: {wall: same}"
    file = Path(written(tmp_path, granules, "uncertainty: {impact.velocity: 3 %}\nlimit: {force: 100 N}"))
    shock = next(line for line in file.read_text().splitlines() if line.startswith("shock"))
    file.write_text(file.read_text().replace(shock, "impact: {velocity: 0.3 m/s, diameter: 25 mm}"))
    scene = sw.load_scenario(file)
    early, late = (sw.simulate(scene.excitation, scene.chain, until=until) for until in (None, 20e-3))
    first, last = early.transmitted.peak_force, late.transmitted.peak_force
    assert first < 100.0 < last < early.later_force
    assert any("A later collision may exert a greater force on the wall" in each for each in early.warnings)
    found = scene.limit.verdict(early)
    assert (found.decision, found.high, found.remedy) == ("undecided", early.later_force, "simulate to a later end")
    assert scene.limit.verdict(late).decision == "above"
    assert sw.Limit(force=2 * early.later_force).verdict(early).decision == "below"
    uncertain = sw.uncertainty(scene, draws=256)
    assert uncertain.exceedance.undecided == uncertain.exceedance.draws == 256
    assert uncertain.exceedance.high == 1.0
    assert uncertain.verdict.decision == "undecided"
    assert sw.Limit(force=0.9 * first).verdict(early).decision == "above"


@pytest.mark.parametrize(
    ("load", "bounded"),
    [
        ({"gravity": 9.81, "end": sw.Wall(material="same")}, True),
        ({"precompression": 1.0, "end": sw.Wall(material="same", mass=0.02, stiffness=1e5)}, True),
        ({"gravity": 9.81, "end": sw.Wall(material="same", mass=0.02, stiffness=1e5)}, False),
    ],
    ids=["gravity", "precompression", "gravity and a movable wall"],
)
def test_a_static_load_leaves_the_verdict_open_where_a_later_force_may_exceed_the_limit(
    load: dict[str, Any], bounded: bool
) -> None:
    # the heavy striker pushes the wall most when it comes again
    chain = sw.Chain(material="stainless-steel-302", diameter=20e-3, granules=3, **load)
    impact = sw.Impact(velocity=0.3, diameter=100e-3)
    early, late = (sw.simulate(impact, chain, until=until) for until in (None, 30e-3))
    assert early.transmitted.peak_force < late.transmitted.peak_force <= early.later_force
    assert (early.later_force < math.inf) == bounded
    between = sw.Limit(force=(early.transmitted.peak_force + late.transmitted.peak_force) / 2)
    assert between.verdict(early).decision == "undecided"
    if bounded:  # the bound is not needlessly large
        assert early.later_force < 5 * late.transmitted.peak_force


def test_a_chain_that_flies_apart_keeps_its_verdict() -> None:
    for end in (sw.Wall(material="same"), None):
        chain = sw.Chain(material="bearing-steel-52100", diameter=9.5e-3, granules=20, end=end)
        result = sw.simulate(sw.Impact(velocity=0.5), chain)
        force = result.contacts[-1].peak_force if end is None else result.transmitted.peak_force
        assert sw.Limit(force=1.01 * force).verdict(result).decision == "below"


def test_a_wave_is_awaited_at_the_last_of_equal_granules(tmp_path: Path) -> None:
    more = "simulate: {until: 60 us}\nlimit: {force: 45 N}"
    result = sw.simulate(written(tmp_path, ", granules: 12", more))
    assert result.verdict.remedy == "simulate to a later end"
    assert result.greatest_force == max(result.contacts, key=lambda contact: contact.peak_force)
    assert str(result).split(": ", 1)[1].startswith("greatest force ")


def test_a_wall_that_no_force_has_reached_has_no_error_estimate(tmp_path: Path) -> None:
    file = written(tmp_path, ", granules: 20, end: {wall: same}", "simulate: {until: 50 us}")
    wall = sw.predict(file).to_dict()["transmitted"]
    assert (wall["peak_force"], wall["low"], wall["high"], wall["error_estimate"]) == (0.0, 0.0, None, None)


@pytest.mark.parametrize("limit", [1000.0, "1 kN", sw.Limit(force=1000.0)], ids=["number", "text", "limit"])
def test_a_limit_is_given_as_a_force(limit: Any, tmp_path: Path) -> None:
    scene = sw.load_scenario(written(tmp_path, more="limit: {force: 1 N}"))
    spreads = {"shock.peak_force": "5 %"}
    for given in ((scene,), (scene.shock, scene.chain)):
        for run in (sw.predict, sw.simulate, sw.compare):
            found = run(*given, limit=limit).verdict
            assert (found.limit, found.decision) == (1000.0, "below")
        exceedance = sw.uncertainty(*given, spreads=spreads, draws=256, limit=limit).exceedance
        assert exceedance is not None
        assert exceedance.limit == 1000.0


@pytest.mark.parametrize("run", [sw.predict, sw.simulate, sw.compare])
def test_a_limit_that_is_no_force_is_refused(run: Any) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^limit: must be a force"):
        run(SHOCK, chain(), limit="80 mm")


def test_a_wall_that_flies_off_keeps_no_verdict_open() -> None:
    chain = sw.Chain(material="stainless-steel-302", diameter=9.5e-3, granules=10, end=sw.Wall(mass=3.6e-3))
    result = sw.simulate(sw.Impact(velocity=0.5), chain, until=10e-3)
    assert sw.Limit(force=1.01 * result.transmitted.peak_force).verdict(result).decision == "below"


def test_a_shock_that_still_acts_leaves_the_verdict_open() -> None:
    chain = sw.Chain(material="stainless-steel-302", diameter=9.5e-3, granules=6, end=sw.Wall(material="same"))
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=5.0), peak_force=50.0, rise_time=0.3e-3)
    result = sw.simulate(shock, chain, until=1e-3)
    found = sw.Limit(force=2 * result.transmitted.peak_force).verdict(result)
    assert (found.decision, found.high) == ("undecided", None)
    assert any("The shock ends after the simulated time" in each for each in result.warnings)
