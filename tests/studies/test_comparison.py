"""The scores of section 4: each promise beside the simulation."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import attrs
import pytest

import shockwave as sw
from shockwave.studies import comparison
from support.scenes import CHAIN, FORCE, STEEL

FILES = sorted((Path(__file__).parents[2] / "profiles" / "paper").glob("*.yaml"))
EVERY_ROW = pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
TRAIN = sw.Shock(
    profile=sw.PowerLaw(rise_exponent=1, decay_exponent=5, duration_ratio=10), peak_force=FORCE, rise_time=15e-6
)


@cache
def compared(file: Path) -> sw.Comparison:
    return sw.compare(file, rtol=1e-9)


@EVERY_ROW
def test_each_promise_is_scored(file: Path) -> None:
    both = compared(file)
    paper = both.predicted.section4
    assert both.errors.peak_force == paper.peak_force / both.simulated.peak_force - 1
    assert both.errors.waves[0].peak_force == pytest.approx(both.errors.peak_force, abs=1e-8)  # of another run
    # a momentum scales as the force to the power 5/6; the coefficients of the paper and the exact one differ
    coefficient = paper.momentum_coefficient / 4.344507853978653
    momentum = coefficient * (1 + both.errors.waves[0].peak_force) ** (5 / 6) - 1
    assert both.errors.waves[0].momentum == pytest.approx(momentum, abs=1e-9)
    assert (both.errors.added_momentum is None) == (paper.regime != "ejection")
    assert both.agrees["relation"] is True


def test_the_simulated_exponents_of_an_impulse_are_known() -> None:
    shock = attrs.evolve(TRAIN, rise_time=1e-9)
    both = sw.compare(shock, CHAIN)
    # F scales as the impulse over A to the power 6/5
    assert attrs.astuple(both.exponents) == pytest.approx((-1.6, -0.6, 0.4), abs=1e-4)


def test_the_exponents_are_simulated_with_the_same_options(monkeypatch: pytest.MonkeyPatch) -> None:
    both, given = sw.compare(TRAIN, CHAIN, rtol=1e-3, backend="numpy", timeout=50.0), []
    run = comparison.simulate_many
    monkeypatch.setattr(comparison, "simulate_many", lambda *rest, **more: given.append(more) or run(*rest, **more))
    assert both.exponents is not None
    assert (given[0]["backend"], given[0]["timeout"]) == ("numpy", 50.0)
    assert (
        sw.compare(TRAIN, CHAIN, integrator="verlet", waves="primary").exponents is not None
    )  # which takes no backend


def test_a_wave_that_is_not_simulated_has_no_error() -> None:
    both = sw.compare(TRAIN, CHAIN, waves="primary")
    first, second = both.errors.waves
    assert both.errors.added_momentum is None
    assert both.to_dict()["agrees"]
    assert "train" not in both.simulated.__dict__
    assert first.peak_force is not None
    assert attrs.astuple(second) == (None, None)
    assert (both.regime, both.agrees["regime"], both.agrees["count"]) == (None, None, None)


def test_waves_that_have_not_separated_are_counted_by_themselves() -> None:
    both = sw.compare(attrs.evolve(TRAIN, rise_time=150e-6), CHAIN)
    others = len(both.simulated.waves) - len(both.waves)
    assert others > 0
    assert f" {len(both.waves)} + {others} not separated " in str(both)


@pytest.mark.parametrize(("error", "added"), [(0.5, 2.0), (2.5, None)], ids=["accurate", "within-its-error"])
def test_the_added_momentum_is_known_if_it_exceeds_its_error(error: float, added: float | None) -> None:
    simulated = SimpleNamespace(options=SimpleNamespace(waves="train"), recoil_momentum=-2.0, recoil_error=error)
    assert comparison.Comparison(predicted=None, simulated=simulated).added_momentum == added


def test_a_scene_that_section_4_does_not_cover_is_simulated_alone() -> None:
    both = sw.compare(TRAIN, attrs.evolve(CHAIN, granules=5, end=sw.Wall(material="same")))
    document = json.loads(json.dumps(both.to_dict(), allow_nan=False))
    assert (document["predicted"], document["errors"], document["agrees"]) == (None, None, None)
    assert "chain.end" in document["reason"]
    assert str(both).startswith("greatest force")
    assert "section 4 does not apply: chain.end (a wall)" in str(both)
    assert (both.errors.peak_force, both.errors.waves) == (None, ())


def test_it_takes_the_settings_of_predictions_and_simulations_and_no_others() -> None:
    both = sw.compare(TRAIN, CHAIN, rtol=1e-4, momentum_coefficient="paper", equal_tolerance=0.5)
    assert both.simulated.rtol == 1e-4
    assert both.predicted.section4.momentum_coefficient == 13 / 3
    assert both.relation == "equal"
    refused = {"foo: unknown argument": {"foo": 3}, "model: must be left out or": {"model": "best"}}
    for path, setting in (refused | {"options: unknown argument": {"options": None}}).items():
        with pytest.raises(sw.InvalidValueError, match=rf"^{path}"):
            sw.compare(TRAIN, CHAIN, **setting)


def test_a_comparison_of_soft_beads_has_no_warning() -> None:
    soft = attrs.evolve(CHAIN, material=attrs.evolve(STEEL, youngs_modulus=1e9))
    assert sw.compare(TRAIN, soft).warnings == ()
