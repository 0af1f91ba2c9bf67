"""Work-precision diagrams of a round: engine, codes made elsewhere and formulae on common axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from attrs import evolve

from shockwave.benchmark.rows import Problem, Row, WorkPrecision
from shockwave.pictures import figure, svg, work_precision

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Panel", "column", "drawing", "need_matplotlib", "panels_of"]

# Width and height of a diagram [in]: its letters are read on a phone too.
_WIDTH, _HEIGHT = 4.6, 4.8


class Panel(NamedTuple):
    """A diagram: an error of a problem against time, or against evaluations."""

    problem: Problem
    quantity: str
    by_evaluations: bool = False

    def rows(self, result: WorkPrecision) -> list[Row]:
        """What is drawn: rows with this error; in place of the time stand evaluations, where they are asked for."""
        found = []
        for row in result.of(self.problem):
            cost = row.evaluations if self.by_evaluations else row.seconds
            error = row.errors.get(self.quantity)
            if not row.problem and error is not None and cost:
                found.append(evolve(row, errors={self.quantity: error}, seconds=float(cost)))
        return found

    @property
    def title(self) -> str:
        """In words."""
        against = "evaluations" if self.by_evaluations else "time"
        return f"{self.problem.family}, {self.problem.name}: error of {self.quantity} against {against}"


def need_matplotlib() -> None:
    """Raise `UsageError` where there is none."""
    figure()


def panels_of(result: WorkPrecision, problem: Problem) -> list[Panel]:
    """The diagrams of a problem: of all errors but that of the energy, which is no error of an answer.

    Quadratures have one error against time and against evaluations, for their areas and impulse err alike.
    """
    first = problem.quantities[0]
    if problem.family == "quadratures":
        panels = [Panel(problem, first), Panel(problem, first, True)]
    else:
        panels = [Panel(problem, name) for name in problem.quantities if name != "energy"]
    return [panel for panel in panels if panel.rows(result)]


def column(result: WorkPrecision) -> str:
    """All diagrams under one another, as one SVG element."""
    return drawing(result, [panel for problem in result.problems for panel in panels_of(result, problem)], "all")


def drawing(result: WorkPrecision, panels: Sequence[Panel], name: str) -> str:
    """Diagrams under one another, as an SVG element.

    Parameters
    ----------
    result : WorkPrecision
        What was found.
    panels : sequence of Panel
        The diagrams; none gives an empty picture.
    name : str
        Letters, digits and hyphens that set its names apart from those of others on one page.
    """
    count = max(len(panels), 1)
    drawn, places = figure(count, 1, (_WIDTH, _HEIGHT * count))
    for ax, panel in zip(places, panels, strict=False):
        _draw(ax, panel, panel.rows(result))
    return svg(drawn, name, "; ".join(panel.title for panel in panels))


def _draw(ax: Axes, panel: Panel, rows: list[Row]) -> None:
    problem = panel.problem
    work_precision(ax, rows, f"relative error: {panel.quantity} ({problem.name})")
    if panel.by_evaluations:
        from matplotlib.ticker import LogFormatterSciNotation

        ax.xaxis.set_major_formatter(LogFormatterSciNotation())
        ax.set_xlabel("evaluations")
    bottom, top = ax.get_ylim()
    if bottom < problem.reference_error < top:
        ax.axhline(problem.reference_error, color="0.4", linewidth=0.7, linestyle=(0, (4, 3)))
