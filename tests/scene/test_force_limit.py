"""Limits of the transmitted force: which force is judged, the decision, and where it is shown."""

from __future__ import annotations

import json
import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attrs import evolve

import shockwave as sw
from shockwave.scene.force_limit import LAST, WALL, WAVE, LeavingForce, verdict
from shockwave.studies.quasi_monte_carlo import exceedance
from shockwave.sweep.runner import run_sweep
from support.command_line import scenario, shockwave
from support.scenes import STEEL

#: A transmitted force.
FORCE = LeavingForce(name="force")
SHOCK = sw.Shock(profile=sw.Triangular(duration_ratio=3.0), peak_force=100.0, rise_time=10e-6)
#: A chain of 20 granules, whose wall has not been reached after 50 us.
WALLED: dict[str, Any] = {"granules": 20, "end": sw.Wall()}


def chain(**features: Any) -> sw.Chain:
    return sw.Chain(material=STEEL, radius=4.75e-3, **features)


def written(folder: Path, features: str = "", *more: str) -> Path:
    """The scenario of SHOCK on a chain."""
    shock = "shock: {profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}"
    return scenario(folder, f"chain: {{material: paper-steel, diameter: 9.5 mm{features}}}", shock, *more)


# ---------------------------------------------------------------- the decision


