"""The bench: references against other arithmetic and methods, orders, timed runs, families, what is refused, page."""

from __future__ import annotations

import gc
import json
import re
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest
from attrs import evolve

import shockwave as sw
from scenes import FORCE, UNITS
from selection import keeping
from shockwave.benchmark import bench, bench_page, chain_problems, convergence_order, predictors, quadrature_problems
from shockwave.benchmark.chain_problems import Reading, at_setting, case_of, named, read_front, reference
from shockwave.benchmark.timed_runs import Answer, Clock, Limits, Method, TooSlowError, measured
from shockwave.benchmark.work_precision import Order, Problem, Row, WorkPrecision, observed_order
from shockwave.errors import FileAccessError, NumericalError, UsageError
from shockwave.registry import entries, load

pytestmark = pytest.mark.usefixtures("frozen")

#: One run, without repetitions, of which none is stopped.
ONCE = Limits(run=60.0, repetitions=0.0, repeats=0)
LITTLE = 0.02
STEPS = [0.4 / 2**power for power in range(7)]
PROBLEM = Problem("integrators", "smooth", "a chain", ("state",), "another", 1e-15)


@cache
def scenario(name: str = "triangular") -> sw.Scenario:
    return sw.load_scenario(f"profiles/examples/{name}.yaml")


def with_profile(scene: sw.Scenario, profile: sw.ShockProfile) -> sw.Scenario:
    return evolve(scene, shock=evolve(scene.shock, profile=profile))


# ---------------------------------------------------------------- observed order


def rows(error: Callable[[float], float | None], reference_error: float = 1e-15) -> list[Row]:
    return [
        Row("integrators", "smooth", "m", value=h, errors={"state": error(h)}, reference_error=reference_error)
        for h in STEPS
    ]


@pytest.mark.parametrize(
    ("runs", "order", "tolerance"),
    [
        pytest.param(rows(lambda h: 0.3 * h**6), 6, 1e-9, id="a power law exactly, up to rounding"),
        pytest.param(rows(lambda h: h**2 + 50 * h**6), 2, 0.01, id="steps too coarse are left out"),
        pytest.param(rows(lambda h: max(h**4, 1e-8), 1e-9), 4, 1e-9, id="errors of the reference are left out"),
    ],
)
def test_order_is_the_slope_over_the_convergent_range(runs: list[Row], order: float, tolerance: float) -> None:
    assert observed_order(runs) == pytest.approx(order, abs=tolerance)


@pytest.mark.parametrize(
    "runs", [rows(lambda h: h ** (20 * h)), rows(lambda h: None)], ids=["no two slopes agree", "all runs failed"]
)
def test_order_is_unknown_without_a_convergent_range(runs: list[Row]) -> None:
    assert observed_order(runs) is None


def test_observed_orders_are_the_declared_ones() -> None:
    problem, methods = convergence_order.experiment(quick=False)
    found = convergence_order.orders([row for method in methods for row in measured(problem, method, ONCE)])
    assert {order.method for order in found} >= {"verlet", "rk4", "pefrl"}
    # slopes over finite steps
    assert {order.method: order.fitted for order in found} == pytest.approx(
        {order.method: order.declared for order in found}, abs=0.15
    )


# ---------------------------------------------------------------- timed runs


def run(function: Callable[[Any, Clock], Any], *values: float, limits: Limits = ONCE) -> list[Row]:
    """The rows of a method that has no error."""

    def answered(value: float, clock: Clock) -> Answer:
        function(value, clock)
        return Answer({"state": 0.0})

    return list(measured(PROBLEM, Method("m", answered, "step", values or (1.0,)), limits))


def test_a_run_is_warmed_up_and_repeated() -> None:
    calls: list[float] = []
    (row,) = run(lambda value, _: calls.append(value), limits=Limits(run=60.0, repetitions=60.0, repeats=4))
    assert (len(calls), row.runs) == (5, 4)
    assert 0 < (row.least or 0) <= (row.seconds or 0) <= (row.most or 0)


def test_repetitions_end_when_their_time_is_up() -> None:
    (row,) = run(lambda *_: time.sleep(0.02), limits=Limits(run=60.0, repetitions=0.05, repeats=100))
    assert 1 <= row.runs <= 2


