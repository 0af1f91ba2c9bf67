"""Prediction and simulation with the profiles, from scenario files and from Python."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shockwave as sw
from shockwave import Chain, Material, Predictor, ScenarioError, Shock, Tabulated, load_scenario, simulate

from shockwave_blast.friedlander import Friedlander

FILES = sorted((Path(__file__).parent.parent / "profiles").glob("*.yaml"))
PEAK_FORCE = 100.0
CHAIN = Chain(
    material=Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0), radius=4.75e-3
)  # steel beads, as in the paper
# Characteristic time [s].
UNIT = CHAIN.time_at_unit_force / PEAK_FORCE ** (1 / 6)

each_file = pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)


def shock_of(natural_times: float, **shape: float) -> Shock:
    """A shock that lasts so many of the chain's characteristic times."""
    profile = Friedlander(**shape)
    return Shock(profile=profile, peak_force=PEAK_FORCE, duration=natural_times * UNIT)


def test_the_scenarios_are_there() -> None:
    assert [file.stem for file in FILES] == ["friedlander", "microcharge", "nylon-balls"]


@each_file
@pytest.mark.parametrize("question", [sw.predict, sw.simulate, sw.compare])
def test_scenarios_run(file: Path, question: Callable[..., sw.Outcome]) -> None:
    assert question(file, waves="primary").to_dict()


@each_file
def test_scenarios_last_less_than_30_natural_times(file: Path) -> None:
    scenario = load_scenario(file)
    unit = scenario.chain.time_at_unit_force / scenario.shock.peak_force ** (1 / 6)
    assert scenario.shock.duration < 30 * unit


@each_file
def test_scenarios_meet_the_conditions(file: Path) -> None:
    scenario = load_scenario(file)
    assert Predictor().section4(scenario.shock, scenario.chain).holds


def test_a_prediction_states_its_assumptions() -> None:
    scenario = load_scenario(next(file for file in FILES if file.stem == "microcharge"))
    assert Predictor().predict(scenario.shock, scenario.chain).notes == scenario.shock.profile.notes != ()


def test_a_standoff_out_of_range_is_located_in_the_file(tmp_path: Path) -> None:
    text = next(file for file in FILES if file.stem == "microcharge").read_text(encoding="utf-8")
    file = tmp_path / "near.yaml"
    file.write_text(text.replace("standoff: 10 cm", "standoff: 1 cm"), encoding="utf-8")
    with pytest.raises(
        ScenarioError, match=r"near\.yaml:\d+:\d+: shock\.parameters\.standoff: must be 0\.0147 m"
    ):
        load_scenario(file)


@pytest.mark.parametrize("b", [0.0, 1.0, 20.0])
def test_a_short_blast_is_an_impulse(b: float) -> None:
    shock = shock_of(0.02, decay_coefficient=b)
    result = simulate(shock, CHAIN, rtol=1e-6)
    impulse = shock.profile.areas().total * PEAK_FORCE * shock.rise_time
    share = impulse / sw.SolitaryWave.of(PEAK_FORCE, CHAIN).momentum
    # In the limit of no duration only the impulse counts; the force spreads over less than 0.005 of the unit.
    assert result.amplification == pytest.approx(1.1681817 * share**1.2, rel=3e-6)


def test_simulation_agrees_with_the_same_pulse_as_a_record() -> None:
    shock = shock_of(3.0, decay_coefficient=2.0, rise_fraction=0.05)
    s = np.concatenate((np.linspace(0, 1, 3), np.linspace(1, 20, 2001)[1:]))
    record = Tabulated(times=shock.rise_time * s, forces=PEAK_FORCE * shock.profile.force(s))
    found, recorded = (
        simulate(given, CHAIN, rtol=1e-7).peak_force for given in (shock, Shock(profile=record))
    )
    # Chords above a curve that bends by (b^2 + 2 b)/12 (1/2000)^2 add 2e-7 of the impulse.
    assert found == pytest.approx(recorded, rel=1e-6)


def test_the_default_rise_changes_the_primary_as_stated() -> None:
    default, shorter = (
        simulate(shock_of(10.0, decay_coefficient=3.0, **rise), CHAIN, waves="primary").peak_force
        for rise in ({}, {"rise_fraction": 1e-6})
    )
    assert default / shorter - 1 == pytest.approx(0.0017, abs=1e-5)


def test_simulation_conserves_momentum_and_energy() -> None:
    shock = shock_of(2.0, decay_coefficient=3.0)
    result = simulate(shock, CHAIN, rtol=1e-6)
    impulse = shock.profile.areas().total * PEAK_FORCE * shock.rise_time
    assert result.applied_momentum == pytest.approx(impulse, rel=1e-12)
    assert result.momentum_defect < 1e-12
    assert result.energy_defect < 1e-6
    assert result.error_estimate <= 1e-6
