"""Templates: every profile has one that loads and has every key, and its commented lines are valid."""

import re
from pathlib import Path

import pytest

import shockwave as sw
from shockwave.prediction.predictor import Predictor
from shockwave.registry import built_ins
from shockwave.registry.registry import load as registered
from shockwave.scenario import block_keys as keys
from shockwave.scenario.chain_blocks import CELL, END, IMPACT, MOTION, SEGMENT, TAPER
from shockwave.scenario.published_results import Published
from shockwave.scenario.sweep_block import SWEEP
from shockwave.scenario.template import template
from shockwave.scene.impact import Impact
from shockwave.scene.material import Material
from shockwave.scene.material_library import BEARING_STEEL_52100
from shockwave.scene.simulate_options import SimulateOptions
from support.scenario_texts import load, schema_faults


@pytest.mark.parametrize("profile", [entry.name for entry in built_ins.ENTRIES["profiles"]])
def test_templates_load_and_have_every_key(tmp_path: Path, profile: str) -> None:
    text, cls = template(profile, full=True), registered("profiles", profile)
    scenario = load(tmp_path, text)
    assert type(scenario.shock.profile) is cls
    assert (scenario.predictor, scenario.simulate) == (Predictor(), SimulateOptions())
    assert schema_faults(text) == []
    parameters = keys.parameters_of(profile, cls)
    fixed = {"duration_ratio"} - {key.name for key in keys.keys_of(cls)} | ({"parameters"} if not parameters else set())
    shock = [key for key in keys.shock_keys(cls) if key.name not in fixed]
    blocks = [keys.SCENARIO, SWEEP, keys.CHAIN, parameters, shock]
    blocks += [keys.keys_of(part) for part in (Material, Predictor, SimulateOptions, Published)]
    blocks += [SEGMENT, CELL, TAPER, END, IMPACT, MOTION[:4]]
    assert {key.name for block in blocks for key in block if f" {key.name}:" not in text.replace("\n", " ")} == set()


#: Commented parts of a template: the further features of a chain, and the impact that replaces the shock.
FEATURES = re.compile(r"  # further features of finite chains.*?\n(.*?)\n\n", re.DOTALL)
STRIKER = re.compile(r"# impact:.*?\n\n", re.DOTALL)
GUIDED = re.compile(r"# motion:.*?\n\n", re.DOTALL)


def test_commented_features_of_a_template_are_valid(tmp_path: Path) -> None:
    text = FEATURES.sub(
        lambda found: re.sub(r"^  # ", "  ", found[1], flags=re.MULTILINE) + "\n\n", template(full=True)
    )
    assert "# impact:" in text
    text = GUIDED.sub("", text)
    scenario = load(tmp_path, STRIKER.sub("", text))
    assert scenario.chain.count == 20 + 10 + 15 * 3
    assert scenario.chain.end is not None
    struck = STRIKER.sub(lambda found: found[0].replace("# ", "", 1).replace("\n# ", "\n"), text)
    struck = re.sub(r"\nshock:.*?\n\n", "\n", struck, flags=re.DOTALL)
    impact = load(tmp_path, struck)
    assert impact.chain == scenario.chain
    assert impact.excitation == Impact(velocity=0.5, diameter=16e-3, material=BEARING_STEEL_52100)


@pytest.mark.parametrize("profile", ["power-law", "half-sine"])
def test_commented_lines_of_a_template_are_valid(profile: str, tmp_path: Path) -> None:
    text = GUIDED.sub("", STRIKER.sub("", FEATURES.sub("", template(profile, full=True))))
    text = text.replace("material: bearing-steel-52100", "").replace("\n  # material:", "\n  material:")
    text = text.replace("\n  #   ", "\n    ").replace("\n#   ", "\n  ")
    for key in ("# limit", "# published", "# sweep", "# uncertainty", "  # granules", "  # quadrature"):
        text = text.replace(f"\n{key}", f"\n{key.replace('# ', '')}")
    scenario = load(tmp_path, text)
    assert (scenario.chain.granules, scenario.predictor.quadrature) == (200, "tanh-sinh")
    assert scenario.limit == sw.Limit(force=60.0)
    assert scenario.published is not None
    assert scenario.sweep is not None
    assert scenario.sweep.shape == (10, 2, 2, 2)
    assert [spread.kind for spread in scenario.uncertainty] == ["relative", "sd", "between", "factor"]
