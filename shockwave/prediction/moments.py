r"""The law of moments for the peak force of the leading wave: a kernel, and a correction by local measures.

Time t is measured in units of A F0^(-1/6) and the force f(t) in units of F0, so that the impulse int f dt is S. On the
scale of the leading wave, of peak force F, time is x = t F^(1/6), and impulses relative to that of the wave are
f dt / F^(5/6). With the kernel G(x) = G0 exp(-|x/w|^(5/2)), F is the force for which the largest eigenvalue of

    psi(x) = int G(x - x') psi(x') f(x') dx' / F

is one, multiplied by a correction: the exponential of a linear combination of products of local measures (`columns`).
The correction vanishes for short shocks as the 5/2-th power of the duration. Two limits determine the kernel. If the
whole impulse is applied at one instant, F = (G0 S)^(6/5), so that G0^(6/5) = 1.1681817. A constant force f gives
F = f int G dx. The power 5/2 is that of the deviation of a short pulse from the impulse limit: the displacement of the
first granule, linear in time, gives a contact force of power 3/2 in time, whose momentum has the power 5/2.

`shockwave.prediction.shock_impulses` represents the pulse by a few impulses with the same lowest moments. The integral
is then a sum, and the eigenvector that of a small matrix.

``moments.json`` contains the coefficients, ``docs/fit_moments.py`` computes them, and ``docs/moments.md`` describes
their validation.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from functools import cache
from itertools import zip_longest
from pathlib import Path

import numpy as np
from attrs import field, frozen

from shockwave.chain.chain import HERTZ
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, wave_law
from shockwave.errors import NumericalError
from shockwave.prediction.gauss_impulses import compiled
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
from shockwave.prediction.shock_impulses import Pulse, alike, pulse_of, pulses_of
from shockwave.quadrature import FloatArray

#: Name of the file with the coefficients, beside this one.
RESOURCE = "moments.json"
#: Names of the local measures, in the order of the columns.
COLUMNS = ("apart", "before", "after", "before_up", "after_up", "lean", "tilt", "offset", "square", "share", "scatter")

# Value of the kernel at 0, from the impulse limit.
_G0 = IMPULSE_LIMIT ** (5 / 6)
# Exponent in the kernel, from the deviation of a short pulse from the impulse limit.
_POWER = 2.5
# Power of the spread with which the error grows beyond the last tabulated spread: where a long shock rises in steps,
# the waves of a later step overtake those of an earlier one and exceed the limit of a lasting force.
_LONG_POWER = 1 / 3
# The same for several peaks, of which the law was fitted up to that spread only; and the largest error: the greatest
# that was found is 0.57.
_LONG_POWER_OF_SEVERAL = 1.5
_LARGEST_ERROR = 0.6
#: Largest spread for which the law was compared with simulations.
FARTHEST = 1000.0
# Iterations of Newton's method for ln F; a few suffice in general.
_MOST_STEPS = 60
# Step of ln F at which the iteration has converged.
_SETTLED = 1e-9
# Largest ratio of the upper bound of the eigenvalue and the eigenvalue; where it is larger, this may be another one.
_BOUND = 1.005
# Shift of the matrix over its upper bound of the eigenvalue; a shift by the eigenvalue would make it singular.
_ABOVE = 1 + 1e-9
_DIVERGED = "the law of moments did not converge for this pulse (simulate it instead)"
# Most elements of matrices in a call; limits the temporary arrays of NumPy to 1 MiB each.
_MOST_TOGETHER = 2**17
# Step of ln t0 for the derivative.
_STEP = 1e-5


def _array(values: Sequence[float]) -> FloatArray:
    # attrs inspects the signature of a converter, which takes milliseconds for `numpy.array`
    return np.array(values)


@frozen(eq=False)
class Law:
    """Coefficients of the law.

    Attributes
    ----------
    step_limit : float
        Amplification of a constant force, int G dx.
    reach : float
        Width of the local measures in x: an impulse at the distance x has the weight exp(-(x/reach)^2).
    terms : sequence of sequence of str
        Products of columns in the correction.
    coefficients : numpy.ndarray, shape (terms,)
        Coefficients of these products.
    spreads, errors, turning_errors : numpy.ndarray, shape (knots,)
        Expected relative errors of shocks with one peak and with several, at spreads tau; their logarithms are
        interpolated linearly. Below the first spread they scale as tau^(5/2), beyond the last as tau^(1/3) for one peak
        and as tau^(3/2) for several.
    """

    step_limit: float
    reach: float
    terms: Sequence[Sequence[str]]
    coefficients: FloatArray = field(converter=_array)
    spreads: FloatArray = field(converter=_array)
    errors: FloatArray = field(converter=_array)
    turning_errors: FloatArray = field(converter=_array)
    # Columns of the factors of each product; where there are fewer, the last one, a column of ones.
    _picks: list[tuple[int, ...]] = field(init=False, repr=False)
    # Logarithms of the spreads, and of the errors of shocks with one peak and with several.
    _table: tuple[FloatArray, FloatArray, FloatArray] = field(init=False, repr=False)

    @_picks.default
    def _picked(self) -> list[tuple[int, ...]]:
        return list(zip_longest(*([COLUMNS.index(name) for name in names] for names in self.terms), fillvalue=-1))

    @_table.default
    def _logarithms(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        return np.log(self.spreads), np.log(self.errors), np.log(self.turning_errors)

    @property
    def width(self) -> float:
        """Width w of the kernel, from int G dx = 2 Gamma(7/5) w G0."""
        return float(self.step_limit / (2 * math.gamma(1 + 1 / _POWER) * _G0))

    def products(self, found: FloatArray) -> FloatArray:
        """Products in the correction, shape (..., terms), from columns of shape (..., columns)."""
        factors = np.concatenate((found, np.ones((*found.shape[:-1], 1))), axis=-1)
        # in this order of memory, the sum of the terms of a pulse does not depend on the number of pulses
        return np.ascontiguousarray(np.prod(factors[..., self._picks], axis=-2))

    def corrected(self, log_force: FloatArray, found: FloatArray) -> FloatArray:
        """Amplification F/F0 of pulses, shape (...), from the kernel's ln F and columns of shape (..., columns)."""
        return np.asarray(np.exp(log_force + (self.products(found) * self.coefficients).sum(axis=-1)))

    def error(self, spread: FloatArray | float, turns: bool) -> FloatArray:
        """Expected relative error at a spread tau, same shape; of shocks with several peaks if it ``turns``."""
        spreads, *errors = self._table
        logarithm = np.log(np.maximum(spread, 1e-300))
        known = np.interp(logarithm, spreads, errors[turns])
        short = _POWER * np.minimum(logarithm - spreads[0], 0)
        power = _LONG_POWER_OF_SEVERAL if turns else _LONG_POWER
        long = power * np.maximum(logarithm - spreads[-1], 0)
        grown = np.minimum(np.exp(known + short + long), _LARGEST_ERROR)
        # in addition, the rounding error of 1.1681817, limited to the smallest tabulated error
        return np.asarray(grown + min(5e-8, float(self.errors[0])))

    def bounds(self, pulses: Sequence[Pulse]) -> FloatArray:
        """Expected relative errors for pulses, shape (pulses,); infinite where none was measured."""
        spread, known, turns = np.array([(each.spread, each.known, each.turns) for each in pulses]).reshape(-1, 3).T
        errors = self.error(spread, False)
        if turns.any():
            errors = np.where(turns, self.error(spread, True), errors)
        return np.where((known > 0) & (spread <= FARTHEST), errors, np.inf)

    def amplification(self, pulses: Sequence[Pulse]) -> FloatArray:
        """Amplification F/F0 of pulses, shape (pulses,)."""
        return self.corrected(*evaluated(self, pulses))


