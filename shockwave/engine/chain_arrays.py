"""Input and output of the integration of a chain of mixed granules, as arrays that the compiled code shares."""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt
from attrs import Factory, define

from shockwave.base.errors import NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_record import Record
from shockwave.engine.integrator import Integrator
from shockwave.engine.nystroem_tableaux import Tableau
from shockwave.engine.scaled_problem import ScaledProblem

if TYPE_CHECKING:  # chains without laws of plugins do not need it
    from shockwave.scene.contact_law import BoundLaw


class Status(IntEnum):
    """Status of a run; PAUSED: its record is full, or the front is at the end of the arrays."""

    RUNNING = 0
    DONE = 1
    TOO_LONG = 2
    FAILED = 3
    PAUSED = 4


#: Number of rows that describe a chain and its motion.
ROWS = 20
#: Number of watched contacts before the sampled rows.
UNSAMPLED = 2
#: Tolerance with which fixed steps end on kinks.
KINK_TOLERANCE = 1e-10
#: Scale of an error that is to be ignored.
LARGEST = 1e300
# Share of the allowed work after which the whole work of a run is estimated, and the estimates over the allowed work
# beyond which the run ends at once: to the end of the shock, and beyond it, where the steps may become longer.
_SOON = 0.1
_HOPELESS = 2.0
_HOPELESS_LATER = 10.0


class Settings(NamedTuple):
    """Settings of a run, in the order of the compiled code.

    Attributes
    ----------
    tolerance : float
    until : float
        End of the simulated time; if it is infinite, the run finds it.
    duration, rise_time, peak_force : float
        The applied force.
    first, longest : float
        First step, and longest one under the force.
    contacts : int
    end_stiffness, end_damping : float
        Spring and dashpot of the end.
    most_work : float
        Allowed work, in evaluations of a contact force.
    damped : bool
        Whether forces depend on velocities at all times.
    weight : float
        Constant force on body 0: the weight of a striker.
    guided : bool
        Whether the path of body 0 is given, for which its inverse mass is 1.
    """

    tolerance: float
    until: float
    duration: float
    rise_time: float
    peak_force: float
    first: float
    longest: float
    contacts: int
    end_stiffness: float = 0.0
    end_damping: float = 0.0
    most_work: float = math.inf
    damped: bool = False
    weight: float = 0.0
    guided: bool = False


@define(eq=False)
class Progress:
    """How far a run has come, and its sums, in the order of the compiled code; at first those at the beginning.

    Attributes
    ----------
    status : float
    time : float
    arrival : float
        Time of the first maximum of the force at the last contact; negative: none.
    work : float
        Of the applied force.
    steps, evaluations : float
    rebound : float
        Velocity of a striker with a weight when it first leaves the chain; 0: it has not.
    size : float
        Size of the next step.
    extremes : array, shape (2, 3)
        Greatest magnitudes of displacement, acceleration and spring force of a movable end (infinite: there is none),
        and their times.
    """

    status: float = 0.0
    time: float = 0.0
    arrival: float = -1.0
    work: float = 0.0
    steps: float = 0.0
    evaluations: float = 0.0
    rebound: float = 0.0
    size: float = 0.0
    extremes: FloatArray = Factory(np.array([[math.inf] * 3, [0.0] * 3]).copy)

    @property
    def numbers(self) -> list[float]:
        """All numbers in a row."""
        sums = [self.status, self.time, self.arrival, self.work, self.steps, self.evaluations, self.rebound, self.size]
        return [*sums, *self.extremes.ravel().tolist()]

    def update(self, numbers: FloatArray) -> None:
        """Replace all numbers."""
        self.status, self.time, self.arrival, self.work, self.steps, *others = numbers[:8].tolist()
        self.evaluations, self.rebound, self.size = others
        self.extremes = numbers[8:].reshape(2, 3)


@define
class Forecast:
    """Estimate of the work of a run to the time ``until``, from its progress; ``cause`` states what makes it large.

    A run whose estimate is ``excess`` times the allowed work ends at once. Between the last two ``marks``, of work and
    time, the work has doubled.
    """

    until: float = math.inf
    most_work: float = math.inf
    cause: Callable[[], str] = str
    excess: float = _HOPELESS
    marks: tuple[tuple[float, float], tuple[float, float]] = ((0.0, 0.0), (0.0, 0.0))

    @classmethod
    def of(cls, settings: Settings, static_forces: FloatArray, cause: Callable[[], str]) -> Forecast:
        """Forecast to a stated end only where static forces, or spring or dashpot of the end, keep the steps short.

        Otherwise, free flight may follow the time that a wave takes to arrive.
        """
        until, most_work, end = settings.until, settings.most_work, settings.end_stiffness or settings.end_damping
        if until < math.inf and (end or (static_forces.any() and not settings.weight)):
            return cls(until, most_work, cause, _HOPELESS_LATER)
        return cls(min(settings.duration + settings.contacts, until), most_work, cause)

    def check(self, time: float, work: float, steps: float) -> None:
        """Raise if the run would exceed the allowed work by far.

        The rate is that of at least the last half of the work so far, since the first steps may be short.
        """
        if self.most_work == math.inf:
            return
        if work >= 2 * self.marks[1][0]:
            self.marks = self.marks[1], (work, time)
        if work < _SOON * self.most_work:
            return
        before, since = self.marks[0]
        whole = work + (self.until - time) * (work - before) / max(time - since, 1e-300)
        if whole > self.excess * self.most_work:
            needed = f"the chain would take about {steps * whole / work:.0e} steps"
            raise NumericalError(f"{needed} because of {self.cause()} (set a timeout to integrate it all the same)")


