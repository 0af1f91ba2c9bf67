"""Section 4 of Hasan & Nemat-Nasser, as a decision.

All quantities are scaled: force by F0, time by T0. With tA = A F0^(-1/6) and L the shock's impulse:

==================================  =========  =======================================
condition                           regime     peak force
==================================  =========  =======================================
alphaF0 tA < n t0                   train      (5a) with alpha; later waves by (5i)
alphaF0 tA >= n t0 and L < tA       ejection   (5h): (5f) with the momentum of (5g)
alphaF0 tA >= n t0 and L >= tA      single     (5f)
==================================  =========  =======================================

The relation to the shock's peak force is decided before that, by (5d) for a train and (5e) otherwise.
"""

from __future__ import annotations

from attrs import evolve

from shockwave.prediction.model_interface import (
    Inequality,
    Regime,
    Relation,
    ScaledAnswer,
    ScaledEjection,
    ScaledShock,
    Settings,
)
from shockwave.prediction.wave_train import constant_alpha, train


def regime(shock: ScaledShock) -> tuple[Regime, tuple[Inequality, ...]]:
    """The regime of a scaled shock, by the table above, and the inequalities that decide it."""
    time_of_wave = shock.momentum_parameter
    long_enough = constant_alpha(shock) * time_of_wave
    statement = "alphaF0 A F0^(-1/6) {} n t0"
    if long_enough < shock.duration:
        return "train", (Inequality(statement.format("<"), long_enough, shock.duration, "(5d)", "train"),)
    split = Inequality(statement.format(">="), long_enough, shock.duration, "(5e)", "one wave")
    statement = "whole impulse over F0 {} A F0^(-1/6)"
    if shock.impulse < time_of_wave:
        step = Inequality(statement.format("<"), shock.impulse, time_of_wave, "4.2.2", "ejection")
        return "ejection", (split, step)
    return "single", (split, Inequality(statement.format(">="), shock.impulse, time_of_wave, "4.2.3", "single"))


def relation_of(ratio: float, tolerance: float) -> Relation:
    """The relation of a primary to the shock, from one over the other."""
    if abs(ratio - 1) <= tolerance:
        return "equal"
    return "greater" if ratio > 1 else "less"


def predict(shock: ScaledShock, settings: Settings) -> ScaledAnswer:
    """Section 4's answer for a scaled shock; the table above is its logic."""
    kind, (split, *momentum) = regime(shock)
    statement, share = "whole impulse over F0 against A F0^(-1/6)", shock.impulse
    if kind == "train":
        statement = "impulse up to alphaF0 A F0^(-1/6), over F0, against A F0^(-1/6)"
        share = shock.impulse_until(split.left)
    time_of_wave = shock.momentum_parameter
    relation = relation_of(share / time_of_wave, settings.equal_tolerance)
    trace = (split, Inequality(statement, share, time_of_wave, split.equation, relation), *momentum)
    if kind == "train":
        return _train(shock, settings, relation, trace)
    if kind == "ejection":
        return _ejection(shock, relation, trace)
    amplitude = (shock.impulse / time_of_wave) ** 1.2  # (5f)
    return ScaledAnswer("single", relation, (amplitude,), trace, sensitivity=-1.2, trust=_length(shock))


def _length(shock: ScaledShock) -> float:
    """Duration over the time in which a wave of the shock's peak force gathers its impulse."""
    return shock.duration / (constant_alpha(shock) * shock.momentum_parameter)


def _ejection(shock: ScaledShock, relation: Relation, trace: tuple[Inequality, ...]) -> ScaledAnswer:
    ratio = shock.impulse / shock.momentum_parameter
    # (5g) is linear in the virtual rise time, so it needs no iteration: t0 / virtual is the ratio itself.
    virtual = shock.momentum_parameter / shock.areas.total
    window = 1 - ratio  # (virtual - t0) / virtual
    n = shock.profile.duration_ratio
    as_virtual = evolve(shock, rise_time=virtual)
    begin = max(n - window, 0.0) * virtual
    added = 2 * (as_virtual.impulse - as_virtual.impulse_until(begin))
    total = ratio + added / shock.momentum_parameter
    # d/d ln A: the ratio falls as 1/A, and the window grows with it by F at its beginning.
    slope = -ratio * (1 - 2 * as_virtual.force_at(begin) / shock.areas.total)
    warnings: tuple[str, ...] = ()
    amplitude = total**1.2  # (5h)
    if amplitude > 1 and relation == "less":
        warnings = (
            "(5h) puts the primary above the shock's peak force while (5e) puts it below: "
            "the added momentum of the virtual pulse is out of proportion here",
        )
    return ScaledAnswer(
        "ejection",
        relation,
        (amplitude,),
        trace,
        sensitivity=1.2 * slope / total,
        trust=window / n,
        ejection=ScaledEjection(virtual, added, window / n),
        warnings=warnings,
    )


def _train(shock: ScaledShock, settings: Settings, relation: Relation, trace: tuple[Inequality, ...]) -> ScaledAnswer:
    found = train(shock, settings)
    # Errors of the literal reading were not measured by range: it has no trustworthy root.
    measured = settings.alpha == "constant" and max(found.amplitudes) == found.amplitudes[0]
    return ScaledAnswer(
        "train",
        relation,
        found.amplitudes,
        trace,
        found.sensitivity,
        trust=_length(shock) if measured else None,
        roots=found.roots,
        warnings=found.warnings,
    )
