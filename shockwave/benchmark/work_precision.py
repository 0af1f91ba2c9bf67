"""Work-precision data: problems, and a row for each method at each setting with its error and its cost."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from attrs import asdict, converters, field, frozen

from shockwave.text import printed

# Errors below this multiple of the reference error are not the method's alone.
_ABOVE_REFERENCE = 30.0
# In the convergent range the slopes between neighbouring steps differ by at most this.
_SLOPE_SPREAD = 0.25
# The number of finest steps among which the convergent range is sought.
_FINEST = 4


def greatest(errors: Iterable[float]) -> float:
    """The greatest error; NaN if any is, which ``max`` would pass over."""
    return float(np.max(list(errors)))


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
        Relative errors by quantity; None where a method does not report the quantity, or the error is not finite.
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
    evaluations: int | None = field(default=None, converter=converters.optional(int))
    steps: int | None = field(default=None, converter=converters.optional(int))
    reference_error: float = 0.0
    problem: str = ""

    @property
    def error(self) -> float | None:
        """The error that is drawn: that of the problem's first quantity."""
        return next(iter(self.errors.values()), None)


@frozen
class Order:
    """The observed order of a method of fixed step beside the declared one.

    ``fitted`` is None where too few steps lie in the convergent range.
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
        return printed(self, "shockwave.benchmark.bench_table:text")


def observed_order(rows: Sequence[Row]) -> float | None:
    """The order of a method of fixed step: the slope of log error against log step over the convergent range.

    The range consists of the finest steps whose errors lie well above that of the reference and fall from step to step
    at the same rate.

    Parameters
    ----------
    rows : sequence of Row
        One method on one smooth problem; ``value`` is the step.

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
    alike = np.abs(slopes - slopes[0]) <= _SLOPE_SPREAD
    count = len(slopes) if alike.all() else int(alike.argmin())
    if count < 2:
        return None
    return float(np.polyfit(steps[: count + 1], errors[: count + 1], 1)[0])
