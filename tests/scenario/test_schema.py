"""The schema: it admits what the loader admits, and rejects unknown keys and wrong values."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from jsonschema import Draft7Validator
from test_bad_scenarios import BAD
from test_scenario import CHAIN_LINE, CONTRACT, RECORD

import shockwave as sw
from shockwave.base.errors import ShockwaveError
from shockwave.registry import built_ins
from shockwave.scenario import block_keys as keys
from shockwave.scenario.loader import load_scenario, scenario_of
from shockwave.scenario.schema import schema
from shockwave.scenario.template import template
from shockwave.scenario.yaml_document import Document, parse_document
from support.pages import PAGES, ROOT, Block, blocks_of, prepare, workplace
from support.texts import CHAIN, SHOCK

#: Faults that a schema sees.
SEEN = (
    *("unknown-block", "unknown-key", "parameter-of-none", "predict-is-text", "material-is-a-number"),
    *("name-is-a-number", "nothing-for-a-number", "unknown-material", "unknown-profile", "unknown-alpha"),
    *("times-in-newtons", "newer-version", "version-as-text"),
    *("rtol-of-a-prediction", "model-that-is-gone", "unknown-quadrature"),
)


@cache
def _validator() -> Draft7Validator:
    return Draft7Validator(schema())


def _faults(text: str) -> list[str]:
    """Where the schema finds a scenario wrong, read as the loader reads it."""
    return [str(fault.json_path) for fault in _validator().iter_errors(parse_document(text, "scenario.yaml").data)]


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
    assert _faults(file.read_text(encoding="utf-8")) == []


SCENARIOS = [
    block
    for page in PAGES
    for block in blocks_of(page)
    if block.language == "yaml" and "faulty" not in block.directives
]


@pytest.mark.parametrize("block", SCENARIOS, ids=str)
def test_scenarios_of_the_pages_are_admitted(block: Block, tmp_path: Path) -> None:
    with workplace(tmp_path) as patch:
        prepare(tmp_path, block, patch)  # plugins of the page
        validator = Draft7Validator(schema())
    data = parse_document(block.text, "scenario.yaml").data
    if "fragment" in block.directives:
        data = parse_document((ROOT / block.directives["fragment"]).read_text(encoding="utf-8"), "base").data | data
    assert [str(fault.json_path) for fault in validator.iter_errors(data)] == []


ADMITTED = {
    "swept-chain": SHOCK + "sweep: {zip: {chain.material: [copper], chain.radius: [1 mm]}}",
    "swept-parameters": CHAIN
    + SHOCK.replace("triangular", "exponential")
    + "sweep: {points: [{shock.parameters.rise_rate: 1, shock.parameters.decay_rate: 2}]}",
    **{f"template-{entry.name}": template(entry.name) for entry in built_ins.ENTRIES["profiles"]},
    "empty-blocks": CHAIN + SHOCK + "predict:\nsimulate:\nrequires:\npublished:\n",
    "empty-settings": CHAIN + SHOCK + "predict: {}\nsimulate: {}\nrequires: []\n",
    "number-as-text": CHAIN.replace("1 mm", '"1e-3"') + SHOCK,
    "whole-number-as-text": CHAIN.replace("}", ', granules: "50"}') + SHOCK,
    "rare-unit": CHAIN.replace("1 mm", "1 thou") + SHOCK.replace("1 us", "3 /GHz"),
    "coefficient-as-number": CHAIN + SHOCK + "predict: {momentum_coefficient: 4.2}",
    "duration": CHAIN + SHOCK.replace("rise_time", "duration"),
    "both-times": CHAIN + SHOCK.replace("duration_ratio: 2", "duration: 3 us"),
    "times-of-a-record": CHAIN
    + "shock: {profile: tabulated, rise_time: 1, duration: 3, parameters: {times: [0, 1, 2], forces: [0, 1, 0]}}",
    "record-of-its-own-size": CHAIN + "shock: {profile: tabulated, parameters: {times: [0, 1, 2], forces: [0, 1, 0]}}",
    "fixed-step": CHAIN + SHOCK + "simulate: {integrator: verlet, step: 0.01, rtol: null}",
    "no-name": CHAIN + SHOCK + "predict: {quadrature: null}\nsimulate: {integrator: null}",
}


@pytest.mark.parametrize("name", ADMITTED)
def test_the_schema_accepts_what_the_loader_accepts(tmp_path: Path, name: str) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_text(ADMITTED[name], encoding="utf-8")
    assert load_scenario(path).shock.peak_force > 0
    assert _faults(ADMITTED[name]) == []


@pytest.mark.parametrize("name", SEEN)
def test_bad_scenarios_are_rejected(name: str) -> None:
    assert _faults(BAD[name]) != []


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
def test_further_errors_are_rejected_in_their_place(tmp_path: Path, name: str) -> None:
    text, place = REJECTED[name]
    path = tmp_path / "bad.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ShockwaveError):
        load_scenario(path)
    assert place in _faults(text)


_VALUES = st.sampled_from([
    None, {}, [], 0, 1, 2, 2.0, 0.5, 1e-3, -1, True, "", " a ", "exact", "paper", "verlet", "radau", "triangular",
    "exponential", "tabulated", "copper", "compiled", "less", "primary", [0, "1 us", 3], ["numpy"], "3", " .5 ",
    "1e-5 s", "-1 us", "+2 µs", "3 minute", "1/Hz", "2 (m/s)*s/m", "4 s**2/s", "5 %", "1 N", "1 x",
])  # fmt: skip


@settings(
    derandomize=True, deadline=None, max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    text=st.sampled_from([CONTRACT, CHAIN_LINE + RECORD, template("exponential")]),
    changes=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), _VALUES), min_size=1, max_size=2),
    left_out=st.sampled_from(["name", "shock", "rise_time", "duration_ratio", "parameters", "radius", "material"]),
)
def test_what_the_loader_takes_is_admitted(tmp_path: Path, text: str, changes: list[Any], left_out: str) -> None:
    document = parse_document(text, "scenario.yaml")
    paths = [path for path in document.values if path and all(isinstance(step, str) for step in path)]
    data = document.having({paths[int(share * len(paths))]: value for share, value in changes}).data
    for block in (data, data.get("shock"), data.get("chain")):
        if isinstance(block, dict):
            block.pop(left_out, None)
    try:
        scenario_of(Document("scenario.yaml", data), tmp_path / "scenario.yaml")
    except ShockwaveError:
        return
    assert list(_validator().iter_errors(data)) == []


#: Keys of the chain and of the prediction, with names in other cases than usual.
CASES = {
    "wall": "granules: 9, end: {wall: SAME}",
    "rigid": "granules: 9, end: {wall: Rigid}",
    "material": "granules: 9, end: {wall: Copper}",
    "free": "granules: 9, end: Free",
    "packing": "packing: Hexagonal",
    "damping": "granules: 9, damping: {model: Tsuji, restitution: 0.9}",
    "contact": "granules: 9, contact: {model: Power-Law, exponent: 1.5, stiffness: 1e9}",
}


@pytest.mark.parametrize("name", CASES)
def test_names_of_a_chain_are_read_in_any_case(name: str) -> None:
    text = "chain: {material: copper, radius: 1 mm, %s}\n" + SHOCK
    assert _faults(text % CASES[name]) == []
    found, usual = (scenario_of(parse_document(text % one, "s"), None) for one in (CASES[name], CASES[name].lower()))
    assert found.chain == usual.chain


@pytest.mark.parametrize("settings", ["momentum_coefficient: Paper", "model: SECTION-4"])
def test_names_of_a_prediction_are_read_in_any_case(settings: str) -> None:
    text = f"chain: {{material: copper, radius: 1 mm}}\n{SHOCK}predict: {{%s}}\n"
    assert _faults(text % settings) == []
    found, usual, other = (
        scenario_of(parse_document(text % one, "s"), None)
        for one in (settings, settings.lower(), "momentum_coefficient: exact")
    )
    predicted, expected, different = (sw.predict(one).section4 for one in (found, usual, other))
    assert (predicted, found.predictor.model) == (expected, usual.predictor.model)
    assert (predicted, found.predictor.model) != (different, other.predictor.model)


def test_names_in_any_case_are_valid() -> None:
    text = "chain: {material: PTFE, radius: 1 mm}\n" + SHOCK + "simulate: {integrator: RKN64}\n"
    assert _faults(text) == []
    assert _faults(text.replace("RKN64", "RKN65")) != []
