"""The predictor: its settings, how the answer depends on the granules, and the outcome, a value finite everywhere."""

from __future__ import annotations

import json
import math
import pickle
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from scenes import CHAIN, FORCE, STEEL, lasting
from shockwave.chain import Scales
from shockwave.prediction import expected_error, moments, shock_impulses

pytestmark = pytest.mark.numerical

T0 = Scales.of(CHAIN, FORCE).time

# Part of the public interface.
KEYS = {
    *("scenario", "model", "regime", "relation", "peak_force", "amplification", "waves", "applied_momentum"),
    *("ejection", "conditions", "expected_error", "warnings"),
}


def _power(n: float, rise: float, decay: float) -> sw.PowerLaw:
    return sw.PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=n)


def _shock(profile: sw.ShockProfile, rise_time: float) -> sw.Shock:
    """Prediction on the beads of the paper at 100 N; the rise time is in T0."""
    return sw.Shock(profile=profile, peak_force=FORCE, rise_time=rise_time * T0)


#: One shock that meets (3) for each regime.
SHOCKS = {
    "ejection": _shock(_power(3, 0.5, 1), 0.6),
    "single": _shock(_power(3, 1 / 9, 1), 0.91),
    "train": _shock(_power(10, 1, 5), 1.0),
}
EVERY_REGIME = pytest.mark.parametrize("shock", SHOCKS.values(), ids=SHOCKS)
EVERY_NAME = pytest.mark.parametrize("name", SHOCKS)


# ---------------------------------------------------------------- how the answer depends on the granules


def _changed(quantity: str, factor: float) -> sw.Chain:
    if quantity == "radius":
        return attrs.evolve(CHAIN, radius=CHAIN.radius * factor)
    return attrs.evolve(CHAIN, material=attrs.evolve(STEEL, **{quantity: getattr(STEEL, quantity) * factor}))


#: Shocks of which every branch of the answer is taken.
BRANCHES = {
    **SHOCKS,
    "ejection-rectangle": _shock(_power(1.5, 0, 0), 0.5),
    "train-exponential": _shock(sw.Exponential(rise_rate=3, decay_rate=4, duration_ratio=20), 0.5),
    "literal-root": _shock(_power(4, 0.25, 1), 1.0),
    "literal-whole-impulse": _shock(_power(5, 2, 7), 3.0),
}


@pytest.mark.parametrize("quantity", ["radius", "density", "youngs_modulus"])
@pytest.mark.parametrize("branch", BRANCHES)
def test_exponents_are_the_slopes_of_the_prediction(branch: str, quantity: str) -> None:
    shock, step = BRANCHES[branch], 1e-4
    predictor = sw.Predictor(alpha="literal" if branch.startswith("literal") else "constant")
    exponents = predictor.predict(shock, CHAIN).exponents
    less, more = (
        math.log(predictor.predict(shock, _changed(quantity, math.exp(sign * step))).peak_force) for sign in (-1, 1)
    )
    # Central difference: step^2 of a third derivative, and rounding over the step.
    assert getattr(exponents, quantity) == pytest.approx((more - less) / (2 * step), rel=1e-5)


@EVERY_REGIME
def test_equal_scaled_rise_times_give_equal_amplification_on_every_chain(shock: sw.Shock) -> None:
    draw = np.random.default_rng(20240607)
    expected = sw.Predictor().predict(shock, CHAIN).amplification
    for _ in range(10):
        modulus, density, radius = 10 ** draw.uniform([6, 1, -6], [12, 4.5, 1])
        material = sw.Material(youngs_modulus=modulus, poisson_ratio=draw.uniform(-0.9, 0.49), density=density)
        chain = sw.Chain(material=material, radius=radius)
        force = 37.0 * radius**2
        alike = attrs.evolve(shock, peak_force=force, rise_time=shock.rise_time / T0 * Scales.of(chain, force).time)
        # The universality of the paper's title; t0/T0 is rounded a few times.
        assert sw.Predictor().predict(alike, chain).amplification == pytest.approx(expected, rel=1e-12)


# ---------------------------------------------------------------- settings


@pytest.mark.parametrize(("choice", "number"), [("exact", 4.344507853978653), ("paper", 13 / 3), (4.3, 4.3)], ids=str)
def test_the_momentum_coefficient_is_named_or_given(choice: Any, number: float) -> None:
    outcome = sw.Predictor(momentum_coefficient=choice).predict(SHOCKS["single"], CHAIN)
    assert outcome.momentum_coefficient == number
    # (5f) with A by that number; the impulse is 0.9 + 1 rise times.
    tied = (1.9 * 0.91 * T0 * FORCE / CHAIN.momentum_parameter(number)) ** 1.2
    assert outcome.peak_force == pytest.approx(tied, rel=1e-12)
    assert outcome.waves[0].momentum == pytest.approx(outcome.applied_momentum, rel=1e-12)


