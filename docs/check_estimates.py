"""Error estimates of simulations, compared with tighter runs and against an independent integrator.

    python docs/check_estimates.py

checks three claims with 500 seeded random shocks of each kind, and writes a table for each into ``docs/simulation.md``:

- the leading wave, at three tolerances, against a tolerance of 1e-11;
- short finite chains, against DOP853, which integrates the whole chain until no granules approach each other;
- later waves and rebounding granules, against a run with smaller steps, far beyond the contacts where the runs of the
  default stop.

It takes about a quarter of an hour on one core; all cores are used. ``--count`` changes the number of shocks.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np
from attrs import evolve, frozen
from check_waves import CHAIN, FORCE, SHORTEST, Check, check, rows, shock_of
from scipy.integrate import DOP853, DenseOutput
from scipy.optimize import brentq
from shock_kinds import ALL, Array, Record, draw

import shockwave as sw
from shockwave.chain import Scales

PAGE = Path(__file__).parent / "simulation.md"
END = "<!-- end of table -->"
SEED = 2312
UNITS = Scales.of(CHAIN, FORCE)
# Durations in T0.
LONGEST, LONGEST_FINITE, LONGEST_TRAIN = 30.0, 40.0, 15.0
# Shocks of each kind.
COUNT = 500
# Shocks that are simulated together.
SHARE = 50
TOLERANCES = (1e-4, 1e-6, 1e-8)
# Tolerance of the references, and the largest error estimate of one that is used.
TIGHT, MOST_DOUBT = 1e-11, 1e-9
TRAIN_ACCURACY = 1e-9
# Of DOP853: tolerances, longest step, the time between two looks for free flight, the shortest flight in closed form,
# the slowest approach of two granules, the end, and the least overlap or gap on both sides of a contact that switches.
RTOL, ATOL, STEP, LOOK, FLIGHT, SLOWEST, LATEST, NEAR = 1e-11, 1e-13, 0.5, 5.0, 1.0, 1e-12, 1e5, 1e-10
# Most samples of a record on a finite chain.
MOST_SAMPLES = 50
# Share of the threshold by which a wave must exceed it to be expected.
ABOVE = 0.01
# Largest difference of the times of a peak in both, in T0.
SAME_TIME = 0.05
# A collision after this time, in T0, is late.
LATE = 100.0


# ---------------------------------------------------------------- leading waves


def leading(kind: int, first: int, count: int) -> Array:
    """Errors over estimates and over tolerances, shape (shocks, tolerances, 2); of shocks with a reference."""
    shocks = [shock_of(kind, number, SEED, LONGEST) for number in range(first, first + count)]
    runs = [sw.simulate_many(shocks, CHAIN, rtol=rtol, waves="primary", threads=1) for rtol in (TIGHT, *TOLERANCES)]
    found = []
    for known, *results in zip(*runs, strict=True):
        if not isinstance(known, sw.SimulationResult) or known.error_estimate > MOST_DOUBT:
            continue
        ratios = []
        for result, rtol in zip(results, TOLERANCES, strict=True):
            assert isinstance(result, sw.SimulationResult)
            error = abs(result.peak_force / known.peak_force - 1)
            ratios.append((max(error - known.error_estimate, 0) / result.error_estimate, error / rtol))
        found.append(ratios)
    return np.array(found).reshape(-1, len(TOLERANCES), 2)


def leading_rows(found: dict[str, Array]) -> Iterator[str]:
    """Table of the leading waves."""
    yield "| kind | shocks | " + " | ".join(f"{rtol:.0e}, % | worst" for rtol in TOLERANCES) + " | within `rtol`, % |"
    yield "|---" * (3 + 2 * len(TOLERANCES)) + "|"
    for name, ratios in found.items():
        held = " | ".join(f"{100 * np.mean(each <= 1):.1f} | {each.max():.2f}" for each in ratios[..., 0].T)
        yield f"| {name} | {len(ratios)} | {held} | {100 * np.mean(ratios[..., 1] <= 1):.1f} |"


# ---------------------------------------------------------------- finite chains


@frozen
class Short:
    """Result for a short chain.

    Errors over estimates of the greatest force and of the waves; of the maxima that were lost, the rise before or the
    fall behind, if smaller, over the force; the error of the final velocities over the greatest, and the time of the
    last collision in T0.
    """

    greatest: float
    waves: tuple[float, ...]
    lost: tuple[float, ...]
    velocities: float
    last: float


def short(kind: int, number: int) -> Short:
    """One shock on a chain of two to eight granules."""
    granules = int(np.random.default_rng([SEED, kind, number]).integers(2, 9))
    times, forces = thinned(*draw(ALL[kind], number, SEED, SHORTEST, LONGEST_FINITE))
    shock = sw.Shock(profile=sw.Tabulated(times=times * UNITS.time, forces=forces * FORCE, clean=False))
    result = sw.simulate(shock, evolve(CHAIN, granules=granules))
    velocities, peaks, dips = collisions(times, forces, granules)
    strongest = max(force for each in peaks for force, _ in each)
    greatest = result.greatest_force
    assert greatest is not None
    assert result.spall_velocities is not None
    here = peaks[result.waves[0].contact]
    least = (1 + ABOVE) * result.options.wave_threshold * max(here)[0]
    errors, lost = [], []
    for force, time in here:
        nearest = min(result.waves, key=lambda wave: abs(wave.arrival_time / UNITS.time - time))
        if abs(nearest.arrival_time / UNITS.time - time) < SAME_TIME:
            errors.append(abs(nearest.peak_force / FORCE / force - 1) / (nearest.error_estimate or np.inf))
        elif force > least:
            around = dips[result.waves[0].contact]
            before = max((dip for dip in around if dip[1] < time), key=lambda dip: dip[1], default=(0.0, 0.0))
            after = min((dip for dip in around if dip[1] > time), key=lambda dip: dip[1], default=(0.0, 0.0))
            lost.append(1 - max(before[0], after[0]) / force)
    flown = np.array(result.spall_velocities) / UNITS.velocity
    fastest = np.abs(velocities).max()
    return Short(
        abs(greatest.peak_force / FORCE / strongest - 1) / greatest.error_estimate,
        tuple(errors),
        tuple(lost),
        float(np.abs(flown - velocities[::-1][: len(flown)]).max(initial=0.0)) / fastest,
        max(time for each in peaks for force, time in each if force > least),
    )


def thinned(times: Array, forces: Array) -> Record:
    """A record of fewer samples, since each of them ends a step of DOP853."""
    kept = np.unique(np.linspace(0, len(times) - 1, min(len(times), MOST_SAMPLES)).astype(int))
    return times[kept], forces[kept]


Extrema = list[list[tuple[float, float]]]


def collisions(times: Array, forces: Array, granules: int) -> tuple[Array, Extrema, Extrema]:
    """Final velocities, and force and time of all maxima and minima at each contact, in scaled units, by DOP853.

    Steps end at the kinks of the force, and where a contact opens or closes. Where a contact opens, the force has a
    minimum of zero.
    """

    def rates(time: float, state: Array) -> Array:
        x, v = np.split(state, 2)
        contacts = np.maximum(x[:-1] - x[1:], 0) ** 1.5
        outside = np.interp(time, times, forces, right=0.0)
        return np.append(v, -np.diff(np.concatenate(([outside], contacts, [0.0]))))

    def motion(state: Array) -> Array:
        """Overlap of each contact, and its rate."""
        return np.array([-np.diff(each) for each in np.split(state, 2)])

    def root(dense: DenseOutput, row: int, contact: int) -> float:
        """Time in a step at which an overlap or its rate is zero."""
        return float(brentq(lambda t: motion(dense(t))[row, contact], dense.t_min, dense.t_max, xtol=1e-14))

    peaks: Extrema = [[] for _ in range(granules - 1)]
    dips: Extrema = [[] for _ in range(granules - 1)]
    state, now = np.zeros(2 * granules), 0.0

    def advance(until: float) -> None:
        nonlocal state, now
        end = until
        while now < until:
            solver = DOP853(rates, now, state, end, rtol=RTOL, atol=ATOL, max_step=STEP)
            end = until
            while solver.status == "running":
                solver.step()
                dense = solver.dense_output()
                before, after = motion(state), motion(solver.y)
                far = np.minimum(abs(before[0]), abs(after[0])) > NEAR
                if (switched := np.flatnonzero(far & (before[0] * after[0] < 0))).size:
                    end = max(min(root(dense, 0, contact) for contact in switched), now + NEAR)
                    break
                for contact in np.flatnonzero((before[1] * after[1] < 0) & (after[0] > 0)):
                    time = root(dense, 1, contact)
                    found = peaks if before[1, contact] > 0 else dips
                    found[contact].append((max(motion(dense(time))[0, contact], 0) ** 1.5, time))
                for contact in np.flatnonzero((before[0] > 0) & (after[0] <= 0)):
                    dips[contact].append((0.0, float(solver.t)))
                state, now = solver.y, solver.t

    for stop in times[1:]:
        advance(float(stop))
    while now < LATEST:
        x, v = np.split(state, 2)
        gaps, approach = np.diff(x), -np.diff(v)
        meets = approach > SLOWEST
        if gaps.min() >= 0 and not meets.any():
            break
        flight = (gaps[meets] / approach[meets]).min() if gaps.min() >= 0 else 0.0
        if flight > FLIGHT:
            state, now = np.append(x + flight * v, v), now + float(flight)
        else:
            advance(now + LOOK)
    return state[granules:], peaks, dips


def short_rows(found: dict[str, list[Short]]) -> Iterator[str]:
    """Table of the finite chains."""
    yield "| kind | chains | late | lost | depth, % | velocities | greatest, % | worst | waves | held, % | worst |"
    yield "|---" * 11 + "|"
    for name, shots in found.items():
        greatest = np.array([shot.greatest for shot in shots])
        waves = np.array([ratio for shot in shots for ratio in shot.waves])
        held = [f"{100 * np.mean(each <= 1):.1f} | {each.max():.2f}" for each in (greatest, waves)]
        late, lost = sum(shot.last > LATE for shot in shots), [depth for shot in shots for depth in shot.lost]
        losses = f"{len(lost)} | {100 * max(lost):.2g}" if lost else "0 | -"
        velocities = f"{max(shot.velocities for shot in shots):.0e}"
        yield f"| {name} | {len(shots)} | {late} | {losses} | {velocities} | {held[0]} | {len(waves)} | {held[1]} |"


# ---------------------------------------------------------------- all


def trains(kind: int, number: int) -> Check:
    """One shock for `check_waves.check`."""
    return check(kind, number, SEED, LONGEST_TRAIN, TRAIN_ACCURACY)


def tables(count: int, pool: ProcessPoolExecutor) -> Iterator[tuple[str, str]]:
    """Names and texts of the tables."""
    names = [kind.__name__ for kind in ALL]
    own = list(range(len(ALL)))
    shares = [(i, n) for i in own for n in range(0, count, SHARE)]
    found = list(pool.map(leading, *zip(*shares, strict=True), [min(SHARE, count)] * len(shares)))
    by_kind = {names[i]: np.concatenate([a for (k, _), a in zip(shares, found, strict=True) if k == i]) for i in own}
    yield "leading waves", "\n".join(leading_rows(by_kind | {"all": np.concatenate(found)}))
    numbers, kinds = zip(*product(range(count), own), strict=True)
    chains = list(pool.map(short, kinds, numbers, chunksize=4))
    yield "finite chains", "\n".join(short_rows({names[i]: chains[i :: len(own)] for i in own} | {"all": chains}))
    checks = list(pool.map(trains, kinds, numbers, chunksize=4))
    yield "trains", "\n".join(rows({names[i]: checks[i :: len(own)] for i in own} | {"all": checks}))


def main() -> None:
    """Check all claims, print the tables and write them into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=COUNT, help="shocks of each kind; others leave the page as it is")
    parser.add_argument("--processes", type=int, help="by default one for each core")
    options = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with ProcessPoolExecutor(options.processes) as pool:
        for name, table in tables(options.count, pool):
            print(f"{name}\n{table}", flush=True)
            begin = f"<!-- table: {name} -->\n"
            if options.count == COUNT:
                before, rest = PAGE.read_text().split(begin)
                PAGE.write_text(f"{before}{begin}{table}\n{END}{rest.partition(END)[2]}")


if __name__ == "__main__":
    main()
