"""Shock response spectrum of an acceleration: greatest responses of oscillators on a base that moves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import cmp_using, field, frozen
from scipy.linalg import solve_banded

from shockwave.base.errors import InvalidValueError
from shockwave.base.numerics import FloatArray, floats
from shockwave.base.quantity_fields import Declaration, Number, text_of
from shockwave.base.result import VERSION, Result, fields_of
from shockwave.base.result_tables import Table, along, cells
from shockwave.base.text import Detail, brief, detail, facts, is_wide, percent, si, strong, table

#: Damping ratio of the oscillators.
DAMPING = Declaration("", "damping ratio of the oscillators", at_least=0, below=1)
#: An end of the range of natural frequencies.
FREQUENCY = Declaration("Hz", "natural frequency", above=0, optional=True)
# Samples of a response per period. Between them it deviates from its chord by at most a thirteenth of its oscillation.
_PER_PERIOD = 8
# Finer samples in an interval that may contain the greatest response, and steps of Newton's method from the best one.
_FINER = 9
_NEWTON_STEPS = 4
# Highest default frequency, over the sampling rate of a history: between samples its course is not known.
_HIGHEST = 0.1
# Number of frequencies per octave.
_PER_OCTAVE = 12
# Frequency in the grid of a spectrum [Hz].
_GRID = 1000.0
# Rows of the printed table.
_ROWS = 5
# Units of the columns of a table.
_UNITS = {"acceleration": "m/s^2", "pseudo_velocity": "m/s", "errors": ""}
_UNITS |= {"input_acceleration": "m/s^2", "input_pseudo_velocity": "m/s"}
# Arrays are equal if all values are.
_ARRAYS = cmp_using(eq=np.array_equal)


@frozen(kw_only=True, repr=False)
class ShockSpectrum(Result):
    """Shock response spectrum: greatest responses (maximax) of oscillators with one degree of freedom, SI units.

    The peak between two samples, and that after the end of the history, are included.

    Attributes
    ----------
    frequencies : array, shape (k,)
        Undamped natural frequencies [Hz].
    acceleration : array, shape (k,)
        Greatest absolute acceleration of the mass [m/s^2].
    pseudo_velocity : array, shape (k,)
        Greatest displacement relative to the base, times the angular frequency [m/s].
    errors : array, shape (k,)
        Relative error estimates of both.
    damping : float
        Damping ratio of the oscillators.
    end : float
        Time after which the base no longer accelerates [s].
    base : str
        The motion of the base in words.
    mass : float or None
        Mass on which the force acts [kg].
    input_acceleration, input_pseudo_velocity : array, shape (k,), or None
        The spectrum of the shock's force over the same mass, without the chain.
    scenario : str or None
        Name of the scenario.
    warnings : tuple of str
        What limits the spectrum.
    """

    frequencies: FloatArray = field(eq=_ARRAYS)
    acceleration: FloatArray = field(eq=_ARRAYS)
    pseudo_velocity: FloatArray = field(eq=_ARRAYS)
    errors: FloatArray = field(eq=_ARRAYS)
    damping: float
    end: float
    base: str = "acceleration"
    mass: float | None = None
    input_acceleration: FloatArray | None = field(default=None, eq=_ARRAYS)
    input_pseudo_velocity: FloatArray | None = field(default=None, eq=_ARRAYS)
    scenario: str | None = None
    warnings: tuple[str, ...] = ()

    _brief = ("scenario", "base", "damping", "error_estimate")
    _picture = "shockwave.pictures.histories:shock_spectrum"
    _tables = (("spectrum", "frequency"),)

    @property
    def error_estimate(self) -> float:
        """The largest of the ``errors``."""
        return float(self.errors.max())

    def _table(self, name: str) -> Table:
        values = {name: values for name in _UNITS if (values := getattr(self, name)) is not None}
        return along("frequency", self.frequencies, values, {"frequency": "Hz", **_UNITS})

    def to_dict(self) -> dict[str, Any]:
        """Document printed by ``shockwave spectrum --json``."""
        return {**VERSION, **fields_of(self), "error_estimate": self.error_estimate}

    def __str__(self) -> str:
        at = int(self.acceleration.argmax())
        answer = f"greatest response {self.acceleration[at]:.4g} m/s^2, at {si(float(self.frequencies[at]), 'Hz', 4)}"
        accuracy = f"estimated relative error {self.error_estimate:.0e}" if self.error_estimate else "exact"
        base = f"{self.base}, to {si(self.end, 's', 4)}; damping {percent(self.damping)}"
        count = len(self.frequencies)
        most = count if is_wide() or detail() is Detail.VERBOSE else _ROWS
        shown = cells(self._table("spectrum"), most, len(_UNITS) + 1, [at])
        rows = table(shown["header"], shown["rows"], ("errors", *shown["header"][4:])).split("\n")
        rows += [f"  ({count} frequencies; --verbose shows all)"] * (most < count)
        return brief([strong(f"{answer}, {accuracy}")], self.warnings, (), [*facts([("base", base)]), *rows])


def shock_spectrum(
    times: npt.ArrayLike,
    accelerations: npt.ArrayLike,
    frequencies: npt.ArrayLike | None = None,
    damping: Number = 0.05,
) -> ShockSpectrum:
    """Compute the shock response spectrum of a history of the acceleration, exact if it is piecewise linear.

    The base is at rest before the first sample, and no longer accelerates after the last one. For samples of a smooth
    course, the spectrum of every second sample differs by about three times the error.

    Parameters
    ----------
    times : array_like, shape (k,)
        Times [s] in ascending order, at any distance; two equal ones are a jump.
    accelerations : array_like, shape (k,)
        Accelerations of the base [m/s^2].
    frequencies : array_like, optional
        Natural frequencies [Hz]. Default: twelve per octave, from one period within the history to a tenth of the mean
        sampling rate.
    damping : float
        Damping ratio, 0.05 for a quality factor of 10.

    Returns
    -------
    ShockSpectrum
        Greatest absolute accelerations and pseudo-velocities.

    Raises
    ------
    InvalidValueError
        If times do not ascend, there are fewer than two, or a value is not finite or out of range.

    Source
    ------
    ISO 18431-4:2007, ramp-invariant method; here with one complex pole, which also serves uneven samples.

    Examples
    --------
    >>> import shockwave as sw
    >>> times, accelerations = [0.0, 0.011], [500.0, 500.0]  # a rectangle of 11 ms
    >>> spectrum = sw.shock_spectrum(times, accelerations, [25.0, 50.0], damping=0)
    >>> spectrum.acceleration.round(3).tolist()
    [760.406, 1000.0]
    """
    t, a = floats("times", times), floats("accelerations", accelerations)
    fits = t.ndim == 1 and t.shape == a.shape and len(t) > 1 and bool(np.isfinite([t, a]).all())
    if not fits or (np.diff(t) < 0).any() or t[-1] == t[0]:
        rule = "must be at least two numbers in ascending order, and as many as accelerations"
        raise InvalidValueError.of("times", f"{rule} (got {text_of(times)})")
    ratio = DAMPING.check("damping", damping)
    if frequencies is None:
        span = float(t[-1] - t[0])
        frequencies = octave_fractions(1 / span, max(_HIGHEST * len(t), 1.0) / span)
    f = np.atleast_1d(floats("frequencies", frequencies))
    if not f.size or not ((f > 0) & (f < math.inf)).all():
        raise InvalidValueError.of("frequencies", f"must be > 0 Hz (got {text_of(frequencies)})")
    acceleration, pseudo_velocity = greatest_responses(t, a, f, ratio)
    return ShockSpectrum(
        frequencies=f,
        acceleration=acceleration,
        pseudo_velocity=pseudo_velocity,
        errors=np.zeros(f.shape),
        damping=ratio,
        end=float(t[-1]),
    )


def octave_fractions(low: float, high: float) -> FloatArray:
    """Frequencies 1 kHz 2^(i/12) from ``low`` to ``high`` [Hz], rounded outwards.

    Raises
    ------
    InvalidValueError
        If ``high`` is less than ``low``.
    """
    if not 0 < low <= high < math.inf:
        raise InvalidValueError.of("frequencies", f"must ascend (got {low:g} Hz to {high:g} Hz)")
    first, last = (_PER_OCTAVE * math.log2(end / _GRID) for end in (low, high))
    return np.asarray(_GRID * 2.0 ** (np.arange(math.floor(first + 1e-9), math.ceil(last - 1e-9) + 1) / _PER_OCTAVE))


# ---------------------------------------------------------------- responses


def greatest_responses(
    times: FloatArray, accelerations: FloatArray, frequencies: FloatArray, damping: float
) -> tuple[FloatArray, FloatArray]:
    """Greatest absolute acceleration and pseudo-velocity of oscillators at each frequency.

    The displacement z relative to the base obeys z'' + 2 D w z' + w^2 z = -a(t). With s = w (-D + i sqrt(1 - D^2)), the
    complex u = z' - conj(s) z obeys u' = s u - a(t), which is solved exactly where a(t) is linear. Absolute
    acceleration and displacement are real parts of multiples of u.
    """
    peaks = [_greatest(times, accelerations, 2 * math.pi * f, damping) for f in frequencies.tolist()]
    acceleration, displacement = np.transpose(peaks)
    return acceleration, 2 * math.pi * frequencies * displacement


def _greatest(times: FloatArray, accelerations: FloatArray, w: float, damping: float) -> tuple[float, float]:
    """Greatest absolute acceleration and displacement at an angular frequency."""
    s = w * complex(-damping, math.sqrt(1 - damping**2))
    steps, a, rises = _divide(times, accelerations, 2 * math.pi / (_PER_PERIOD * w))
    x = s * steps
    growth = np.expm1(x)
    mean = growth / x
    drives = -steps * (mean * a + (mean - 1) / x * rises)
    # u[n] = exp(x) u[n-1] + drive
    bands = np.array([np.ones(len(x) + 1), np.append(-1 - growth, 0)])
    u = solve_banded((1, 0), bands, np.append(0, drives), overwrite_ab=True, check_finite=False)
    rates = rises / steps
    level = a / s + rates / s**2  # u = (u0 - level) exp(s t) + level + rate t / s
    factors = complex(-2 * damping * w, w * w * (1 - 2 * damping**2) / s.imag), complex(0, -1 / s.imag)
    greatest = []
    for factor in factors:
        ends, swing = np.abs((factor * u).real), factor * (u[:-1] - level)
        chord = np.maximum(ends[:-1], ends[1:])
        near = chord + (w * steps) ** 2 / 8 * np.abs(swing) > ends.max()
        parts: Any = (each[near, None] for each in (steps, swing, factor * level, factor * rates / s))
        greatest.append(max(float(ends.max()), _peak_between(s, *parts), _peak_after(s, factor * u[-1])))
    return greatest[0], greatest[1]


def _divide(times: FloatArray, values: FloatArray, longest: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Lengths of intervals of at most ``longest``, values at their beginnings, and increments of the values."""
    steps, rises = np.diff(times), np.diff(values)
    counts = np.maximum(np.ceil(steps / longest), 1).astype(int)
    before = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    rises = np.repeat(rises / counts, counts)
    steps, starts = np.repeat(steps / counts, counts), np.repeat(values[:-1], counts) + before * rises
    moving = steps > 0  # a jump changes no response
    return steps[moving], starts[moving], rises[moving]


def _peak_between(s: complex, steps: FloatArray, swing: Any, level: Any, rates: Any) -> float:
    """Greatest value of \\|Re(swing exp(s t) + level + rate t)\\| in intervals, shape (k, 1) each."""

    def values(t: FloatArray) -> FloatArray:
        return np.asarray(np.abs((swing * np.exp(s * t) + level + rates * t).real))

    t = np.linspace(0, 1, _FINER) * steps
    t = np.take_along_axis(t, values(t).argmax(axis=1)[:, None], axis=1)
    for _ in range(_NEWTON_STEPS):
        turning = s * swing * np.exp(s * t)
        bend = (s * turning).real
        t = np.clip(t - (turning + rates).real / np.where(bend == 0, math.inf, bend), 0, steps)
    return float(values(t).max(initial=0))


def _peak_after(s: complex, swing: complex) -> float:
    """Greatest value of \\|Re(swing exp(s t))\\| for t > 0: that of its first extremum."""
    turn = (math.pi / 2 - np.angle(s * swing)) % math.pi / s.imag
    return abs(float((swing * np.exp(s * turn)).real))
