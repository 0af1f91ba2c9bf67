"""Search for the leading wave: the front is followed until the limit of its peak force is known.

The compiled code, which runs several shocks at a time, and `wave_search_numpy` implement the same algorithm.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from itertools import chain, islice
from types import ModuleType

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.engine.nystroem_integrators import Nystroem
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.search_request import Passage, Primary, SearchRequest, short_limits
from shockwave.engine.time_limit import expired
from shockwave.scene.solitary_wave import wave_law

# Number of shocks that the compiled code runs at a time.
_WIDTH = 8
# Numbers found for each shock.
_NUMBERS = len(Primary._fields) - 1
# Number of columns of the table of jobs, JOB in `_lane.h`.
_COLUMNS = 27
# Table without requested contacts.
_NONE = np.empty(0)


def find_primaries(
    requests: Sequence[SearchRequest], method: type[Nystroem], compiled: ModuleType | None
) -> list[Primary]:
    """The leading wave for each request, in order; ``compiled`` is the compiled module, or None for NumPy.

    A search that reaches the time limit has the status RUNNING.
    """
    if compiled is None:
        from shockwave.engine.wave_search_numpy import search

        return [search(request, method()) for request in requests]
    if len(requests) == 1:
        return _search_compiled(compiled, method, requests)
    # Shocks of similar duration run together, so that none waits for a much longer one.
    groups: dict[float, list[tuple[float, int]]] = {}
    for index, request in enumerate(requests):
        groups.setdefault(request.problem.exponent, []).append((request.problem.duration, index))
    primaries: dict[int, Primary] = {}
    for group in groups.values():
        order = [index for _, index in sorted(group, reverse=True)]
        primaries |= zip(order, _search_compiled(compiled, method, [requests[index] for index in order]), strict=True)
    return [primaries[index] for index in range(len(requests))]


def find_short(
    problems: Sequence[ScaledProblem],
    tolerances: FloatArray,
    uncertainties: FloatArray,
    method: type[Nystroem],
    compiled: ModuleType,
) -> tuple[FloatArray, FloatArray]:
    """Find the leading waves of short shocks on chains with the same contact law; the table of jobs is made in arrays.

    ``tolerances`` and ``uncertainties`` are ``tolerance`` and ``doubt`` of each `SearchRequest`. Returns a row for each
    shock, with the numbers of `Primary`, and the errors of the free-particle displacements.
    """
    count, exponent = len(problems), problems[0].exponent
    numbers = np.array([(each.rise_time, each.peak_force, each.duration, each.granules or 0) for each in problems])
    order = np.argsort(-numbers[:, 2], kind="stable")
    sorted_problems = [problems[index] for index in order.tolist()]
    paths = [each.path for each in sorted_problems]
    rows, coefficients = [path.rows for path in paths], [path.coefficients for path in paths]
    stops = [each.stops for each in sorted_problems]
    jobs = np.zeros((count, _COLUMNS))
    jobs[:, :4], jobs[:, 4], jobs[:, 5] = numbers[order], tolerances[order], uncertainties[order]
    for column, limits in enumerate(short_limits(jobs[:, 2], wave_law(exponent).spread), start=6):
        jobs[:, column] = limits
    # PIECES; FIRST_PIECE, FIRST_COEFFICIENT and FIRST_STOP
    jobs[:, -5] = list(map(len, rows))
    for column, parts in ((-6, rows), (-4, coefficients), (-3, stops)):
        jobs[1:, column] = np.cumsum(list(map(len, parts)))[:-1]
    table = np.zeros((count, _NUMBERS))
    all_stops = array("d", chain.from_iterable(stops))
    tables = jobs, np.concatenate(rows), np.concatenate(coefficients), all_stops, _NONE, table
    lanes = 1 if count < _WIDTH else _WIDTH
    compiled.primary(method.tableau.pack_for(exponent), *tables, lanes, expired)
    results, errors = np.empty_like(table), np.empty(count)
    results[order], errors[order] = table, [path.error for path in paths]
    return results, errors


def _search_compiled(compiled: ModuleType, method: type[Nystroem], requests: Sequence[SearchRequest]) -> list[Primary]:
    """The leading waves by the compiled code, from tables with the columns that `_lane.h` defines."""
    jobs: list[float] = []
    stops: list[float] = []
    wanted: list[float] = []
    pieces = terms = 0
    for request in requests:
        problem = request.problem
        path = problem.path
        jobs += (problem.rise_time, problem.peak_force, problem.duration, problem.granules or 0)
        jobs += (request.tolerance, request.doubt, *request.limits, *problem.above)
        jobs += (pieces, len(path.rows), terms, len(stops), len(wanted) // 3, len(request.contacts))
        pieces += len(path.rows)
        terms += len(path.coefficients)
        stops += problem.stops
        for contact in request.contacts:
            wanted += (contact, math.nan, math.nan)
    paths = [request.problem.path for request in requests]
    rows, coefficients = paths[0].rows, paths[0].coefficients
    if len(paths) > 1:
        rows = np.concatenate([path.rows for path in paths])
        coefficients = np.concatenate([path.coefficients for path in paths])
    numbers = array("d", bytes(8 * _NUMBERS * len(requests)))
    lanes = 1 if len(requests) < _WIDTH else _WIDTH
    passages = array("d", wanted)
    tables = array("d", jobs), rows, coefficients, array("d", stops), passages, numbers
    packed = method.tableau.pack_for(requests[0].problem.exponent)
    compiled.primary(packed, *tables, lanes, expired)
    triples = zip(*[iter(passages)] * 3, strict=True)
    answers = []
    for row, request in zip(zip(*[iter(numbers)] * _NUMBERS, strict=True), requests, strict=True):
        times_and_forces = islice(triples, len(request.contacts)) if request.contacts else ()
        reached = [
            Passage(int(contact), time, force) for contact, time, force in times_and_forces if not math.isnan(time)
        ]
        answers.append(Primary._make((*row, tuple(reached))))
    return answers
