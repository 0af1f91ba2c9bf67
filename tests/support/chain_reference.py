"""An independent integration of any chain by DOP853 of SciPy.

It integrates all granules of the chain, restarts at the kinks of the shock and wherever a contact opens, closes or is
cut off, and knows nothing of windows, equilibria or free-particle displacements.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853, DenseOutput
from scipy.optimize import brentq

import shockwave as sw
from shockwave.scene.layout import Layout

# Relative and absolute tolerance of DOP853.
RTOL = 1e-13
ATOL = 1e-15
# Longest step, in characteristic times.
STEP = 0.3
# Samples of a step in which a maximum is looked for.
SAMPLES = 9
Array = NDArray[np.float64]


class Reference:
    """Equations of motion of a chain, in units of a time, a mass and a length."""

    def __init__(self, excitation: sw.Shock | sw.Impact, chain: sw.Chain, unit: float) -> None:
        layout = Layout.of(chain, excitation)
        wall = chain.end
        self.movable = wall is not None and wall.mass is not None
        masses = np.append(layout.masses, wall.mass) if self.movable else layout.masses
        self.mass, self.unit = float(np.median(layout.masses)), unit
        self.length = max(float(np.abs(layout.overlaps).max()), 1e-6)
        force = self.mass * self.length / unit**2
        self.force = force
        self.rates = self.mass / masses
        self.exponents, self.powers = layout.pairs.exponents, layout.damping_powers
        self.stiffnesses = layout.pairs.stiffnesses * self.length**self.exponents / force
        self.damping = layout.damping_coefficients * self.length ** (self.powers + 1) / unit / force
        self.damped = bool(self.damping.any())
        self.offsets = layout.overlaps / self.length
        self.static = layout.static_forces / force
        self.spring = wall.stiffness * self.length / force if wall else 0.0
        self.dashpot = wall.damping * self.length / unit / force if wall else 0.0
        self.fixed = wall is not None and not self.movable
        self.shock = excitation if isinstance(excitation, sw.Shock) else None
        self.weight = chain.gravity * masses[0] / force if isinstance(excitation, sw.Impact) else 0.0
        self.start = np.zeros(2 * len(masses))
        self.start[len(masses)] = layout.velocity * unit / self.length

    def contacts(self, states: Array) -> tuple[Array, Array]:
        """Total contact forces, and what changes its sign at their kinks, for states of shape (2 bodies, ...)."""
        bodies = len(self.rates)
        ends = np.zeros((2, bodies + self.fixed, *states.shape[1:]))
        ends[:, :bodies] = states.reshape(2, bodies, *states.shape[1:])
        column = (-1,) + (1,) * (states.ndim - 1)
        overlap, closing = ends[:, :-1] - ends[:, 1:]
        overlap += self.offsets.reshape(column)
        closed = np.maximum(overlap, 0.0)
        force = self.stiffnesses.reshape(column) * closed ** self.exponents.reshape(column)
        if self.damped:
            force += self.damping.reshape(column) * closed ** self.powers.reshape(column) * closing
        acts = overlap > 0
        return np.where(acts, np.maximum(force, 0.0), 0.0), np.where(acts & (force < 0), force, overlap)

    def __call__(self, time: float, state: Array) -> Array:
        bodies = len(self.rates)
        excess = self.contacts(state)[0] - self.static
        net = np.zeros(bodies)
        net[: len(excess)] -= excess
        net[1:] += excess[: bodies - 1]
        net[0] += self.weight
        if self.shock is not None and time * self.unit < self.shock.duration:
            net[0] += float(self.shock.profile.force(time * self.unit / self.shock.rise_time)) * (
                self.shock.peak_force / self.force
            )
        if self.movable:
            net[-1] -= self.spring * state[bodies - 1] + self.dashpot * state[-1]
        return np.concatenate((state[bodies:], net * self.rates))

    def greatest(self, end: float, looser: float = 1.0) -> tuple[Array, Array]:
        """Greatest dynamic parts of the forces [N] and their times [s], from 0 to ``end`` [s]."""
        best, when = self.contacts(self.start)[0], np.zeros(len(self.static))
        for dense, sampled in self.steps(end, looser):
            forces = self.contacts(dense(sampled))[0]
            for contact in np.flatnonzero(forces.max(axis=1) > best * (1 - 1e-3)):
                at, force = self._top(dense, sampled, forces[contact], contact)
                if force > best[contact]:
                    best[contact], when[contact] = force, at
        return (best - self.static) * self.force, when * self.unit

    def history(self, times: Array) -> tuple[Array, Array, Array]:
        """Total contact forces [N], displacements [m] and velocities [m/s], a row for each of ``times`` [s]."""
        states = np.repeat(self.start[:, None], len(times), axis=1)
        for dense, sampled in self.steps(float(times[-1])):
            inside = (times > sampled[0] * self.unit) & (times <= sampled[-1] * self.unit * (1 + 1e-14))
            states[:, inside] = dense(times[inside] / self.unit)
        bodies, forces = len(self.rates), self.contacts(states)[0] * self.force
        return forces.T, self.length * states[:bodies].T, self.length / self.unit * states[bodies:].T

    def steps(self, end: float, looser: float = 1.0) -> Iterator[tuple[DenseOutput, Array]]:
        """Steps to ``end`` [s], which end on kinks: their dense output, and times within them."""
        control = {"max_step": STEP, "rtol": looser * RTOL, "atol": looser * ATOL}
        stops = [end]
        if self.shock is not None:
            stops += [point * self.shock.rise_time for point in self.shock.profile.breakpoints]
        times = sorted({stop / self.unit for stop in stops if 0 <= stop <= end} | {0.0})
        state, size = self.start, None
        for begin, stop in pairwise(times):
            time, kink, struck = begin, stop, -1
            while time < stop:
                step = None if size is None else min(size, kink - time)
                solver = DOP853(self, time, state, kink, first_step=step, **control)
                while solver.status == "running":
                    before = solver.y
                    solver.step()
                    dense, sampled = solver.dense_output(), np.linspace(solver.t_old, solver.t, SAMPLES)
                    signs = self.contacts(dense(sampled))[1]
                    if kink == stop and (found := self._kink(dense, sampled, signs, struck)):
                        # once more, to the kink
                        state, (time, kink, struck), size = before, (solver.t_old, *found), solver.step_size
                        break
                    struck = -1 if kink == stop else struck
                    yield dense, sampled
                else:
                    state, time, size, kink = solver.y, kink, solver.h_abs, stop

    def _kink(self, dense: DenseOutput, times: Array, signs: Array, struck: int) -> tuple[float, int] | None:
        """The first time within a step at which a contact opens, closes or is cut off, and the contact."""
        changes = signs[:, :-1] * signs[:, 1:] < 0
        changes[struck, :2] &= struck < 0
        if not changes.any():
            return None
        place = int(changes.any(axis=0).argmax())
        found = []
        for contact in np.flatnonzero(changes[:, place]).tolist():
            interval = float(times[place]), float(times[place + 1])
            sign = lambda time, own=contact: float(self.contacts(dense(np.array([time])))[1][own, 0])  # noqa: E731
            found.append((brentq(sign, *interval, xtol=1e-14, rtol=1e-14, disp=False), contact))
        time, contact = min(found)
        return (time, contact) if times[0] < time < times[-1] else None

    def _top(self, dense: DenseOutput, times: Array, forces: Array, contact: int) -> tuple[float, float]:
        """Time and value of the maximum of a force within a step, by two parabolas."""
        top = int(forces.argmax())
        found = float(times[top]), float(forces[top])
        step = times[1] - times[0]
        for _ in range(3):
            near = np.clip(found[0], times[0] + step, times[-1] - step) + step * np.array([-1.0, 0.0, 1.0])
            left, middle, right = self.contacts(dense(near))[0][contact].tolist()
            bend = left - 2 * middle + right
            if bend >= 0:
                break
            time = float(np.clip(near[1] + step * (left - right) / (2 * bend), times[0], times[-1]))
            force = float(self.contacts(dense(np.array([time])))[0][contact, 0])
            if force >= found[1]:
                found = time, force
            step /= 30
        return found
