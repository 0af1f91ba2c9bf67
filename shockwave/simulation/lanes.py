"""The search for the primary in NumPy: the readable twin of the compiled code, step for step.

The last axis of every array is the lane: each shock has its own time, step and window. Local row j of a lane is granule
``base + j``; granules beyond the window are at rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from shockwave.quadrature import FloatArray
from shockwave.simulation.lane import ROWS, Force, Lane
from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.one_step import Attempt
from shockwave.simulation.peak import KEPT, STRIDE, crossing, hertz, limit
from shockwave.simulation.primary import AT_END, KNOWN, TOO_LONG, Passage, Primary, Request

__all__ = ["run"]

_WIDTH = 32
_AT_REST = 1e-16
_FLOOR = 1e-4  # weaker peaks are none
_SLIGHT = 1e-3  # nor is a contact looked at that is closed by less
_WEAK = 0.2  # nor does something behind the front count that is closed by less
_REACH = 8  # contacts from which a free end is felt
_RECENT = 6.0  # a wave passes from one contact to the next in less
_TREND = 4  # contacts over which its change is taken: a single one tells little more than noise
_SLACK = 0.1  # force of a contact that may be cut, over the primary
_TALLER = 0.999  # a wave of this share of the primary may be as tall as it
_FREE_FLIGHT = 2.4  # a granule in free flight at velocity v makes a wave of less than this times v^1.2
_WALL = 1e30  # a granule out of reach stands in for the free end


def run(requests: Sequence[Request], method: type[Nystroem]) -> list[Primary]:
    """The primary of each request, in their order."""
    return _March(requests, method()).run()


class _March:
    """All lanes, and the arrays of their state: positions, velocities, accelerations, shape (rows, lanes).

    ``late`` and ``since`` are force and time of the last peak at each contact that the front has left behind.
    """

    def __init__(self, requests: Sequence[Request], method: Nystroem) -> None:
        self.method = method
        self.waiting = [Lane(index, request) for index, request in enumerate(requests)]
        self.waiting.sort(key=lambda lane: lane.request.problem.duration)
        self.found: list[Primary | None] = [None] * len(requests)
        width = min(len(requests), _WIDTH)
        self.lanes: list[Lane | None] = [None] * width
        self.x, self.v, self.a, self.late, self.since = (np.zeros((2 * ROWS, width)) for _ in range(5))
        for lane in range(width):
            self._take_up(lane)

    def run(self) -> list[Primary]:
        with np.errstate(over="ignore", invalid="ignore"):
            while any(lane is not None for lane in self.lanes):
                self._turn()
        return [primary for primary in self.found if primary is not None]

    def _take_up(self, place: int) -> None:
        for array in (self.x, self.v, self.a, self.late, self.since):
            array[:, place] = 0.0
        self.lanes[place] = self.waiting.pop() if self.waiting else None
        self._wall(place)

    def _wall(self, place: int) -> None:
        lane = self.lanes[place]
        if lane is not None and lane.request.problem.granules is not None:
            self.x[lane.request.problem.granules - lane.base :, place] = _WALL

    def _make_room(self, rows: int) -> None:
        more = rows - len(self.x)
        if more > 0:
            for name in ("x", "v", "a", "late", "since"):
                array = getattr(self, name)
                setattr(self, name, np.concatenate((array, np.zeros((more, array.shape[1])))))
            for place in range(len(self.lanes)):
                self._wall(place)

    def _turn(self) -> None:
        """One attempt in every lane, and what follows from it."""
        lanes = self.lanes
        rows = max(lane.count for lane in lanes if lane is not None) + 1
        self._make_room(rows + ROWS)
        sizes = np.array([0.0 if lane is None else lane.next_size() for lane in lanes])
        times = np.array([0.0 if lane is None else lane.time for lane in lanes])
        sums = times + sizes
        at_stop = [lane is not None and size >= lane.until - lane.time for lane, size in zip(lanes, sizes, strict=True)]
        ends = [lane.until if lane and stop else end for lane, stop, end in zip(lanes, at_stop, sums, strict=True)]
        x, v, a = self.x[:rows], self.v[:rows], self.a[:rows]
        force = Force(lanes, rows, sums, ends)
        # one lane alone goes faster with plain numbers
        alone = len(lanes) == 1
        tried = self.method.attempt(
            force, float(times[0]) if alone else times, float(sizes[0]) if alone else sizes, x, v, a
        )
        errors = np.asarray(tried.error).tolist()
        for place, lane in enumerate(lanes):
            if lane is None:
                continue
            size, stops = float(sizes[place]), at_stop[place]
            end = float(ends[place])
            holds = lane.control(size, errors[place] / lane.request.tolerance, stops, self.method)
            if holds:
                free = lane.request.problem.free(end) if lane.driven else (0.0, 0.0)
                self._book_work(lane, place, size, free[0], force, a)
                self._observe(lane, place, size, free, tried)
                self._accept(lane, place, end, stops, free, tried)
            if lane.status:
                self.found[lane.index] = self._finish(lane, place)
                self._take_up(place)

    def _book_work(self, lane: Lane, place: int, size: float, path: float, force: Force, a: FloatArray) -> None:
        """Work of the force by parts, I u1 + I^2/2 less the integral of I times the first granule's acceleration.

        Of an impulse that is too rough for the stages, the exact integral is put in place of theirs, under the mean
        acceleration; ``path`` is that of the free granule at the end of the step.
        """
        if not lane.driven:
            return
        impulses = [lane.free[1], *(row[place] for row in force.impulses)]
        rates = [a[0, place], *(row[place] for row in force.first)]
        mean = summed = 0.0
        for weight, impulse, rate in zip(self.method.tableau.weights[1].tolist(), impulses, rates, strict=False):
            lane.work -= size * weight * impulse * rate
            mean += weight * rate
            summed += weight * impulse
        lane.work -= mean * ((path - lane.free[0]) - size * summed)

    def _observe(self, lane: Lane, place: int, size: float, free: tuple[float, float], tried: Attempt) -> None:
        """Contacts whose force has passed a maximum within the step."""
        v, v1 = self.v[: lane.count, place], tried.v[: lane.count, place]
        before, after = v[:-1] - v[1:], v1[:-1] - v1[1:]
        before[0] += lane.free[1]
        after[0] += free[1]
        for j in np.flatnonzero((before > 0) & (after <= 0)).tolist():
            closed = tried.x.item(j, place) - tried.x.item(j + 1, place)
            if j and closed <= _SLIGHT:
                continue
            if lane.base + j <= lane.head and closed + (0.0 if j else free[0]) < _WEAK:
                continue
            slopes = (size * (a.item(j, place) - a.item(j + 1, place)) for a in (self.a, tried.a))
            share, moved = crossing(before.item(j), after.item(j), *slopes)
            overlap = self.x.item(j, place) - self.x.item(j + 1, place) + (0.0 if j else lane.free[0])
            force = hertz(overlap + size * moved)
            if force >= _FLOOR:
                self._note(lane, place, j, size, share, force)

    def _note(self, lane: Lane, place: int, j: int, size: float, share: float, force: float) -> None:
        """A peak at local contact j: of the front, or of something behind it."""
        contact = lane.base + j
        if contact <= lane.head:
            self.late[j, place] = force
            self.since[j, place] = lane.time + share * size
            return
        lane.head = contact
        wanted, followed = contact in lane.request.contacts, (contact + 1) % STRIDE == 0
        if not (wanted or followed):
            return
        peak = self._read_peak(lane, place, j, size, share)
        if wanted:
            lane.passages.append(peak)
        if followed:
            lane.peaks.append(peak)
            self._judge(lane, place)

    def _read_peak(self, lane: Lane, place: int, j: int, size: float, share: float) -> Passage:
        """Step again, from the state before, to where the contact stops closing.

        A step moves nothing further than its stages, so a part of the window is enough.
        """
        stages = len(self.method.tableau.nodes) + 1
        first, last = max(j - stages, 0), j + stages + 2
        self._make_room(last)
        x, v, a = (array[first:last, place : place + 1].copy() for array in (self.x, self.v, self.a))
        at = j - first
        free = (0.0, 0.0)
        for _ in range(6):
            time = lane.time + share * size
            times, sizes = np.array([lane.time]), np.array([share * size])
            force = Force([lane if first == 0 else None], len(x), times + sizes, times + sizes)
            tried = self.method.attempt(force, times, sizes, x, v, a)
            lane.evaluations += self.method.tableau.evaluations
            if lane.driven and first == 0:
                free = lane.request.problem.free(time)
            positions, velocities = tried.x[:, 0], tried.v[:, 0]
            positions[0] += free[0]
            velocities[0] += free[1]
            overlaps = (positions[:-1] - positions[1:]).tolist()
            closing = float(velocities[at] - velocities[at + 1])
            slope = (hertz(overlaps[at - 1]) if at else 0.0) + hertz(overlaps[at + 1]) - 2 * hertz(overlaps[at])
            if lane.driven and j == 0:
                slope += _applied(lane, time, size)
            if not slope < 0:
                break
            left = -closing / slope
            if abs(left) < 1e-4:
                return Passage(lane.base + j, time + left, hertz(overlaps[at] + 0.5 * closing * left))
            share += left / size
            if not 0 < share < 1.5:
                break
        return Passage(lane.base + j, time, hertz(overlaps[at]))

    def _judge(self, lane: Lane, place: int) -> None:
        """Whether the peaks of the front have come to their limit."""
        if len(lane.peaks) < KEPT or lane.driven or lane.time < lane.request.known_from:
            return
        peak = lane.peaks[-1].force
        allowed = lane.request.doubt * peak
        value, doubt = limit([passage.force for passage in lane.peaks[-KEPT:]], allowed)
        if doubt <= allowed and not self._overtaken(lane, place):
            lane.status = KNOWN
            lane.limit = value, doubt / peak

    def _overtaken(self, lane: Lane, place: int) -> bool:
        """Whether something behind the front may outgrow it: a wave as tall, or a granule in free flight as fast."""
        front = lane.head - lane.base - 2
        if front <= 0 or not lane.peaks:
            return False
        bound = _TALLER * lane.peaks[-1].force
        late, since = self.late[:front, place], self.since[:front, place]
        # What a wave may grow to, from its change over the last contacts: one that shrinks gives to another.
        change, same = np.zeros(front), np.ones(front, dtype=bool)
        for back in range(1, min(_TREND, front - 1) + 1):
            same[back:] &= (since[:-back] < since[1 : front - back + 1]) & (late[:-back] > 0)
            same[:back] = False
            change[same] = np.abs(late[same] - late[np.flatnonzero(same) - back]) / back
        grown = late + np.minimum(lane.request.growing * change, late)
        if np.any((lane.time - since < _RECENT) & (grown > bound)):
            return True
        x, v = self.x[: front + 1, place], self.v[:front, place]
        closed = np.maximum(x[:-1] - x[1:], 0.0)
        if np.any(closed * np.sqrt(closed) > bound):
            return True
        flying = (closed == 0) & (np.append(0.0, closed[:-1]) == 0) & (v > 0)
        return bool(np.any(_FREE_FLIGHT * np.where(flying, v, 0.0) ** 1.2 > bound))

    def _accept(
        self, lane: Lane, place: int, end: float, at_stop: bool, free: tuple[float, float], tried: Attempt
    ) -> None:
        """Take the step over."""
        rows = len(tried.x)
        self.x[:rows, place], self.v[:rows, place], self.a[:rows, place] = (
            array[:, place] for array in (tried.x, tried.v, tried.a)
        )
        lane.time, lane.free = end, free
        lane.steps += 1
        if at_stop:
            lane.stop += 1
            if lane.until == math.inf:
                lane.driven = False
                lane.free_path, lane.impulse = free
                lane.work += free[1] * float(self.v[0, place]) + 0.5 * free[1] ** 2
                self.x[0, place] += free[0]
                self.v[0, place] += free[1]
                lane.free = (0.0, 0.0)
        self._grow(lane, place)
        if not lane.driven:
            self._cut(lane, place)
        if lane.status:
            return
        request = lane.request
        if request.problem.granules is not None and lane.head >= request.problem.granules - 1 - _REACH:
            lane.status = AT_END
        elif lane.head > request.most_contacts or lane.effort > request.most_work:
            lane.status = TOO_LONG

    def _grow(self, lane: Lane, place: int) -> None:
        row, granules = lane.count - 2, lane.request.problem.granules
        if max(abs(self.x[row, place]), abs(self.v[row, place])) > _AT_REST:
            lane.count += ROWS
            if granules is not None:
                lane.count = min(lane.count, granules - lane.base)

    def _cut(self, lane: Lane, place: int) -> None:
        """Drop granules far behind the front, and book what they hold.

        The cut runs through a contact that is all but open, for else what is cut off would have been felt, and is made
        only if nothing behind may outgrow the front.
        """
        most = lane.head - lane.base - lane.request.rear_of(lane.peaks[-1].force) if lane.peaks else 0
        if most < ROWS or self._overtaken(lane, place):
            return
        first = most - ROWS
        x = self.x[first : most + 1, place]
        closed = np.maximum(x[:-1] - x[1:], 0.0)
        forces = (closed * np.sqrt(closed))[::-1]
        weakest = int(np.argmin(forces))
        if not forces[weakest] < _SLACK * lane.peaks[-1].force:
            return
        rows = most - weakest
        lane.bank_momentum += math.fsum(self.v[:rows, place].tolist())
        lane.bank_energy += _energy(self.x[: rows + 1, place], self.v[:rows, place])
        for array in (self.x, self.v, self.a, self.late, self.since):
            array[:-rows, place] = array[rows:, place]
            array[lane.count - rows :, place] = 0.0
        self.a[0, place] = -hertz(float(self.x[0, place] - self.x[1, place]))  # it has lost its neighbour
        lane.base += rows
        lane.count -= rows
        self._wall(place)

    def _finish(self, lane: Lane, place: int) -> Primary:
        """The books, and the wave: from the foot behind the head on."""
        x, v = self.x[: lane.count + 1, place], self.v[: lane.count, place]
        closed = np.maximum(x[:-1] - x[1:], 0.0)
        forces = (closed * np.sqrt(closed)).tolist()
        foot = max(lane.head - lane.base, 0)
        while foot > 0 and forces[foot - 1] < forces[foot]:
            foot -= 1
        last = lane.peaks[-1] if lane.peaks else Passage(0, 0.0, 0.0)
        previous = lane.peaks[-2] if len(lane.peaks) > 1 else last
        if lane.status != KNOWN:
            lane.limit = last.force, 1.0
        return Primary(
            status=lane.status,
            peak=lane.limit[0],
            last=last.force,
            contact=last.contact,
            time=float(last.time),
            doubt=lane.limit[1],
            speed=STRIDE / float(last.time - previous.time) if last is not previous else 0.0,
            momentum=math.fsum(v[foot + 1 :].tolist()),
            energy=_energy(x[foot + 1 :], v[foot + 1 :]),
            foot=forces[foot],
            chain_momentum=lane.bank_momentum + math.fsum(v.tolist()),
            chain_energy=lane.bank_energy + _energy(x, v),
            work=float(lane.work),
            impulse=lane.impulse,
            free_path=lane.free_path,
            steps=lane.steps,
            evaluations=lane.evaluations,
            passages=tuple(lane.passages),
        )


def _applied(lane: Lane, time: float, size: float) -> float:
    """The applied force, from the impulse about ``time``, within the step of this size."""
    about, end = 1e-4 * size, lane.time + size
    before, after = max(time - about, lane.time), min(time + about, end)
    impulse = lane.request.problem.impulse
    return (impulse(after) - impulse(before)) / (after - before) if after > before else 0.0


def _energy(x: FloatArray, v: FloatArray) -> float:
    """Of granules with velocities v, and of the contact of each with the next; x has one more."""
    closed = np.maximum(x[:-1] - x[1:], 0.0)
    # summed without rounding, so that it does not matter how many lanes lie between two granules
    return math.fsum((0.5 * v * v + 0.4 * closed * closed * np.sqrt(closed)).tolist())
