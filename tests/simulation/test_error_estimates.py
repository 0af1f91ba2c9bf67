"""What error estimates contain: every part of an error, in full; and how they compare with errors of many scenes."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave.base.numerics import FloatArray
from shockwave.engine.peak_log import Peak
from shockwave.engine.search_request import Primary, SearchStatus
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation import convergence_runs as repeated_runs
from shockwave.simulation import leading_wave, wave_passages, wave_train_run
from shockwave.simulation import wave_train as train
from shockwave.simulation.result_parts import MeasuredWave, Passage
from shockwave.simulation.wave_setup import scale_scene, setup_of
from shockwave.simulation.wave_train_run import ChainRun
from support.pulse_families import FAMILIES
from support.random_chains import scene as random_scene
from support.scenes import CASE_A, CHAIN, UNITS, lasting, random_pulses

# ---------------------------------------------------------------- contacts of a chain, from two runs


def motion(contacts: int, changes: dict[int, float] | None = None, late: float = 0.0) -> Any:
    """A run with unit forces at all contacts, but for relative ``changes``."""
    forces = np.ones(contacts)
    for contact, change in (changes or {}).items():
        forces[contact] += change
    return SimpleNamespace(forces=forces, dynamic_forces=forces, force_times=np.full(contacts, 5.0 + late))


def estimates(
    coarse: Any, fine: Any, tolerance: float = 1e-12, damping: float = 0.0, judged: Any = None, ratio: float = 0.01
) -> tuple[FloatArray, bool]:
    assembly = SimpleNamespace(force=None, damping=np.full(len(fine.forces), damping))
    every = np.arange(len(fine.forces)) if judged is None else np.array(judged)
    options = SimpleNamespace(step=None)
    case: Any = SimpleNamespace(rtol=1e-5, options=options, assembly=assembly, judged_contacts=lambda forces: every)
    return repeated_runs._errors(case, coarse, fine, tolerance, ratio)


def test_the_estimate_is_twice_the_difference_of_two_runs_there_and_at_three_contacts_around() -> None:
    errors, missed = estimates(motion(12, {5: 1e-4}), motion(12), judged=[0])
    # the difference may vanish by chance at a contact, but not at all of its neighbours
    assert np.flatnonzero(errors > 1e-6).tolist() == [2, 3, 4, 5, 6, 7, 8]
    # both runs may be wrong; the tolerance of a step adds 1e-12
    assert errors[2:9] == pytest.approx(2e-4, rel=1e-6)
    assert not missed  # no run is made for the sake of contacts that do not decide
    # damping ends abruptly when a contact opens
    damped, _ = estimates(motion(12, {5: 1e-4}), motion(12), damping=0.1, judged=[0])
    assert damped == pytest.approx(2 * errors, rel=1e-2)


@pytest.mark.parametrize(("ratio", "estimate", "missed"), [(0.01, 2e-5, True), (0.001, 2e-6, False)])
def test_the_estimate_of_contacts_that_decide_is_in_proportion_to_the_tolerances(
    ratio: float, estimate: float, missed: bool
) -> None:
    errors = estimates(motion(12, {5: 1e-4}), motion(12), ratio=ratio)
    assert errors[1] == missed
    assert errors[0][5] == pytest.approx(estimate, rel=1e-5)
    # a fifth of it around
    assert errors[0][[2, 3, 4, 6, 7, 8]] == pytest.approx(estimate / 5, rel=1e-5)


def test_the_estimate_contains_the_tolerance_of_a_step() -> None:
    errors, missed = estimates(motion(4), motion(4), tolerance=1e-7)
    assert np.all(errors >= 1e-7)
    assert not missed


@pytest.mark.parametrize(("late", "missed"), [(4e-4, False), (1e-3, True)])
def test_times_of_peaks_have_ten_times_the_tolerance_in_characteristic_times(late: float, missed: bool) -> None:
    assert estimates(motion(4, late=late), motion(4))[1] == missed


# ---------------------------------------------------------------- waves of a train, from two runs


def wave(force: float, **values: float) -> MeasuredWave:
    rest = {"momentum": 1.0, "energy": 1.0, "speed": 1.0, "width": 1.0, "granule_velocity": 1.0, "contact": 60}
    return MeasuredWave(
        **{**rest, "peak_force": force, "arrival_time": 60.0, "error_estimate": 0.0, "foot": 0.0} | values
    )


def train_errors(waves: list[MeasuredWave], change: float = 0.0, early: float = 60.0, defect: float = 0.0) -> list[Any]:
    """Error estimates of waves that a second run finds stronger by ``change`` at the time ``early``."""
    problem, integrator = SimpleNamespace(exponent=1.5), SimpleNamespace(tolerance=1e-9)
    fine: Any = SimpleNamespace(waves=waves, problem=problem, integrator=integrator, work=1.0, energy=1.0 + defect)
    traced = [Peak(0, 60, -1, -1, early, each.peak_force) for each in waves]
    nearest = {peak.force: peak._replace(force=peak.force * (1 + change)) for peak in traced}
    forces = iter(nearest.values())
    coarse: Any = SimpleNamespace(nearest=lambda contact, time: next(forces))
    return [each.error_estimate for each in train._waves(fine, traced, coarse, UNITS)]


@pytest.mark.parametrize(
    ("values", "runs", "error"),
    [
        ({}, {"change": 1e-3}, 1e-3),
        ({}, {"change": 1e-3, "early": 20.0}, 3e-3),
        ({"error_estimate": 2e-4}, {"change": 1e-3}, 1.2e-3),
        # a peak force scales as the power 3/5 of the energy
        ({}, {"defect": -1e-3}, 6e-4),
    ],
    ids=["difference of two runs", "which grows until the wave is measured", "distance from the limit", "energy"],
)
def test_the_estimate_of_a_wave_contains_each_part_in_full(values: Any, runs: Any, error: float) -> None:
    # and the tolerance of a step
    assert train_errors([wave(1.0, **values)], **runs) == pytest.approx([error], rel=1e-5)


def end_with(monkeypatch: pytest.MonkeyPatch, name: str, value: Any) -> None:
    """Give all runs of a chain another value at their end."""
    finished = ChainRun.finish

    def changed(run: ChainRun) -> ChainRun:
        ended = finished(run)
        setattr(ended, name, value)
        return ended

    monkeypatch.setattr(ChainRun, "finish", changed)


def test_the_error_of_the_recoil_contains_what_may_still_rebound(monkeypatch: pytest.MonkeyPatch) -> None:
    end_with(monkeypatch, "unfinished_recoil", 0.25)
    assert sw.simulate(CASE_A, CHAIN, rtol=1e-4).recoil_error >= 0.25 * UNITS.momentum


def test_the_error_of_the_recoil_contains_the_difference_of_two_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = iter([-1.0, -1.5])
    monkeypatch.setattr(train, "find_rebounding", lambda *_: ((next(runs),), 0.0))
    assert sw.simulate(CASE_A, CHAIN, rtol=1e-4).recoil_error >= 0.5 * UNITS.momentum


@pytest.mark.parametrize(
    ("share", "profile", "rise_time"),
    [
        ("_CHANGE_SHARE", sw.Triangular(duration_ratio=4), 30e-6),
        ("_BACKWARD_SHARE", sw.PowerLaw(rise_exponent=1, decay_exponent=5, duration_ratio=10), 60e-6),
        ("_REMAINING_SHARE", sw.Triangular(duration_ratio=4), 30e-6),
    ],
    ids=["change", "slow granules", "granules behind the waves"],
)
def test_the_error_of_the_recoil_contains_each_part(
    share: str, profile: sw.ShockProfile, rise_time: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    shock = sw.Shock(profile=profile, peak_force=100.0, rise_time=rise_time)
    before = sw.simulate(shock, CHAIN, rtol=1e-6).recoil_error
    monkeypatch.setattr(wave_train_run, share, 1e6)
    assert sw.simulate(shock, CHAIN, rtol=1e-6).recoil_error > 100 * before


def test_a_run_that_ends_before_its_waves_have_settled_has_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    assert sw.simulate(CASE_A, CHAIN, rtol=1e-4).train.warnings == ()
    end_with(monkeypatch, "settled", False)
    (warning,) = sw.simulate(CASE_A, CHAIN, rtol=1e-4).train.warnings
    assert "still moving when it was measured" in warning


@pytest.mark.parametrize(("factor", "warned"), [(1.0, False), (1.01, True)])
def test_a_strongest_wave_other_than_the_leading_one_has_a_warning(
    factor: float, warned: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = train._train

    def stronger(*arguments: Any) -> Any:
        found, run = measured(*arguments)
        strongest, *others = found.waves
        strongest = attrs.evolve(strongest, peak_force=factor * strongest.peak_force)
        return attrs.evolve(found, waves=(strongest, *others)), run

    monkeypatch.setattr(train, "_train", stronger)
    warnings = sw.simulate(CASE_A, CHAIN, rtol=1e-4).train.warnings
    assert any("differs from the leading wave by 1e-02" in each for each in warnings) == warned


@pytest.mark.parametrize("rtol", [1e-2, 1e-4])
def test_waves_are_separated_from_noise_however_loose_the_tolerance(rtol: float) -> None:
    setup = setup_of(SimulateOptions(rtol=rtol))
    step, doubt = setup.accuracy(scale_scene(Scene(excitation=CASE_A, chain=CHAIN))[0])
    assert step <= 2e-4
    assert doubt <= 3e-5


def test_errors_of_a_step_are_larger_relative_to_weak_waves() -> None:
    strong, weak = train_errors([wave(1.0), wave(0.01)])
    assert strong == pytest.approx(1e-9, rel=0.01)  # and rounding
    assert weak == pytest.approx(1e-8, rel=0.01)


# ---------------------------------------------------------------- the leading wave


def primary(**values: float) -> Primary:
    nothing = dict.fromkeys(Primary._fields[:-1], 0.0)
    return Primary(**{**nothing, "status": SearchStatus.KNOWN, "chain_energy": 1.0, "work": 1.0, **values})


def test_the_estimate_of_the_leading_wave_contains_each_part_in_full() -> None:
    assert leading_wave._error(primary(doubt=1e-4), 0.0, 0.0) == pytest.approx(1e-4, rel=1e-6)
    assert leading_wave._error(primary(), 1e-5, 0.0) == pytest.approx(1e-5, rel=1e-6)
    assert leading_wave._error(primary(), 0.0, 1e-6) == pytest.approx(1e-6, rel=1e-6)
    # if the whole defect is the leading wave's, whose force scales as the power 3/5 of its energy of about 1/3
    assert leading_wave._error(primary(chain_energy=1.001), 0.0, 0.0) >= 1.7e-3
    # the whole path is rounded to one part in 2^52
    assert leading_wave._error(primary(free_path=1e8), 0.0, 0.0) >= 1e8 * 2.0**-53


def test_the_estimate_is_not_below_the_error_of_a_fitted_shock(monkeypatch: pytest.MonkeyPatch) -> None:
    fit = sw.Exponential.free_path
    monkeypatch.setattr(sw.Exponential, "free_path", lambda profile: attrs.evolve(fit(profile), error=1e-4))
    profile = sw.Exponential(rise_rate=1.0, decay_rate=1.0, duration_ratio=3.0)
    result = sw.simulate(lasting(profile, 1.0), CHAIN, rtol=1e-6, waves="primary")
    assert 1e-4 <= result.error_estimate < 2e-4


# ---------------------------------------------------------------- passages, from two runs


def passage_errors(monkeypatch: pytest.MonkeyPatch, *changes: dict[int, tuple[float, float]]) -> dict[int, float]:
    """Estimates of contacts 3 to 6 from runs whose times and forces differ from 1 by these changes."""
    runs = iter(changes)

    def peaks(*arguments: Any) -> Any:
        own = next(runs)
        return {at: (1 + own.get(at, (0, 0))[0], 1 + own.get(at, (0, 0))[1]) for at in range(1, 9)}, 1e-10

    monkeypatch.setattr(wave_passages, "_peaks", peaks)
    result = sw.simulate(CASE_A, CHAIN, rtol=1e-3, waves="primary")
    passages: dict[int, Passage] = {}
    wave_passages._integrate(result, passages, [3, 4, 5, 6], setup_of(result.options).search)
    return {contact: passage.error_estimate for contact, passage in passages.items()}


@pytest.mark.parametrize("change", [(1e-4, 0.0), (0.0, -1e-4)], ids=["time", "force"])
def test_the_estimate_of_a_passage_is_the_difference_of_two_runs_there_and_at_two_contacts_around(
    change: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    errors = passage_errors(monkeypatch, {6: change}, {})
    assert errors == pytest.approx({3: 0.0, 4: 1e-4, 5: 1e-4, 6: 1e-4}, rel=1e-3, abs=1e-9)
    assert errors[3] >= 1e-10  # the tolerance of a step


def test_a_passage_that_misses_the_tolerance_is_computed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    errors = passage_errors(monkeypatch, {6: (0.0, 1e-2)}, {6: (0.0, 1e-4)}, {})
    assert errors == pytest.approx({3: 0.0, 4: 1e-4, 5: 1e-4, 6: 1e-4}, rel=1e-3, abs=1e-9)


# ---------------------------------------------------------------- estimates and errors of many scenes


def shocks(count: int) -> list[sw.Shock]:
    """Seeded shocks of every family, of 0.03 to 30 characteristic times."""
    draws = [(family, np.random.default_rng([5, number])) for number in range(count) for family in FAMILIES.values()]
    return [lasting(family(draw), float(np.exp(draw.uniform(np.log(0.03), np.log(30.0))))) for family, draw in draws]


def leading_waves() -> Iterator[float]:
    scenes = [*shocks(25), *random_pulses(seed=9, count=60)]
    runs, fine = (sw.simulate_many(scenes, CHAIN, rtol=rtol, waves="primary") for rtol in (1e-6, 1e-9))
    return (abs(a.peak_force / b.peak_force - 1) / a.error_estimate for a, b in zip(runs, fine, strict=True))


def noisy_records() -> Iterator[float]:
    """Passages of records of 2000 samples with noise."""
    for number in range(20):
        draw = np.random.default_rng([7, number])
        forces = np.sin(np.pi * np.linspace(0, 1, 2000)) + draw.uniform(0.01, 0.3) * draw.normal(size=2000)
        forces[[0, -1]] = 0
        profile = sw.Tabulated(times=np.linspace(0, 1, 2000), forces=np.maximum(forces, 0))
        yield from passages_of(lasting(profile, float(np.exp(draw.uniform(np.log(0.03), np.log(30.0))))))


def passages() -> Iterator[float]:
    for shock in shocks(6):
        yield from passages_of(shock)


def passages_of(shock: sw.Shock) -> Iterator[float]:
    """Errors of forces and times of passages; requested ones meet the tolerance."""
    contacts = [0, 1, 3, 8, 20]
    run, fine = (sw.simulate(shock, CHAIN, rtol=rtol, contacts=contacts, waves="primary") for rtol in (1e-6, 1e-12))
    exact = {passage.contact: passage for passage in fine.passages}
    for own in run.passages:
        assert own.error_estimate <= 1e-6
        if own.contact in exact:  # a maximum at contact 0 may be missed
            other = exact[own.contact]
            late = abs(own.arrival_time / other.arrival_time - 1)
            yield max(abs(own.peak_force / other.peak_force - 1), late) / own.error_estimate


def later_waves() -> Iterator[float]:
    for shock in shocks(10):
        run, fine = (sw.simulate(shock, CHAIN, rtol=rtol).train for rtol in (1e-5, 1e-8))
        for own in run.waves[1:]:
            other = min(fine.waves, key=lambda each: abs(each.peak_force - own.peak_force))
            if own.error_estimate and (other.error_estimate or 1) < 0.3 * own.error_estimate:
                yield abs(own.peak_force / other.peak_force - 1) / own.error_estimate


def chains(damped: bool) -> Iterator[float]:
    """Forces at the contacts of random chains, and impulses on their walls."""
    for number in range(110 if damped else 30):
        excitation, chain = random_scene(number, most=14)
        if chain.is_damped != damped or chain.end is None:
            continue
        run = sw.simulate(excitation, chain)
        fine = sw.simulate(excitation, chain, rtol=1e-9, until=run.end)
        yield abs(run.transmitted.impulse / fine.transmitted.impulse - 1) / run.transmitted.impulse_error
        for own, other in zip(run.contacts, fine.contacts, strict=True):
            dynamic = other.peak_force - other.static_force
            if dynamic > 1e-6 * fine.greatest_force.peak_force and other.error_estimate < 0.3 * own.error_estimate:
                yield abs(own.peak_force - other.peak_force) / dynamic / own.error_estimate


def steep_viscous_contacts() -> Iterator[float]:
    """Contacts with strong damping under shocks of a very short rise, whose first step decides."""
    for number in range(60):
        draw = np.random.default_rng([12, number])
        rise, duration = 10 ** draw.uniform(-3, -2), 10 ** draw.uniform(-1, -0.3)
        profile = sw.PowerLaw(rise_exponent=1.0, decay_exponent=1.0, duration_ratio=duration / rise)
        damping = sw.KuwabaraKono(time=10 ** draw.uniform(0, 1) * UNITS.time)
        chain = attrs.evolve(CHAIN, granules=5, damping=damping)
        run = sw.simulate(lasting(profile, duration), chain, rtol=1e-8)
        fine = sw.simulate(lasting(profile, duration), chain, rtol=1e-11, until=run.end)
        for own, other in zip(run.contacts, fine.contacts, strict=True):
            yield abs(own.peak_force / other.peak_force - 1) / own.error_estimate


MEDIANS: dict[str, tuple[Any, float]] = {
    # errors over their estimates, and the estimate over the error in the median
    "leading waves": (leading_waves, 29.0),
    "passages": (passages, 197.0),
    "noisy records": (noisy_records, 20.0),
    "later waves": (later_waves, 79.0),
    "undamped chains": (lambda: chains(damped=False), 1270.0),
    "damped chains": (lambda: chains(damped=True), 718.0),
    "steep viscous contacts": (steep_viscous_contacts, 240.0),
}


@pytest.mark.parametrize(("ratios", "median"), MEDIANS.values(), ids=MEDIANS)
def test_estimates_hold_and_are_neither_halved_nor_a_hundred_times_too_large(ratios: Any, median: float) -> None:
    errors = np.array(list(ratios()))  # over their estimates
    assert len(errors) >= 40
    assert np.mean(errors <= 1) >= 0.95
    # the median of hundreds of scenes differs by a few per cent between processors
    assert median / 1.5 < 1 / np.median(errors) < 1.5 * median


@pytest.mark.parametrize(("error", "part"), [(1e-7, "the time of a greatest force"), (1e-5, "at contact 1")])
def test_a_missed_tolerance_is_that_of_the_time_or_of_the_force(error: float, part: str) -> None:
    options = SimpleNamespace(step=None)
    case: Any = SimpleNamespace(rtol=1e-6, options=options, judged_contacts=lambda forces: np.arange(len(forces)))
    runs: Any = SimpleNamespace(
        case=case,
        missed=True,
        motion=SimpleNamespace(forces=np.ones(2)),
        errors=np.array([0.0, error]),
        judged_end_errors=np.empty(0),
    )
    (warning,) = repeated_runs.warn_missed(runs)
    assert part in warning


@pytest.mark.parametrize("plastic", [True, False], ids=["plastic", "elastic"])
def test_estimates_of_the_force_behind_a_soft_pad_hold_where_collisions_amplify_errors(plastic: bool) -> None:
    rubber = sw.Material(youngs_modulus=50e6, poisson_ratio=0.48, density=1150.0)
    soft: Any = {"count": 1, "contact": sw.Hertz(), "damping": sw.KuwabaraKono(time=20e-6)}
    granules = [sw.Segment(count=9), sw.Segment(**soft), sw.Segment(**soft, material=rubber)]
    wall = sw.Wall(material="same")
    steel = sw.Chain(material="bearing-steel-52100", diameter=20e-3, granules=granules, gravity=9.81, end=wall)
    chain = attrs.evolve(steel, contact=sw.ElasticPlastic() if plastic else None)
    weight = sw.Material(youngs_modulus=203e9, poisson_ratio=0.3, density=30558.0, yield_strength=2030e6)
    for height in (0.3, 0.7):
        blow = sw.Impact(velocity=(2 * 9.81 * height) ** 0.5, diameter=50e-3, material=weight)
        run, fine = (sw.simulate(blow, chain, rtol=rtol, until=20e-3).transmitted for rtol in (1e-6, 1e-11))
        assert abs(run.peak_force / fine.peak_force - 1) < run.error_estimate + fine.error_estimate
