"""The predictor: its settings, how the answer depends on the granules, and the outcome, a value finite everywhere."""

from __future__ import annotations

import json
import math
import pickle
import re
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave.prediction import predictor
from shockwave.scene.chain import Scales
from shockwave.simulation import simulate
from support.scenes import CHAIN, FORCE, STEEL, lasting, power_law, random_pulses

PAPER = sw.Predictor(model="section-4")
T0 = Scales.of(CHAIN, FORCE).time

# Part of the public interface.
KEYS = {
    *("scenario", "model", "regime", "relation", "peak_force", "amplification", "waves", "applied_momentum"),
    *("ejection", "conditions", "section4", "section4_reason", "low", "high", "method", "reason", "greatest_force"),
    *("transmitted", "verdict", "yield", "warnings", "notes"),
}


def _shock(profile: sw.ShockProfile, rise_time: float) -> sw.Shock:
    """Prediction on the beads of the paper at 100 N; the rise time is in T0."""
    return sw.Shock(profile=profile, peak_force=FORCE, rise_time=rise_time * T0)


#: One shock that meets (3) for each regime.
SHOCKS = {
    "ejection": _shock(power_law(3, 0.5, 1), 0.6),
    "single": _shock(power_law(3, 1 / 9, 1), 0.91),
    "train": _shock(power_law(10, 1, 5), 1.0),
}
EVERY_REGIME = pytest.mark.parametrize("shock", SHOCKS.values(), ids=SHOCKS)
EVERY_NAME = pytest.mark.parametrize("name", SHOCKS)


# ---------------------------------------------------------------- how the answer depends on the granules


def _changed(chain: sw.Chain, quantity: str, factor: float) -> sw.Chain:
    if quantity == "radius":
        return attrs.evolve(chain, radius=chain.radius * factor)
    return attrs.evolve(chain, material=attrs.evolve(STEEL, **{quantity: getattr(STEEL, quantity) * factor}))


#: Shocks of which every branch of the answer is taken.
BRANCHES = {
    **SHOCKS,
    "ejection-rectangle": _shock(power_law(1.5, 0, 0), 0.5),
    "train-exponential": _shock(sw.Exponential(rise_rate=3, decay_rate=4, duration_ratio=20), 0.5),
    "literal-root": _shock(power_law(4, 0.25, 1), 1.0),
    "literal-whole-impulse": _shock(power_law(5, 2, 7), 3.0),
    "contact-of-another-exponent": _shock(power_law(3, 1, 1), 30.0),
}


@pytest.mark.parametrize("quantity", ["radius", "density", "youngs_modulus"])
@pytest.mark.parametrize("branch", BRANCHES)
def test_exponents_are_the_slopes_of_the_prediction(branch: str, quantity: str) -> None:
    shock, step = BRANCHES[branch], 1e-4
    predictor = sw.Predictor(model="section-4", alpha="literal" if branch.startswith("literal") else "constant")
    contact = sw.PowerContact(exponent=2.5, stiffness=1e10) if branch.startswith("contact") else None
    chain = attrs.evolve(CHAIN, contact=contact)
    exponents = predictor.section4(shock, chain).exponents
    less, more = (
        math.log(predictor.predict(shock, _changed(chain, quantity, math.exp(sign * step))).peak_force)
        for sign in (-1, 1)
    )
    # Central difference: step^2 of a third derivative, and rounding over the step. Young's modulus does not change a
    # contact of a stiffness of its own.
    assert getattr(exponents, quantity) == pytest.approx((more - less) / (2 * step), rel=1e-5)


@EVERY_REGIME
def test_equal_scaled_rise_times_give_equal_amplification_on_every_chain(shock: sw.Shock) -> None:
    draw = np.random.default_rng(20240607)
    expected = PAPER.predict(shock, CHAIN).amplification
    for _ in range(10):
        modulus, density, radius = 10 ** draw.uniform([6, 1, -6], [12, 4.5, 1])
        material = sw.Material(youngs_modulus=modulus, poisson_ratio=draw.uniform(-0.9, 0.49), density=density)
        chain = sw.Chain(material=material, radius=radius)
        force = 37.0 * radius**2
        alike = attrs.evolve(shock, peak_force=force, rise_time=shock.rise_time / T0 * Scales.of(chain, force).time)
        # The universality of the paper's title; t0/T0 is rounded a few times.
        assert PAPER.predict(alike, chain).amplification == pytest.approx(expected, rel=1e-12)


