"""The primary of a shock, and nothing else: the front is followed until the limit of its peak force is known.

Two codes do the same: the compiled one, and `lanes` in NumPy. Both take many shocks at once, a shock a lane.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from types import ModuleType
from typing import NamedTuple

import numpy as np
from attrs import frozen

from shockwave.quadrature import FloatArray
from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.problem import ChainProblem

__all__ = ["AT_END", "FAILED", "KNOWN", "TOO_LONG", "Passage", "Primary", "Request", "find_primaries"]

# How a search ended. TOO_LONG: the limit was not known after as many contacts as there may be.
KNOWN, TOO_LONG, AT_END, FAILED = 1, 2, 3, 4

_MOST_CONTACTS, _CONTACT_RATE = 20_000, 400
# Evaluations of a contact force: at most seconds of the compiled code, minutes of NumPy.
_WORK, _WORK_RATE, _MOST_WORK = 3e7, 3e4, 2e9
# How far behind the front granules are still followed once the force has ended: so many, and if the shock is long some
# more for the time that its force was near what the front may come from, a 2.33rd of its peak. Less would change peaks
# by more than they are asked for.
_REAR, _LONG, _LASTING, _RATE = 16, 10.0, 2.33, 1.25
# Of a long shock, by the least tolerance of a step for which it will do.
_LONG_REARS = ((1e-7, 18), (1e-10, 24), (0.0, 32))
# Contacts over which a wave may go on changing as it did over the last few: of a shock that rises again, long.
_GROWING, _GROWING_AGAIN = 20.0, 200.0
# The margin allows for rounding of a power that should equal a tenth.
_TENTHS = np.arange(10) / 10 * (1 + 1e-9)
# Shocks that run side by side in the compiled code.
_WIDTH = 8
_SHORT = 16.0


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

    @cached_property
    def known_from(self) -> float:
        """Time before which the primary is not taken as known: a later pulse of the shock must have made its wave."""
        problem = self.problem
        again = problem.duration >= _LONG and problem.rises_again
        return 2 * problem.duration if again else problem.duration

    @property
    def rear(self) -> int:
        if self.problem.duration < _LONG:
            return _REAR
        return next(rear for least, rear in _LONG_REARS if self.tolerance >= least)

    @property
    def growing(self) -> float:
        return _GROWING_AGAIN if self.problem.duration >= _LONG and self.problem.rises_again else _GROWING

    @cached_property
    def above(self) -> list[float]:
        """How long the force is above 0, 1, ... 9 tenths of its peak; zeros for a short shock."""
        problem = self.problem
        if problem.duration < _LONG:
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
    """What was found, in scaled units.

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


def find_primaries(requests: Sequence[Request], method: type[Nystroem], compiled: ModuleType | None) -> list[Primary]:
    """The primary of each request, in their order; ``compiled`` is the compiled module, or None for NumPy."""
    if not requests:
        return []
    if compiled is None:
        from shockwave.simulation.lanes import run

        return run(requests, method)
    # Shocks that take about as long side by side, and those that take far longer apart: none waits for another.
    groups: dict[int, list[int]] = {}
    for index, request in enumerate(requests):
        groups.setdefault(int(math.log(max(request.problem.duration, _SHORT), 4)), []).append(index)
    found: list[Primary] = [None] * len(requests)  # type: ignore[list-item]
    for group in groups.values():
        group.sort(key=lambda index: requests[index].problem.duration, reverse=True)
        for index, primary in zip(group, _compiled(compiled, method, [requests[i] for i in group]), strict=True):
            found[index] = primary
    return found


def _compiled(compiled: ModuleType, method: type[Nystroem], requests: list[Request]) -> list[Primary]:
    jobs: list[float] = []
    rows: list[FloatArray] = []
    coefficients: list[FloatArray] = []
    stops: list[float] = []
    wanted: list[float] = []
    pieces = terms = 0
    for request in requests:
        problem = request.problem
        path = problem.path
        rows.append(path.rows)
        coefficients.append(path.coefficients)
        jobs += _job(request, pieces, terms, len(stops), len(wanted) // 3)
        pieces += len(path.rows)
        terms += len(path.coefficients)
        stops += problem.stops
        for contact in request.contacts:
            wanted += (contact, math.nan, math.nan)
    one = len(requests) == 1
    found = np.zeros((len(requests), len(Primary._fields) - 1))
    passages = np.array(wanted)
    compiled.primary(
        method.tableau.packed,
        np.array(jobs),
        rows[0] if one else np.concatenate(rows),
        coefficients[0] if one else np.concatenate(coefficients),
        np.array(stops),
        passages,
        found,
        1 if len(requests) < _WIDTH else _WIDTH,
    )
    if not wanted:
        return [Primary(*row) for row in found.tolist()]  # type: ignore[arg-type]
    ends = np.cumsum([len(request.contacts) for request in requests]).tolist()
    return [
        Primary(*row, passages=_passages(passages[3 * (end - len(request.contacts)) : 3 * end]))  # type: ignore
        for row, end, request in zip(found.tolist(), ends, requests, strict=True)
    ]


def _job(request: Request, pieces: int, terms: int, stops: int, wanted: int) -> tuple[float, ...]:
    """The row of a request: its numbers, and where its share of the other tables begins."""
    problem = request.problem
    return (
        problem.rise_time,
        problem.peak_force,
        problem.duration,
        problem.granules or 0,
        request.tolerance,
        request.doubt,
        request.most_contacts,
        request.most_work,
        request.rear,
        request.known_from,
        request.growing,
        *request.above,
        pieces,
        len(problem.path.rows),
        terms,
        stops,
        wanted,
        len(request.contacts),
    )


def _passages(flat: FloatArray) -> tuple[Passage, ...]:
    triples = flat.reshape(-1, 3).tolist()
    return tuple(Passage(int(contact), time, force) for contact, time, force in triples if not math.isnan(time))
