"""The benchmark: references, timed runs, families of problems, printed tables and page."""

from __future__ import annotations

import gc
import json
import math
import re
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import shockwave as sw
from conftest import HOOKS, Install
from shockwave.base.errors import NumericalError
from shockwave.benchmark import bench, bench_output
from shockwave.benchmark.chain_problems import CASES, case_of, reference
from shockwave.benchmark.work_precision import (
    Answer,
    Limits,
    Method,
    Problem,
    Row,
    WorkPrecision,
    measure,
)
from shockwave.cli import main
from shockwave.engine.time_limit import expired
from shockwave.registry.registry import entries, load

pytestmark = pytest.mark.usefixtures("frozen")

#: A single run, practically without a time limit.
ONCE = Limits(run=60.0, repetitions=0.0, repeats=0)
LITTLE = 0.02
PROBLEM = Problem("integrators", "trial", "a chain", ("state",), "another", 1e-15)


@cache
def scenario(name: str = "triangular") -> sw.Scenario:
    return sw.load_scenario(f"profiles/examples/{name}.yaml")


# ---------------------------------------------------------------- timed runs


def run(function: Callable[[Any], Any], *values: float, limits: Limits = ONCE) -> list[Row]:
    """The rows of a method that has no error."""

    def answered(value: float) -> Answer:
        function(value)
        return Answer({"state": 0.0})

    return list(measure(PROBLEM, Method("m", answered, "step", values or (1.0,)), limits))


def test_runs_are_repeated_after_a_warm_up_without_garbage_collection() -> None:
    enabled: list[bool] = []
    (row,) = run(lambda *_: enabled.append(gc.isenabled()), limits=Limits(run=60.0, repetitions=60.0, repeats=4))
    assert (enabled, row.runs) == ([False] * 5, 4)
    assert 0 < (row.least or 0) <= (row.seconds or 0) <= (row.most or 0)


def test_quick_run_skips_settings() -> None:
    assert [row.value for row in run(lambda *_: None, 1.0, 2.0, 3.0, limits=evolve(ONCE, every=2))] == [1.0, 3.0]


def test_a_setting_that_would_take_too_long_is_left_out() -> None:
    first, second = run(lambda _: time.sleep(0.02), 1.0, 2.0, limits=Limits(run=0.03, repetitions=0.0, repeats=0))
    # the next finer setting takes about twice the time of the last one
    assert first.problem == ""
    assert "left out" in second.problem


def test_run_stops_at_the_time_limit_and_finer_settings_are_left_out() -> None:
    def endless(_: float) -> None:
        while not expired():
            pass
        raise NumericalError("the time limit was reached")

    stopped, *others = run(endless, 1.0, 2.0, 3.0, limits=Limits(run=0.01, repetitions=0.0, repeats=0))
    assert stopped.problem == "stopped at the time limit of 0.01 s for a run"
    assert all("left out" in row.problem for row in others)


@pytest.mark.parametrize(
    ("error", "reason"),
    [(NumericalError("no wave"), "no wave"), (ZeroDivisionError("by zero"), "ZeroDivisionError: by zero")],
    ids=["own", "of-a-plugin"],
)
def test_failed_run_states_the_reason_and_later_settings_are_run(error: Exception, reason: str) -> None:
    def failing(value: float) -> None:
        if value == 1.0:
            raise error

    first, second = run(failing, 1.0, 2.0)
    assert (first.problem, first.error) == (reason, None)
    assert (second.problem, second.error) == ("", 0.0)


def test_error_that_is_not_finite_is_reported() -> None:
    (row,) = measure(PROBLEM, Method("m", lambda *_: Answer({"state": float("nan")})), ONCE)
    assert (row.errors, row.problem) == ({"state": None}, "not finite")


# ---------------------------------------------------------------- the front at a contact


@pytest.mark.parametrize(
    ("name", "method", "setting", "bound"),
    [
        # 20 digits are known; rounding of some hundred steps
        ("A", "rkn1210", 1e-13, 1e-12),
        # independent code: errors of a thousand steps of 1e-11
        ("slow", "dop853", 1e-11, 3e-9),
        # expected accuracy; the tolerance of radau applies to each of hundreds of steps
        ("A", "pefrl", 0.05, 1e-3),
        ("A", "radau", 1e-4, 1e-3),
        # the wall behind soft granules, whose late collisions amplify errors
        ("wall", "dop853", 1e-11, 1e-9),
        ("wall", "verlet", 0.05, 1e-3),
    ],
)
def test_front_is_measured_with_any_method(name: str, method: str, setting: float, bound: float) -> None:
    case = CASES[name]
    # both methods of the reference near rounding, over some hundred steps
    assert reference(case).error < 1e-11
    front = case.front(case.run(load("integrators", method), setting))
    assert max(reference(case).errors(*front).values()) < bound


