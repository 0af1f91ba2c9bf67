"""Chains with two free ends: what they keep, and what flies off."""

from __future__ import annotations

from functools import cache

import attrs
import pytest

import shockwave as sw
from scenes import CHAIN, power, triangle


@cache
def finite(granules: int) -> sw.SimulationResult:
    return sw.simulate(power(0.5), attrs.evolve(CHAIN, granules=granules))


@pytest.mark.parametrize("granules", [2, 3, 5, 9, 20, 50, 100, 200, 300])
def test_finite_chain_keeps_momentum_and_energy(granules: int) -> None:
    # rounding, and rtol
    assert finite(granules).momentum_defect < 1e-13
    assert finite(granules).energy_defect < 1e-6


@pytest.mark.parametrize("granules", [2, 3, 5, 9, 20])
def test_granules_of_a_short_chain_carry_all_momentum_away(granules: int) -> None:
    result = finite(granules)
    momentum = CHAIN.granule_mass * sum(result.spall_velocities or ())
    # left out are granules slower than a thousandth of the fastest
    assert momentum + result.recoil_momentum == pytest.approx(result.applied_momentum, rel=5e-3)


def test_granule_at_the_free_end_flies_off_alike_in_chains_of_100_and_300() -> None:
    first, second = ((finite(granules).spall_velocities or ())[0] for granules in (100, 300))
    # both see the primary alone, known to rtol 1e-6
    assert first == pytest.approx(second, rel=1e-6)


def test_second_of_two_granules_leaves_with_the_velocity_of_the_first() -> None:
    result = sw.simulate(triangle(1e-4), attrs.evolve(CHAIN, granules=2), rtol=1e-8)
    # an elastic collision of equals; the shock is short against it, to the square of the ratio of their durations
    expected = result.applied_momentum / CHAIN.granule_mass
    assert (result.spall_velocities or ())[0] == pytest.approx(expected, rel=1e-7)


def test_waves_of_a_long_finite_chain_are_those_of_an_endless_one() -> None:
    endless = sw.simulate(power(0.5), CHAIN)
    assert finite(300).found == endless.found
    assert finite(300).waves == endless.waves
    assert endless.spall_velocities is None
