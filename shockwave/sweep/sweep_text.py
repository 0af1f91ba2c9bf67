"""Text of sweeps for people: results, the report at the end, and the plan of a dry run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from shockwave.sweep.header import NOTES
from shockwave.sweep.journal import NOT_RUN
from shockwave.text import notes, si, table

if TYPE_CHECKING:
    from shockwave.sweep.report import SweepPlan, SweepReport
    from shockwave.sweep.results import SweepResults


# Failed points, and words of a column, that are listed.
_SHOWN = 5


def results_text(results: SweepResults) -> str:
    """The text of the results of a sweep."""
    status = results.values("status")
    done, run = (int(np.count_nonzero(of)) for of in (status == "done", status != NOT_RUN))
    head = f"  points  {status.size}: {done} done, {run - done} failed"
    lines = [f"sweep of {results.name}", f"  run     {results.run}", head]
    if not results.complete:
        lines[-1] += ", the others not run yet"
    shown = [column for column in results.columns if column.name != NOTES]
    parts = {
        "axis": {name: results.coordinate(name) for axis in results.axes for name in axis.names},
        "column": {column.name: results.values(column.name).ravel() for column in shown},
    }
    for kind, arrays in parts.items():
        rows = [(name, *_range(values, results.units[name])) for name, values in arrays.items()]
        text = table((kind, "least", "greatest", "values"), rows)
        lines += ["", *(f"  {line}" for line in text.splitlines())]
    remarks = [f"{_point(failure.point)}: {failure.problem}" for failure in results.failed[:_SHOWN]]
    if len(results.failed) > _SHOWN:
        remarks.append(f"and {len(results.failed) - _SHOWN} more have failed")
    noted = np.count_nonzero(results.values(NOTES) != "") if len(shown) < len(results.columns) else 0
    if noted:
        remarks.append(f"{noted} points have notes, in the column {NOTES}")
    return "\n".join(lines + notes([*remarks, *results.warnings]))


def _point(values: Mapping[str, Any]) -> str:
    texts = {name: f"{value:g}" if isinstance(value, float) else str(value) for name, value in values.items()}
    return ", ".join(f"{name} {text}" for name, text in texts.items())


def _range(values: npt.NDArray[Any], unit: str | None) -> tuple[str, str, str]:
    """Least, greatest and number of values, as text."""
    if unit is None:
        words, counts = np.unique(values[values != ""], return_counts=True)
        texts = [f"{count} {word}" for word, count in zip(words[:_SHOWN], counts, strict=False)]
        return "", "", ", ".join(texts + ["..."] * (len(words) > _SHOWN))
    known = values[np.isfinite(values)]
    if not known.size:
        return "", "", "0"
    low, high = (si(float(value), unit) if unit else f"{value:.5g}" for value in (known.min(), known.max()))
    return low, high, str(known.size)


def report_text(report: SweepReport) -> str:
    """The text of the report at the end of a sweep."""
    others = {"failed": report.failed, "crashed": report.crashed, "not run": report.left}
    head = f"{report.folder}: {report.done} of {report.points} points are done"
    head += "".join(f", {count} {state}" for state, count in others.items() if count)
    ran = report.points - report.left - report.before
    lines = [head, f"  now          {ran} run in {duration(report.seconds)}" if ran else "  now          nothing to do"]
    if report.batches:
        lines.append(f"  batches      {report.batches}, overhead of each {si(report.overhead, 's', 3)} of a worker")
    if report.before:
        lines.append(f"  before       {report.before}")
    if report.files:
        lines.append(f"  written      {', '.join(file.name for file in report.files)}")
    remarks = list(report.notes)
    if report.failed or report.crashed:
        remarks.append("errors stand in results.csv, column problem; --retry-failed runs these points again")
    return "\n".join(lines + notes(remarks))


def plan_text(plan: SweepPlan) -> str:
    """The text of the plan of a sweep."""
    shape = ", ".join(f"{length} of {names}" for names, length in plan.axes.items())
    tried = "" if plan.tried == plan.points else f" of {plan.tried} that were tried"
    lines = [
        f"{plan.points} points, {plan.run}: {shape}",
        f"  left out     {plan.finished} that are finished",
        f"  cannot be    {plan.unbuilt}{tried}" + (f": {plan.problem}" if plan.problem else ""),
    ]
    if plan.seconds is not None:
        low, high = map(duration, plan.seconds)
        span = low if low == high else f"{low} to {high}"
        lines.append(f"  will take    {span} on {plan.workers} workers, measured on {plan.measured} points")
    return "\n".join(lines + notes(plan.notes))


def duration(seconds: float) -> str:
    """A time for people, to two digits at most."""
    for unit, size in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.2g} s"
