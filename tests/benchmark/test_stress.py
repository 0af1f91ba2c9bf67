"""Extreme cases: the catalogue passes, and its checks can fail; accuracy of steep, rough and slow shocks."""

from __future__ import annotations

import json
import math
import os
import time
from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave.benchmark import extreme_cases, stress
from shockwave.benchmark.benchmark_scenes import noisy_pulse, sampled_pulse
from shockwave.benchmark.extreme_cases import CASES, CHECKS, Case, Finding, find_cases
from shockwave.benchmark.stress import Row, Stress, check
from shockwave.engine.backend import compiled
from support.pages import table
from support.scenes import CHAIN, lasting, power
from support.slow_cases import thinned

QUICK = [case for case in CASES if case.limit <= 60]
#: One case for each kind of check, for the NumPy backend.
WITH_NUMPY = ("rates-1e-12", "small-weak-stiff", "rise-time-1e-12", "two-granules-blow", "steep-decay", "no-force")


def case(check: str, scene: tuple[float, ...] = (0.5, 1, 3, 0.5), **fields: object) -> Case:
    """A case outside the catalogue, with a shock that is not short."""
    fields = {"scene": {"power_law": scene}, "options": {"waves": "primary"}, **fields}
    return Case(name="trial", theme="trials", description="a shock", check=check, **fields)  # type: ignore[arg-type]


@pytest.mark.parametrize("one", thinned(QUICK, 8), ids=lambda one: one.name)
def test_quick_cases_pass(one: Case) -> None:
    assert check(one, "numpy" if compiled is None else "compiled").faults == ()


@pytest.mark.parametrize("name", WITH_NUMPY)
def test_cases_of_every_kind_pass_in_numpy(name: str) -> None:
    (one,) = find_cases([name])
    assert check(one, "numpy").faults == ()


def test_names_are_unique_checks_exist_and_the_page_lists_every_case() -> None:
    names = [*(one.name for one in CASES), *{one.theme for one in CASES}]
    assert len(set(names)) == len(names)
    assert {one.check for one in CASES} == set(CHECKS)
    assert table("docs/stress.md", "cases") == [[f"`{one.name}`", one.description, one.must] for one in CASES]


@pytest.mark.parametrize(
    ("one", "count"),
    [
        pytest.param(case("reference_value", reference=0.51), 1, id="another number"),
        pytest.param(case("impulse_limit"), 1, id="a shock that is not short"),
        # simulation and prediction both
        pytest.param(case("equal_scene", other={"power_law": [0.5, 1, 3, 0.5001]}), 2, id="another scene"),
        pytest.param(case("raised_error", message="must be > 0"), 1, id="no error"),
        pytest.param(case("raised_error", (1, 1, 1, 1), message="must be > 0"), 1, id="an error with another message"),
    ],
)
def test_wrong_result_is_a_fault(one: Case, count: int) -> None:
    assert len(check(one, "numpy").faults) == count


