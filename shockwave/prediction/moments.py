r"""The law of the primary's peak force: one kernel, and a correction by local measures.

Time t is measured in A F0^(-1/6), the force f(t) in F0, so that the impulse int f dt is S. The primary, of peak
force F, sees the pulse on its own scales: x = t F^(1/6), and impulses over those of a wave, f dt / F^(5/6). With the
kernel G(x) = G0 exp(-|x/w|^(5/2)) the law says that F is the force for which the largest eigenvalue of

    psi(x) = int G(x - x') psi(x') f(x') dx' / F

is one, times the exponential of a short sum of products of local measures (`columns`), which vanishes with the 5/2-th
power of the duration. Two limits fix the kernel. All impulse at one instant gives F = (G0 S)^(6/5), so that G0^(6/5) =
1.1681817. A force f that lasts for ever gives F = f int G dx. The power 5/2 is that by which a short pulse falls short
of an impulse: the path of the granule gives a contact force of the power 3/2 in time, and that force a momentum.

The pulse enters by its moments: `shockwave.prediction.shock_measures` makes of it a few impulses with the same first
moments. Integral and eigenvector are then sums and a small matrix.

``moments.json`` holds the coefficients, ``docs/fit_moments.py`` makes them, ``docs/moments.md`` reports how they were
judged.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from functools import cache
from importlib import resources

import numpy as np
from attrs import field, frozen

from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.errors import NumericalError
from shockwave.prediction.model_interface import (
    Model,
    Peaks,
    ScaledAnswer,
    ScaledEjection,
    ScaledShock,
    Settings,
    Shocks,
)
from shockwave.prediction.section4 import regime, relation_of
from shockwave.prediction.shock_measures import Pulse, pulse_of
from shockwave.quadrature import FloatArray

#: Name of the file with the coefficients, beside this one.
RESOURCE = "moments.json"
#: Names of the local measures, in the order of the columns.
COLUMNS = ("apart", "before", "after", "before_up", "after_up", "lean", "tilt", "offset", "square", "share", "scatter")

_G0 = IMPULSE_LIMIT ** (5 / 6)
_POWER = 2.5
_MOST_STEPS = 60
# Step of ln F at which it has settled.
_SETTLED = 1e-9
_STEP = 1e-4  # of ln t0, for the derivative


@frozen(eq=False)
class Law:
    """Coefficients of the law.

    Attributes
    ----------
    step_limit : float
        Amplification of a force that lasts for ever, int G dx.
    reach : float
        Of the local measures, in x: they count an impulse at a distance x by exp(-(x/reach)^2).
    terms : sequence of sequence of str
        The products of columns in the correction.
    coefficients : numpy.ndarray, shape (terms,)
        Of these products.
    spreads, errors : numpy.ndarray, shape (knots,)
        Relative error to be expected, at spreads tau; between them powers, below the first one the power 5/2.
    """

    step_limit: float
    reach: float
    terms: Sequence[Sequence[str]]
    coefficients: FloatArray = field(converter=np.array)
    spreads: FloatArray = field(converter=np.array)
    errors: FloatArray = field(converter=np.array)

    @property
    def width(self) -> float:
        """w of the kernel: int G dx = 2 Gamma(7/5) w G0."""
        return float(self.step_limit / (2 * math.gamma(1 + 1 / _POWER) * _G0))

    def products(self, found: FloatArray) -> FloatArray:
        """The products in the correction, shape (..., terms), of columns of shape (..., columns)."""
        picks = [[COLUMNS.index(name) for name in names] for names in self.terms]
        return np.stack([np.prod(found[..., pick], axis=-1) for pick in picks], axis=-1)

    def corrected(self, log_force: FloatArray, found: FloatArray) -> FloatArray:
        """Amplification F/F0 of pulses, shape (...), from the kernel's ln F and columns of shape (..., columns)."""
        return np.asarray(np.exp(log_force + (self.products(found) * self.coefficients).sum(axis=-1)))

    def error(self, spread: FloatArray | float) -> FloatArray:
        """Relative error to be expected at a spread tau, same shape; it was measured up to the last of ``spreads``."""
        logarithm = np.log(np.maximum(spread, 1e-300))
        known = np.interp(logarithm, np.log(self.spreads), np.log(self.errors))
        short = _POWER * np.minimum(logarithm - math.log(self.spreads[0]), 0)
        # the error of 1.1681817 itself, to its last digit, and a share of the smallest error that could be measured
        return np.asarray(np.exp(known + short) + min(5e-8, float(self.errors[0])))

    def bound(self, pulse: Pulse) -> float:
        """The error to be expected of a pulse; infinite where none was measured."""
        measured = pulse.known and pulse.spread <= self.spreads[-1]
        return float(self.error(pulse.spread)) if measured else math.inf

    def amplification(self, pulses: Sequence[Pulse]) -> FloatArray:
        """F/F0 of pulses, shape (pulses,)."""
        return self.corrected(*evaluated(self, pulses))


