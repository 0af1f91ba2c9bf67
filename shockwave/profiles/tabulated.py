"""Tabulated: the shape of a recorded force, piecewise linear between its samples."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable
from functools import cached_property, partial
from itertools import islice
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from attrs import frozen

from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import Quantity, text_of
from shockwave.numerics import scatter
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.record import read_record
from shockwave.quadrature import FloatArray

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath

__all__ = ["Tabulated"]

# Shares of the peak: where a pulse has begun and where it has ended, and what a baseline may be.
_BEGUN, _ENDED = 0.05, 0.01
_HIGHEST_BASELINE, _WIDEST_NOISE = 0.2, 0.02
_ROUGH, _MANY = 0.01, 50  # scatter that hides where a pulse begins; samples that it takes to see it
_ROUNDING = 1e-12
# In standard deviations of the lead. A long tail holds a chance sample beyond 3, but none beyond 5.
_QUIET, _CERTAIN = 3, 5
_SHORTEST_LEAD, _MOST_FAULTS = 5, 20

_RATIO = Quantity("", "whole duration over rise time, stretches the decay", above=1.0, optional=True)
_TIMES = Quantity("s", "sample times, ascending", samples=True)
_FORCES = Quantity("N", "forces at these times", samples=True)
_same = attrs.cmp_using(eq=np.array_equal)
_shown = partial(np.array2string, separator=", ", threshold=8, precision=4, max_line_width=200)


def _samples(value: Any) -> Any:
    """A read-only copy as floats; what holds no numbers is left alone, for the check to report."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            if array.ndim != 1 or any(_TIMES.problem(sample) for sample in value):
                return value
            array = np.array([float(sample) for sample in value])
        with np.errstate(over="ignore"):
            array = np.array(array, dtype=float)
    except (TypeError, ValueError):
        return value
    array.setflags(write=False)
    return array


def _ratio(value: Any) -> Any:
    return _RATIO.convert(value)


def _check_ratio(_: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    if (problem := _RATIO.problem(value)) is not None:
        raise InvalidValueError.of(attribute.name, problem)


@frozen
class Tabulated(ShockProfile):
    """A force record, linear between its samples; peak force, rise time and n are read off it.

    The rise ends at the first sample of the highest force; a plateau belongs to the decay. A baseline,
    forces below zero and the quiet before and after the pulse are removed, and `notes` tell so.

    Parameters
    ----------
    times : array_like of float, shape (k,)
        Sample times [s], ascending; at least three.
    forces : array_like of float, shape (k,)
        Forces [N]; the highest is above zero, and neither the first nor the last.
    duration_ratio : float, optional
        n of eq. (2), > 1: the decay is stretched in time to have it. Left out, n is the record's.

    Raises
    ------
    InvalidValueError
        When the samples are no pulse; each fault names its sample.
    """

    times: FloatArray = attrs.field(converter=_samples, eq=_same, repr=_shown, metadata={"shockwave": _TIMES})
    forces: FloatArray = attrs.field(converter=_samples, eq=_same, repr=_shown, metadata={"shockwave": _FORCES})
    duration_ratio: float = attrs.field(
        default=None, converter=_ratio, validator=_check_ratio, metadata={"shockwave": _RATIO}
    )
    _pulse: _Pulse = attrs.field(init=False, repr=False, eq=False)
    _assumed: tuple[str, ...] = attrs.field(init=False, repr=False, eq=False, default=())

    def __attrs_post_init__(self) -> None:
        pulse = _pulse_of(self.times, self.forces, self.duration_ratio, lambda index: "")
        object.__setattr__(self, "_pulse", pulse)
        object.__setattr__(self, "duration_ratio", float(pulse.knots[-1]))

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], duration_ratio: float | None = None) -> Tabulated:
        """The profile of a record in a text file with a time and a force column; see `read_record`.

        Parameters
        ----------
        path : path-like
            The file. Its header may name units; without any, seconds and newtons are assumed.
        duration_ratio : float, optional
            As for the class.

        Raises
        ------
        FileAccessError
            When the file cannot be read.
        InvalidValueError
            When it holds no pulse; each fault names its line.
        """
        record = read_record(pathlib.Path(path))
        try:
            profile = cls(record.times, record.forces, duration_ratio)
        except InvalidValueError:
            # Once more, for the same faults with the lines on which they stand.
            places = [f"{path}:{line}" for line in record.lines.tolist()]
            _pulse_of(record.times, record.forces, None, places.__getitem__)
            raise
        object.__setattr__(profile, "_assumed", record.notes)
        return profile

    def __hash__(self) -> int:
        return hash((self.times.size, self.duration_ratio, self.recorded_peak_force, self.recorded_rise_time))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        return self._pulse.breakpoints

    @property
    def recorded_peak_force(self) -> float:
        return self._pulse.peak_force

    @property
    def recorded_rise_time(self) -> float:
        return self._pulse.rise_time

    @property
    def notes(self) -> tuple[str, ...]:
        return self._assumed + self._pulse.notes

    def rise(self, s: FloatArray) -> FloatArray:
        return self._pulse.force(s)

    def decay(self, s: FloatArray) -> FloatArray:
        return self._pulse.force(s)

    def closed_areas(self) -> tuple[float, float]:
        return self._pulse.areas

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        return self._pulse.running_impulse(s)

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        return self._pulse.double_integral(s)

    def closed_free_path(self) -> FreePath:
        return self._pulse.free_path


