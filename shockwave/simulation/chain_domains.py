"""Integration of long chains in parts, each with steps of its own.

One step for a whole chain would be limited by every contact that opens or closes anywhere. A disturbance takes time to
pass from granule to granule, so for a short time each part of the chain moves independently of what happens farther
away. Granules that fly freely or are at rest need no integration. `chain_march` integrates the parts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from types import ModuleType

import numpy as np
import numpy.typing as npt
from attrs import evolve

from shockwave.quadrature import FloatArray
from shockwave.simulation import chain_march
from shockwave.simulation.chain_contacts import FAR, Contacts
from shockwave.simulation.chain_job import SHARED, Job, Status
from shockwave.simulation.time_limit import expired

# Smallest number of bodies in parts.
_LEAST_BODIES = 256
# Number of bodies on both sides of a part that are integrated with it, and number of bodies of a part without them.
_MARGIN = 16
_LENGTH = 64
# Effect of a disturbance at the end of the margin on the part, over the tolerance.
_LEAK = 1e-3
# The force may rise by this factor during a step of all parts.
_RISE = 3.0
# A contact is quiet if its motion is slower than this, times the tolerance, over its fastest so far ...
_QUIET = 1.0
# ... and its oscillation slower than this angle during a step of all parts.
_ANGLE = 0.5
# Velocities and displacements below this count as rest.
_AT_REST = 1e-40


def run(job: Job, compiled: ModuleType | None) -> None:
    """Integrate to the end, in place, long conservative chains in parts."""
    contacts = Contacts(job)
    if contacts.damped or job.law is not None or contacts.bodies < _LEAST_BODIES:
        chain_march.run(job, compiled)
    else:
        _Parts(contacts, compiled).run()


class _Parts:
    """A run in parts."""

    def __init__(self, contacts: Contacts, compiled: ModuleType | None) -> None:
        self.own, self.job, self.compiled = contacts, contacts.job, compiled
        self.x, self.v = self.job.x, self.job.v
        self.bodies, self.both, p = contacts.bodies, self.job.switches[0], contacts.p
        self.free_wall = float(contacts.end_stiffness) == 0.0
        self.sizes = np.full(self.bodies, math.inf)
        self.sizes[0] = contacts.first
        self.most = np.zeros(self.bodies)
        self.time, self.arrival, self.until = 0.0, -1.0, contacts.until
        self.work = self.steps = self.effort = 0.0
        self.next_sample = 0
        with np.errstate(divide="ignore"):
            self.stiff = contacts.k ** (1 / p)
            # squared frequency at unit force: the geometric mean over the contacts of a margin
            rates = np.log(p * self.stiff[:-1] * np.sqrt(contacts.inverse[:-1] * contacts.inverse[1:]))
        sums = np.add.accumulate(np.append(0.0, rates))
        mean = float(np.exp(np.max(sums[_MARGIN:] - sums[:-_MARGIN]) / _MARGIN))
        leak = math.lgamma(2 * _MARGIN + 1) + math.log(_LEAK * contacts.tolerance)
        self.span = math.exp(leak / (2 * _MARGIN)) / math.sqrt(mean)

    def run(self) -> None:
        """Integrate to the end."""
        own, job = self.own, self.job
        status = Status.RUNNING
        while status is Status.RUNNING and not expired():
            x, v = self.x, self.v
            f = own.forces(x, v, 0, self.bodies)[0]
            stretch = (x[:-1] - x[1:]) + own.gap
            w, d = v[:-1] - v[1:], stretch + own.base
            speed = w * w + np.abs(f * stretch) * self.both
            closing = (d > 0) | (w > 0)
            end, strongest = self.next_end(np.where(closing, speed, 0.0), d, w)
            span = end - self.time
            live = self.live(f, stretch, d, w, speed, strongest, span)
            if self.until == math.inf and self.time >= own.duration and not live.any():
                if not f.any() and not (w > 0).any():
                    status = Status.DONE
                    break
            if not self.advance(f, live, end):
                status = Status.FAILED
            elif self.time >= self.until:
                status = Status.DONE
            elif self.effort > own.most_work:
                status = Status.TOO_LONG
        job.found[:] = status, self.time, self.arrival, self.work, self.steps, self.effort / self.bodies, 0.0

    def next_end(self, speed: FloatArray, d: FloatArray, w: FloatArray) -> tuple[float, float]:
        """End of the next step of all parts, and the strongest force until then."""
        own, p = self.own, self.own.p
        energy = float(np.max(self.stiff * speed / self.both)) * (p + 1) / 2
        force = energy ** (p / (p + 1)) + float(own.static.max())
        if self.time < own.duration and self.job.problem is not None:
            force = max(force, float(self.job.settings[6]))
        force *= _RISE
        span = self.span / force ** ((p - 1) / (2 * p)) if force > 0 else math.inf
        return min(self.time + span, self.until), force

    def live(self, f, stretch, d, w, speed, strongest, span):
        """Whether each contact needs integration."""
        own, p = self.own, self.own.p
        np.maximum(self.most, speed, out=self.most)
        least = (_QUIET * own.tolerance) ** 2 * self.most
        least = np.where(own.base > 0, 0.0, least)
        fast = p * np.abs(f) * self.both * span * span > _ANGLE**2 * np.abs(d)
        live = (speed > np.maximum(least, _AT_REST**2)) | (fast & (np.abs(stretch) > _AT_REST))
        live &= (d > 0) | (d + w * span > 0)
        if self.time < own.duration and self.job.problem is not None:
            live[0] = True
        if not self.free_wall:
            live[-1] |= bool(speed[-1] > 0)
        return live

    def pieces(self, live) -> Iterator[tuple[int, int, int, int]]:
        """Ranges of bodies, without and with their margins."""
        at = np.flatnonzero(live)
        if not at.size:
            return
        breaks = np.flatnonzero(np.diff(at) > 2 * _MARGIN + 1)
        lows = np.append(at[:1], at[breaks + 1]) - _MARGIN
        highs = np.append(at[breaks], at[-1:]) + 2 + _MARGIN
        for low, high in zip(np.maximum(lows, 0).tolist(), np.minimum(highs, self.bodies).tolist(), strict=True):
            count = max((high - low - _MARGIN) // _LENGTH, 1)
            cuts = [low + (high - low) * i // count for i in range(count + 1)]
            for a, b in zip(cuts[:-1], cuts[1:], strict=True):
                yield a, b, max(a - _MARGIN, low), min(b + _MARGIN, high)

    def advance(self, f, live, end) -> bool:
        """Advance all bodies to ``end``."""
        own, job = self.own, self.job
        span = end - self.time
        x, v, padded = self.x, self.v, np.concatenate(([0.0], f))
        new_v = v.copy()
        new_v[:-1] += span * (own.inverse * (padded[:-1] - padded[1:]))
        new_x = x + span * new_v
        new_x[-1], new_v[-1] = 0.0, 0.0
        impulses = span * f
        sizes = np.full(self.bodies, math.inf)
        due = job.times[self.next_sample :]
        due = due[due <= end]
        shown = job.samples[self.next_sample : self.next_sample + len(due)]
        if len(due):
            shown[:, 0] = x + (due - self.time)[:, None] * new_v
            shown[:, 1] = new_v
            shown[:, 2, :-1] = f + own.static
        last = -1
        for a, b, low, high in self.pieces(live):
            first = max(low - 1, 0)
            part = self.part(first, low, high, f, end, due, min(float(self.sizes[a:b].min()), span / 8))
            chain_march.run(part, self.compiled)
            status, _, arrival, work, steps, evaluations, size = part.found.tolist()
            if status != Status.DONE:
                return False
            self.steps += steps
            self.effort += evaluations * (high - low)
            self.work += work
            if high == self.bodies and self.arrival < 0 <= arrival:
                self.arrival = arrival
            mine, here = slice(a, b), slice(a - first, b - first)
            new_x[mine], new_v[mine] = part.x[here], part.v[here]
            if a == last and a > low:  # the impulse between two parts is that of the first
                new_v[a] += own.inverse[a] * (impulses[a - 1] - part.sums[0, a - first - 1])
            impulses[mine] = part.sums[0, here]
            job.peaks[:, mine] = part.peaks[:, here]
            kept = slice(a, b if high == self.bodies or b < high else b - 1)
            job.scales[:, kept] = part.scales[:, kept.start - first : kept.stop - first]
            sizes[mine] = size
            last = b
            if len(due):
                shown[:, :, mine] = part.samples[:, :, here]
        self.x[:], self.v[:], self.sizes = new_x, new_v, sizes
        job.sums[0] += impulses
        self.time = end
        self.next_sample += len(due)
        if self.arrival >= 0 and self.until == math.inf:
            self.until = max(own.duration + 3 * self.arrival, end)
        return True

    def part(self, first, low, high, f, end, due, size) -> Job:
        """The job of bodies low to high; the forces at its ends are constant."""
        job, own = self.job, self.own
        width = high - first + 2
        table = np.zeros((len(job.table), width))
        table[:SHARED] = job.table[:SHARED, first : high + 2]
        whole = high == self.bodies
        driven = first == 0 and self.time < own.duration and job.problem is not None
        settings = job.settings.copy()
        settings[3] = end
        settings[9] = own.contacts - first if whole else high - first
        if not whole:
            settings[10] = 0.0
        part = evolve(
            job,
            problem=job.problem if driven else None,
            settings=settings,
            stops=job.stops[job.stops > self.time] if driven else job.stops[:0],
            times=due,
            samples=np.zeros((len(due), 3, width - 1)),
            found=np.array([0.0, self.time, self.arrival if whole else 0.0, 0.0, 0.0, 0.0, size]),
            table=table,
            window=width,
        )
        part.sums[:] = 0.0
        held = [0] * (low > 0) + [high - first - 1] * (not whole)
        for j in held:
            part.chain[1:7, j] = 0.0, -FAR, 0.0, 0.0, -f[first + j], 0.0
            part.scales[:, j] = math.inf
        if low > 0:
            part.chain[0, 0] = 0.0
            part.chain[7:9, 1] = 0.0
            part.scales[:, 0] = 1e300
        return part
