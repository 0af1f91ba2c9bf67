"""Uncertainty: distributions against direct simulations and closed forms, and the block of a scenario."""

from __future__ import annotations

import math
import re
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np
import pytest
from attrs import evolve

import shockwave as sw
from shockwave import cli
from shockwave.base.quantities import Quantity
from shockwave.scenario.dotted_names import variable
from shockwave.scenario.uncertainty_block import Spread
from shockwave.scenario.variations import Family
from shockwave.scene.force_limit import LeavingForce, Limit
from shockwave.studies import varied_scenes as scenes
from shockwave.studies.quasi_monte_carlo import Distribution, difference, exceedance, statistics
from shockwave.studies.uncertainty_result import Estimate
from shockwave.studies.uncertainty_study import UncertainScenes, _sensitivity
from support.pages import ROOT
from support.scenes import CASE_A, CHAIN, POWER, UNITS, triangle

FILE = ROOT / "profiles" / "examples" / "protector.yaml"
SPREADS = {
    "chain.material.youngs_modulus": {"factor": 1.2},
    "chain.radius": "3 %",
    "shock.peak_force": {"sd": "8 N"},
    "shock.rise_time": {"between": [1.0 * UNITS.time, 3.0 * UNITS.time]},
}
SCENE = scenes.scenario_of(CASE_A, CHAIN)
SHORT = sw.Shock(profile=POWER, peak_force=100.0, rise_time=1e-3 * UNITS.time)
FORCE = LeavingForce(name="force")


@cache
def result_of_case_a() -> sw.Uncertainty:
    return sw.uncertainty(CASE_A, CHAIN, SPREADS, draws=512)


@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize(
    "spreads",
    [SPREADS, {"shock.parameters.decay_exponent": "5 %", "shock.duration_ratio": {"between": [2.5, 3.5]}}],
    ids=["values", "shape"],
)
def test_draws_are_simulations_of_their_scenes(spreads: dict[str, Any]) -> None:
    result = sw.uncertainty(CASE_A, CHAIN, spreads, draws=64)
    values = [{name: float(result.values[name][index]) for name in spreads} for index in range(20)]
    drawn = [Family(SCENE).scenario(each) for each in values]
    known = sw.simulate_many([each.shock for each in drawn], [each.chain for each in drawn], rtol=1e-8)
    forces = [each.peak_force for each in known]
    assert result.outputs["peak_force"][:20] == pytest.approx(forces, rel=result.peak_force.model_error + 1e-8)
    ratios = [each.amplification for each in known]
    assert result.outputs["amplification"][:20] == pytest.approx(ratios, rel=result.peak_force.model_error + 1e-8)


@pytest.mark.usefixtures("few_draws")
def test_a_warning_of_some_draws_is_reported_with_their_number() -> None:
    """First yield scales as R^2: some of the draws are beyond it, although the scenario is not."""
    chain = sw.Chain(material="bearing-steel-52100", radius=4.75e-3)
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=1.0, rise_time=20e-6)
    near: Any = {"vary": "shock.peak_force", "between": (1, 1e3), "target": "yield.peak_ratio = 0.99"}
    force = float(sw.design(shock, chain, **near).solutions[0].value)
    result = sw.uncertainty(evolve(shock, peak_force=force), chain, {"shock.peak_force": "5 %"}, draws=64)
    (warning,) = result.warnings
    assert ", here the greatest: Beyond elastic validity" in warning
    count, scenes = map(int, re.findall(r"^In (\d+) of (\d+) scenes", warning)[0])
    assert scenes == 192
    assert 0.3 < count / scenes < 0.5


