"""The short form of the law of moments: draws pulses, simulates them, fits the coefficients, and judges them on others.

    python docs/fit_short.py

makes, in ten seconds or so, ``shockwave/theory/short.json`` and a table of ``docs/auto.md``. The kinds of pulses are
those of ``fit_moments.py``, which stands beside it; half of those judged are of kinds that had no part in the fit.
"""

from __future__ import annotations

import json
import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
from attrs import evolve
from fit_moments import CHAIN, FORCE, NEW, OLD, SCALES, Array

import shockwave as sw
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.theory import short
from shockwave.theory.measures import measures
from shockwave.theory.scaled import ScaledShock

PAGE = Path(__file__).parent / "auto.md"
FILE = Path(sw.__file__).parent / "theory" / short.RESOURCE

SEED, COUNT, RTOL, MOST_DOUBT = 6201, 4000, 1e-7, 1e-5
# Of x: beyond, one number no longer orders the errors; below, the error is nothing.
LEAST, FARTHEST = 1e-3, 0.25
# Which error a pulse may have in the fit, at the least and over x^(3/2).
ALLOWED, SHARE = 2e-5, 0.05
# The error told: this quantile of the sizes over x^(3/2) of pulses with x above a small one, widened.
QUANTILE, WIDENED = 0.995, 1.25
BANDS = (1e-3, 5e-3, 0.015, 0.03, 0.06, 0.12, 0.25)


def sample(seed: int, count: int, old: bool) -> tuple[Array, ...]:
    """x, g, ln of the impulse limit over the simulated peak, and tau, of random pulses, x even in its logarithm."""
    draw, kinds = np.random.default_rng(seed), OLD if old else NEW
    known, pulses = [], []
    while len(pulses) < count:
        try:
            profile = kinds[len(pulses) % len(kinds)](draw)
        except sw.InvalidValueError:  # noise may leave no pulse
            continue
        areas = profile.areas()
        (correction, skewness), x = (
            short.integrals([profile], [areas.total])[0],
            draw.uniform(*np.log([LEAST, FARTHEST])),
        )
        if math.isnan(correction):
            continue
        ratio = math.cbrt(math.exp(x) / short.CORRECTION / correction)
        measured = measures(ScaledShock(profile, areas, ratio, MOMENTUM))
        spread = math.nan if measured is None else measured.spread
        known.append((math.exp(x), float(skewness), areas.total * ratio / MOMENTUM, spread))
        pulses.append(sw.Shock(profile=profile, peak_force=FORCE, rise_time=ratio * SCALES.time))
    results = sw.simulate_many(pulses, CHAIN, rtol=RTOL, waves="primary")
    rows = [
        (x, skewness, math.log(IMPULSE_LIMIT * strength**1.2 / result.amplification), spread)
        for (x, skewness, strength, spread), result in zip(known, results, strict=True)
        if isinstance(result, sw.SimulationResult) and result.error_estimate < MOST_DOUBT
    ]
    return tuple(np.array(rows).T)


def fitted(x: Array, g: Array, missing: Array) -> short.ShortLaw:
    """Coefficients by weighted least squares, and the error that they leave."""
    columns, target = np.stack([x, x * g, x * g * g], axis=1), x / missing - 1
    weight = missing**2 / x / (ALLOWED + SHARE * x**1.5)
    coefficients = np.linalg.lstsq(columns * weight[:, None], target * weight, rcond=None)[0]
    law = short.ShortLaw(np.round(coefficients, 4), 0.0, FARTHEST)
    size = errors(law, x, g, missing) / x**1.5
    return evolve(law, error=round(WIDENED * float(np.quantile(size, QUANTILE)), 3))


def errors(law: short.ShortLaw, x: Array, g: Array, missing: Array) -> Array:
    """Relative, their size."""
    return np.abs(np.expm1(missing - x / law.slope(x, g)))


def table(law: short.ShortLaw) -> list[str]:
    """Errors on pulses that the fit has not seen, by x."""
    kinds = [sample(SEED + 1, COUNT // 2, old=True), sample(SEED + 2, COUNT // 2, old=False)]
    x, g, missing, spread = np.concatenate(kinds, axis=1)
    size, old = errors(law, x, g, missing), np.arange(len(x)) < len(kinds[0][0])
    held, rows = size <= law.bound(x) + 2 * RTOL, []
    for low, high in pairwise(BANDS):
        here = (x >= low) & (x < high)
        parts = " | ".join(f"{100 * np.quantile(size[here & which], 0.99):.3f}" for which in (old, ~old))
        figures = f"{100 * size[here].max():.3f} | {100 * float(law.bound(np.array(high))):.3f}"
        counts = f"{np.nanmedian(spread[here]):.2f} | {here.sum()}"
        rows.append(f"| {low:g} to {high:g} | {counts} | {parts} | {figures} | {100 * held[here].mean():.1f} |")
    return rows


def main() -> None:
    """Make everything, and print the judgement."""
    x, g, missing, _ = sample(SEED, COUNT, old=True)
    law = fitted(x, g, missing)
    entries = {
        "about": "the short form of the law of moments of shockwave.theory.short; docs/auto.md tells what it is",
        "provenance": {
            "command": "python docs/fit_short.py",
            "shockwave": sw.__version__,
            "seed": SEED,
            "pulses": len(x),
            "rtol": RTOL,
        },
        "law": {"coefficients": law.coefficients.tolist(), "error": law.error, "farthest": law.farthest},
    }
    FILE.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
    rows = table(law)
    if PAGE.exists():
        text = PAGE.read_text(encoding="utf-8")
        pattern = r"(<!-- table: short form -->\n.*\n\|---.*\n)(?:\|.*\n)*"
        PAGE.write_text(re.sub(pattern, lambda m: m[1] + "".join(row + "\n" for row in rows), text), encoding="utf-8")
    print(entries["law"], *rows, sep="\n")


if __name__ == "__main__":
    main()
