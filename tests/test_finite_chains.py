"""Chains with two free ends: conservation, and granules that leave the ends."""

from __future__ import annotations

from functools import cache

import attrs
import pytest

import shockwave as sw
from scenes import CHAIN, FORCE, UNITS, power, triangle


@cache
def finite(granules: int) -> sw.SimulationResult:
    return sw.simulate(power(0.5), attrs.evolve(CHAIN, granules=granules))


@pytest.mark.parametrize("granules", [2, 3, 5, 9, 20, 50, 100, 200, 300])
def test_a_finite_chain_conserves_momentum_and_energy(granules: int) -> None:
    # rounding, and rtol
    assert finite(granules).momentum_defect < 1e-13
    assert finite(granules).energy_defect < 1e-6


@pytest.mark.parametrize("granules", [2, 3, 5, 9, 20])
def test_granules_of_a_short_chain_carry_all_momentum_away(granules: int) -> None:
    result = finite(granules)
    momentum = CHAIN.granule_mass * sum(result.spall_velocities or ())
    # left out are granules slower than a thousandth of the fastest
    assert momentum + result.recoil_momentum == pytest.approx(result.applied_momentum, rel=5e-3)


def test_waves_of_a_long_finite_chain_are_those_of_an_endless_one() -> None:
    endless = sw.simulate(power(0.5), CHAIN)
    assert finite(300).found == endless.found
    for one, other in zip(finite(300).waves, endless.waves, strict=True):
        assert one.peak_force == pytest.approx(other.peak_force, rel=other.error_estimate)
    assert endless.spall_velocities is None


def test_a_short_chain_states_its_greatest_force_first() -> None:
    profile = sw.PowerLaw(rise_exponent=1, decay_exponent=0.5, duration_ratio=4)
    shock = sw.Shock(profile=profile, peak_force=FORCE, rise_time=3 * UNITS.time)
    result = sw.simulate(shock, attrs.evolve(CHAIN, granules=5))
    (warning,) = result.warnings
    assert "reach the free end" in warning
    assert str(result).startswith("greatest force 126.406621 N at contact 3, 96.48 us, estimated error")
    greatest = result.to_dict()["greatest_force"]
    assert greatest["contact"] == 3
    finer = sw.simulate(shock, attrs.evolve(CHAIN, granules=5), rtol=1e-10).greatest_force
    assert finer is not None
    assert greatest["peak_force"] == pytest.approx(finer.peak_force, rel=greatest["error_estimate"])
    # the default rtol
    assert greatest["error_estimate"] < 1e-6


def test_the_greatest_force_of_a_short_shock_is_at_the_loaded_contact() -> None:
    greatest = finite(300).greatest_force
    assert greatest is not None
    assert greatest.contact == 0
    assert greatest.peak_force == pytest.approx(sw.simulate(power(0.5), CHAIN).passage(0).peak_force, rel=1e-6)  # rtol
    assert sw.simulate(power(0.5), CHAIN).to_dict()["greatest_force"] is None


def test_granules_collide_after_a_long_free_flight() -> None:
    times, forces = [0, 0.5, 1, 11, 11.5, 12], [0, 1, 0, 0, 1.05, 0]
    record = sw.Tabulated(times=[t * UNITS.time for t in times], forces=[f * FORCE for f in forces])
    result = sw.simulate(sw.Shock(profile=record), attrs.evolve(CHAIN, granules=2))
    # velocities after the blows, which a collision of equal masses exchanges
    last, first = (velocity / UNITS.velocity for velocity in result.spall_velocities or ())
    assert (first, last) == pytest.approx((0.497, 0.528), abs=5e-4)
    _, late = result.waves
    assert late.arrival_time / UNITS.time == pytest.approx(148, abs=0.5)
    # two equal masses that approach at this speed: 2/5 d^(5/2) = v^2/4; the tolerance is ten times the error estimate
    assert late.peak_force / FORCE == pytest.approx((5 / 8 * (last - first) ** 2) ** 0.6, rel=1e-5)
    assert not any("collide" in warning for warning in result.all_warnings)


def test_forces_of_collisions_after_the_run_are_bounded() -> None:
    profile = sw.PowerLaw(rise_exponent=1, decay_exponent=0.5, duration_ratio=4)
    shock = sw.Shock(profile=profile, peak_force=FORCE, rise_time=3 * UNITS.time)
    result = sw.simulate(shock, attrs.evolve(CHAIN, granules=200))
    assert any("may collide after" in warning for warning in result.all_warnings)
    # no contact force of this train exceeds that of the settled leading wave
    assert str(result).startswith("peak force")


def test_two_granules_collide_according_to_their_relative_motion() -> None:
    result = sw.simulate(triangle(1e-4), attrs.evolve(CHAIN, granules=2), rtol=1e-8)
    # Two equal masses under an impulse: the relative coordinate has mass 1/2, so the greatest overlap stores half
    # the kinetic energy, 2/5 d^(5/2) = v^2/4.
    speed = result.applied_momentum / CHAIN.granule_mass
    # the shock is short against the collision; its spread acts at the order of the ratio of their durations
    assert result.amplification == pytest.approx((5 / 8 * (speed / UNITS.velocity) ** 2) ** 0.6, rel=1e-4)
    # an elastic collision of equals, to the square of that ratio
    assert (result.spall_velocities or ())[0] == pytest.approx(speed, rel=1e-7)
