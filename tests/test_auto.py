"""The model auto, the short form of the law of moments, and many predictions at once."""

from __future__ import annotations

import importlib
import json
import math
import sys
from collections.abc import Iterator
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
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.prediction.model_interface import Peaks
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT, correction, integrals, short_law
from shockwave.quadrature import FloatArray
from shockwave.studies import auto

DOCS = Path(__file__).parent.parent / "docs"
TRIANGLE = sw.Triangular(duration_ratio=3)
# the force of this one has an infinite slope at its begin, and that one is a record
SHAPES = {
    "triangle": TRIANGLE,
    "power law": sw.PowerLaw(rise_exponent=0.5, decay_exponent=1, duration_ratio=3),
    "step": sw.PowerLaw(rise_exponent=1e-5, decay_exponent=0.05, duration_ratio=12),
    "exponential": sw.Exponential(rise_rate=-4, decay_rate=30, duration_ratio=8),
    "two humps": sw.Tabulated(times=[0, 1, 2, 3, 4, 5], forces=[0, 1, 0.1, 0.7, 0.3, 0]),
}
OF_SHAPES = pytest.mark.parametrize("profile", SHAPES.values(), ids=SHAPES)
#: One wave that takes the whole impulse: section 4 is within 2 % of it.
SINGLE = sw.Shock(
    profile=sw.PowerLaw(rise_exponent=1 / 9, decay_exponent=1, duration_ratio=3),
    peak_force=FORCE,
    rise_time=0.91 * UNITS.time,
)


def twins(duration: float) -> sw.Shock:
    """Two nearly equal humps, whose waves part slowly."""
    profile = sw.Tabulated(times=[0, 1, 2, 3, 4], forces=[0, 1, 0, 0.7, 0])
    return sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=duration * UNITS.time)


@pytest.fixture(autouse=True)
def _no_curves() -> Iterator[None]:
    auto.forget()
    yield
    auto.forget()


def predicted(shock: sw.Shock, rtol: float | None = None, **settings: Any) -> sw.Outcome:
    return sw.Predictor(model="auto", rtol=rtol, **settings).predict(shock, CHAIN)


def bound_of(outcome: sw.Outcome) -> float:
    assert outcome.expected_error is not None
    low, high = outcome.expected_error
    assert low == -high
    return high


def simulated(shock: sw.Shock, rtol: float = 1e-9) -> float:
    return sw.simulate(shock, CHAIN, rtol=rtol, waves="primary").amplification


# ---------------------------------------------------------------- the short form of the law


# few points of Gauss have the area of s^5 to all digits, and q 2 % off
NARROW = {
    f"decay {decay}": sw.PowerLaw(rise_exponent=5, decay_exponent=decay, duration_ratio=ratio)
    for decay, ratio in ((1000, 1.001), (300, 1.0001), (64, 1.01))
}


@pytest.mark.parametrize("profile", (SHAPES | NARROW).values(), ids=SHAPES | NARROW)
def test_the_correction_of_a_shape_is_that_of_finer_points(profile: sw.ShockProfile) -> None:
    ((found, _, _),) = integrals([profile], [profile.areas().total])
    # points may miss 1e-5 of the impulse
    assert found == pytest.approx(correction(profile), rel=3e-5)


@OF_SHAPES
def test_the_shortest_shocks_are_impulses(profile: sw.ShockProfile) -> None:
    shock = sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=1e-4 * UNITS.time)
    strength = profile.areas().total * shock.rise_time / UNITS.time / MOMENTUM
    # the correction goes with the cube of the duration
    assert predicted(shock).amplification == pytest.approx(IMPULSE_LIMIT * strength**1.2, rel=1e-10)


