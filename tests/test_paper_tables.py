"""Tables 1 and 2 of the paper, from the scenario files that the project ships."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

import shockwave as sw

PAPER = Path(__file__).parent.parent / "profiles" / "paper"


@cache
def row(name: str) -> sw.Comparison:
    scenario = sw.load_scenario(PAPER / f"{name}.yaml")
    return sw.compare(scenario.shock, scenario.chain, scenario.predictor, rtol=1e-7)


@pytest.mark.parametrize(
    ("name", "peaks", "relation"),
    [
        ("table1-row1", (101.81738, 14.556), "equal"),
        ("table1-row2", (82.82810, 0.77), "less"),
        ("table1-row3", (127.00698, 14.012), "greater"),
    ],
)
class TestTable1:
    def test_simulated_peak(self, name: str, peaks: tuple[float, float], relation: str) -> None:
        assert row(name).simulated.peak_force == pytest.approx(peaks[0], rel=1e-6)

    def test_simulated_second_wave(self, name: str, peaks: tuple[float, float], relation: str) -> None:
        # to the digits that are given
        assert row(name).simulated.waves[1].peak_force == pytest.approx(peaks[1], abs=5e-3)

    def test_predicted_relation(self, name: str, peaks: tuple[float, float], relation: str) -> None:
        assert row(name).predicted.relation == relation

    def test_simulated_relation(self, name: str, peaks: tuple[float, float], relation: str) -> None:
        assert row(name).relation == relation

    def test_printed_relation(self, name: str, peaks: tuple[float, float], relation: str) -> None:
        published = sw.load_scenario(PAPER / f"{name}.yaml").published
        assert published is not None
        assert published.relation == relation


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
class TestTable2:
    def test_virtual_rise_time(
        self, name: str, virtual_rise_time: float, simulated: float, predicted: float, error: float
    ) -> None:
        outcome = row(name).predicted
        assert isinstance(outcome, sw.EjectionOutcome)
        assert outcome.virtual_rise_time == pytest.approx(virtual_rise_time, abs=5e-9)

    def test_simulated_peak(
        self, name: str, virtual_rise_time: float, simulated: float, predicted: float, error: float
    ) -> None:
        assert row(name).simulated.peak_force == pytest.approx(simulated, rel=1e-6)

    def test_predicted_peak(
        self, name: str, virtual_rise_time: float, simulated: float, predicted: float, error: float
    ) -> None:
        assert row(name).predicted.peak_force == pytest.approx(predicted, abs=5e-4)

    def test_error_to_the_last_digit(
        self, name: str, virtual_rise_time: float, simulated: float, predicted: float, error: float
    ) -> None:
        assert round(100 * row(name).error, 2) == error

    def test_error_lies_in_the_range_told(
        self, name: str, virtual_rise_time: float, simulated: float, predicted: float, error: float
    ) -> None:
        bounds = row(name).predicted.expected_error
        assert bounds is not None
        assert bounds[0] <= error / 100 <= bounds[1]
