"""The run of extreme cases, each in a process of its own with a time limit, and its rows."""

from __future__ import annotations

import os
import time
import traceback
from collections.abc import Iterable
from concurrent.futures import Future
from multiprocessing import get_context
from typing import Any

from attrs import asdict, frozen
from pebble import ProcessExpired, ProcessPool

from shockwave.benchmark.extreme_cases import CHECKS, Case, Finding, find
from shockwave.progress import progressed
from shockwave.simulation.backend import Backend, chosen, lack
from shockwave.text import table

# Of an outcome in the table.
_WIDEST = 60


@frozen
class Row:
    """A case that was run with a backend: its finding, and the seconds in its process, None where that ended early."""

    case: Case
    backend: str
    finding: Finding
    seconds: float | None = None

    @property
    def passed(self) -> bool:
        """Whether what must happen has happened."""
        return not self.finding.faults

    def to_dict(self) -> dict[str, Any]:
        """The row as ``stress --json`` prints it."""
        case = self.case
        return {
            "case": case.name,
            "theme": case.theme,
            "backend": self.backend,
            "asked": case.asked,
            "must": case.must,
            "passed": self.passed,
            **asdict(self.finding),
            "seconds": self.seconds,
        }

    def cells(self) -> list[str]:
        """The row as text, a cell for each column of the table."""
        found = self.finding
        outcome = found.outcome.partition("\n")[0]
        figures = (found.error, found.bound, found.momentum_defect)
        return [
            self.case.name,
            self.backend,
            self.case.asked,
            outcome if len(outcome) <= _WIDEST else f"{outcome[: _WIDEST - 3]}...",
            *("-" if value is None else f"{value:.0e}" for value in figures),
            "-" if self.seconds is None else f"{self.seconds:.2f} s",
            "passed" if self.passed else "FAILED",
        ]


@frozen
class Stress:
    """All rows in the order of the catalogue, and the seconds for all of them."""

    rows: tuple[Row, ...]
    seconds: float

    @property
    def exit_code(self) -> int:
        """0, or 1 where a case has failed."""
        return 0 if all(row.passed for row in self.rows) else 1

    def to_dict(self) -> dict[str, Any]:
        """The document that ``stress --json`` prints: no NaN."""
        cases = [row.to_dict() for row in self.rows]
        return {"passed": self.exit_code == 0, "seconds": self.seconds, "cases": cases}

    def __str__(self) -> str:
        """A line for each row, the faults, and the count."""
        header = ("case", "backend", "asked", "outcome", "error", "at most", "momentum", "time", "")
        lines = [table(header, [row.cells() for row in self.rows], margin=0), ""]
        for row in self.rows:
            name = f"{row.case.name} ({row.backend})"
            lines += [f"  {name}: {fault}" for fault in row.finding.faults]
        passed = sum(row.passed for row in self.rows)
        lines.append(f"{passed} of {len(self.rows)} passed in {self.seconds:.1f} s")
        return "\n".join(lines)


def stress(names: Iterable[str] = (), backend: str | None = None) -> Stress:
    """Run cases of the catalogue.

    Parameters
    ----------
    names : iterable of str
        Of cases or themes; none for all.
    backend : "compiled", "numpy" or "auto", optional
        Left out, both, or NumPy alone where the other was not built.

    Raises
    ------
    UnknownNameError
        When no case or theme has a name.
    InvalidValueError
        When the backend is unknown, or was not built.
    """
    backends = _backends(backend)
    jobs = []
    for case in find(names):
        own = backends if case.each_backend else backends[-1:]
        jobs += [(case, each) for each in own]
    begin = time.perf_counter()
    rows = []
    with ProcessPool(os.cpu_count() or 1, max_tasks=1, context=get_context("spawn")) as pool:
        futures = [pool.schedule(_in_process, (case.name, each), timeout=case.limit) for case, each in jobs]
        try:
            for (case, each), future in zip(jobs, futures, strict=True):
                row = _row(case, each, future)
                rows.append(row)
                progressed("stress", len(rows), len(jobs))
        except KeyboardInterrupt:
            pool.stop()  # type: ignore[no-untyped-call]
            raise
    return Stress(tuple(rows), time.perf_counter() - begin)


def _backends(backend: str | None) -> tuple[Backend, ...]:
    if backend is None:
        return ("numpy",) if lack() else ("compiled", "numpy")
    return ("numpy",) if chosen(backend) is None else ("compiled",)


def _in_process(name: str, backend: Backend) -> tuple[Finding, float]:
    (case,) = find([name])
    begin = time.perf_counter()
    return checked(case, backend), time.perf_counter() - begin


def checked(case: Case, backend: Backend) -> Finding:
    """The finding of a case; what its check raises is a fault."""
    try:
        return CHECKS[case.check](case, backend)
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return Finding(f"{type(error).__name__}: {error}", (f"raised in {place.name}, line {place.lineno}",))


def _row(case: Case, backend: str, future: Future[tuple[Finding, float]]) -> Row:
    """The row of a case; one that hangs or crashes says so."""
    try:
        return Row(case, backend, *future.result())
    except TimeoutError:
        outcome = f"does not end: stopped after {case.limit:g} s"
    except ProcessExpired as error:
        outcome = f"its process ended with status {error.exitcode}"
    return Row(case, backend, Finding(outcome, (outcome,)))
