"""Measure how often the stated accuracies hold, for random shocks of many kinds.

    python docs/check_accuracy.py

draws shocks of each kind with a seed, predicts and simulates them, and writes two tables into ``docs/trust.md``: the
share of shocks whose simulated peak force lies in the range of the estimate, and whose error lies in the expected error
of section 4. It takes about ten minutes; ``--count`` changes the number of shocks of each kind.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from attrs import frozen
from numpy.typing import NDArray
from scipy.special import erfc, erfcx

import shockwave as sw
from shockwave.chain import Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.prediction.model_interface import ScaledShock
from shockwave.prediction.shock_measures import pulse_of, turns

Array = NDArray[np.float64]
Draw = np.random.Generator
Samples = tuple[Array, Array]

PAGE = Path(__file__).parent / "trust.md"
CHAIN = sw.Chain(material=sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0), radius=4.75e-3)
FORCE = 100.0
TIME = Scales.of(CHAIN, FORCE).time
SEED = 71
COUNT = 500
# Range of the durations in T0, of shocks with one peak and with several, whose waves separate slowly.
DURATIONS = (1e-3, 300.0)
DURATIONS_TURNING = (1e-3, 20.0)
# Requested relative error of the simulations, and the largest error estimate of one that is used.
RTOL = 1e-7
MOST_DOUBT = 1e-3
# Samples of a smooth record.
SAMPLES = 400
# Bands of the spread, with the target for the median width of the range.
BANDS = ((0.0, 0.45, 0.02), (0.45, 2.5, 0.08), (2.5, np.inf, 0.2))


# ---------------------------------------------------------------- kinds of shocks: samples of time and force


def twin_haversines(draw: Draw) -> Samples:
    """Two humps sin^2 with a gap of up to a third of the duration, in either order."""
    gap, low, (first, second) = draw.uniform(0, 0.6), draw.uniform(0.3, 1), draw.uniform(0.5, 1.5, 2)
    t = np.linspace(0, first + gap + second, SAMPLES)
    f = np.where(t < first, np.sin(np.pi * t / first) ** 2, 0)
    f += np.where(t > first + gap, low * np.sin(np.pi * (t - first - gap) / second) ** 2, 0)
    return t, f[::-1] if draw.random() < 0.5 else f


def humps_with_gaps(draw: Draw) -> Samples:
    """Two to four humps of different heights and shapes with gaps between them."""
    times, forces, share = [0.0], [0.0], np.linspace(0, 1, 60)[1:]
    for _ in range(draw.integers(2, 5)):
        width, height = draw.uniform(0.3, 1.5), draw.uniform(0.2, 1)
        hump = height * np.sin(np.pi * share) ** draw.uniform(0.7, 3)
        times += (times[-1] + width * share).tolist()
        forces += [*hump[:-1].tolist(), 0.0]
        times.append(times[-1] + draw.uniform(0.1, 2))
        forces.append(0.0)
    return np.array(times[:-1]), np.array(forces[:-1])


def modified_gaussian(draw: Draw) -> Samples:
    """A Gaussian convolved with an exponential."""
    rate = 10 ** draw.uniform(-1, 0.7)
    t = np.linspace(-4, 4 + 7 / rate, SAMPLES)
    z = np.maximum((rate - t) / np.sqrt(2), -25)
    f = np.where(z > -5, np.exp(-(t**2) / 2) * erfcx(np.maximum(z, -5)), np.exp(rate**2 / 2 - rate * t) * erfc(z))
    f = np.maximum(f - np.linspace(f[0], f[-1], SAMPLES), 0)
    return t - t[0], f[::-1] if draw.random() < 0.3 else f


def convex_decay(draw: Draw) -> Samples:
    """A power-law rise and a steep, convex decay."""
    n, power = 10 ** draw.uniform(0.2, 1.3), draw.uniform(1, 8)
    rise = np.linspace(0, 1, 60)
    decay = 1 + (n - 1) * np.linspace(0, 1, SAMPLES - 60)[1:] ** 1.7
    forces = rise ** draw.uniform(0.3, 2), ((n - decay) / (n - 1)) ** power
    return np.concatenate([rise, decay]), np.concatenate(forces)


def needle_with_tail(draw: Draw) -> Samples:
    """A narrow triangle on a long, low tail, or the reverse in time."""
    width, height = draw.uniform(0.02, 0.3), draw.uniform(0.1, 0.6)
    t = np.concatenate([np.linspace(0, width, 80), width + (1 - width) * np.linspace(0, 1, SAMPLES - 80)[1:]])
    tail = height * np.maximum(1 - t, 0) ** draw.uniform(0.5, 3) * np.minimum(2 * t / width, 1)
    f = tail + (1 - height) * np.maximum(1 - np.abs(2 * t / width - 1), 0)
    return ((1 - t)[::-1], f[::-1]) if draw.random() < 0.5 else (t, f)


def twin_triangles(draw: Draw) -> Samples:
    """Two triangles with a gap between them, in either order."""
    gap, lean, (first, second) = draw.uniform(0.02, 1.5), draw.uniform(0.05, 0.95, 2), draw.uniform(0.3, 1.5, 2)
    t = np.array([0, lean[0] * first, first, first + gap, first + gap + lean[1] * second, first + gap + second])
    f = np.array([0, 1, 0, 0, draw.uniform(0.3, 1), 0])
    return (t[-1] - t[::-1], f[::-1]) if draw.random() < 0.5 else (t, f)


def staircase(draw: Draw) -> Samples:
    """Three to eight plateaus of any heights, with short ramps between them."""
    count = draw.integers(3, 9)
    widths = np.stack([np.full(count, 0.03), draw.uniform(0.1, 1, count)]).T.ravel()
    heights = np.repeat(draw.uniform(0.1, 1, count), 2)
    return np.concatenate([[0], np.cumsum([*widths, 0.03])]), np.concatenate([[0], heights, [0]])


def half_sine(draw: Draw) -> Samples:
    """A power of a half sine."""
    t = np.linspace(0, 1, SAMPLES)
    return t, np.sin(np.pi * t) ** draw.uniform(0.7, 2.5)


def trapezoid(draw: Draw) -> Samples:
    """A plateau between two ramps."""
    rise, fall = draw.uniform(0.02, 0.45, 2)
    return np.array([0, rise, 1 - fall, 1]), np.array([0.0, 1, 1, 0])


def random_table(draw: Draw) -> Samples:
    """Three to eleven random samples."""
    count = draw.integers(3, 12)
    t = np.concatenate([[0], np.sort(draw.uniform(0, 1, count)), [1]]) + 1e-3 * np.arange(count + 2)
    return t, np.concatenate([[0], draw.uniform(0, 1, count), [0]])


def noisy_record(draw: Draw) -> Samples:
    """A half sine with noise, as measured."""
    t, f = half_sine(draw)
    noise = np.convolve(draw.normal(size=SAMPLES), np.ones(9) / 9, "same")
    return t, f + 0.15 * noise * np.sqrt(np.maximum(f, 0))


def few_and_many_samples(draw: Draw) -> Samples:
    """A triangle sampled densely in one part and by two samples in the other."""
    n, count = 1 + 10 ** draw.uniform(-1, 1), int(draw.integers(10, 200))
    counts = (count, 2) if draw.random() < 0.5 else (2, count)
    t = np.concatenate([np.linspace(0, 1, counts[0]), np.linspace(1, n, counts[1])[1:]])
    return t, np.interp(t, [0, 1, n], [0, 1, 0])


KINDS: tuple[Callable[[Draw], Samples], ...] = (
    twin_haversines,
    humps_with_gaps,
    twin_triangles,
    staircase,
    random_table,
    modified_gaussian,
    convex_decay,
    needle_with_tail,
    half_sine,
    trapezoid,
    noisy_record,
    few_and_many_samples,
)


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


def shots(kind: Callable[[Draw], Samples], count: int) -> list[Shot]:
    """Draw, predict and simulate shocks of a kind; those that simulation does not resolve are left out."""
    draw = np.random.default_rng([SEED, KINDS.index(kind)])
    shocks = []
    for _ in range(count):
        t, f = kind(draw)
        f = np.clip(f, 0, None)
        f[[0, -1]] = 0
        profile = sw.Tabulated(times=t, forces=f)
        low, high = np.log(DURATIONS_TURNING if turns(profile) else DURATIONS)
        duration = float(np.exp(draw.uniform(low, high))) * TIME
        shocks.append(sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=duration))
    found = []
    for shock, result in zip(shocks, sw.simulate_many(shocks, CHAIN, rtol=RTOL, waves="primary"), strict=True):
        if isinstance(result, sw.SimulationResult) and result.error_estimate <= MOST_DOUBT:
            scaled = ScaledShock(shock.profile, shock.profile.areas(), shock.rise_time / TIME, MOMENTUM)
            outcome = sw.Predictor().predict(shock, CHAIN)
            found.append(Shot(outcome, pulse_of(scaled).spread, result.peak_force, result.error_estimate))
    return found


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
    every: list[Shot] = []
    rows = []
    for kind in KINDS:
        found = shots(kind, count)
        every += found
        rows.append(row_of(kind.__name__, found))
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