def test_a_short_shock_with_lognormal_values_is_lognormal() -> None:
    """F ~ t0^(6/5) F0^(6/5) R^(-8/5) for an impulse: all results have closed forms."""
    factors = {"shock.rise_time": 1.1, "shock.peak_force": 1.05, "chain.radius": 1.08}
    powers = {"shock.rise_time": 1.2, "shock.peak_force": 1.2, "chain.radius": -1.6}
    result = sw.uncertainty(SHORT, CHAIN, {name: {"factor": factor} for name, factor in factors.items()}, draws=1024)
    variances = {name: (powers[name] * math.log(factor)) ** 2 for name, factor in factors.items()}
    sigma2 = sum(variances.values())
    force, shares = result.peak_force, result.peak_force.sensitivities
    median = force.nominal
    # a 95 % interval fails once in twenty times, three times that interval practically never
    assert force.mean.value == pytest.approx(median * math.exp(sigma2 / 2), abs=3 * force.mean.error)
    sd = median * math.exp(sigma2 / 2) * math.sqrt(math.expm1(sigma2))
    assert force.sd.value == pytest.approx(sd, abs=3 * force.sd.error)
    high = median * math.exp(1.6448536 * math.sqrt(sigma2))
    assert force.quantiles[0.95].value == pytest.approx(high, abs=3 * force.quantiles[0.95].error)
    for one in shares:
        first = math.expm1(variances[one.name]) / math.expm1(sigma2)
        rest = sigma2 - variances[one.name]
        total = 1 - math.expm1(rest) / math.expm1(sigma2)
        assert one.first.value == pytest.approx(first, abs=3 * one.first.error)
        assert one.total.value == pytest.approx(total, abs=3 * one.total.error)
        # of the slope over 0.15 standard deviations of a power with exponents up to 1.6
        assert one.exponent == pytest.approx(powers[one.name], abs=1e-3)
        assert abs(one.exponent - powers[one.name]) < one.exponent_error


def test_intervals_of_quantiles_contain_the_exact_values() -> None:
    """Of sixteen batches of evenly spaced numbers the quantiles are known."""
    rng, shares = np.random.default_rng(3), (0.05, 0.95)
    quantiles = []
    for _ in range(100):
        batches = (rng.permuted(np.tile(np.arange(64), (16, 1)), axis=1) + rng.random((16, 64))) / 64
        quantiles.append(statistics(batches)["quantiles"])
    held = [abs(each[share].value - share) <= each[share].error for each in quantiles for share in shares]
    # a 95 % interval that is too wide for evenly spaced numbers; 75 % would be that of the scatter of the quantiles
    assert np.mean(held) > 0.93
    off = np.mean([abs(each[share].value - share) for each in quantiles for share in shares])
    assert np.mean([each[share].error for each in quantiles for share in shares]) < 6 * off


def test_a_slope_has_the_error_of_its_curvature_and_of_the_simulations() -> None:
    ends = np.array([-1.0, -0.5, 0.5, 1.0])
    # x + x^3: 2 over the wide ends, 1.25 over the narrow ones
    assert difference(ends, ends + ends**3, 0.0) == Estimate(1.25, 0.75)
    assert difference(ends, 3 * ends, 0.1).error == pytest.approx(0.2, rel=1e-12)


@pytest.mark.parametrize(("longest", "refused"), [(5.9, True), (6.1, False)])
def test_a_draw_that_lasts_too_long_is_an_error(longest: float, refused: bool) -> None:
    scenario = scenes.scenario_of(triangle(6.0), CHAIN)
    (result,) = scenes.simulate_each([scenario], scenario.simulate, 1e-4, longest)
    assert isinstance(result, sw.InvalidValueError) == refused


def test_each_draw_has_the_bound_of_its_later_force(monkeypatch: pytest.MonkeyPatch) -> None:
    forces = [LeavingForce(name="force", value=1.0, high=high, later=7.0) for high in (1.1, None)]
    results = [SimpleNamespace(leaving=force, error_estimate=1e-6, wave_warnings=()) for force in forces]
    monkeypatch.setattr(scenes, "simulate_all", lambda *_: results)
    scenario: Any = SimpleNamespace(limit=Limit(force=5.0), impact=object(), simulate=None)
    family: Any = SimpleNamespace(scenario=lambda values: scenario)
    draws = UncertainScenes(scenario, [], SimpleNamespace(yielding=None), [Quantity("leaving.value", "N")], family)
    figures, _ = draws.evaluate({"impact.velocity": np.ones(2)}, 1e-4)
    # no bound is known where the force itself has none
    assert figures.tolist() == [[1.0, 1.0], [1.0, 1.0], [7.0, math.inf]]


