"""What a step costs and does, beyond the clauses of the contract."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from shockwave.hooks import OneStep

from shockwave_composition.blanes_moan import BlanesMoan4, BlanesMoan6, BlanesMoan6Long
from shockwave_composition.verlet_richardson import VerletRichardson

SPLITTING = [BlanesMoan4, BlanesMoan6, BlanesMoan6Long]
PHASES = np.arange(5) * 0.7

pytestmark = pytest.mark.parametrize("method", [*SPLITTING, VerletRichardson], ids=lambda method: method.name)


def _path(time: Any) -> tuple[np.ndarray, np.ndarray]:
    """A solution chosen beforehand, and its velocity."""
    angle = time + PHASES.reshape(-1, *[1] * np.ndim(time))
    return np.cos(angle) + 0.3 * np.sin(2 * angle), 0.6 * np.cos(2 * angle) - np.sin(angle)


def _between(x: np.ndarray) -> np.ndarray:
    force = np.sin(x[:-1] - x[1:])
    nothing = np.zeros_like(x[:1])
    return np.concatenate((nothing, force)) - np.concatenate((force, nothing))


def _driven(time: Any, x: np.ndarray) -> np.ndarray:
    """A chain with smooth forces between neighbours, driven so that it takes the path."""
    angle = time + PHASES.reshape(-1, *[1] * (x.ndim - 1))
    return _between(x) - _between(_path(time)[0]) - np.cos(angle) - 1.2 * np.sin(2 * angle)


class _Watched:
    """The driven chain with the times at which it was asked."""

    def __init__(self) -> None:
        self.times: list[float] = []

    def __call__(self, time: float, x: np.ndarray) -> np.ndarray:
        self.times.append(time)
        return _driven(time, x)


def test_a_step_costs_what_the_documentation_says(method: type[OneStep]) -> None:
    watched = _Watched()
    x, v = _path(0.7)
    method().attempt(watched, 0.7, 0.1, x, v, _driven(0.7, x))
    stated = {BlanesMoan4: 6, BlanesMoan6: 11, BlanesMoan6Long: 15, VerletRichardson: 11}
    assert len(watched.times) == stated[method]


def test_nothing_moves_in_no_time(method: type[OneStep]) -> None:
    x, v = _path(0.3)
    tried = method().attempt(_driven, 0.3, 0.0, x, v, _driven(0.3, x))
    assert np.array_equal(tried[:2], (x, v))
    assert tried.error == 0


def test_a_batch_is_its_chains_side_by_side(method: type[OneStep]) -> None:
    times, sizes = np.array([0.0, 0.3, 1.1]), np.array([0.1, 0.25, 0.0])
    x, v = _path(times)
    batch = method().attempt(_driven, times, sizes, x, v, _driven(times, x))
    for lane, (time, size) in enumerate(zip(times, sizes, strict=True)):
        x, v = _path(time)
        single = method().attempt(_driven, float(time), float(size), x, v, _driven(time, x))
        # numpy's sines of arrays of another length may differ in the last digit
        assert np.allclose([row[:, lane] for row in batch[:3]], single[:3], rtol=0, atol=1e-14)
        assert np.broadcast_to(batch.error, 3)[lane] == pytest.approx(single.error, rel=1e-6, abs=1e-15)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-11])
def test_the_error_follows_the_setting(method: type[OneStep], tolerance: float) -> None:
    if not method.adaptive:
        # the step that the order asks for, and a constant that is far below 1 for these methods
        tolerance, size = tolerance / 10, 0.7 * tolerance ** (1 / method.order)
    else:
        size = 0.05
    integrator = method(tolerance=tolerance, size=size)
    *_, last = integrator.steps(_driven, 0.1, 2.0 + 1 / 3, *_path(0.1), None)
    # the errors of some ten steps add up
    assert np.max(np.abs(np.subtract((last.x, last.v), _path(last.end)))) < 10 * tolerance