@cache
def moments_law() -> Law:
    """The law, read once."""
    text = resources.files(__package__).joinpath(RESOURCE).read_text(encoding="utf-8")
    return Law(**json.loads(text)["law"])


def evaluated(law: Law, pulses: Sequence[Pulse]) -> tuple[FloatArray, FloatArray]:
    """The kernel's ln F/F0, shape (pulses,), and the columns, shape (pulses, columns)."""
    log_force = np.empty(len(pulses))
    found = np.empty((len(pulses), len(COLUMNS)))
    for row, pulse in enumerate(pulses):
        log_force[row], weights = kernel_force(law, pulse)
        found[row] = columns(law, pulse, log_force[row], weights)
    return log_force, found


# ---------------------------------------------------------------- the kernel and the local measures


def kernel_force(law: Law, pulse: Pulse) -> tuple[float, FloatArray]:
    """ln F/F0 of a pulse by the kernel alone, and the weights m psi^2 of its impulses, of sum 1, shape (k,).

    Raises
    ------
    NumericalError
        When the eigenvalue does not settle.
    """
    apart = np.abs(pulse.times[:, None] - pulse.times) / law.width
    root = np.sqrt(pulse.impulses)
    # Both limits are upper bounds.
    log_force = min(1.2 * math.log(_G0 * pulse.impulses.sum()), math.log(law.step_limit))
    for _ in range(_MOST_STEPS):
        power = (apart * math.exp(log_force / 6)) ** _POWER
        matrix = _G0 * np.exp(-power) * root[:, None] * root
        values, vectors = np.linalg.eigh(matrix)
        eigenvalue, vector = float(values[-1]), vectors[:, -1]
        # d ln(eigenvalue) / d ln F is this over six.
        slope = -_POWER * float(vector @ (power * matrix) @ vector) / eigenvalue
        step = (1.2 * math.log(eigenvalue) - log_force) / (1 - 0.2 * slope)
        log_force += step
        if abs(step) < _SETTLED:
            return log_force, vector**2
    raise NumericalError("the kernel of the law of moments has no settled eigenvalue for this pulse: simulate it")