@pytest.mark.parametrize("value", [2.0, -2.0])
def test_an_exponent_has_the_sign_of_a_relative_change(value: float) -> None:
    parameter: Any = SimpleNamespace(name="shock.parameters.rise_rate", value=value)
    found = _sensitivity(parameter, Estimate(3.0, 0.3), 6.0, np.zeros((2, 2)))
    # d ln Q/d ln x = Q' x/Q
    assert (found.exponent, found.exponent_error) == pytest.approx((3.0 * value / 6.0, 0.1), rel=1e-12)


def test_a_verdict_is_on_the_range_of_98_percent_with_the_error_of_the_simulations() -> None:
    forces = np.linspace(1.0, 2.0, 1600).reshape(100, 16).T
    _, verdict = exceedance(Limit(force=5.0), FORCE, forces, 0.1)
    # the ends of 98 % are 1.01 and 1.99
    assert (verdict.low, verdict.high) == (pytest.approx(1.01 * 0.9, rel=1e-3), pytest.approx(1.99 * 1.1, rel=1e-3))
    assert exceedance(Limit(force=2.1), FORCE, forces, 0.1)[1].decision == "undecided"
    assert exceedance(Limit(force=2.1), FORCE, forces, 0.0)[1].decision == "below"


def test_a_force_at_the_limit_reaches_it() -> None:
    found, _ = exceedance(Limit(force=2.0), FORCE, np.full((16, 16), 2.0), 0.0)
    assert found.probability == 1.0


def exponent(scenario: sw.Scenario, name: str, spread: float) -> float:
    """Exponent of the peak force for a relative standard deviation of the parameter."""
    one = Distribution.of(Spread(variable(name, scenes.data_of(scenario)), "relative", (spread,)), scenario)
    own = UncertainScenes.of(scenario, [one], 1e-4, ())
    ((slope, _),) = own.slopes()
    return slope.value * one.value / float(own.nominal.peak_force)


def distribution(name: str, value: float, kind: Any, *numbers: float) -> Distribution:
    scenario = Family(SCENE).scenario({name: value})
    return Distribution.of(Spread(variable(name, scenes.data_of(scenario)), kind, numbers), scenario)


def test_a_normal_distribution_stays_within_the_range_of_its_value() -> None:
    one = distribution("chain.material.poisson_ratio", 0.45, "sd", 0.1)
    values = one.at((np.arange(1000) + 0.5) / 1000)
    assert values.max() < 0.5
    # the limit 0.5 is half a standard deviation above the mean
    assert one.cut == pytest.approx(0.3085, abs=1e-4)
    assert np.median(values) < 0.45


@pytest.mark.parametrize(
    ("kind", "numbers", "mean", "sd"),
    [
        ("sd", (0.5,), 10.0, 0.5),
        ("relative", (0.05,), 10.0, 0.5),
        ("between", (8.0, 14.0), 11.0, 6 / math.sqrt(12)),
        ("factor", (1.1,), 10 * math.exp(math.log(1.1) ** 2 / 2), 10 * math.log(1.1) * (1 + 0.75 * math.log(1.1) ** 2)),
    ],
    ids=["sd", "relative", "between", "factor"],
)
def test_distributions_have_the_requested_mean_and_deviation(
    kind: str, numbers: tuple[float, ...], mean: float, sd: float
) -> None:
    one = distribution("shock.peak_force", 10.0, kind, *numbers)
    values = one.at((np.arange(20_000) + 0.5) / 20_000)
    assert values.mean() == pytest.approx(mean, rel=1e-5)
    # the standard deviation of the lognormal one is of second order, and the midpoint rule truncates the tails
    assert one.sd == pytest.approx(sd, rel=2e-4 if kind == "factor" else 1e-12)


