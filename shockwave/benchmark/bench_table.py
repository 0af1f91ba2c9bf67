"""The tables that `shockwave bench` prints."""

from __future__ import annotations

from shockwave.benchmark.work_precision import Order, Problem, Row, WorkPrecision
from shockwave.text import indent, si, table

ORDER_COLUMNS = ("method", "declared", "fitted")


def text(result: WorkPrecision) -> str:
    """All rows, problem by problem."""
    parts = [_part(problem, result.of(problem)) for problem in result.problems]
    if result.orders:
        orders = table(ORDER_COLUMNS, map(order_cells, result.orders))
        parts.append(f"orders, on a smooth problem\n\n{indent(orders)}")
    return "\n\n".join(parts)


def _part(problem: Problem, rows: list[Row]) -> str:
    head = [
        f"{problem.family}: {problem.name}",
        f"  {problem.description}",
        f"  reference: {problem.reference}, off by at most {problem.reference_error:.0e}",
        "",
    ]
    return "\n".join([*head, indent(table(columns(problem), (cells(problem, row) for row in rows)))])


def columns(problem: Problem) -> tuple[str, ...]:
    """The heads of the columns of a problem's table."""
    errors = (f"error: {name}" for name in problem.quantities)
    return ("method", "setting", *errors, "time", "spread", "evaluations", "note")


def cells(problem: Problem, row: Row) -> tuple[str, ...]:
    """A row as text, a cell for each column of the table."""
    errors = (row.errors.get(name) for name in problem.quantities)
    spread = "-"
    if row.least is not None and row.most is not None:
        spread = f"{si(row.least, 's', 4)} .. {si(row.most, 's', 4)}"
    return (
        row.method,
        row.setting,
        *("-" if error is None else f"{error:.1e}" for error in errors),
        "-" if row.seconds is None else si(row.seconds, "s", 4),
        spread,
        "-" if row.evaluations is None else str(row.evaluations),
        row.problem,
    )


def order_cells(order: Order) -> tuple[str, ...]:
    """An order as text, a cell for each of `ORDER_COLUMNS`."""
    return order.method, str(order.declared), "-" if order.fitted is None else f"{order.fitted:.2f}"
