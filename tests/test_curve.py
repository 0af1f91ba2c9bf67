"""Universal curves against simulations that were not used in their fit."""

from __future__ import annotations

import json
import math
import re
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from attrs import evolve

import shockwave as sw
from pages import ROOT
from scenes import CHAIN, FORCE, TRUTH, UNITS, name_of, shock_of
from selection import keeping, thinned
from shockwave import cli, pictures
from shockwave.chain import Scales
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.prediction import short_shock_law as short
from shockwave.quadrature import FloatArray
from shockwave.studies import universal_curve_fit
from shockwave.studies.chebyshev_fit import evaluated, fitted
from shockwave.studies.universal_curve import UniversalCurve
from shockwave.studies.varied_scenes import curve_of
from support.pulse_families import Composed

pytestmark = pytest.mark.numerical

TRIANGLE = sw.Triangular(duration_ratio=3)
SHAPES: dict[str, sw.ShockProfile] = {
    "triangle": TRIANGLE,
    "abrupt end": sw.Triangular(duration_ratio=1.0001),
    "infinite slopes": sw.PowerLaw(rise_exponent=0.5, decay_exponent=0.5, duration_ratio=6),
    "rectangle": sw.PowerLaw(rise_exponent=0, decay_exponent=0, duration_ratio=2),
    "steep": sw.PowerLaw(rise_exponent=0.1, decay_exponent=8, duration_ratio=30),
    "exponential": sw.Exponential(rise_rate=5, decay_rate=5, duration_ratio=5),
    "two humps": sw.Tabulated(times=[0, 1, 2, 3, 4], forces=[0, 0.6, 0.1, 1, 0]),
    "humps apart": sw.Tabulated(times=[0, 1, 2, 6, 7, 8], forces=[0, 1, 0, 0, 0.95, 0]),
    "another's blast": Composed("haversine", "blast", 0.5, 10.0),
    "another's trapezoid": Composed("trapezoid", "haversine", 0.3, 3.0),
}


@cache
def curve(name: str, rtol: float = 1e-4) -> UniversalCurve:
    return UniversalCurve(SHAPES[name], rtol=rtol)


def simulated(profile: sw.ShockProfile, ratios: FloatArray, rtol: float) -> FloatArray:
    """Amplifications at these t0/T0."""
    shocks = [sw.Shock(profile=profile, peak_force=FORCE, rise_time=ratio * UNITS.time) for ratio in ratios]
    results = sw.simulate_many(shocks, CHAIN, rtol=rtol, waves="primary")
    return np.array([result.amplification for result in results])  # type: ignore[union-attr]


@cache
def errors(name: str, rtol: float, count: int) -> tuple[FloatArray, FloatArray]:
    """Errors and bounds of a curve at points spread over n t0/T0 from 1e-3 to 50."""
    found = curve(name, rtol)
    # multiples of the golden ratio: evenly spread, and none is a node
    shares = np.arange(1, count + 1) * ((5**0.5 - 1) / 2) % 1.0
    ratios = 1e-3 * 5e4**shares / found.shape.duration_ratio
    known = simulated(SHAPES[name], ratios, rtol / 1e3)
    return np.abs(found.amplification(ratios) / known - 1), found.error(ratios)


