"""Runs of a chain with decreasing tolerances, and the error estimates that their differences give."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from shockwave.base.errors import NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_motion import ChainMotion, integrate
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.result_parts import ContactPeak
from shockwave.simulation.wave_setup import UNSETTLED, warn_step

# Tolerances of a step of two runs whose difference gives the error of the first, over the requested relative error, the
# least tolerances, and that of the coarse run with which the arrival of a wave is found, unless rtol is larger.
_FINE = 0.1
_COARSE = 10.0
_LEAST_FINE = 1e-13
_LEAST_COARSE = 1e-12
_LARGEST_COARSE = 1e-5
# Least error tolerance of a step, and its factor from run to run.
_TIGHTEST = 1e-15
_TIGHTER = 0.1
# Largest number of runs: two show the error, each further one corrects a result that misses its tolerance. None
# follows if the error would still exceed the tolerance by this factor after the last one: collisions may amplify errors
# without limit.
_RUNS = 6
_HOPELESS = 10.0
# Error estimate of a force, over the largest difference of the last two runs at this number of contacts on both sides,
# for it may vanish by chance at one of them. Where the tolerance decides about another run, it is the difference there
# or this share of those around, over this and the ratio of the tolerances, to which the errors are nearly proportional.
# research/check/check_chains.py measures how often both hold.
_FACTOR = 2.0
_NEIGHBOURS = 3
_PROPORTIONAL = 20.0
_NEIGHBOUR_SHARE = 0.2
# Substitute for the ratio of the tolerances if two runs have fixed steps, of which one is twice the other: a method of
# order 2 has a third of their difference as error, others less.
_STEPS_RATIO = 1 / _PROPORTIONAL
# Factor of the estimate with damping, which ends abruptly when a contact opens.
_DAMPED = 2.0
# Error estimate of the impulse on a wall, over its difference between two runs: the errors of both may be of the same
# order, since late collisions amplify them, so that the difference may be small by chance.
_IMPULSE_FACTOR = 10.0
# Relative rounding error of a total force.
_ROUNDING = 1e-14
# Tightest tolerance of a force, over its total; errors are relative to no smaller dynamic part than this one allows.
_LEAST_OF_TOTAL = 1e-12
#: Dynamic part below which a force has no relative error of its own, over the largest dynamic part; above zero even if
# no contact ever closes.
NEGLIGIBLE = 1e-9
_TINY = 1e-300
# Error of the time of a peak, in characteristic times, that is allowed over the tolerance of the force.
_TIME_SHARE = 10.0
# Larger differences of the times of two runs, in characteristic times, belong to different peaks of about equal force.
_OTHER_PEAK = 0.5

# Numbers of a `ContactPeak`.
_PEAK = "contact", "peak_force", "time", "error_estimate", "static_force", "residual_overlap"


class Runs(NamedTuple):
    """The best of several runs.

    Attributes
    ----------
    case : ChainSetup
        The chain.
    motion : ChainMotion
        The best run.
    errors : array, shape (contacts,)
        Error estimates of its greatest forces, relative to their dynamic parts.
    end_errors : array, shape (3,) or (0,)
        Relative error estimates of the greatest displacement, acceleration and spring force of a movable end.
    impulse_error : float
        Error estimate of the impulse at the last contact, relative to it.
    missed : bool
        Whether a force that the result shows, or its time, misses the tolerance.
    steps, evaluations : int
        Cost of all runs.
    """

    case: ChainSetup
    motion: ChainMotion
    errors: FloatArray
    end_errors: FloatArray
    impulse_error: float
    missed: bool
    steps: int
    evaluations: int

    @property
    def reached(self) -> float:
        """Largest error for which the tolerance holds."""
        judged = self.case.judged_contacts(self.motion.forces)
        return float(np.append(self.errors[judged], self.judged_end_errors).max())

    @property
    def judged_end_errors(self) -> FloatArray:
        """Errors of the motion of a movable end, unless the force on it is negligible."""
        forces = self.motion.dynamic_forces
        return self.end_errors if forces[-1] > NEGLIGIBLE * forces.max() else np.empty(0)

    @property
    def greatest(self) -> ContactPeak:
        """The greatest of all forces."""
        return self.peak(int(np.argmax(self.motion.forces)))

    @property
    def reported(self) -> tuple[ContactPeak, ...]:
        """The greatest forces at the reported contacts."""
        return tuple(ContactPeak(**numbers) for numbers in self.numbers_at(self.case.reported))

    def peak(self, contact: int) -> ContactPeak:
        """The greatest force at a contact."""
        return ContactPeak(**self.numbers_at(np.array([contact % len(self.errors)]))[0])

    def numbers_at(self, contacts: npt.NDArray[np.intp]) -> list[dict[str, Any]]:
        """Numbers of the `ContactPeak` of each of these contacts."""
        scales, motion, static_forces = self.case.scales, self.motion, self.case.layout.static_forces
        forces, times = motion.forces[contacts] * scales.contact_force, motion.force_times[contacts] * scales.time
        columns = [contacts, forces, times, self.errors[contacts], static_forces[contacts]]
        if motion.residual_overlaps is not None:
            columns.append(scales.energy / scales.force * motion.residual_overlaps[contacts])
        rows = zip(*(column.tolist() for column in columns), strict=True)
        return [dict(zip(_PEAK, row, strict=False)) for row in rows]


def runs_of(case: ChainSetup) -> Runs:
    """Integrate a chain with smaller and smaller tolerances until the difference of two runs shows that they are met.

    Raises
    ------
    NumericalError
        If the first two runs fail or reach the time limit.
    """
    tolerance, looser = accuracies_of(case)
    fixed = case.options.step is not None
    coarse = run(case, looser, case.until)
    steps, evaluations = coarse.steps, coarse.evaluations
    best: Runs | None = None
    for left in reversed(range(_RUNS - 1)):
        try:
            fine = run(case, tolerance, coarse.end)
        except NumericalError:
            if best is None:
                raise
            break
        steps, evaluations = steps + fine.steps, evaluations + fine.evaluations
        least, ratio = (0.0, _STEPS_RATIO) if fixed else (tolerance, tolerance / looser)
        errors, missed = _errors(case, coarse, fine, least, ratio)
        end_errors = _end_errors(case, coarse, fine, least, ratio)
        if best is not None:  # two runs can agree by chance
            errors = np.maximum(errors, tolerance / looser * best.errors)
            end_errors = np.maximum(end_errors, tolerance / looser * best.end_errors)
        change = abs(fine.last_impulse - coarse.last_impulse)
        impulse_error = _IMPULSE_FACTOR * change / max(abs(fine.last_impulse), _TINY) + least
        latest = Runs(case, fine, errors, end_errors, impulse_error, missed, steps, evaluations)
        if latest.judged_end_errors.max(initial=0.0) > _allowed_error(case):
            missed, latest = True, latest._replace(missed=True)
        if best is None or latest.reached < best.reached:
            best = latest
        if fixed or not missed or tolerance <= _TIGHTEST or latest.reached * _TIGHTER**left > _HOPELESS * case.rtol:
            break
        coarse, looser, tolerance = fine, tolerance, max(tolerance * _TIGHTER, _TIGHTEST)
    assert best is not None
    return best._replace(steps=steps, evaluations=evaluations)


def warn_missed(runs: Runs) -> list[str]:
    """Warning if a force that decides, or its time, does not meet the tolerance."""
    if not runs.missed:
        return []
    if runs.case.options.step is not None:
        return [warn_step(runs.case.options)]
    judged = runs.case.judged_contacts(runs.motion.forces)
    worst = int(judged[np.argmax(runs.errors[judged])])
    if runs.judged_end_errors.max(initial=0.0) > max(runs.errors[worst], runs.case.rtol):
        missed = f"the relative error of the motion of the wall is estimated as {runs.end_errors.max():.1e}"
        return [f"The tolerance was not met: {missed} (rtol {runs.case.rtol:.1e})."]
    missed = f"the relative error of the greatest force at contact {worst} is estimated as {runs.errors[worst]:.1e}"
    if runs.errors[worst] <= runs.case.rtol:
        missed = "the time of a greatest force may be wrong by more than 10 rtol of the characteristic time"
    return [f"The tolerance was not met: {missed} (rtol {runs.case.rtol:.1e})."]


def _allowed_error(case: ChainSetup) -> float:
    """Relative error that is allowed, or not warned of with a fixed step."""
    return case.rtol if case.options.step is None else UNSETTLED


def accuracies_of(case: ChainSetup) -> tuple[float, float]:
    """Tolerances, or fixed steps, of the run whose results count, and of a coarser one."""
    step = case.options.step
    return tolerances_for(case.rtol) if step is None else (step, 2 * step)


def tolerances_for(rtol: float) -> tuple[float, float]:
    """Tolerances of the run whose results count, and of a coarser one from which its errors are estimated.

    In 99 % of random chains the errors of the first run are below ``rtol`` where that applies. In the others, as in
    collisions that amplify errors, the estimate exceeds ``rtol``: then repeat with a smaller one.
    """
    coarse = max(min(_COARSE * rtol, _LARGEST_COARSE), _FINE * rtol, _LEAST_COARSE)
    return min(max(_FINE * rtol, _LEAST_FINE), _TIGHTER * coarse), coarse


def run(
    case: ChainSetup,
    accuracy: float,
    until: float | None,
    times: FloatArray | tuple[()] = (),
    rows: npt.NDArray[np.int64] | None = None,
) -> ChainMotion:
    """One run with a tolerance, or a fixed step, to ``until``, with samples of ``rows``, or all, at ``times``."""
    code, method = case.compiled, case.method
    return integrate(case.assembly, accuracy, until=until, times=times, rows=rows, compiled=code, integrator=method)


def _errors(
    case: ChainSetup, coarse: ChainMotion, fine: ChainMotion, tolerance: float, ratio: float
) -> tuple[FloatArray, bool]:
    """Relative error estimates of the forces at all contacts, and whether one that counts exceeds its tolerance.

    ``tolerance`` is that of the step of the fine run, ``ratio`` its ratio to that of the coarse one.
    """
    forces, dynamic, rtol = fine.forces, fine.dynamic_forces, _allowed_error(case)
    least = max(NEGLIGIBLE * float(dynamic.max()), _TINY)
    base = np.maximum(np.maximum(dynamic, least), _LEAST_OF_TOTAL / rtol * forces)
    changes, judged = np.abs(dynamic - coarse.dynamic_forces), case.judged_contacts(forces)
    here, near = changes / base, np.zeros(len(base))
    for shift in range(1, _NEIGHBOURS + 1):
        larger = np.maximum(base[shift:], base[:-shift])
        near[shift:] = np.maximum(near[shift:], changes[:-shift] / larger)
        near[:-shift] = np.maximum(near[:-shift], changes[shift:] / larger)
    relative = _FACTOR * np.maximum(here, near)
    factor = _PROPORTIONAL * ratio
    # the errors of a fixed step differ more from contact to contact, since it is not shortened for a collision
    share, most = (_NEIGHBOUR_SHARE, _HOPELESS * rtol) if case.options.step is None else (1.0, UNSETTLED)
    decisive = np.maximum(here, share * near)[judged]
    # where collisions amplify errors this much, these are not proportional to the tolerances
    relative[judged] = decisive * np.where(factor * decisive > most, max(factor, _FACTOR), factor)
    caution = _DAMPED if case.assembly.damping.any() else 1.0
    floor = caution * tolerance + (0.0 if case.assembly.force is None else case.assembly.force.path.error)
    errors = caution * relative + floor + _ROUNDING * forces / base
    errors[forces <= 0] = 0.0
    late = np.abs(fine.force_times - coarse.force_times)[judged]
    late = late[late < _OTHER_PEAK].max(initial=0.0)
    return errors, bool(errors[judged].max() > rtol or factor * late > _TIME_SHARE * rtol)


def _end_errors(case: ChainSetup, coarse: ChainMotion, fine: ChainMotion, tolerance: float, ratio: float) -> FloatArray:
    """Relative error estimates of the motion of a movable end, shape (3,), as of a contact that decides; else empty."""
    if not case.assembly.movable_end:
        return np.empty(0)
    changes = np.abs(fine.extremes[0] - coarse.extremes[0]) / np.maximum(fine.extremes[0], _TINY)
    changes = np.maximum(changes, _NEIGHBOUR_SHARE * changes.max())
    shock = case.assembly.force
    return np.asarray(_DAMPED * (_PROPORTIONAL * ratio * changes + tolerance) + (shock.path.error if shock else 0.0))
