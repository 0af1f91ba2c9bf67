"""The layout of finite chains: closed forms of masses, stiffnesses, static loads and damping coefficients."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import attrs
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import shockwave as sw
from shockwave.base.errors import InvalidValueError
from shockwave.scene.damping import tsuji_ratio
from shockwave.scene.elastic_plastic import Loading
from shockwave.scene.layout import Layout, mass_and_length
from support.scenes import CHAIN, STEEL, triangle

PTFE = sw.Material(youngs_modulus=1.46e9, poisson_ratio=0.46, density=2178.0)
SHOCK = triangle(3.0)
RADIUS = CHAIN.radius
#: A few products, quotients and roots: each rounds once.
ROUNDINGS = 1e-14


def chain(*granules: Any, **features: Any) -> sw.Chain:
    return sw.Chain(material=STEEL, radius=RADIUS, granules=granules or (sw.Segment(count=4),), **features)


def stiffness(one: sw.Material, other: sw.Material | None, curvature: float) -> float:
    """Hertz's stiffness of two bodies, the second one rigid if it is None; ``curvature`` is 1/R*."""
    bodies = [one] if other is None else [one, other]
    compliance = sum((1 - body.poisson_ratio**2) / body.youngs_modulus for body in bodies)
    return 4 / 3 / compliance / math.sqrt(curvature)


def test_contacts_between_different_spheres_have_hertz_s_stiffness() -> None:
    layout = Layout.of(chain(sw.Segment(), sw.Segment(material=PTFE, diameter=4e-3)), SHOCK)
    volumes = [4 / 3 * math.pi * radius**3 for radius in (RADIUS, 2e-3)]
    assert layout.masses == pytest.approx([STEEL.density * volumes[0], PTFE.density * volumes[1]], rel=ROUNDINGS)
    assert layout.pairs.stiffnesses == pytest.approx([stiffness(STEEL, PTFE, 1 / RADIUS + 1 / 2e-3)], rel=ROUNDINGS)
    assert layout.pairs.masses == pytest.approx([1 / (1 / layout.masses).sum()], rel=ROUNDINGS)


@pytest.mark.parametrize(
    ("material", "expected"),
    [
        ("same", stiffness(PTFE, PTFE, 1 / RADIUS)),
        ("rigid", stiffness(PTFE, None, 1 / RADIUS)),
        (STEEL, stiffness(PTFE, STEEL, 1 / RADIUS)),
    ],
    ids=["same", "rigid", "other"],
)
def test_a_wall_is_flat_and_the_last_contact(material: Any, expected: float) -> None:
    layout = Layout.of(chain(sw.Segment(count=2), sw.Segment(material=PTFE), end=sw.Wall(material=material)), SHOCK)
    assert len(layout.pairs.stiffnesses) == len(layout.masses) == 3
    assert layout.pairs.stiffnesses[-1] == pytest.approx(expected, rel=ROUNDINGS)
    assert layout.pairs.masses[-1] == pytest.approx(layout.masses[-1], rel=ROUNDINGS)
    movable = Layout.of(chain(end=sw.Wall(material=material, mass=CHAIN.granule_mass)), SHOCK)
    assert movable.pairs.masses[-1] == pytest.approx(CHAIN.granule_mass / 2, rel=ROUNDINGS)


def test_equal_granules_have_the_mass_and_stiffness_of_their_chain() -> None:
    layout = Layout.of(chain(sw.Segment(count=3), sw.Cell(repeat=2, cell=[sw.Segment()])), SHOCK)
    assert layout.masses.tolist() == [CHAIN.granule_mass] * 5
    assert layout.pairs.stiffnesses == pytest.approx([CHAIN.contact_stiffness] * 4, rel=ROUNDINGS)


