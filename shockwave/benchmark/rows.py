"""Work-precision as an object: a row for each method at each setting, with what it found or why it did not."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from attrs import converters, field, frozen

from shockwave.benchmark.timing import Tried
from shockwave.text import indent, si, table

__all__ = [
    "FAMILIES",
    "Order",
    "Problem",
    "Row",
    "WorkPrecision",
    "cells",
    "columns",
    "order",
    "setting_text",
    "worst",
]

FAMILIES = ("quadratures", "predictors", "integrators")

# Errors below so many times what the reference may be off are not the method's alone.
_ABOVE_REFERENCE = 30.0
# Of the slopes between neighbouring steps, how far they may be apart in the convergent range; the finest so many steps.
_ALIKE, _FINEST = 0.25, 4
_COST = ("time", "spread", "evaluations", "note")


def worst(*errors: float) -> float:
    """The greatest of the errors; NaN if any is, which ``max`` would pass over."""
    return float(np.max(errors))


@frozen(kw_only=True)
class Problem:
    """What is solved, in words, and how well its answer is known.

    ``reference_error`` is relative, and ``reference`` says where the reference is from. ``quantities`` are the names
    of the errors that rows carry, the one that is drawn first.
    """

    family: str
    name: str
    description: str
    quantities: tuple[str, ...]
    reference: str
    reference_error: float

    def to_dict(self) -> dict[str, Any]:
        """As in the JSON document."""
        return {
            "family": self.family,
            "name": self.name,
            "description": self.description,
            "quantities": list(self.quantities),
            "reference": self.reference,
            "reference_error": self.reference_error,
        }


@frozen(kw_only=True)
class Row:
    """A method at a setting, on a problem.

    Attributes
    ----------
    family, case, method, setting : str
        Of the problem, and what was run; ``value`` is the setting as a number, None where there is none to choose.
    errors : dict of float or None
        Relative errors by quantity, those of the problem; None for a quantity that the method does not tell, and for
        one that is not finite, of which ``problem`` speaks.
    seconds, least, most : float or None
        Median, shortest and longest of ``runs`` runs [s].
    evaluations, steps : int or None
        Of the integrand, or of the acceleration of the chain.
    reference_error : float
        What the reference may be off, relatively: errors as small say nothing more.
    problem : str
        Why there is nothing; "" where there is something.
    """

    family: str
    case: str
    method: str
    setting: str
    value: float | None
    errors: dict[str, float | None] = field(factory=dict)
    seconds: float | None = None
    least: float | None = None
    most: float | None = None
    runs: int = 0
    evaluations: int | None = field(default=None, converter=converters.optional(int))
    steps: int | None = field(default=None, converter=converters.optional(int))
    reference_error: float = 0.0
    problem: str = ""

    def __attrs_post_init__(self) -> None:
        wrong = [name for name, error in self.errors.items() if error is not None and not math.isfinite(error)]
        if wrong:
            object.__setattr__(self, "errors", {**self.errors, **dict.fromkeys(wrong)})
            object.__setattr__(self, "problem", self.problem or "not finite")

    @classmethod
    def of(
        cls,
        problem: Problem,
        method: str,
        setting: str,
        tried: Tried[Any, Any],
        value: float | None = None,
        **told: Any,
    ) -> Row:
        """The row of what was ``tried``; ``told`` are its errors and its cost."""
        return cls(
            family=problem.family,
            case=problem.name,
            method=method,
            setting=setting,
            value=value,
            seconds=tried.seconds,
            least=tried.least,
            most=tried.most,
            runs=tried.runs,
            reference_error=problem.reference_error,
            problem=tried.problem,
            **told,
        )

    @property
    def error(self) -> float | None:
        """The error that is drawn: that of the problem's first quantity."""
        return next(iter(self.errors.values()), None)

    def to_dict(self) -> dict[str, Any]:
        """As in the JSON document: no NaN."""
        return {
            "family": self.family,
            "case": self.case,
            "method": self.method,
            "setting": self.setting,
            "value": self.value,
            "errors": dict(self.errors),
            "seconds": self.seconds,
            "least": self.least,
            "most": self.most,
            "runs": self.runs,
            "evaluations": self.evaluations,
            "steps": self.steps,
            "reference_error": self.reference_error,
            "problem": self.problem or None,
        }


