"""Estimate of the peak force with a range, and expected error of section 4, both from the law of moments.

The law of moments describes simulated peak forces of shocks of any shape with a known error. A predicted peak force
divided by both ends of the range of the law gives the range of its error. ``docs/trust.md`` reports how often the
errors of shocks that were not used in the fit lay in these ranges.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from attrs import frozen

from shockwave.prediction.model_interface import ScaledAnswer, ScaledShock
from shockwave.prediction.moments import FARTHEST, moments_law
from shockwave.prediction.shock_impulses import HIGHEST, pulse_of, turns
from shockwave.profiles.conditions import Condition
from shockwave.text import si

# Fewest granules in which the leading wave of a short shock forms, and additional ones per T0 of the duration.
_GRANULES = 40
_GRANULES_PER_TIME = 5

#: Warning for finite chains.
FIRST_CONTACTS = (
    "The greatest force in the chain can exceed that of the leading wave: at the first contacts by 19 % after a short "
    "shock, and by more after several blows. A simulation gives it."
)

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

    None if the shock is longer or finer than those of the law.
    """
    if answer.states_error and answer.expected_error is not None:
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
        Warnings on the conditions that fail.
    """
    if answer.states_error:
        return answer.expected_error, []
    failed = [f"{each.statement} fails by {-each.margin:.3g}" for each in conditions if not each.holds]
    if failed:
        return None, [f"Section 4 does not hold here: the shock violates the conditions (3) ({'; '.join(failed)})."]
    if estimate is None:
        return None, []
    peak = answer.amplitudes[0]
    return (peak / estimate.high - 1, peak / estimate.low - 1), []


def chain_problem(granules: int, shock: ScaledShock) -> str:
    """Reason why the leading wave does not form in a chain of so many granules; empty if it forms.

    The waves of several peaks separate slowly, so for them no finite chain is long enough.
    """
    where = f"in a chain of {granules} granules"
    if turns(shock):
        return f"{where} the waves of several peaks may not separate; simulate"
    needed = math.ceil(_GRANULES + _GRANULES_PER_TIME * shock.duration)
    return f"{where} the leading wave does not form (it needs {needed} granules); simulate" * (granules < needed)


def unbounded(shock: ScaledShock, force: float) -> str:
    """Reason why there is no estimate for a shock of peak force ``force`` [N], with what is known of its wave."""
    pulse = pulse_of(shock)
    if pulse.spread <= FARTHEST:
        return "the force varies too fast for its moments to be computed; simulate"
    problem = "the shock is longer than those for which errors were measured"
    if pulse.turns:
        return f"{problem}, and has several peaks; simulate its strongest part"
    return f"{problem}; at most {si(HIGHEST * force, 'N', digits=3)}, {HIGHEST:g} times the peak force of the shock"


def warning_of(problem: str) -> str:
    """Warning that a ``problem`` leaves the error unknown."""
    return f"The error is not known: {problem}."
