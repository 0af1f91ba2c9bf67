"""The scaled problem: eq. (1) with mass and contact stiffness 1, and the shock's force taken out of it.

The first granule is written as x1 = y1 + g(t), where g'' is the applied force: g is the path of a free granule
under the shock, known exactly. What is left to integrate contains no force, only the smooth shift g in the
first overlap, so neither a kink nor an infinite slope of the force reaches the integrator's order.
"""

from __future__ import annotations

import numpy as np
from attrs import frozen

from shockwave.profiles.base import ShockProfile
from shockwave.quadrature import FloatArray

__all__ = ["ChainProblem", "contact_forces", "overlaps"]

# More knots than this are a sampled record: its kinks are too small and too many to end steps on.
_MOST_STOPS = 64


@frozen(eq=False)
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

    @property
    def duration(self) -> float:
        """When the force ends."""
        return self.profile.duration_ratio * self.rise_time

    @property
    def stops(self) -> tuple[float, ...]:
        """Times at which steps must end: kinks of the force and its end."""
        points = self.profile.breakpoints
        if len(points) > _MOST_STOPS:
            points = (0.0, 1.0, self.profile.duration_ratio)
        return tuple(point * self.rise_time for point in points if point > 0)

    def force(self, time: float) -> float:
        """Applied force."""
        return self.peak_force * float(self.profile.force(time / self.rise_time))

    def impulse(self, time: float) -> float:
        """Impulse applied up to ``time``: the velocity of a free granule."""
        return self.peak_force * self.rise_time * float(self.profile.running_impulse(time / self.rise_time))

    def free_path(self, time: float) -> float:
        """The path g of a free granule under the force."""
        unit = self.peak_force * self.rise_time**2
        return unit * float(self.profile.double_integral(time / self.rise_time))

    def acceleration(self, time: float, y: FloatArray, driven: bool) -> FloatArray:
        """y'' of eq. (1), shape (granules,); while ``driven`` the first granule is at y1 + g."""
        overlap = y[:-1] - y[1:]
        if driven:
            overlap[0] += self.free_path(time)
        np.maximum(overlap, 0.0, out=overlap)
        force = overlap * np.sqrt(overlap)
        result = np.empty_like(y)
        result[0] = -force[0]
        np.subtract(force[:-1], force[1:], out=result[1:-1])
        result[-1] = force[-1]
        return result


def overlaps(x: FloatArray) -> FloatArray:
    """Overlap at each contact, negative where it is open; shape (granules - 1,)."""
    return np.asarray(x[:-1] - x[1:])


def contact_forces(x: FloatArray) -> FloatArray:
    """Contact forces, shape (granules - 1,)."""
    closed = np.maximum(overlaps(x), 0.0)
    return np.asarray(closed * np.sqrt(closed))
