"""Bad scenarios: each ends in an error that names the place and the remedy, none in a traceback or a hang."""

from __future__ import annotations

from pathlib import Path

import pytest

from shockwave import __version__
from shockwave.base.errors import FileAccessError, ScenarioError
from shockwave.scenario.loader import load_scenario
from support.texts import CHAIN, SHOCK, TABULATED


def _chain(content: str) -> str:
    return f"chain: {{{content}}}\n{SHOCK}"


def _shock(old: str, new: str) -> str:
    return CHAIN + SHOCK.replace(old, new)


def _with(block: str) -> str:
    return CHAIN + SHOCK + block


# text with a mark before the first fault, its path, a part of its problem
MARKED = {
    # keys
    "unknown-block": (_with("|predicts: {}"), "predicts", "did you mean 'predict'?"),
    "unknown-key": (
        _chain("material: copper, radius: 1, |diametr: 2"), "chain.diametr",
        "unknown key (got 'diametr'; did you mean 'diameter'? known: material, diameter, radius, granules, end, "
        "precompression, gravity, damping, packing, contact, elastic_only)",
    ),
    "parameter-of-none": (_shock("}", ", parameters: {|n: 1}}"), "shock.parameters.n", "no keys are allowed here"),
    "missing-size": ("|" + _chain("material: copper"), "chain.diameter", "or give radius"),
    "missing-density": (
        _chain("radius: 1, |material: {youngs_modulus: 1, poisson_ratio: 0}"), "chain.material.density", "<= 1e+30 kg",
    ),
    "both-sizes": (_chain("material: copper, |radius: 1, diameter: 2"), "chain.radius", "if diameter is"),
    # kinds and units
    "predict-is-text": (_with("predict: |section-4"), "predict", "must be a mapping of model"),
    "material-is-a-number": (_chain("material: |5, radius: 1"), "chain.material", "must be a mapping"),
    "name-is-a-number": (_with("name: |12"), "name", "must be text (got 12; put it in quotes if it is text)"),
    "wrong-dimension": (_shock("1 us", "|15 kg"), "shock.rise_time", "must be a time, such as '15 us' (got '15 kg')"),
    "decimal-comma": (_chain("material: copper, diameter: |'9,5 mm'"), "chain.diameter", "a decimal point and no"),
    "decimal-comma-between-keys": (
        _chain("material: copper, diameter: 9,|5 mm"), "chain.'5 mm'", "a decimal point and no comma",
    ),
    "thousands": (_shock("1 N", "|'1.000,5 N'"), "shock.peak_force", "a decimal point and no comma"),
    "newer-version": (
        _with("version: |2"), "version",
        f"must be 1 for shockwave {__version__} (got 2; a newer shockwave may read it)",
    ),
    "version-true": (_with("version: |true"), "version", "must be 1 for"),
    "version-float": (_with("version: |1.0"), "version", "must be 1 for"),
    "version-as-text": (_with("version: |'1'"), "version", "must be 1 for"),
    "no-version": (_with("version:|"), "version", "must be 1 for"),
    "nothing-for-a-number": (_shock(" 1 N", "| "), "shock.peak_force", "(got nothing)"),
    # ranges
    "negative-force": (_shock("1 N", "|-1 kN"), "shock.peak_force", "> 0 N (got '-1 kN')"),
    "incompressible": (
        _chain("radius: 1, material: {youngs_modulus: 1, poisson_ratio: |50 %, density: 1}"),
        "chain.material.poisson_ratio", "must be > -1 and < 0.5 (got '50 %')",
    ),
    "diameter-beyond-mass": (_chain("material: copper, diameter: |1e-200"), "chain.diameter", "a mass that"),
    # names
    "unknown-material": (_chain("material: |coper, radius: 1"), "chain.material", "did you mean 'copper'?"),
    "unknown-profile": (_shock("triangular", "|triangle"), "shock.profile", "did you mean"),
    "unknown-alpha": (_with("predict: {alpha: |liteal}"), "predict.alpha", "must be 'constant' or 'literal'"),
    "unknown-coefficient": (
        _with("predict: {momentum_coefficient: |roughly}"), "predict.momentum_coefficient", "'exact', 'paper'",
    ),
    "rtol-of-a-prediction": (
        _with("predict: {|rtol: 1e-6}"), "predict.rtol",
        "must be left out (got 1e-06; simulate.rtol is the tolerance of all forces)",
    ),
    "model-that-is-gone": (
        _with("predict: {model: |moments}"), "predict.model", "must be 'best' or 'section-4' (got 'moments')",
    ),
    "unknown-quadrature": (_with("predict: {quadrature: |tanh}"), "predict.quadrature", "did you mean 'tanh-sinh'?"),
    "not-installed": (_with("requires: [numpy, |no-such-distribution-1]"), "requires[1]", "must be an installed"),
    "published-without-source": (_with("|published: {error: 1 %}"), "published.source", "must be given"),
    "sweep": (_with("sweep: {grid: {|shock.duration_rati: [2, 4]}}"), "sweep.grid.'shock.duration_rati'", "did you"),
    # records
    "record-of-nothing": (TABULATED.replace("par", "|par") % "", "shock.parameters.times", "or give file"),
    "file-and-times": (TABULATED % "times: [0, 1], |file: x.csv", "shock.parameters.file", "must be left out"),
    "two-samples": (TABULATED % "times: |[0, 1], forces: [0, 1]", "shock.parameters.times", "at least three"),
    "times-backwards": (
        TABULATED % "times: [0, 2, |1], forces: [0, 1, 0]", "shock.parameters.times[2]", "must be greater than",
    ),
    "times-in-newtons": (
        TABULATED % "times: [0, |2 N, 3], forces: [0, 1, x]", "shock.parameters.times[1]", "must be a time",
    ),
    "peak-at-start": (
        TABULATED % "times: [0, 1, 2], forces: |[5, 1, 0]", "shock.parameters.forces", "must rise to a peak",
    ),
    "file-above": (TABULATED % "file: |../../x.csv", "shock.parameters.file", "in the scenario's folder"),
    "file-through-a-link": (TABULATED % "file: |link/x.csv", "shock.parameters.file", "scenario's folder"),
}  # fmt: skip
BAD = {name: marked.replace("|", "") for name, (marked, _, _) in MARKED.items()}


