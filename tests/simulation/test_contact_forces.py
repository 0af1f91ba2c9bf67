"""Results of chains beyond equal spheres: reference results, errors, balances, texts, documents and histories."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest
from scipy.integrate import trapezoid

import shockwave as sw
from shockwave.engine import backend, chain_motion
from shockwave.engine.chain_arrays import Forecast
from shockwave.scene.chain_end import Wall
from shockwave.scene.contact_law import PowerContact
from shockwave.scene.damping import Dashpot, KuwabaraKono, Tsuji
from shockwave.scene.impact import Impact
from shockwave.scene.segments import Segment
from shockwave.simulation.recording import Recording
from shockwave.simulation.simulation_result import Simulation
from support.chain_reference import Reference
from support.reference_chains import CASES, simulated
from support.scenes import CHAIN, power, triangle

# Wall forces of the reference are accurate to this, relative to the force.
WALL_TRUST = 1e-6
# Times of the reference are interpolated between its steps [s].
TIME_TRUST = 5e-12
NAMES = sorted(CASES)
#: Chains beyond equal granules.
FEATURED = [name for name in NAMES if name != "free end, short"]


# ---------------------------------------------------------------- reference results


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("name", NAMES)
def test_a_reference_result_is_met_within_the_tolerance(name: str, rtol: float) -> None:
    case, result = CASES[name], simulated(name, rtol)
    document = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    found = {peak["contact"]: peak for peak in document["contacts"]}
    assert list(found) == [peak["contact"] for peak in case["contacts"]]
    for peak in case["contacts"]:
        own = found[peak["contact"]]
        dynamic = peak["peak_force"] - own["static_force"]
        error = abs(own["peak_force"] - peak["peak_force"]) / dynamic
        assert error < max(rtol, case["trust"])
        assert error < own["error_estimate"] + case["trust"] * peak["peak_force"] / dynamic
        scale = result.characteristic_time
        assert abs(own["time"] - peak["time"]) < 10 * rtol * scale + TIME_TRUST
    if "transmitted" not in case:
        assert document["transmitted"] is None
        return
    wall = case["transmitted"]
    assert document["transmitted"]["peak_force"] == pytest.approx(wall["peak_force"], rel=max(rtol, WALL_TRUST))
    assert document["transmitted"]["impulse"] == pytest.approx(wall["impulse"], rel=max(10 * rtol, WALL_TRUST))
    # the final state is not controlled; collisions amplify its errors
    velocities, expected = document["velocities"][: len(case["velocities"])], case["velocities"]
    assert velocities == pytest.approx(expected, abs=100 * max(rtol, 1e-7) * max(map(abs, expected)))


@pytest.mark.parametrize("name", FEATURED)
def test_momentum_and_energy_are_balanced(name: str) -> None:
    result = simulated(name, 1e-6)
    # rounding; the error of the integration
    assert result.momentum_defect < 1e-13
    assert result.energy_defect < 3e-6
    stored = math.fsum(segment.energy for segment in result.segments)
    defect = result.energy_defect + 1e-12
    assert stored + result.dissipated.energy == pytest.approx(result.applied_energy, rel=defect)


# ---------------------------------------------------------------- results as objects and documents


WALLED = sw.Chain(material=CHAIN.material, radius=CHAIN.radius, granules=6, end=Wall())
SHOCK = triangle(1.0)


@cache
def walled(**options: Any) -> Simulation:
    return sw.simulate(SHOCK, WALLED, **options)


def test_the_impulse_on_the_wall_of_a_long_chain_has_an_estimate_of_its_own() -> None:
    cell = [sw.Segment(), sw.Segment(material=sw.material("ptfe"))]
    granules = [sw.Cell(repeat=35, cell=cell)]
    chain = sw.Chain(material=sw.material("stainless-steel-302"), diameter=9e-3, granules=granules, end=Wall())
    rough = sw.simulate(sw.Impact(velocity=0.5), chain, rtol=1e-4)
    fine = sw.simulate(sw.Impact(velocity=0.5), chain, rtol=1e-7, until=rough.end)
    error = abs(rough.transmitted.impulse / fine.transmitted.impulse - 1)
    # the late collisions of a chain of two materials amplify the errors of the impulse, not those of the force
    assert rough.transmitted.error_estimate < error <= rough.transmitted.impulse_error


def test_results_that_may_change_later_have_warnings() -> None:
    early = sw.simulate(SHOCK, WALLED, until=walled().arrival_time)
    assert any("acts on the wall at the end of the simulated time" in warning for warning in early.warnings)
    assert walled().warnings == ()
    # the striker rebounds slowly, and the wave that the wall reflects will follow it
    followed = sw.simulate(Impact(velocity=0.5), WALLED, until=1e-4)
    assert any("its restitution is provisional" in warning for warning in followed.warnings)
    free = sw.simulate(Impact(velocity=0.5, radius=CHAIN.radius / 2), attrs.evolve(WALLED, end=None))
    assert free.restitution is not None
    assert free.warnings == ()


def test_a_tolerance_that_is_not_met_has_a_warning() -> None:
    # rounding of hundreds of steps
    result = sw.simulate(SHOCK, attrs.evolve(WALLED, granules=160), rtol=1e-13, contacts=range(0, 160, 5))
    assert any(warning.startswith("The tolerance was not met") for warning in result.warnings)


def test_a_granule_that_follows_the_striker_makes_its_restitution_provisional() -> None:
    # the second granule crosses a gap, rebounds from a heavy one, and is faster than the striker
    segments = [Segment(), Segment(gap=1e-5), Segment(diameter=40e-3)]
    chain = sw.Chain(material="stainless-steel-302", diameter=9.5e-3, granules=segments)
    early, late = (sw.simulate(Impact(velocity=0.5), chain, until=until) for until in (1e-4, 3e-4))
    assert any("its restitution is provisional" in warning for warning in early.warnings)
    assert late.restitution > 2 * early.restitution
    assert not any("provisional" in warning for warning in late.warnings)


def test_a_striker_that_goes_on_has_no_restitution() -> None:
    # it is heavier than the granule in front of it, which crosses a gap until then
    chain = attrs.evolve(WALLED, granules=[Segment(gap=1e-4), Segment()])
    result = sw.simulate(Impact(velocity=0.5, radius=1.5 * CHAIN.radius), chain, until=8e-5)
    assert 0 < result.velocities[0] < 0.5 < result.velocities[1]
    assert result.restitution is None


@pytest.mark.parametrize(("velocity", "doubtful"), [(50.0, False), (60.0, True)])
def test_overlaps_beyond_a_tenth_of_the_radius_have_a_warning(velocity: float, doubtful: bool) -> None:
    result = sw.simulate(Impact(velocity=velocity), attrs.evolve(CHAIN, granules=2))
    assert any("Hertz's law holds for small overlaps only" in warning for warning in result.warnings) == doubtful


def test_a_chain_without_limits_has_the_keys_of_a_chain_with_limits() -> None:
    document = walled().to_dict()
    equal = sw.simulate(SHOCK, attrs.evolve(CHAIN, granules=6)).to_dict()
    assert set(document) == set(equal)
    assert document["peak_force"] is None
    assert document["amplification"] is None
    assert document["waves"] == []
    assert document["error_estimate"] == max(peak["error_estimate"] for peak in document["contacts"])


def test_all_contacts_are_reported_unless_some_are_requested() -> None:
    assert [peak.contact for peak in walled().contacts] == [0, 1, 2, 3, 4, 5]
    assert [peak.contact for peak in walled(contacts=(4, 1)).contacts] == [1, 4]
    assert walled(contacts=(1,)).greatest_force == walled().greatest_force


def test_a_thousand_contacts_of_a_longer_chain_are_reported() -> None:
    chain = attrs.evolve(WALLED, granules=1500)
    contacts = [peak.contact for peak in sw.simulate(SHOCK, chain, until=1e-4).contacts]
    assert len(contacts) == 1000
    assert (contacts[0], contacts[-1]) == (0, 1499)
    assert set(np.diff(contacts)) == {1, 2}


def test_contacts_that_stay_open_have_no_force() -> None:
    result = sw.simulate(SHOCK, attrs.evolve(WALLED, granules=60), until=1e-4)
    assert result.arrival_time is None
    last = result.contacts[-1]
    assert (last.peak_force, last.time, last.error_estimate) == (0.0, 0.0, 0.0)
    assert result.transmitted.peak_force == 0.0
    assert "no force" in str(result)


@pytest.mark.parametrize("backend", ["auto", "numpy"])
def test_the_simulated_time_is_that_of_the_shock_and_three_arrivals(backend: str) -> None:
    arrival = walled(backend=backend).arrival_time
    assert walled(backend=backend).end == pytest.approx(SHOCK.duration + 3 * arrival, rel=1e-6)
    assert walled(backend=backend, until=1e-4).end == pytest.approx(1e-4, rel=1e-12)


@pytest.mark.parametrize("holds", [{"stiffness": 1e18}, {"damping": 1e15}], ids=["spring", "dashpot"])
def test_a_wall_that_hardly_moves_is_fixed(holds: dict[str, float]) -> None:
    fixed, held = (
        sw.simulate(SHOCK, attrs.evolve(WALLED, end=sw.Wall(material="rigid", **wall)))
        for wall in ({}, {"mass": 1e-3, **holds})
    )
    assert held.transmitted == fixed.transmitted
    assert any("integrated as a fixed one" in warning for warning in held.warnings)
    assert not any("integrated as a fixed one" in warning for warning in fixed.warnings)


@pytest.mark.parametrize(
    ("mass", "stiffness", "static"),
    [
        (1e-6, 1e10, {}),
        (1e-3, 1e13, {}),
        (1e-3, 1e12, {"precompression": 1.0}),
        (1e-6, 1e12, {"gravity": 9.81}),
    ],
    ids=["light", "heavy", "pressed", "weight"],
)
def test_a_wall_that_oscillates_ahead_of_the_wave_does_not_end_the_simulated_time(
    mass: float, stiffness: float, static: dict[str, float]
) -> None:
    chain = attrs.evolve(WALLED, end=sw.Wall(material="rigid", mass=mass, stiffness=stiffness), **static)
    rigid = sw.simulate(SHOCK, attrs.evolve(WALLED, end=sw.Wall(material="rigid"), **static))
    # the wall gives way by a part in a thousand of the overlap at most
    assert sw.simulate(SHOCK, chain, rtol=1e-4).end == pytest.approx(rigid.end, rel=1e-3)


def test_a_wall_counts_as_fixed_only_if_its_motion_changes_no_force_by_more_than_the_tolerance() -> None:
    walls = [sw.Wall(material="rigid", mass=1e-3, stiffness=stiffness) for stiffness in (1e13, 1e14, 1e15)]
    forces = [sw.simulate(SHOCK, attrs.evolve(WALLED, end=wall), rtol=1e-4).transmitted.peak_force for wall in walls]
    exact = sw.simulate(SHOCK, attrs.evolve(WALLED, end=sw.Wall(material="rigid"))).transmitted.peak_force
    assert forces == pytest.approx([exact] * 3, rel=1e-4)


def test_a_wall_that_a_heavy_striker_moves_is_not_fixed() -> None:
    contact, wall = PowerContact(exponent=10, stiffness=1e36), sw.Wall(mass=10.0, stiffness=1e10)
    chain = attrs.evolve(CHAIN, radius=1e-3, granules=4, contact=contact, end=wall)
    impact = sw.Impact(velocity=1.0, radius=0.5)
    loose, exact = (sw.simulate(impact, chain, rtol=rtol).transmitted.peak_force for rtol in (1e-4, 1e-7))
    assert loose == pytest.approx(exact, rel=1e-4)


HOPELESS: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "dashpot of a light wall": ({"end": sw.Wall(mass=1e-3, damping=1e10)}, {}, "chain.end.damping"),
    "dashpots": ({"damping": sw.Dashpot(coefficient=1e12)}, {}, "chain.damping"),
    "viscous contacts": ({"damping": KuwabaraKono(time=1e6)}, {}, "chain.damping"),
    "simulated time": ({"precompression": 2.0}, {"until": 1e4}, "simulate.until"),
}


@pytest.mark.slow
@pytest.mark.parametrize(("features", "options", "key"), HOPELESS.values(), ids=HOPELESS)
def test_an_integration_that_would_take_minutes_is_refused_at_once(
    features: dict[str, Any], options: dict[str, Any], key: str
) -> None:
    with pytest.raises(sw.NumericalError, match=rf"would take about .* steps because of {key}.*set a timeout"):
        sw.simulate(SHOCK, attrs.evolve(WALLED, **features), **options)


def test_the_work_of_a_run_is_estimated_from_its_second_half() -> None:
    forecast = Forecast(until=1000.0, most_work=100.0, cause=lambda: "the scene")
    forecast.check(time=1.0, work=9.0, steps=9)  # too early
    with pytest.raises(sw.NumericalError, match="steps because of the scene"):
        forecast.check(time=1.2, work=20.0, steps=20)
    # short steps at the beginning do not count
    forecast = Forecast(until=100.0, most_work=100.0, cause=lambda: "the scene")
    forecast.check(time=1e-6, work=9.0, steps=9)
    forecast.check(time=50.0, work=20.0, steps=20)


@pytest.mark.skipif(backend.compiled is None, reason=backend.lack())
def test_short_steps_of_a_collision_do_not_count_for_the_free_flight_after_it(monkeypatch: pytest.MonkeyPatch) -> None:
    # the collision takes about half of the work that is allowed here
    monkeypatch.setattr(chain_motion, "_WORK", 2e8)
    monkeypatch.setattr(chain_motion, "_WORK_PER_BODY", 0.0)
    chain = attrs.evolve(CHAIN, radius=2e-4, granules=3, end=sw.Wall())
    result = sw.simulate(sw.Impact(velocity=0.1, radius=0.05), chain, until=10.0)
    # nothing is dissipated, and the beads are light
    assert result.restitution == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("backend", ["auto", "numpy"])
@pytest.mark.parametrize("timeout", [0.01, 0.05])
def test_the_time_limit_ends_a_simulation(timeout: float, backend: Any) -> None:
    # also within one of the parts in which a long chain is integrated
    with pytest.raises(sw.NumericalError, match="time limit"):
        sw.simulate(SHOCK, attrs.evolve(WALLED, granules=2000), rtol=1e-10, timeout=timeout, backend=backend)


# ---------------------------------------------------------------- chains of equal granules


def test_contacts_of_equal_granules_with_free_ends() -> None:
    shock = power(0.5)
    result = sw.simulate(shock, attrs.evolve(CHAIN, granules=9))
    assert [peak.contact for peak in result.contacts] == list(range(8))
    top = max(result.contacts, key=lambda peak: peak.peak_force)
    # the tolerance
    assert top.peak_force == pytest.approx(result.greatest_force.peak_force, rel=1e-6)
    assert top.contact == result.greatest_force.contact


@pytest.mark.parametrize("method", [{"integrator": "dop853"}, {"integrator": "verlet", "step": 0.01}])
def test_the_integrator_of_the_waves_integrates_the_contacts(method: dict[str, Any]) -> None:
    chain, shock = attrs.evolve(CHAIN, granules=9), power(0.5)
    own, usual = sw.simulate(shock, chain, **method).contacts, sw.simulate(shock, chain).contacts
    assert own != usual
    assert [peak.peak_force for peak in own] == pytest.approx([peak.peak_force for peak in usual], rel=1e-4)


def test_a_fixed_step_is_that_of_the_runs_and_a_large_one_is_warned_of() -> None:
    shock, chain = power(0.5), attrs.evolve(CHAIN, granules=6, end=sw.Wall(material="same"), precompression=0.5)
    fine, coarse = (sw.simulate(shock, chain, integrator="verlet", step=step) for step in (0.01, 0.5))
    exact = sw.simulate(shock, chain, rtol=1e-8)
    for result in (fine, coarse):
        assert (result.rtol, result.integrator) == (None, "verlet")
        assert abs(result.greatest_force.peak_force / exact.greatest_force.peak_force - 1) < result.error_estimate
    assert fine.error_estimate < 1e-3
    warning = "The step of 0.5 is too large for verlet"
    assert [any(warning in each for each in result.to_dict()["warnings"]) for result in (fine, coarse)] == [False, True]


def test_forces_at_the_contacts_of_a_very_long_chain_need_an_end_of_the_simulated_time() -> None:
    chain = attrs.evolve(CHAIN, granules=10**6)
    result = sw.simulate(power(0.5), chain, waves="primary")
    assert result.contacts == ()
    assert "set until or a timeout" in result.to_dict()["warnings"][-1]


# ---------------------------------------------------------------- strikers, ends and materials


@pytest.mark.parametrize("law", [None, PowerContact(exponent=2.0, stiffness=1e10)], ids=["hertz", "power"])
def test_a_collision_of_two_equal_spheres(law: PowerContact | None) -> None:
    chain = attrs.evolve(WALLED, granules=[Segment()], end=None, contact=law)
    result = sw.simulate(Impact(velocity=0.5), chain, rtol=1e-8)
    p, k = (1.5, chain.contact_stiffness) if law is None else (law.exponent, law.stiffness)
    # two equal masses: the greatest overlap stores half the kinetic energy, k d^(p + 1)/(p + 1) = m v^2/4
    overlap = ((p + 1) / 4 * chain.granule_mass * 0.5**2 / k) ** (1 / (p + 1))
    assert result.greatest_force.peak_force == pytest.approx(k * overlap**p, rel=1e-8)
    assert result.restitution == pytest.approx(1.0, rel=1e-8)
    assert result.spall_velocities == pytest.approx([0.5], rel=1e-8)


def test_a_striker_rebounds_with_the_restitution_of_tsuji() -> None:
    chain = attrs.evolve(WALLED, granules=[Segment()], end=None, damping=Tsuji(restitution=0.6))
    # the tolerance
    result = sw.simulate(Impact(velocity=0.3), chain)
    assert result.restitution == pytest.approx(0.6, rel=1e-6)
    # two equal spheres: the first goes on with half of the difference of the velocities
    assert result.striker.velocity == result.velocities[0] == pytest.approx(0.3 * (1 - 0.6) / 2, rel=1e-6)
    assert result.striker.restitution == result.restitution
    assert sw.simulate(SHOCK, CHAIN).striker is None


def test_a_movable_wall_keeps_its_share_of_the_energy() -> None:
    result = sw.simulate(SHOCK, attrs.evolve(WALLED, end=Wall(mass=5e-3, stiffness=1e5)))
    stored = math.fsum([*(segment.energy for segment in result.segments), result.end_energy])
    assert stored == pytest.approx(result.applied_energy, rel=1e-6)
    assert result.momentum_defect < 1e-13
    damped = sw.simulate(SHOCK, attrs.evolve(WALLED, end=Wall(mass=5e-3, damping=50.0)))
    assert damped.dissipated.energy > 0
    assert damped.energy_defect < 1e-6


def test_static_forces_are_part_of_the_forces() -> None:
    chain = attrs.evolve(WALLED, precompression=2.0, gravity=9.81)
    result = sw.simulate(SHOCK, chain)
    static = [2.0 + 9.81 * chain.granule_mass * (contact + 1) for contact in range(6)]
    assert [peak.static_force for peak in result.contacts] == pytest.approx(static, rel=1e-12)
    assert all(peak.peak_force > peak.static_force for peak in result.contacts)
    assert result.spall_velocities is None
    assert result.recoil_momentum is None


DROP = """
chain:
  material: bearing-steel-52100
  diameter: 20 mm
  gravity: 9.81 m/s**2
  granules:
    - {count: 1, diameter: 60 mm, material: {youngs_modulus: 10 MPa, poisson_ratio: 0.49, density: 1100 kg/m**3}}
    - {count: 1}
  end: {wall: carbon-steel-1020, mass: 2 kg, stiffness: 5e7 N/m, damping: 500 N*s/m}
