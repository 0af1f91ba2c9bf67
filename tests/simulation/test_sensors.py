"""Sensors: their histories, the files that they are written to, and what they cost where there are none."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attrs import evolve

import shockwave as sw
from shockwave import pictures
from shockwave.cli import main
from shockwave.scene.scene import Scene
from shockwave.scene.sensors import Sensor
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.contact_setup import ChainSetup
from support.chain_reference import Reference
from support.figures import inside
from support.programs import SCENE
from support.scenario_texts import load
from support.scenes import CHAIN, STEEL, triangle

pytestmark = pytest.mark.compiled

GRAVITY = 9.81
WALL = sw.Wall(material="rigid")
SPRUNG = sw.Wall(mass="2 g", stiffness="1e6 N/m", damping="50 N*s/m")
STRIKER = sw.Impact(velocity="0.4 m/s", diameter="12 mm", material="ptfe")
LAYERS = (sw.Segment(count=4), sw.Segment(count=3, material="ptfe", diameter="6 mm"), sw.Segment(count=3))
#: Excitation, chain and end of the simulated time [s].
SCENES: dict[str, tuple[Any, sw.Chain, float]] = {
    "equal granules": (triangle(2.0), evolve(CHAIN, granules=10), 4e-4),
    "precompressed": (triangle(2.0), evolve(CHAIN, granules=10, precompression=20.0), 4e-4),
    "vertical": (STRIKER, evolve(CHAIN, granules=LAYERS, end=WALL, gravity=GRAVITY), 1e-3),
    "damped": (STRIKER, evolve(CHAIN, granules=LAYERS, end=WALL, damping=sw.KuwabaraKono(time="2 us")), 1e-3),
    "on a structure": (STRIKER, evolve(CHAIN, granules=LAYERS, end=SPRUNG), 2e-3),
}
SENSORS: list[Any] = [
    {"contact": 2},
    {"granule": 5},
    {"granule": 3, "quantity": "velocity"},
    {"granule": 6, "quantity": "displacement"},
]
BRASS = sw.Chain(material=STEEL, radius=4.75e-3, granules=8, end=sw.Wall())


def values(result: sw.Simulation) -> dict[str, Any]:
    return {each.name: each.values for each in result.recording.sensors}


@pytest.mark.parametrize("name", SCENES)
def test_histories_agree_with_an_independent_integration(name: str) -> None:
    excitation, chain, until = SCENES[name]
    at_end: list[Any] = [] if chain.end is None else ["wall"] if chain.end.mass is None else ["wall", "structure"]
    result = sw.simulate(excitation, chain, rtol=1e-8, sensors=SENSORS + at_end, until=until, interval=2e-6)
    reference = Reference(excitation, chain, 1e-5)
    forces, x, v = reference.history(np.asarray(result.recording.times))
    expected = {
        "contact_2": forces[:, 2],
        "granule_5": (forces[:, 4] + forces[:, 5]) / 2,
        "granule_3_velocity": v[:, 3],
        "granule_6_displacement": x[:, 6],
    }
    if at_end:
        expected["wall"] = forces[:, -1]
    if "structure" in at_end:
        spring = 1e6 * x[:, -1] + 50 * v[:, -1]
        expected |= {"structure_displacement": x[:, -1], "structure_velocity": v[:, -1]}
        expected |= {"structure_acceleration": (forces[:, -1] - spring) / 2e-3, "structure_spring_force": spring}
    found = values(result)
    assert found.keys() == expected.keys()
    for sensor, history in expected.items():
        # relative to the greatest value, at a hundredth of this tolerance
        assert found[sensor] == pytest.approx(history, abs=1e-6 * np.abs(history).max()), sensor


@pytest.mark.parametrize("static", [0.0, 20.0], ids=["loose", "precompressed"])
def test_an_endless_chain_is_recorded_to_its_last_sensor(static: float) -> None:
    sensors: list[Any] = [{"granule": 8}, {"contact": 30}]
    chain, finite = (evolve(CHAIN, granules=count, precompression=static) for count in (None, 120))
    endless = sw.simulate(triangle(2.0), chain, rtol=1e-8, sensors=sensors)
    until = float(endless.recording.times[-1])
    whole = sw.simulate(triangle(2.0), finite, rtol=1e-8, sensors=sensors, until=until)
    for name, history in values(endless).items():
        # the waves do not reach the end of the finite chain; tolerance of the two runs
        assert history == pytest.approx(values(whole)[name], abs=1e-7 * history.max()), name
        assert history.argmax() < len(history) / 2


def test_an_endless_chain_reports_contacts_that_waves_reach_within_the_time_of_its_sensors() -> None:
    chain = evolve(CHAIN, precompression=20.0)
    whole, near = (sw.simulate(triangle(2.0), chain, sensors=sensors) for sensors in ([], [{"granule": 8}]))
    assert [peak.contact for peak in near.contacts] == [0, 1, 2, 5]
    expected = [peak.peak_force for peak in whole.contacts[:4]]
    assert [peak.peak_force for peak in near.contacts] == pytest.approx(expected, rel=1e-6)  # the tolerance


def test_an_integrator_with_steps_of_its_own_is_recorded_from_the_beginning() -> None:
    chain = evolve(BRASS, granules=(sw.Segment(count=3), sw.Segment(count=2, radius="3 mm")))
    sensors: list[Any] = [{"contact": 1}, {"granule": 0, "quantity": "velocity"}]
    options: Any = {"until": 1e-4, "interval": 2e-6, "sensors": sensors, "record": ["energies"]}
    usual, other = (sw.simulate(STRIKER, chain, integrator=name, rtol=1e-6, **options) for name in ("rkn86", "radau"))
    assert values(other)["granule_0_velocity"][0] == 0.4
    for name, history in values(usual).items():
        assert values(other)[name] == pytest.approx(history, abs=1e-5 * np.abs(history).max()), name
    assert len(other.to_dict()["sensors"]) == 2


def test_the_tolerance_holds_for_the_contacts_of_sensors() -> None:
    scene = Scene(excitation=triangle(2.0), chain=BRASS)
    case = ChainSetup.of(SimulateOptions(sensors=[{"granule": 4}, {"contact": 1}]), scene)
    assert case.judged_contacts(np.arange(8.0)).tolist() == [1, 3, 4, 7]


@pytest.mark.parametrize(
    ("sensor", "chain", "problem"),
    [
        ("roof", BRASS, "sensors[0]: must be wall, structure, {contact: N}, {granule: N} or"),
        ({"granule": 1.5}, BRASS, "sensors[0]: must be wall"),
        ({"granule": 1, "contact": 2}, BRASS, "sensors[0]: must be wall"),
        ({"contact": 1, "quantity": "velocity"}, BRASS, "sensors[0]: must be wall"),
        ("wall", CHAIN, "sensors[0]: must be a place in the chain (got wall at a free end; state chain.end)"),
        (
            "structure",
            BRASS,
            "sensors[0]: must be a place in the chain (got structure at a fixed wall; state its mass)",
        ),
        ({"contact": 8}, BRASS, "sensors[0].contact: must be 0 to 7 in this chain (got 8)"),
        ({"granule": 8}, BRASS, "sensors[0].granule: must be 1 to 7 in this chain (got 8)"),
        ({"granule": 7}, evolve(CHAIN, granules=8), "sensors[0].granule: must be 1 to 6 in this chain (got 7)"),
        ({"granule": 0}, BRASS, "(got 0; on its only contact, {contact: 0})"),
        ({"granule": 0}, CHAIN, "sensors[0].granule: must be at least 1 (got 0"),
    ],
    ids=str,
)
def test_a_place_that_the_chain_does_not_have_is_refused(sensor: Any, chain: sw.Chain, problem: str) -> None:
    with pytest.raises(sw.InvalidValueError) as error:
        sw.simulate(triangle(2.0), chain, sensors=[sensor])
    assert problem in str(error.value)


SCENARIO = """
chain: {material: copper, radius: 5 mm, granules: 6, end: {wall: same}}
impact: {velocity: 1 m/s}
simulate:
  sensors: [wall, {granule: 3}, {granule: 2, quantity: velocity}]
  interval: 2 us
