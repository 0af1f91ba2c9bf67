"""The scaled problem: eq. (1) with mass and contact stiffness 1, and the shock's force taken out of it.

The first granule is written as x1 = y1 + g(t), where g'' is the applied force: g is the path of a free granule
under the shock, known exactly. What is left to integrate contains no force, only the smooth shift g in the
first overlap, so neither a kink nor an infinite slope of the force reaches the integrator's order.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen

from shockwave.profiles.base import ShockProfile
from shockwave.quadrature import FloatArray

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath


# More knots than this are a sampled record: its kinks are too small and too many to end steps on.
_MOST_STOPS = 64
# Shocks of at least this duration are long.
_LONG = 10.0
# Samples of the force, and the share of its peak that is a little.
_SAMPLES = 200
_LITTLE = 0.05


@frozen(eq=False, slots=False)
class ChainProblem:
    """A shock on a chain, in scaled units.

    Attributes
    ----------
    profile : ShockProfile
        Shape of the shock.
    rise_time, peak_force : float
        In the units of the problem.
    granules : int or None
        Their number; None for a chain without end.
    """

    profile: ShockProfile
    rise_time: float
    peak_force: float
    granules: int | None = None

    @cached_property
    def duration(self) -> float:
        """When the force ends."""
        return float(self.profile.duration_ratio) * self.rise_time

    @cached_property
    def stops(self) -> tuple[float, ...]:
        """Times at which steps must end: kinks of the force and, last of them, its end."""
        points = self.profile.breakpoints
        if len(points) > _MOST_STOPS:
            points = (0.0, 1.0, self.profile.duration_ratio)
        return (*(point * self.rise_time for point in points[1:-1]), self.duration)

    @cached_property
    def path(self) -> FreePath:
        """Path and impulse of a free granule under the force, as a table in units of the profile."""
        return self.profile.free_path()

    @cached_property
    def course(self) -> FloatArray:
        """The force over its peak at equal intervals, shape (200,)."""
        # Midpoints, so that neither end is a point of its own.
        shares = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
        return self.profile.force(shares * float(self.profile.duration_ratio))

    @property
    def is_long(self) -> bool:
        """Whether the first waves are nearly alike, and part slowly."""
        return self.duration >= _LONG

    @cached_property
    def rises_again(self) -> bool:
        """Whether a long force rises once more after it has fallen, by more than a little."""
        if not self.is_long:
            return False
        fallen = np.maximum.accumulate(self.course) - self.course
        return bool((np.maximum.accumulate(fallen) - fallen).max() > _LITTLE)

    def free(self, time: float) -> tuple[float, float]:
        """Path and velocity of a free granule under the force."""
        if time > self.duration:
            path, impulse = self.path.at(float(self.profile.duration_ratio))
            path += impulse * (time - self.duration) / self.rise_time
        else:
            path, impulse = self.path.at(time / self.rise_time)
        unit = self.peak_force * self.rise_time
        return unit * self.rise_time * path, unit * impulse

    def impulse(self, time: float) -> float:
        """Impulse applied up to ``time``: the velocity of a free granule."""
        return self.free(time)[1]


@frozen(eq=False)
class ChainAcceleration:
    """y'' of eq. (1) as a function of time and positions, shape (granules,), which the compiled step knows too.

    While it is ``driven`` the first granule is at y1 + g.
    """

    problem: ChainProblem
    driven: bool

    def __call__(self, time: float, y: FloatArray) -> FloatArray:
        return chain_acceleration(y, self.problem.free(time)[0] if self.driven else 0.0)


def chain_acceleration(y: FloatArray, shift: float = 0.0) -> FloatArray:
    """Accelerations of granules at ``y``, the first of them at ``y[0] + shift``; shape (granules,)."""
    forces = np.zeros(len(y) + 1)
    contacts = forces[1:-1]
    np.subtract(y[:-1], y[1:], out=contacts)
    if shift:
        contacts[0] = (y[0] + shift) - y[1]
    np.maximum(contacts, 0.0, out=contacts)
    contacts *= np.sqrt(contacts)
    return np.asarray(forces[:-1] - forces[1:])


def overlaps(x: FloatArray) -> FloatArray:
    """Overlap at each contact, negative where it is open; shape (granules - 1,)."""
    return np.asarray(x[:-1] - x[1:])


def contact_forces(x: FloatArray) -> FloatArray:
    """Contact forces, shape (granules - 1,)."""
    closed = np.maximum(overlaps(x), 0.0)
    return np.asarray(closed * np.sqrt(closed))


def chain_energy(x: FloatArray, v: FloatArray) -> float:
    """Energy of the granules and of their contacts."""
    stored = 0.4 * contact_forces(x) * np.maximum(overlaps(x), 0.0)
    return float(0.5 * np.sum(v * v) + np.sum(stored))
