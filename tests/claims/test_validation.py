"""The comparisons of docs/validation.md: the page shows what `published_chains` computes, and references agree."""

from functools import cache
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import shockwave as sw
from support import published_chains
from support.pages import table
from support.slow_cases import keeping

ROOT = Path(__file__).parents[2]

#: Largest relative difference from references that do not agree to all their digits; the page gives the reasons.
LARGEST = {"taperchain": 3e-4, "restitution": 1e-4, "walls": 1e-6, "precompression": 4e-3, "lazaridi": 0.21}
LARGEST["finite-elements"] = 0.23
FAST = ("taperchain", "restitution", "walls", "lazaridi", "finite-elements")


@cache
def rows(name: str) -> list[Any]:
    return list(published_chains.CHECKS[name]())


@pytest.mark.parametrize("name", keeping(published_chains.CHECKS, *FAST))
def test_the_page_shows_the_results(name: str) -> None:
    shown = table("docs/validation.md", name)
    assert [cells[:2] for cells in shown] == [[row.quantity, row.reference] for row in rows(name)]
    for cells, row in zip(shown, rows(name), strict=True):
        assert float(cells[2]) == pytest.approx(
            row.value, rel=0, abs=1.01 * 10.0 ** -(row.decimals + published_chains.MORE_DIGITS)
        )
        assert (cells[4] == "within rounding") == row.agrees


@pytest.mark.parametrize("name", keeping(published_chains.CHECKS, *FAST))
def test_results_agree_with_the_references(name: str) -> None:
    largest = LARGEST.get(name)
    assert [row for row in rows(name) if not (row.agrees or (largest and abs(row.difference) <= largest))] == []


def test_the_series_of_the_restitution_is_approached_at_low_velocity() -> None:
    differences = [abs(row.difference) for row in rows("restitution") if "series" in row.quantity]
    assert len(differences) == 3
    assert differences == sorted(differences, reverse=True)


def test_the_table_of_lammps_agrees_and_converges() -> None:
    shown = table("docs/validation.md", "lammps")
    assert len(shown) == 12
    for damping, *_, step, half, limit in shown:
        assert abs(float(limit)) < (2e-8 if damping == "none" else 5e-6)
        assert float(step) / float(half) == pytest.approx(4 if damping == "none" else 2, rel=0.2)


def test_two_spheres_without_the_cut_off_lose_more_energy() -> None:
    attracted, cut = rows("restitution")[:2]
    assert attracted.value < cut.value


def test_taperchain_is_reproduced_with_the_stiffness_that_it_prints() -> None:
    scene = sw.load_scenario(ROOT / "profiles" / "validation" / "taperchain.yaml")
    chain = evolve(scene.chain, material=evolve(scene.chain.material, youngs_modulus=314.159e9))
    result = sw.simulate(scene.impact, chain, until=2.9e-3, record=["forces", "field"], interval=5e-6)
    assert result.recording.wall_force.max() == pytest.approx(43.2206, rel=1.2e-5)  # six digits of a sampled force
    # the first bead returns to the wall behind it
    back = result.recording.times[1:][result.recording.displacements[1:, 0] <= 0]
    assert back[0] == pytest.approx(0.39e-3, abs=5e-6)


@pytest.mark.parametrize(("row", "printed"), [(3, 0.005), (5, 0.029)])
def test_the_rounding_of_rise_times_does_not_explain_rows_3_and_5_of_table_2(row: int, printed: float) -> None:
    scene = sw.load_scenario(ROOT / "profiles" / "paper" / f"table2-row{row}.yaml")
    errors = []
    for shift in (-0.05e-6, 0.05e-6):
        shock = evolve(scene.shock, rise_time=scene.shock.rise_time + shift)
        simulated = sw.simulate(shock, scene.chain, waves="primary").peak_force
        paper = scene.predictor.predict(shock, scene.chain).section4
        errors.append(paper.peak_force / simulated - 1)
    assert min(errors) == pytest.approx(0.010, abs=5e-4)
    assert not min(errors) <= printed <= max(errors)
