"""Work-precision: rows, orders, timing, tables."""

from __future__ import annotations

import gc
import json
import math
import time

import pytest

from shockwave.benchmark import smooth
from shockwave.benchmark.rows import Order, Problem, Row, WorkPrecision, order, worst
from shockwave.benchmark.timing import Clock, Limits, TooSlowError, tried
from shockwave.errors import NumericalError
from shockwave.registry import load

pytestmark = pytest.mark.usefixtures("frozen")

#: One run, without repetitions, of which none is stopped.
ONCE = Limits(run=60.0, method=0.0, repeats=0)


def row(value: float, error: float | None, reference_error: float = 1e-15, problem: str = "") -> Row:
    errors: dict[str, float | None] = {} if error is None else {"state": error}
    return Row(
        family="integrators",
        case="smooth",
        method="m",
        setting=f"step {value:g}",
        value=value,
        errors=errors,
        seconds=1e-3,
        least=0.5e-3,
        most=2e-3,
        runs=3,
        reference_error=reference_error,
        problem=problem,
    )


# ---------------------------------------------------------------- order


STEPS = [0.4 / 2**power for power in range(7)]


@pytest.mark.parametrize("power", [1, 2, 4, 6])
def test_order_is_the_power_of_the_step(power: int) -> None:
    # a power law exactly, up to rounding
    assert order(row(h, 0.3 * h**power) for h in STEPS) == pytest.approx(power, abs=1e-9)


def test_order_leaves_out_steps_that_are_too_coarse() -> None:
    # of errors h^2 + 50 h^6, slopes over the finest four steps are 2 to better than 0.01
    rows = [row(h, h**2 + 50 * h**6) for h in STEPS]
    assert order(rows) == pytest.approx(2, abs=0.01)


def test_order_leaves_out_errors_that_are_the_references() -> None:
    rows = [row(h, max(h**4, 1e-8), reference_error=1e-9) for h in STEPS]
    assert order(rows) == pytest.approx(4, abs=1e-9)


def test_order_is_unknown_where_no_two_slopes_agree() -> None:
    assert order([row(0.1, 1e-4), row(0.2, 1e-3), row(0.4, 1.0), row(0.8, 2.0)]) is None


def test_order_is_unknown_of_failures() -> None:
    assert order(row(h, None, problem="not finite") for h in STEPS) is None


@pytest.mark.parametrize("name", smooth.names())
def test_fitted_order_is_the_declared_one(name: str) -> None:
    assert order(smooth.rows(name, ONCE, quick=False)) == pytest.approx(load("integrators", name).order, abs=0.15)


def test_orders_stand_beside_those_declared() -> None:
    rows = list(smooth.rows("verlet", ONCE, quick=True))
    assert smooth.orders(rows) == (Order(method="verlet", declared=2, fitted=order(rows)),)


# ---------------------------------------------------------------- timing


def test_a_run_is_warmed_up_and_repeated() -> None:
    calls = []
    (found,) = tried([1], lambda setting, _: calls.append(setting), Limits(run=60.0, method=60.0, repeats=4))
    assert (len(calls), found.runs) == (5, 4)


def test_seconds_are_the_median_between_the_least_and_the_most() -> None:
    (found,) = tried([1], lambda *_: None, Limits(run=60.0, method=60.0, repeats=9))
    assert found.least is not None
    assert found.seconds is not None
    assert found.most is not None
    assert 0 < found.least <= found.seconds <= found.most


def test_repetitions_end_when_their_time_is_up() -> None:
    (found,) = tried([1], lambda *_: time.sleep(0.02), Limits(run=60.0, method=0.05, repeats=100))
    assert 1 <= found.runs <= 2


def test_a_slow_run_is_worth_more_than_none() -> None:
    (found,) = tried([1], lambda *_: "answer", ONCE)
    assert (found.result, found.runs) == ("answer", 1)


def test_a_run_is_stopped_where_it_asks_the_clock() -> None:
    def endless(_: int, clock: Clock) -> None:
        while True:
            clock.check()

    (found,) = tried([1], endless, Limits(run=0.01, method=0.0, repeats=0))
    assert found.problem == "stopped: a run may take 0.01 s"


def test_what_comes_after_a_run_that_was_stopped_is_left_out() -> None:
    calls = []

    def slow(setting: int, _: Clock) -> None:
        calls.append(setting)
        raise TooSlowError("stopped")

    found = list(tried([1, 2, 3], slow, ONCE))
    assert calls == [1]
    assert all("left out" in late.problem for late in found[1:])


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (NumericalError("no wave"), "no wave"),
        (ZeroDivisionError("by\nzero"), "ZeroDivisionError: by zero"),
        (SystemExit(3), "SystemExit: 3"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_failure_says_why_and_does_not_stop_the_others(error: BaseException, words: str) -> None:
    def run(setting: int, _: Clock) -> int:
        if setting == 1:
            raise error
        return setting

    found = list(tried([1, 2], run, ONCE))
    assert (found[0].problem, found[0].result, found[1].result) == (words, None, 2)


def test_an_interrupt_by_the_user_passes() -> None:
    def run(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(tried([1], run, ONCE))


def test_no_garbage_is_collected_meanwhile() -> None:
    (found,) = tried([1], lambda *_: gc.isenabled(), ONCE)
    assert (found.result, gc.isenabled()) == (False, True)


# ---------------------------------------------------------------- the object


PROBLEM = Problem(
    family="integrators",
    name="smooth",
    description="a chain",
    quantities=("state",),
    reference="another",
    reference_error=1e-15,
)


def result(*rows: Row) -> WorkPrecision:
    return WorkPrecision(problems=(PROBLEM,), rows=rows, orders=(), provenance={"python": "3"})


def test_document_is_json_without_nan() -> None:
    document = result(row(0.1, 1e-4), row(0.05, None, problem="not finite")).to_dict()
    rows = json.loads(json.dumps(document, allow_nan=False))["rows"]
    assert [(r["errors"], r["problem"]) for r in rows] == [({"state": 1e-4}, None), ({}, "not finite")]


def test_table_has_a_line_for_each_row_and_the_reason_of_a_failure() -> None:
    lines = result(row(0.1, 1e-4), row(0.05, None, problem="not finite")).table().splitlines()
    assert lines[-2].split() == ["m", "step", "0.1", "1.0e-04", "1", "ms", "500", "us", "..", "2", "ms", "-"]
    assert lines[-1].endswith("not finite")


@pytest.mark.parametrize("error", [float("nan"), float("inf"), -float("inf")])
def test_an_error_that_is_not_finite_is_a_problem(error: float) -> None:
    wrong = row(0.1, error)
    assert (wrong.errors, wrong.problem) == ({"state": None}, "not finite")
    json.dumps(result(wrong).to_dict(), allow_nan=False)


def test_a_problem_known_before_is_kept() -> None:
    assert row(0.1, float("nan"), problem="stopped").problem == "stopped"


@pytest.mark.parametrize("errors", [(float("nan"), 1.0), (1.0, float("nan"))])
def test_the_worst_of_errors_is_one_that_is_none(errors: tuple[float, float]) -> None:
    assert math.isnan(worst(*errors))
