r"""Peak force of the leading wave in a chain with any exponent p of the contact force.

Time t is measured in units of P(F0)/F0, where P(F0) is the momentum of a wave of the shock's peak force F0, and force
in units of F0, so that the impulse int f dt is S. A shock of vanishing duration generates a leading wave of peak force
``I_p S^(2p/(p+1))``, and a lasting constant force f one of ``C_p f``; both factors depend on p alone. As in
`shockwave.prediction.moments`, F is the force for which the largest eigenvalue of

    psi(x) = int G(x - x') psi(x') f(x') dx' / F,    G(x) = G0 exp(-|x/w|^(p+1)),    x = t F^((p-1)/(2p))

is one, multiplied by a correction. I_p determines G0, and C_p the width w. The logarithm of the correction is a linear
combination of `terms` in three local measures of the shock, with coefficients that are cubic in 1/p.
``docs/fit_kernel_law.py`` computes all coefficients and measures the errors.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
from attrs import evolve, frozen

from shockwave.chain.chain import HERTZ
from shockwave.chain.solitary_wave import MOMENTUM, wave_law
from shockwave.prediction.model_interface import ScaledShock
from shockwave.prediction.shock_impulses import pulse_of
from shockwave.quadrature import FloatArray

#: File of the coefficients.
RESOURCE = "kernel_law.json"
#: p - 1 below which shocks were simulated only up to a spread that scales as the square of p - 1.
FULL_LENGTH = 0.25
#: Number of powers of 1.5/p - 1 in each coefficient of the correction.
POWERS = 4
# Width of the local measures in x, as in the law of moments.
_REACH = 1.2
# Most iterations of Newton's method for ln F, which starts from an upper bound, and the step at which it stops.
_MOST_STEPS = 60
_SETTLED = 1e-10
# Relative error of the limit I_p for p near 1.
_ROUNDING = 1e-7


@frozen
class KernelLaw:
    """Coefficients of the law.

    Attributes
    ----------
    impulse, lasting : sequence of float
        Chebyshev coefficients of ln(I_p - 1) and of ln C_p as functions of ln(p - 1).
    exponents : tuple of float
        Least and greatest p.
    correction : sequence of sequence of float
        For each term, the coefficients of the powers 0 to 3 of 1.5/p - 1.
    error_exponents, spreads : sequence of float
        Exponents p and spreads of the errors; a spread is the standard deviation of the force as a density in x.
    errors, turning_errors : sequence of sequence of float
        Relative errors of shocks with one peak and with several, a row for each exponent.
    farthest : float
        Largest spread for which errors were measured, from p = 1.25 on.
    """

    impulse: Sequence[float]
    lasting: Sequence[float]
    exponents: tuple[float, float]
    correction: Sequence[Sequence[float]]
    error_exponents: Sequence[float]
    spreads: Sequence[float]
    errors: Sequence[Sequence[float]]
    turning_errors: Sequence[Sequence[float]]
    farthest: float

    def limit(self, exponent: float) -> float:
        """I_p, the peak force of a shock of vanishing duration and the impulse of a wave of peak force 1."""
        return 1 + math.exp(self._series(self.impulse, exponent))

    def lasting_limit(self, exponent: float) -> float:
        """C_p, the amplification of a force that is switched on and lasts."""
        return math.exp(self._series(self.lasting, exponent))

    def _series(self, coefficients: Sequence[float], exponent: float) -> float:
        low, high = (math.log(end - 1) for end in self.exponents)
        place = (2 * math.log(exponent - 1) - low - high) / (high - low)
        # Clenshaw's recurrence
        one = two = 0.0
        for coefficient in coefficients[:0:-1]:
            one, two = coefficient + 2 * place * one - two, one
        return coefficients[0] + place * one - two

    def error(self, exponent: float, spread: float, turns: bool) -> float:
        """Relative error, interpolated by powers; below the first spread it scales as the square, like the terms."""
        place, known = math.log(exponent - 1), np.log(np.subtract(self.error_exponents, 1))
        table = np.log(self.turning_errors if turns else self.errors)
        row = [float(np.interp(place, known, column)) for column in table.T]
        short = 2 * min(math.log(spread / self.spreads[0]), 0.0)
        return math.exp(float(np.interp(math.log(spread), np.log(self.spreads), row)) + short) + _ROUNDING

    def peak(self, exponent: float, found: Solved) -> float:
        """F/F0 with the correction."""
        return math.exp(
            found.log_force + float(found.terms @ self.correction @ (HERTZ / exponent - 1) ** np.arange(POWERS))
        )

    def amplifications(self, shock: ScaledShock) -> tuple[float, float, float] | None:
        """Estimate of F/F0 and the ends of its range; None for a shock longer or faster-varying than those measured."""
        found = solved(self, shock)
        farthest = self.farthest * min((shock.exponent - 1) / FULL_LENGTH, 1.0) ** 2
        if not (found.known and found.spread <= farthest):
            return None
        peak, error = self.peak(shock.exponent, found), self.error(shock.exponent, found.spread, found.turns)
        return peak, peak / (1 + error), peak / (1 - error)


@frozen(eq=False)
class Solved:
    """Solution of the eigenvalue equation for one shock.

    Attributes
    ----------
    log_force, terms : float, numpy.ndarray, shape (5,)
        ln F/F0 without the correction, and the terms of the correction.
    spread, turns : float, bool
        Standard deviation of the force as a density in x; whether the shock has several peaks.
    known : bool
        Whether the moments of the shock are accurate and the iteration has converged.
    """

    log_force: float
    terms: FloatArray
    spread: float
    turns: bool
    known: bool


def solved(law: KernelLaw, shock: ScaledShock, stretch: float = 1.0) -> Solved:
    """Solve the eigenvalue equation for a shock of ``stretch`` times the duration, by Newton's method for ln F.

    The local measures are the averages over the instants, weighted by psi^2, of sum u - 1, of (sum u y)^2 and of
    sum u abs(y)^(5/2), where u are the weighted impulses near an instant and y their distances from it.
    """
    p, unit = shock.exponent, wave_law(shock.exponent).momentum
    # times in units of P(F0)/F0: `pulse_of` divides by the momentum for Hertz's law
    pulse = pulse_of(evolve(shock, rise_time=shock.rise_time * MOMENTUM / unit, exponent=HERTZ))
    lasting, peak = law.lasting_limit(p), law.limit(p) ** shock.of_momentum
    masses, off = peak * stretch * pulse.impulses, stretch * (pulse.times[:, None] - pulse.times)
    apart = np.abs(off * (2 * math.gamma(1 + 1 / (p + 1)) * peak / lasting)) ** (p + 1)
    roots = np.sqrt(np.outer(masses, masses))
    # the limits of a short and of a lasting force are both upper bounds
    log_force = min(math.log(masses.sum()) * shock.of_force, math.log(lasting))
    for _ in range(_MOST_STEPS):
        distance = apart * math.exp(log_force * shock.of_time * (p + 1))
        matrix = np.exp(-distance) * roots
        values, vectors = np.linalg.eigh(matrix)
        value, vector = values[-1], vectors[:, -1]
        slope = -shock.of_time * (p + 1) * float(vector @ (distance * matrix) @ vector) / value
        step = (math.log(value) - shock.of_momentum * log_force) / (shock.of_momentum - slope)
        log_force += step
        if abs(step) < _SETTLED:
            break
    scale = math.exp(log_force * shock.of_time)
    off *= scale
    near = np.exp(-((off / _REACH) ** 2)) * masses * math.exp(-log_force * shock.of_momentum)
    offset, share, distant = vector**2 @ np.stack(
        ((near * off).sum(axis=1) ** 2, near.sum(axis=1) - 1, (near * np.abs(off) ** 2.5).sum(axis=1)), axis=1
    )
    terms = np.array((offset, share, offset * distant, offset**2, share**2))
    spread = pulse.spread / (shock.impulse / unit) ** 0.2 * scale
    return Solved(log_force, terms, spread, pulse.turns, pulse.known and abs(step) < _SETTLED)


@cache
def kernel_law() -> KernelLaw:
    """Law from the file of coefficients, read once."""
    return KernelLaw(**json.loads((Path(__file__).parent / RESOURCE).read_text(encoding="utf-8"))["law"])


def too_long(shock: ScaledShock) -> str:
    """Reason why there is no estimate."""
    measured = "the shock is longer, or varies faster, than those for which errors were measured"
    return f"{measured} with the contact exponent {shock.exponent:g}; simulate"
