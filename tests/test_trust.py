"""The ranges of error that predictions tell, on shocks that were not used to make them."""

from __future__ import annotations

from functools import cache
from itertools import islice

import pytest

import shockwave as sw
from measure_trust import draws, judge
from scenes import CHAIN, FORCE, UNITS
from shockwave.prediction.trust import expected_error
from shockwave.profiles.conditions import Condition

COUNT = 40


@cache
def verdicts() -> list[tuple[str, str, float]]:
    return [judge(shock) for shock in islice(draws(2026), COUNT)]


def test_errors_lie_in_the_ranges_told() -> None:
    told = [standing for _, standing, _ in verdicts() if standing != "not told"]
    # of 645 ranges told in 800 draws of another seed, 644 held; 95 % are promised
    assert told.count("in") >= 0.95 * len(told)


def test_most_shocks_are_told_a_range() -> None:
    assert sum(standing != "not told" for _, standing, _ in verdicts()) > 0.9 * COUNT


def test_ranges_are_narrow_where_one_wave_forms() -> None:
    low, high = expected_error("ejection", 0.1, 0.3, 0.3**1.2, [])[0] or (0, 0)
    assert high - low < 0.1


@pytest.mark.parametrize("trust", [0.17, 0.5])
def test_no_range_is_told_beyond_the_widest_window(trust: float) -> None:
    bounds, sentences = expected_error("ejection", trust, 0.3, 0.3, [])
    assert bounds is None
    assert "simulate instead" in sentences[0]


def test_no_range_is_told_outside_the_conditions() -> None:
    broken = Condition("steep-rise", "a1 >= 1/2", -0.1, False)
    bounds, sentences = expected_error("train", 2.0, 1.0, 1.0, [broken])
    assert bounds is None
    assert "a1 >= 1/2 fails by 0.1" in sentences[0]


def test_a_correction_larger_than_the_shock_is_told() -> None:
    bounds, sentences = expected_error("ejection", 0.05, 0.01, 0.01, [])
    assert bounds is not None
    assert bounds[0] > 0.5
    assert "simulate instead" in sentences[0]


def test_no_range_is_told_for_a_shock_with_two_peaks() -> None:
    record = sw.Tabulated(times=[0, 1e-5, 3e-5, 5e-5, 9e-5], forces=[0, 100, 20, 60, 0])
    outcome = sw.Predictor().predict(sw.Shock(profile=record), CHAIN)
    assert outcome.expected_error is None
    assert any("several peaks (it turns by 40% of its peak)" in warning for warning in outcome.warnings)


def test_no_range_is_told_for_a_coefficient_of_one_s_own() -> None:
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=100.0, rise_time=1e-5)
    assert sw.Predictor(momentum_coefficient=8.0).predict(shock, CHAIN).expected_error is None


@pytest.mark.parametrize("ratio", [2.25, 2.3148, 4.0])
@pytest.mark.parametrize("duration", [5.0, 8.0, 14.0])
def test_errors_of_triangles_lie_in_the_ranges_told(ratio: float, duration: float) -> None:
    shock = sw.Shock(
        profile=sw.Triangular(duration_ratio=ratio), peak_force=FORCE, rise_time=duration / ratio * UNITS.time
    )
    found = sw.compare(shock, CHAIN, rtol=1e-2, wave_threshold=0.5)
    bounds = found.predicted.expected_error
    if max(found.predicted.waves, key=lambda wave: wave.peak_force) != found.predicted.waves[0]:
        assert bounds is None  # (5i) puts a later wave above the primary: the formula has left its ground
    else:
        assert bounds is not None
        assert bounds[0] <= found.error <= bounds[1]
