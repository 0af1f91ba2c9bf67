"""Bad scenarios: each ends in an error that names the place and the remedy, none in a traceback or a hang."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shockwave.errors import FileAccessError, ScenarioError, ShockwaveError
from shockwave.scenario.loader import load_scenario

CHAIN = "chain: {material: copper, radius: 1 mm}\n"
SHOCK = "shock: {profile: triangular, peak_force: 1 N, rise_time: 1 us, duration_ratio: 2}\n"
TABULATED = CHAIN + "shock: {profile: tabulated, parameters: {%s}}\n"
GOOD = """\
name: a good one  # with a comment
chain:
  material: {youngs_modulus: 193 GPa, poisson_ratio: 0.3, density: 7958 kg/m**3}
  diameter: 9.5 mm
  granules: 200
shock:
  profile: power-law
  peak_force: 100 N
  rise_time: 1.5e-5
  duration_ratio: 10
  parameters:
    rise_exponent: 1
    decay_exponent: 5
predict: {model: section-4, momentum_coefficient: paper, alpha: constant}
simulate:
  rtol: "1e-6"
requires: [numpy]
published:
  source: 'Table 1'
  error: 3 %
"""
RECORD = """\
chain: {material: copper, radius: 1 mm}
shock:
  profile: tabulated
  peak_force: 3 N
  parameters:
    times: [0, 5 us, 1e-5, 20 us]
    forces:
      - 0
      - 0.1 kN
      - 50
      - 0
