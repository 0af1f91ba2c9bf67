"""Universal curves against simulations that are not among their points."""

from __future__ import annotations

import json
import math
import pickle
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import shockwave as sw
from shockwave import cli
from shockwave.base.numerics import FloatArray
from shockwave.scene.chain import Scales
from shockwave.scene.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.studies import amplification_curve as studied
from shockwave.studies.amplification_curve import UniversalCurve, refine
from support.pages import ROOT
from support.pulse_families import Composed
from support.scenes import CHAIN, FORCE, UNITS
from support.slow_cases import thinned

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
}
PROTECTOR = str(ROOT / "profiles" / "examples" / "protector.yaml")


@cache
def curve(name: str, rtol: float = 1e-4) -> UniversalCurve:
    return UniversalCurve(SHAPES[name], rtol=rtol)


def simulated(profile: sw.ShockProfile, ratios: FloatArray, rtol: float) -> FloatArray:
    """Amplifications at these t0/T0."""
    shocks = [sw.Shock(profile=profile, peak_force=FORCE, rise_time=ratio * UNITS.time) for ratio in ratios]
    results = sw.simulate_many(shocks, CHAIN, rtol=rtol, waves="primary")
    return np.array([result.amplification for result in results])  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("name", "rtol"),
    [*((name, 1e-4) for name in SHAPES), ("triangle", 1e-2), ("abrupt end", 1e-2), ("triangle", 1e-6), ("steep", 1e-6)],
)
def test_the_curve_is_within_its_stated_error_of_other_simulations(name: str, rtol: float) -> None:
    universal = curve(name, rtol)
    ratios = np.exp(np.random.default_rng(3).uniform(math.log(1e-3), math.log(50), 30)) / SHAPES[name].duration_ratio
    difference = np.abs(universal.amplification(ratios) / simulated(SHAPES[name], ratios, rtol / 100) - 1)
    assert (difference <= universal.error(ratios)).all()
    # three times 0.3 rtol at midpoints, and 0.03 rtol of simulations and 0.1 rtol of the impulse limit
    assert universal.error(ratios).max() <= 1.03 * rtol
    assert difference.max() <= rtol


def test_a_longer_curve_covers_longer_shocks() -> None:
    ratios = np.array([70.0, 110.0, 149.0]) / 30
    universal = UniversalCurve(SHAPES["steep"], rtol=1e-3, longest=150)
    assert universal.amplification(ratios) == pytest.approx(simulated(SHAPES["steep"], ratios, 1e-6), rel=1e-3)


@pytest.mark.parametrize("name", thinned(SHAPES, 3))
def test_the_amplification_of_the_shortest_shocks_follows_from_their_impulse(name: str) -> None:
    ratio = 1e-7
    limit = IMPULSE_LIMIT * (ratio * SHAPES[name].areas().total / MOMENTUM) ** 1.2
    # a tenth of the tolerance is left to the deviation at the first point
    difference = abs(float(curve(name).amplification(ratio)) / limit - 1)
    assert difference <= min(float(curve(name).error(ratio)), 1e-5)


@pytest.mark.parametrize("force", [1e-3, 1e5])
@pytest.mark.parametrize("radius", [1e-5, 0.3])
def test_one_curve_covers_every_chain_and_force(force: float, radius: float) -> None:
    chain = sw.Chain(material=sw.Material(youngs_modulus=1.5e9, poisson_ratio=0.46, density=2178.0), radius=radius)
    shock = sw.Shock(profile=TRIANGLE, peak_force=force, rise_time=1.3 * Scales.of(chain, force).time)
    known = sw.simulate(shock, chain, rtol=1e-8, waves="primary").amplification
    assert float(curve("triangle").amplification(1.3)) == pytest.approx(known, rel=float(curve("triangle").error(1.3)))


@pytest.mark.parametrize("ratio", [0.0, -1.0, math.nan, math.inf, 17.0, None], ids=repr)
def test_a_rise_time_out_of_range_is_refused(ratio: Any) -> None:
    for function in (curve("triangle").amplification, curve("triangle").error):
        with pytest.raises(sw.InvalidValueError, match=r"rise_time: must be t0/T0 > 0 and <= 16\.6667 \(got "):
            function([1.0, ratio])


@pytest.mark.parametrize(
    ("name", "value"),
    [("rtol", 1e-8), ("rtol", math.nan), ("longest", 0.0), ("longest", 1e4), ("profile", CHAIN)],
)
def test_wrong_arguments_are_refused(name: str, value: Any) -> None:
    arguments: dict[str, Any] = {"profile": TRIANGLE, name: value}
    with pytest.raises(sw.InvalidValueError, match=f"{name}: must be"):
        UniversalCurve(**arguments)


@pytest.mark.parametrize("place", [0.3, -1.234])
def test_the_grid_is_fine_near_a_kink(place: float) -> None:
    x, y, errors = refine(lambda at: (np.abs(at - place), np.zeros(len(at)), 0), -2.0, 3.0, 1e-4)
    between = np.linspace(-2, 3, 20001)[1:-1]
    differences = np.abs(CubicSpline(x, y)(between) - np.abs(between - place))
    assert (differences <= errors[np.searchsorted(x, between) - 1]).all()
    assert differences.max() <= 1e-4
    # 40 intervals at first; elsewhere the function is a line
    assert len(x) < 250


