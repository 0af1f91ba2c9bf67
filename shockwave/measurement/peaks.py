"""Peaks of the contact forces, logged contact by contact, and the waves that they belong to."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from attrs import define, field
from scipy.optimize import brentq

from shockwave.simulation.march import Span
from shockwave.simulation.problem import contact_forces

__all__ = ["Peak", "PeakLog", "natural_time"]

# Peaks weaker than this, over the strongest so far, are the noise floor of a chain at rest.
_FLOOR = 1e-4
# No more than so many peaks of one contact can be younger than the time that a wave takes to the next.
_RECENT = 8
# A wave that was followed keeps more than this share of its peak force from one contact to the next few.
_SAME_WAVE = 0.5


class Peak(NamedTuple):
    """A maximum in time of the force at a contact, counted from 0."""

    contact: int
    time: float
    force: float


@define
class PeakLog:
    """Every maximum in time of every contact force that matters, as the chain is stepped."""

    peaks: dict[int, list[Peak]] = field(factory=dict)
    strongest: float = 0.0

    def observe(self, span: Span) -> None:
        """Log the maxima that fall into ``span``."""
        forces = contact_forces(span.x1)
        self.strongest = max(self.strongest, float(forces.max()))
        closing_before = span.v0[:-1] - span.v0[1:]
        closing_after = span.v1[:-1] - span.v1[1:]
        reached = np.maximum(forces, contact_forces(span.x0)) > _FLOOR * self.strongest
        for contact in np.nonzero((closing_before > 0) & (closing_after <= 0) & reached)[0]:
            self._log(span, int(contact))

    def _log(self, span: Span, contact: int) -> None:
        def closing(time: float) -> float:
            _, v = span.at(time)
            return float(v[contact] - v[contact + 1])

        # Interpolation and step agree to rounding only; at an end their signs may differ.
        if closing(span.begin) * closing(span.end) < 0:
            time = brentq(closing, span.begin, span.end, xtol=1e-14, rtol=1e-14)
        else:
            time = span.end
        x, _ = span.at(time)
        overlap = max(float(x[contact] - x[contact + 1]), 0.0)
        self.peaks.setdefault(contact, []).append(Peak(contact, time, overlap**1.5))

    def heads(self, now: float, share: float) -> list[Peak]:
        """The foremost peak of every wave under way, front first, down to ``share`` of the strongest of them.

        A peak is a head when the next contact has not peaked since, and may still be expected to.
        """
        fresh = (
            peak.force
            for peaks in self.peaks.values()
            for peak in peaks[-_RECENT:]
            if now - peak.time < _patience(peak.force)
        )
        strongest = max(fresh, default=0.0)
        # Stirrings below the share must not hide the wave that has just gone by.
        latest = {contact: peak for contact, peaks in self.peaks.items() if (peak := _last(peaks, share * strongest))}
        return [
            latest[contact]
            for contact in sorted(latest, reverse=True)
            if (contact + 1 not in latest or latest[contact + 1].time < latest[contact].time)
            and now - latest[contact].time < _patience(latest[contact].force)
        ]

    def top(self) -> Peak:
        """The strongest peak of all."""
        return max((peak for peaks in self.peaks.values() for peak in peaks), key=lambda peak: peak.force)

    def history(self, head: Peak, contacts: int) -> list[Peak]:
        """Peaks of the wave at ``head`` and at the ``contacts`` behind it, as far as it can be followed."""
        trail = [head]
        for contact in range(head.contact - 1, max(head.contact - contacts, 0) - 1, -1):
            ahead = trail[-1]
            peaks = reversed(self.peaks.get(contact, []))
            same = (p for p in peaks if p.time < ahead.time and p.force > _SAME_WAVE * ahead.force)
            earlier = next(same, None)
            if earlier is None:
                break
            trail.append(earlier)
        return trail

    def arrival(self, head: Peak, contact: int) -> Peak | None:
        """The peak of the wave at ``head`` when it comes by ``contact``, or None before it does.

        It is followed from contact to contact: a wave just ahead may not have passed ``contact`` yet either.
        """
        for following in range(head.contact + 1, contact + 1):
            least = _SAME_WAVE * head.force
            later = (p for p in self.peaks.get(following, ()) if p.time > head.time and p.force > least)
            found = next(later, None)
            if found is None:
                return None
            head = found
        return head


def _last(peaks: list[Peak], least: float) -> Peak | None:
    return next((peak for peak in reversed(peaks) if peak.force >= least), None)


def natural_time(force: float) -> float:
    """Unit of time of a wave of this peak force: it passes 0.9 contacts in it."""
    return math.pow(max(force, 1e-30), -1 / 6)


def _patience(force: float) -> float:
    """How long a wave of this peak force may take to the next contact: several times what it needs."""
    return 6.0 * natural_time(force)
