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
from shockwave.base.errors import InvalidValueError, NotCoveredError
from shockwave.scene.contact_law import BoundLaw, ContactLaw, Hertz, Pairs
from shockwave.scene.coverage_rules import reduced
from shockwave.scene.damping import tsuji_ratio
from shockwave.scene.layout import Layout
from shockwave.scene.scene import Scene
from support.scenes import CHAIN, STEEL, triangle

PTFE = sw.Material(youngs_modulus=1.46e9, poisson_ratio=0.46, density=2178.0)
SHOCK = triangle(3.0)
RADIUS = CHAIN.radius
SQUARE = sw.PowerContact(exponent=2, stiffness=1e7)
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
    made = chain(sw.Segment(), sw.Segment(count=2, gap=1e-5), sw.Segment(gap=3e-5), end=sw.Wall())
    assert Layout.of(made, SHOCK).overlaps.tolist() == [0, -1e-5, -1e-5, -3e-5]
    free = attrs.evolve(made, end=None)
    assert Layout.of(free, SHOCK).overlaps.tolist() == [0, -1e-5, -1e-5]


# ---------------------------------------------------------------- damping


def test_dampings_have_their_coefficients_and_powers() -> None:
    kuwabara = Layout.of(chain(damping=sw.KuwabaraKono(time=2e-6)), SHOCK)
    assert kuwabara.damping_power == 0.5
    assert kuwabara.damping_coefficients == pytest.approx(1.5 * 2e-6 * kuwabara.pairs.stiffnesses, rel=ROUNDINGS)
    dashpot = Layout.of(chain(damping=sw.Dashpot(coefficient=6.0)), SHOCK)
    assert (dashpot.damping_power, dashpot.damping_coefficients.tolist()) == (0.0, [6.0] * 3)
    contact = sw.PowerContact(exponent=2.5, stiffness=1e9)
    other = Layout.of(chain(damping=sw.KuwabaraKono(time=2e-6), contact=contact), SHOCK)
    assert other.damping_power == 1.5
    assert other.damping_coefficients == pytest.approx([2.5 * 2e-6 * 1e9] * 3, rel=ROUNDINGS)
    uneven = chain(sw.Segment(), sw.Segment(radius=1e-3), end=sw.Wall(), damping=sw.Tsuji(restitution=0.5))
    tsuji = Layout.of(uneven, SHOCK)
    expected = math.sqrt(5) * tsuji_ratio(0.5) * np.sqrt(tsuji.pairs.masses * tsuji.pairs.stiffnesses)
    assert tsuji.damping_power == 0.25
    assert tsuji.damping_coefficients == pytest.approx(expected.tolist(), rel=ROUNDINGS)


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


# ---------------------------------------------------------------- laws of plugins


