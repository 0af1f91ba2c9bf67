"""Integration of a chain of mixed granules; the compiled code and NumPy implement the same algorithm.

The step adapts to errors of overlaps and closing velocities relative to the greatest ones of each contact. Steps end on
kinks of the applied force, and where a contact closes, opens or starts to be cut off, if that affects the result.
"""

from __future__ import annotations

import math
from enum import IntEnum
from types import ModuleType
from typing import Any

import numpy as np
from attrs import define, frozen

from shockwave.quadrature import FloatArray
from shockwave.simulation.general_nystroem import GeneralTableau, scaled_error
from shockwave.simulation.problem import ChainProblem
from shockwave.simulation.time_limit import expired

# Smaller overlaps count as zero: arithmetic with subnormal numbers is slow.
MIN_OVERLAP = 1e-60
# Number of granules of the first window, and by which it grows.
_WINDOW = 12
_GROWTH = 8
# The granule this many before the end of the window must be at rest: its displacement and velocity are below this.
_MARGIN = 4
_AT_REST = 1e-40
# Safety factor and limits of the ratio of consecutive step sizes (Hairer, Norsett & Wanner, section II.4).
_SAFETY = 0.6
_MIN_FACTOR = 0.2
_MAX_FACTOR = 3.0
# Smallest step, relative to the time and to the first step.
_MIN_STEP = 1e-15
_MIN_FIRST = 1e-13
# Smallest fraction of a step after which a contact is predicted to close that shortens the step.
_SOON = 1e-3
# Velocity error of a step with a kink of the force, over the length of the shorter part and the force.
_KINK = 0.1
# Fraction of the tolerance that a kink may use.
_KINK_SHARE = 0.1
# Largest number of steps that are shortened in succession to end at a kink.
_MOST_CUTS = 8
# Fraction of the tolerance within which the closing of a contact with a dashpot is located.
_LOCATED = 0.1
# Rounding error of an overlap, relative to positions and displacements.
_ROUNDING = 1e-14
# A maximum within a step is computed if it may exceed the greatest force so far, less this fraction of it.
_NEARLY = 0.1
# Error over the tolerance beyond which a step is too long to find a kink in it.
_HOPELESS = 1e6
# Largest number of steps to a maximum.
_MOST_TURNS = 30
# Precision of the time of a maximum, over the step, up to which the force is a parabola.
_NEAR = 1e-4
# The wave has arrived when the last force is below this fraction of its maximum ...
_PASSED = 0.99
# ... if that is at least this fraction of the greatest force at the contact before.
_WAVE = 1e-3


class Status(IntEnum):
    """Status of a run."""

    RUNNING = 0
    DONE = 1
    TOO_LONG = 2
    FAILED = 3


@frozen(eq=False)
class Job:
    """Input and output of a run, as arrays that the compiled code shares.

    Row j of an array with a row for each body belongs to contact j, between bodies j and j + 1; the last one is the
    contact with the wall, the spring of a movable end, or none.

    Attributes
    ----------
    method : GeneralTableau
    problem : ChainProblem or None
        The applied force.
    law : object or None
        Contact law of a plugin.
    settings : array, shape (15,)
        Exponent, damping power, tolerance, until (infinite: found by the run), duration, rise time and peak force,
        first step, longest step under force, number of contacts, stiffness and damping of the end, most steps, most
        work, damped.
    chain : array, shape (9, bodies)
        Inverse masses, stiffnesses, gaps (zero or negative), static overlaps, their roots, static forces, damping
        coefficients, and the least fractions of closing velocity and overlap expected of a contact, over those of the
        contact before.
    x, v : array, shape (bodies + 1,)
        State; the last value is the wall.
    scales : array, shape (2, bodies)
        Closing velocities and overlaps to which the errors are compared.
    peaks : array, shape (2, bodies)
        Greatest force minus static force, and its time.
    sums : array, shape (2, bodies)
        Impulse, and dissipated energy.
    stops, times : array
        Kinks of the applied force; times of samples.
    samples : array, shape (times, 3, bodies + 1)
        x, v and total forces.
    found : array, shape (6,)
        Status, time, arrival (negative: none), work, steps, evaluations.
    """

    method: GeneralTableau
    problem: ChainProblem | None
    law: Any
    settings: FloatArray
    chain: FloatArray
    x: FloatArray
    v: FloatArray
    scales: FloatArray
    peaks: FloatArray
    sums: FloatArray
    stops: FloatArray
    times: FloatArray
    samples: FloatArray
    found: FloatArray


