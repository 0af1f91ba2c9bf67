"""The model auto, the short form of the law of moments, and many predictions at once."""

from __future__ import annotations

import importlib
import json
import math
import sys
from functools import cache
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from pages import table
from scenes import CHAIN, FORCE, STEEL, TRUTH, UNITS, name_of, random_pulses, shock_of, triangle
from shockwave import cli
from shockwave.prediction.short_shock_law import short_law
from shockwave.quadrature import FloatArray
from shockwave.studies import automatic_model as auto
from shockwave.studies.universal_curve import cached_curve

DOCS = Path(__file__).parent.parent / "docs"
HUMPS = sw.Tabulated(times=[0, 1, 2, 3, 4, 5], forces=[0, 1, 0.1, 0.7, 0.3, 0])


def predicted(shock: sw.Shock, rtol: float | None = None, **settings: Any) -> sw.Outcome:
    return sw.Predictor(model="auto", rtol=rtol, **settings).predict(shock, CHAIN)


def bound_of(outcome: sw.Outcome) -> float:
    assert outcome.expected_error is not None
    low, high = outcome.expected_error
    assert low == -high
    return high


def simulated(shock: sw.Shock, rtol: float = 1e-9) -> float:
    return sw.simulate(shock, CHAIN, rtol=rtol, waves="primary").amplification


@pytest.mark.parametrize(
    ("shock", "rtol", "method"),
    [(triangle(1.0), 1e-3, "moments"), (triangle(1.0), 1e-6, "simulation"), (triangle(8.0), 1e-1, "simulation")],
    ids=["law", "fine", "train"],
)
def test_the_cheapest_method_that_meets_the_tolerance_is_used(shock: sw.Shock, rtol: float, method: str) -> None:
    outcome = predicted(shock, rtol)
    assert (outcome.model, outcome.method) == ("auto", method)
    assert bound_of(outcome) <= rtol
    assert outcome.amplification == pytest.approx(simulated(shock), rel=bound_of(outcome))
    assert outcome.reason == f"the cheapest method accurate to {rtol:g} (error bound {bound_of(outcome):.1e})"
    assert f"method {method}: {outcome.reason}" in " ".join(str(outcome).split())


def test_exponents_by_the_short_form_agree_with_a_slightly_denser_chain() -> None:
    predictor = sw.Predictor(model="auto", rtol=1e-2)
    chains = [attrs.evolve(CHAIN, material=attrs.evolve(STEEL, density=STEEL.density * f)) for f in (0.999, 1.001)]
    low, high = (predictor.predict(triangle(1.5), chain).peak_force for chain in chains)
    exponents = predictor.predict(triangle(1.5), CHAIN).exponents
    assert exponents is not None
    # the error of a difference over 0.2 % is about 1e-6
    assert math.log(high / low) / math.log(1.001 / 0.999) == pytest.approx(exponents.density, abs=1e-5)


def test_without_compiled_code_the_full_law_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "chosen", lambda _: None)
    outcome = predicted(triangle(8.0), 3e-2)
    assert outcome.method == "moments"
    law = sw.Predictor(model="moments").predict(triangle(8.0), CHAIN)
    assert outcome.peak_force == pytest.approx(law.peak_force, rel=1e-9)
    assert outcome.expected_error == law.expected_error
    assert outcome.exponents is not None
    assert law.exponents is not None
    # the error of a one-sided difference is half its step
    assert outcome.exponents.density == pytest.approx(law.exponents.density, rel=1e-3)
    many = sw.Predictor(model="auto", rtol=3e-2).predict_many([triangle(8.0), triangle(1.0)], CHAIN)
    assert many.method.tolist() == ["moments", "moments"]
    assert many.peak_force[0] == pytest.approx(law.peak_force, rel=1e-12)


def test_the_full_law_is_not_used_for_a_record_that_rises_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "chosen", lambda _: None)
    shock = sw.Shock.of_duration(profile=HUMPS, peak_force=FORCE, duration=8 * UNITS.time)
    assert predicted(shock, 1e-1).method == "simulation"


def inaccurate(monkeypatch: pytest.MonkeyPatch, error: float) -> None:
    """Give simulations this error estimate."""
    known = sw.simulate(triangle(8.0), CHAIN, rtol=1e-2, waves="primary")
    monkeypatch.setattr(auto, "simulate_many", lambda *_, **__: [attrs.evolve(known, error_estimate=error)])