# ---------------------------------------------------------------- settings


@pytest.mark.parametrize(("choice", "number"), [("exact", 4.344507853978653), ("paper", 13 / 3), (4.3, 4.3)], ids=str)
def test_the_momentum_coefficient_is_named_or_given(choice: Any, number: float) -> None:
    outcome = sw.Predictor(model="section-4", momentum_coefficient=choice).predict(SHOCKS["single"], CHAIN)
    assert outcome.section4.momentum_coefficient == number
    # (5f) with A by that number; the impulse is 0.9 + 1 rise times.
    tied = (1.9 * 0.91 * T0 * FORCE / CHAIN.momentum_parameter(number)) ** 1.2
    assert outcome.peak_force == pytest.approx(tied, rel=1e-12)
    assert outcome.waves[0].momentum == pytest.approx(outcome.applied_momentum, rel=1e-12)


_COEFFICIENT = "momentum_coefficient: must be 'exact', 'paper' or a number >= 0.01 and <= 1000"


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"alpha": "x"}, "alpha: must be constant or literal (got 'x')"),
        ({"equal_tolerance": -1}, "equal_tolerance: must be >= 0 and < 1 (got -1)"),
        ({"equal_tolerance": math.nan}, "equal_tolerance: must be >= 0 and < 1 (got nan)"),
        ({"wave_threshold": 0}, "wave_threshold: must be > 0 and < 1 (got 0)"),
        ({"momentum_coefficient": "13/3"}, f"{_COEFFICIENT} (got '13/3')"),
        ({"momentum_coefficient": 0}, f"{_COEFFICIENT} (got 0)"),
        ({"model": "moments"}, "model: must be best or section-4 (got 'moments')"),
        ({"model": 4}, "model: must be best or section-4 (got 4)"),
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
    by_quadrature = sw.Predictor(quadrature=quadrature).section4(shock, CHAIN)
    # Areas are good to 1e-12; the sixth power of a time multiplies that.
    assert by_quadrature.peak_force == pytest.approx(PAPER.predict(shock, CHAIN).peak_force, rel=1e-11)
    assert by_quadrature.areas.rise.method == quadrature


# ---------------------------------------------------------------- the outcome


@EVERY_NAME
def test_json_contains_the_outcome(name: str) -> None:
    outcome = sw.Predictor().predict(SHOCKS[name], CHAIN)
    read = json.loads(json.dumps(outcome.to_dict(), allow_nan=False))
    assert read == outcome.to_dict()
    assert set(read) >= KEYS
    assert (read["version"], read["method"], read["regime"]) == (2, "simulation", name)
    for key in ("model", "relation", "peak_force", "low", "high", "amplification", "applied_momentum", "regime"):
        assert read[key] == getattr(outcome, key)
    assert read["waves"][0]["peak_force"] == read["peak_force"]
    # One division.
    assert read["amplification"] == pytest.approx(read["peak_force"] / FORCE, rel=1e-15)
    paper = read["section4"]
    assert all({"peak_force", "momentum", "energy", "speed", "width"} <= set(wave) for wave in paper["waves"])
    assert paper["error"] == paper["peak_force"] / read["peak_force"] - 1
    assert [set(each) >= {"name", "margin", "holds"} for each in read["conditions"]] == [True] * 3
    assert (read["ejection"] is not None) == (name == "ejection")
    assert f"section 4 regime  {name}" in str(outcome)


@EVERY_NAME
def test_the_first_numbers_are_those_of_the_simulation(name: str) -> None:
    outcome, result = sw.predict(SHOCKS[name], CHAIN, rtol=1e-8), sw.simulate(SHOCKS[name], CHAIN, rtol=1e-8)
    assert (outcome.peak_force, outcome.amplification) == (result.peak_force, result.amplification)
    assert outcome.high / outcome.peak_force - 1 == pytest.approx(result.error_estimate, rel=1e-6)  # a cancellation
    assert outcome.waves == (result.primary,)
    paper = sw.predict(SHOCKS[name], CHAIN, model="section-4")
    assert outcome.section4 == paper.section4
    assert outcome.section4.error == paper.peak_force / result.peak_force - 1