def test_granules_are_numbered_from_the_struck_end() -> None:
    cell = sw.Cell(repeat=2, cell=[sw.Segment(radius=1e-3), sw.Segment(count=2, radius=2e-3)])
    layout = Layout.of(chain(sw.Segment(material=PTFE), cell, sw.Segment(radius=3e-3)), sw.Impact(velocity=1.0))
    # a striker takes size and material of the chain
    assert layout.radii.tolist() == [RADIUS, RADIUS, 1e-3, 2e-3, 2e-3, 1e-3, 2e-3, 2e-3, 3e-3]
    assert layout.materials == (STEEL, PTFE, *[STEEL] * 7)
    assert layout.segments == (-1, 0, 1, 1, 1, 1, 1, 1, 2)
    assert layout.velocity == 1.0
    assert Layout.of(chain(), sw.Impact(velocity=1.0, radius=4e-3)).radii[0] == 4e-3


def test_tapers_have_equal_differences_or_equal_ratios() -> None:
    linear, geometric = (
        Layout.of(chain(sw.Segment(count=5, diameter=sw.Taper(first=8e-3, last=2e-3, spacing=spacing))), SHOCK).radii
        for spacing in ("linear", "geometric")
    )
    assert linear == pytest.approx([4e-3, 3.25e-3, 2.5e-3, 1.75e-3, 1e-3], rel=ROUNDINGS)
    assert geometric == pytest.approx([4e-3 * 4 ** (-index / 4) for index in range(5)], rel=ROUNDINGS)
    assert (linear[0], geometric[0], linear[-1], geometric[-1]) == (4e-3, 4e-3, 1e-3, 1e-3)


# ---------------------------------------------------------------- static loads and gaps


@pytest.mark.parametrize("exponent", [None, 2.0], ids=["hertz", "power-law"])
def test_static_overlaps_carry_precompression_and_the_weight_above(exponent: float | None) -> None:
    contact = None if exponent is None else sw.PowerContact(exponent=exponent, stiffness=1e7)
    made = chain(sw.Segment(count=3), end=sw.Wall(), precompression=2.0, gravity=9.81, contact=contact)
    layout = Layout.of(made, SHOCK)
    expected = [2 + 9.81 * CHAIN.granule_mass * number for number in (1, 2, 3)]
    assert layout.static_forces == pytest.approx(expected, rel=ROUNDINGS)
    carried = layout.pairs.stiffnesses * layout.overlaps ** (exponent or 1.5)
    assert carried == pytest.approx(expected, rel=ROUNDINGS)


def test_a_striker_neither_carries_nor_weighs() -> None:
    made = chain(sw.Segment(count=2), end=sw.Wall(), precompression=2.0, gravity=10.0)
    static = Layout.of(made, sw.Impact(velocity=1.0, radius=2 * RADIUS)).static_forces
    weight = 10 * CHAIN.granule_mass
    assert static == pytest.approx([0.0, 2 + weight, 2 + 2 * weight], rel=ROUNDINGS)
    assert Layout.of(chain(precompression=5.0), SHOCK).static_forces.tolist() == [5.0] * 3


def test_a_gap_follows_each_granule_of_its_segment() -> None:
    made = chain(sw.Segment(), sw.Segment(count=2, gap=1e-5), sw.Segment(gap=3e-5, radius=2 * RADIUS), end=sw.Wall())
    assert Layout.of(made, SHOCK).overlaps.tolist() == [0, -1e-5, -1e-5, -3e-5]
    free = attrs.evolve(made, end=None)
    assert Layout.of(free, SHOCK).overlaps.tolist() == [0, -1e-5, -1e-5]
    assert mass_and_length(made) == pytest.approx((11 * CHAIN.granule_mass, 10 * RADIUS + 5e-5), rel=ROUNDINGS)


# ---------------------------------------------------------------- damping


