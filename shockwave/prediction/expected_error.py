"""Errors of section 4 to be expected of a shock, from errors that direct simulation has shown.

Simulated peak forces of random shocks of the built-in kinds are described by two laws, each a polynomial in
integrals of the shock with the spread of the simulated figures about it; ``expected_error.json`` holds them, and
``docs/map_section4.py`` makes that file. A range of errors is the predicted peak force over both ends of the simulated
one. ``docs/trust.md`` reports how often the error lay in the range for shocks that had no part in the laws.
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

# Window of (5h) over the virtual shock: beyond, its added momentum means nothing, whatever the range would say.
_WIDEST_WINDOW = 0.165
# Noise turns a record by so much; more is a second peak.
_MOST_REVERSAL = 0.05
# Errors were measured with the exact coefficient of A; they hold for others as near as the paper's.
_NEAR = 0.01
# Below this many granules the steady wave of a prediction has not formed.
_SHORT_CHAIN = 25

_Range = tuple[float, float] | None


@frozen(eq=False)
class Law:
    """ln of F / (1.1681817 F0 S^(6/5)): a polynomial, the spread about it, and how far out it holds.

    Attributes
    ----------
    name : str
        ``short``: tau^2 times a polynomial in tau and the skewness; ``long``: a polynomial in the logarithms of
        strength, mean force and cubic mean force.
    degree : int
        Of the polynomial.
    centre, scale : numpy.ndarray, shape (inputs,)
        The inputs are shifted and divided by these.
    basis : numpy.ndarray, shape (terms, terms)
        Makes of the monomials, a row, polynomials that are orthonormal over the shocks that were simulated.
    coefficients : numpy.ndarray, shape (terms,)
        Of these polynomials.
    farthest : float
        Mean square of the polynomials, 1 on average, beyond which a shock is unlike those that were simulated.
    bounds, low, high : numpy.ndarray, shape (bands,)
        Of the first input before shift: upper ends of its bands; lowest and highest difference from the polynomial.
    longest : float
        Of the durations n t0/T0.
    shocks : sequence of int
        How many simulated shocks each band rests on.
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
        """The inputs of this law, shape (inputs,)."""
        return np.array([found.spread, found.skewness]) if self.name == "short" else found.logarithms()

    def polynomials(self, inputs: FloatArray) -> FloatArray:
        """The orthonormal polynomials at ``inputs``, shape (..., inputs): shape (..., terms)."""
        return product(monomials((inputs - self.centre) / self.scale, self.degree), self.basis)

    def bounds_of(self, found: Measures) -> _Range:
        """Lowest and highest simulated peak force over F0, or None where the law was not measured."""
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
    """All products of up to ``degree`` of the inputs, shape (..., inputs): shape (..., terms)."""
    count = inputs.shape[-1]
    picks = [pick for power in range(degree + 1) for pick in combinations_with_replacement(range(count), power)]
    return np.stack([np.prod(inputs[..., list(pick)], axis=-1) for pick in picks], axis=-1)


@cache
def laws() -> tuple[Law, Law]:
    """The laws of short and of long shocks, read once."""
    entries = json.loads(resources.files(__package__).joinpath(RESOURCE).read_text(encoding="utf-8"))["laws"]
    return Law("short", **entries["short"]), Law("long", **entries["long"])


def expected_error(
    answer: ScaledAnswer, shock: ScaledShock, conditions: Sequence[Condition]
) -> tuple[_Range, list[str]]:
    """The range of the relative error of the primary's peak force, None if unknown; and sentences on it.

    Parameters
    ----------
    answer : ScaledAnswer
        A model's answer, which may state its own range; the others are those of section 4. Its ``trust`` is None when
        errors were not measured for the reading in use.
    shock : ScaledShock
        The shock.
    conditions : sequence of Condition
        The inequalities (3): errors were measured only where all hold.
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
        return None, ["the shock is longer, or of another shape, than those that were measured: simulate to know"]
    low, high = simulated
    peak = answer.amplitudes[0]
    return (peak / high - 1, peak / low - 1), []


def _unmeasured(answer: ScaledAnswer, shock: ScaledShock, conditions: Sequence[Condition]) -> str:
    """Why there is no range; empty if there may be one."""
    broken = [f"{each.statement} fails by {-each.margin:.3g}" for each in conditions if not each.holds]
    if broken:
        return f"outside the conditions (3) no error was measured for section 4: {'; '.join(broken)}"
    turns = reversal(shock.profile)
    if turns > _MOST_REVERSAL:
        return f"the shock has several peaks (it turns by {turns:.0%} of its peak): simulate to know"
    if answer.trust is None or abs(shock.momentum_parameter / MOMENTUM - 1) > _NEAR:
        return "no error was measured for this reading of section 4: simulate to know"
    if answer.regime == "ejection" and answer.trust > _WIDEST_WINDOW:
        window = f"the correction window of (5h) is {answer.trust:.2f} of the virtual shock"
        return f"{window}; beyond 0.165 its error has no useful bound: simulate instead"
    return ""


def chain_warnings(chain: Chain, states_error: bool) -> list[str]:
    """Sentences on a finite chain for which the expected error does not hold; empty where it holds.

    Errors were measured on endless chains; those that a model states itself hold there alone, to many digits.
    """
    if chain.granules is None or (chain.granules >= _SHORT_CHAIN and not states_error):
        return []
    if chain.granules < _SHORT_CHAIN:
        return [f"a chain of {chain.granules} granules is too short for the steady wave that is predicted"]
    error = f"of a chain of {chain.granules} granules the error is not known"
    return [f"{error}: the peak force is that of an endless chain (simulate to know)"]