def test_a_run_stops_at_the_time_limit() -> None:
    radau = Method("radau", partial(CASES["wall"].run, load("integrators", "radau")), "tolerance", (1e-12,))
    (row,) = measure(PROBLEM, radau, Limits(run=0.01, repetitions=0.0, repeats=0))
    assert row.problem == "stopped at the time limit of 0.01 s for a run"


def test_front_of_a_finite_chain_is_measured_before_the_end() -> None:
    scene = scenario()
    assert case_of(evolve(scene, chain=evolve(scene.chain, granules=30))).contact == 20


# ---------------------------------------------------------------- quadratures


def test_gauss_legendre_reaches_rounding_on_all_areas() -> None:
    for experiment in bench.list_problems("quadratures", quick=False):
        problem, methods = experiment()
        (gauss,) = (method for method in methods if method.name == "gauss-legendre")
        tightest = list(measure(problem, gauss, ONCE))[-1]
        # 1e-14 if the position of the kink is not given
        assert max(error or 0.0 for error in tightest.errors.values()) < 3e-14


@pytest.mark.parametrize("wrong", [None, 1e-8], ids=["no-closed-form", "wrong-closed-form"])
def test_areas_of_any_profile_are_checked_and_the_difference_is_stated(wrong: float | None) -> None:
    exponential = scenario("exponential").shock.profile
    first, second = exponential.closed_areas() or (math.nan, math.nan)

    class Claimed(sw.ShockProfile):
        duration_ratio = float(exponential.duration_ratio)
        rise, decay = exponential.rise, exponential.decay

        def closed_areas(self) -> tuple[float, float] | None:
            return (first, second * (1 + wrong)) if wrong else None

    areas = bench.areas_of(Claimed())
    assert "checked by" in areas.source
    # rounding of both
    assert areas.error == pytest.approx(wrong or 0.0, rel=1e-6, abs=1e-14)
    assert areas.values == pytest.approx((first, second), rel=1e-7 if wrong else 1e-14)


# ---------------------------------------------------------------- families


@cache
def predicted() -> WorkPrecision:
    return bench.run([scenario()], ["predictors"], quick=True)


def of_method(begin: str) -> list[Row]:
    return [row for row in predicted().rows if row.method.startswith(begin)]


@pytest.mark.parametrize(("family", "others"), [("quadratures", set()), ("integrators", {"simulate"})])
def test_every_registered_method_has_rows_on_every_problem(family: str, others: set[str]) -> None:
    result = bench.run([scenario()], [family], quick=True, longest=LITTLE)
    names = {entry.name for entry in entries(family)} | others
    pairs = {(row.case, row.method) for row in result.rows}
    assert pairs == {(problem.name, name) for problem in result.problems for name in names}
    settings = {row.method: row.setting.split()[0] for row in result.rows}
    assert family == "quadratures" or (settings["verlet"], settings["rkn86"]) == ("step", "tolerance")


def test_section_4_has_a_row_for_each_variant_with_its_error() -> None:
    settings = [row.setting for row in of_method("section-4")]
    assert settings == [f"alpha {alpha}, {a} A" for alpha in ("constant", "literal") for a in ("exact", "paper")]
    scene = scenario()
    exact = sw.simulate(scene.shock, scene.chain, rtol=1e-9, waves="primary").peak_force
    formula: Any = sw.Predictor(model="section-4").predict(scene.shock, scene.chain)
    # the tolerance of the simulation, times ten
    assert of_method("section-4, constant")[0].error == pytest.approx(abs(formula.peak_force / exact - 1), abs=1e-8)


def test_error_of_the_simulation_is_below_its_tolerance() -> None:
    found = of_method("simulate")
    assert len(found) >= 3
    assert all(row.error is not None and row.value is not None and row.error <= row.value for row in found)


def test_broken_plugin_has_a_single_row(install: Install) -> None:
    hooks = HOOKS.replace("profiles", "integrators").replace('"a pulse"', '"a method", takes="step"')
    install("broken", hooks=hooks, pulse="1 / 0")
    _, methods = bench.integrators(CASES["A"])
    (broken,) = [method for method in methods if method.name == "broken"]
    (row,) = measure(PROBLEM, broken, ONCE)
    assert "plugin broken is faulty" in row.problem


# ---------------------------------------------------------------- printed text, documents and page


