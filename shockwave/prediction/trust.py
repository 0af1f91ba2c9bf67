"""How far section 4 can be trusted: errors of the primary's peak force measured against direct simulation.

The shocks were random and met the conditions (3); see ``docs/trust.md``. Each row holds for values of its
regime's measure up to ``upto``.
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
    upto: float
    low: float
    high: float


# Ejection, by the window of (5h) over the virtual duration.
_EJECTION = (_Row(0.05, -0.14, 0.05), _Row(0.10, -0.14, 0.26), _Row(0.165, -0.14, 1.31))
# Single and train, by n t0 over alphaF0 A F0^(-1/6); below 1 it is a single wave.
_SINGLE = (_Row(1.0, -0.13, 0.11),)
_TRAIN = (
    _Row(1.6, -0.13, 0.11),
    _Row(2.5, -0.59, 0.11),
    _Row(5.0, -0.59, 0.08),
    _Row(math.inf, -0.88, -0.02),
)
_ROWS: dict[Regime, Sequence[_Row]] = {"ejection": _EJECTION, "single": _SINGLE, "train": _TRAIN}

_BEYOND = (
    "the correction window of (5h) is {trust:.2f} of the virtual shock; beyond 0.16 its measured errors reach"
    " +2277 %: simulate instead"
)


def expected_error(
    regime: Regime, trust: float | None, conditions: Sequence[Condition]
) -> tuple[tuple[float, float] | None, list[str]]:
    """The measured range of the relative error, or None, and why.

    Parameters
    ----------
    regime : str
        Of the outcome.
    trust : float or None
        The measure of that regime; None when errors were not measured for the reading in use.
    conditions : sequence of Condition
        The inequalities (3): errors were measured only where all hold.
    """
    broken = [condition for condition in conditions if not condition.holds]
    if broken:
        listed = "; ".join(f"{c.statement} fails by {-c.margin:.3g}" for c in broken)
        return None, [f"outside the conditions (3) no error was measured for section 4: {listed}"]
    if trust is None:
        return None, ["no error was measured for this reading of alpha: simulate to know"]
    for row in _ROWS[regime]:
        if trust <= row.upto:
            return (row.low, row.high), []
    return None, [_BEYOND.format(trust=trust)]
