"""Laws of walls, strikers and damping, and predictions for finite chains, compared with simulations.

    python docs/check_wall.py

draws 500 shocks of all kinds and 200 strikers on chains of random lengths before walls of random stiffness, 500 shocks
on chains with free ends, none of which were used in the fit of the laws, and 500 points of each law, and writes four
tables into ``docs/chain-laws.md``. It takes about two minutes.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from attrs import evolve, frozen
from check_waves import CHAIN, FORCE, shock_of
from fit_chain_laws import FORCE as FIT_FORCE
from fit_chain_laws import decay, impulse_limit, leading, simulated, wall_ratio
from judge_auto import write_table
from shock_kinds import ALL

import shockwave as sw
from shockwave.chain import Scales
from shockwave.prediction import chain_laws as laws

PAGE = Path(__file__).parent / "chain-laws.md"
SEED = 20263
SHOCKS, STRIKERS = 500, 200
UNIT = Scales.of(CHAIN, FORCE).time
# Longest shock [T0], and its bands in the table.
LONGEST = 60.0
BANDS = (0.0, 2.0, 5.0, 15.0, LONGEST)
# Relative tolerance of the simulations.
RTOL = 1e-5
# Mass ratios and ends of the bands of A/T of the errors of the laws.
MASSES = (1e-3, 100.0)
DAMPINGS = (0.0, 0.03, 0.05)
# Share of rigid walls.
RIGID_SHARE = 0.2


@frozen
class Check:
    """Result of one case: a number by which the cases are ordered, the simulated force, and the ends of its range.

    All forces are relative to the estimate; None if there is none.
    """

    number: float
    force: float | None
    low: float = 0.0
    high: float = 0.0

    @property
    def holds(self) -> bool:
        """Whether the range holds, within the error of the simulation."""
        return self.force is not None and self.low - RTOL <= self.force <= self.high + RTOL


def walled(draw: np.random.Generator, granules: int) -> sw.Chain:
    """A chain before a wall of random stiffness."""
    share = draw.uniform(0.02, 0.999)
    soft = evolve(CHAIN.material, youngs_modulus=CHAIN.material.youngs_modulus * share / (1 - share))
    material: Any = "rigid" if draw.random() < RIGID_SHARE else soft
    return evolve(CHAIN, granules=granules, end=sw.Wall(material=material))


def checked(number: float, excitation: sw.Shock | sw.Impact, chain: sw.Chain) -> Check:
    """Prediction and simulation of one case."""
    predicted = sw.predict(excitation, chain).transmitted
    if predicted is None:
        return Check(number, None)
    assert chain.count is not None
    last = chain.count - 1 + isinstance(excitation, sw.Impact)
    simulated = sw.simulate(excitation, chain, rtol=RTOL, contacts=[last]).transmitted.peak_force
    figures = (force / predicted.peak_force for force in (simulated, predicted.low, predicted.high))
    return Check(number, *figures)


def shock_and_length(draw: np.random.Generator, number: int) -> tuple[sw.Shock, int]:
    """One shock, and a number of granules from the least in which its wave forms to several times as many."""
    one = shock_of(number % len(ALL), number, SEED, LONGEST)
    duration = one.duration / UNIT
    return one, round(float(np.exp(draw.uniform(np.log(9 + duration), np.log(60 + 6 * duration)))))


def shock(number: int) -> Check:
    """One shock on a chain before a wall."""
    draw = np.random.default_rng([SEED, number])
    one, granules = shock_and_length(draw, number)
    return checked(one.duration / UNIT, one, walled(draw, granules))


def free(number: int) -> Check:
    """The leading wave of one shock on a chain with free ends."""
    one, granules = shock_and_length(np.random.default_rng([SEED, 3, number]), number)
    chain = evolve(CHAIN, granules=granules)
    found = sw.predict(one, chain).estimate
    if found is None:
        return Check(one.duration / UNIT, None)
    peak_force = sw.simulate(one, chain, rtol=RTOL, waves="primary").peak_force
    figures = (force / found.peak_force for force in (peak_force, found.low, found.high))
    return Check(one.duration / UNIT, *figures)


def striker(number: int) -> Check:
    """One striker of a random size and material; the number is the mass ratio."""
    draw = np.random.default_rng([SEED, 1, number])
    ratio = float(np.exp(draw.uniform(*np.log([1e-3, 50.0]))))
    density = float(np.exp(draw.uniform(*np.log([0.3, 3.0]))))
    radius = CHAIN.radius * (ratio / density) ** (1 / 3)
    modulus = CHAIN.material.youngs_modulus * float(np.exp(draw.uniform(*np.log([0.3, 3.0]))))
    material = evolve(CHAIN.material, youngs_modulus=modulus, density=density * CHAIN.material.density)
    granules = round((10 + 6 * ratio**0.5) * draw.uniform(1.05, 3))
    impact = sw.Impact(velocity=0.5, radius=radius, material=material)
    return checked(ratio, impact, walled(draw, granules))


def rows(found: list[Check], bands: tuple[float, ...], name: str) -> Iterator[str]:
    """The table: cases by their number, and all of them."""
    yield f"| {name} | cases | estimated | range holds, % | simulated over estimate | range |"
    yield "|---|---|---|---|---|---|"
    for low, high in (*pairwise(bands), (bands[0], bands[-1])):
        here = [one for one in found if low <= one.number <= high]
        known = [one for one in here if one.force is not None]
        held = 100 * np.mean([one.holds for one in known])
        force = [one.force for one in known]
        ends = f"{np.mean([one.low for one in known]):.3f} to {np.mean([one.high for one in known]):.3f}"
        where = "all" if (low, high) == (bands[0], bands[-1]) else f"{low:g} to {high:g}"
        yield f"| {where} | {len(here)} | {len(known)} | {held:.1f} | {min(force):.3f} to {max(force):.3f} | {ends} |"


def law_rows(count: int) -> Iterator[str]:
    """The table: greatest relative errors of the laws at random points."""
    draw = np.random.default_rng([SEED, 2])
    wave = simulated(120, 100.0, rtol=1e-12, contacts=[50]).contacts[0].peak_force / FIT_FORCE
    kappa = laws.RIGID * draw.uniform(0, 1, count) ** 2
    factor = np.array([wall_ratio(each, wave) for each in kappa]) * kappa**0.4
    ratios = np.exp(draw.uniform(*np.log(MASSES), count))
    first = np.exp([leading(math.log(each)) for each in ratios]) * [impulse_limit(each) for each in ratios]
    errors = {
        "wall factor": laws.wall_factor(kappa) / factor,
        f"leading wave of a striker, $\\mu$ from {MASSES[0]:g} to {MASSES[1]:g}": laws.striker_waves(ratios)[:, 0]
        / first,
    }
    for low, high in pairwise(DAMPINGS):
        found: list[float] = []
        while len(found) < count:
            damping = draw.uniform(low, high)
            # the characteristic time of the wave of this striker is about 1.1
            n, times = decay(1.1 * damping, 150)
            found += (laws.damped_decay(n, min(1.1 * damping / times[0], high)) * (times / times[0]) ** 6).tolist()
        errors[f"decay, $A/T$ from {low:g} to {high:g}"] = np.array(found)
    yield "| law | points | greatest relative error |"
    yield "|---|---|---|"
    for name, each in errors.items():
        yield f"| {name} | {len(each)} | {np.abs(each - 1).max():.1g} |"


def main() -> None:
    """Check all cases, and write and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=SHOCKS)
    count = parser.parse_args().count
    tables = {
        "errors of the laws": law_rows(count),
        "shocks on walls": rows([shock(number) for number in range(count)], BANDS, "duration, $T_0$"),
        "shocks on free chains": rows([free(number) for number in range(count)], BANDS, "duration, $T_0$"),
        "strikers and walls": rows(
            [striker(number) for number in range(min(count, STRIKERS))], (1e-3, 0.1, 1.0, 5.0, 50.0), "mass ratio"
        ),
    }
    for name, lines in tables.items():
        table = list(lines)
        print(name, *table, sep="\n")
        if count == SHOCKS:
            write_table(PAGE, name, table[2:])


if __name__ == "__main__":
    main()
