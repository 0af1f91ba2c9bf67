"""Search for the first pulses at contacts and sensors.

D is a force less its static part, and M its greatest value so far. The pulse begins when D first exceeds 2 % of its
greatest value in the simulated time, and ends when D next falls to M/2.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from attrs import Factory, evolve, frozen

from shockwave.base.errors import NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_arrays import Samples
from shockwave.engine.chain_motion import ChainMotion
from shockwave.scene.sensors import Sensor
from shockwave.simulation.chain_histories import Signal, setup_of_result
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.convergence_runs import accuracies_of, run, tolerances_for
from shockwave.simulation.first_pulse import FirstPulse
from shockwave.simulation.recording import MOST_NUMBERS
from shockwave.simulation.sampled_history import TIME_SHARE, History, Places
from shockwave.simulation.simulation_result import Simulation

# Figures of a pulse, in this order.
_FIGURES = ("time", "arrival", "peak", "width", "merged", "impulse")
# Fraction of its greatest value at which a pulse begins, and least of these values, over the greatest force.
_BEGINS = 0.02
_LEAST = 1e-6
# Interval of the samples, over the inverse of the fastest frequency of a contact, and in characteristic times; and
# their largest and least numbers.
_SAMPLING = 0.09
_LONGEST = 0.05
_MOST_SAMPLES = 300_000
_FEWEST_SAMPLES = 20
# Largest number of signals refined together: denser samples about an instant of one signal are taken of all of these.
_MOST_SIGNALS = 200
# Time after which a first pulse has usually passed, over that of the greatest force, or of the wave at the end.
_PASSED = 1.25
# Fraction of the greatest sample so far below which a pulse has ended.
_ENDED = 0.49
# Tolerances, over rtol, with which pulses that miss rtol are computed again.
_TIGHTER = 0.02, 4e-4
# Smallest accepted ratio of the new error estimate of such a pulse to the previous one.
_LEAST_RATIO = 0.1
# Error estimate, over the difference from a run whose tolerance is ten to a hundred times larger. With fixed steps, the
# estimate is the difference from a run with twice the step.
_SHARE = 0.2


def first_pulses(result: Simulation, contacts: Sequence[int] | None) -> tuple[tuple[FirstPulse, ...], Sequence[str]]:
    """First pulses at contacts or, if they are None, of the sensors of a result.

    Also returns warnings of those that miss the tolerance, and the reason if there are none.
    """
    sensors = result.options.sensors if contacts is None else [Sensor("contact", contact) for contact in contacts]
    try:
        pulses = _with_speeds(*setup_of_result(result), sensors)
    except NumericalError as error:
        return (), [f"No first pulses: {error}."]
    rtol = math.inf if result.rtol is None else result.rtol
    missed = [(each, f"{each.error_estimate:.1e}") for each in pulses if (each.error_estimate or 0.0) > rtol]
    sentence = "The tolerance was not met: the relative error of the first pulse at {} is {} ({}), not {}."
    shown = f"{rtol:.1e}"
    return pulses, [sentence.format(each.sensor, error, each.worst, shown) for each, error in missed if error != shown]


def _with_speeds(case: ChainSetup, end: float, sensors: Sequence[Sensor]) -> tuple[FirstPulse, ...]:
    """First pulses of sensors in a chain, in blocks that limit the memory."""
    signals, pulses = [Signal.of(sensor, case) for sensor in sensors], list[FirstPulse]()
    most = min(int(MOST_NUMBERS / (len(Samples._fields) * min(end / _LONGEST, _MOST_SAMPLES))) + 1, _MOST_SIGNALS)
    for first in range(0, len(signals), most):
        pulses += _accurate_pulses(case, signals[first : first + most], end)
    latest: dict[str, FirstPulse] = {}
    for index, pulse in enumerate(pulses):
        pulses[index] = evolve(pulse, speed=pulse.speed_from(latest.get(pulse.kind, pulse)))
        latest[pulse.kind] = pulse
    return tuple(pulses)


def _accurate_pulses(case: ChainSetup, signals: list[Signal], end: float) -> list[FirstPulse]:
    """First pulses of signals; compiled code repeats those that miss their tolerance up to twice, with smaller ones."""
    pulses = list(_pulses_of(case, signals, end, accuracies_of(case)))
    for share in _TIGHTER if case.options.step is None and case.compiled is not None else ():
        # an error of _SHARE or more is that of a figure which only one of two runs has
        missed = [i for i, each in enumerate(pulses) if case.rtol < (each.error_estimate or 0.0) < _SHARE]
        if not missed:
            break
        try:
            repeated = list(_pulses_of(case, [signals[i] for i in missed], end, tolerances_for(share * case.rtol)))
        except NumericalError:
            break
        for i, pulse in zip(missed, repeated, strict=True):
            before, after = pulses[i].error_estimate or 1.0, pulse.error_estimate or 1.0
            if after < before:  # limited, because two runs can agree by chance
                least = _LEAST_RATIO * before, pulses[i].worst
                error, worst = max((after, pulse.worst), least)
                pulses[i] = evolve(pulse, error_estimate=error, worst=worst)
    return pulses


def _pulses_of(
    case: ChainSetup, signals: list[Signal], end: float, accuracies: tuple[float, float]
) -> Iterator[FirstPulse]:
    """First pulses of signals, with errors estimated from a run with the second, larger of two tolerances."""
    unit = case.scales.time
    share, least_error = (_SHARE, accuracies[0]) if case.options.step is None else (1.0, 0.0)
    motion = run(case, accuracies[0], end)
    spacing = _spacing(case, motion, signals, end)
    greatest = np.array([signal.greatest(motion) for signal in signals])
    tops = motion.force_times[np.concatenate([signal.contacts for signal in signals])]
    passed = _PASSED * min(float(tops.max(initial=0.0)), motion.arrival or end)
    for until in (end,) if np.isnan(greatest).any() else (min(max(passed, _FEWEST_SAMPLES * spacing), end), end):
        times: FloatArray = spacing * np.arange(int(until / spacing) + 1, dtype=float)
        fine, coarse = (History.of(case, accuracy, signals, times) for accuracy in accuracies)
        greatest = np.where(np.isnan(greatest), fine.greatest(), greatest)
        forces = np.array([signal.unit == "N" for signal in signals])
        least = forces * (_LEAST * case.scales.contact_force * float(motion.forces.max()))
        levels = np.where(greatest > least, _BEGINS * greatest, np.inf)
        figures, check = _figures_of(fine, levels), _figures_of(coarse, levels)
        if not np.isnan(figures[np.isfinite(levels), -1]).any():
            break
    changes = np.abs(figures - check)
    changes[:, :2] *= TIME_SHARE / unit
    changes[:, 2:] /= np.where(figures[:, 2:], np.abs(figures[:, 2:]), 1.0)
    changes[np.isnan(figures) & np.isnan(check)] = 0.0
    changes = np.nan_to_num(changes, nan=1.0)
    worst = changes.argmax(axis=1)
    errors = np.minimum(share * changes.max(axis=1) + least_error, 1.0)
    for index, signal in enumerate(signals):
        values = [None if math.isnan(value) else value for value in figures[index].tolist()]
        pulse = FirstPulse(
            sensor=signal.name,
            unit=signal.unit,
            position=signal.position,
            greatest=float(greatest[index]) + signal.static,
            error_estimate=None if math.isnan(figures[index, 0]) else float(errors[index]),
            kind=signal.kind,
            worst=_FIGURES[worst[index]],
            **dict(zip(_FIGURES, values, strict=True)),
        )
        yield evolve(pulse, merged=None if pulse.merged is None else pulse.merged > 0)


def _spacing(case: ChainSetup, motion: ChainMotion, signals: list[Signal], end: float) -> float:
    """Interval of the samples, from the fastest oscillation of the contacts near the signals under their forces."""
    at = np.unique(np.concatenate([signal.nearby for signal in signals]))
    inverse = np.append(case.assembly.inverse_masses, 0.0)
    p, stiffnesses = case.layout.pairs.exponents[at], case.assembly.stiffnesses[at]
    rates = p * stiffnesses ** (1 / p) * motion.forces[at] ** (1 - 1 / p) * (inverse[at] + inverse[at + 1])
    fastest = float(np.sqrt(rates.max(initial=0.0)))
    return max(min(_LONGEST, _SAMPLING / max(fastest, _SAMPLING), end / _FEWEST_SAMPLES), end / _MOST_SAMPLES)


def _figures_of(history: History, levels: FloatArray) -> FloatArray:
    """Time and arrival [s], peak, width [s], whether it is merged, and impulse of the pulses that begin at ``levels``.

    They have a row for each signal, with NaN where there is none.
    """
    spans = [_turning_points(d, level) for d, level in zip(history.d, levels.tolist(), strict=True)]
    rows, places = np.repeat(np.arange(len(spans)), [len(span) for span in spans]), np.concatenate(spans)
    turns = (places > 0) & (places < history.d.shape[1] - 1)
    solved = history.solve(rows[turns], places[turns], np.full(int(turns.sum()), np.nan))
    points = np.array((history.spacing * places, history.d[rows, places], history.integrals[rows, places]))
    points[:, turns] = solved[:3]
    pulses = [_Pulse.of(points[:, rows == row], level, history.case.rtol) for row, level in enumerate(levels.tolist())]
    crossings = [
        (row, _place(history.d[row], spans[row][segment - 1], spans[row][segment], level), level, name)
        for row, pulse in enumerate(pulses)
        for name, segment, level in pulse.crossings()
    ]
    columns = [np.array([each[i] for each in crossings]) for i in range(3)]
    crossed = history.solve(columns[0].astype(int), columns[1].astype(int), columns[2].astype(float))
    for (row, *_, name), time, integral in zip(crossings, crossed.times, crossed.integrals, strict=True):
        pulses[row].instants[name] = float(time), float(integral)
    ended = [bool(span[-1] < history.d.shape[1] - 1) for span in spans]
    return np.array([_figures(*each) for each in zip(pulses, history.signals, ended, strict=True)])


@frozen(eq=False)
class _Pulse:
    """The first pulse of a signal, by the numbers of its turning points.

    Attributes
    ----------
    points : array, shape (3, points)
        Times, values and integrals at the first sample, the turning points, and perhaps the last sample.
    level : float
        Value at which the pulse begins.
    begin, peak, end : int or None
        Points that follow the beginning, of the peak, and that follows the end.
    merged : bool
        Whether there is a minimum before the end.
    instants : dict
        Time and integral at the beginning, the arrival, the end, and where the value is zero.
    """

    points: FloatArray
    level: float
    begin: int | None
    peak: int
    end: int | None
    merged: bool
    instants: dict[str, tuple[float, float]] = Factory(dict)

    @classmethod
    def of(cls, points: FloatArray, level: float, noise: float) -> _Pulse:
        """Find the pulse; a minimum must be deeper than ``noise`` times the greatest value so far."""
        values, begin, peak, end, merged = points[1].tolist(), None, 0, None, False
        for index, value in enumerate(values):
            before = values[max(index - 1, 0)]
            if begin is None:
                begin, peak = (index, index) if value > level else (None, 0)
            elif value < before and value <= values[peak] / 2:
                end = index
                break
            elif value > before:
                dip = min(value, values[index - 2]) - before if index > begin + 1 else 0.0
                merged = merged or dip > noise * values[peak]
                peak = index if value > values[peak] else peak
        return cls(points, level, begin, peak, end, merged)

    def crossings(self) -> Iterator[tuple[str, int, float]]:
        """Names and levels of crossings, and the points that follow them."""
        values, half = self.points[1].tolist(), 0.5 * float(self.points[1][self.peak])
        if self.begin is None:
            return
        if self.begin > 0:
            yield "begin", self.begin, self.level
        for index in range(self.peak, 0, -1):
            if values[index - 1] < half:
                yield "arrival", index, half
                break
        if self.end is not None:
            yield "end", self.end, half
            if values[self.end] < 0:
                yield "zero", self.end, 0.0


def _figures(pulse: _Pulse, signal: Signal, ended: bool) -> list[float]:
    """Figures of a pulse in SI units, as of `_History.figures`; the signal has ``ended`` at its last turning point."""
    if pulse.begin is None:
        return [np.nan] * 6
    unit, (times, values, integrals) = signal.case.scales.time, pulse.points
    first = float(times[0]), float(integrals[0])
    arrival, width, impulse = pulse.instants.get("arrival", first)[0], np.nan, np.nan
    if pulse.end is not None:
        width = pulse.instants["end"][0] - arrival
        stop = pulse.instants.get("zero")
        if stop is None and (ended or pulse.end < len(times) - 1):
            stop = float(times[pulse.end]), float(integrals[pulse.end])
        if stop is not None:
            impulse = stop[1] - pulse.instants.get("begin", first)[1]
    peak, time = float(values[pulse.peak]), float(times[pulse.peak])
    return [time * unit, arrival * unit, peak, width * unit, float(pulse.merged), impulse]


def _turning_points(d: FloatArray, level: float) -> Places:
    """The first sample, and those next to the extremes up to the first minimum after the pulse, or the last sample."""
    above = d > level
    if not above.any():
        return np.zeros(1, dtype=np.intp)
    begin = int(np.argmax(above))
    fallen = d[begin:] < _ENDED * np.maximum.accumulate(d[begin:])
    ended = begin + int(np.argmax(fallen)) if fallen.any() else len(d) - 1
    steps = np.diff(d)
    turns = 1 + np.flatnonzero((steps[:-1] * steps[1:] <= 0) & (steps[:-1] != 0))
    after = turns[turns >= ended]
    return np.concatenate(([0], turns[turns < ended], after[:1] if after.size else [len(d) - 1]))


def _place(d: FloatArray, first: int, last: int, level: float) -> int:
    """The sample before a crossing of a level between two turning points."""
    beyond = (d[first : last + 1] > level) != (d[first] > level)
    return int(first + np.argmax(beyond) - 1) if beyond.any() else max(int(last) - 1, 0)
