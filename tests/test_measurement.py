"""The parts that read waves off the chain."""

from __future__ import annotations

import numpy as np
import pytest

import shockwave as sw
from scenes import CHAIN, FORCE, TRUTH, UNITS
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.measurement.peaks import PeakLog, history
from shockwave.measurement.run import Demand, run
from shockwave.measurement.settle import settling
from shockwave.simulation.scipy_solver import Dop853
from shockwave.simulation.march import Stretch, free_granules, march
from shockwave.simulation.problem import ChainProblem, contact_forces


def problem(rise_time: float = 2.0, granules: int | None = None) -> ChainProblem:
    """Case A of the engine's references: power law, eta 1/2 and 1, n = 3, in natural units."""
    profile = sw.PowerLaw(rise_exponent=0.5, decay_exponent=1, duration_ratio=3)
    return ChainProblem(profile, rise_time, 1.0, granules)


def log_of(*peaks: tuple[int, float, float]) -> PeakLog:
    log = PeakLog()
    for contact, time, force in sorted(peaks, key=lambda peak: peak[1]):
        log.add(contact, time, force)
    return log


# Peak force and its time at contacts counted from 0, integrated in quadruple precision by two methods.
@pytest.mark.parametrize(
    ("contact", "force", "time"),
    [
        (9, 1.490253931405875817, 12.118161972131167),
        (19, 1.505058603966965105, 22.435361572695436),
        (59, 1.505133369796510557, 63.699048040316566),
    ],
)
def test_peaks_along_the_chain_agree_with_quadruple_precision(contact: int, force: float, time: float) -> None:
    log = PeakLog()
    for span in march(problem(), Dop853(tolerance=1e-12)):
        log.observe(Stretch.of(span))
        if contact in log.peaks:
            break
    # a step's tolerance times the number of steps that a wave takes
    assert (log.peaks[contact][0].force, log.peaks[contact][0].time) == pytest.approx((force, time), rel=3e-11)


def test_chain_ahead_of_the_front_is_at_rest() -> None:
    for span in march(problem(), Dop853(tolerance=1e-9)):
        assert abs(span.x1[-1]) < 1e-30
        if span.end > 20:
            break


def test_steps_end_on_the_kinks_of_the_force() -> None:
    ends = []
    for span in march(problem(), Dop853(tolerance=1e-6)):
        ends.append(span.end)
        if span.end > 10:
            break
    assert {2.0, 6.0} <= set(ends)


def test_steps_join_without_gaps() -> None:
    end = 0.0
    for span in march(problem(), Dop853(tolerance=1e-6)):
        assert span.begin == end
        end = span.end
        if end > 10:
            break


def test_momentum_is_the_impulse_at_every_step() -> None:
    scene = problem()
    for span in march(scene, Dop853(tolerance=1e-6)):
        assert np.sum(span.v1) == pytest.approx(scene.impulse(span.end), rel=1e-13)
        if span.end > 10:
            break


def test_interpolation_is_as_good_as_the_step() -> None:
    loose = next(span for span in march(problem(), Dop853(tolerance=1e-6)) if span.end > 4)
    middle = (loose.begin + loose.end) / 2
    tight = next(span for span in march(problem(), Dop853(tolerance=1e-13)) if span.end >= middle)
    difference = loose.at(middle)[0][:8] - tight.at(middle)[0][:8]
    assert np.max(np.abs(difference)) < 1e-5


def test_integrator_counts_its_evaluations() -> None:
    calls = 0

    def acceleration(_: float, x: np.ndarray) -> np.ndarray:
        nonlocal calls
        calls += 1
        return -x

    method = Dop853(tolerance=1e-8)
    list(method.steps(acceleration, 0.0, 3.0, np.ones(2), np.zeros(2), None))
    assert method.evaluations == calls


def test_integrator_stays_within_its_interval() -> None:
    seen = []

    def acceleration(time: float, x: np.ndarray) -> np.ndarray:
        seen.append(time)
        return -x

    list(Dop853(tolerance=1e-8).steps(acceleration, 1.0, 3.0, np.ones(2), np.zeros(2), 0.1))
    assert (min(seen), max(seen)) == (1.0, 3.0)


def test_integrator_has_the_order_that_it_declares() -> None:
    def error(tolerance: float) -> tuple[float, int]:
        method = Dop853(tolerance=tolerance)
        *_, last = method.steps(lambda _, x: -x, 0.0, 20.0, np.ones(1), np.zeros(1), None)
        return abs(last.x[0] - np.cos(20.0)), method.evaluations

    (loose, few), (tight, many) = error(1e-5), error(1e-11)
    slope = np.log(loose / tight) / np.log(many / few)
    assert slope == pytest.approx(Dop853.order, abs=1.0)