def columns(law: Law, pulse: Pulse, log_force: float, weights: FloatArray) -> FloatArray:
    """The local measures of a pulse, shape (columns,), with what `kernel_force` returns.

    Each instant x_i has the impulses m_j F^(-5/6) around it, u_ij = G0 m_j F^(-5/6) exp(-((x_i - x_j)/reach)^2), with
    the sums N = sum u_ij, D = sum u_ij (x_i - x_j), Q = sum u_ij (x_i - x_j)^2, and B and A, the parts of D with x_j
    before and after x_i, both positive. With means < > over the instants, by the weights m_i psi_i^2:

    ==========  ==================================  ==========  ==================================
    apart       < sum u_ij abs(x_i - x_j)^(5/2) >   lean, tilt  < D^3 >, < D Q >
    before      < B^(5/2) >                         offset      < D^2 >
    after       < A^(5/2) >                         square      < Q >
    before_up   < B^(7/2) >                         share       < N > - 1
    after_up    < A^(7/2) >                         scatter     < N^2 > - < N >^2
    ==========  ==================================  ==========  ==================================
    """
    x = pulse.times * math.exp(log_force / 6)
    strength = _G0 * pulse.impulses * math.exp(-log_force * (5 / 6))
    off = x[:, None] - x
    distance = np.abs(off)
    near = np.exp(-((off / law.reach) ** 2)) * strength
    total = near.sum(axis=1)
    directed = (near * off).sum(axis=1)
    length = (near * distance).sum(axis=1)
    squared = (near * off * off).sum(axis=1)
    before = np.maximum(length + directed, 0) / 2
    after = np.maximum(length - directed, 0) / 2
    share = total - 1
    local = (
        (near * distance * distance * np.sqrt(distance)).sum(axis=1),
        before**2.5,
        after**2.5,
        before**3.5,
        after**3.5,
        directed**3,
        directed * squared,
        directed**2,
        squared,
        share,
        (share - (weights * share).sum()) ** 2,
    )
    return np.array([(weights * each).sum() for each in local])


# ---------------------------------------------------------------- the model


def predict(shock: ScaledShock, settings: Settings) -> ScaledAnswer:
    """The primary of a scaled shock by the law; the regime by (5d), (5e), the relation by the peak force."""
    pulse = pulse_of(shock)
    law = moments_law()
    stretched = [pulse.stretched(math.exp(step)) for step in (0.0, _STEP, -_STEP)]
    peak, longer, shorter = law.amplification(stretched).tolist()
    sensitivity = -math.log(longer / shorter) / (2 * _STEP)
    warnings = ["the law of moments predicts the primary alone: later waves of a train are not listed"]
    bound = law.bound(pulse)
    if math.isinf(bound):
        warnings.append("the shock is longer, or finer, than those on which the law was judged: simulate to know")
    return answer(shock, settings, peak, bound, sensitivity, warnings)


def answer(
    shock: ScaledShock,
    settings: Settings,
    peak: float,
    bound: float,
    sensitivity: float | None,
    warnings: Sequence[str] = (),
) -> ScaledAnswer:
    """The answer for a shock of which the primary alone is predicted, of amplification ``peak`` within ``bound``."""
    kind, trace = regime(shock)
    return ScaledAnswer(
        kind,
        relation_of(peak, settings.equal_tolerance),
        (peak,),
        trace,
        sensitivity,
        ejection=_ejection(shock, peak) if kind == "ejection" else None,
        roots=(peak,) if kind == "train" else (),
        warnings=tuple(warnings),
        states_error=True,
        expected_error=None if math.isinf(bound) else (-bound, bound),
    )


def peaks(shocks: Shocks, settings: Settings) -> Peaks:
    """The primaries of many shocks by the law."""
    law = moments_law()
    results = Peaks.of(len(shocks))
    results.method[:] = "moments"
    for index in range(len(shocks)):
        pulse = pulse_of(shocks.shock(index))
        results.amplification[index] = law.amplification([pulse])[0]
        results.high[index] = law.bound(pulse)
    results.low[:] = -results.high
    return results


#: The model as it is registered.
MODEL = Model(predict, peaks)


def _ejection(shock: ScaledShock, peak: float) -> ScaledEjection:
    """The virtual rise time of (5g), and as added momentum what the primary has beyond the shock's impulse.

    A single wave leaves that to the rebounding granules, as momentum the other way: 0.1383 of the impulse of a short
    shock.
    """
    virtual = shock.momentum_parameter / shock.areas.total
    window = 1 - shock.impulse / shock.momentum_parameter
    added = MOMENTUM * peak ** (5 / 6) - shock.impulse
    return ScaledEjection(virtual, added, window / shock.profile.duration_ratio)
