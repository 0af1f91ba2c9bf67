"""Integration of long chains in parts, each with separate step sizes.

A step of a whole chain is limited by every contact that opens or closes anywhere. A disturbance takes time to pass from
granule to granule, so for a short span of time each part of the chain moves independently of what happens farther away:
the force where it is cut out of the chain can be kept constant. Granules that fly freely or are at rest need no
integration. `chain_backend` integrates the parts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from types import ModuleType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from shockwave.base.numerics import FloatArray
from shockwave.engine import chain_backend
from shockwave.engine.chain_arrays import LARGEST, UNSAMPLED, Job, Progress, Settings, Status
from shockwave.engine.chain_forces import FAR, Contacts
from shockwave.engine.time_limit import expired

# Least number of bodies of a chain that is integrated in parts; shorter ones take longer in parts than as a whole.
_LEAST_BODIES = 512
# Number of bodies of a part, and of those on both sides that are integrated with it.
_LENGTH = 192
_MARGIN = 24
# Effect on a part of a change of the force at the end of its margin, over the change and the tolerance.
_LEAK = 1e-3
# The greatest force may increase by this factor within a span: at a rigid wall by 2.24.
_RISE = 3.0
# A contact is quiet while its motion is slower than its fastest so far by the tolerance ...
_QUIET = 1.0
# ... and it oscillates by less than this angle within a span.
_ANGLE = 0.5
# Velocities and displacements below this are at rest.
_AT_REST = 1e-40
# First step of a part, over the span.
_FIRST = 0.125
# Shortest span, in characteristic times, in which a chain with damping is integrated in parts.
_SHORTEST = 1.0
_TINY = 1e-300


def run(job: Job, compiled: ModuleType | None) -> None:
    """Integrate to the end, in place."""
    whole = job.law is not None or job.bar or job.integrator is not None or not job.method.adaptive
    long = len(job.x) > _LEAST_BODIES and not whole
    parts = _Parts(Contacts(job), compiled) if long else None
    if parts and parts.viscous >= _SHORTEST:
        parts.run()
    else:
        chain_backend.run(job, compiled)


class _State(NamedTuple):
    """Forces minus static ones, changes of the overlaps, overlaps, closing velocities, and squared speeds of contacts.

    The speed of a contact includes the velocity that its energy can cause.
    """

    f: FloatArray
    stretch: FloatArray
    d: FloatArray
    w: FloatArray
    square: FloatArray


class _Parts:
    """A run in parts."""

    def __init__(self, contacts: Contacts, compiled: ModuleType | None) -> None:
        self.chain, self.job, self.compiled = contacts, contacts.job, compiled
        self.bodies, self.both = contacts.bodies, self.job.switches[0]
        self.sizes = np.full(self.bodies, math.inf)
        self.sizes[0] = contacts.first
        self.most = np.zeros(self.bodies)
        self.until, self.next_sample = contacts.until, 0
        self.rows = self.job.watched[UNSAMPLED:]
        if self.job.plastic.size:
            from shockwave.engine.chain_modes import Plasticity

            contacts.flow = Plasticity(contacts, self.job)
        self.viscous = self.spans_under(1.0)[1]

    @property
    def driven(self) -> bool:
        """Whether the applied force acts."""
        return self.job.problem is not None and self.job.progress.time < self.chain.duration

    def run(self) -> None:
        """Integrate to the end."""
        job, progress, status = self.job, self.job.progress, Status.RUNNING
        while status is Status.RUNNING and not expired():
            state = self.state()
            span = min(self.span(state), self.until - progress.time)
            live = self.live(state, span)
            if self.until == math.inf and not (live.any() or state.f.any() or (state.w > 0).any()):
                status = Status.DONE
            elif (reached := self.advance(state.f, live, span)) is not Status.DONE:
                status = reached
            elif progress.time >= self.until:
                status = Status.DONE
            elif progress.evaluations * self.bodies > job.settings.most_work:
                status = Status.TOO_LONG
            else:
                job.forecast.check(progress.time, progress.evaluations * self.bodies, progress.steps)
        progress.status, progress.size = status, 0.0

    def state(self) -> _State:
        """The state of all contacts."""
        chain, x, v = self.chain, self.job.x, self.job.v
        stretch = (x[:-1] - x[1:]) + chain.gap
        if chain.contacts < self.bodies:
            stretch[-1] = x[-2]  # the spring of the end
        d, w = stretch + chain.base, v[:-1] - v[1:]
        chain.on = d >= 0
        f = chain.forces(x, v, 0, self.bodies)[0]
        return _State(f, stretch, d, w, w * w + np.abs(f * stretch) * self.both)

    def span(self, state: _State) -> float:
        """Time in which a change does not pass the margin of a part."""
        chain, p = self.chain, self.chain.p
        stiff = self.stiffest(0.0) ** (1 / p)
        energies = np.where((state.d > 0) | (state.w > 0), stiff * state.square / self.both, 0.0)
        force = float((((p + 1) / 2 * energies) ** (p / (p + 1))).max()) + float(chain.static.max()) + chain.weight
        if self.driven:
            force = max(force, chain.settings.peak_force)
        return min(self.spans_under(max(_RISE * force, _TINY)))

    def stiffest(self, force: float) -> FloatArray:
        """Largest k of each contact at forces up to this one, or as now."""
        return self.chain.k if self.chain.flow is None else self.chain.flow.stiffest(force)

    def spans_under(self, force: float) -> tuple[float, float]:
        """Times in which a change does not pass the elastic contacts, and the dashpots, of a margin.

        A change passes M contacts of frequency o in the time t with the weight (o t)^(2M)/(2M)!, M dashpots of rate g
        with (g t)^M/M!. The ``force`` is the greatest one.
        """
        chain, p = self.chain, self.chain.p[:-1]
        stiff = self.stiffest(force)[:-1] ** (1 / p)
        mobile = np.sqrt(chain.inverse[:-1] * chain.inverse[1:])
        leak, share = math.log(_LEAK * chain.tolerance), 2.0 if chain.damped else 1.0
        reach = math.exp((math.lgamma(2 * _MARGIN + 1) + leak) / (2 * _MARGIN))
        elastic = reach / math.sqrt(share * _strongest(p * stiff * force ** (1 - 1 / p) * mobile))
        if not chain.damped:
            return elastic, math.inf
        reach = math.exp((math.lgamma(_MARGIN + 1) + leak) / _MARGIN)
        overlaps = force ** (1 / p) / np.maximum(stiff, _TINY)
        return elastic, reach / (share * _strongest(chain.c[:-1] * overlaps ** chain.q[:-1] * mobile))

    def live(self, state: _State, span: float) -> npt.NDArray[np.bool_]:
        """Whether each contact is integrated: it is not quiet, and closed or will be, or it has a static force."""
        chain = self.chain
        np.maximum(self.most, state.square, out=self.most)
        least = np.where(chain.base > 0, 0.0, (_QUIET * chain.tolerance) ** 2 * self.most)
        moves = state.square > np.maximum(least, _AT_REST**2)
        moves |= chain.p * np.abs(state.f) * self.both * span**2 > _ANGLE**2 * np.maximum(np.abs(state.d), _AT_REST)
        live = moves & ((chain.base > 0) | (state.d > 0) | (state.d + state.w * span > 0))
        live[0] |= self.driven or chain.weight > 0
        if chain.end_stiffness or chain.end_damping:
            live[-1] |= state.square[-1] > 0
        return np.asarray(live)

    def ranges(self, live: npt.NDArray[np.bool_]) -> Iterator[tuple[int, int, int, int]]:
        """Bodies of each part, without and with those on both sides."""
        at = np.flatnonzero(live)
        if not at.size:
            return
        breaks = np.flatnonzero(np.diff(at) > 2 * _MARGIN + 1)
        lows = np.append(at[:1], at[breaks + 1]) - _MARGIN
        highs = np.append(at[breaks], at[-1:]) + 2 + _MARGIN
        for low, high in zip(np.maximum(lows, 0).tolist(), np.minimum(highs, self.bodies).tolist(), strict=True):
            count = max((high - low - _MARGIN) // _LENGTH, 1)
            cuts = [low + (high - low) * i // count for i in range(count + 1)]
            for a, b in pairwise(cuts):
                yield a, b, max(a - _MARGIN, low), min(b + _MARGIN, high)

    def advance(self, f: FloatArray, live: npt.NDArray[np.bool_], span: float) -> Status:
        """Advance all bodies by ``span``; the status is DONE, or that of the part that does not reach the end."""
        chain, job, progress, end = self.chain, self.job, self.job.progress, self.job.progress.time + span
        end = self.until if end >= self.until else end
        times = job.times[self.next_sample :]
        times = times[times <= end]
        shown = job.samples[self.next_sample : self.next_sample + len(times)]
        x, v = self.fly(f, span, times, shown)
        impulses, sizes, ends = span * f, np.full(self.bodies, math.inf), list[int]()
        for a, b, low, high in self.ranges(live):
            first = max(low - 1, 0)
            part = self.part((first, low, high), (a, b), f, end, times)
            part.progress.size = min(float(self.sizes[a:b].min()), _FIRST * span)
            chain_backend.run(part, self.compiled)
            if part.progress.status != Status.DONE:
                return Status(int(part.progress.status))
            self.join(part, (first, low, high), (a, b), shown)
            mine, here, (left, right) = slice(a, b), slice(a - first, b - first), part.impulses[:UNSAMPLED].tolist()
            x[mine], v[mine], sizes[mine] = part.x[here], part.v[here], part.progress.size
            if low < a:  # the impulse at the contact with the part before is that of the latter
                v[a] += chain.inverse[a] * (impulses[a - 1] - left)
            if a == 0:
                impulses[0] = left
            impulses[part.watched[UNSAMPLED:] + first] = part.impulses[UNSAMPLED:]
            impulses[min(b, chain.contacts) - 1] = right
            ends += [high] * (b == high < self.bodies)
        x[-1] = v[-1] = 0.0
        job.x[:], job.v[:], self.sizes = x, v, sizes
        for high in ends:
            self.raise_scales(high - 1)
        job.impulses[:] += impulses[job.watched]
        progress.time, self.next_sample = end, self.next_sample + len(times)
        if progress.arrival >= 0 and self.until == math.inf:
            self.until = max(chain.duration + 3 * progress.arrival, end)
        return Status.DONE

    def fly(self, f: FloatArray, span: float, times: FloatArray, shown: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities after free flight, with small forces between quiet granules, and its samples."""
        chain, job = self.chain, self.job
        v = job.v.copy()
        v[:-1] += span * (chain.mobile[:-1] * (np.append(0.0, f[:-1]) - f))
        rows, passed, forces = self.rows, times[:, None] - job.progress.time, f + chain.static
        shown[:, 0] = job.x[rows] + passed * v[rows]
        shown[:, 1], shown[:, 2] = v[rows], forces[rows]
        shown[:, 3] = job.impulses[UNSAMPLED:] + passed * f[rows]
        if chain.flow is not None:
            shown[:, 4] = chain.flow.released_energies(chain.overlaps(job.x, 0, self.bodies)[1], forces)[rows]
        return job.x + span * v, v

    def join(self, part: Job, rows: tuple[int, int, int], body: tuple[int, int], shown: FloatArray) -> None:
        """Add the sums of a part, and take over what belongs to its contacts; see `part`."""
        (first, low, high), (a, b), job, progress = rows, body, self.job, self.job.progress
        progress.steps += part.progress.steps
        progress.evaluations += part.progress.evaluations * (high - low) / self.bodies
        progress.work += part.progress.work
        if first == 0:
            progress.rebound = part.progress.rebound
        if high == self.bodies:
            progress.arrival = max(progress.arrival, part.progress.arrival)
            progress.extremes = part.progress.extremes
        mine, here = slice(a, b), slice(a - first, b - first)
        job.losses[mine] += part.losses[here]
        job.peaks[:, mine] = part.peaks[:, here]
        kept = slice(a, b - (b == high < self.bodies))
        there = slice(kept.start - first, kept.stop - first)
        job.scales[:, kept] = part.scales[:, there]
        if self.chain.flow is not None:
            job.chain[1:5, kept], job.plastic[:, kept] = part.chain[1:5, there], part.plastic[:, there]
        columns = self.columns(a, b)
        part.samples[:, 3] += job.impulses[UNSAMPLED:][columns]
        shown[:, :, columns] = part.samples

    def raise_scales(self, contact: int) -> None:
        """Raise the scales of the errors to what is reached at the end of a range, and expected beyond it."""
        job, beyond = self.job, slice(contact, contact + 2 * _MARGIN)
        stretch = job.x[contact] - job.x[contact + 1] + self.chain.gap[contact]
        shares = job.chain[7:9, beyond].copy()
        shares[:, 0] = abs(job.v[contact] - job.v[contact + 1]), abs(stretch)
        np.maximum(job.scales[:, beyond], np.multiply.accumulate(shares, axis=1), out=job.scales[:, beyond])

    def columns(self, low: int, high: int) -> slice:
        """Columns of the samples of bodies low to high."""
        return slice(*np.searchsorted(self.rows, (low, high)).tolist())

    def part(
        self, rows: tuple[int, int, int], body: tuple[int, int], f: FloatArray, end: float, times: FloatArray
    ) -> Job:
        """The job of bodies low to high, between contacts of constant force, from the row of the first of these.

        The impulses are those at the contacts before and at the end of the bodies that count.
        """
        first, low, high = rows
        job, whole, driven = self.job, high == self.bodies, first == 0 and self.driven
        progress = Progress(time=job.progress.time, arrival=0.0, rebound=job.progress.rebound)
        if whole:
            progress.arrival, progress.extremes = job.progress.arrival, job.progress.extremes.copy()
        (a, b), contacts = body, self.chain.contacts
        watched = np.append([max(a - 1, first), min(b, contacts) - 1], self.rows[self.columns(a, b)])
        part = Job(
            method=job.method,
            problem=job.problem if driven else None,
            law=None,
            by_law=job.by_law[first:high],
            settings=self.settings_of(first, high, end),
            stops=job.stops[job.stops > progress.time] if driven else job.stops[:0],
            times=times,
            samples=np.zeros((len(times), job.samples.shape[1], len(watched) - UNSAMPLED)),
            watched=watched - first,
            impulses=np.zeros(len(watched)),
            progress=progress,
            table=job.table[:, first : high + 1].copy(),
            plastic=job.plastic[:, first : high + 1].copy(),
            curves=job.curves,
            window=high - first,
        )
        part.losses[:] = 0.0
        chain, scales = part.chain, part.scales
        if self.chain.flow is not None:
            part.plastic[:, [0] * (low > 0) + [-2] * (not whole)] = self.chain.flow.elastic[:, None]
        if not whole:
            chain[1:7, -1] = 0.0, -FAR, 0.0, 0.0, -f[high - 1], 0.0
            scales[:, -1] = LARGEST
        if low > 0:  # a body that does not move
            chain[:7, 0] = 0.0, 0.0, -FAR, 0.0, 0.0, -f[first], 0.0
            chain[7:, 1] = 0.0
            scales[:, 0] = LARGEST
        return part

    def settings_of(self, first: int, high: int, end: float) -> Settings:
        """Settings of the part with these rows; only the first has what acts on body 0, the last what is at the end."""
        settings, whole = self.job.settings, high == self.bodies
        return settings._replace(
            until=end,
            contacts=self.chain.contacts - first if whole else high - first,
            end_stiffness=settings.end_stiffness * whole,
            end_damping=settings.end_damping * whole,
            weight=settings.weight * (first == 0),
            guided=settings.guided and first == 0,
        )


def _strongest(rates: FloatArray) -> float:
    """Greatest geometric mean over the contacts of a margin."""
    sums = np.add.accumulate(np.append(0.0, np.log(np.maximum(rates, _TINY))))
    return math.exp(float(np.max(sums[_MARGIN:] - sums[:-_MARGIN])) / _MARGIN)
