"""Request to the search for the primary, and its answer."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from attrs import frozen

from shockwave.simulation.problem import ChainProblem

#: How a search ended. TOO_LONG: the limit was not known after as many contacts as there may be.
RUNNING = 0
KNOWN = 1
TOO_LONG = 2
AT_END = 3
FAILED = 4

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


class Passage(NamedTuple):
    """The peak of the front at a contact, counted from 0, in scaled units."""

    contact: int
    time: float
    force: float


@frozen(eq=False, slots=False)
class Request:
    """A shock and what is asked of it.

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
        level = 0.9 * peak / (_LASTING * self.problem.peak_force)
        tenth = int(10 * level) if level < 0.9 else 8
        share = 10 * level - tenth if level < 0.9 else 1.0
        above, further = self.above[tenth : tenth + 2]
        return int(self.rear + _RATE * (above + share * (further - above)))


class Primary(NamedTuple):
    """The primary that was found, in scaled units.

    ``peak`` is the limit along the chain, ``doubt`` a bound on its relative error as such; ``last`` and ``time`` are
    those of the peak at ``contact``, the last that was read, ``speed`` that of the front there. ``momentum`` and
    ``energy`` are those of the wave from its ``foot`` on, the force behind it. ``chain_momentum`` and
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