@pytest.mark.parametrize("count", [50, pytest.param(200, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", thinned(SHAPES, 3))
def test_the_curve_is_within_tolerance_and_bound_of_other_simulations(name: str, count: int) -> None:
    off, bound = errors(name, 1e-4, count)
    assert off.max() <= 1e-4
    # the bound is three times the error of the last checks and covers 99.9 %; simulations are accurate to 1e-7
    assert np.count_nonzero(off > bound + 1e-7) <= max(1, count // 100)
    assert curve(name).simulations <= 64


@pytest.mark.parametrize("name", keeping(["triangle", "rectangle", "exponential", "another's blast"], "triangle"))
def test_a_curve_to_1e_6_is_within_its_tolerance(name: str) -> None:
    off, _ = errors(name, 1e-6, 60)
    assert off.max() <= 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("case", [case for case in TRUTH if case["kind"] != "tabulated"], ids=name_of)
def test_the_curve_agrees_with_independent_simulations(case: dict[str, Any]) -> None:
    shock = shock_of(case)
    longest = max(50.0, 1.1 * shock.duration / UNITS.time)
    answer = UniversalCurve(shock.profile, longest=longest).answer(shock, CHAIN)
    assert answer.amplification == pytest.approx(case["peaks"][0], rel=1e-4)


def test_a_longer_curve_covers_longer_shocks() -> None:
    profile = SHAPES["steep"]
    ratios = np.array([70.0, 110.0, 149.0]) / 30
    found = UniversalCurve(profile, rtol=1e-3, longest=150)
    assert found.amplification(ratios) == pytest.approx(simulated(profile, ratios, 1e-6), rel=1e-3)


@pytest.mark.parametrize("name", thinned(SHAPES, 3))
def test_the_amplification_of_the_shortest_shocks_follows_from_their_impulse(name: str) -> None:
    found = curve(name)
    ratio = 1e-7
    strength = ratio * SHAPES[name].areas().total / MOMENTUM
    # the constant has eight digits
    assert float(found.amplification(ratio)) == pytest.approx(IMPULSE_LIMIT * strength**1.2, rel=5e-8)


@pytest.mark.parametrize("name", thinned(SHAPES, 3))
def test_the_leading_correction_scales_as_the_cube_of_the_duration(name: str) -> None:
    profile = SHAPES[name]
    ratio = 0.2 / profile.duration_ratio
    (known,) = simulated(profile, np.array([ratio]), 1e-12)
    strength = ratio * profile.areas().total / MOMENTUM
    loss = -math.log(known / (short.IMPULSE_LIMIT * strength**1.2))
    # the next term is less than a thousandth of this one, which is 1e-5 at least; the limit is accurate to 1e-9
    assert loss == pytest.approx(short.CORRECTION * short.correction(profile) * ratio**3, rel=1e-3)


def test_the_leading_correction_of_a_rectangle_has_its_closed_form() -> None:
    # g = s^2/2 over a = n: the integrals are (n^4/4)/(2 n)^(3/2) and (n/2)^(5/2)/(5/2)
    n = mpmath.mpf(2)
    exact = mpmath.sqrt(n) * (n**4 / 4 / (2 * n) ** 1.5 - (n / 2) ** 2.5 / 2.5)
    # by graded Gauss rules, whose only breakpoint is the peak between two equal forces
    assert short.correction(SHAPES["rectangle"]) == pytest.approx(float(exact), rel=1e-12)


@pytest.mark.parametrize("force", [1e-3, 1e5])
@pytest.mark.parametrize("radius", [1e-5, 0.3])
def test_one_curve_covers_every_chain_and_force(force: float, radius: float) -> None:
    chain = sw.Chain(material=sw.Material(youngs_modulus=1.5e9, poisson_ratio=0.46, density=2178.0), radius=radius)
    shock = sw.Shock(profile=TRIANGLE, peak_force=force, rise_time=1.3 * Scales.of(chain, force).time)
    known = sw.simulate(shock, chain, rtol=1e-8, waves="primary").peak_force
    assert curve("triangle").peak_force(shock, chain) == pytest.approx(known, rel=1e-4)


def test_another_shape_is_refused() -> None:
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3.001), peak_force=1.0, rise_time=1e-5)
    with pytest.raises(sw.InvalidValueError, match=r"profile: must have the shape Triangular\(duration_ratio=3.0\)"):
        curve("triangle").answer(shock, CHAIN)


def test_a_shock_is_refused_as_profile() -> None:
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=1.0, rise_time=1e-5)
    with pytest.raises(sw.InvalidValueError, match=r"profile: must be a ShockProfile \(got Shock"):
        sw.UniversalCurve(shock)  # type: ignore[arg-type]


@pytest.mark.parametrize("ratio", [0.0, -1.0, math.nan, math.inf, 17.0, None], ids=repr)
def test_a_rise_time_out_of_range_is_refused(ratio: Any) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"rise_time: must be t0/T0 > 0 and <= 16\.6667 \(got "):
        curve("triangle").amplification([1.0, ratio])


