"""Stages of a step of a chain of mixed granules, with NumPy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_arrays import Job
from shockwave.engine.chain_forces import Contacts, End
from shockwave.engine.nystroem_tableaux import scaled_error

if TYPE_CHECKING:  # other methods do not need it
    from shockwave.engine.integrator_steps import IntegratorSteps


class Stages(Contacts):
    """Contacts that a method moves; ``n`` bodies are in the window, the others at rest."""

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        window = job.record.bodies if job.record else job.window
        whole = job.law is not None or job.integrator is not None
        self.n = self.bodies if whole else min(window, self.bodies)
        self.mobile[self.n :] = 0.0
        self.method, stages = job.method, len(job.method.nodes)
        # forces and accelerations, as those of `End`, and powers of the damping
        self.stages, self.stage_rates = np.zeros((stages, self.bodies + 2)), np.zeros((stages, self.bodies))
        self.powers = np.zeros((stages, self.bodies))
        self.stages[:, 0] = self.weight
        self.weighted = np.empty(0)
        self.integrator_steps = None
        if job.integrator is not None:
            from shockwave.engine.integrator_steps import IntegratorSteps

            self.integrator_steps = IntegratorSteps(self, job.integrator, job.progress.size)
            self.weighted = np.zeros((4, self.n))
        self.time, self.evaluations = job.progress.time, job.progress.evaluations
        self.driven = job.problem is not None and self.time < self.duration
        self.free = (0.0, 0.0) if job.problem is None or self.time == 0 else job.problem.free(self.time)

    def attempt(
        self, start: End, size: float, end: float, low: int, high: int
    ) -> tuple[FloatArray, FloatArray, list[float]]:
        """State after a step, of bodies low to high; valid at least one body per stage inside of ends within the chain.

        Also returns the impulses of the applied force at the stages, since the beginning of the step.
        """
        if self.integrator_steps is not None:
            return self.read(self.integrator_steps, start, size, end)
        method, h = self.method, size
        part = slice(low, high)
        x, v = start.x[part], start.v[part]
        whole_y, whole_z = start.x.copy(), start.v.copy()
        y, z = whole_y[part], whole_z[part]
        nodes, first, *later = method.columns
        coasting = x + nodes * h * v
        impulses = [0.0]
        self.stages[0], self.stage_rates[0, : self.n] = start.f, start.a[:-1]
        self.powers[0, : self.n] = start.powers
        # each acceleration is added at once to all sums that contain it, in the same order as in the compiled code
        sums = first * self.stage_rates[0, part]
        terms, row = np.empty_like(sums), 0
        for i, (c, column) in enumerate(zip(method.nodes[1:].tolist(), later, strict=True), start=1):
            self.move((y, z), (coasting[i], v), sums[row : row + 1 + method.damped], h, high)
            row += 1 + method.damped
            if c == 0:
                self.stage_rates[1, part] = h * self.jerks(start)[part]
                sums[row:] += np.multiply(column, self.stage_rates[1, part], out=terms[row:])
                impulses.append(0.0)
                continue
            if self.driven and low == 0:
                self.push(whole_y, whole_z, impulses, c * h, end if c == 1.0 else self.time + c * h)
            self.evaluate(i, whole_y, whole_z, low, high)
            left = sums[row:]
            left += np.multiply(column, self.stage_rates[i, part], out=terms[row:])
        # rows: those of position and velocity, then those of their errors
        self.weighted = sums[row:]
        self.move((y, z), (coasting[-1], v), self.weighted[:2], h, high)
        self.evaluations += method.evaluations
        if self.driven and low == 0:
            self.push(whole_y, whole_z, impulses, h, end)
        return whole_y, whole_z, impulses

    def evaluate(self, stage: int, x: FloatArray, v: FloatArray, low: int, high: int) -> None:
        """Set forces, accelerations and powers of the damping at a stage, of bodies low to high."""
        self.stages[stage, low + 1 : high + 1], powers, _ = self.forces(x, v, low, high)
        if self.damped:
            self.powers[stage, low:high] = powers
        f = self.stages[stage, low : high + 1]
        np.multiply(self.mobile[low:high], f[:-1] - f[1:], out=self.stage_rates[stage, low:high])

    def move(
        self,
        to: tuple[FloatArray, FloatArray],
        free: tuple[FloatArray, FloatArray],
        sums: FloatArray,
        h: float,
        high: int,
    ) -> None:
        """Set positions to those of free flight plus h^2 times the first sum, and velocities with h and the second.

        The flat of a bar, without mass, has its displacement in the place of its velocity.
        """
        np.add(free[0], h * h * sums[0], out=to[0])
        if len(sums) > 1:
            np.add(free[1], h * sums[1], out=to[1])
        if self.flat > 0 and high == self.bodies:
            to[0][-1] = to[1][-1]

    def jerks(self, start: End) -> FloatArray:
        """Time derivatives of the accelerations at the beginning of a step, of the bodies in the window."""
        slope = np.append(0.0, start.slope)
        return np.asarray(self.mobile[: self.n] * (slope[:-1] - slope[1:]))

    def read(
        self, steps: IntegratorSteps, start: End, size: float, end: float
    ) -> tuple[FloatArray, FloatArray, list[float]]:
        """`attempt` within the last step of an `Integrator`, and for the whole the forces at nodes with a weight."""
        (x, v), watched = steps.state(end), self.job.watched
        self.evaluations = float(steps.integrator.evaluations)
        is_part = steps.step is not None and end < steps.step.end
        if self.job.record or (is_part and not self.job.samples.size):
            return x, v, [0.0, 0.0]  # there are no integrals
        at_end = self.forces(x, v, 0, self.bodies)[0]
        self.stages[1:, 1:-1], self.stages[0] = 0.0, start.f
        acts = self.driven or start.f[1:-1][watched].any() or at_end[watched].any()
        impulses = [0.0]
        for i, c in enumerate(self.method.nodes[1:].tolist(), start=1):
            time = end if c == 1.0 else self.time + c * size
            if acts and self.method.weights[1, i]:
                self.stages[i, 1:-1] = self.forces(*steps.state(time), 0, self.bodies)[0]
            impulses.append(self.shift(size, time)[1] if self.driven else 0.0)
        return x, v, [*impulses, impulses[-1]]

    def push(self, x: FloatArray, v: FloatArray, impulses: list[float], passed: float, time: float) -> None:
        """Add the motion of body 0 by the applied force within the step, and append its impulse to ``impulses``."""
        shift, impulse = self.shift(passed, time)
        impulses.append(impulse)
        x[0] += shift
        v[0] += self.inverse[0] * impulse

    def shift(self, passed: float, time: float) -> tuple[float, float]:
        """Displacement of body 0 by the applied force since the beginning of the step, and the impulse."""
        problem = self.job.problem
        assert problem is not None
        path, impulse = problem.free(time)
        return float(self.inverse[0]) * ((path - self.free[0]) - passed * self.free[1]), impulse - self.free[1]

    def error(self, size: float) -> float:
        """Largest error of the last attempt over the tolerance."""
        n, rates = self.n, self.weighted[2:].reshape(-1, 2, self.n)
        changes = np.zeros((*rates.shape[:2], n + 1))  # the last element is the wall, which is at rest
        np.multiply(rates, ((size * size,), (size,)), out=changes[..., :-1])
        errors = np.abs(changes[..., :-1] - changes[..., 1:])
        errors /= self.job.scales[::-1, :n]
        return float(scaled_error(*np.maximum.reduce(errors, axis=(1, 2)).tolist()) / self.tolerance)
