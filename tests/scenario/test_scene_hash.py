"""Hash of a scenario: that of the scene, whatever its units and names."""

from pathlib import Path
from typing import Any

import numpy as np
from attrs import evolve

import shockwave as sw
from shockwave.scenario.scene_hash import normalise, scene_hash
from shockwave.scene.simulate_options import SimulateOptions
from support.scenario_texts import load, scenario_in_python
from support.scenes import CHAIN, power

# A granule of the paper, and a shock of 100 N.
TEXT = """\
name: %s
chain: {material: {youngs_modulus: 193 GPa, poisson_ratio: 0.3, density: 7958 kg/m**3}, %s}
shock: {profile: power-law, peak_force: %s, %s, duration_ratio: 3,
  parameters: {rise_exponent: 0.5, decay_exponent: 1}}
"""


def test_units_and_names_do_not_change_the_hash(tmp_path: Path) -> None:
    one = normalise(load(tmp_path, TEXT % ("a", "diameter: 9.5 mm", "100 N", "rise_time: 1.9 us")))
    other = normalise(load(tmp_path, TEXT % ("another", "radius: 4.75e-3", "0.1 kN", "duration: 5.7 us")))
    assert one == other


CHANGES: list[dict[str, Any]] = [
    {"chain": evolve(CHAIN, radius=4.750001e-3)},
    {"shock": evolve(power(0.5), peak_force=100.0001)},
    {"shock": evolve(power(0.5), profile=sw.Triangular(duration_ratio=3))},
    {"predictor": sw.Predictor(alpha="literal")},
    {"predictor": sw.Predictor(momentum_coefficient="paper")},
    {"simulate": SimulateOptions(rtol=1e-8)},
    {"limit": sw.Limit(force=60.0)},
    {"chain": evolve(CHAIN, material=evolve(CHAIN.material, yield_strength=2e9))},
    {"chain": evolve(CHAIN, elastic_only=True)},
    {"chain": evolve(CHAIN, granules=50)},
    {"chain": evolve(CHAIN, packing="hexagonal")},
]


def test_other_inputs_have_other_hashes() -> None:
    scene = scenario_in_python(power(0.5))
    hashes = [scene_hash(evolve(scene, **change)) for change in ({}, *CHANGES)]
    assert len(set(hashes)) == len(hashes)


class Kept(sw.ShockProfile):
    """A triangle whose parameter is not an attribute."""

    duration_ratio = 3.0

    def __init__(self, power: float) -> None:
        self._power = power

    def rise(self, s: np.ndarray) -> np.ndarray:
        return np.asarray(s**self._power)

    def decay(self, s: np.ndarray) -> np.ndarray:
        return np.asarray((3 - s) / 2)


def test_a_profile_without_parameters_is_identified_by_its_force() -> None:
    shocks = [sw.Shock(profile=Kept(power), peak_force=1.0, rise_time=1e-5) for power in (1.0, 1.0, 1.001)]
    one, same, other = (scene_hash(scenario_in_python(shock)) for shock in shocks)
    assert one == same != other