@pytest.mark.parametrize(("name", "value"), [("rtol", 1e-8), ("rtol", math.nan), ("longest", 0.0), ("longest", 1e4)])
def test_wrong_arguments_are_refused(name: str, value: Any) -> None:
    given: dict[str, Any] = {"profile": TRIANGLE, name: value}
    with pytest.raises(sw.InvalidValueError, match=f"{name}: must be"):
        UniversalCurve(**given)


@pytest.mark.parametrize("name", thinned(SHAPES, 3))
@pytest.mark.parametrize("target", [1e-4, 0.05, 0.6, 1.4])
def test_solutions_have_the_requested_amplification(name: str, target: float) -> None:
    (ratio,) = curve(name).solve(target)
    # the root is found to the last digits
    assert float(curve(name).amplification(ratio)) == pytest.approx(target, rel=1e-13)


def test_no_amplification_above_the_greatest_has_a_solution() -> None:
    ratio, most = curve("triangle").highest
    assert curve("triangle").solve(most * (1 - 1e-12))[-1] == pytest.approx(ratio, rel=1e-9)
    assert curve("triangle").solve(most * (1 + 1e-9)) == ()
    with pytest.raises(sw.InvalidValueError, match="amplification: must be > 0"):
        curve("triangle").solve(math.nan)


@pytest.mark.parametrize(
    ("function", "tolerance"),
    [(math.sin, 1e-8), (math.exp, 1e-4), (lambda x: 1 / (1 + 4 * (x - 1) ** 2), 1e-5)],
    ids=["sine", "exponential", "bell"],
)
def test_smooth_functions_are_fitted_to_the_tolerance(function: Any, tolerance: float) -> None:
    pieces = fitted(function, -2.0, 3.0, tolerance)
    x = np.linspace(-2, 3, 2001)
    assert np.abs(evaluated(pieces, x) - [function(one) for one in x]).max() <= tolerance


def test_pieces_are_narrow_near_a_kink() -> None:
    pieces = fitted(lambda x: abs(x - 0.3), -2.0, 3.0, 1e-4)
    x = np.linspace(-2, 3, 20001)
    # between the last checks the error at a kink can be a few times that of the checks
    assert np.abs(evaluated(pieces, x) - np.abs(x - 0.3)).max() <= 3e-4
    assert min(piece.end - piece.begin for piece in pieces) < 0.02


def test_a_jump_shows_in_the_error_of_a_narrow_piece() -> None:
    pieces = fitted(lambda x: float(x > 0.3), -2.0, 3.0, 1e-4)
    wide = [piece for piece in pieces if piece.error > 1e-4]
    assert all(piece.end - piece.begin < 2e-3 for piece in wide)
    assert max(piece.error for piece in wide) > 0.1


def test_the_fit_of_a_rough_function_is_stopped() -> None:
    noise = np.random.default_rng(1)
    with pytest.raises(sw.NumericalError, match="does not converge within 1000 simulations"):
        fitted(lambda _: float(noise.normal()), -2.0, 3.0, 1e-4)


def test_a_shape_without_a_long_curve_has_a_shorter_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def unreliable(shock: sw.Shock, chain: sw.Chain, **options: Any) -> sw.SimulationResult:
        result = sw.simulate(shock, chain, **options)
        return result if shock.duration <= 20 * Scales.of(chain, 1.0).time else evolve(result, error_estimate=1.0)

    monkeypatch.setattr(universal_curve_fit, "simulate", unreliable)
    # a tolerance that no other test uses, since curves are cached
    assert curve_of(TRIANGLE, 1.7e-4, 9.0).longest == 9.0
    match = r"no curve covers this duration: a simulation of 26 characteristic times is too slow or has no error"
    with pytest.raises(sw.NumericalError, match=match):
        curve_of(TRIANGLE, 1.7e-4, 26.0)
    monkeypatch.setattr(universal_curve_fit, "_BUDGET", 20_000)
    with pytest.raises(sw.NumericalError, match=r"is too slow .*\(durations up to [1-9]"):
        UniversalCurve(TRIANGLE)


def test_a_curve_prints_its_range_its_error_and_its_cost() -> None:
    text = str(curve("triangle"))
    assert re.fullmatch(r"universal curve accurate to \de-0[45] \(requested: 1e-04\)", text.splitlines()[0])
    for part in ("Triangular(duration_ratio=3.0)", "n t0/T0 up to 50", "at most 2.10", "simulations"):
        assert part in text


