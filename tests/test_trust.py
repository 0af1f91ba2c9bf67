"""Expected errors of predictions for shocks that were not used to determine them, and the data of the laws."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from attrs import frozen

import shockwave as sw
from pages import table as table_of
from pulse_families import FAMILIES
from scenes import CHAIN, FORCE, UNITS, script
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.prediction import expected_error
from shockwave.prediction.model_interface import ScaledShock
from shockwave.prediction.shock_measures import Measures, measures

# A thousand shocks with a range, drawn with a seed of their own; singles are drawn on purpose.
COUNTS = {"built-in": 440, "recorded": 350, "composed": 60, "single": 150}
CLAIMED = 0.95


def study() -> ModuleType:
    return script("map_section4")


@cache
def table(name: str) -> dict[str, Any]:
    return dict(study().read(name))


@cache
def resource() -> dict[str, Any]:
    return dict(
        json.loads((Path(expected_error.__file__).parent / expected_error.RESOURCE).read_text(encoding="utf-8"))
    )


#: Which part of them is drawn.
PARTS = pytest.mark.parametrize(
    "part", [pytest.param(1, id="all", marks=pytest.mark.slow), pytest.param(10, id="part")]
)


@frozen
class Verdict:
    """A shock's regime, its range of error, and whether the error lies in it as far as simulation shows."""

    regime: str
    width: float
    holds: bool


@cache
def verdicts(family: str, part: int) -> list[Verdict]:
    """Random shocks of a family that satisfy (3) and have a range."""
    draw = np.random.default_rng(2026)
    shocks: list[sw.Shock] = []
    outcomes: list[sw.Outcome] = []
    while len(shocks) < COUNTS[family] // part:
        profile = FAMILIES[family](draw)
        shock = lasting(profile, draw.uniform(2.2, 3.4) if family == "single" else 10 ** draw.uniform(-2.0, 1.75))
        outcome = sw.Predictor().predict(shock, CHAIN)
        met = outcome.expected_error is not None and all(condition.holds for condition in outcome.conditions)
        if met and (family != "single" or outcome.regime == "single"):
            shocks.append(shock)
            outcomes.append(outcome)
    return [
        verdict(outcome, result)
        for outcome, result in zip(outcomes, sw.simulate_many(shocks, CHAIN, rtol=1e-3, waves="primary"), strict=True)
    ]


def verdict(outcome: sw.Outcome, result: sw.SimulationResult | sw.ShockwaveError) -> Verdict:
    assert isinstance(result, sw.SimulationResult)
    low, high = outcome.expected_error or (math.nan, math.nan)
    error = outcome.peak_force / result.peak_force - 1
    doubt = (1 + error) * result.error_estimate
    return Verdict(outcome.regime, high - low, low - doubt <= error <= high + doubt)


def lasting(profile: sw.ShockProfile, duration: float) -> sw.Shock:
    return sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=duration * UNITS.time)


def predicted(profile: sw.ShockProfile, duration: float, **settings: Any) -> sw.Outcome:
    return sw.Predictor(**settings).predict(lasting(profile, duration), CHAIN)


def measured(profile: sw.ShockProfile, duration: float) -> Measures:
    found = measures(ScaledShock(profile, profile.areas(), duration / profile.duration_ratio, MOMENTUM))
    assert found is not None
    return found


# ---------------------------------------------------------------- whether the ranges hold


@PARTS
@pytest.mark.parametrize("regime", ["ejection", "single", "train"])
def test_errors_of_a_regime_are_in_their_ranges(regime: str, part: int) -> None:
    own = [verdict.holds for family in COUNTS for verdict in verdicts(family, part) if verdict.regime == regime]
    assert len(own) >= 150 // part
    assert np.mean(own) >= CLAIMED


# Medians of a quarter of them lie too far apart.
# Medians were 0.2, 2.8 and 9 % over 6 000 shocks.
@pytest.mark.slow
@pytest.mark.parametrize(("regime", "width"), [("ejection", 0.004), ("single", 0.04), ("train", 0.12)])
def test_ranges_are_narrow(regime: str, width: float) -> None:
    own = [each.width for family in COUNTS for each in verdicts(family, 1) if each.regime == regime]
    assert np.median(own) < width


def test_a_vanishing_shock_has_the_error_of_5f_in_the_impulse_limit() -> None:
    low, high = predicted(sw.Triangular(duration_ratio=1e6), 1e-4).expected_error or (math.nan, math.nan)
    assert low < 1 / 1.1681817 - 1 < high
    assert high - low < 0.002


def test_the_range_refers_to_the_simulated_force_for_any_coefficient() -> None:
    exact, paper = (predicted(sw.Triangular(duration_ratio=5), 3.0, momentum_coefficient=c) for c in ("exact", "paper"))
    assert exact.expected_error is not None
    assert paper.expected_error is not None
    # both say between which forces the simulated one lies
    for end, other in zip(exact.expected_error, paper.expected_error, strict=True):
        assert exact.peak_force / (1 + end) == pytest.approx(paper.peak_force / (1 + other), rel=1e-12)


