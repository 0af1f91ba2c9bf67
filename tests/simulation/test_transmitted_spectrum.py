"""Spectra of what reaches the structure behind a chain: against histories, their error estimates, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

import shockwave as sw
from shockwave.cli import main
from shockwave.simulation import transmitted_spectrum

pytestmark = pytest.mark.compiled

SHOCK = sw.Shock(profile="half-sine", peak_force="50 N", duration="100 us")
MASS, STIFFNESS, DAMPING = 0.2, 1e6, 50.0
ENDS = {
    "wall": sw.Wall(material="aluminium-6061-t6"),
    "free": None,
    "movable": sw.Wall(material="aluminium-6061-t6", mass=MASS, stiffness=STIFFNESS, damping=DAMPING),
}
FREQUENCIES = {"low": "500 Hz", "high": "20 kHz"}


def simulate(end: str, excitation: sw.Shock | sw.Impact = SHOCK, **options: object) -> sw.Simulation:
    chain = sw.Chain(material="ptfe", diameter="9.5 mm", granules=8, end=ENDS[end])
    return sw.simulate(excitation, chain, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("end", ENDS)
def test_a_spectrum_is_that_of_the_recorded_force(end: str) -> None:
    result = simulate(end, record=["forces"], interval=1e-7, until="1.5 ms")
    spectrum = result.spectrum(mass=None if end == "movable" else MASS, **FREQUENCIES)
    record = result.recording
    accelerations = (record.forces[:, -1] if end == "free" else record.wall_force) / MASS
    if end == "movable":  # the force moves the mass on its spring
        rates = [-STIFFNESS / MASS, -DAMPING / MASS]
        _, accelerations, _ = lsim(([[0, 1], rates], [[0], [1]], [rates], [[1]]), accelerations, record.times)
    expected = sw.shock_spectrum(record.times, accelerations, spectrum.frequencies)
    # the intervals of the spectrum are longer than those of the record
    assert spectrum.error_estimate < 1e-3
    assert spectrum.acceleration == pytest.approx(expected.acceleration, rel=spectrum.error_estimate)
    assert spectrum.pseudo_velocity == pytest.approx(expected.pseudo_velocity, rel=spectrum.error_estimate)


def test_errors_stay_below_their_estimates(monkeypatch: pytest.MonkeyPatch) -> None:
    result = simulate("wall")
    spectrum = result.spectrum(mass=MASS)
    monkeypatch.setattr(transmitted_spectrum, "_AGREED", 1e-5)
    better = result.spectrum(mass=MASS)
    assert better.error_estimate < 1e-5 < spectrum.error_estimate
    changes = np.abs(spectrum.acceleration / better.acceleration - 1)
    assert (changes <= spectrum.errors + better.errors).all()


def test_the_shock_alone_acts_on_the_same_mass() -> None:
    spectrum = simulate("wall").spectrum(mass=MASS, damping=0, low="5 kHz", high="10 kHz")
    assert spectrum.frequencies[12] == pytest.approx(10e3, rel=0.06)
    pulse = np.linspace(0, 1e-4, 4001)
    force = 50 * np.sin(np.pi * pulse / 1e-4)
    expected = sw.shock_spectrum(pulse, force / MASS, spectrum.frequencies, damping=0)
    assert spectrum.input_acceleration == pytest.approx(expected.acceleration, rel=1e-3)
    assert simulate("wall", sw.Impact(velocity="0.5 m/s")).spectrum(mass=MASS).input_acceleration is None


def test_the_shock_alone_moves_a_movable_end_on_its_mounts() -> None:
    frequencies = {"low": "200 Hz", "high": "10 kHz"}  # that of the mounts is 356 Hz
    spectrum = simulate("movable", until="20 ms").spectrum(damping=0, **frequencies)
    times = np.linspace(0, 20e-3, 40001)
    forces = np.where(times < 1e-4, 50 * np.sin(np.pi * times / 1e-4), 0)
    rates = [-STIFFNESS / MASS, -DAMPING / MASS]
    _, accelerations, _ = lsim(([[0, 1], rates], [[0], [1 / MASS]], [rates], [[1 / MASS]]), forces, times)
    expected = sw.shock_spectrum(times, accelerations, spectrum.frequencies, damping=0)
    assert spectrum.input_acceleration == pytest.approx(expected.acceleration, rel=2e-3)
    assert spectrum.input_pseudo_velocity == pytest.approx(expected.pseudo_velocity, rel=2e-3)


#: Excitations without a force on the first granule.
OTHERS = {"impact": "impact: {velocity: 0.1 m/s}", "motion": "motion: {velocity: 0.1 m/s, until: 20 us}"}


@pytest.mark.parametrize("name", OTHERS)
def test_stiff_oscillators_follow_the_force_at_the_last_contact(name: str) -> None:
    chain = "chain: {material: bearing-steel-52100, diameter: 9.5 mm, granules: 8}"
    result = sw.simulate(sw.Scenario.from_yaml(f"{chain}\n{OTHERS[name]}\n"))
    spectrum = result.spectrum(mass=MASS, low="1 MHz", high="1 MHz")
    # the response exceeds the force by the square of the period over its duration
    assert spectrum.acceleration[0] == pytest.approx(result.contacts[-1].peak_force / MASS, rel=1e-2)


def test_the_static_force_is_left_out() -> None:
    chain = sw.Chain(material="ptfe", diameter="9.5 mm", granules=8, end=sw.Wall(), precompression="20 N")
    spectrum = sw.simulate(SHOCK, chain).spectrum(mass=MASS, low="50 kHz", high="50 kHz")
    assert spectrum.acceleration[0] < 3 * 50 / MASS < (20 + 50) * 3 / MASS


def test_motion_at_the_end_of_the_simulated_time_is_a_warning() -> None:
    warnings = simulate("movable", until="0.6 ms").spectrum().warnings
    assert "later motion is left out" in warnings[0]
    assert warnings[0].endswith("(set simulate.until: 3 ms).")
    slow = simulate("movable", until="0.6 ms").spectrum(low="50 Hz").warnings
    assert slow[0].endswith("(set simulate.until: 50 ms).")


@pytest.mark.parametrize(
    ("end", "arguments", "message"),
    [
        ("wall", {}, "mass: must be given for a force"),
        ("movable", {"mass": 1.0}, "mass: must be left out for a movable end"),
        ("wall", {"mass": "1 s"}, "mass: must be a quantity in kg"),
        ("wall", {"mass": 1.0, "low": 10.0, "high": 1.0}, "frequencies: must ascend"),
    ],
    ids=["no-mass", "two-masses", "unit", "order"],
)
def test_wrong_arguments_are_refused(end: str, arguments: dict[str, object], message: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=message):
        simulate(end).spectrum(**arguments)  # type: ignore[arg-type]


def test_endless_chains_and_unreached_ends_have_no_spectrum() -> None:
    with pytest.raises(sw.InvalidValueError, match=r"chain\.granules: must be given for a spectrum"):
        sw.simulate(SHOCK, sw.Chain(material="ptfe", diameter="9.5 mm")).spectrum(mass=MASS)
    # the shorter time is less than the sampling interval
    for until, longer in (("50 us", "100 us"), ("1 us", "2 us")):
        with pytest.raises(sw.NumericalError, match=rf"nothing reaches the structure .*until: {longer}\)"):
            simulate("wall", until=until).spectrum(mass=MASS)


SCENE = """
chain: {material: ptfe, diameter: 9.5 mm, granules: 8, end: {wall: rigid}}
shock: {profile: half-sine, peak_force: 50 N, duration: 100 us}
"""


def test_the_command_writes_a_table(tmp_path, monkeypatch, capsys) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.yaml").write_text(SCENE)
    arguments = ["spectrum", "scene.yaml", "--mass", "2 kg", "--from", "1 kHz", "--to", "2 kHz", "--damping", "3 %"]
    assert main([*arguments, "-o", "s.csv"]) == 0
    answer = capsys.readouterr().out
    assert answer.startswith("greatest response ")
    assert "damping 3 %" in answer
    header, *rows = (tmp_path / "s.csv").read_text().splitlines()
    assert header.startswith("frequency [Hz],acceleration [m/s^2],pseudo_velocity [m/s],errors,input_acceleration")
    assert [float(row.split(",")[0]) for row in (rows[0], rows[-1])] == pytest.approx([1000, 2000])
    for wrong, problem in (("x", "must be a quantity in Hz"), ("3 kHz", "must ascend (got 3000 Hz to 2000 Hz)")):
        assert main([wrong if word == "1 kHz" else word for word in arguments]) == 2
        assert f"--from: {problem}" in capsys.readouterr().err
