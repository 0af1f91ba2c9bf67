"""Scenarios: what a valid file becomes, from built-in and third-party profiles, and the templates."""

import os
import sys
from collections import Counter
from pathlib import Path
from types import FrameType

import pytest

import shockwave as sw
from shockwave.base.errors import FileAccessError, ScenarioError
from shockwave.base.quantity_fields import Declaration
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.tabulated import Tabulated
from shockwave.scenario import block_keys as keys
from shockwave.scenario.published_results import Published
from shockwave.scenario.scenario import Scenario, load_scenario
from shockwave.scenario.value_conversion import convert
from shockwave.scene.chain import Chain
from shockwave.scene.material import Material
from shockwave.scene.material_library import PAPER_STEEL
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions
from support.pages import ROOT
from support.scenario_texts import SHOCK, load, schema_faults

CONTRACT = """\
name: table 1, first row
chain:
  material: {youngs_modulus: 193 GPa, poisson_ratio: 0.3, density: 7958 kg/m**3}   # or a name
  diameter: 9.5 mm
  granules: 200
shock:
  profile: power-law
  peak_force: 100 N
  rise_time: 15 us
  duration_ratio: 10
  parameters: {rise_exponent: 1, decay_exponent: 5}
predict:
  model: section-4
  momentum_coefficient: paper
  alpha: constant
  equal_tolerance: 0.05
simulate:
  integrator: dop853
  rtol: 1e-6
"""
CHAIN_LINE = "chain: {material: paper-steel, radius: 4.75 mm}\n"
RECORD = "shock: {profile: tabulated, parameters: {times: [0, 15 us, 0.15 ms], forces: [0, 0.1 kN, 0]}}\n"


def test_the_scenario_of_the_contract(tmp_path: Path) -> None:
    profile = PowerLaw(rise_exponent=1, decay_exponent=5, duration_ratio=10)
    steel = Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
    assert load(tmp_path, CONTRACT) == Scenario(
        name="table 1, first row",
        path=tmp_path / "scene.yaml",
        shock=Shock(profile=profile, peak_force=100.0, rise_time=15e-6),
        chain=Chain(material=steel, radius=4.75e-3, granules=200),
        predictor=Predictor(model="section-4", momentum_coefficient="paper"),
        simulate=SimulateOptions(integrator="dop853", rtol=1e-6),
    )


def test_optional_blocks_may_be_left_out_or_empty(tmp_path: Path) -> None:
    bare = load(tmp_path, CHAIN_LINE + SHOCK)
    empty = load(tmp_path, CHAIN_LINE + SHOCK + "predict:\nsimulate:\nrequires:\npublished:\n")
    assert bare == empty
    assert (bare.name, bare.predictor, bare.simulate) == ("scene", Predictor(), SimulateOptions())
    assert bare.chain == Chain(material=PAPER_STEEL, radius=4.75e-3)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("momentum_coefficient: 4.2", Predictor(momentum_coefficient=4.2)),
        ('momentum_coefficient: "4.2"', Predictor(momentum_coefficient=4.2)),
        ("momentum_coefficient: exact, alpha: literal", Predictor(alpha="literal")),
        ("equal_tolerance: 3 %, wave_threshold: 1e-3", Predictor(equal_tolerance=0.03, wave_threshold=1e-3)),
        ("quadrature: tanh-sinh", Predictor(quadrature="tanh-sinh")),
        ("quadrature: null, model: Best", Predictor()),
    ],
)
def test_predict_block_gives_the_predictor(tmp_path: Path, text: str, expected: Predictor) -> None:
    assert load(tmp_path, f"{CHAIN_LINE}{SHOCK}predict: {{{text}}}").predictor == expected


def test_published_figures_and_requirements(tmp_path: Path) -> None:
    text = "published: {source: Table 2, relation: less, virtual_rise_time: 28 us, error: 3.0 %}\n"
    scenario = load(tmp_path, f"{CHAIN_LINE}{SHOCK}{text}requires: [numpy, attrs]\n")
    assert scenario.published == Published(source="Table 2", relation="less", virtual_rise_time=28e-6, error=0.03)


