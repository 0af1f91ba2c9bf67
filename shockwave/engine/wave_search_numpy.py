"""Search for the leading wave in NumPy, with the same algorithm as the compiled code; all in scaled units."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.base.progress import report_progress
from shockwave.engine.force_law import contact_force, power_force
from shockwave.engine.nystroem_integrators import Nystroem, kink
from shockwave.engine.one_step import Attempt
from shockwave.engine.peak_limit import KEPT, NOISE, STRIDE, find_crossing, growth_since, limit, window_energy
from shockwave.engine.scaled_problem import WindowAcceleration, contact_forces
from shockwave.engine.search_request import FORMING, Passage, Primary, SearchRequest, SearchStatus
from shockwave.engine.time_limit import expired

# First number of granules in the window, and by how many it grows.
_ROWS = 8
_FIRST_STEP = 0.05
_LONGEST_STEP = 1.0
# Safety factor and limits of the ratio of consecutive step sizes.
_SAFETY = 0.9
_MIN_FACTOR = 0.2
_MAX_FACTOR = 3.0
# Largest displacement and velocity of a granule at rest.
_AT_REST = 1e-16
# Smallest peak force and smallest overlap of a peak.
_FLOOR = 1e-4
_SLIGHT = 1e-3
# Smallest overlap of a peak behind the front.
_WEAK = 0.2
# Number of contacts at the free end that it affects.
_REACH = 8
# Largest force of a contact at which the window may be cut, over the peak force of the front.
_SLACK = 0.1
# Fraction of the peak force of the front above which a wave may be as strong.
_TALLER = 0.999
# Error of the leading wave, over the amount by which another wave exceeds it.
_RIVAL = 2.0
# Position of the granule beyond a free end, out of reach of all others.
_FAR = 1e30


def search(request: SearchRequest, method: Nystroem) -> Primary:
    """Find the leading wave of one shock."""
    window = _Window(request, method)
    with np.errstate(over="ignore", invalid="ignore"):
        while window.status is SearchStatus.RUNNING and not expired():
            window.step()
            if not window.steps % 64:  # rarely enough to cost nothing
                report_progress("leading wave", window.steps)
    report_progress("leading wave", window.steps, window.steps)
    return window.primary()


class _Window:
    """The granules near the front; local row j is granule ``base + j``.

    ``x``, ``v``, ``a`` are positions, velocities and accelerations of the granules and of the next one, which is at
    rest; ``late`` and ``since`` are force and time of the last peak at each contact behind the front. While the force
    acts, ``free`` are displacement and impulse of a free granule, which are added to those of the first granule.
    """

    def __init__(self, request: SearchRequest, method: Nystroem) -> None:
        self.request = request
        self.problem = request.problem
        self.method = method
        self.exponent = request.problem.exponent
        self._force = partial(contact_force, exponent=self.exponent)
        self.stops = [*request.problem.stops, math.inf]
        self.base = 0
        self.head = self.tried = -1
        self._set(np.zeros((5, 1)))
        self._extend(_ROWS)
        self.status = SearchStatus.RUNNING
        self.driven = True
        self.rejected = False
        self.time = 0.0
        self.size = _FIRST_STEP
        self.free = (0.0, 0.0)
        self.applied = (0.0, 0.0)
        self.work = 0.0
        self.removed_momentum = 0.0
        self.removed_energy = 0.0
        self.steps = 0
        self.effort = 0
        self.evaluations = 0
        self.peaks: list[Passage] = []
        self.passages: list[Passage] = []
        self.limit = (0.0, 1.0)

    def _extend(self, rows: int) -> None:
        granules = self.problem.granules or math.inf
        rows = int(min(rows, granules - self.base - len(self.x) + 1))
        self._set([np.append(array, np.zeros(rows)) for array in self._arrays()])
        if self.base + len(self.x) - 1 == granules:
            self.x[-1] = _FAR

    def _arrays(self) -> tuple[FloatArray, ...]:
        return self.x, self.v, self.a, self.late, self.since

    def _set(self, arrays: Iterable[FloatArray]) -> None:
        self.x, self.v, self.a, self.late, self.since = arrays

    # ---------------------------------------------------------------- steps

    def step(self) -> None:
        """Attempt a step and process it."""
        left = self.stops[0] - self.time
        # avoids a very short last step before the next stop
        size = left if self.size >= left else min(self.size, left / 2)
        at_stop = size >= left
        end = self.stops[0] if at_stop else self.time + size
        force = WindowAcceleration(self.problem.free if self.driven else None, self.exponent, self.time + size, end)
        tried = self.method.attempt(force, self.time, size, self.x, self.v, self.a)
        free = self.problem.free(end) if self.driven else (0.0, 0.0)
        # only while the force acts: nothing catches up with a wave from the contacts that open behind it
        paths = self.free[0], free[0]
        jolt = kink(self.x[:-1], tried.x[:-1], paths, size, self.exponent) if self.driven else 0.0
        if not self._control(size, float(tried.error) / self.request.tolerance, jolt / self.request.tolerance, at_stop):
            return
        if self.driven:
            self._add_work(size, free[0], force)
        self._find_peaks(size, free, tried)
        self._accept(end, at_stop, free, tried)

    def _control(self, size: float, error: float, jolt: float, at_stop: bool) -> bool:
        """Choose the next step size from both errors, in units of the tolerance; whether the step is accepted."""
        tableau = self.method.tableau
        self.effort += (len(self.x) - 1) * len(tableau.nodes)
        self.evaluations += tableau.evaluations
        factor = _SAFETY * max(error, 1e-12) ** (-1 / (self.method.error_order + 1)) if error == error else 0.0
        if error <= 1 < jolt:
            # both velocity and length of the step make the change of the overlap
            self.size = size * (jolt ** (-1 / (self.exponent + 1)) if jolt < 300 else 0.1)
            self.rejected = True
            return False
        if not error <= 1:
            self.size = size * (factor if _MIN_FACTOR < factor < 1 else _MIN_FACTOR)
            self.rejected = True
            if self.effort > self.request.limits.max_work:
                self.status = SearchStatus.TOO_LONG
            if self.size < 1e-14 * (1 + self.time):
                self.status = SearchStatus.FAILED
            return False
        factor = min(factor, 1.0 if self.rejected else _MAX_FACTOR)
        self.rejected = False
        if not (at_stop and size * factor < self.size):
            self.size = min(size * factor, _LONGEST_STEP)
        return True

    def _add_work(self, size: float, path: float, force: WindowAcceleration) -> None:
        """Add the work of the force, integrated by parts: I u1 + I^2/2 minus the integral of I a1.

        I is the impulse, u1 and a1 are velocity and acceleration of the first granule. With the mean acceleration, the
        quadrature of I over the stages is replaced by its exact integral; ``path`` is that at the end of the step.
        """
        impulses = [self.free[1], *force.impulses]
        rates = [self.a.item(0), *force.first]
        mean = summed = 0.0
        for weight, impulse, rate in zip(self.method.tableau.weights[1].tolist(), impulses, rates, strict=False):
            self.work -= size * weight * impulse * rate
            mean += weight * rate
            summed += weight * impulse
        self.work -= mean * ((path - self.free[0]) - size * summed)

    def _accept(self, end: float, at_stop: bool, free: tuple[float, float], tried: Attempt) -> None:
        self.x, self.v, self.a = tried.x, tried.v, tried.a
        self.time, self.free = end, free
        self.steps += 1
        if at_stop:
            del self.stops[0]
            if self.stops[0] == math.inf:
                self._release()
        if max(abs(self.x.item(-3)), abs(self.v.item(-3))) > _AT_REST:
            self._extend(_ROWS)
        if not self.driven:
            self._cut()
        if self.status != SearchStatus.RUNNING:
            return
        if self.head >= (self.problem.granules or math.inf) - 1 - _REACH:
            self.status = SearchStatus.AT_END
        elif self.head > self.request.limits.max_contacts or self.effort > self.request.limits.max_work:
            self.status = SearchStatus.TOO_LONG

    def _release(self) -> None:
        """Integrate the true position of the first granule from now on: the force has ended."""
        path, impulse = self.applied = self.free
        self.driven = False
        self.work += impulse * self.v.item(0) + 0.5 * impulse**2
        self.x[0] += path
        self.v[0] += impulse
        self.free = (0.0, 0.0)

    def _cut(self) -> None:
        """Remove granules far behind the front, and add up their momentum and energy; once for each contact it passes.

        The chain is cut at a contact with almost no force, so that the removed granules have no influence, and only if
        no wave behind the front can become stronger than it.
        """
        most = self.head - self.base - self.request.rear_of(self.peaks[-1].force) if self.peaks else 0
        if most < _ROWS or self.tried == self.head or self.time < self.problem.duration + FORMING:
            return
        self.tried = self.head
        forces = contact_forces(self.x[most - _ROWS : most + 1], self.exponent)[::-1]
        weakest = int(np.argmin(forces))
        if not forces[weakest] < _SLACK * self.peaks[-1].force or self._strongest_behind() > _TALLER:
            return
        rows = most - weakest
        self.removed_momentum += math.fsum(self.v[:rows].tolist())
        self.removed_energy += window_energy(self.x[: rows + 1], self.v[:rows], self.exponent)
        self._set([array[rows:].copy() for array in self._arrays()])
        self.a[0] = -self._force(self.x.item(0) - self.x.item(1))  # no neighbour behind
        self.base += rows

    # ---------------------------------------------------------------- peaks

    def _find_peaks(self, size: float, free: tuple[float, float], tried: Attempt) -> None:
        """Find contacts whose force has a maximum within the step."""
        before, after = self.v[:-2] - self.v[1:-1], tried.v[:-2] - tried.v[1:-1]
        before[0] += self.free[1]
        after[0] += free[1]
        at = ((before > 0) & (after <= 0)).nonzero()[0]
        if not at.size:
            return
        closed, opened = tried.x[at] - tried.x[at + 1], self.x[at] - self.x[at + 1]
        if at[0] == 0:
            closed[0] += free[0]
            opened[0] += self.free[0]
        ahead = at > self.head - self.base
        strong = ((closed >= _WEAK) | (ahead & ((closed > _SLIGHT) | (at == 0)))).nonzero()[0]
        if not strong.size:
            return
        at = at[strong]
        rates = before[at], after[at], *(size * (a[at] - a[at + 1]) for a in (self.a, tried.a))
        shares, moved = find_crossing(*rates)
        forces = power_force(np.maximum(opened[strong] + size * moved, 0.0), self.exponent)
        front = int(at.searchsorted(self.head - self.base, "right"))
        behind = (forces[:front] >= _FLOOR).nonzero()[0]
        self.late[at[behind]], self.since[at[behind]] = forces[behind], self.time + shares[behind] * size
        for j, share, force in zip(at[front:].tolist(), shares[front:].tolist(), forces[front:].tolist(), strict=True):
            if force >= _FLOOR:
                self._add_peak(j, size, share)

    def _add_peak(self, j: int, size: float, share: float) -> None:
        """Process a peak of the front at local contact j."""
        self.head = contact = self.base + j
        wanted, followed = contact in self.request.contacts, (contact + 1) % STRIDE == 0
        if not (wanted or followed):
            return
        peak = self._read_peak(j, size, share, 1e-6 if wanted else 1e-4)
        if wanted:
            self.passages.append(peak)
        if followed:
            self.peaks.append(peak)
            self._judge()

    def _read_peak(self, j: int, size: float, share: float, near: float) -> Passage:
        """Compute the peak by repeated steps from the previous state to the time at which the contact stops closing.

        That time is found by Newton's method with bisections, whose last shift is at most ``near``. The domain of
        dependence of a step is one granule per stage, so a part of the window is sufficient.
        """
        stages = len(self.method.tableau.nodes)
        first, last = max(j - stages, 0), j + stages + 2
        x, v, a = (array[first:last] for array in (self.x, self.v, self.a))
        at = j - first
        driven = self.driven and first == 0
        low, high = 0.0, 1.5
        for _ in range(60):
            part = share * size
            time = self.time + part
            force = WindowAcceleration(self.problem.free if driven else None, self.exponent, time, time)
            tried = self.method.attempt(force, self.time, part, x, v, a)
            self.evaluations += self.method.tableau.evaluations
            free = self.problem.free(time) if driven else (0.0, 0.0)
            tried.x[0] += free[0]
            tried.v[0] += free[1]
            overlaps = (tried.x[:-1] - tried.x[1:]).tolist()
            closing = float(tried.v[at] - tried.v[at + 1])
            slope = (self._force(overlaps[at - 1]) if at else 0.0) + self._force(overlaps[at + 1])
            slope -= 2 * self._force(overlaps[at])
            if driven and j == 0:
                slope += self._applied_force(time, size)
            left = -closing / slope if slope < 0 else size
            if abs(left) < near:
                return Passage(self.base + j, time + left, self._force(overlaps[at] + 0.5 * closing * left))
            low, high = (share, high) if closing > 0 else (low, share)
            share += left / size
            if not low < share < high:
                share = (low + (1.0 if low < 1 < high else high)) / 2
        return Passage(self.base + j, time, self._force(overlaps[at]))

    def _applied_force(self, time: float, size: float) -> float:
        """Applied force at ``time`` in a step of this size, from the difference of the impulse."""
        about = 1e-4 * size
        before, after = max(time - about, self.time), min(time + about, self.time + size)
        gained = self.problem.free(after)[1] - self.problem.free(before)[1]
        return gained / (after - before) if after > before else 0.0

    def _judge(self, end: bool = False) -> None:
        """Check whether the peaks of the front have reached their limit; at the ``end`` state how near they are."""
        if len(self.peaks) < KEPT or self.driven or self.time < self.request.limits.earliest_time:
            return
        peak = self.peaks[-1].force
        allowed = peak if end else self.request.doubt * peak
        value, doubt = limit([passage.force for passage in self.peaks[-KEPT:]], math.inf if end else allowed)
        if end:
            doubt = doubt / NOISE + _RIVAL * max(self._strongest_behind() - _TALLER, 0.0) * peak
        elif doubt <= allowed and self._strongest_behind() <= _TALLER:
            self.status = SearchStatus.KNOWN
        if doubt < allowed if end else self.status is SearchStatus.KNOWN:
            self.limit = value, doubt / peak

    def _strongest_behind(self) -> float:
        """Peak force that a wave behind the front may reach, over that of the front."""
        front = self.head - self.base - 2
        if front <= 0 or not self.peaks:
            return 0.0
        recent = growth_since(self.late[:front], self.since[:front], self.time, self.request.limits.growing)
        forces = contact_forces(self.x[: front + 1], self.exponent)
        return float(max(recent.max(), forces.max())) / self.peaks[-1].force

    def primary(self) -> Primary:
        """The leading wave, from the smallest force behind its peak, and the balances of the chain."""
        v = self.v[:-1]
        forces = contact_forces(self.x, self.exponent).tolist()
        foot = max(self.head - self.base, 0)
        while foot > 0 and forces[foot - 1] < forces[foot]:
            foot -= 1
        none = Passage(0, 0.0, 0.0)
        previous, last = [none, none, *self.peaks][-2:]
        if self.status != SearchStatus.KNOWN:
            self.limit = last.force, 1.0
            self._judge(end=True)
        return Primary(
            status=self.status,
            peak=self.limit[0],
            last=last.force,
            contact=last.contact,
            time=float(last.time),
            doubt=self.limit[1],
            speed=0.0 if previous is none else STRIDE / float(last.time - previous.time),
            momentum=math.fsum(v[foot + 1 :].tolist()),
            energy=window_energy(self.x[foot + 1 :], v[foot + 1 :], self.exponent),
            foot=forces[foot],
            chain_momentum=self.removed_momentum + math.fsum(v.tolist()),
            chain_energy=self.removed_energy + window_energy(self.x, v, self.exponent),
            work=self.work,
            impulse=self.applied[1],
            free_path=self.applied[0],
            steps=self.steps,
            evaluations=self.evaluations,
            passages=tuple(self.passages),
        )