@pytest.mark.parametrize(
    ("low", "high", "decision"),
    [
        pytest.param(50.0, 59.9, "below", id="below"),
        pytest.param(59.0, 61.0, "undecided", id="inside"),
        pytest.param(50.0, 60.0, "undecided", id="reaches-the-limit"),
        pytest.param(60.0, 60.0, "above", id="equals-the-limit"),
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
    assert found.remedy == ("set a later simulate.until" if decision == "undecided" else None)


def test_a_later_end_is_the_remedy_only_where_the_force_itself_is_below_the_limit() -> None:
    force = LeavingForce(name="force", value=50.0, low=49.0, high=61.0, later=70.0, remedy="narrow")
    assert verdict(sw.Limit(force=60.0), force).remedy == "narrow"
    forces = np.linspace(50.0, 61.0, 1600).reshape(100, 16).T
    _, judged = exceedance(sw.Limit(force=60.0), FORCE, forces, 1e-4, 70.0)
    assert judged.remedy == "narrow the distributions"


@pytest.mark.parametrize(
    ("limit", "shown"),
    [(38.948664, "38.948664 N"), ("20 lbf", "88.9644 N"), ("0.1 kip", "444.822 N")],
    ids=["newtons", "pounds", "kip"],
)
def test_a_limit_is_shown_as_it_was_stated_or_rounded(limit: float | str, shown: str) -> None:
    judged = verdict(sw.Limit(force=limit), LeavingForce(name="force", value=50.0, low=49.0, high=51.0))
    assert f"the limit of {shown}:" in str(judged)


@pytest.mark.parametrize(
    ("low", "high", "limit", "figures"),
    [
        (595.13, None, 597.0, "595 N or more"),
        (595.13, None, 595.12, "595.13 N or more"),
        (550.0, 640.2, 640.1, "range 550 N to 641 N"),
        (550.0, 640.2, 640.5, "range 550 N to 640.2 N"),
    ],
    ids=["lower bound", "beside the limit", "range", "upper end beside the limit"],
)
def test_ends_of_a_range_are_rounded_outwards_but_not_across_the_limit(
    low: float, high: float | None, limit: float, figures: str
) -> None:
    force = LeavingForce(name="force", value=595.2, low=low, high=high)
    judged = verdict(sw.Limit(force=limit), evolve(force, spring=force))
    assert figures in str(judged).partition(";")[0]
    assert figures in str(judged.beside)


def test_the_verdict_and_the_first_line_round_a_force_alike() -> None:
    # the error estimate is relative to the small dynamic part of the force
    steel = chain(granules=20, end=sw.Wall(), precompression=500.0)
    result = sw.simulate(SHOCK, steel, rtol=1e-2, limit=2000.0)
    assert result.transmitted.error_estimate > 2 * result.transmitted.total_error
    number = str(result.verdict).partition("force on the wall ")[2].partition(" N")[0]
    assert f"force {number} N on the wall" in str(result)
    assert f"force on the wall {number} N," in str(sw.predict(SHOCK, steel, rtol=1e-2))


@pytest.mark.parametrize("error", [50.0, 60.0])
def test_a_force_of_unknown_error_decides_nothing(error: float) -> None:
    found = verdict(sw.Limit(force=60.0), LeavingForce.from_simulation("force", 50.0, error))
    assert (found.low, found.high, found.decision) == (None, None, "undecided")


# ---------------------------------------------------------------- the force that is judged


@pytest.mark.parametrize(
    ("features", "force"),
    [
        ({}, WAVE),
        ({"granules": 20}, LAST),
        ({"granules": [sw.Segment(count=10), sw.Segment(count=5, radius=4e-3)]}, LAST),
        (WALLED, WALL),
    ],
    ids=["endless", "equal", "different", "wall"],
)
def test_the_force_that_leaves_the_chain_is_judged_alike_in_predictions_and_simulations(
    features: dict[str, Any], force: str
) -> None:
    result = sw.simulate(SHOCK, chain(**features))
    forces = {WAVE: lambda: result.peak_force, LAST: lambda: result.contacts[-1].peak_force}
    value = forces.get(force, lambda: result.transmitted.peak_force)()
    for limit, decision in ((1.0, "above"), (1000.0, "below")):
        found = sw.Limit(force=limit).verdict(result)
        assert (found.value, found.force, found.decision) == (value, force, decision)
        assert features == {} or sw.predict(SHOCK, chain(**features), limit=limit).verdict == found


def test_a_prediction_is_judged_by_the_range_of_its_peak_force() -> None:
    outcome = sw.predict(SHOCK, chain())
    found = sw.Limit(force=outcome.peak_force).verdict(outcome)
    assert (found.value, found.low, found.high) == (outcome.peak_force, outcome.low, outcome.high)
    assert found.low < found.value < found.high
    assert found.decision == "undecided"


def test_the_last_contact_is_judged_whatever_contacts_are_reported() -> None:
    whole, few = (sw.simulate(SHOCK, chain(granules=20), contacts=contacts) for contacts in ([3, 18], [3]))
    # the same run, whose error estimate covers the same contacts
    assert sw.Limit(force=1.0).verdict(few).value == pytest.approx(whole.contacts[1].peak_force, rel=1e-12)


def test_the_verdict_of_a_comparison_is_that_of_its_simulation() -> None:
    both = sw.compare(SHOCK, chain(), limit=60.0)
    assert both.verdict == sw.simulate(SHOCK, chain(), limit=60.0).verdict is not None
    assert sw.Limit(force=60.0).verdict(both) == both.verdict
    with pytest.raises(sw.InvalidValueError, match=r"^result: must be the result of a prediction or a simulation"):
        sw.Limit(force=60.0).verdict(3)


# ---------------------------------------------------------------- verdicts that remain open


def test_before_the_wave_arrives_no_force_is_below_the_limit() -> None:
    result = sw.simulate(SHOCK, chain(**WALLED), until=50e-6)
    found = sw.Limit(force=1000.0).verdict(result)
    assert (found.decision, found.high) == ("undecided", None)
    assert "force on the wall has not acted yet" in str(found)
    wall = sw.predict(SHOCK, chain(**WALLED), until=50e-6).to_dict()["transmitted"]
    assert (wall["peak_force"], wall["low"], wall["high"], wall["error_estimate"]) == (0.0, 0.0, None, None)


@pytest.mark.parametrize(("features", "force"), [({}, WAVE), ({"granules": 200}, LAST)], ids=["endless", "finite"])
def test_section_4_alone_decides_no_limit(features: dict[str, Any], force: str) -> None:
    found = sw.predict(SHOCK, chain(**features), model="section-4", limit=1000.0).verdict
    assert (found.decision, found.value, found.high) == ("undecided", None, None)
    assert (found.force, found.remedy) == (force, "simulate")


def test_a_prediction_without_an_answer_states_what_would_decide_its_limit() -> None:
    found = sw.predict(SHOCK, chain(**WALLED), timeout=1e-6, limit=1000.0).verdict
    assert (found.decision, found.value, found.force) == ("undecided", None, WALL)
    assert found.remedy == "simulate with a longer timeout or a larger rtol"


def test_a_range_within_the_simulated_time_is_shown_apart_from_the_bound_of_later_forces() -> None:
    force = LeavingForce(name=WALL, value=225.0, low=208.0, high=237.0, later=551.0)
    assert "force on the wall 225 N, range 208 N to 237 N, later at most 551 N" in str(
        verdict(sw.Limit(force=300), force)
    )
    assert "range 208 N to 237 N;" in str(verdict(sw.Limit(force=230), evolve(force, later=0.0)))


def test_a_wave_is_awaited_at_the_last_of_equal_granules() -> None:
    result = sw.simulate(SHOCK, chain(granules=12), until=60e-6, limit=45.0)
    assert result.verdict.remedy == "set simulate.until: 200 us"
    assert result.greatest_force == max(result.contacts, key=lambda contact: contact.peak_force)
    assert str(result).startswith("greatest force ")


@pytest.mark.usefixtures("few_draws")
def test_a_later_collision_that_may_reach_the_limit_leaves_the_verdict_open() -> None:
    # the soft beads hold back the heavy striker, and the wall is pushed most when they let it go
    granules = [sw.Segment(count=6), sw.Segment(count=5, material="ptfe"), sw.Segment(count=2)]
    scene = sw.Impact(velocity=0.3, diameter=25e-3), chain(granules=granules, end=sw.Wall())
    early, late = (sw.simulate(*scene, until=until) for until in (None, 20e-3))
    first, last = early.transmitted.peak_force, late.transmitted.peak_force
    limit = sw.Limit(force=100.0)
    assert first < limit.force < last < early.leaving.later
    assert any("A later collision may exert a greater force on the wall" in each for each in early.warnings)
    found = limit.verdict(early)
    assert (found.decision, found.high) == ("undecided", early.leaving.later)
    assert found.remedy.startswith("set simulate.until: ")
    assert limit.verdict(late).decision == "above"
    assert sw.Limit(force=2 * early.leaving.later).verdict(early).decision == "below"
    assert sw.Limit(force=0.9 * first).verdict(early).decision == "above"
    uncertain = sw.uncertainty(*scene, spreads={"impact.velocity": "3 %"}, draws=64, limit=limit)
    assert uncertain.exceedance.undecided == uncertain.exceedance.draws == 64
    assert uncertain.exceedance.high == 1.0
    assert uncertain.verdict.decision == "undecided"


@pytest.mark.parametrize(
    "load",
    [
        {"gravity": 9.81, "end": sw.Wall()},
        {"precompression": 1.0, "end": sw.Wall(mass=0.02, stiffness=1e5)},
        {"gravity": 9.81, "end": sw.Wall(mass=0.02, stiffness=1e5)},
    ],
    ids=["gravity", "precompression", "gravity and a movable wall"],
)
def test_a_static_load_leaves_the_verdict_open_where_a_later_force_may_exceed_the_limit(load: dict[str, Any]) -> None:
    # the heavy striker pushes the wall most when it comes again
    chain = sw.Chain(material="stainless-steel-302", diameter=20e-3, granules=3, **load)
    impact = sw.Impact(velocity=0.3, diameter=100e-3)
    early, late = (sw.simulate(impact, chain, until=until) for until in (None, 30e-3))
    # without damping, the energy under a static load stays, and no end of the simulated time decides
    remedy = "state a damping (without damping, waves never cease)"
    assert early.leaving.later_remedy == late.leaving.later_remedy == remedy
    assert not any("simulate.until" in each for each in (*early.warnings, *late.warnings))
    assert any("waves never cease" in each for each in early.warnings)
    assert early.transmitted.peak_force < late.transmitted.peak_force <= early.leaving.later
    between = sw.Limit(force=(early.transmitted.peak_force + late.transmitted.peak_force) / 2)
    assert between.verdict(early).decision == "undecided"
    # the bound is not needlessly large
    assert early.leaving.later < 5 * late.transmitted.peak_force


@pytest.mark.parametrize(("stiffness", "until"), [(1e6, "700 us"), (1e3, "20 ms")], ids=["stiff", "soft"])
def test_the_advised_time_exceeds_half_a_period_of_the_wall_on_its_spring(stiffness: float, until: str) -> None:
    end = sw.Wall(mass=0.02, stiffness=stiffness, damping=1.0)
    impact = sw.Impact(velocity=0.5)
    found = sw.simulate(impact, chain(granules=2, end=end), until="0.2 ms", limit=sw.Limit(force=200.0, at="spring"))
    assert any(f"(set simulate.until: {until})" in warning for warning in found.warnings)


@pytest.mark.parametrize("early", ["3 ms", "30 ms"], ids=["rising", "high up"])
def test_the_advised_time_decides_after_a_weight_has_fallen_back(early: str) -> None:
    pad = sw.Segment(contact=sw.PowerContact(exponent=1, stiffness=1e6), damping=sw.Dashpot(coefficient="20 N*s/m"))
    row = sw.Chain(
        material="bearing-steel-52100",
        diameter=20e-3,
        granules=[sw.Segment(count=2), pad],
        gravity=9.81,
        end=sw.Wall(material="rigid"),
    )
    weight = sw.Impact(velocity=0.5, diameter=60e-3)
    result = sw.simulate(weight, row, until=early)
    limit = 1.01 * result.transmitted.peak_force
    undecided = sw.Limit(force=limit).verdict(result)
    assert undecided.decision == "undecided"
    until = undecided.remedy.removeprefix("set simulate.until: ")
    assert any("A later collision may" in each and until in each for each in result.warnings)
    assert sw.simulate(weight, row, until=until, limit=limit).verdict.decision == "below"


def test_a_drop_weight_that_comes_to_rest_on_a_spring_is_below_a_limit() -> None:
    end = sw.Wall(mass=0.02, stiffness=1e5, damping=20.0)
    damping = sw.KuwabaraKono(time=5e-6)
    chain = sw.Chain(material="stainless-steel-302", diameter=20e-3, granules=3, gravity=9.81, end=end, damping=damping)
    impact = sw.Impact(velocity=0.3, diameter=100e-3)
    early, late = (sw.simulate(impact, chain, until=until) for until in (3e-3, 0.5))
    peak = late.structure.peak_spring_force
    assert peak <= early.leaving.spring.later < math.inf
    assert late.transmitted.peak_force <= early.leaving.later
    limit = sw.Limit(force=1.05 * peak, at="spring")
    assert (limit.verdict(early).decision, limit.verdict(late).decision) == ("undecided", "below")
    # the spring carries the weight of the striker
    assert 9.81 * 7860 * 4 / 3 * math.pi * 0.05**3 < late.leaving.spring.later < early.leaving.spring.later


def test_a_wall_that_gives_way_under_the_weight_of_a_striker_leaves_the_verdict_open() -> None:
    chain = sw.Chain(material="stainless-steel-302", diameter=20e-3, granules=3, gravity=9.81, end=sw.Wall(mass=0.02))
    found = sw.simulate(sw.Impact(velocity=0.3, diameter=100e-3), chain, limit="1 MN").verdict
    assert (found.decision, found.high) == ("undecided", None)
    assert found.remedy.startswith("state chain.end.stiffness")


@pytest.mark.parametrize(
    ("end", "until"),
    [(sw.Wall(), None), (None, None), (sw.Wall(mass=3.6e-3), 10e-3)],
    ids=["wall", "free", "movable wall"],
)
def test_a_chain_that_flies_apart_keeps_its_verdict(end: sw.Wall | None, until: float | None) -> None:
    result = sw.simulate(sw.Impact(velocity=0.5), chain(granules=20, end=end), until=until)
    force = result.contacts[-1].peak_force if end is None else result.transmitted.peak_force
    assert sw.Limit(force=1.01 * force).verdict(result).decision == "below"


def test_a_shock_that_still_acts_leaves_the_verdict_open() -> None:
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=5.0), peak_force=50.0, rise_time=0.3e-3)
    result = sw.simulate(shock, chain(granules=6, end=sw.Wall()), until=1e-3)
    found = sw.Limit(force=2 * result.transmitted.peak_force).verdict(result)
    assert (found.decision, found.high) == ("undecided", None)
    assert any("The shock ends after the simulated time" in each for each in result.warnings)