def made(name: str = "<b>&", method: str = "simulate") -> WorkPrecision:
    """A small result whose texts contain characters that HTML must escape."""
    problem = Problem("predictors", name, "a <pulse>", ("peak force",), "r", 1e-9)
    other = evolve(problem, family="integrators", quantities=("peak force", "arrival time"))
    row = Row("predictors", name, method, "rtol 1e-02", 1e-2, {"peak force": 1e-4}, 1e-4, reference_error=1e-9)
    formula = Row("predictors", name, "section-4", "-", None, {"peak force": 1e-2}, 1.23e-4, 1.1e-4, 1.5e-4, runs=3)
    absent = Row("predictors", name, "<absent>", problem="no <script>")
    front = evolve(row, family="integrators", errors={"peak force": 1e-3, "arrival time": None})
    return WorkPrecision(provenance={"os": "<x>"}, problems=(problem, other), rows=(row, formula, absent, front))


def test_document_is_json_with_null_where_there_is_nothing() -> None:
    document = json.loads(json.dumps(made().to_dict(), allow_nan=False))
    assert list(document) == ["version", "provenance", "problems", "rows"]
    assert [row["problem"] for row in document["rows"]] == [None, None, "no <script>", None]
    assert document["rows"][3]["errors"]["arrival time"] is None


def test_table_shows_digits_within_the_spread_and_notes_the_reason_of_a_failure() -> None:
    lines = str(made()).splitlines()
    (formula,) = (line for line in lines if line.lstrip().startswith("section-4"))
    assert formula.split() == ["section-4", "-", "1.0e-02", "120", "us", "110", "us", "..", "150", "us", "-"]
    assert "  note: <absent>, -: no <script>" in lines


def test_error_below_that_of_the_reference_is_shown_as_a_bound() -> None:
    result = made()
    rows = [evolve(row, reference_error=1e-3) for row in result.rows]
    assert "<1e-03" in str(evolve(result, rows=rows))


def test_text_begins_with_the_fastest_run_that_meets_the_target() -> None:
    result = made(name="P")
    exact = evolve(result.rows[0], errors={"peak force": 1e-7}, seconds=0.5, least=0.5, most=0.5)
    slower = evolve(exact, setting="rtol 1e-08", seconds=1.0)
    first, *lines = str(evolve(result, rows=(*result.rows, slower, exact))).splitlines()
    assert first == "Fastest runs with relative errors of at most 1e-06"
    assert lines[0] == "  ! integrators: P: no run is as accurate; the smallest error is 1.0e-03 by"
    assert lines[5].split() == ["predictors:", "P", "simulate", "rtol", "1e-02", "1.0e-07", "500", "ms"]


@cache
def drawn() -> str:
    pytest.importorskip("matplotlib")
    return bench_output.page(made())


def test_page_has_no_external_links() -> None:
    links = re.findall(r'\b(?:src|href)="([^"]*)"', drawn())
    assert all(link.startswith("#") for link in links)
    policy = re.search('<meta http-equiv="Content-Security-Policy" content="([^"]*)">', drawn())
    assert {"default-src 'none'", "base-uri 'none'", "form-action 'none'"} <= set(policy[1].split("; "))


def test_texts_of_the_page_are_escaped() -> None:
    tags = re.findall(r"<(\w+)", drawn())
    assert {"b", "script", "pulse", "absent", "x"} & set(tags) == set()
    assert "<li>&lt;absent&gt;: no &lt;script&gt;</li>" in drawn()


def test_page_has_a_figure_for_each_error_and_is_reproducible() -> None:
    names = re.findall(r' id="([^"]+)"', drawn())
    assert drawn().count("<figure>") == 2
    assert len(names) == len(set(names)) > 0
    assert bench_output.page(made()) == drawn()


def test_names_are_drawn_without_characters_that_reverse_text() -> None:
    pytest.importorskip("matplotlib")
    page = bench_output.page(made("$\\frac{a}{$\u202e", "$x^{$"))
    assert "<figure>" in page
    assert "\u202e" not in page


@pytest.mark.parametrize("family", bench.FAMILIES)
@pytest.mark.parametrize(
    ("more", "key"), [("impact: {velocity: 1}", "impact"), ("", "chain.end")], ids=["striker", "wall"]
)
def test_scenario_beyond_equal_granules_is_refused_in_its_place(
    family: str, more: str, key: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "scene.yaml"
    shock = "shock: {profile: triangular, peak_force: 1, rise_time: 1e-5, duration_ratio: 3}"
    end = "" if more else ", end: {wall: same}"
    file.write_text(f"chain: {{material: copper, diameter: 9.5 mm, granules: 10{end}}}\n{more or shock}\n")
    assert main(["bench", str(file), "--quick", "--family", family]) == 3
    assert f": {key}: must be left out for bench, which covers only shocks on chains" in capsys.readouterr().err
