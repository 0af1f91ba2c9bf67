"""The scaled problem: eq. (1) with mass and contact stiffness 1, and the shock's force taken out of it.

The first granule is written as x1 = y1 + g(t), where g'' is the applied force: g is the path of a free granule
under the shock, known exactly. What is left to integrate contains no force, only the smooth shift g in the
first overlap, so neither a kink nor an infinite slope of the force reaches the integrator's order.

`Request` and `Primary` are the input and the answer of the search for the primary.
"""

from __future__ import annotations

from enum import IntEnum
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

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

# Contacts that a front may pass: so many, and so many for each unit of time that the force lasts.
_MOST_CONTACTS = 20_000
_CONTACT_RATE = 400
# Evaluations of a contact force: at most seconds of the compiled code, minutes of NumPy.
_WORK = 3e7
_WORK_RATE = 3e4
_MOST_WORK = 2e9
# How far behind the front granules are still followed once the force has ended: so many, and if the shock is long some
# more for the time that its force was near what the front may come from, a 2.33rd of its peak. Less would change peaks
# by more than the tolerance.
_REAR = 16
_LASTING = 2.33
_RATE = 1.25
# Of a long shock, by the least tolerance of a step for which it will do.
_LONG_REARS = ((1e-7, 18), (1e-10, 24), (0.0, 32))
# Contacts over which a wave may go on changing as it did over the last few: of a shock that rises again, long.
_GROWING = 20.0
_GROWING_AGAIN = 200.0
# The margin allows for rounding of a power that should equal a tenth.
_TENTHS = np.arange(10) / 10 * (1 + 1e-9)


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
        """Path and velocity of a free granule under the force; the velocity is the impulse applied so far."""
        late = time > self.duration
        path, impulse = self.path.at(float(self.profile.duration_ratio) if late else time / self.rise_time)
        if late:
            path += impulse * (time - self.duration) / self.rise_time
        unit = self.peak_force * self.rise_time
        return unit * self.rise_time * path, unit * impulse


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


def contact_energies(x: FloatArray) -> FloatArray:
    """Elastic energy of each contact, shape (granules - 1,)."""
    return np.asarray(0.4 * contact_forces(x) * np.maximum(overlaps(x), 0.0))


def chain_energy(x: FloatArray, v: FloatArray) -> float:
    """Energy of the granules and of their contacts."""
    return float(0.5 * np.sum(v * v) + np.sum(contact_energies(x)))


# ---------------------------------------------------------------- the search for the primary


class Status(IntEnum):
    """How a search ended; TOO_LONG: the limit was not known after as many contacts as there may be."""

    RUNNING = 0
    KNOWN = 1
    TOO_LONG = 2
    AT_END = 3
    FAILED = 4


class Passage(NamedTuple):
    """The peak of the front at a contact, counted from 0, in scaled units."""

    contact: int
    time: float
    force: float


@frozen(eq=False, slots=False)
class Request:
    """Input of the search for the primary.

    ``tolerance`` is the absolute error allowed in a step, ``doubt`` how far the peak may be from its limit,
    relatively; ``contacts`` ascend: passages of the front that are wanted too. ``patience`` multiplies the work that it
    may take.
    """

    problem: ChainProblem
    tolerance: float
    doubt: float
    contacts: tuple[int, ...] = ()
    patience: float = 1.0

    @property
    def most_contacts(self) -> float:
        return _MOST_CONTACTS + _CONTACT_RATE * self.problem.duration

    @property
    def most_work(self) -> float:
        return min(self.patience * (_WORK + _WORK_RATE * self.problem.duration**2), _MOST_WORK)

    @property
    def known_from(self) -> float:
        """Time before which the primary is not taken as known: a later pulse of the shock must have made its wave."""
        return (2 if self.problem.rises_again else 1) * self.problem.duration

    @property
    def rear(self) -> int:
        if not self.problem.is_long:
            return _REAR
        return next(rear for least, rear in _LONG_REARS if self.tolerance >= least)

    @property
    def growing(self) -> float:
        return _GROWING_AGAIN if self.problem.rises_again else _GROWING

    @cached_property
    def above(self) -> list[float]:
        """How long the force is above 0, 1, ... 9 tenths of its peak; zeros for a short shock."""
        problem = self.problem
        if not problem.is_long:
            return [0.0] * 10
        below = np.searchsorted(np.sort(problem.course), _TENTHS, side="right")
        times: list[float] = ((1 - below / len(problem.course)) * problem.duration).tolist()
        return times

    def rear_of(self, peak: float) -> int:
        """How far behind a front of this peak force granules may be cut off."""
        level = min(10 * (0.9 * peak / (_LASTING * self.problem.peak_force)), 9.0)
        tenth = min(int(level), 8)
        above, further = self.above[tenth : tenth + 2]
        return int(self.rear + _RATE * (above + (level - tenth) * (further - above)))


class Primary(NamedTuple):
    """The primary that was found, in scaled units.

    ``peak`` is the limit along the chain, ``doubt`` a bound on its relative error as such; ``last`` and ``time`` are
    those of the peak at ``contact``, the last that was read, ``speed`` that of the front there. ``momentum`` and
    ``energy`` are those of the wave down to the least force behind it, ``foot``. ``chain_momentum`` and
    ``chain_energy`` are those of all granules, against ``impulse`` and ``work`` of the force; ``free_path`` is how far
    it would have moved a granule by itself.
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
        """Energy in the chain against the work of the force, relative."""
        return abs(self.chain_energy / self.work - 1)

    @property
    def momentum_defect(self) -> float:
        """Momentum in the chain against the impulse, relative."""
        return abs(self.chain_momentum / self.impulse - 1)
