"""A prescribed motion of the first granule: a constant velocity, and records of a base on a shaker."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp, trapezoid
from scipy.interpolate import CubicHermiteSpline, CubicSpline, PchipInterpolator

import shockwave as sw
from shockwave.engine.chain_motion import integrate
from shockwave.scene.layout import Layout
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.contact_setup import ChainSetup
from support.scenario_texts import load

Array = NDArray[np.float64]
LASTS = 2e-4
TIMES = np.linspace(0, LASTS, 41)
SHAPES = {
    "acceleration": 2000 * np.sin(np.pi * TIMES / LASTS),
    "velocity": 0.2 * np.sin(np.pi * TIMES / (2 * LASTS)),
    "displacement": 1e-5 * (1 - np.cos(np.pi * TIMES / LASTS)),
}
MOTIONS = {
    "constant": sw.Motion(velocity=0.2, until=LASTS),
    **{name: sw.Motion(times=TIMES, values=values, quantity=name) for name, values in SHAPES.items()},  # type: ignore[arg-type]
}


def row(granules: int = 6, **features: Any) -> sw.Chain:
    return sw.Chain(material="ptfe", diameter="9.5 mm", granules=granules, **features)


def interpolated(name: str) -> tuple[Any, Any]:
    """Displacement and velocity of a motion, as functions of time, by SciPy."""
    if name == "constant":
        return lambda t: 0.2 * t, lambda t: 0.2 + 0 * t
    if name == "displacement":
        spline = CubicSpline(TIMES, SHAPES[name], bc_type=((1, 0.0), "not-a-knot"))
        return spline, spline.derivative()
    if name == "velocity":
        spline = PchipInterpolator(TIMES, SHAPES[name])
        return spline.antiderivative(), spline
    fine = np.linspace(0, LASTS, 20 * 40 + 1)  # linear between samples: the trapezoidal rule is exact for the velocity
    values = np.interp(fine, TIMES, SHAPES[name])
    speeds = np.append(0.0, np.cumsum((values[1:] + values[:-1]) / 2 * np.diff(fine)))
    hermite = CubicHermiteSpline(fine, speeds, values)  # exact for the parabolas of the velocity
    return hermite.antiderivative(), hermite


def greatest_forces(name: str, chain: sw.Chain, end: float) -> Array:
    """Greatest forces at all contacts, by an independent integration: driven first, then free."""
    plan = Layout.of(chain, MOTIONS[name])
    path, speed = interpolated(name)
    bodies, wall = len(plan.masses), chain.end is not None

    def forces(x: Array, v: Array) -> Array:
        x, v = (np.append(each, 0.0 * each[:1], axis=0).T if wall else each.T for each in (x, v))
        closed = np.maximum(plan.overlaps + x[..., :-1] - x[..., 1:], 0.0)
        damped = plan.damping_coefficients * closed**plan.damping_powers * (v[..., :-1] - v[..., 1:])
        return np.asarray(np.maximum(plan.pairs.stiffnesses * closed**1.5 + damped, 0.0))

    def rates(time: float, state: Array, guided: bool) -> Array:
        x, v = state[:bodies].copy(), state[bodies:].copy()
        if guided:
            x[0], v[0] = path(time), speed(time)
        f = forces(x, v)
        a = (np.append(0.0, f[: bodies - 1]) - np.append(f, [] if wall else 0.0)) / plan.masses
        return np.append(v, np.append(0.0, a[1:]) if guided else a)

    state, most = np.zeros(2 * bodies), np.zeros(len(plan.overlaps))
    for begin, stop, guided in ((0.0, LASTS, True), (LASTS, end, False)):
        run = solve_ivp(
            rates,
            (begin, stop),
            state,
            "DOP853",
            rtol=1e-12,
            atol=1e-18,
            max_step=5e-6,
            dense_output=True,
            args=(guided,),
        )
        times = np.linspace(begin, stop, 8001)
        states = run.sol(times)
        if guided:
            states[0], states[bodies] = path(times), speed(times)
        most = np.maximum(most, forces(states[:bodies], states[bodies:]).max(axis=0))
        state = run.y[:, -1].copy()
        state[0], state[bodies] = (path(stop), speed(stop)) if guided else (state[0], state[bodies])
    return most


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize(
    "features",
    [{}, {"damping": sw.KuwabaraKono(time=2e-6), "end": sw.Wall(material="rigid")}],
    ids=["free", "damped, with a wall"],
)
def test_forces_are_those_of_an_independent_integration(name: str, features: dict[str, Any]) -> None:
    chain = row(**features)
    result = sw.simulate(MOTIONS[name], chain, until=1e-3)
    forces = [peak.peak_force for peak in result.contacts]
    # the reference samples the forces every 0.1 us: a maximum is then exact to 1e-7
    assert forces == pytest.approx(greatest_forces(name, chain, 1e-3).tolist(), rel=1e-6)


@pytest.mark.parametrize("name", MOTIONS)
def test_impulse_and_work_of_the_motion_close_the_balances(name: str) -> None:
    result = sw.simulate(MOTIONS[name], row(end=sw.Wall(mass=5e-3, stiffness=1e5, damping=3.0)), rtol=1e-8)
    assert result.momentum_defect < 1e-12
    assert result.energy_defect < 1e-8


@pytest.mark.parametrize("backend", ["compiled", "numpy"])
def test_the_first_granule_moves_as_prescribed_and_then_flies_free(backend: Any) -> None:
    result = sw.simulate(
        MOTIONS["velocity"], row(), record=["field", "forces"], interval=2e-6, until=4e-4, backend=backend
    )
    histories, (path, speed) = result.recording, interpolated("velocity")
    guided = histories.times <= LASTS
    assert histories.displacements[guided, 0] == pytest.approx(path(histories.times[guided]), rel=1e-12, abs=1e-18)
    assert histories.velocities[guided, 0] == pytest.approx(speed(histories.times[guided]), rel=1e-12, abs=1e-12)
    # the force accelerates the granule and balances that of the contact
    mass, forces = row().granule_mass, histories.applied_force
    needed = mass * speed(histories.times, 1) + histories.forces[:, 0]
    assert forces[guided] == pytest.approx(needed[guided], rel=1e-9, abs=1e-12)
    assert not forces[~guided].any()
    # then the contact alone decelerates it
    after = np.flatnonzero(~guided)[[1, -1]]
    lost = mass * -np.diff(histories.velocities[after, 0])[0]
    impulse = trapezoid(histories.forces[after[0] : after[1] + 1, 0], histories.times[after[0] : after[1] + 1])
    assert lost == pytest.approx(impulse, rel=1e-3)


def test_the_simulated_time_can_end_before_the_motion() -> None:
    early, late = (sw.simulate(MOTIONS["acceleration"], row(), until=until) for until in (1.5e-4, 1e-3))
    assert early.velocities[0] == pytest.approx(float(MOTIONS["acceleration"].course(1.5e-4, 1)), rel=1e-12)
    assert early.momentum_defect < 1e-12
    assert early.contacts[0].peak_force <= late.contacts[0].peak_force


def test_a_history_that_ends_before_the_motion_has_each_sample_once() -> None:
    recording = sw.simulate(MOTIONS["velocity"], row(), record=["field"], interval=1e-5, until=1e-4).recording
    assert recording.displacements.shape == (len(recording.times), 6)


def test_a_long_chain_in_parts_moves_as_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = sw.Scenario.from_dict(
        {
            "chain": {"material": "ptfe", "diameter": 0.0095, "granules": 600},
            "motion": {"velocity": 0.2, "until": 2e-3},
        }
    )
    case = ChainSetup.of(SimulateOptions(), scenario.scene)
    parts = integrate(case.assembly, 1e-8, compiled=case.compiled)
    monkeypatch.setattr("shockwave.engine.chain_domains._LEAST_BODIES", 10_000)
    whole = integrate(case.assembly, 1e-8, compiled=case.compiled)
    assert parts.forces[:500] == pytest.approx(whole.forces[:500], rel=1e-6)
    assert (parts.applied_impulse, parts.work) == pytest.approx((whole.applied_impulse, whole.work), rel=1e-7)


def test_a_constant_velocity_is_a_heavy_piston() -> None:
    # a piston of infinite mass is one that is not slowed down
    piston = sw.Chain(material="ptfe", diameter="9.5 mm", granules=[sw.Segment(count=5)])
    heavy = sw.Impact(velocity=0.2, material=sw.Material(youngs_modulus=1.46e9, poisson_ratio=0.46, density=2.178e13))
    light = sw.simulate(heavy, piston, until=3e-4)
    guided = sw.simulate(sw.Motion(velocity=0.2, until=3e-4), row(6), until=3e-4)
    assert [each.peak_force for each in guided.contacts] == pytest.approx(
        [each.peak_force for each in light.contacts], rel=1e-6
    )


# ---------------------------------------------------------------- files and refusals

SCENE = "chain: {material: ptfe, diameter: 9.5 mm, granules: 6}\nmotion: {file: base.csv, quantity: %s%s}\n"


@pytest.mark.parametrize(
    ("name", "header", "factor"),
    [
        ("acceleration", "time (ms), a (g)", 1 / 9.80665),
        ("velocity", "t [ms], v [mm/s]", 1e3),
        ("displacement", "ms,um", 1e6),
    ],
)
def test_a_record_is_read_with_its_units(tmp_path: Path, name: str, header: str, factor: float) -> None:
    rows = "".join(f"{1e3 * t!r},{factor * x!r}\n" for t, x in zip(TIMES.tolist(), SHAPES[name].tolist(), strict=True))
    (tmp_path / "base.csv").write_text(f"{header}\n{rows}", encoding="utf-8")
    scenario = load(tmp_path, SCENE % (name, ""))
    assert scenario.motion.quantity == name
    assert scenario.motion.values == pytest.approx(MOTIONS[name].values, rel=1e-12)
    assert scenario.files[-1] == tmp_path / "base.csv"
    forces = [sw.simulate(each, scenario.chain).greatest_force.peak_force for each in (scenario.motion, MOTIONS[name])]
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)


@pytest.mark.parametrize(
    ("motion", "features", "problem"),
    [
        ("{velocity: 1}", "", "motion.until: must be given with velocity"),
        ("{until: 1 us}", "", "motion.velocity: must be given with until"),
        ("{}", "", "motion.velocity: must be given with until, or a record"),
        ("{velocity: 1, until: 1 us, quantity: velocity}", "", "motion.quantity: must be left out"),
        ("{times: [0, 1], values: [0, 1]}", "", "motion.quantity: must be given with times"),
        ("{times: [0, 0], values: [0, 1], quantity: velocity}", "", "motion.times: must be finite and ascending"),
        ("{times: [0, 1, 2, 3], values: [1, 1, 1, 1], quantity: displacement}", "", "motion.values: must begin with"),
        ("{velocity: 1, until: 1 us, sign: -1}", "", "motion.sign: must be left out without file"),
        ("{file: base.csv}", "", "motion.quantity: must be given with file"),
        ("{file: ../base.csv, quantity: velocity}", "", "motion.file: must be a file in the scenario's folder"),
        ("{velocity: 1, until: 1 us}", ", precompression: 1", "chain.precompression: must be left out under a motion"),
        ("{velocity: 1, until: 1 us}\nimpact: {velocity: 1}", "", "motion: must be left out if impact is given"),
    ],
)
def test_what_a_motion_excludes_is_refused_in_its_place(motion: str, features: str, problem: str) -> None:
    with pytest.raises(sw.ScenarioError, match=problem):
        sw.Scenario.from_yaml(f"chain: {{material: ptfe, diameter: 9.5 mm, granules: 6{features}}}\nmotion: {motion}\n")


def test_section_4_does_not_cover_a_motion() -> None:
    outcome = sw.predict(MOTIONS["constant"], row())
    assert outcome.section4 is None
    assert "motion" in outcome.section4_reason
    assert outcome.applied_momentum == sw.simulate(MOTIONS["constant"], row()).applied_momentum
    assert outcome.to_dict()["scene"]["motion"] == {"velocity": 0.2, "until": LASTS}


def test_a_motion_is_varied() -> None:
    scenario = sw.Scenario.from_yaml(
        "chain: {material: ptfe, diameter: 9.5 mm, granules: 5}\nmotion: {velocity: 0.1 m/s, until: 200 us}\n"
    )
    design = sw.design(
        scenario, vary={"motion.velocity": ("1 cm/s", "1 m/s")}, target="greatest_force.peak_force = 5 N"
    )
    forces = sw.simulate(sw.Motion(velocity=design.solutions[0].values[0], until=LASTS), scenario.chain)
    assert forces.greatest_force.peak_force == pytest.approx(5.0, rel=2e-3)
