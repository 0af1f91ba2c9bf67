"""The chain: its contact law and A of eq. (4c), the scales of eq. (1), and wrong values, parts and features."""

from __future__ import annotations

import math
from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave.base.errors import InvalidValueError
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.material import Material
from support.scenes import CHAIN as BEADS
from support.scenes import STEEL

SQUARE = sw.PowerContact(exponent=2, stiffness=1e7)
AUXETIC = Material(youngs_modulus=5e7, poisson_ratio=-0.7, density=120.0)
CHAINS = pytest.mark.parametrize("chain", [BEADS, Chain(material=AUXETIC, radius=0.3)], ids=["paper", "auxetic"])


@CHAINS
def test_mass_contact_stiffness_and_momentum_parameter_are_those_of_spheres(chain: Chain) -> None:
    # Products of a handful of numbers and one root: a few roundings each.
    volume = math.pi * (2 * chain.radius) ** 3 / 6
    assert chain.granule_mass == pytest.approx(volume * chain.material.density, rel=1e-15)
    # Hertz for any two spheres: 4/3 E* sqrt(R*), with 1/E* and 1/R* sums over both.
    joint_modulus = chain.material.youngs_modulus / (2 * (1 - chain.material.poisson_ratio**2))
    assert chain.contact_stiffness == pytest.approx(4 / 3 * joint_modulus * math.sqrt(chain.radius / 2), rel=1e-15)
    # A of eq. (4c)
    group = chain.material.density**1.5 * chain.radius**4 / (2 * joint_modulus)
    assert chain.momentum_parameter(13 / 3) == pytest.approx(13 / 3 * group ** (1 / 3), rel=2e-15)


@CHAINS
def test_scaled_equation_of_motion_has_unit_coefficients(chain: Chain) -> None:
    # m x'' = k d^(3/2): a granule under the unit force moves the unit overlap in the unit time.
    scales = Scales.of(chain, 70.0)
    overlap = (scales.force / chain.contact_stiffness) ** (2 / 3)
    # A few roundings each, here and below.
    assert scales.mass * overlap / scales.time**2 == pytest.approx(scales.force, rel=3e-15)
    assert scales.momentum == pytest.approx(scales.mass * scales.velocity, rel=1e-15)
    assert scales.energy == pytest.approx(scales.mass * scales.velocity**2, rel=1e-15)
    assert scales.wave_speed == pytest.approx(2 * chain.radius / scales.time, rel=1e-15)


def test_beads_of_the_paper_have_its_times() -> None:
    # to the digits given: A F0^(-1/6) at 100 N with the paper's 13/3, and T0
    assert BEADS.momentum_parameter(13 / 3) * 100 ** (-1 / 6) == pytest.approx(24.024e-6, abs=0.5e-9)
    assert Scales.of(BEADS, 100.0).time == pytest.approx(14.58e-6, abs=0.5e-8)


@pytest.mark.parametrize("lam", [1e-6, 0.3, 1e6], ids=str)
@pytest.mark.parametrize(
    ("attribute", "power"),
    [("time", -1 / 4), ("velocity", 5 / 4), ("momentum", 5 / 4), ("energy", 5 / 2), ("wave_speed", 1 / 4)],
)
def test_scales_follow_the_symmetry_of_eq_1(lam: float, attribute: str, power: float) -> None:
    # x -> lam x, t -> lam^(-1/4) t, F -> lam^(3/2) F leaves eq. (1) unchanged.
    before, after = Scales.of(BEADS, 7.0), Scales.of(BEADS, lam**1.5 * 7.0)
    # Powers of numbers up to 1e15.
    assert getattr(after, attribute) == pytest.approx(lam**power * getattr(before, attribute), rel=1e-13)


@pytest.mark.parametrize("radius", [1e-150, 1e103], ids=str)
def test_a_size_beyond_floating_point_numbers_is_refused(radius: float) -> None:
    with pytest.raises(InvalidValueError, match=r"^radius: must give granules a mass"):
        Chain(material=STEEL, radius=radius)