# ---------------------------------------------------------------- where there is none

TRIANGLE = sw.Triangular(duration_ratio=4)
SPIKE = sw.Tabulated(times=[0, 1, 2, 99, 100], forces=[0, 100, 3, 3, 0])
TWO_PEAKS = sw.Tabulated(times=[0, 1, 3, 5, 9], forces=[0, 100, 20, 60, 0])


@pytest.mark.parametrize(
    ("profile", "duration", "settings", "sentence"),
    [
        (sw.PowerLaw(rise_exponent=3, decay_exponent=2, duration_ratio=3), 2.0, {}, "a1 >= 1/2 fails by 0.25"),
        (sw.Triangular(duration_ratio=1.1), 1.0, {}, "a2 >= a1 fails by"),
        (sw.PowerLaw(rise_exponent=1, decay_exponent=0.5, duration_ratio=30), 30.0, {}, "a2 <= (n-1)/2 fails by"),
        (TWO_PEAKS, 6.0, {}, "several peaks (its force reverses by 40% of the peak force)"),
        # a triangle with n = 2 and rise time T has a window (1 - T/1.652)/2, with 1.652 = A F0^(-1/6) over T0
        (sw.Triangular(duration_ratio=2), 2 * 1.652 * (1 - 2 * 0.17), {}, "errors have no useful bound above 0.165"),
        (TRIANGLE, 6.0, {"momentum_coefficient": 8.0}, "This interpretation"),
        (TRIANGLE, 6.0, {"alpha": "literal"}, "This interpretation"),
        (sw.PowerLaw(rise_exponent=0.1, decay_exponent=1, duration_ratio=50), 61.0, {}, "longer"),
        (SPIKE, 50.0, {}, "or its shape differs"),
    ],
    ids=["outside-3", "sawtooth", "slow-decay", "two-peaks", "window", "coefficient", "literal", "long", "shape"],
)
def test_there_is_no_range(profile: sw.ShockProfile, duration: float, settings: dict[str, Any], sentence: str) -> None:
    outcome = predicted(profile, duration, **settings)
    assert outcome.expected_error is None
    assert any(sentence in warning for warning in outcome.warnings)


def test_a_window_of_less_than_0_165_has_a_range() -> None:
    assert predicted(sw.Triangular(duration_ratio=2), 2 * 1.652 * (1 - 2 * 0.16)).expected_error is not None


# ---------------------------------------------------------------- measures


def test_measures_of_a_symmetric_triangle() -> None:
    found = measured(sw.Triangular(duration_ratio=2), 3.0)
    assert found.strength == pytest.approx(1.5 / MOMENTUM, rel=1e-12)
    # a triangle of base 3 has the standard deviation 3/sqrt(24)
    assert found.spread == pytest.approx(3 / math.sqrt(24) / MOMENTUM * (1.5 / MOMENTUM) ** 0.2, rel=1e-12)
    assert found.skewness == pytest.approx(0, abs=1e-12)
    assert found.mean_force == pytest.approx(2 / 3, rel=1e-12)
    assert found.cubic_mean_force == pytest.approx((2 / 5) ** (1 / 3), rel=1e-12)


# ---------------------------------------------------------------- the data behind it


def test_laws_are_those_fitted_to_the_shipped_shocks() -> None:
    again = study().fitted(table("pulses.csv"))
    assert {key: again[key] for key in ("about", "provenance")} == {
        key: resource()[key] for key in ("about", "provenance")
    }
    for name, entries in resource()["laws"].items():
        for key in ("centre", "scale", "farthest", "bounds", "low", "high", "longest", "coefficients"):
            if key in entries:
                # sums of a few thousand terms differ in their last digits from machine to machine
                assert np.allclose(again["laws"][name][key], entries[key], rtol=1e-5, atol=1e-8), f"{name}.{key}"


@pytest.mark.parametrize("name", ["short", "long"])
def test_the_page_shows_the_bands_of_the_laws(name: str) -> None:
    entries = resource()["laws"][name]
    bounds = np.exp(entries["bounds"]) if name == "long" else entries["bounds"]
    own = zip(bounds, entries["low"], entries["high"], entries["shocks"], strict=True)
    shown = [[float(cell) for cell in row] for row in table_of("docs/trust.md", f"{name} law")]
    # two decimals of a percent, two digits of a bound
    assert shown == [[float(f"{b:.2g}"), round(100 * low, 2), round(100 * high, 2), n] for b, low, high, n in own]


def test_shipped_shocks_are_those_of_the_seed() -> None:
    module = study()
    shocks = [shock for _, shock in module.random_shocks(module.SEED, 40)]
    for i, (shock, peak) in enumerate(zip(shocks, module.simulated(shocks), strict=True)):
        found = measures(module.scaled(shock))
        assert found is not None
        assert table("pulses.csv")["spread"][i] == pytest.approx(found.spread, rel=1e-5)
        assert table("pulses.csv")["simulated"][i] == pytest.approx(peak, rel=2 * module.RTOL)
