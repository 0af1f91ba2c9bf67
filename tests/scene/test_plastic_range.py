"""Range of the law of elastic-plastic contacts: refusals and warnings, with the bodies and their places."""

from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave.base.errors import InvalidValueError
from shockwave.scene.plausibility import unusual
from shockwave.scene.scene import faults_of

PLASTIC = sw.ElasticPlastic()
IMPACT = sw.Impact(velocity=1.0)
STEEL = sw.Material(youngs_modulus=200e9, poisson_ratio=0.3, density=7650, yield_strength=1.9e9, name="hard steel")
MODULUS = 200e9 / (2 * 0.91)


def chain(*parts: Any, **features: Any) -> sw.Chain:
    granules = parts or (sw.Segment(count=3),)
    return sw.Chain(**{"material": STEEL, "radius": 5e-3, "granules": granules, "contact": PLASTIC} | features)


@pytest.mark.parametrize(
    ("ratio", "refused", "warned"),
    [(0.9e-3, True, True), (1.1e-3, False, True), (0.02, False, False), (0.09, False, True), (0.11, True, True)],
)
def test_the_strength_is_compared_with_the_modulus_of_the_contact(ratio: float, refused: bool, warned: bool) -> None:
    beads = chain(material=attrs.evolve(STEEL, yield_strength=ratio * MODULUS))
    assert bool(faults_of(beads, IMPACT)) is refused
    assert any("is less accurate" in fault.problem for fault in unusual(IMPACT, beads)) is warned
    if refused:
        with pytest.raises(
            InvalidValueError, match=r"^chain.contact: must not be elastic-plastic at contact 0, between the str"
        ):
            sw.simulate(IMPACT, beads)


def test_a_refusal_names_both_bodies_and_the_one_without_a_strength() -> None:
    (fault,) = faults_of(chain(sw.Segment(count=3), sw.Segment(count=3, material="homalite-100")), None)
    assert "contact 2, between granule 2 (hard steel) and granule 3 (homalite-100)" in fault.problem
    assert "; give granule 2 a segment of its own with contact: {model: hertz}, or state the yield_str" in fault.problem
    assert "state the yield_strength of homalite-100" in fault.problem
    # the law behind a striker is that of the chain, and a smaller strength than that of metals is an error
    soft = attrs.evolve(STEEL, yield_strength=0.5e-3 * MODULUS)
    for beads in (chain(sw.Segment(count=3, material="homalite-100", contact=sw.Hertz())), chain(material=soft)):
        hits = faults_of(beads, attrs.evolve(IMPACT, material=STEEL))
        assert hits
        assert not any("hertz" in fault.problem for fault in hits)


def test_a_pad_with_hertz_contacts_is_neither_refused_nor_warned_of() -> None:
    pad = [sw.Segment(count=3), sw.Segment(contact=sw.Hertz()), sw.Segment(material="ptfe", contact=sw.Hertz())]
    rubber = sw.Material(youngs_modulus=5e7, poisson_ratio=0.48, density=1150)
    for material in ("ptfe", rubber):
        beads = chain(*pad[:2], attrs.evolve(pad[2], material=material), sw.Segment(count=2))
        assert faults_of(beads, IMPACT) == unusual(IMPACT, beads) == []


def test_a_strength_that_depends_on_the_rate_is_refused_at_a_bar() -> None:
    fast = attrs.evolve(STEEL, rate_constant=0.03)
    bar, own = sw.Bar(material=fast, diameter=0.02), sw.Segment(contact=sw.Hertz())
    with pytest.raises(
        InvalidValueError, match=r"^chain\.end: must be a wall where .* \(got a bar; give the last gran"
    ):
        sw.simulate(IMPACT, chain(material=fast, end=bar))
    for beads in (chain(end=bar), chain(sw.Segment(count=2), own, material=fast, end=bar)):
        assert faults_of(beads, IMPACT) == []


def test_a_law_behind_the_last_granule_at_a_free_end_is_that_of_no_contact() -> None:
    beads = chain(sw.Segment(count=3), sw.Segment(contact=PLASTIC), contact=None)
    assert faults_of(beads, IMPACT) == unusual(IMPACT, beads) == []
    assert sw.simulate(IMPACT, beads).dissipated.plastic == 0


def test_a_refusal_of_damping_names_the_law_and_another_one() -> None:
    with pytest.raises(
        InvalidValueError, match=r"contact law elastic-plastic, .* \(or contact: {model: hertz} for this"
    ):
        chain(sw.Segment(count=3), sw.Segment(damping=sw.Dashpot(coefficient=1.0)))


def test_the_place_of_a_refusal_is_the_law_of_the_contact() -> None:
    soft = attrs.evolve(STEEL, yield_strength=1e7, name="soft")
    own = sw.Segment(material=soft, contact=PLASTIC)
    cell = sw.Cell(repeat=2, cell=[own, sw.Segment(material=soft)])
    places = [fault.path for fault in faults_of(chain(sw.Segment(), own, cell, contact=None), IMPACT)]
    # once for each pair of materials at a place, and not for elastic contacts
    assert places == ["chain.granules[1].contact", "chain.granules[2]"]


@pytest.mark.parametrize(
    ("material", "part"),
    [
        ("alumina", "does not describe alumina: such materials break"),
        ("nylon-66", "does not describe nylon-66: such materials creep"),
        (attrs.evolve(STEEL, yield_strength=None, name=""), "treats E 200 GPa as elastic"),
    ],
    ids=["brittle", "creeping", "without-strength"],
)
def test_materials_that_the_law_does_not_describe_are_named(material: Any, part: str) -> None:
    assert any(part in fault.problem for fault in unusual(IMPACT, chain(material=material)))
    assert not any(part in fault.problem for fault in unusual(IMPACT, chain(material=material, contact=None)))