@pytest.mark.parametrize(
    ("times", "forces"),
    [
        ([0, 0.01, 0.3, 0.305, 0.31, 1.02, 1.03], [0, 0.01, 0.01, 1, 0.01, 0.01, 0]),
        ([0, 0.5, 1, 15, 15.7, 17], [0, 1, 0, 0, 0.05, 0]),
        ([0, 1, 2, 9, 10, 11, 30, 31, 32], [0, 1, 0, 0, 0.3, 0, 0, 0.03, 0]),
    ],
    ids=["spike-on-a-pedestal", "weak-hump", "pauses"],
)
@pytest.mark.parametrize("x", [0.01, 0.06, 0.2])
def test_the_bound_holds_for_far_tails(times: list[float], forces: list[float], x: float) -> None:
    profile = sw.Tabulated(times=times, forces=forces)
    ((q, _, _),) = integrals([profile], [profile.areas().total])
    shock = sw.Shock(profile=profile, peak_force=FORCE, rise_time=(x / CORRECTION / q) ** (1 / 3) * UNITS.time)
    outcome = predicted(shock, 0.5)
    assert outcome.method == "moments"
    assert outcome.amplification == pytest.approx(simulated(shock, 1e-6), rel=bound_of(outcome))


def test_exponents_are_those_of_a_chain_slightly_denser() -> None:
    shock = triangle(1.5)
    outcome = predicted(shock, 1e-2)
    assert outcome.exponents is not None
    peaks = [
        sw.Predictor(model="auto", rtol=1e-2)
        .predict(shock, attrs.evolve(CHAIN, material=attrs.evolve(STEEL, density=STEEL.density * factor)))
        .peak_force
        for factor in (0.999, 1.001)
    ]
    slope = math.log(peaks[1] / peaks[0]) / math.log(1.001 / 0.999)
    # a difference over 0.2 % errs by a part in 1e6
    assert slope == pytest.approx(outcome.exponents.density, abs=1e-5)


# ---------------------------------------------------------------- what is taken


@pytest.mark.parametrize(
    ("shock", "rtol", "method"),
    [
        (triangle(1.0), 1e-3, "moments"),
        (triangle(1.0), 1e-6, "simulation"),
        (triangle(8.0), 1e-1, "simulation"),
        (SINGLE, 2e-2, "simulation"),
        (twins(16.0), 5e-2, "moments"),
        (twins(16.0), 5e-3, "simulation"),
    ],
    ids=["law", "fine", "train", "one-wave", "slow", "slow-and-fine"],
)
def test_the_cheapest_that_meets_the_tolerance_is_taken(shock: sw.Shock, rtol: float, method: str) -> None:
    outcome = predicted(shock, rtol)
    assert (outcome.model, outcome.method) == ("auto", method)
    assert bound_of(outcome) <= rtol
    assert outcome.amplification == pytest.approx(simulated(shock), rel=bound_of(outcome))


def test_without_compiled_code_the_whole_law_is_cheaper(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "chosen", lambda _: None)
    outcome = predicted(triangle(8.0), 3e-2)
    assert outcome.method == "moments"
    law = sw.Predictor(model="moments").predict(triangle(8.0), CHAIN)
    assert outcome.peak_force == pytest.approx(law.peak_force, rel=1e-9)
    assert outcome.expected_error == law.expected_error
    assert outcome.exponents is not None
    assert law.exponents is not None
    # a difference on one side errs by half of its step
    assert outcome.exponents.density == pytest.approx(law.exponents.density, rel=1e-3)
    many = sw.Predictor(model="auto", rtol=3e-2).predict_many([triangle(8.0), triangle(1.0)], CHAIN)
    assert many.method.tolist() == ["moments", "moments"]
    assert many.peak_force[0] == pytest.approx(law.peak_force, rel=1e-12)


def test_it_says_why() -> None:
    outcome = predicted(triangle(1.0), 1e-2)
    assert outcome.reason == f"the cheapest whose bound, {bound_of(outcome):.1e}, meets 0.01"
    assert f"method            moments: {outcome.reason}" in str(outcome)
    document = outcome.to_dict()
    assert (document["method"], document["reason"]) == ("moments", outcome.reason)


