"""The catalogue of extremes: its quick cases pass, its checks can fail, and no case takes the others down."""

from __future__ import annotations

import json
import math

import attrs
import pytest

import shockwave as sw
from pages import table
from scenes import CHAIN, power
from shockwave.benchmark.stress.case import Case, Finding
from shockwave.benchmark.stress.catalogue import CASES, find
from shockwave.benchmark.stress.checks import against, by_law, faults_of, judged, like, refused
from shockwave.benchmark.stress.runner import Row, Stress, run_case, stress
from shockwave.benchmark.stress.scenes import power as made
from shockwave.benchmark.stress.worker import checked
from shockwave.simulation.backend import compiled

QUICK = [case for case in CASES if not case.slow]
#: One of each kind of check, for the code in NumPy.
WITH_NUMPY = ("rates-1e-12", "small-weak-stiff", "rise-time-1e-12", "two-granules-blow", "steep-decay", "no-force")


def case(check: object, **changes: object) -> Case:
    """A case that is in no catalogue."""
    return Case(name="trial", theme="trials", asked="?", must="!", check=check, **changes)  # type: ignore[arg-type]


def simulated() -> sw.SimulationResult:
    return sw.simulate(power(0.5), CHAIN, waves="primary")


# ---------------------------------------------------------------- the cases


@pytest.mark.parametrize(
    "one",
    [pytest.param(one, id=one.name, marks=[pytest.mark.slow] * (index % 8 > 0)) for index, one in enumerate(QUICK)],
)
def test_quick_cases_pass(one: Case) -> None:
    finding, _ = checked(one, "numpy" if compiled is None else "compiled")
    assert finding.faults == ()


@pytest.mark.parametrize("name", WITH_NUMPY)
def test_cases_of_every_kind_pass_in_numpy(name: str) -> None:
    (one,) = find([name])
    assert checked(one, "numpy")[0].faults == ()


def test_names_are_unique() -> None:
    assert len({one.name for one in CASES} | {one.theme for one in CASES}) == len(CASES) + len(
        {one.theme for one in CASES}
    )


def test_themes_stand_together() -> None:
    themes = [one.theme for one in CASES]
    assert themes == sorted(themes, key=themes.index)


# ---------------------------------------------------------------- checks can fail


def test_a_peak_force_that_is_off_is_a_fault() -> None:
    result = simulated()
    assert judged(result, result.amplification, 1e-9).faults == ()
    (fault,) = judged(result, result.amplification * (1 + 2e-9), 1e-9).faults
    assert fault.startswith("the peak force is")


def test_an_open_book_of_momentum_is_a_fault() -> None:
    result = simulated()
    found = result.found._replace(chain_momentum=result.found.chain_momentum * (1 + 1e-11))
    assert faults_of(attrs.evolve(result, found=found)) == ["the book of momentum is open by 1.0e-11"]


def test_a_figure_that_is_not_finite_is_a_fault() -> None:
    result = simulated()
    broken = attrs.evolve(result, found=result.found._replace(energy=math.nan))
    assert faults_of(broken) == ["a figure of the result is not finite"]


def test_a_tolerance_that_is_missed_is_a_fault() -> None:
    result = sw.simulate(power(0.5), CHAIN, waves="primary", rtol=1e-13)
    (fault,) = faults_of(result)
    assert fault.startswith("the tolerance was not met")


def test_a_shock_that_is_not_short_breaks_the_law_of_short_shocks() -> None:
    assert by_law(made(0.5, 1.0, 3.0, 0.5))("numpy").faults != ()


def test_another_scene_is_told_from_the_same() -> None:
    finding = like(made(0.5, 1.0, 3.0, 0.5), made(0.5, 1.0, 3.0, 0.5001), 1e-6, waves="primary")("numpy")
    # simulation and prediction both
    assert len(finding.faults) == 2


def test_a_wrong_number_is_told() -> None:
    assert against(made(0.5, 1.0, 3.0, 0.5), 0.51, 1e-6, waves="primary")("numpy").faults != ()


def raising(error: Exception) -> object:
    def call(backend: str) -> None:
        raise error

    return call


@pytest.mark.parametrize(
    "call",
    [
        raising(sw.NumericalError("too slow")),
        raising(sw.InvalidValueError.of("force", "must be strong")),
        lambda backend: simulated(),
    ],
    ids=["another-error", "other-words", "no-error"],
)
def test_what_is_not_refused_as_it_should_be_is_a_fault(call: object) -> None:
    check = refused(call, sw.InvalidValueError, "must be > 0")  # type: ignore[arg-type]
    assert check("numpy").faults == ("it should be InvalidValueError with 'must be > 0'",)