def test_an_interval_need_not_contain_the_value_of_the_scenario() -> None:
    ratio, step = POWER.duration_ratio, 1e-3
    between = {"shock.duration_ratio": {"between": [1.1 * ratio, 1.4 * ratio]}}
    (one,) = sw.uncertainty(CASE_A, CHAIN, between, draws=256).peak_force.sensitivities
    shocks = [evolve(CASE_A, profile=evolve(POWER, duration_ratio=ratio * math.exp(step * k))) for k in (-1, 1)]
    low, high = (sw.simulate(shock, CHAIN, rtol=1e-10, waves="primary").peak_force for shock in shocks)
    # the value is below the interval: the difference to one side, over 2 % of the value, has an error of first order
    assert one.exponent == pytest.approx(math.log(high / low) / (2 * step), abs=one.exponent_error + 1e-3)


def test_a_cut_distribution_has_a_warning() -> None:
    result = sw.uncertainty(CASE_A, CHAIN, {"chain.material.poisson_ratio": {"sd": 0.2}}, draws=256)
    assert any("0.16 of the distribution of chain.material.poisson_ratio" in warning for warning in result.warnings)


def load(tmp_path: Path, block: str) -> sw.Scenario:
    file = tmp_path / "scene.yaml"
    text = FILE.read_text()
    file.write_text(text[: text.index("uncertainty:")] + f"uncertainty: {block}\n")
    return sw.load_scenario(file)


def test_a_parameter_without_effect_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.yaml"
    chain = "{material: ptfe, diameter: 9.5 mm, granules: [{count: 5, diameter: 9 mm}], end: {wall: same}}"
    shock = "{profile: triangular, peak_force: 100 N, rise_time: 15 us, duration_ratio: 4}"
    file.write_text(f"chain: {chain}\nshock: {shock}\nuncertainty: {{shock.peak_force: 5 %, chain.diameter: 5 %}}\n")
    assert cli.main(["uncertainty", str(file), "--draws", "256"]) == 3
    message = capsys.readouterr().err
    assert message.startswith(f"{file}:3:")
    assert "chain.diameter': must change a quantity of the result (got the same " in message


def test_the_block_is_read_in_any_units(tmp_path: Path) -> None:
    scenario = load(tmp_path, "{chain.diameter: {sd: 10 um}, shock.rise_time: {between: [30 us, 0.05 ms]}}")
    assert [(one.name, one.kind, one.numbers) for one in scenario.uncertainty] == [
        ("chain.diameter", "sd", (1e-5,)),
        ("shock.rise_time", "between", (30e-6, 50e-6)),
    ]


FAULTS = {
    "name": ("{chain.radios: 5 %}", "15:15", "did you mean 'chain.radius'"),
    "bare": ("{chain.radius: 5}", "15:29", "must be a percentage such as 5 %"),
    "form": ("{chain.radius: {factr: 2}}", "15:30", "did you mean 'factor'"),
    "unit": ("{chain.radius: {sd: 1 N}}", "15:34", "must be a length"),
    "factor": ("{chain.radius: {factor: 0.5}}", "15:38", "must be > 1"),
    "order": ("{chain.radius: {between: [2 mm, 1 mm]}}", "15:39", "must ascend"),
    "range": ("{chain.material.poisson_ratio: {between: [0.1, 0.7]}}", "15:61", "must be > -1 and < 0.5"),
    "length": ("{chain.radius: {between: [1 mm]}}", "15:39", "must be a list of two values"),
    "null": ("{chain.material.yield_strength: {between: [null, 1 GPa]}}", "15:56", "must be a list of two values"),
    "whole": ("{chain.granules: 5 %}", "15:15", "must be a continuous value"),
    "setting": ("{predict.equal_tolerance: 5 %}", "15:15", "must be a continuous value of the chain or its excitation"),
    "twins": ("{chain.radius: 5 %, chain.diameter: 5 %}", "15:34", "must be left out if chain.radius is given"),
    "list": ("[chain.radius]", "15:14", "must be a mapping of dotted names"),
}


