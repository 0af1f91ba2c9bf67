"""The catalogue: all cases, by their themes."""

from __future__ import annotations

from collections.abc import Iterable

from shockwave.benchmark.stress import chains, collisions, records, shapes, sizes
from shockwave.benchmark.stress.case import Case
from shockwave.errors import UnknownNameError

__all__ = ["CASES", "find"]

#: Every case, in the order in which they are told.
CASES: tuple[Case, ...] = (*shapes.CASES, *sizes.CASES, *chains.CASES, *records.CASES, *collisions.CASES)


def find(names: Iterable[str]) -> tuple[Case, ...]:
    """The cases of these names, or of the themes among them, in the order of the catalogue; all for no name.

    Raises
    ------
    UnknownNameError
        For a name that is neither.
    """
    wanted = set(names)
    known = [*dict.fromkeys(case.theme for case in CASES), *(case.name for case in CASES)]
    for name in sorted(wanted - set(known)):
        raise UnknownNameError("case", name, known)
    return tuple(case for case in CASES if not wanted or {case.name, case.theme} & wanted)
