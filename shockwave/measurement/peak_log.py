"""Log of the peaks of the contact forces, and the waves to which they belong."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise, takewhile

import numpy as np
from attrs import define, field, frozen
from numpy.polynomial.polynomial import polyder, polyval
from scipy.optimize import brentq

from shockwave.numerics import product
from shockwave.quadrature import FloatArray
from shockwave.simulation.march import Span, Stretch

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
# Fraction of its peak force that a wave keeps at least from one contact to the next few.
_SAME_WAVE = 0.5

# Matrix from the value and the first three derivatives, each over its factorial, at 0 and at 1 to the powers 0 to 7.
_POWERS = np.eye(8)
_POWERS[4:] = [
    [-35, -20, -10, -4, 35, -15, 5, -1],
    [84, 45, 20, 6, -84, 39, -14, 3],
    [-70, -36, -15, -4, 70, -34, 13, -3],
    [20, 10, 4, 1, -20, 10, -4, 1],
]
_FACTORIALS = np.array([1.0, 1.0, 2.0, 6.0])


@frozen(eq=False)
class Peak:
    """A maximum in time of the force at a contact, counted from 0.

    ``behind`` is the peak of the same wave at the preceding contact, or None if the wave cannot be traced back.
    """

    contact: int
    time: float
    force: float
    behind: Peak | None = field(default=None, repr=False)


@define
class PeakLog:
    """All maxima in time of the contact forces that are above the noise floor.

    ``tolerance`` is the error tolerance of a step. Peaks are located on the integrator's interpolant if a polynomial
    between the ends of the step is less accurate than that; with 0 always.
    """

    tolerance: float = 0.0
    peaks: dict[int, list[Peak]] = field(factory=dict)
    strongest: float = 0.0

    def observe(self, stretch: Stretch) -> None:
        """Log the maxima within ``stretch``."""
        closing = stretch.v[:, :-1] - stretch.v[:, 1:]
        steps, contacts = np.nonzero((closing[:-1] > 0) & (closing[1:] <= 0))
        ends = np.array((steps, steps + 1))
        overlap = np.maximum(stretch.x[ends, contacts] - stretch.x[ends, contacts + 1], 0.0).max(axis=0)
        forces = overlap * np.sqrt(overlap)
        self.strongest = max(self.strongest, float(forces.max(initial=0.0)))
        reached = forces > _FLOOR * self.strongest
        if not reached.any():
            return
        steps, contacts = steps[reached], contacts[reached]
        times, overlaps = _maxima(stretch, steps, contacts)
        # In the order of time, so that the preceding peak of each wave is already in the log.
        for index in np.argsort(times, kind="stable").tolist():
            contact, time, overlap = int(contacts[index]), float(times[index]), float(overlaps[index])
            span = stretch.spans[steps[index]]
            force = max(overlap, 0.0) ** 1.5
            loss = _LOSS * force * ((span.end - span.begin) / characteristic_time(force)) ** 8
            if contact == 0:  # the shock acts on one of its granules, which the polynomial does not include
                time, overlap = _sought(span, contact)
            elif loss > _NEGLIGIBLE * self.tolerance:
                time, overlap = _corrected(span, contact, time)
            self.add(contact, time, max(overlap, 0.0) ** 1.5)

    def add(self, contact: int, time: float, force: float) -> None:
        """Log a maximum; it must be later than all previous ones at this contact."""
        earlier = reversed(self.peaks.get(contact - 1, ()))
        behind = next((p for p in earlier if p.force > _SAME_WAVE * force and p.time < time), None)
        self.peaks.setdefault(contact, []).append(Peak(contact, time, force, behind))

    def heads(self, now: float, share: float) -> list[Peak]:
        """Foremost peak of every travelling wave, front first, down to ``share`` of the strongest wave.

        A peak is a head if the next contact has not had a peak since then but may still have one.
        """
        oldest = now - _patience(_FLOOR * self.strongest)
        under_way = (peak.force for peak in self._since(oldest) if now - peak.time < _patience(peak.force))
        strongest = max(under_way, default=0.0)
        # Weaker peaks must not hide the wave that has just passed.
        found = []
        passed = -math.inf
        for contact in range(max(self.peaks, default=-1), -1, -1):
            earlier = reversed(self.peaks.get(contact, []))
            last = next((peak for peak in earlier if peak.force >= share * strongest), None)
            if last is not None and last.time > passed and now - last.time < _patience(last.force):
                found.append(last)
            passed = -math.inf if last is None else last.time
        return found

    def _since(self, oldest: float) -> Iterator[Peak]:
        for peaks in self.peaks.values():
            yield from takewhile(lambda peak: peak.time >= oldest, reversed(peaks))

    def top(self) -> Peak:
        """Strongest peak in the log."""
        return max((peak for peaks in self.peaks.values() for peak in peaks), key=lambda peak: peak.force)

    def arrival(self, head: Peak, contact: int) -> Peak | None:
        """Peak of the wave at ``head`` when it arrives at ``contact``, or None if it has not arrived yet.

        The wave is followed from contact to contact, because a wave ahead may not have passed ``contact`` either.
        """
        found: Peak | None = head
        while found is not None and found.contact < contact:
            here, least = found, _SAME_WAVE * found.force
            following = self.peaks.get(here.contact + 1, ())
            found = next((peak for peak in following if peak.time > here.time and peak.force > least), None)
        return found


def history(head: Peak, contacts: int) -> list[Peak]:
    """Peaks of the wave at ``head`` and at the preceding ``contacts``, as far as it can be traced back."""
    trail = [head]
    while len(trail) <= contacts and (behind := trail[-1].behind) is not None:
        trail.append(behind)
    return trail


def force_rates(overlap: FloatArray, closing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Contact forces d^(3/2) and their rates of change, from overlaps d and their rates of change ``closing``."""
    root = np.sqrt(np.maximum(overlap, 0.0))
    return root**3, 1.5 * root * closing


