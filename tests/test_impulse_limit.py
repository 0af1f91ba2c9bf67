"""The limit of a very short shock: the impact of a granule at given speed on a chain of its equals."""

from __future__ import annotations

from functools import cache

import pytest

import shockwave as sw
from scenes import CHAIN, FORCE, UNITS
from shockwave.chain import Scales
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM

# A shock of a millionth of the natural time: its spread acts at the order of its square.
RISE_TIME = 1e-6


@cache
def impact() -> tuple[sw.SimulationResult, float, Scales]:
    """The result, the impact's speed, and the scales of a unit mass at unit speed."""
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=FORCE, rise_time=RISE_TIME * UNITS.time)
    result = sw.simulate(shock, CHAIN, rtol=1e-8)
    speed = result.applied_momentum / CHAIN.granule_mass
    # F scales as v^(6/5) in units of mass and stiffness
    scaled = (speed / UNITS.velocity) ** 1.2
    return result, speed, Scales.of(CHAIN, scaled * FORCE)


def test_peak_force() -> None:
    result, _, scales = impact()
    assert result.peak_force / scales.force == pytest.approx(0.63955423, rel=1e-4)


def test_peak_granule_velocity() -> None:
    result, speed, _ = impact()
    assert result.waves[0].granule_velocity / speed == pytest.approx(0.68163152, rel=1e-4)


def test_share_of_energy_in_the_wave() -> None:
    result, speed, _ = impact()
    assert result.waves[0].energy / (0.5 * CHAIN.granule_mass * speed**2) == pytest.approx(0.99366, abs=1e-5)


def test_wave_carries_more_than_the_impulse() -> None:
    result, _, _ = impact()
    assert result.waves[0].momentum / result.applied_momentum == pytest.approx(1.1383, rel=1e-4)


@pytest.mark.parametrize(("granule", "velocity"), [(0, -0.0710850), (1, -0.0302738), (2, -0.0158334), (3, -0.0088857)])
def test_recoil_velocities(granule: int, velocity: float) -> None:
    result, speed, _ = impact()
    assert result.recoil_velocities[granule] / speed == pytest.approx(velocity, rel=1e-4)


def test_recoil_is_what_the_wave_has_too_much() -> None:
    result, _, _ = impact()
    assert result.applied_momentum - result.recoil_momentum == pytest.approx(result.waves[0].momentum, rel=1e-6)


def test_amplification_follows_the_impulse_law() -> None:
    result, _, _ = impact()
    strength = result.applied_momentum / (MOMENTUM * UNITS.momentum)
    assert result.amplification == pytest.approx(IMPULSE_LIMIT * strength**1.2, rel=1e-6)
