"""The run of extreme cases, each in a process of its own with a time limit, and its rows."""

from __future__ import annotations

import os
import signal
import time
import traceback
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from multiprocessing import get_context
from typing import Any

from attrs import asdict, frozen
from pebble import ProcessExpired, ProcessPool

from shockwave.benchmark.extreme_cases import Case, find
from shockwave.benchmark.extreme_checks import CHECKS, Finding
from shockwave.simulation.backend import Backend, chosen, lack
from shockwave.text import printed


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
        about = {"case": case.name, "theme": case.theme, "backend": self.backend, "asked": case.asked}
        found = {**asdict(self.finding), "faults": list(self.finding.faults), "seconds": self.seconds}
        return {**about, "must": case.must, "passed": self.passed, **found}


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
        """What ``stress --json`` prints: no NaN."""
        cases = [row.to_dict() for row in self.rows]
        return {"passed": self.exit_code == 0, "seconds": self.seconds, "cases": cases}

    def __str__(self) -> str:
        return printed(self, "shockwave.benchmark.stress_table:text")


def stress(
    names: Iterable[str] = (), backend: str | None = None, progress: Callable[[str], None] = lambda _: None
) -> Stress:
    """Run cases of the catalogue.

    Parameters
    ----------
    names : iterable of str
        Of cases or themes; none for all.
    backend : "compiled", "numpy" or "auto", optional
        Left out, both, or NumPy alone where the other was not built.
    progress : callable, optional
        Called with a line for each case that has ended.

    Raises
    ------
    UnknownNameError
        When no case or theme has a name.
    InvalidValueError
        When the backend is unknown, or was not built.
    """
    backends = _backends(backend)
    jobs = [(case, each) for case in find(names) for each in (backends if case.each_backend else backends[-1:])]
    begin = time.perf_counter()
    rows = []
    with ProcessPool(os.cpu_count() or 1, max_tasks=1, context=get_context("spawn")) as pool:
        try:
            futures = [pool.schedule(_in_process, (case.name, each), timeout=case.limit) for case, each in jobs]
            for (case, each), future in zip(jobs, futures, strict=True):
                rows.append(_row(case, each, future))
                progress(f"{case.name} ({each}): {'passed' if rows[-1].passed else 'FAILED'}")
        except BaseException:
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
        fault = f"raised in {place.name}, line {place.lineno}"
        return Finding(f"{type(error).__name__}: {error}", (fault,))


def _row(case: Case, backend: str, future: Future[tuple[Finding, float]]) -> Row:
    """The row of a case; one that hangs or crashes says so."""
    try:
        return Row(case, backend, *future.result())
    except TimeoutError:
        outcome = f"does not end: stopped after {case.limit:g} s"
    except ProcessExpired as error:
        crashed = error.exitcode < 0
        end = f"crashed ({signal.Signals(-error.exitcode).name})" if crashed else f"ended with status {error.exitcode}"
        outcome = f"its process {end}"
    return Row(case, backend, Finding(outcome, (outcome,)))
