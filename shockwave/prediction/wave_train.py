"""Trains of solitary waves: the primary's share of the impulse, (5a) and (5c), and the later waves, (5i).

Scaled units: force by F0, time by T0. ``unit`` stands for A F0^(-1/6), the momentum of a wave of peak force 1.
"""

from __future__ import annotations

import math

import numpy as np
from attrs import frozen

from shockwave.numerics import bracketed_root
from shockwave.prediction.model_interface import ScaledShock, Settings

_MOST_WAVES = 1000
_SCAN_POINTS = 150
# A remainder of the impulse below this share is rounding, not a wave.
_NOTHING_LEFT = 1e-12


@frozen
class Train:
    """Peak forces of the waves, all roots of the primary's relation, its sensitivity, and sentences on it."""

    amplitudes: tuple[float, ...]
    roots: tuple[float, ...]
    sensitivity: float | None
    warnings: tuple[str, ...]


def constant_alpha(shock: ScaledShock) -> float:
    """alpha^F0 of section 4.1: 2 less the deviation of the areas from a triangle's."""
    return 2 - _deviation(shock.areas.rise.value) - _deviation(_decay_share(shock))


def train(shock: ScaledShock, settings: Settings) -> Train:
    """The primary by (5a), with alpha^F0 or with (5c) as printed, and the later waves by (5i)."""
    if settings.alpha == "literal":
        primary, end, roots, warnings = _literal_primary(shock)
        reach = 2 * primary / (2 * primary - (2 - constant_alpha(shock))) - 1 / 6
    else:
        alpha = constant_alpha(shock)
        end = _wave_end(shock, 0.0, alpha)
        primary = (alpha * shock.momentum_parameter / end) ** 6
        roots, warnings, reach = (primary,), (), -1 / 6
    if end >= shock.duration:
        warnings += ("the primary takes the whole impulse: the time it needs ends after the shock",)
    later, ending = _later_waves(shock, settings, primary, end)
    if max(later, default=0.0) > primary:
        warnings += ("(5i) puts a later wave above the primary: the rise is too slow for section 4",)
    # Implicit derivative of A F^(5/6) = I(t), t = alpha(F) A F^(-1/6); ``reach`` is d ln t / d ln F at fixed A.
    held = min(end, shock.duration)
    weight = 0.0 if end >= shock.duration else held * shock.force_at(held) / shock.impulse_until(held)
    slope = 5 / 6 - weight * reach
    sensitivity = (weight - 1) / slope if abs(slope) > 1e-6 else None
    return Train((primary, *later), roots, sensitivity, warnings + ending)


def _deviation(area: float) -> float:
    return float(abs(0.5 - area) ** 1.5)


def _decay_share(shock: ScaledShock) -> float:
    return shock.areas.decay.value / (shock.profile.duration_ratio - 1)


def _wave_end(shock: ScaledShock, start: float, alpha: float) -> float:
    """When a wave that begins to gather impulse at ``start`` has its own, (5a) and (5i).

    With d its time, the wave's peak force is (alpha unit / d)^6 and the impulse in d is unit F^(5/6). The
    impulse grows with d and the wave's momentum falls, so there is one root.
    """
    unit = shock.momentum_parameter
    before = shock.impulse_until(start)

    def excess(time: float) -> float:
        return shock.impulse_until(start + time) - before - unit * (alpha * unit / time) ** 5

    # Below, even the full peak force would give too little; above, the rest of the impulse is enough.
    lower = 0.99 * unit * alpha ** (5 / 6)
    enough = alpha * unit * (unit / (shock.impulse - before)) ** 0.2
    upper = 1.01 * max(shock.duration - start, enough, lower)
    return start + bracketed_root(excess, lower, upper, "time of a wave in the train (5i)")


def _later_waves(
    shock: ScaledShock, settings: Settings, primary: float, end: float
) -> tuple[tuple[float, ...], tuple[str, ...]]:
    alpha = (8 - math.sqrt(2)) / 4 - _deviation(_decay_share(shock))
    least = settings.wave_threshold * primary
    waves: list[float] = []
    while shock.impulse - shock.impulse_until(end) > _NOTHING_LEFT * shock.impulse:
        start, end = end, _wave_end(shock, end, alpha)
        peak = (alpha * shock.momentum_parameter / (end - start)) ** 6
        if peak < least:
            break
        waves.append(peak)
        if len(waves) >= _MOST_WAVES:
            return tuple(waves), (f"only the first {_MOST_WAVES} later waves were counted",)
    return tuple(waves), ()


def _literal_primary(shock: ScaledShock) -> tuple[float, float, tuple[float, ...], tuple[str, ...]]:
    """Peak force and time by (5c) as printed, alpha = 2 F/F0 - deviation; with all roots."""
    unit, deviation = shock.momentum_parameter, 2 - constant_alpha(shock)

    def time(force: float) -> float:
        return unit * (2 * force - deviation) * math.pow(force, -1 / 6)

    def force_at(end: float) -> float:
        # Above the deviation the time exceeds unit F^(5/6), which gives the upper end of the bracket.
        upper = 1.01 * max(deviation, math.pow(end / unit, 1.2))
        return bracketed_root(lambda force: time(force) - end, upper * 1e-15, upper, "force of a time in (5c)")

    def missing(force: float) -> float:
        return unit * math.pow(force, 5 / 6) - shock.impulse_until(max(time(force), 0.0))

    grid = [force_at(end) for end in _scan_times(shock)]
    grid.append(max(1.1 * math.pow(shock.impulse / unit, 1.2), 1.01 * grid[-1]))
    signs = [missing(force) for force in grid]
    roots = tuple(
        bracketed_root(missing, grid[i], grid[i + 1], "a root of (5c) as printed")
        for i in range(len(grid) - 1)
        if signs[i] * signs[i + 1] < 0 or signs[i] == 0
    )
    # Only a root whose time lies within the shock is a train; rounding may put the end itself just inside.
    inside = [root for root in roots if time(root) < shock.duration * (1 - 1e-9)]
    if not inside:
        whole = (shock.impulse / unit) ** 1.2
        sentence = "(5c) as printed has no root within the shock: the primary is given the whole impulse"
        return whole, shock.duration, roots, (sentence,)
    listed = ", ".join(f"{root:.6g}" for root in roots)
    sentence = f"(5c) as printed has the roots {listed} (times the peak force); the last within the shock is used"
    return inside[-1], time(inside[-1]), roots, (sentence,)


def _scan_times(shock: ScaledShock) -> list[float]:
    """Times between which a root may lie: dense at both ends of rise and decay, where roots crowd."""
    share = np.concatenate((np.geomspace(1e-6, 0.5, _SCAN_POINTS), 1 - np.geomspace(0.5, 1e-6, _SCAN_POINTS)[1:]))
    decay = 1 + (shock.profile.duration_ratio - 1) * share
    points = np.concatenate((share, [1.0], decay, [shock.profile.duration_ratio]))
    return [shock.rise_time * float(point) for point in points]
