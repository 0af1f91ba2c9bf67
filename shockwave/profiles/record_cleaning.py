"""From a force record to a pulse: its samples are checked, baseline and quiet ends removed, and scaled."""

from __future__ import annotations

from typing import Any

import numpy as np
from attrs import frozen

from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import text_of
from shockwave.numerics import scatter
from shockwave.quadrature import FloatArray

# Share of the peak from which on a pulse has certainly begun.
_BEGUN = 0.05
# Share of the peak down to which it has certainly not ended.
_ENDED = 0.01
# A baseline is smaller, as a share of the peak.
_HIGHEST_BASELINE = 0.2
# The noise of a baseline is smaller, as such a share.
_WIDEST_NOISE = 0.02
# Scatter of a record, as such a share, that hides where a pulse begins.
_ROUGH = 0.01
# Samples that it takes to see the scatter.
_MANY = 50
_ROUNDING = 1e-12
# Standard deviations of the lead within which all is quiet.
_QUIET = 3
# Those beyond which it is certainly not. A long tail holds a chance sample beyond 3, but none beyond 5.
_CERTAIN = 5
_SHORTEST_LEAD = 5
# Rise times that a pulse lasts at most: the square of more is no number.
_LONGEST = 1e150
_MOST_FAULTS = 20


@frozen(eq=False)
class Pulse:
    """A pulse in units of its peak force [N] and rise time [s]: forces ``values`` at the times ``knots``."""

    knots: FloatArray
    values: FloatArray
    peak_force: float
    rise_time: float
    notes: tuple[str, ...]


def pulse_of(times: Any, forces: Any, ratio: float | None) -> Pulse:
    """The pulse of a record.

    Parameters
    ----------
    times, forces : array of float, shape (k,)
        Samples [s] and [N]; anything else is refused.
    ratio : float, optional
        Duration ratio to which the decay is stretched.

    Raises
    ------
    InvalidValueError
        When the samples are no pulse; each fault names its sample.
    """
    _check_samples(times, forces)
    values, peak_force, start, notes = _cleaned(times, forces)
    peak = int(np.argmax(values))
    if peak in (0, values.size - 1):
        part, where = ("rise", "before") if peak == 0 else ("decay", "after")
        problem = f"must not be the peak, for then there is no {part} (got {peak_force:g} N; "
        remedy = f"put a sample of zero force {where} it)"
        raise InvalidValueError.of(f"forces[{start + peak}]", problem + remedy)
    # Times of absurd size overflow.
    with np.errstate(over="ignore", invalid="ignore"):
        elapsed = times[start : start + values.size] - times[start]
        knots = elapsed / elapsed[peak]
        if ratio is not None and ratio != knots[-1]:
            notes.append(f"the decay was stretched in time: n is {ratio:g}, that of the record {knots[-1]:g}")
            knots[peak + 1 :] = 1.0 + (knots[peak + 1 :] - 1.0) * ((ratio - 1.0) / (knots[-1] - 1.0))
            knots[-1] = ratio
        if not (np.diff(knots) > 0).all() or not knots[-1] < _LONGEST:
            rule = f"must differ by more than rounding, and last less than {_LONGEST:g} rise times"
            raise InvalidValueError.of("times", f"{rule} (got n = {knots[-1]:g})")
    return Pulse(knots, values, peak_force, float(elapsed[peak]), tuple(notes))


def _check_samples(times: Any, forces: Any) -> None:
    faults = _number_faults("times", "s", times) + _number_faults("forces", "N", forces)
    if faults:
        raise InvalidValueError(faults[:_MOST_FAULTS])
    if forces.size != times.size:
        problem = f"must have one force for each time (got {forces.size} forces and {times.size} times)"
        faults.append(Fault("forces", problem))
    elif times.size < 3:
        faults.append(Fault("times", f"must have at least three samples, start, peak and end (got {times.size})"))
    for index in (np.flatnonzero(times[1:] <= times[:-1])[:_MOST_FAULTS] + 1).tolist():
        got = f"got {times[index]:g} s after {times[index - 1]:g} s; sort the samples, and drop repeated ones"
        faults.append(Fault(f"times[{index}]", f"must be greater than times[{index - 1}] ({got})"))
    if forces.size and forces.max() <= 0:
        got = f"got at most {forces.max():g} N; turn the sign, if pressure is negative"
        faults.append(Fault("forces", f"must be > 0 N somewhere ({got})"))
    if faults:
        raise InvalidValueError(faults)


def _number_faults(name: str, unit: str, values: Any) -> list[Fault]:
    """What in ``values`` is no finite number."""
    if not isinstance(values, np.ndarray) or values.ndim != 1:
        return [Fault(name, f"must be a sequence of numbers (got {text_of(values)})")]
    wrong = np.flatnonzero(~np.isfinite(values))[:_MOST_FAULTS]
    return [Fault(f"{name}[{at}]", f"must be a finite number {unit} (got {values[at]:g})") for at in wrong.tolist()]


def _cleaned(times: FloatArray, forces: FloatArray) -> tuple[FloatArray, float, int, list[str]]:
    """(force over peak force of the pulse alone, peak force [N], index of its first sample, notes)."""
    baseline, noise, count = _quiet_lead(forces)
    above = forces - baseline if baseline else forces
    peak_force = float(above.max())
    below = np.minimum(above, 0.0) / peak_force
    values = np.maximum(above, 0.0) / peak_force
    start, stop = _ends(values, noise / peak_force)
    pulse = values[start : stop + 1].copy()
    # What lies within the noise of a quiet lead is as good as zero.
    pulse[[0, -1]] *= pulse[[0, -1]] > _QUIET * noise / peak_force
    impulse = _impulse(times[start : stop + 1], pulse)

    def share(part: float) -> str:
        return f"({100 * abs(part) / impulse:.2g} % of the impulse)"

    notes = []
    if times[0] != 0:
        notes.append(f"the times start at {times[0]:g} s, and were shifted to start at zero")
    if baseline:
        what = f"a baseline of {baseline:.4g} N, the mean of the {count} samples before the pulse, was subtracted"
        notes.append(f"{what} {share(baseline / peak_force * (times[stop] - times[start]))}")
    number = int(np.count_nonzero(below))
    if number:
        were = "was" if number == 1 else "were"
        lost = share(_impulse(times, below))
        notes.append(f"{number} of {forces.size} samples lay below zero and {were} set to zero {lost}")
    for cut, where in ((slice(0, start + 1), "before"), (slice(stop, None), "after")):
        number = times[cut].size - 1
        if number:
            samples = "sample" if number == 1 else "samples"
            were = "was" if number == 1 else "were"
            lost = share(_impulse(times[cut], values[cut]))
            notes.append(f"{number} quiet {samples} {where} the pulse {were} cut off {lost}")
    for end, verb in ((0, "starts"), (-1, "ends")):
        if pulse[end] > _ROUNDING:
            size = f"{pulse[end] * peak_force:.4g} N, {100 * pulse[end]:.2g} % of its peak"
            notes.append(f"the record {verb} at {size}: the force jumps there")
    if not count and forces.size >= _MANY and (rough := scatter(forces) / peak_force) > _ROUGH:
        found = f"the record scatters by {rough:.1%} of its peak, and no quiet lead was found to take a baseline from"
        notes.append(f"{found}: rise time and duration may include what is not the pulse (cut the lead off, or smooth)")
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
            count = 3 * count // 4  # the beginning of a slow rise is no part of the lead
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


def _impulse(times: FloatArray, values: FloatArray) -> float:
    return float(np.sum(0.5 * np.diff(times) * (values[1:] + values[:-1])))
