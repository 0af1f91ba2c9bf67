"""Processing of a record: baseline, filter, crop, negative phase and quiet ends, with a note on the effect of each."""

from __future__ import annotations

import numpy as np
from attrs import define, field, frozen

from shockwave.errors import Fault, InvalidValueError
from shockwave.quadrature import FloatArray

#: Advice for a record in which compression is negative, unless it is a file.
CHANGE_SIGNS = "change the signs of forces"
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
# Largest negative phase, over the impulse, that is set to zero unasked.
_SMALL_PHASE = 0.01
# Order of the low-pass filter, which is applied forwards and backwards.
_ORDER = 4
# Fewest samples that are filtered.
_FEWEST_FILTERED = 16
# Periods of the cut-off frequency by which the filter extends the record at each end: its response has then decayed.
_EXTENSION = 2
# Largest relative difference of sampling intervals of a record that is filtered: times are rounded when written.
_UNEVEN = 0.1
# Relative change of impulse or peak force by a step that is due to rounding.
_UNCHANGED = 1e-9
# Smallest relative change of impulse and peak force by the cleaning that a note states.
_NOTICEABLE = 1e-4
# Smallest relative change of impulse or peak force by a low-pass filter that is a warning.
_DISTORTED = 0.2
# Largest peak force, over that before, of a pulse that a low-pass filter has removed.
_REMOVED = 0.05
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


@frozen(eq=False)
class Pulse:
    """A pulse in units of its peak force [N] and rise time [s]: forces ``values`` at the times ``knots``."""

    knots: FloatArray
    values: FloatArray
    peak_force: float
    rise_time: float
    notes: tuple[str, ...]
    alarms: tuple[str, ...]


Window = tuple[float, float] | None


@define(eq=False)
class _Process:
    """A record during its processing.

    ``first`` is the index of its first sample in the whole record, ``figures`` are peak force and impulse after a step,
    ``alarms`` are notes that put the pulse in doubt.
    """

    times: FloatArray
    forces: FloatArray
    first: int = 0
    notes: list[str] = field(factory=list)
    alarms: list[str] = field(factory=list)
    figures: tuple[float, ...] = ()

    def step(self, change: str, forces: FloatArray, kept: slice = slice(None)) -> None:
        """Take new ``forces``, of which the samples ``kept`` remain, and note the effect on peak force and impulse."""
        times, forces = self.times[kept], forces[kept]
        before = self.figures or (float(self.forces.max()), _impulse(self.times, self.forces))
        self.figures = after = float(forces.max()), _impulse(times, forces)
        effects = [
            f"{name} {100 * (new / old - 1):+.2g} %"
            for name, old, new in zip(("peak force", "impulse"), before, after, strict=True)
            if old > 0 and abs(new / old - 1) > _UNCHANGED
        ]
        self.notes.append(f"{change} ({', '.join(effects) or 'peak force and impulse unchanged'}).")
        self.times, self.forces, self.first = times, forces, self.first + (kept.start or 0)

    def within(self, name: str, window: tuple[float, float], fewest: int) -> slice:
        """Samples in a time window [s]."""
        start, stop = np.searchsorted(self.times, window[0]), np.searchsorted(self.times, window[1], side="right")
        if stop - start < fewest:
            rule = f"must contain {fewest} samples or more"
            got = f"got {stop - start} from {window[0]:g} to {window[1]:g} s"
            raise InvalidValueError.of(name, f"{rule} ({got}; the record is {self.times[0]:g} to {self.times[-1]:g} s)")
        return slice(int(start), int(stop))