"""


def test_a_scenario_states_sensors_and_its_faults_have_their_places(tmp_path: Path) -> None:
    sensors = load(tmp_path, SCENARIO).simulate.sensors
    assert sensors == (Sensor("wall"), Sensor("granule", 3), Sensor("granule", 2, "velocity"))
    with pytest.raises(sw.ScenarioError) as error:
        load(tmp_path, SCENARIO.replace("wall, {granule: 3}", "structure, {granule: 9}"))
    assert "5:13: simulate.sensors[0]: must be a place in the chain" in str(error.value)
    assert "5:34: simulate.sensors[1].granule: must be 1 to 6 in this chain (got 9)" in str(error.value)


def test_the_command_writes_histories_and_their_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    xarray = pytest.importorskip("xarray")
    (tmp_path / "scene.yaml").write_text(SCENARIO)
    files = [str(tmp_path / f"out.{ending}") for ending in ("csv", "nc", "svg")]
    assert (
        main(["simulate", str(tmp_path / "scene.yaml"), *(word for file in files for word in ("--record", file))]) == 0
    )
    assert capsys.readouterr().err.count(": written") == len(files)
    with open(files[0], newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["time [s]", "wall [N]", "granule_3 [N]", "granule_2_velocity [m/s]"]
    written = np.array(rows, dtype=float).T
    assert np.diff(written[0]) == pytest.approx(2e-6, rel=1e-9)  # rounding
    data = xarray.load_dataset(files[1])
    assert data.granule_2_velocity.attrs["units"] == "m/s"
    assert np.array_equal(data.wall, written[1])
    assert "<svg" in Path(files[2]).read_text()


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ([SCENE, "--record", "out.csv"], "simulate.sensors: must be given for --record (got nothing;"),
        ([SCENE, "--record", "out.xls"], "--record: must end in .csv, .nc, .svg, .png or .pdf (got out.xls)"),
        ([SCENE, SCENE, "--record", "out.csv"], "--record: must be given with one scenario (got 2)"),
    ],
    ids=["nothing", "ending", "several"],
)
def test_a_record_that_cannot_be_written_is_refused(
    words: list[str], problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", *words]) in (2, 3)
    assert problem in capsys.readouterr().err


def test_the_picture_has_a_line_for_each_sensor_of_a_unit() -> None:
    sensors: list[Any] = ["wall", {"granule": 1}, {"granule": 3}, {"granule": 3, "quantity": "velocity"}]
    result = sw.simulate(triangle(2.0), BRASS, sensors=sensors)
    forces, velocities = result.plot(), pictures.sensors(result.recording, "m/s")
    labels = [str(line.get_label()) for line in forces.get_lines()]
    assert [label.partition(",")[0] for label in labels] == ["wall", "granule 1", "granule 3"]
    assert all(", width " in label for label in labels)
    assert [label.endswith("m/s") for label in labels] == [False, False, True]
    assert forces.get_ylabel() == "force (N)"
    assert velocities.get_ylabel() == "velocity (mm/s)"
    assert inside(forces.figure)
    with pytest.raises(sw.InvalidValueError, match="unit: must be N, m/s"):
        pictures.sensors(result, "m")
    with pytest.raises(sw.InvalidValueError, match="sensors: must be requested"):
        pictures.sensors(sw.simulate(triangle(2.0), BRASS))
