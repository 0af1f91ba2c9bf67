"""Short scenarios, as text, and what the schema says of them."""

from functools import cache
from pathlib import Path
from typing import Any

from jsonschema import Draft7Validator

from shockwave.prediction.predictor import Predictor
from shockwave.scenario.scenario import Scenario, load_scenario
from shockwave.scenario.schema import schema
from shockwave.scenario.yaml_document import parse_document
from shockwave.scene.chain import Chain
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions
from support.scenes import CHAIN as PAPER_CHAIN

CHAIN = "chain: {material: copper, radius: 1 mm}\n"
SHOCK = "shock: {profile: triangular, peak_force: 1 N, rise_time: 1 us, duration_ratio: 2}\n"
IMPACT = "impact: {velocity: 0.5 m/s}\n"
TABULATED = CHAIN + "shock: {profile: tabulated, parameters: {%s}}\n"
#: Every key of chains beyond equal granules.
EVERY_FEATURE = """\
chain:
  material: stainless-steel-302
  diameter: 9.5 mm
  granules:
    - {count: 20}
    - {count: 10, material: ptfe, gap: 0 mm}
    - {count: 5, diameter: {from: 9.5 mm, to: 5 mm, spacing: geometric}}
    - {repeat: 3, cell: [{material: brass-260}, {diameter: 5 mm, count: 2}]}
    - {radius: {from: 1 mm, to: 2 mm}, count: 3, material: {youngs_modulus: 1 GPa, poisson_ratio: 0.3, density: 1e3}}
  end: {wall: same, mass: 2 kg, stiffness: 1e6 N/m, damping: 50 N*s/m}
  precompression: 2 N
  gravity: 9.81 m/s**2
  damping: {model: kuwabara-kono, time: 2 us}
  contact: {exponent: 1.5, stiffness: 1.0e7}
impact: {velocity: 0.5 m/s, diameter: 16 mm, material: stainless-steel-302}
simulate: {contacts: [0, 5, 20], until: 2 ms}
"""


def finite(more: str = "", excitation: str = SHOCK) -> str:
    """A scenario of four granules with further keys of its chain."""
    return f"chain: {{material: copper, radius: 1 mm, granules: [{{count: 4}}]{more}}}\n{excitation}"


@cache
def _validator() -> Draft7Validator:
    return Draft7Validator(schema())


def schema_faults(scenario: str | dict[str, Any], validator: Draft7Validator | None = None) -> list[str]:
    """Where the schema finds a scenario wrong, read as the loader reads it."""
    data = parse_document(scenario, "scenario.yaml").data if isinstance(scenario, str) else scenario
    return [str(fault.json_path) for fault in (validator or _validator()).iter_errors(data)]


def load(folder: Path, text: str) -> Scenario:
    """The scenario of a file with this text."""
    (folder / "scene.yaml").write_text(text, encoding="utf-8")
    return load_scenario(folder / "scene.yaml")


def scenario_in_python(shock: Shock, chain: Chain = PAPER_CHAIN, **options: Any) -> Scenario:
    """A scenario without a file."""
    simulate = SimulateOptions(**options)
    return Scenario(name="a scene", path=None, shock=shock, chain=chain, predictor=Predictor(), simulate=simulate)