def powers_between(begin: FloatArray, end: FloatArray, size: FloatArray) -> FloatArray:
    """Hermite polynomials of degree 7 between the ends of steps, in powers of the fraction of the step.

    Parameters
    ----------
    begin, end : FloatArray
        Value and first three derivatives at the ends, shape (4, ...).
    size : FloatArray
        Step sizes; its shape is that of the values or of their leading dimensions.

    Returns
    -------
    FloatArray
        Coefficients, lowest first, shape (8, ...).
    """
    scale = np.array([size**order / factorial for order, factorial in enumerate(_FACTORIALS)])
    scale = scale.reshape(*scale.shape, *(1,) * (begin.ndim - scale.ndim))
    known = np.concatenate((begin * scale, end * scale))
    return product(_POWERS, known.reshape(8, -1)).reshape(known.shape)


def _maxima(stretch: Stretch, steps: np.ndarray, contacts: np.ndarray) -> tuple[FloatArray, FloatArray]:
    """Times and values of the largest overlaps of these contacts in these steps, from the states at their ends."""
    # The granules of the contact and their neighbours; at an end of the chain a granule is repeated, without force.
    rows = np.array((steps, steps + 1))[..., None]
    columns = np.clip(contacts[:, None] + np.arange(-1, 3), 0, stretch.x.shape[1] - 1)
    overlap, closing = -np.diff(stretch.x[rows, columns]), -np.diff(stretch.v[rows, columns])
    changes = [rate[..., 0] - 2 * rate[..., 1] + rate[..., 2] for rate in force_rates(overlap, closing)]
    jets = np.array((overlap[..., 1], closing[..., 1], *changes))
    size = np.diff(stretch.times)[steps]
    powers = powers_between(jets[:, 0], jets[:, 1], size)
    slopes = polyder(powers)
    bends = polyder(slopes)
    share = jets[1, 0] / (jets[1, 0] - jets[1, 1])
    for _ in range(_CORRECTIONS):
        bend = np.minimum(polyval(share, bends, tensor=False), -1e-300)
        with np.errstate(over="ignore"):  # for linear pieces, which have their maximum at an end
            share = np.clip(share - polyval(share, slopes, tensor=False) / bend, 0.0, 1.0)
    return stretch.times[steps] + share * size, polyval(share, powers, tensor=False)


def _corrected(span: Span, contact: int, time: float) -> tuple[float, float]:
    """Time and value of the largest overlap near ``time``, by Newton's method on the integrator's interpolant."""
    first = contact - 1
    for _ in range(_CORRECTIONS):
        x, v = span.at(time)
        near = x[first : contact + 3].tolist()
        before, here, *after = (max(a - b, 0.0) ** 1.5 for a, b in pairwise(near))
        slowing = 2 * here - before - sum(after)
        closing = float(v[contact] - v[contact + 1])
        end = min(max(time + closing / slowing, span.begin), span.end) if slowing > 0 else time
        shift = end - time
        if abs(shift) < _NEAR:
            break
        time = end
    return end, near[1] - near[2] + shift * (closing - shift * slowing / 2)


def _sought(span: Span, contact: int) -> tuple[float, float]:
    """Time and value of the largest overlap, at which the two velocities are equal."""

    def closing(time: float) -> float:
        _, v = span.at(time)
        return float(v[contact] - v[contact + 1])

    # Interpolant and step agree up to rounding errors; at an end their signs can differ.
    differ = closing(span.begin) * closing(span.end) < 0
    time = brentq(closing, span.begin, span.end, xtol=1e-14, rtol=1e-14) if differ else span.end
    x, _ = span.at(time)
    return time, float(x[contact] - x[contact + 1])


def characteristic_time(force: float) -> float:
    """Characteristic time of a wave of this peak force, in which it passes 0.9 contacts."""
    return math.pow(max(force, 1e-30), -1 / 6)


def _patience(force: float) -> float:
    """Longest time of a wave of this peak force to the next contact: several times the usual one."""
    return 6.0 * characteristic_time(force)
