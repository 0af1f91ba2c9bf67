"""Records: a million samples, noise, gaps, plateaus, jumps, and samples that are no pulse."""

from __future__ import annotations

import time
from functools import cache

import numpy as np

from shockwave.benchmark.stress.case import Case, Finding
from shockwave.benchmark.stress.checks import AT_DEFAULT, BOOK, by_method, judged, like, refused
from shockwave.benchmark.stress.scenes import BEADS, FORCE, UNITS, Make, Scene, record
from shockwave.errors import InvalidValueError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.shock import Shock
from shockwave.profiles.tabulated import Tabulated
from shockwave.quadrature import FloatArray
from shockwave.simulation.backend import Backend

__all__ = ["CASES"]

_DURATION = 20.0
_SECONDS, _TRIES = 1.0, 3


@cache
def _samples(count: int, noise: float) -> tuple[FloatArray, FloatArray]:
    """Times [s] and forces [N] of a smooth pulse, steeper in its rise, with noise of a share of the peak."""
    share = np.linspace(0.0, 1.0, count)
    forces = np.sin(np.pi * share**0.7) ** 2
    forces += np.random.default_rng(20).normal(0.0, noise, count) if noise else 0.0
    return share * _DURATION * UNITS.time, FORCE * forces


def _pulse(count: int, noise: float) -> Scene:
    times, forces = _samples(count, noise)
    return Shock(profile=Tabulated(times=times, forces=forces)), BEADS


def _million(backend: Backend) -> Finding:
    shock, chain = _pulse(1_000_000, 0.01)
    fastest = float("inf")
    for _ in range(_TRIES):
        # each time on a record that nothing was computed of yet
        shock, chain = _pulse(1_000_000, 0.01)
        begin = time.perf_counter()
        outcome = Predictor().predict(shock, chain)
        result = simulate(shock, chain, backend=backend, waves="primary")
        fastest = min(fastest, time.perf_counter() - begin)
    tight = simulate(shock, chain, backend=backend, waves="primary", rtol=1e-10)
    faults = [] if fastest < _SECONDS else [f"prediction and simulation took {fastest:.2f} s"]
    note = f"predicted {outcome.amplification:.4g} F0, both in {fastest:.2g} s"
    return judged(result, tight.amplification, 1e-6, note, *faults)


def _finer(backend: Backend) -> Finding:
    coarse, fine = (simulate(*_pulse(count, 0.0), backend=backend, waves="primary") for count in (100_000, 1_000_000))
    steps = fine.found.steps / coarse.found.steps
    faults = [] if steps < 1.5 else [f"it took {steps:.2g} times the steps"]
    faults += [] if coarse.momentum_defect <= BOOK else ["the book of momentum of the coarser record is open"]
    note = f"{fine.found.steps:g} steps for {coarse.found.steps:g}"
    return judged(fine, coarse.amplification, AT_DEFAULT, note, *faults)


def _resampled(make_times: FloatArray, times: list[float], shares: list[float]) -> Make:
    return lambda: record(make_times.tolist(), np.interp(make_times, times, shares).tolist())()


def _noisy(count: int) -> Make:
    share = np.linspace(0.0, 1.0, count)
    forces = np.sin(np.pi * share) ** 2 + np.random.default_rng(3).normal(0.0, 0.02, count)
    forces[[0, -1]] = 0.0
    return record((6.0 * share).tolist(), np.maximum(forces, 0.0).tolist())


