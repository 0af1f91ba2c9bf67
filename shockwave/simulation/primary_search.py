"""Search for the leading wave: the front is followed until the limit of its peak force is known.

The compiled code, which runs several shocks at a time, and `numpy_backend` implement the same algorithm.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import islice
from types import ModuleType

import numpy as np

from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.problem import Passage, Primary, Request
from shockwave.simulation.time_limit import expired

# Number of shocks that the compiled code runs at a time.
_WIDTH = 8
# Shorter shocks take about as long as one of this duration, in characteristic times.
_SHORT = 16.0


def find_primaries(requests: Sequence[Request], method: type[Nystroem], compiled: ModuleType | None) -> list[Primary]:
    """The leading wave for each request, in order; ``compiled`` is the compiled module, or None for NumPy.

    A search that reaches the time limit has the status RUNNING.
    """
    if compiled is None:
        from shockwave.simulation.numpy_backend import search

        return [search(request, method()) for request in requests]
    # Shocks with similar run times are grouped, so that none waits for a much longer one.
    groups: dict[tuple[float, int], list[int]] = {}
    for index, request in enumerate(requests):
        decade = int(math.log(max(request.problem.duration, _SHORT), 4))
        groups.setdefault((request.problem.exponent, decade), []).append(index)
    found: dict[int, Primary] = {}
    for group in groups.values():
        group.sort(key=lambda index: requests[index].problem.duration, reverse=True)
        answers = _search_compiled(compiled, method, [requests[index] for index in group])
        found |= zip(group, answers, strict=True)
    return [found[index] for index in range(len(requests))]


def _search_compiled(compiled: ModuleType, method: type[Nystroem], requests: list[Request]) -> list[Primary]:
    """The leading waves by the compiled code, from tables with the columns that `_compiled.c` defines."""
    jobs: list[float] = []
    stops: list[float] = []
    wanted: list[int] = []
    pieces = terms = 0
    for request in requests:
        problem = request.problem
        path = problem.path
        jobs += (problem.rise_time, problem.peak_force, problem.duration, problem.granules or 0)
        jobs += (request.tolerance, request.doubt, request.max_contacts, request.max_work)
        jobs += (request.rear, request.earliest_time, request.growing, *request.above)
        jobs += (pieces, len(path.rows), terms, len(stops), len(wanted), len(request.contacts))
        pieces += len(path.rows)
        terms += len(path.coefficients)
        stops += problem.stops
        wanted += request.contacts
    rows = np.concatenate([request.problem.path.rows for request in requests])
    coefficients = np.concatenate([request.problem.path.coefficients for request in requests])
    found = np.zeros((len(requests), len(Primary._fields) - 1))
    passages = np.full((len(wanted), 3), math.nan)
    passages[:, 0] = wanted
    lanes = 1 if len(requests) < _WIDTH else _WIDTH
    tables = np.array(jobs), rows, coefficients, np.array(stops), passages, found
    packed = method.tableau.packed_for(requests[0].problem.exponent)
    compiled.primary(packed, *tables, lanes, expired)
    triples = iter(passages.tolist())
    answers = []
    for numbers, request in zip(found.tolist(), requests, strict=True):
        own = islice(triples, len(request.contacts))
        reached = tuple(Passage(int(contact), time, force) for contact, time, force in own if not math.isnan(time))
        answers.append(Primary._make([*numbers, reached]))
    return answers
