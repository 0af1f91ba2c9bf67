"""Output of `shockwave bench`: the printed tables, and the page of work-precision diagrams."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from attrs import evolve

from shockwave.base.text import facts, html_of, limits, notes, si, strong, table
from shockwave.benchmark.work_precision import Problem, Row, WorkPrecision
from shockwave.pictures import figure, svg, work_precision

# Width and height of a diagram [in]: its text is readable on a phone too.
_SIZE = (4.6, 4.8)
# Relative error of the runs that are compared at the top: the default tolerance of a simulation.
_TARGET = 1e-6
# Least relative uncertainty of a time, and that of a single run.
_REPRODUCIBLE = 0.01
_SINGLE = 0.3


def text(result: WorkPrecision) -> str:
    """The fastest accurate run of each problem, then the table of each problem."""
    fastest, missing = _find_fastest(result)
    lines = [strong(f"Fastest runs with relative errors of at most {_TARGET:.0e}"), *limits(missing)]
    if fastest:
        lines += ["", table(("problem", "method", "setting", "error", "time"), fastest)]
    for problem in result.problems:
        reference = f"{problem.reference}; relative error at most {problem.reference_error:.0e}"
        lines += ["", f"{problem.family}: {problem.name}"]
        lines += facts((("problem", problem.description), ("reference", reference)))
        rows = result.of(problem)
        if cells := [_cells(row, problem) for row in rows if row.seconds is not None]:
            lines += ["", "  Relative errors and median times:"]
            lines.append(table(_columns(problem), cells, (*problem.quantities[1:], "evaluations", "spread")))
        failed = groupby((row for row in rows if row.problem), lambda row: (row.method, row.problem))
        lines += notes(f"{method}, {', '.join(row.setting for row in of)}: {why}" for (method, why), of in failed)
    return "\n".join(lines)


def _find_fastest(result: WorkPrecision) -> tuple[list[list[str]], list[str]]:
    """Cells of the fastest run on each problem that meets the target, and a sentence where there is none."""
    fastest, missing = [], []
    for problem in result.problems:
        name = f"{problem.family}: {problem.name}"
        rows = [row for row in result.of(problem) if row.seconds and not row.problem]
        accurate = [row for row in rows if _largest_error(row) <= _TARGET]
        if accurate:
            row = min(accurate, key=lambda row: row.seconds or 0.0)
            fastest.append([name, row.method, row.setting, f"{_largest_error(row):.1e}", _times(row)[0]])
        elif rows:
            row = min(rows, key=_largest_error)
            best = f"{_largest_error(row):.1e} by {row.method}, {row.setting}"
            missing.append(f"{name}: no run is as accurate; the smallest error is {best}")
        else:
            missing.append(f"{name}: no run succeeded")
    return fastest, missing


def _largest_error(row: Row) -> float:
    """The largest relative error; no smaller than that of the reference."""
    return max([row.reference_error, *(error for error in row.errors.values() if error is not None)])


def _columns(problem: Problem) -> list[str]:
    return ["method", "setting", *problem.quantities, "time", "spread", "evaluations"]


def _cells(row: Row, problem: Problem) -> list[str]:
    """The row of a run as text, a cell for each column."""
    bound = f"<{row.reference_error:.0e}"
    errors = [row.errors.get(name) for name in problem.quantities]
    shown = ["-" if each is None else f"{each:.1e}" if each > row.reference_error else bound for each in errors]
    return [row.method, row.setting, *shown, *_times(row), str(row.evaluations or "-")]


def _times(row: Row) -> tuple[str, str]:
    """Median time and its range, with the digits that the range allows."""
    if row.seconds is None or row.least is None or row.most is None:
        return "-", "-"
    spread = (row.most - row.least) / row.seconds if row.runs > 1 else _SINGLE
    error = max(spread, _REPRODUCIBLE)
    median, least, most = (si(time, "s", error=error) for time in (row.seconds, row.least, row.most))
    return median, f"{least} .. {most}"


def page(result: WorkPrecision) -> str:
    """The page as HTML; nothing is loaded from other places."""
    template = Path(__file__).with_name("bench_page.html")
    return html_of(template, result=result, columns=_columns, cells=_cells, drawings=_drawings)


def _drawings(result: WorkPrecision, problem: Problem) -> list[str]:
    """The diagrams of a problem as SVG elements, one for each quantity with known errors."""
    index = result.problems.index(problem)
    drawings = []
    for number, quantity in enumerate(problem.quantities):
        errors = [(row, row.errors.get(quantity)) for row in result.of(problem)]
        rows = [evolve(row, errors={quantity: error}) for row, error in errors if error is not None]
        if rows:
            title = f"relative error: {quantity} ({problem.name})"
            canvas, (ax,) = figure(size=_SIZE)
            work_precision(rows, title, ax=ax)
            bottom, top = ax.get_ylim()
            if bottom < problem.reference_error < top:
                ax.axhline(problem.reference_error, color="0.4", linewidth=0.7, linestyle=(0, (4, 3)))
            # ids must be unique within the page
            drawings.append(svg(canvas, f"p{index}q{number}", title))
    return drawings
