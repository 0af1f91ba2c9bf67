"""Fit the short form of the law of moments to simulated pulses, and validate it on other pulses.

    python docs/fit_short.py

writes, in about fifteen seconds, ``shockwave/prediction/short_shock_law.json`` and two tables of ``docs/auto.md``. The
common kinds of pulses are those of ``fit_moments.py`` in the same folder; half of those of the validation are of kinds
that are not used in the fit. The kinds with long tails in this file determine the error bound.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from attrs import evolve
from fit_moments import CHAIN, FORCE, NEW, OLD, SCALES, Array, Draw
from judge_auto import write_table

import shockwave as sw
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.prediction import short_shock_law as short
from shockwave.prediction.model_interface import ScaledShock
from shockwave.prediction.shock_impulses import pulse_of

PAGE = Path(__file__).parent / "auto.md"
FILE = Path(sw.__file__).parent / "prediction" / short.RESOURCE

# Seed and number of the pulses.
SEED = 6201
COUNT = 4000
# Requested relative error of the simulations, and largest error estimate of one that is used.
RTOL = 1e-7
MOST_DOUBT = 1e-5
# Range of x: the error is negligible below it, and is not ordered by x alone above it.
LEAST = 1e-3
FARTHEST = 0.25
# Error of a pulse that has the weight one in the fit: a constant, and a factor of x^(3/2).
ALLOWED = 2e-5
SHARE = 0.05
# The error bound is this quantile of the errors over x^(3/2) and the root of the kurtosis, for the kinds with long
# tails.
QUANTILE = 0.999
# Ends of the bands of x in the table.
BANDS = (1e-3, 5e-3, 0.015, 0.03, 0.06, 0.12, 0.25)


# ---------------------------------------------------------------- kinds with long tails


def needle(draw: Draw) -> sw.ShockProfile:
    """A spike on a low pedestal."""
    low, wide, at = 10 ** draw.uniform(-3, -0.3), 10 ** draw.uniform(-3, -0.5), draw.uniform(0, 1)
    times = [0, wide, at + wide, at + 1.5 * wide, at + 2 * wide, 1 + 3 * wide, 1 + 4 * wide]
    return sw.Tabulated(times=times, forces=[0, low, low, 1, low, low, 0])


def weak_hump(draw: Draw) -> sw.ShockProfile:
    """A triangle with a weaker one long before or after it."""
    gap, weak = 1 + 10 ** draw.uniform(-0.5, 2), 10 ** draw.uniform(-2, 0)
    forces = [0, 1, 0, 0, weak, 0]
    rise, fall = draw.uniform(0.2, 3, 2)
    turned = forces[::-1] if draw.random() < 0.5 else forces
    return sw.Tabulated(times=[0, 0.5, 1, gap, gap + rise, gap + rise + fall], forces=turned)


def with_zeros(draw: Draw) -> sw.ShockProfile:
    """Triangles of random height with pauses between them."""
    times, forces = [0.0], [0.0]
    for _ in range(draw.integers(3, 9)):
        wide = 10 ** draw.uniform(-2, 0)
        times += [times[-1] + wide, times[-1] + 2 * wide]
        forces += [10 ** draw.uniform(-2, 0), 0]
        if draw.random() < 0.7:
            times.append(times[-1] + 10 ** draw.uniform(-2, 0.5))
            forces.append(0)
    return sw.Tabulated(times=times, forces=forces)


FAR = (needle, weak_hump, with_zeros)


def sample(seed: int, count: int, kinds: Sequence[Callable[[Draw], sw.ShockProfile]]) -> tuple[Array, ...]:
    """x, g, h, ln of the impulse limit over the simulated peak force, and tau of random pulses, log-uniform in x."""
    draw = np.random.default_rng(seed)
    known, pulses = [], []
    while len(pulses) < count:
        try:
            profile = kinds[len(pulses) % len(kinds)](draw)
        except sw.InvalidValueError:  # because of the noise there may be no pulse
            continue
        areas = profile.areas()
        correction, skewness, tails = short.integrals([profile], [areas.total])[0].tolist()
        x = draw.uniform(*np.log([LEAST, FARTHEST]))
        if math.isnan(correction):
            continue
        ratio = math.cbrt(math.exp(x) / short.CORRECTION / correction)
        spread = pulse_of(ScaledShock(profile, areas, ratio, MOMENTUM)).spread
        known.append((math.exp(x), skewness, tails, areas.total * ratio / MOMENTUM, spread))
        pulses.append(sw.Shock(profile=profile, peak_force=FORCE, rise_time=ratio * SCALES.time))
    results = sw.simulate_many(pulses, CHAIN, rtol=RTOL, waves="primary")
    rows = [
        (x, skewness, tails, math.log(short.IMPULSE_LIMIT * strength**1.2 / result.amplification), spread)
        for (x, skewness, tails, strength, spread), result in zip(known, results, strict=True)
        if isinstance(result, sw.SimulationResult) and result.error_estimate < MOST_DOUBT
    ]
    return tuple(np.array(rows).T)


def fitted() -> tuple[short.ShortLaw, int]:
    """Fit the coefficients by weighted least squares and the bound by the kinds with long tails; number of pulses."""
    x, g, _, missing, _ = sample(SEED, COUNT, OLD)
    columns, target = np.stack([x, x * g, x * g * g], axis=1), x / missing - 1
    weight = missing**2 / x / (ALLOWED + SHARE * x**1.5)
    coefficients = np.linalg.lstsq(columns * weight[:, None], target * weight, rcond=None)[0]
    law = short.ShortLaw(np.round(coefficients, 4), 0.0, FARTHEST)
    far, g, tails, missing, _ = sample(SEED + 3, COUNT // 2, FAR)
    size = errors(law, far, g, missing) / far**1.5 / np.sqrt(tails)
    return evolve(law, error=math.ceil(100 * float(np.quantile(size, QUANTILE))) / 100), len(x) + len(far)


def errors(law: short.ShortLaw, x: Array, g: Array, missing: Array) -> Array:
    """Magnitudes of the relative errors."""
    return np.abs(np.expm1(missing - x / law.slope(x, g)))


def tables(law: short.ShortLaw) -> dict[str, list[str]]:
    """Rows of the tables of the page: errors of other pulses, by x and by kind."""
    samples = [sample(SEED + 1 + i, COUNT // 2, kinds) for i, kinds in enumerate((OLD, NEW))]
    samples += [sample(SEED + 4 + i, COUNT // 4, [kind]) for i, kind in enumerate(FAR)]
    x, g, tails, missing, spread = np.concatenate(samples, axis=1)
    of = np.repeat(np.arange(len(samples)), [len(each[0]) for each in samples])
    size = errors(law, x, g, missing)
    held, common = size <= law.bound(x, tails) + 2 * RTOL, of < 2
    by_x, by_kind = [], []
    for low, high in pairwise(BANDS):
        here = common & (x >= low) & (x < high)
        parts = " | ".join(f"{100 * np.quantile(size[here & (of == which)], 0.99):.3f}" for which in (0, 1))
        bound = float(np.median(law.bound(x, tails)[here]))
        figures = f"{100 * size[here].max():.3f} | {100 * bound:.3f}"
        counts = f"{np.nanmedian(spread[here]):.2f} | {here.sum()}"
        by_x.append(f"| {low:g} to {high:g} | {counts} | {parts} | {figures} | {100 * held[here].mean():.1f} |")
    names = ("kinds of the fit", "new kinds", "spike on a pedestal", "hump and a weak one", "triangles with pauses")
    for which, name in enumerate(names):
        own = of == which
        share = size[own] / law.bound(x, tails)[own]
        figures = f"{np.median(tails[own]):.1f} | {tails[own].max():.1f} | {share.max():.2f}"
        by_kind.append(f"| {name} | {own.sum()} | {figures} | {100 * held[own].mean():.1f} |")
    return {"short form": by_x, "short form by kind": by_kind}


def main() -> None:
    """Fit and validate the law, write all files, and print the tables."""
    law, count = fitted()
    entries = {
        "about": "short form of the law of moments (shockwave.prediction.short_shock_law), described in docs/auto.md",
        "provenance": {
            "command": "python docs/fit_short.py",
            "shockwave": sw.__version__,
            "seed": SEED,
            "pulses": count,
            "rtol": RTOL,
        },
        "law": {"coefficients": law.coefficients.tolist(), "error": law.error, "farthest": law.farthest},
    }
    FILE.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
    for name, rows in tables(law).items():
        print(name, *rows, sep="\n")
        write_table(PAGE, name, rows)


if __name__ == "__main__":
    main()
