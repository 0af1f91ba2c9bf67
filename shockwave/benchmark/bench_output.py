"""Output of `shockwave bench`: the tables that it prints, and the page of work-precision diagrams."""

from __future__ import annotations

from pathlib import Path

from attrs import evolve

from shockwave.benchmark.work_precision import Problem, Row, WorkPrecision
from shockwave.errors import UsageError
from shockwave.pictures import figure, svg, work_precision
from shockwave.text import admitted, si, table

# Width and height of a diagram [in]: its letters are readable on a phone too.
_SIZE = (4.6, 4.8)


def text(result: WorkPrecision) -> str:
    """All rows, problem by problem."""
    parts = []
    for problem in result.problems:
        reference = f"{problem.reference}, off by at most {problem.reference_error:.0e}"
        head = f"{problem.family}: {problem.name}\n  {problem.description}\n  reference: {reference}"
        parts += [head, table(_columns(problem), _cells(result, problem))]
    return "\n\n".join(parts)


def _columns(problem: Problem) -> list[str]:
    errors = [f"error: {name}" for name in problem.quantities]
    return ["method", "setting", *errors, "time", "spread", "evaluations", "note"]


def _cells(result: WorkPrecision, problem: Problem) -> list[list[str]]:
    """The rows of a problem as text, a cell for each column."""
    lines = []
    for row in result.of(problem):
        errors = [row.errors.get(name) for name in problem.quantities]
        shown = ["-" if error is None else f"{error:.1e}" for error in errors]
        times = ["-" if value is None else si(value, "s", 4) for value in (row.seconds, row.least, row.most)]
        spread = "-" if row.least is None else f"{times[1]} .. {times[2]}"
        evaluations = "-" if row.evaluations is None else str(row.evaluations)
        lines.append([row.method, row.setting, *shown, times[0], spread, evaluations, row.problem])
    return lines


def check_output(output: str) -> None:
    """Refuse an output that cannot be written, before a long round.

    Raises
    ------
    UsageError
        When it is no page (.html), or matplotlib is missing.
    """
    path = Path(output)
    if path.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"output must end in .html (got {path.name!r})")
    figure()


def page(result: WorkPrecision) -> str:
    """The page as HTML: every text is escaped, and nothing is loaded from elsewhere."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("shockwave.benchmark", ""),
        autoescape=True,
        finalize=lambda value: admitted(value) if type(value) is str else value,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("bench_page.html").render(
        result=result,
        columns=_columns,
        cells=_cells,
        drawings=_drawings,
    )


def _drawings(result: WorkPrecision, problem: Problem) -> list[str]:
    """The diagrams of a problem as SVG elements, one for each error that is known."""
    index = result.problems.index(problem)
    drawings = []
    for number, quantity in enumerate(problem.quantities):
        errors = [(row, row.errors.get(quantity)) for row in result.of(problem)]
        rows = [evolve(row, errors={quantity: error}) for row, error in errors if error is not None]
        if rows:
            title = f"relative error: {quantity} ({problem.name})"
            # inner names of an element differ from those of the others on the page
            drawings.append(_drawing(rows, title, f"p{index}q{number}"))
    return drawings


def _drawing(rows: list[Row], title: str, name: str) -> str:
    drawn, (ax,) = figure(size=_SIZE)
    work_precision(ax, rows, title)
    bottom, top = ax.get_ylim()
    error = rows[0].reference_error
    if bottom < error < top:
        ax.axhline(error, color="0.4", linewidth=0.7, linestyle=(0, (4, 3)))
    return svg(drawn, name, title)