def test_a_record_defines_peak_force_rise_time_and_ratio(tmp_path: Path) -> None:
    shock = load(tmp_path, CHAIN_LINE + RECORD).shock
    assert shock.profile == Tabulated(times=[0, 15e-6, 0.15e-3], forces=[0, 100, 0])
    assert (shock.peak_force, shock.rise_time) == (100.0, 15e-6)


def test_a_record_is_scaled_to_what_is_given(tmp_path: Path) -> None:
    given = "{profile: tabulated, peak_force: 50 N, rise_time: 5 us, duration_ratio: 4,"
    shock = load(tmp_path, CHAIN_LINE + RECORD.replace("{profile: tabulated,", given)).shock
    assert (shock.peak_force, shock.rise_time, shock.profile.duration_ratio) == (50.0, 5e-6, 4.0)


def test_a_record_file_is_searched_beside_the_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scenes" / "data").mkdir(parents=True)
    (tmp_path / "scenes" / "data" / "pulse.csv").write_text("time [us],force [N]\n0,0\n15,100\n150,0\n")
    monkeypatch.chdir(tmp_path)
    path = Path("scenes", "scene.yaml")
    path.write_text(CHAIN_LINE + "shock: {profile: tabulated, parameters: {file: data/pulse.csv}}")
    assert load_scenario(path).shock.peak_force == 100.0


def test_a_missing_record_is_located_and_if_it_is_the_only_error_a_file_access_error(tmp_path: Path) -> None:
    record = "shock: {profile: tabulated, parameters: {file: no.csv}}"
    missing = r"\.yaml:2:48: shock\.parameters\.file: .*no\.csv: cannot be read"
    with pytest.raises(FileAccessError, match=missing) as alone:
        load(tmp_path, CHAIN_LINE + record)
    assert [fault.path for fault in alone.value.faults] == ["shock.parameters.file"]
    with pytest.raises(ScenarioError) as caught:
        load(tmp_path, "chain: {material: cheese, radius: 1}\n" + record)
    assert [fault.path for fault in caught.value.faults] == ["chain.material", "shock.parameters.file"]


@pytest.mark.skipif(os.name != "posix", reason="links of POSIX")
def test_a_record_that_is_a_link_to_itself_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "loop.csv").symlink_to("loop.csv")
    (tmp_path / "scene.yaml").write_text(CHAIN_LINE + "shock: {profile: tabulated, parameters: {file: loop.csv}}")
    with pytest.raises(FileAccessError, match=r"loop\.csv: cannot be read \(Too many levels of symbolic links"):
        sw.load_scenario(tmp_path / "scene.yaml")


@pytest.mark.parametrize(
    ("file", "most"), [("paper/table1-row1.yaml", 430), ("examples/hammer.yaml", 440), ("maps/amplification.yaml", 430)]
)
def test_loading_makes_few_calls(file: str, most: int) -> None:
    # a bound on the machinery between a file and its scene that does not depend on the machine, as times do
    path = ROOT / "profiles" / file
    load_scenario(path)
    package, calls = os.path.dirname(sw.__file__), Counter[str]()

    def count(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(package):
            calls[frame.f_code.co_qualname] += 1

    sys.setprofile(count)
    try:
        load_scenario(path)
    finally:
        sys.setprofile(None)
    assert 0 < calls.total() <= most, calls.most_common(10)


@pytest.mark.parametrize(
    "times",
    ["rise_time: 2 us, duration: 5 us", "rise_time: 2 us, duration_ratio: 2.5", "duration: 5 us, duration_ratio: 2.5"],
)
@pytest.mark.parametrize("profile", ["triangular", "tabulated"])
def test_any_two_times_describe_a_shock(tmp_path: Path, profile: str, times: str) -> None:
    parameters = ", parameters: {times: [0, 1, 3], forces: [0, 1, 0]}" if profile == "tabulated" else ""
    text = f"{CHAIN_LINE}shock: {{profile: {profile}, peak_force: 1, {times}{parameters}}}"
    shock = load(tmp_path, text).shock
    assert (shock.rise_time, shock.profile.duration_ratio) == pytest.approx((2e-6, 2.5), rel=1e-15)
    assert schema_faults(text) == []


def test_a_large_whole_number_keeps_all_its_digits() -> None:
    key = keys.Key("seed", spec=Declaration("", "a seed", whole=True))
    assert convert(key, 2**53 + 1) == 2**53 + 1