impact: {velocity: 2.426 m/s, diameter: 106.7 mm, material: carbon-steel-1020}
simulate: {until: 30 ms}
"""


def test_a_drop_weight_on_a_pad_agrees_with_scipy(tmp_path: Path) -> None:
    file = tmp_path / "drop.yaml"
    file.write_text(DROP, encoding="utf-8")
    scene = sw.load_scenario(file)
    result = sw.simulate(scene, contacts=[0])
    later = 1.02 * max(result.transmitted.time, result.contacts[0].time)
    dynamic, _times = Reference(scene.excitation, scene.chain, result.characteristic_time).greatest(later, 1e3)
    assert result.transmitted.peak_force - result.transmitted.static_force == pytest.approx(dynamic[-1], rel=1e-6)
    assert result.contacts[0].peak_force == pytest.approx(dynamic[0], rel=1e-6)
    # the impulse of the drop weight, and of its weight until it leaves
    mass, gravity = 4 / 3 * math.pi * 0.05335**3 * scene.excitation.material.density, 9.81
    assert result.applied_momentum == pytest.approx(mass * (2.426 + gravity * 0.03), rel=1e-9)
    assert result.momentum_defect < 1e-9
    assert result.energy_defect < 1e-6
    assert 0.98 < result.restitution < 1  # the dashpot of the wall takes little


def test_a_drop_weight_that_comes_to_rest_leaves_a_complete_impulse() -> None:
    chain = sw.Chain(
        material="ptfe",
        diameter=0.02,
        granules=1,
        end=sw.Wall(material="rigid"),
        gravity=9.81,
        damping=sw.Dashpot(coefficient=3000.0),
    )
    result = sw.simulate(sw.Impact(velocity=0.05, diameter=0.1, material="carbon-steel-1020"), chain, until=0.05)
    assert not any("impulse is incomplete" in warning for warning in result.warnings)


def test_first_yield_is_that_of_the_softest_contact() -> None:
    steel = attrs.evolve(CHAIN.material, yield_strength=6e8)
    soft = attrs.evolve(CHAIN.material, yield_strength=3e8)
    chain = attrs.evolve(WALLED, material=steel, granules=[Segment(count=3), Segment(count=2, material=soft)])
    result = sw.simulate(SHOCK, chain)
    modulus = chain.plane_strain_modulus / 2
    first = math.pi**3 * (chain.radius / 2) ** 2 * (1.6 * 3e8) ** 3 / (6 * modulus**2)
    assert result.yielding.first_yield_force == pytest.approx(first, rel=1e-12)
    forces = [peak.peak_force for peak in result.contacts]
    # the last contact is with a flat, where R* is twice as large
    ratios = [forces[0] / 8, forces[1] / 8, forces[2], forces[3], forces[4] / 4]
    assert result.yielding.peak_ratio == pytest.approx(max(ratios) / first, rel=1e-12)
    endless = sw.simulate(SHOCK, attrs.evolve(CHAIN, material=soft)).yielding
    assert endless.first_yield_force == pytest.approx(first, rel=1e-12)


# ---------------------------------------------------------------- histories


@cache
def recorded() -> tuple[Simulation, Recording]:
    chain = attrs.evolve(WALLED, precompression=1.0)
    result = sw.simulate(
        SHOCK, chain, rtol=1e-8, contacts=[0, 3], record=["forces", "field", "energies"], interval=2e-7, until=2e-4
    )
    return result, result.recording


def test_histories_contain_the_greatest_forces_and_the_impulse() -> None:
    result, kept = recorded()
    assert kept.forces.shape == (1001, 2)
    greatest = [peak.peak_force for peak in result.contacts]
    # samples every 2e-7 s miss a maximum by less than this
    assert kept.forces.max(axis=0) == pytest.approx(greatest, rel=1e-4)
    assert (kept.forces.max(axis=0) <= np.array(greatest) * (1 + 1e-9)).all()
    wall = result.transmitted
    assert kept.wall_force[0] == pytest.approx(1.0, rel=1e-12)
    assert float(trapezoid(kept.wall_force - 1.0, kept.times)) == pytest.approx(wall.impulse, rel=1e-4)


def test_histories_contain_all_contacts_by_default() -> None:
    for chain, count in ((WALLED, len(walled().contacts)), (attrs.evolve(CHAIN, granules=12), 11)):
        result = sw.simulate(SHOCK, chain, record=["forces"], until=1e-4)
        kept = result.recording
        assert kept.contacts == tuple(range(count))
        assert kept.forces.shape == (len(kept.times), count)
        assert len(repr(kept)) < 200


def test_histories_balance_energy_and_momentum() -> None:
    result, kept = recorded()
    assert kept.velocities[-1] == pytest.approx(list(result.velocities), rel=1e-6, abs=1e-9)
    energy = np.add(kept.kinetic_energy, kept.contact_energy)
    after = kept.times > SHOCK.duration
    # the tolerance
    assert energy[after] == pytest.approx(np.full(after.sum(), result.applied_energy), rel=1e-6)


# ---------------------------------------------------------------- many chains, ends of histories, later forces


@pytest.mark.parametrize("backend", ["compiled", "numpy"])
def test_the_last_sample_is_at_the_end_of_the_simulated_time(backend: str) -> None:
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3.0), peak_force=50.0, rise_time=20e-6)
    chain = attrs.evolve(CHAIN, granules=5, end=Wall(material="same"))
    for until in (0.1e-3, 0.3e-3):  # some multiples of the interval are rounded upwards
        result = sw.simulate(shock, chain, until=until, record=["field", "energies"], interval=1e-6, backend=backend)
        kept = result.recording
        assert kept.times[-1] == pytest.approx(until, rel=1e-12)
        assert np.allclose(kept.velocities[-1], result.velocities, rtol=1e-5, atol=1e-9)
        assert kept.kinetic_energy[-1] > 0


def test_the_energy_of_the_spring_behind_a_wall_may_exert_a_later_force() -> None:
    # the wall has the mass of a granule and nearly all energy; after a quarter of its period, 1 ms, it is in the spring
    wall = Wall(material="same", mass=4e-3, stiffness=1e4)
    chain = sw.Chain(material="stainless-steel-302", diameter=9.5e-3, granules=1, end=wall)
    early, late = (sw.simulate(Impact(velocity=0.3), chain, until=until) for until in (1e-3, 4e-3))
    assert late.transmitted.time > 1e-3
    assert early.transmitted.peak_force < late.transmitted.peak_force < early.leaving.later


def test_the_dashpot_of_a_contact_may_exert_a_later_force() -> None:
    # it acts at once as the granule meets the wall, with more than the elastic force that takes all its energy
    damping = Dashpot(coefficient=1000.0)
    chain = attrs.evolve(CHAIN, granules=[Segment(gap=1e-3)], end=Wall(), damping=damping)
    early, late = (sw.simulate(Impact(velocity=0.3), chain, until=until) for until in (1e-3, 10e-3))
    assert early.transmitted.peak_force == 0
    assert damping.coefficient * early.velocities[-1] < 1.01 * late.transmitted.peak_force < early.leaving.later
