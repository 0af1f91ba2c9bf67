"""One shock on its way into its chain, and the forces on the chains of many."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from attrs import define, field

from shockwave.quadrature import FloatArray
from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.primary import FAILED, Passage, Request

__all__ = ["ROWS", "Force", "Lane"]

#: A window grows by so many granules.
ROWS = 8
_FIRST_STEP, _LONGEST_STEP = 0.05, 1.0
_SAFETY, _LEAST_FACTOR, _MOST_FACTOR = 0.9, 0.2, 3.0


@define(eq=False, slots=False)
class Lane:
    """One shock on its way."""

    index: int
    request: Request
    stops: tuple[float, ...] = ()
    status: int = 0
    base: int = 0
    count: int = ROWS
    head: int = -1
    stop: int = 0
    driven: bool = True
    rejected: bool = False
    time: float = 0.0
    size: float = _FIRST_STEP
    free: tuple[float, float] = (0.0, 0.0)
    impulse: float = 0.0
    free_path: float = 0.0
    work: float = 0.0
    bank_momentum: float = 0.0
    bank_energy: float = 0.0
    steps: int = 0
    effort: int = 0
    evaluations: int = 0
    peaks: list[Passage] = field(factory=list)
    passages: list[Passage] = field(factory=list)
    limit: tuple[float, float] = (0.0, 0.0)

    def __attrs_post_init__(self) -> None:
        self.stops = (*self.request.problem.stops, math.inf)
        granules = self.request.problem.granules
        self.count = ROWS if granules is None else min(ROWS, granules)

    @property
    def until(self) -> float:
        return self.stops[self.stop]

    def next_size(self) -> float:
        """The next step, so that none is left a sliver before the next stop."""
        left = self.until - self.time
        if self.size >= left:
            return left
        return left / 2 if self.size > left / 2 else self.size

    def control(self, size: float, error: float, at_stop: bool, method: Nystroem) -> bool:
        """The size of the step after one of ``size`` with this error over the tolerance; whether that one holds."""
        self.effort += self.count * (len(method.tableau.nodes) + 1)
        self.evaluations += method.tableau.evaluations
        factor = _SAFETY * max(error, 1e-12) ** (-1 / (method.error_order + 1)) if error == error else 0.0
        if not error <= 1:
            self.size = size * (factor if _LEAST_FACTOR < factor < 1 else _LEAST_FACTOR)
            self.rejected = True
            if self.size < 1e-14 * (1 + self.time) or self.effort > self.request.most_work:
                self.status = FAILED
            return False
        factor = min(factor, 1.0 if self.rejected else _MOST_FACTOR)
        self.rejected = False
        if not (at_stop and size * factor < self.size):
            self.size = min(size * factor, _LONGEST_STEP)
        return True


class Force:
    """Accelerations of all lanes; keeps what the work of the force is made of, stage by stage."""

    def __init__(self, lanes: Sequence[Lane | None], rows: int, sums: FloatArray, ends: Sequence[float]) -> None:
        self.driven = [(place, lane) for place, lane in enumerate(lanes) if lane is not None and lane.driven]
        # begin and size may add up to a rounding less or more than the stop at which a step ends
        self.sums, self.ends = sums.tolist(), ends
        self.impulses: list[list[float]] = []
        self.first: list[FloatArray] = []
        self.overlaps = np.zeros((rows, len(lanes)))
        self.inner = self.overlaps[:-1]  # the last row has no granule ahead: it stays 0
        forces = np.zeros((rows + 1, len(lanes)))
        self.behind, self.ahead = forces[:-1], forces[1:]

    def __call__(self, times: FloatArray, y: FloatArray) -> FloatArray:
        np.subtract(y[:-1], y[1:], out=self.inner)
        if self.driven:
            self._drive(np.ravel(times), y)
        np.maximum(self.overlaps, 0.0, out=self.overlaps)
        np.sqrt(self.overlaps, out=self.ahead)
        np.multiply(self.ahead, self.overlaps, out=self.ahead)
        result: FloatArray = self.behind - self.ahead
        if self.driven:
            self.first.append(result[0])
        return result

    def _drive(self, times: FloatArray, y: FloatArray) -> None:
        """Add the free path to the first overlap of each lane that is driven."""
        impulses = [0.0] * len(self.ends)
        for place, lane in self.driven:
            time = float(times[place])
            path, impulses[place] = lane.request.problem.free(self.ends[place] if time == self.sums[place] else time)
            self.overlaps[0, place] = (y[0, place] + path) - y[1, place]
        self.impulses.append(impulses)
