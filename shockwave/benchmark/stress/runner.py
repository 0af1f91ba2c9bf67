"""Runs cases, each in a process of its own with a time limit, and gathers what came of them."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from attrs import frozen

from shockwave.benchmark.stress.case import Case, Finding
from shockwave.benchmark.stress.catalogue import find
from shockwave.simulation.backend import Backend, chosen, lack
from shockwave.text import table

__all__ = ["Row", "Stress", "run_case", "stress"]

_WORKER = "shockwave.benchmark.stress.worker"
_PROGRAM = f"import sys; sys.path[:] = {{path!r}}; from {_WORKER} import answer; answer({{name!r}}, {{backend!r}})"
_MOST_ERROR_TEXT, _WIDEST = 300, 60
#: Processes of cases that are running; they end with an interrupt.
_under_way: set[subprocess.Popen[bytes]] = set()


@frozen(kw_only=True)
class Row:
    """A case that was run.

    Attributes
    ----------
    name, theme, asked, must : str
        As of `Case`.
    backend : str
        Which code stepped the chain, compiled or numpy.
    outcome, error, bound, momentum_defect, faults
        As of `Finding`.
    seconds : float
        That it took in its process; differ from run to run.
    """

    name: str
    theme: str
    asked: str
    must: str
    backend: str
    outcome: str
    error: float | None
    bound: float | None
    momentum_defect: float | None
    faults: tuple[str, ...]
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether what must happen has happened."""
        return not self.faults

    @classmethod
    def of(cls, case: Case, backend: str, finding: Finding, seconds: float) -> Row:
        """The row of a finding; figures that are not finite become faults."""
        faults = list(finding.faults)
        figures: dict[str, float | None] = {}
        for name in ("error", "bound", "momentum_defect"):
            figures[name] = value = getattr(finding, name)
            if value is not None and not math.isfinite(value):
                figures[name] = None
                faults.append(f"{name.replace('_', ' ')} is {value}")
        return cls(
            name=case.name,
            theme=case.theme,
            asked=case.asked,
            must=case.must,
            backend=backend,
            outcome=finding.outcome,
            faults=tuple(faults),
            seconds=seconds,
            error=figures["error"],
            bound=figures["bound"],
            momentum_defect=figures["momentum_defect"],
        )

    def to_dict(self) -> dict[str, Any]:
        """The row as ``stress --json`` prints it."""
        return {
            "case": self.name,
            "theme": self.theme,
            "backend": self.backend,
            "asked": self.asked,
            "must": self.must,
            "passed": self.passed,
            "outcome": self.outcome,
            "error": self.error,
            "bound": self.bound,
            "momentum_defect": self.momentum_defect,
            "seconds": self.seconds,
            "faults": list(self.faults),
        }


@frozen(kw_only=True)
class Stress:
    """All that were run, in the order of the catalogue, and the seconds for all of them."""

    rows: tuple[Row, ...]
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether every case has passed."""
        return all(row.passed for row in self.rows)

    @property
    def exit_code(self) -> int:
        """0, or 1 where a case has failed."""
        return 0 if self.passed else 1

    def to_dict(self) -> dict[str, Any]:
        """What ``stress --json`` prints: no NaN."""
        return {"passed": self.passed, "seconds": self.seconds, "cases": [row.to_dict() for row in self.rows]}

    def __str__(self) -> str:
        header = ("case", "backend", "asked", "outcome", "error", "at most", "momentum", "time", "")
        failed = [row for row in self.rows if not row.passed]
        count = f"{len(self.rows) - len(failed)} of {len(self.rows)} passed in {self.seconds:.1f} s"
        lines = [table(header, map(_cells, self.rows)), ""]
        lines += [f"  {row.name} ({row.backend}): {fault}" for row in failed for fault in row.faults]
        return "\n".join([*lines, count])


def _cells(row: Row) -> tuple[str, ...]:
    def figure(value: float | None) -> str:
        return "-" if value is None else f"{value:.0e}"

    outcome = row.outcome.partition("\n")[0]
    return (
        row.name,
        row.backend,
        row.asked,
        outcome if len(outcome) <= _WIDEST else f"{outcome[: _WIDEST - 3]}...",
        figure(row.error),
        figure(row.bound),
        figure(row.momentum_defect),
        f"{row.seconds:.2f} s",
        "passed" if row.passed else "FAILED",
    )


def stress(names: Iterable[str] = (), backend: str | None = None, tell: Callable[[Row], None] | None = None) -> Stress:
    """Run cases of the catalogue.

    Parameters
    ----------
    names : iterable of str
        Of cases or themes; none for all.
    backend : "compiled", "numpy" or "auto", optional
        Left out, both codes, or NumPy alone where the other was not built.
    tell : callable, optional
        Called with each row as soon as it is known.

    Returns
    -------
    Stress
        The rows, case by case.

    Raises
    ------
    UnknownNameError
        When no case or theme has a name.
    InvalidValueError
        When the backend is unknown, or was not built.
    """
    cases, codes = find(names), _codes(backend)
    jobs = [(case, code) for case in cases for code in (codes if case.twice else codes[-1:])]
    begin = time.perf_counter()

    def one(job: tuple[Case, Backend]) -> Row:
        row = run_case(*job)
        if tell is not None:
            tell(row)
        return row

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        try:
            rows = tuple(pool.map(one, jobs))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in tuple(_under_way):
                process.kill()
            raise
    return Stress(rows=rows, seconds=time.perf_counter() - begin)


def _codes(backend: str | None) -> tuple[Backend, ...]:
    if backend is None:
        return ("numpy",) if lack() else ("compiled", "numpy")
    return ("numpy",) if chosen(backend) is None else ("compiled",)


def run_case(case: Case, backend: Backend) -> Row:
    """One case in a process of its own; one that hangs or crashes is a row that says so."""
    program = _PROGRAM.format(path=sys.path, name=case.name, backend=backend)
    begin = time.perf_counter()
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        _under_way.add(process)
        try:
            output, complaint = process.communicate(timeout=case.limit)
        except subprocess.TimeoutExpired:
            outcome = f"does not end: stopped after {case.limit:g} s"
            return Row.of(case, backend, Finding(outcome=outcome, faults=(outcome,)), time.perf_counter() - begin)
        finally:
            process.kill()
            _under_way.discard(process)
    seconds = time.perf_counter() - begin
    try:
        document = json.loads(output)
    except ValueError:
        outcome = _ending(process.returncode)
        lines = complaint.decode(errors="replace").strip().splitlines() or [outcome]
        return Row.of(case, backend, Finding(outcome=outcome, faults=(lines[-1][:_MOST_ERROR_TEXT],)), seconds)
    seconds = document.pop("seconds")
    document["faults"] = tuple(document["faults"])
    return Row.of(case, backend, Finding(**document), seconds)


def _ending(status: int) -> str:
    if status >= 0:
        return f"its process ended with status {status}"
    try:
        return f"its process crashed ({signal.Signals(-status).name})"
    except ValueError:
        return f"its process crashed (signal {-status})"