"""


def _with(block: str) -> str:
    return CHAIN + SHOCK + block


# text, line and column of the first fault, its path, a part of its problem
BAD = {
    # keys
    "unknown-block": (_with("predicts: {}"), "3:1", "predicts", "did you mean 'predict'?"),
    "unknown-key-of-chain": (
        "chain: {material: copper, radius: 1, diametr: 2}\n" + SHOCK, "1:38", "chain.diametr",
        "unknown key (got 'diametr'; did you mean 'diameter'? known: material, diameter, radius, granules)",
    ),
    "parameter-of-none": (CHAIN + SHOCK.replace("}", ", parameters: {n: 1}}"), "2:96", "shock.parameters.n", "none"),
    "missing-size": ("chain: {material: copper}\n" + SHOCK, "1:1", "chain.diameter", "or give radius"),
    "missing-density": (
        "chain: {radius: 1, material: {youngs_modulus: 1 GPa, poisson_ratio: 0}}\n" + SHOCK,
        "1:20", "chain.material.density", "density rho, > 0 kg/m**3",
    ),
    "both-sizes": (
        "chain: {material: copper, radius: 1, diameter: 2}\n" + SHOCK, "1:27", "chain.radius", "where diameter is",
    ),
    # kinds and units
    "predict-is-text": (_with("predict: section-4"), "3:10", "predict", "must be a mapping of model"),
    "material-is-a-number": ("chain: {material: 5, radius: 1}\n" + SHOCK, "1:19", "chain.material", "be a mapping"),
    "name-is-a-number": (_with("name: 12"), "3:7", "name", "must be text (got 12; put it in quotes if it is text)"),
    "wrong-dimension": (
        CHAIN + SHOCK.replace("1 us", "15 kg"), "2:58", "shock.rise_time",
        "must be a time, such as '15 us' (got '15 kg')",
    ),
    "nothing-for-a-number": (CHAIN + SHOCK.replace("1 N", ""), "2:41", "shock.peak_force", "(got nothing)"),
    # ranges
    "negative-force": (CHAIN + SHOCK.replace("1 N", "-1 kN"), "2:42", "shock.peak_force", "> 0 N (got '-1 kN')"),
    "incompressible": (
        "chain: {radius: 1, material: {youngs_modulus: 1, poisson_ratio: 50 %, density: 1}}\n" + SHOCK,
        "1:65", "chain.material.poisson_ratio", "must be > -1 and < 0.5 (got '50 %')",
    ),
    "diameter-beyond-mass": (
        "chain: {material: copper, diameter: 1e-200}\n" + SHOCK, "1:37", "chain.diameter", "a mass that",
    ),
    # names
    "unknown-material": (
        "chain: {material: coper, radius: 1}\n" + SHOCK, "1:19", "chain.material", "did you mean 'copper'?",
    ),
    "unknown-profile": (CHAIN + SHOCK.replace("triangular", "triangle"), "2:18", "shock.profile", "did you mean"),
    "unknown-alpha": (_with("predict: {alpha: liteal}"), "3:18", "predict.alpha", "must be 'constant' or 'literal'"),
    "unknown-coefficient": (
        _with("predict: {momentum_coefficient: roughly}"), "3:33", "predict.momentum_coefficient", "'exact', 'paper'",
    ),
    "rtol-without-use": (_with("predict: {rtol: 1e-6}"), "3:17", "predict.rtol", "must be left out for model"),
    "not-installed": (
        _with("requires: [numpy, no-such-distribution-1]"), "3:19", "requires[1]", "must be installed",
    ),
    "published-without-source": (_with("published: {error: 1 %}"), "3:1", "published.source", "must be given"),
    "sweep": (_with("sweep: {grid: {shock.duration_rati: [2, 4]}}"), "3:16", "sweep.grid.'shock.duration_rati'", "did"),
    # records
    "record-of-nothing": (TABULATED % "", "2:29", "shock.parameters.times", "or give file"),
    "file-and-times": (TABULATED % "times: [0, 1], file: x.csv", "2:57", "shock.parameters.file", "must be left out"),
    "two-samples": (TABULATED % "times: [0, 1], forces: [0, 1]", "2:49", "shock.parameters.times", "at least three"),
    "times-backwards": (
        TABULATED % "times: [0, 2, 1], forces: [0, 1, 0]", "2:56", "shock.parameters.times[2]", "must be greater than",
    ),
    "times-in-newtons": (
        TABULATED % "times: [0, 2 N, 3], forces: [0, 1, x]", "2:53", "shock.parameters.times[1]", "must be a time",
    ),
    "peak-at-start": (
        TABULATED % "times: [0, 1, 2], forces: [5, 1, 0]", "2:69", "shock.parameters.forces[0]", "there is no rise",
    ),
    "file-above": (TABULATED % "file: ../../x.csv", "2:48", "shock.parameters.file", "in the scenario's folder"),
    "file-through-a-link": (TABULATED % "file: link/x.csv", "2:48", "shock.parameters.file", "scenario's folder"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_scenario_is_refused_in_its_place(tmp_path: Path, name: str) -> None:
    text, place, where, part = BAD[name]
    (tmp_path / "link").symlink_to("/usr")
    path = tmp_path / "bad.yaml"
    path.write_text(text, encoding="utf-8", newline="")
    with pytest.raises((ScenarioError, FileAccessError)) as caught:
        load_scenario(path)
    first = str(caught.value).split("\n")[0]
    assert first.startswith(f"{path}:{place}: {where}{': ' if where else ''}")
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


def test_messages_call_the_file_by_the_name_that_was_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.yaml").write_text("x: 1\n")
    with pytest.raises(ScenarioError, match=r"^\./bad\.yaml:1:1: "):
        load_scenario("./bad.yaml")


def test_a_flood_of_faults_ends_in_a_short_list(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(TABULATED % f"times: [{'x,' * 3000}], forces: [{'1 N,' * 3000}]")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert len(caught.value.faults) == 101
    assert str(caught.value.faults[-1]).endswith("more faults")


# ---------------------------------------------------------------- whatever comes

_PIECES = st.sampled_from([
    "", " ", "\n", "  ", "\t", ":", ": ", "- ", "[", "]", "{", "}", "'", '"', "#", "&a ", "*a", "!", "|", "null",
    "true", "-1", "0", "1e400", "1e-400", "1e300", "9" * 400, ".nan", "15 kg", "9**9**9 s", "x", "<<: ", "\x00", "µ",
    "0x10", "radius: 1", "tabulated", "triangular", "file: x.csv", "sweep: 1", "1 N", "%", "---\n", "...\n", "? ",
])  # fmt: skip


@settings(
    derandomize=True, deadline=None, max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    text=st.sampled_from([GOOD, RECORD]),
    cuts=st.lists(st.tuples(st.floats(0, 1), st.integers(0, 30), _PIECES, st.booleans()), min_size=1, max_size=4),
)
def test_mutated_scenarios(tmp_path: Path, text: str, cuts: list[tuple[float, int, str, bool]]) -> None:
    (tmp_path / "good.yaml").write_text(text)
    assert load_scenario(tmp_path / "good.yaml").shock.peak_force in (100.0, 3.0)
    for start, length, piece, twice in cuts:
        first = int(start * len(text))
        span = text[first : first + length]
        text = text[:first] + (span + piece + span if twice else piece) + text[first + length :]
    path = tmp_path / "any.yaml"
    path.write_text(text, encoding="utf-8", newline="")
    try:
        scenario = load_scenario(path)
    except ShockwaveError as error:
        message = str(error)
    else:
        message = scenario.name
        assert None not in (scenario.shock, scenario.chain, scenario.predictor, scenario.simulate)
    assert message.encode("utf-8")
