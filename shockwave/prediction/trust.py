"""How far section 4 can be trusted: errors of the primary's peak force measured against direct simulation.

The shocks were random, of the built-in kinds, and met the conditions (3); ``docs/trust.md`` tells how many, and how
often the error lay in the range told for shocks that were not used to make the tables.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from attrs import frozen

from shockwave.profiles.conditions import Condition
from shockwave.theory.scaled import Regime

__all__ = ["expected_error"]


@frozen
class _Row:
    """Holds for values of its table's measure up to ``upto``."""

    upto: float
    low: float
    high: float


# One wave: what simulation gives for F / (F0 S^(6/5)), by the strength S = L / (A F0^(5/6)) with A exact. It tends
# to the impulse limit 1.16818 as S -> 0. A formula's error follows by division.
_TRUE_FACTOR = (
    _Row(0.1, 1.165, 1.16819),
    _Row(0.2, 1.150, 1.16819),
    _Row(0.4, 1.09, 1.167),
    _Row(0.6, 1.03, 1.155),
    _Row(0.8, 0.98, 1.13),
    _Row(1.0, 0.92, 1.08),
    _Row(math.inf, 0.93, 1.05),
)
# Train: relative error, by n t0 over alphaF0 A F0^(-1/6).
_TRAIN = (
    _Row(1.6, -0.15, 0.20),
    _Row(2.0, -0.30, 0.15),
    _Row(2.5, -0.50, 0.13),
    _Row(3.5, -0.70, 0.09),
    _Row(5.0, -0.80, 0.06),
    _Row(10.0, -0.93, 0.03),
    _Row(math.inf, -1.0, 0.0),
)
# Window of (5h) over the virtual shock: beyond, its added momentum means nothing, whatever the range would say.
_WIDEST_WINDOW = 0.165
# Noise turns a record by so much; more is a second peak.
_MOST_REVERSAL = 0.05
# An upper end above this is a warning of its own.
_USELESS = 0.5


def expected_error(
    regime: Regime,
    trust: float | None,
    strength: float,
    amplitude: float,
    conditions: Sequence[Condition],
    reversal: float = 0.0,
) -> tuple[tuple[float, float] | None, list[str]]:
    """The measured range of the relative error, or None; and sentences on it.

    Parameters
    ----------
    regime : str
        Of the outcome.
    trust : float or None
        The measure of that regime; None when errors were not measured for the reading in use.
    strength : float
        S, the shock's impulse over A F0^(5/6) with A exact.
    amplitude : float
        Predicted peak force over the shock's.
    conditions : sequence of Condition
        The inequalities (3): errors were measured only where all hold.
    reversal : float
        How far the force falls back before its peak or rises again after it, over the peak: errors were measured
        for shocks with one peak.
    """
    broken = [condition for condition in conditions if not condition.holds]
    if broken:
        listed = "; ".join(f"{c.statement} fails by {-c.margin:.3g}" for c in broken)
        return None, [f"outside the conditions (3) no error was measured for section 4: {listed}"]
    if reversal > _MOST_REVERSAL:
        return None, [f"the shock has several peaks (it turns by {reversal:.0%} of its peak): simulate to know"]
    if trust is None:
        return None, ["no error was measured for this reading of section 4: simulate to know"]
    if regime == "train":
        row = _row(_TRAIN, trust)
        return (row.low, row.high), []
    if regime == "ejection" and trust > _WIDEST_WINDOW:
        return None, [
            f"the correction window of (5h) is {trust:.2f} of the virtual shock; beyond 0.165 its error has"
            " no useful bound (+2277 % was measured, and it grows as the shock shortens): simulate instead"
        ]
    row = _row(_TRUE_FACTOR, strength)
    impulse_law = strength**1.2
    low, high = (amplitude / (factor * impulse_law) - 1 for factor in (row.high, row.low))
    doubts = []
    if high > _USELESS:
        doubts.append("(5h) adds more momentum than the shock has to give: simulate instead")
    return (low, high), doubts


def _row(table: Sequence[_Row], measure: float) -> _Row:
    return next(row for row in table if measure <= row.upto)