def pulse_of(
    times: FloatArray,
    forces: FloatArray,
    ratio: float | None,
    clean: bool = True,
    *,
    baseline: Window = None,
    low_pass: float | None = None,
    crop: Window = None,
    negative: str | None = None,
) -> Pulse:
    """Extract the pulse of a record.

    Parameters
    ----------
    times, forces : array of float, shape (k,)
        Samples [s] and [N].
    ratio : float, optional
        Duration ratio to which the decay is stretched.
    clean : bool
        Whether to remove a baseline that precedes the pulse, and its quiet ends.
    baseline, low_pass, crop, negative
        As of `Tabulated`.

    Raises
    ------
    InvalidValueError
        If the samples are not a pulse; each error states its sample.
    """
    _check_samples(times, forces)
    _check_push(forces)
    process = _Process(times, forces)
    if clean and times[0] != 0:
        process.notes.append(f"The times begin at {times[0]:g} s and were shifted to begin at zero.")
    kept = slice(None) if crop is None else process.within("crop", crop, 3)
    if baseline is not None:
        window = process.within("baseline", baseline, 1)
        level = float(forces[window].mean())
        found = f"A baseline of {level:.4g} N, the mean from {baseline[0]:g} to {baseline[1]:g} s,"
        process.step(f"{found} was subtracted", forces - level)
    lead = _quiet_lead(process.forces) if clean else (0.0, 0.0, 0)
    # the record may begin with something that the crop removes
    level, noise, count = lead if lead[2] or not clean else _quiet_lead(process.forces[kept])
    if level and baseline is None:
        found = f"A baseline of {level:.4g} N, the mean of the {count} samples before the pulse,"
        process.step(f"{found} was subtracted", process.forces - level)
    if low_pass is not None:
        _apply_filter(process, low_pass)
        # the filtered pulse begins earlier
        noise = float(process.forces[: count // 2].std()) if noise else 0.0
    if crop is not None:
        process.step(f"The record was cropped to {crop[0]:g} to {crop[1]:g} s", process.forces, kept)
    _check_push(process.forces)
    _resolve_negative(process, noise, clean, negative)
    if clean:
        _cut_quiet_ends(process, noise)
        _note_sum(process, times, forces)
    values, peak_force = process.forces / process.forces.max(), float(process.forces.max())
    return _scaled_pulse(process, values, peak_force, ratio)


def _scaled_pulse(process: _Process, values: FloatArray, peak_force: float, ratio: float | None) -> Pulse:
    """The pulse in units of its peak force and rise time."""
    notes = [*process.notes, *_ends_notes(values, peak_force)]
    peak = int(np.argmax(values))
    if peak in (0, values.size - 1):
        part, where = ("rise", "before") if peak == 0 else ("decay", "after")
        problem = f"must not be the peak, because then there is no {part} (got {peak_force:g} N; add a sample of zero"
        raise InvalidValueError.of(f"forces[{process.first + peak}]", f"{problem} force {where} it)")
    # Extremely large times overflow.
    with np.errstate(over="ignore", invalid="ignore"):
        elapsed = process.times - process.times[0]
        knots = elapsed / elapsed[peak]
        if ratio is not None and ratio != knots[-1]:
            notes.append(f"The decay was stretched in time: n is {ratio:g}, that of the record {knots[-1]:g}.")
            knots[peak + 1 :] = 1.0 + (knots[peak + 1 :] - 1.0) * ((ratio - 1.0) / (knots[-1] - 1.0))
            knots[-1] = ratio
        if not (np.diff(knots) > 0).all() or not knots[-1] < _LONGEST:
            rule = f"must differ by more than rounding errors and span less than {_LONGEST:g} rise times"
            raise InvalidValueError.of("times", f"{rule} (got n = {knots[-1]:g})")
    if _impulse(knots, values) <= 0:
        raise InvalidValueError.of("forces", "must have an impulse > 0 N s (got a greater negative phase)")
    return Pulse(knots, values, peak_force, float(elapsed[peak]), tuple(notes), tuple(process.alarms))


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
    if faults:
        raise InvalidValueError(faults)


def _check_push(forces: FloatArray) -> None:
    if forces.max() <= 0:
        got = f"got at most {forces.max() + 0.0:g} N; if compression is negative, {CHANGE_SIGNS}"
        raise InvalidValueError.of("forces", f"must be > 0 N somewhere ({got})")


def _number_faults(name: str, unit: str, values: FloatArray) -> list[Fault]:
    """Errors for the ``values`` that are not finite numbers."""
    wrong = np.flatnonzero(~np.isfinite(values))[:_MOST_FAULTS]
    return [Fault(f"{name}[{at}]", f"must be a finite number of {unit} (got {values[at]:g})") for at in wrong.tolist()]


# ---------------------------------------------------------------- steps


def _apply_filter(process: _Process, low_pass: float) -> None:
    """Apply the low-pass filter, with a warning if it distorts the pulse.

    Raises
    ------
    InvalidValueError
        If it removes the pulse.
    """
    before, filtered = process.forces, _filtered(process.times, process.forces, low_pass)
    share = float(filtered.max() / before.max())
    if before.max() > 0 and share <= _REMOVED:
        got = f"got {low_pass:g} Hz, which leaves {filtered.max():.3g} of {before.max():.3g} N; set a higher frequency"
        raise InvalidValueError.of("low_pass", f"must keep the pulse ({got})")
    process.step(f"A low-pass filter at {low_pass:g} Hz was applied", filtered)
    if before.max() > 0 and abs(share - 1) > _DISTORTED:
        change = f"changes the peak force by {100 * (share - 1):+.2g} %"
        process.alarms.append(f"The low-pass filter {change}: it distorts the pulse (set a higher low_pass).")


def _filtered(times: FloatArray, forces: FloatArray, low_pass: float) -> FloatArray:
    """The forces after a Butterworth filter that is applied forwards and backwards, so that it shifts no phase."""
    from scipy import signal  # needed only here

    steps = np.diff(times)
    if not (forces.size >= _FEWEST_FILTERED and np.ptp(steps) <= _UNEVEN * steps.mean()):
        rule = f"must be left out for fewer than {_FEWEST_FILTERED} samples and for uneven sampling"
        got = f"got {forces.size} samples at intervals from {steps.min():.4g} to {steps.max():.4g} s"
        raise InvalidValueError.of("low_pass", f"{rule} ({got})")
    rate = float(1 / steps.mean())
    if not low_pass < rate / 2:
        got = f"got {low_pass:g} Hz; the record has {rate:.4g} samples a second"
        raise InvalidValueError.of("low_pass", f"must be below {rate / 2:.4g} Hz, half the sampling rate ({got})")
    sections = signal.butter(_ORDER, low_pass, fs=rate, output="sos")
    extension = min(forces.size - 1, int(np.ceil(_EXTENSION * rate / low_pass)))
    return np.asarray(signal.sosfiltfilt(sections, forces, padlen=extension), dtype=float)


def _resolve_negative(process: _Process, noise: float, clean: bool, negative: str | None) -> None:
    """Keep negative forces, or set them to zero.

    Raises
    ------
    InvalidValueError
        If it is not stated what to do with negative forces that are more than noise.
    """
    times, forces = process.times, process.forces
    below = np.minimum(forces, 0.0)
    if not below.any():
        return
    wrong = np.flatnonzero(below)[:_MOST_FAULTS].tolist()
    if not clean and negative is None:
        problem = "must be >= 0 N in a record that is not cleaned (got {:g} N; set negative: keep, or zero)"
        raise InvalidValueError([Fault(f"forces[{process.first + at}]", problem.format(forces[at])) for at in wrong])
    # Noise alone has negative samples, too: it cancels in the running impulse, and is small.
    running = np.cumsum(np.diff(times, prepend=times[0]) * forces)
    drop = float((np.maximum.accumulate(running) - running).max())
    lobes = -_impulse(times, np.where(forces < -_QUIET * noise, forces, 0.0))
    share = max(drop, lobes) / _impulse(times, np.maximum(forces, 0.0))
    if negative == "keep":
        process.notes.append(f"The negative forces were kept: their impulse is {100 * share:.2g} % of that above zero.")
        return
    if negative is None and share > _SMALL_PHASE:
        part = f"{100 * share:.2g} %" if share < 1 else "most"
        rule = f"must be keep or zero, because negative forces have {part} of the impulse"
        hints = f"keep simulates pulling forces; zero ignores them; if compression is negative, {CHANGE_SIGNS}"
        raise InvalidValueError.of("negative", f"{rule} (got nothing; {hints})")
    change = f"Negative samples were set to zero: {np.count_nonzero(below)} of {forces.size}"
    process.step(change, np.maximum(forces, 0.0))


def _cut_quiet_ends(process: _Process, noise: float) -> None:
    """Remove quiet samples before and after the pulse."""
    peak_force = float(process.forces.max())
    start, stop = _ends(np.abs(process.forces) / peak_force, noise / peak_force)
    for kept, count, where in (
        (slice(start, None), start, "before"),
        (slice(0, stop - start + 1), process.forces.size - 1 - stop, "after"),
    ):
        if count:
            process.step(f"Quiet samples {where} the pulse were removed: {count}", process.forces, kept)
    # Forces within the noise of the quiet lead are zero.
    process.forces = process.forces.copy()
    process.forces[[0, -1]] *= np.abs(process.forces[[0, -1]]) > _QUIET * noise


def _note_sum(process: _Process, times: FloatArray, forces: FloatArray) -> None:
    """Note the sum of all changes, from the record ``forces`` at ``times``."""
    before, highest = _impulse(times, forces), float(forces.max())
    impulse = _impulse(process.times, process.forces)
    changes = impulse / before - 1 if before > 0 else 1.0, float(process.forces.max()) / highest - 1
    if max(map(abs, changes)) > _NOTICEABLE:
        changed = f"the impulse by {100 * changes[0]:+.2g} % and the peak force by {100 * changes[1]:+.2g} %"
        process.notes.append(f"Together this changes {changed} (clean: false keeps the record as it is).")


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
