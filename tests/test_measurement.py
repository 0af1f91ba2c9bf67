"""Reading waves off the chain: heads and histories of waves, limits, one run, free ends."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave.measurement.peaks import PeakLog, history
from shockwave.measurement.train_run import Demand, Run, run
from shockwave.measurement.wave_limits import settling
from shockwave.simulation.nystroem import Rkn86
from shockwave.simulation.problem import ChainProblem

# Case A of the engine's references: power law, eta 1/2 and 1, n = 3, in natural units.
CASE = ChainProblem(sw.PowerLaw(rise_exponent=0.5, decay_exponent=1, duration_ratio=3), 2.0, 1.0)


def log_of(*peaks: tuple[int, float, float]) -> PeakLog:
    log = PeakLog()
    for contact, time, force in sorted(peaks, key=lambda peak: peak[1]):
        log.add(contact, time, force)
    return log


@pytest.mark.parametrize(
    ("peaks", "now", "heads"),
    [
        pytest.param([(3, 1.0, 1.0), (4, 2.0, 1.0), (3, 2.5, 0.5)], 3.0, [(4, 1.0), (3, 0.5)], id="two-waves"),
        pytest.param([(4, 2.0, 1.0), (4, 2.4, 1e-3)], 3.0, [(4, 1.0)], id="weak-stirrings-hide-no-wave"),
        pytest.param([(3, 1.0, 1.0)], 100.0, [], id="died-away"),
    ],
)
def test_heads_are_where_the_next_contact_has_not_peaked(
    peaks: list[tuple[int, float, float]], now: float, heads: list[tuple[int, float]]
) -> None:
    assert [(head.contact, head.force) for head in log_of(*peaks).heads(now, 0.01)] == heads


def test_history_follows_one_wave_back() -> None:
    log = log_of((3, 1.0, 1.0), (3, 3.0, 0.4), (4, 2.0, 1.0), (4, 5.0, 0.4), (5, 3.0, 1.0))
    assert [peak.time for peak in history(log.peaks[5][0], 10)] == [3.0, 2.0, 1.0]


def doubt_in(forces: list[float]) -> float:
    """The doubt in the peak of a wave with these peaks at the contacts."""
    log = log_of(*((contact, 1.1 * contact, force) for contact, force in enumerate(forces)))
    granules = np.zeros(len(forces) + 8)
    ((_, doubt),), _ = settling(log, 1.1 * len(forces), granules, granules, 0.01)
    return doubt


def test_doubt_covers_a_geometric_approach() -> None:
    forces = [1 - 0.7**contact for contact in range(40)]
    assert 1 - forces[-1] <= doubt_in(forces) < 100 * (1 - forces[-1])


def test_a_constant_peak_leaves_no_doubt_unless_its_history_is_short() -> None:
    assert doubt_in([1.0] * 40) == 0
    assert doubt_in([1.0] * 12) == np.inf


def run_on(granules: int | None) -> Run:
    return run(attrs.evolve(CASE, granules=granules), Rkn86(tolerance=1e-9), Demand(5e-3, 1e-6, 1e-5, 1000))


def test_runs_repeat_and_keep_the_energy_that_the_chain_had_when_the_force_ended() -> None:
    first, second = run_on(None), run_on(None)
    assert (first.waves, first.recoils, first.steps) == (second.waves, second.recoils, second.steps)
    # the tolerance of some hundred steps
    assert first.energy == pytest.approx(first.work, rel=1e-7)


def test_spalls_come_last_granule_first() -> None:
    spalls = run_on(60).spalls or ()
    assert len(spalls) > 3
    assert list(spalls) == sorted(spalls, reverse=True)


def test_waves_are_not_followed_to_a_far_end() -> None:
    found = run_on(3000)
    assert found.spalls is None
    assert found.waves == run_on(None).waves
