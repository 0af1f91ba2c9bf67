"""Laws of walls, strikers and damping: reference figures, limits, bounds on points not used in the fit."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from scenes import CHAIN, lasting, triangle
from shockwave import cli
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.prediction.chain_laws import (
    MASS_RATIOS,
    RIGID,
    damped_decay,
    striker_count,
    striker_velocity,
    striker_waves,
    wall_factor,
)

pytestmark = pytest.mark.numerical

SHOCK = triangle(1.0)
# Units in which mass and contact stiffness of the granules of CHAIN and a velocity of 0.5 m/s are 1.
VELOCITY = 0.5
FORCE = (CHAIN.granule_mass**3 * CHAIN.contact_stiffness**2 * VELOCITY**6) ** 0.2
TIME = CHAIN.granule_mass * VELOCITY / FORCE


def walled(granules: int = 60, **given: Any) -> sw.Chain:
    return attrs.evolve(CHAIN, granules=granules, end=sw.Wall(**given))


# ---------------------------------------------------------------- walls


@pytest.mark.parametrize(
    ("ratio", "factor"),
    [
        (0.25, 1.0143524),
        (0.5, 1.3449538),
        (1.0, 1.7504034),
        (math.sqrt(2), 1.9439025),
        (2.0, 2.1110769),
        (RIGID, 2.2383756),
    ],
)
def test_the_wall_factor_meets_the_reference_to_all_its_digits(ratio: float, factor: float) -> None:
    assert wall_factor(ratio) == pytest.approx(factor, abs=6e-8)


def test_soft_walls_approach_a_power_law_from_above() -> None:
    ratios = np.geomspace(1e-12, 1e-4, 9)
    # the deviation is linear in the ratio
    assert wall_factor(ratios) / ratios**0.4 == pytest.approx(np.full(9, 1.756917), rel=1e-5)
    assert wall_factor(0.0) == 0.0


def test_the_wall_factor_increases_with_the_stiffness() -> None:
    assert (np.diff(wall_factor(np.linspace(0, RIGID, 5000))) > 0).all()


@pytest.mark.parametrize("ratio", [-0.1, 2.83, math.nan])
def test_ratios_beyond_those_of_spheres_are_refused(ratio: float) -> None:
    with pytest.raises(sw.InvalidValueError, match=r"stiffness_ratio: must be from 0 to 2 sqrt\(2\)"):
        wall_factor([1.0, ratio])


@pytest.mark.parametrize("share", [0.03, 0.17, 0.183, 0.31, 0.77])
def test_the_wall_factor_is_that_of_simulations(share: float) -> None:
    soft = attrs.evolve(CHAIN.material, youngs_modulus=CHAIN.material.youngs_modulus * share / (1 - share))
    striker = sw.Impact(velocity=VELOCITY)
    result: Any = sw.simulate(striker, walled(60, material=soft), rtol=1e-9, contacts=[40])
    found = result.transmitted.peak_force / result.contacts[0].peak_force
    # the wave at contact 40 differs by less than 2e-8 from its limit
    assert wall_factor(RIGID * share) == pytest.approx(found, rel=1e-7)


def test_the_laws_evaluate_a_million_points_in_a_second() -> None:
    ratios = np.random.default_rng(1).uniform(0.01, 2.8, 10**5)
    for law in (wall_factor, striker_waves, lambda each: damped_decay(100, each / 100)):
        begin = time.process_time()
        law(ratios)
        assert time.process_time() - begin < 0.1 * 2  # a tenth of the points; twice, for a busy processor


# ---------------------------------------------------------------- strikers


@pytest.mark.parametrize(
    ("ratio", "peaks"),
    [
        (0.5, [0.38824]),
        (1.0, [0.6395542]),
        (2.0, [0.95026, 0.13456, 0.02112, 0.00393]),
        (5.0, [1.37709, 0.63372, 0.31242, 0.15896, 0.08273, 0.04400]),
        (10.0, [1.65379, 1.06960, 0.72754, 0.50687, 0.35814, 0.25546]),
    ],
)
def test_trains_of_strikers_meet_the_reference_to_all_its_digits(ratio: float, peaks: list[float]) -> None:
    found = striker_waves(ratio)
    digits = 1e-7 if ratio == 1.0 else 1e-5
    assert found[found > 0] == pytest.approx(peaks, abs=0.6 * digits)


@pytest.mark.parametrize(("ratio", "velocity"), [(0.5, -0.36339), (1.0, -0.0710850), (2.0, 0.0), (10.0, 0.0)])
def test_strikers_rebound_with_the_reference_velocity(ratio: float, velocity: float) -> None:
    assert striker_velocity(ratio) == pytest.approx(velocity, abs=6e-6)


def test_light_strikers_approach_the_impulse_limit_of_an_elastic_rebound() -> None:
    ratios = np.array([1e-6, 1e-3])
    limit = IMPULSE_LIMIT * (2 * ratios / MOMENTUM) ** 1.2
    assert striker_waves(ratios)[:, 0] == pytest.approx(limit, rel=2e-3)
    assert striker_velocity(ratios) == pytest.approx((ratios - 1) / (ratios + 1), rel=1e-6)


def test_the_leading_wave_increases_with_the_mass_of_the_striker() -> None:
    ratios = np.geomspace(*MASS_RATIOS, 2000)
    waves = striker_waves(ratios)
    assert (np.diff(waves[:, 0]) > 0).all()
    assert (np.diff(waves, axis=1) <= 0).all()
    assert (np.diff(striker_count(ratios)) >= 0).all()


@pytest.mark.parametrize("ratio", [0.013, 0.37, 1.6, 7.3, 31.0])
def test_the_leading_wave_of_a_striker_is_that_of_simulations(ratio: float) -> None:
    heavy = attrs.evolve(CHAIN.material, density=ratio * CHAIN.material.density)
    contact = round(50 + 10 * ratio**0.65)
    impact, chain = sw.Impact(velocity=VELOCITY, material=heavy), attrs.evolve(CHAIN, granules=contact + 20)
    until = (60 + 1.6 * contact / min(ratio, 1.0) ** 0.2) * TIME
    result: Any = sw.simulate(impact, chain, rtol=1e-8, contacts=[contact], until=until)
    assert result.contacts[0].peak_force / FORCE == pytest.approx(striker_waves(ratio)[0], rel=3e-7)


def test_an_impact_is_predicted_with_its_train() -> None:
    heavy = attrs.evolve(CHAIN.material, density=10 * CHAIN.material.density)
    found = sw.predict(sw.Impact(velocity=VELOCITY, material=heavy), attrs.evolve(CHAIN, granules=200))
    assert isinstance(found, sw.StrikerOutcome)
    assert (found.regime, found.relation, found.amplification) == ("train", None, None)
    assert [wave.peak_force / FORCE for wave in found.waves] == pytest.approx(striker_waves(10.0).tolist(), rel=1e-12)
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert document["striker"]["mass_ratio"] == pytest.approx(10.0)
    assert document["estimate"]["low"] < document["peak_force"] < document["estimate"]["high"]
    assert str(found).startswith("leading wave")


def test_commands_take_strikers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, "granules: 60, end: {wall: same}", "impact: {velocity: 0.5 m/s, diameter: 16 mm}")
    for command in ("predict", "compare"):
        assert cli.main([command, file]) == 0
        assert "force on the wall" in capsys.readouterr().out
        assert cli.main([command, file, file]) == 0
        assert "wall range" in capsys.readouterr().out
    assert cli.main(["predict", "--json", file]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["relation"], found["conditions"], found["striker"]["velocity"]) == (None, [], 0.0)
    assert cli.main(["compare", "--json", file]) == 0
    assert abs(json.loads(capsys.readouterr().out)["errors"]["transmitted"]) < 0.02


@pytest.mark.parametrize("diameter", [1e-3, 4e-3, 20e-3])
def test_the_range_of_a_striker_includes_its_contact_stiffness(diameter: float) -> None:
    chain = attrs.evolve(CHAIN, granules=180)
    impact = sw.Impact(velocity=VELOCITY, diameter=diameter)
    found = sw.predict(impact, chain).estimate
    assert found is not None
    result: Any = sw.simulate(impact, chain, rtol=1e-5, contacts=[150])
    assert found.low <= result.contacts[0].peak_force <= found.high


@pytest.mark.parametrize(
    ("striker", "reason"),
    [
        ({"diameter": 0.2}, "times the mass of a granule"),
        ({"diameter": 1e-4}, "times as stiff"),
        ({"diameter": 60e-3}, "granules"),
    ],
)
def test_strikers_beyond_the_law_have_no_estimate(striker: dict[str, float], reason: str) -> None:
    found = sw.predict(sw.Impact(velocity=VELOCITY, **striker), attrs.evolve(CHAIN, granules=30))
    assert found.estimate is None
    assert found.no_estimate is not None
    assert reason in found.no_estimate


# ---------------------------------------------------------------- damping


@pytest.mark.parametrize(("damping", "accuracy"), [(0.002, 1e-3), (0.02, 3e-3), (0.055, 0.03)])
def test_waves_in_damped_chains_decay_by_the_law(damping: float, accuracy: float) -> None:
    chain = attrs.evolve(CHAIN, granules=120, damping=sw.KuwabaraKono(time=damping * TIME))
    result: Any = sw.simulate(sw.Impact(velocity=VELOCITY), chain, rtol=1e-6, contacts=[15, 50, 85])
    first, *later = (peak.peak_force / FORCE for peak in result.contacts)
    law = damped_decay([35, 70], damping * first ** (1 / 6))
    assert [force / first for force in later] == pytest.approx(law.tolist(), rel=accuracy)


def test_without_damping_a_wave_keeps_its_force() -> None:
    assert damped_decay([0, 1000], 0.0).tolist() == [1.0, 1.0]
    with pytest.raises(sw.InvalidValueError, match="damping_ratio: must be from 0 to "):
        damped_decay(1, 0.2)


# ---------------------------------------------------------------- forces on walls in predictions


@pytest.mark.parametrize("granules", [12, 40, 200])
@pytest.mark.parametrize("end", [{}, {"material": "rigid"}])
def test_the_range_of_the_force_on_a_wall_includes_the_simulation(granules: int, end: dict[str, Any]) -> None:
    chain = walled(granules, **end)
    found = sw.predict(SHOCK, chain).transmitted
    assert found is not None
    result: Any = sw.simulate(SHOCK, chain)
    assert found.low <= result.transmitted.peak_force <= found.high


def test_the_wave_before_a_long_chain_s_wall_is_that_of_the_endless_chain() -> None:
    before, endless = sw.predict(SHOCK, walled(300)), sw.predict(SHOCK, CHAIN)
    assert before.peak_force == endless.peak_force
    assert before.estimate is not None
    assert endless.estimate is not None
    assert before.estimate.peak_force == endless.estimate.peak_force
    assert before.transmitted is not None
    factor = float(wall_factor(math.sqrt(2)))
    assert before.transmitted.peak_force == pytest.approx(factor * endless.estimate.peak_force, rel=1e-12)


def test_too_short_a_chain_states_in_its_first_line_why_the_force_is_not_known() -> None:
    found = sw.predict(SHOCK, walled(5))
    assert found.transmitted is None
    assert str(found).startswith("force on the wall not known a priori: in a chain of 5 granules")


def test_the_wall_can_yield_first() -> None:
    hard = attrs.evolve(CHAIN.material, yield_strength=2e9)
    chain = attrs.evolve(walled(200, material="rigid"), material=hard)
    predicted: Any = sw.predict(SHOCK, chain)
    simulated: Any = sw.simulate(SHOCK, chain)
    assert predicted.yielding.first_yield_force == pytest.approx(simulated.yielding.first_yield_force)
    assert predicted.yielding.peak_ratio == pytest.approx(simulated.yielding.peak_ratio, rel=0.05)


def test_a_movable_wall_is_refused() -> None:
    with pytest.raises(sw.NotCoveredError, match=r"chain\.end"):
        sw.predict(SHOCK, walled(60, mass=1.0))


def test_the_verdict_on_a_limit_is_that_of_the_force_on_the_wall() -> None:
    outcome = sw.predict(SHOCK, walled(200))
    assert outcome.transmitted is not None
    found = sw.Limit(force=2 * outcome.transmitted.peak_force).verdict(outcome)
    assert (found.value, found.force, found.decision) == (outcome.transmitted.peak_force, "force on the wall", "below")


def written(folder: Path, chain: str, excitation: str) -> str:
    file = folder / "scene.yaml"
    file.write_text(f"chain: {{material: ptfe, diameter: 10 mm, {chain}}}\n{excitation}\n")
    return str(file)


PULSE = "shock: {profile: triangular, peak_force: 10 N, rise_time: 20 us, duration_ratio: 3}"


def test_commands_lead_with_the_force_on_the_wall(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, "granules: 80, end: {wall: rigid}", PULSE)
    assert cli.main(["predict", file]) == 0
    assert capsys.readouterr().out.startswith("scene: force on the wall ")
    assert cli.main(["predict", "--json", file]) == 0
    wall = json.loads(capsys.readouterr().out)["transmitted"]
    assert list(wall) == ["peak_force", "low", "high"]
    assert cli.main(["compare", "--json", file]) == 0
    both = json.loads(capsys.readouterr().out)
    error = wall["peak_force"] / both["simulated"]["transmitted"]["peak_force"] - 1
    assert both["errors"] == {"peak_force": None, "transmitted": pytest.approx(error)}
    assert cli.main(["compare", file]) == 0
    assert "force on the wall" in capsys.readouterr().out
    assert cli.main(["compare", file, file]) == 0
    assert "estimate" in capsys.readouterr().out


def test_without_a_wall_the_key_is_null(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["predict", "--json", written(tmp_path, "granules: 80", PULSE)]) == 0
    assert json.loads(capsys.readouterr().out)["transmitted"] is None


def test_sweeps_have_columns_of_the_force_on_the_wall(tmp_path: Path) -> None:
    more = "\nsweep: {run: compare, grid: {chain.granules: [60, 80]}}"
    file = written(tmp_path, "granules: 60, end: {wall: same}", PULSE + more)
    sw.run_sweep(sw.load_scenario(file), tmp_path / "out", workers=1)
    found = sw.load_sweep(tmp_path / "out")
    low, high, force = (found.values(name) for name in ("transmitted_low", "transmitted_high", "transmitted_force"))
    assert ((low <= force) & (force <= high)).all()
    assert found.values("transmitted_error") == pytest.approx(found.values("transmitted") / force - 1)


def test_a_plain_prediction_loads_no_code_for_walls_and_strikers() -> None:
    code = (
        "import sys, shockwave as sw\n"
        "steel = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)\n"
        "shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=100.0, rise_time=2e-5)\n"
        "print(sw.predict(shock, sw.Chain(material=steel, radius=5e-3)))\n"
        "names = ('prediction.chain_laws', 'prediction.striker', 'chain.ends', 'chain.impact', 'chain.coverage')\n"
        "sys.exit(any(f'shockwave.{name}' in sys.modules for name in names))\n"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, capture_output=True).returncode == 0


# ---------------------------------------------------------------- packings


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
    one, other = sw.predict(SHOCK, packed).estimate, sw.predict(SHOCK, plain).estimate
    assert one is not None
    assert other is not None
    assert (one.low, one.high) == pytest.approx((share * other.low, share * other.high), rel=1e-9)
    many = sw.Predictor().predict_many([SHOCK], packed)
    assert many.peak_force[0] == pytest.approx(sw.predict(SHOCK, packed).peak_force, rel=1e-12)
    assert many.estimate[0, 0] == pytest.approx(one.peak_force, rel=1e-12)


def test_contacts_of_a_finite_packing_carry_their_share() -> None:
    packed, plain, share = equivalent("hexagonal", granules=20)
    one, other = (sw.simulate(SHOCK, chain, contacts=[0, 5]) for chain in (packed, plain))
    assert [peak.peak_force for peak in one.contacts] == pytest.approx(
        [share * peak.peak_force for peak in other.contacts], rel=1e-9
    )


def test_packings_take_no_further_features() -> None:
    with pytest.raises(sw.InvalidValueError, match="packing: must be left out"):
        attrs.evolve(walled(), packing="fcc-111")
    with pytest.raises(sw.InvalidValueError, match="packing: must be hexagonal or fcc-111"):
        attrs.evolve(CHAIN, packing="bcc")
    packed = attrs.evolve(CHAIN, packing="hexagonal", granules=20)
    for run in (sw.predict, sw.simulate):
        with pytest.raises(sw.ShockwaveError, match=r"chain\.packing: must be left out"):
            run(sw.Impact(velocity=1.0), packed)


@pytest.mark.parametrize("command", ["predict", "simulate", "compare"])
def test_commands_take_a_packing(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, "packing: fcc-111", PULSE)
    assert cli.main([command, file, "--json"]) == 0
    capsys.readouterr()
    assert cli.main([command, file]) == 0
    assert "packing fcc-111" in capsys.readouterr().out


def test_a_sweep_of_packings_is_that_of_chains(tmp_path: Path) -> None:
    file = written(
        tmp_path, "packing: hexagonal", PULSE + "\nsweep: {run: predict, grid: {chain.radius: [4 mm, 5 mm]}}"
    )
    Path(file).write_text(Path(file).read_text().replace("diameter: 10 mm", "radius: 5 mm"))
    sw.run_sweep(sw.load_scenario(file), tmp_path / "out", workers=1)
    last = sw.predict(
        sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=10.0, rise_time=20e-6),
        sw.Chain(material=sw.material("ptfe"), radius=5e-3, packing="hexagonal"),
    )
    assert last.estimate is not None
    found = sw.load_sweep(tmp_path / "out")
    assert found.values("peak_force")[-1] == pytest.approx(last.peak_force, rel=1e-12)
    assert found.values("estimate")[-1] == pytest.approx(last.estimate.peak_force, rel=1e-12)


def test_a_striker_needs_a_finite_chain() -> None:
    with pytest.raises(sw.InvalidValueError, match=r"^chain.granules: must be given, because a striker"):
        sw.predict(sw.Impact(velocity=1.0), CHAIN)


@pytest.mark.parametrize("end", [None, sw.Wall()], ids=["free", "wall"])
def test_a_wave_needs_as_many_granules_before_any_end(end: sw.Wall | None) -> None:
    shock = triangle(4.0)
    needed = 12  # 8, and the duration
    short, enough = (attrs.evolve(CHAIN, granules=count, end=end) for count in (needed - 1, needed))
    assert sw.predict(shock, short).estimate is None
    found, endless = sw.predict(shock, enough).estimate, sw.predict(shock, CHAIN).estimate
    assert found is not None
    assert endless is not None
    assert found.low < endless.low < endless.high < found.high
    many = sw.Predictor().predict_many([shock], enough)
    assert many.estimate[0].tolist() == pytest.approx([found.peak_force, found.low, found.high], rel=1e-9)


def test_waves_of_several_peaks_need_a_longer_chain_to_separate() -> None:
    two = sw.Tabulated(times=[0, 1, 2, 3, 4], forces=[0, 100, 0, 80, 0])

    def lowered(profile: sw.ShockProfile, granules: int) -> float:
        """Decrease of the lower end of the range in a finite chain."""
        shock, finite = lasting(profile, 8.0), attrs.evolve(CHAIN, granules=granules)
        low, endless = (sw.predict(shock, chain).estimate for chain in (finite, CHAIN))
        assert low is not None
        assert endless is not None
        return 1 - low.low / endless.low

    one = sw.Triangular(duration_ratio=4)
    assert lowered(two, 20) > lowered(one, 20) + 0.2
    assert lowered(two, 300) < 1e-3
