"""Many shocks at once: order, failures, progress, and agreement with single simulations."""

from __future__ import annotations

from functools import cache

import attrs
import pytest

import shockwave as sw
from shockwave.base.progress import show_progress
from support.scenes import CHAIN, power, random_pulses

pytestmark = pytest.mark.compiled

# More than share a vector, and enough for two threads.
PULSES = random_pulses(seed=5, count=40)
FEW = PULSES[:5]


@cache
def singles() -> list[sw.Simulation]:
    return [sw.simulate(pulse, CHAIN) for pulse in PULSES]


def test_many_are_equal_to_single_runs() -> None:
    assert sw.simulate_many(iter(PULSES), CHAIN) == singles()


def test_many_by_another_pair_are_equal_to_single_runs() -> None:
    many = sw.simulate_many(PULSES[:20], CHAIN, integrator="rkn1210")
    assert many == [sw.simulate(pulse, CHAIN, integrator="rkn1210") for pulse in PULSES[:20]]


@pytest.mark.parametrize("threads", [1, 4])
def test_the_number_of_threads_does_not_change_results(threads: int | None) -> None:
    assert sw.simulate_many(PULSES, CHAIN, threads=threads) == singles()


def test_many_in_numpy_are_equal_to_single_runs_in_numpy() -> None:
    many = sw.simulate_many(FEW, CHAIN, rtol=1e-4, backend="numpy")
    single = [sw.simulate(pulse, CHAIN, rtol=1e-4, backend="numpy") for pulse in FEW]
    # sums over a column of many lanes, and over one alone, are rounded in another order
    assert [result.peak_force for result in many] == pytest.approx([result.peak_force for result in single], rel=1e-12)


BAD = {
    "weightless": (attrs.evolve(power(1.0), peak_force=1e-300), sw.InvalidValueError, "peak_force: must give waves"),
    "endless": (attrs.evolve(power(1.0), rise_time=1e3), sw.NumericalError, "the shock lasts"),
}


@pytest.mark.parametrize("name", BAD)
@pytest.mark.parametrize("integrator", [None, "verlet"], ids=["search", "march"])
def test_a_failed_shock_has_its_error_in_its_place(name: str, integrator: str | None) -> None:
    shock, kind, message = BAD[name]
    others = power(0.5), power(0.7)
    before, error, after = sw.simulate_many([others[0], shock, others[1]], CHAIN, integrator=integrator)
    assert isinstance(error, kind)
    assert message in str(error)
    assert (before.shock, after.shock) == others


def test_many_shocks_on_chains_of_different_lengths_and_contacts_are_equal_to_single_runs() -> None:
    laws = [sw.PowerContact(exponent=exponent, stiffness=1e9) for exponent in (1.3, 2.0)]
    chains = [attrs.evolve(CHAIN, granules=5), CHAIN, attrs.evolve(CHAIN, granules=100)]
    chains += [attrs.evolve(CHAIN, contact=contact) for contact in laws]
    many = sw.simulate_many(FEW, chains, rtol=1e-5)
    assert many == [sw.simulate(pulse, chain, rtol=1e-5) for pulse, chain in zip(FEW, chains, strict=True)]


def test_a_wrong_number_of_chains_is_refused() -> None:
    for number in (2, len(FEW) + 1):
        with pytest.raises(sw.InvalidValueError, match=rf"a list of {len(FEW)} \(got a list of {number}\)"):
            sw.simulate_many(FEW, [CHAIN] * number)
    with pytest.raises(sw.InvalidValueError, match=r"chain: must be a Chain, or one for each shock \(got 'steel'\)"):
        sw.simulate_many(FEW, "steel")  # type: ignore[arg-type]


def test_a_single_shock_is_refused() -> None:
    with pytest.raises(sw.InvalidValueError, match=r"shocks: must be a list of shocks \(got Shock; or use simulate\)"):
        sw.simulate_many(FEW[0], CHAIN)  # type: ignore[arg-type]
    with pytest.raises(sw.InvalidValueError, match=r"shocks: must be a list of shocks \(got Shock; or use predict\)"):
        sw.Predictor().predict_many(FEW[0], CHAIN)  # type: ignore[arg-type]


@pytest.mark.parametrize("backend", ["auto", "numpy"])
def test_progress_of_many_is_reported_with_the_total(backend: str) -> None:
    reports = []
    with show_progress(lambda *report: reports.append(report)):
        sw.simulate_many(PULSES, CHAIN, rtol=1e-3, backend=backend, waves="primary")  # type: ignore[arg-type]
    counts = [done for work, done, total in reports if work == "simulations" and total == len(PULSES)]
    assert counts == sorted(counts)
    assert (counts[0], counts[-1]) == (0, len(PULSES))


def test_progress_of_a_wave_train_is_reported_with_the_total_in_the_second_run() -> None:
    reports = []
    with show_progress(lambda *report: reports.append(report)):
        _ = sw.simulate(FEW[0], CHAIN).train
    works, done, totals = zip(*reports, strict=True)
    assert list(dict.fromkeys(works)) == ["wave train, run 1 of 2", "wave train, run 2 of 2"]
    assert totals[0] is None
    assert totals[-2] == done[-1]
