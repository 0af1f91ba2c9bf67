"""The profile of a force record, without its baseline and quiet ends, linear between samples."""

from __future__ import annotations

import os
import pathlib
import re
from bisect import bisect_right
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from attrs import frozen

from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import Quantity, quantity, text_of
from shockwave.numerics import running_sums
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.record_file import Record, read_record
from shockwave.quadrature import FloatArray

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath

# Force, over the peak force, above which the pulse has certainly begun.
_BEGUN = 0.05
# Force, over the peak force, above which the pulse has certainly not ended.
_ENDED = 0.01
# Largest baseline, over the peak force.
_HIGHEST_BASELINE = 0.2
# Largest standard deviation of the noise of a baseline, over the peak force.
_WIDEST_NOISE = 0.02
# Forces below this fraction of the peak force are rounding errors.
_ROUNDING = 1e-12
# Smallest relative change of impulse and peak force by the cleaning that a note states.
_NOTICEABLE = 1e-4
# Samples within this number of standard deviations of the noise are quiet.
_QUIET = 3
# Samples beyond this number are certainly not noise: a long tail has random samples beyond 3, but not beyond 5.
_CERTAIN = 5
# Fewest samples before the pulse from which a baseline can be determined.
_SHORTEST_LEAD = 5
# Longest pulse in rise times: the square of a longer one overflows.
_LONGEST = 1e150
# Errors that are reported for one record: more would not help to correct it.
_MOST_FAULTS = 20