_COEFFICIENT = "momentum_coefficient: must be 'exact', 'paper' or a number >= 0.01 and <= 1000"


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"alpha": "x"}, "alpha: must be 'constant' or 'literal' (got 'x')"),
        ({"equal_tolerance": -1}, "equal_tolerance: must be >= 0 and < 1 (got -1)"),
        ({"equal_tolerance": math.nan}, "equal_tolerance: must be >= 0 and < 1 (got nan)"),
        ({"wave_threshold": 0}, "wave_threshold: must be > 0 and < 1 (got 0)"),
        ({"momentum_coefficient": "13/3"}, f"{_COEFFICIENT} (got '13/3')"),
        ({"momentum_coefficient": 0}, f"{_COEFFICIENT} (got 0)"),
        ({"rtol": 1e-6}, "rtol: must be left out for model 'section-4'"),
        ({"model": "moments", "alpha": "literal"}, "alpha: must be left out for model 'moments'"),
        ({"model": 4}, "unknown model (got 4; known: section-4, moments, auto"),
        ({"model": "section4"}, "unknown model (got 'section4'; did you mean 'section-4'?"),
        ({"quadrature": "gauss-legendr"}, "unknown quadrature (got 'gauss-legendr'; did you mean 'gauss-legendre'?"),
    ],
    ids=str,
)
def test_a_wrong_setting_is_refused_with_its_rule(setting: dict[str, Any], message: str) -> None:
    with pytest.raises(sw.ShockwaveError) as caught:
        sw.Predictor(**setting)
    assert str(caught.value).startswith(message)


@EVERY_REGIME
@pytest.mark.parametrize("quadrature", ["gauss-legendre", "tanh-sinh", "quadpack"])
def test_a_quadrature_agrees_with_the_closed_forms(quadrature: str, shock: sw.Shock) -> None:
    by_quadrature = sw.Predictor(quadrature=quadrature).predict(shock, CHAIN)
    # Areas are good to 1e-12; the sixth power of a time multiplies that.
    assert by_quadrature.peak_force == pytest.approx(sw.Predictor().predict(shock, CHAIN).peak_force, rel=1e-11)
    assert by_quadrature.areas.rise.method == quadrature


# ---------------------------------------------------------------- the outcome


@EVERY_NAME
def test_json_contains_the_outcome(name: str) -> None:
    outcome = sw.Predictor().predict(SHOCKS[name], CHAIN)
    read = json.loads(json.dumps(outcome.to_dict(), allow_nan=False))
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
    assert f"regime            {name}" in str(outcome)


def test_the_accuracy_is_computed_when_it_is_accessed(monkeypatch: pytest.MonkeyPatch) -> None:
    law, calls = expected_error.peaks, []
    monkeypatch.setattr(expected_error, "peaks", lambda *given: calls.append(given) or law(*given))
    outcome = sw.Predictor().predict(SHOCKS["train"], CHAIN)
    many = sw.Predictor().predict_many([SHOCKS["train"]], CHAIN)
    assert many.peak_force[0] == pytest.approx(outcome.peak_force, rel=1e-12)
    assert not calls
    assert outcome.estimate is not None
    assert outcome.expected_error == pytest.approx(many.expected_error[0], rel=1e-9)
    # once for each, and no more for the warnings
    assert (outcome.warnings, many.warnings) == ((), ())
    assert len(calls) == 2


def test_the_law_is_not_evaluated_again_to_say_why_there_is_no_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    strongest, calls = shock_impulses.strongest_section, []
    monkeypatch.setattr(shock_impulses, "strongest_section", lambda *given: calls.append(given) or strongest(*given))
    outcome = sw.Predictor().predict(lasting(sw.Triangular(duration_ratio=4), 5000.0), CHAIN)
    assert outcome.no_estimate is not None
    assert "longer" in outcome.no_estimate
    assert len(calls) == 1


