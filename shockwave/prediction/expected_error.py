"""Expected error of section 4 for a shock, from the errors observed in direct simulations.

Two laws describe the simulated peak forces of random shocks with built-in profiles. Each is a polynomial in integrals
of the shock, with the range of the residuals. ``docs/map_section4.py`` fits them and writes ``expected_error.json``.
The predicted peak force divided by both ends of the simulated range gives the range of the error. ``docs/trust.md``
reports how often the error of shocks that were not used in the fit lay in this range.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from functools import cache
from importlib import resources
from itertools import combinations_with_replacement

import numpy as np
from attrs import field, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.numerics import product
from shockwave.prediction.model_interface import ScaledAnswer, ScaledShock
from shockwave.prediction.shock_measures import Measures, measures
from shockwave.profiles.conditions import Condition, reversal
from shockwave.quadrature import FloatArray

#: Name of the file with the laws, beside this one.
RESOURCE = "expected_error.json"

# Largest ratio of the window of (5h) to the virtual shock for which the added momentum is meaningful.
_WIDEST_WINDOW = 0.165
# Largest reversal of the force, over the peak force, that noise causes; a larger one is a second peak.
_MOST_REVERSAL = 0.05
# Errors were measured with the exact coefficient of A; they are valid for coefficients within this relative distance.
_NEAR = 0.01
# Fewest granules in which the steady wave of a prediction forms.
_SHORT_CHAIN = 25

_Range = tuple[float, float] | None


@frozen(eq=False)
class Law:
    """Law for ln of F / (1.1681817 F0 S^(6/5)): a polynomial, the range of its residuals, and its range of validity.

    Attributes
    ----------
    name : str
        ``short``: tau^2 times a polynomial in tau and the skewness; ``long``: a polynomial in the logarithms of
        strength, mean force and cubic mean force.
    degree : int
        Degree of the polynomial.
    centre, scale : numpy.ndarray, shape (inputs,)
        Shift and scale by which the inputs are standardised.
    basis : numpy.ndarray, shape (terms, terms)
        Matrix that converts a row of monomials to polynomials that are orthonormal over the simulated shocks.
    coefficients : numpy.ndarray, shape (terms,)
        Coefficients of these polynomials.
    farthest : float
        Largest mean square of the polynomials, 1 on average, for which a shock is similar to the simulated ones.
    bounds, low, high : numpy.ndarray, shape (bands,)
        Upper ends of the bands of the first input, before its shift; lowest and highest residual in each band.
    longest : float
        Longest duration n t0/T0 that was simulated.
    shocks : sequence of int
        Number of simulated shocks in each band.
    """

    name: str
    degree: int
    centre: FloatArray = field(converter=np.array)
    scale: FloatArray = field(converter=np.array)
    basis: FloatArray = field(converter=np.array)
    coefficients: FloatArray = field(converter=np.array)
    farthest: float
    bounds: FloatArray = field(converter=np.array)
    low: FloatArray = field(converter=np.array)
    high: FloatArray = field(converter=np.array)
    longest: float = math.inf
    shocks: Sequence[int] = ()

    def inputs(self, found: Measures) -> FloatArray:
        """Inputs of this law, shape (inputs,)."""
        return np.array([found.spread, found.skewness]) if self.name == "short" else found.logarithms()

    def polynomials(self, inputs: FloatArray) -> FloatArray:
        """Orthonormal polynomials, shape (..., terms), at ``inputs``, shape (..., inputs)."""
        return product(monomials((inputs - self.centre) / self.scale, self.degree), self.basis)

    def bounds_of(self, found: Measures) -> _Range:
        """Lowest and highest simulated peak force over F0, or None outside the range of validity."""
        inputs = self.inputs(found)
        terms = self.polynomials(inputs)
        if inputs[0] > self.bounds[-1] or np.mean(terms**2) > self.farthest or found.duration > self.longest:
            return None
        band = int(np.searchsorted(self.bounds, inputs[0]))
        logarithm = float((terms * self.coefficients).sum()) * (found.spread**2 if self.name == "short" else 1.0)
        impulse_limit = IMPULSE_LIMIT * found.strength**1.2
        low, high = (impulse_limit * math.exp(logarithm + float(ends[band])) for ends in (self.low, self.high))
        return low, high


def monomials(inputs: FloatArray, degree: int) -> FloatArray:
    """All products of up to ``degree`` inputs, shape (..., terms), from ``inputs``, shape (..., inputs)."""
    count = inputs.shape[-1]
    picks = [pick for power in range(degree + 1) for pick in combinations_with_replacement(range(count), power)]
    return np.stack([np.prod(inputs[..., list(pick)], axis=-1) for pick in picks], axis=-1)


@cache
def laws() -> tuple[Law, Law]:
    """Laws of short and of long shocks, read once."""
    entries = json.loads(resources.files(__package__).joinpath(RESOURCE).read_text(encoding="utf-8"))["laws"]
    return Law("short", **entries["short"]), Law("long", **entries["long"])


def expected_error(
    answer: ScaledAnswer, shock: ScaledShock, conditions: Sequence[Condition]
) -> tuple[_Range, list[str]]:
    """Range of the relative error of the peak force of the leading wave, with warnings.

    Parameters
    ----------
    answer : ScaledAnswer
        Answer of a model, which can state its own range; any other answer is one of section 4. ``answer.trust`` is None
        if no errors were measured for the interpretation in use.
    shock : ScaledShock
        The shock.
    conditions : sequence of Condition
        Conditions (3); errors were measured only for shocks that satisfy all of them.

    Returns
    -------
    tuple of float or None
        Lowest and highest relative error, or None if they are unknown.
    list of str
        Warnings that state why they are unknown.
    """
    if answer.states_error:
        return answer.expected_error, []
    reason = _unmeasured(answer, shock, conditions)
    if reason:
        return None, [reason]
    found = measures(shock)
    short, long = laws()
    law = short if found and found.spread <= short.bounds[-1] else long
    simulated = law.bounds_of(found) if found else None
    if simulated is None:
        return None, [
            "The error of section 4 is not known for this shock: it is longer than the shocks for which errors were"
            " measured, or its shape differs from theirs. A simulation gives the accurate peak force."
        ]
    low, high = simulated
    peak = answer.amplitudes[0]
    return (peak / high - 1, peak / low - 1), []


def _unmeasured(answer: ScaledAnswer, shock: ScaledShock, conditions: Sequence[Condition]) -> str:
    """Sentences that state why no range was measured; empty if one may have been."""
    failed = [f"{each.statement} fails by {-each.margin:.3g}" for each in conditions if not each.holds]
    turn = reversal(shock.profile)
    if failed:
        reason = f"The shock violates the conditions (3) of section 4 ({'; '.join(failed)})"
    elif turn > _MOST_REVERSAL:
        reason = f"The shock has several peaks (its force reverses by {turn:.0%} of the peak force)"
    elif answer.trust is None or abs(shock.momentum_parameter / MOMENTUM - 1) > _NEAR:
        reason = "This interpretation of section 4, or this coefficient of A, differs from that of the measured errors"
    elif answer.regime == "ejection" and answer.trust > _WIDEST_WINDOW:
        window = f"The correction window of (5h) is {answer.trust:.2f} times the virtual shock"
        reason = f"{window}, and errors have no useful bound above {_WIDEST_WINDOW}"
    else:
        return ""
    return f"{reason}, so the error is not known. A simulation gives the accurate peak force."


def chain_warnings(chain: Chain, states_error: bool) -> list[str]:
    """Warnings for a finite chain for which the expected error is not valid; empty if it is valid.

    Errors were measured on endless chains. The error that a model itself states is valid only for endless chains.
    """
    if chain.granules is None or (chain.granules >= _SHORT_CHAIN and not states_error):
        return []
    if chain.granules < _SHORT_CHAIN:
        problem = "is too short for the predicted steady wave to form, so the error is not known"
    else:
        problem = "is treated as endless, and the error of this approximation is not known"
    advice = "A simulation takes the free end into account."
    return [f"The chain of {chain.granules} granules {problem}. {advice}"]
