"""Integration of a chain of mixed granules; the compiled code and NumPy implement the same algorithm.

The step is fixed, or adapts to errors of overlaps and closing velocities relative to the greatest ones of each contact.
Steps end on kinks of the applied force, and where a contact closes, opens or starts to be cut off, if that affects the
result.
"""

from __future__ import annotations

import math
from copy import copy

import numpy as np
import numpy.typing as npt

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_arrays import UNSAMPLED, Job, Status
from shockwave.engine.chain_end import EndExtremes
from shockwave.engine.chain_forces import (
    KINK_SHARE,
    MIN_STEP,
    MOST_CHANGES,
    End,
    greatest_overlap,
    has_arrived,
    is_over,
    kink_error,
)
from shockwave.engine.chain_peaks import MOST_TURNS, NEAR, Overlap, vanish
from shockwave.engine.chain_stages import Stages
from shockwave.engine.cubic_interpolation import around_tops, root, top_between
from shockwave.engine.stretch import Span
from shockwave.engine.time_limit import expired

#: Number of granules by which the window grows.
GROWTH = 8
#: The granule this many before the end of the window must be at rest: its displacement and velocity are below this.
MARGIN = 4
AT_REST = 1e-40
# The same for an integrator with steps of its own.
_NEARLY_AT_REST = 1e-16
#: Safety factor and limits of the ratio of consecutive step sizes (Hairer, Norsett & Wanner, section II.4).
SAFETY = 0.8
MIN_FACTOR = 0.2
_MAX_FACTOR = 3.0
# Work on a stage besides that on the contacts, in evaluations of a contact force of the compiled code.
_STEP = 4000
# Smallest first step over that estimated.
_MIN_FIRST = 1e-13
# Largest factor and smallest step, over the first, of a fixed step: the next is never longer, and one that fails is not
# repeated.
_FIXED = 1.0, 0.5
#: Smallest fraction of a step after which a contact is predicted to close that shortens the step.
SOON = 1e-3
#: Largest number of steps that are shortened in succession to end at a kink.
MOST_CUTS = 8
#: A maximum within a step is computed if it may exceed the greatest force so far, less this fraction of it.
NEARLY = 0.1
#: Rest of a step after a maximum, relative to it, over which a parabola continues the force from its end.
AT_END = 1e-2
#: Error over the tolerance beyond which a step is too long to find a kink in it.
HOPELESS = 1e6


def limits(adaptive: bool) -> tuple[float, float]:
    """Largest ratio of consecutive step sizes, and the smallest step over the first."""
    return (_MAX_FACTOR, _MIN_FIRST) if adaptive else _FIXED


def _front(end: End) -> int:
    """Number of bodies up to the front of the waves, with some at rest, if all are integrated."""
    moving = np.flatnonzero(np.maximum(np.abs(end.x), np.abs(end.v)) > _NEARLY_AT_REST)
    return min(int(moving.max(initial=0)) + MARGIN, len(end.x) - 1)


