"""The engine for elastic-plastic contacts: reference chains, both codes, balances, and what thermodynamics demands."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from attrs import evolve

import shockwave as sw
from shockwave.base.errors import InvalidValueError
from shockwave.engine import chain_domains
from shockwave.engine.chain_assembly import Assembly
from shockwave.engine.chain_forces import FINER
from shockwave.engine.chain_motion import integrate
from shockwave.engine.nystroem_integrators import Pefrl, Rkn64, Rkn86, Rkn1210
from shockwave.engine.nystroem_tableaux import with_velocities
from shockwave.engine.scipy_integrators import Dop853, Radau
from shockwave.scene.elastic_plastic import Curve
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.convergence_runs import runs_of
from support.assemblies import compiled
from support.fixed_steps import runge_kutta
from support.plastic_chains import REFERENCE, plastic, reference_scenario

pytestmark = pytest.mark.compiled

NAMES = list(REFERENCE["cases"])


def setup(name: str, rtol: float, **changes: Any) -> ChainSetup:
    scenario = reference_scenario(name)
    return ChainSetup.of(evolve(scenario.simulate, rtol=rtol, **changes), scenario.scene)


@pytest.mark.skipif(compiled is None, reason="without compiled code it takes long")
@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
@pytest.mark.parametrize("name", NAMES)
def test_reference_chains_are_met(name: str, rtol: float) -> None:
    runs, reference = runs_of(setup(name, rtol)), REFERENCE["cases"][name]
    scales, motion = runs.case.scales, runs.motion
    errors = np.abs(motion.forces * scales.force / reference["peaks"] - 1)
    judged = runs.case.judged_contacts(motion.forces)
    assert (errors[judged] <= reference["trust"] + rtol).all()
    # the reference is good to its trust
    assert (errors <= reference["trust"] + runs.errors).mean() >= 0.95
    count = len(reference["velocities"])
    assert np.abs(motion.v[:count] * scales.velocity - reference["velocities"]).max() < max(10 * rtol, 2e-5)
    assert np.abs(motion.force_times * scales.time - reference["times"]).max() < 1e-2 * scales.time
    assert not runs.missed


MIXED: dict[str, Assembly] = {
    "plain": plastic(6),
    "rate": plastic(5, rate=0.03),
    "gaps": plastic(5, overlaps=-np.linspace(0.0, 0.3, 5)),
    "static": plastic(6, radius=300.0, overlaps=np.full(6, 1.2)),
    "static-rate": plastic(4, radius=300.0, rate=0.03, overlaps=np.full(4, 1.2)),
    "movable-end": plastic(
        5, radius=300.0, inverse_masses=np.append(np.ones(5), 0.1), fixed_wall=False, end_stiffness=0.3, end_damping=0.1
    ),
    "mixed-laws": plastic(
        6,
        radius=300.0,
        rate=0.02,
        some=np.arange(6) % 2 == 0,
        exponents=np.array([1.5, 1.5, 1.5, 2.0, 1.5, 1.5]),
        damping=np.array([0.0, 0.1, 0.0, 0.2, 0.0, 0.1]),
        damping_powers=np.array([0.0, 0.5, 0.0, 0.0, 0.0, 0.5]),
    ),
    "striker": plastic(6, radius=200.0, force=None, velocity=1.0),
}


@pytest.mark.skipif(compiled is None, reason="not compiled")
@pytest.mark.parametrize("name", MIXED)
def test_both_codes_agree(name: str) -> None:
    times = np.linspace(0, 25, 5)
    one, other = (integrate(MIXED[name], 1e-6, until=25.0, times=times, compiled=code) for code in (compiled, None))
    assert (one.steps, one.evaluations) == (other.steps, other.evaluations)
    for key in (
        "forces",
        "force_times",
        "x",
        "v",
        "losses",
        "residual_overlaps",
        "greatest_overlaps",
    ):
        np.testing.assert_allclose(getattr(one, key), getattr(other, key), rtol=1e-10, atol=1e-12, err_msg=key)
    for here, there in zip(one.samples, other.samples, strict=True):
        np.testing.assert_allclose(here, there, rtol=1e-10, atol=1e-12)
    assert (one.residual_overlaps > 0).any()


@pytest.mark.parametrize("name", MIXED)
def test_momentum_and_energy_balance(name: str) -> None:
    chain = MIXED[name]
    motion = integrate(chain, 1e-8, until=25.0, compiled=compiled)
    whole = motion.work + motion.initial_energy
    assert abs(motion.energy_balance) < 1e-6 * whole
    assert (motion.losses >= -1e-9 * whole).all()
    masses = 1 / chain.inverse_masses
    given = motion.applied_impulse + chain.velocity * masses[0]
    taken = motion.last_impulse if chain.fixed_wall else 0.0
    if chain.end_stiffness == 0:
        assert math.fsum((masses * motion.v).tolist()) + taken == pytest.approx(given, abs=1e-7)


@pytest.mark.parametrize("name", ["gaps", "static-rate", "mixed-laws"])
def test_chains_agree_with_fixed_steps(name: str) -> None:
    motion = integrate(MIXED[name], 1e-8, until=12.0, compiled=compiled)
    course = runge_kutta(MIXED[name], 12.0, 0.008)
    # the history of a contact is that at the ends of the steps
    np.testing.assert_allclose(motion.forces, course.forces, rtol=3e-3)
    np.testing.assert_allclose(motion.x, course.x, atol=3e-3 * np.abs(course.x).max())


@pytest.mark.parametrize("rate", [0.0, 0.03])
def test_a_long_chain_in_parts_moves_like_a_whole(rate: float, monkeypatch: pytest.MonkeyPatch) -> None:
    masses = np.random.default_rng(1).uniform(0.5, 2.0, 600)
    chain = plastic(600, rate=rate, radius=300.0, inverse_masses=1 / masses)
    parts = integrate(chain, 1e-7, until=60.0, compiled=compiled)
    monkeypatch.setattr(chain_domains, "_LEAST_BODIES", 1000)
    whole = integrate(chain, 1e-7, until=60.0, compiled=compiled)
    passed = whole.force_times < 50.0
    for key in ("forces", "residual_overlaps", "losses"):
        one, other = (getattr(motion, key)[passed] for motion in (parts, whole))
        np.testing.assert_allclose(one, other, rtol=1e-5, atol=1e-7, err_msg=key)
    assert abs(parts.energy_balance) < 1e-6 * parts.work


@pytest.mark.parametrize(("velocity", "restitution"), [*REFERENCE["restitution"].items()])
def test_restitution_of_two_spheres(velocity: str, restitution: float) -> None:
    material = sw.Material(youngs_modulus=200e9, poisson_ratio=0.3, density=7650.0, yield_strength=1896e6)
    chain = sw.Chain(material=material, diameter=6.35e-3, granules=1, contact=sw.ElasticPlastic())
    result = sw.simulate(sw.Impact(velocity=float(velocity)), chain, rtol=1e-8)
    assert result.restitution == pytest.approx(restitution, abs=1e-8)


def test_an_elastic_contact_among_plastic_ones_is_that_of_hertz() -> None:
    elastic = evolve(plastic(3, strength=math.inf), plastic=None)
    one, other = (integrate(chain, 1e-8, until=15.0) for chain in (plastic(3, strength=math.inf), elastic))
    np.testing.assert_array_equal(one.forces, other.forces)
    assert one.dissipated == 0
    assert one.residual_overlaps is not None
    assert not one.residual_overlaps.any()
    assert other.residual_overlaps is None


@pytest.mark.parametrize("name", ["plain", "static", "mixed-laws"])
def test_energies_in_the_run_are_those_of_runs_that_end_there(name: str) -> None:
    chain, times = MIXED[name], np.array([3.0, 6.0, 11.0])
    motion = integrate(chain, 1e-9, until=12.0, times=times, compiled=compiled)
    potentials = chain.potentials(motion.samples.x, motion.samples.energies)
    for time, potential in zip(times, potentials, strict=True):
        ended = integrate(chain, 1e-9, until=float(time), compiled=compiled)
        np.testing.assert_allclose(potential, ended.potential, atol=1e-6 * max(1.0, np.abs(potential).max()))


@pytest.mark.parametrize("integrator", [Rkn64, Rkn1210, Dop853, Pefrl])
def test_integrators_agree(integrator: Any) -> None:
    chain, accuracy = MIXED["plain"], 1e-9 if integrator.adaptive else 0.01
    one = integrate(chain, 1e-9, until=25.0, compiled=compiled)
    other = integrate(chain, accuracy, until=25.0, compiled=compiled, integrator=integrator)
    np.testing.assert_allclose(one.forces, other.forces, rtol=1e-6)


def test_integrators_that_cannot_step_a_chain_refuse() -> None:
    with pytest.raises(InvalidValueError, match=r"must be rkn64, rkn86 or dop853 .*rate"):
        integrate(MIXED["rate"], 1e-6, integrator=Rkn1210)
    with pytest.raises(InvalidValueError, match="got 'radau', whose steps do not end where plastic flow begins"):
        integrate(MIXED["plain"], 1e-6, integrator=Radau)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [0.0, 0.03])
@pytest.mark.parametrize("number", range(3))
def test_random_chains_agree_with_short_steps(number: int, rate: float) -> None:
    draw = np.random.default_rng(number)
    granules = int(draw.integers(2, 7))
    chain = plastic(
        granules,
        rate=rate,
        radius=10 ** draw.uniform(2.3, 3.0),
        some=draw.random(granules) < 0.8,
        inverse_masses=1 / draw.uniform(0.5, 2.0, granules),
        overlaps=-draw.uniform(0.0, 0.2, granules) * (draw.random(granules) < 0.4),
    )
    motion, course = integrate(chain, 1e-8, until=10.0, compiled=compiled), runge_kutta(chain, 10.0, 2e-3)
    # where flow is rate-dependent, a force has its maximum at a corner, which the ends of the steps miss
    closed = motion.forces > 1e-6
    np.testing.assert_allclose(motion.forces[closed], course.forces[closed], rtol=3e-3 if rate else 5e-5)


def steel(rate: float, granules: int, until: float) -> ChainSetup:
    """A chain of beads of different diameters that flow, at a rigid wall."""
    material = sw.Material(
        youngs_modulus=193e9, poisson_ratio=0.3, density=7860.0, yield_strength=600e6, rate_constant=rate
    )
    diameters = np.random.default_rng(1).uniform(6e-3, 14e-3, granules)
    beads = tuple(sw.Segment(count=1, diameter=each) for each in diameters.tolist())
    chain = sw.Chain(
        material=material, diameter=9e-3, granules=beads, contact=sw.ElasticPlastic(), end=sw.Wall(material="rigid")
    )
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=1000.0, rise_time=20e-6)
    return ChainSetup.of(SimulateOptions(rtol=1e-6, until=until), Scene(excitation=shock, chain=chain))


@pytest.mark.skipif(compiled is None, reason="without compiled code it takes long")
def test_rate_costs_few_steps_and_no_more_stages() -> None:
    costs = []
    for rate in (0.0, 0.025):
        case = steel(rate, 30, 1e-3)
        motion = integrate(case.assembly, 1e-7, until=case.until, compiled=compiled)
        costs.append([motion.steps, motion.evaluations])
    assert costs[1][0] < 1.2 * costs[0][0]
    assert costs[1][1] < 1.2 * costs[0][1]


def test_the_energy_of_a_rate_dependent_chain_is_balanced_to_less_than_the_tolerance() -> None:
    case = steel(0.025, 12, 3e-4)
    motion = integrate(case.assembly, 1e-6, until=case.until, compiled=compiled)
    assert abs(motion.energy_balance) < 2e-8 * motion.work


def test_velocities_of_stages_integrate_polynomials() -> None:
    method = with_velocities(Rkn86.tableau)
    nodes = method.nodes
    for stage in range(2, len(nodes) - 1):
        for power in range(stage):
            values = nodes**power
            values[1] = power == 1  # the derivative at the beginning
            mean = method.velocities[stage] @ values
            assert mean == pytest.approx(nodes[stage] ** (power + 1) / (power + 1), abs=1e-12)
    np.testing.assert_array_equal(method.velocities[-1], method.weights[1])


@pytest.mark.skipif(compiled is None, reason="without compiled code it takes long")
@pytest.mark.parametrize("rate", [0.0, 0.03])
def test_a_precompressed_chain_takes_few_steps(rate: float) -> None:
    # ahead of the wave, forces less the static ones and ends of modes must not be rounding errors
    chain = plastic(60, radius=300.0, rate=rate, overlaps=np.full(60, 1.2), velocity=1.0, force=None)
    assert integrate(chain, 1e-6, until=40.0, compiled=compiled).steps < 3000


def test_the_time_of_a_peak_is_that_of_a_corner() -> None:
    # contact 1 meets the falling loading curve before it turns
    masses = np.random.default_rng(3).uniform(0.3, 3, 20)
    chain = plastic(20, radius=300.0, rate=0.03, inverse_masses=1 / masses)
    one, other = (integrate(chain, each, until=25.0, compiled=compiled) for each in (1e-5, 1e-9))
    np.testing.assert_allclose(one.force_times[1:16], other.force_times[1:16], atol=1e-5)


@pytest.mark.parametrize("strength", [1e-3, 0.01, 0.1])
def test_pieces_are_the_loading_curves_of_a_greater_strength(strength: float) -> None:
    contacts = plastic(1, strength=strength, rate=0.05).plastic
    assert contacts is not None
    pieces, _ = contacts.curves
    grown = np.random.default_rng(0).uniform(0, len(pieces), 200)
    share = (grown % 1)[:, None, None] ** np.arange(pieces.shape[1])[:, None]
    curve = Curve.of(strength * (1 + grown / FINER))
    values = curve.ratio - curve.bend * np.log(curve.first), curve.bend, curve.level, curve.slope
    np.testing.assert_allclose((pieces[grown.astype(int)] * share).sum(1).T, values, rtol=1e-12)