@pytest.mark.parametrize(("block", "place", "message"), FAULTS.values(), ids=FAULTS)
def test_faults_are_reported_with_their_place(block: str, place: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(sw.ScenarioError) as caught:
        load(tmp_path, block)
    (fault,) = caught.value.faults
    assert fault.location.endswith(f"scene.yaml:{place}")
    assert message in fault.problem


CALLS: dict[str, tuple[dict[str, Any], str]] = {
    "nothing": ({}, "uncertainty: must name the uncertain parameters"),
    "name": ({"spreads": {"chain.radios": "5 %"}}, "uncertainty.*did you mean 'chain.radius'"),
    "draws": ({"spreads": SPREADS, "draws": 5000}, "draws: must be a power of 2"),
    "rtol": ({"spreads": SPREADS, "rtol": 1.0}, "rtol: must be >= 1e-07"),
    "too-long": (
        {"spreads": {"shock.rise_time": {"factor": 50}}},
        r"^uncertainty: must give only valid samples \(shock: must last at most 300 .*narrow the distributions",
    ),
}


@pytest.mark.parametrize(("given", "message"), CALLS.values(), ids=CALLS)
def test_wrong_arguments_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=message):
        sw.uncertainty(CASE_A, CHAIN, **given)


@pytest.mark.parametrize("argument", ["--draws=100", "--seed=-1"])
def test_a_wrong_argument_is_refused(argument: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["uncertainty", str(FILE), argument]) == 2
    assert capsys.readouterr().err.startswith(f"{argument.partition('=')[0]}: must be a whole number")


def test_numbers_have_the_digits_that_their_errors_leave() -> None:
    text, force = str(result_of_case_a()), result_of_case_a().peak_force
    assert max(map(len, text.splitlines())) <= 80
    mean = next(line.split() for line in text.splitlines() if line.lstrip().startswith("mean"))
    # sampling and the simulations; one digit, or two digits if the first is 1 or 2
    assert float(mean[3]) == pytest.approx(math.hypot(force.mean.error, force.model_error * force.mean.value), rel=0.2)
    assert text.startswith(f"peak force: mean {mean[1]} +- {mean[3]} N, 90 % between ")
    assert not re.search(r"\+- \de[-+]", text)
    assert [str(Estimate(12345.6, error)) for error in (0.04, 1.3, 40.0)] == [
        "12345.60 +- 0.04",
        "12345.6 +- 1.3",
        "12350 +- 40",
    ]


@pytest.mark.parametrize(("share", "explained"), [(0.9, False), (1.11, True)])
def test_a_contribution_above_100_per_cent_is_explained(share: float, explained: bool) -> None:
    result = result_of_case_a()
    peak = evolve(
        result.quantities[0],
        sensitivities=[evolve(each, total=Estimate(share, 0.1)) for each in result.quantities[0].sensitivities],
    )
    text = " ".join(str(evolve(result, quantities=(peak,))).split())
    assert ("contributions above 100 % are due to sampling" in text) == explained


def test_a_scenario_with_a_sweep_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "swept.yaml"
    file.write_text(f"{FILE.read_text()}\nsweep: {{grid: {{shock.peak_force: [1, 2]}}}}\n")
    design = ["design", str(file), "--vary", "chain.radius", "--target", "speed=9", "--between", "1 mm", "2 mm"]
    for arguments in (["uncertainty", str(file)], design):
        assert cli.main(arguments) == 2
        assert "delete the `sweep` block" in capsys.readouterr().err


