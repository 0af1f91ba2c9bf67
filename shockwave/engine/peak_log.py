"""Log of the peaks of the contact forces, and the waves to which they belong."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from attrs import define, field
from numpy.polynomial.polynomial import polyder, polyval

from shockwave.base.numerics import FloatArray, product
from shockwave.engine.force_law import contact_force, power_force, stiffenings
from shockwave.engine.integrator import LONGEST_STEP
from shockwave.engine.stretch import Span, Stretch
from shockwave.scene.solitary_wave import HERTZ_WAVE, WaveLaw

# Noise floor of a chain at rest: weaker peaks, over the strongest so far, are ignored.
_FLOOR = 1e-4
# Relative error of a peak force from the polynomial between the ends of a step, over the eighth power of the step size
# in characteristic times of the wave.
_LOSS = 6e-5
# The polynomial is used if its error is below this fraction of the error tolerance of a step.
_NEGLIGIBLE = 0.1
# Largest number of Newton steps for the time of a peak.
_CORRECTIONS = 4
# Newton step in time below which the error of the force is a rounding error.
_NEAR = 1e-5
# Last secant in time of the search for a peak without derivatives: the error that remains is much smaller.
_AT_ONCE = 1e-7
# Largest number of secants.
_MOST_SECANTS = 60

# Fraction of its peak force that a wave keeps at least from one contact to the next few.
_SAME_WAVE = 0.5

# Longest time of a wave to the next contact, in its characteristic times: several times the usual one.
_PATIENCE = 6.0

#: Matrix from the value and the first three derivatives, each over its factorial, at 0 and at 1 to the powers 0 to 7.
POWERS = np.eye(8)
POWERS[4:] = [
    [-35, -20, -10, -4, 35, -15, 5, -1],
    [84, 45, 20, 6, -84, 39, -14, 3],
    [-70, -36, -15, -4, 70, -34, 13, -3],
    [20, 10, 4, 1, -20, 10, -4, 1],
]
_FACTORIALS = np.array([1.0, 1.0, 2.0, 6.0])


class Peak(NamedTuple):
    """A maximum in time of the force at a contact, counted from 0, and its row in the log.

    ``behind`` is the row of the peak of the same wave at the preceding contact, and ``previous`` that of the
    preceding peak at the same contact; -1 if there is none.
    """

    row: int
    contact: int
    behind: int
    previous: int
    time: float
    force: float


class Trail(NamedTuple):
    """Peaks of a wave, latest first: their rows in the log, times and forces."""

    rows: list[int]
    times: list[float]
    forces: list[float]


#: A row of `PeakLog.table`.
PEAK = np.dtype(list(zip(Peak._fields[1:], ("i8", "i8", "i8", "f8", "f8"), strict=True)))


@define(eq=False)
class PeakLog:
    """All maxima in time of the contact forces that are above the noise floor.

    ``tolerance`` is the error tolerance of a step, ``wave`` the solitary wave of the chain. Peaks are located on the
    integrator's interpolant if a polynomial between the ends of the step is less accurate than that; with 0 always. The
    first ``count`` rows of ``table`` are the peaks, and ``last`` the index of the last peak at each contact.
    ``removed`` are the contact ahead of which waves have been removed from the chain, the time, and the peak force of
    the strongest of them.
    """

    tolerance: float = 0.0
    wave: WaveLaw = HERTZ_WAVE
    strongest: float = 0.0
    removed: tuple[int, float, float] = (0, -math.inf, 0.0)
    count: int = 0
    table: np.ndarray = field(factory=lambda: np.zeros(0, PEAK))
    last: np.ndarray = field(factory=lambda: np.zeros(0, np.int64))
    _lists: tuple[list[int], list[float], list[float]] = field(factory=lambda: ([], [], []))

    def reserve(self, peaks: int, contacts: int) -> None:
        """Make room for so many more peaks, and for so many contacts."""
        if self.count + peaks > len(self.table):
            table = np.empty(2 * (self.count + peaks), PEAK)
            table[: self.count] = self.peaks
            self.table = table
        if contacts > len(self.last):
            self.last = np.concatenate((self.last, np.full(contacts, -1)))

    @property
    def peaks(self) -> np.ndarray:
        """Peaks in the order in which they were logged."""
        return self.table[: self.count]

    @property
    def front(self) -> int:
        """Foremost contact with a peak."""
        return int(self.peaks["contact"].max(initial=0))

    def at(self, contact: int) -> Iterator[Peak]:
        """Peaks at a contact, latest first."""
        index = self.last.item(contact) if contact < len(self.last) else -1
        while index >= 0:
            yield (peak := self.peak(index))
            index = peak.previous

    def nearest(self, contact: int, time: float) -> Peak | None:
        """Among the peaks at a contact, the one nearest to ``time``; None if there is none."""
        return min(self.at(contact), key=lambda peak: abs(peak.time - time), default=None)

    def next_time(self, peak: Peak) -> float:
        """Time of the next peak at the contact of ``peak``; infinite if there is none."""
        return next((later.time for later in self.at(peak.contact) if later.previous == peak.row), math.inf)

    def observe(self, stretch: Stretch) -> None:
        """Log the maxima within ``stretch``."""
        closing = stretch.v[:, :-1] - stretch.v[:, 1:]
        steps, contacts = np.nonzero((closing[:-1] > 0) & (closing[1:] <= 0))
        ends = np.array((steps, steps + 1))
        overlap = np.maximum(stretch.x[ends, contacts] - stretch.x[ends, contacts + 1], 0.0).max(axis=0)
        exponent = self.wave.exponent
        forces = power_force(overlap, exponent)
        strongest = np.maximum.accumulate(np.append(self.strongest, forces))
        self.strongest = float(strongest[-1])
        reached = forces > _FLOOR * strongest[1:]
        if not reached.any():
            return
        steps, contacts = steps[reached], contacts[reached]
        times, overlaps = _maxima(stretch, steps, contacts, exponent)
        self.reserve(len(times), stretch.x.shape[1])
        located = (steps.tolist(), contacts.tolist(), times.tolist(), overlaps.tolist())
        for step, contact, time, overlap in zip(*located, strict=True):
            span = stretch.spans[step]
            force = contact_force(overlap, exponent)
            loss = _LOSS * force * ((span.end - span.begin) / self.wave.time(force)) ** 8
            if contact == 0:  # the shock acts on one of its granules, which the polynomial does not include
                time, overlap = _locate_peak(span, contact)
            elif loss > _NEGLIGIBLE * self.tolerance:
                time, overlap = _correct(span, contact, time, exponent)
            self.add(contact, time, contact_force(overlap, exponent))

    def add(self, contact: int, time: float, force: float) -> None:
        """Log a maximum; it must be later than all previous ones at this contact."""
        self.reserve(1, contact + 1)
        behind = self.last.item(contact - 1) if contact else -1
        while behind >= 0 and not ((other := self.peak(behind)).force > _SAME_WAVE * force and other.time < time):
            behind = other.previous
        self.table[self.count] = (contact, behind, self.last[contact], time, force)
        self.last[contact] = self.count
        self.count += 1

    def peak(self, index: int) -> Peak:
        """Peak with this index."""
        return Peak(index, *self.table.item(index))

    def heads(self, now: float, share: float) -> list[Peak]:
        """Foremost peak of every travelling wave, front first, down to ``share`` of the strongest wave.

        A peak is a head if the next contact has not had a peak since then but may still have one.
        """
        contact, since, most = self.removed
        # the log is in the order of time but for the length of a step
        begin = bisect_left(self._copy_columns()[1], now - self._patience(_FLOOR * self.strongest) - LONGEST_STEP)
        peaks = self.table[begin : self.count]
        time, force, at = peaks["time"], peaks["force"], peaks["contact"]
        under_way = now - time < _PATIENCE * np.maximum(force, 1e-30) ** -self.wave.of_speed
        # Weaker peaks must not hide the wave that has just passed.
        strong = (force >= share * force[under_way].max(initial=most)).nonzero()[0]
        latest = np.empty(at.max(initial=-1) + 2, np.intp)
        latest.fill(len(time))
        latest[at[strong]] = strong
        padded = np.empty(len(time) + 1)
        padded[:-1], padded[-1] = time, -math.inf  # the latter where a contact has no peak yet
        passed = padded[latest]
        if since > -math.inf:
            ahead = passed[contact + 1 :]
            ahead[ahead <= since] = -math.inf
        head = latest[:-1][passed[:-1] > passed[1:]]
        return [self.peak(begin + index) for index in head[under_way[head]][::-1].tolist()]

    def top(self) -> Peak:
        """Strongest peak in the log."""
        return self.peak(int(self.peaks["force"].argmax()))

    def trail(self, head: Peak, contacts: int) -> Trail:
        """Peaks of the wave at ``head`` and at the preceding ``contacts``, as far as it can be traced back."""
        behind, times, forces = self._copy_columns()
        rows, row, time, patience = [head.row], head.behind, head.time, self._patience(_SAME_WAVE * head.force)
        for _ in range(contacts):
            if row < 0 or time - times[row] >= patience:
                break
            rows.append(row)
            row, time = behind[row], times[row]
        return Trail(rows, [times[row] for row in rows], [forces[row] for row in rows])

    def trace(self, waves: list[tuple[int, float]], since: float) -> list[Peak]:
        """Earliest peaks after ``since`` of the waves that have peaks at these contacts and times, or these peaks."""
        behind, times, _ = self._copy_columns()
        earliest = []
        for contact, time in waves:
            peak = self.nearest(contact, time)
            assert peak is not None
            row = peak.row
            while (before := behind[row]) >= 0 and times[before] >= since:
                row = before
            earliest.append(self.peak(row))
        return earliest

    def _patience(self, force: float) -> float:
        """Longest time of a wave of this peak force to the next contact."""
        return _PATIENCE * self.wave.time(force)

    def _copy_columns(self) -> tuple[list[int], list[float], list[float]]:
        """Columns ``behind``, ``time`` and ``force`` as lists, of which single elements are found faster."""
        behind, times, forces = self._lists
        if len(times) < self.count:
            new = self.table[len(times) : self.count]
            behind += new["behind"].tolist()
            times += new["time"].tolist()
            forces += new["force"].tolist()
        return behind, times, forces


def force_rates(overlap: FloatArray, closing: FloatArray, exponent: float) -> tuple[FloatArray, FloatArray]:
    """Contact forces d^p and their rates of change, from overlaps d and their rates of change ``closing``."""
    closed = np.maximum(overlap, 0.0)
    power = stiffenings(closed, exponent)
    return power * closed, exponent * power * closing


def hermite_data(begin: FloatArray, end: FloatArray, size: FloatArray) -> FloatArray:
    """Values and derivatives with respect to the fraction of a step at its two ends, over their factorials.

    `POWERS` converts them to the coefficients of the Hermite polynomial of degree 7.

    Parameters
    ----------
    begin, end : FloatArray
        Value and first three derivatives at the ends, shape (4, ...).
    size : FloatArray
        Step sizes; its shape is that of the values or of their leading dimensions.
    """
    scale = np.array([size**order / factorial for order, factorial in enumerate(_FACTORIALS)])
    scale = scale.reshape(*scale.shape, *(1,) * (begin.ndim - scale.ndim))
    return np.concatenate((begin * scale, end * scale))


def _maxima(
    stretch: Stretch, steps: np.ndarray, contacts: np.ndarray, exponent: float
) -> tuple[FloatArray, FloatArray]:
    """Times and values of the largest overlaps of these contacts in these steps, from the states at their ends."""
    # The granules of the contact and their neighbours; at an end of the chain a granule is repeated, without force.
    rows = np.array((steps, steps + 1))[..., None]
    columns = np.clip(contacts[:, None] + np.arange(-1, 3), 0, stretch.x.shape[1] - 1)
    overlap, closing = -np.diff(stretch.x[rows, columns]), -np.diff(stretch.v[rows, columns])
    changes = [np.diff(rate, 2)[..., 0] for rate in force_rates(overlap, closing, exponent)]
    jets = np.array((overlap[..., 1], closing[..., 1], *changes))
    size = np.diff(stretch.times)[steps]
    powers = product(POWERS, hermite_data(jets[:, 0], jets[:, 1], size))
    slopes = polyder(powers)
    bends = polyder(slopes)
    share = jets[1, 0] / (jets[1, 0] - jets[1, 1])
    for _ in range(_CORRECTIONS):
        bend = np.minimum(polyval(share, bends, tensor=False), -1e-300)
        with np.errstate(over="ignore"):  # for linear pieces, which have their maximum at an end
            share = np.clip(share - polyval(share, slopes, tensor=False) / bend, 0.0, 1.0)
    return stretch.times[steps] + share * size, polyval(share, powers, tensor=False)


def _correct(span: Span, contact: int, time: float, exponent: float) -> tuple[float, float]:
    """Time and value of the largest overlap near ``time``, by Newton's method on the integrator's interpolant."""
    first = contact - 1
    for _ in range(_CORRECTIONS):
        x, v = span.at(time)
        near = x[first : contact + 3].tolist()
        before, here, *after = (contact_force(a - b, exponent) for a, b in pairwise(near))
        slowing = (here - sum(after)) - (before - here)
        closing = float(v[contact] - v[contact + 1])
        end = min(max(time + closing / slowing, span.begin), span.end) if slowing > 0 else time
        shift = end - time
        if abs(shift) < _NEAR:
            break
        time = end
    return end, near[1] - near[2] + shift * (closing - shift * slowing / 2)


def _locate_peak(span: Span, contact: int) -> tuple[float, float]:
    """Time and value of the largest overlap, at which the two velocities are equal, by secants within a bracket."""
    before, time, x = span.begin, span.end, span.x1
    there, closing = (float(v[contact] - v[contact + 1]) for v in (span.v0, span.v1))
    begin, end = before, time
    for _ in range(_MOST_SECANTS):
        slope = (closing - there) / (time - before)
        following = time - closing / slope if slope < 0 else begin
        shift = (following if begin < following <= end else (begin + end) / 2) - time
        if abs(shift) < _AT_ONCE:
            break
        before, there, time = time, closing, time + shift
        x, v = span.at(time)
        closing = float(v[contact] - v[contact + 1])
        begin, end = (time, end) if closing > 0 else (begin, time)
    return time + shift, float(x[contact] - x[contact + 1]) + shift * closing / 2
