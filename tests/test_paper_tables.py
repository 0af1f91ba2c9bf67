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
    ("name", "virtual_rise_time", "simulated", "predicted", "error"),
    [
        ("table2-row1", 14.41e-6, 50.88311, 52.489, 3.16),
        ("table2-row2", 24.02e-6, 75.89821, 77.902, 2.64),
        ("table2-row3", 9.61e-6, 35.49084, 35.994, 1.42),
        ("table2-row4", 7.94e-6, 20.85979, 21.482, 2.98),
        ("table2-row5", 8.58e-6, 27.61066, 28.022, 1.49),
    ],
)
def test_table_2(name: str, virtual_rise_time: float, simulated: float, predicted: float, error: float) -> None:
    _, found = compared(name)
    outcome = found.predicted
    assert isinstance(outcome, sw.EjectionOutcome)
    # half a unit of the last digit given
    assert outcome.virtual_rise_time == pytest.approx(virtual_rise_time, abs=5e-9)
    assert outcome.peak_force == pytest.approx(predicted, abs=5e-4)
    assert found.simulated.peak_force == pytest.approx(simulated, rel=1e-6)
    assert round(100 * found.error, 2) == error
    low, high = outcome.expected_error or (0.0, 0.0)
    assert low <= found.error <= high
