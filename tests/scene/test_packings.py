"""Plane waves in packings: each is that of an equivalent chain, with the force shared by its contacts."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from support.command_line import scenario
from support.scenes import CHAIN, triangle

SHOCK = triangle(1.0)


def equivalent(packing: str, **given: Any) -> tuple[sw.Chain, sw.Chain, float]:
    """A chain with a packing, a plain chain of the same mass, stiffness and spacing, and the contacts' share."""
    contacts, cosine = {"hexagonal": (2, math.sqrt(3) / 2), "fcc-111": (3, math.sqrt(2 / 3))}[packing]
    radius, own = CHAIN.radius * cosine, CHAIN.material
    modulus = own.youngs_modulus * contacts * cosine**2
    material = attrs.evolve(own, youngs_modulus=modulus, density=own.density / cosine**3)
    packed = attrs.evolve(CHAIN, packing=packing, **given)
    return packed, sw.Chain(material=material, radius=radius, **given), 1 / (contacts * cosine)


@pytest.mark.parametrize("packing", ["hexagonal", "fcc-111"])
def test_a_packing_is_a_chain_with_the_force_shared_by_its_contacts(packing: str) -> None:
    packed, plain, share = equivalent(packing)
    for run in (sw.predict, sw.simulate):
        one, other = run(SHOCK, packed), run(SHOCK, plain)
        # the same equations up to rounding errors
        assert one.peak_force == pytest.approx(share * other.peak_force, rel=1e-9)
        assert one.amplification == pytest.approx(other.amplification, rel=1e-9)
        for name in ("momentum", "energy", "speed", "width"):
            assert getattr(one.waves[0], name) == pytest.approx(getattr(other.waves[0], name), rel=1e-9)
        assert one.waves[0].peak_force == pytest.approx(share * other.waves[0].peak_force, rel=1e-9)


def test_contacts_of_a_finite_packing_carry_their_share() -> None:
    packed, plain, share = equivalent("hexagonal", granules=20)
    runs = [sw.simulate(SHOCK, chain, contacts=[0, 5]) for chain in (packed, plain)]
    one, other = (np.array([peak.peak_force for peak in run.contacts]) for run in runs)
    assert one == pytest.approx(share * other, rel=1e-9)


def test_packings_take_no_further_features() -> None:
    with pytest.raises(sw.InvalidValueError, match="packing: must be left out"):
        attrs.evolve(CHAIN, granules=60, end=sw.Wall(), packing="fcc-111")
    with pytest.raises(sw.InvalidValueError, match="packing: must be hexagonal or fcc-111"):
        attrs.evolve(CHAIN, packing="bcc")
    packed = attrs.evolve(CHAIN, packing="hexagonal", granules=20)
    for run in (sw.predict, sw.simulate):
        with pytest.raises(sw.ShockwaveError, match=r"chain\.packing: must be left out"):
            run(sw.Impact(velocity=1.0), packed)


def test_studies_of_packings_are_those_of_their_contacts(tmp_path: Path) -> None:
    blocks = [
        "chain: {material: ptfe, radius: 5 mm, packing: hexagonal}",
        "shock: {profile: triangular, peak_force: 10 N, rise_time: 20 us, duration_ratio: 3}",
        "uncertainty: {shock.peak_force: 5 %}",
    ]
    file = scenario(tmp_path, *blocks)
    expected = sw.simulate(file)
    assert "packing hexagonal" in expected.text("verbose")
    assert sw.uncertainty(file, draws=256).peak_force.nominal == pytest.approx(expected.peak_force, rel=1e-4)
    swept = scenario(tmp_path, *blocks, "sweep: {run: simulate, grid: {chain.radius: [4 mm, 5 mm]}}")
    sw.run_sweep(swept, tmp_path / "out", workers=1)
    # both within the default tolerance
    assert sw.load_sweep(tmp_path / "out").values("peak_force")[-1] == pytest.approx(expected.peak_force, rel=2e-6)