@cache
def moments_law() -> Law:
    """Law from the file of coefficients, read once."""
    text = (Path(__file__).parent / RESOURCE).read_text(encoding="utf-8")
    return Law(**json.loads(text)["law"])


def evaluated(law: Law, pulses: Sequence[Pulse]) -> tuple[FloatArray, FloatArray]:
    """Evaluate ln F/F0 by the kernel, shape (pulses,), and the local measures, shape (pulses, columns)."""
    log_force = np.empty(len(pulses))
    found = np.empty((len(pulses), len(COLUMNS)))
    for where in alike(np.array([pulse.times.size**2 for pulse in pulses], dtype=int), _MOST_TOGETHER):
        times, impulses = (np.array([getattr(pulses[i], name) for i in where]) for name in ("times", "impulses"))
        log_force[where], found[where] = measured(law, times, impulses)
    return log_force, found


def measured(law: Law, times: FloatArray, impulses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Results of `kernel_force` and `columns` for pulses of shape (pulses, k), by compiled code if there is any."""
    if compiled is None:
        log_force, vectors = kernel_force(law, times, impulses)
        return log_force, columns(law, times, impulses, log_force, vectors)
    log_force, found = np.empty(len(times)), np.empty((len(times), len(COLUMNS)))
    compiled.law(times, impulses, log_force, found, len(times), law.width, law.reach, _G0, law.step_limit)
    return log_force, found


# ---------------------------------------------------------------- kernel and local measures


def kernel_force(law: Law, times: FloatArray, impulses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Solve for ln F/F0 of pulses by the kernel without the correction.

    The eigenvector is found by Noda's iteration, which solves a linear system with a shift above the largest
    eigenvalue and keeps the vector positive; each of its steps is followed by one of Newton's method for ln F. Both
    converge quadratically: two to five steps suffice in general.

    Parameters
    ----------
    law : Law
        The coefficients.
    times, impulses : numpy.ndarray, shape (pulses, k)
        Times and impulses of the pulses.

    Returns
    -------
    numpy.ndarray, shape (pulses,)
        ln F/F0; NaN for a pulse for which the iteration does not converge.
    numpy.ndarray, shape (pulses, k)
        Eigenvector psi.

    References
    ----------
    Noda, T. (1971). Note on the computation of the maximal eigenvalue of a non-negative irreducible matrix. Numerische
    Mathematik, 17, 382-386.
    """
    apart = np.abs(times[:, :, None] - times[:, None]) / law.width
    apart *= apart * np.sqrt(apart)
    masses, unit = _G0 * impulses, np.eye(times.shape[1])
    # The limits of a short and of a constant force are both upper bounds.
    highest = np.minimum(1.2 * np.log(masses.sum(axis=1)), math.log(law.step_limit))
    log_force, vector = highest, np.ones_like(times)
    for _ in range(_MOST_STEPS):
        power = apart * np.exp(log_force * (_POWER / 6))[:, None, None]
        matrix = np.exp(-power) * masses[:, None]
        shift = _ABOVE * (_applied(matrix, vector) / vector).max(axis=1)
        vector = np.linalg.solve(shift[:, None, None] * unit - matrix, vector[:, :, None])[:, :, 0]
        vector /= vector.max(axis=1)[:, None]
        weights = masses * vector
        norm = (weights * vector).sum(axis=1)
        eigenvalue = (weights * _applied(matrix, vector)).sum(axis=1) / norm
        # six times d ln(eigenvalue) / d ln F
        power *= matrix
        slope = -_POWER * (weights * _applied(power, vector)).sum(axis=1) / (norm * eigenvalue)
        step = (1.2 * np.log(eigenvalue) - log_force) / (1 - 0.2 * slope)
        log_force = log_force + step
        settled = (np.abs(step) < _SETTLED) & (shift < _BOUND * eigenvalue)
        if settled.all():
            return log_force, vector
    return np.where(settled, log_force, math.nan), vector


def _applied(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Products of ``matrices``, shape (..., k, k), and ``vectors``, shape (..., k), without the threads of BLAS."""
    return np.asarray(np.einsum("...ij,...j->...i", matrices, vectors))


def columns(
    law: Law, times: FloatArray, impulses: FloatArray, log_force: FloatArray, vectors: FloatArray
) -> FloatArray:
    """Local measures of pulses, shape (pulses, columns), from the arguments and results of `kernel_force`.

    The impulses m_j F^(-5/6) around an instant x_i have the weighted values
    u_ij = G0 m_j F^(-5/6) exp(-((x_i - x_j)/reach)^2), with the sums N = sum u_ij, D = sum u_ij (x_i - x_j) and
    Q = sum u_ij (x_i - x_j)^2. B and A are the magnitudes of the parts of D with x_j before and after x_i. The measures
    are means < > over the instants with the weights m_i psi_i^2:

    ==========  ==================================  ==========  ==================================
    apart       < sum u_ij abs(x_i - x_j)^(5/2) >   lean, tilt  < D^3 >, < D Q >
    before      < B^(5/2) >                         offset      < D^2 >
    after       < A^(5/2) >                         square      < Q >
    before_up   < B^(7/2) >                         share       < N > - 1
    after_up    < A^(7/2) >                         scatter     < N^2 > - < N >^2
    ==========  ==================================  ==========  ==================================
    """
    weights = impulses * vectors**2
    weights /= weights.sum(axis=1)[:, None]
    x = times * np.exp(log_force / 6)[:, None]
    strength = _G0 * impulses * np.exp(log_force * (-5 / 6))[:, None]
    off = x[:, :, None] - x[:, None]
    square = off * off
    near = np.exp(square * (-1 / law.reach**2))
    distance = np.abs(off)
    total, directed, length, squared, apart = (
        _applied(near * each, strength) for each in (1.0, off, distance, square, square * np.sqrt(distance))
    )
    before = np.maximum(length + directed, 0) / 2
    after = np.maximum(length - directed, 0) / 2
    share = total - 1
    local = (
        apart,
        before**2.5,
        after**2.5,
        before**3.5,
        after**3.5,
        directed**3,
        directed * squared,
        directed**2,
        squared,
        share,
        (share - (weights * share).sum(axis=1)[:, None]) ** 2,
    )
    return np.stack([(weights * each).sum(axis=1) for each in local], axis=1)


# ---------------------------------------------------------------- model


def predict(shock: ScaledShock, settings: Settings) -> ScaledAnswer:
    """Predict the leading wave by the law; the regime follows from (5d) and (5e), the relation from the peak force."""
    if shock.exponent == HERTZ:
        pulse = pulse_of(shock)
        law = moments_law()
        peak, longer = _amplifications(law, pulse)
        if math.isnan(peak):
            raise NumericalError(_DIVERGED)
        (bound,) = law.bounds([pulse]).tolist()
    else:
        from shockwave.prediction.kernel_law import kernel_law, solved, too_long  # Hertz's law does not need it

        law_of_all = kernel_law()
        found = law_of_all.amplifications(shock)
        if found is None:
            raise NumericalError(too_long(shock))
        peak, low, _ = found
        bound, longer = peak / low - 1, law_of_all.peak(shock.exponent, solved(law_of_all, shock, 1 + _STEP))
    sensitivity = -math.log(longer / peak) / math.log1p(_STEP)
    warnings = ["The law of moments predicts only the leading wave. A simulation gives the later waves of a train."]
    return answer(shock, settings, peak, bound, sensitivity, warnings)


def _amplifications(law: Law, pulse: Pulse) -> tuple[float, float]:
    """Amplification of a pulse, and of one of the same peak force that is longer by the step for the derivative."""
    lengths = np.array([[1.0], [1 + _STEP]])
    peak, longer = law.corrected(*measured(law, lengths * pulse.times, lengths * pulse.impulses)).tolist()
    return peak, longer


def answer(
    shock: ScaledShock,
    settings: Settings,
    peak: float,
    bound: float,
    sensitivity: float | None,
    warnings: Sequence[str] = (),
) -> ScaledAnswer:
    """Answer with the leading wave only, of amplification ``peak`` with the relative error ``bound``."""
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
    """Predict the leading waves of many shocks by the law."""
    law = moments_law()
    results = Peaks.of(len(shocks))
    pulses = pulses_of(shocks)
    results.amplification[:] = law.amplification(pulses)
    results.high[:] = law.bounds(pulses)
    results.failures.update(dict.fromkeys(np.flatnonzero(np.isnan(results.amplification)).tolist(), _DIVERGED))
    results.high[list(results.failures)] = math.inf
    results.low[:] = -results.high
    return results


#: The registered model.
MODEL = Model(predict, peaks)


def _ejection(shock: ScaledShock, peak: float) -> ScaledEjection:
    """Virtual rise time of (5g), and as added momentum the excess of the leading wave over the shock's impulse.

    For a single wave the rebounding granules carry the opposite momentum: 0.1383 of the impulse of a short shock.
    """
    virtual = shock.momentum_parameter / shock.areas.total
    window = 1 - shock.impulse / shock.momentum_parameter
    added = wave_law(shock.exponent).momentum * peak**shock.of_momentum - shock.impulse
    return ScaledEjection(virtual, added, window / shock.profile.duration_ratio)