def test_a_jump_is_stated_as_the_error_of_narrow_intervals() -> None:
    x, _, errors = refine(lambda at: ((at > 0.3) * 1.0, np.zeros(len(at)), 0), -2.0, 3.0, 1e-4)
    wide = errors[:-1] > 1e-4
    assert np.diff(x)[wide].max() < 1e-2
    assert errors.max() > 0.5


def test_noise_within_the_errors_of_simulations_is_not_refined() -> None:
    noise = np.random.default_rng(1)
    x, _, errors = refine(lambda at: (noise.uniform(-1e-3, 1e-3, len(at)), np.full(len(at), 1e-2), 0), -2.0, 3.0, 1e-4)
    assert len(x) == 41
    assert errors.min() >= 1e-2


def test_a_spent_budget_leaves_larger_errors() -> None:
    _, _, errors = refine(lambda at: (np.abs(at), np.zeros(len(at)), 1_000_000), -2.0, 3.0, 1e-4)
    assert errors.max() > 1e-3


def test_a_failed_simulation_names_its_duration(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(shocks: list[sw.Shock], *_: Any, **options: Any) -> list[sw.ShockwaveError]:
        return [sw.NumericalError("too long")] * len(shocks)

    monkeypatch.setattr(studied, "simulate_many", failing)
    with pytest.raises(sw.NumericalError, match=r"^no curve covers n t0/T0 = 0\.04642: too long$"):
        UniversalCurve(TRIANGLE)


def test_section_4_stands_beside_the_simulations() -> None:
    point = curve("exponential").points[30]
    shock = sw.Shock(profile=SHAPES["exponential"], peak_force=FORCE, rise_time=point.rise_time * UNITS.time)
    known = sw.Predictor(model="section-4").predict(shock, CHAIN).amplification
    assert point.section4_amplification == pytest.approx(known, rel=1e-9)


def test_equal_curves_have_equal_documents() -> None:
    again = UniversalCurve(TRIANGLE)
    assert again == curve("triangle") == pickle.loads(pickle.dumps(again))
    assert json.dumps(again.to_dict(), allow_nan=False) == json.dumps(curve("triangle").to_dict())
    frame = again.to_pandas()
    assert list(frame.columns) == ["amplification", "error", "section4_amplification"]
    assert (frame.index.name, frame.attrs["units"]["scaled_rise_time"]) == ("scaled_rise_time", "")


def test_the_text_of_a_curve_is_short() -> None:
    for name in ("triangle", "two humps"):
        lines = str(curve(name)).splitlines()
        assert lines[0].startswith("universal curve accurate to ")
        assert len(lines) <= 14
        assert max(map(len, lines)) <= 80


def test_a_curve_is_written_as_json_or_as_a_picture(tmp_path: Path) -> None:
    for name in ("curve.json", "curve.svg"):
        assert cli.main(["curve", PROTECTOR, "-o", str(tmp_path / name)]) == 0
    profile = sw.load_scenario(PROTECTOR).shock.profile
    assert json.loads((tmp_path / "curve.json").read_text()) == UniversalCurve(profile).to_dict()
    assert (tmp_path / "curve.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_the_command_refuses_another_contact_law(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "linear.yaml"
    law = "contact: {exponent: 2, stiffness: 1e7}"
    file.write_text(
        f"chain: {{material: copper, radius: 1 mm, {law}}}\n"
        "shock: {profile: triangular, peak_force: 1 N, rise_time: 1 us, duration_ratio: 2}\n"
    )
    assert cli.main(["curve", str(file)]) == 3
    assert "chain.contact: must be left out for the universal curve" in capsys.readouterr().err


def test_the_command_prints_the_curve_and_its_scene(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["curve", PROTECTOR]) == 0
    first, second, *_ = capsys.readouterr().out.splitlines()
    scene = sw.load_scenario(PROTECTOR)
    universal, ratio = UniversalCurve(scene.shock.profile), 1.16665
    # the digits that are printed
    amplification, error = re.match(r"amplification ([\d.]+), error (\S+), at t0/T0 = 1.16665$", first).groups()  # type: ignore[union-attr]
    assert float(amplification) == pytest.approx(float(universal.amplification(ratio)), rel=1e-5)
    assert float(error) == pytest.approx(float(universal.error(ratio)), rel=0.5)
    assert second == "  ! the chain of 60 granules is treated as endless"
    assert cli.main(["curve", PROTECTOR, "--longest", "1"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("t0/T0 = 1.16665 is beyond the range of this curve (increase --longest)\n")


@pytest.mark.parametrize(("command", "endings"), [("curve", ".json, .svg, .png or .pdf"), ("bench", ".html or .htm")])
def test_a_wrong_output_is_refused_first(command: str, endings: str, capsys: pytest.CaptureFixture[str]) -> None:
    # the scenario is missing, which has status 5
    assert cli.main([command, "none.yaml", "-o", "curve.txt"]) == 2
    assert capsys.readouterr().err.startswith(f"--output: must end in {endings}")
