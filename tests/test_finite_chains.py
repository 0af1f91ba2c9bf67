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
    assert finite(300).waves == endless.waves
    assert endless.spall_velocities is None


def test_a_short_chain_warns_and_states_its_largest_force() -> None:
    profile = sw.PowerLaw(rise_exponent=1, decay_exponent=0.5, duration_ratio=4)
    shock = sw.Shock(profile=profile, peak_force=FORCE, rise_time=3 * UNITS.time)
    (warning,) = sw.simulate(shock, attrs.evolve(CHAIN, granules=5)).warnings
    assert "reach the free end" in warning
    assert "largest contact force is 126.41 N, at contact 3" in warning


def test_two_granules_collide_according_to_their_relative_motion() -> None:
    result = sw.simulate(triangle(1e-4), attrs.evolve(CHAIN, granules=2), rtol=1e-8)
    # Two equal masses under an impulse: the relative coordinate has mass 1/2, so the greatest overlap stores half
    # the kinetic energy, 2/5 d^(5/2) = v^2/4.
    speed = result.applied_momentum / CHAIN.granule_mass
    # the shock is short against the collision; its spread acts at the order of the ratio of their durations
    assert result.amplification == pytest.approx((5 / 8 * (speed / UNITS.velocity) ** 2) ** 0.6, rel=1e-4)
    # an elastic collision of equals, to the square of that ratio
    assert (result.spall_velocities or ())[0] == pytest.approx(speed, rel=1e-7)
