"""Measurement of waves: heads and histories of waves, limits, a run, free ends."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave.measurement.chain_run import ChainRun
from shockwave.measurement.peak_log import PeakLog
from shockwave.measurement.waves import settling
from shockwave.simulation.nystroem import Rkn86
from shockwave.simulation.problem import ChainProblem

# Case A of the references: power law, eta 1/2 and 1, n = 3, in scaled units.
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


@pytest.mark.parametrize(
    ("forces", "least", "most"),
    [
        pytest.param(1 - 0.7 ** np.arange(40), 0.7**39, 0.7**39 * 100, id="geometric-approach"),
        pytest.param(np.ones(40), 0.0, 0.0, id="constant"),
        pytest.param(np.ones(12), np.inf, np.inf, id="short-history"),
    ],
)
def test_the_bound_covers_the_approach_to_the_limit(forces: np.ndarray, least: float, most: float) -> None:
    log = log_of(*((contact, 1.1 * contact, force) for contact, force in enumerate(forces.tolist())))
    granules = np.zeros(len(forces) + 8)
    ((_, doubt),), _ = settling(log, 1.1 * len(forces), granules, granules, 0.01)
    assert least <= doubt <= most


def test_waves_are_not_followed_to_a_far_end() -> None:
    found, endless = (
        ChainRun(attrs.evolve(CASE, granules=granules), Rkn86(tolerance=1e-9), 5e-3, 1e-6, 1e-5, 1000).finished()
        for granules in (3000, None)
    )
    assert found.spalls is None
    assert (found.waves, found.recoils, found.steps) == (endless.waves, endless.recoils, endless.steps)
