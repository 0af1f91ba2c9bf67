"""Results of elastic-plastic contacts: energies, residual overlaps, yielded contacts, advice, sweeps and pictures."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave.base.text import si
from shockwave.scene.force_limit import LeavingForce
from shockwave.scene.layout import Layout, elastic_chain
from shockwave.scene.yielding import law_facts
from support.command_line import scenario, shockwave
from support.scenario_texts import scenario_in_python

STEEL = sw.Material(youngs_modulus=200e9, poisson_ratio=0.3, density=7650, yield_strength=1.9e9)
PLASTIC, IMPACT = sw.ElasticPlastic(), sw.Impact(velocity=5.0)
BEADS = sw.Chain(material=STEEL, radius=3e-3, granules=8, contact=PLASTIC, end=sw.Wall())
DASHPOT = sw.Dashpot(coefficient=20.0)
MIXED = [
    sw.Segment(count=3),
    sw.Segment(count=2, contact=sw.Hertz(), damping=DASHPOT),
    sw.Segment(count=2, contact=sw.PowerContact(exponent=2.0, stiffness=1e12)),
]
CHAINS = {
    "wall": BEADS,
    "free": attrs.evolve(BEADS, end=None),
    "laws": attrs.evolve(BEADS, granules=MIXED),
    "movable": attrs.evolve(BEADS, end=sw.Wall(mass=0.01, stiffness=1e6, damping=20.0), granules=MIXED),
    "loaded": attrs.evolve(BEADS, precompression=100.0),
}


@pytest.mark.parametrize("name", CHAINS)
def test_energies_add_up(name: str) -> None:
    result: Any = sw.simulate(IMPACT, CHAINS[name], rtol=1e-6)
    lost = result.dissipated
    assert lost.energy == pytest.approx(lost.plastic + lost.damping + lost.end + lost.bar, rel=1e-12)
    stored = sum(segment.energy for segment in result.segments) + (result.end_energy or 0.0)
    assert stored + lost.energy == pytest.approx(result.applied_energy, rel=1e-6)
    contacts = sum(segment.dissipated for segment in result.segments)
    assert contacts == pytest.approx(lost.plastic + lost.damping, rel=1e-12)
    assert lost.plastic > 0.05 * result.applied_energy
    assert (lost.damping > 0) is (name in ("laws", "movable"))
    assert (lost.end > 0) is (name == "movable")
    document = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert document["dissipated"] == attrs.asdict(lost)
    assert "plastic flow" in result.text("verbose")


def test_a_contact_keeps_a_residual_overlap_where_it_has_yielded() -> None:
    result: Any = sw.simulate(IMPACT, CHAINS["laws"], rtol=1e-6)
    residual = [peak.residual_overlap for peak in result.contacts]
    # of the striker's contact and of those of the first segment
    assert min(residual[:4]) > 1e-7
    assert residual[4:8] == [0.0] * 4
    gentle: Any = sw.simulate(sw.Impact(velocity=0.01), BEADS, rtol=1e-6)
    assert (gentle.yielding.yielded_contacts, gentle.dissipated.plastic) == (0, 0.0)
    assert {peak.residual_overlap for peak in gentle.contacts} == {0.0}


def test_elastic_contacts_alone_are_warned_about() -> None:
    def beyond(chain: sw.Chain) -> int:
        return sum("Beyond elastic" in warning for warning in sw.simulate(IMPACT, chain, rtol=1e-4).warnings)

    assert [beyond(chain) for chain in (BEADS, CHAINS["laws"], elastic_chain(BEADS))] == [0, 1, 1]


def test_the_value_with_yield_is_that_of_a_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    elastic: Any = sw.simulate(IMPACT, elastic_chain(BEADS), rtol=1e-4)
    plastic: Any = sw.simulate(IMPACT, BEADS, rtol=1e-4)
    (sentence,) = elastic.value_with_yield
    assert f"{plastic.greatest_force.peak_force:.0f} N" in sentence
    assert f"the force on the wall is {plastic.transmitted.peak_force:.0f} N" in sentence
    assert sentence in elastic.warnings
    assert sentence not in elastic.first_warnings
    shock = sw.Shock(profile="half-sine", peak_force=500.0, rise_time=5e-6)
    uniform = sw.Chain(material=STEEL, radius=3e-3, granules=20)
    assert sw.simulate(shock, uniform).value_with_yield
    long = attrs.evolve(uniform, granules=101)
    brittle = attrs.evolve(uniform, material=attrs.evolve(STEEL, yield_strength=1e7))
    damped = attrs.evolve(uniform, damping=DASHPOT)
    for chain in (long, brittle, damped, attrs.evolve(uniform, granules=None)):
        result = sw.simulate(shock, chain, rtol=1e-4, waves="primary")
        assert any("Beyond elastic" in warning for warning in result.first_warnings)
        assert result.value_with_yield == ()


PAD = sw.Segment(count=2, contact=sw.PowerContact(exponent=1.0, stiffness=1e7), damping=DASHPOT)
RUBBER = sw.Material(youngs_modulus=50e6, poisson_ratio=0.48, density=1150)
LAYER = sw.Segment(material=RUBBER, contact=sw.Hertz(), damping=DASHPOT)


@pytest.mark.parametrize(
    "end",
    [[PAD], [sw.Segment(contact=sw.Hertz(), damping=DASHPOT), LAYER]],
    ids=["pad", "damped rubber"],
)
def test_the_value_with_yield_leaves_pads_as_they_are(end: list[sw.Segment]) -> None:
    padded = attrs.evolve(BEADS, granules=[sw.Segment(count=5), *end])
    elastic, plastic = (sw.simulate(IMPACT, chain, rtol=1e-4) for chain in (elastic_chain(padded), padded))
    (sentence,) = elastic.value_with_yield
    assert f"{plastic.greatest_force.peak_force:.0f} N" in sentence
    assert f"the force on the wall is {si(plastic.transmitted.peak_force, 'N', 3)}" in sentence


def test_no_value_with_yield_replaces_the_damping_of_contacts_that_yield() -> None:
    damped = attrs.evolve(BEADS, granules=MIXED, contact=None)
    result = sw.simulate(IMPACT, damped, rtol=1e-4)
    assert any("Beyond elastic" in warning for warning in result.warnings)
    assert result.value_with_yield == ()


def test_an_elastic_result_computes_no_value_with_yield(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shockwave.simulation.yield_advice.value_with_yield", None)  # a call fails
    assert sw.simulate(sw.Impact(velocity=0.01), elastic_chain(BEADS)).warnings == ()


@pytest.mark.parametrize("run", [sw.predict, sw.simulate])
def test_a_result_states_the_error_of_the_plastic_law_once(run: Any) -> None:
    plastic, elastic = run(IMPACT, BEADS, rtol=1e-4), run(sw.Impact(velocity=0.01), elastic_chain(BEADS), rtol=1e-4)
    (note,) = plastic.to_dict()["notes"]
    assert note.startswith("Error estimates do not include the model error of the elastic-plastic law: -2 to +11 %")
    assert [
        result.text(level).count("-2 to +11 %") for result in (plastic, elastic) for level in ("short", "verbose")
    ] == [*(1, 1, 0, 0)]
    assert elastic.to_dict()["notes"] == []


@pytest.mark.parametrize(("rate_constant", "error"), [(0.0, "-2 to +11 %"), (0.035, "-22 to +1.5 %")])
def test_the_error_of_the_plastic_law_is_that_without_or_with_rate(rate_constant: float, error: str) -> None:
    (text,) = dict(law_facts(attrs.evolve(BEADS, material=attrs.evolve(STEEL, rate_constant=rate_constant)))).values()
    assert text.startswith(error)


def test_a_design_states_the_error_of_the_plastic_law() -> None:
    scene = attrs.evolve(scenario_in_python(None, attrs.evolve(BEADS, granules=2)), impact=IMPACT)  # type: ignore[arg-type]
    target = "transmitted.peak_force <= 300 N"
    least = sw.design(scene, vary="impact.velocity", between=(3.0, 5.0), target=target, points=3)
    assert sum("elastic-plastic law" in warning for warning in least.warnings) == 1


def test_large_overlaps_are_warned_about() -> None:
    soft = attrs.evolve(BEADS, material=attrs.evolve(STEEL, yield_strength=3e8))
    (warning,) = [each for each in sw.simulate(sw.Impact(velocity=400.0), soft).warnings if "overlap" in each]
    assert "times the reduced radius" in warning


def test_the_elastic_chain_differs_in_its_elastic_plastic_contacts_alone() -> None:
    cell = sw.Cell(repeat=2, cell=[sw.Segment(contact=PLASTIC), sw.Segment(damping=DASHPOT, contact=sw.Hertz())])
    mixed = attrs.evolve(BEADS, granules=[*MIXED, cell])
    elastic = elastic_chain(mixed)
    assert not elastic.is_plastic
    layouts = [Layout.of(chain, IMPACT) for chain in (mixed, elastic)]
    for name in ("exponents", "stiffnesses"):
        assert np.array_equal(*(getattr(layout.pairs, name) for layout in layouts))
    assert layouts[1].plastic is None


def test_pictures_show_hysteresis_and_the_elastic_forces() -> None:
    pictures = pytest.importorskip("shockwave.pictures")
    pytest.importorskip("matplotlib")
    result = sw.simulate(IMPACT, BEADS, rtol=1e-4, record=("forces", "field"), contacts=range(0, 9, 2))
    _, (left, right) = pictures.figure(columns=2)
    drawn, elastic = pictures.force_overlap(result, 8, ax=left).get_lines()
    (overlaps, forces), (_, hertz) = drawn.get_data(), elastic.get_data()
    assert max(forces) == pytest.approx(result.transmitted.peak_force, rel=0.02)  # the samples miss the peak
    assert min(overlaps) > 0
    assert max(hertz) == pytest.approx(max(forces), rel=1e-9)
    with pytest.raises(sw.InvalidValueError, match=r"recorded contact .*recorded are 0, 2, 4, 6, 8"):
        pictures.force_overlap(result, 1, ax=left)
    lines = {line.get_label(): line.get_ydata() for line in pictures.peak_forces(result, ax=right).get_lines()}
    assert (np.array(lines["elastic"]) > lines["greatest force"]).all()


def test_a_sweep_has_the_columns_of_plastic_flow(tmp_path: Path) -> None:
    chain = "chain: {material: stainless-steel-440c, radius: 3 mm, granules: 5, contact: {model: elastic-plastic}}"
    grid = "sweep: {run: simulate, grid: {impact.velocity: [0.1 m/s, 5 m/s]}}"
    file = scenario(tmp_path, chain, "impact: {velocity: 1 m/s}", grid)
    assert shockwave("sweep", file, "-o", tmp_path / "out", "--workers", "1").status == 0
    results = sw.load_sweep(tmp_path / "out")
    assert results.values("yielded_contacts").tolist() == [0, 5]
    assert results.values("plastic_energy")[1] > results.values("plastic_energy")[0] == 0.0


def test_the_value_with_yield_includes_the_force_of_a_spring_behind_the_chain() -> None:
    end = sw.Wall(material="bearing-steel-52100", mass=0.1, stiffness=1e6)
    chain = sw.Chain(material="bearing-steel-52100", diameter="10 mm", granules=2, end=end)
    (sentence,) = sw.simulate(sw.Impact(velocity="3 m/s"), chain).value_with_yield
    assert ", and the force of the spring on the ground is " in sentence


def test_contacts_that_turn_at_the_force_of_precompression_do_not_shorten_the_steps() -> None:
    # the contacts ahead of the wave vibrate by rounding errors at the overlaps at which they flow
    steel = sw.Material(
        youngs_modulus="200 GPa", poisson_ratio=0.3, density=7650.0, yield_strength="1896 MPa", rate_constant=0.035
    )
    light = sw.Segment(count=4, material="aluminium-6061-t6", diameter="7 mm")
    chain = sw.Chain(
        material=steel,
        diameter="9.5 mm",
        granules=(light, *(sw.Segment(count=3), light) * 4),
        end=sw.Wall(material="same", mass="2 kg", stiffness="1e6 N/m", damping="50 N*s/m"),
        precompression=2.0,
        contact=sw.ElasticPlastic(),
    )
    result = sw.simulate(sw.Impact(velocity="1 m/s", material="brass-260"), chain, until=1e-4)
    assert result.run_cost.steps < 500
    assert "has not reached the wall" in " ".join(result.warnings)
    assert not [each for each in result.warnings if "tolerance was not met" in each or "A wave acts" in each]


def test_integrators_step_rate_dependent_contacts_as_the_default_does_or_are_refused() -> None:
    scene = IMPACT, attrs.evolve(BEADS, material=attrs.evolve(STEEL, rate_constant=0.035))
    default = sw.simulate(*scene)
    assert default == attrs.evolve(
        sw.simulate(*scene, integrator=default.integrator), options=default.options, run_cost=default.run_cost
    )
    for name in ("rkn64", "dop853"):
        other = sw.simulate(*scene, integrator=name)
        for one, peak in zip(default.contacts, other.contacts, strict=True):
            assert peak.peak_force == pytest.approx(one.peak_force, rel=one.error_estimate + peak.error_estimate)
    for name in ("rkn1210", "verlet", "radau"):
        with pytest.raises(sw.InvalidValueError, match="must be rkn64, rkn86 or dop853"):
            sw.simulate(*scene, integrator=name)


@pytest.mark.parametrize(("rate", "least", "most"), [(0.0, -0.02, 0.11), (0.035, -0.22, 0.015)])
def test_a_limit_within_the_error_of_the_law_is_undecided(rate: float, least: float, most: float) -> None:
    result = sw.simulate(IMPACT, attrs.evolve(BEADS, material=attrs.evolve(STEEL, rate_constant=rate)))
    force = result.transmitted.peak_force
    for limit, decision in (
        (0.99 * force / (1 + most), "above"),
        (1.01 * force / (1 + most), "undecided"),
        (0.99 * force / (1 + least), "undecided"),
        (1.01 * force / (1 + least), "below"),
    ):
        verdict = sw.Limit(force=limit).verdict(result)
        assert verdict == attrs.evolve(result, scene=attrs.evolve(result.scene, limit=sw.Limit(force=limit))).verdict
        assert verdict.decision == decision
        assert (verdict.remedy is not None) == (decision == "undecided")


def test_a_force_without_an_upper_end_is_above_a_limit_only_beyond_the_error_of_the_law() -> None:
    force = LeavingForce(name="force on the wall", value=100.0, low=99.0, high=None, law_error=(-0.02, 0.11))
    verdicts = [sw.Limit(force=limit).verdict(SimpleNamespace(leaving=force)) for limit in (89.0, 90.0, 99.0)]
    assert [each.decision for each in verdicts] == ["above", "undecided", "undecided"]
    assert "may be 89.1 N or more" in str(verdicts[1])
