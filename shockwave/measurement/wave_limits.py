"""Whether waves are at their limits along the chain: separated, in order, with nothing to come."""

from __future__ import annotations

import math
from itertools import accumulate

import numpy as np

from shockwave.chain.solitary_wave import ENERGY
from shockwave.measurement.peaks import Peak, PeakLog, history
from shockwave.quadrature import FloatArray
from shockwave.simulation.march import free_granules
from shockwave.simulation.problem import contact_forces, overlaps

# Contacts between the peaks whose differences show how fast a wave nears its limit.
_STRIDE = 10
# A wave and the force behind it reach this many granules back.
_BACK = 3
# Waves are followed down to this share of the threshold.
_FOLLOWED = 0.3
# A wave this much taller than one before it will overtake it.
_TALLER = 1.001
# Slower approaches than this, per stride, cannot be distinguished from noise.
_SLOWEST = 0.97


def settling(
    log: PeakLog, now: float, x: FloatArray, v: FloatArray, threshold: float, noise: float = 0.0
) -> tuple[list[tuple[Peak, float]], bool]:
    """Judge the state of the chain after the force has ended.

    Parameters
    ----------
    log : PeakLog
        All peaks up to ``now``.
    x, v : FloatArray
        Positions and velocities at ``now``, shape (granules,).
    threshold : float
        Peak force, over the strongest wave's, above which a wave counts.
    noise : float
        Error of a peak force due to step errors: differences below it are not significant.

    Returns
    -------
    list of (Peak, float)
        The foremost peak of each wave, front first, and a bound on how far it may still be from its limit, relatively;
        infinite for a wave with a collision ahead of it or behind it, or followed by one that may yet outgrow it.
    bool
        Whether nothing behind them can become another wave.
    """
    # Weaker waves are followed too: one may still grow, and its energy is accounted for.
    followed = log.heads(now, _FOLLOWED * threshold)
    if not followed:
        return [], False
    forces = [head.force for head in followed]
    least = threshold * max(forces)
    doubts = [_doubt(history(head, 2 * _STRIDE), noise) for head in followed]
    tallest = [force * (1 + min(doubt, 1.0)) for force, doubt in zip(forces, doubts, strict=True)]
    weakest_ahead = [math.inf, *accumulate(forces, min)]
    tallest_behind = list(accumulate([0.0, *reversed(tallest[1:])], max))[::-1]
    for i, force in enumerate(forces):
        if _TALLER * weakest_ahead[i] < force or tallest_behind[i] > _TALLER * force:
            doubts[i] = math.inf
    waves = list(zip(followed, doubts, strict=True))
    may_grow = any(head.force < least <= head.force * (1 + doubt) for head, doubt in waves)
    complete = not may_grow and _nothing_to_come(x, v, followed[-1].contact, least)
    return [(head, doubt) for head, doubt in waves if head.force >= least], complete


def _doubt(trail: list[Peak], noise: float) -> float:
    """Bound on the relative distance of a wave's peak from its limit, from its last peaks.

    Far from the others a wave nears its limit geometrically: what is left follows from how much the peak varied
    over the last contacts and over those before. It must also slow down within the last ones, lest it lingers.
    """
    if len(trail) <= 2 * _STRIDE:
        return math.inf
    half = _STRIDE // 2
    forces = np.array([peak.force for peak in trail])
    recent = float(np.ptp(forces[: half + 1]))
    older = float(np.ptp(forces[half : _STRIDE + 1]))
    last = float(np.ptp(forces[: _STRIDE + 1]))
    previous = float(np.ptp(forces[_STRIDE : 2 * _STRIDE + 1]))
    if last <= noise:
        return last / trail[0].force
    ratio = min(max(_ratio(last, previous), _ratio(recent, older) ** 2), _SLOWEST)
    return last * max(ratio / (1 - ratio), 0.1) / trail[0].force


def _ratio(later: float, earlier: float) -> float:
    return later / earlier if earlier > 0 else math.inf


def _nothing_to_come(x: FloatArray, v: FloatArray, rearmost: int, least_force: float) -> bool:
    """Whether what lies behind the rearmost wave is too weak to form a wave of ``least_force``."""
    first, last = free_granules(x, v), max(rearmost - _BACK, 0)
    if first >= last:
        return True
    energy = 0.5 * v[first:last] ** 2
    energy += 0.4 * contact_forces(x)[first:last] * np.maximum(overlaps(x)[first:last], 0.0)
    # All of it counts: granules far apart may still drive one another together.
    return float(energy.sum()) < ENERGY * math.pow(least_force, 5 / 3)