@pytest.mark.parametrize(
    ("scene", "name", "value", "rule"),
    [
        *((STEEL, "youngs_modulus", value, ">= 1e-30 and <= 1e+30 Pa") for value in (0, math.nan, math.inf)),
        (STEEL, "youngs_modulus", True, "a stress, such as '193 GPa'"),
        *((STEEL, "poisson_ratio", value, "> -1 and < 0.5") for value in (-1, 0.5)),
        (STEEL, "density", [0.3], "a density, such as '7958 kg/m**3'"),
        (BEADS, "radius", 0, "> 0 m"),
        *((BEADS, "granules", value, "a whole number >= 1") for value in (0, 2.5)),
        (BEADS, "material", 302, "a Material"),
    ],
    ids=lambda value: "" if isinstance(value, Material | Chain) else repr(value),
)
def test_a_wrong_value_is_refused_with_its_rule(scene: Any, name: str, value: object, rule: str) -> None:
    with pytest.raises(InvalidValueError) as caught:
        attrs.evolve(scene, **{name: value})
    assert str(caught.value).startswith(f"{name}: must be {rule}")
    assert f"(got {value!r}" in str(caught.value)


@attrs.frozen
class Law(sw.ContactLaw):
    """A law of a plugin."""

    def force(self, *_: Any) -> Any:
        return 0.0


WRONG: dict[str, tuple[dict[str, Any], str, str]] = {
    "both-sizes": ({"diameter": 1e-3}, "diameter", "must be left out if radius is given"),
    "gap-under-gravity": (
        {"granules": [sw.Cell(repeat=2, cell=[sw.Segment(gap=1e-6)])], "gravity": 1.0, "end": sw.Wall()},
        "granules[0].cell[0].gap",
        "must be 0 under gravity",
    ),
    "law-with-damping": ({"contact": Law(), "damping": sw.Dashpot(coefficient=1.0)}, "damping", "Law"),
    "law-under-precompression": ({"contact": Law(), "precompression": 1.0}, "precompression", "Law"),
    "too-many-in-segments": ({"granules": [sw.Segment(count=10**6)] * 2}, "granules", "at most 1000000 granules"),
    "no-segments": ({"granules": [sw.Segment(), 3]}, "granules[1]", "must be a Segment or a Cell (got 3)"),
    "no-wall": ({"end": "rigid"}, "end", "such as sw.Wall(material='same') (got 'rigid')"),
    "no-damping": ({"damping": 0.9}, "damping", "must be a KuwabaraKono"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_chain_is_refused_with_the_place(name: str) -> None:
    features, path, part = WRONG[name]
    with pytest.raises(InvalidValueError) as caught:
        sw.Chain(**{"material": STEEL, "radius": BEADS.radius, "granules": 4, **features})
    assert str(caught.value).startswith(f"{path}: ")
    assert part in str(caught.value)


def test_all_errors_of_a_chain_are_reported_together() -> None:
    with pytest.raises(InvalidValueError) as caught:
        attrs.evolve(BEADS, granules=[sw.Segment(gap=1e-6), sw.Segment(gap=1e-6)], gravity=1.0)
    assert [fault.path for fault in caught.value.faults] == ["gravity", "granules[0].gap", "granules[1].gap"]


@pytest.mark.parametrize(
    ("part", "values", "message"),
    [
        (sw.Taper, {"first": 1, "last": 2, "spacing": "even"}, "spacing: must be linear or geometric"),
        (sw.Tsuji, {"restitution": 0}, "restitution: must be > 0 and <= 1"),
        (sw.PowerContact, {"exponent": 0.5, "stiffness": 1}, "exponent: must be >= 1 and <= 10"),
    ],
    ids=["taper", "damping", "contact"],
)
def test_a_wrong_part_is_refused_with_its_rule(part: Any, values: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{message}"):
        part(**values)


def test_chains_with_features_are_values() -> None:
    one, other = (
        attrs.evolve(BEADS, granules=[sw.Segment(count=2, diameter=1e-3)], end=sw.Wall(mass=1.0)) for _ in range(2)
    )
    assert one == other
    assert hash(one) == hash(other)
    assert attrs.evolve(one, precompression=1.0) != one
    assert sw.Chain(material=STEEL, diameter=2 * BEADS.radius) == BEADS