def _samples(value: Any, attribute: attrs.Attribute[Any]) -> FloatArray:
    """A read-only copy as floats."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        array = np.zeros(())
    if array.ndim != 1:
        raise InvalidValueError.of(attribute.name, f"must be a sequence of numbers (got {text_of(value)})")
    array.setflags(write=False)
    return array


def _column(unit: str, meaning: str) -> Any:
    """An attrs field that holds samples."""
    return attrs.field(
        converter=attrs.Converter(_samples, takes_field=True),
        eq=attrs.cmp_using(eq=np.array_equal),
        repr=partial(np.array2string, separator=", ", threshold=8, precision=4, max_line_width=200),
        metadata={"shockwave": Quantity(unit, meaning, samples=True)},
    )


@frozen(eq=False)
class Pulse:
    """A pulse in units of its peak force [N] and rise time [s]: forces ``values`` at the times ``knots``."""

    knots: FloatArray
    values: FloatArray
    peak_force: float
    rise_time: float
    notes: tuple[str, ...]


@frozen(slots=False)
class Tabulated(ShockProfile):
    """A force record, linear between its samples, with its own peak force, rise time and duration ratio n.

    The rise ends at the first sample with the highest force; a plateau is part of the decay. Unless ``clean`` is False,
    a baseline, negative forces and quiet samples around the pulse are removed; `notes` state what this changes.

    Parameters
    ----------
    times : array_like of float, shape (k,)
        Sample times [s], ascending; at least three.
    forces : array_like of float, shape (k,)
        Forces [N]; the highest is above zero, and neither the first nor the last.
    duration_ratio : float, optional
        n of eq. (2), above 1, to which the decay is stretched in time. By default n is that of the record.
    clean : bool
        Whether to remove what does not belong to the pulse. If not, the force must not be negative.

    Raises
    ------
    InvalidValueError
        If the samples are not a pulse; each error states its sample.
    """

    times: Any = _column("s", "sample times, ascending")  # noqa: RUF009
    forces: Any = _column("N", "forces at these times")  # noqa: RUF009
    duration_ratio: float = quantity(
        "", "total duration over rise time; the decay is stretched to fit", above=1.0, optional=True, default=None
    )
    clean: bool = True
    _pulse: Pulse = attrs.field(init=False, repr=False, eq=False)
    _assumed: tuple[str, ...] = attrs.field(init=False, repr=False, eq=False, default=())

    def __attrs_post_init__(self) -> None:
        if not isinstance(self.clean, bool):
            raise InvalidValueError.of("clean", f"must be True or False (got {text_of(self.clean)})")
        pulse = pulse_of(self.times, self.forces, self.duration_ratio, self.clean)
        object.__setattr__(self, "_pulse", pulse)
        object.__setattr__(self, "duration_ratio", float(pulse.knots[-1]))

    @classmethod
    def from_file(
        cls, path: str | os.PathLike[str], duration_ratio: float | None = None, clean: bool = True
    ) -> Tabulated:
        """Read the profile from a text file with a time and a force column; see `read_record`.

        Parameters
        ----------
        path : path-like
            The file. Its header can name units; without units, seconds and newtons are assumed.
        duration_ratio, clean
            As for the class.

        Raises
        ------
        FileAccessError
            If the file cannot be read.
        InvalidValueError
            If the file does not contain a pulse; each error states its line.
        """
        record = read_record(pathlib.Path(path))
        try:
            profile = cls(record.times, record.forces, duration_ratio, clean)  # type: ignore[arg-type]
        except InvalidValueError as error:
            raise InvalidValueError([_placed(fault, path, record) for fault in error.faults]) from None
        object.__setattr__(profile, "_assumed", record.notes)
        return profile

    def __hash__(self) -> int:
        return hash((self.times.size, self.duration_ratio, self.recorded_peak_force, self.recorded_rise_time))

    @cached_property
    def breakpoints(self) -> tuple[float, ...]:
        return tuple(self._pulse.knots.tolist())

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
        return np.asarray(self._at(s)[2])

    def decay(self, s: FloatArray) -> FloatArray:
        return np.asarray(self._at(s)[2])

    def closed_areas(self) -> tuple[float, float]:
        return self._sums[2]

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        before, step, force = self._at(s)
        return np.asarray(self._sums[0][before] + 0.5 * step * (self._pulse.values[before] + force))

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        before, step, force = self._at(s)
        rest = step * (2.0 * self._pulse.values[before] + force) / 6.0
        return np.asarray(self._sums[1][before] + step * (self._sums[0][before] + rest))

    def closed_at(self, s: float) -> tuple[float, float]:
        before = min(bisect_right(self.breakpoints, s), len(self.breakpoints) - 1) - 1
        begin, end = self.breakpoints[before : before + 2]
        left, right = self._pulse.values[before : before + 2].tolist()
        force = left + (s - begin) / (end - begin) * (right - left)
        return float(self._sums[0][before]) + 0.5 * (s - begin) * (left + force), force

    def closed_free_path(self) -> FreePath:
        from shockwave.profiles.free_path import of_samples

        return of_samples(self._pulse.knots, self._pulse.values, *self._sums[:2])

    @cached_property
    def _sums(self) -> tuple[FloatArray, FloatArray, tuple[float, float]]:
        """Running impulse and double integral at the samples; a1 and a2."""
        widths = np.diff(self._pulse.knots)
        left, right = self._pulse.values[:-1], self._pulse.values[1:]
        areas = 0.5 * widths * (left + right)
        impulses = running_sums(areas)
        paths = running_sums(widths * (impulses[:-1] + widths * (2.0 * left + right) / 6.0))
        peak = int(np.argmax(self._pulse.values))
        # The decay is summed separately: a difference of two sums would lose digits of a short decay.
        return impulses, paths, (float(impulses[peak]), float(running_sums(areas[peak:])[-1]))

    def _at(self, s: FloatArray) -> tuple[Any, Any, Any]:
        """Index of the sample before ``s``, distance from it, and force at ``s``, each of the shape of ``s``."""
        knots, values = self._pulse.knots, self._pulse.values
        before = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, knots.size - 2)
        step = s - knots[before]
        left, right = values[before], values[before + 1]
        # A fraction of the interval instead of a slope, which could overflow for close samples.
        return before, step, left + step / (knots[before + 1] - knots[before]) * (right - left)


def _placed(fault: Fault, path: str | os.PathLike[str], record: Record) -> Fault:
    """``fault`` with the line of the sample that it concerns."""
    index = re.search(r"\[(\d+)\]", fault.path)
    line = record.lines[int(index[1])] if index else record.lines[0]
    return attrs.evolve(fault, location=f"{path}:{line}")


# ---------------------------------------------------------------- cleaning


def pulse_of(times: FloatArray, forces: FloatArray, ratio: float | None, clean: bool = True) -> Pulse:
    """Extract the pulse of a record.

    Parameters
    ----------
    times, forces : array of float, shape (k,)
        Samples [s] and [N].
    ratio : float, optional
        Duration ratio to which the decay is stretched.
    clean : bool
        Whether to remove everything but the pulse.

    Raises
    ------
    InvalidValueError
        If the samples are not a pulse; each error states its sample.
    """
    _check_samples(times, forces)
    values, peak_force, start, notes = _cleaned(times, forces) if clean else _uncleaned(forces)
    notes += _ends_notes(values, peak_force)
    peak = int(np.argmax(values))
    if peak in (0, values.size - 1):
        part, where = ("rise", "before") if peak == 0 else ("decay", "after")
        problem = f"must not be the peak, because then there is no {part} (got {peak_force:g} N; add a sample of zero"
        raise InvalidValueError.of(f"forces[{start + peak}]", f"{problem} force {where} it)")
    # Extremely large times overflow.
    with np.errstate(over="ignore", invalid="ignore"):
        elapsed = times[start : start + values.size] - times[start]
        knots = elapsed / elapsed[peak]
        if ratio is not None and ratio != knots[-1]:
            notes.append(f"The decay was stretched in time: n is {ratio:g}, that of the record {knots[-1]:g}.")
            knots[peak + 1 :] = 1.0 + (knots[peak + 1 :] - 1.0) * ((ratio - 1.0) / (knots[-1] - 1.0))
            knots[-1] = ratio
        if not (np.diff(knots) > 0).all() or not knots[-1] < _LONGEST:
            rule = f"must differ by more than rounding errors and span less than {_LONGEST:g} rise times"
            raise InvalidValueError.of("times", f"{rule} (got n = {knots[-1]:g})")
    return Pulse(knots, values, peak_force, float(elapsed[peak]), tuple(notes))


def _check_samples(times: FloatArray, forces: FloatArray) -> None:
    faults = _number_faults("times", "s", times) + _number_faults("forces", "N", forces)
    if faults:
        raise InvalidValueError(faults[:_MOST_FAULTS])
    if forces.size != times.size:
        problem = f"must have one force for each time (got {forces.size} forces and {times.size} times)"
        faults.append(Fault("forces", problem))
    elif times.size < 3:
        faults.append(Fault("times", f"must have at least three samples: beginning, peak and end (got {times.size})"))
    for index in (np.flatnonzero(times[1:] <= times[:-1])[:_MOST_FAULTS] + 1).tolist():
        got = f"got {times[index]:g} s after {times[index - 1]:g} s; sort the samples and remove repeated ones"
        faults.append(Fault(f"times[{index}]", f"must be greater than times[{index - 1}] ({got})"))
    if forces.size and forces.max() <= 0:
        got = f"got at most {forces.max():g} N; if compression is negative, change the sign"
        faults.append(Fault("forces", f"must be > 0 N somewhere ({got})"))
    if faults:
        raise InvalidValueError(faults)


def _number_faults(name: str, unit: str, values: FloatArray) -> list[Fault]:
    """Errors for the ``values`` that are not finite numbers."""
    wrong = np.flatnonzero(~np.isfinite(values))[:_MOST_FAULTS]
    return [Fault(f"{name}[{at}]", f"must be a finite number of {unit} (got {values[at]:g})") for at in wrong.tolist()]


def _cleaned(times: FloatArray, forces: FloatArray) -> tuple[FloatArray, float, int, list[str]]:
    """Remove everything but the pulse.

    Returns
    -------
    tuple
        Force over peak force, shape (samples of the pulse,); peak force [N]; index of the first sample; notes.
    """
    baseline, noise, count = _quiet_lead(forces)
    above = forces - baseline if baseline else forces
    peak_force = float(above.max())
    below = np.minimum(above, 0.0) / peak_force
    values = np.maximum(above, 0.0) / peak_force
    start, stop = _ends(values, noise / peak_force)
    pulse = values[start : stop + 1].copy()
    # Forces within the noise of the quiet lead are zero.
    pulse[[0, -1]] *= pulse[[0, -1]] > _QUIET * noise / peak_force
    impulse = _impulse(times[start : stop + 1], pulse)

    notes = []

    def note(change: str, part: float) -> None:
        notes.append(f"{change} ({100 * abs(part) / impulse:.2g} % of the impulse).")

    if times[0] != 0:
        notes.append(f"The times begin at {times[0]:g} s and were shifted to begin at zero.")
    if baseline:
        found = f"A baseline of {baseline:.4g} N, the mean of the {count} samples before the pulse,"
        note(f"{found} was subtracted", baseline / peak_force * (times[stop] - times[start]))
    if below.any():
        note(f"Negative samples were set to zero: {np.count_nonzero(below)} of {forces.size}", _impulse(times, below))
    for cut, where in ((slice(0, start + 1), "before"), (slice(stop, None), "after")):
        number = times[cut].size - 1
        if number:
            note(f"Quiet samples {where} the pulse were removed: {number}", _impulse(times[cut], values[cut]))
    before, highest = _impulse(times, forces), float(forces.max())
    changes = impulse * peak_force / before - 1 if before else 1.0, peak_force / highest - 1
    if max(map(abs, changes)) > _NOTICEABLE:
        changed = f"the impulse by {100 * changes[0]:+.2g} % and the peak force by {100 * changes[1]:+.2g} %"
        notes.append(f"Together this changes {changed} (clean: false keeps the record as it is).")
    return pulse, peak_force, start, notes


def _uncleaned(forces: FloatArray) -> tuple[FloatArray, float, int, list[str]]:
    """As `_cleaned`, for a record that is left as it is."""
    negative = np.flatnonzero(forces < 0)[:_MOST_FAULTS].tolist()
    if negative:
        problem = "must be >= 0 N in a record that is not cleaned (got {:g} N; clean: true sets it to zero)"
        raise InvalidValueError([Fault(f"forces[{at}]", problem.format(forces[at])) for at in negative])
    return forces / forces.max(), float(forces.max()), 0, []


def _ends_notes(pulse: FloatArray, peak_force: float) -> list[str]:
    """Notes on a pulse that does not begin or end at zero."""
    size = "{:.4g} N, {:.2g} % of its peak: the force is discontinuous there."
    ends = [(end, verb) for end, verb in ((0, "begins"), (-1, "ends")) if pulse[end] > _ROUNDING]
    return [f"The record {verb} at {size.format(pulse[end] * peak_force, 100 * pulse[end])}" for end, verb in ends]


def _ends(values: FloatArray, noise: float) -> tuple[int, int]:
    """Indices of the first and last sample of the pulse: the zeros next to the part that certainly belongs to it."""
    begun = int(np.argmax(values >= max(_BEGUN, _CERTAIN * noise)))
    ended = values.size - 1 - int(np.argmax(values[::-1] >= max(_ENDED, _CERTAIN * noise)))
    before = np.flatnonzero(values[:begun] <= _QUIET * noise)
    after = np.flatnonzero(values[ended:] <= 0)
    if not after.size:
        after = np.flatnonzero(values[ended:] <= _QUIET * noise)
    start = int(before[-1]) if before.size else 0
    return start, ended + int(after[0]) if after.size else values.size - 1


def _quiet_lead(forces: FloatArray) -> tuple[float, float, int]:
    """Baseline [N], noise [N] and number of the samples before the pulse; zeros if there are too few of them."""
    peak, mean = forces.max(), np.median(forces[:_SHORTEST_LEAD])
    noise, least = forces[:_SHORTEST_LEAD].std(), _BEGUN * (peak - mean)
    for _ in range(2):  # the first five samples give only a rough estimate of the noise
        count = int(np.argmax(forces - mean >= max(least, _CERTAIN * noise)))
        while count >= _SHORTEST_LEAD and not _is_flat(forces[:count], peak):
            count = 3 * count // 4  # the beginning of a slow rise is not part of the lead
        if count < _SHORTEST_LEAD:
            return 0.0, 0.0, 0
        mean, noise, least = forces[:count].mean(), forces[:count].std(ddof=1), 0.0
        if noise <= _ROUNDING * peak:
            return float(forces[0]), 0.0, count
    if abs(mean) > _CERTAIN * noise / np.sqrt(count):
        return float(mean), float(noise), count
    # Without a baseline, noise has both signs; a record without noise does not.
    return 0.0, float(noise) if forces[:count].min() < 0 else 0.0, count


def _is_flat(lead: FloatArray, peak: float) -> bool:
    """Whether samples scatter about a constant level, unlike those of a slowly rising force."""
    mean, spread, steps = abs(lead.mean()), lead.std(), np.diff(lead)
    if spread <= _ROUNDING * peak:
        return bool(mean < _HIGHEST_BASELINE * peak)
    # Von Neumann's ratio is 2 for independent samples and near 0 for a smooth curve. Filtered noise is smooth, too; it
    # differs from a curve that begins at zero by a level far above its standard deviation.
    rough = np.mean(steps**2) >= spread**2
    level = mean > 4 * spread and steps.min() < 0 < steps.max()
    small = mean < _HIGHEST_BASELINE * peak and spread < _WIDEST_NOISE * peak
    return bool(small and (rough or level))


def _impulse(times: FloatArray, values: FloatArray) -> float:
    return float(np.sum(0.5 * np.diff(times) * (values[1:] + values[:-1])))
