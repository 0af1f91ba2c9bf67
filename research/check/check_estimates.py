"""Error estimates of simulations, compared with finer simulations.

    python research/check/check_estimates.py

draws 200 shocks of each kind of ``tests/support/pulse_families.py`` and of records with several peaks, of 0.03 to 30
characteristic times. It compares the leading wave at ``rtol`` 1e-6 with a run at 1e-11; the later waves and the
momentum of the rebounding granules of the same run are compared with a run at 1e-10 that has a lower threshold and
follows the waves over twice the distance and more. The table is written into ``docs/trust.md``. It takes about five
minutes on two cores; all cores are used. ``--count`` changes the number of shocks.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from attrs import fields, frozen

import shockwave as sw
from shockwave.scene.chain import Scales
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation import wave_train_run
from shockwave.simulation.wave_setup import scale_scene, setup_of

sys.path.append(str(Path(__file__).parents[2] / "tests"))
from support.pulse_families import FAMILIES
from support.scenes import CHAIN, lasting

PAGE = Path(__file__).parents[2] / "docs" / "trust.md"
BEGIN, END = "<!-- table: error estimates -->\n", "<!-- end of table -->"
SEED = 1605
COUNT = 200
# Durations in characteristic times.
SHORTEST = 0.03
LONGEST = 30.0
# Relative tolerances of the reference of the leading wave, and of that of the train.
TIGHT = 1e-11
FINE = 1e-10
# Of the reference of the train: threshold, distances from the limits of the first and of later waves, most contacts.
THRESHOLD = 3e-3
FIRST = 1e-8
LATER = 1e-7
FARTHEST = 100_000
# Contacts over which waves are followed: at least, and for each characteristic time of the shock.
WAY = 350.0
WAY_RATE = 12.0
# A wave is judged where the reference is more accurate than this share of its estimate.
SHARE = 0.3


def several_peaks(draw: np.random.Generator) -> sw.ShockProfile:
    """A record of random samples."""
    count = draw.integers(3, 12)
    times = np.cumsum(draw.uniform(0.1, 1.0, count + 2))
    return sw.Tabulated(times=times - times[0], forces=[0.0, *draw.uniform(0.05, 1.0, count), 0.0])


KINDS: dict[str, Callable[[np.random.Generator], sw.ShockProfile]] = {**FAMILIES, "several peaks": several_peaks}


@frozen
class Check:
    """Errors over their estimates: of the leading wave, of the later waves, and of the rebound momentum."""

    leading_waves: tuple[float, ...]
    later_waves: tuple[float, ...]
    rebound_momenta: tuple[float, ...]


def shock_of(kind: str, number: int) -> sw.Shock:
    """Shock ``number`` of a kind."""
    draw = np.random.default_rng([SEED, number, list(KINDS).index(kind)])
    return lasting(KINDS[kind](draw), float(np.exp(draw.uniform(np.log(SHORTEST), np.log(LONGEST)))))


def reference(shock: sw.Shock) -> tuple[wave_train_run.ChainRun, Scales]:
    """The chain, integrated more finely and further, in scaled units."""
    problem, scales = scale_scene(Scene(excitation=shock, chain=CHAIN))
    usual = wave_train_run._BUDGET, wave_train_run._BUDGET_RATE
    wave_train_run._BUDGET, wave_train_run._BUDGET_RATE = WAY, WAY_RATE
    try:
        integrator = setup_of(SimulateOptions(rtol=FINE)).integrator()
        return wave_train_run.ChainRun(problem, integrator, THRESHOLD, FIRST, LATER, FARTHEST).finish(), scales
    finally:
        wave_train_run._BUDGET, wave_train_run._BUDGET_RATE = usual


def check(task: tuple[str, int]) -> Check:
    """Compare the simulation of one shock with the references."""
    shock = shock_of(*task)
    result = sw.simulate(shock, CHAIN)
    precise = sw.simulate(shock, CHAIN, rtol=TIGHT, waves="primary")
    error = max(abs(result.peak_force / precise.peak_force - 1) - precise.error_estimate, 0.0)
    leading = (error / result.error_estimate,)
    fine, scales = reference(shock)
    later = []
    for wave in result.train.waves[1:]:
        force = wave.peak_force / scales.force
        nearest = min(fine.waves, key=lambda other: abs(other.peak_force - force))
        uncertainty = math.inf if nearest.error_estimate is None else nearest.error_estimate
        if wave.error_estimate is not None and uncertainty <= SHARE * wave.error_estimate:
            later.append(abs(nearest.peak_force / force - 1) / wave.error_estimate)
    claimed = result.train.recoil_error / scales.momentum
    off = abs(result.train.recoil_momentum / scales.momentum - sum(fine.recoils))
    return Check(leading, tuple(later), (off / claimed,) if fine.unfinished_recoil <= claimed else ())


def rows(checks: list[Check]) -> Iterator[str]:
    """A row for each quantity."""
    yield "| quantity | compared | held, % | worst |"
    yield "|---|---|---|---|"
    for field in fields(Check):
        ratios = np.array([ratio for each in checks for ratio in getattr(each, field.name)])
        held = f"{100 * np.mean(ratios <= 1):.1f} | {ratios.max():.2f}" if len(ratios) else "- | -"
        yield f"| {field.name.replace('_', ' ')} | {len(ratios)} | {held} |"


def main() -> None:
    """Check all shocks, print the table and write it into the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=COUNT, help="shocks of each kind; others leave the page as it is")
    count = parser.parse_args().count
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with ProcessPoolExecutor() as pool:
        checks = list(pool.map(check, [(kind, number) for kind in KINDS for number in range(count)], chunksize=4))
    table = "\n".join(rows(checks))
    print(table)
    if count == COUNT:
        before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
        PAGE.write_text(f"{before}{BEGIN}{table}\n{END}{rest.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()