@pytest.mark.parametrize("name", MARKED)
def test_bad_scenario_is_refused_in_its_place(tmp_path: Path, name: str) -> None:
    marked, where, part = MARKED[name]
    before = marked.partition("|")[0]
    (tmp_path / "link").symlink_to("/usr")
    path = tmp_path / "bad.yaml"
    path.write_text(BAD[name], encoding="utf-8", newline="")
    with pytest.raises((ScenarioError, FileAccessError)) as caught:
        load_scenario(path)
    first = str(caught.value).split("\n")[0]
    place = f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"
    assert first.startswith(f"{path}:{place}: {where}: ")
    assert part in first


def test_all_faults_are_reported_together_in_the_order_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(
        "shock:\n"
        "  profile: power-law\n"
        "  peak_force: 15 kg\n"
        "  rise_time: 15 us\n"
        "  duration_ratio: 0.5\n"
        "  parameters: {rise_exponent: -1, decay_exponent: 5, extra: 1}\n"
        "chain:\n"
        "  diametr: 9.5 mm\n"
        "  material: {youngs_modulus: .inf, poisson_ratio: 0.3}\n"
        "predict: {model: section-5, alpha: none, quadrature: none, equal_tolerance: 2}\n"
        "simulate: {integrator: none, rtol: 1}\n"
        "predict: {}\n"
        "sweep: {}\n"
    )
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    found = [f"{fault.location.removeprefix(str(path))} {fault.path}" for fault in caught.value.faults]
    assert found == [
        ":3:15 shock.peak_force",
        ":5:19 shock.duration_ratio",
        ":6:31 shock.parameters.rise_exponent",
        ":6:54 shock.parameters.extra",
        ":7:1 chain.diameter",
        ":8:3 chain.diametr",
        ":9:3 chain.material.density",
        ":9:30 chain.material.youngs_modulus",
        ":10:18 predict.model",
        ":10:36 predict.alpha",
        ":10:54 predict.quadrature",
        ":10:77 predict.equal_tolerance",
        ":11:24 simulate.integrator",
        ":11:36 simulate.rtol",
        ":12:1 predict",
        ":13:8 sweep",
    ]


def test_faults_of_a_record_file_keep_its_lines_and_those_of_the_scenario_theirs(tmp_path: Path) -> None:
    (tmp_path / "pulse.csv").write_text("t [s],f [N]\n0,0\n2,1\n1,0\n")
    path = tmp_path / "bad.yaml"
    path.write_text("chain: {radius: 1, material: no}\nshock: {profile: tabulated, parameters: {file: pulse.csv}}")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert [fault.location for fault in caught.value.faults] == [f"{path}:1:30", f"{tmp_path / 'pulse.csv'}:4"]


def test_messages_use_the_given_name_of_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.yaml").write_text("x: 1\n")
    with pytest.raises(ScenarioError, match=r"^\./bad\.yaml:1:1: "):
        load_scenario("./bad.yaml")


def test_a_long_list_of_errors_is_shortened(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(TABULATED % f"times: [{'x,' * 3000}], forces: [{'1 N,' * 3000}]")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert len(caught.value.faults) == 101
    assert str(caught.value.faults[-1]).endswith("more errors")
