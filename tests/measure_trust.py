"""Errors of section 4 against simulation for random shocks that meet the conditions (3).

    python tests/measure_trust.py --seed 33 --count 1000

prints, for each regime, how many errors lie in the range that the outcome told. The draws are seeded.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator

import numpy as np

import shockwave as sw
from scenes import CHAIN, FORCE, UNITS


def draws(seed: int) -> Iterator[sw.Shock]:
    """Random shocks without end: power laws, exponentials and tables that meet (3), 0.003 to 25 T0 long."""
    rng = np.random.default_rng(seed)
    while True:
        kind, ratio = rng.choice(["power", "exponential", "table"]), 1 + 10 ** rng.uniform(-0.5, 1.5)
        profile: sw.ShockProfile
        if kind == "power":
            profile = sw.PowerLaw(
                rise_exponent=float(rng.choice([1e-5, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0])),
                decay_exponent=float(rng.choice([1, 1.5, 2, 3, 5, 8])),
                duration_ratio=ratio,
            )
        elif kind == "exponential":
            rates = rng.uniform(0, 8, size=2)
            profile = sw.Exponential(rise_rate=rates[0], decay_rate=rates[1], duration_ratio=ratio)
        else:
            profile = _table(rng, ratio)
        shock = sw.Shock(profile=profile, peak_force=FORCE, rise_time=10 ** rng.uniform(-2.5, 1.4) / ratio * UNITS.time)
        if all(condition.holds for condition in sw.Predictor().predict(shock, CHAIN).conditions):
            yield shock


def _table(rng: np.random.Generator, ratio: float) -> sw.Tabulated:
    times = np.array([0.0, 0.0])
    while np.min(np.diff(times)) < 1e-3:
        times = np.concatenate(([0], np.sort(rng.uniform(0, 1, 3)), [1], np.sort(rng.uniform(1, ratio, 4)), [ratio]))
    rise, decay = np.sort(rng.uniform(0, 1, 3)), np.sort(rng.uniform(0, 1, 4))[::-1]
    return sw.Tabulated(times=times, forces=np.concatenate(([0], rise, [1], decay, [0])))


def judge(shock: sw.Shock) -> tuple[str, str, float]:
    """Regime, whether the error lay ``in`` or ``out`` of the range told (or none was), and the error."""
    found = sw.compare(shock, CHAIN, rtol=1e-3)
    bounds, slack = found.predicted.expected_error, found.simulated.error_estimate
    if bounds is None:
        return found.predicted.regime, "not told", found.error
    inside = bounds[0] - slack <= found.error <= bounds[1] + slack
    return found.predicted.regime, "in" if inside else "out", found.error


def main() -> None:
    """Print the tally."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=33)
    parser.add_argument("--count", type=int, default=1000)
    options = parser.parse_args()
    tally: Counter[tuple[str, str]] = Counter()
    for _, shock in zip(range(options.count), draws(options.seed), strict=False):
        regime, standing, _ = judge(shock)
        tally[regime, standing] += 1
    for (regime, standing), number in sorted(tally.items()):
        print(f"{regime:10} {standing:10} {number}")


if __name__ == "__main__":
    main()
