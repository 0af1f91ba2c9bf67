"""Peak force of the leading wave of a short shock in a chain with any exponent of the contact force.

A shock of vanishing duration and impulse L generates a leading wave of peak force ``I_p F0 S^(2p/(p+1))``, with S the
impulse over that of a wave of the shock's peak force F0; I_p depends on the exponent p alone. A longer shock generates
a weaker wave. If sigma is the standard deviation of the force as a density in time, and T the characteristic time of
the wave of the limit, ``ln(F / limit)`` lies between -0.47 (sigma/T)^2 and 0 for all exponents and shapes up to
sigma = T. ``docs/fit_impulse_law.py`` computes I_p and measures this range.
"""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

from attrs import frozen

from shockwave.chain.solitary_wave import wave_law
from shockwave.prediction.expected_error import failed_conditions, warning_of
from shockwave.prediction.model_interface import ScaledAnswer, ScaledShock
from shockwave.prediction.outcome import Accuracy, Estimate
from shockwave.prediction.shock_impulses import spread_of
from shockwave.profiles.shock import Shock

#: File of the coefficients.
RESOURCE = "impulse_law.json"
#: Name of the method of the estimate.
METHOD = "impulse"


@frozen
class ImpulseLaw:
    """Coefficients of the law.

    Attributes
    ----------
    coefficients : tuple of float
        Chebyshev coefficients of ln(I_p - 1) as a function of ln(p - 1).
    exponents : tuple of float
        Least and greatest p.
    decrease : float
        Largest decrease of ln F, over (sigma/T)^2.
    farthest : float
        Largest sigma/T for which the law was validated.
    """

    coefficients: tuple[float, ...]
    exponents: tuple[float, float]
    decrease: float
    farthest: float

    def limit(self, exponent: float) -> float:
        """I_p, the peak force of a shock of vanishing duration and the impulse of a wave of peak force 1."""
        low, high = (math.log(end - 1) for end in self.exponents)
        place = (2 * math.log(exponent - 1) - low - high) / (high - low)
        # Clenshaw's recurrence
        one = two = 0.0
        for coefficient in self.coefficients[:0:-1]:
            one, two = coefficient + 2 * place * one - two, one
        return 1 + math.exp(self.coefficients[0] + place * one - two)

    def amplifications(self, shock: ScaledShock) -> tuple[float, float, float] | None:
        """Estimate of F/F0 and the ends of its range; None for a shock that is longer than those of the law."""
        wave = wave_law(shock.exponent)
        limit = self.limit(shock.exponent)
        ratio = spread_of(shock) * wave.momentum * limit**wave.of_speed
        if not ratio <= self.farthest:
            return None
        most = limit * (shock.impulse / wave.momentum) ** shock.of_force
        least = most * math.exp(-self.decrease * ratio * ratio)
        return math.sqrt(least * most), least, most


@cache
def impulse_law() -> ImpulseLaw:
    """Law from the file of coefficients, read once."""
    return ImpulseLaw(**json.loads((Path(__file__).parent / RESOURCE).read_text(encoding="utf-8"))["law"])


def accuracy_of(shock: Shock, scaled: ScaledShock, answer: ScaledAnswer) -> Accuracy[Estimate | None, Any]:
    """Estimate by the law, and the range of the error of ``answer`` that it gives where the conditions (3) hold."""
    found, problem, error = impulse_law().amplifications(scaled), None, None
    failed = failed_conditions(scaled)
    if found is None:
        problem = (
            f"for a contact exponent other than 3/2 (here {scaled.exponent:g}) errors were measured for short shocks"
            " alone; simulate"
        )
    elif not failed:
        error = (answer.amplitudes[0] / found[2] - 1, answer.amplitudes[0] / found[1] - 1)
    warnings = [*[failed] * bool(failed), *answer.warnings, *([] if problem is None else [warning_of(problem)])]
    estimate = None
    if found is not None:
        peak, low, high = (ratio * shock.peak_force for ratio in found)
        estimate = Estimate(peak, low, high, METHOD)
    return Accuracy(estimate, problem, error, (*shock.profile.notes, *warnings))
