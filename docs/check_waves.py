"""Error estimates of later waves and of rebounding granules, compared with a reference.

    python docs/check_waves.py

draws 40 shocks of each of 13 kinds, 0.3 to 30 characteristic times long. It simulates them with default settings, and
once more as a reference: with smaller steps (1e-10), a lower threshold, and on twice the way and more, far beyond the
contacts where the runs of the default stop. It takes some minutes and writes a table of ``docs/trust.md``.
"""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np
from attrs import frozen
from shock_kinds import ALL, KINDS, draw

import shockwave as sw
from shockwave.chain import Scales
from shockwave.measurement import chain_run
from shockwave.measurement.result import Train
from shockwave.measurement.simulation_setup import scaled, setup_of
from shockwave.options import SimulateOptions

PAGE = Path(__file__).parent / "trust.md"
BEGIN, END = "<!-- table: waves -->\n", "<!-- end of table -->"
STEEL = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
CHAIN = sw.Chain(material=STEEL, radius=4.75e-3)
FORCE = 100.0
SEED, COUNT, SHORTEST, LONGEST = 1605, 40, 0.3, 30.0
# Of the reference: accuracy of its steps, threshold, distances from their limits, and the way, contacts at least and
# for each characteristic time of the shock.
ACCURACY, THRESHOLD, FIRST, LATER = 1e-10, 3e-3, 1e-8, 1e-7
WAY, WAY_RATE, FARTHEST = 350.0, 12.0, 100_000
# A wave is judged where the reference knows it better than this share of its estimate.
SHARE = 0.3


@frozen
class Check:
    """Errors over estimates, of the later waves and of the rebound momentum; waves without estimate or reference.

    ``rebounds`` is empty where the rebound momentum of the reference is not known as well as claimed.
    """

    waves: tuple[float, ...]
    rebounds: tuple[float, ...]
    unsettled: int
    unjudged: int


def reference(shock: sw.Shock, accuracy: float = ACCURACY) -> chain_run.ChainRun:
    """The chain, integrated more finely and further."""
    problem, _ = scaled(shock, CHAIN)
    integrator = setup_of(SimulateOptions(rtol=accuracy)).integrator()
    usual = chain_run._BUDGET, chain_run._BUDGET_RATE
    chain_run._BUDGET, chain_run._BUDGET_RATE = WAY, WAY_RATE
    try:
        return chain_run.ChainRun(problem, integrator, THRESHOLD, FIRST, LATER, FARTHEST).finished()
    finally:
        chain_run._BUDGET, chain_run._BUDGET_RATE = usual


def checked(train: Train, scales: Scales, known: chain_run.ChainRun) -> Check:
    """The errors of a train against the reference; each wave beside the one that is nearest to it."""
    ratios, unsettled, unjudged = [], 0, 0
    for wave in train.waves[1:]:
        if wave.error_estimate is None:
            unsettled += 1
            continue
        force = wave.peak_force / scales.force
        nearest = min(known.waves, key=lambda other: abs(other.peak_force - force))
        doubt = math.inf if nearest.error_estimate is None else nearest.error_estimate
        if doubt > SHARE * wave.error_estimate:
            unjudged += 1
            continue
        ratios.append(abs(nearest.peak_force / force - 1) / wave.error_estimate)
    claimed = train.recoil_error / scales.momentum
    error = abs(train.recoil_momentum / scales.momentum - sum(known.recoils))
    rebounds = (error / claimed,) if known.unfinished_recoil <= claimed else ()
    return Check(tuple(ratios), rebounds, unsettled, unjudged)


def shock_of(kind: int, number: int, seed: int, longest: float) -> sw.Shock:
    """Shock ``number`` of a kind, in SI units."""
    times, forces = draw(ALL[kind], number, seed, SHORTEST, longest)
    unit = Scales.of(CHAIN, FORCE).time
    return sw.Shock(profile=sw.Tabulated(times=times * unit, forces=forces * FORCE))


def check(kind: int, number: int, seed: int = SEED, longest: float = LONGEST, accuracy: float = ACCURACY) -> Check:
    """One shock."""
    shock = shock_of(kind, number, seed, longest)
    _, scales = scaled(shock, CHAIN)
    return checked(sw.simulate(shock, CHAIN).train, scales, reference(shock, accuracy))


def rows(checks: dict[str, list[Check]]) -> Iterator[str]:
    """The table, a row for each kind and one for all."""
    yield "| kind | waves | held, % | worst | without | not judged | rebounds | held, % | worst |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for name, found in checks.items():
        waves = np.array([ratio for each in found for ratio in each.waves])
        rebound = np.array([ratio for each in found for ratio in each.rebounds])
        counts = sum(each.unsettled for each in found), sum(each.unjudged for each in found)
        shares = [
            f"{100 * np.mean(each <= 1):.1f} | {each.max():.2g}" if len(each) else "- | -" for each in (waves, rebound)
        ]
        yield f"| {name} | {len(waves)} | {shares[0]} | {counts[0]} | {counts[1]} | {len(rebound)} | {shares[1]} |"


def main() -> None:
    """Check all shocks, print the table and write it into the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=COUNT, help="shocks of each kind; others leave the page as it is")
    count = parser.parse_args().count
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    numbers, kinds = zip(*product(range(count), range(len(KINDS))), strict=True)
    with ProcessPoolExecutor() as pool:
        found = list(pool.map(check, kinds, numbers))
    checks = {kind.__name__: found[index :: len(KINDS)] for index, kind in enumerate(KINDS)}
    table = "\n".join(rows(checks | {"all": found}))
    print(table)
    if count == COUNT:
        before, rest = PAGE.read_text().split(BEGIN)
        PAGE.write_text(f"{before}{BEGIN}{table}\n{END}{rest.split(END)[1]}")


if __name__ == "__main__":
    main()
