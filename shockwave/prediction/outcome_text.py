"""Predictions as text: of one shock, and of many."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from shockwave.prediction.outcome import EjectionOutcome, Outcome
from shockwave.text import indent, notes, range_text, si, table

if TYPE_CHECKING:
    from shockwave.prediction.many_shocks import Predictions


# Listed figures of a wave, with their units.
_WAVE = {"peak_force": "N", "momentum": "N s", "energy": "J", "speed": "m/s", "width": "s"}
_RELATIONS = {"less": "less than", "equal": "about equal to", "greater": "greater than"}


def outcome_text(outcome: Outcome) -> str:
    """The figures, the waves, and the inequalities that decided."""
    lines = [
        f"prediction by {outcome.model}" + (f" of {outcome.scenario}" if outcome.scenario else ""),
        *outcome.scene.lines(),
        *([f"  method            {outcome.method}: {outcome.reason}"] if outcome.reason else []),
        f"  regime            {outcome.regime}",
        f"  relation          primary {_RELATIONS[outcome.relation]} the shock's peak force",
        f"  peak force        {si(outcome.peak_force, 'N')}, {outcome.amplification:.5g} times the shock's",
        f"  expected error    {range_text(outcome.expected_error)}",
        f"  applied momentum  {si(outcome.applied_momentum, 'N s')}",
    ]
    if isinstance(outcome, EjectionOutcome):
        rise, added = si(outcome.virtual_rise_time, "s"), si(outcome.added_momentum, "N s")
        lines.append(f"  ejection          virtual rise time {rise}, added momentum {added}")
    if powers := outcome.exponents:
        scaling = f"R^{powers.radius:.3f} rho^{powers.density:.3f} E^{powers.youngs_modulus:.3f}"
        lines.append(f"  scales as         {scaling}")
    waves = []
    for number, wave in enumerate(outcome.waves, start=1):
        figures = [si(getattr(wave, name), unit) for name, unit in _WAVE.items()]
        waves.append([str(number), *figures])
    conditions = [(c.statement, f"{c.margin:+.4g} t0", "holds" if c.holds else "FAILS") for c in outcome.conditions]
    steps = [(t.statement, si(t.left, "s"), si(t.right, "s"), t.outcome, t.equation) for t in outcome.trace]
    tables = (
        table(("wave", *(name.replace("_", " ") for name in _WAVE)), waves),
        table(("condition (3)", "margin", ""), conditions),
        table(("decided by", "left", "right", "hence", "equation"), steps),
    )
    for each in tables:
        lines += ["", indent(each)]
    return "\n".join(lines + notes(outcome.warnings))


def predictions_text(predictions: Predictions) -> str:
    """Counts by method, and ranges."""
    good = np.isfinite(predictions.peak_force)
    known = good & np.isfinite(predictions.expected_error).all(axis=1)
    lines = [f"{len(predictions)} predictions by {predictions.model}"]
    for name, count in Counter(predictions.method[good].tolist()).most_common():
        lines.append(f"  by {name:<15}{count}")
    if good.any():
        own = predictions.amplification[good]
        lines.append(f"  amplification     {own.min():.5g} to {own.max():.5g}")
    if known.any():
        ends = predictions.expected_error[known]
        within = range_text((float(ends[:, 0].min()), float(ends[:, 1].max())))
        lines.append(f"  expected error    {within}, known of {known.sum()}")
    if predictions.failures:
        index, reason = predictions.failures[0]
        lines.append(f"  no answer         {len(predictions.failures)}; the first, shock {index}: {reason}")
    return "\n".join(lines + notes(predictions.warnings))
