"""The solitary wave: its constants from a new solution of the fixed point, and its properties in SI units."""

from __future__ import annotations

import math
from functools import cache

import attrs
import numpy as np
import pytest
import scipy.optimize
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.scene import solitary_wave as exact
from shockwave.scene.chain import Chain
from shockwave.scene.material import Material
from shockwave.scene.solitary_wave import SolitaryWave

BEADS = Chain(material=Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0), radius=4.75e-3)

# Quantity -> its constant, and the power of the peak force with which it scales.
QUANTITIES = {
    "speed": (exact.SPEED, 1 / 6),
    "momentum": (exact.MOMENTUM, 5 / 6),
    "granule_velocity": (exact.GRANULE_VELOCITY, 5 / 6),
    "energy": (exact.ENERGY, 5 / 3),
    "width": (exact.WIDTH, -1 / 6),
}


@frozen
class Wave:
    """A wave of peak contact force 1, in units of mass and stiffness."""

    speed: float
    momentum: float
    granule_velocity: float
    kinetic: float
    potential: float
    width: float

    @property
    def energy(self) -> float:
        return self.kinetic + self.potential


@cache
def solved(granules: int, points: int) -> Wave:
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
    return Wave(
        speed=float(speed),
        momentum=float(force.sum() * step / speed),
        granule_velocity=float(velocity[0]),
        kinetic=float((velocity**2).sum() * step / 2),
        potential=float((overlap**2.5).sum() * step * 2 / 5),
        width=float(2 * half / speed),
    )


# ---------------------------------------------------------------- constants


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_constant_is_that_of_the_fixed_point(quantity: str) -> None:
    # All constants are printed to 12 digits at least.
    assert getattr(solved(24, 2**13), quantity) == pytest.approx(QUANTITIES[quantity][0], rel=1e-11)


def test_kinetic_to_potential_energy_is_five_to_four() -> None:
    wave = solved(24, 2**13)
    # The virial theorem for a force of power 3/2; sums of 1e4 numbers.
    assert wave.kinetic / wave.potential == pytest.approx(5 / 4, rel=1e-12)


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


def test_a_coefficient_changes_only_the_momentum() -> None:
    exactly, paper = (SolitaryWave.of(80.0, BEADS, coefficient) for coefficient in (4.344507853978653, 13 / 3))
    assert paper.momentum == pytest.approx(BEADS.momentum_parameter(13 / 3) * 80.0 ** (5 / 6), rel=1e-12)
    assert attrs.evolve(paper, momentum=0.0) == attrs.evolve(exactly, momentum=0.0)


def test_a_wave_of_100_newton_in_the_paper_s_beads() -> None:
    wave = SolitaryWave.of(100.0, BEADS)
    # T0 = 14.58 us: 0.9055 of 9.5 mm in that time, and 1.5593 of it wide.
    assert wave.speed == pytest.approx(0.905515776 * 9.5e-3 / 14.579228e-6, rel=1e-7)
    assert wave.width == pytest.approx(1.5592532 * 14.579228e-6, rel=1e-7)
    work = 100.0 * (100.0 / BEADS.contact_stiffness) ** (2 / 3)  # of the peak force along the peak overlap
    assert wave.energy == pytest.approx(exact.ENERGY * work, rel=1e-13)
    velocity = exact.GRANULE_VELOCITY * math.sqrt(work / BEADS.granule_mass)
    assert wave.granule_velocity == pytest.approx(velocity, rel=1e-13)
