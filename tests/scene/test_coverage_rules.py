"""Which chains are equal granules, and the features that methods for these refuse."""

from __future__ import annotations

from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave.base.errors import NotCoveredError
from shockwave.scene.contact_law import Hertz
from shockwave.scene.coverage_rules import reduce_chain
from shockwave.scene.scene import Scene
from support.scenes import CHAIN, STEEL, triangle

SHOCK = triangle(3.0)
RADIUS = CHAIN.radius


def segments(*granules: sw.Segment | sw.Cell) -> sw.Chain:
    return attrs.evolve(CHAIN, granules=granules)


def test_segments_of_equal_granules_are_a_number_of_granules() -> None:
    made = segments(
        sw.Segment(count=3), sw.Cell(repeat=2, cell=[sw.Segment(radius=RADIUS), sw.Segment(material=STEEL)])
    )
    assert not made.is_uniform
    assert made.count == 7
    assert reduce_chain(made) == attrs.evolve(CHAIN, granules=7)
    smaller = segments(sw.Segment(count=5, radius=1e-3))
    assert reduce_chain(smaller) == sw.Chain(material=STEEL, radius=1e-3, granules=5)
    assert attrs.evolve(CHAIN, granules=4, contact=Hertz()) == attrs.evolve(CHAIN, granules=4)


FURTHER: dict[str, dict[str, Any]] = {
    "granules[1]": {"granules": [sw.Segment(), sw.Segment(radius=1e-3)]},
    "granules[0]": {"granules": [sw.Segment(count=2, radius=sw.Taper(first=1e-3, last=2e-3))]},
    "granules[0].cell[1]": {"granules": [sw.Cell(repeat=2, cell=[sw.Segment(), sw.Segment(material="ptfe")])]},
    "granules[0].gap": {"granules": [sw.Segment(count=4, gap=1e-6)]},
    "end": {"end": sw.Wall()},
    "precompression": {"precompression": 1.0},
    "damping": {"damping": sw.Dashpot(coefficient=1.0)},
    "contact": {"contact": sw.PowerContact(exponent=2, stiffness=1e7)},
}


def test_another_contact_law_is_refused_by_methods_that_know_hertz_alone() -> None:
    scene = Scene(excitation=SHOCK, chain=attrs.evolve(CHAIN, contact=sw.PowerContact(exponent=2, stiffness=1e7)))
    assert scene.covered_chain("a test", laws=True) == scene.chain
    with pytest.raises(NotCoveredError, match=r"^chain\.contact: must be left out .*\(got another contact law\)$"):
        scene.covered_chain("a test")


@pytest.mark.parametrize("path", FURTHER)
def test_methods_for_equal_granules_refuse_every_further_feature(path: str) -> None:
    made = sw.Chain(material=STEEL, radius=RADIUS, **{"granules": 4, **FURTHER[path]})
    assert reduce_chain(made) is None
    message = r"must be left out for a test, which covers only shocks on chains of equal granules with free ends \(got "
    with pytest.raises(NotCoveredError, match=message) as caught:
        Scene(excitation=SHOCK, chain=made).covered_chain("a test")
    assert [fault.path for fault in caught.value.faults] == [f"chain.{path}"]
    with pytest.raises(NotCoveredError, match=r"^impact: must be left out"):
        Scene(excitation=sw.Impact(velocity=1.0), chain=attrs.evolve(CHAIN, granules=4)).covered_chain("a test")
    predictor = sw.Predictor(model="section-4")
    with pytest.raises(NotCoveredError, match="must be left out for section 4"):
        predictor.predict(SHOCK, made)
    (refused,) = predictor.predict_many([SHOCK], made)
    assert [fault.path for fault in refused.faults] == [f"chain.{path}"]
    outcome = sw.Predictor().predict(SHOCK, made)
    assert [fault.path for fault in outcome.section4_faults] == [f"chain.{path}"]
    assert outcome.greatest_force == sw.simulate(SHOCK, made).greatest_force
    assert sw.compare(SHOCK, made).predicted is None