@EVERY_NAME
def test_section_4_alone_states_its_own_numbers(name: str) -> None:
    outcome = PAPER.predict(SHOCKS[name], CHAIN)
    assert (outcome.peak_force, outcome.waves) == (outcome.section4.peak_force, outcome.section4.waves)
    assert (outcome.low, outcome.high, outcome.transmitted, outcome.greatest_force) == (None,) * 4
    assert (outcome.method, outcome.section4.error) == ("section-4", None)
    judged = sw.Limit(force=1e6).verdict(outcome)
    assert (judged.decision, judged.remedy) == ("undecided", "simulate")


def test_the_engine_runs_once_when_a_number_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    run, calls = simulate.run_jobs, []
    monkeypatch.setattr(simulate, "run_jobs", lambda jobs, *rest: calls.append(len(jobs)) or run(jobs, *rest))
    outcomes = sw.Predictor().predict_many(SHOCKS.values(), CHAIN)
    assert "Outcome" in repr(outcomes)
    assert outcomes == sw.Predictor().predict_many(SHOCKS.values(), CHAIN)
    assert [outcome.regime for outcome in outcomes if isinstance(outcome, sw.Outcome)] == [*SHOCKS]
    assert not calls
    for outcome in outcomes:
        assert outcome.peak_force > outcome.low
        assert "leading wave" in str(outcome)
    assert calls == [3]


def test_scenes_in_several_threads_are_simulated_at_the_same_time() -> None:
    together = threading.Barrier(2)
    outcomes = [attrs.evolve(sw.predict(SHOCKS["train"], CHAIN), simulation=lambda: together.wait(30)) for _ in "ab"]
    with ThreadPoolExecutor(2) as pool:
        assert sorted(pool.map(lambda outcome: outcome.simulated, outcomes)) == [0, 1]


@pytest.mark.parametrize("threads", [0, -1, 1.5, "x"])
def test_a_wrong_number_of_threads_is_refused(threads: Any) -> None:
    for run in (sw.simulate_many, sw.Predictor().predict_many):
        with pytest.raises(sw.InvalidValueError, match=r"^threads: must be a whole number >= 1"):
            run([SHOCKS["train"]] * 40, CHAIN, threads=threads)


def test_options_of_another_type_are_refused() -> None:
    options: Any = {"rtol": 1e-4}
    with pytest.raises(sw.InvalidValueError, match=r"^options: must be SimulateOptions"):
        sw.Predictor().predict(SHOCKS["train"], CHAIN, options)


def test_forces_that_take_too_long_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(predictor, "_PATIENCE", 1e-3)
    outcome = sw.predict(SHOCKS["train"], attrs.evolve(CHAIN, granules=2000), until=1.0, limit=60.0)
    assert (outcome.greatest_force, outcome.contacts) == (None, ())
    assert outcome.verdict.decision == "undecided"


def test_section_4_without_a_floating_point_answer_has_a_reason() -> None:
    chain = attrs.evolve(CHAIN, contact=sw.PowerContact(exponent=1.05, stiffness=1e7))
    shock = sw.Shock(profile=power_law(3, 1e4, 1), peak_force=FORCE, rise_time=1e5)
    assert "too small" in (sw.predict(shock, chain).section4_reason or "")
    with pytest.raises(sw.NumericalError, match="too small"):
        sw.predict(shock, chain, model="section-4")


def test_many_predictions_are_those_of_single_ones() -> None:
    scenes = [*random_pulses(11, 60), sw.Impact(velocity=0.3), SHOCKS["train"], SHOCKS["train"]]
    walled = attrs.evolve(CHAIN, granules=8, end=sw.Wall(material="same"))
    chains = [CHAIN] * 60 + [walled, walled, attrs.evolve(CHAIN, granules=30)]
    for outcome, scene, chain in zip(sw.Predictor().predict_many(scenes, chains), scenes, chains, strict=True):
        alone = sw.predict(scene, chain)
        assert (outcome.peak_force, outcome.transmitted) == (alone.peak_force, alone.transmitted)