class March(Stages):
    """A run with NumPy; ``n`` bodies are in the window, the others at rest."""

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        self.stops = [*job.stops[job.stops > self.time].tolist(), math.inf]
        self.progress, self.size = job.progress, job.progress.size
        self.max_factor, self.min_first = limits(job.method.adaptive)
        self.extremes = EndExtremes(self)
        self.held = self.effort = 0.0
        self.rejected, self.cuts = False, 0
        self.next_sample = 0
        self.record = job.record
        self.kinks = self.integrator_steps is None and (job.record is None or job.record.kinks)
        if job.plastic.size:
            from shockwave.engine.chain_modes import Plasticity

            self.flow = Plasticity(self, job)

    def run(self) -> None:
        """Integrate to the end."""
        job, status = self.job, Status.RUNNING
        start = self.begin(job.x.copy(), job.v.copy())
        self.sample(start, -math.inf)
        while status is Status.RUNNING and not expired():
            if self.record and self.record.is_full(self.bodies):
                status = Status.PAUSED
                break
            size, end = self.next_size(start)
            at_stop = end == min(self.stops[0], self.until)
            x1, v1, impulses = self.attempt(start, size, end, 0, self.n)
            error = self.error(size)
            finish = self.end_of(x1, v1, end, self.n)
            self.effort += len(self.method.nodes) * (self.n + _STEP)
            ends = self.kinks and error < HOPELESS and self.cuts < MOST_CUTS
            share = self.kink(start, finish, size) if ends else 1.0
            if self.integrator_steps is not None or self.resize(size, error, share, at_stop):
                start = self.accept(start, finish, size, end, impulses)
                over = self.until == math.inf and self.time >= self.duration and is_over(start, self.contacts)
                if self.time >= self.until or over:
                    status = Status.DONE
            elif share == 1 and self.size < max(MIN_STEP * self.time, self.min_first * self.first):
                status = Status.FAILED
            if status is Status.RUNNING and self.effort > self.settings.most_work:
                status = Status.TOO_LONG
            job.forecast.check(self.time, self.effort, self.progress.steps)
        job.x[:], job.v[:] = start.x, start.v
        progress = self.progress
        progress.status, progress.time, progress.size = status, self.time, self.size
        progress.evaluations = self.evaluations

    def span(self, start: End, finish: End, end: float) -> Span:
        """The present step."""
        n, march = self.n, copy(self)
        march.integrator_steps = copy(self.integrator_steps)

        def state(time: float) -> tuple[FloatArray, FloatArray]:
            x, v, _impulses = march.attempt(start, time - march.time, time, 0, n)
            return x[:n], v[:n]

        return Span(self.time, end, start.x[:n], start.v[:n], finish.x[:n], finish.v[:n], state)

    def resize(self, size: float, error: float, share: float, at_stop: bool) -> bool:
        """Set the size of the next step, from the error over the tolerance, and return whether this one is accepted.

        ``share`` is the fraction of this step at which it should end, and ``at_stop`` whether it was shortened.
        """
        factor = SAFETY * max(error, 1e-12) ** (-1 / (self.method.error_order + 1)) if error == error else 0.0
        if share < 1.0:
            self.cuts += 1
            if self.cuts == 1:
                self.held = self.size if error <= 1 else size * max(factor, MIN_FACTOR)
            self.size = size * share
            return False
        if not error <= 1:
            self.size = size * (factor if MIN_FACTOR < factor < 1 else MIN_FACTOR)
            self.rejected, self.held = True, 0.0
            return False
        # a step that was shortened to end here does not shorten the next one
        longest = size * min(factor, 1.0 if self.rejected else self.max_factor)
        self.size = max(longest, self.held, self.size if at_stop or size < self.size else 0.0)
        self.rejected, self.held, self.cuts = False, 0.0, 0
        return True

    def begin(self, x: FloatArray, v: FloatArray, last: End | None = None) -> End:
        """State at the beginning of the next step; contacts with a dashpot are switched here.

        ``last``, the state at the end of the last step, is used again if no contact is switched or added.
        """
        n = self.n
        if self.jumps.any():
            d, w = self.overlaps(x, 0, n)[1], self.closing_velocities(v, 0, n)
            on = (d >= 0) | (self.jumps[:n] & (d >= -self.closing_tolerance(x, w, self.time)) & (w > 0))
            last = last if np.array_equal(on, self.on[:n]) else None
            self.on[:n] = on
        start = last
        if start is None or len(start.d) != n or self.job.law is not None:
            start = self.end_of(x, v, self.time, n)
        for _ in range(MOST_CHANGES):
            if self.flow is None or not self.flow.change_modes(start, self.time):
                break
            start = self.end_of(x, v, self.time, n)
        f, best = start.f[1 : n + 1], self.job.peaks
        above = np.flatnonzero(f[: self.contacts] > best[0, : min(n, self.contacts)])
        best[0, above], best[1, above] = f[above], self.time
        return start

    def next_size(self, start: End) -> tuple[float, float]:
        """Size and end of the next step."""
        stop = min(self.stops[0], self.until)
        if self.integrator_steps is not None:
            size, end = self.integrator_steps.advance(start, self.time, stop, self.driven)
            self.size = self.integrator_steps.size
            return size, end
        left, h = stop - self.time, self.size
        size = self.longest if self.driven or not self.kinks else math.inf
        near = np.flatnonzero(np.abs(start.d) < h * np.abs(start.w))
        if near.size and self.kinks:
            d, w = start.d[near], start.w[near]
            at = -d / w / h
            soon = at > SOON
            opens = kink_error(h, start.raw[near], 1 - at) > KINK_SHARE * self.allowed_impulses(self.n)[near]
            soon &= (d < 0) | (opens & ~self.viscous[near])
            size = min(size, float((at[soon] * h).min(initial=math.inf)))
            # a contact has just closed: its force is a power of the time
            closed = (np.abs(d) < SOON * h * w) & ~self.by_law[near] & self.method.adaptive
            for j in near[closed].tolist():
                self.size = min(self.size, self.first_size(j, float(start.w[j])))
        size = min(size, self.size, self.flow.turns(start, self.time) if self.flow else math.inf)
        if size >= left:
            return left, stop
        size = min(size, left / 2)  # avoids a very short last step
        return size, self.time + size

    def kink(self, start: End, finish: End, size: float) -> float:
        """Fraction of the step at which it should end since a contact closes, opens or is cut off; 1 if it need not."""
        law = self.by_law[: self.n]
        share = greatest_overlap(start, finish, size, self.tolerance, law) if self.state.size else 1.0
        acts, still_acts = self.on[: self.n] if self.jumps.any() else start.d >= 0, finish.d >= 0
        if self.damped:  # otherwise the force has the sign of the overlap, but for rounding under a static force
            elastic = ~self.viscous[: self.n]
            acts, still_acts = acts & (elastic | (start.raw >= 0)), still_acts & (elastic | (finish.raw >= 0))
        changes = acts != still_acts
        if changes.any():
            share = self.end_of_contacts(start, finish, size, (acts, changes), share)
        return self.flow.end_of_modes(start, finish, self.time, size, share) if self.flow else share

    def end_of_contacts(
        self, start: End, finish: End, size: float, flags: tuple[npt.NDArray[np.bool_], ...], share: float
    ) -> float:
        """Fraction of the step at which it should end since some contacts act or cease to; ``share`` if it need not.

        The ``flags`` are those of contacts that act at the beginning, and of those that change.
        """
        acts, changes = flags
        late, allowed = self.closing_tolerance(finish.x, finish.w, self.time), self.allowed_impulses(self.n)
        for j in np.flatnonzero(changes).tolist():
            d0, d1, raw0, raw1 = (float(a[j]) for a in (start.d, finish.d, start.raw, finish.raw))
            at = 0.5
            if (d0 < 0) != (d1 < 0):
                at = root(d0, size * float(start.w[j]), d1, size * float(finish.w[j]))
            closes = not acts[j]
            jumps = closes and self.jumps[j] and d0 < 0
            if self.viscous[j] and d0 >= 0 and raw0 * raw1 < 0 and (d1 >= 0 or self.q[j] == 0):
                change = raw1 - raw0
                rate = size * float(start.slope[j]) if raw0 > 0 else change
                cut = root(raw0, rate, raw1, 2 * change - rate)
                at = cut if d1 >= 0 else min(at, cut)
            elif self.viscous[j] and not closes:
                at *= 0.5  # the force ends before the contact opens
            error = float(kink_error(size, max(raw0, raw1), at if closes else 1 - at))
            if jumps:
                w = max(float(start.w[j]), float(finish.w[j]))
                error += float(self.c[j]) * w * (1 - at) * size
                at += 0.5 * float(late[j]) / (size * w) if w > 0 else 0.0
            if error > KINK_SHARE * allowed[j] and at * size > MIN_STEP * max(self.time, self.first):
                share = min(share, at)
        return share

    def accept(self, start: End, finish: End, size: float, end: float, impulses: list[float]) -> End:
        """Process an accepted step; the beginning of the next one."""
        job = self.job
        gained = self.impulses_in(size)
        self.add_losses(start, finish, size)
        if self.driven:
            self.add_work(start, finish, size, end, impulses)
        if self.record:
            self.record.spans.append(self.span(start, finish, end))
        else:
            self.find_peaks(start, finish, size, self.n)
        self.extremes.update(start, finish, (self.time, size), self.attempt)
        self.sample(start, end)
        job.impulses[:] += gained
        if self.weight > 0 and self.progress.rebound == 0:
            self.progress.rebound = self.first_rebound(start, finish, size)
        self.time = end
        self.progress.steps += 1
        if end == self.stops[0]:
            del self.stops[0]
        if self.driven:
            assert job.problem is not None
            self.free = job.problem.free(end)
            self.driven = end < self.duration
        self.widen(finish)
        if job.law is not None:
            here = self.by_law[: self.contacts]
            d, w = (np.where(here, values[: self.contacts], 0.0) for values in (finish.d, finish.w))
            self.state = job.law.update(d, w, self.state)
        following = self.begin(finish.x, finish.v, finish)
        self.look_for_arrival(following)
        return following

    def add_losses(self, start: End, finish: End, size: float) -> None:
        """Add the energies that contacts dissipate within the step."""
        n, weights, stages = self.n, self.method.weights[1][:, None], slice(len(self.method.nodes))
        if self.flow:
            self.flow.add_losses(start, finish, (self.time, size), self.stages)
        if self.damped:
            lost = size * np.add.reduce(weights * self.powers[stages, :n], axis=0)
            # a contact that is cut off loses its energy, whatever the length of the step
            idle = [((end.raw < 0) | (end.d < 0)) & (self.k[:n] > 0) for end in (start, finish)]
            p = self.p[:n] + 1
            kept = [self.k[:n] / p * np.maximum(end.d, 0.0) ** p for end in (start, finish)]
            self.job.losses[:n] += np.where(idle[0] & idle[1], kept[0] - kept[1], lost)

    def impulses_in(self, size: float) -> FloatArray:
        """Impulses at the watched contacts within the last attempt."""
        forces = self.stages[: len(self.method.nodes), self.job.watched + 1]
        return np.asarray(size * np.add.reduce(self.method.weights[1][:, None] * forces, axis=0))

    def widen(self, finish: End) -> None:
        """Widen the window if the waves are near its end, and raise the scales of the errors or state the front."""
        n, last = self.n, max(self.n - MARGIN, 0)
        if n < self.bodies and max(abs(finish.x[last]), abs(finish.v[last])) > AT_REST:
            self.n = min(n + GROWTH, self.bodies)
            self.mobile[n : self.n] = self.inverse[n : self.n]
        if self.record is None:
            self.raise_scales(finish, self.n)
        else:
            self.record.bodies = self.n if self.integrator_steps is None else _front(finish)

    def add_work(self, start: End, finish: End, size: float, end: float, impulses: list[float]) -> None:
        """Add the work of the force, integrated by parts: J w + J^2/2m minus the integral of J w'.

        J is the impulse since the beginning of the step, w the velocity of body 0 without it. With the mean of w', the
        quadrature of J over the stages is replaced by its exact integral. If the path of body 0 is given, the force on
        it is that of the contact, and its velocity w0 + J.
        """
        inverse, weights = float(self.inverse[0]), self.method.weights[1].tolist()
        impulse = impulses[-1]
        mean = summed = product = 0.0
        for weight, each, force in zip(weights, impulses, self.stages[:, 1].tolist(), strict=False):
            product += weight * each * force
            mean += weight * force
            summed += weight * each
        area = self.shift(size, end)[0] / inverse
        if self.guided:
            work = float(start.v[0]) * size * mean
        else:
            work = impulse * (float(finish.v[0]) - inverse * impulse) + 0.5 * inverse * impulse * impulse
        self.progress.work += work
        self.progress.work += inverse * (size * product + mean * (area - size * summed))

    def look_for_arrival(self, start: End) -> None:
        """Set the time at which the wave arrives at the last contact, and the end of the run if that depends on it."""
        last, progress = self.contacts - 1, self.progress
        if progress.arrival < 0 and self.n > last and has_arrived(start, self.job.peaks[0], last, self.static[last]):
            progress.arrival = float(self.job.peaks[1, last])
            if self.until == math.inf:
                self.until = max(self.duration + 3 * progress.arrival, self.time)

    def find_peaks(self, start: End, finish: End, size: float, n: int) -> None:
        """Compute the maxima of the contact forces within the step that may be the greatest so far."""
        forces = np.array([start.f[1 : n + 1], finish.f[1 : n + 1]])
        low, high, most = around_tops(forces, size * np.array([start.slope, finish.slope]))
        best = self.job.peaks[0, :n]
        least = np.maximum(best - NEARLY * np.abs(best + self.static[:n]), forces.max(axis=0))
        for j in np.flatnonzero(((low[2] > 0) & (high[2] <= 0) & (most > least))[: self.contacts]).tolist():
            self.find_peak(start, finish, size, j, low[:, j].tolist(), high[:, j].tolist())

    def find_peak(self, start: End, finish: End, size: float, j: int, begin: list[float], end: list[float]) -> None:
        """Compute the maximum of a contact force in an interval of the step.

        A repeated step ends at the time at which its slope vanishes, by the polynomial of the overlap.
        """
        best = self.job.peaks[:, j]
        overlap = Overlap.between(self, start, finish, self.time, size, j)
        share, bend = vanish(overlap.slope, begin[0], end[0], top_between(begin, end))
        if 1 - share < AT_END:
            force = float(finish.f[j + 1]) + 0.5 * size * float(finish.slope[j]) * (share - 1)
            if force > best[0]:
                best[:] = force, self.time + share * size
            return
        reach = len(self.method.nodes) + 2
        first, last = max(j - reach, 0), min(j + reach + 1, self.n)
        left = here = slope = 0.0
        for turn in range(MOST_TURNS):
            time = self.time + share * size
            x, v, _impulses = self.attempt(start, share * size, time, first, last)
            here, slope = self.force_at(x, v, j, time, self.n)
            slope *= size
            left = max(min(-slope / bend if bend < 0 else 0.0, 1 - share), -share)
            if abs(left) < NEAR:
                break
            if turn + 1 < MOST_TURNS:
                share += left
        if here + 0.5 * slope * left > best[0]:
            best[:] = here + 0.5 * slope * left, self.time + (share + left) * size

    def sample(self, start: End, end: float) -> None:
        """Store the sampled rows at the requested times up to the end of the step."""
        job = self.job
        rows = job.watched[UNSAMPLED:]
        while self.next_sample < len(job.times) and job.times[self.next_sample] <= max(end, self.time):
            time = float(job.times[self.next_sample])
            x, v, impulses = start.x, start.v, job.impulses
            if self.integrator_steps is None or time > self.time:  # an `Integrator` has no step at first
                x, v, _ = self.attempt(start, time - self.time, time, 0, self.n)
                impulses = impulses + self.impulses_in(time - self.time)
            sample, forces = job.samples[self.next_sample], self.forces(x, v, 0, self.bodies)[0] + self.static
            sample[:4] = x[rows], v[rows], forces[rows], impulses[UNSAMPLED:]
            if self.flow:
                sample[4] = self.flow.released_energies(self.overlaps(x, 0, self.bodies)[1], forces)[rows]
            self.next_sample += 1
