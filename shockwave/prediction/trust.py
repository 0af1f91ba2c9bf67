"""How far section 4 can be trusted: errors of the primary's peak force, as direct simulation has shown them.

What simulation gives was measured for random shocks of the built-in kinds and put into two laws, each a polynomial in
integrals of the shock with the spread of the simulated figures about it; ``section4.json`` holds them, and
``docs/map_section4.py`` makes that file. A range of errors is the predicted peak force over both ends of the simulated
one. ``docs/trust.md`` tells how often the error lay in the range for shocks that had no part in the laws.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from functools import cache
from importlib import resources
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from attrs import frozen

from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.numerics import product
from shockwave.prediction.measures import Measures, measures
from shockwave.prediction.scaled import ScaledAnswer, ScaledShock
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.conditions import Condition, reversal
from shockwave.quadrature import FloatArray

__all__ = ["RESOURCE", "Law", "Measures", "expected_error", "laws", "measures", "told"]

#: Name of the file with the laws, beside this one.
RESOURCE = "section4.json"

# Window of (5h) over the virtual shock: beyond, its added momentum means nothing, whatever the range would say.
_WIDEST_WINDOW = 0.165
# Noise turns a record by so much; more is a second peak.
_MOST_REVERSAL = 0.05
# An upper end above this is a warning of its own.
_USELESS = 0.5
# Errors were measured with the exact coefficient of A; they hold for others as near as the paper's.
_NEAR = 0.01


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
    """

    name: str
    degree: int
    centre: FloatArray
    scale: FloatArray
    basis: FloatArray
    coefficients: FloatArray
    farthest: float
    bounds: FloatArray
    low: FloatArray
    high: FloatArray
    longest: float = math.inf

    @classmethod
    def of(cls, name: str, entries: dict[str, Any]) -> Law:
        """From what the file holds under ``name``."""
        known: dict[str, Any] = {key: value for key, value in entries.items() if key != "shocks"}
        known |= {key: np.array(value) for key, value in known.items() if isinstance(value, list)}
        return cls(name, **known)

    def inputs(self, found: Measures) -> FloatArray:
        """The inputs of this law, shape (inputs,)."""
        return np.array([found.spread, found.skewness]) if self.name == "short" else found.logarithms()

    def polynomials(self, inputs: FloatArray) -> FloatArray:
        """The orthonormal polynomials at ``inputs``, shape (..., inputs): shape (..., terms)."""
        return product(monomials((inputs - self.centre) / self.scale, self.degree), self.basis)

    def bounds_of(self, found: Measures) -> tuple[float, float] | None:
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
    text = resources.files(__package__).joinpath(RESOURCE).read_text(encoding="utf-8")
    entries = json.loads(text)["laws"]
    return Law.of("short", entries["short"]), Law.of("long", entries["long"])


_LATER_ABOVE = (
    "no error was measured for this reading of section 4 where a later wave is predicted above the primary: simulate,"
    " or take model moments"
)


def told(
    answer: ScaledAnswer, shock: ScaledShock, conditions: Sequence[Condition]
) -> tuple[tuple[float, float] | None, list[str]]:
    """The range of errors that the model itself tells of its answer, or else that measured for section 4."""
    if answer.tells_error:
        return answer.expected_error, []
    return expected_error(answer, shock, conditions, abs(shock.momentum_parameter / MOMENTUM - 1) < _NEAR)


def expected_error(
    answer: ScaledAnswer, shock: ScaledShock, conditions: Sequence[Condition], near: bool = True
) -> tuple[tuple[float, float] | None, list[str]]:
    """The measured range of the relative error of the primary's peak force, or None; and sentences on it.

    Parameters
    ----------
    answer : ScaledAnswer
        What section 4 makes of the shock; its ``trust`` is None when errors were not measured for the reading in use.
    shock : ScaledShock
        The shock.
    conditions : sequence of Condition
        The inequalities (3): errors were measured only where all hold.
    near : bool
        Whether the coefficient of A is near the exact one.
    """
    doubts = _why_not(answer, shock.profile, conditions, near)
    if doubts:
        return None, doubts
    found = measures(shock)
    simulated = None if found is None else _simulated(found)
    if simulated is None:
        return None, [
            "the shock is longer, or of another shape, than those whose errors were measured: simulate to know"
        ]
    low, high = (answer.amplitudes[0] / end - 1 for end in reversed(simulated))
    if high > _USELESS and answer.regime == "ejection":
        doubts.append("(5h) adds more momentum than the shock has to give: simulate instead")
    return (low, high), doubts


def _simulated(found: Measures) -> tuple[float, float] | None:
    short, long = laws()
    return (short if found.spread <= short.bounds[-1] else long).bounds_of(found)


def _why_not(answer: ScaledAnswer, profile: ShockProfile, conditions: Sequence[Condition], near: bool) -> list[str]:
    """Why no range is told; empty if one may be."""
    broken = [condition for condition in conditions if not condition.holds]
    if broken:
        listed = "; ".join(f"{c.statement} fails by {-c.margin:.3g}" for c in broken)
        return [f"outside the conditions (3) no error was measured for section 4: {listed}"]
    turns = reversal(profile)
    if turns > _MOST_REVERSAL:
        return [f"the shock has several peaks (it turns by {turns:.0%} of its peak): simulate to know"]
    if answer.trust is None and near and answer.regime == "train" and max(answer.amplitudes) > answer.amplitudes[0]:
        return [_LATER_ABOVE]
    if answer.trust is None or not near:
        return ["no error was measured for this reading of section 4: simulate to know"]
    if answer.regime == "ejection" and answer.trust > _WIDEST_WINDOW:
        return [
            f"the correction window of (5h) is {answer.trust:.2f} of the virtual shock; beyond 0.165 its error has"
            " no useful bound (+2277 % was measured, and it grows as the shock shortens): simulate instead"
        ]
    return []
