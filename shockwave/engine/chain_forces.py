"""Forces of the contacts of a chain of mixed granules, with NumPy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Protocol

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_arrays import Job
from shockwave.engine.cubic_interpolation import root
from shockwave.scene.chain import HERTZ

#: Smaller overlaps count as zero: arithmetic with subnormal numbers is slow.
MIN_OVERLAP = 1e-60
#: Gap of a contact that does not exist.
FAR = 1e100
#: Impulse error of a step with a kink of the force, over the force and the length of the shorter part.
KINK = 0.1
#: Impulse error of the step in which a contact closes, over its length and the elastic or viscous force at its end.
ELASTIC = 1e-3
VISCOUS = 8e-3
#: Fraction of the tolerance within which the closing of a contact with a dashpot is located.
LOCATED = 0.1
#: Rounding error of an overlap, relative to positions and displacements.
ROUNDING = 1e-14
#: Fraction of the tolerance that a kink may use.
KINK_SHARE = 0.1
#: Smallest step, relative to the time and to the first step.
MIN_STEP = 1e-15
#: Parts of a step at whose ends the mode of a contact with rate is examined, and the largest number of changes of a
#: mode at one time.
PARTS = 2
#: Fraction of the allowed delay of the end of a mode with rate: the force may be greatest there, with a corner.
SHARP = 0.25
MOST_CHANGES = 4
#: Pieces of the loading curves with rate while the strength doubles, and the greatest logarithm of the closing
#: velocity over that above which it grows: a strain rate of 1e9/s.
FINER = 128.0
FASTEST = 27.6
#: Change of overlap and closing velocity, relative to the overlap and to the greatest velocity, for the slope of the
#: force of a plugin: the error of its central difference is about the square, and that of rounding 1e-16 over it.
LAW_CHANGE = 1e-5

#: Half of the time over which the applied force is averaged, over the longest step.
INSTANT = 1e-4
#: The wave has arrived when the forces at the last two contacts are below this fraction of their maxima ...
PASSED = 0.99
#: ... if the last maximum is at least this fraction of the one before.
WAVE = 1e-3
#: ... and this fraction of the static force, whose rounding errors make smaller ones.
NOISE = 1e-12


@frozen(eq=False)
class End:
    """State at one end of a step.

    ``u``, ``d`` and ``w`` are changes of the overlaps, overlaps and closing velocities; ``f``, ``raw`` and ``slope``
    are forces minus static ones (that of contact j in element j + 1, the weight of a striker in element 0), total
    forces before they are cut off, and their time derivatives, zero for an open contact; ``powers`` are those of the
    damping, and ``a`` the accelerations of the bodies due to the contacts, zero for the body beyond.
    """

    x: FloatArray
    v: FloatArray
    u: FloatArray
    d: FloatArray
    w: FloatArray
    f: FloatArray
    raw: FloatArray
    powers: FloatArray
    slope: FloatArray
    a: FloatArray


class Flow(Protocol):
    """The modes of elastic-plastic contacts: `chain_modes.Plasticity`, which other chains do not load.

    A force has the terms ``offset`` and ``tangent`` times the change of the overlap besides that of Hertz; ``elastic``
    is the column of a contact without modes.
    """

    offset: FloatArray
    tangent: FloatArray
    elastic: FloatArray

    def stiffest(self, force: float) -> FloatArray:
        """Largest stiffness k of each contact at forces up to this one, or as now."""
        ...

    def forces(self, f: FloatArray, motion: Sequence[FloatArray], low: int) -> None:
        """Replace the forces minus static ones of contacts that flow along a curve."""
        ...

    def add_losses(self, start: End, finish: End, span: tuple[float, float], stages: FloatArray) -> None:
        """Add the work on contacts that flow with rate, from time and size of a step and forces at its stages."""
        ...

    def rates(self, slope: FloatArray, motion: Sequence[FloatArray], low: int) -> None:
        """Replace the time derivatives of the forces of contacts that flow."""
        ...

    def released_energies(self, d: FloatArray, forces: FloatArray) -> FloatArray:
        """Energies that all contacts release from their overlaps, less residual ones, and forces on."""
        ...

    def change_modes(self, start: End, time: float) -> bool:
        """Change the modes that end at the beginning of a step; whether there are any."""
        ...

    def turns(self, start: End, time: float) -> float:
        """Least size of a step that ends after a contact turns, of those whose flow does not depend on the rate."""
        ...

    def end_of_modes(self, start: End, finish: End, time: float, size: float, share: float) -> float:
        """Fraction of the step at which it should end because a mode does; ``share`` if it need not."""
        ...


def greatest_overlap(start: End, finish: End, size: float, tolerance: float, contacts: npt.NDArray[np.bool_]) -> float:
    """Fraction of a step at which an overlap of these ``contacts`` is greatest, where the history changes; else 1.

    A step need not be divided if the overlap at its beginning or at its end is the greatest to a relative difference of
    ``tolerance``.
    """
    turns = np.flatnonzero((start.w > 0) & (finish.w < 0) & (finish.d > 0) & contacts)
    before, after, overlap = start.w[turns], -finish.w[turns], finish.d[turns]
    misses = np.minimum(before, after) ** 2 / (before + after) * size > tolerance * overlap
    return float((before / (before + after))[misses].min(initial=1.0))


def has_arrived(start: End, best: FloatArray, last: int, static: float) -> bool:
    """Whether the wave has passed the contact ``last``, from present and greatest forces minus its ``static`` one.

    A wall on a stiff spring oscillates ahead of the wave, which has then not passed the contact before.
    """
    before = max(last - 1, 0)
    passed = start.f[before + 1 : last + 2] < PASSED * best[before : last + 1]
    tall = best[last] > 0 and best[last] >= NOISE * static and (last == 0 or best[last] >= WAVE * best[last - 1])
    return bool(tall and passed.all())


def is_over(start: End, contacts: int) -> bool:
    """Whether no contact force acts and none can follow: beyond the last contact a granule flies off freely."""
    return not start.f.any() and not (start.w[:contacts] > 0).any()


def kink_error(size: float, force: FloatArray | float, idle: FloatArray | float) -> FloatArray:
    """Impulse error of a step if no force acts during the fraction ``idle`` of it."""
    return np.asarray(KINK * size * force * np.minimum(1.0, idle / np.maximum(1 - idle, 1e-300)))


class Contacts:
    """The contacts of a `Job`, and the applied force.

    A contact with a dashpot acts only if ``on``: its force jumps when it closes, where steps end.
    """

    def __init__(self, job: Job) -> None:
        self.job = job
        settings = self.settings = job.settings
        self.tolerance, self.until, self.duration = settings.tolerance, settings.until, settings.duration
        self.first, self.longest, self.weight = settings.first, settings.longest, settings.weight
        self.end_stiffness, self.end_damping = settings.end_stiffness, settings.end_damping
        self.inverse, self.k, self.gap, self.base, self.root, self.static, self.c = job.chain[:7]
        self.reach = job.chain[7:]
        self.p, self.q = job.exponents
        self.hertz = bool((self.p == HERTZ).all())
        self.bodies, self.contacts = len(self.inverse), settings.contacts
        self.mobile = np.append(self.inverse, 0.0)
        self.guided = settings.guided
        self.mobile[0] *= not self.guided  # contacts do not move a body whose path is given
        # a flat without mass, whose displacement is in the place of its velocity, and the force over Z is its rate
        self.flat = self.bodies - 1 if job.bar else -1
        self.both = job.switches[0]
        self.damped = settings.damped
        self.viscous = (self.c != 0) | job.by_law
        self.loaded = bool(self.base.any())
        self.by_law = job.by_law
        self.jumps = self.damped & (self.q == 0) & ~job.by_law
        self.on = np.ones(self.bodies, dtype=bool)
        self.flow: Flow | None = None
        self.state = np.empty(0) if job.law is None else job.law.initial_state()

    def end_of(self, x: FloatArray, v: FloatArray, time: float, n: int) -> End:
        """Everything at one end of a step, of the first n contacts."""
        forces, powers, raw = self.forces(x, v, 0, n)
        whole = np.zeros(self.bodies + 2)
        whole[0], whole[1 : n + 1] = self.weight, forces
        (u, d), w = self.overlaps(x, 0, n), self.closing_velocities(v, 0, n)
        a = self.mobile[: n + 1] * (whole[: n + 1] - whole[1 : n + 2])
        if 0 < self.flat <= n:
            w[self.flat - 1] -= a[self.flat]
        slope = np.where(raw > 0, self.rates(d, w, self.closing_accelerations(a, time)), 0.0)
        return End(x, v, u, d, w, whole, raw, powers, slope, a)

    def overlaps(self, x: FloatArray, low: int, high: int) -> tuple[FloatArray, FloatArray]:
        """Overlaps of the contacts from ``low`` to ``high`` - 1: relative to the static overlaps, and in all."""
        stretch = x[low:high] - x[low + 1 : high + 1]
        stretch += self.gap[low:high]
        return stretch, stretch + self.base[low:high] if self.loaded else stretch

    def closing_velocities(self, v: FloatArray, low: int, high: int) -> FloatArray:
        """Closing velocities of some contacts; of that with the flat of a bar, without the velocity of the flat."""
        w = v[low:high] - v[low + 1 : high + 1]
        if low < self.flat <= high:
            w[self.flat - 1 - low] = v[self.flat - 1]
        return np.asarray(w)

    def slip(self, d: FloatArray, low: int) -> float:
        """Factor 1 + c d^q/Z by which the flat of a bar reduces forces of contacts from ``low`` on."""
        at = self.flat - 1
        overlap, rate = float(d[at - low]), float(self.c[at] * self.inverse[self.flat])
        return 1 + rate * overlap ** float(self.q[at]) if overlap > MIN_OVERLAP else 1.0

    def forces(self, x: FloatArray, v: FloatArray, low: int, high: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Forces minus static ones, powers of the damping, and forces before they are cut off, of some contacts."""
        part = slice(low, high)
        static = self.static[part]
        stretch, d = self.overlaps(x, low, high)
        closed = d > MIN_OVERLAP
        powers = np.zeros(high - low)
        if self.damped or self.flow:
            w = self.closing_velocities(v, low, high)
        inside = np.where(closed, d, 1.0)
        elastic = self.elastic(stretch, d, inside, part)
        if self.flow:
            elastic = elastic + (self.flow.offset[part] + self.flow.tangent[part] * stretch)
        raw = f = np.where(closed, elastic, -static)
        if self.flow:
            self.flow.forces(f, (stretch, d, w), low)
        if self.damped:
            # only the dashpot of a contact that is off does not act: its force would jump within the step
            jumps = self.q[part] == 0
            viscous = self.c[part] * _powers(inside, self.q[part]) * w
            raw = f + np.where(jumps | closed, viscous, 0.0)
            at, meets_flat = self.flat - 1 - low, low < self.flat <= high
            if meets_flat:
                raw[at] /= self.slip(d, low)  # a constant force on the flat balances the static one
            total = np.maximum(np.where(np.where(jumps, self.on[part], closed), raw, f), -static)
            if meets_flat:
                w[at] -= self.mobile[self.flat] * total[at]
            powers = powers + (total - f) * w
            f = total
            if self.flat > 0 and high == self.bodies:
                powers[-1] = self.mobile[self.flat] * f[-2] ** 2
        if self.job.law is not None:
            here, law = self.by_law[part], self.law_forces(d, w, low, high)
            raw, f, powers = (np.where(here, law, other) for law, other in ((law, raw), (law, f), (law * w, powers)))
        if high == self.bodies and (self.end_stiffness or self.end_damping):
            f[-1] = self.end_stiffness * x[-2] + self.end_damping * v[-2]
            powers[-1] = self.end_damping * v[-2] * v[-2]
        return f, powers, raw + static if self.loaded else raw

    def elastic(self, stretch: FloatArray, d: FloatArray, inside: FloatArray, part: slice) -> FloatArray:
        """Elastic forces minus static ones of some contacts; ``inside`` are the overlaps, or 1 where they are open."""
        k, p, base, root = self.k[part], self.p[part], self.base[part], np.sqrt(inside)
        if not self.loaded:
            return np.asarray(k * (inside * root if self.hertz else _powers(inside, p)))
        hertz = k * (stretch * (d + root * self.root[part] + base) / (root + self.root[part]))
        if self.hertz:
            return np.asarray(hertz)
        strain = np.where(d > MIN_OVERLAP, stretch, 0.0) / np.where(base > 0, base, 1.0)
        strain = _libm(lambda each, power: math.expm1(power * math.log1p(each)), strain, p)
        changes = np.where(p == HERTZ, hertz, self.static[part] * strain)
        return np.asarray(np.where(base > 0, changes, k * _powers(inside, p)))

    def law_forces(self, d: FloatArray, w: FloatArray, low: int, high: int) -> FloatArray:
        """Forces of a plugin's contact law for some contacts, from their overlaps and closing velocities.

        The law has the state and the properties of all contacts, so it is evaluated for all: the others as if open.
        """
        assert self.job.law is not None
        every, forces = np.zeros((2, self.bodies)), np.zeros(self.bodies)
        every[:, low:high] = d, w
        overlaps, velocities = (every * self.by_law)[:, : self.contacts]
        forces[: self.contacts] = self.job.law.force(overlaps, velocities, self.state)
        return np.where(d > MIN_OVERLAP, forces[low:high], 0.0)

    def closing_accelerations(self, a: FloatArray, time: float, low: int = 0) -> FloatArray:
        """Closing accelerations of contacts from ``low`` on, from those of the bodies due to the contacts."""
        if low == 0:
            a = a.copy()
            a[0] += self.inverse[0] * self.applied_force(time)
        if 0 < self.flat - low < len(a):  # it has a velocity in this place
            a = np.where(np.arange(len(a)) == self.flat - low, 0.0, a)
        return np.asarray(a[:-1] - a[1:])

    def rates(self, d: FloatArray, w: FloatArray, closing: FloatArray, low: int = 0) -> FloatArray:
        """Time derivatives of the forces of contacts from ``low`` on before they are cut off; zero if they are open.

        The arguments are overlaps, closing velocities, and the time derivatives of the latter.
        """
        high = low + len(d)
        part, closed = slice(low, high), d > MIN_OVERLAP
        inside, p, q = np.where(closed, d, 1.0), self.p[part], self.q[part]
        slope = p * self.k[part] * _powers(inside, p - 1) * w
        if self.damped:
            slope = slope + self.c[part] * _powers(inside, q) * (q / inside * w * w + closing)
        if low < self.flat <= high:
            slope[self.flat - 1 - low] /= self.slip(d, low)
        if self.flow:
            self.flow.rates(slope, (d, w, closing), low)
        if self.job.law is not None:
            rate = np.abs(w) / inside + np.abs(closing) / self.job.scales[0, part]
            span = LAW_CHANGE / np.maximum(rate, 1e-300)
            after, before = (self.law_forces(d + side * w, w + side * closing, low, high) for side in (span, -span))
            slope = np.where(self.by_law[part], (after - before) / (2 * span), slope)
        return np.where(closed, slope, 0.0)

    def force_at(self, x: FloatArray, v: FloatArray, j: int, time: float, n: int) -> tuple[float, float]:
        """Force of a contact, of the first n, and its time derivative."""
        near, after = max(j - 1, 0), min(j + 2, n)
        whole = np.zeros(after - near + 2)
        whole[0] = 0.0 if near else self.weight
        whole[1:-1], _powers, raw = self.forces(x, v, near, after)
        at = j - near
        a = self.mobile[j : j + 2] * (whole[at : at + 2] - whole[at + 1 : at + 3])
        w = self.closing_velocities(v, j, j + 1) - (a[1] if j + 1 == self.flat else 0.0)
        rate = self.rates(self.overlaps(x, j, j + 1)[1], w, self.closing_accelerations(a, time, j), j)
        return float(whole[at + 1]), float(rate[0]) if raw[at] > 0 else 0.0

    def first_size(self, j: int, w: float) -> float:
        """Longest step after contact j has closed with the velocity w."""
        p, q, allowed = float(self.p[j]) + 1, float(self.q[j]) + 1, float(self.allowed_impulses(j + 1)[j])
        most = math.pow(allowed / (ELASTIC * self.k[j] * math.pow(w, p - 1)), 1 / p)
        if q == 1:
            return most
        return min(most, math.pow(allowed / (VISCOUS * self.c[j] * math.pow(w, q)), 1 / q))

    def first_rebound(self, start: End, finish: End, size: float) -> float:
        """Velocity of a striker when it leaves the chain within a step; 0 if it does not."""
        d0, w0, d1, w1 = (float(values[0]) for values in (start.d, start.w, finish.d, finish.w))
        if not (d0 >= 0 > d1 and finish.v[0] < 0):
            return 0.0
        flight = size * (1 - root(d0, size * w0, d1, size * w1))
        return float(finish.v[0] - self.inverse[0] * self.weight * flight)

    def closing_tolerance(self, x: FloatArray, w: FloatArray, time: float) -> FloatArray:
        """Tolerances of the overlaps at which contacts with a dashpot close."""
        n = len(w)
        velocity, overlap = self.job.scales[:, :n]
        most = np.minimum(velocity / np.maximum(self.both[:n] * self.c[:n], 1e-300), overlap)
        least = ROUNDING * (np.abs(x[:n]) + np.abs(x[1 : n + 1]) + time * np.abs(w))
        return np.asarray(np.maximum(most * (LOCATED * self.tolerance), least))

    def raise_scales(self, finish: End, n: int) -> None:
        """Raise the scales of the errors of n contacts to what was reached, or is expected next to it."""
        scales, reached = (
            self.job.scales,
            np.array((np.abs(finish.w), np.where(finish.d > 0, np.abs(finish.u), self.base[: len(finish.d)]))),
        )
        known = scales[:, : reached.shape[1]]
        np.maximum(known, reached, out=known)
        following = scales[:, 1:n]
        np.maximum(following, self.reach[:, 1:n] * scales[:, : n - 1], out=following)

    def allowed_impulses(self, n: int) -> FloatArray:
        """Impulses that change the closing velocities of the first n contacts by the tolerance."""
        return np.asarray(self.tolerance * self.job.scales[0, :n] / self.both[:n])

    def applied_force(self, time: float) -> float:
        """Applied force, from the difference of its impulse."""
        problem = self.job.problem
        if problem is None or time >= self.duration:
            return 0.0
        about = INSTANT * min(self.longest, self.duration)
        before, after = max(time - about, 0.0), min(time + about, self.duration)
        return float((problem.free(after)[1] - problem.free(before)[1]) / (after - before))


def _powers(d: FloatArray, powers: FloatArray) -> FloatArray:
    """Powers of d, by roots where possible: they are equal to the last bit everywhere."""
    roots = np.sqrt(d)
    values = np.where(powers == 0.5, roots, np.where(powers == HERTZ, d * roots, 1.0))
    values = np.where(powers == 0.25, np.sqrt(roots), values)
    others = np.flatnonzero((powers != 0) & (powers != 0.25) & (powers != 0.5) & (powers != HERTZ))
    if others.size:
        values[others] = _libm(math.pow, d[others], powers[others])
    return values


def _libm(function: Callable[[float, float], float], values: FloatArray, powers: FloatArray) -> FloatArray:
    """A function of the C library, as in the compiled code: the steps amplify a difference in the last digit."""

    def or_infinity(value: float, power: float) -> float:
        with suppress(OverflowError):
            return function(value, power)
        return math.inf

    return np.fromiter(map(or_infinity, values.tolist(), powers.tolist()), float, len(values))
