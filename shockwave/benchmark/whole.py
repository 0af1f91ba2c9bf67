"""The whole chain as a first-order system, as a code that knows nothing of shockwave is given it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
from attrs import frozen

from shockwave.benchmark.chains import FLOOR, Case, Reading, energy
from shockwave.benchmark.timing import Clock
from shockwave.errors import NumericalError
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.triangular import Triangular
from shockwave.quadrature import FloatArray
from shockwave.simulation.problem import contact_forces

__all__ = ["Piece", "PowerPulse", "Solve", "Whole"]

# Runs go on beyond the peak for so long, in natural times, and this share of the time: a loose one is late.
_BEYOND, _LATE = 1.0, 0.02
# Newton's corrections of the time of the peak, and one that leaves no error but rounding in the force.
_CORRECTIONS, _NEAR = 30, 1e-6


class Piece(NamedTuple):
    """What a solver gives of an interval: its steps' ends, the states there, shape (steps + 1, 2 granules).

    ``evaluations`` is None where the code does not tell.
    """

    times: FloatArray
    states: FloatArray
    evaluations: int | None


class Solve(Protocol):
    """Solves from ``begin`` to ``end``, between which the force is smooth."""

    def __call__(self, begin: float, end: float, state: FloatArray, tolerance: float) -> Piece: ...


class PowerPulse(NamedTuple):
    """A power-law pulse, for code that is compiled: s^rise on [0, 1], ((n - s)/(n - 1))^decay on [1, n]."""

    rise_time: float
    ratio: float
    rise: float
    decay: float
    peak_force: float


@frozen(eq=False, slots=False)
class Whole:
    """A chain of ``granules`` at rest, the pulse, and when the peak at the contact of ``case`` is due."""

    case: Case
    due: float

    @property
    def granules(self) -> int:
        """Their number: more than the front has reached when it is read."""
        return self.case.granules

    @property
    def until(self) -> float:
        """When a run may end."""
        return (1 + _LATE) * self.due + _BEYOND

    @property
    def power(self) -> PowerPulse:
        """The pulse as a power law.

        Raises
        ------
        NumericalError
            When it is none.
        """
        problem, profile = self.case.problem, self.case.problem.profile
        if isinstance(profile, PowerLaw):
            exponents = profile.rise_exponent, profile.decay_exponent
        elif isinstance(profile, Triangular):
            exponents = 1.0, 1.0
        else:
            raise NumericalError(f"offered for power laws only, not for {type(profile).__name__}")
        return PowerPulse(problem.rise_time, profile.duration_ratio, *exponents, problem.peak_force)

    @cached_property
    def force(self) -> Callable[[float], float]:
        """The force of the pulse at a time."""
        problem = self.case.problem
        try:
            rise_time, ratio, rise, decay, peak = self.power
        except NumericalError:
            return lambda time: float(problem.peak_force * problem.profile.force(time / problem.rise_time))

        def force(time: float) -> float:
            s = time / rise_time
            if s <= 1:
                return float(peak * max(s, 0.0) ** rise)
            return float(peak * (max(ratio - s, 0.0) / (ratio - 1)) ** decay)

        return force

    @cached_property
    def ends(self) -> tuple[float, ...]:
        """Where runs begin anew: at the start, at the kinks of the force, and the end."""
        return (0.0, *(stop for stop in self.case.problem.stops if stop < self.until), self.until)

    def rates(self, time: float, state: FloatArray) -> FloatArray:
        """The right-hand side: displacements first, then velocities."""
        granules = self.granules
        result = np.empty_like(state)
        result[:granules] = state[granules:]
        overlap = np.maximum(state[: granules - 1] - state[1:granules], 0.0)
        force = overlap * np.sqrt(overlap)
        result[granules] = self.force(time) - force[0]
        np.subtract(force[:-1], force[1:], out=result[granules + 1 : -1])
        result[-1] = force[-1]
        return result

    def run(self, solve: Solve, tolerance: float, clock: Clock) -> Reading:
        """The front, read where the velocities at the contact are equal, by steps made anew to that time.

        Raises
        ------
        NumericalError
            When the solver fails, or takes too long, or there is no peak.
        """
        state = np.zeros(2 * self.granules)
        held: float | None = None
        drift: float | None = None
        evaluations: int | None = 0
        steps, found = 0, None
        for begin, end in pairwise(self.ends):
            piece = solve(begin, end, state, tolerance)
            clock.check()
            state = piece.states[-1]
            if not np.all(np.isfinite(state)):
                raise NumericalError("not finite")
            steps += len(piece.times) - 1
            evaluations = _sum(evaluations, piece.evaluations)
            step = None if found is not None else self._front(piece)
            if step is not None:
                found = self._top(piece, step, solve, tolerance)
                drift = None if held is None else abs(self._energy(piece.states[step + 1]) / held - 1)
            if end == self.case.problem.duration:
                held = self._energy(state)
        if found is None:
            raise NumericalError(f"no peak at contact {self.case.contact} by t = {self.until:.4g} T0, when one is due")
        return Reading(*found, drift, evaluations, steps)

    def _energy(self, state: FloatArray) -> float:
        return energy(state[: self.granules], state[self.granules :])

    def _front(self, piece: Piece) -> int | None:
        """The step in which the force at the contact has its first maximum, if it has one."""
        contact = self.case.contact
        closing = self._closing(piece)
        overlap = np.maximum(piece.states[:, contact] - piece.states[:, contact + 1], 0.0)
        tops = np.nonzero((closing[:-1] > 0) & (closing[1:] <= 0) & (overlap[1:] ** 1.5 > FLOOR))[0]
        return int(tops[0]) if len(tops) else None

    def _closing(self, piece: Piece) -> FloatArray:
        """How fast the contact closes, at each step's end."""
        place = self.granules + self.case.contact
        return np.asarray(piece.states[:, place] - piece.states[:, place + 1])

    def _top(self, piece: Piece, step: int, solve: Solve, tolerance: float) -> tuple[float, float]:
        """Peak force and its time by Newton's method, within a step and from its beginning each time.

        At a loose tolerance a step is as long as the whole wave: where Newton's method leads out of the interval in
        which the maximum is known to be, that is halved.
        """
        contact, granules = self.case.contact, self.granules
        begin, end = piece.times[step : step + 2].tolist()
        before, after = self._closing(piece)[step : step + 2].tolist()
        state = piece.states[step]
        time, low, high = begin + (end - begin) * before / (before - after), begin, end
        for _ in range(_CORRECTIONS):
            y = solve(begin, time, state, tolerance).states[-1]
            closing = float(y[granules + contact] - y[granules + contact + 1])
            forces = np.concatenate(([self.force(time)], contact_forces(y[:granules]), [0.0]))
            slowing = float(2 * forces[contact + 1] - forces[contact] - forces[contact + 2])
            low, high = (time, high) if closing > 0 else (low, time)
            shift = closing / slowing if slowing > 0 else math.inf
            if abs(shift) < _NEAR:
                overlap = float(y[contact] - y[contact + 1]) + shift * (closing - shift * slowing / 2)
                return math.pow(max(overlap, 0.0), 1.5), time + shift
            time = time + shift if low < time + shift < high else (low + high) / 2
        raise NumericalError(f"the time of the peak at contact {contact} is not found: the tolerance is too loose")


def _sum(one: int | None, other: int | None) -> int | None:
    return None if one is None or other is None else one + other
