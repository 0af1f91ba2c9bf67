"""Section 4 as a decision, one case for each branch, and Tables 1 and 2 of the paper."""

from __future__ import annotations

from pathlib import Path

import pytest

import shockwave as sw
from shockwave.prediction.scaled_shock import ScaledShock
from shockwave.prediction.section4 import predict
from support.scenes import CHAIN, FORCE, power_law

PAPER = sw.Predictor(model="section-4", momentum_coefficient="paper")
SCENARIOS = Path(__file__).parents[2] / "profiles" / "paper"
#: A F0^(-1/6) of the paper's beads at 100 N with 13/3, from eq. (4c) written out.
TIME = 13 / 3 * ((1 - 0.3**2) * 7958**1.5 * 4.75e-3**4 / 193e9) ** (1 / 3) * FORCE ** (-1 / 6)
Row = tuple[float, float, float]


def _power(row: Row, rise_time: float) -> sw.Shock:
    return sw.Shock(profile=power_law(*row), peak_force=FORCE, rise_time=rise_time)


def _in_units(units: float, n: float = 2.0) -> sw.Shock:
    """A triangle whose rise time is so many A F0^(-1/6)."""
    return sw.Shock(profile=sw.Triangular(duration_ratio=n), peak_force=FORCE, rise_time=units * TIME)


@pytest.mark.parametrize(
    ("tolerance", "relation"), [(0.0, "greater"), (0.0215, "greater"), (0.0225, "equal"), (0.5, "equal")], ids=str
)
def test_the_tolerance_of_equality_is_a_setting(tolerance: float, relation: str) -> None:
    # The sides of Table 1's first row differ by 2.204 %.
    predictor = sw.Predictor(model="section-4", momentum_coefficient="paper", equal_tolerance=tolerance)
    outcome = predictor.predict(_power((10, 1, 5), 15e-6), CHAIN)
    assert outcome.relation == relation
    # The digits that are given.
    step = outcome.trace[1]
    assert (round(step.left * 1e6, 2), round(step.right * 1e6, 2)) == (24.55, 24.02)


# ---------------------------------------------------------------- the decision


#: Shock and regime on either side of each border.
DECISIONS = {
    # A triangle with n = 2: alphaF0 = 2, impulse t0, duration 2 t0.
    "short-triangle": (_in_units(0.5), "ejection"),
    "triangle-just-below": (_in_units(0.999), "ejection"),
    "triangle-just-above": (_in_units(1.001), "train"),
    # Steep rise to 0.9 of the area: impulse 1.4 t0, duration 2 t0, alphaF0 = 2 - 0.4^1.5 = 1.747.
    "steep-ejection": (_power((2, 1 / 9, 1), 0.7 * TIME), "ejection"),
    "steep-single": (_power((2, 1 / 9, 1), 0.75 * TIME), "single"),
    "steep-single-just-below": (_power((2, 1 / 9, 1), 0.87 * TIME), "single"),
    "steep-train": (_power((2, 1 / 9, 1), 0.88 * TIME), "train"),
    # Long but weak: a train by its duration, though its impulse 0.51 TIME would not make one wave of F0.
    "weak-train": (_power((300, 1, 299), TIME * 0.34), "train"),
}
EQUATIONS = {"ejection": ["(5e)", "(5e)", "4.2.2"], "single": ["(5e)", "(5e)", "4.2.3"], "train": ["(5d)", "(5d)"]}


@pytest.mark.parametrize("decision", DECISIONS)
def test_regime_and_trace(decision: str) -> None:
    shock, regime = DECISIONS[decision]
    outcome = PAPER.predict(shock, CHAIN)
    classes = {"ejection": sw.EjectionOutcome, "single": sw.SingleOutcome, "train": sw.TrainOutcome}
    assert outcome.regime == regime
    assert type(outcome.section4) is classes[regime]
    assert [step.equation for step in outcome.trace] == EQUATIONS[regime]
    # in seconds; a few roundings
    assert outcome.trace[0].right == pytest.approx(shock.duration, rel=1e-14)
    assert outcome.trace[1].right == pytest.approx(TIME, rel=1e-13)


def test_equality_at_both_thresholds_is_a_single_wave() -> None:
    # alphaF0 tA = n t0 = 2 and L = tA = 1, without any rounding.
    profile = sw.Triangular(duration_ratio=2)
    shock = ScaledShock(profile=profile, areas=profile.areas(), rise_time=1.0, momentum_parameter=1.0)
    assert predict(shock).regime == "single"


def test_a_single_wave_takes_the_whole_impulse() -> None:
    outcome = PAPER.predict(_power((2, 1 / 9, 1), 0.8 * TIME), CHAIN)
    # (5f) with the impulse 1.4 t0 and A F0^(-1/6) = TIME; rounding.
    assert outcome.amplification == pytest.approx((1.4 * 0.8) ** 1.2, rel=1e-12)