@attrs.frozen(kw_only=True)
class Worn(ContactLaw):
    """A law that softens with the greatest overlap."""

    states = 1

    def force(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        return pairs.stiffnesses * overlap * (1 - state[0]) - 0.5 * closing_velocity

    def update(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        return np.maximum(state, overlap)


def test_a_law_is_evaluated_in_scaled_units() -> None:
    layout = Layout.of(chain(contact=Worn()), SHOCK)
    assert layout.law == Worn()
    law = BoundLaw(layout.law, layout.pairs, length=1.0, velocity=1.0, unit_force=1.0)
    assert law.initial_state().shape == (1, 3)
    overlap, velocity, state = np.array([1e-6, -1e-6, 1e-6]), np.array([0.1, 0.0, 1e6]), np.array([[0.5, 0.0, 0.0]])
    forces = law.force(overlap, velocity, state)
    # neither an open contact nor an attraction has a force
    assert forces.tolist() == [pytest.approx(0.5e-6 * CHAIN.contact_stiffness - 0.05, rel=ROUNDINGS), 0.0, 0.0]
    scaled = attrs.evolve(law, length=1e-6, velocity=0.1, unit_force=2.0)
    assert scaled.force(overlap / 1e-6, velocity / 0.1, state) == pytest.approx(forces / 2, rel=ROUNDINGS)
    assert scaled.update(overlap / 1e-6, velocity / 0.1, np.zeros((1, 3))) == pytest.approx(
        np.array([[1e-6, 0, 1e-6]]), rel=ROUNDINGS
    )


# ---------------------------------------------------------------- equal granules among other chains


def test_segments_of_equal_granules_are_a_number_of_granules() -> None:
    made = chain(sw.Segment(count=3), sw.Cell(repeat=2, cell=[sw.Segment(radius=RADIUS), sw.Segment(material=STEEL)]))
    assert not made.is_uniform
    assert made.count == 7
    assert reduced(made) == attrs.evolve(CHAIN, granules=7)
    smaller = chain(sw.Segment(count=5, radius=1e-3))
    assert reduced(smaller) == sw.Chain(material=STEEL, radius=1e-3, granules=5)
    assert chain(contact=Hertz()) == chain()


FURTHER: dict[str, dict[str, Any]] = {
    "granules[1]": {"granules": [sw.Segment(), sw.Segment(radius=1e-3)]},
    "granules[0]": {"granules": [sw.Segment(count=2, radius=sw.Taper(first=1e-3, last=2e-3))]},
    "granules[0].cell[1]": {"granules": [sw.Cell(repeat=2, cell=[sw.Segment(), sw.Segment(material=PTFE)])]},
    "granules[0].gap": {"granules": [sw.Segment(count=4, gap=1e-6)]},
    "end": {"end": sw.Wall()},
    "precompression": {"precompression": 1.0},
    "damping": {"damping": sw.Dashpot(coefficient=1.0)},
    "contact": {"contact": SQUARE},
}


@pytest.mark.parametrize("path", FURTHER)
def test_methods_for_equal_granules_refuse_every_further_feature(path: str) -> None:
    made = sw.Chain(material=STEEL, radius=RADIUS, **{"granules": 4, **FURTHER[path]})
    assert reduced(made) is None
    message = r"must be left out for a test, which covers only shocks on chains of equal granules with free ends \(got "
    with pytest.raises(NotCoveredError, match=message) as caught:
        Scene(excitation=SHOCK, chain=made).covered("a test")
    assert [fault.path for fault in caught.value.faults] == [f"chain.{path}"]
    with pytest.raises(NotCoveredError, match=r"^impact: must be left out"):
        Scene(excitation=sw.Impact(velocity=1.0), chain=attrs.evolve(CHAIN, granules=4)).covered("a test")
    predictor = sw.Predictor(model="section-4")
    with pytest.raises(NotCoveredError, match="must be left out for section 4"):
        predictor.predict(SHOCK, made)
    (refused,) = predictor.predict_many([SHOCK], made)
    assert [fault.path for fault in refused.faults] == [f"chain.{path}"]
    outcome = sw.Predictor().predict(SHOCK, made)
    assert [fault.path for fault in outcome.section4_faults] == [f"chain.{path}"]
    assert outcome.greatest_force == sw.simulate(SHOCK, made).greatest_force
    assert sw.compare(SHOCK, made).predicted is None


def test_segments_of_equal_granules_are_predicted_like_their_number() -> None:
    one, other = (sw.predict(SHOCK, each) for each in (chain(), attrs.evolve(CHAIN, granules=4)))
    assert one.to_dict() == other.to_dict()
    assert sw.Predictor().predict_many([SHOCK], chain()) == [other]


# ---------------------------------------------------------------- wrong chains

WRONG: dict[str, tuple[dict[str, Any], str, str]] = {
    "wall-of-an-endless-chain": ({"granules": None, "end": sw.Wall()}, "end", "must be left out for an endless"),
    "gravity-without-a-wall": ({"gravity": 9.81}, "gravity", "must be 0 for a chain with a free end"),
    "tsuji-without-hertz": (
        {"damping": sw.Tsuji(restitution=0.9), "contact": SQUARE}, "damping.model", "(got tsuji, exponent 2)"
    ),
    "too-many-granules": ({"granules": 2_000_000, "end": sw.Wall()}, "granules", "must be <= 1000000"),
    "both-sizes": ({"diameter": 1e-3}, "diameter", "must be left out if radius is given"),
    "gap-under-gravity": (
        {"granules": [sw.Cell(repeat=2, cell=[sw.Segment(gap=1e-6)])], "gravity": 1.0, "end": sw.Wall()},
        "granules[0].cell[0].gap",
        "must be 0 under gravity",
    ),
    "law-with-damping": ({"contact": Worn(), "damping": sw.Dashpot(coefficient=1.0)}, "damping", "Worn"),
    "law-under-precompression": ({"contact": Worn(), "precompression": 1.0}, "precompression", "Worn"),
    "too-many-in-segments": ({"granules": [sw.Segment(count=10**6)] * 2}, "granules", "at most 1000000 granules"),
    "no-segments": ({"granules": [sw.Segment(), 3]}, "granules[1]", "must be a Segment or a Cell (got 3)"),
    "no-wall": ({"end": "rigid"}, "end", "must be a Wall (got 'rigid')"),
    "no-damping": ({"damping": 0.9}, "damping", "must be a KuwabaraKono"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_chain_is_refused_with_the_place(name: str) -> None:
    features, path, part = WRONG[name]
    with pytest.raises(InvalidValueError) as caught:
        sw.Chain(**{"material": STEEL, "radius": RADIUS, "granules": 4, **features})
    assert str(caught.value).startswith(f"{path}: ")
    assert part in str(caught.value)


def test_all_errors_of_a_chain_are_reported_together() -> None:
    with pytest.raises(InvalidValueError) as caught:
        chain(sw.Segment(gap=1e-6), sw.Segment(gap=1e-6), gravity=1.0)
    assert [fault.path for fault in caught.value.faults] == ["gravity", "granules[0].gap", "granules[1].gap"]


@pytest.mark.parametrize(
    ("part", "values", "message"),
    [
        (sw.Taper, {"first": 1, "last": 2, "spacing": "even"}, "spacing: must be linear or geometric"),
        (sw.Segment, {"radius": sw.Taper(first=1, last=2)}, r"count: must be >= 2 for a taper \(got 1\)"),
        (sw.Cell, {"repeat": 2, "cell": []}, "cell: must be a list of one or more Segment objects"),
        (sw.Wall, {"stiffness": 1e6}, "stiffness: must be left out for a fixed wall"),
        (sw.Tsuji, {"restitution": 0}, "restitution: must be > 0 and <= 1"),
        (sw.PowerContact, {"exponent": 0.5, "stiffness": 1}, "exponent: must be >= 1 and <= 10"),
    ],
    ids=["taper", "segment", "cell", "wall", "damping", "contact"],
)
def test_a_wrong_part_is_refused_with_its_rule(part: Any, values: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{message}"):
        part(**values)


def test_a_scene_without_a_contact_is_refused() -> None:
    with pytest.raises(InvalidValueError, match=r"^chain.granules: must be given, because a striker needs a finite"):
        Layout.of(CHAIN, sw.Impact(velocity=1.0))
    with pytest.raises(InvalidValueError, match=r"^chain.granules: must give a contact \(got 1 granule"):
        Layout.of(chain(sw.Segment()), SHOCK)


def test_chains_with_features_are_values() -> None:
    one, other = (chain(sw.Segment(count=2, diameter=1e-3), end=sw.Wall(mass=1.0)) for _ in range(2))
    assert one == other
    assert hash(one) == hash(other)
    assert attrs.evolve(one, precompression=1.0) != one
    assert sw.Chain(material=STEEL, diameter=2 * RADIUS) == CHAIN