# ---------------------------------------------------------------- the scaled pulse


@frozen(slots=False, eq=False)
class _Pulse:
    """A pulse in scaled units at its samples, with its integrals up to each of them."""

    knots: FloatArray
    values: FloatArray
    peak: int
    peak_force: float
    rise_time: float
    notes: tuple[str, ...]
    impulses: FloatArray = attrs.field(init=False)
    paths: FloatArray = attrs.field(init=False)
    areas: tuple[float, float] = attrs.field(init=False)

    def __attrs_post_init__(self) -> None:
        widths, left, right = np.diff(self.knots), self.values[:-1], self.values[1:]
        areas = 0.5 * widths * (left + right)
        impulses = _running_sum(areas)
        paths = _running_sum(widths * (impulses[:-1] + widths * (2.0 * left + right) / 6.0))
        object.__setattr__(self, "impulses", impulses)
        object.__setattr__(self, "paths", paths)
        # The decay is summed for itself: the difference of two sums would lose digits of a short one.
        decay = _running_sum(areas[self.peak :])
        object.__setattr__(self, "areas", (float(impulses[self.peak]), float(decay[-1])))

    @cached_property
    def breakpoints(self) -> tuple[float, ...]:
        return tuple(self.knots.tolist())

    @cached_property
    def free_path(self) -> FreePath:
        from shockwave.profiles.free_path import of_samples

        return of_samples(self.knots, self.values, self.impulses, self.paths)

    def force(self, s: FloatArray) -> FloatArray:
        return np.asarray(self._at(s)[2])

    def running_impulse(self, s: FloatArray) -> FloatArray:
        before, step, force = self._at(s)
        return np.asarray(self.impulses[before] + 0.5 * step * (self.values[before] + force))

    def double_integral(self, s: FloatArray) -> FloatArray:
        before, step, force = self._at(s)
        rest = step * (2.0 * self.values[before] + force) / 6.0
        return np.asarray(self.paths[before] + step * (self.impulses[before] + rest))

    def _at(self, s: FloatArray) -> tuple[Any, Any, Any]:
        """Index of the sample before ``s``, distance from it, and the force at ``s``."""
        before = np.clip(np.searchsorted(self.knots, s, side="right") - 1, 0, self.knots.size - 2)
        step = s - self.knots[before]
        left, right = self.values[before], self.values[before + 1]
        # A share of the step, not a slope: it stays finite however close two samples are.
        return before, step, left + step / (self.knots[before + 1] - self.knots[before]) * (right - left)


def _running_sum(terms: FloatArray) -> FloatArray:
    """Sums of the first 0, 1, 2, ... terms, each good to the last digits: Knuth's two-sum, vectorised."""
    sums = np.concatenate(([0.0], np.cumsum(terms)))
    before, after = sums[:-1], sums[1:]
    added = after - before
    lost = (before - (after - added)) + (terms - added)
    after += np.cumsum(lost)
    return sums


# ---------------------------------------------------------------- from samples to the pulse