def test_a_shock_for_which_the_law_does_not_converge_leaves_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    # three steps suffice for the short shock, but not for the long one
    monkeypatch.setattr(moments, "compiled", None)
    monkeypatch.setattr(moments, "_MOST_STEPS", 3)
    shocks = [lasting(sw.Triangular(duration_ratio=4), duration) for duration in (0.1, 9.0)]
    many = sw.Predictor(model="moments").predict_many(shocks, CHAIN)
    assert np.isfinite(many.peak_force).tolist() == [True, False]
    assert [index for index, reason in many.failures if "did not converge" in reason] == [1]
    with pytest.raises(sw.NumericalError, match="did not converge"):
        sw.Predictor(model="moments").predict(shocks[1], CHAIN)
    assert np.isfinite(sw.Predictor().predict_many(shocks, CHAIN).estimate[:, 0]).tolist() == [True, False]


def test_warnings_of_many_predictions_name_their_shocks() -> None:
    record = sw.Tabulated(times=[5, 6, 7, 9], forces=[0, 100, 20, 0])
    shocks = [_shock(sw.Triangular(duration_ratio=2), 1.0), *[sw.Shock(profile=record, rise_time=1e-5)] * 20]
    chains = [sw.Chain(material=CHAIN.material, radius=CHAIN.radius, granules=n) for n in (5, *[10_000] * 20)]
    short, shifted, *others = sw.Predictor().predict_many(shocks, chains).warnings
    assert short.startswith("Shock 0: The error is not known: in a chain of 5 granules")
    assert shifted.startswith("Shocks 1, 2, 3, 4, 5, 6, 7, 8 and 12 more: The times begin at 5 s")
    assert not others


def test_a_shock_and_a_chain_in_the_wrong_order_are_refused() -> None:
    rule = r"^shock: must be a Shock, and the chain a Chain \(got Chain and Shock\)$"
    with pytest.raises(sw.InvalidValueError, match=rule):
        sw.Predictor().predict(CHAIN, SHOCKS["train"])  # type: ignore[arg-type]
    with pytest.raises(sw.InvalidValueError, match=rule):
        sw.Predictor().predict_many([CHAIN], [SHOCKS["train"]])  # type: ignore[list-item]
    with pytest.raises(sw.InvalidValueError, match=rule):
        sw.simulate(CHAIN, SHOCKS["train"])  # type: ignore[arg-type]


def test_an_outcome_can_be_pickled() -> None:
    outcome = sw.Predictor().predict(SHOCKS["train"], CHAIN)
    copy = pickle.loads(pickle.dumps(outcome))
    assert copy == outcome
    assert copy.estimate == outcome.estimate


# ---------------------------------------------------------------- extremes


@pytest.mark.parametrize(
    ("profile", "rise_time"),
    [
        (sw.Triangular(duration_ratio=2), 1e-12),
        (sw.Triangular(duration_ratio=2), 1e3),
        (_power(2, 50, 50), 1e-12),
        (_power(1 + 1e-9, 50, 50), 1.0),
        (sw.Exponential(rise_rate=1e4, decay_rate=1e4, duration_ratio=1 + 1e-9), 1.0),
        (sw.Exponential(rise_rate=-700, decay_rate=-700, duration_ratio=2), 1e-12),
    ],
    ids=lambda value: f"{value:g}" if isinstance(value, float) else str(value).replace("duration_ratio", "n"),
)
@pytest.mark.parametrize("alpha", ["constant", "literal"])
def test_an_extreme_shock_has_a_finite_outcome(profile: sw.ShockProfile, rise_time: float, alpha: Any) -> None:
    # Only the strongest waves are requested: a long train has a thousand.
    predictor = sw.Predictor(alpha=alpha, wave_threshold=0.999)
    outcome = predictor.predict(_shock(profile, rise_time), CHAIN)
    assert all(0 < wave.peak_force < math.inf for wave in outcome.waves)
    json.dumps(outcome.to_dict(), allow_nan=False)


@EVERY_REGIME
def test_a_finely_sampled_record_is_predicted_like_its_formula(shock: sw.Shock) -> None:
    # Samples gather towards the start, where the slope may be unbounded.
    s = np.concatenate((np.linspace(0, 1, 2001) ** 4, np.linspace(1, shock.profile.duration_ratio, 4001)[1:]))
    record = sw.Shock(profile=sw.Tabulated(s * shock.rise_time, shock.profile.force(s) * FORCE))
    sampled, exact = (sw.Predictor().predict(each, CHAIN) for each in (record, shock))
    assert sampled.regime == exact.regime
    # Chords cut what is convex: second order in the spacing.
    assert sampled.peak_force == pytest.approx(exact.peak_force, rel=1e-3)


