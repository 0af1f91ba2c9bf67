"""Thornton's law: its curves, and the coefficient of restitution that he published."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
import shockwave as sw
from shockwave.hooks import Pairs
from shockwave.testing import ContactLawContract

from shockwave_plasticity.thornton import Thornton

STEEL = sw.Material(youngs_modulus=200e9, poisson_ratio=0.3, density=7800.0)
LAW = Thornton(yield_pressure=1e9)
#: Two equal spheres, of which one strikes the other.
PAIR = sw.Chain(material=STEEL, radius=5e-3, granules=[sw.Segment()], contact=LAW)


#: Their contact: E* = E/(2 (1 - nu^2)), R* = R/2, m* = m/2, and k of Hertz's law.
MASS = sw.Chain(material=STEEL, radius=5e-3).granule_mass
MODULUS, RADIUS = 200e9 / (2 * 0.91), 2.5e-3
PAIRS = Pairs(
    moduli=np.array([MODULUS]),
    radii=np.array([RADIUS]),
    masses=np.array([MASS / 2]),
    stiffnesses=np.array([4 / 3 * MODULUS * math.sqrt(RADIUS)]),
    exponents=np.array([1.5]),
)


def _yield_velocity() -> float:
    """Relative velocity at which a collision just yields: m* v^2 / 2 = 2/5 F_y d_y."""
    overlap, force = LAW.first_yield(PAIRS)
    return float(np.sqrt(4 / 5 * force * overlap / PAIRS.masses)[0])


def test_first_yield_is_that_of_the_limiting_pressure() -> None:
    overlap, force = LAW.first_yield(PAIRS)
    # the pressure of Hertz at the centre of the contact, 3 F / (2 pi a^2) with a^2 = R* d
    assert 3 * force / (2 * math.pi * PAIRS.radii * overlap) == pytest.approx([1e9], rel=1e-12)
    assert force == pytest.approx(math.pi**3 * 1e27 * PAIRS.radii**2 / (6 * PAIRS.moduli**2), rel=1e-12)


def test_a_sphere_on_a_heavy_wall_has_the_published_yield_velocity() -> None:
    # v_y = (pi / (2 E*))^2 (2 / (5 rho))^(1/2) p^(5/2), with m* the mass of the sphere
    overlap, force = LAW.first_yield(PAIRS)
    mass = 4 / 3 * math.pi * STEEL.density * PAIRS.radii**3
    published = (math.pi / (2 * PAIRS.moduli)) ** 2 * math.sqrt(2 / (5 * STEEL.density)) * 1e9**2.5
    assert np.sqrt(4 / 5 * force * overlap / mass) == pytest.approx(published, rel=1e-12)


class TestContract(ContactLawContract):
    #: Far beyond first yield, just beyond it, and below.
    laws: ClassVar = [Thornton(yield_pressure=pressure) for pressure in (1e9, 2.5e9, 1e12)]


@pytest.mark.parametrize("end", ["", "end: {wall: same}, "], ids=["free", "wall"])
def test_a_striker_on_forty_beads_of_a_scenario(end: str, tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(
        f"chain: {{material: stainless-steel-316, diameter: 9.5 mm, granules: 40, {end}"
        "contact: {model: thornton, yield_pressure: 1 GPa}}\nimpact: {velocity: 1 m/s}\n"
    )
    scene = sw.load_scenario(file)
    result: Any = sw.simulate(scene.excitation, scene.chain, rtol=1e-4, until=60e-6)
    # a run at rtol 1e-6; the tolerance of this one
    assert result.greatest_force.peak_force == pytest.approx(117.48216, rel=1e-4)


def test_a_chain_that_does_not_yield_is_that_of_hertz() -> None:
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=10.0, rise_time=20e-6)
    hard = Thornton(yield_pressure=1e12)
    parts = [sw.Segment(count=5)]
    chains = (
        sw.Chain(material=STEEL, radius=5e-3, granules=parts, end=sw.Wall(), **law)
        for law in ({"contact": hard}, {"damping": sw.Dashpot(coefficient=0.0)})
    )
    thornton, hertz = (
        [peak.peak_force for peak in sw.simulate(shock, chain, rtol=1e-8, contacts=range(5)).contacts]
        for chain in chains
    )
    # both are a hundred times as accurate as rtol, until late collisions amplify the errors
    assert thornton == pytest.approx(hertz, rel=2e-9)


def _published(ratio: float) -> float:
    """Thornton's restitution for the ratio v_y/v."""
    first = math.sqrt(6 * math.sqrt(3) / 5) * math.sqrt(1 - ratio**2 / 6)
    return first * (ratio / (ratio + 2 * math.sqrt(6 / 5 - ratio**2 / 5))) ** 0.25


@pytest.mark.parametrize("ratio", [0.8, 0.3, 0.1, 0.03, 0.01])
def test_restitution_is_the_published_curve(ratio: float) -> None:
    impact = sw.Impact(velocity=_yield_velocity() / ratio)
    result = sw.simulate(impact, PAIR, rtol=1e-7)
    # rtol is that of the force; the velocities differ by up to 10 rtol, since the law has kinks within steps
    assert result.restitution == pytest.approx(_published(ratio), rel=5e-6)


def test_slower_collisions_are_elastic() -> None:
    result = sw.simulate(sw.Impact(velocity=0.9 * _yield_velocity()), PAIR, rtol=1e-6)
    assert result.restitution == pytest.approx(1.0, rel=1e-5)
