"""The catalogue of extremes: its quick cases pass, its checks can fail, and no case takes the others down."""

from __future__ import annotations

import json
import math
import os
import time

import attrs
import pytest

import shockwave as sw
from pages import table
from scenes import CHAIN, power
from shockwave.benchmark import extreme_checks, stress
from shockwave.benchmark.extreme_cases import CASES, Case, find
from shockwave.benchmark.extreme_checks import CHECKS, Finding
from shockwave.benchmark.stress import Row, Stress, checked
from shockwave.simulation.backend import compiled

QUICK = [case for case in CASES if case.limit <= 60]
#: One of each kind of check, for the code in NumPy.
WITH_NUMPY = ("rates-1e-12", "small-weak-stiff", "rise-time-1e-12", "two-granules-blow", "steep-decay", "no-force")


def case(check: str, scene: tuple[float, ...] = (0.5, 1, 3, 0.5), **fields: object) -> Case:
    """A case that is in no catalogue, of a shock that is not short."""
    options = {"waves": "primary"}
    return Case(name="trial", theme="trials", asked="?", check=check, scene={"power": scene}, options=options, **fields)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "one",
    [pytest.param(one, id=one.name, marks=[pytest.mark.slow] * (index % 8 > 0)) for index, one in enumerate(QUICK)],
)
def test_quick_cases_pass(one: Case) -> None:
    assert checked(one, "numpy" if compiled is None else "compiled").faults == ()


@pytest.mark.parametrize("name", WITH_NUMPY)
def test_cases_of_every_kind_pass_in_numpy(name: str) -> None:
    (one,) = find([name])
    assert checked(one, "numpy").faults == ()


def test_names_are_unique_checks_exist_and_the_page_lists_every_case() -> None:
    names = [*(one.name for one in CASES), *{one.theme for one in CASES}]
    assert len(set(names)) == len(names)
    assert {one.check for one in CASES} == set(CHECKS)
    assert table("docs/stress.md", "cases") == [[f"`{one.name}`", one.asked, one.must] for one in CASES]


# ---------------------------------------------------------------- checks can fail


@pytest.mark.parametrize(
    ("one", "count"),
    [
        pytest.param(case("number", reference=0.51), 1, id="another number"),
        pytest.param(case("law"), 1, id="a shock that is not short"),
        # simulation and prediction both
        pytest.param(case("like", other={"power": [0.5, 1, 3, 0.5001]}), 2, id="another scene"),
        pytest.param(case("refused", message="must be > 0"), 1, id="no error"),
        pytest.param(case("refused", (1, 1, 1, 1), message="must be > 0"), 1, id="an error with another message"),
        pytest.param(case("number", (1, 1, 1, 1)), 1, id="an error by accident"),
    ],
)
def test_what_must_not_happen_is_a_fault(one: Case, count: int) -> None:
    assert len(checked(one, "numpy").faults) == count


@pytest.mark.parametrize(
    ("changes", "rtol", "fault"),
    [
        ({"chain_momentum": 1 + 1e-11}, 1e-6, "the momentum balance is violated by 1.0e-11"),
        ({"energy": math.nan}, 1e-6, "a value of the result is not finite"),
        ({}, 1e-13, "the tolerance was not met"),
    ],
    ids=["momentum", "not-finite", "tolerance"],
)
def test_a_result_that_is_not_sound_is_a_fault(
    changes: dict[str, float], rtol: float, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = sw.simulate(power(0.5), CHAIN, waves="primary", rtol=rtol)
    changed = {name: getattr(result.found, name) * factor for name, factor in changes.items()}
    broken = attrs.evolve(result, found=result.found._replace(**changed))
    monkeypatch.setattr(extreme_checks, "simulate", lambda *_, **__: broken)
    (found,) = checked(case("number", reference=result.amplification), "numpy").faults
    assert found.startswith(fault)


# ---------------------------------------------------------------- the run


def hung(name: str, backend: str) -> None:
    time.sleep(60)


def crashed(name: str, backend: str) -> None:
    os.abort()


@pytest.mark.parametrize(
    ("work", "limit", "outcome"),
    [
        (hung, 0.1, "does not end: stopped after 0.1 s"),
        (crashed, 60.0, "its process ended with status -6"),
    ],
    ids=["hangs", "crashes"],
)
def test_a_case_that_does_not_end_as_it_should_is_a_row_that_says_so(
    work: object, limit: float, outcome: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stress, "_in_process", work)
    monkeypatch.setattr(stress, "find", lambda _: [attrs.evolve(find(["one-granule"])[0], limit=limit)])
    (row,) = stress.stress(backend="numpy").rows
    assert (row.finding.outcome, row.passed) == (outcome, False)


FAILED = Stress((Row(case("law"), "numpy", Finding("1 F0", ("it is wrong",), math.inf, 1e-6), 0.5),), 1.0)


def test_a_failure_ends_with_1_and_says_why() -> None:
    assert FAILED.exit_code == 1
    assert str(FAILED).endswith("trial (numpy): it is wrong\n0 of 1 passed in 1.0 s")


def test_rows_are_in_the_order_of_the_catalogue_and_the_document_holds_no_nan() -> None:
    passed = stress.stress(["two-granules-blow", "duration-ratio-1"], backend="numpy")
    assert [row.case.name for row in passed.rows] == ["duration-ratio-1", "two-granules-blow"]
    for result, code in ((passed, 0), (FAILED, 1)):
        document = json.loads(json.dumps(result.to_dict(), allow_nan=False))
        assert (document["passed"], result.exit_code) == (code == 0, code)
        assert list(document["cases"][0]) == [
            *("case", "theme", "backend", "asked", "must", "passed", "outcome", "faults", "error", "bound"),
            *("momentum_defect", "seconds"),
        ]


def test_a_theme_stands_for_its_cases_and_no_name_for_all() -> None:
    assert [one.name for one in find(["collisions"])] == ["steep-decay", "recollisions", "chain-flies-apart"]
    assert find([]) == CASES


def test_a_name_that_is_no_case_is_answered_with_the_nearest() -> None:
    with pytest.raises(sw.UnknownNameError, match="did you mean 'steep-decay'"):
        find(["steep-decya"])


@pytest.mark.slow
def test_both_backends_are_run_unless_one_is_asked_for_or_nothing_is_stepped() -> None:
    both = ["numpy"] if compiled is None else ["compiled", "numpy"]
    rows = stress.stress(["two-granules", "one-granule", "slow-push-dop853"]).rows
    assert [row.backend for row in rows] == [*both, "numpy", "numpy"]