@pytest.mark.parametrize(
    ("shock", "rtol"),
    [(triangle(1.0), 1e-2), (triangle(5.0), 1e-4), (SINGLE, 2e-2)],
    ids=["law", "simulation", "one-wave"],
)
def test_the_coefficient_of_the_paper_does_not_change_the_peak_force(shock: sw.Shock, rtol: float) -> None:
    paper, exact = (predicted(shock, rtol, momentum_coefficient=choice) for choice in ("paper", "exact"))
    assert (paper.peak_force, paper.method) == (exact.peak_force, exact.method)


def test_without_compiled_code_one_and_many_take_section_4_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "chosen", lambda _: None)
    monkeypatch.setattr("shockwave.prediction.moments.peaks", lambda shocks, _: Peaks.of(len(shocks)))
    alone = predicted(SINGLE, 2e-2)
    many = sw.Predictor(model="auto", rtol=2e-2).predict_many([SINGLE], CHAIN)
    assert alone.method == many.method[0] == "section-4"
    assert alone.peak_force == many.peak_force[0] == sw.Predictor().predict(SINGLE, CHAIN).peak_force


def test_the_full_law_is_not_asked_for_uneven_records(monkeypatch: pytest.MonkeyPatch) -> None:
    profile = sw.Tabulated(times=[0, 0.03, 1, 2, 3, 4], forces=[0, 1, 0, 0.7, 0, 0])
    shock = sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=16 * UNITS.time)
    assert predicted(shock, 1e-1).method == "simulation"
    monkeypatch.setattr(auto, "chosen", lambda _: None)
    assert predicted(shock, 1e-1).method == "simulation"


def doubtful(monkeypatch: pytest.MonkeyPatch, doubts: dict[float, float]) -> list[float]:
    """Simulations whose error estimates are these by what is asked; what was asked comes into the list."""
    known, asked = sw.simulate(triangle(8.0), CHAIN, rtol=1e-2, waves="primary"), []

    def simulate_many(shocks: list[sw.Shock], chain: sw.Chain, rtol: float, waves: str) -> list[sw.SimulationResult]:
        asked.append(rtol)
        doubt = next(value for least, value in doubts.items() if rtol >= least)
        return [attrs.evolve(known, error_estimate=doubt)]

    monkeypatch.setattr(auto, "simulate_many", simulate_many)
    return asked