def test_the_best_result_is_returned_if_none_meets_the_tolerance(monkeypatch: pytest.MonkeyPatch) -> None:
    inaccurate(monkeypatch, 1e-6)
    outcome = predicted(triangle(8.0), 1e-7)
    assert (outcome.method, bound_of(outcome)) == ("simulation", 2e-6)
    assert outcome.warnings[0] == "the tolerance was not met: the smallest error bound is 2.0e-06 (requested: 1e-07)"
    many = sw.Predictor(model="auto", rtol=1e-7).predict_many([triangle(8.0)], CHAIN)
    (warning,) = many.warnings
    largest = "the largest error bound is 2.0e-06 (requested: 1e-07)"
    assert warning == f"the tolerance was not met for 1 of 1 shocks: {largest}"
    assert f"! {warning}" in " ".join(str(many).split())


def test_the_law_is_used_if_the_simulation_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    inaccurate(monkeypatch, 1.0)
    outcome = predicted(triangle(8.0), 1e-6)
    law = sw.Predictor(model="moments").predict(triangle(8.0), CHAIN)
    assert (outcome.method, outcome.expected_error) == ("moments", law.expected_error)
    assert outcome.warnings[0].startswith("the tolerance was not met")


@pytest.mark.parametrize(
    ("model", "granules", "sentence"),
    [
        ("auto", 10, "The error is not known: in a chain of 10 granules"),
        ("moments", 10, "The error is not known: in a chain of 10 granules"),
        ("section-4", 10, "The error is not known: in a chain of 10 granules"),
    ],
)
def test_a_short_chain_has_no_bound(model: str, granules: int, sentence: str) -> None:
    chain, predictor = attrs.evolve(CHAIN, granules=granules), sw.Predictor(model=model)
    outcome = predictor.predict(triangle(4.0), chain)
    assert outcome.expected_error is None
    assert any(warning.startswith(sentence) for warning in outcome.warnings)
    assert outcome.reason.endswith("on an endless chain") == (model == "auto")
    many = predictor.predict_many([triangle(4.0)] * 2, [chain, CHAIN])
    assert np.isfinite(many.expected_error).tolist() == [[False, False], [True, True]]
    (warning,) = many.warnings
    assert warning.startswith(f"Shock 0: {sentence}")


@pytest.mark.parametrize("rtol", [1e-9, 0.6])
def test_a_tolerance_out_of_range_is_refused(rtol: Any) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^rtol: must be >= 1e-08 and <= 0.5"):
        sw.Predictor(model="auto", rtol=rtol)


# ---------------------------------------------------------------- against simulation


@cache
def judge() -> Any:
    sys.path.insert(0, str(DOCS))
    try:
        return importlib.import_module("judge_auto")
    finally:
        sys.path.remove(str(DOCS))


@cache
def sample() -> tuple[list[sw.Shock], FloatArray]:
    """Fifty random pulses of every kind, including plugins, and their amplifications."""
    shocks = judge().drawn(77, 50)
    results = sw.simulate_many(shocks, CHAIN, rtol=1e-9, waves="primary")
    return shocks, np.array([result.amplification for result in results if isinstance(result, sw.SimulationResult)])


@pytest.mark.usefixtures("sample_plugins")
@pytest.mark.parametrize("rtol", [1e-1, 1e-2, 1e-3, 1e-6])
def test_random_pulses_are_within_the_tolerance(rtol: float) -> None:
    shocks, known = sample()
    many = sw.Predictor(model="auto", rtol=rtol).predict_many(shocks, CHAIN)
    error = np.abs(many.amplification / known - 1)
    # one in two hundred may exceed it; none of these fifty does
    assert error.max() <= rtol
    # the simulations are accurate to 1e-9
    assert np.all(error <= many.expected_error[:, 1] + 1e-9)
    assert set(many.method.tolist()) >= {"moments", "simulation"}


@pytest.mark.parametrize("case", TRUTH, ids=name_of)
def test_pulses_with_nine_accurate_digits_are_within_the_bound(case: dict[str, Any]) -> None:
    outcome = predicted(shock_of(case), 1e-2)
    assert outcome.amplification == pytest.approx(max(case["peaks"]), rel=bound_of(outcome) + 2e-9)


def test_the_tables_of_the_page_show_met_tolerances() -> None:
    rows = table("docs/auto.md", "auto")
    assert [float(row[0]) for row in rows] == [1e-1, 1e-2, 1e-3, 1e-6]
    assert all(float(share) >= 99.5 for row in rows for share in row[1:3])
    bounds = [*table("docs/auto.md", "short form"), *table("docs/auto.md", "short form by kind")]
    assert all(float(row[-1]) >= 99.5 for row in bounds)