EVERY_CHAIN = {
    "wall": attrs.evolve(CHAIN, granules=6, end=sw.Wall(material="rigid")),
    "taper": sw.Chain(
        material=STEEL, radius=4e-3, granules=[sw.Segment(count=8, radius=sw.Taper(first=4e-3, last=2e-3))]
    ),
    "damped": attrs.evolve(CHAIN, granules=6, damping=sw.Dashpot(coefficient=5.0)),
    "precompressed": attrs.evolve(CHAIN, granules=6, precompression=3.0),
    "endless-precompressed": attrs.evolve(CHAIN, precompression=3.0),
}


@pytest.mark.parametrize("name", EVERY_CHAIN)
@pytest.mark.parametrize("struck", [False, True], ids=["shock", "striker"])
def test_every_scene_has_the_numbers_of_the_simulation(name: str, struck: bool) -> None:
    chain = EVERY_CHAIN[name]
    excitation: Any = sw.Impact(velocity=0.3) if struck else SHOCKS["single"]
    if struck and chain.granules is None:
        with pytest.raises(sw.InvalidValueError, match="a striker needs a finite chain"):
            sw.predict(excitation, chain)
        return
    outcome, result = sw.predict(excitation, chain), sw.simulate(excitation, chain)
    assert outcome.section4 is None
    assert outcome.section4_reason
    assert (outcome.regime, outcome.conditions, outcome.ejection) == (None, None, None)
    assert (outcome.peak_force, outcome.waves, outcome.greatest_force) == (None, (), result.greatest_force)
    assert outcome.transmitted == result.transmitted
    # the static part is no error of the force
    assert outcome.greatest_force.low <= outcome.greatest_force.peak_force <= outcome.greatest_force.high
    assert outcome.applied_momentum == pytest.approx(result.applied_momentum, rel=1e-12)  # products in another order
    json.dumps(outcome.to_dict(), allow_nan=False)
    with pytest.raises(sw.NotCoveredError):
        sw.predict(excitation, chain, model="section-4")


def test_a_wave_that_does_not_reach_the_wall_has_no_force_there() -> None:
    # a wave passes about one contact in T0
    chain, until = attrs.evolve(CHAIN, granules=30, end=sw.Wall()), 10 * T0
    warning = "The leading wave has not reached the wall by the end of the simulated time (set simulate.until: "
    outcome = sw.predict(SHOCKS["single"], chain, until=until)
    assert str(outcome).startswith("the wave does not reach the wall\n")
    transmitted = outcome.to_dict()["transmitted"]
    assert (transmitted["peak_force"], transmitted["low"], transmitted["high"]) == (0.0, 0.0, None)
    assert outcome.greatest_force.peak_force > 0.5 * FORCE
    assert warning in str(outcome.warnings)
    assert warning in str(sw.simulate(SHOCKS["single"], chain, until=until).warnings)
    arrived = sw.predict(SHOCKS["single"], chain)
    assert str(arrived).startswith("force on the wall ")
    assert arrived.to_dict()["transmitted"]["high"] == arrived.transmitted.high > arrived.transmitted.peak_force > 0
    assert warning not in str(arrived.warnings)


@pytest.mark.parametrize(
    ("duration", "options", "reason"),
    [(2e4, {}, "quasi-static"), (300.0, {"timeout": 1e-3}, "the time limit was reached")],
    ids=["too-long", "time-limit"],
)
def test_what_the_engine_refuses_has_a_reason_and_no_number(duration: float, options: Any, reason: str) -> None:
    outcome = sw.predict(lasting(sw.Triangular(duration_ratio=2), duration), CHAIN, limit=60.0, **options)
    assert (outcome.peak_force, outcome.low, outcome.high, outcome.amplification, outcome.relation) == (None,) * 5
    assert (outcome.transmitted, outcome.greatest_force, outcome.yielding, outcome.waves) == (None, None, None, ())
    assert reason in (outcome.reason or "")
    assert outcome.verdict.decision == "undecided"
    assert outcome.section4.error is None
    json.dumps(outcome.to_dict(), allow_nan=False)
    assert str(outcome).startswith("no answer: ")


