"""Curves of what comes behind the primary, against simulations that had no part in them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import shockwave as sw
from scenes import CHAIN, FORCE, UNITS
from shockwave.curve import TrainCurve

SHAPES = {
    "triangle": sw.Triangular(duration_ratio=3),
    "exponential": sw.Exponential(rise_rate=5, decay_rate=5, duration_ratio=5),
}
# None is a node; the first makes no train.
DURATIONS = (0.013, 0.7, 2.2, 3.3, 4.1, 6.0, 11.0)
CASES = [
    pytest.param(name, duration, marks=[pytest.mark.slow] * (name != "triangle"))
    for name in SHAPES
    for duration in DURATIONS
]


@cache
def curve(name: str) -> TrainCurve:
    return TrainCurve(SHAPES[name], longest=12)


@cache
def simulated(name: str, duration: float) -> sw.SimulationResult:
    profile = SHAPES[name]
    shock = sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=duration * UNITS.time)
    return sw.simulate(shock, CHAIN, rtol=1e-6, wave_threshold=1e-3)


def ratio(name: str, duration: float) -> float:
    return duration / SHAPES[name].duration_ratio


@pytest.mark.parametrize(("name", "duration"), CASES)
def test_the_second_wave_is_within_the_tolerance(name: str, duration: float) -> None:
    waves = simulated(name, duration).waves
    known = waves[1].peak_force / FORCE if len(waves) > 1 else 0.0
    assert float(curve(name).second(ratio(name, duration))) == pytest.approx(known, abs=5e-3)


@pytest.mark.parametrize(("name", "duration"), CASES)
def test_the_recoil_is_within_a_fifth_of_the_tolerance(name: str, duration: float) -> None:
    result = simulated(name, duration)
    known = -result.recoil_momentum / result.applied_momentum
    assert float(curve(name).recoil(ratio(name, duration))) == pytest.approx(known, abs=1e-3)


@pytest.mark.parametrize(("name", "duration"), CASES)
def test_the_number_of_waves_lies_between_its_bounds(name: str, duration: float) -> None:
    least, most = curve(name).waves(ratio(name, duration))
    assert least <= len(simulated(name, duration).waves) <= most


def test_errors_told_are_within_the_tolerance() -> None:
    ratios = np.geomspace(1e-3, curve("triangle").longest_rise_time, 200)
    assert curve("triangle").second_error(ratios).max() <= 5e-3
    assert curve("triangle").recoil_error(ratios).max() <= 1e-3


def test_a_saved_train_is_the_same_to_the_last_bit(tmp_path: Path) -> None:
    curve("triangle").save(tmp_path / "train.json")
    assert TrainCurve.load(tmp_path / "train.json") == curve("triangle")


def test_a_curve_of_the_primary_is_no_train() -> None:
    document = curve("triangle").to_dict() | {"format": "shockwave universal curve"}
    with pytest.raises(sw.InvalidValueError, match="format: must be 'shockwave train curve'"):
        TrainCurve.from_dict(document)


@pytest.mark.parametrize("value", [[], [[0.0]], [[0.0, 1], [0.0, 1]]], ids=["none", "no number", "not ascending"])
def test_a_file_without_counts_is_refused(value: Any) -> None:
    with pytest.raises(sw.InvalidValueError, match="counts"):
        TrainCurve.from_dict(curve("triangle").to_dict() | {"counts": value})


@pytest.mark.parametrize("bad", [0.0, 4.001, float("nan"), "one"], ids=repr)
def test_rise_times_beyond_the_curve_are_refused(bad: Any) -> None:
    with pytest.raises(sw.InvalidValueError, match="rise_time: must be t0/T0 > 0 and <= 4"):
        curve("triangle").second(bad)


def test_a_shape_that_makes_no_train_is_refused() -> None:
    profile = sw.PowerLaw(rise_exponent=1e3, decay_exponent=1e3, duration_ratio=3)
    with pytest.raises(sw.InvalidValueError, match=r"longest: must be above .* for this shape"):
        TrainCurve(profile)


def test_a_train_prints_its_errors() -> None:
    lines = str(curve("triangle")).splitlines()
    assert lines[0] == "train curve of Triangular(duration_ratio=3)"
    assert any(line.startswith("  recoil         within ") for line in lines)
