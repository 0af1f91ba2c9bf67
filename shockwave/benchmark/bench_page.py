"""The page of work-precision diagrams and tables that `shockwave bench --output` writes, or its diagrams alone."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from attrs import evolve

from shockwave.benchmark import bench_table
from shockwave.benchmark.convergence_order import NAME
from shockwave.benchmark.work_precision import Problem, Row, WorkPrecision
from shockwave.errors import FileAccessError, UsageError
from shockwave.files import write_file
from shockwave.pictures import figure, svg, work_precision

# Width and height of a diagram [in]: its letters are readable on a phone too.
_WIDTH = 4.6
_HEIGHT = 4.8
# What HTML does not admit, and what reverses the direction of text.
_UNFIT = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")


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


def write(result: WorkPrecision, output: str) -> None:
    """Write the page, or for an ending ``.svg`` the diagrams under one another."""
    if Path(output).suffix.lower() == ".svg":
        panels = [panel for problem in result.problems for panel in _panels(result, problem)]
        write_file(output, '<?xml version="1.0" encoding="utf-8"?>\n' + _drawing(panels, "all"))
    else:
        write_file(output, page(result))


def page(result: WorkPrecision) -> str:
    """The page as HTML: every text is escaped, and nothing is loaded from elsewhere."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("shockwave.benchmark", ""),
        autoescape=True,
        finalize=_admitted,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    shown = [_shown(result, problem, f"p{number}") for number, problem in enumerate(result.problems)]
    orders = [bench_table.order_cells(order) for order in result.orders]
    template = environment.get_template("bench_page.html")
    return template.render(result=result, shown=shown, orders=orders, tables=bench_table, smooth_problem=NAME)


def _admitted(value: object) -> object:
    return _UNFIT.sub("\N{REPLACEMENT CHARACTER}", value) if type(value) is str else value


def _shown(result: WorkPrecision, problem: Problem, key: str) -> dict[str, Any]:
    """What the template shows of a problem; ``key`` begins the names within its drawings."""
    rows = result.of(problem)
    drawn = {row.method for row in rows if not row.problem}
    return {
        "problem": problem,
        "drawings": [_drawing([panel], f"{key}q{n}") for n, panel in enumerate(_panels(result, problem))],
        "failures": {row.method: row.problem for row in rows if row.method not in drawn},
        "table": [bench_table.cells(problem, row) for row in rows],
    }


class _Panel(NamedTuple):
    """A diagram: rows with one error alone, and what is asked for in place of the time."""

    title: str
    label: str
    by_evaluations: bool
    rows: list[Row]


def _panels(result: WorkPrecision, problem: Problem) -> list[_Panel]:
    """The diagrams of a problem: of all errors but that of the energy, which is no error of an answer.

    Quadratures have one error against time and against evaluations, for their areas and impulse err alike.
    """
    quantities = [name for name in problem.quantities if name != "energy"]
    wanted = [(name, False) for name in quantities]
    if problem.family == "quadratures":
        wanted = [(quantities[0], False), (quantities[0], True)]
    panels = []
    for quantity, by_evaluations in wanted:
        title = f"{problem.family}, {problem.name}: error of {quantity}"
        rows = []
        for row in result.of(problem):
            error, cost = row.errors.get(quantity), row.evaluations if by_evaluations else row.seconds
            if error is not None and cost:
                rows.append(evolve(row, errors={quantity: error}, seconds=float(cost)))
        if rows:
            panels.append(_Panel(title, f"relative error: {quantity} ({problem.name})", by_evaluations, rows))
    return panels


def _drawing(panels: Sequence[_Panel], name: str) -> str:
    """Diagrams under one another, as an SVG element whose inner names begin with ``name``."""
    count = max(len(panels), 1)
    drawn, places = figure(count, 1, (_WIDTH, _HEIGHT * count))
    for ax, panel in zip(places, panels, strict=False):
        work_precision(ax, panel.rows, panel.label)
        if panel.by_evaluations:
            from matplotlib.ticker import LogFormatterSciNotation

            ax.xaxis.set_major_formatter(LogFormatterSciNotation())
            ax.set_xlabel("evaluations")
        bottom, top = ax.get_ylim()
        if bottom < panel.rows[0].reference_error < top:
            ax.axhline(panel.rows[0].reference_error, color="0.4", linewidth=0.7, linestyle=(0, (4, 3)))
    return svg(drawn, name, "; ".join(panel.title for panel in panels))