def test_dampings_have_their_coefficients_and_powers() -> None:
    kuwabara = Layout.of(chain(damping=sw.KuwabaraKono(time=2e-6)), SHOCK)
    assert kuwabara.damping_powers.tolist() == [0.5] * 3
    assert kuwabara.damping_coefficients == pytest.approx(1.5 * 2e-6 * kuwabara.pairs.stiffnesses, rel=ROUNDINGS)
    dashpot = Layout.of(chain(damping=sw.Dashpot(coefficient=6.0)), SHOCK)
    assert (dashpot.damping_powers.tolist(), dashpot.damping_coefficients.tolist()) == ([0.0] * 3, [6.0] * 3)
    contact = sw.PowerContact(exponent=2.5, stiffness=1e9)
    other = Layout.of(chain(damping=sw.KuwabaraKono(time=2e-6), contact=contact), SHOCK)
    assert other.damping_powers.tolist() == [1.5] * 3
    assert other.damping_coefficients == pytest.approx([2.5 * 2e-6 * 1e9] * 3, rel=ROUNDINGS)
    uneven = chain(sw.Segment(), sw.Segment(radius=1e-3), end=sw.Wall(), damping=sw.Tsuji(restitution=0.5))
    tsuji = Layout.of(uneven, SHOCK)
    expected = math.sqrt(5) * tsuji_ratio(0.5) * np.sqrt(tsuji.pairs.masses * tsuji.pairs.stiffnesses)
    assert tsuji.damping_powers.tolist() == [0.25] * 2
    assert tsuji.damping_coefficients == pytest.approx(expected.tolist(), rel=ROUNDINGS)


# ---------------------------------------------------------------- laws of segments

POWER = sw.PowerContact(exponent=2.0, stiffness=1e9)


def test_a_segment_s_laws_hold_between_each_of_its_granules_and_the_next_one_or_the_wall() -> None:
    dashpot, viscous = sw.Dashpot(coefficient=6.0), sw.KuwabaraKono(time=2e-6)
    own = sw.Segment(count=2, contact=POWER, damping=dashpot)
    cell = sw.Cell(repeat=2, cell=[sw.Segment(contact=sw.Hertz()), own])
    layout = Layout.of(chain(cell, end=sw.Wall(), damping=viscous), sw.Impact(velocity=1.0))
    assert layout.pairs.exponents.tolist() == [1.5, 1.5, 2, 2, 1.5, 2, 2]  # the striker's contact has the chain's law
    assert layout.pairs.stiffnesses[[2, 6]].tolist() == [1e9, 1e9]
    assert layout.damping_powers.tolist() == [0.5, 0.5, 0, 0, 0.5, 0, 0]
    assert layout.damping_coefficients[[2, 6]].tolist() == [6.0, 6.0]
    # the chain's damping has the stiffness and the exponent of each contact
    viscous_only = Layout.of(chain(sw.Segment(count=2, contact=POWER), damping=viscous), SHOCK)
    assert viscous_only.damping_coefficients == pytest.approx([2 * 2e-6 * 1e9], rel=ROUNDINGS)


def test_hertz_in_a_segment_replaces_the_law_of_the_chain() -> None:
    layout = Layout.of(chain(sw.Segment(contact=sw.Hertz()), sw.Segment(count=2), contact=POWER), SHOCK)
    assert layout.pairs.exponents.tolist() == [1.5, 2.0]
    assert layout.pairs.stiffnesses == pytest.approx([CHAIN.contact_stiffness, 1e9], rel=ROUNDINGS)


def test_a_chain_of_equal_granules_whose_laws_differ_is_not_uniform() -> None:
    plain = chain(sw.Segment(), sw.Segment(count=3))
    assert sw.simulate(SHOCK, plain).wave is not None
    laws: list[dict[str, Any]] = [{"contact": sw.Hertz()}, {"damping": sw.Dashpot(coefficient=0.0)}]
    for each in laws:
        assert sw.simulate(SHOCK, chain(sw.Segment(), sw.Segment(count=3, **each))).wave is None


# ---------------------------------------------------------------- elastic-plastic contacts

HARD, SOFT = (
    attrs.evolve(STEEL, yield_strength=strength, rate_constant=rate) for strength, rate in ((2e9, 0.04), (6e8, 0.02))
)