def _pulse_of(times: Any, forces: Any, ratio: float | None, place: Callable[[int], str]) -> _Pulse:
    """Check, clean and scale a record; ``place`` tells where in a file a sample stands."""
    _check_samples(times, forces, place)
    # Samples of absurd size overflow: what comes of it is caught at the end.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        values, peak_force, start, notes = _cleaned(times, forces)
        peak = int(np.argmax(values))
        if peak in (0, values.size - 1):
            what, where = ("rise", "before") if peak == 0 else ("decay", "after")
            problem = f"must not be the peak, for then there is no {what} (got {peak_force:g} N; "
            remedy = f"put a sample of zero force {where} it)"
            raise InvalidValueError([Fault(f"forces[{start + peak}]", problem + remedy, place(start + peak))])
        elapsed = times[start : start + values.size] - times[start]
        rise_time = elapsed[peak]
        knots = elapsed / rise_time
        if ratio is not None and ratio != knots[-1]:
            notes.append(f"the decay was stretched in time: n is {ratio:g}, that of the record {knots[-1]:g}")
            knots[peak + 1 :] = 1.0 + (knots[peak + 1 :] - 1.0) * ((ratio - 1.0) / (knots[-1] - 1.0))
            knots[-1] = ratio
        pulse = _Pulse(knots, values, peak, peak_force, float(rise_time), tuple(notes))
    merged = np.flatnonzero(~(knots[1:] > knots[:-1]))
    if merged.size:
        index = start + int(merged[0]) + 1
        problem = f"must differ from the sample before by more than rounding (got {times[index]:g} s)"
        raise InvalidValueError([Fault(f"times[{index}]", problem, place(index))])
    if not np.isfinite(pulse.paths[-1]):
        problem = f"must last less than 1e150 rise times, and forces be finite (got n = {knots[-1]:g})"
        raise InvalidValueError([Fault("times", problem, place(start))])
    return pulse


def _check_samples(times: Any, forces: Any, place: Callable[[int], str]) -> None:
    faults = _number_faults("times", _TIMES, times, place) + _number_faults("forces", _FORCES, forces, place)
    if faults:
        raise InvalidValueError(faults[:_MOST_FAULTS])
    if forces.size != times.size:
        problem = f"must have one force for each time (got {forces.size} forces and {times.size} times)"
        faults.append(Fault("forces", problem))
    elif times.size < 3:
        problem = f"must have at least three samples, start, peak and end (got {times.size})"
        faults.append(Fault("times", problem, place(0) if times.size else ""))
    for index in (np.flatnonzero(times[1:] <= times[:-1])[:_MOST_FAULTS] + 1).tolist():
        got = f"got {times[index]:g} s after {times[index - 1]:g} s; sort the samples, and drop repeated ones"
        problem = f"must be greater than times[{index - 1}] ({got})"
        faults.append(Fault(f"times[{index}]", problem, place(index)))
    if forces.size and forces.max() <= 0:
        highest = int(np.argmax(forces))
        got = f"got at most {forces[highest]:g} N; turn the sign, if pressure is negative"
        problem = f"must be > 0 N somewhere ({got})"
        faults.append(Fault("forces", problem, place(highest)))
    if faults:
        raise InvalidValueError(faults)


def _number_faults(name: str, spec: Quantity, values: Any, place: Callable[[int], str]) -> list[Fault]:
    """What in ``values``, as the converter left it, is no finite number."""
    row = isinstance(values, np.ndarray) and values.ndim == 1
    numeric = row and values.dtype == float
    if numeric:
        suspects = [(index, float(values[index])) for index in np.flatnonzero(~np.isfinite(values)).tolist()]
    else:
        suspects = list(enumerate(values)) if row or isinstance(values, list | tuple) else []
    problems = ((index, problem) for index, sample in suspects if (problem := spec.problem(sample)))
    faults = [Fault(f"{name}[{i}]", problem, place(i)) for i, problem in islice(problems, _MOST_FAULTS)]
    if not faults and not numeric:
        got = text_of(values.tolist() if isinstance(values, np.ndarray) else values)
        faults.append(Fault(name, f"must be a sequence of numbers (got {got})"))
    return faults


