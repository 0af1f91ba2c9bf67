"""Input and result of the search for the leading wave of an endless chain, in scaled units."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any, NamedTuple

from attrs import field, frozen

from shockwave.engine.scaled_problem import ScaledProblem

# Largest number of contacts that a front may pass, and its increase per characteristic time of the shock.
_MAX_CONTACTS = 20_000
_CONTACT_RATE = 400
# Largest number of evaluations of a contact force, its increase with the square of the duration, and its upper limit:
# seconds for the compiled code, minutes for NumPy.
_WORK = 3e7
_WORK_RATE = 3e4
_MAX_WORK = 5e8
# Lower limit of the evaluations, over the square of the duration, for very long shocks: slightly more than triangular
# shocks need.
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


class SearchStatus(IntEnum):
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
class SearchRequest:
    """Input of the search for the leading wave.

    ``tolerance`` is the absolute error allowed in a step, ``doubt`` the permitted relative extrapolation uncertainty of
    the peak force. ``contacts``, in ascending order, are those at which the passage of the front is requested.
    ``patience`` multiplies the limit on the work.
    """

    problem: ScaledProblem
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
