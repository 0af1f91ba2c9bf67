"""Estimate of the peak force with a range, and expected error of section 4, both from the law of moments.

The law of moments describes simulated peak forces of shocks of any shape with a known error. A predicted peak force
divided by both ends of the range of the law gives the range of its error. ``docs/trust.md`` reports how often the
errors of shocks that were not used in the fit lay in these ranges.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from shockwave.chain.chain import Chain
from shockwave.plausibility import unusual_warnings
from shockwave.prediction.model_interface import Peaks, ScaledAnswer, ScaledShock, Settings, Shocks
from shockwave.prediction.moments import FARTHEST, peaks
from shockwave.prediction.outcome import Accuracy, Estimate
from shockwave.prediction.shock_impulses import LASTING, spread_of, turns
from shockwave.profiles.conditions import conditions, hold
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.text import si

# Fewest granules in which the leading wave of a short shock forms; a longer one needs one more per T0 of its duration.
_FEWEST = 8
# Relative widening of the range of the wave in so short a chain: for long shocks at the lower and at the upper end, and
# for all shocks at both ends, before a wall and a free end.
_BELOW = 0.42
_ABOVE = 0.1
_AT_WALL = 0.003
_AT_FREE_END = 0.02
# Rate at which it decreases with the number of additional granules over the duration, and shortest long duration [T0].
_SETTLING = 0.65
_LONG = 5.0
# Additional widening for shocks of several peaks, whose waves have to separate, and its rate of decrease.
_SEVERAL_BELOW = 0.35
_SEVERAL_ABOVE = 0.05
_SEPARATING = 0.7

#: Warning for finite chains.
FIRST_CONTACTS = (
    "The greatest force in the chain can exceed that of the leading wave: at the first contacts by 19 % after a short "
    "shock, and by more after several blows or if the shock outlasts the passage of the wave. A simulation gives it."
)


def expected_errors(found: Peaks, shocks: Shocks) -> tuple[FloatArray, FloatArray]:
    """Estimates of peak forces, and ranges of the relative errors of predicted ones.

    The best estimate is that of a model that states its error, or that of the law of moments. A model that does not
    state its error is section 4, whose range follows from the estimate where the conditions (3) hold.

    Parameters
    ----------
    found : Peaks
        Predictions of a model.
    shocks : Shocks
        The shocks.

    Returns
    -------
    numpy.ndarray, shape (shocks, 3)
        Estimated amplification and the ends of its range; NaN for shocks that are longer or vary faster than those of
        the law.
    numpy.ndarray, shape (shocks, 2)
        Lowest and highest relative error; infinite if they are unknown.
    """
    own, errors = found.states_error & _bounded(found), np.stack((found.low, found.high), axis=1)
    if own.all():
        return _ranges(found), errors
    law = peaks(shocks, Settings())
    valid = hold(shocks.areas, [profile.duration_ratio for profile in shocks.profiles])
    known = ~found.states_error & np.isfinite(law.high) & valid[shocks.shapes]
    estimates = np.where(own[:, None], _ranges(found), _ranges(law))
    errors[known] = (found.amplification[:, None] / estimates[:, [2, 1]] - 1)[known]
    return estimates, errors


def _ranges(found: Peaks) -> FloatArray:
    """Amplifications and the ends of their ranges, shape (shocks, 3)."""
    bounds = np.stack((np.zeros(len(found.high)), found.high, found.low))
    with np.errstate(divide="ignore"):
        return np.where(_bounded(found), found.amplification / (1 + bounds), np.nan).T


def _bounded(found: Peaks) -> npt.NDArray[np.bool_]:
    """Whether the stated errors bound the peak forces."""
    return np.isfinite(found.high) & (found.low > -1)


def failed_conditions(shock: ScaledShock) -> str:
    """Warning that lists the conditions (3) that fail, with their margins; empty if all hold."""
    checked = conditions(shock.areas, shock.profile.duration_ratio)
    failed = "; ".join(f"{each.statement} fails by {-each.margin:.3g}" for each in checked if not each.holds)
    return f"Section 4 does not hold here: the shock violates the conditions (3) ({failed})." if failed else ""


def in_chain(
    chain: Chain, shock: ScaledShock, estimate: Sequence[float], error: Sequence[float]
) -> tuple[str, FloatArray, FloatArray]:
    """Estimate and range of the error in a chain, finite or not, from those in an endless one.

    Parameters
    ----------
    chain : Chain
        Equal granules with a free end or a fixed wall.
    shock : ScaledShock
        The shock.
    estimate, error : sequence of float
        Estimate with the ends of its range, and lowest and highest relative error, in an endless chain.

    Returns
    -------
    str
        Reason why the leading wave does not form; empty if it forms.
    numpy.ndarray, shape (3,)
        Estimate with the ends of its range; NaN if it does not form.
    numpy.ndarray, shape (2,)
        Range of the error; infinite if it does not form.
    """
    if chain.count is None:
        return "", np.array(estimate), np.array(error)
    duration = shock.duration
    spare = chain.count - _FEWEST - duration
    if spare < 0:
        where = f"in a chain of {chain.count} granules the leading wave does not form"
        problem = f"{where} (it needs {math.ceil(_FEWEST + duration)} granules); simulate"
        return problem, np.full(3, np.nan), np.array([-np.inf, np.inf])
    distance = spare / (duration + _LONG)
    decay, always = math.exp(-_SETTLING * distance), _AT_FREE_END if chain.end is None else _AT_WALL
    # blows within a short time act as one
    together = math.exp(-_SEPARATING * distance) * min(duration / _LONG, 1.0) ** 2 * turns(shock)
    below, above = (
        (each * duration / (duration + _LONG) + always) * decay + several * together
        for each, several in ((_BELOW, _SEVERAL_BELOW), (_ABOVE, _SEVERAL_ABOVE))
    )
    ends = np.array([1 - below, 1 + above])
    return "", np.multiply(estimate, [1, *ends]), (1 + np.array(error)) / ends[::-1] - 1


def unbounded(shock: ScaledShock, force: float) -> str:
    """Reason why there is no estimate for a shock of peak force ``force`` [N], with what is known of its wave."""
    if spread_of(shock) <= FARTHEST:
        return "the force varies too fast for its moments to be computed; simulate"
    problem = "the shock is longer than those for which errors were measured"
    if turns(shock):
        return f"{problem}, and has several peaks; simulate its strongest part"
    return f"{problem}; {si(LASTING * force, 'N', digits=3)} is the limit if it is smooth, and steps give more"


def warning_of(problem: str) -> str:
    """Warning that a ``problem`` leaves the error unknown."""
    return f"The error is not known: {problem}."


def accuracy_with_exponent(
    shock: Shock, chain: Chain, scaled: ScaledShock, answer: ScaledAnswer, model: str
) -> Accuracy[Estimate | None, Any]:
    """Accuracy for a contact exponent other than 3/2: the estimate is that of ``model`` or of the law of moments."""
    force, peak, own = shock.peak_force, answer.amplitudes[0], answer.expected_error
    failed = "" if answer.states_error else failed_conditions(scaled)
    warnings = [*shock.profile.notes, *unusual_warnings(shock, chain), *[failed] * bool(failed), *answer.warnings]
    if own is not None:
        estimate = Estimate(
            peak * force, peak * force / (1 + own[1]), peak * force / (1 + own[0]), answer.method or model
        )
        return Accuracy(estimate, None, own, tuple(warnings))
    from shockwave.prediction.kernel_law import kernel_law, too_long  # Hertz's law does not need it

    found = kernel_law().amplifications(scaled)
    if found is None:
        return Accuracy(None, too_long(scaled), None, (*warnings, warning_of(too_long(scaled))))
    best, low, high = found
    estimate = Estimate(best * force, low * force, high * force, "moments")
    return Accuracy(estimate, None, None if failed else (peak / high - 1, peak / low - 1), tuple(warnings))
