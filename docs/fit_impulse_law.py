"""Compute the impulse limits of chains with any exponent of the contact force, and measure the range of short shocks.

    python docs/fit_impulse_law.py

writes, in about half a minute, ``shockwave/prediction/impulse_law.json`` and a table of ``docs/chains.md``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from judge_auto import write_table
from numpy.polynomial import chebyshev
from shock_kinds import ALL, draw

import shockwave as sw
from shockwave.chain import Scales
from shockwave.chain.features import WAVE_EXPONENTS
from shockwave.chain.solitary_wave import wave_law
from shockwave.prediction.impulse_law import RESOURCE, ImpulseLaw

PAGE = Path(__file__).parent / "chains.md"
FILE = Path(sw.__file__).parent / "prediction" / RESOURCE
STEEL = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
# Number of exponents and of coefficients, and duration over the characteristic time of the wave: the peak force is that
# of a vanishing duration but for its power p + 1.
NODES, TERMS, SHORT = 32, 24, 1e-5
# The range of ln F over (sigma/T)^2, with a margin of some per cent, and the largest sigma/T.
DECREASE, FARTHEST = 0.47, 1.0
SEED, COUNT, SHORTEST, LONGEST, RTOL = 1806, 6, 0.03, 1.0, 1e-5
EXPONENTS = (1.05, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 6.0)
BANDS = (0.03, 0.1, 0.2, 0.3, 0.45, 0.7, 1.0)


def chain_of(exponent: float) -> sw.Chain:
    """A chain with this exponent."""
    return sw.Chain(material=STEEL, radius=4.75e-3, contact=sw.PowerContact(exponent=exponent, stiffness=1e10))


def limit_of(exponent: float) -> float:
    """I_p, from the simulation of a very short shock with the impulse of a wave of 1 N."""
    chain, wave = chain_of(exponent), wave_law(exponent)
    scales = Scales.of(chain, 1.0)
    profile = sw.Triangular(duration_ratio=2)
    shock = sw.Shock(profile=profile, peak_force=2 * wave.momentum / SHORT, rise_time=SHORT / 2 * scales.time)
    return float(sw.simulate(shock, chain, rtol=1e-11).peak_force)


def coefficients() -> list[float]:
    """Chebyshev coefficients of ln(I_p - 1) in ln(p - 1)."""
    low, high = (math.log(end - 1) for end in WAVE_EXPONENTS)
    places = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    exponents = 1 + np.exp((low + high + places * (high - low)) / 2)
    values = [math.log(limit_of(float(exponent)) - 1) for exponent in exponents]
    return list(map(float, chebyshev.chebfit(places, values, TERMS - 1)))


def sample(law: ImpulseLaw) -> Iterator[tuple[float, float, float]]:
    """Exponent, sigma/T, and the decrease of ln F over its square, of shocks of all kinds."""
    generator = np.random.default_rng(SEED)
    for exponent in EXPONENTS:
        chain, wave = chain_of(exponent), wave_law(exponent)
        time = Scales.of(chain, 1.0).time  # of the limit, which is 1 N
        impulse = wave.momentum * law.limit(exponent) ** -wave.of_momentum * time
        shocks, ratios = [], []
        for kind in ALL:
            for number in range(COUNT):
                times, forces = draw(kind, number, SEED, 1.0, 1.0)
                weights = np.diff(times) / 2
                whole = float(np.dot(weights, forces[1:] + forces[:-1]))
                fine = np.linspace(0, times[-1], 4001)
                force = np.interp(fine, times, forces)
                mean = float(np.dot(fine, force) / force.sum())
                deviation = math.sqrt(float(np.dot((fine - mean) ** 2, force) / force.sum()))
                ratio = math.exp(generator.uniform(math.log(SHORTEST), math.log(LONGEST)))
                unit = ratio * time / deviation
                profile = sw.Tabulated(times=(times * unit).tolist(), forces=(forces * impulse / whole / unit).tolist())
                shocks.append(sw.Shock(profile=profile))
                ratios.append(ratio)
        for ratio, result in zip(ratios, sw.simulate_many(shocks, chain, rtol=RTOL, waves="primary"), strict=True):
            if not isinstance(result, sw.ShockwaveError):
                yield exponent, ratio, -math.log(result.peak_force) / ratio**2


def rows(found: np.ndarray) -> Iterator[str]:
    """Rows of the table: shocks by sigma/T."""
    for low, high in pairwise(BANDS):
        part = found[(found[:, 1] >= low) & (found[:, 1] < high)]
        held = (part[:, 2] <= DECREASE) & (part[:, 2] * part[:, 1] ** 2 >= -3 * RTOL)
        width = math.expm1(DECREASE * high**2)
        ends = f"{round(part[:, 2].min(), 3) + 0.0:.3f} | {part[:, 2].max():.3f}"
        figures = f"{ends} | {100 * held.mean():.1f} % | {100 * width:.1f} %"
        yield f"| {low:g} to {high:g} | {len(part)} | {figures} |"


def main() -> None:
    """Compute and validate the law, and write all files."""
    law = ImpulseLaw(tuple(coefficients()), WAVE_EXPONENTS, DECREASE, FARTHEST)
    found = np.array(list(sample(law)))
    entries = {
        "about": "limits of short shocks (shockwave.prediction.impulse_law), described in docs/chains.md",
        "provenance": {"command": "python docs/fit_impulse_law.py", "shockwave": sw.__version__, "shocks": len(found)},
        "law": {
            "coefficients": law.coefficients,
            "exponents": law.exponents,
            "decrease": law.decrease,
            "farthest": law.farthest,
        },
    }
    FILE.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
    table = list(rows(found))
    print(*table, sep="\n")
    write_table(PAGE, "short shocks", table)
    worst = max(abs(law.limit(p) / limit_of(p) - 1) for p in (1.07, *EXPONENTS))
    print(f"largest error of a limit: {worst:.0e}")


if __name__ == "__main__":
    main()
