"""The scaled problem: eq. (1) with mass and contact stiffness 1, and the force of the shock eliminated.

The contact force is d^p of the overlap d, with p = 3/2 for Hertz's law.

The position of the first granule is x1 = y1 + g(t), where g'' is the applied force: g is the free-particle
displacement, which is known exactly. The equation for y1 contains no force, only the smooth shift g in the first
overlap, so that kinks and infinite slopes of the force do not reduce the order of the integrator.

`Request` and `Primary` are the input and the result of the search for the leading wave.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import IntEnum
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

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

# Largest number of contacts that a front may pass, and its increase per characteristic time of the shock.
_MAX_CONTACTS = 20_000
_CONTACT_RATE = 400
# Largest number of evaluations of a contact force, its increase with the square of the duration, and its upper limit:
# seconds for the compiled code, minutes for NumPy.
_WORK = 3e7
_WORK_RATE = 3e4
_MAX_WORK = 5e8
# The same over the square of the duration, for very long shocks: somewhat more than triangles need.
_LEAST_RATE = 100.0
# Number of granules behind the front that are integrated after the force has ended. Fewer would change the peaks by
# more than the tolerance.
_REAR = 16
# The same for long shocks, with the smallest tolerance of a step for which it is sufficient.
_LONG_REARS = ((1e-7, 18), (1e-10, 24), (0.0, 32))
# Increase of this number per characteristic time during which a long force exceeds 1/2.33 of the peak of the front; a
# constant force makes a front of 2.33 times its value.
_LASTING = 2.33
_RATE = 1.25
# Number of contacts over which a wave may continue to grow at its present rate, without and with a second rise.
_GROWING = 20.0
_GROWING_AGAIN = 200.0
#: Time after the end of the force in which a last blow forms its wave, whose force at the first contact may be small
#: before.
FORMING = 6.0
# Tenths of the peak force, with a margin for rounding.
_TENTHS = np.arange(10) / 10 * (1 + 1e-9)
_NEVER = (0.0,) * len(_TENTHS)


@frozen(eq=False, slots=False)
class ChainProblem:
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
    return np.asarray(1 / (exponent + 1) * contact_forces(x, exponent) * np.maximum(overlaps(x), 0.0))


def chain_energy(x: FloatArray, v: FloatArray, exponent: float = HERTZ) -> float:
    """Total energy of granules and contacts."""
    return float(0.5 * np.sum(v * v) + np.sum(contact_energies(x, exponent)))


# ---------------------------------------------------------------- search for the leading wave


class Status(IntEnum):
    """Status of a search; TOO_LONG: the limit was not known after the largest number of contacts."""

    RUNNING = 0
    KNOWN = 1
    TOO_LONG = 2
    AT_END = 3
    FAILED = 4


class Passage(NamedTuple):
    """Peak of the front at a contact, counted from 0, in scaled units."""

    contact: int
    time: float
    force: float


class Limits(NamedTuple):
    """Limits of a search, from the duration and course of the shock.

    ``max_contacts`` and ``max_work`` are the largest numbers of contacts that the front may pass and of evaluations of
    a contact force, ``rear`` is the number of granules behind the front that are integrated after the force has ended,
    and ``growing`` the number of contacts over which a wave may continue to grow at its present rate. The leading wave
    is accepted from ``earliest_time`` on: later pulses must have formed their waves.
    """

    max_contacts: float
    max_work: float
    rear: int
    earliest_time: float
    growing: float


def short_limits(duration: Any, spread: float) -> Limits:
    """Limits of the search after a short shock; ``duration`` may be an array.

    ``spread`` is that of the `WaveLaw`.
    """
    work = _WORK + _WORK_RATE * duration * duration
    return Limits(
        _MAX_CONTACTS + _CONTACT_RATE * duration, work, math.ceil(_REAR * spread), duration + FORMING, _GROWING
    )


@frozen(eq=False, slots=False)
class Request:
    """Input of the search for the leading wave.

    ``tolerance`` is the absolute error allowed in a step, ``doubt`` the permitted relative extrapolation uncertainty of
    the peak force. ``contacts``, in ascending order, are those at which the passage of the front is requested.
    ``patience`` multiplies the limit on the work.
    """

    problem: ChainProblem
    tolerance: float
    doubt: float
    contacts: tuple[int, ...] = ()
    patience: float = 1.0
    limits: Limits = field(init=False)

    @limits.default
    def _limits(self) -> Limits:
        problem = self.problem
        duration = problem.duration
        limits = short_limits(duration, problem.wave.spread)
        rear, again = limits.rear, False
        if problem.is_long:
            rear = math.ceil(problem.wave.spread * next(rear for least, rear in _LONG_REARS if self.tolerance >= least))
            again = problem.rises_again
        work = min(self.patience * limits.max_work, max(_MAX_WORK, _LEAST_RATE * duration * duration))
        growing, earliest = (_GROWING_AGAIN, 2 * duration) if again else (_GROWING, duration + FORMING)
        return Limits(limits.max_contacts, work, rear, earliest, growing)

    def rear_of(self, peak: float) -> int:
        """Number of granules to keep behind a front of this peak force."""
        level = min(10 * (0.9 * peak / (_LASTING * self.problem.peak_force)), 9.0)
        tenth = min(int(level), 8)
        above, further = self.problem.above[tenth : tenth + 2]
        return int(self.limits.rear + _RATE * (above + (level - tenth) * (further - above)))


class Primary(NamedTuple):
    """The leading wave, in scaled units.

    ``peak`` is the limit of the peak force along the chain, ``doubt`` its relative extrapolation uncertainty. ``last``,
    ``time`` and ``speed`` are peak force, arrival time and speed of the front at ``contact``, the last one that was
    evaluated. ``momentum`` and ``energy`` are those of the wave, which extends to the smallest force behind it, the
    residual force ``foot``. ``chain_momentum`` and ``chain_energy`` are those of all granules, to be compared with
    ``impulse`` and ``work`` of the force; ``free_path`` is the free-particle displacement.
    """

    status: float
    peak: float
    last: float
    contact: float
    time: float
    doubt: float
    speed: float
    momentum: float
    energy: float
    foot: float
    chain_momentum: float
    chain_energy: float
    work: float
    impulse: float
    free_path: float
    steps: float
    evaluations: float
    passages: tuple[Passage, ...] = ()

    @property
    def energy_defect(self) -> float:
        """Relative difference between the energy of the chain and the work of the force."""
        return abs(self.chain_energy / self.work - 1)

    @property
    def momentum_defect(self) -> float:
        """Relative difference between the momentum of the chain and the impulse."""
        return abs(self.chain_momentum / self.impulse - 1)
