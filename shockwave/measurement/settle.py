"""When the waves are known: separated, in order, at their limits along the chain, with nothing to come."""

from __future__ import annotations

import math

import numpy as np
from attrs import frozen

from shockwave.chain.solitary_wave import ENERGY
from shockwave.measurement.peaks import Peak, PeakLog
from shockwave.quadrature import FloatArray
from shockwave.simulation.problem import contact_forces, overlaps

__all__ = ["Settling", "free_granules", "settling"]

# Contacts between the peaks whose differences show how fast a wave nears its limit.
_STRIDE = 10
# A wave and its foot span this many granules; so does any concentration of energy that could become one.
_FOOT = 5
_SPAN = 12
# Waves are followed down to this share of the threshold.
_FOLLOWED = 0.3
# A wave this much taller than one before it will overtake it.
_TALLER = 1.001


@frozen
class Settling:
    """The waves at this moment, front first.

    ``doubts`` bound how far each peak may still be from its limit, relatively; infinite for a wave that a taller
    one follows. ``complete`` says that nothing behind them can become another wave.
    """

    heads: tuple[Peak, ...]
    doubts: tuple[float, ...]
    complete: bool


def settling(log: PeakLog, now: float, x: FloatArray, v: FloatArray, threshold: float) -> Settling:
    """Judge the state of the chain after the force has ended.

    Parameters
    ----------
    log : PeakLog
        All peaks up to ``now``.
    x, v : FloatArray
        Positions and velocities at ``now``, shape (granules,).
    threshold : float
        Peak force, over the strongest wave's, above which a wave counts.
    """
    # Weaker waves are followed too: one may still grow, and its energy is accounted for.
    followed = log.heads(now, _FOLLOWED * threshold)
    if not followed:
        return Settling((), (), False)
    least = threshold * max(head.force for head in followed)
    doubts = [_doubt(log.history(head, 2 * _STRIDE)) for head in followed]
    for i in range(len(followed)):
        if any(behind.force > _TALLER * followed[i].force for behind in followed[i + 1 :]):
            doubts[i] = math.inf
    counted = [i for i, head in enumerate(followed) if head.force >= least]
    may_grow = any(
        head.force * (1 + doubt) >= least for head, doubt in zip(followed, doubts, strict=True) if head.force < least
    )
    complete = not may_grow and _nothing_to_come(x, v, followed[-1].contact, least)
    return Settling(tuple(followed[i] for i in counted), tuple(doubts[i] for i in counted), complete)


def free_granules(x: FloatArray, v: FloatArray) -> int:
    """How many granules at the loaded end fly free: out of contact, and no two of them closing in."""
    apart = (overlaps(x) <= 0) & (v[:-1] <= v[1:])
    return int(np.argmin(apart)) if not apart.all() else len(x)


def _doubt(trail: list[Peak]) -> float:
    """Bound on the relative distance of a wave's peak from its limit, from its last peaks.

    Far from the others a wave nears its limit geometrically: what is left follows from how much the peak varied
    over the last contacts and over those before.
    """
    if len(trail) <= 2 * _STRIDE:
        return math.inf
    forces = [peak.force for peak in trail[: 2 * _STRIDE + 1]]
    last, previous = (max(part) - min(part) for part in (forces[: _STRIDE + 1], forces[_STRIDE:]))
    ratio = min(last / previous, 0.9) if previous > 0 else 0.9
    return last * max(ratio / (1 - ratio), 0.1) / forces[0]


def _nothing_to_come(x: FloatArray, v: FloatArray, rearmost: int, least_force: float) -> bool:
    """Whether what lies behind the rearmost wave is too weak to form a wave of ``least_force``."""
    first, last = free_granules(x, v), max(rearmost - _FOOT, 0)
    if first >= last:
        return True
    energy = 0.5 * v[first:last] ** 2
    energy += 0.4 * contact_forces(x)[first:last] * np.maximum(overlaps(x)[first:last], 0.0)
    sums = np.convolve(energy, np.ones(_SPAN))
    return bool(sums.max() < ENERGY * least_force ** (5 / 3))
