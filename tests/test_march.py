"""The march with every integrator, the polynomials between step ends, free granules, and free ends."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave.chain.solitary_wave import ENERGY, GRANULE_VELOCITY, MOMENTUM, SPEED, WIDTH
from shockwave.measurement.peaks import PeakLog, powers_between
from shockwave.measurement.run import Demand, Run, run
from shockwave.registry import load
from shockwave.simulation.march import Stretch, march
from shockwave.simulation.nystroem import Rkn86, Rkn1210
from shockwave.simulation.problem import ChainProblem

# Case A of the engine's references, and a short shock, which throws back many granules.
CASE = ChainProblem(sw.PowerLaw(rise_exponent=0.5, decay_exponent=1, duration_ratio=3), 2.0, 1.0)
SHORT = ChainProblem(sw.PowerLaw(rise_exponent=0.5, decay_exponent=1, duration_ratio=3), 0.1, 10.0)
DEMAND = Demand(5e-3, 1e-6, 1e-5, 1000)
# The peak at contact 9 of case A, integrated in quadruple precision by two methods.
FORCE, TIME = 1.490253931405875817, 12.118161972131167


def peak_at(contact: int, method: object, tolerance: float) -> tuple[float, float]:
    log = PeakLog(tolerance)
    log.observe(Stretch.of(*march(CASE, method, until=14.0)))
    top = max(log.peaks[contact], key=lambda peak: peak.force)
    return top.force, top.time


@pytest.mark.parametrize("exact", [True, False], ids=["interpolant", "polynomial"])
@pytest.mark.parametrize(
    ("name", "settings", "force", "time"),
    [
        # what the method itself errs by at these settings, rounded up
        ("rkn86", {"tolerance": 1e-12}, 1e-14, 1e-14),
        ("rkn1210", {"tolerance": 1e-12}, 1e-14, 1e-14),
        ("rkn64", {"tolerance": 1e-12}, 1e-14, 1e-14),
        ("dop853", {"tolerance": 1e-12}, 1e-11, 1e-12),
        pytest.param("radau", {"tolerance": 1e-8}, 1e-8, 1e-10, marks=pytest.mark.slow),
        ("verlet", {"size": 0.02}, 1e-4, 3e-5),
        ("rk4", {"size": 0.02}, 3e-8, 1e-8),
        ("pefrl", {"size": 0.02}, 2e-9, 4e-11),
    ],
)
def test_peak_along_the_chain_is_as_good_as_the_method(
    name: str, settings: dict[str, float], force: float, time: float, exact: bool
) -> None:
    method = load("integrators", name)(**settings)
    found = peak_at(9, method, 0.0 if exact else method.tolerance)
    assert found[0] == pytest.approx(FORCE, rel=force)
    assert found[1] == pytest.approx(TIME, rel=time)


def test_peaks_of_long_steps_are_found_on_the_interpolant() -> None:
    method = Rkn1210(tolerance=1e-9)  # its steps are as long as 0.6, and a polynomial would miss by 1e-7
    assert peak_at(9, method, method.tolerance)[0] == pytest.approx(FORCE, rel=1e-11)


def test_polynomial_of_degree_seven_is_its_own_interpolant() -> None:
    polynomial = np.polynomial.Polynomial(np.random.default_rng(1).normal(size=8))
    jets = np.array([polynomial.deriv(order)(np.array([2.0, 2.5])) for order in range(4)])
    powers = powers_between(jets[:, :1], jets[:, 1:], np.array([0.5]))[:, 0]
    assert np.polynomial.Polynomial(powers)(0.3) == pytest.approx(polynomial(2.0 + 0.3 * 0.5), rel=1e-11)


def test_march_ends_where_it_is_told() -> None:
    assert [list(march(CASE, Rkn86(), until=end))[-1].end for end in (1.0, 6.0, 7.5)] == [1.0, 6.0, 7.5]


def states(problem: ChainProblem, until: float) -> tuple[np.ndarray, np.ndarray]:
    last = list(march(problem, Rkn86(tolerance=1e-11), until))[-1]
    return last.x1, last.v1


@pytest.mark.parametrize("problem", [CASE, SHORT], ids=["long", "short"])
def test_free_granules_fly_as_they_would_be_integrated(problem: ChainProblem, monkeypatch: pytest.MonkeyPatch) -> None:
    flown = states(problem, 60.0)
    monkeypatch.setattr("shockwave.simulation.march._PARTING", 10**9)
    integrated = states(problem, 60.0)
    # displacements are of order 10 and errors add up over some 600 steps
    assert np.max(np.abs(flown[0] - integrated[0])) < 1e-8
    assert np.max(np.abs(flown[1] - integrated[1])) < 1e-9


def test_free_granules_are_not_integrated() -> None:
    seen = []

    class Watched(Rkn86):
        def attempt(self, acceleration, time, size, x, v, a):  # type: ignore[no-untyped-def]
            seen.append(len(x))
            return super().attempt(acceleration, time, size, x, v, a)

    last = list(march(SHORT, Watched(tolerance=1e-7), 60.0))[-1]
    assert seen[-1] < 0.6 * len(last.x1)


def test_a_flying_granule_that_is_met_is_integrated_again() -> None:
    # The second force drives the first granule after those that the first one has thrown back.
    record = sw.Tabulated(times=[0, 0.5, 1, 60, 60.5, 61], forces=[0, 1, 0, 0, 1, 0])
    scene = ChainProblem(record, 0.5, 1.0)
    energies = [
        0.5 * np.sum(span.v1**2) + 0.4 * np.sum(np.maximum(span.x1[:-1] - span.x1[1:], 0) ** 2.5)
        for span in march(scene, Rkn86(tolerance=1e-10), 300.0)
        if span.end >= 61
    ]
    # Errors of a step add up over some thousand of them.
    assert energies[-1] == pytest.approx(energies[0], rel=1e-7)


@pytest.mark.parametrize(("tolerance", "error"), [(1e-4, 1e-5), (1e-8, 1e-9)])
def test_a_wave_is_measured_as_the_exact_solitary_wave(tolerance: float, error: float) -> None:
    wave = run(CASE, Rkn86(tolerance=tolerance), Demand(5e-3, 1e-9, 1e-8, 1000)).waves[0]
    force = wave.peak_force
    assert wave.momentum == pytest.approx(MOMENTUM * force ** (5 / 6), rel=error)
    assert wave.energy == pytest.approx(ENERGY * force ** (5 / 3), rel=error)
    assert wave.speed == pytest.approx(SPEED * force ** (1 / 6), rel=error)
    assert wave.width == pytest.approx(WIDTH * force ** (-1 / 6), rel=error)
    assert wave.granule_velocity == pytest.approx(GRANULE_VELOCITY * force ** (5 / 6), rel=error)


def finite(granules: int) -> Run:
    return run(attrs.evolve(CASE, granules=granules), Rkn86(tolerance=1e-9), DEMAND)


def test_two_granules_leave_with_momentum_and_energy() -> None:
    found = finite(2)
    assert sum(found.spalls or ()) + sum(found.recoils) == pytest.approx(found.books.impulse, rel=1e-12)
    assert 0.5 * sum(v**2 for v in (found.spalls or ())) == pytest.approx(found.books.energy, rel=1e-6)


def test_spalls_come_last_granule_first() -> None:
    spalls = finite(60).spalls or ()
    assert len(spalls) > 3
    assert list(spalls) == sorted(spalls, reverse=True)


def test_first_spall_of_a_long_chain_is_that_of_a_longer_one() -> None:
    first, second = (finite(granules).spalls or () for granules in (60, 120))
    assert first[0] == pytest.approx(second[0], rel=1e-6)


def test_waves_are_not_followed_to_a_far_end() -> None:
    found = finite(3000)
    assert found.spalls is None
    assert found.waves == run(CASE, Rkn86(tolerance=1e-9), DEMAND).waves
