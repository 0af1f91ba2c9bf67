"""The solitary wave: its constants from a new solution of the fixed point, and its properties in SI units."""

from __future__ import annotations

import math
from functools import cache

import attrs
import numpy as np
import pytest
import scipy.optimize

from shockwave.base.numerics import FloatArray
from shockwave.scene import solitary_wave as exact
from shockwave.scene.chain import Scales
from shockwave.scene.solitary_wave import SolitaryWave
from support.scenes import CHAIN as BEADS

# Quantity -> its constant, and the power of the peak force with which it scales.
QUANTITIES = {
    "speed": (exact.SPEED, 1 / 6),
    "momentum": (exact.MOMENTUM, 5 / 6),
    "granule_velocity": (exact.GRANULE_VELOCITY, 5 / 6),
    "energy": (exact.ENERGY, 5 / 3),
    "width": (exact.WIDTH, -1 / 6),
}


@cache
def solved(granules: int, points: int) -> dict[str, float]:
    """The wave by Petviashvili's iteration at unit speed, brought to peak force 1 by its scaling law."""
    step = granules / points
    number = np.fft.fftfreq(points, step)  # cycles per granule
    box = np.sinc(number)  # spectrum of a box one granule wide; twice, that of the triangle

    def smeared(values: FloatArray, times: int) -> FloatArray:
        return np.asarray(np.fft.ifft(np.fft.fft(values) * box**times).real)

    # The crest is at index 0; distances wrap around.
    place = np.minimum(np.arange(points), points - np.arange(points)) * step
    overlap = np.exp(-(place**2))
    for _ in range(60):
        response = smeared(np.maximum(overlap, 0.0) ** 1.5, 2)
        # 3 = p/(p - 1) of the power p = 3/2: the iteration would diverge without.
        overlap = response * (np.dot(overlap, overlap) / np.dot(overlap, response)) ** 3
    crest = overlap[0]
    overlap, speed = np.maximum(overlap / crest, 0.0), crest**-0.25
    force = overlap**1.5
    # A granule is pushed by the contact behind and held by the one ahead: -c V' = F(x - 1/2) - F(x + 1/2).
    velocity = smeared(force, 1) / speed
    spectrum = np.fft.fft(overlap) / points

    def above_half(distance: float) -> float:
        value = (spectrum * np.exp(2j * np.pi * number * distance)).sum().real
        return float(value - 0.5 ** (2 / 3))

    half = scipy.optimize.brentq(above_half, 0.1, 2.0, xtol=1e-15, rtol=1e-15)
    kinetic = (velocity**2).sum() * step / 2
    potential = (overlap**2.5).sum() * step * 2 / 5
    # The virial theorem for a force of power 3/2; sums of 1e4 numbers.
    assert kinetic / potential == pytest.approx(5 / 4, rel=1e-12)
    return {
        "speed": float(speed),
        "momentum": float(force.sum() * step / speed),
        "granule_velocity": float(velocity[0]),
        "energy": float(kinetic + potential),
        "width": float(2 * half / speed),
    }


# ---------------------------------------------------------------- constants


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_constant_is_that_of_the_fixed_point(quantity: str) -> None:
    # All constants are printed to 12 digits at least.
    assert solved(24, 2**13)[quantity] == pytest.approx(QUANTITIES[quantity][0], rel=1e-11)


# ---------------------------------------------------------------- the coefficient of A and the wave in SI


def test_the_exact_coefficient_follows_from_the_momentum_and_the_paper_s_is_a_quarter_percent_low() -> None:
    # A F^(5/6) = MOMENTUM sqrt(m) k^(-1/3) F^(5/6) with m and k of equal spheres.
    expected = exact.MOMENTUM * math.sqrt(4 * math.pi / 3) * 3 ** (1 / 3) * 2 ** (-1 / 6)
    assert pytest.approx(expected, rel=1e-12) == exact.EXACT_COEFFICIENT
    # to the digits given
    assert pytest.approx(0.00257, abs=5e-6) == 1 - exact.PAPER_COEFFICIENT / exact.EXACT_COEFFICIENT


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("factor", [1e-9, 1e9], ids=str)
def test_a_wave_scales_with_its_peak_force(quantity: str, factor: float) -> None:
    one, other = (SolitaryWave.of(force, BEADS) for force in (10.0, 10.0 * factor))
    ratio = getattr(other, quantity) / getattr(one, quantity)
    assert ratio == pytest.approx(factor ** QUANTITIES[quantity][1], rel=1e-13)  # powers of 1e9
    assert getattr(one.stronger(factor), quantity) == pytest.approx(getattr(other, quantity), rel=1e-13)


def test_a_wave_has_the_constants_in_the_units_of_its_chain() -> None:
    wave, units = SolitaryWave.of("100 N", BEADS), Scales.of(BEADS, 100.0)
    scales = {"speed": units.wave_speed, "width": units.time, "granule_velocity": units.velocity}
    scales |= {"momentum": units.momentum, "energy": units.energy}
    for quantity, (constant, _) in QUANTITIES.items():
        assert getattr(wave, quantity) == pytest.approx(constant * scales[quantity], rel=1e-13)


def test_a_coefficient_changes_only_the_momentum() -> None:
    exactly, paper = (SolitaryWave.of(80.0, BEADS, coefficient) for coefficient in (4.344507853978653, 13 / 3))
    assert paper.momentum == pytest.approx(BEADS.momentum_parameter(13 / 3) * 80.0 ** (5 / 6), rel=1e-12)
    assert attrs.evolve(paper, momentum=0.0) == attrs.evolve(exactly, momentum=0.0)
