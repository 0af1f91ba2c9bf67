"""Output of `shockwave bench`: the tables that it prints, and the page of work-precision diagrams."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TypeAlias

from attrs import evolve

from shockwave.benchmark.families import SMOOTH
from shockwave.benchmark.work_precision import Problem, Row, WorkPrecision
from shockwave.errors import FileAccessError, UsageError
from shockwave.pictures import figure, svg, work_precision
from shockwave.text import admitted, indent, si, table

_ORDER_COLUMNS = ("method", "declared", "fitted")
# Width and height of a diagram [in]: its letters are readable on a phone too.
_SIZE = (4.6, 4.8)
_Diagram: TypeAlias = tuple[list[Row], str]


def text(result: WorkPrecision) -> str:
    """All rows, problem by problem."""
    parts = []
    for problem in result.problems:
        reference = f"{problem.reference}, off by at most {problem.reference_error:.0e}"
        head = f"{problem.family}: {problem.name}\n  {problem.description}\n  reference: {reference}"
        parts += [head, indent(table(_columns(problem), _cells(result, problem)))]
    if result.orders:
        parts += ["orders, on a smooth problem", indent(table(_ORDER_COLUMNS, _order_cells(result)))]
    return "\n\n".join(parts)


def _columns(problem: Problem) -> list[str]:
    errors = [f"error: {name}" for name in problem.quantities]
    return ["method", "setting", *errors, "time", "spread", "evaluations", "note"]


def _cells(result: WorkPrecision, problem: Problem) -> list[list[str]]:
    """The rows of a problem as text, a cell for each column."""
    return [_row_cells(row, problem.quantities) for row in result.of(problem)]


def _row_cells(row: Row, quantities: tuple[str, ...]) -> list[str]:
    errors = [row.errors.get(name) for name in quantities]
    spread = "-"
    if row.least is not None and row.most is not None:
        spread = f"{si(row.least, 's', 4)} .. {si(row.most, 's', 4)}"
    return [
        row.method,
        row.setting,
        *("-" if error is None else f"{error:.1e}" for error in errors),
        "-" if row.seconds is None else si(row.seconds, "s", 4),
        spread,
        "-" if row.evaluations is None else str(row.evaluations),
        row.problem,
    ]


def _order_cells(result: WorkPrecision) -> list[list[str]]:
    return [
        [order.method, str(order.declared), "-" if order.fitted is None else f"{order.fitted:.2f}"]
        for order in result.orders
    ]


def check_output(output: str) -> None:
    """Refuse an output that cannot be written, before a long round.

    Raises
    ------
    UsageError
        When it is neither a page (.html) nor figures (.svg), or matplotlib is missing.
    FileAccessError
        When it cannot be written there.
    """
    path = Path(output)
    if path.suffix.lower() not in (".html", ".htm", ".svg"):
        raise UsageError(f"output must end in .html or .svg (got {path.name!r})")
    figure()
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        raise FileAccessError(f"{path}: cannot be written (must be a file in a folder that is writable)")


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
        order_columns=_ORDER_COLUMNS,
        orders=_order_cells(result),
        smooth_problem=SMOOTH,
    )


def document(result: WorkPrecision, output: str) -> str:
    """Text of the file ``output``: the page, or for an ending ``.svg`` all diagrams under one another."""
    if not output.lower().endswith(".svg"):
        return page(result)
    diagrams = [one for problem in result.problems for one in _diagrams(result, problem)]
    return '<?xml version="1.0" encoding="utf-8"?>\n' + _drawing(diagrams, "all")


def _drawings(result: WorkPrecision, problem: Problem) -> list[str]:
    """The diagrams of a problem as SVG elements."""
    first = f"p{result.problems.index(problem)}q"
    return [_drawing([one], f"{first}{number}") for number, one in enumerate(_diagrams(result, problem))]


def _diagrams(result: WorkPrecision, problem: Problem) -> list[_Diagram]:
    """Rows and title of the diagrams of a problem, one for each error."""
    diagrams = []
    for quantity in problem.quantities:
        errors = [(row, row.errors.get(quantity)) for row in result.of(problem)]
        rows = [evolve(row, errors={quantity: error}) for row, error in errors if error is not None]
        if rows:
            diagrams.append((rows, f"relative error: {quantity} ({problem.name})"))
    return diagrams


def _drawing(diagrams: list[_Diagram], name: str) -> str:
    """Diagrams under one another as an SVG element whose inner names begin with ``name``."""
    width, height = _SIZE
    drawn, axes = figure(rows=len(diagrams), size=(width, height * len(diagrams)))
    for ax, (rows, title) in zip(axes, diagrams, strict=True):
        work_precision(ax, rows, title)
        bottom, top = ax.get_ylim()
        error = rows[0].reference_error
        if bottom < error < top:
            ax.axhline(error, color="0.4", linewidth=0.7, linestyle=(0, (4, 3)))
    return svg(drawn, name, "; ".join(title for _, title in diagrams))
