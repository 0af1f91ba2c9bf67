"""Processing of a record by the steps that the user requests, with a note on the effect of each."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import define, field, frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.numerics import FloatArray
from shockwave.base.text import percent, si
from shockwave.records.record_proposals import glitches, propose, sample_warnings

#: Advice for a record in which compression is negative, unless it is a file.
CHANGE_SIGNS = "change the signs of forces"
# Forces below this fraction of the peak force or of a baseline are rounding errors.
_ROUNDING = 1e-12
# Largest force at the ends of a pulse, over its peak force, and largest relative change of peak force, rise time and
# impulse by proposed keys, without a warning.
_NOTICEABLE = 0.01
# The former of a cropped record, which may end at a slow tail.
_CUT = 0.05
# Impulse of the samples set to zero over that of the others that is a warning.
_MANY = 0.05
# Order of the low-pass filter, which is applied forwards and backwards.
_ORDER = 4
# Periods of the cut-off frequency by which the filter extends the record at each end: its response has then decayed.
_EXTENSION = 2
# Largest relative difference of sampling intervals of a record that is filtered: times are rounded when written.
_UNEVEN = 0.1
# Distance from the ends of a window, over the mean sampling interval, at which samples still belong to it.
_AT_END = 1e-3
# Smallest relative change that the note on a step states.
_UNCHANGED = 5e-5
# Largest relative change of the peak force by a low-pass filter without a warning.
_DISTORTED = 0.2
# Longest pulse in rise times, and largest time [s] and force [N]: the squares of larger numbers overflow.
_LARGEST = 1e150

#: Steps of the processing by their keys, as of `Tabulated`, with None for those that are not asked for.
Processing = Mapping[str, Any]


@frozen(eq=False)
class Pulse:
    """A pulse in units of its peak force [N] and rise time [s]: forces ``values`` at the times ``knots``.

    ``figures`` are those of the record before its decay was stretched; ``negative`` is the impulse of its negative
    samples over that of the others.
    """

    knots: FloatArray
    values: FloatArray
    peak_force: float
    rise_time: float
    notes: tuple[str, ...]
    figures: Mapping[str, float]
    negative: float


@define(eq=False)
class _Process:
    """A record during its processing, with notes on the steps so far.

    ``least`` is that of the forces that count for the effect of a step: 0 if negative ones are set to zero later.
    """

    times: FloatArray
    forces: FloatArray
    least: float
    notes: list[str] = field(factory=list)

    def step(self, change: str, forces: FloatArray, kept: slice = slice(None), pulse: slice = slice(None)) -> None:
        """Take new ``forces``, of which the samples ``kept`` remain, and note the effect on the ``pulse``."""
        before, self.times, self.forces = self._figures(pulse), self.times[kept], forces[kept]
        self.notes.append(f"{change} ({changes(before, self._figures(pulse)) or 'no change'}).")

    def _figures(self, pulse: slice) -> dict[str, float]:
        return _figures(self.times[pulse], self.forces[pulse].clip(self.least))


def pulse_of(times: FloatArray, forces: FloatArray, ratio: float | None, steps: Processing) -> Pulse:
    """Extract the pulse of a record; apart from ``steps``, only samples of zero force at its ends are removed.

    Parameters
    ----------
    times, forces : array of float, shape (k,)
        Samples [s] and [N].
    ratio : float, optional
        Duration ratio to which the decay is stretched.
    steps : mapping
        Values of baseline, low_pass, crop and negative, as of `Tabulated`.

    Raises
    ------
    InvalidValueError
        If the samples are not a pulse.
    """
    _check_samples(times, forces)
    pulse = slice(None) if steps["crop"] is None else _samples_within(times, "crop", steps["crop"], 3)
    process = _Process(times, forces, 0.0 if steps["negative"] == "zero" else -np.inf)
    if steps["baseline"] is not None:
        level = float(forces[_samples_within(times, "baseline", steps["baseline"], 1)].mean())
        lowered = np.where(np.abs(forces - level) > _ROUNDING * abs(level), forces - level, 0.0)
        window = "{:g} to {:g} s".format(*steps["baseline"])
        process.step(f"A baseline of {level:.4g} N, the mean from {window}, was subtracted", lowered, pulse=pulse)
    if steps["low_pass"] is not None:
        filtered = _filter_forces(times, process.forces, steps["low_pass"])
        process.step(f"A low-pass filter at {steps['low_pass']:g} Hz was applied", filtered, pulse=pulse)
    if steps["crop"] is not None:
        process.step("The record was cropped to {:g} to {:g} s".format(*steps["crop"]), process.forces, pulse)
    if process.forces.max() <= 0:
        got = f"got at most {process.forces.max() + 0.0:g} N; if compression is negative, {CHANGE_SIGNS}"
        raise InvalidValueError.of("forces", f"must be > 0 N somewhere ({got})")
    count, above = int(np.count_nonzero(process.forces < -_ROUNDING * process.forces.max())), process.forces.clip(0)
    share = 1 - _impulse(process.times, process.forces) / _impulse(process.times, above)
    if count and steps["negative"] is None:
        offset = "set baseline for an offset" if steps["baseline"] is None else ""
        hints = [offset, "negative: zero ignores them, keep simulates pulling"]
        hints += [f"if compression is negative, {CHANGE_SIGNS}", _advice(times, forces, ratio, steps)]
        got = f"got nothing; their impulse is {percent(share)} of that of the others; {'; '.join(filter(None, hints))}"
        rule = f"must be keep or zero, because {count} of {above.size} forces are negative"
        raise InvalidValueError.of("negative", f"{rule} ({got})")
    if count and steps["negative"] == "zero":
        process.least = -np.inf
        process.step(f"Negative samples were set to zero: {count} of {above.size}", above)
    elif not count:
        process.forces = above
    inside = np.flatnonzero(process.forces)
    samples = slice(max(int(inside[0]) - 1, 0), int(inside[-1]) + 2)
    if samples.start > 0 or samples.stop < process.forces.size:  # without them the force is the same
        process.step("Samples of zero force before and after the pulse were removed", process.forces, samples)
    return _scale_pulse(process, ratio, share)


def _scale_pulse(process: _Process, ratio: float | None, negative: float) -> Pulse:
    """The pulse in units of its peak force and rise time."""
    notes, peak_force, peak = process.notes, float(process.forces.max()), int(np.argmax(process.forces))
    if peak in (0, process.forces.size - 1):
        got = f"got the peak, {peak_force:g} N, at an end; add a sample of zero force there"
        raise InvalidValueError.of("forces", f"must rise to a peak and fall from it ({got})")
    values, elapsed = process.forces / peak_force, process.times - process.times[0]
    if not (np.diff(elapsed) > 0).all() or not elapsed[-1] < _LARGEST * elapsed[peak]:
        rule = f"must differ by more than rounding errors and span less than {_LARGEST:g} rise times"
        raise InvalidValueError.of("times", f"{rule} (got {elapsed[-1]:g} s and a rise time of {elapsed[peak]:g} s)")
    knots = elapsed / elapsed[peak]
    if ratio is not None and ratio != knots[-1]:
        notes.append(f"The decay was stretched in time: n is {ratio:g}, that of the record {knots[-1]:g}.")
        knots[peak + 1 :] = 1.0 + (knots[peak + 1 :] - 1.0) * ((ratio - 1.0) / (knots[-1] - 1.0))
        knots[-1] = ratio
    if _impulse(knots, values) <= 0:
        raise InvalidValueError.of("forces", "must have an impulse > 0 N s (got a greater negative phase)")
    figures = _figures(process.times, process.forces)
    return Pulse(knots, values, peak_force, float(elapsed[peak]), tuple(notes), figures, negative)


def _check_samples(times: FloatArray, forces: FloatArray) -> None:
    """Raise an error for the first of the samples that violate a rule, with their number."""
    if forces.size != times.size or times.size < 3:
        got = f"got {times.size} times and {forces.size} forces"
        raise InvalidValueError.of("times", f"must be at least three, and as many as forces ({got})")
    for name, values in (("times", times), ("forces", forces)):
        _check(name, values, np.abs(values) < _LARGEST, f"must be a finite number below {_LARGEST:g}", "correct it")
    hint, repeated = "delete it, or sort the times", int(np.count_nonzero(times[1:] == times[:-1]))
    if repeated > 1 + times.size // 100:  # fewer are errors of single rows
        hint = "where digits are missing, set interval to the sampling interval of the instrument"
    if ((times[1:] <= times[0]) & (np.diff(times) < 0)).any():
        hint = "a second record begins here: keep one of them"
    _check("times", times, np.append(True, times[1:] > times[:-1]), "must be greater than the one before", hint)


def _check(name: str, values: FloatArray, right: npt.NDArray[np.bool_], rule: str, hint: str) -> None:
    """Raise an error for the first of ``values`` that is not ``right``."""
    if not right.all():
        at = int(np.argmin(right))
        got = f"got {values[at]:g}, one of {np.count_nonzero(~right)}"
        raise InvalidValueError.of(f"{name}[{at}]", f"{rule} ({got}; {hint})")


# ---------------------------------------------------------------- steps


def _samples_within(times: FloatArray, name: str, window: tuple[float, float], fewest: int) -> slice:
    """Samples in a time window [s]."""
    margin = _AT_END * (times[-1] - times[0]) / times.size
    start, stop = np.searchsorted(times, (window[0] - margin, window[1] + margin)).tolist()
    if stop - start < fewest:
        got = f"got {stop - start}; the record is {times[0]:g} to {times[-1]:g} s"
        raise InvalidValueError.of(name, f"must contain {fewest} samples or more ({got})")
    return slice(start, stop)


def _filter_forces(times: FloatArray, forces: FloatArray, low_pass: float) -> FloatArray:
    """The forces after a Butterworth filter that is applied forwards and backwards, so that it shifts no phase."""
    from scipy import signal  # needed only here

    steps = np.diff(times)
    rate = float(1 / steps.mean())
    if np.ptp(steps) > _UNEVEN * steps.mean() or not low_pass < rate / 2:
        rule = "must be below half the sampling rate of evenly spaced samples"
        got = f"got {low_pass:g} Hz for {forces.size} samples every {steps.min():.4g} to {steps.max():.4g} s"
        raise InvalidValueError.of("low_pass", f"{rule} ({got})")
    sections = signal.butter(_ORDER, low_pass, fs=rate, output="sos")
    extension = min(forces.size - 1, int(np.ceil(_EXTENSION * rate / low_pass)))
    return np.asarray(signal.sosfiltfilt(sections, forces, padlen=extension), dtype=float)


# ---------------------------------------------------------------- warnings


def pulse_warnings(
    times: FloatArray, forces: FloatArray, ratio: float | None, steps: Processing, pulse: Pulse
) -> list[str]:
    """Warnings that a record may not be a pulse alone, or not the whole pulse, with the keys that would change it."""
    samples = slice(None) if steps["crop"] is None else _samples_within(times, "crop", steps["crop"], 3)
    if wrong := glitches(forces[samples]):
        value = f"{forces[samples][wrong[0]]:.4g} N at {si(times[samples][wrong[0]], 's')}"
        return [f"A sample, {value}, is far from those beside it: correct or delete it."]
    sentences, advice = sample_warnings(times[samples], forces[samples]), _advice(times, forces, ratio, steps)
    with suppress(InvalidValueError):  # unfiltered, it may be no pulse
        full = pulse_of(times, forces, ratio, {**steps, "low_pass": None, "negative": steps["negative"] or "zero"})
        if abs(pulse.peak_force - full.peak_force) > _DISTORTED * full.peak_force:
            sentences.append(
                f"The low-pass filter distorts the pulse of {full.peak_force:.4g} N: set a higher low_pass."
            )
    if steps["negative"] == "zero" and pulse.negative > _MANY:
        share = f"{percent(pulse.negative)} of that of the others"
        sentences.append(f"The impulse of the samples set to zero is {share}: set baseline to a window without force.")
    if advice:
        sentences.append(f"The record is longer than its pulse, has a second one or an offset ({advice}).")
    elif steps["crop"] is None or times[samples].size < times.size:  # a crop can state that all is the pulse
        first, last = abs(pulse.values[0]), abs(pulse.values[-1])
        if max(first, last) > (_NOTICEABLE if steps["crop"] is None else _CUT):
            hint = f"set baseline for an offset; crop: {_window(times[0], times[-1])} keeps all of it"
            ends = f"begins at {percent(first)} and ends at {percent(last)} of its peak force"
            sentences.append(f"The record {ends} ({hint}).")
    return sentences


def _advice(times: FloatArray, forces: FloatArray, ratio: float | None, steps: Processing) -> str:
    """Keys that reduce the record to its pulse, and their effect; empty if the effect is small."""
    windows = propose(times, forces, steps["baseline"] is None, steps["crop"] is None)
    present = {**steps, "negative": steps["negative"] or "zero"}
    with suppress(InvalidValueError):  # a proposal that leaves no pulse is none
        before, after = (pulse_of(times, forces, ratio, each) for each in (present, present | windows))
        keys = [f"{key}: {_window(*window)}" for key, window in windows.items()]
        if "baseline" in windows:
            keys[0] += f" (subtracts {forces[_samples_within(times, 'baseline', windows['baseline'], 1)].mean():.4g} N)"
        if steps["negative"] is None and after.negative > 0:
            keys.append("negative: zero")
        if effect := changes(before.figures, after.figures, _NOTICEABLE):
            return f"{', '.join(keys)} would change {effect}"
    return ""


def _window(start: float, stop: float) -> str:
    return f"[{si(start, 's', 9)}, {si(stop, 's', 9)}]"


def _figures(times: FloatArray, forces: FloatArray) -> dict[str, float]:
    """Peak force [N], rise time [s] and impulse [N s]."""
    peak = int(np.argmax(forces))
    figures = {"peak_force": forces[peak], "rise_time": times[peak] - times[0], "impulse": _impulse(times, forces)}
    return {name: float(value) for name, value in figures.items()}


def changes(before: Mapping[str, float], after: Mapping[str, float], least: float = _UNCHANGED) -> str:
    """Relative changes of figures beyond ``least``, with their names; the rise includes what precedes a pulse."""
    names = {name: name.replace("rise_time", "time to the peak").replace("_", " ") for name in before}
    relative = {names[name]: (after[name] - old) / abs(old) for name, old in before.items() if old}
    return ", ".join(f"{name} {percent(by, '+')}" for name, by in relative.items() if abs(by) > least)


def _impulse(times: FloatArray, values: FloatArray) -> float:
    return float(np.sum(0.5 * np.diff(times) * (values[1:] + values[:-1])))
