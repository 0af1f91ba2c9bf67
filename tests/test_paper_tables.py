"""Tables 1 and 2 of the paper, from the scenario files that the project ships."""

from __future__ import annotations

from pathlib import Path

import pytest

import shockwave as sw

PAPER = Path(__file__).parent.parent / "profiles" / "paper"


def compared(name: str) -> tuple[sw.Scenario, sw.Comparison]:
    scenario = sw.load_scenario(PAPER / f"{name}.yaml")
    return scenario, sw.compare(scenario.shock, scenario.chain, scenario.predictor, rtol=1e-7)


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
    assert scenario.published is not None
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
    outcome, shock = found.predicted, scenario.shock
    assert isinstance(outcome, sw.EjectionOutcome)
    assert outcome.relation == "less"
    # half a unit of the last digit given
    assert outcome.virtual_rise_time * 1e6 == pytest.approx(virtual, abs=5e-4)
    assert outcome.peak_force == pytest.approx(by_5h, abs=5e-4)
    parameter = scenario.chain.momentum_parameter(13 / 3)
    assert (outcome.applied_momentum / parameter) ** 1.2 == pytest.approx(by_5f, abs=5e-4)
    # (5h) is (5f) with the added momentum: powers and a quotient, rounding.
    total = outcome.applied_momentum + outcome.added_momentum
    assert (total / parameter) ** 1.2 == pytest.approx(outcome.peak_force, rel=1e-13)
    # eta2 = 1 in all rows: the virtual shock ends in a triangle, of height d/((n - 1) t0_hat) over d = t0_hat - t0.
    hat, n = outcome.virtual_rise_time, shock.profile.duration_ratio
    added = shock.peak_force * (hat - shock.rise_time) ** 2 / ((n - 1) * hat)
    assert outcome.added_momentum == pytest.approx(added, rel=1e-12)
    assert found.simulated.peak_force == pytest.approx(simulated, rel=1e-6)
    assert round(100 * found.error, 2) == error
    low, high = outcome.expected_error or (0.0, 0.0)
    assert low <= found.error <= high
