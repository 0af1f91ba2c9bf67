"""Endless chains with other exponents of the contact force, and under precompression."""

from __future__ import annotations

import pytest

import shockwave as sw
from shockwave.scene.chain import Scales
from shockwave.scene.power_law_wave import solve_wave
from shockwave.scene.solitary_wave import HERTZ_WAVE, SolitaryWave, WaveLaw, wave_law
from support.chain_reference import Reference
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
    return sw.Shock(profile=profile, peak_force=FORCE, duration=duration * time)


# ---------------------------------------------------------------- the solitary wave


@pytest.mark.parametrize("exponent", REFERENCES)
def test_solitary_wave_agrees_with_the_reference(exponent: float) -> None:
    law = WaveLaw(exponent, *solve_wave(exponent))
    # half of the last digit of the reference
    assert [law.speed, law.momentum, law.energy] == pytest.approx(REFERENCES[exponent][:3], abs=6e-11)


def test_solitary_wave_of_hertz_is_the_known_one() -> None:
    assert solve_wave(1.5) == pytest.approx(
        [getattr(HERTZ_WAVE, name) for name in ("speed", "momentum", "granule_velocity", "energy", "width")], rel=1e-12
    )


# ---------------------------------------------------------------- waves


@pytest.mark.parametrize("duration", [0.5, 12.0])
@pytest.mark.parametrize("exponent", [1.05, 1.5, 6.0])
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


@pytest.mark.parametrize("exponent", [1.25, 3.0])
def test_passages_agree_with_an_independent_integration(exponent: float) -> None:
    chain = chain_of(exponent)
    shock, unit = shock_of(chain, 4.0), Scales.of(chain, FORCE).time
    # no wave has returned from the end of the finite chain
    peaks, times = Reference(shock, chain_of(exponent, granules=14), unit).greatest(12 * unit, 1e3)
    result = sw.simulate(shock, chain, rtol=1e-9, contacts=(0, 1, 3, 6))
    for passage in result.passages:
        # the reference is good to 1e-9 of the force
        assert passage.peak_force == pytest.approx(peaks[passage.contact], rel=3e-9)
        assert passage.arrival_time == pytest.approx(times[passage.contact], rel=1e-6)


@pytest.mark.parametrize("exponent", [1.2, 4.0])
def test_both_codes_agree(exponent: float) -> None:
    chain = chain_of(exponent)
    shock = shock_of(chain, 3.0)
    one, other = (sw.simulate(shock, chain, backend=name) for name in ("compiled", "numpy"))
    assert one.peak_force == pytest.approx(other.peak_force, rel=1e-10)
    assert [wave.peak_force for wave in one.waves] == pytest.approx([wave.peak_force for wave in other.waves], rel=1e-9)
    # the collisions of granules that rebound amplify the differences of the two codes
    assert one.recoil_momentum == pytest.approx(other.recoil_momentum, rel=1e-6, abs=one.recoil_error)


@pytest.mark.parametrize("exponent", [1.1, 2.5])
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


@pytest.mark.parametrize("integrator", ["rk4", "dop853"])
def test_other_integrators_step_other_exponents(integrator: str) -> None:
    chain = chain_of(2.0)
    shock = shock_of(chain, 3.0)
    found = sw.simulate(shock, chain, integrator=integrator, waves="primary")
    assert found.peak_force == pytest.approx(sw.simulate(shock, chain).peak_force, rel=1e-5)


# ---------------------------------------------------------------- predictions


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
        # the waves reach more than 512 granules with the power contact, so that one chain is integrated in parts, the
        # other as a whole: 1.5e-12, far below the error estimates of 1e-7
        assert here.peak_force == pytest.approx(there.peak_force, rel=1e-11)
        assert here.time == pytest.approx(there.time, rel=1e-9)
    assert one.peak_force is None
    assert one.waves == ()
    assert one.scene.contact_count is None
    assert "approaches its limit too slowly" in one.warnings[-1]
    assert one.momentum_defect < 1e-12
    assert one.error_estimate < 1e-6


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


def test_histories_of_an_endless_precompressed_chain() -> None:
    chain = sw.Chain(material=STEEL, radius=RADIUS, precompression=5.0)
    found = sw.simulate(shock_of(chain, 2.0), chain, contacts=(0, 20), record=("forces", "field"))
    kept = found.recording
    assert kept.forces[0].tolist() == pytest.approx([5.0, 5.0], rel=1e-12)
    assert kept.forces[:, 1].max() == pytest.approx(found.contacts[1].peak_force, rel=1e-2)
    assert kept.velocities.shape[1] == pytest.approx(len(found.velocities), abs=2)


# ---------------------------------------------------------------- the command line and the documents


def test_the_scene_states_the_contact_law() -> None:
    chain = chain_of(2.0)
    found = sw.simulate(shock_of(chain, 2.0), chain)
    assert found.to_dict()["scene"]["contact"] == {"model": "power-law", "exponent": 2.0, "stiffness": 1e10}
    assert "exponent 2, stiffness 1e+10" in found.text("verbose")
    assert sw.simulate(shock_of(HERTZ_CHAIN, 2.0), HERTZ_CHAIN).to_dict()["scene"]["contact"] is None
