"""Entry points for scenarios, their files, and shocks on chains; quantities with units in Python."""

from pathlib import Path
from typing import Any

import pytest

import shockwave as sw

ROOT = Path(__file__).parents[2]
FILE = ROOT / "profiles" / "paper" / "table1-row1.yaml"
SHOCK = sw.Shock(profile=sw.Triangular(duration_ratio=3.0), peak_force=100.0, rise_time=10e-6)
CHAIN = sw.Chain(material=sw.material("paper-steel"), radius=4.75e-3)


@pytest.fixture(params=["scenario", "path", "text"])
def scene(request: pytest.FixtureRequest) -> Any:
    return {"scenario": sw.load_scenario(FILE), "path": FILE, "text": str(FILE)}[request.param]


def test_a_scenario_is_predicted_with_its_own_settings(scene: Any) -> None:
    scenario = sw.load_scenario(FILE)
    expected = scenario.predictor.predict(scenario.shock, scenario.chain, scenario.simulate)
    assert sw.predict(scene).to_dict() == {**expected.to_dict(), "scenario": scenario.name}


def test_a_scenario_is_simulated_with_its_own_options(scene: Any) -> None:
    scenario = sw.load_scenario(FILE)
    result = sw.simulate(scene)
    assert (result.scenario, result.rtol) == (scenario.name, scenario.simulate.rtol or 1e-6)
    assert result.peak_force == sw.simulate(scenario.shock, scenario.chain, rtol=scenario.simulate.rtol).peak_force


def test_a_comparison_of_a_scenario_has_its_published_figures(scene: Any) -> None:
    both = sw.compare(scene)
    scenario = sw.load_scenario(FILE)
    assert both.published == scenario.published is not None
    assert both.predicted is not None
    assert (both.scenario, both.simulated.scenario) == (scenario.name,) * 2


@pytest.mark.usefixtures("few_draws")
def test_studies_take_a_scenario_or_its_file(scene: Any) -> None:
    assert sw.uncertainty(scene, spreads={"shock.peak_force": "5 %"}, draws=64).scenario == "table 1 row 1"
    radius = {"between": ("4 mm", "5 mm"), "target": {"amplification": 1.0}, "points": 2}
    assert sw.design(scene, vary="chain.radius", **radius).scenario == "table 1 row 1"
    materials = {"chain.material": ["copper", "brass-260"]}
    assert sw.design(scene, vary=materials, target=["amplification >= 0.1"], least="peak_force").best


def test_options_given_replace_those_of_the_scenario() -> None:
    assert sw.simulate(FILE, rtol=1e-4, waves="primary").options.waves == "primary"
    assert sw.simulate(FILE, rtol=1e-4).rtol == 1e-4
    paper = sw.predict(FILE, momentum_coefficient="paper", rtol=1e-4)
    assert paper.section4.momentum_coefficient == 13 / 3
    assert paper.peak_force == sw.simulate(FILE, rtol=1e-4).peak_force
    assert sw.compare(FILE, rtol=1e-4).simulated.rtol == 1e-4


def test_an_option_of_wrong_type_is_refused_even_if_it_equals_a_cached_one() -> None:
    assert sw.simulate(SHOCK, CHAIN, timeout=1, waves="primary").options.timeout == 1.0
    with pytest.raises(sw.InvalidValueError, match=r"^timeout: must be"):
        sw.simulate(SHOCK, CHAIN, timeout=True, waves="primary")
    assert sw.simulate(SHOCK, CHAIN, contacts=(1,)).options.contacts == (1,)
    with pytest.raises(sw.InvalidValueError, match=r"^contacts"):
        sw.simulate(SHOCK, CHAIN, contacts=(1.0,))


def test_a_method_given_ignores_the_tolerance_of_the_scenario(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    shock = "{profile: triangular, peak_force: 1 N, rise_time: 10 us, duration_ratio: 2}"
    chain = "{material: paper-steel, diameter: 9.5 mm}"
    file.write_text(f"chain: {chain}\nshock: {shock}\nsimulate: {{rtol: 1e-7}}\n", encoding="utf-8")
    assert sw.simulate(file, integrator="verlet", step=0.02).rtol is None


@pytest.mark.parametrize("scene", [(FILE,), (SHOCK, CHAIN)], ids=["file", "shock"])
@pytest.mark.parametrize("answer", [sw.predict, sw.simulate, sw.compare], ids=["predict", "simulate", "compare"])
def test_an_unknown_argument_is_refused_by_name(scene: Any, answer: Any) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^foo: unknown argument \(got 'foo'; known: .*\blimit, .*\brtol, "):
        answer(*scene, foo=1)


@pytest.mark.parametrize("scene", [FILE, SHOCK], ids=["file-with-a-chain", "shock-alone"])
@pytest.mark.parametrize("answer", [sw.predict, sw.simulate, sw.compare], ids=["predict", "simulate", "compare"])
def test_half_a_scene_is_refused(scene: Any, answer: Any) -> None:
    chain = CHAIN if scene is FILE else None
    with pytest.raises(sw.InvalidValueError, match=r"^scene: must be a scenario or its file alone, or a shock"):
        answer(scene, chain)


def test_a_sweep_is_refused() -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^scene: must describe a single case \(got a sweep of \d+;"):
        sw.predict(ROOT / "profiles" / "maps" / "amplification.yaml")


def test_a_comparison_does_not_advise_to_simulate() -> None:
    profile = sw.PowerLaw(rise_exponent=0.5, decay_exponent=2, duration_ratio=1.5)
    shock = sw.Shock(profile=profile, peak_force=100.0, rise_time=1e-6)
    assert "Simulate to obtain" in " ".join(sw.predict(shock, CHAIN, model="section-4").warnings)
    for answer in (sw.predict(shock, CHAIN), sw.compare(shock, CHAIN)):
        assert "FAILS" in answer.text("explain")  # a condition (3)
        assert "Simulate" not in answer.text("verbose")
