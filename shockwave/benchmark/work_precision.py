"""Work-precision data: problems, and a row for each method at each setting with its error and its cost."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from attrs import asdict, field, frozen

from shockwave.text import printed

# Errors below this multiple of the reference error are not the method's alone.
_ABOVE_REFERENCE = 30.0
# The number of finest steps from which an order is read.
_FINEST = 4


@frozen
class Problem:
    """A problem in words, and how accurate its reference is.

    ``reference_error`` is relative, and ``reference`` states how the reference was obtained. ``quantities`` are the
    names of the errors in rows; the first is drawn first.
    """

    family: str
    name: str
    description: str
    quantities: tuple[str, ...]
    reference: str
    reference_error: float


@frozen
class Row:
    """A method at a setting, on a problem.

    Attributes
    ----------
    family, case, method, setting : str
        The problem, and what was run; ``value`` is the setting as a number, None where there is none to choose.
    errors : dict of float or None
        Relative errors by quantity; None where the error is not finite.
    seconds, least, most : float or None
        Median, shortest and longest of ``runs`` runs [s].
    evaluations, steps : int or None
        Of the integrand, or of the acceleration of the chain.
    reference_error : float
        Relative error of the reference: smaller errors carry no information.
    problem : str
        Why there is no answer; "" where there is one.
    """

    family: str
    case: str
    method: str
    setting: str = "-"
    value: float | None = None
    errors: dict[str, float | None] = field(factory=dict)
    seconds: float | None = None
    least: float | None = None
    most: float | None = None
    runs: int = 0
    evaluations: int | None = None
    steps: int | None = None
    reference_error: float = 0.0
    problem: str = ""

    @property
    def error(self) -> float | None:
        """The error that is drawn: that of the problem's first quantity."""
        return next(iter(self.errors.values()), None)


@frozen
class Order:
    """The observed order of a method of fixed step beside the declared one.

    ``fitted`` is None where too few steps have an error to read.
    """

    method: str
    declared: int
    fitted: float | None


@frozen(kw_only=True)
class WorkPrecision:
    """What accuracy costs: on what machine it was measured, problems, rows, and observed orders."""

    provenance: dict[str, str]
    problems: tuple[Problem, ...]
    rows: tuple[Row, ...]
    orders: tuple[Order, ...]

    def of(self, problem: Problem) -> list[Row]:
        """The rows of a problem."""
        return [row for row in self.rows if (row.family, row.case) == (problem.family, problem.name)]

    def to_dict(self) -> dict[str, Any]:
        """The document that ``bench --json`` prints: no NaN."""
        document = asdict(self)
        for row in document["rows"]:
            row["problem"] = row["problem"] or None
        return document

    def __str__(self) -> str:
        return printed(self, "shockwave.benchmark.bench_output:text")


def observed_order(rows: Sequence[Row]) -> float | None:
    """The order of a method of fixed step: the slope of log error against log step over the finest steps.

    Left out are steps whose errors do not lie well above that of the reference.

    Parameters
    ----------
    rows : sequence of Row
        One method on one smooth problem; ``value`` is the step.

    Returns
    -------
    float or None
        None where fewer than three steps are left.
    """
    clear = sorted(
        (row.value, row.error)
        for row in rows
        if row.value and row.error is not None and row.error > _ABOVE_REFERENCE * row.reference_error
    )
    if len(clear) < 3:
        return None
    steps, errors = np.log(clear[:_FINEST]).T
    return float(np.polyfit(steps, errors, 1)[0])
