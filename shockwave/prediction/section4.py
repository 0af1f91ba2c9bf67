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

from shockwave.prediction.scaled import Inequality, Relation, ScaledAnswer, ScaledEjection, ScaledShock, Settings
from shockwave.prediction.train import constant_alpha, train

__all__ = ["predict"]


def predict(shock: ScaledShock, settings: Settings) -> ScaledAnswer:
    """Section 4's answer for a scaled shock; the table above is its logic."""
    time_of_wave = shock.momentum_parameter
    alpha = constant_alpha(shock)
    is_train = alpha * time_of_wave < shock.duration
    split = Inequality(
        f"alphaF0 A F0^(-1/6) {'<' if is_train else '>='} n t0",
        alpha * time_of_wave,
        shock.duration,
        "(5d)" if is_train else "(5e)",
        "train" if is_train else "one wave",
    )
    share = shock.impulse_until(alpha * time_of_wave) if is_train else shock.impulse
    relation = _relation(share / time_of_wave, settings.equal_tolerance)
    related = Inequality(
        "impulse up to alphaF0 A F0^(-1/6), over F0, against A F0^(-1/6)"
        if is_train
        else "whole impulse over F0 against A F0^(-1/6)",
        share,
        time_of_wave,
        "(5d)" if is_train else "(5e)",
        relation,
    )
    if is_train:
        return _train(shock, settings, relation, (split, related))
    ejects = shock.impulse < time_of_wave
    momentum = Inequality(
        f"whole impulse over F0 {'<' if ejects else '>='} A F0^(-1/6)",
        shock.impulse,
        time_of_wave,
        "4.2.2" if ejects else "4.2.3",
        "ejection" if ejects else "single",
    )
    branch = _ejection if ejects else _single
    return branch(shock, relation, (split, related, momentum))


def _relation(ratio: float, tolerance: float) -> Relation:
    if abs(ratio - 1) <= tolerance:
        return "equal"
    return "greater" if ratio > 1 else "less"


def _single(shock: ScaledShock, relation: Relation, trace: tuple[Inequality, ...]) -> ScaledAnswer:
    amplitude = (shock.impulse / shock.momentum_parameter) ** 1.2  # (5f)
    ratio = shock.duration / (constant_alpha(shock) * shock.momentum_parameter)
    return ScaledAnswer("single", relation, (amplitude,), trace, sensitivity=-1.2, trust=ratio)


def _ejection(shock: ScaledShock, relation: Relation, trace: tuple[Inequality, ...]) -> ScaledAnswer:
    ratio = shock.impulse / shock.momentum_parameter
    # (5g) is linear in the virtual rise time, so it needs no iteration: t0 / virtual is the ratio itself.
    virtual = shock.momentum_parameter / shock.areas.total
    window = 1 - ratio  # (virtual - t0) / virtual
    n = shock.profile.duration_ratio
    as_virtual = ScaledShock(shock.profile, shock.areas, virtual, shock.momentum_parameter)
    begin = max(n - window, 0.0)
    added = 2 * (as_virtual.impulse - as_virtual.impulse_until(begin * virtual))
    total = ratio + added / shock.momentum_parameter
    # d/d ln A: the ratio falls as 1/A, and the window grows with it by F at its beginning.
    slope = -ratio * (1 - 2 * as_virtual.force_at(begin * virtual) / shock.areas.total)
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
    ratio = shock.duration / (constant_alpha(shock) * shock.momentum_parameter)
    return ScaledAnswer(
        "train",
        relation,
        found.amplitudes,
        trace,
        found.sensitivity,
        trust=ratio if settings.alpha == "constant" and max(found.amplitudes) == found.amplitudes[0] else None,
        roots=found.roots,
        warnings=found.warnings,
    )
