"""A long bar at the end of a chain: a flat without mass that moves with F/Z."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp, trapezoid

import shockwave as sw

Array = NDArray[np.float64]
BAR = sw.Bar(material="steel-4340", diameter="19 mm")
IMPACT = sw.Impact(velocity=0.5)
END = 3e-4


def row(end: Any = BAR, **features: Any) -> sw.Chain:
    return sw.Chain(material="steel-4340", diameter="9.5 mm", granules=4, end=end, **features)


def reference(chain: sw.Chain) -> tuple[Array, Array, Array]:
    """Times, forces at all contacts and displacement of the flat, by an independent integration."""
    layout = sw.simulate(IMPACT, chain, until=1e-6).scene.layout
    count, resistance, exponent = len(layout.masses), chain.end.resistance, layout.pairs.exponents
    spring, coefficients, powers = layout.pairs.stiffnesses, layout.damping_coefficients, layout.damping_powers

    def forces(state: Array) -> Array:
        x, v = state[:count].T, state[count : 2 * count].T  # of one state, or of many
        closed = np.maximum(layout.overlaps + x - np.concatenate((x[..., 1:], state[-1:].T), axis=-1), 0.0)
        c = np.where(coefficients > 0, coefficients * closed**powers, 0.0)
        total = spring * closed**exponent + c * (v - np.concatenate((v[..., 1:], 0 * state[-1:].T), axis=-1))
        static, slip = layout.static_forces[-1], 1 + c[..., -1] / resistance
        total[..., -1] = static + (total[..., -1] - static) / slip  # the flat moves with the dynamic force over Z
        return np.asarray(np.maximum(total, 0.0))

    def rates(_: float, state: Array) -> Array:
        dynamic = forces(state) - layout.static_forces
        push = np.append(layout.weight, dynamic[:-1])
        return np.concatenate((state[count : 2 * count], (push - dynamic) / layout.masses, [dynamic[-1] / resistance]))

    start = np.zeros(2 * count + 1)
    start[count] = layout.velocity
    run = solve_ivp(rates, (0, END), start, "DOP853", rtol=1e-11, atol=1e-17, max_step=2e-6, dense_output=True)
    times = np.linspace(0, END, 30_001)
    states = run.sol(times)
    return times, forces(states), states[-1]


@pytest.mark.parametrize(
    "features",
    [
        {},
        {"damping": sw.KuwabaraKono(time=2e-6)},
        {"precompression": 30.0},
        {"gravity": 9.81, "damping": sw.Tsuji(restitution=0.8)},
        {"precompression": 30.0, "damping": sw.KuwabaraKono(time=2e-6)},
        {"contact": sw.PowerContact(exponent=2, stiffness=1e12)},
    ],
    ids=["elastic", "damped", "precompressed", "vertical", "precompressed, damped", "power law"],
)
def test_forces_and_energy_are_those_of_an_independent_integration(features: dict[str, Any]) -> None:
    chain = row(**features)
    result = sw.simulate(IMPACT, chain, until=END, rtol=1e-7)
    times, forces, _ = reference(chain)
    # samples every 10 ns: a maximum is then exact to 1e-7
    assert [peak.peak_force for peak in result.contacts] == pytest.approx(forces.max(axis=0).tolist(), rel=1e-6)
    assert result.transmitted.peak_force == pytest.approx(forces[:, -1].max(), rel=1e-6)
    dynamic = forces[:, -1] - result.transmitted.static_force
    assert result.dissipated.bar == pytest.approx(trapezoid(dynamic**2, times) / BAR.resistance, rel=1e-6)
    assert result.transmitted.impulse == pytest.approx(trapezoid(dynamic, times), rel=1e-6)
    assert result.momentum_defect < 1e-12
    assert result.energy_defect < 1e-7


def test_a_static_load_on_a_bar_does_not_move_it() -> None:
    weak = sw.Shock(profile=sw.Triangular(duration_ratio=2), peak_force=1e-3, rise_time=1e-5)
    chain = row(sw.Bar(material="steel-4340", impedance=1e3), precompression=20.0, damping=sw.Dashpot(coefficient=50.0))
    result = sw.simulate(weak, attrs.evolve(chain, granules=40))  # more than there are in the window at first
    assert result.transmitted.peak_force == pytest.approx(20, rel=1e-4)
    assert 0 < result.dissipated.bar < result.dissipated.energy < result.applied_energy


def test_a_stiff_bar_is_a_fixed_wall_and_a_softer_one_takes_less_force() -> None:
    wall = sw.simulate(IMPACT, row(sw.Wall(material="steel-4340")), until=END).transmitted.peak_force
    forces = [
        sw.simulate(IMPACT, row(sw.Bar(material="steel-4340", impedance=z)), until=END).transmitted.peak_force
        for z in (1e8, 1e4, 1e3)
    ]
    assert forces[0] == pytest.approx(wall, rel=1e-4)
    assert forces[0] > forces[1] > forces[2]


def test_the_impedance_of_a_bar_is_that_of_its_section() -> None:
    assert BAR.resistance == pytest.approx(math.pi * 0.0095**2 * math.sqrt(207e9 * 7850), rel=1e-12)
    same = sw.Bar(material="steel-4340", impedance=BAR.resistance)
    assert sw.simulate(IMPACT, row(same), until=END).contacts == sw.simulate(IMPACT, row(), until=END).contacts


def test_the_later_force_on_a_bar_is_bounded() -> None:
    early, late = (sw.simulate(IMPACT, row(), until=until) for until in (5e-5, 1e-3))
    assert late.transmitted.peak_force <= early.leaving.later
    assert early.structure is None
    assert early.end_energy is None


@pytest.mark.parametrize("given", [{}, {"diameter": 1e-2, "impedance": 1.0}], ids=["nothing", "both"])
def test_exactly_one_of_size_and_impedance_is_needed(given: dict[str, Any]) -> None:
    with pytest.raises(sw.InvalidValueError, match="impedance: must be given, or the diameter, but not both"):
        sw.Bar(material="steel-4340", **given)


FILE = "chain: {material: steel-4340, diameter: 9.5 mm, granules: 4, end: {bar: %s}}\nimpact: {velocity: 0.5 m/s}\n"


def test_a_bar_is_read_from_a_file_and_varied() -> None:
    scenario = sw.Scenario.from_yaml(FILE % "{material: steel-4340, diameter: 19 mm}")
    assert scenario.chain.end == BAR
    other = sw.Scenario.from_yaml(FILE % "{material: copper, impedance: 1.1e4 N*s/m}").chain.end
    assert other == sw.Bar(material="copper", impedance=1.1e4)
    assert sw.simulate(scenario, until=END).scene.summary().numbers["chain"]["end"] == {
        "bar": {"material": {"name": "steel-4340", **MATERIAL}, "radius": 0.0095}
    }


MATERIAL = {
    name: getattr(sw.material("steel-4340"), name)
    for name in ("youngs_modulus", "poisson_ratio", "density", "yield_strength", "source")
}


@pytest.mark.parametrize(
    ("bar", "problem"),
    [
        ("{diameter: 1 mm}", r"chain.end.bar.material: must be given"),
        ("{material: steel-4340}", r"chain.end.bar.diameter: must be given .*or give radius or impedance"),
        ("{material: steel-4340, diameter: 1 mm, impedance: 1}", r"chain.end.bar.impedance: must be left out"),
    ],
    ids=["material", "size", "both"],
)
def test_a_wrong_bar_is_refused_in_its_place(bar: str, problem: str) -> None:
    with pytest.raises(sw.ScenarioError, match=problem):
        sw.Scenario.from_yaml(FILE % bar)


def test_the_compiled_code_refuses_a_bar() -> None:
    with pytest.raises(sw.InvalidValueError, match="backend: must be auto or numpy for a bar at the end"):
        sw.simulate(IMPACT, row(), backend="compiled")


def test_a_text_names_the_bar() -> None:
    for result in (sw.simulate(IMPACT, row()), sw.predict(IMPACT, row())):
        assert "bar" in str(result)
        assert "wall" not in str(result)
