"""The table that `shockwave stress` prints."""

from __future__ import annotations

from shockwave.benchmark.stress import Row, Stress
from shockwave.text import table

_WIDEST = 60


def text(result: Stress) -> str:
    """A line for each row, the faults, and the count."""
    header = ("case", "backend", "asked", "outcome", "error", "at most", "momentum", "time", "")
    failed = [row for row in result.rows if not row.passed]
    faults = [f"  {row.case.name} ({row.backend}): {fault}" for row in failed for fault in row.finding.faults]
    count = f"{len(result.rows) - len(failed)} of {len(result.rows)} passed in {result.seconds:.1f} s"
    return "\n".join([table(header, map(_cells, result.rows)), "", *faults, count])


def _cells(row: Row) -> tuple[str, ...]:
    found = row.finding
    outcome = found.outcome.partition("\n")[0]
    return (
        row.case.name,
        row.backend,
        row.case.asked,
        outcome if len(outcome) <= _WIDEST else f"{outcome[: _WIDEST - 3]}...",
        *("-" if value is None else f"{value:.0e}" for value in (found.error, found.bound, found.momentum_defect)),
        "-" if row.seconds is None else f"{row.seconds:.2f} s",
        "passed" if row.passed else "FAILED",
    )
