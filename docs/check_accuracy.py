"""Measure how often the stated accuracies hold, for random shocks of many kinds.

    python docs/check_accuracy.py

draws shocks of each kind with a seed, predicts and simulates them, and writes two tables into ``docs/trust.md``: the
share of shocks whose simulated peak force lies in the range of the estimate, and whose error lies in the expected error
of section 4. It takes about twenty minutes; ``--count`` changes the number of shocks of each kind.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from attrs import frozen
from shock_kinds import KINDS, MISLEADING, Draw, Record, draw, trapezoid

import shockwave as sw
from shockwave.chain import Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.prediction.model_interface import ScaledShock
from shockwave.prediction.shock_impulses import pulse_of, turns

PAGE = Path(__file__).parent / "trust.md"
CHAIN = sw.Chain(material=sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0), radius=4.75e-3)
FORCE = 100.0
TIME = Scales.of(CHAIN, FORCE).time
SEED = 71
COUNT = 500
# Range of the durations in T0, and its end for shocks with several peaks, whose waves separate slowly.
DURATIONS = (1e-3, 300.0)
LONGEST_TURNING = 20.0
# The same for flat tops, whose many waves are of almost equal strength.
LONGEST_FLAT = 150.0
# Requested relative error of the simulations, up to a duration in T0 and beyond.
RTOL = 1e-9
RTOL_LONG = 1e-6
LONG = 30.0
# Largest error estimate of a simulation that is used.
MOST_DOUBT = 1e-3
# Longest time of a simulation of a long shock [s]; a longer one does not resolve it.
TIMEOUT = 20.0
# Bands of the spread, with the target for the median width of the range.
BANDS = ((0.0, 0.45, 0.02), (0.45, 2.5, 0.08), (2.5, np.inf, 0.2))


# ---------------------------------------------------------------- shocks, predictions and simulations


@frozen
class Shot:
    """A shock, its prediction, its spread tau, and its simulated peak force with the relative error estimate."""

    outcome: sw.Outcome
    spread: float
    simulated: float
    doubt: float

    @property
    def miss(self) -> float:
        """Distance of the simulated peak force from the estimate over that of the end of the range on this side."""
        found = self.outcome.estimate
        assert found is not None
        off = self.simulated - found.peak_force
        reach = found.high - found.peak_force if off > 0 else found.peak_force - found.low
        return max(abs(off) - self.doubt * self.simulated, 0) / reach

    @property
    def held(self) -> bool:
        """Whether the error of section 4 lies in its range."""
        low, high = self.outcome.expected_error or (-np.inf, np.inf)
        error = self.outcome.peak_force / self.simulated - 1
        doubt = self.doubt * (1 + error)
        return low - doubt <= error <= high + doubt


def shots(kind: Callable[[Draw], Record], count: int) -> list[Shot]:
    """Draw, predict and simulate shocks of a kind."""
    return judged([shock_of(kind, number, SEED) for number in range(count)])


def mixed(count: int) -> list[Shot]:
    """Draw, predict and simulate shocks of all kinds in turn and of all durations."""
    kinds = (*KINDS, *MISLEADING)
    return judged([shock_of(kinds[number % len(kinds)], number, SEED + 1, longest=True) for number in range(count)])


def shock_of(kind: Callable[[Draw], Record], number: int, seed: int, longest: bool = False) -> sw.Shock:
    """Shock ``number`` of a kind; its duration is limited as its waves separate, unless ``longest``."""
    low, high = DURATIONS if longest else MISLEADING.get(kind, DURATIONS)
    if kind is trapezoid and not longest:
        high = min(high, LONGEST_FLAT)
    times, forces = draw(kind, number, seed, low, high)
    # cleaning would remove a faint tail
    profile = sw.Tabulated(times=times, forces=forces, clean=kind not in MISLEADING)
    shock = sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=times[-1] * TIME)
    if longest or high <= LONGEST_TURNING or not turns(scaled(shock)):
        return shock
    duration = low * (times[-1] / low) ** (np.log(LONGEST_TURNING / low) / np.log(high / low))
    return sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=duration * TIME)


def scaled(shock: sw.Shock) -> ScaledShock:
    """The shock in units of the chain."""
    return ScaledShock(shock.profile, shock.profile.areas(), shock.rise_time / TIME, MOMENTUM)


def judged(shocks: list[sw.Shock]) -> list[Shot]:
    """Predict and simulate shocks; those that simulation does not resolve are left out."""
    short = [shock for shock in shocks if shock.duration <= LONG * TIME]
    long = [shock for shock in shocks if shock.duration > LONG * TIME]
    results = [*sw.simulate_many(short, CHAIN, rtol=RTOL, waves="primary"), *map(simulated, long)]
    found = []
    for shock, result in zip([*short, *long], results, strict=True):
        if isinstance(result, sw.SimulationResult) and result.error_estimate <= MOST_DOUBT:
            outcome = sw.Predictor().predict(shock, CHAIN)
            found.append(Shot(outcome, pulse_of(scaled(shock)).spread, result.peak_force, result.error_estimate))
    return found


def simulated(shock: sw.Shock) -> sw.SimulationResult | None:
    """Simulate a long shock; None if this takes too long."""
    try:
        return sw.simulate(shock, CHAIN, rtol=RTOL_LONG, waves="primary", timeout=TIMEOUT)
    except sw.ShockwaveError:
        return None


def row_of(name: str, found: list[Shot]) -> str:
    """Row of the table of kinds."""
    known = [shot for shot in found if shot.outcome.estimate is not None]
    misses = np.array([shot.miss for shot in known])
    inside = [shot.held for shot in found if shot.outcome.expected_error is not None]
    section4 = f"{len(inside)} | {100 * np.mean(inside):.1f}" if inside else "0 | -"
    estimate = f"{len(known)} | {100 * np.mean(misses <= 1):.1f} | {misses.max():.2f}"
    return f"| {name.replace('_', ' ')} | {len(found)} | {estimate} | {section4} |"


def width_rows(found: Iterable[Shot]) -> list[str]:
    """Rows of the table of widths."""
    known = [shot for shot in found if shot.outcome.estimate is not None]
    rows = []
    for low, high, target in BANDS:
        own = [shot.outcome.estimate for shot in known if low <= shot.spread < high]
        widths = [(each.high - each.low) / each.peak_force for each in own if each is not None]
        ends = f"{low:g} to {high:g}" if np.isfinite(high) else f"over {low:g}"
        figures = " | ".join(f"{100 * np.quantile(widths, q):.2f}" for q in (0.5, 0.95))
        rows.append(f"| {ends} | {len(widths)} | {figures} | {100 * target:g} |")
    return rows


def main() -> None:
    """Measure, print and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=COUNT, help="shocks of each kind")
    count = parser.parse_args().count
    rows = []
    for kind in (*KINDS, *MISLEADING):
        rows.append(row_of(kind.__name__, shots(kind, count)))
        print(rows[-1], flush=True)
    every = mixed(2 * count)
    rows.append(row_of("all kinds, all durations", every))
    print(rows[-1], flush=True)
    made = {"coverage by kind": rows, "widths of the range": width_rows(every)}
    print(*made["widths of the range"], sep="\n")
    if count == COUNT:
        text = PAGE.read_text(encoding="utf-8")
        for name, lines in made.items():
            body = "".join(line + "\n" for line in lines)
            pattern = rf"(<!-- table: {name} -->\n.*\n\|---.*\n)(?:\|.*\n)*"
            text = re.sub(pattern, lambda head, body=body: head[1] + body, text)
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
