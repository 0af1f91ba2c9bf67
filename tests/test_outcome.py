"""An outcome: a frozen value that JSON can hold, finite at every extreme, for records as for formulae."""

from __future__ import annotations

import json
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from scenes import CHAIN, FORCE
from shockwave.chain import Scales

T0 = Scales.of(CHAIN, FORCE).time

# Part of the public face.
KEYS = {
    *("scenario", "model", "regime", "relation", "peak_force", "amplification", "waves", "applied_momentum"),
    *("ejection", "conditions", "expected_error", "warnings"),
}


def _power(n: float, rise: float, decay: float) -> sw.PowerLaw:
    return sw.PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=n)


def _predict(profile: sw.ShockProfile, rise_time: float, **settings: Any) -> sw.Outcome:
    """On the paper's beads at 100 N; the rise time in T0."""
    shock = sw.Shock(profile=profile, peak_force=FORCE, rise_time=rise_time * T0)
    return sw.Predictor(**settings).predict(shock, CHAIN)


#: Name -> profile, rise time over T0.
CASES: dict[str, tuple[sw.ShockProfile, float]] = {
    "ejection": (_power(3, 0.5, 1), 0.6),
    "single": (_power(3, 1 / 9, 1), 0.91),
    "train": (_power(10, 1, 5), 1.0),
}
EVERY_REGIME = pytest.mark.parametrize("name", CASES)


def _read(outcome: sw.Outcome) -> dict[str, Any]:
    """``to_dict`` by way of JSON, which refuses NaN, infinities and numbers of numpy."""
    read: dict[str, Any] = json.loads(json.dumps(outcome.to_dict(), allow_nan=False))
    return read


@EVERY_REGIME
def test_json_holds_the_outcome(name: str) -> None:
    outcome = _predict(*CASES[name])
    read = _read(outcome)
    assert read == outcome.to_dict()
    assert set(read) >= KEYS
    assert read["regime"] == name
    for key in ("model", "relation", "peak_force", "amplification", "applied_momentum"):
        assert read[key] == getattr(outcome, key)
    assert read["waves"][0]["peak_force"] == read["peak_force"]
    # One division.
    assert read["amplification"] == pytest.approx(read["peak_force"] / FORCE, rel=1e-15)
    assert all({"peak_force", "momentum", "energy", "speed", "width"} <= set(wave) for wave in read["waves"])
    assert [set(each) >= {"name", "margin", "holds"} for each in read["conditions"]] == [True] * 3
    assert (read["ejection"] is not None) == (name == "ejection")
    low, high = read["expected_error"]
    assert -1 <= low < high


@EVERY_REGIME
def test_an_outcome_is_a_frozen_value(name: str) -> None:
    profile, rise_time = CASES[name]
    outcome = _predict(profile, rise_time)
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        outcome.peak_force = 1.0  # type: ignore[misc]
    assert outcome == _predict(profile, rise_time)
    assert hash(outcome) == hash(_predict(profile, rise_time))
    assert outcome != _predict(profile, rise_time * (1 + 1e-9))


@EVERY_REGIME
def test_an_outcome_prints_its_regime(name: str) -> None:
    assert f"regime            {name}" in str(_predict(*CASES[name]))


# ---------------------------------------------------------------- extremes


@pytest.mark.parametrize(
    ("profile", "rise_time"),
    [
        (sw.Triangular(duration_ratio=2), 1e-12),
        (sw.Triangular(duration_ratio=2), 1e3),
        (sw.Triangular(duration_ratio=1 + 1e-9), 1.0),
        (sw.Triangular(duration_ratio=1e4), 1e3),
        (_power(2, 50, 50), 1e-12),
        (_power(1 + 1e-9, 50, 50), 1.0),
        (_power(1e4, 50, 1), 1e-2),
        (_power(1e4, 0, 50), 1e3),
        (_power(1e4, 1e-9, 1e-9), 1e-12),
        (sw.Exponential(rise_rate=1e4, decay_rate=1e4, duration_ratio=1 + 1e-9), 1.0),
        pytest.param(sw.Exponential(rise_rate=1e4, decay_rate=1e4, duration_ratio=1e4), 1e3, marks=pytest.mark.slow),
        (sw.Exponential(rise_rate=-700, decay_rate=1e4, duration_ratio=2), 1.0),
        (sw.Exponential(rise_rate=-700, decay_rate=-700, duration_ratio=2), 1e-12),
        pytest.param(sw.Exponential(rise_rate=-700, decay_rate=-700, duration_ratio=2), 1e3, marks=pytest.mark.slow),
    ],
    ids=lambda value: f"{value:g}" if isinstance(value, float) else str(value).replace("duration_ratio", "n"),
)
@pytest.mark.parametrize("alpha", ["constant", "literal"])
def test_an_extreme_shock_has_a_finite_outcome(profile: sw.ShockProfile, rise_time: float, alpha: str) -> None:
    # Only the waves near the primary are asked for: a long train has a thousand.
    read = _read(_predict(profile, rise_time, alpha=alpha, wave_threshold=0.999))
    assert all(wave["peak_force"] > 0 for wave in read["waves"])


@pytest.mark.parametrize("force", [1e-30, 1e30], ids=str)
@pytest.mark.parametrize("radius", [1e-9, 1e3], ids=str)
@EVERY_REGIME
def test_extreme_sizes_and_forces_have_finite_outcomes(name: str, radius: float, force: float) -> None:
    profile, rise_time = CASES[name]
    chain = attrs.evolve(CHAIN, radius=radius)
    shock = sw.Shock(profile=profile, peak_force=force, rise_time=rise_time * Scales.of(chain, force).time)
    assert _read(sw.Predictor().predict(shock, chain))["regime"] == name


# ---------------------------------------------------------------- records


@EVERY_REGIME
def test_a_finely_sampled_record_is_predicted_like_its_formula(name: str) -> None:
    profile, rise_time = CASES[name]
    # Samples gather towards the start, where the slope may be unbounded.
    s = np.concatenate((np.linspace(0, 1, 2001) ** 4, np.linspace(1, profile.duration_ratio, 4001)[1:]))
    record = sw.Shock(profile=sw.Tabulated(s * rise_time * T0, profile.force(s) * FORCE))
    sampled, exact = sw.Predictor().predict(record, CHAIN), _predict(profile, rise_time)
    assert sampled.regime == exact.regime
    # Chords cut what is convex: second order in the spacing.
    assert sampled.peak_force == pytest.approx(exact.peak_force, rel=1e-3)


def test_notes_on_a_record_are_among_the_warnings() -> None:
    shock = sw.Shock(profile=sw.Tabulated([1.0, 2.0, 4.0], [0.0, 5.0, 0.0]))
    assert shock.profile.notes
    assert set(shock.profile.notes) <= set(sw.Predictor().predict(shock, CHAIN).warnings)