def test_an_ejection_has_the_added_momentum_of_the_window() -> None:
    # A rectangle with n = 1.5: L = 0.6 TIME, and the window of (5h) adds 0.8/1.5 of it at full force.
    outcome = PAPER.predict(_power((1.5, 0, 0), 0.4 * TIME), CHAIN)
    assert outcome.amplification == pytest.approx((0.6 + 0.8 / 1.5) ** 1.2, rel=1e-12)


@pytest.mark.parametrize(
    ("ratio", "relation", "warned"), [(0.6, "less", True), (0.94, "less", True), (0.97, "equal", False)]
)
def test_an_ejection_with_a_smaller_impulse_and_a_stronger_wave_is_in_contradiction(
    ratio: float, relation: str, warned: bool
) -> None:
    # a rectangle with n = 1.5, whose (5h) gives (4 - ratio)/3 of the impulse of a wave of the peak force of the shock
    outcome = PAPER.predict(_power((1.5, 0, 0), ratio / 1.5 * TIME), CHAIN).section4
    assert (outcome.regime, outcome.relation) == ("ejection", relation)
    assert outcome.amplification == pytest.approx(((4 - ratio) / 3) ** 1.2, rel=1e-12)
    assert any("in contradiction to (5e)" in warning for warning in outcome.warnings) == warned


# ---------------------------------------------------------------- the paper's tables


def compared(name: str) -> tuple[sw.Scenario, sw.Comparison]:
    scenario = sw.load_scenario(SCENARIOS / f"{name}.yaml")
    return scenario, sw.compare(scenario, rtol=1e-7)


@pytest.mark.parametrize(
    ("name", "peaks", "relation"),
    [
        ("table1-row1", (101.81738, 14.556), "equal"),
        ("table1-row2", (82.82810, 0.77), "less"),
        ("table1-row3", (127.00698, 14.012), "greater"),
    ],
)
def test_table_1(name: str, peaks: tuple[float, float], relation: str) -> None:
    scenario, found = compared(name)
    assert found.simulated.peak_force == pytest.approx(peaks[0], rel=1e-6)
    # to the digits that are given
    assert found.simulated.waves[1].peak_force == pytest.approx(peaks[1], abs=5e-3)
    assert found.predicted.relation == found.relation == scenario.published.relation == relation


@pytest.mark.parametrize(
    ("name", "virtual", "by_5f", "by_5h", "simulated", "error"),
    [
        ("table2-row1", 14.414, 44.929, 52.489, 50.88311, 3.16),
        ("table2-row2", 24.024, 70.722, 77.902, 75.89821, 2.64),
        ("table2-row3", 9.610, 30.783, 35.994, 35.49084, 1.42),
        ("table2-row4", 7.938, 17.982, 21.482, 20.85979, 2.98),
        ("table2-row5", 8.580, 23.866, 28.022, 27.61066, 1.49),
    ],
)
def test_table_2(name: str, virtual: float, by_5f: float, by_5h: float, simulated: float, error: float) -> None:
    scenario, found = compared(name)
    outcome, shock, impulse = found.predicted.section4, scenario.shock, found.predicted.applied_momentum
    assert outcome.relation == "less"
    # half a unit of the last digit given
    assert outcome.virtual_rise_time * 1e6 == pytest.approx(virtual, abs=5e-4)
    assert outcome.peak_force == pytest.approx(by_5h, abs=5e-4)
    parameter = scenario.chain.momentum_parameter(13 / 3)
    assert (impulse / parameter) ** 1.2 == pytest.approx(by_5f, abs=5e-4)
    # (5h) is (5f) with the added momentum: powers and a quotient, rounding.
    total = impulse + outcome.added_momentum
    assert (total / parameter) ** 1.2 == pytest.approx(outcome.peak_force, rel=1e-13)
    # eta2 = 1 in all rows: the virtual shock ends in a triangle, of height d/((n - 1) t0_hat) over d = t0_hat - t0.
    hat, n = outcome.virtual_rise_time, shock.profile.duration_ratio
    added = shock.peak_force * (hat - shock.rise_time) ** 2 / ((n - 1) * hat)
    assert outcome.added_momentum == pytest.approx(added, rel=1e-12)
    # rebounding granules add what they carry backwards
    ratio = outcome.added_momentum / -found.simulated.recoil_momentum
    assert found.errors.added_momentum == pytest.approx(ratio - 1, rel=1e-12)
    assert found.simulated.peak_force == pytest.approx(simulated, rel=1e-6)
    assert round(100 * found.errors.peak_force, 2) == error


# ---------------------------------------------------------------- trains


def test_each_wave_of_a_long_train_takes_few_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    shock, calls = _power((100, 1, 1), 100 * TIME), []
    closed = sw.PowerLaw.closed_at
    monkeypatch.setattr(sw.PowerLaw, "closed_at", lambda profile, s: calls.append(s) or closed(profile, s))
    waves = PAPER.predict(shock, CHAIN).waves
    assert len(waves) > 900
    # about four steps of Newton's method, and one evaluation at the end of the wave
    assert len(calls) < 6 * len(waves)
