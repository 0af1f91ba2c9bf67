"""The schema: it admits what the loader admits, and rejects unknown keys and wrong values."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from jsonschema import Draft7Validator
from test_loader import CHAIN_LINE, CONTRACT, RECORD

from shockwave.base.errors import ShockwaveError
from shockwave.scenario import block_keys as keys
from shockwave.scenario.scenario import parse_scenario
from shockwave.scenario.scene_hash import scene_hash
from shockwave.scenario.schema import schema
from shockwave.scenario.template import template
from shockwave.scenario.yaml_document import Document, parse_document
from support.pages import ROOT
from support.scenario_texts import CHAIN, EVERY_FEATURE, SHOCK, load, schema_faults


def test_schema_is_one_of_draft_07_and_the_same_in_every_process() -> None:
    Draft7Validator.check_schema(schema())
    program = "import json; from shockwave.scenario.schema import schema; print(json.dumps(schema(), allow_nan=False))"
    environment = {**os.environ, "PYTHONHASHSEED": "1"}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment)
    assert json.loads(done.stdout) == schema()


def test_every_key_is_present_with_its_meaning() -> None:
    top = schema()["properties"]
    assert [*top] == [key.name for key in keys.SCENARIO]
    forms = {name: form for block in top.values() for name, form in {"": block, **block.get("properties", {})}.items()}
    assert [name for name, form in forms.items() if not form.get("description")] == []


@pytest.mark.parametrize("file", sorted((ROOT / "profiles").rglob("*.yaml")), ids=lambda file: file.name)
def test_scenarios_of_profiles_are_admitted(file: Path) -> None:
    assert schema_faults(file.read_text(encoding="utf-8")) == []


RATES = "{points: [{shock.parameters.rise_rate: 1, shock.parameters.decay_rate: 2}]}"
ADMITTED = {
    "swept-chain": SHOCK + "sweep: {zip: {chain.material: [copper], chain.radius: [1 mm]}}",
    "swept-parameters": CHAIN + SHOCK.replace("triangular", "exponential") + f"sweep: {RATES}",
    "empty-blocks": CHAIN + SHOCK + "predict:\nsimulate:\nrequires:\npublished:\n",
    "empty-settings": CHAIN + SHOCK + "predict: {}\nsimulate: {}\nrequires: []\n",
    "number-as-text": CHAIN.replace("1 mm", '"1e-3"') + SHOCK,
    "whole-number-as-text": CHAIN.replace("}", ', granules: "50"}') + SHOCK,
    "rare-unit": CHAIN.replace("1 mm", "1 thou") + SHOCK.replace("1 us", "3 /GHz"),
    "coefficient-as-number": CHAIN + SHOCK + "predict: {momentum_coefficient: 4.2}",
    "minus-sign": CHAIN + "shock: {profile: tabulated, parameters: {times: [\u22121, \u2212.5, 1], forces: [0, 1, 0]}}",
    "record-of-its-own-size": CHAIN + "shock: {profile: tabulated, parameters: {times: [0, 1, 2], forces: [0, 1, 0]}}",
    "fixed-step": CHAIN + SHOCK + "simulate: {integrator: verlet, step: 0.01, rtol: null}",
    "no-name": CHAIN + SHOCK + "predict: {quadrature: null}\nsimulate: {integrator: null}",
}


@pytest.mark.parametrize("name", ADMITTED)
def test_the_schema_accepts_what_the_loader_accepts(tmp_path: Path, name: str) -> None:
    assert load(tmp_path, ADMITTED[name]).shock.peak_force > 0
    assert schema_faults(ADMITTED[name]) == []


REJECTED = {
    "unknown-history": (CHAIN + SHOCK + "simulate: {record: [forces, speeds]}", "$.simulate.record[1]"),
    "half-a-contact": (CHAIN + SHOCK + "simulate: {contacts: [1, 2.5]}", "$.simulate.contacts[1]"),
    "unit-alone": (CHAIN + SHOCK.replace("1 us", "us"), "$.shock.rise_time"),
    "ratio-of-one": (CHAIN + SHOCK.replace(": 2", ": 1"), "$.shock.duration_ratio"),
    "key-of-a-material": (
        "chain: {radius: 1, material: {youngs_modulus: 1, poisson_ratio: 0, density: 1, x: 1}}\n" + SHOCK,
        "$.chain.material",
    ),
    "parameters-of-another-profile": (
        CHAIN + SHOCK.replace("}", ", parameters: {rise_rate: 1, decay_rate: 1}}"), "$.shock.parameters",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REJECTED)
def test_errors_are_rejected_in_their_place(tmp_path: Path, name: str) -> None:
    text, place = REJECTED[name]
    with pytest.raises(ShockwaveError):
        load(tmp_path, text)
    assert place in schema_faults(text)


_VALUES = st.sampled_from([
    None, {}, [], 0, 1, 2, 2.0, 0.5, 1e-3, -1, True, "", " a ", "exact", "paper", "verlet", "radau", "triangular",
    "exponential", "tabulated", "copper", "compiled", "less", "primary", [0, "1 us", 3], ["numpy"], "3", " .5 ",
    "1e-5 s", "-1 us", "+2 µs", "3 minute", "1/Hz", "2 (m/s)*s/m", "4 s**2/s", "5 %", "1 N", "1 x", "3 m/s",
    "same", "rigid", "free", "ptfe", "hertz", "tsuji", [{"count": 2}], {"wall": "same"}, {"from": 1, "to": 2},
    {"repeat": 2, "cell": [{}]}, {"model": "dashpot", "coefficient": 1}, {"exponent": 2, "stiffness": 1},
    {"count": 3, "gap": 0}, {"youngs_modulus": 1e9, "poisson_ratio": 0.3, "density": 1e3},
])  # fmt: skip


@settings(
    derandomize=True, deadline=None, max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    text=st.sampled_from([CONTRACT, CHAIN_LINE + RECORD, template("exponential"), *[EVERY_FEATURE] * 6]),
    changes=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), _VALUES), min_size=1, max_size=2),
    left_out=st.sampled_from(["name", "shock", "rise_time", "duration_ratio", "parameters", "radius", "material"]),
)
def test_what_the_loader_takes_is_admitted(tmp_path: Path, text: str, changes: list[Any], left_out: str) -> None:
    document = parse_document(text, "scenario.yaml")
    paths = [path for path in document.values if path]
    if text == EVERY_FEATURE:  # few changes of many features are valid
        del changes[1:]
    data = document.with_values({paths[int(share * len(paths))]: value for share, value in changes}).data
    for block in (data, data.get("shock"), data.get("chain")):
        if isinstance(block, dict) and text != EVERY_FEATURE:
            block.pop(left_out, None)
    try:
        parse_scenario(Document("scenario.yaml", data), tmp_path / "scenario.yaml")
    except ShockwaveError:
        return
    assert schema_faults(data) == []


#: Names in other cases than usual.
CASES = {
    "wall": "granules: 9, end: {wall: SAME}",
    "rigid": "granules: 9, end: {wall: Rigid}",
    "material": "granules: 9, end: {wall: Copper}",
    "free": "granules: 9, end: Free",
    "packing": "packing: Hexagonal",
    "damping": "granules: 9, damping: {model: Tsuji, restitution: 0.9}",
    "contact": "granules: 9, contact: {model: Power-Law, exponent: 1.5, stiffness: 1e9}",
    "coefficient": "}\npredict: {momentum_coefficient: Paper",
    "model": "}\npredict: {model: SECTION-4, quadrature: Tanh-Sinh",
    "integrator": "}\nsimulate: {integrator: RKN64",
}


@pytest.mark.parametrize("name", CASES)
def test_names_are_read_in_any_case(tmp_path: Path, name: str) -> None:
    text = f"name: a\n{SHOCK}chain: {{material: copper, radius: 1 mm, %s}}\n"
    assert schema_faults(text % CASES[name]) == []
    found, usual = (scene_hash(load(tmp_path, text % case)) for case in (CASES[name], CASES[name].lower()))
    assert found == usual
    assert schema_faults("simulate: {integrator: RKN65}") == ["$.simulate.integrator"]
