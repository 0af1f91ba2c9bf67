"""Record of a run of a whole chain: the peaks of all contact forces, and the states at the ends of the steps."""

from __future__ import annotations

import numpy as np
from attrs import Factory, define, evolve

from shockwave.base.numerics import FloatArray
from shockwave.engine.peak_log import PEAK, PeakLog
from shockwave.engine.stretch import Span, Stretch

# Largest number of steps of a stretch.
_MOST_STEPS = 256
# Least room for states, in steps, with which the next run begins.
_FEWEST_STEPS = 16
_NOTHING = np.empty(0)
#: Buffers of a run without a record.
NO_RECORD = (_NOTHING, _NOTHING, np.empty(0, PEAK), np.empty(0, np.int64))


@define(eq=False)
class Record:
    """Record of the integration of a chain of equal granules; a run pauses when the arrays of the record are full.

    The scales of the errors of such a run are constant.

    Attributes
    ----------
    log : PeakLog
        All maxima of the contact forces.
    kinks : bool
        Whether steps end where contacts close or open. Nothing behind the waves of an endless chain affects them.
    bodies : int
        Number of bodies that move.
    kept : bool
        Whether the states at the ends of all steps are kept.
    continues : bool
        Whether the chain continues at rest beyond the arrays.
    since : float
        Time from which states are kept.
    spans : list of Span
        The steps, by NumPy.
    stretch : Stretch or None
        The states of the last run, if they are kept.
    states : array
        Room for the states of the next run, by compiled code.
    """

    log: PeakLog
    kinks: bool
    bodies: int
    kept: bool
    continues: bool = True
    since: float = 0.0
    spans: list[Span] = Factory(list)
    stretch: Stretch | None = None
    states: FloatArray = _NOTHING

    def is_full(self, bodies: int) -> bool:
        """Whether there is no room for another step by NumPy, or none for the front in arrays of so many bodies."""
        return len(self.spans) >= _MOST_STEPS or (self.continues and self.bodies >= bodies)

    def buffers(self, bodies: int) -> tuple[np.ndarray, ...]:
        """Arrays for the compiled code: numbers, states with time, positions and velocities, and the log."""
        self.log.reserve(4 * bodies, bodies)
        numbers = self.continues, self.kinks, self.since, self.log.strongest, self.log.count, 0, self.bodies
        if self.kept and (len(self.states) < _FEWEST_STEPS or self.states.shape[1] != 2 * bodies + 1):
            self.states = np.empty((_MOST_STEPS + 1, 2 * bodies + 1))
        return np.array(numbers, dtype=float), self.states, self.log.table, self.log.last

    def read(self, numbers: FloatArray) -> None:
        """Take what the compiled code has recorded."""
        self.log.strongest, peaks, kept, bodies = numbers[3:].tolist()
        self.log.count, self.bodies, self.stretch = int(peaks), int(bodies), None
        if kept:
            rows, last = self.states[: int(kept)], self.states.shape[1] // 2 + 1
            self.states = self.states[int(kept) :]
            self.stretch = Stretch((), rows[:, 0], rows[:, 1 : 1 + self.bodies], rows[:, last : last + self.bodies])

    def read_spans(self) -> None:
        """Log the steps by NumPy."""
        stretch, self.stretch = Stretch.of(*self.spans) if self.spans else None, None
        if stretch:
            self.log.observe(stretch)
            self.stretch = evolve(stretch, spans=(), x=stretch.x[:, : self.bodies], v=stretch.v[:, : self.bodies])
        self.spans.clear()
