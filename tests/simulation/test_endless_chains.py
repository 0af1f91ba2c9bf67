"""Endless chains with other exponents of the contact force, and under precompression."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy.integrate
from attrs import evolve

import shockwave as sw
from shockwave.base.numerics import FloatArray
from shockwave.scene.chain import Scales
from shockwave.scene.power_law_wave import solved
from shockwave.scene.solitary_wave import HERTZ_WAVE, SolitaryWave, WaveLaw, wave_law
from shockwave.sweep.runner import run_sweep
from support.scenes import FORCE, STEEL

RADIUS = 4.75e-3
HERTZ_CHAIN = sw.Chain(material=STEEL, radius=RADIUS)
TRIANGLE = sw.Triangular(duration_ratio=3)
#: Exponent -> speed, momentum and energy of the solitary wave of peak force 1, and impulse limit (published digits).
REFERENCES = {
    1.25: (0.9463465548, 2.2012631643, 1.4698120649, 1.3098045),
    1.5: (0.9055157764, 1.6520665186, 1.0465162035, 1.1681817383),
    2.0: (0.8458536424, 1.2814612714, 0.7404560335, 1.0702189426),
    2.5: (0.8026176848, 1.1207362304, 0.5992493127, 1.0337688422),
    3.0: (0.7684198279, 1.0230892168, 0.5116013422, 1.0170997242),
}


def chain_of(exponent: float, stiffness: float = 1e10, granules: int | None = None, **features: float) -> sw.Chain:
    contact = sw.PowerContact(exponent=exponent, stiffness=stiffness)
    return sw.Chain(material=STEEL, radius=RADIUS, contact=contact, granules=granules, **features)


def shock_of(chain: sw.Chain, duration: float, profile: sw.ShockProfile = TRIANGLE) -> sw.Shock:
    """A shock of 100 N; its duration is in characteristic times of the chain."""
    time = Scales.of(chain, FORCE).time
    return sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=duration * time)


# ---------------------------------------------------------------- the solitary wave


@pytest.mark.parametrize("exponent", REFERENCES)
def test_solitary_wave_agrees_with_the_reference(exponent: float) -> None:
    law = WaveLaw(exponent, *solved(exponent))
    # half of the last digit of the reference
    assert [law.speed, law.momentum, law.energy] == pytest.approx(REFERENCES[exponent][:3], abs=6e-11)


def test_solitary_wave_of_hertz_is_the_known_one() -> None:
    assert solved(1.5) == pytest.approx(
        [getattr(HERTZ_WAVE, name) for name in ("speed", "momentum", "granule_velocity", "energy", "width")], rel=1e-12
    )


@pytest.mark.parametrize("exponent", [1.05, 1.2, 2.0, 6.0])
def test_solitary_wave_scales_with_its_force(exponent: float) -> None:
    law = wave_law(exponent)
    wave, stronger = (SolitaryWave.of(force, chain_of(exponent)) for force in (FORCE, 8 * FORCE))
    assert stronger.momentum / wave.momentum == pytest.approx(8**law.of_momentum, rel=1e-13)
    assert stronger.speed / wave.speed == pytest.approx(8**law.of_speed, rel=1e-13)
    assert stronger.energy / wave.energy == pytest.approx(8**law.of_energy, rel=1e-13)
    assert wave.stronger(8.0, exponent).width == pytest.approx(stronger.width, rel=1e-13)


# ---------------------------------------------------------------- waves


@pytest.mark.parametrize("duration", [0.5, 12.0])
@pytest.mark.parametrize("exponent", [1.05, 1.25, 2.0, 3.0, 6.0])
def test_leading_wave_is_the_solitary_wave(exponent: float, duration: float) -> None:
    chain = chain_of(exponent)
    result = sw.simulate(shock_of(chain, duration), chain)
    wave, exact = result.waves[0], SolitaryWave.of(result.peak_force, chain)
    # what is left behind the wave, at the contact where it is measured, still overlaps with it
    for name in ("momentum", "energy", "speed", "width", "granule_velocity"):
        assert getattr(wave, name) == pytest.approx(getattr(exact, name), rel=2e-5), name
    assert result.error_estimate < 1e-6
    assert result.momentum_defect < 1e-12
    assert result.recoil_momentum <= 0


@cache
def independent(exponent: float, granules: int, duration: float) -> tuple[FloatArray, FloatArray]:
    """Peak force and its time at each contact of a long chain, by DOP853 with a triangle of unit force, scaled."""
    rise = duration / 3

    def force(time: float) -> float:
        return max(min(time / rise, (duration - time) / (duration - rise)), 0.0)

    def motion(time: float, state: FloatArray) -> FloatArray:
        x, v = state[:granules], state[granules:]
        contacts = np.maximum(x[:-1] - x[1:], 0.0) ** exponent
        pushes = np.concatenate(([force(time)], contacts, [0.0]))
        return np.concatenate((v, pushes[:-1] - pushes[1:]))

    peaks, times = np.zeros((2, granules - 1))
    state, begin = np.zeros(2 * granules), 0.0
    for end in (rise, duration, granules * 0.9):
        found = scipy.integrate.solve_ivp(
            motion, (begin, end), state, method="DOP853", rtol=1e-12, atol=1e-14, dense_output=True
        )
        fine = np.arange(begin, end, 0.005)
        x = found.sol(fine)[:granules]
        forces = np.maximum(x[:-1] - x[1:], 0.0) ** exponent
        top = forces.argmax(axis=1)
        for contact, at in enumerate(top):
            inner = min(max(at, 1), len(fine) - 2)
            before, here, after = forces[contact, inner - 1 : inner + 2]
            bend = before - 2 * here + after
            shift = 0.5 * (before - after) / bend if bend < 0 else 0.0
            peak = here - 0.25 * (before - after) * shift if abs(shift) <= 1 else forces[contact, at]
            if peak > peaks[contact]:
                peaks[contact], times[contact] = peak, fine[inner] + shift * 0.005
        state, begin = found.y[:, -1], end
    return peaks, times


@pytest.mark.parametrize("exponent", [1.25, 2.0, 3.0])
def test_passages_agree_with_an_independent_integration(exponent: float) -> None:
    chain = chain_of(exponent)
    scales = Scales.of(chain, FORCE)
    peaks, times = independent(exponent, 60, 4.0)
    result = sw.simulate(shock_of(chain, 4.0), chain, rtol=1e-9, contacts=(3, 10, 30))
    for passage in result.passages:
        # the parabola through samples 0.005 apart locates a peak to 1e-9 of its force, its time to 1e-6
        assert passage.peak_force / FORCE == pytest.approx(peaks[passage.contact], rel=3e-9)
        assert passage.arrival_time / scales.time == pytest.approx(times[passage.contact], rel=1e-6)


@pytest.mark.parametrize("exponent", [1.2, 2.0, 4.0])
def test_both_codes_agree(exponent: float) -> None:
    chain = chain_of(exponent)
    shock = shock_of(chain, 3.0)
    one, other = (sw.simulate(shock, chain, backend=name) for name in ("compiled", "numpy"))
    assert one.peak_force == pytest.approx(other.peak_force, rel=1e-10)
    assert [wave.peak_force for wave in one.waves] == pytest.approx([wave.peak_force for wave in other.waves], rel=1e-9)
    # the collisions of granules that rebound amplify the differences of the two codes
    assert one.recoil_momentum == pytest.approx(other.recoil_momentum, rel=1e-6, abs=one.recoil_error)


@pytest.mark.parametrize("exponent", [1.1, 1.5, 2.5])
def test_results_scale_with_stiffness_and_force(exponent: float) -> None:
    soft, stiff = chain_of(exponent), chain_of(exponent, stiffness=3e12)
    one, other = (sw.simulate(shock_of(chain, 2.0), chain, rtol=1e-8) for chain in (soft, stiff))
    assert one.peak_force == pytest.approx(other.peak_force, rel=1e-12)
    ratio = Scales.of(soft, FORCE).time / Scales.of(stiff, FORCE).time
    assert one.waves[0].width / other.waves[0].width == pytest.approx(ratio, rel=1e-9)


def test_exponent_of_hertz_gives_the_result_of_equal_spheres() -> None:
    chain = chain_of(1.5, HERTZ_CHAIN.contact_stiffness)
    shock = shock_of(HERTZ_CHAIN, 4.0)
    one, other = sw.simulate(shock, chain), sw.simulate(shock, HERTZ_CHAIN)
    assert one.peak_force == other.peak_force
    assert one.waves == other.waves
    one, other = (sw.predict(shock, each) for each in (chain, HERTZ_CHAIN))
    assert (one.peak_force, one.low, one.high) == (other.peak_force, other.low, other.high)
    assert one.section4.peak_force == other.section4.peak_force


@pytest.mark.parametrize("exponent", [1.4999999, 1.5000001])
def test_general_exponents_join_the_fast_code_of_hertz(exponent: float) -> None:
    chain = chain_of(1.5)
    shock = shock_of(chain, 2.0)
    # the same overlap under the force of the shock; d ln F / dp is then of order 1
    factor = (FORCE / 1e10) ** (1 - exponent / 1.5)
    near = chain_of(exponent, 1e10 * factor)
    assert sw.simulate(shock, near).peak_force == pytest.approx(sw.simulate(shock, chain).peak_force, rel=1e-6)


def test_passages_and_histories_are_those_of_the_wave() -> None:
    chain = chain_of(2.0)
    result = sw.simulate(shock_of(chain, 2.0), chain, contacts=(0, 15, 150), record=("forces", "energies"))
    kept = result.recording
    assert kept is not None
    assert kept.forces is not None
    assert kept.kinetic_energy is not None
    assert kept.forces[:, 2].max() == pytest.approx(result.passages[2].peak_force, rel=5e-3)  # samples
    energy = kept.kinetic_energy + kept.contact_energy
    assert energy[-1] == pytest.approx(energy[len(energy) // 2], rel=1e-7)
    assert result.passages[2].exact
    steps = (result.passages[2].arrival_time - result.passages[1].arrival_time) / 135
    assert 2 * RADIUS / steps == pytest.approx(result.waves[0].speed, rel=1e-6)


@pytest.mark.parametrize("integrator", ["rk4", "dop853"])
def test_other_integrators_step_other_exponents(integrator: str) -> None:
    chain = chain_of(2.0)
    shock = shock_of(chain, 3.0)
    found = sw.simulate(shock, chain, integrator=integrator, waves="primary")
    assert found.peak_force == pytest.approx(sw.simulate(shock, chain).peak_force, rel=1e-5)


# ---------------------------------------------------------------- predictions


@pytest.mark.parametrize("exponent", REFERENCES)
def test_the_force_of_an_impulse_agrees_with_the_reference(exponent: float) -> None:
    chain, wave = chain_of(exponent), wave_law(exponent)
    shock = shock_of(chain, 1e-4)
    strength = shock.peak_force * shock.duration / 2 / (wave.momentum * Scales.of(chain, FORCE).momentum)
    limit = REFERENCES[exponent][3] * FORCE * strength ** (1 / wave.of_momentum)
    # the simulation has a relative error of 1e-8, and the reference is rounded by up to 1e-7
    assert sw.predict(shock, chain, rtol=1e-8).peak_force == pytest.approx(limit, rel=1e-7)


def test_exponents_of_section_4_are_the_slopes_of_its_prediction() -> None:
    chain = chain_of(2.5)
    shock = shock_of(chain, 8.0)
    exponents = sw.Predictor().section4(shock, chain).exponents
    assert exponents is not None
    dense = [evolve(chain, material=evolve(STEEL, density=ratio * STEEL.density)) for ratio in (0.999, 1.001)]
    low, high = (sw.predict(shock, each, model="section-4").peak_force for each in dense)
    # a difference over 0.2 %, to the square of that
    assert math.log(high / low) / math.log(1.001 / 0.999) == pytest.approx(exponents.density, rel=1e-5)
    # the contacts are given: the radius acts through the mass alone
    assert exponents.radius == pytest.approx(3 * exponents.density, rel=1e-12)
    assert exponents.youngs_modulus == 0


@pytest.mark.parametrize("exponent", [1.2, 2.0, 3.0])
def test_relations_for_a_single_wave_conserve_its_momentum(exponent: float) -> None:
    chain = chain_of(exponent)
    train, single = (
        sw.predict(
            shock_of(chain, share * wave_law(exponent).momentum, sw.Triangular(duration_ratio=2)),
            chain,
            model="section-4",
        )
        for share in (2.2, 2.0)
    )
    assert train.regime == "train"
    assert single.waves[0].momentum == pytest.approx(single.applied_momentum, rel=1e-12)


def test_many_predictions_may_have_several_contact_laws() -> None:
    chains = [chain_of(2.0), HERTZ_CHAIN, chain_of(1.25)]
    shocks = [shock_of(chain, 2.0) for chain in chains]
    for outcome, shock, chain in zip(sw.Predictor().predict_many(shocks, chains), shocks, chains, strict=True):
        alone = sw.simulate(shock, chain)
        assert isinstance(outcome, sw.Outcome)
        assert (outcome.peak_force, outcome.section4) == (alone.peak_force, sw.Predictor().section4(shock, chain))


def test_a_sweep_of_exponents(tmp_path: Path) -> None:
    path = tmp_path / "sweep.yaml"
    path.write_text(
        "chain: {material: copper, radius: 1 mm, contact: {exponent: 2, stiffness: 1e10}}\n"
        "shock: {profile: triangular, peak_force: 10 N, rise_time: 5 us, duration_ratio: 3}\n"
        "sweep: {grid: {chain.contact.exponent: [1.3, 1.5, 2.5]}}\n"
    )
    with ThreadPoolExecutor(1) as executor:
        report = run_sweep(path, tmp_path / "results", executor)
    assert (report.done, report.failed) == (3, 0)
    scene = sw.load_scenario(path)
    # the columns of equal spheres
    results = sw.load_sweep(tmp_path / "results")
    forces = zip(results.values("peak_force"), results.values("section4_peak_force"), strict=True)
    for p, (force, by_section4) in zip((1.3, 1.5, 2.5), forces, strict=True):
        chain = evolve(scene.chain, contact=sw.PowerContact(exponent=p, stiffness=1e10))
        assert sw.simulate(scene.shock, chain, waves="primary").peak_force == force
        assert sw.Predictor().section4(scene.shock, chain).peak_force == by_section4


# ---------------------------------------------------------------- precompression


@pytest.mark.parametrize("contact", [None, sw.PowerContact(exponent=2.5, stiffness=1e14)])
@pytest.mark.parametrize("static", [0.1, 300.0])
def test_a_precompressed_endless_chain_is_a_long_finite_one(contact: sw.PowerContact | None, static: float) -> None:
    chain = sw.Chain(material=STEEL, radius=RADIUS, precompression=static, contact=contact)
    long = sw.Chain(material=STEEL, radius=RADIUS, precompression=static, contact=contact, granules=300)
    shock = shock_of(chain, 3.0)
    one = sw.simulate(shock, chain, contacts=(0, 5, 40))
    other = sw.simulate(shock, long, contacts=(0, 5, 40), until=one.end)
    assert [peak.contact for peak in one.contacts] == [0, 5, 40]
    for here, there in zip(one.contacts, other.contacts, strict=True):
        assert here.peak_force == pytest.approx(there.peak_force, rel=1e-12)
        assert here.time == pytest.approx(there.time, rel=1e-9)
    assert one.peak_force is None
    assert one.waves == ()
    assert one.contact_count is None
    assert "approaches its limit too slowly" in one.all_warnings[-1]
    assert one.momentum_defect < 1e-12
    assert one.error_estimate < 1e-6


def test_both_codes_agree_under_precompression() -> None:
    chain = sw.Chain(material=STEEL, radius=RADIUS, precompression=20.0)
    shock = shock_of(chain, 3.0)
    one, other = (sw.simulate(shock, chain, backend=name, contacts=(0, 10)) for name in ("compiled", "numpy"))
    for here, there in zip(one.contacts, other.contacts, strict=True):
        assert here.peak_force == pytest.approx(there.peak_force, rel=1e-10)


@pytest.mark.parametrize(("static", "tolerance"), [(50.0, 4e-3), (5.0, 1.5e-2)])
def test_speed_under_precompression_is_that_of_coste(static: float, tolerance: float) -> None:
    chain = sw.Chain(material=STEEL, radius=RADIUS, precompression=static)
    scales = Scales.of(chain, static)
    result = sw.simulate(shock_of(chain, 4.0), chain, contacts=(150, 200))
    near, far = result.contacts
    speed = 50 * scales.time / (far.time - near.time)
    ratio = far.peak_force / static
    sound = math.sqrt(1.5)
    expected = math.sqrt(4 / 15 * (3 + 2 * ratio ** (5 / 3) - 5 * ratio ** (2 / 3))) / (ratio ** (2 / 3) - 1)
    # Coste's formula is good to 0.4 % up to a ratio of 10, and 1.2 % low beyond
    assert speed / sound == pytest.approx(expected, rel=tolerance)
    assert speed > sound


def test_reported_contacts_have_a_default_and_a_later_end_keeps_their_forces() -> None:
    chain = sw.Chain(material=STEEL, radius=RADIUS, precompression=5.0)
    shock = shock_of(chain, 2.0)
    found = sw.simulate(shock, chain)
    assert [peak.contact for peak in found.contacts] == [0, 1, 2, 5, 10, 20, 50, 100]
    later = sw.simulate(shock, chain, until=1.3 * found.end)
    assert [peak.peak_force for peak in later.contacts] == pytest.approx(
        [peak.peak_force for peak in found.contacts], rel=1e-7
    )
    assert len(later.velocities) > len(found.velocities)


def test_every_integrator_may_be_requested_for_waves_of_other_exponents(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(
        "chain: {material: copper, diameter: 9.5 mm, contact: {exponent: 2, stiffness: 1e12}}\n"
        "shock: {profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}\n"
        "simulate: {integrator: rkn64}\n"
    )
    assert sw.load_scenario(file).simulate.integrator == "rkn64"


def test_histories_of_an_endless_precompressed_chain() -> None:
    chain = sw.Chain(material=STEEL, radius=RADIUS, precompression=5.0)
    found = sw.simulate(shock_of(chain, 2.0), chain, contacts=(0, 20), record=("forces", "field"))
    kept = found.recording
    assert kept is not None
    assert kept.forces is not None
    assert kept.velocities is not None
    assert kept.forces[0].tolist() == pytest.approx([5.0, 5.0], rel=1e-12)
    assert kept.forces[:, 1].max() == pytest.approx(found.contacts[1].peak_force, rel=1e-2)
    assert kept.velocities.shape[1] == pytest.approx(len(found.velocities), abs=2)


def test_a_contact_that_is_too_far_is_refused() -> None:
    chain = sw.Chain(material=STEEL, radius=RADIUS, precompression=5.0)
    with pytest.raises(sw.ShockwaveError, match="until: must be less, since the waves reach"):
        sw.simulate(shock_of(chain, 2.0), chain, until=1e3)


def test_an_endless_precompressed_chain_leaves_its_limit_open() -> None:
    chain = sw.Chain(material=STEEL, radius=RADIUS, precompression=5.0)
    found = sw.simulate(shock_of(chain, 2.0), chain, contacts=(0,))
    known = sw.Limit(force=60.0).verdict(found)
    assert known.decision == "undecided"
    assert known.remedy == "simulate a finite chain"


# ---------------------------------------------------------------- the command line and the documents


def test_the_scene_states_the_contact_law() -> None:
    chain = chain_of(2.0)
    found = sw.simulate(shock_of(chain, 2.0), chain)
    assert found.to_dict()["scene"]["contact"] == {"model": "power-law", "exponent": 2.0, "stiffness": 1e10}
    assert "exponent 2, stiffness 1e+10" in found.text("verbose")
    assert sw.simulate(shock_of(HERTZ_CHAIN, 2.0), HERTZ_CHAIN).to_dict()["scene"]["contact"] is None
