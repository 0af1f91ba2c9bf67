"""Integration of a shock on a whole chain: steps, peaks along the chain, granules that are hit again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from attrs import define

import shockwave as sw
from shockwave.engine.integrator import Integrator
from shockwave.engine.nystroem_integrators import Rkn86
from shockwave.engine.scaled_problem import ScaledProblem, chain_energy
from shockwave.registry.registry import load
from shockwave.simulation.whole_chain import WholeChain
from support.scenes import POWER

pytestmark = pytest.mark.compiled

# Case A of the references.
CASE = ScaledProblem(POWER, 2.0, 1.0)
# Peak at contact 9 of case A from two methods in quadruple precision.
FORCE = 1.490253931405875817
TIME = 12.118161972131167


def method(name: str, **settings: float) -> Integrator:
    made: Integrator = load("integrators", name)(**settings)
    return made


@pytest.mark.parametrize("exact", [True, False], ids=["interpolant", "polynomial"])
@pytest.mark.parametrize(
    ("name", "settings", "force", "time"),
    [
        # errors of the methods at these settings, rounded up
        ("rkn86", {"tolerance": 1e-12}, 1e-14, 1e-14),
        ("rkn1210", {"tolerance": 1e-12}, 1e-14, 1e-14),
        ("rkn64", {"tolerance": 1e-12}, 1e-14, 1e-14),
        ("dop853", {"tolerance": 1e-12}, 1e-11, 1e-12),
        # with steps of up to 0.6, a polynomial would have an error of 1e-7
        ("rkn1210", {"tolerance": 1e-9}, 1e-11, 1e-11),
        ("verlet", {"size": 0.02}, 1e-4, 3e-5),
        ("rk4", {"size": 0.02}, 3e-8, 1e-8),
        ("pefrl", {"size": 0.02}, 2e-9, 4e-11),
    ],
)
def test_peak_along_the_chain_is_as_accurate_as_the_method(
    name: str, settings: dict[str, float], force: float, time: float, exact: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if exact:
        monkeypatch.setattr("shockwave.engine.peak_log._NEGLIGIBLE", 0.0)
    whole = WholeChain(CASE, method(name, **settings))
    whole.advance_to(14.0, "", 14.0)
    top = max(whole.log.at(9), key=lambda peak: peak.force)
    assert top.force == pytest.approx(FORCE, rel=force)
    assert top.time == pytest.approx(TIME, rel=time)


@pytest.mark.parametrize(
    ("name", "settings"),
    [("rkn86", {"tolerance": 1e-8}), ("radau", {"tolerance": 1e-8}), ("verlet", {"size": 0.002})],
)
def test_the_peak_under_the_shock_is_where_its_granules_have_equal_velocities(name: str, settings: Any) -> None:
    whole = WholeChain(CASE, method(name, **settings))
    whole.advance_to(6.0, "", 6.0)
    (peak,) = whole.log.at(0)
    stretch = WholeChain(CASE, method(name, **settings)).advance_to(peak.time, "", 6.0)
    x, v = stretch.x[-1], stretch.v[-1]
    # errors of the methods, rounded up; a polynomial without the applied force misses the time by 1e-3
    assert v[0] == pytest.approx(v[1], abs=2e-6)
    assert peak.force == pytest.approx((x[0] - x[1]) ** 1.5, rel=1e-6)


@pytest.mark.parametrize("end", [1.0, 7.5])
def test_steps_end_on_kinks_and_on_the_end(end: float) -> None:
    times = WholeChain(CASE, Rkn86()).advance(end).times
    assert times[0] == 0
    assert (np.diff(times) > 0).all()
    assert times[-1] == end
    assert {time for time in (2.0, 6.0) if time <= end} <= set(times.tolist())


def test_momentum_equals_the_impulse_and_the_chain_ahead_is_at_rest() -> None:
    stretch = WholeChain(CASE, Rkn86(tolerance=1e-6)).advance(20.0)
    for time, x, v in zip(stretch.times.tolist(), stretch.x, stretch.v, strict=True):
        # rounding
        assert np.sum(v) == pytest.approx(CASE.free(time)[1], rel=1e-13)
        assert abs(x[-1]) < 1e-30


def test_granules_that_are_hit_again_keep_their_energy() -> None:
    # The second force drives the first granule after those that rebounded from the first one.
    record = sw.Tabulated(times=[0, 0.5, 1, 60, 60.5, 61], forces=[0, 1, 0, 0, 1, 0])
    whole = WholeChain(ScaledProblem(record, 0.5, 1.0), Rkn86(tolerance=1e-10))
    before, after = (whole.advance_to(time, "", time) for time in (61.0, 300.0))
    energies = [chain_energy(stretch.x[-1], stretch.v[-1]) for stretch in (before, after)]
    # Errors add up over about a thousand steps.
    assert energies[1] == pytest.approx(energies[0], rel=1e-7)


@define
class Derived(Rkn86):
    """An integrator with steps of its own, as far as the engine knows."""


def test_steps_during_the_shock_are_interpolated_with_its_force_after_it_has_ended() -> None:
    chains = [WholeChain(CASE, kind(tolerance=1e-10)) for kind in (Rkn86, Derived)]
    peaks = []
    for whole in chains:
        whole.advance_to(14.0, "", 14.0)
        peaks.append([max(whole.log.at(contact), key=lambda peak: peak.force).force for contact in range(3)])
    assert peaks[1] == pytest.approx(peaks[0], rel=1e-8)
