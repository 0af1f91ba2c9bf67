"""Histories of signals at equal intervals, and their extremes and crossings, sampled again where not resolved.

Instants follow from polynomials through eight samples. Where those through the inner six differ from them by too much,
as at a kink, the chain is integrated again with denser samples.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.simulation.chain_histories import Signal, rows_of
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.convergence_runs import run

# Interval of all samples over that about an instant that is not resolved, these samples, and the largest number of
# times that the interval is divided.
_DENSER = 8
_CLUSTER = np.arange(17)
_ROUNDS = 6
# Relative error that is resolved, over rtol.
_RESOLVED = 0.3
# Error of the time of an extreme, in intervals, over the ratio of the sixth to the second differences, which is small
# unless the slope jumps there: then both polynomials have a similar error.
_KINK = 0.04
#: Share of the error of a time, in characteristic times, that counts as a relative error.
TIME_SHARE = 0.1
_BISECTIONS = 30
# Places of the samples of a polynomial, and the matrices that give its coefficients from all eight and the inner six.
_NODES = np.arange(-3.0, 5.0)
_FITS = np.linalg.inv(np.vander(_NODES, increasing=True)), np.zeros((8, 8))
_FITS[1][:6, 1:7] = np.linalg.inv(np.vander(_NODES[1:7], increasing=True))

#: Numbers of samples or signals.
Places: TypeAlias = npt.NDArray[np.intp]


class Instants(NamedTuple):
    """Times, values and integrals of signals at instants, and errors of the polynomials that gave them."""

    times: FloatArray
    values: FloatArray
    integrals: FloatArray
    errors: FloatArray


@frozen(eq=False)
class History:
    """Samples of signals at equal intervals, with a row for each signal.

    Attributes
    ----------
    case : ChainSetup
    tolerance : float
        That of a step, or its fixed size.
    signals : list of Signal
        The signals of the rows.
    begins : array, shape (signals,)
        Scaled times of the first samples.
    spacing : float
        Scaled interval.
    d, integrals : array, shape (signals, times)
        Values less their static parts, and their integrals.
    """

    case: ChainSetup
    tolerance: float
    signals: list[Signal]
    begins: FloatArray
    spacing: float
    d: FloatArray
    integrals: FloatArray

    @classmethod
    def of(cls, case: ChainSetup, tolerance: float, signals: list[Signal], times: FloatArray) -> History:
        """Integrate a chain and sample all signals."""
        samples = run(case, tolerance, float(times[-1]), times, rows_of(signals)).samples
        d = np.array([signal.dynamic(samples) for signal in signals])
        integrals = np.array([signal.integral(samples) for signal in signals])
        return cls(case, tolerance, signals, np.zeros(len(signals)), float(times[1]), d, integrals)

    def about(self, rows: Places, centres: FloatArray, spacing: float) -> History:
        """Integrate the chain again, and sample the signal of each of ``rows`` about a time."""
        span = spacing * (len(_CLUSTER) - 1)
        last = self.begins[0] + self.spacing * (self.d.shape[1] - 1)
        begins = np.clip(centres - span / 2, 0.0, last - span)
        times = (begins[:, None] + spacing * _CLUSTER).ravel()
        order, owners = np.argsort(times), np.repeat(rows, len(_CLUSTER))
        signals, values = [self.signals[row] for row in rows], np.zeros((2, len(times)))
        samples = run(self.case, self.tolerance, float(times.max()), times[order], rows_of(signals)).samples
        for row in np.unique(rows).tolist():
            mine, signal = owners[order] == row, self.signals[row]
            values[:, order[mine]] = signal.dynamic(samples)[mine], signal.integral(samples)[mine]
        d, integrals = values.reshape(2, len(rows), -1)
        return History(self.case, self.tolerance, signals, begins, spacing, d, integrals)

    def fit(self, rows: Places, places: Places, levels: FloatArray, scales: FloatArray) -> Instants:
        """Extremes next to the samples at ``places`` or, where a level is not NaN, its crossings after them.

        Errors of values are relative to ``scales``.
        """
        begins = np.clip(places - 3, 0, self.d.shape[1] - len(_NODES))
        window = rows[:, None], begins[:, None] + np.arange(len(_NODES))
        y, shift, turns = self.d[window], (places - 3 - begins).astype(float), np.isnan(levels)
        low, high = np.maximum(shift - turns, _NODES[0]), np.minimum(shift + 1, _NODES[-1])
        both = np.concatenate([y @ matrix.T for matrix in _FITS])
        at, value = _solve(both, *(np.tile(each, 2) for each in (levels, low, high)))
        (at, other), (value, check) = np.split(at, 2), np.split(value, 2)
        gap = self.spacing * np.abs(at - other)
        share = np.where(value > self.d[rows, np.maximum(places - 1, 0)], TIME_SHARE, np.maximum(value, 0.0) / scales)
        sixth, second = (np.abs(np.diff(y, order)).max(axis=1) for order in (6, 2))
        kink = self.spacing * np.minimum(_KINK * sixth / np.maximum(second, 1e-300), 1.0)
        errors = np.where(turns, np.abs(value - check) / scales + share * np.maximum(gap, kink), gap)
        opens = turns & (self.d[rows, places] == 0)
        at, value, errors = np.where(opens, shift, at), np.where(opens, 0.0, value), np.where(opens, 0.0, errors)
        times = self.begins[rows] + self.spacing * (begins + 3 + at)
        return Instants(times, value, _evaluate(self.integrals[window] @ _FITS[0].T, at), errors)

    def solve(self, rows: Places, places: Places, levels: FloatArray) -> Instants:
        """Instants as of `fit`, with more samples where they are not resolved."""
        # of the greatest value so far
        scales = np.maximum(np.maximum.accumulate(np.abs(self.d), axis=1)[rows, places], 1e-300)
        instants, spacing = self.fit(rows, places, levels, scales), self.spacing
        falls = np.isnan(levels) & (self.d[rows, places] < self.d[rows, np.maximum(places - 1, 0)])
        for _ in range(_ROUNDS):
            poor = np.flatnonzero(instants.errors > _RESOLVED * self.case.rtol)
            if not poor.size:
                break
            spacing /= _DENSER
            closer = self.about(rows[poor], instants.times[poor], spacing)
            sign, level = np.where(falls[poor], -1.0, 1.0)[:, None], levels[poor, None]
            crosses = (closer.d[:, 1:] > level) != (closer.d[:, :-1] > level)
            near = np.where(crosses, np.abs(_CLUSTER[:-1] - len(_CLUSTER) // 2), len(_CLUSTER))
            inner = 1 + np.argmax(sign * closer.d[:, 1:-1], axis=1)
            at = np.where(np.isnan(levels[poor]), inner, np.argmin(near, axis=1))
            for whole, part in zip(
                instants, closer.fit(np.arange(len(poor)), at, levels[poor], scales[poor]), strict=True
            ):
                whole[poor] = part
        return instants

    def greatest(self) -> FloatArray:
        """Greatest values."""
        places, most = self.d.argmax(axis=1), self.d.max(axis=1)
        tops = self.fit(np.arange(len(places)), places, np.full(len(places), np.nan), np.ones(len(places))).values
        return np.where((places > 0) & (places < self.d.shape[1] - 1), tops, most)


def _evaluate(coefficients: FloatArray, at: FloatArray) -> FloatArray:
    """Values of polynomials, in rows of ascending powers."""
    value = coefficients[:, -1]
    for column in coefficients.T[-2::-1]:
        value = value * at + column
    return np.asarray(value)


def _solve(
    coefficients: FloatArray, levels: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Places in intervals where polynomials have these levels or, where these are NaN, extremes; and their values."""
    turns = np.isnan(levels)[:, None]
    slopes = np.append(coefficients[:, 1:] * np.arange(1, len(_NODES)), np.zeros((len(levels), 1)), axis=1)
    target = np.where(turns, slopes, coefficients)
    target[:, 0] -= np.where(turns[:, 0], 0.0, levels)
    begins = _evaluate(target, low) > 0
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        before = (_evaluate(target, middle) > 0) == begins
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    middle = (low + high) / 2
    return middle, _evaluate(coefficients, middle)