def test_the_page_shows_the_coefficients() -> None:
    text = (DOCS / "auto.md").read_text()
    p0, p1, p2 = short_law().coefficients
    assert f"1 + x\\,({p0:g} + {p1:g}\\,g + {p2:g}\\,g^2)" in text
    assert f"${short_law().error:g}\\,\\sqrt h\\,x^{{3/2}}$" in text


# ---------------------------------------------------------------- many at once

MIXED = [*random_pulses(11, 12, longest=10), triangle(0.5), triangle(6.0)]


@pytest.mark.parametrize("model", ["section-4", "moments", "auto"])
def test_many_are_predicted_like_each_alone(model: str) -> None:
    predictor = sw.Predictor(model=model)
    many, alone = predictor.predict_many(MIXED, CHAIN), [predictor.predict(shock, CHAIN) for shock in MIXED]
    # several pulses are summed in another order, and share the steps of a simulation
    close = {"section-4": 1e-12, "moments": 1e-8, "auto": 1e-7}[model]
    assert many.peak_force == pytest.approx(np.array([outcome.peak_force for outcome in alone]), rel=close)
    assert many.amplification == pytest.approx(np.array([outcome.amplification for outcome in alone]), rel=close)
    assert many.method.tolist() == [outcome.method for outcome in alone]
    bounds = np.array([outcome.expected_error or (-math.inf, math.inf) for outcome in alone])
    # error estimates agree less closely
    assert many.expected_error == pytest.approx(bounds, rel=1e-3 if model == "auto" else 1e-6)
    assert many.failures == ()
    estimates = [[each.estimate.peak_force, each.estimate.low, each.estimate.high] for each in alone if each.estimate]
    assert many.estimate == pytest.approx(np.array(estimates), rel=1e-6)
    assert many.to_dict()["estimate"] == many.estimate.tolist()


def test_a_wrong_number_of_chains_is_refused() -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^chain: must be one, or one for each shock \(got 2\)"):
        sw.Predictor(model="auto").predict_many([triangle(1.0)], [CHAIN, CHAIN])


def test_a_failure_does_not_stop_the_others() -> None:
    shocks = [triangle(1.0), triangle(1e6), triangle(1e14), triangle(0.5)]
    many = sw.Predictor(model="auto").predict_many(shocks, CHAIN)
    assert [(index, reason.split(" ")[0]) for index, reason in many.failures] == [(1, "the"), (2, "rise_time:")]
    assert many.method.tolist() == ["moments", "", "", "moments"]
    assert "4 predictions by auto\n  by moments        2\n" in str(many)
    assert "no answer         2; the first, shock 1: the shock lasts" in str(many)
    read = json.loads(json.dumps(many.to_dict(), allow_nan=False))
    assert read["peak_force"] == [many.peak_force[0], None, None, many.peak_force[3]]
    assert read["expected_error"][1:3] == [None, None]


# ---------------------------------------------------------------- curves


@pytest.fixture(name="series", scope="module")
def _series() -> list[sw.Shock]:
    return [triangle(duration) for duration in np.geomspace(4.0, 12.0, 350)]


def test_a_curve_is_used_for_many_shocks_of_one_shape(series: list[sw.Shock]) -> None:
    predictor = sw.Predictor(model="auto", rtol=1e-3)
    many = predictor.predict_many(series, CHAIN)
    assert set(many.method.tolist()) == {"curve"}
    assert np.all(many.expected_error[:, 1] <= 1e-3)
    known = [simulated(shock, 1e-6) for shock in series[::60]]
    assert many.amplification[::60] == pytest.approx(known, rel=1e-3)


def test_a_cached_curve_makes_no_difference(series: list[sw.Shock]) -> None:
    predictor = sw.Predictor(model="auto", rtol=1e-3)
    shorter = series[:320]
    cached_curve.cache_clear()
    first = predictor.predict_many(shorter, CHAIN)
    assert predictor.predict_many(series, CHAIN).method.tolist() == ["curve"] * 350
    assert predictor.predict_many(shorter, CHAIN) == first
    assert predictor.predict_many([triangle(7.0)], CHAIN).method.tolist() == ["simulation"]


# ---------------------------------------------------------------- from a file

SCENE = """\
chain: {material: {youngs_modulus: 193 GPa, poisson_ratio: 0.3, density: 7958 kg/m^3}, radius: 4.75 mm}
shock: {profile: triangular, peak_force: 100 N, rise_time: %s, duration_ratio: 3}
predict: {model: %s, rtol: 1e-3}
"""


def test_a_scenario_can_request_the_model_and_its_tolerance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE % ("20 us", "auto"))
    assert cli.main(["predict", "--json", str(file)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["model"], document["method"]) == ("auto", "simulation")
    assert 0 < document["expected_error"][1] <= 1e-3
