"""Random shocks of many kinds, as records of force over time in units of their duration and peak force.

Shared by the scripts that measure how often an accuracy holds. ``draw(kind, number)`` gives the same shock on every
machine.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfcx

Array = NDArray[np.float64]
Draw = np.random.Generator
Record = tuple[Array, Array]

SAMPLES = 400
# Samples nearer than this, in durations, are one.
NEAREST = 1e-9


def _reversed(draw: Draw, times: Array, forces: Array) -> Record:
    """The record, or half the time the same backwards."""
    return (times, forces) if draw.random() < 0.5 else (times[-1] - times[::-1], forces[::-1])


def twin_sin2(draw: Draw) -> Record:
    """Two sine-squared humps, apart by up to half their widths or touching."""
    gap, low, first, second = draw.uniform(0, 0.6), draw.uniform(0.3, 1), *draw.uniform(0.5, 1.5, 2)
    times = np.linspace(0, first + gap + second, SAMPLES)
    humps = np.where(times < first, np.sin(np.pi * times / first) ** 2, 0)
    humps += np.where(times > first + gap, low * np.sin(np.pi * (times - first - gap) / second) ** 2, 0)
    return _reversed(draw, times, humps)


def humps_gaps(draw: Draw) -> Record:
    """Two to four humps of any heights and widths, with gaps between them."""
    times, forces = [np.zeros(1)], [np.zeros(1)]
    for _ in range(draw.integers(2, 5)):
        share = np.linspace(0, 1, 60)[1:]
        begin = times[-1][-1] + (draw.uniform(0.1, 2) if len(times) > 1 else 0.0)
        hump = draw.uniform(0.2, 1) * np.sin(np.pi * share) ** draw.uniform(0.7, 3)
        times += [np.array([begin]) if len(times) > 1 else np.zeros(0), begin + draw.uniform(0.3, 1.5) * share]
        forces += [np.zeros(len(times[-2])), np.append(hump[:-1], 0.0)]
    return np.concatenate(times), np.concatenate(forces)


def modified_gaussian(draw: Draw) -> Record:
    """An exponentially modified Gaussian."""
    rate = 10 ** draw.uniform(-1, 0.7)
    times = np.linspace(-4, 4 + 7 / rate, SAMPLES)
    # beyond -5 the scaled error function overflows, and the exponential alone is left
    argument = np.maximum((rate - times) / np.sqrt(2), -5)
    late = (rate - times) / np.sqrt(2) < -5
    forces = np.exp(-(times**2) / 2) * erfcx(argument)
    forces = np.where(late, 2 * np.exp(rate**2 / 2 - rate * np.maximum(times, 0)), forces)
    forces = np.maximum(forces - np.linspace(forces[0], forces[-1], SAMPLES), 0)
    return times, forces


def convex(draw: Draw) -> Record:
    """A short rise and a convex decay."""
    ratio, power, steep = 10 ** draw.uniform(0.2, 1.3), draw.uniform(1, 8), draw.uniform(0.3, 2)
    rise, decay = np.linspace(0, 1, 60), 1 + (ratio - 1) * np.linspace(0, 1, SAMPLES - 60)[1:] ** 1.7
    return np.append(rise, decay), np.append(rise**steep, ((ratio - decay) / (ratio - 1)) ** power)


def needle_tail(draw: Draw) -> Record:
    """A needle with a tail, or led by one."""
    width, height, power = draw.uniform(0.02, 0.3), draw.uniform(0.1, 0.6), draw.uniform(0.5, 3)
    times = np.append(np.linspace(0, width, 80), width + (1 - width) * np.linspace(0, 1, SAMPLES - 80)[1:])
    forces = height * (1 - times) ** power * np.minimum(times / (width / 2), 1)
    return _reversed(draw, times, forces + (1 - height) * np.maximum(1 - np.abs(2 * times / width - 1), 0))


def twin_triangles(draw: Draw) -> Record:
    """Two triangles, apart or touching."""
    gap, low, lean, width = draw.uniform(0.05, 1.5), draw.uniform(0.3, 1), *draw.uniform(0.05, 0.95, (2, 2))
    width += 0.3
    begin = width[0] + gap
    times = np.array([0, lean[0] * width[0], width[0], begin, begin + lean[1] * width[1], begin + width[1]])
    return _reversed(draw, times, np.array([0, 1, 0, 0, low, 0]))


def staircase(draw: Draw) -> Record:
    """Three to eight plateaus."""
    count = draw.integers(3, 9)
    ends = np.cumsum(np.column_stack((np.full(count, 0.03), draw.uniform(0.1, 1, count))).ravel())
    forces = np.repeat(draw.uniform(0.1, 1, count), 2)
    return np.concatenate(([0], ends, [ends[-1] + 0.03])), np.concatenate(([0], forces, [0]))


def power(draw: Draw) -> Record:
    """A power law, with samples that are denser towards its ends."""
    ratio, (rise, decay) = 1 + 10 ** draw.uniform(-1, 1.2), 10 ** draw.uniform(-0.7, 0.7, 2)
    share = np.linspace(0, 1, SAMPLES // 2)
    times = np.append(share**2, 1 + (ratio - 1) * (1 - (1 - share[1:]) ** 2))
    return times, np.append(share ** (2 * rise), (1 - share[1:]) ** (2 * decay))


def half_sine(draw: Draw) -> Record:
    """A half-sine to some power."""
    times = np.linspace(0, 1, SAMPLES)
    return times, np.append(np.sin(np.pi * times[:-1]) ** draw.uniform(0.7, 2.5), 0.0)


def trapezoid(draw: Draw) -> Record:
    """A trapezoid."""
    rise, fall = draw.uniform(0.02, 0.45, 2)
    return np.array([0, rise, 1 - fall, 1]), np.array([0.0, 1, 1, 0])


def random_table(draw: Draw) -> Record:
    """A record of three to eleven random samples."""
    count = draw.integers(3, 12)
    times = np.concatenate(([0], np.sort(draw.uniform(0, 1, count)), [1])) + 1e-3 * np.arange(count + 2)
    return times, np.concatenate(([0], draw.uniform(0, 1, count), [0]))


def noisy(draw: Draw) -> Record:
    """A half-sine with noise."""
    times, forces = half_sine(draw)
    noise = np.convolve(draw.normal(size=SAMPLES), np.ones(9) / 9, "same")
    return times, np.maximum(forces + 0.15 * noise * np.sqrt(forces), 0)


def double_exponential(draw: Draw) -> Record:
    """A difference of two exponentials, with a weaker echo."""
    times = np.linspace(0, 1, SAMPLES)
    forces = np.exp(-draw.uniform(3, 12) * times) - np.exp(-draw.uniform(15, 80) * times)
    echo = np.roll(forces, int(draw.uniform(0.1, 0.6) * SAMPLES)) * (times > 0.1)
    forces = np.maximum(forces + draw.uniform() * echo, 0)
    return times, np.append(forces[:-1], 0.0)


# ---------------------------------------------------------------- kinds that try to mislead the law of moments


def precursor(draw: Draw) -> Record:
    """A weak pulse shortly before the main one."""
    gap, low, width = draw.uniform(0.01, 0.6), draw.uniform(0.06, 0.6), draw.uniform(0.05, 0.3)
    begin = width + gap
    return np.array([0, width / 2, width, begin, begin + 0.3, begin + 0.6]), np.array([0, low, 0, 0, 1, 0])


def short_blow(draw: Draw) -> Record:
    """A short blow with a faint tail of up to two hundred times its duration."""
    blow, peak, low = 10 ** draw.uniform(-2.3, -1.3), draw.uniform(0.1, 0.9), 10 ** draw.uniform(-6, -3)
    return np.array([0, peak * blow, blow, 1]), np.array([0, 1, low, 0])


def needle_faint_tail(draw: Draw) -> Record:
    """A needle with a long, weak tail."""
    width, low, power = 10 ** draw.uniform(-3.5, -1.5), 10 ** draw.uniform(-3, -1.5), draw.uniform(1, 3)
    share = np.linspace(0, 1, 60)[1:]
    times = np.concatenate(([0, width / 2, width], width + (1 - width) * share))
    return times, np.concatenate(([0, 1, low], low * (1 - share) ** power))


def needle_humps(draw: Draw) -> Record:
    """A needle of small impulse, and two weak humps later."""
    width, low = 10 ** draw.uniform(-4, -2), draw.uniform(0.02, 0.06, 2)
    times = np.array([0, width / 2, width, 0.2, *np.cumsum(draw.uniform(0.1, 0.4, 5)) + 0.2])
    return times, np.array([0, 1, 0, 0, low[0], 0, 0, low[1], 0])


KINDS: tuple[Callable[[Draw], Record], ...] = (
    twin_sin2,
    humps_gaps,
    modified_gaussian,
    convex,
    needle_tail,
    twin_triangles,
    staircase,
    power,
    half_sine,
    trapezoid,
    random_table,
    noisy,
    double_exponential,
)
#: Further kinds, with the range of their durations in T0.
MISLEADING: dict[Callable[[Draw], Record], tuple[float, float]] = {
    precursor: (1.0, 6.0),
    short_blow: (80.0, 200.0),
    needle_faint_tail: (10.0, 100.0),
    needle_humps: (1.0, 20.0),
}


def draw(kind: Callable[[Draw], Record], number: int, seed: int, shortest: float, longest: float) -> Record:
    """Shock ``number`` of a kind, of peak force 1; its duration is log-uniform between the bounds."""
    generator = np.random.default_rng([seed, number, (*KINDS, *MISLEADING).index(kind)])
    times, forces = kind(generator)
    kept = np.append(True, np.diff(times) > NEAREST * times[-1])
    times, forces = times[kept] - times[0], forces[kept]
    forces[[0, -1]] = 0.0  # as all of them mean to be
    duration = float(np.exp(generator.uniform(np.log(shortest), np.log(longest))))
    return times / times[-1] * duration, forces / forces.max()