# ---------------------------------------------------------------- where a limit is given and shown


@pytest.mark.parametrize("command", ["predict", "simulate", "compare"])
def test_the_option_of_a_command_overrides_the_block(command: str, tmp_path: Path) -> None:
    file = written(tmp_path, "", "limit: {force: 10 N}")
    for options, limit, decision in (((), 10.0, "above"), (("--limit", "1 kN"), 1000.0, "below")):
        found = shockwave(command, file, "--json", *options).document["verdict"]
        assert (found["limit"], found["decision"]) == (limit, decision)
    assert "below the limit of 1 kN" in shockwave(command, file, "--limit", "1 kN").out.splitlines()[1]
    assert shockwave(command, written(tmp_path), "--json").document["verdict"] is None


def test_a_table_of_several_files_shows_the_decisions(tmp_path: Path) -> None:
    file = written(tmp_path)
    header, _, *rows = shockwave("simulate", file, file, "--limit", "10 N").out.splitlines()
    assert header.split()[1] == "verdict"
    assert [row.split()[1] for row in rows[:2]] == ["above", "above"]


@pytest.mark.parametrize(
    ("run", "settings", "decisions"),
    [
        ("predict", "", ["below", "above"]),
        ("simulate", "", ["below", "above"]),
        ("compare", "", ["below", "above"]),
        ("predict", "predict: {model: section-4}", ["undecided", "undecided"]),
        ("predict", "simulate: {timeout: 1e-6}", ["undecided", "undecided"]),
    ],
    ids=["predict", "simulate", "compare", "section-4", "no answer"],
)
def test_sweeps_have_a_column_of_decisions(run: str, settings: str, decisions: list[str], tmp_path: Path) -> None:
    grid = f"sweep: {{run: {run}, grid: {{shock.peak_force: [1 N, 1 kN]}}}}"
    features = ", granules: 5, end: {wall: same}" if "timeout" in settings else ""
    with ThreadPoolExecutor(1) as executor:
        run_sweep(written(tmp_path, features, settings, "limit: {force: 60 N}", grid), tmp_path / "out", executor)
    rows = [json.loads(line) for line in (tmp_path / "out" / "results.jsonl").read_text().splitlines()]
    assert [row["verdict"] for row in rows] == decisions


