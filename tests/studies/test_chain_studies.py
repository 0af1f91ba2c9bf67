"""Studies of chains beyond equal spheres: uncertainty and sweeps, each by simulations."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from attrs import evolve

import shockwave as sw
from shockwave import cli
from shockwave.scenario.variations import Family
from shockwave.studies.quantities import Quantity

SCENE = """\
name: a short chain
chain:
  material: stainless-steel-302
  diameter: 9.5 mm
  granules: [{count: 3}, {count: 2, material: ptfe}]
  end: {wall: same}
  damping: {model: kuwabara-kono, time: 1 us}
shock: {profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}
simulate: {contacts: [0, 4]}
uncertainty: {'chain.granules[1].material.youngs_modulus': 10 %, shock.peak_force: {sd: 5 N}}
"""
STRIKER = """\
chain: {material: stainless-steel-302, diameter: 9.5 mm, granules: 1}
impact: {velocity: 0.5 m/s}
uncertainty: {impact.velocity: {factor: 1.1}}
"""
WALL_FORCE, GREATEST = "transmitted.peak_force", "greatest_force.peak_force"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def scene(path: Path, text: str) -> sw.Scenario:
    path.write_text(text)
    return sw.load_scenario(path)


# ---------------------------------------------------------------- uncertainty


def test_draws_are_simulations_of_their_scenes(file: Path) -> None:
    scenario = sw.load_scenario(file)
    found = sw.uncertainty(scenario, draws=256)
    values = {name: float(column[7]) for name, column in found.values.items()}
    own = Family(scenario).scenario(values)
    known = sw.simulate(own.shock, own.chain, rtol=1e-8, contacts=[0, 4])
    names = [WALL_FORCE, "transmitted.impulse", GREATEST, "dissipated_energy", "contacts[1].peak_force"]
    errors = {one.name: one.model_error for one in found.quantities}
    for name in names:
        reached = Quantity.named(name, [0, 4], "target").read(known)
        assert reached is not None
        # the stated error is that of the forces; other quantities are about as accurate
        assert found.outputs[name][7] == pytest.approx(reached[0], rel=10 * errors[name])


@pytest.fixture(scope="module")
def collision(tmp_path_factory: pytest.TempPathFactory) -> sw.Uncertainty:
    return sw.uncertainty(scene(tmp_path_factory.mktemp("collision") / "s.yaml", STRIKER), draws=256)


def test_a_collision_has_the_distribution_of_the_closed_form(collision: sw.Uncertainty) -> None:
    """The peak force of two equal spheres scales as v^(6/5), so that it is lognormal if the velocity is."""
    force, restitution = collision.quantities
    (share,) = force.sensitivities
    sigma = 1.2 * np.log(1.1)
    mean = force.nominal * np.exp(sigma**2 / 2)
    # three times the 95 % interval is practically never exceeded
    assert force.mean.value == pytest.approx(mean, abs=3 * force.mean.error)
    high = force.nominal * np.exp(1.6448536 * sigma)
    assert force.quantiles[0.95].value == pytest.approx(high, abs=3 * force.quantiles[0.95].error)
    assert share.first.value == pytest.approx(1, abs=3 * share.first.error)
    # the slope over 0.3 standard deviations, of a curve with relative curvature 0.12
    assert share.exponent == pytest.approx(1.2, abs=1e-3)
    assert restitution.mean.value == pytest.approx(1, abs=1e-6)
    assert any("restitution is within the error of the simulations" in warning for warning in collision.warnings)


def test_the_command_prints_the_distributions_that_python_gives(
    collision: sw.Uncertainty, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene(tmp_path / "s.yaml", STRIKER)
    assert cli.main(["uncertainty", str(tmp_path / "s.yaml"), "--draws", "256", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    # the same seed gives the same digits
    assert document == json.loads(json.dumps(collision.to_dict()))
    printed = str(collision)
    assert printed.startswith("greatest force: mean ")
    assert max(map(len, printed.splitlines())) <= 80
    assert [one["name"] for one in document["quantities"]] == [GREATEST, "restitution"]
    assert document["quantities"][0]["sensitivities"][0]["name"] == "impact.velocity"
    assert (collision.peak_force, collision.amplification) == (None, None)


def test_the_mass_of_a_fixed_wall_cannot_be_uncertain(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text(SCENE.replace("shock.peak_force: {sd: 5 N}", "chain.end.mass: 5 %"))
    assert cli.main(["uncertainty", str(file)]) == 3
    assert "uncertainty.'chain.end.mass': must have a value in the scenario" in capsys.readouterr().err


# ---------------------------------------------------------------- sweeps

SWEPT = SCENE.split("uncertainty")[0]
GRID = "sweep: {{run: {}, grid: {{chain.damping.time: [1 us, 2 us]}}}}\n"


def test_predictions_that_cover_no_point_are_refused_before_the_sweep(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file.write_text(SWEPT + "predict: {model: section-4}\n" + GRID.format("predict"))
    assert cli.main(["sweep", str(file), "-o", str(file.parent / "out")]) == 3
    assert capsys.readouterr().err.startswith(f"{file}:5:")
    assert not (file.parent / "out").exists()


def test_a_prediction_that_may_cover_some_points_is_not_refused(file: Path) -> None:
    text = "chain: {material: ptfe, diameter: 9.5 mm, granules: 5, precompression: 1 N}\n"
    shock = "shock: {profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}\n"
    model = "predict: {model: section-4}\n"
    file.write_text(text + shock + model + "sweep: {run: predict, grid: {chain.precompression: [1 N, 0 N]}}\n")
    report = sw.run_sweep(file, file.parent / "out", workers=1)
    assert (report.done, report.failed) == (1, 1)


def test_predictions_of_a_sweep_of_chains_are_those_of_single_scenes(file: Path) -> None:
    file.write_text(SWEPT + GRID.format("predict"))
    report = sw.run_sweep(file, file.parent / "out", workers=1)
    assert (report.done, report.failed) == (2, 0)
    results, scenario = sw.load_sweep(file.parent / "out"), sw.load_scenario(file)
    for index, time in enumerate((1e-6, 2e-6)):
        chain = evolve(scenario.chain, damping=sw.KuwabaraKono(time=time))
        outcome = sw.predict(scenario.shock, chain, contacts=[0, 4])
        assert outcome.greatest_force is not None
        assert outcome.transmitted is not None
        known = {
            "greatest_force": outcome.greatest_force.peak_force,
            "transmitted_force": outcome.transmitted.peak_force,
        }
        known |= {"force_4": outcome.contacts[1].peak_force, "error_estimate": outcome.simulated.error_estimate}
        for name, value in known.items():
            assert results.values(name)[index] == pytest.approx(value, rel=1e-12)


def test_a_sweep_of_predictions_covers_points_with_and_without_features(file: Path) -> None:
    text = "chain: {material: ptfe, diameter: 9.5 mm, granules: 5, precompression: 1 N}\n"
    shock = "shock: {profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}\n"
    file.write_text(text + shock + "sweep: {run: predict, grid: {chain.precompression: [1 N, 0 N]}}\n")
    report = sw.run_sweep(file, file.parent / "out", workers=1)
    assert (report.done, report.failed) == (2, 0)
    forces = sw.load_sweep(file.parent / "out").values("greatest_force")
    chain = sw.Chain(material="ptfe", diameter="9.5 mm", granules=5)
    excited = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=100.0, rise_time=10e-6)
    for force, precompression in zip(forces, (1.0, 0.0), strict=True):
        known = sw.predict(excited, evolve(chain, precompression=precompression)).greatest_force
        assert known is not None
        # the tolerance; the train, which the sweep leaves out, changes the steps
        assert force == pytest.approx(known.peak_force, rel=1e-6)


def test_a_comparison_without_predictions_has_no_empty_columns(file: Path) -> None:
    file.write_text(SWEPT + GRID.format("compare"))
    sw.run_sweep(file, file.parent / "out", workers=1)
    table = sw.load_sweep(file.parent / "out").to_pandas()
    named = {name for name in table if not name.startswith("predicted_")}
    assert "transmitted_force" in named
    assert "restitution" not in named
    assert [name for name in table if table[name].isna().all() and name != "notes"] == []


def test_pulling_forces_are_simulated_in_an_uncertainty(tmp_path: Path) -> None:
    record = "{times: [0, 1e-5, 2e-5, 3e-5, 4e-5], forces: [0, 50, 0, -5, 0], negative: keep}"
    pulling = scene(
        tmp_path / "pulling.yaml",
        "chain: {material: bearing-steel-52100, diameter: 9.5 mm}\n"
        f"shock: {{profile: tabulated, parameters: {record}}}\nuncertainty: {{shock.peak_force: 5 %}}\n",
    )
    found = sw.uncertainty(pulling, draws=256)
    assert found.peak_force is not None
    assert found.peak_force.nominal == pytest.approx(sw.simulate(pulling, rtol=1e-6).peak_force, rel=1e-4)