def run(job: Job, compiled: ModuleType | None) -> None:
    """Integrate to the end, in place."""
    if compiled is None:
        _March(job).run()
        return
    problem = job.problem
    none = np.empty(0)
    tables = (none, none) if problem is None else (problem.path.rows, problem.path.coefficients)
    arrays = job.stops, job.times, job.settings, job.chain, job.x, job.v, job.scales, job.peaks, job.sums, job.samples
    compiled.run(job.method.packed, *tables, *arrays, job.found, expired)


@define(eq=False)
class _End:
    """State at one end of a step: overlaps, closing velocities, forces minus static ones (contact j in element j + 1), forces
    before they are cut off, and their time derivatives, zero for an open contact.
    """

    x: FloatArray
    v: FloatArray
    d: FloatArray
    w: FloatArray
    f: FloatArray
    raw: FloatArray
    powers: FloatArray
    slope: FloatArray


class _March:
    """A run with NumPy; ``n`` bodies are in the window, the others at rest."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.p, self.q, self.tolerance, self.until, self.duration = job.settings[:5].tolist()
        self.first, self.longest, contacts, self.end_stiffness, self.end_damping = job.settings[7:12].tolist()
        self.most_steps, self.most_work, damped = job.settings[12:].tolist()
        self.inverse, self.k, self.gap, self.base, self.root, self.static, self.c = job.chain[:7]
        self.reach_w, self.reach_u = job.chain[7:]
        self.bodies, self.contacts = len(self.inverse), int(contacts)
        self.padded = np.append(self.inverse, 0.0)
        # accelerations of the closing velocity of each contact by a unit force
        self.both = self.inverse + self.padded[1:]
        self.damped = damped != 0
        self.jumps = self.damped and self.q == 0 and job.law is None
        self.n = min(_WINDOW, self.bodies) if job.law is None else self.bodies
        stages = len(job.method.nodes)
        self.stages, self.powers = np.zeros((stages, self.bodies + 2)), np.zeros((stages, self.bodies))
        self.on = np.ones(self.bodies, dtype=bool)
        self.state = None if job.law is None else job.law.initial_state()
        self.stops = [*job.stops.tolist(), math.inf]
        self.driven = job.problem is not None
        self.free = (0.0, 0.0)
        self.time = self.held = self.work = self.effort = 0.0
        self.size, self.arrival = self.first, -1.0
        self.rejected = False
        self.steps = self.evaluations = self.next_sample = 0

    # ---------------------------------------------------------------- forces

    def forces(self, x: FloatArray, v: FloatArray, low: int, high: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Forces minus static ones, power of the damping, and forces before they are cut off, of contacts of a range."""
        part = slice(low, high)
        k, base, static = self.k[part], self.base[part], self.static[part]
        stretch = (x[part] - x[low + 1 : high + 1]) + self.gap[part]
        d = stretch + base
        w = v[part] - v[low + 1 : high + 1]
        closed = d > MIN_OVERLAP
        inside = np.where(closed, d, 1.0)
        powers = np.zeros(high - low)
        if self.job.law is not None:
            raw = np.zeros(high - low)
            raw[: self.contacts] = self.job.law.force(d[: self.contacts], w[: self.contacts], self.state)
            f = np.maximum(raw, 0.0)
            powers = f * w
        else:
            if self.p == 1.5:
                root = np.sqrt(inside)
                f = k * (stretch * (d + root * self.root[part] + base) / (root + self.root[part]))
            else:
                strain = np.where(closed, stretch, 0.0) / np.where(base > 0, base, 1.0)
                f = np.where(base > 0, static * np.expm1(self.p * np.log1p(strain)), k * inside**self.p)
            raw = f = np.where(closed, f, -static)
            if self.damped:
                if self.q == 0.0:
                    raw, acts = f + self.c[part] * w, self.on[part]
                else:
                    rate = _power(inside, self.q)
                    raw, acts = np.where(closed, f + self.c[part] * rate * w, f), closed
                total = np.where(acts, np.maximum(raw, -static), -static)
                powers = np.where(acts, total - f, 0.0) * w
                f = total
        if high == self.bodies and (self.end_stiffness or self.end_damping):
            f[-1] = self.end_stiffness * x[-2] + self.end_damping * v[-2]
            powers[-1] = self.end_damping * v[-2] * v[-2]
        return f, powers, raw + static

    def slopes(self, x: FloatArray, v: FloatArray, f: FloatArray, low: int, high: int, time: float) -> FloatArray:
        """Time derivatives of the forces of closed contacts of a range before they are cut off."""
        part = slice(low, high)
        d = (x[part] - x[low + 1 : high + 1]) + self.gap[part] + self.base[part]
        w = v[part] - v[low + 1 : high + 1]
        closed = d > MIN_OVERLAP
        inside = np.where(closed, d, 1.0)
        power = _power(inside, self.p - 1)
        slope = self.p * self.k[part] * power * w
        if self.damped:
            a = self.padded[low : high + 1] * (f[low : high + 1] - f[low + 1 : high + 2])
            if low == 0:
                a[0] += self.inverse[0] * self.applied(time)
            rate = _power(inside, self.q)
            slope = slope + self.c[part] * rate * (self.q / inside * w * w + (a[:-1] - a[1:]))
        return np.where(closed, slope, 0.0)

    def applied(self, time: float) -> float:
        """Applied force, from the difference of its impulse."""
        problem = self.job.problem
        if problem is None or time >= self.duration:
            return 0.0
        about = 1e-4 * self.longest
        before, after = max(time - about, 0.0), min(time + about, self.duration)
        return (problem.free(after)[1] - problem.free(before)[1]) / (after - before)

    def end_of(self, x: FloatArray, v: FloatArray, time: float) -> _End:
        """Everything at one end of a step."""
        n = self.n
        forces, powers, raw = self.forces(x, v, 0, n)
        whole = np.zeros(self.bodies + 2)
        whole[1 : n + 1] = forces
        d = (x[:n] - x[1 : n + 1]) + self.gap[:n] + self.base[:n]
        w = v[:n] - v[1 : n + 1]
        slope = np.where(raw > 0, self.slopes(x, v, whole, 0, n, time), 0.0)
        return _End(x, v, d, w, whole, raw, powers, slope)

    # ---------------------------------------------------------------- steps

    def attempt(
        self, start: _End, size: float, end: float, low: int, high: int
    ) -> tuple[FloatArray, FloatArray, list[float]]:
        """State after a step, of bodies low to high; valid at least one body per stage inside of ends within the chain.

        Also returns the impulses of the applied force at the stages, since the beginning of the step.
        """
        method, h = self.job.method, size
        x, v, inverse = start.x, start.v, self.inverse[low:high]
        y, z = x.copy(), v.copy()
        impulses, shift = [0.0], 0.0
        square = h * h
        self.stages[0] = start.f
        self.powers[0, : self.n] = start.powers
        part = slice(low, high)
        f = self.stages[:, low : high + 1]
        for i in range(1, len(method.nodes)):
            sums = np.add.reduce(method.positions[i, :i, None] * f[:i], axis=0)
            c = float(method.nodes[i])
            y[part] = x[part] + (c * h) * v[part] + square * (inverse * (sums[:-1] - sums[1:]))
            if method.damped:
                sums = np.add.reduce(method.velocities[i, :i, None] * f[:i], axis=0)
                z[part] = v[part] + h * (inverse * (sums[:-1] - sums[1:]))
            if self.driven and low == 0:
                shift, impulse = self.shift(c * h, end if c == 1.0 else self.time + c * h)
                impulses.append(impulse)
                y[0] += shift
                z[0] += self.inverse[0] * impulse
            self.stages[i, low + 1 : high + 1], powers, _ = self.forces(y, z, low, high)
            if self.damped:
                self.powers[i, part] = powers
        x1, v1 = x.copy(), v.copy()
        position, velocity = np.add.reduce(method.weights[:2, :, None] * f, axis=1)
        x1[part] = x[part] + h * v[part] + square * (inverse * (position[:-1] - position[1:]))
        v1[part] = v[part] + h * (inverse * (velocity[:-1] - velocity[1:]))
        if self.driven and low == 0:
            shift, impulse = self.shift(h, end)
            impulses.append(impulse)
            x1[0] += shift
            v1[0] += self.inverse[0] * impulse
        return x1, v1, impulses

    def shift(self, passed: float, time: float) -> tuple[float, float]:
        """Displacement of body 0 by the applied force since the beginning of the step, and the impulse."""
        problem = self.job.problem
        assert problem is not None
        path, impulse = problem.free(time)
        return self.inverse[0] * ((path - self.free[0]) - passed * self.free[1]), impulse - self.free[1]

    def error(self, size: float) -> float:
        """Largest error of the last attempt over the tolerance."""
        n, weights = self.n, self.job.method.weights
        f = self.stages[:, : n + 1]
        worst = []
        for position, velocity in (weights[2:4], weights[4:6]):
            most = 0.0
            for row, power, scale in (
                (position, size * size, self.job.scales[1]),
                (velocity, size, self.job.scales[0]),
            ):
                sums = np.add.reduce(row[:, None] * f, axis=0)
                changes = np.append(power * (self.inverse[:n] * (sums[:-1] - sums[1:])), 0.0)
                error = float((np.abs(changes[:-1] - changes[1:]) / scale[:n]).max())
                most = error if not error <= most else most
            worst.append(most)
        return scaled_error(*worst) / self.tolerance

    def run(self) -> None:
        """Integrate to the end."""
        job = self.job
        start = self.begin(job.x.copy(), job.v.copy())
        self.sample(start, -math.inf)
        status, cuts = Status.RUNNING, 0
        while status is Status.RUNNING and not expired():
            size, end = self.next_size(start)
            at_stop = end == min(self.stops[0], self.until)
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                x1, v1, impulses = self.attempt(start, size, end, 0, self.n)
                error = self.error(size)
                finish = self.end_of(x1, v1, end)
            self.evaluations += len(job.method.nodes)
            self.effort += len(job.method.nodes) * self.n
            share = self.kink(start, finish, size) if error < _HOPELESS and cuts < _MOST_CUTS else 1.0
            factor = _SAFETY * max(error, 1e-12) ** (-1 / (job.method.error_order + 1)) if error == error else 0.0
            if share < 1.0:
                cuts += 1
                if cuts == 1:
                    self.held = self.size if error <= 1 else size * max(factor, _MIN_FACTOR)
                self.size = size * share
            elif not error <= 1:
                self.size = size * (factor if _MIN_FACTOR < factor < 1 else _MIN_FACTOR)
                self.rejected, self.held = True, 0.0
                if self.size < max(_MIN_STEP * self.time, _MIN_FIRST * self.first):
                    status = Status.FAILED
            else:
                # a step that was shortened to end here does not shorten the next one
                grown = size * min(factor, 1.0 if self.rejected else _MAX_FACTOR)
                self.size = max(grown, self.held, self.size if at_stop or size < self.size else 0.0)
                self.rejected, self.held, cuts = False, 0.0, 0
                start = self.accept(start, finish, size, end, impulses)
                if self.time >= self.until or (self.until == math.inf and self.is_over(start)):
                    status = Status.DONE
            if status is Status.RUNNING and (self.steps >= self.most_steps or self.effort > self.most_work):
                status = Status.TOO_LONG
        job.x[:], job.v[:] = start.x, start.v
        job.found[:] = status, self.time, self.arrival, self.work, self.steps, self.evaluations

    def begin(self, x: FloatArray, v: FloatArray) -> _End:
        """The beginning of the next step; contacts with a dashpot close here."""
        n = self.n
        if self.jumps:
            d = (x[:n] - x[1 : n + 1]) + self.gap[:n] + self.base[:n]
            w = v[:n] - v[1 : n + 1]
            self.on[:n] = (d >= 0) | ((d >= -self.late(x, w)) & (w > 0))
        start = self.end_of(x, v, self.time)
        f, best = start.f[1 : n + 1], self.job.peaks
        above = f[: self.contacts] > best[0, : min(n, self.contacts)]
        best[0, : len(above)][above] = f[: len(above)][above]
        best[1, : len(above)][above] = self.time
        return start

    def late(self, x: FloatArray, w: FloatArray) -> FloatArray:
        """Overlaps by which contacts with a dashpot may be early or late to close."""
        n = len(w)
        allowed = _LOCATED * self.tolerance * self.job.scales[0, :n] / np.maximum(self.both[:n] * self.c[:n], 1e-300)
        return np.maximum(allowed, _ROUNDING * (np.abs(x[:n]) + np.abs(x[1 : n + 1]) + self.time * np.abs(w)))

    def next_size(self, start: _End) -> tuple[float, float]:
        """Size and end of the next step."""
        stop = min(self.stops[0], self.until)
        left = stop - self.time
        size = min(self.size, self.longest) if self.driven else self.size
        near = (start.d < 0) & (start.w > 0)
        if near.any():
            soon = float((-start.d[near] / start.w[near]).min())
            size = soon if _SOON * size < soon < size else size
        if size >= left:
            return left, stop
        size = min(size, left / 2)  # avoids a very short last step
        return size, self.time + size

    def kink(self, start: _End, finish: _End, size: float) -> float:
        """Fraction of the step at which it should end because a contact closes, opens or is cut off; 1 if it need not."""
        share = 1.0
        acts = (start.d >= 0) & (start.raw >= 0)
        if self.jumps:
            acts = self.on[: self.n] & (start.raw >= 0)
        changes = acts != ((finish.d >= 0) & (finish.raw >= 0))
        if not changes.any():
            return share
        late = self.late(finish.x, finish.w)
        for j in np.flatnonzero(changes).tolist():
            d0, d1, raw0, raw1 = (float(a[j]) for a in (start.d, finish.d, start.raw, finish.raw))
            least = _KINK_SHARE * self.tolerance * float(self.job.scales[0, j]) / float(self.both[j])
            at = root(d0, d1, size * float(start.w[j]), size * float(finish.w[j])) if (d0 < 0) != (d1 < 0) else 0.5
            closes = not acts[j]
            if closes and self.jumps and d0 < 0:
                error = raw1 * (1 - at) * size
                at += 0.5 * float(late[j]) / (size * float(finish.w[j])) if finish.w[j] > 0 else 0.0
            else:
                if self.damped and d0 >= 0 and raw0 * raw1 < 0 and (d1 >= 0 or self.q == 0.0):
                    at = raw0 / (raw0 - raw1)
                elif self.damped and not closes:
                    at *= 0.5  # the force ends before the contact opens
                active, idle = (1 - at, at) if closes else (at, 1 - at)
                error = _KINK * size * max(raw0, raw1) * min(1.0, idle / max(active, 1e-300))
            if error > least and at * size > _MIN_STEP * max(self.time, self.first):
                share = min(share, at)
        return share

    def accept(self, start: _End, finish: _End, size: float, end: float, impulses: list[float]) -> _End:
        """Process an accepted step; the beginning of the next one."""
        job, n = self.job, self.n
        weights = job.method.weights[1][:, None]
        job.sums[0, :n] += size * np.add.reduce(weights * self.stages[:, 1 : n + 1], axis=0)
        if self.damped:
            lost = size * np.add.reduce(weights * self.powers[:, :n], axis=0)
            # a contact that is cut off loses its energy, whatever the length of the step
            idle = [((end.raw < 0) | (end.d < 0)) & (self.k[:n] > 0) for end in (start, finish)]
            kept = [self.k[:n] / (self.p + 1) * np.maximum(end.d, 0.0) ** (self.p + 1) for end in (start, finish)]
            job.sums[1, :n] += np.where(idle[0] & idle[1], kept[0] - kept[1], lost)
        if self.driven:
            self.add_work(finish, size, end, impulses)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            for j in np.flatnonzero((start.slope > 0) & (finish.slope <= 0)).tolist():
                self.find_peak(start, finish, size, j)
        self.sample(start, end)
        # the change of the overlap, not the difference of overlaps: ahead of the wave that is below their rounding errors
        stretch = (finish.x[:n] - finish.x[1 : n + 1]) + self.gap[:n]
        w, u = np.abs(finish.w), np.where(finish.d > 0, np.abs(stretch), self.base[:n])
        for scale, value, reach in ((job.scales[0], w, self.reach_w), (job.scales[1], u, self.reach_u)):
            expected = np.append(0.0, reach[1:n] * scale[: n - 1])
            scale[:n] = np.maximum(np.maximum(scale[:n], value), expected)
        self.time = end
        self.steps += 1
        if end == self.stops[0]:
            del self.stops[0]
        if self.driven:
            assert job.problem is not None
            self.free = job.problem.free(end)
            self.driven = end < self.duration
        last = max(n - _MARGIN, 0)
        if n < self.bodies and max(abs(finish.x[last]), abs(finish.v[last])) > _AT_REST:
            self.n = min(n + _GROWTH, self.bodies)
            # under static forces the bodies at the end of the window are not quite at rest
            for j in range(n, self.n):
                for scale, reach in ((job.scales[0], self.reach_w), (job.scales[1], self.reach_u)):
                    scale[j] = max(scale[j], reach[j] * scale[j - 1])
        if job.law is not None:
            count = self.contacts
            self.state = job.law.update(finish.d[:count], finish.w[:count], self.state)
        following = self.begin(finish.x, finish.v)
        self.look_for_arrival(following)
        return following

    def add_work(self, finish: _End, size: float, end: float, impulses: list[float]) -> None:
        """Add the work of the force, integrated by parts: J w + J^2/2m minus the integral of J w'.

        J is the impulse since the beginning of the step, w the velocity of body 0 without it. With the mean of w', the
        quadrature of J over the stages is replaced by its exact integral.
        """
        inverse, weights = float(self.inverse[0]), self.job.method.weights[1].tolist()
        impulse = impulses[-1]
        mean = summed = product = 0.0
        for weight, each, force in zip(weights, impulses, self.stages[:, 1].tolist(), strict=False):
            product += weight * each * force
            mean += weight * force
            summed += weight * each
        area = self.shift(size, end)[0] / inverse
        self.work += impulse * (float(finish.v[0]) - inverse * impulse) + 0.5 * inverse * impulse * impulse
        self.work += inverse * (size * product + mean * (area - size * summed))

    def is_over(self, start: _End) -> bool:
        """Whether no contact force acts and none can follow."""
        return self.time >= self.duration and not start.f.any() and not (start.w > 0).any()

    def look_for_arrival(self, start: _End) -> None:
        """Set the time at which the wave arrives at the last contact, and the end of the run if that depends on it."""
        last = self.contacts - 1
        best, times = self.job.peaks
        if self.arrival >= 0 or self.n <= last or not best[last] > 0:
            return
        if start.f[last + 1] < _PASSED * best[last] and (last == 0 or best[last] >= _WAVE * best[last - 1]):
            self.arrival = float(times[last])
            if self.until == math.inf:
                self.until = max(self.duration + 3 * self.arrival, self.time)

    # ---------------------------------------------------------------- peaks and samples

    def find_peak(self, start: _End, finish: _End, size: float, j: int) -> None:
        """Compute the maximum of a contact force within the step, if it may be the greatest so far.

        Repeated steps end at the time at which its slope vanishes, from cubic interpolation of the force.
        """
        best = self.job.peaks[:, j]
        low, f0, r0 = 0.0, float(start.f[j + 1]), size * float(start.slope[j])
        high, f1, r1 = 1.0, float(finish.f[j + 1]), size * float(finish.slope[j])
        share = low + (high - low) * top(r0, r1, f1 - f0)
        if max(f0, f1) + 0.25 * (r0 - r1) <= best[0] - _NEARLY * abs(best[0] + self.static[j]):
            return
        reach = len(self.job.method.nodes) + 2
        first, last = max(j - reach, 0), min(j + reach + 1, self.n)
        near, after = max(j - 1, 0), min(j + 2, self.n)
        whole = np.zeros(self.bodies + 2)
        for _ in range(_MOST_TURNS):
            time = self.time + share * size
            x, v, _impulses = self.attempt(start, share * size, time, first, last)
            self.evaluations += len(self.job.method.nodes)
            f, _powers, raw = self.forces(x, v, near, after)
            whole[near + 1 : after + 1] = f
            here, slope = float(f[j - near]), 0.0
            if raw[j - near] > 0:
                slope = size * float(self.slopes(x, v, whole, j, j + 1, time)[0])
            if slope > 0:
                low, f0, r0 = share, here, slope
            else:
                high, f1, r1 = share, here, slope
            following = low + (high - low) * top((high - low) * r0, (high - low) * r1, f1 - f0)
            left = following - share
            if abs(left) < _NEAR or high - low < _NEAR:
                if here + 0.5 * slope * left > best[0]:
                    best[:] = here + 0.5 * slope * left, time + left * size
                return
            share = following
        if here > best[0]:
            best[:] = here, time

    def sample(self, start: _End, end: float) -> None:
        """Store the states at the requested times up to the end of the step."""
        job = self.job
        while self.next_sample < len(job.times) and job.times[self.next_sample] <= max(end, self.time):
            time = float(job.times[self.next_sample])
            x, v = start.x, start.v
            if time > self.time:
                x, v, _ = self.attempt(start, time - self.time, time, 0, self.n)
            row = job.samples[self.next_sample]
            row[0], row[1], row[2, :-1] = x, v, self.forces(x, v, 0, self.bodies)[0] + self.static
            self.next_sample += 1


