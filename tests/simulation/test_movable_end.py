"""Motion of a movable end: displacement, acceleration and spring force, and what is limited."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

import shockwave as sw
from shockwave.engine.chain_motion import integrate
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.contact_setup import ChainSetup

IMPACT = sw.Impact(velocity=0.5)
SOFT = sw.Wall(mass=0.05, stiffness=1e6)
LIGHT = sw.Wall(mass=3e-3, stiffness=2e5, damping=30.0)
NAMES = ("peak_displacement", "peak_acceleration", "peak_spring_force")


def row(end: sw.Wall, **features: Any) -> sw.Chain:
    return sw.Chain(material="stainless-steel-302", diameter="9.5 mm", granules=4, end=end, **features)


@pytest.mark.parametrize(
    "chain",
    [
        row(SOFT),
        row(LIGHT),
        row(LIGHT, damping=sw.KuwabaraKono(time=2e-6)),
        row(SOFT, precompression=20.0),
        row(sw.Wall(mass=5e-3)),
    ],
    ids=["spring", "light with a dashpot", "damped contacts", "precompressed", "free mass"],
)
def test_the_greatest_motion_is_that_of_the_recorded_one(chain: sw.Chain) -> None:
    """`test_sensors` compares the histories of a structure with an independent integration."""
    result = sw.simulate(IMPACT, chain, until=0.6e-3)
    dense = sw.simulate(IMPACT, chain, until=0.6e-3, rtol=1e-9, sensors=["structure"], interval=1e-8).recording
    histories = {each.name.removeprefix("structure_"): each.values for each in dense.sensors}
    for name in NAMES:
        # between samples every 10 ns, a maximum with a width of 10 us is missed by a few 1e-7 at most
        greatest = float(np.abs(histories[name.removeprefix("peak_")]).max())
        assert getattr(result.structure, name) == pytest.approx(greatest, rel=1e-6), name
        assert 0 <= getattr(result.structure, f"{name}_error") <= 1e-6


def test_the_motion_at_the_end_of_a_long_chain_is_that_of_the_whole_chain(monkeypatch: pytest.MonkeyPatch) -> None:
    case = ChainSetup.of(SimulateOptions(), sw.Scenario.from_dict(LONG).scene)
    in_parts = integrate(case.assembly, 1e-9, compiled=case.compiled)
    monkeypatch.setattr("shockwave.engine.chain_domains._LEAST_BODIES", 10_000)
    whole = integrate(case.assembly, 1e-9, compiled=case.compiled)
    assert whole.extremes.all()
    assert in_parts.extremes == pytest.approx(whole.extremes, rel=1e-7)


LONG = {
    "chain": {
        "material": "ptfe",
        "diameter": 0.01,
        "granules": 600,
        "end": {"wall": "same", "mass": 1e-2, "stiffness": 1e5, "damping": 3.0},
    },
    "impact": {"velocity": 1.0},
}


@pytest.mark.parametrize("damping", [0.0, 30.0], ids=["spring", "spring and dashpot"])
def test_the_spring_force_after_the_simulated_time_is_bounded(damping: float) -> None:
    chain = row(sw.Wall(mass=0.05, stiffness=1e6, damping=damping))
    late = sw.simulate(IMPACT, chain, until=3e-3).structure
    # after the last blow and before the wall has turned
    early = sw.simulate(IMPACT, chain, until=0.3e-3)
    spring = early.leaving.spring
    assert late.peak_spring_force > early.structure.peak_spring_force
    assert late.peak_spring_force <= spring.later * (1 + 1e-6)
    if not damping:  # the energy of wall and spring is then known
        assert spring.later == pytest.approx(late.peak_spring_force, rel=0.05)
    (warning,) = (each for each in early.warnings if "spring force" in each)
    half = math.pi * math.sqrt(0.05 / 1e6)
    stated = re.search(r"to at most ([\d.]+) N", warning)
    assert stated is not None
    assert spring.later <= float(stated[1]) <= 1.01 * spring.later
    assert f"half a period of wall and spring is {1e6 * half:.2g} us".replace("e+02", "00") in warning
    assert not any("spring force" in each for each in sw.simulate(IMPACT, chain, until=3e-3).warnings) or damping


def test_a_limit_on_the_spring_is_judged_by_its_force_and_the_text_has_both() -> None:
    on_wall, behind = (
        sw.simulate(IMPACT, row(LIGHT), until=1e-3, limit=sw.Limit(force=20.0, at=at)) for at in ("chain", "spring")
    )
    wall, spring = on_wall.transmitted.peak_force, behind.structure.peak_spring_force
    assert spring < 20 < wall
    assert (on_wall.verdict.decision, behind.verdict.decision) == ("above", "below")
    assert (on_wall.verdict.value, behind.verdict.value) == (wall, spring)
    for verdict, other in ((on_wall.verdict, "of the spring"), (behind.verdict, "on the wall")):
        assert f"; force {other}" in str(verdict)
    assert on_wall.verdict.beside.endswith("below")
    assert behind.verdict.beside.endswith("above")


@pytest.mark.parametrize("end", [None, sw.Wall(), sw.Wall(mass=0.1)], ids=["free", "fixed", "free mass"])
def test_a_limit_on_a_spring_that_there_is_not_is_refused(end: sw.Wall | None) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"limit.at: must be chain for an end without a spring"):
        sw.simulate(IMPACT, row(end), limit=sw.Limit(force=20.0, at="spring"))  # type: ignore[arg-type]


def test_of_an_end_that_is_integrated_as_fixed_the_spring_force_is_that_on_the_wall() -> None:
    result = sw.simulate(IMPACT, row(sw.Wall(mass=1.0, stiffness=1e20), precompression=10.0))
    force = result.transmitted.peak_force - result.transmitted.static_force
    assert result.structure.peak_spring_force == force
    assert result.structure.peak_acceleration is None


def test_without_a_movable_end_there_is_no_structure() -> None:
    assert sw.simulate(IMPACT, row(sw.Wall())).structure is None
    outcome = sw.predict(IMPACT, row(SOFT))
    assert outcome.structure == sw.simulate(IMPACT, row(SOFT)).structure
    assert outcome.to_dict()["structure"]["peak_spring_force"] == outcome.structure.peak_spring_force


def test_a_limit_on_a_spring_is_read_from_a_file_and_refused_in_its_place() -> None:
    scene = {**LONG, "limit": {"force": "60 N", "at": "spring"}}
    assert sw.Scenario.from_dict(scene).limit == sw.Limit(force=60.0, at="spring")
    with pytest.raises(sw.ScenarioError, match=r"text:2:27: limit\.at: must be chain"):
        sw.Scenario.from_yaml(
            "{chain: {material: ptfe, diameter: 9.5 mm, granules: 5}, impact: {velocity: 1},\n"
            " limit: {force: 60 N, at: spring}}"
        )


@pytest.mark.usefixtures("few_draws")
def test_designs_and_uncertainties_read_the_structure() -> None:
    scene = {**LONG, "chain": {**LONG["chain"], "granules": 5}, "limit": {"force": 6, "at": "spring"}}
    scenario = sw.Scenario.from_dict({**scene, "uncertainty": {"impact.velocity": "20 %"}})
    result = sw.uncertainty(scenario, draws=64)
    assert result.verdict.force == "force of the spring on the ground"
    forces = result.outputs["structure.peak_spring_force"]
    assert result.exceedance.probability == pytest.approx(float(np.mean(forces >= 6)), abs=1e-9)
    assert {f"structure.{name}" for name in NAMES} <= {each.name for each in result.quantities}
    design = sw.design(
        scenario, vary={"chain.end.mass": ("5 g", "50 g")}, target="structure.peak_acceleration <= 1000 m/s^2"
    )
    assert design.solutions


@pytest.mark.parametrize("sensors", [(), ("wall", "structure")], ids=["no-sensors", "sensors"])
def test_the_short_text_states_the_greatest_motion_above_the_sensors(sensors: Any) -> None:
    result = sw.simulate(IMPACT, row(SOFT), sensors=sensors)
    short, whole = str(result), result.text("verbose")
    for part in ("structure         displacement", "spring force      "):
        assert part in short.partition("first peak")[0]
        assert whole.count(f"\n  {part}") == 1
