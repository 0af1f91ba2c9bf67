"""Expected errors of predictions for shocks that were not used to determine them, and the data of the laws."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import attrs
import numpy as np
import pytest
from attrs import frozen

import shockwave as sw
from pulse_families import FAMILIES
from scenes import CHAIN, FORCE, UNITS, lasting, script
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.prediction.model_interface import ScaledShock
from shockwave.prediction.shock_impulses import pulse_of

# A thousand shocks with a range, drawn with a seed of their own; singles are drawn on purpose.
COUNTS = {"built-in": 440, "recorded": 350, "composed": 60, "single": 150}
CLAIMED = 0.95


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


def predicted(profile: sw.ShockProfile, duration: float, **settings: Any) -> sw.Outcome:
    return sw.Predictor(**settings).predict(lasting(profile, duration), CHAIN)


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
    # 1.1681817 has eight digits
    assert (low, high) == pytest.approx((1 / 1.1681817 - 1,) * 2, rel=1e-6)


def test_the_range_refers_to_the_simulated_force_for_any_coefficient() -> None:
    exact, paper = (predicted(sw.Triangular(duration_ratio=5), 3.0, momentum_coefficient=c) for c in ("exact", "paper"))
    assert exact.expected_error is not None
    assert paper.expected_error is not None
    # both say between which forces the simulated one lies
    for end, other in zip(exact.expected_error, paper.expected_error, strict=True):
        assert exact.peak_force / (1 + end) == pytest.approx(paper.peak_force / (1 + other), rel=1e-12)


# ---------------------------------------------------------------- where there is none


@pytest.mark.parametrize(
    ("profile", "duration", "sentence"),
    [
        (sw.PowerLaw(rise_exponent=3, decay_exponent=2, duration_ratio=3), 2.0, "a1 >= 1/2 fails by 0.25"),
        (sw.Triangular(duration_ratio=1.1), 1.0, "a2 >= a1 fails by"),
        (sw.PowerLaw(rise_exponent=1, decay_exponent=0.5, duration_ratio=30), 30.0, "a2 <= (n-1)/2 fails by"),
        (sw.Triangular(duration_ratio=4), 5000.0, "longer"),
    ],
    ids=["outside-3", "sawtooth", "slow-decay", "long"],
)
def test_there_is_no_range(profile: sw.ShockProfile, duration: float, sentence: str) -> None:
    outcome = predicted(profile, duration)
    assert outcome.expected_error is None
    assert any(sentence in warning for warning in outcome.warnings)


TWO_PEAKS = sw.Tabulated(times=[0, 1, 3, 5, 9], forces=[0, 100, 20, 60, 0])


@pytest.mark.parametrize(
    ("profile", "duration", "settings"),
    [
        (TWO_PEAKS, 6.0, {}),
        (sw.Triangular(duration_ratio=2), 2.2, {}),
        (sw.Triangular(duration_ratio=4), 6.0, {"momentum_coefficient": 8.0}),
        (sw.Triangular(duration_ratio=4), 6.0, {"alpha": "literal"}),
    ],
    ids=["two-peaks", "wide-window", "coefficient", "literal"],
)
def test_the_range_holds_for_any_reading_of_section_4(
    profile: sw.ShockProfile, duration: float, settings: dict[str, Any]
) -> None:
    outcome = predicted(profile, duration, **settings)
    simulated = sw.simulate(lasting(profile, duration), CHAIN, rtol=1e-6, waves="primary").peak_force
    low, high = outcome.expected_error or (math.nan, math.nan)
    assert low <= outcome.peak_force / simulated - 1 <= high


# ---------------------------------------------------------------- the estimate

CHECK = script("check_accuracy")


def sampled_triangle(rise: int, decay: int, duration: float) -> sw.Shock:
    times = np.concatenate((np.linspace(0, 1, rise), np.linspace(1, 4, decay)[1:]))
    profile = sw.Tabulated(times=times, forces=np.interp(times, [0, 1, 4], [0, 1, 0]))
    return lasting(profile, duration)


@pytest.mark.parametrize("duration", [0.5, 3.0, 30.0, 60.0, 100.0])
@pytest.mark.parametrize("samples", [(21, 2), (2, 21), (16, 2), (101, 2), (500, 700), (3000, 3000)], ids=str)
def test_the_estimate_does_not_depend_on_the_sampling(samples: tuple[int, int], duration: float) -> None:
    exact = predicted(sw.Triangular(duration_ratio=4), duration).estimate
    found = sw.Predictor().predict(sampled_triangle(*samples, duration), CHAIN).estimate
    assert exact is not None
    assert found is not None
    assert found.peak_force == pytest.approx(exact.peak_force, rel=1e-6)


def test_a_faint_long_tail_hardly_changes_the_estimate() -> None:
    shapes = [([0, 0.9, 3], [0, 1, 0]), ([0, 0.9, 3, 90], [0, 1, 1e-6, 0])]
    profiles = [sw.Tabulated(times=times, forces=forces, clean=False) for times, forces in shapes]
    short, long = (predicted(profile, profile.duration_ratio * 0.9).estimate for profile in profiles)
    assert short is not None
    assert long is not None
    # a tenth of the range: the section around the blow is resolved in a sixteenth of the wave's time
    assert long.peak_force == pytest.approx(short.peak_force, rel=1e-3)


@pytest.mark.parametrize("kind", [*CHECK.KINDS, *CHECK.MISLEADING], ids=lambda kind: kind.__name__)
def test_the_estimate_and_the_error_of_section_4_hold_for_every_kind(
    kind: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    # durations of which a simulation is quick
    monkeypatch.setattr(CHECK, "DURATIONS", (1e-2, 30.0))
    monkeypatch.setattr(CHECK, "LONGEST_TURNING", 8.0)
    monkeypatch.setattr(CHECK, "RTOL", 1e-5)
    shots = CHECK.shots(kind, 20)
    assert len(shots) >= 19
    misses = [shot.miss for shot in shots]
    # 98 % hold, so that two of twenty are unlikely to miss
    assert sum(miss > 1 for miss in misses) <= 1
    assert max(misses) < 3
    assert sum(not shot.held for shot in shots) <= 1


def test_a_half_sine_of_11_ms_leads_with_an_estimate_that_holds() -> None:
    # section 4 gives 3 N, for the rise is slow; the simulated force was 340.2 N at a tolerance of 1e-6
    share = np.linspace(0, 1, 101)
    profile = sw.Tabulated(times=11e-3 * share, forces=148 * np.sin(np.pi * share) * (share < 1))
    outcome = sw.Predictor().predict(sw.Shock(profile=profile), CHAIN)
    assert outcome.estimate is not None
    assert outcome.estimate.low < 340.2 < outcome.estimate.high
    assert str(outcome).startswith("leading wave 340 N, range 310 to 400 N")
    assert outcome.peak_force < 10


@pytest.mark.parametrize(("granules", "known"), [(None, True), (200, True), (60, True), (37, False)])
def test_a_finite_chain_has_an_estimate_where_the_wave_forms(granules: int | None, known: bool) -> None:
    chain = attrs.evolve(CHAIN, granules=granules)
    outcome = sw.Predictor().predict(lasting(sw.Triangular(duration_ratio=4), 30.0), chain)
    assert (outcome.estimate is not None) == known
    assert known or str(outcome).startswith("leading wave not known a priori")


@pytest.mark.parametrize("granules", [None, 100])
def test_a_warning_states_that_first_contacts_of_a_finite_chain_carry_more(granules: int | None) -> None:
    chain = attrs.evolve(CHAIN, granules=granules)
    outcome = sw.Predictor().predict(lasting(sw.Triangular(duration_ratio=4), 0.1), chain)
    assert any("The greatest force" in warning for warning in outcome.warnings) == (granules is not None)


def test_first_contacts_exceed_the_leading_wave_of_a_short_shock_by_19_percent() -> None:
    result = sw.simulate(lasting(sw.Triangular(duration_ratio=4), 0.01), attrs.evolve(CHAIN, granules=100))
    assert result.greatest_force is not None
    assert result.greatest_force.contact == 0
    assert result.greatest_force.peak_force / result.peak_force == pytest.approx(1.186, abs=5e-4)  # three digits


@pytest.mark.parametrize(
    ("shape", "stated"),
    [
        (([0, 1, 4], [0, 1, 0]), "233 N is the limit if it is smooth"),
        (([0, 1, 2, 3, 4], [0, 1, 0, 1, 0]), "has several peaks; simulate its strongest part"),
    ],
    ids=["one-peak", "two-peaks"],
)
def test_the_first_line_states_what_is_known_of_a_shock_too_long_to_simulate(
    shape: tuple[list[float], list[float]], stated: str
) -> None:
    shock = lasting(sw.Tabulated(times=shape[0], forces=shape[1]), 2e4)
    outcome = sw.Predictor().predict(shock, CHAIN)
    assert outcome.no_estimate is not None
    assert outcome.no_estimate.startswith("the shock is longer")
    assert stated in outcome.no_estimate


def test_the_range_allows_for_waves_of_a_step_that_overtake_those_of_a_lower_one() -> None:
    # the amplification of one lasting step is 2.33; simulated to 6e-7
    steps = sw.Tabulated(times=[0, 1, 150, 151, 300, 301], forces=[0, 0.5, 0.5, 1, 1, 0], clean=False)
    estimate = predicted(steps, 301).estimate
    assert estimate is not None
    assert estimate.low < 2.4565 * FORCE < estimate.high


def test_a_needle_does_not_hide_that_weak_humps_are_several_peaks() -> None:
    times, humps = [0, 0.5, 1, 1.5, 2.0, 3.0, 4.0], [0, 0, 0.045, 0, 0, 0.045, 0]
    needle = sw.Tabulated(times=[0, 1e-4, 2e-4, *times[1:]], forces=[0, 1, 0, *humps[1:]], clean=False)
    errors = []
    for profile, force in ((needle, 1.0), (sw.Tabulated(times=times, forces=humps), 0.045)):
        shock = sw.Shock.of_duration(profile=profile, peak_force=force * FORCE, duration=10 * UNITS.time)
        estimate = sw.Predictor().predict(shock, CHAIN).estimate
        assert estimate is not None
        errors.append(estimate.high / estimate.peak_force - 1)
    # interpolated between the same two errors
    assert errors[0] == pytest.approx(errors[1], rel=0.1)


def test_the_impulses_of_a_symmetric_triangle_have_its_moments() -> None:
    profile = sw.Triangular(duration_ratio=2)
    pulse = pulse_of(ScaledShock(profile, profile.areas(), 1.5, MOMENTUM))
    # rounding errors
    assert pulse.impulses.sum() == pytest.approx(1.5 / MOMENTUM, rel=1e-12)
    # a triangle of base 3 has the standard deviation 3/sqrt(24)
    assert pulse.spread == pytest.approx(3 / math.sqrt(24) / MOMENTUM * (1.5 / MOMENTUM) ** 0.2, rel=1e-12)
    assert pulse.impulses @ pulse.times**3 == pytest.approx(0, abs=1e-12)


def test_an_answer_several_times_too_high_is_said_not_to_hold() -> None:
    outcome = sw.predict(lasting(sw.Triangular(duration_ratio=3), 0.3), CHAIN)
    assert all(condition.holds for condition in outcome.conditions)
    assert outcome.expected_error is not None
    assert outcome.expected_error[0] > 1
    assert "does not hold here" in str(outcome)
    assert "times the estimate" in str(outcome)