def _power(d: FloatArray, q: float) -> FloatArray:
    """The power q of d, by roots where possible: they are equal to the last bit everywhere."""
    if q == 0.25:
        return np.asarray(np.sqrt(np.sqrt(d)))
    return np.ones_like(d) if q == 0 else np.sqrt(d) if q == 0.5 else np.asarray(d**q)


def root(d0: float, d1: float, m0: float, m1: float) -> float:
    """Root in [0, 1] of the cubic with values d0, d1 of opposite signs and slopes m0, m1 at the ends."""
    c, e = 3 * (d1 - d0) - 2 * m0 - m1, m0 + m1 - 2 * (d1 - d0)
    low, high, at = 0.0, 1.0, d0 / (d0 - d1)
    for _ in range(6):
        value = d0 + at * (m0 + at * (c + at * e))
        slope = m0 + at * (2 * c + at * 3 * e)
        low, high = (at, high) if value * d0 > 0 else (low, at)
        at = at - value / slope if slope else -1.0
        if not low <= at <= high:
            at = (low + high) / 2
    return at


def top(r0: float, r1: float, rise: float) -> float:
    """Place in (0, 1) of the maximum of the cubic that rises by ``rise``, with slopes r0 > 0 and r1 <= 0 at the ends."""
    b, c = 6 * rise - 4 * r0 - 2 * r1, 3 * (r0 + r1) - 6 * rise
    square = b * b - 4 * c * r0
    at = 2 * r0 / (math.sqrt(square) - b) if square > 0 and math.sqrt(square) > b else r0 / (r0 - r1)
    return at if 0.0 < at < 1.0 else 0.5