@pytest.mark.parametrize(
    ("settings", "path"),
    [
        ({"rtol": 1.0}, "rtol"),
        ({"contacts": [5], "chain": attrs.evolve(CHAIN, granules=4)}, "contacts"),
        ({"integrator": "verlet", "chain": EVERY_CHAIN["damped"]}, "integrator"),
        ({"until": 1e-9, "chain": EVERY_CHAIN["wall"]}, "until"),
        ({"until": 1e-9, "chain": attrs.evolve(CHAIN, granules=20)}, "until"),
        ({"until": 1e-9, "chain": EVERY_CHAIN["endless-precompressed"]}, "until"),
        ({"until": 1e3, "chain": EVERY_CHAIN["endless-precompressed"]}, "until"),
        ({"contacts": [10**9], "chain": EVERY_CHAIN["endless-precompressed"]}, "contacts"),
        ({"record": ["field"], "interval": 1e-15, "until": 1e-3, "chain": EVERY_CHAIN["wall"]}, "interval"),
        ({"record": ["forces"]}, "contacts"),
        ({"foo": 3}, "foo"),
        ({"chain": sw.Chain(material=STEEL, radius=4e-3, granules=1, precompression=1.0)}, "chain.granules"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_invalid_scene_or_option_is_refused_before_anything_runs(
    settings: dict[str, Any], path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulate, "run_jobs", lambda *_: pytest.fail("the engine ran"))
    chain = settings.pop("chain", CHAIN)
    with pytest.raises(sw.InvalidValueError, match=rf"^{path}: "):
        sw.predict(SHOCKS["train"], chain, **settings)


def test_a_fault_of_a_plugin_is_raised_when_a_number_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    fault = sw.PluginError("integrator 'mine': must not raise")
    monkeypatch.setattr(simulate, "run_jobs", lambda jobs, *_: [fault] * len(jobs))
    outcome = sw.predict(SHOCKS["train"], CHAIN)
    with pytest.raises(sw.PluginError, match="mine"):
        _ = outcome.peak_force


def test_an_outcome_can_be_pickled_with_its_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = sw.Predictor().predict_many([SHOCKS["train"], SHOCKS["single"]], CHAIN)
    before = pickle.loads(pickle.dumps(second))
    peak = second.peak_force
    after = pickle.loads(pickle.dumps(second))
    assert before == after == second != first
    assert before.peak_force == peak
    monkeypatch.setattr(simulate, "run_jobs", lambda *_: pytest.fail("the engine ran again"))
    assert after.peak_force == peak
    assert sw.Limit(force=1.0).verdict(second).decision == "above"


def test_notes_on_a_record_are_no_warnings() -> None:
    shock = sw.Shock(profile=sw.Tabulated([0.0, 1.0, 2.0, 4.0], [0.0, 0.0, 5.0, 0.0]))
    outcome = sw.Predictor().predict(shock, attrs.evolve(CHAIN, material=attrs.evolve(STEEL, youngs_modulus=1e4)))
    assert outcome.notes == shock.profile.notes != ()
    assert not set(outcome.warnings) & set(outcome.notes)


def test_a_shock_and_a_chain_in_the_wrong_order_are_refused() -> None:
    rule = r"^shock: must be a Shock, Impact or Motion, and the chain a Chain \(got Chain and Shock; .* second\)$"
    with pytest.raises(sw.InvalidValueError, match=rule):
        sw.Predictor().predict(CHAIN, SHOCKS["train"])  # type: ignore[arg-type]
    (error,) = sw.Predictor().predict_many([CHAIN], [SHOCKS["train"]])  # type: ignore[list-item]
    assert re.search(rule, str(error))
    with pytest.raises(sw.InvalidValueError, match=rule):
        sw.simulate(CHAIN, SHOCKS["train"])  # type: ignore[arg-type]