@define(eq=False)
class Job:
    """Input and output of a run, as arrays that the compiled code shares.

    Row j of an array with a row for each body belongs to contact j, between bodies j and j + 1; the last one is the
    contact with the wall, the spring of a movable end, or none.

    Attributes
    ----------
    method : Tableau
    problem : ScaledProblem or None
        The applied force.
    law : BoundLaw or None
        Contact law of a plugin.
    by_law : array of bool, shape (bodies,)
        Where it holds.
    settings : Settings
    stops, times : array
        Kinks of the applied force; times of samples.
    samples : array, shape (times, 4 or 5, rows)
        x, v, total forces, and impulses of the forces less the static ones, of the sampled rows; with elastic-plastic
        contacts, the energies that contacts release, for p = 3/2.
    watched : array of int
        Contacts whose impulses are summed: two, followed by the sampled rows in ascending order.
    impulses : array
        These sums, without those of the static forces.
    progress : Progress
    table : array, shape (20, bodies + 1)
        The arrays below.
    plastic : array, shape (26, bodies + 1) or (0, 0)
        Rows of elastic-plastic contacts; see `chain_modes`.
    curves : array, shape (pieces, 5, 4)
        Pieces of the loading curves of rate-dependent contacts.
    integrator : Integrator or None
        Takes the steps in place of ``method``, whose weights then integrate over them.
    window : int
        Number of bodies that move at first.
    forecast : Forecast
        Estimate of the work of the whole run.
    bar : bool
        Whether the last body is the flat of a bar; NumPy alone integrates it.
    record : Record or None
    """

    method: Tableau
    problem: ScaledProblem | None
    law: BoundLaw | None
    by_law: npt.NDArray[np.bool_]
    settings: Settings
    stops: FloatArray
    times: FloatArray
    samples: FloatArray
    watched: npt.NDArray[np.int64]
    impulses: FloatArray
    progress: Progress
    table: FloatArray
    plastic: FloatArray = Factory(lambda: np.empty((0, 0)))
    curves: FloatArray = Factory(lambda: np.empty(0))
    integrator: Integrator | None = None
    window: int = 12
    forecast: Forecast = Factory(Forecast)
    bar: bool = False
    record: Record | None = None

    @property
    def bodies(self) -> int:
        """Number of bodies."""
        return len(self.by_law)

    @property
    def chain(self) -> FloatArray:
        """Inverse masses, stiffnesses, gaps (zero or negative), static overlaps, their roots, static forces, damping
        coefficients, and the least fractions of closing velocity and overlap expected of a contact, over those of the
        contact before; shape (9, bodies).
        """
        return self.table[:9, :-1]

    @property
    def scales(self) -> FloatArray:
        """Closing velocities and overlaps to which the errors are compared, shape (2, bodies)."""
        return self.table[9:11, :-1]

    @property
    def peaks(self) -> FloatArray:
        """Greatest force minus static force, and its time, shape (2, bodies)."""
        return self.table[11:13, :-1]

    @property
    def losses(self) -> FloatArray:
        """Dissipated energy, shape (bodies,)."""
        return self.table[13, :-1]

    @property
    def x(self) -> FloatArray:
        """Positions, shape (bodies + 1,); the last one is that of the wall."""
        return np.asarray(self.table[14])

    @property
    def v(self) -> FloatArray:
        """Velocities, shape (bodies + 1,)."""
        return np.asarray(self.table[15])

    @property
    def switches(self) -> FloatArray:
        """Accelerations of the closing velocities by a unit force, and whether dashpots act, shape (2, bodies)."""
        return self.table[16:18, :-1]

    @property
    def exponents(self) -> FloatArray:
        """Exponents of the elastic forces, and powers of the damping, shape (2, bodies)."""
        return self.table[18:20, :-1]


class Samples(NamedTuple):
    """Samples of some bodies, and of the contact after each, at requested times.

    Attributes
    ----------
    rows : array of int
        Numbers of the bodies and contacts, in ascending order.
    x, v : array, shape (times, rows)
    forces : array, shape (times, rows)
        Total forces of the contacts; behind the last body that of the spring and dashpot of a movable end.
    impulses : array, shape (times, rows)
        Integrals of these forces from the beginning, less those of the static forces.
    energies : array, shape (times, rows), or None
        Energies that elastic-plastic contacts release; None without such contacts.
    """

    rows: npt.NDArray[np.int64]
    x: FloatArray
    v: FloatArray
    forces: FloatArray
    impulses: FloatArray
    energies: FloatArray | None = None