_BOX = ([0.0, 0.01, 8.0, 8.01], [0.0, 1.0, 1.0, 0.0])
_SHAPES: dict[str, tuple[str, Make]] = {
    "noisy-100": ("100 samples with noise of 2 %", _noisy(100)),
    "noisy-1000": ("1000 samples with noise of 2 %", _noisy(1000)),
    "plateau": ("a force that stays at its peak for 8 natural times", record([0, 1, 9, 10], [0, 1, 1, 0])),
    "two-pulses": ("two pulses, 8 natural times apart", record([0, 1, 2, 10, 11, 12], [0, 1, 0, 0, 0.6, 0])),
    "second-pulse-stronger": (
        "two pulses, the second twice as strong: it overtakes",
        record([0, 1, 2, 10, 11, 12], [0, 0.5, 0, 0, 1, 0]),
    ),
    "jump-at-the-end": ("a pulse that ends at 70 % of its peak", record([0, 1, 4], [0, 1, 0.7])),
    "jump-at-the-beginning": ("a pulse that begins at half of its peak", record([0, 1, 4], [0.5, 1, 0])),
    "spike-then-push": (
        "a spike of 2e-9 natural times, then a hundredth of it for 5",
        record([0, 1e-9, 2e-9, 5], [0, 1, 0.01, 0]),
    ),
    "subnormal-samples": (
        "samples of 5e-322 N beside the peak",
        record([0, 1, 2, 3, 4, 5], [0, 5e-324, 1e-310, 1, 1e-320, 0]),
    ),
}


def _by_method(name: str) -> Case:
    asked, make = _SHAPES[name]
    return Case(name=name, theme="records", asked=asked, must="the peak force of DOP853 to 2e-6", check=by_method(make))


def _far_apart(backend: Backend) -> Finding:
    pulse, gap = [0, 1, 0], 300.0
    first = simulate(*record([0, 1, 2], pulse)(), backend=backend, waves="primary")
    both = simulate(*record([0, 1, 2, gap, gap + 1, gap + 2], [*pulse, *pulse])(), backend=backend, waves="primary")
    return judged(both, first.amplification, AT_DEFAULT)


def _tabulated(times: list[float], forces: list[float]) -> SimulationResult:
    return simulate(Shock(profile=Tabulated(times=times, forces=forces)), BEADS)


def _no_pulse(name: str, asked: str, times: list[float], forces: list[float], words: str) -> Case:
    check = refused(lambda backend: _tabulated(times, forces), InvalidValueError, words)
    return Case(name=name, theme="records", asked=asked, must=f"InvalidValueError: '{words}'", check=check, twice=False)


CASES = (
    Case(
        name="million-samples",
        theme="records",
        asked="1 000 000 samples of a pulse of 20 natural times, with noise of 1 %",
        must="prediction and simulation in less than a second, the best of three; the peak force at rtol 1e-10 to 1e-6",
        check=_million,
        slow=True,
    ),
    Case(
        name="ten-times-finer",
        theme="records",
        asked="one smooth pulse in 100 000 and in 1 000 000 samples",
        must="the same peak force to 2e-6, with less than 1.5 times the steps",
        check=_finer,
        slow=True,
    ),
    Case(
        name="jumps-between-samples",
        theme="records",
        asked="a box of 8 natural times in 802 samples: jumps within one",
        must="the answers for its four corners to 2e-6",
        check=like(_resampled(np.linspace(0.0, 8.01, 802), *_BOX), record(*_BOX), AT_DEFAULT),
    ),
    *(_by_method(name) for name in _SHAPES),
    Case(
        name="two-pulses-far-apart",
        theme="records",
        asked="two equal pulses, 300 natural times apart",
        must="the primary of the first alone, to 2e-6: the second meets granules that fly away, and is weaker",
        check=_far_apart,
    ),
    _no_pulse("no-force", "a record of zeros", [0, 1, 2, 3], [0, 0, 0, 0], "must be > 0 N somewhere"),
    _no_pulse("not-a-number", "a sample that is no number", [0, 1, 2], [0, np.nan, 0], "forces[1]: must be a finite"),
    _no_pulse("no-decay", "a record that ends at its peak", [0, 1, 2], [0, 1, 2], "there is no decay"),
    _no_pulse("time-runs-back", "samples out of order", [0, 2, 1, 3], [0, 1, 1, 0], "must be greater than times[1]"),
)
