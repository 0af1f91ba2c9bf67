"""Plane waves in packings: each is that of an equivalent chain, with the force shared by its contacts."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave import cli
from support.scenes import CHAIN, triangle

SHOCK = triangle(1.0)


def written(folder: Path, chain: str, more: str = "") -> str:
    file = folder / "scene.yaml"
    shock = "shock: {profile: triangular, peak_force: 10 N, rise_time: 20 us, duration_ratio: 3}"
    file.write_text(f"chain: {{material: ptfe, radius: 5 mm, {chain}}}\n{shock}\n{more}\n")
    return str(file)


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
    one, other = (sw.simulate(SHOCK, chain, contacts=[0, 5]) for chain in (packed, plain))
    assert [peak.peak_force for peak in one.contacts] == pytest.approx(
        [share * peak.peak_force for peak in other.contacts], rel=1e-9
    )


def test_packings_take_no_further_features() -> None:
    with pytest.raises(sw.InvalidValueError, match="packing: must be left out"):
        attrs.evolve(CHAIN, granules=60, end=sw.Wall(), packing="fcc-111")
    with pytest.raises(sw.InvalidValueError, match="packing: must be hexagonal or fcc-111"):
        attrs.evolve(CHAIN, packing="bcc")
    packed = attrs.evolve(CHAIN, packing="hexagonal", granules=20)
    for run in (sw.predict, sw.simulate):
        with pytest.raises(sw.ShockwaveError, match=r"chain\.packing: must be left out"):
            run(sw.Impact(velocity=1.0), packed)


@pytest.mark.parametrize("command", ["predict", "simulate", "compare"])
def test_commands_take_a_packing(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, "packing: fcc-111")
    assert cli.main([command, file, "--json"]) == 0
    capsys.readouterr()
    assert cli.main([command, file, "--verbose"]) == 0
    assert "packing fcc-111" in capsys.readouterr().out


def test_a_sweep_of_packings_is_that_of_chains(tmp_path: Path) -> None:
    sweep = "sweep: {run: simulate, grid: {chain.radius: [4 mm, 5 mm]}}"
    sw.run_sweep(sw.load_scenario(written(tmp_path, "packing: hexagonal", sweep)), tmp_path / "out", workers=1)
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=10.0, rise_time=20e-6)
    last = sw.simulate(shock, sw.Chain(material=sw.material("ptfe"), radius=5e-3, packing="hexagonal"))
    # both within the default tolerance
    assert sw.load_sweep(tmp_path / "out").values("peak_force")[-1] == pytest.approx(last.peak_force, rel=2e-6)