def test_the_picture_draws_the_curve_over_its_range() -> None:
    _, (ax,) = pictures.figure()
    found = curve("triangle")
    pictures.universal_curves(ax, {"universal curve": found}, mark=2.0)
    line = ax.get_lines()[0]
    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    assert np.array_equal(y, found.amplification(x))
    assert (x[-1], ax.get_xscale()) == (found.longest_rise_time, "log")
    assert ax.get_legend_handles_labels()[1] == ["universal curve", "this shock"]


@pytest.mark.parametrize("name", ["triangle", "two humps", "another's blast"])
def test_a_saved_curve_is_read_to_the_last_bit(name: str, tmp_path: Path) -> None:
    curve(name).save(tmp_path / "curve.json")
    again = UniversalCurve.load(tmp_path / "curve.json")
    ratios = np.geomspace(1e-3, 1, 300) * again.longest_rise_time
    assert again == curve(name) != curve("rectangle")
    assert again.made_with["shockwave"] == sw.__version__
    assert np.array_equal(again.amplification(ratios), curve(name).amplification(ratios))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"format": "a poem"}, "format: must be 'shockwave universal curve'"),
        ({"version": 99}, "version: must be 1"),
        ({"area": -1.5}, "document: must be that of a curve .*area: must be > 0"),
        ({"rtol": "small"}, "document: .*expected float @ document.rtol"),
        ({"short": {"end": 1, "error": 0.1}}, "document: .*missing @ document.short.second_correction"),
        ({"pieces": [{"coefficients": [1, "x"]}]}, r"document: .*pieces\[0\].coefficients\[1\]"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_a_file_without_a_curve_is_refused(changed: dict[str, Any], message: str, tmp_path: Path) -> None:
    file = tmp_path / "curve.json"
    file.write_text(json.dumps({**curve("triangle").to_dict(), **changed}))
    with pytest.raises(sw.InvalidValueError, match=rf"curve\.json: {message}"):
        UniversalCurve.load(file)


@pytest.mark.parametrize("text", ["", "[1, 2]", None], ids=["empty", "list", "missing"])
def test_a_file_without_a_document_is_refused(text: str | None, tmp_path: Path) -> None:
    file = tmp_path / "curve.json"
    if text is not None:
        file.write_text(text)
    with pytest.raises(sw.FileAccessError if text is None else sw.InvalidValueError, match=r"curve\.json: "):
        UniversalCurve.load(file)


def test_a_curve_is_written_as_json_or_as_a_picture(tmp_path: Path) -> None:
    file = str(ROOT / "profiles" / "examples" / "protector.yaml")
    for name in ("curve.json", "curve.svg"):
        assert cli.main(["curve", file, "-o", str(tmp_path / name)]) == 0
    profile = sw.load_scenario(file).shock.profile
    assert UniversalCurve.load(tmp_path / "curve.json") == UniversalCurve(profile)
    assert (tmp_path / "curve.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_the_command_prints_the_curve_and_its_scene(capsys: pytest.CaptureFixture[str]) -> None:
    file = str(ROOT / "profiles" / "examples" / "protector.yaml")
    assert cli.main(["curve", file]) == 0
    first, second, *_ = capsys.readouterr().out.splitlines()
    scene = sw.load_scenario(file)
    assert first == str(UniversalCurve(scene.shock.profile).answer(scene.shock, scene.chain))
    assert second == "  ! the chain of 60 granules is treated as endless"
    assert cli.main(["curve", file, "--longest", "1"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("t0/T0 = 1.07993 is beyond the range of this curve (increase --longest)\n")
    assert "polynomials" not in printed


@pytest.mark.parametrize(("command", "endings"), [("curve", ".json, .svg, .png or .pdf"), ("bench", ".html or .htm")])
def test_a_wrong_output_is_refused_first(command: str, endings: str, capsys: pytest.CaptureFixture[str]) -> None:
    # the scenario is missing, which has status 5
    assert cli.main([command, "none.yaml", "-o", "curve.txt"]) == 2
    assert capsys.readouterr().err.startswith(f"--output: must end in {endings}")