def test_a_report_states_the_verdict(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shockwave.report.html_page.choose_pictures", lambda _: {})  # a page without pictures
    page = tmp_path / "page.html"
    assert shockwave("report", written(tmp_path), "--limit", "10 N", "-o", page).status == 0
    assert "Verdict: <strong>above the limit of 10 N: " in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("limit", ["-3 N", "3 s"])
def test_a_limit_that_is_no_force_is_refused(limit: str, tmp_path: Path) -> None:
    answer = shockwave("predict", written(tmp_path), f"--limit={limit}")
    assert answer.status == 2
    assert answer.err.startswith("--limit: limit.force: must be ")
    for run in (sw.predict, sw.simulate, sw.compare):
        with pytest.raises(sw.InvalidValueError, match=r"^limit: must be "):
            run(SHOCK, chain(), limit=limit)
    with pytest.raises(sw.ScenarioError, match=rf"scene.yaml:3:16: limit.force: must be .*\(got '{limit}'"):
        sw.load_scenario(written(tmp_path, "", f"limit: {{force: {limit}}}"))


@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize("limit", [1000.0, "1 kN", sw.Limit(force=1000.0)], ids=["number", "text", "limit"])
def test_a_limit_is_given_as_a_force(limit: Any, tmp_path: Path) -> None:
    scene = sw.load_scenario(written(tmp_path, "", "limit: {force: 1 N}"))
    for given in ((scene,), (scene.shock, scene.chain)):
        for run in (sw.predict, sw.simulate, sw.compare):
            found = run(*given, limit=limit).verdict
            assert (found.limit, found.decision) == (1000.0, "below")
        exceedance = sw.uncertainty(*given, spreads={"shock.peak_force": "5 %"}, draws=64, limit=limit).exceedance
        assert exceedance.limit == 1000.0


# ---------------------------------------------------------------- probability of exceedance


def test_the_probability_of_exceedance_is_that_of_the_quantiles(tmp_path: Path) -> None:
    block = "uncertainty: {shock.peak_force: 10 %, chain.diameter: {between: [9 mm, 10 mm]}}"
    scene = sw.load_scenario(written(tmp_path, "", block))
    quantile = sw.uncertainty(scene, draws=256).peak_force.quantiles[0.75]
    found = sw.uncertainty(scene, draws=256, limit=sw.Limit(force=quantile.value)).exceedance
    assert found.low < 0.25 < found.high
    assert found.probability == pytest.approx(0.25, abs=1 / 256)
    shown = shockwave("uncertainty", written(tmp_path, "", block), "--draws", "256", "--limit", "1 kN").out
    assert "exceedance        probability 0 %, between 0 % and 1.2 %\n" in shown


def test_the_interval_of_a_probability_includes_the_error_of_each_force() -> None:
    forces = np.linspace(0.0, 1.0, 1600).reshape(100, 16).T
    exact, _ = exceedance(sw.Limit(force=0.5), FORCE, forces, 0.0)
    coarse, _ = exceedance(sw.Limit(force=0.5), FORCE, forces, 0.1)
    assert exact.probability == coarse.probability == 0.5
    # forces from 0.5 / 1.1 to 0.5 / 0.9 may or may not reach the limit
    assert coarse.low == pytest.approx(exact.low - (0.5 / 0.9 - 0.5), abs=3e-3)
    assert coarse.high == pytest.approx(exact.high + (0.5 - 0.5 / 1.1), abs=3e-3)
    # forces of the law that are up to 11 % too large, or 2 % too small
    lawful, _ = exceedance(sw.Limit(force=0.5), evolve(FORCE, law_error=(-0.02, 0.11)), forces, 0.0)
    assert lawful.probability == 0.5
    assert lawful.low == pytest.approx(exact.low - 0.11 * 0.5, abs=3e-3)
    assert lawful.high == pytest.approx(exact.high + 0.02 * 0.5, abs=3e-3)


def test_a_probability_without_any_exceedance_is_not_known_to_be_zero() -> None:
    found, judged = exceedance(sw.Limit(force=2.0), FORCE, np.full((16, 64), 1.0), 1e-4)
    assert (found.probability, found.low) == (0.0, 0.0)
    assert found.high == pytest.approx(3 / 1024)
    assert judged.decision == "below"


def test_the_remedy_is_that_of_the_nominal_scene_where_it_is_undecided_alone() -> None:
    batches = np.linspace(1.0, 3.0, 1024).reshape(16, 64)
    for force, remedy in (
        (FORCE, "narrow the distributions"),
        (evolve(FORCE, high=2.0, later=4.0), FORCE.later_remedy),
    ):
        _, judged = exceedance(sw.Limit(force=2.5), force, batches, 1e-4)
        assert (judged.decision, judged.remedy) == ("undecided", remedy)


def test_scenes_without_a_known_bound_are_undecided_and_counted() -> None:
    forces = np.linspace(0.0, 1.0, 1600).reshape(100, 16).T
    # a quarter of the scenes may be struck harder later, half of them by less than the limit
    later = np.where(forces < 0.125, math.inf, np.where(forces < 0.25, 0.4, 0.0))
    found, judged = exceedance(sw.Limit(force=0.5), FORCE, forces, 0.0, later)
    assert (found.probability, found.draws, found.undecided) == (0.5, 1600, 200)
    assert 0.5 + 0.125 < found.high < 0.5 + 0.125 + 0.01
    assert str(found).startswith("probability between ")
    assert str(found).endswith("; 200 of 1600 scenes are undecided")
    assert judged.decision == "undecided"
    # a force that is not known, too
    unknown, _ = exceedance(sw.Limit(force=0.5), FORCE, np.where(forces > 0.75, math.nan, forces), 0.0)
    assert unknown.undecided == pytest.approx(400, abs=1)


@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize(("features", "force"), [({}, LAST), ({"end": sw.Wall()}, WALL)], ids=["free end", "wall"])
def test_uncertain_finite_chains_are_judged_by_the_force_that_leaves_them(features: dict[str, Any], force: str) -> None:
    scene = SHOCK, chain(granules=2, **features)
    found = sw.uncertainty(*scene, spreads={"shock.peak_force": "10 %"}, draws=64, limit=1.0)
    expected = {"limit": 1.0, "probability": 1.0, "low": 1 - 3 / 64, "high": 1.0, "draws": 64, "undecided": 0}
    assert found.to_dict()["exceedance"] == expected
    assert (found.verdict.decision, found.verdict.force) == ("above", force)


@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize(
    ("features", "simulate", "value"),
    [
        (", precompression: 2 N", "{contacts: [0]}", None),
        (", granules: 8, end: {wall: same}", "{until: 15 us}", 0.0),
    ],
    ids=["no limit along the chain", "not arrived"],
)
def test_an_uncertain_force_that_is_not_known_leaves_the_verdict_open(
    features: str, simulate: str, value: float | None, tmp_path: Path
) -> None:
    scene = sw.load_scenario(written(tmp_path, features, f"simulate: {simulate}"))
    # one parameter, and one quantity in the first case
    found = sw.uncertainty(scene, spreads={"shock.peak_force": "5 %"}, draws=64, limit=60.0)
    assert (found.verdict.decision, found.verdict.value) == ("undecided", value)
    assert "undecided for the limit of 60 N" in str(found)