def test_the_softer_body_and_its_rate_constant_count() -> None:
    parts = [sw.Segment(material=HARD), sw.Segment(material=SOFT, radius=2e-3), sw.Segment(), sw.Segment(count=2)]
    layout = Layout.of(chain(*parts, contact=sw.ElasticPlastic(), end=sw.Wall(material=HARD)), SHOCK)
    assert layout.plastic is not None
    assert layout.plastic.strengths.tolist() == [6e8, 6e8, math.inf, math.inf, 2e9]
    assert layout.plastic.rate_constants[[0, 1, 4]].tolist() == [0.02, 0.02, 0.04]
    assert layout.plastic.lengths[[0, 4]].tolist() == [RADIUS + 2e-3, RADIUS]
    # of equally strong bodies, that with the smaller rate constant flows first
    equal = attrs.evolve(SOFT, rate_constant=0.0)
    for pair in ((SOFT, equal), (equal, SOFT)):
        pairs = Layout.of(chain(*(sw.Segment(material=body) for body in pair), contact=sw.ElasticPlastic()), SHOCK)
        assert pairs.plastic is not None
        assert pairs.plastic.rate_constants.tolist() == [0.0]


def test_elastic_plastic_contacts_may_be_those_of_one_segment_alone() -> None:
    own = sw.Segment(material=SOFT, contact=sw.ElasticPlastic())
    layout = Layout.of(chain(sw.Segment(material=SOFT), own, sw.Segment(count=2, material=SOFT)), SHOCK)
    assert layout.plastic is not None
    assert layout.plastic.strengths.tolist() == [math.inf, 6e8, math.inf]
    assert Layout.of(chain(), SHOCK).plastic is None


@pytest.mark.parametrize("force", [0.5, 50.0, 5000.0], ids=["elastic", "flowing", "fully-plastic"])
def test_static_overlaps_of_elastic_plastic_contacts_carry_the_static_force(force: float) -> None:
    beads = chain(sw.Segment(count=3, material=SOFT), contact=sw.ElasticPlastic(), precompression=force)
    layout = Layout.of(beads, SHOCK)
    pairs, strengths = layout.pairs, 6e8 / layout.pairs.moduli
    assert Loading(pairs.stiffnesses, pairs.radii, strengths).force(layout.overlaps) == pytest.approx([force] * 2)
    hertz = (force / pairs.stiffnesses) ** (2 / 3)
    assert (layout.overlaps > 1.01 * hertz).all() == (force > 10)


@pytest.mark.parametrize("restitution", [0.99, 0.9, 0.5, 0.136, 0.13, 0.01])
def test_tsuji_s_coefficient_gives_the_restitution_of_an_integrated_collision(restitution: float) -> None:
    # m = k = v = 1; up to the end of the collision, where the total force vanishes
    coefficient = math.sqrt(5) * tsuji_ratio(restitution)

    def motion(_: float, state: Any) -> Any:
        overlap = max(state[0], 0.0)
        return state[1], -(overlap**1.5) - coefficient * overlap**0.25 * state[1]

    def force(_: float, state: Any) -> float:
        return max(state[0], 0.0) ** 1.25 + coefficient * state[1]

    force.terminal = True  # type: ignore[attr-defined]
    force.direction = -1  # type: ignore[attr-defined]
    found = solve_ivp(motion, (0, 1e5), (1e-12, 1.0), "LSODA", rtol=1e-11, atol=1e-14, events=force)
    # the tolerance of the integration, and its start at a small overlap
    assert -found.y[1, -1] == pytest.approx(restitution, rel=1e-6)


def test_tsuji_s_ratio_is_that_of_the_linear_oscillator() -> None:
    assert tsuji_ratio(1.0) == 0.0
    # e = exp(-2) belongs to critical damping; there the root is flat, with half the digits
    assert tsuji_ratio(math.exp(-2)) == pytest.approx(1.0, abs=1e-7)
    for low, high in pairwise([0.999, 0.7, 0.2, 0.1353, 0.05, 1e-6]):
        assert tsuji_ratio(low) < tsuji_ratio(high)
    ratio = tsuji_ratio(0.8)
    angle = math.asin(ratio)
    assert math.exp(-(math.pi - 2 * angle) * math.tan(angle)) == pytest.approx(0.8, rel=ROUNDINGS)


def test_a_scene_without_a_contact_is_refused() -> None:
    with pytest.raises(InvalidValueError, match=r"^chain.granules: must be given, because a striker needs a finite"):
        Layout.of(CHAIN, sw.Impact(velocity=1.0))
    with pytest.raises(InvalidValueError, match=r"^chain.granules: must give a contact \(got 1 granule"):
        Layout.of(chain(sw.Segment()), SHOCK)
