"""The limit of a very short shock: the impact of a granule at given speed on a chain of its equals."""

from __future__ import annotations

from functools import cache

import pytest

import shockwave as sw
from scenes import CHAIN, UNITS, triangle
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM


@cache
def impact() -> tuple[sw.SimulationResult, float]:
    """The result of a shock of a millionth of the natural time, whose spread acts at its square; the impact's speed."""
    result = sw.simulate(triangle(3e-6), CHAIN, rtol=1e-8)
    return result, result.applied_momentum / CHAIN.granule_mass


def test_primary_of_an_impact() -> None:
    result, speed = impact()
    wave = result.waves[0]
    # the digits of the published values
    assert result.amplification / (speed / UNITS.velocity) ** 1.2 == pytest.approx(0.63955423, rel=1e-4)
    assert wave.granule_velocity / speed == pytest.approx(0.68163152, rel=1e-4)
    assert wave.energy / (0.5 * CHAIN.granule_mass * speed**2) == pytest.approx(0.99366, abs=1e-5)
    assert wave.momentum / result.applied_momentum == pytest.approx(1.1383, rel=1e-4)


def test_recoil_velocities_of_an_impact() -> None:
    result, speed = impact()
    shares = [velocity / speed for velocity in result.recoil_velocities[:4]]
    # the digits of the published values
    assert shares == pytest.approx([-0.0710850, -0.0302738, -0.0158334, -0.0088857], rel=1e-4)


def test_recoil_is_the_excess_momentum_of_the_wave() -> None:
    result, _ = impact()
    # the wave is the only one above the threshold; rtol of the train
    assert result.applied_momentum - result.recoil_momentum == pytest.approx(result.waves[0].momentum, rel=1e-6)


def test_amplification_follows_the_impulse_law() -> None:
    result, _ = impact()
    strength = result.applied_momentum / (MOMENTUM * UNITS.momentum)
    # the digits of the constant
    assert result.amplification == pytest.approx(IMPULSE_LIMIT * strength**1.2, rel=1e-6)