@frozen(kw_only=True)
class Order:
    """The slope of a method of fixed step on a smooth problem, beside the order that it declares.

    ``fitted`` is None where too few steps lie in the convergent range.
    """

    method: str
    declared: int
    fitted: float | None


def order(rows: Iterable[Row]) -> float | None:
    """The order of a method of fixed step: the slope of its error over the convergent range.

    The range is made of the finest steps whose errors stand clear of the reference's and fall from step to step at the
    same rate; the slope of log error against log step is fitted to them.

    Parameters
    ----------
    rows : iterable of Row
        Of one method on one smooth problem, their ``value`` the step.

    Returns
    -------
    float or None
        None where fewer than three steps lie in the range.
    """
    clear = sorted(
        (row.value, row.error)
        for row in rows
        if row.value and row.error is not None and row.error > _ABOVE_REFERENCE * row.reference_error
    )
    if len(clear) < 3:
        return None
    steps, errors = np.log(np.array(clear[:_FINEST])).T
    slopes = np.diff(errors) / np.diff(steps)
    alike = 1
    while alike < len(slopes) and abs(slopes[alike] - slopes[0]) <= _ALIKE:
        alike += 1
    if alike < 2:
        return None
    return float(np.polyfit(steps[: alike + 1], errors[: alike + 1], 1)[0])


@frozen(kw_only=True)
class WorkPrecision:
    """What accuracy costs: problems, rows, orders, and on what machine it was found.

    There is no winner: which method is best depends on the error that one can bear, and on the problem.
    """

    problems: tuple[Problem, ...]
    rows: tuple[Row, ...]
    orders: tuple[Order, ...]
    provenance: dict[str, str]

    def of(self, problem: Problem) -> list[Row]:
        """The rows of a problem."""
        return [row for row in self.rows if (row.family, row.case) == (problem.family, problem.name)]

    def to_dict(self) -> dict[str, Any]:
        """What ``bench --json`` prints: no NaN."""
        return {
            "provenance": dict(self.provenance),
            "problems": [problem.to_dict() for problem in self.problems],
            "rows": [row.to_dict() for row in self.rows],
            "orders": [
                {"method": found.method, "declared": found.declared, "fitted": found.fitted} for found in self.orders
            ],
        }

    def table(self) -> str:
        """All rows for people, problem by problem."""
        parts = [_part(problem, self.of(problem)) for problem in self.problems]
        if self.orders:
            rows = ((o.method, str(o.declared), "-" if o.fitted is None else f"{o.fitted:.2f}") for o in self.orders)
            parts.append("orders, on a smooth problem\n\n" + indent(table(("method", "declared", "fitted"), rows)))
        return "\n\n".join(parts)

    __str__ = table


def _part(problem: Problem, rows: Sequence[Row]) -> str:
    head = [
        f"{problem.family}: {problem.name}",
        f"  {problem.description}",
        f"  reference: {problem.reference}, off by at most {problem.reference_error:.0e}",
        "",
    ]
    return "\n".join([*head, indent(table(columns(problem), (cells(problem, row) for row in rows)))])


def columns(problem: Problem) -> tuple[str, ...]:
    """The heads of the columns of a problem's table."""
    return ("method", "setting", *(f"error: {name}" for name in problem.quantities), *_COST)


def cells(problem: Problem, row: Row) -> tuple[str, ...]:
    """A row as text, a cell for each column of the table."""
    return (
        row.method,
        row.setting,
        *(_error(row.errors.get(name)) for name in problem.quantities),
        "-" if row.seconds is None else si(row.seconds, "s", 4),
        "-" if row.least is None or row.most is None else f"{si(row.least, 's', 4)} .. {si(row.most, 's', 4)}",
        "-" if row.evaluations is None else str(row.evaluations),
        row.problem,
    )


def setting_text(what: str, value: float | None) -> str:
    """A setting in words: steps as they are, tolerances as powers of ten."""
    if value is None:
        return "-"
    return f"{what} {value:.3g}" if what == "step" else f"{what} {value:.0e}"


def _error(error: float | None) -> str:
    return "-" if error is None or not math.isfinite(error) else f"{error:.1e}"
