"""Estimate of the peak force with a range, and expected error of section 4, both from the law of moments.

The law of moments describes simulated peak forces of shocks of any shape with a known error. A predicted peak force
divided by both ends of the range of the law gives the range of its error. ``docs/trust.md`` reports how often the
errors of shocks that were not used in the fit lay in these ranges.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from shockwave.prediction.model_interface import Peaks, ScaledShock, Settings, Shocks
from shockwave.prediction.moments import FARTHEST, peaks
from shockwave.prediction.shock_impulses import LASTING, spread_of, turns
from shockwave.profiles.conditions import Condition, conditions
from shockwave.quadrature import FloatArray
from shockwave.text import si

# Fewest granules in which the leading wave of a short shock forms, and additional ones per T0 of the duration.
_GRANULES = 40
_GRANULES_PER_TIME = 5

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
        Estimated amplification and the ends of its range; NaN for shocks that are longer or finer than those of the
        law.
    numpy.ndarray, shape (shocks, 2)
        Lowest and highest relative error; infinite if they are unknown.
    """
    own, errors = found.states_error & _bounded(found), np.stack((found.low, found.high), axis=1)
    if own.all():
        return _ranges(found), errors
    law, shapes = peaks(shocks, Settings()), zip(shocks.areas, shocks.profiles, strict=True)
    failed = [violations(conditions(areas, profile.duration_ratio)) for areas, profile in shapes]
    known = ~found.states_error & np.isfinite(law.high) & (np.array(failed)[shocks.shapes] == "")
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


def violations(checked: Sequence[Condition]) -> str:
    """The conditions (3) that fail, with their margins; empty if all hold."""
    return "; ".join(f"{each.statement} fails by {-each.margin:.3g}" for each in checked if not each.holds)


def chain_problem(granules: int, shock: ScaledShock) -> str:
    """Reason why the leading wave does not form in a chain of so many granules; empty if it forms.

    The waves of several peaks separate slowly, so for them no finite chain is long enough.
    """
    where = f"in a chain of {granules} granules"
    if turns(shock):
        return f"{where} the waves of several peaks may not separate; simulate"
    needed = math.ceil(_GRANULES + _GRANULES_PER_TIME * shock.duration)
    return f"{where} the leading wave may not form (it needs {needed} granules); simulate" * (granules < needed)


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