def _cleaned(times: FloatArray, forces: FloatArray) -> tuple[FloatArray, float, int, list[str]]:
    """(force over peak force of the pulse alone, peak force [N], index of its first sample, notes)."""
    baseline, noise, count = _quiet_lead(forces)
    above = forces - baseline if baseline else forces
    peak_force = float(above.max())
    below = np.minimum(above, 0.0) / peak_force
    values = np.maximum(above, 0.0) / peak_force
    start, stop = _ends(values, noise / peak_force)
    kept, pulse = slice(start, stop + 1), values[start : stop + 1].copy()
    # What lies within the noise of a quiet lead is as good as zero.
    pulse[[0, -1]] *= pulse[[0, -1]] > _QUIET * noise / peak_force
    impulse = _area(times[kept], pulse)

    def share(part: np.float64) -> str:
        return f"{100 * abs(part) / impulse:.2g} % of the impulse"

    notes = []
    if times[0] != 0:
        notes.append(f"the times start at {times[0]:g} s, and were shifted to start at zero")
    if baseline:
        what = f"a baseline of {baseline:.4g} N, the mean of the {count} samples before the pulse"
        notes.append(f"{what}, was subtracted ({share(baseline / peak_force * (times[stop] - times[start]))})")
    if np.any(below):
        count_below = np.count_nonzero(below)
        lay = "lay below zero and was" if count_below == 1 else "lay below zero and were"
        notes.append(f"{count_below} of {forces.size} samples {lay} set to zero ({share(_area(times, below))})")
    for cut, where in ((slice(0, start + 1), "before"), (slice(stop, None), "after")):
        if times[cut].size > 1:
            part = share(_area(times[cut], values[cut]))
            number = times[cut].size - 1
            samples, were = ("sample", "was") if number == 1 else ("samples", "were")
            notes.append(f"{number} quiet {samples} {where} the pulse {were} cut off ({part})")
    for end, verb in ((0, "starts"), (-1, "ends")):
        if pulse[end] > _ROUNDING:
            size = f"{pulse[end] * peak_force:.4g} N, {100 * pulse[end]:.2g} % of its peak"
            notes.append(f"the record {verb} at {size}: the force jumps there")
    if not count and forces.size >= _MANY and (rough := scatter(forces) / peak_force) > _ROUGH:
        told = f"the record scatters by {rough:.1%} of its peak, and no quiet lead was found to take a baseline from"
        notes.append(f"{told}: rise time and duration may include what is not the pulse (cut the lead off, or smooth)")
    return pulse, peak_force, start, notes


def _ends(values: FloatArray, noise: float) -> tuple[int, int]:
    """First and last sample of the pulse: the zeros around what certainly belongs to it."""
    begun = int(np.argmax(values >= max(_BEGUN, _CERTAIN * noise)))
    ended = values.size - 1 - int(np.argmax(values[::-1] >= max(_ENDED, _CERTAIN * noise)))
    before = np.flatnonzero(values[:begun] <= _QUIET * noise)
    after = np.flatnonzero(values[ended:] <= 0)
    if not after.size:
        after = np.flatnonzero(values[ended:] <= _QUIET * noise)
    start = int(before[-1]) if before.size else 0
    return start, ended + int(after[0]) if after.size else values.size - 1


def _quiet_lead(forces: FloatArray) -> tuple[float, float, int]:
    """Baseline [N], noise [N] and number of the samples before the pulse; zeros where it starts at once."""
    peak, mean = forces.max(), np.median(forces[:_SHORTEST_LEAD])
    noise, least = forces[:_SHORTEST_LEAD].std(), _BEGUN * (peak - mean)
    for _ in range(2):  # five samples give but a first idea of the noise that the pulse must exceed
        count = int(np.argmax(forces - mean >= max(least, _CERTAIN * noise)))
        while count >= _SHORTEST_LEAD and not _is_flat(forces[:count], peak):
            count = 3 * count // 4  # the foot of a slow rise is no part of the lead
        if count < _SHORTEST_LEAD:
            return 0.0, 0.0, 0
        mean, noise, least = forces[:count].mean(), forces[:count].std(ddof=1), 0.0
        if noise <= _ROUNDING * peak:
            return float(forces[0]), 0.0, count
    if abs(mean) > _CERTAIN * noise / np.sqrt(count):
        return float(mean), float(noise), count
    # Without a baseline, noise has both signs; a clean record has not.
    return 0.0, float(noise) if forces[:count].min() < 0 else 0.0, count


def _is_flat(lead: FloatArray, peak: float) -> bool:
    """Whether samples scatter about one level, as those of a slowly rising force do not."""
    mean, spread, steps = abs(lead.mean()), lead.std(), np.diff(lead)
    if spread <= _ROUNDING * peak:
        return bool(mean < _HIGHEST_BASELINE * peak)
    # Von Neumann's ratio is 2 for independent samples and near 0 for a smooth curve. Noise that passed a
    # filter is smooth too: it is known by a level far above its spread, which a curve from zero cannot have.
    rough = np.mean(steps**2) >= spread**2
    level = mean > 4 * spread and steps.min() < 0 < steps.max()
    small = mean < _HIGHEST_BASELINE * peak and spread < _WIDEST_NOISE * peak
    return bool(small and (rough or level))


def _area(times: FloatArray, values: FloatArray) -> np.float64:
    return np.float64(np.sum(0.5 * np.diff(times) * (values[1:] + values[:-1])))
