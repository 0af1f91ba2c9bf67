"""Steps of an `Integrator`, with its own step-size control, along a chain of mixed granules without damping."""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import copy

import numpy as np
from attrs import define, field

from shockwave.base.errors import PluginError
from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_forces import Contacts, End
from shockwave.engine.integrator import Integrator, Step, finite
from shockwave.registry.registry import blame, owner_of

# Longest interval in one call of the integrator, in characteristic times.
_STRETCH = 50.0


@define
class IntegratorSteps:
    """The steps from one stop to the next.

    The integrated position of body 0 is that without the applied force, so that the acceleration is smooth.

    Attributes
    ----------
    contacts : Contacts
    integrator : Integrator
    size : float
        Size of the next step.
    step : Step or None
        The last step.
    """

    contacts: Contacts
    integrator: Integrator
    size: float
    step: Step | None = None
    _stop: float = -math.inf
    _driven: bool = False
    _steps: Iterator[Step] = field(factory=lambda: iter(()))

    def advance(self, start: End, time: float, stop: float, driven: bool) -> tuple[float, float]:
        """Take a step from ``start``, at most to ``stop``; its size and its end. The force acts if ``driven``."""
        with blame("integrators", type(self.integrator)):
            if time >= self._stop or stop < self._stop:
                self._stop, self._driven = min(stop, time + _STRETCH), driven
                shift, impulse = self.free(time)
                x, v = start.x[:-1].copy(), start.v[:-1].copy()
                x[0] -= shift
                v[0] -= impulse
                # of a copy: its steps may be interpolated after the force has ended
                self._steps = self.integrator.steps(copy(self).acceleration, time, self._stop, x, v, self.size)
            self.step = next(self._steps, None)
        if self.step is None or not self._is_valid(self.step, time):
            got = "no further step" if self.step is None else f"a step from {self.step.begin:g} to {self.step.end:g}"
            rule = f"must yield finite steps without gaps up to until = {self._stop:g} (got {got} at {time:g})"
            raise PluginError(f"integrator {owner_of('integrators', type(self.integrator))}: {rule}")
        self.size = self.step.next_size
        return self.step.end - self.step.begin, self.step.end

    def _is_valid(self, step: Step, time: float) -> bool:
        """Whether a step fulfils clauses 3 and 8 of the contract."""
        return step.begin == time < step.end <= self._stop and finite(step.x, step.v)

    def free(self, time: float) -> tuple[float, float]:
        """Displacement and velocity of body 0 by the force alone."""
        problem, inverse = self.contacts.job.problem, float(self.contacts.inverse[0])
        if problem is None or not self._driven:
            return 0.0, 0.0
        path, impulse = problem.free(time)
        return inverse * path, inverse * impulse

    def acceleration(self, time: float, positions: FloatArray) -> FloatArray:
        """Accelerations without the applied force."""
        contacts = self.contacts
        x = np.append(positions, 0.0)
        x[0] += self.free(time)[0]
        f = np.append(contacts.weight, contacts.forces(x, np.zeros_like(x), 0, contacts.bodies)[0])
        return np.asarray(contacts.mobile[:-1] * (f[:-1] - f[1:]))

    def state(self, time: float) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities at a time within the last step, with those of the wall."""
        assert self.step is not None
        if time == self.step.end:
            x, v = self.step.x, self.step.v
        else:
            with blame("integrators", type(self.integrator)):
                x, v = self.step.interpolate(time)
        x, v = np.append(x, 0.0), np.append(v, 0.0)
        shift, impulse = self.free(time)
        x[0] += shift
        v[0] += impulse
        return x, v