def test_the_best_answer_is_kept_where_none_meets_the_tolerance(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = doubtful(monkeypatch, {1e-6: 3e-4, 3e-7: 1e-6, 0.0: 1.0})
    outcome = predicted(triangle(8.0), 1e-7)
    assert asked == pytest.approx([5e-8, 5e-7, 5e-7])
    assert (outcome.method, bound_of(outcome)) == ("simulation", 2e-6)
    assert outcome.warnings[0] == "the tolerance was not met: nothing comes nearer to 1e-07 than 2.0e-06"
    many = sw.Predictor(model="auto", rtol=1e-7).predict_many([triangle(8.0)], CHAIN)
    assert many.warnings == ("the tolerance was not met: 1 have bounds above 1e-07, up to 2.0e-06",)
    assert f"note: {many.warnings[0]}" in str(many)


def test_where_simulation_has_no_answer_the_law_has_one(monkeypatch: pytest.MonkeyPatch) -> None:
    doubtful(monkeypatch, {0.0: 1.0})
    outcome = predicted(triangle(8.0), 1e-6)
    law = sw.Predictor(model="moments").predict(triangle(8.0), CHAIN)
    assert (outcome.method, outcome.expected_error) == ("moments", law.expected_error)
    assert outcome.warnings[0].startswith("the tolerance was not met")


@pytest.mark.parametrize(
    ("model", "granules", "sentence"),
    [
        ("auto", 100, "of a chain of 100 granules the error is not known"),
        ("moments", 100, "of a chain of 100 granules the error is not known"),
        ("auto", 10, "a chain of 10 granules is too short"),
        ("section-4", 10, "a chain of 10 granules is too short"),
    ],
)
def test_no_bound_is_told_of_a_finite_chain(model: str, granules: int, sentence: str) -> None:
    chain, predictor = attrs.evolve(CHAIN, granules=granules), sw.Predictor(model=model)
    outcome = predictor.predict(SINGLE, chain)
    assert outcome.expected_error is None
    assert any(warning.startswith(sentence) for warning in outcome.warnings)
    assert outcome.reason.endswith("on an endless chain") == (model == "auto")
    many = predictor.predict_many([SINGLE] * 2, [chain, CHAIN])
    assert np.isfinite(many.expected_error).tolist() == [[False, False], [True, True]]
    (warning,) = many.warnings
    assert warning.startswith(sentence)


@pytest.mark.parametrize("rtol", [1e-9, 0.6, "no"])
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
    """Fifty random pulses of every kind, those of plugins among them, and what they are amplified by."""
    shocks = judge().drawn(77, 50)
    results = sw.simulate_many(shocks, CHAIN, rtol=1e-9, waves="primary")
    return shocks, np.array([result.amplification for result in results if isinstance(result, sw.SimulationResult)])


@pytest.mark.usefixtures("sample_plugins")
@pytest.mark.parametrize("rtol", [1e-1, 1e-2, 1e-3, 1e-6])
def test_random_pulses_are_within_the_tolerance(rtol: float) -> None:
    shocks, known = sample()
    many = sw.Predictor(model="auto", rtol=rtol).predict_many(shocks, CHAIN)
    error = np.abs(many.amplification / known - 1)
    # one in two hundred may be beyond: none of fifty is
    assert error.max() <= rtol
    # the simulations are known to 1e-9 themselves
    assert np.all(error <= many.expected_error[:, 1] + 1e-9)
    assert set(many.method.tolist()) >= {"moments", "simulation"}


@pytest.mark.parametrize("case", TRUTH, ids=name_of)
def test_pulses_known_to_nine_digits_are_within_the_bound(case: dict[str, Any]) -> None:
    outcome = predicted(shock_of(case), 1e-2)
    assert outcome.amplification == pytest.approx(max(case["peaks"]), rel=bound_of(outcome) + 2e-9)


def test_the_page_tells_that_what_was_asked_for_is_met() -> None:
    rows = table("docs/auto.md", "auto")
    assert [float(row[0]) for row in rows] == [1e-1, 1e-2, 1e-3, 1e-6]
    assert all(float(share) >= 99.5 for row in rows for share in row[1:3])
    bounds = [*table("docs/auto.md", "short form"), *table("docs/auto.md", "short form by kind")]
    assert all(float(row[-1]) >= 99.5 for row in bounds)


def test_the_page_tells_the_coefficients() -> None:
    told = (DOCS / "auto.md").read_text()
    p0, p1, p2 = short_law().coefficients
    assert f"1 + x\\,({p0:g} + {p1:g}\\,g + {p2:g}\\,g^2)" in told
    assert f"${short_law().error:g}\\,\\sqrt h\\,x^{{3/2}}$" in told


# ---------------------------------------------------------------- many at once

MIXED = [*random_pulses(11, 12, longest=10), triangle(0.5), triangle(6.0)]


@pytest.mark.parametrize("model", ["section-4", "moments", "auto"])
def test_many_are_predicted_as_each_alone(model: str) -> None:
    predictor = sw.Predictor(model=model)
    many, alone = predictor.predict_many(MIXED, CHAIN), [predictor.predict(shock, CHAIN) for shock in MIXED]
    # pulses side by side are summed in another order, and lanes of a simulation share their steps
    close = {"section-4": 1e-12, "moments": 1e-8, "auto": 1e-7}[model]
    assert many.peak_force == pytest.approx(np.array([outcome.peak_force for outcome in alone]), rel=close)
    assert many.amplification == pytest.approx(np.array([outcome.amplification for outcome in alone]), rel=close)
    assert many.method.tolist() == [outcome.method for outcome in alone]
    told = np.array([outcome.expected_error or (-math.inf, math.inf) for outcome in alone])
    # estimates of errors are no better known
    assert many.expected_error == pytest.approx(told, rel=1e-3 if model == "auto" else 1e-6)
    assert many.failures == ()


def test_a_wrong_number_of_chains_is_refused() -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^chain: must be one, or one for each shock \(got 2\)"):
        sw.Predictor(model="auto").predict_many([triangle(1.0)], [CHAIN, CHAIN])


FAILING = [triangle(1.0), triangle(1e6), triangle(1e14), triangle(0.5)]


def test_one_without_an_answer_does_not_stop_the_others() -> None:
    many = sw.Predictor(model="auto").predict_many(FAILING, CHAIN)
    assert np.isfinite(many.peak_force).tolist() == [True, False, False, True]
    assert [(index, reason.split(" ")[0]) for index, reason in many.failures] == [(1, "the"), (2, "rise_time:")]
    assert many.method.tolist() == ["moments", "", "", "moments"]


def test_many_are_written_as_json_and_printed() -> None:
    many = sw.Predictor(model="auto").predict_many(FAILING, CHAIN)
    assert "4 predictions by auto\n  by moments        2\n" in str(many)
    assert "no answer         2; the first, shock 1: the shock lasts" in str(many)
    read = json.loads(json.dumps(many.to_dict(), allow_nan=False))
    assert read["peak_force"] == [many.peak_force[0], None, None, many.peak_force[3]]
    assert read["expected_error"][1:3] == [None, None]
    assert [failure["index"] for failure in read["failures"]] == [1, 2]


# ---------------------------------------------------------------- curves


@pytest.fixture(name="series", scope="module")
def _series() -> list[sw.Shock]:
    return [triangle(duration) for duration in np.geomspace(4.0, 12.0, 300)]


def test_for_many_of_one_shape_a_curve_is_made(series: list[sw.Shock]) -> None:
    predictor = sw.Predictor(model="auto", rtol=1e-3)
    many = predictor.predict_many(series, CHAIN)
    assert set(many.method.tolist()) == {"curve"}
    assert np.all(many.expected_error[:, 1] <= 1e-3)
    known = [simulated(shock, 1e-6) for shock in series[::60]]
    assert many.amplification[::60] == pytest.approx(known, rel=1e-3)


def test_a_curve_is_kept_and_makes_no_difference(series: list[sw.Shock], monkeypatch: pytest.MonkeyPatch) -> None:
    predictor = sw.Predictor(model="auto", rtol=1e-3)
    shorter = series[:250]
    first, alone = predictor.predict_many(shorter, CHAIN), predictor.predict(triangle(7.0), CHAIN)
    auto.forget()
    assert predictor.predict_many(series, CHAIN).method.tolist() == ["curve"] * 300
    assert predictor.predict_many(shorter, CHAIN) == first
    assert predictor.predict(triangle(7.0), CHAIN) == alone
    assert predictor.predict_many([triangle(7.0)], CHAIN).method.tolist() == ["simulation"]
    monkeypatch.setattr("shockwave.studies.universal_curve.UniversalCurve", None)
    assert predictor.predict_many(shorter, CHAIN) == first


# ---------------------------------------------------------------- from a file

SCENE = """\
chain: {material: {youngs_modulus: 193 GPa, poisson_ratio: 0.3, density: 7958 kg/m^3}, radius: 4.75 mm}
shock: {profile: triangular, peak_force: 100 N, rise_time: %s, duration_ratio: 3}
predict: {model: %s, rtol: 1e-3}
"""


def test_a_scenario_names_it_with_its_tolerance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE % ("20 us", "auto"))
    assert cli.main(["predict", "--json", str(file)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["model"], told["method"]) == ("auto", "simulation")
    assert 0 < told["expected_error"][1] <= 1e-3


@pytest.mark.parametrize(
    ("rise_time", "model", "code", "message"),
    [
        ("20 us", "moments", 3, "3:33: predict.rtol: must be left out for model 'moments'"),
        ("100 s", "auto", 1, "natural times of its wave, 20000 is the most"),
    ],
    ids=["refused", "too-long"],
)
def test_what_cannot_be_had_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rise_time: str, model: str, code: int, message: str
) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE % (rise_time, model))
    assert cli.main(["predict", str(file)]) == code
    assert message in capsys.readouterr().err
