"""The velocity of a striker, given as such or as the height of its fall."""

from __future__ import annotations

import math
from typing import Any

import pytest

import shockwave as sw

HEIGHT = 0.05


@pytest.mark.parametrize(
    ("features", "gravity"),
    [({}, 9.80665), ({"gravity": 1.62, "end": sw.Wall()}, 1.62)],
    ids=["standard gravity", "gravity of the chain"],
)
def test_a_fall_gives_the_striker_its_velocity(features: dict[str, Any], gravity: float) -> None:
    chain = sw.Chain(material="ptfe", diameter=9.5e-3, granules=3, **features)
    velocity = math.sqrt(2 * gravity * HEIGHT)
    fallen, thrown = (
        sw.simulate(impact, chain) for impact in (sw.Impact(drop_height="5 cm"), sw.Impact(velocity=velocity))
    )
    assert fallen.greatest_force == thrown.greatest_force
    assert fallen.restitution == thrown.restitution
    assert sw.predict(sw.Impact(drop_height=HEIGHT), chain).applied_momentum == pytest.approx(
        chain.granule_mass * velocity, rel=1e-12
    )


@pytest.mark.parametrize(
    "given", [{}, {"velocity": 1.0, "drop_height": 0.1}, {"radius": 1e-3}], ids=["nothing", "both", "size alone"]
)
def test_exactly_one_of_velocity_and_height_is_needed(given: dict[str, Any]) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"velocity: must be given, or drop_height, but not both"):
        sw.Impact(**given)


@pytest.mark.parametrize(
    ("block", "problem"),
    [
        ("{}", r"impact.velocity: must be given .*or give drop_height"),
        ("{velocity: 1, drop_height: 5 cm}", r"impact.drop_height: must be left out if velocity is given"),
        ("{drop_height: 5 s}", r"impact.drop_height: must be a length"),
    ],
    ids=["nothing", "both", "a time"],
)
def test_a_file_is_refused_in_the_same_way(block: str, problem: str) -> None:
    chain = "chain: {material: ptfe, diameter: 9.5 mm, granules: 5}"
    with pytest.raises(sw.ScenarioError, match=problem):
        sw.Scenario.from_yaml(f"{chain}\nimpact: {block}")


def test_a_height_is_varied() -> None:
    scenario = sw.Scenario.from_yaml(
        "chain: {material: ptfe, diameter: 9.5 mm, granules: 5}\nimpact: {drop_height: 5 cm}\n"
    )
    design = sw.design(scenario, vary={"impact.drop_height": ("1 mm", "1 m")}, target="greatest_force.peak_force = 5 N")
    height = design.solutions[0].values[0]
    force = sw.simulate(sw.Impact(drop_height=height), scenario.chain).greatest_force.peak_force
    assert force == pytest.approx(5.0, rel=2e-3)