def test_notes_on_a_record_are_among_the_warnings() -> None:
    shock = sw.Shock(profile=sw.Tabulated([1.0, 2.0, 4.0], [0.0, 5.0, 0.0]))
    assert shock.profile.notes
    assert set(shock.profile.notes) <= set(sw.Predictor().predict(shock, CHAIN).warnings)


def test_shocks_predicted_together_have_the_outcomes_of_single_predictions() -> None:
    shapes = (sw.Triangular(duration_ratio=3), sw.PowerLaw(rise_exponent=1, decay_exponent=5, duration_ratio=10))
    shocks = [sw.Shock(profile=shape, peak_force=FORCE, rise_time=time) for shape in shapes for time in (5e-6, 4e-5)]
    together = sw.Predictor().predict_each(shocks, [CHAIN] * len(shocks))
    for shock, found in zip(shocks, together, strict=True):
        assert isinstance(found, sw.Outcome)
        single = sw.Predictor().predict(shock, CHAIN)
        assert found.waves == single.waves
        # the linear algebra of several shocks may round differently
        assert found.expected_error == pytest.approx(single.expected_error, rel=1e-9)
        assert attrs.astuple(found.estimate)[:3] == pytest.approx(attrs.astuple(single.estimate)[:3], rel=1e-12)


# ---------------------------------------------------------------- columns


def _many() -> list[tuple[sw.Shock, sw.Chain]]:
    """Shocks of every regime and of several kinds, also outside (3), on endless and finite chains."""
    profiles = [_power(n, rise, decay) for n in (1.1, 3, 20) for rise in (0, 0.5, 3, 300) for decay in (0, 1, 8)]
    profiles += [sw.Exponential(rise_rate=3, decay_rate=4, duration_ratio=20), sw.Triangular(duration_ratio=3)]
    profiles.append(sw.Tabulated(times=[0, 1, 2, 3, 4], forces=[0, 1, 0.1, 0.7, 0]))
    # some forces are beyond first yield
    beads = attrs.evolve(CHAIN, material=attrs.evolve(CHAIN.material, yield_strength=2e9))
    chains = [beads, attrs.evolve(beads, granules=60)]
    times = (1e-3, 0.4, 0.9, 3.0, 40.0)
    scenes = [(_shock(profile, time), chain) for profile in profiles for time in times for chain in chains]
    return [*scenes, (_shock(profiles[0], 1e5), beads)]  # longer than those of the estimate


@pytest.mark.parametrize("settings", [{}, {"alpha": "literal"}, {"wave_threshold": 1e-4}])
def test_columns_hold_the_attributes_of_outcomes(settings: dict[str, Any]) -> None:
    scenes = _many()[:: 1 if not settings else 23]
    predictor = sw.Predictor(**settings)
    shocks, chains = zip(*scenes, strict=True)
    columns = predictor.columns(shocks, chains)
    assert columns is not None
    assert columns.failures == {}
    assert columns.places == list(range(len(scenes)))
    rows = [dict(zip(columns.values, row, strict=True)) for row in zip(*columns.values.values(), strict=True)]
    for row, outcome in zip(rows, predictor.predict_each(shocks, chains), strict=True):
        assert isinstance(outcome, sw.Outcome)
        estimate = outcome.estimate
        expected = {
            "regime": outcome.regime,
            "relation": outcome.relation,
            "waves": len(outcome.waves),
            "notes": " ".join(outcome.warnings) or None,
            "virtual_rise_time": getattr(outcome, "virtual_rise_time", None),
            "estimate": estimate and estimate.peak_force,
            "estimate_low": estimate and estimate.low,
            "peak_force": outcome.peak_force,
            "applied_momentum": outcome.applied_momentum,
            "expected_error_high": outcome.expected_error and outcome.expected_error[1],
        }
        found = {name: row[name] for name in expected}
        # iterations that start together may take a step more
        assert found == {
            name: pytest.approx(value, rel=1e-8, abs=1e-10) if isinstance(value, float) else value
            for name, value in expected.items()
        }


def test_columns_do_not_depend_on_the_number_of_shocks() -> None:
    scenes = _many()[::7]
    predictor = sw.Predictor()

    def rows_of(some: list[tuple[sw.Shock, sw.Chain]]) -> list[tuple[Any, ...]]:
        columns = predictor.columns(*zip(*some, strict=True))
        assert columns is not None
        return list(zip(*columns.values.values(), strict=True))

    assert rows_of(scenes) == [row for scene in scenes for row in rows_of([scene])]


def test_models_without_columns_have_none() -> None:
    assert sw.Predictor(model="moments").columns([SHOCKS["train"]], [CHAIN]) is None
