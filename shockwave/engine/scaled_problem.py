"""The scaled problem: eq. (1) with mass and contact stiffness 1, and the force of the shock eliminated.

The contact force is d^p of the overlap d, with p = 3/2 for Hertz's law.

The position of the first granule is x1 = y1 + g(t), where g'' is the applied force: g is the free-particle
displacement, which is known exactly. The equation for y1 contains no force, only the smooth shift g in the first
overlap, so that kinks and infinite slopes of the force do not reduce the order of the integrator.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from attrs import define, field, frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.force_law import contact_force, power_force, stiffenings
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.registry.plugin_check import memoize
from shockwave.scene.chain import HERTZ
from shockwave.scene.solitary_wave import WaveLaw, wave_law

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath

# Largest number of breakpoints on which steps end; a sampled record has more, but smaller, kinks.
_MAX_STOPS = 64
# Largest number of granules for which plain floats are faster than arrays.
_FEW = 12
# Zero as an array, which saves a conversion in every call.
_ZERO = np.zeros(())
# Duration of the shortest long shock, in characteristic times.
_LONG = 10.0
# Times at which the force is sampled, over its duration: midpoints of equal intervals, so that both ends are excluded.
_SHARES = (np.arange(200) + 0.5) / 200
# Least rise of the force that counts as a second rise, in units of the peak force.
_SECOND_RISE = 0.05

# Tenths of the peak force, with a margin for rounding.
_TENTHS = np.arange(10) / 10 * (1 + 1e-9)
_NEVER = (0.0,) * len(_TENTHS)


@frozen(eq=False, slots=False)
class ScaledProblem:
    """A shock on a chain, in scaled units.

    Attributes
    ----------
    profile : ShockProfile
        Shape of the shock.
    rise_time, peak_force : float
        In scaled units.
    granules : int or None
        Number of granules; None for an infinite chain.
    exponent : float
        p of the contact force d^p.
    """

    profile: ShockProfile
    rise_time: float
    peak_force: float
    granules: int | None = None
    exponent: float = HERTZ

    @property
    def wave(self) -> WaveLaw:
        """The solitary wave of the chain."""
        return wave_law(self.exponent)

    @cached_property
    def duration(self) -> float:
        """Duration of the force."""
        return float(self.profile.duration_ratio) * self.rise_time

    @cached_property
    def breakpoints(self) -> tuple[float, ...]:
        """Breakpoints of the profile, in units of the rise time."""
        return self.profile.breakpoints

    @property
    def stops(self) -> tuple[float, ...]:
        """Times on which steps must end: the kinks and the end of the force."""
        points = self.breakpoints
        if len(points) > _MAX_STOPS:
            points = (0.0, 1.0, self.profile.duration_ratio)
        return (*[point * self.rise_time for point in points[1:-1]], self.duration)

    @cached_property
    def path(self) -> FreePath:
        """Table of displacement and impulse of a free granule under the force, in units of the profile."""
        return self.profile.free_path()

    @cached_property
    def course(self) -> FloatArray:
        """The force over its peak at equal intervals, shape (200,)."""
        return _sample(self.profile)

    @property
    def is_long(self) -> bool:
        """Whether the first waves of the train are nearly equal and separate slowly."""
        return self.duration >= _LONG

    @cached_property
    def rises_again(self) -> bool:
        """Whether a long force rises again after it has decreased."""
        if not self.is_long:
            return False
        fallen = np.maximum.accumulate(self.course) - self.course
        return bool((np.maximum.accumulate(fallen) - fallen).max() > _SECOND_RISE)

    @cached_property
    def above(self) -> tuple[float, ...]:
        """Times during which the force exceeds 0, 0.1, ... 0.9 of its peak; zeros for a short shock."""
        if not self.is_long:
            return _NEVER
        below = np.searchsorted(np.sort(self.course), _TENTHS, side="right")
        return tuple(((1 - below / len(self.course)) * self.duration).tolist())

    def free(self, time: float) -> tuple[float, float]:
        """Displacement and velocity of a free granule under the force; the velocity equals the impulse so far."""
        late = time > self.duration
        path, impulse = self.path.at(float(self.profile.duration_ratio) if late else time / self.rise_time)
        if late:
            path += impulse * (time - self.duration) / self.rise_time
        unit = self.peak_force * self.rise_time
        return unit * self.rise_time * path, unit * impulse


@memoize
def _sample(profile: ShockProfile) -> FloatArray:
    return profile.force(_SHARES * float(profile.duration_ratio))


@define
class WindowAcceleration:
    """Accelerations of a window; stores the impulse and the acceleration of the first granule at each stage.

    ``path`` gives displacement and impulse of a free granule; it is None after the force has ended. ``rounded_end`` is
    the sum of beginning and size of a step, which may differ from its ``end`` by rounding.
    """

    path: Callable[[float], tuple[float, float]] | None
    exponent: float
    rounded_end: float
    end: float
    impulses: list[float] = field(factory=list)
    first: list[float] = field(factory=list)

    def __call__(self, time: float, y: FloatArray) -> FloatArray:
        if self.path is None:
            return chain_acceleration(y, exponent=self.exponent)
        path, impulse = self.path(self.end if time == self.rounded_end else float(time))
        result = chain_acceleration(y, path, self.exponent)
        self.impulses.append(impulse)
        self.first.append(result.item(0))
        return result


def chain_acceleration(y: FloatArray, shift: float = 0.0, exponent: float = HERTZ) -> FloatArray:
    """Accelerations of granules at ``y``, with the first at ``y[0] + shift``; shape (granules,)."""
    if len(y) <= _FEW:
        here, *others = y.tolist()
        here += shift
        behind, accelerations = 0.0, []
        for other in others:
            ahead = contact_force(here - other, exponent)
            accelerations.append(behind - ahead)
            here, behind = other, ahead
        return np.array([*accelerations, behind])
    forces = np.zeros(len(y) + 1)
    contacts = forces[1:-1]
    np.subtract(y[:-1], y[1:], out=contacts)
    if shift:
        contacts[0] = (y[0] + shift) - y[1]
    np.maximum(contacts, _ZERO, out=contacts)
    contacts *= stiffenings(contacts, exponent)
    return np.asarray(forces[:-1] - forces[1:])


def overlaps(x: FloatArray) -> FloatArray:
    """Overlap at each contact, negative if it is open; shape (granules - 1,)."""
    return np.asarray(x[:-1] - x[1:])


def contact_forces(x: FloatArray, exponent: float = HERTZ) -> FloatArray:
    """Contact forces, shape (granules - 1,)."""
    return power_force(np.maximum(overlaps(x), 0.0), exponent)


def contact_energies(x: FloatArray, exponent: float = HERTZ) -> FloatArray:
    """Elastic energy of each contact, shape (granules - 1,)."""
    return np.asarray(1 / (exponent + 1) * contact_forces(x, exponent) * overlaps(x))


def chain_energy(x: FloatArray, v: FloatArray, exponent: float = HERTZ) -> float:
    """Total energy of granules and contacts."""
    return float(0.5 * (v * v).sum() + contact_energies(x, exponent).sum())
