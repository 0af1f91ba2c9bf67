"""Integration of a shock on a chain: steps, peaks along the chain, granules in free flight."""

from __future__ import annotations

import numpy as np
import pytest

import shockwave as sw
from shockwave.engine.equal_chain_run import Span, Stretch, march
from shockwave.engine.nystroem_integrators import Rkn86
from shockwave.engine.peak_log import PeakLog
from shockwave.engine.scaled_problem import ChainProblem, chain_energy
from shockwave.registry.registry import load
from support.scenes import POWER

pytestmark = pytest.mark.compiled

# Case A of the references, and a short shock after which many granules rebound.
CASE = ChainProblem(POWER, 2.0, 1.0)
SHORT = ChainProblem(POWER, 0.1, 10.0)
# Peak at contact 9 of case A from two methods in quadruple precision.
FORCE = 1.490253931405875817
TIME = 12.118161972131167


def peak_at(contact: int, method: object, tolerance: float) -> tuple[float, float]:
    log = PeakLog(tolerance)
    log.observe(Stretch.of(*march(CASE, method, until=14.0)))
    top = max(log.at(contact), key=lambda peak: peak.force)
    return top.force, top.time


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
    name: str, settings: dict[str, float], force: float, time: float, exact: bool
) -> None:
    method = load("integrators", name)(**settings)
    found = peak_at(9, method, 0.0 if exact else method.tolerance)
    assert found[0] == pytest.approx(FORCE, rel=force)
    assert found[1] == pytest.approx(TIME, rel=time)


@pytest.mark.parametrize("name", ["rkn86", "dop853", "radau", "verlet"])
def test_the_peak_under_the_shock_is_where_its_granules_have_equal_velocities(name: str) -> None:
    spans = list(march(CASE, load("integrators", name)(tolerance=1e-6), until=6.0))
    log = PeakLog()
    log.observe(Stretch.of(*spans))
    (peak,) = log.at(0)
    x, v = next(span for span in spans if span.begin <= peak.time <= span.end).at(peak.time)
    assert v[0] == pytest.approx(v[1], abs=1e-12)
    assert peak.force == pytest.approx((x[0] - x[1]) ** 1.5, rel=1e-13)


@pytest.mark.parametrize("end", [1.0, 7.5])
def test_steps_are_contiguous_and_end_on_kinks_and_on_the_end(end: float) -> None:
    spans = list(march(CASE, Rkn86(), until=end))
    ends = [span.end for span in spans]
    assert [span.begin for span in spans] == [0.0, *ends[:-1]]
    assert ends[-1] == end
    assert {time for time in (2.0, 6.0) if time <= end} <= set(ends)


def test_momentum_equals_the_impulse_and_the_chain_ahead_is_at_rest() -> None:
    for span in march(CASE, Rkn86(tolerance=1e-6), until=20.0):
        # rounding
        assert np.sum(span.v1) == pytest.approx(CASE.free(span.end)[1], rel=1e-13)
        assert abs(span.x1[-1]) < 1e-30


def last_span(problem: ChainProblem) -> Span:
    return list(march(problem, Rkn86(tolerance=1e-11), 60.0))[-1]


@pytest.mark.parametrize("problem", [CASE, SHORT], ids=["long", "short"])
def test_free_flight_agrees_with_integration(problem: ChainProblem, monkeypatch: pytest.MonkeyPatch) -> None:
    flown = last_span(problem)
    monkeypatch.setattr("shockwave.engine.equal_chain_run._PARTING", 10**9)
    integrated = last_span(problem)
    # displacements are of order 10, and errors add up over about 600 steps
    assert np.max(np.abs(flown.x1 - integrated.x1)) < 1e-8
    assert np.max(np.abs(flown.v1 - integrated.v1)) < 1e-9


def test_free_granules_are_not_integrated() -> None:
    seen = []

    class Watched(Rkn86):
        def attempt(self, acceleration, time, size, x, v, a):  # type: ignore[no-untyped-def]
            seen.append(len(x))
            return super().attempt(acceleration, time, size, x, v, a)

    last = list(march(SHORT, Watched(tolerance=1e-7), 60.0))[-1]
    # most granules of a short shock rebound
    assert seen[-1] < 0.6 * len(last.x1)


def test_granule_in_free_flight_that_is_hit_is_integrated_again() -> None:
    # The second force drives the first granule after those that rebounded from the first one.
    record = sw.Tabulated(times=[0, 0.5, 1, 60, 60.5, 61], forces=[0, 1, 0, 0, 1, 0])
    spans = march(ChainProblem(record, 0.5, 1.0), Rkn86(tolerance=1e-10), 300.0)
    energies = [chain_energy(span.x1, span.v1) for span in spans if span.end >= 61]
    # Errors add up over about a thousand steps.
    assert energies[-1] == pytest.approx(energies[0], rel=1e-7)
