"""Validate the model ``auto``: how often it meets its tolerance, by which method, and at what cost.

    python docs/judge_auto.py

draws 1 000 random pulses of all kinds, including those of the sample plugins, compares ``auto`` with simulations with
rtol 1e-9, and measures its run time relative to that of simulations, in about a minute. It writes two tables of
``docs/auto.md``. The ratios of run times depend on the machine.
"""

from __future__ import annotations

import math
import re
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from attrs import evolve
from fit_moments import CHAIN, FORCE, Draw, exponential, lasting, one_peak, power_law, ratio, several_peaks

import shockwave as sw
from shockwave.prediction import short_shock_law as short
from shockwave.profiles import base
from shockwave.registry import load
from shockwave.studies.universal_curve import cached_curve

PAGE = Path(__file__).parent / "auto.md"
# Seed and number of the pulses.
SEED = 6301
COUNT = 1000
# Range of the durations, in T0.
SHORTEST = 1e-2
LONGEST = 20.0
# Tolerances that are requested from the model.
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-6)
# Relative error of the reference simulations.
KNOWN = 1e-9


def triangular(draw: Draw) -> sw.ShockProfile:
    """A triangle."""
    return sw.Triangular(duration_ratio=ratio(draw))


def plugged(draw: Draw) -> sw.ShockProfile:
    """A profile of a sample plugin."""
    share = float(10 ** draw.uniform(-3, -0.5))
    kinds: dict[str, dict[str, Any]] = {
        "half-sine": {},
        "haversine": {},
        "trapezoid": {"rise_fraction": share, "fall_fraction": float(draw.uniform(0.05, 0.5))},
        "initial-peak-sawtooth": {"rise_fraction": share},
        "final-peak-sawtooth": {"fall_fraction": share},
        "rectangular": {"rise_fraction": min(share, 0.1), "fall_fraction": 0.02},
        "hertz-impact": {},
        "friedlander": {"decay_coefficient": float(draw.uniform(0, 5)), "rise_fraction": share},
    }
    name = list(kinds)[draw.integers(len(kinds))]
    profile: sw.ShockProfile = load("profiles", name)(**kinds[name])
    return profile


KINDS = (power_law, exponential, triangular, one_peak, several_peaks, plugged)


def drawn(seed: int, count: int) -> list[sw.Shock]:
    """Random pulses of the kinds in turn, log-uniform in n t0/T0."""
    draw = np.random.default_rng(seed)
    logs = draw.uniform(math.log(SHORTEST), math.log(LONGEST), count)
    return [lasting(KINDS[index % len(KINDS)](draw), math.exp(log)) for index, log in enumerate(logs)]


def fresh() -> None:
    """Clear the caches of shapes, so that each run time includes all of the work."""
    cached_curve.cache_clear()
    base._areas.cache_clear()
    short._of_one.cache_clear()


def best(calls: Sequence[Callable[[], Any]], repeats: int) -> list[float]:
    """Shortest run time of each call [s]; the calls take turns."""
    times = [math.inf] * len(calls)
    for _ in range(repeats):
        for index, call in enumerate(calls):
            fresh()
            begin = time.perf_counter()
            call()
            times[index] = min(times[index], time.perf_counter() - begin)
    return times


def timed(predictor: sw.Predictor, shocks: list[sw.Shock], rtol: float, alone: bool) -> float:
    """Run time of predictions over that of simulations with ``rtol``, one by one or all at once."""
    calls: list[Callable[[], Any]] = [
        lambda: predictor.predict_many(shocks, CHAIN),
        lambda: sw.simulate_many(shocks, CHAIN, rtol=rtol, waves="primary"),
    ]
    if alone:
        calls = [
            lambda: [predictor.predict(shock, CHAIN) for shock in shocks],
            lambda: [sw.simulate(shock, CHAIN, rtol=rtol, waves="primary") for shock in shocks],
        ]
    mine, theirs = best(calls, 2 if alone else 5)
    return mine / theirs


def accuracy(shocks: list[sw.Shock]) -> list[str]:
    """Rows of the table: how often the tolerance is met, by which method, and the time over that of simulations."""
    known = sw.simulate_many(shocks, CHAIN, rtol=KNOWN, waves="primary")
    true = np.array([result.amplification for result in known if isinstance(result, sw.SimulationResult)])
    assert len(true) == len(shocks)
    rows = []
    for rtol in TOLERANCES:
        predictor = sw.Predictor(model="auto", rtol=rtol)
        outcomes = [predictor.predict(shock, CHAIN) for shock in shocks]
        many = predictor.predict_many(shocks, CHAIN)
        error = np.abs([outcome.amplification for outcome in outcomes] / true - 1)
        bound = np.array([outcome.expected_error[1] for outcome in outcomes if outcome.expected_error])
        both = np.abs(many.amplification / true - 1)
        taken = Counter(outcome.method for outcome in outcomes)
        counts = " | ".join(str(taken[name]) for name in ("moments", "simulation"))
        met = " | ".join(f"{100 * np.mean(each <= rtol):.1f}" for each in (error, both))
        figures = f"{100 * np.mean(error <= bound + KNOWN):.1f} | {error.max():.1e}"
        costs = " | ".join(f"{timed(predictor, shocks, min(rtol, 1e-2), alone):.1f}" for alone in (True, False))
        rows.append(f"| {rtol:g} | {met} | {figures} | {counts} | {costs} |")
    return rows


def throughput() -> list[str]:
    """Rows of the table: many pulses in the range of the short law, relative to `simulate_many`, both with 1e-2."""
    draw, predictor = np.random.default_rng(SEED + 1), sw.Predictor(model="auto", rtol=1e-2)
    shapes = [kind(draw) for kind in KINDS[:5]]
    durations, longer = (np.exp(draw.uniform(math.log(0.05), math.log(most), 4000)) for most in (1.2, 20.0))
    few, all_ = ([lasting(shapes[i % 5], value) for i, value in enumerate(each)] for each in (durations, longer))
    forces = draw.uniform(0.5, 2, len(few)) * FORCE
    own = [lasting(KINDS[index % 5](draw), value) for index, value in enumerate(durations[:1000])]
    named = [
        ("five shapes, 800 durations each", few),
        ("the same, each with its own peak force", [evolve(s, peak_force=f) for s, f in zip(few, forces, strict=True)]),
        ("five shapes, 800 durations up to 20 each, curves made anew", all_),
    ]
    named += [
        (f"each of its own shape: {kind.__name__.replace('_', ' ')}", own[i::5]) for i, kind in enumerate(KINDS[:5])
    ]
    rows = []
    for name, shocks in named:
        share = 100 * np.mean(predictor.predict_many(shocks, CHAIN).method == "moments")
        rows.append(f"| {name} | {len(shocks)} | {share:.0f} | {1 / timed(predictor, shocks, 1e-2, False):.1f} |")
    return rows


def write_table(page: Path, name: str, rows: list[str]) -> None:
    """Write the rows of a table into a page."""
    text, body = page.read_text(encoding="utf-8"), "".join(row + "\n" for row in rows)
    pattern = rf"(<!-- table: {name} -->\n.*\n\|---.*\n)(?:\|.*\n)*"
    page.write_text(re.sub(pattern, lambda match: match[1] + body, text), encoding="utf-8")


def main() -> None:
    """Validate the model, print the tables, and write them into the page."""
    for name, rows in {"auto": accuracy(drawn(SEED, COUNT)), "auto: many": throughput()}.items():
        print(name, *rows, sep="\n")
        write_table(PAGE, name, rows)


if __name__ == "__main__":
    main()