@pytest.mark.parametrize(
    ("changes", "rtol", "fault"),
    [
        ({"chain_momentum": 1 + 1e-11}, 1e-6, "the momentum balance is violated by 1.0e-11"),
        ({"energy": math.nan}, 1e-6, "a value of the result is not finite"),
        ({}, 1e-13, "The tolerance was not met"),
    ],
    ids=["momentum", "not-finite", "tolerance"],
)
def test_unsound_result_is_a_fault(
    changes: dict[str, float], rtol: float, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = sw.simulate(power(0.5), CHAIN, waves="primary", rtol=rtol)
    changed = {name: getattr(result.wave.scaled, name) * factor for name, factor in changes.items()}
    scaled = result.wave.scaled._replace(**changed)
    wave = attrs.evolve(result.wave, scaled=scaled)
    broken = attrs.evolve(result, wave=wave, momentum_defect=scaled.momentum_defect)
    monkeypatch.setattr(extreme_cases, "simulate", lambda *_, **__: broken)
    (found,) = check(case("reference_value", reference=result.amplification), "numpy").faults
    assert found.startswith(fault)


def hung(name: str, backend: str) -> None:
    time.sleep(60)


def crashed(name: str, backend: str) -> None:
    os.abort()


@pytest.mark.parametrize(
    ("work", "limit", "outcome"),
    [(hung, 0.1, "stopped at the time limit of 0.1 s"), (crashed, 60.0, "the process ended with status -6")],
    ids=["hangs", "crashes"],
)
def test_case_that_hangs_or_crashes_has_a_row_that_states_it(
    work: object, limit: float, outcome: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stress, "_check_by_name", work)
    monkeypatch.setattr(stress, "find_cases", lambda _: [attrs.evolve(find_cases(["one-granule"])[0], limit=limit)])
    (row,) = stress.stress(backend="numpy").rows
    assert (row.finding.outcome, row.passed) == (outcome, False)


WRONG = Row(case("impulse_limit", must="law"), "numpy", Finding("1 F0", ("it is wrong",), math.inf, 1e-6), 0.5)
FAILED = Stress((attrs.evolve(WRONG, finding=Finding("2 F0")), WRONG), 1.0)


def test_failed_cases_come_first_with_the_reason_and_the_exit_status_is_1() -> None:
    assert FAILED.exit_code == 1
    lines = str(FAILED).splitlines()
    assert lines[0] == "1 of 2 cases passed (1.0 s)"
    reason = "trial (numpy), a shock: it is wrong (result: 1 F0; required: law)"
    assert lines[1].strip() == f"! {reason}"
    assert [line.split()[2] for line in lines[5:7]] == ["FAILED", "passed"]


def test_rows_are_in_the_order_of_the_catalogue_and_the_document_contains_no_nan() -> None:
    passed = stress.stress(["two-granules-blow", "duration-ratio-1"], backend="numpy")
    assert [row.case.name for row in passed.rows] == ["duration-ratio-1", "two-granules-blow"]
    for result, code in ((passed, 0), (FAILED, 1)):
        document = json.loads(json.dumps(result.to_dict(), allow_nan=False))
        assert (document["passed"], result.exit_code) == (code == 0, code)
        assert list(document["cases"][0]) == [
            *("case", "theme", "backend", "asked", "must", "passed", "outcome", "faults", "error", "bound"),
            *("momentum_defect", "seconds"),
        ]


def test_an_unknown_name_is_refused_with_the_nearest() -> None:
    with pytest.raises(sw.UnknownNameError, match="did you mean 'steep-decay'"):
        find_cases(["steep-decya"])


@pytest.mark.slow
def test_both_backends_are_run_where_the_result_depends_on_them() -> None:
    both = ["numpy"] if compiled is None else ["compiled", "numpy"]
    rows = stress.stress(["two-granules", "one-granule", "slow-push-radau"]).rows
    assert [row.backend for row in rows] == [*both, "numpy", "numpy"]


each_backend = pytest.mark.parametrize("backend", ["numpy", *([] if compiled is None else ["compiled"])])


#: Shocks with layers inside a step, whose work the stages of the step do not resolve.
STEEP = {
    "drop-after-the-peak": (sw.Exponential(rise_rate=1.0, decay_rate=1e4, duration_ratio=3.0), 6.0),
    "high-power-of-a-train": (
        sw.PowerLaw(rise_exponent=0.1, decay_exponent=1000.0, duration_ratio=1.5),
        4.0191158124,
    ),
    "steep-at-both-ends": (sw.Exponential(rise_rate=-100.0, decay_rate=-700.0, duration_ratio=1e4), 0.4858348223366917),
}


@pytest.mark.parametrize("name", STEEP)
def test_error_of_steep_pulses_is_within_the_estimate_at_any_tolerance(name: str) -> None:
    shock = lasting(*STEEP[name])
    found, tight = (sw.simulate(shock, CHAIN, rtol=rtol, waves="primary") for rtol in (1e-6, 1e-10))
    assert found.warnings == ()
    assert abs(found.peak_force / tight.peak_force - 1) <= found.error_estimate + tight.error_estimate
    assert tight.error_estimate < 1e-9


@each_backend
def test_noise_does_not_increase_the_energy_defect(backend: Any) -> None:
    found = sw.simulate(noisy_pulse(1000)[0], CHAIN, backend=backend, waves="primary")
    assert found.error_estimate < 1e-6
    # with the integral of the impulse from the stages it would be 3e-7 to 1e-6
    assert found.energy_defect < 1.5e-7


@each_backend
def test_finer_samples_of_a_smooth_pulse_take_no_more_steps(backend: Any) -> None:
    shocks = [sampled_pulse(count)[0] for count in (10_001, 100_001)]
    coarse, fine = (sw.simulate(shock, CHAIN, backend=backend, waves="primary") for shock in shocks)
    assert fine.cost.steps < 1.5 * coarse.cost.steps
    # the two pulses differ by 1e-8, a hundredth of the permitted error of a step
    assert fine.peak_force == pytest.approx(coarse.peak_force, rel=1e-7)


def test_estimate_covers_the_error_where_both_runs_take_their_longest_steps() -> None:
    shock = lasting(sw.PowerLaw(rise_exponent=3.0, decay_exponent=3.0, duration_ratio=2.0), 2000.0)
    found = sw.simulate(shock, attrs.evolve(CHAIN, granules=5))
    # the amplification at rtol 1e-11 by the method of order 12, to ten digits
    assert abs(found.amplification / 0.6021994909 - 1) <= found.error_estimate + 1e-10
    assert found.error_estimate < 1e-6
