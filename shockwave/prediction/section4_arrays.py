"""Section 4 for many shocks: `section4` in arrays for power laws, one by one for other shapes."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from shockwave.numerics import newton_roots
from shockwave.prediction.model_interface import Model, Peaks, Settings, Shocks, one_by_one
from shockwave.prediction.section4 import (
    ABOVE_ROUNDING,
    CONTRADICTION,
    ENTIRE,
    LATER_ALPHA,
    MANY,
    MOST_WAVES,
    NOTHING_LEFT,
    STRONGER,
    predict,
)
from shockwave.profiles.guard import trusted
from shockwave.profiles.power_law import ManyPowers, Powers
from shockwave.quadrature import FloatArray


def peaks(shocks: Shocks, settings: Settings) -> Peaks:
    """Predict many shocks; those of all power laws are computed together."""
    shapes = zip(shocks.profiles, shocks.areas, strict=True)
    laws = [isinstance(each, Powers) and trusted(each) and areas.rise.method == "closed form" for each, areas in shapes]
    together = np.array(laws, dtype=bool)[shocks.shapes] & (settings.alpha == "constant")
    results = one_by_one(predict, shocks, settings, np.flatnonzero(~together).tolist())
    if together.any():
        laws_of = ManyPowers([shocks.profiles[shape] for shape in shocks.shapes[together]])
        _of_powers(laws_of, shocks.rise_times[together], shocks.momentum_parameter, settings, results, together)
    results.states_error[:] = False
    return results


def _of_powers(
    laws: ManyPowers,
    rise_times: FloatArray,
    unit: float,
    settings: Settings,
    results: Peaks,
    together: npt.NDArray[np.bool_],
) -> None:
    """Fill the results of the shocks ``together``, whose shapes are ``laws``; see `section4.predict`."""
    a1, a2 = map(np.asarray, laws.closed_areas())
    n, impulse = laws.duration_ratio, rise_times * (a1 + a2)
    ratio, deviation = impulse / unit, np.abs(0.5 - a2 / (n - 1)) ** 1.5
    alpha = 2 - np.abs(0.5 - a1) ** 1.5 - deviation
    train = alpha * unit < n * rise_times
    ejection = ~train & (ratio < 1)
    s = np.where(train, np.minimum(alpha * unit / rise_times, n), np.clip(n - 1 + ratio, 0.0, n))
    until, _ = laws.impulse_and_force(s)
    added = np.where(ejection, 2 * (1 - until / (a1 + a2)), 0.0)
    amplification = (ratio + added) ** 1.2  # (5f), (5h)
    share = np.where(train, rise_times * until / unit, ratio)
    relation = np.where(share > 1, "greater", "less")
    relation[np.abs(share - 1) <= settings.equal_tolerance] = "equal"
    waves = np.ones(len(n), dtype=np.intp)
    notes: dict[int, list[str]] = {}
    for index in np.flatnonzero(ejection & (amplification > 1) & (relation == "less")).tolist():
        notes[index] = [CONTRADICTION]
    own = np.flatnonzero(train)
    if len(own):
        trains = _Trains(laws.some(own), rise_times[own], impulse[own], unit)
        end = trains.passage(np.zeros(len(own)), np.zeros(len(own)), alpha[own], np.zeros(len(own)))
        amplification[own] = (alpha[own] * unit / end) ** 6
        highest = np.zeros(len(own))
        if settings.wave_threshold < math.inf:
            later = LATER_ALPHA - deviation[own]
            waves[own], highest = trains.later(later, settings.wave_threshold * amplification[own], end)
        cases = (
            end >= n[own] * rise_times[own],
            highest > ABOVE_ROUNDING * amplification[own],
            waves[own] > MOST_WAVES,
        )
        for case, sentence in zip(cases, (ENTIRE, STRONGER, MANY), strict=True):
            for index in own[case].tolist():
                notes.setdefault(index, []).append(sentence)
    results.amplification[together], results.relation[together], results.waves[together] = (
        amplification,
        relation,
        waves,
    )
    results.regime[together] = np.where(train, "train", np.where(ejection, "ejection", "single"))
    results.virtual_rise_time[together] = np.where(ejection, unit / (a1 + a2), np.nan)
    results.added_momentum[together] = np.where(ejection, unit * added, np.nan)
    places = np.flatnonzero(together)
    results.notes.update((int(places[index]), tuple(sentences)) for index, sentences in notes.items())


class _Trains:
    """Shocks that make trains: their shapes, rise times and impulses, shape (shocks,), and the unit of momentum."""

    def __init__(self, laws: ManyPowers, rise_times: FloatArray, impulse: FloatArray, unit: float) -> None:
        self.laws, self.rise_times, self.impulse, self.unit = laws, rise_times, impulse, unit

    def some(self, where: npt.NDArray[np.bool_]) -> _Trains:
        """Return some of the shocks."""
        return _Trains(self.laws.some(where), self.rise_times[where], self.impulse[where], self.unit)

    def at(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Impulse of the shocks up to ``time``, and their force."""
        s, n = time / self.rise_times, self.laws.duration_ratio
        impulse, force = self.laws.impulse_and_force(np.minimum(s, n))
        return np.where(s < n, self.rise_times * impulse, self.impulse), np.where(s < n, force, 0.0)

    def passage(self, start: FloatArray, before: FloatArray, alpha: FloatArray, guess: FloatArray) -> FloatArray:
        """Times for which waves collect impulse; see `section4._passage_time`."""
        unit = self.unit

        def excess(time: FloatArray) -> tuple[FloatArray, FloatArray]:
            until, force = self.at(start + time)
            impulse = np.maximum(until - before, 0.0)
            value = np.log(time / (alpha * unit)) + 0.2 * np.log(impulse / unit)
            return value, np.where(impulse > 0, 1 + 0.2 * time * force / impulse, 1.0)

        lower = 0.99 * unit * alpha ** (5 / 6)
        enough = alpha * unit * (unit / (self.impulse - before)) ** 0.2
        left = self.laws.duration_ratio * self.rise_times - start
        upper = 1.01 * np.maximum(np.maximum(left, enough), lower)
        return newton_roots(excess, lower, upper, guess, "time of a wave in the train (5i)")

    def later(self, alpha: FloatArray, least: FloatArray, end: FloatArray) -> tuple[npt.NDArray[np.intp], FloatArray]:
        """Numbers of waves, and peak forces of the strongest later ones; see `section4._later_waves`."""
        waves, highest = np.ones(len(end), dtype=np.intp), np.zeros(len(end))
        index, shocks = np.arange(len(end)), self
        before, _ = self.at(end)
        passage = guess = np.zeros(len(end))
        while True:
            left = (shocks.impulse - before > NOTHING_LEFT * shocks.impulse) & (waves[index] <= MOST_WAVES)
            index, shocks = index[left], shocks.some(left)
            if not len(index):
                return waves, highest
            end, before, guess, last = end[left], before[left], guess[left], passage[left]
            passage = shocks.passage(end, before, alpha[index], guess)
            peak = (alpha[index] * self.unit / passage) ** 6
            strong = peak >= least[index]
            index, shocks, passage, last = index[strong], shocks.some(strong), passage[strong], last[strong]
            waves[index] += 1
            highest[index] = np.maximum(highest[index], peak[strong])
            end = end[strong] + passage
            before, _ = shocks.at(end)
            guess = np.divide(passage * passage, last, out=passage.copy(), where=last > 0)


#: The registered model.
MODEL = Model(predict, peaks, complete=True)
