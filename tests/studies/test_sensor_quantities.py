"""Figures of first pulses, and ratios of two, as targets of designs, in uncertainties and as columns of sweeps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from matplotlib import pyplot

import shockwave as sw
from shockwave.base.quantities import sensor_figures
from shockwave.base.text import render_on_screen
from shockwave.cli import main
from shockwave.scene.sensors import Sensor
from shockwave.studies.quantities import targets_of
from shockwave.sweep.sweep_picture import plot
from support.scenario_texts import load

pytestmark = pytest.mark.compiled

BLOCKS = """
name: taper
chain:
  material: bearing-steel-52100
  diameter: 9.5 mm
  granules:
    - {count: 6}
    - {count: 10, diameter: {from: 9.5 mm, to: 6 mm}}
  end: {wall: same}
impact: {velocity: 0.4 m/s}
simulate: {sensors: [{contact: 3}, {contact: 13}, {granule: 4, quantity: velocity}]}
"""
SWEEP = """
sweep:
  grid: {"chain.granules[1].diameter.to": [5 mm, 9 mm]}
  quantities: ['sensors[1].peak / sensors[0].peak', 'segments[1].energy', arrival_time]
"""
RATIO = "sensors[1].peak / sensors[0].peak"


@pytest.mark.parametrize(
    ("target", "read"),
    [
        (f"{RATIO.replace(' ', '')} = 0.8", lambda first, second: second.peak / first.peak),
        ("sensors[1].arrival = 240 us", lambda _, second: second.arrival),
    ],
    ids=["ratio", "time"],
)
def test_a_design_meets_a_target_on_first_pulses(tmp_path: Path, target: str, read: Any) -> None:
    scenario = load(tmp_path, BLOCKS)
    vary = "impact.velocity" if "arrival" in target else "chain.granules[1].diameter.to"
    between = (0.1, 2.0) if "arrival" in target else ("4 mm", "9 mm")
    (solution, *_) = sw.design(scenario, vary=vary, between=between, target=target, points=3).solutions
    value = float(target.split("= ")[1].split()[0]) * (1e-6 if "us" in target else 1.0)
    assert solution.reached == pytest.approx(value, rel=1e-4)
    text = BLOCKS.replace("to: 6 mm", f"to: {solution.value} m")
    if vary == "impact.velocity":
        text = BLOCKS.replace("velocity: 0.4", f"velocity: {solution.value}")
    first, second, _ = sw.simulate(load(tmp_path, text)).sensors
    assert read(first, second) == pytest.approx(value, rel=1e-3)


@pytest.mark.parametrize(
    ("target", "problem"),
    [
        ("sensors[3].peak = 4 N", "must count from 0 in the list of sensors, simulate.sensors (got 'sensors[3].peak'"),
        (f"{RATIO.replace('[0]', '[9]')} = 4", "the list has 3)"),
        ("sensors[0].peak / nothing = 4", "must be a property of the result (got 'sensors[0].peak / nothing'"),
        ("sensors[0].speed = 4 m/s", "must be a property of the result (got 'sensors[0].speed'; did you mean"),
        ("sensors[2].speed = 4 m/s", "must be a property of the result"),
        ("__import__('os') = 4", "must be a quantity, <=, >= or =, and a value"),
    ],
    ids=["number", "number in a ratio", "name in a ratio", "first speed", "speed of another kind", "code"],
)
def test_a_wrong_target_is_refused(tmp_path: Path, target: str, problem: str) -> None:
    with pytest.raises(sw.InvalidValueError) as error:
        sw.design(load(tmp_path, BLOCKS), vary="impact.velocity", between=(0.1, 1.0), target=target)
    assert problem in str(error.value)


def test_a_speed_of_merged_pulses_is_refused_with_the_reason(tmp_path: Path) -> None:
    scenario = load(tmp_path, BLOCKS.replace("{contact: 13}", "{contact: 15}"))
    with pytest.raises(sw.InvalidValueError, match=r"null where impact.velocity is 0\.1: .* or merged with"):
        sw.design(scenario, vary="impact.velocity", between=(0.1, 1.0), target="sensors[1].speed = 500 m/s")


@pytest.mark.usefixtures("few_draws")
def test_an_uncertainty_has_the_figures_of_sensors_and_named_ratios(tmp_path: Path) -> None:
    text = BLOCKS.replace("{contact: 13}, {granule: 4, quantity: velocity}", "{contact: 7}")
    scenario = load(tmp_path, text.replace("count: 10", "count: 4"))
    named = ["contact_7_peak / contact_3_peak", "contact_7_speed"]
    result = sw.uncertainty(scenario, spreads={"impact.velocity": "5 %"}, draws=64, quantities=named)
    assert [each.name for each in result.quantities[:2]] == [RATIO, "sensors[1].speed"]
    shares = result.to_pandas("sensitivities").loc["impact.velocity"]
    by_name = {each.name: each for each in result.quantities}
    (total,) = (each.total for each in by_name["sensors[1].peak"].sensitivities)
    assert (shares["sensors[1].peak total"], shares["sensors[1].peak total error"]) == (total.value, total.error)
    # a 95 % interval fails once in twenty times, three times that interval practically never
    assert total.value == pytest.approx(1.0, abs=3 * total.error)
    assert {"sensors[0].peak", "sensors[1].arrival", "sensors[1].speed", RATIO} <= by_name.keys()
    (arrival,) = (each for each in by_name["sensors[1].arrival"].sensitivities if each.name == "impact.velocity")
    assert arrival.exponent == pytest.approx(-0.2, abs=0.01)  # t scales as v^(-1/5)
    (peak,) = (each for each in by_name["sensors[1].peak"].sensitivities if each.name == "impact.velocity")
    assert peak.exponent == pytest.approx(1.2, abs=0.01)  # F scales as v^(6/5)
    assert by_name[RATIO].nominal < 1
    assert result.quantities[0].name == RATIO
    assert str(result).startswith("contact 7 first-pulse peak / contact 3 first-pulse peak: mean")
    # like other texts, in units with prefixes
    shown = render_on_screen(result, wide=True)
    assert "  contact 7 first-pulse arrival, us  contact 7 first-pulse width, us  " in shown
    assert f"  {1e6 * by_name['sensors[1].arrival'].nominal:.1f}" in shown


def test_figures_of_a_sensor_on_a_wall_are_not_named_as_those_of_the_run() -> None:
    labels = [each.label for each in targets_of(sensor_figures([Sensor("wall")])).values()]
    assert {"wall impulse", "wall first-pulse impulse", "wall greatest value"} <= set(labels)
    assert len(labels) == len(set(labels))


def test_a_sweep_has_columns_of_sensors_and_of_named_quantities(tmp_path: Path) -> None:
    report = sw.run_sweep(load(tmp_path, BLOCKS + SWEEP), tmp_path / "out", workers=1)
    frame = sw.load_sweep(report.folder).to_pandas()
    ratio = frame["contact_13_peak / contact_3_peak"]
    assert ratio.tolist() == (frame["contact_13_peak"] / frame["contact_3_peak"]).tolist()
    assert ratio.iloc[0] < ratio.iloc[1]
    assert (frame["contact_13_arrival"] < frame["arrival_time"]).all()
    assert (frame["segment_1_energy"] >= 0).all()
    assert "granule_4_velocity_peak" in frame
    assert frame.attrs["units"]["contact_13_speed"] == "m/s"
    results, column = sw.load_sweep(report.folder), "contact_13_peak / contact_3_peak"
    for name in (column, RATIO, RATIO.replace(" ", "")):
        drawn = plot(results, name)
        assert drawn.column == column
        assert drawn.notes[0].startswith(f"{column}: relative error at most")
        assert drawn.ax.get_xlabel().startswith("segment 1 last diameter (mm)")
        pyplot.close(drawn.ax.figure)
    picture = tmp_path / "ratio.svg"
    assert main(["plot", str(report.folder), "--column", RATIO, "-o", str(picture)]) == 0
    assert picture.exists()


def test_an_unknown_quantity_of_a_sweep_is_refused_in_its_place(tmp_path: Path) -> None:
    scenario = load(tmp_path, BLOCKS + SWEEP.replace("arrival_time", "arrival"))
    with pytest.raises(
        sw.InvalidValueError, match=r"sweep.quantities\[2\]: must be a quantity or a ratio of two \(got"
    ):
        sw.run_sweep(scenario, tmp_path / "out", workers=1)


def test_an_unknown_quantity_is_an_error_of_its_option_with_names_of_sensors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "taper.yaml"
    file.write_text(BLOCKS + "uncertainty: {impact.velocity: 5 %}\n")
    assert main(["uncertainty", str(file), "--quantity", "contact_13_sped"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("--quantity: must be a property of the result")
    assert "did you mean 'sensors[1].speed'" in error