def test_the_named_error_with_its_words_passes() -> None:
    error = sw.InvalidValueError.of("force", "must be > 0 N")
    finding = refused(raising(error), sw.InvalidValueError, "must be > 0")("numpy")  # type: ignore[arg-type]
    assert finding == Finding(outcome="InvalidValueError: force: must be > 0 N")


def test_what_a_check_raises_by_accident_is_a_fault() -> None:
    finding, _ = checked(case(raising(ZeroDivisionError("by nothing"))), "numpy")
    assert finding.outcome == "ZeroDivisionError: by nothing"
    assert len(finding.faults) == 1


# ---------------------------------------------------------------- the runner


def test_a_case_that_hangs_is_a_row_that_says_so() -> None:
    # far less than the interpreter takes to start
    row = run_case(attrs.evolve(CASES[0], limit=0.001), "numpy")
    assert row.faults == ("does not end: stopped after 0.001 s",)
    assert not row.passed


def test_a_process_that_fails_is_a_row_that_says_why() -> None:
    row = run_case(case(lambda backend: Finding(outcome="")), "numpy")
    assert row.outcome == "its process ended with status 1"
    assert "unknown case (got 'trial'" in row.faults[0]


@pytest.fixture(scope="module")
def two() -> Stress:
    return stress(["duration-ratio-1", "two-granules-blow"], backend="numpy")


def test_rows_are_in_the_order_of_the_catalogue(two: Stress) -> None:
    assert [row.name for row in two.rows] == ["duration-ratio-1", "two-granules-blow"]
    assert [row.backend for row in two.rows] == ["numpy", "numpy"]


def test_cases_that_pass_end_with_0(two: Stress) -> None:
    assert two.passed
    assert two.exit_code == 0


def failed() -> Row:
    finding = Finding(outcome="1 F0", error=math.inf, bound=1e-6, momentum_defect=0.0)
    return Row.of(case(lambda backend: finding), "numpy", finding, 0.5)


def test_a_failure_ends_with_1() -> None:
    run = Stress(rows=(failed(),), seconds=1.0)
    assert run.exit_code == 1
    assert "trial (numpy): error is inf" in str(run)
    assert str(run).endswith("0 of 1 passed in 1.0 s")


@pytest.mark.parametrize("rows", ["two", "failed"])
def test_the_document_holds_no_nan(rows: str, two: Stress) -> None:
    run = two if rows == "two" else Stress(rows=(failed(),), seconds=1.0)
    document = json.loads(json.dumps(run.to_dict(), allow_nan=False))
    assert document["passed"] is run.passed
    assert len(document["cases"]) == len(run.rows)


def test_every_row_is_told_as_soon_as_it_is_known() -> None:
    told: list[str] = []
    stress(["one-granule", "no-force"], backend="numpy", tell=lambda row: told.append(row.name))
    assert sorted(told) == ["no-force", "one-granule"]


def test_a_theme_stands_for_its_cases() -> None:
    assert [one.name for one in find(["collisions"])] == ["steep-decay", "recollisions", "chain-flies-apart"]


def test_no_name_stands_for_all_cases() -> None:
    assert find([]) == CASES


def test_a_name_that_is_no_case_is_answered_with_the_nearest() -> None:
    with pytest.raises(sw.UnknownNameError, match="did you mean 'steep-decay'"):
        find(["steep-decya"])


@pytest.mark.slow
def test_both_codes_are_run_unless_one_is_asked_for() -> None:
    codes = ["numpy"] if compiled is None else ["compiled", "numpy"]
    assert [row.backend for row in stress(["two-granules"]).rows] == codes


def test_what_steps_no_chain_or_by_numpy_alone_is_run_once() -> None:
    refused = {one.name for one in CASES if one.must.startswith("InvalidValueError") and not one.twice}
    assert {one.name for one in CASES if not one.twice} - refused == {"slow-push-dop853", "slow-push-radau"}
    assert "one-granule" in refused


# ---------------------------------------------------------------- the page


def test_page_tells_every_case() -> None:
    rows = [[f"`{one.name}`", one.asked, one.must] for one in CASES]
    assert table("docs/stress.md", "cases") == rows