def test_integrator_that_meets_no_number_says_so() -> None:
    with pytest.raises(sw.NumericalError, match="cannot step beyond"):
        list(Dop853().steps(lambda _, x: x * np.nan, 0.0, 1.0, np.ones(2), np.zeros(2), 0.1))


def test_open_contacts_carry_no_force() -> None:
    assert contact_forces(np.array([0.0, 1.0, 0.0])).tolist() == [0.0, 1.0]


@pytest.mark.parametrize(
    ("x", "v", "free"),
    [
        pytest.param([-2.0, -1.0, 0.0], [-3.0, -2.0, -1.0], 3, id="all-apart"),
        pytest.param([-2.0, 0.5, 0.0], [-3.0, 0.0, 0.0], 1, id="first-alone"),
        pytest.param([-2.0, -1.0, 0.0], [-1.0, -2.0, 0.0], 0, id="first-two-will-meet"),
        pytest.param([0.5, 0.0, 0.0], [0.0, 0.0, 0.0], 0, id="in-contact"),
    ],
)
def test_free_granules_are_those_that_nothing_can_reach(x: list[float], v: list[float], free: int) -> None:
    assert free_granules(np.array(x), np.array(v)) == free


def test_heads_are_where_the_next_contact_has_not_peaked() -> None:
    log = log_of((3, 1.0, 1.0), (4, 2.0, 1.0), (3, 2.5, 0.5))
    assert [(head.contact, head.force) for head in log.heads(3.0, 0.01)] == [(4, 1.0), (3, 0.5)]


def test_weak_stirrings_do_not_hide_a_wave() -> None:
    log = log_of((4, 2.0, 1.0), (4, 2.4, 1e-3))
    assert [head.force for head in log.heads(3.0, 0.01)] == [1.0]


def test_heads_that_died_away_are_forgotten() -> None:
    assert log_of((3, 1.0, 1.0)).heads(100.0, 0.01) == []


def test_history_follows_one_wave_back() -> None:
    log = log_of((3, 1.0, 1.0), (3, 3.0, 0.4), (4, 2.0, 1.0), (4, 5.0, 0.4), (5, 3.0, 1.0))
    assert [peak.time for peak in history(log.peaks[5][0], 10)] == [3.0, 2.0, 1.0]


def settled(forces: list[float]) -> tuple[float, ...]:
    log = log_of(*((contact, 1.1 * contact, force) for contact, force in enumerate(forces)))
    granules = np.zeros(len(forces) + 8)
    return settling(log, 1.1 * len(forces), granules, granules, 0.01).doubts


def test_a_constant_peak_leaves_no_doubt() -> None:
    assert settled([1.0] * 40) == (0.0,)


def test_doubt_covers_a_geometric_approach() -> None:
    forces = [1 - 0.7**contact for contact in range(40)]
    (doubt,) = settled(forces)
    assert 1 - forces[-1] <= doubt < 100 * (1 - forces[-1])


def test_a_short_history_is_no_limit() -> None:
    assert settled([1.0] * 12) == (np.inf,)


def test_two_runs_of_one_problem_are_alike() -> None:
    demand = Demand(5e-3, 1e-6, 1e-5, 1000)
    first, second = (run(problem(), Dop853(tolerance=1e-8), demand) for _ in range(2))
    assert (first.waves, first.recoils, first.steps) == (second.waves, second.recoils, second.steps)


def test_energy_in_the_chain_stays_what_it_was_when_the_force_ended() -> None:
    books = run(problem(), Dop853(tolerance=1e-11), Demand(5e-3, 1e-6, 1e-5, 1000)).books
    assert books.energy == pytest.approx(books.held, rel=1e-9)


def test_momentum_through_a_contact_is_that_of_the_wave() -> None:
    (wave, *_) = run(problem(), Dop853(tolerance=1e-10), Demand(5e-3, 1e-9, 1e-6, 1000)).waves
    assert wave.momentum == pytest.approx(MOMENTUM * wave.peak_force ** (5 / 6), rel=1e-7)


def test_noise_of_a_loose_run_is_told() -> None:
    case = TRUTH[0]
    shock = sw.Shock(
        profile=sw.PowerLaw(rise_exponent=case["eta1"], decay_exponent=case["eta2"], duration_ratio=case["n"]),
        peak_force=FORCE,
        rise_time=case["T"] * UNITS.time,
    )
    result = sw.simulate(shock, CHAIN, rtol=1e-4)
    weakest = result.waves[len(case["peaks"]) - 1]
    error = abs(weakest.peak_force / FORCE / case["peaks"][-1] - 1)
    assert error <= weakest.error_estimate
