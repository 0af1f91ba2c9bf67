"""The engine for chains of mixed granules: reference chains, balances, closed forms, extremes, and both codes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from attrs import evolve, frozen
from scipy.optimize import brentq

import shockwave as sw
from shockwave.base.errors import InvalidValueError, NumericalError, PluginError
from shockwave.base.numerics import FloatArray
from shockwave.engine import chain_domains
from shockwave.engine.chain_assembly import Assembly
from shockwave.engine.chain_motion import ChainMotion, integrate
from shockwave.engine.integrator import Step
from shockwave.engine.nystroem_integrators import Pefrl, Rk4, Rkn64, Rkn86, Rkn1210, Verlet
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.scipy_integrators import Dop853
from shockwave.scene.contact_law import BoundLaw, ContactLaw, Pairs
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.convergence_runs import tolerances_for
from support.assemblies import PULSE, compiled, mixed, uniform
from support.chain_reference import Reference
from support.fixed_steps import runge_kutta
from support.random_chains import scene as random_scene
from support.reference_chains import scenario_of

pytestmark = pytest.mark.compiled

NUMBERS = [0, 1, 2, 3, 6]


def striker(granules: int) -> Assembly:
    """A mixed chain under its weight, which a striker with a weight hits."""
    overlaps = np.append(0.0, np.linspace(0.01, 0.02, granules - 1))
    return mixed(granules, force=None, velocity=0.5, weight=0.02, overlaps=overlaps)


def scaled(name: str) -> tuple[Assembly, float]:
    """The assembly of a reference chain, and the end of its simulated time."""
    scenario = scenario_of(name)
    case = ChainSetup.of(scenario.simulate, scenario.scene)
    assert case.until is not None
    return case.assembly, case.until


def momentum_defect(assembly: Assembly, motion: ChainMotion) -> float:
    masses = 1 / assembly.inverse_masses
    taken = motion.last_impulse if assembly.fixed_wall else 0.0
    given = motion.applied_impulse + assembly.velocity * masses[0]
    return float(abs(math.fsum((masses * motion.v).tolist()) + taken - given))


MIXED = {
    "power": mixed(20, exponent=1.2),
    "precompressed-power": mixed(20, exponent=1.2, overlaps=np.full(20, 0.1)),
    "striker-with-a-weight": striker(8),
    "damped-striker": evolve(striker(8), damping=np.full(8, 0.05), damping_powers=np.full(8, 0.5)),
    "long": mixed(520),
    "movable": uniform(
        4,
        inverse_masses=np.append(np.ones(4), 0.4),
        fixed_wall=False,
        end_stiffness=0.3,
        end_damping=0.1,
        damping=0.1 * np.ones(4),
    ),
}


@pytest.mark.skipif(compiled is None, reason="not compiled")
@pytest.mark.parametrize("name", [*MIXED, "free end, short", "precompressed", "dashpot", "all at once"])
def test_both_codes_agree(name: str) -> None:
    chain, until = (MIXED[name], 40.0) if name in MIXED else scaled(name)
    times = np.linspace(0, until, 7)
    one, other = (integrate(chain, 1e-7, until=until, times=times, compiled=c) for c in (compiled, None))
    assert (one.steps, one.evaluations) == (other.steps, other.evaluations)
    # rounding errors that a thousand steps amplify; powers that differ in the last digit gave 1e-10
    np.testing.assert_allclose(one.forces, other.forces, rtol=1e-12 if "power" in name else 1e-10, atol=1e-12)
    for key in ("force_times", "x", "v", "last_impulse", "extremes"):
        np.testing.assert_allclose(getattr(one, key), getattr(other, key), rtol=1e-10, atol=1e-12, err_msg=key)
    for key in ("rows", "x", "v", "forces", "impulses"):
        here, there = (getattr(motion.samples, key) for motion in (one, other))
        np.testing.assert_allclose(here, there, rtol=1e-10, atol=1e-12, err_msg=key)
    assert one.work == pytest.approx(other.work, rel=1e-12)
    if "striker" in name:
        assert one.rebound == pytest.approx(other.rebound, rel=1e-10)


@pytest.mark.parametrize("code", [None, compiled])
@pytest.mark.parametrize("name", MIXED)
def test_samples_of_some_rows_are_those_of_all_and_their_impulses_balance_the_momenta(name: str, code: Any) -> None:
    chain, times = MIXED[name], np.linspace(0.0, 40.0, 31)
    bodies = len(chain.inverse_masses)
    rows = np.unique([0, 1, bodies // 2, bodies - 1])
    whole = integrate(chain, 1e-7, until=40.0, times=times, compiled=code).samples
    some = integrate(chain, 1e-7, until=40.0, times=times, rows=rows, compiled=code).samples
    for here, there in zip(some[1:5], whole[1:5], strict=True):
        np.testing.assert_allclose(here, there[:, rows], rtol=1e-12, atol=1e-14)
    momenta = np.cumsum(whole.v / chain.inverse_masses, axis=1)
    applied = [chain.weight * time if chain.force is None else chain.force.free(time)[1] for time in times]
    expected = np.array(applied)[:, None] - momenta + chain.velocity / chain.inverse_masses[0]
    np.testing.assert_allclose(whole.impulses, expected, atol=1e-12)


@pytest.mark.skipif(compiled is None, reason="not compiled")
def test_both_codes_make_the_same_steps_where_contacts_open_under_a_static_force() -> None:
    """Rounding then gives the force of an open contact either sign."""
    granules = [sw.Segment(count=16), sw.Segment(count=7, material="ptfe")]
    chain = sw.Chain(material="stainless-steel-302", diameter=9.5e-3, granules=granules, precompression=3.0)
    one, other = (sw.simulate(sw.Impact(velocity=1.0), chain, backend=code).cost for code in ("compiled", "numpy"))
    assert (one.steps, one.force_evaluations) == (other.steps, other.force_evaluations)


@pytest.mark.parametrize("number", NUMBERS)
def test_random_chains_agree_with_scipy(number: int) -> None:
    excitation, chain = random_scene(number, most=24)
    first = sw.simulate(excitation, chain, rtol=1e-4)
    # later collisions amplify the errors of the reference
    until = min(first.end, 15 * first.characteristic_time)
    result = sw.simulate(excitation, chain, rtol=1e-8, until=until)
    expected, _times = Reference(excitation, chain, first.characteristic_time).greatest(until)
    at = np.flatnonzero(expected > 1e-6 * expected.max())
    found = [result.contacts[contact] for contact in at.tolist()]
    errors = np.abs([peak.peak_force - peak.static_force for peak in found] / expected[at] - 1)
    # the reference is good to 1e-9
    assert errors.max() < min(1e-8, max(peak.error_estimate for peak in found) + 1e-9)


@pytest.mark.parametrize(
    ("damping", "power", "stages", "most"),
    [(0.0, 0.0, 9, 1.35), (0.1, 0.0, 12, 1.65), (0.1, 0.25, 12, 1.55), (0.1, 0.5, 12, 1.75)],
    ids=["conservative", "dashpots", "q = 1/4", "q = 1/2"],
)
def test_few_steps_are_repeated_where_contacts_open_and_close(
    damping: float, power: float, stages: int, most: float
) -> None:
    chain = mixed(40, damping=np.full(40, damping), damping_power=power)
    motion = integrate(chain, 1e-8, until=100.0, compiled=compiled)
    # steps that are repeated to end at a kink or at a maximum; linear interpolation of the force gave 1.4 to 2.1
    assert motion.evaluations < most * stages * motion.steps


#: Granules before a wall whose force has a maximum and a minimum in a step of a coarser run: exponent, masses, rise
#: exponent, duration ratio, rise time, end, rtol and the relative error allowed, which are those of the forces.
PAIR = (3, [0.3441218, 2.3242289], 1.0, 1.6024628652045292, 0.5829715548, 7.6, 1e-4, 1e-4)
ALONE = (2, [0.19846434690296877], 0.5, 3.7341573529838183, 0.12742181133878316, 4.448434, 1e-3, 2e-5)


@pytest.mark.parametrize("backend", ["auto", "numpy"])
@pytest.mark.parametrize(
    ("scene", "coefficient"),
    [(PAIR, 0.364), (PAIR, 0.37), (PAIR, 0.376), (PAIR, 0.382), (ALONE, 0.2939666941028608)],
    ids=["0.364", "0.37", "0.376", "0.382", "in-the-same-half"],
)
def test_a_maximum_close_to_a_minimum_is_found(scene: Any, coefficient: float, backend: Any) -> None:
    exponent, masses, rise, ratio, rise_time, until, rtol, error = scene
    radii = [(mass / (1000 * 4 / 3 * math.pi)) ** (1 / 3) for mass in masses]
    chain = sw.Chain(
        material=sw.Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1000.0),
        radius=radii[0],
        granules=[sw.Segment(count=1, radius=radius) for radius in radii],
        end=sw.Wall(),
        contact=sw.PowerContact(exponent=exponent, stiffness=1.0),
        damping=sw.Dashpot(coefficient=coefficient),
    )
    profile = sw.PowerLaw(rise_exponent=rise, decay_exponent=1, duration_ratio=ratio)
    shock = sw.Shock(profile=profile, peak_force=1.0, rise_time=rise_time)
    rough, fine = (sw.simulate(shock, chain, rtol=each, until=until, backend=backend) for each in (rtol, 1e-6 * rtol))
    for one, other in zip(rough.contacts, fine.contacts, strict=True):
        assert one.peak_force == pytest.approx(other.peak_force, rel=error)


LONG: dict[str, dict[str, Any]] = {
    "conservative": {},
    "precompressed": {"overlaps": np.full(520, 0.1)},
    "contacts that open and close again": {"overlaps": np.full(520, 0.01), "damping": np.full(520, 0.1)},
    "exponent 2": {"exponent": 2.0},
    "dashpots": {"damping": np.full(520, 0.1)},
    "viscous": {"damping": np.full(520, 0.1), "damping_power": 0.5},
    "striker that falls back": {
        "force": None,
        "velocity": 0.5,
        "weight": 0.02,
        "overlaps": np.append(0.0, np.full(519, 1e-3)),
    },
}


def test_the_front_of_a_wave_along_a_long_linear_chain_passes_the_ends_of_the_parts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    chain = uniform(530, exponent=1.0, force=None, velocity=1.0)
    parts = integrate(chain, 1e-6, until=80.0, compiled=compiled)
    monkeypatch.setattr(chain_domains, "_LEAST_BODIES", 1000)
    whole = integrate(chain, 1e-6, until=80.0, compiled=compiled)
    np.testing.assert_allclose(parts.forces, whole.forces, atol=1e-8)


@pytest.mark.parametrize("changes", LONG.values(), ids=LONG)
def test_a_long_chain_in_parts_moves_like_a_short_one(changes: dict[str, Any]) -> None:
    # no wave has reached the end of the short one
    times, near = [50.0, 100.0], slice(0, 80)
    short = mixed(200, **{key: each[:200] if isinstance(each, np.ndarray) else each for key, each in changes.items()})
    whole = integrate(short, 1e-11, until=100.0, times=times, compiled=compiled)
    chain = mixed(520, **changes)
    parts = integrate(chain, 1e-9, until=100.0, times=times, compiled=compiled)
    np.testing.assert_allclose(parts.forces[near], whole.forces[near], atol=1e-8)
    # errors of positions add up over a thousand steps
    np.testing.assert_allclose(parts.samples.x[:, near], whole.samples.x[:, near], atol=1e-6)
    assert parts.dissipated == pytest.approx(whole.dissipated, abs=1e-7)
    assert momentum_defect(chain, parts) < 1e-13
    assert abs(parts.energy_balance) < 1e-7


@pytest.mark.parametrize("wall", ["rigid", "movable"])
def test_a_wave_returns_from_the_end_of_a_long_chain(wall: str) -> None:
    # PHYSICS: an isolated wave exerts 2.2383756 times its force on a rigid wall of stiffness 2 sqrt 2
    stiff = np.append(np.ones(399), 2 * math.sqrt(2))
    chain = uniform(400, stiffnesses=stiff, force=ScaledProblem(PULSE.profile, 0.1, 1.0))
    if wall == "movable":
        bodies = np.append(np.ones(400), 1e-12)
        chain = evolve(chain, inverse_masses=bodies, fixed_wall=False, end_stiffness=1.0)
    motion = integrate(chain, 1e-9, compiled=compiled)
    assert motion.forces[-1] / motion.forces[300] == pytest.approx(2.2383756, rel=1e-7)
    # three arrivals: the reflected wave has thrown the first granules back
    assert motion.force_times[-1] == pytest.approx(motion.arrival, rel=1e-9)
    assert motion.v[0] < -0.5 * motion.forces[300] ** 0.5
    assert abs(motion.energy_balance) < 1e-7


# ---------------------------------------------------------------- gravity on a striker


@pytest.mark.parametrize("code", [None, compiled])
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.5])
@pytest.mark.parametrize("velocity", [1e-9, 0.7])
def test_a_striker_falls_while_it_compresses_a_spring(velocity: float, exponent: float, code: Any) -> None:
    chain = uniform(1, exponent=exponent, force=None, velocity=velocity, weight=0.3)
    motion = integrate(chain, 1e-11, until=12.0, compiled=code)
    # from rest it sinks until the energy of the spring is W d: then its force is (p + 1) W
    energy = lambda d: d ** (exponent + 1) / (exponent + 1) - 0.3 * d - velocity**2 / 2  # noqa: E731
    deepest = brentq(energy, 0.3 ** (1 / exponent), 10.0, xtol=1e-14)
    assert motion.forces[0] == pytest.approx(deepest**exponent, rel=1e-10)
    if velocity < 1e-6:
        assert motion.forces[0] == pytest.approx((exponent + 1) * 0.3, rel=1e-8)
    else:
        assert motion.rebound == pytest.approx(velocity, rel=1e-9)  # of the first separation, not after its flight
        assert abs(motion.v[0]) != pytest.approx(velocity, rel=1e-3)
    assert momentum_defect(chain, motion) < 1e-12
    assert abs(motion.energy_balance) < 1e-10


@pytest.mark.parametrize("ratio", [1e-9, 1.0, 1e6])
def test_precompression_loses_no_digits(ratio: float) -> None:
    # a weak wave in a strongly compressed chain obeys linear equations: its forces scale with the pulse
    static = ratio ** (2 / 3)
    chain = uniform(20, overlaps=np.full(20, static))
    fine, finer = (integrate(chain, each, until=20 / (1 + static) ** 0.25, compiled=compiled) for each in (1e-9, 1e-12))
    arrived = finer.dynamic_forces > 1e-9 * finer.dynamic_forces.max()
    np.testing.assert_allclose(fine.dynamic_forces[arrived], finer.dynamic_forces[arrived], rtol=1e-8)


EXTREMES = {
    **{
        f"mass {ratio:g}": uniform(20, inverse_masses=1 / np.where(np.arange(20) == 9, ratio, 1.0))
        for ratio in (1e-3, 1e9)
    },
    **{
        f"stiffness {ratio:g}": uniform(20, stiffnesses=np.where(np.arange(20) == 9, ratio, 1.0))
        for ratio in (1e-6, 1e3)
    },
    **{f"exponent {p:g}": uniform(20, exponent=p) for p in (1.05, 6.0)},
    **{f"dashpot {c:g}": uniform(20, damping=np.full(20, c)) for c in (1e-6, 100.0)},
    **{f"tsuji {c:g}": uniform(20, damping=np.full(20, c), damping_power=0.25) for c in (1e-6, 100.0)},
    "gap": uniform(20, overlaps=np.where(np.arange(20) == 9, -1e3, 0.0)),
    "one granule": uniform(1),
}


@pytest.mark.parametrize("chain", EXTREMES.values(), ids=EXTREMES)
def test_extremes_are_within_their_bounds(chain: Assembly) -> None:
    fine, coarse = (integrate(chain, each, until=60.0, compiled=compiled) for each in tolerances_for(1e-6))
    finest = integrate(chain, 1e-11, until=60.0, compiled=compiled)
    arrived = finest.dynamic_forces > 1e-9 * finest.dynamic_forces.max()
    np.testing.assert_allclose(fine.dynamic_forces[arrived], finest.dynamic_forces[arrived], rtol=1e-6)
    np.testing.assert_allclose(coarse.dynamic_forces[arrived], finest.dynamic_forces[arrived], rtol=1e-5)


@pytest.mark.parametrize("code", [None, compiled])
def test_a_run_ends_when_all_granules_fly_apart_before_a_wave_arrives(code: Any) -> None:
    # the last granule is so light that no wave reaches it
    masses = np.array([1.0, 1.0, 1e-4])
    chain = uniform(2, inverse_masses=1 / masses, fixed_wall=False)
    motion = integrate(chain, 1e-6, compiled=code)
    assert motion.arrival is None
    assert np.all(np.diff(motion.v) > 0)


def test_integrators_that_cannot_step_a_chain_refuse() -> None:
    with pytest.raises(InvalidValueError, match="must be dop853 for a chain with damping"):
        integrate(uniform(5, damping=np.ones(5)), 1e-6, integrator=Rkn64)


@pytest.mark.parametrize("integrator", [Rkn64, Rkn1210, Dop853])
def test_integrators_agree(integrator: Any) -> None:
    own = integrate(uniform(5), 1e-9, until=20.0, compiled=compiled)
    other = integrate(uniform(5), 1e-9, until=20.0, compiled=compiled, integrator=integrator)
    assert other.integrator == integrator.name
    np.testing.assert_allclose(other.forces, own.forces, rtol=1e-7)


@pytest.mark.skipif(compiled is None, reason="not compiled")
@pytest.mark.parametrize("method", [Verlet, Pefrl, Rk4], ids=lambda method: method.name)
def test_both_codes_take_the_same_fixed_steps(method: Any) -> None:
    one, other = (integrate(mixed(20), 0.05, until=25.0, compiled=code, integrator=method) for code in (compiled, None))
    # where the force has a kink or a contact closes, a step is divided
    assert 500 < one.steps == other.steps < 600
    assert one.evaluations == other.evaluations
    np.testing.assert_allclose(one.x, other.x, rtol=1e-12)


@pytest.mark.parametrize("method", [Verlet, Rk4], ids=lambda method: method.name)
@pytest.mark.parametrize("code", [None, compiled])
def test_a_fixed_step_that_is_too_long_is_an_error(method: Any, code: Any) -> None:
    stiff = uniform(3, stiffnesses=np.full(3, 1e6), overlaps=np.full(3, 1.0))
    with pytest.raises(NumericalError, match=r"because of the fixed step of 1 |use a smaller step"):
        integrate(stiff, 1.0, until=1e4, compiled=code, integrator=method)


def broken(name: str) -> type[Rkn86]:
    """An integrator whose third step violates the contract."""

    def steps(self: Any, *arguments: Any) -> Iterator[Step]:
        for number, step in enumerate(Rkn86.steps(self, *arguments)):
            if number != 2:
                yield step
            elif name != "ends":
                wrong = {"nan": {"x": np.nan * step.x}, "late": {"end": step.end + 99}, "still": {"end": step.begin}}
                yield evolve(step, **wrong[name])
            else:
                return

    return type("Broken", (Rkn86,), {"name": "broken", "steps": steps, "__module__": __name__})


@pytest.mark.parametrize("name", ["nan", "late", "still", "ends"])
def test_steps_that_violate_the_contract_are_an_error_of_the_plugin(name: str) -> None:
    with pytest.raises(PluginError, match=r"integrator .*Broken: must yield finite steps without gaps up to until"):
        integrate(uniform(4), 1e-6, until=10.0, integrator=broken(name))


def test_laws_that_change_along_the_chain_are_those_of_each_contact() -> None:
    exponents, powers = np.repeat([1.5, 2.0, 1.2], 4), np.repeat([0.5, 0.0, 0.25], 4)
    chain = evolve(uniform(12), exponents=exponents, damping=np.repeat([0.1, 0.0, 0.2], 4), damping_powers=powers)
    one, other = (integrate(chain, 1e-8, until=40.0, compiled=code) for code in (compiled, None))
    assert one.steps == other.steps
    np.testing.assert_allclose(one.forces, other.forces, rtol=1e-11)
    # fixed steps pass the opening of contacts, and the ends of steps miss the maxima
    np.testing.assert_allclose(one.forces, runge_kutta(chain, 40.0, 0.01).forces, rtol=1e-4)
    assert abs(one.energy_balance) < 1e-7 * one.work


@frozen
class Copy(ContactLaw):
    """Hertz's law as that of a plugin."""

    def force(self, overlap: FloatArray, closing_velocity: FloatArray, state: FloatArray, pairs: Pairs) -> FloatArray:
        return pairs.stiffnesses * np.maximum(overlap, 0.0) ** 1.5


def test_a_law_of_a_plugin_stands_beside_power_laws() -> None:
    chain = mixed(8, damping=np.full(8, 0.05), damping_power=0.5)
    some = np.arange(8) % 3 == 0
    chain = evolve(chain, damping=np.where(some, 0.0, chain.damping))
    pairs = Pairs(*np.ones((4, 8)), exponents=np.full(8, 1.5))
    by_law = evolve(chain, law=BoundLaw(Copy(), pairs, 1.0, 1.0, 1.0), law_contacts=some)
    one, other = (integrate(each, 1e-8, until=20.0) for each in (chain, by_law))
    np.testing.assert_allclose(one.forces, other.forces, rtol=1e-8)
    # the energies of such contacts are not known, and count as dissipated
    assert abs(other.energy_balance) < 1e-6 * other.work
    assert other.potential[some].tolist() == [0.0] * 3
