"""The decision procedure of section 4 of Hasan & Nemat-Nasser.

All quantities are scaled: force by F0, time by T0. With tA = A F0^(-1/6) and the impulse L of the shock:

==================================  =========  =======================================
condition                           regime     peak force
==================================  =========  =======================================
alphaF0 tA < n t0                   train      (5a) with alpha; later waves by (5i)
alphaF0 tA >= n t0 and L < tA       ejection   (5h): (5f) with the momentum of (5g)
alphaF0 tA >= n t0 and L >= tA      single     (5f)
==================================  =========  =======================================

The relation to the shock's peak force is decided beforehand, by (5d) for a train and by (5e) otherwise. In the code
``unit`` is A F0^(-1/6), the momentum of a wave of peak force 1. For a contact force d^p with another p than 3/2 the
powers of the force are those of its solitary wave.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from attrs import evolve

from shockwave.base.numerics import bracketed_root, newton_root
from shockwave.prediction.scaled_shock import Inequality, Regime, Relation, ScaledAnswer, ScaledEjection, ScaledShock
from shockwave.scene.chain import HERTZ

#: Readings of alpha: that of section 4.1, or (5c) as printed.
Alpha = Literal["constant", "literal"]
#: Largest number of later waves in a train.
MOST_WAVES = 1000
# Points of the scan for roots of (5c) towards each end of rise and decay.
_SCAN_POINTS = 150
#: A remaining fraction of the impulse below this is a rounding error and does not form a wave.
NOTHING_LEFT = 1e-12
#: Coefficient alpha of the later waves of a shock with the decay of a triangle, (5i).
LATER_ALPHA = (8 - math.sqrt(2)) / 4
#: Least ratio of the peak forces of a later wave and the leading wave that is no rounding error.
ABOVE_ROUNDING = 1 + 1e-9
#: Warnings.
CONTRADICTION = (
    "The peak force of the leading wave by (5h) is above that of the shock, in contradiction to (5e): the added"
    " momentum is too large here. Simulate to obtain an accurate peak force."
)
ENTIRE = (
    "The leading wave carries the entire impulse, because the wave is still forming when the shock ends."
    " Simulate to obtain the later waves, if there are any."
)
STRONGER = (
    "A later wave by (5i) is stronger than the leading wave: the rise is too slow for section 4. Simulate to"
    " obtain accurate peak forces."
)
MANY = f"Only the first {MOST_WAVES} later waves are listed; a larger wave_threshold omits more."


def regime(shock: ScaledShock) -> tuple[Regime, tuple[Inequality, ...]]:
    """Regime of a scaled shock by the table above, with the inequalities that decide it."""
    time_of_wave = shock.momentum_parameter
    long_enough = constant_alpha(shock) * time_of_wave
    wave = f"A F0^(-{'1/6' if shock.wave.exponent == HERTZ else f'{shock.wave.of_speed:.4g}'})"
    statement = f"alphaF0 {wave} {{}} n t0"
    if long_enough < shock.duration:
        return "train", (Inequality(statement.format("<"), long_enough, shock.duration, "(5d)", "train"),)
    split = Inequality(statement.format(">="), long_enough, shock.duration, "(5e)", "one wave")
    statement = f"total impulse / F0 {{}} {wave}"
    if shock.impulse < time_of_wave:
        step = Inequality(statement.format("<"), shock.impulse, time_of_wave, "4.2.2", "ejection")
        return "ejection", (split, step)
    return "single", (split, Inequality(statement.format(">="), shock.impulse, time_of_wave, "4.2.3", "single"))


def relation_of(ratio: float, tolerance: float) -> Relation:
    """Relation of the leading wave to the shock, from the ratio of the former to the latter."""
    if abs(ratio - 1) <= tolerance:
        return "equal"
    return "greater" if ratio > 1 else "less"


def predict(
    shock: ScaledShock, alpha: Alpha = "constant", equal_tolerance: float = 0.05, wave_threshold: float = 5e-3
) -> ScaledAnswer:
    """Answer of section 4 for a scaled shock, by the table above; for the settings see `Predictor`."""
    kind, (split, *momentum) = regime(shock)
    wave = split.statement.split(" ", 1)[1].rsplit(" ", 3)[0]
    statement, share = f"total impulse / F0 vs. {wave}", shock.impulse
    if kind == "train":
        statement = f"impulse / F0 until alphaF0 {wave} vs. {wave}"
        share = shock.at(split.left)[0]
    unit = shock.momentum_parameter
    relation = relation_of(share / unit, equal_tolerance)
    trace = (split, Inequality(statement, share, unit, split.equation, relation), *momentum)
    if kind == "train":
        return _train(shock, alpha == "literal", wave_threshold, relation, trace)
    if kind == "ejection":
        return _ejection(shock, relation, trace)
    amplitude = (shock.impulse / unit) ** shock.of_force  # (5f)
    return ScaledAnswer("single", relation, (amplitude,), trace, sensitivity=-shock.of_force)


def _ejection(shock: ScaledShock, relation: Relation, trace: tuple[Inequality, ...]) -> ScaledAnswer:
    """Answer with one wave and rebounding granules, by (5g) and (5h)."""
    ratio = shock.impulse / shock.momentum_parameter
    # (5g) is linear in the virtual rise time, so no iteration is needed: t0 / virtual equals the ratio.
    virtual = shock.momentum_parameter / shock.areas.total
    window = 1 - ratio  # (virtual - t0) / virtual
    n = shock.profile.duration_ratio
    as_virtual = evolve(shock, rise_time=virtual)
    begin = max(n - window, 0.0) * virtual
    until, force = as_virtual.at(begin)
    added = 2 * (as_virtual.impulse - until)
    total = ratio + added / shock.momentum_parameter
    # d/d ln A: the ratio decreases as 1/A, and the window grows at its beginning, where the force is F.
    slope = -ratio * (1 - 2 * force / shock.areas.total)
    amplitude = total**shock.of_force  # (5h)
    warnings = (CONTRADICTION,) * (amplitude > 1 and relation == "less")
    return ScaledAnswer(
        "ejection",
        relation,
        (amplitude,),
        trace,
        sensitivity=shock.of_force * slope / total,
        ejection=ScaledEjection(virtual, added, window / n),
        warnings=warnings,
    )


def constant_alpha(shock: ScaledShock) -> float:
    """Coefficient alpha^F0 of section 4.1: 2 minus the deviations of the areas from those of a triangle."""
    return 2 - _deviation(shock.areas.rise.value) - _deviation(_decay_share(shock))


# ---------------------------------------------------------------- trains


def _train(
    shock: ScaledShock, literal: bool, wave_threshold: float, relation: Relation, trace: tuple[Inequality, ...]
) -> ScaledAnswer:
    """Answer with the leading wave by (5a), with alpha^F0 or (5c) as printed, and the later waves by (5i)."""
    alpha = constant_alpha(shock)
    if literal:
        primary, end, roots, warnings = _literal_primary(shock)
        reach = 2 * primary / (2 * primary - (2 - alpha)) - shock.wave.of_speed
    else:
        end = _passage_time(shock, 0.0, 0.0, alpha, 0.0)
        primary = (alpha * shock.momentum_parameter / end) ** (1 / shock.wave.of_speed)
        roots, warnings, reach = (primary,), [], -shock.wave.of_speed
    if end >= shock.duration:
        warnings.append(ENTIRE)
    later = _later_waves(shock, wave_threshold * primary, end)
    highest = max(later, default=0.0)
    if highest > ABOVE_ROUNDING * primary:
        warnings.append(STRONGER)
    if len(later) == MOST_WAVES:
        warnings.append(MANY)
    # Implicit derivative of A F^(5/6) = I(t), t = alpha(F) A F^(-1/6); ``reach`` is d ln t / d ln F for constant A.
    impulse, force = shock.at(end)
    weight = end * force / impulse
    slope = shock.wave.of_momentum - weight * reach
    return ScaledAnswer(
        "train",
        relation,
        (primary, *later),
        trace,
        sensitivity=(weight - 1) / slope if abs(slope) > 1e-6 else None,
        roots=roots,
        warnings=tuple(warnings),
    )


def _deviation(area: float) -> float:
    return float(abs(0.5 - area) ** 1.5)


def _decay_share(shock: ScaledShock) -> float:
    return shock.areas.decay.value / (shock.profile.duration_ratio - 1)


def _passage_time(shock: ScaledShock, start: float, before: float, alpha: float, guess: float) -> float:
    """Time for which a wave collects impulse from ``start`` on, (5a) and (5i); ``before`` is the impulse until then.

    If the wave collects impulse for the time d, its peak force is F = (alpha unit / d)^6 and its momentum unit F^(5/6).
    The impulse increases with d and the momentum decreases, so there is exactly one root. The logarithm of d times the
    fifth root of the impulse is nearly linear in ln d. For other exponents of the contact force the powers differ.
    """
    unit = shock.momentum_parameter
    root = (shock.wave.exponent - 1) / (shock.wave.exponent + 1)

    def excess(time: float) -> tuple[float, float]:
        until, force = shock.at(start + time)
        impulse = until - before
        if impulse <= 0:
            return -math.inf, 1.0
        return math.log(time / (alpha * unit)) + root * math.log(impulse / unit), 1 + root * time * force / impulse

    # Below ``lower`` even the full peak force gives too little impulse; at ``upper`` the remaining impulse suffices.
    lower = 0.99 * unit * alpha**shock.wave.of_momentum
    enough = alpha * unit * (unit / (shock.impulse - before)) ** root
    upper = 1.01 * max(shock.duration - start, enough, lower)
    return newton_root(excess, lower, upper, guess, "time of a wave in the train (5i)")


def _later_waves(shock: ScaledShock, least: float, end: float) -> list[float]:
    """Peak forces, by (5i), of the waves behind the one that ends at ``end``, down to ``least``."""
    alpha = LATER_ALPHA - _deviation(_decay_share(shock))
    waves: list[float] = []
    passage, guess, before = 0.0, 0.0, shock.at(end)[0]
    while len(waves) < MOST_WAVES and shock.impulse - before > NOTHING_LEFT * shock.impulse:
        last, passage = passage, _passage_time(shock, end, before, alpha, guess)
        guess = passage * passage / last if last else passage
        peak = (alpha * shock.momentum_parameter / passage) ** (1 / shock.wave.of_speed)
        if peak < least:
            break
        waves.append(peak)
        end += passage
        before = shock.at(end)[0]
    return waves


def _literal_primary(shock: ScaledShock) -> tuple[float, float, tuple[float, ...], list[str]]:
    """Peak force and end of the leading wave by (5c) as printed, alpha = 2 F/F0 - deviation; all roots; warnings."""
    unit, deviation = shock.momentum_parameter, 2 - constant_alpha(shock)

    def time(force: float) -> float:
        return unit * (2 * force - deviation) * math.pow(force, -shock.wave.of_speed)

    def force_at(end: float) -> float:
        # For F above the deviation the time exceeds unit F^(5/6), which gives the upper end of the bracket.
        upper = 1.01 * max(deviation, math.pow(end / unit, shock.of_force))
        return bracketed_root(lambda force: time(force) - end, upper * 1e-15, upper, "force of a time in (5c)")

    def missing(force: float) -> float:
        return unit * math.pow(force, shock.wave.of_momentum) - shock.at(max(time(force), 0.0))[0]

    grid = [force_at(end) for end in _scan_times(shock)]
    grid.append(max(1.1 * math.pow(shock.impulse / unit, shock.of_force), 1.01 * grid[-1]))
    signs = [missing(force) for force in grid]
    changes = [i for i in range(len(grid) - 1) if signs[i] * signs[i + 1] < 0 or signs[i] == 0]
    roots = tuple(bracketed_root(missing, grid[i], grid[i + 1], "a root of (5c) as printed") for i in changes)
    # Only a root with a time within the shock is a train; rounding errors may place the end itself just inside.
    inside = [root for root in roots if time(root) < shock.duration * (1 - 1e-9)]
    if not inside:
        full_impulse_force = (shock.impulse / unit) ** shock.of_force
        sentence = (
            "(5c) as printed has no root within the shock, so the leading wave is assumed to carry the entire impulse."
            " Set alpha: constant, or simulate, to obtain a reliable peak force."
        )
        return full_impulse_force, shock.duration, roots, [sentence]
    listed = ", ".join(f"{root:.6g}" for root in roots)
    sentence = (
        f"(5c) as printed has the roots {listed} (times the peak force of the shock), of which the last one within the"
        " shock is used. Set alpha: constant, or simulate, to obtain a reliable peak force."
    )
    return inside[-1], time(inside[-1]), roots, [sentence]


def _scan_times(shock: ScaledShock) -> list[float]:
    """Times between which roots are sought, dense towards both ends of rise and decay, where roots are close."""
    share = np.concatenate((np.geomspace(1e-6, 0.5, _SCAN_POINTS), 1 - np.geomspace(0.5, 1e-6, _SCAN_POINTS)[1:]))
    decay = 1 + (shock.profile.duration_ratio - 1) * share
    points = np.concatenate((share, [1.0], decay, [shock.profile.duration_ratio]))
    return [shock.rise_time * float(point) for point in points]
