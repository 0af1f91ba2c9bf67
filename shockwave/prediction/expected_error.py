"""Estimate of the peak force with a range, and expected error of section 4, both from the law of moments.

The law of moments describes simulated peak forces of shocks of any shape with a known error. A predicted peak force
divided by both ends of the range of the law gives the range of its error. ``docs/trust.md`` reports how often the
errors of shocks that were not used in the fit lay in these ranges.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from attrs import frozen

from shockwave.chain.chain import Chain
from shockwave.prediction.model_interface import ScaledAnswer, ScaledShock
from shockwave.prediction.moments import moments_law
from shockwave.prediction.shock_impulses import pulse_of, turns
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.conditions import Condition

# Fewest granules in which the leading wave of a short shock forms, and additional ones per T0 of the duration.
_GRANULES = 40
_GRANULES_PER_TIME = 5

#: Reason why there is no estimate of a shock on a semi-infinite chain.
TOO_FAR = "the shock is longer, or finer, than those for which errors were measured"

_Range = tuple[float, float] | None


@frozen
class ScaledEstimate:
    """Amplification of the leading wave, the ends of its range, and the method."""

    amplification: float
    low: float
    high: float
    method: str


def estimated(answer: ScaledAnswer, shock: ScaledShock, model: str) -> ScaledEstimate | None:
    """Best estimate of the amplification: that of a model that states its error, or that of the law of moments.

    None if the model does not know its error, or the shock is longer or finer than those of the law.
    """
    if answer.states_error:
        if answer.expected_error is None:
            return None
        least, most = answer.expected_error
        peak = answer.amplitudes[0]
        return ScaledEstimate(peak, peak / (1 + most), peak / (1 + least), answer.method or model)
    law, pulse = moments_law(), pulse_of(shock)
    bound = law.bound(pulse)
    if math.isinf(bound):
        return None
    peak = float(law.amplification([pulse])[0])
    return ScaledEstimate(peak, peak / (1 + bound), peak / (1 - bound), "moments")


def expected_error(
    answer: ScaledAnswer, estimate: ScaledEstimate | None, conditions: Sequence[Condition]
) -> tuple[_Range, list[str]]:
    """Range of the relative error of the peak force of the leading wave, with warnings.

    Parameters
    ----------
    answer : ScaledAnswer
        Answer of a model, which can state its own range; any other answer is one of section 4.
    estimate : ScaledEstimate or None
        The `estimated` amplification.
    conditions : sequence of Condition
        Conditions (3); section 4 has no range where one of them fails.

    Returns
    -------
    tuple of float or None
        Lowest and highest relative error, or None if they are unknown.
    list of str
        Warnings that state why they are unknown.
    """
    if answer.states_error:
        return answer.expected_error, []
    failed = [f"{each.statement} fails by {-each.margin:.3g}" for each in conditions if not each.holds]
    if failed:
        return None, [f"Section 4 does not hold here: the shock violates the conditions (3) ({'; '.join(failed)})."]
    if estimate is None:
        return None, [warning_of(TOO_FAR)]
    peak = answer.amplitudes[0]
    return (peak / estimate.high - 1, peak / estimate.low - 1), []


def chain_problem(chain: Chain, duration: float, profile: ShockProfile) -> str:
    """Reason why the leading wave does not form in a finite chain; empty if it forms.

    ``duration`` is that of the shock over T0. The waves of several peaks separate slowly, so for them no finite chain
    is long enough.
    """
    if chain.granules is None:
        return ""
    if turns(profile):
        return f"in a chain of {chain.granules} granules the waves of several peaks may not separate"
    needed = math.ceil(_GRANULES + _GRANULES_PER_TIME * duration)
    if chain.granules >= needed:
        return ""
    return f"in a chain of {chain.granules} granules the leading wave does not form (it needs {needed} granules)"


def warning_of(problem: str) -> str:
    """Warning that a ``problem`` leaves the error unknown."""
    return f"The error is not known: {problem}. Simulate to obtain an accurate peak force."
