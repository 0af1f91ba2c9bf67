"""Search for the leading waves of shocks, repeated with a smaller tolerance where the error estimate is too large."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.search_request import Primary, SearchStatus
from shockwave.engine.time_limit import expired
from shockwave.engine.wave_search import find_primaries, find_short
from shockwave.simulation.result_parts import Train
from shockwave.simulation.wave_setup import Setup

if TYPE_CHECKING:
    from types import ModuleType

    from shockwave.engine.nystroem_integrators import Nystroem

# Error estimate of a peak force in energy defects: if the whole defect were the leading wave's, F ~ E^(3/5) would give
# 1.7.
_DEFECTS = 2.0
# Contribution of the step tolerance to this estimate; the sum of both covered the error of 98 % of 400 shocks.
_TOLERANCE_SHARE = 0.3
# The same for records, at whose kinks the errors can cancel in the energy defect.
_RECORD_SHARE = 5.0
# Largest number of breakpoints of a smooth rise and a smooth decay.
_SMOOTH = 3
# Relative rounding error of a simulation.
_ROUNDING = 2e-13
# Relative rounding error of a float.
_EPSILON = 2e-16
# Largest number of repetitions of a search that does not meet its tolerance, each with a tolerance smaller by a decade.
_REPEATS = 2
# Largest tolerance in the repetitions of an inconclusive search, which are also allowed more work.
_LOOSEST = 1e-4
# A search is inconclusive if another wave may still exceed the leading wave by more than this fraction.
_OUTGROWN = 1e-3
#: Longest shock, in characteristic times, that is measured on the whole chain if the search has failed; the waves of
#: longer shocks are too similar to be separated there.
LONGEST_MEASURED = 60.0


class Answer(NamedTuple):
    """Leading wave with its error estimate; train and warnings if it was measured on the whole chain."""

    primary: Primary
    error_estimate: float
    train: Train | None = None
    warnings: tuple[str, ...] = ()


def search(problems: dict[int, ScaledProblem], setup: Setup) -> dict[int, Answer]:
    """Find the leading waves, with the keys of their problems; of several results, keep the most accurate."""
    if setup.search is None:
        return {}
    answers: dict[int, Answer] = {}
    tried: dict[int, Primary] = {}
    if len(problems) > 1 and setup.compiled is not None and not expired():
        answers, tried = _search_short(problems, setup, setup.search, setup.compiled)
    rest = {key: each for key, each in problems.items() if key not in answers} if answers else problems
    shares = {key: _tolerance_share(each) for key, each in rest.items()}
    # a tolerance whose contribution to the error estimate exceeds what was requested is not tried
    left = {key: int(shares[key] * setup.accuracy(each)[0] > setup.rtol) for key, each in rest.items()}
    unknown: dict[int, Primary] = {}
    repeats = 0
    while left and not expired():
        untried = [key for key in left if key not in tried]
        requests = [setup.request(problems[key], left[key], patient=repeats > 0) for key in untried]
        primaries = tried | dict(zip(untried, find_primaries(requests, setup.search, setup.compiled), strict=True))
        requested, left, tried = left, {}, {}
        for key, decades in requested.items():
            problem, primary = problems[key], primaries[key]
            if primary.status in (SearchStatus.KNOWN, SearchStatus.TOO_LONG) and primary.doubt < 1:
                error = _error(primary, problem.path.error, shares[key] * setup.accuracy(problem, decades)[0])
                if key not in answers or error < answers[key].error_estimate:
                    answers[key] = Answer(primary, error)
                if primary.doubt < _OUTGROWN:
                    if answers[key].error_estimate > setup.rtol and 0 <= decades < _REPEATS:
                        left[key] = decades + 1
                    continue
            elif primary.status not in (SearchStatus.TOO_LONG, SearchStatus.FAILED):
                continue
            unknown[key] = primary
            if setup.rtol_of(problem) * 10.0 ** (repeats - decades) <= _LOOSEST or not repeats:
                # while the force acts, rejected steps take most of the work: smaller ones take less
                left[key] = decades - repeats if repeats or primary.impulse else 1
        repeats += 1
    for key, primary in unknown.items():
        if problems[key].duration > LONGEST_MEASURED and primary.impulse and primary.peak:
            answers.setdefault(key, Answer(primary, 1.0))
    return answers


def _search_short(
    problems: dict[int, ScaledProblem], setup: Setup, method: type[Nystroem], compiled: ModuleType
) -> tuple[dict[int, Answer], dict[int, Primary]]:
    """Search once for the leading waves of short shocks, with `find_short`.

    Returns the answers that meet the tolerance, and the other leading waves.
    """
    answers: dict[int, Answer] = {}
    tried: dict[int, Primary] = {}
    by_exponent: dict[float, list[int]] = {}
    for key, problem in problems.items():
        if not problem.is_long:
            by_exponent.setdefault(problem.exponent, []).append(key)
    for keys in by_exponent.values():
        batch = [problems[key] for key in keys]
        shares = np.array([_tolerance_share(each) for each in batch])
        usual, tighter = setup.accuracy(batch[0]), setup.accuracy(batch[0], decades=1)
        tight = shares * usual[0] > setup.rtol
        tolerances, uncertainties = (np.where(tight, *pair) for pair in zip(tighter, usual, strict=True))
        rows, errors_of_paths = find_short(batch, tolerances, uncertainties, method, compiled)
        columns = Primary(*rows.T)
        with np.errstate(divide="ignore", invalid="ignore"):  # of searches without a result
            errors = _error(columns, errors_of_paths, shares * tolerances)
        meets = (columns.status == SearchStatus.KNOWN) & (columns.doubt < _OUTGROWN) & (errors <= setup.rtol)
        for key, row, error, known in zip(keys, rows.tolist(), errors.tolist(), meets.tolist(), strict=True):
            primary = Primary(*row)
            if known:
                answers[key] = Answer(primary, error)
            else:
                tried[key] = primary
    return answers, tried


def _error(primary: Primary, path_error: Any, step_error: Any) -> Any:
    """Relative error estimate of the peak force; ``step_error`` is the contribution of the step tolerance.

    The numbers may be arrays, with an element for each shock.
    """
    # The position of the first granule is the difference of the free-particle displacement and the chain's reaction.
    rounding = _ROUNDING + _EPSILON * primary.free_path
    step_error = step_error + _DEFECTS * primary.energy_defect
    return primary.doubt + step_error + path_error + rounding


def _tolerance_share(problem: ScaledProblem) -> float:
    """Contribution to the error estimate per unit of the step tolerance."""
    return _TOLERANCE_SHARE if len(problem.breakpoints) <= _SMOOTH else _RECORD_SHARE
