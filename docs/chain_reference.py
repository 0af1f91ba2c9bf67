"""Random chains of mixed granules in scaled units, and their motion by SciPy's DOP853 with steps that end at kinks.

The reference shares no code with the engine. Every contact is open, acting or cut off; its force is smooth until that
changes, which ends a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853
from scipy.optimize import brentq

import shockwave as sw
from shockwave.simulation.assembly import Assembly
from shockwave.simulation.problem import ChainProblem

Array = npt.NDArray[np.float64]

OPEN, ACTING, CUT = range(3)
# Forces and overlaps below this count as zero in the search for changes.
ZERO = 1e-13
# Number of intervals of a step in which changes and peaks are sought.
PARTS = 8
# Relative and absolute tolerance of the reference.
RTOL, ATOL = 1e-12, 1e-14
# Precision of the time of a peak; the force is flat there.
PRECISION = 3e-8
GOLDEN = (math.sqrt(5) - 1) / 2


def random_chain(seed: int, most: int = 200) -> Assembly:
    """A chain of 2 to ``most`` granules with any of the features."""
    draw = np.random.default_rng(seed)
    count = round(2 * (most / 2) ** draw.random())
    masses = [
        np.ones(count),
        np.exp(draw.normal(0, 0.8, count)),
        np.where(np.arange(count) % 2, np.exp(draw.uniform(-2.5, 1)), 1.0),
        np.exp(draw.uniform(-2, 2) * np.arange(count) / count),
        np.where(np.arange(count) == draw.integers(count), np.exp(draw.uniform(-4, 3)), 1.0),
    ][draw.integers(5)]
    wall = bool(draw.random() < 0.6)
    contacts = count if wall else count - 1
    exponent = 1.5 if draw.random() < 0.6 else float(np.exp(draw.uniform(math.log(1.05), math.log(6))))
    stiffnesses = np.exp(draw.normal(0, 0.5 * draw.integers(2), contacts))
    if wall:
        stiffnesses[-1] *= np.exp(draw.uniform(-1.5, 1.5))
    overlaps = [
        np.zeros(contacts),
        (np.exp(draw.uniform(math.log(1e-3), math.log(1e2))) / stiffnesses) ** (1 / exponent),
        -np.where(draw.random(contacts) < 0.4, np.exp(draw.uniform(-4, 1.5, contacts)), 0.0),
    ][draw.choice(3, p=[0.5, 0.3, 0.2])]
    damped = draw.random() < 0.5
    damping = damped * np.exp(draw.uniform(math.log(0.02), math.log(2))) * stiffnesses ** draw.integers(2)
    spring, dashpot = (0.0, 0.0) if wall or draw.random() < 0.8 else np.exp(draw.normal(size=2)) * (1, damped)
    force, velocity = None, 0.0
    if draw.random() < 0.6:
        rise, decay = draw.choice([0.5, 1, 2]), draw.choice([0.5, 1, 2, 5])
        profile = sw.PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=draw.uniform(1.5, 6))
        force = ChainProblem(profile, float(np.exp(draw.uniform(math.log(0.1), math.log(6)))), 1.0)
    else:
        velocity = float(np.exp(draw.uniform(-0.5, 0.5)))
        masses[0] *= np.exp(draw.uniform(-1.5, 2))
        overlaps[0] = min(overlaps[0], 0.0)
    return Assembly(
        inverse_masses=1 / masses,
        stiffnesses=stiffnesses,
        overlaps=overlaps,
        exponent=exponent,
        fixed_wall=wall,
        damping=damping,
        damping_power=float([0.0, exponent - 1, 0.25][draw.integers(3)]),
        end_stiffness=float(spring),
        end_damping=float(dashpot),
        force=force,
        velocity=velocity,
    )


class Reference(NamedTuple):
    """Greatest forces minus static ones, their times, and the velocities at the end."""

    forces: Array
    times: Array
    velocities: Array


def reference(chain: Assembly, until: float) -> Reference:
    """The motion from rest to ``until``."""
    return _Reference(chain).run(until)


class _Reference:
    def __init__(self, chain: Assembly) -> None:
        self.chain = chain
        self.count, self.contacts = len(chain.inverse_masses), len(chain.overlaps)
        self.static = chain.stiffnesses * np.maximum(chain.overlaps, 0.0) ** chain.exponent
        self.damped = bool(chain.damping.any())
        self.mode = np.where(chain.overlaps < 0, OPEN, ACTING)
        self.best, self.times = np.zeros((2, self.contacts))

    def contact(self, time: float, y: Array) -> tuple[Array, Array, Array]:
        """Forces minus static ones of acting contacts, overlaps and closing velocities."""
        chain, n, p = self.chain, self.count, self.chain.exponent
        x, v = y[:n].copy(), y[n:].copy()
        if chain.force is not None:
            path, impulse = chain.force.free(time)
            x[0] += chain.inverse_masses[0] * path
            v[0] += chain.inverse_masses[0] * impulse
        change, w = (np.append(each[:-1] - each[1:], each[-1])[: self.contacts] for each in (x, v))
        d = chain.overlaps + change
        closed = np.maximum(d, 0.0)
        strain = np.where(d > 0, change, 0.0) / np.where(chain.overlaps > 0, chain.overlaps, 1.0)
        static = chain.overlaps > 0
        with np.errstate(invalid="ignore"):
            elastic = np.where(static, self.static * np.expm1(p * np.log1p(strain)), chain.stiffnesses * closed**p)
        force = np.where(d > 0, elastic, -self.static)
        if self.damped:
            force = force + chain.damping * (1.0 if chain.damping_power == 0 else closed**chain.damping_power) * w
        return force, d, w

    def forces(self, time: float, y: Array) -> Array:
        return np.where(self.mode == ACTING, self.contact(time, y)[0], -self.static)

    def rates(self, time: float, y: Array) -> Array:
        chain, n = self.chain, self.count
        push = np.zeros(n + 1)
        push[1 : self.contacts + 1] = self.forces(time, y)
        if not chain.fixed_wall:
            x, v = y[:n], y[n:]
            late = chain.force.free(time) if n == 1 and chain.force is not None else (0.0, 0.0)
            push[n] = chain.end_stiffness * (x[-1] + late[0]) + chain.end_damping * (v[-1] + late[1])
        return np.concatenate((y[n:], chain.inverse_masses * (push[:-1] - push[1:])))

    def margins(self, time: float, y: Array) -> Array:
        """Negative for a contact that is to change."""
        force, d, _ = self.contact(time, y)
        if not self.damped:
            return np.where(self.mode == OPEN, -d, d + ZERO)
        total = force + self.static + ZERO
        cut = np.where(d > 0, 2 * ZERO - total, 1.0)
        return np.where(self.mode == OPEN, -d, np.where(self.mode == ACTING, total, cut))

    def run(self, until: float) -> Reference:
        chain = self.chain
        y, time, size = np.zeros(2 * self.count), 0.0, 1e-3
        y[self.count] = chain.velocity
        stops = [stop for stop in (chain.force.stops if chain.force else ()) if stop < until]
        for stop in (*stops, until):
            while time < stop:
                solver = DOP853(
                    self.rates, time, y, stop, rtol=RTOL, atol=ATOL, first_step=min(size, stop - time), max_step=1.0
                )
                changed = False
                while solver.status == "running" and not changed:
                    assert solver.step() is None
                    time, y, changed = self.follow(solver)
                size = 1e-4 if changed else solver.h_abs
        velocities = y[self.count :].copy()
        if chain.force is not None:
            velocities[0] += chain.inverse_masses[0] * chain.force.free(until)[1]
        return Reference(self.best, self.times, velocities)

    def follow(self, solver: DOP853) -> tuple[float, Array, bool]:
        """The end of a step, or the first change of a contact in it; log the peaks until then."""
        dense = solver.dense_output()
        times = np.linspace(solver.t_old, solver.t, PARTS + 1)
        margins = np.array([self.margins(time, dense(time)) for time in times])
        end, which = solver.t, -1
        for row in range(1, PARTS + 1):
            for j in np.flatnonzero((margins[row] < 0) & (margins[row - 1] >= 0)):
                at = self.change(dense, times[row - 1], times[row], j)
                if at < end or which < 0:
                    end, which = at, int(j)
            if which >= 0:
                break
        self.log(dense, solver.t_old, end)
        y = dense(end) if which >= 0 else solver.y
        _, d, w = self.contact(end, y)
        if which >= 0:
            closes = self.mode[which] == OPEN
            acts = (not self.damped or w[which] > 0) if closes else self.mode[which] == CUT
            self.mode[which] = ACTING if acts else CUT if self.damped and (closes or d[which] > 0) else OPEN
        opened = (self.mode == CUT) & (d < 0)
        self.mode[opened] = OPEN
        now = self.forces(end, y)
        self.best, self.times = np.where(now > self.best, [now, np.full(self.contacts, end)], [self.best, self.times])
        return end, y, which >= 0 or bool(opened.any())

    def change(self, dense: Callable[[float], Array], low: float, high: float, j: int) -> float:
        def margin(time: float) -> float:
            return float(self.margins(time, dense(time))[j])

        return float(brentq(margin, low, high, xtol=1e-15, rtol=1e-15)) if margin(low) > 0 else low

    def log(self, dense: Callable[[float], Array], begin: float, end: float) -> None:
        times = np.linspace(begin, end, PARTS + 1)
        forces = np.array([self.forces(time, dense(time)) for time in times])
        tops = forces.argmax(axis=0)
        for j in np.flatnonzero((forces.max(axis=0) > (1 - 1e-3) * self.best) & (forces.max(axis=0) > 0)).tolist():

            def force(time: float, j: int = j) -> float:
                return float(self.forces(time, dense(time))[j])

            low, high = times[max(tops[j] - 1, 0)], times[min(tops[j] + 1, PARTS)]
            while high - low > PRECISION:  # golden-section search
                one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
                low, high = (low, other) if force(one) > force(other) else (one, high)
            for time in ((low + high) / 2, times[tops[j]]):
                if force(time) > self.best[j]:
                    self.best[j], self.times[j] = force(time), time