def test_a_run_is_stopped_by_its_clock_and_finer_settings_are_left_out() -> None:
    def endless(_: float, clock: Clock) -> None:
        while True:
            clock.check()

    stopped, *others = run(endless, 1.0, 2.0, 3.0, limits=Limits(run=0.01, repetitions=0.0, repeats=0))
    assert stopped.problem == "stopped: a run may take 0.01 s"
    assert all("left out" in row.problem for row in others)


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (NumericalError("no wave"), "no wave"),
        (ZeroDivisionError("by\nzero"), "ZeroDivisionError: by zero"),
        (SystemExit(3), "SystemExit: 3"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_failure_says_why_and_does_not_stop_the_others(error: BaseException, reason: str) -> None:
    def failing(value: float, _: Clock) -> None:
        if value == 1.0:
            raise error

    first, second = run(failing, 1.0, 2.0)
    assert (first.problem, first.error) == (reason, None)
    assert (second.problem, second.error) == ("", 0.0)


def test_an_interrupt_by_the_user_passes() -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(interrupted)


def test_no_garbage_is_collected_during_a_run() -> None:
    enabled: list[bool] = []
    run(lambda *_: enabled.append(gc.isenabled()))
    assert (enabled, gc.isenabled()) == ([False], True)


@pytest.mark.parametrize("error", [float("nan"), float("inf"), -float("inf")])
def test_an_error_that_is_not_finite_is_a_problem(error: float) -> None:
    (row,) = measured(PROBLEM, Method("m", lambda *_: Answer({"state": error})), ONCE)
    assert (row.errors, row.problem) == ({"state": None}, "not finite")


# ---------------------------------------------------------------- the front at a contact

CASE_A, CASE_B = named("A"), named("B")


def greater_error(case: chain_problems.Case, reading: Reading) -> float:
    """The greater relative error of peak force and arrival time."""
    return max(error or 0.0 for error in reference(case).errors(reading.force, reading.time).values())


@pytest.mark.parametrize("case", [CASE_A, CASE_B], ids=lambda case: case.name)
def test_tight_runs_read_the_digits_that_are_known(case: chain_problems.Case) -> None:
    reading = read_front(case, at_setting(load("integrators", "rkn1210"), 1e-13), Clock())
    # rounding of some hundred steps
    assert greater_error(case, reading) < 1e-12


@pytest.mark.parametrize("name", ["slow", "short"])
def test_references_are_those_of_a_code_made_elsewhere(name: str) -> None:
    case = named(name)
    # both methods of the reference at a tolerance near rounding, over some hundred steps
    assert reference(case).error < 1e-11
    # errors of a thousand steps of 1e-11, relative and absolute
    assert greater_error(case, read_front(case, at_setting(load("integrators", "dop853"), 1e-11), Clock())) < 3e-9


@pytest.mark.parametrize(("name", "setting"), [("pefrl", 0.05), ("radau", 1e-4), ("rkn64", 1e-6)])
def test_the_front_is_read_by_any_method(name: str, setting: float) -> None:
    reading = read_front(CASE_A, at_setting(load("integrators", name), setting), Clock())
    # what these settings are good for: radau's tolerance is one of a step, of which there are hundreds
    assert greater_error(CASE_A, reading) < 1e-3


def test_energy_drift_is_unknown_while_the_force_acts() -> None:
    # the front passes contact 19 of B at 26, and the force ends at 100
    case = evolve(CASE_B, contact=19)
    assert read_front(case, at_setting(load("integrators", "rkn86"), 1e-6), Clock()).drift is None


def test_energy_drift_scales_as_the_square_of_verlets_step() -> None:
    loose, tight = (read_front(CASE_A, load("integrators", "verlet")(size=h), Clock()).drift for h in (0.1, 0.0125))
    # 64 where the drift is read at the same phase of a wave, which moves it by less than that
    assert (loose or 0.0) > 10 * (tight or 1.0)


def test_a_march_is_stopped_by_its_clock() -> None:
    with pytest.raises(TooSlowError):
        read_front(CASE_A, load("integrators", "verlet")(size=1e-3), Clock(0.01))


def test_a_late_reference_is_looser_and_states_its_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(case: chain_problems.Case, integrator: Any, clock: Clock) -> Reading:
        if integrator.tolerance < 1e-10:
            raise TooSlowError("stopped")
        return read_front(case, integrator, clock)

    tight = reference(named("short"))
    monkeypatch.setattr(chain_problems, "read_front", read)
    loose = reference(named("short"))
    assert "1e-09" in loose.source
    # some hundred steps that each err by 1e-9
    assert 1e-13 < loose.error < 1e-6
    assert loose.force == pytest.approx(tight.force, rel=10 * loose.error)


def test_a_late_limit_is_looser_and_states_its_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(predictors, "patience", lambda _: 0.0)
    problem, _ = predictors.of_scenario(scenario(), ONCE, quick=True)
    assert "rtol 1e-06" in problem.reference
    assert 1e-9 < problem.reference_error < 1e-5


def test_named_chains_are_in_the_units_of_the_force() -> None:
    # the digits of A and B are in characteristic units of 100 N
    assert CASE_A.shock.rise_time == pytest.approx(2 * UNITS.time, rel=1e-12)
    assert CASE_A.shock.peak_force == FORCE


def test_a_chain_that_ends_is_read_before_its_end() -> None:
    scene = scenario()
    assert case_of(evolve(scene, chain=evolve(scene.chain, granules=30))).contact == 20


# ---------------------------------------------------------------- quadratures


def test_areas_of_the_smooth_profile_are_those_of_another_arithmetic() -> None:
    with mp.workdps(30):
        rise = mp.quad(lambda s: mp.expm1(-2 * s) / mp.expm1(-2), [0, 1])
        decay = 3 * mp.quad(lambda u: (mp.exp(-3 * u) - mp.exp(-3)) / (1 - mp.exp(-3)), [0, 1])
    (smooth,) = (areas for areas in quadrature_problems.named_areas() if areas.name == "smooth")
    # rounded to a double
    assert smooth.values == pytest.approx((float(rise), float(decay)), rel=3e-16)


@pytest.mark.parametrize("areas", list(quadrature_problems.named_areas()), ids=lambda areas: areas.name)
def test_areas_are_reached_by_a_registered_quadrature(areas: quadrature_problems.Areas) -> None:
    answer = areas.answer(areas.integrals("gauss-legendre", 1e-15))
    # where a kink is not given its panels go on to 1e-14
    assert max(error or 0.0 for error in answer.errors.values()) < 3e-14


@pytest.mark.parametrize("wrong", [None, 0.0, 1e-8])
def test_areas_of_any_profile_are_cross_checked_and_the_difference_stated(wrong: float | None) -> None:
    exponential = scenario("exponential").shock.profile

    class Claimed(sw.ShockProfile):
        duration_ratio = float(exponential.duration_ratio)
        rise, decay = exponential.rise, exponential.decay

        def closed_areas(self) -> tuple[float, float] | None:
            rise, decay = exponential.closed_areas() or (1.0, 1.0)
            return None if wrong is None else (rise, decay * (1 + wrong))

    areas = quadrature_problems.areas_of("claimed", Claimed(), "claimed")
    assert "cross-checked" in areas.reference
    # rounding of both
    assert areas.reference_error == pytest.approx(wrong or 0.0, rel=1e-6, abs=1e-14)
    assert areas.values == pytest.approx(exponential.closed_areas(), rel=1e-14 if not wrong else 1e-7)


# ---------------------------------------------------------------- families


@cache
def predicted() -> WorkPrecision:
    return bench.run([scenario()], ["predictors"], quick=True)


def of_method(result: WorkPrecision, begin: str) -> list[Row]:
    return [row for row in result.rows if row.method.startswith(begin)]


def test_every_quadrature_has_rows_on_every_problem() -> None:
    result = bench.run(families=["quadratures"], quick=True, longest=LITTLE)
    pairs = {(row.case, row.method) for row in result.rows}
    names = {entry.name for entry in entries("quadratures")}
    assert pairs == {(problem.name, name) for problem in result.problems for name in names}


def test_every_integrator_has_rows() -> None:
    result = bench.run([scenario()], ["integrators"], quick=True, longest=LITTLE)
    assert {entry.name for entry in entries("integrators")} | {"simulate"} == {row.method for row in result.rows}
    assert result.orders == ()


def test_section_4_is_there_in_every_reading() -> None:
    settings = [row.setting for row in of_method(predicted(), "section-4")]
    assert settings == [f"alpha {alpha}, {a} A" for alpha in ("constant", "literal") for a in ("exact", "paper")]


def test_error_of_a_formula_is_that_of_the_comparison() -> None:
    scene = scenario()
    compared = sw.compare(scene.shock, scene.chain, rtol=1e-9, waves="primary")
    row = of_method(predicted(), "section-4, constant")[0]
    # the tolerance of the comparison, times ten
    assert row.error == pytest.approx(abs(compared.error), abs=1e-8)


def test_simulation_errs_by_less_than_its_tolerance() -> None:
    found = of_method(predicted(), "simulate")
    assert len(found) >= 3
    assert all(row.error is not None and row.value is not None and row.error <= row.value for row in found)


def test_a_scene_that_cannot_be_simulated_is_a_row_that_says_why() -> None:
    slow = evolve(scenario(), shock=evolve(scenario().shock, rise_time=10.0))
    (row,) = bench.run([slow], ["predictors"], quick=True).rows
    assert "a matter of statics" in row.problem


def test_scenes_of_one_name_are_told_apart() -> None:
    result = bench.run([scenario()] * 2, ["quadratures"], quick=True, longest=LITTLE)
    assert [problem.name for problem in result.problems] == [scenario().name, f"{scenario().name} (2)"]
    assert len(result.of(result.problems[0])) == len(result.of(result.problems[1])) > 0


# ---------------------------------------------------------------- what is printed and written


def made(name: str = "<b>&", method: str = "simulate", error: float = 1e-4) -> WorkPrecision:
    """A small result whose texts are not HTML."""
    problem = Problem("predictors", name, "a <pulse>", ("peak force",), "r", 1e-9)
    common = {"family": "predictors", "case": name, "reference_error": 1e-9}
    found = [
        Row(**common, method=method, setting="rtol 1e-02", value=1e-2, errors={"peak force": error}, seconds=error),  # type: ignore[arg-type]
        Row(**common, method="section-4", errors={"peak force": 1e-2}, seconds=1e-4, least=5e-5, most=2e-4),  # type: ignore[arg-type]
        Row(**common, method="<absent>", problem="no <script>"),  # type: ignore[arg-type]
    ]
    other = evolve(problem, family="integrators", quantities=("peak force", "arrival time", "energy"))
    errors = {"peak force": 1e-3, "arrival time": 1e-4, "energy": None}
    found.append(evolve(found[0], family="integrators", errors=errors))
    return WorkPrecision(
        provenance={"os": "<x>"}, problems=(problem, other), rows=tuple(found), orders=(Order("<m>", 2, 2.01),)
    )


def test_document_is_json_with_null_where_there_is_nothing() -> None:
    document = json.loads(json.dumps(made().to_dict(), allow_nan=False))
    assert list(document) == ["provenance", "problems", "rows", "orders"]
    assert [row["problem"] for row in document["rows"]] == [None, None, "no <script>", None]
    assert document["rows"][3]["errors"]["energy"] is None


def test_table_has_a_line_for_each_row_and_the_reason_of_a_failure() -> None:
    lines = str(made()).splitlines()
    (formula,) = (line for line in lines if line.lstrip().startswith("section-4"))
    assert formula.split() == ["section-4", "-", "1.0e-02", "100", "us", "50", "us", "..", "200", "us", "-"]
    assert any(line.endswith("no <script>") for line in lines)


@cache
def drawn() -> str:
    pytest.importorskip("matplotlib")
    return bench_page.page(made())


def test_the_page_loads_and_sends_nothing() -> None:
    links = re.findall(r'\b(?:src|href)="([^"]*)"', drawn())
    assert all(link.startswith("#") for link in links)
    policy = re.search('<meta http-equiv="Content-Security-Policy" content="([^"]*)">', drawn())
    assert policy is not None
    assert {"default-src 'none'", "base-uri 'none'", "form-action 'none'"} <= set(policy[1].split("; "))


def test_texts_of_the_page_are_escaped() -> None:
    tags = re.findall(r"<(\w+)", drawn())
    assert {"b", "script", "pulse", "absent", "m", "x"} & set(tags) == set()
    assert "<li>&lt;absent&gt;: no &lt;script&gt;</li>" in drawn()


def test_the_page_has_a_figure_for_each_error_that_is_drawn() -> None:
    names = re.findall(r' id="([^"]+)"', drawn())
    assert drawn().count("<figure>") == 3
    assert len(names) == len(set(names)) > 0


def test_the_page_is_the_same_whenever_it_is_made() -> None:
    assert bench_page.page(made()) == drawn()


def test_characters_that_reverse_text_direction_are_replaced_in_the_page() -> None:
    assert "\u202e" not in bench_page.page(made(name="a\u202eb"))


def test_any_name_is_drawn() -> None:
    pytest.importorskip("matplotlib")
    assert "<figure>" in bench_page.page(made(r"$\frac{a}{$", "$x^{$"))


@pytest.mark.parametrize("ending", keeping(["html", "svg"], "html"))
def test_output_is_written(ending: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    file = tmp_path / f"page.{ending}"
    bench_page.check_output(str(file))
    bench_page.write(made(), str(file))
    assert re.search(r"</(html|svg)>\s*$", file.read_text(encoding="utf-8"))


@pytest.mark.parametrize("place", ["missing/page.svg", "folder.html"])
def test_output_that_cannot_be_written_is_refused_before_anything_is_run(place: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(FileAccessError, match="cannot be written"):
        bench_page.check_output(str(tmp_path / place))


def test_another_ending_of_the_page_is_refused() -> None:
    with pytest.raises(UsageError, match=r"output must end in .html or .svg \(got 'page.pdf'\)"):
        bench_page.check_output("page.pdf")
