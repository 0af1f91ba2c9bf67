"""Search for the leading wave: the front is followed until the limit of its peak force is known.

The compiled code, which runs several shocks at a time, and `numpy_backend` implement the same algorithm.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from itertools import islice
from types import ModuleType

import numpy as np

from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.problem import Passage, Primary, Request
from shockwave.simulation.time_limit import expired

# Number of shocks that the compiled code runs at a time.
_WIDTH = 8
# Numbers found for each shock.
_NUMBERS = len(Primary._fields) - 1


def find_primaries(requests: Sequence[Request], method: type[Nystroem], compiled: ModuleType | None) -> list[Primary]:
    """The leading wave for each request, in order; ``compiled`` is the compiled module, or None for NumPy.

    A search that reaches the time limit has the status RUNNING.
    """
    if compiled is None:
        from shockwave.simulation.numpy_backend import search

        return [search(request, method()) for request in requests]
    if len(requests) == 1:
        return _search_compiled(compiled, method, requests)
    # Shocks of similar duration run together, so that none waits for a much longer one.
    groups: dict[float, list[tuple[float, int]]] = {}
    for index, request in enumerate(requests):
        groups.setdefault(request.problem.exponent, []).append((request.problem.duration, index))
    found: dict[int, Primary] = {}
    for group in groups.values():
        order = [index for _, index in sorted(group, reverse=True)]
        found |= zip(order, _search_compiled(compiled, method, [requests[index] for index in order]), strict=True)
    return [found[index] for index in range(len(requests))]


def _search_compiled(compiled: ModuleType, method: type[Nystroem], requests: Sequence[Request]) -> list[Primary]:
    """The leading waves by the compiled code, from tables with the columns that `_compiled.c` defines."""
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
    found = array("d", bytes(8 * _NUMBERS * len(requests)))
    lanes = 1 if len(requests) < _WIDTH else _WIDTH
    passages = array("d", wanted)
    tables = array("d", jobs), rows, coefficients, array("d", stops), passages, found
    packed = method.tableau.packed_for(requests[0].problem.exponent)
    compiled.primary(packed, *tables, lanes, expired)
    triples = zip(*[iter(passages)] * 3, strict=True)
    answers = []
    for numbers, request in zip(zip(*[iter(found)] * _NUMBERS, strict=True), requests, strict=True):
        own = islice(triples, len(request.contacts)) if request.contacts else ()
        reached = [Passage(int(contact), time, force) for contact, time, force in own if not math.isnan(time)]
        answers.append(Primary._make((*numbers, tuple(reached))))
    return answers
