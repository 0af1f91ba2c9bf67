"""Run of the extreme cases in worker processes, with a time limit for each case and backend, and the results."""

from __future__ import annotations

import os
import time
import traceback
from collections.abc import Iterable
from concurrent.futures import Future
from typing import Any

from attrs import asdict, frozen
from pebble import ProcessExpired, ProcessPool

from shockwave.base.progress import track
from shockwave.base.result import VERSION
from shockwave.base.text import alarm, limits, si, strong, table
from shockwave.benchmark.extreme_cases import CHECKS, Case, Finding, find_cases
from shockwave.engine.backend import Backend, compiled_code, lack
from shockwave.sweep.fork_server import start_server

# Modules that are loaded once, before the processes of the cases are forked.
_MODULES = (
    __name__,
    "shockwave.simulation.wave_train",
    "shockwave.profiles.free_path",
    "shockwave.engine.scipy_integrators",
)
# Relative uncertainty of the time of a single run.
_SINGLE = 0.3


@frozen
class Row:
    """Result of a case with a backend, and its run time [s]; None if its process ended early."""

    case: Case
    backend: str
    finding: Finding
    seconds: float | None = None

    @property
    def passed(self) -> bool:
        """Whether the result is as required."""
        return not self.finding.faults

    def to_dict(self) -> dict[str, Any]:
        """The row as ``stress --json`` prints it."""
        case = self.case
        return {
            "case": case.name,
            "theme": case.theme,
            "backend": self.backend,
            "asked": case.description,
            "must": case.must,
            "passed": self.passed,
            **asdict(self.finding),
            "seconds": self.seconds,
        }

    def cells(self) -> list[str]:
        """The row as text, a cell for each column of the table."""
        finding = self.finding
        return [
            self.case.name,
            self.backend,
            "passed" if self.passed else alarm("FAILED"),
            _cell(finding.error),
            _cell(finding.bound),
            "-" if self.seconds is None else si(self.seconds, "s", error=_SINGLE),
            self.case.description,
            _cell(finding.momentum_defect),
            finding.outcome.partition("\n")[0],
        ]

    def failures(self) -> list[str]:
        """A sentence for each fault."""
        finding = self.finding
        return [
            f"{self.case.name} ({self.backend}), {self.case.description}: {fault} (result: {finding.outcome}; "
            f"required: {self.case.must})"
            for fault in finding.faults
        ]


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:.0e}" if value else "0"


@frozen
class Stress:
    """All rows in the order of the catalogue, and the total run time [s]."""

    rows: tuple[Row, ...]
    seconds: float

    @property
    def exit_code(self) -> int:
        """1 if a case has failed, else 0."""
        return 0 if all(row.passed for row in self.rows) else 1

    def to_dict(self) -> dict[str, Any]:
        """The document that ``stress --json`` prints; it contains no NaN."""
        cases = [row.to_dict() for row in self.rows]
        return {**VERSION, "passed": self.exit_code == 0, "seconds": self.seconds, "cases": cases}

    def __str__(self) -> str:
        """The number of passed cases, the failures, and a table with the failed cases first."""
        header = ("case", "backend", "result", "error", "bound", "time", "description", "momentum", "outcome")
        rows = sorted(self.rows, key=lambda row: row.passed)
        passed = sum(row.passed for row in rows)
        time_taken = si(self.seconds, "s", error=_SINGLE)
        lines = [strong(f"{passed} of {len(rows)} cases passed ({time_taken})")]
        lines += limits(failure for row in rows for failure in row.failures())
        return "\n".join([*lines, "", table(header, [row.cells() for row in rows], header[3:])])


def stress(names: Iterable[str] = (), backend: str | None = None) -> Stress:
    """Run cases of the catalogue.

    Parameters
    ----------
    names : iterable of str
        Names of cases or themes. Default: all cases.
    backend : "compiled", "numpy" or "auto", optional
        Default: both backends, or NumPy only if the compiled code was not built.

    Raises
    ------
    UnknownNameError
        If a name is neither a case nor a theme.
    InvalidValueError
        If the backend is unknown or was not built.
    """
    backends = _backends(backend)
    jobs = [(case, each) for case in find_cases(names) for each in (backends if case.each_backend else backends[-1:])]
    begin = time.perf_counter()
    with ProcessPool(os.cpu_count() or 1, context=start_server(_MODULES)) as pool:
        futures = [pool.schedule(_check_by_name, (case.name, each), timeout=case.limit) for case, each in jobs]
        try:
            rows = [_row(*job, future) for job, future in zip(track("stress", jobs), futures, strict=True)]
        except KeyboardInterrupt:
            pool.stop()  # type: ignore[no-untyped-call]
            raise
    return Stress(tuple(rows), time.perf_counter() - begin)


def _backends(backend: str | None) -> tuple[Backend, ...]:
    if backend is None:
        return ("numpy",) if lack() else ("compiled", "numpy")
    return ("numpy",) if compiled_code(backend) is None else ("compiled",)


def _check_by_name(name: str, backend: Backend) -> tuple[Finding, float]:
    (case,) = find_cases([name])
    begin = time.perf_counter()
    return check(case, backend), time.perf_counter() - begin


def check(case: Case, backend: Backend) -> Finding:
    """The finding of a case; an exception of its check is a fault."""
    try:
        return CHECKS[case.check](case, backend)
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return Finding(f"{type(error).__name__}: {error}", (f"raised in {place.name}, line {place.lineno}",))


def _row(case: Case, backend: Backend, future: Future[tuple[Finding, float]]) -> Row:
    """The row of a run, also of one that hangs or crashes."""
    try:
        return Row(case, backend, *future.result())
    except TimeoutError:
        outcome = f"stopped at the time limit of {case.limit:g} s"
    except ProcessExpired as error:
        outcome = f"the process ended with status {error.exitcode}"
    return Row(case, backend, Finding(outcome, (outcome,)))