def record(folder: Path, parameters: str, spread: str) -> Path:
    (folder / "blow.csv").write_text("time [us],value\n0,0\n5,50\n10,100\n15,100\n20,50\n30,0\n")
    file = folder / "blow.yaml"
    shock = f"shock: {{profile: tabulated, parameters: {{file: blow.csv, {parameters}}}}}"
    chain = "chain: {material: stainless-steel-316, diameter: 12.7 mm}"
    file.write_text(f"{chain}\n{shock}\nuncertainty:\n  {spread}\n")
    return file


@pytest.mark.parametrize(
    ("name", "parameters"),
    [("area", "unit: MPa, area: 1 mm**2"), ("scale", "unit: N, scale: 1")],
    ids=["area", "scale"],
)
def test_the_sensitivity_of_a_sensor_can_be_uncertain(name: str, parameters: str, tmp_path: Path) -> None:
    scene = sw.load_scenario(record(tmp_path, parameters, f"shock.parameters.{name}: 5 %"))
    # the force of the record is proportional to each of them
    known = []
    for factor in (0.99, 1.01):
        shock = evolve(scene.shock, peak_force=factor * scene.shock.peak_force)
        known.append(sw.simulate(shock, scene.chain, rtol=1e-8, waves="primary").peak_force)
    slope = math.log(known[1] / known[0]) / math.log(1.01 / 0.99)
    # the differences over 2 % and 1.5 % are of second order
    assert exponent(scene, f"shock.parameters.{name}", 0.05) == pytest.approx(slope, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("shock.parameters.scale", "must have a value"),
        ("chain.precompression", "must be {sd: ...} or {between: ...}, as the value is 0"),
    ],
    ids=["not-stated", "percentage-of-nothing"],
)
def test_a_value_that_the_scenario_does_not_have_is_refused_with_its_place(
    name: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = record(tmp_path, "unit: N", f"{name}: 5 %")
    assert cli.main(["uncertainty", str(file)]) == 3
    assert capsys.readouterr().err.startswith(f"{file}:4:3: uncertainty.'{name}': {message}")


@pytest.mark.usefixtures("few_draws")
def test_the_probability_of_yield_is_that_of_the_draws() -> None:
    chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm", granules=5, end=sw.Wall())
    shock = sw.Shock(profile="half-sine", peak_force=60.0, rise_time="20 us")
    result = sw.uncertainty(shock, chain, {"shock.peak_force": "20 %"}, draws=64, quantities=["yield.peak_ratio"])
    assert result.yield_probability is not None
    share = float(np.mean(result.outputs["yield.peak_ratio"] > 1))
    assert 0.01 < share < 0.99
    assert result.yield_probability.value == pytest.approx(share)
    assert "first yield" in str(result)


@pytest.mark.usefixtures("few_draws")
def test_contacts_without_a_yield_strength_do_not_hide_that_others_yield() -> None:
    pad = sw.Segment(count=1, material=sw.Material(youngs_modulus=5e9, poisson_ratio=0.4, density=1200.0))
    chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm", granules=[sw.Segment(count=4), pad])
    shock = sw.Shock(profile="half-sine", peak_force=300.0, rise_time="20 us")
    result = sw.uncertainty(shock, chain, {"shock.peak_force": "1 %"}, draws=64)
    assert result.yield_probability is not None
    assert result.yield_probability.value == 1
    assert "probability 100 % +- 0 % at contacts that are judged" in str(result)


@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize("at", ["chain", "spring"])
def test_the_force_that_is_judged_comes_first(at: Literal["chain", "spring"]) -> None:
    end = sw.Wall(mass=0.5, stiffness=1e6)
    chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm", granules=3, end=end)
    limit = Limit(force=20.0, at=at)
    result = sw.uncertainty(sw.Impact(velocity=0.1), chain, {"impact.velocity": "5 %"}, draws=64, limit=limit)
    name = {"chain": "transmitted.peak_force", "spring": "structure.peak_spring_force"}[at]
    assert result.quantities[0].name == name
    assert str(result).startswith(f"{result.quantities[0].label}: mean ")
