"""Work-precision data and their measurement: timed runs of methods at several settings on a problem."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from timeit import Timer
from typing import Any, NamedTuple, TypeAlias

from attrs import asdict, evolve, field, frozen

from shockwave.base.errors import PluginError, message_of
from shockwave.base.result import VERSION
from shockwave.base.text import render
from shockwave.engine.time_limit import time_limit

# Estimated ratio of the run times of one setting and the next coarser one.
_GROWTH = 2.0


@frozen
class Problem:
    """Description of a problem and of its reference.

    ``reference`` states how the reference was obtained, and ``reference_error`` is its relative error. ``quantities``
    are the names of the errors in rows, in the order of the figures.
    """

    family: str
    name: str
    description: str
    quantities: tuple[str, ...]
    reference: str
    reference_error: float


@frozen
class Row:
    """Result of a method at one setting on a problem.

    Attributes
    ----------
    family, case, method, setting : str
        Names of the problem and of the method, and its setting; ``value`` is the setting as a number, None if the
        method has no setting.
    errors : dict of float or None
        Relative errors by quantity; None for an error that is not finite.
    seconds, least, most : float or None
        Median, shortest and longest time of ``runs`` runs [s].
    evaluations, steps : int or None
        Number of evaluations of the integrand or of the acceleration of the chain, and number of steps.
    reference_error : float
        Relative error of the reference; smaller errors carry no information.
    problem : str
        Reason why there is no result; empty if there is one.
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
        """Error in the first quantity of the problem."""
        return next(iter(self.errors.values()), None)


@frozen(kw_only=True)
class WorkPrecision:
    """Results of a benchmark: software and machine, problems, and rows."""

    provenance: dict[str, str]
    problems: tuple[Problem, ...]
    rows: tuple[Row, ...]

    def of(self, problem: Problem) -> list[Row]:
        """The rows of a problem."""
        return [row for row in self.rows if (row.family, row.case) == (problem.family, problem.name)]

    def to_dict(self) -> dict[str, Any]:
        """The document that ``bench --json`` prints; it contains no NaN."""
        document = asdict(self)
        for row in document["rows"]:
            row["problem"] = row["problem"] or None
        return VERSION | document

    def __str__(self) -> str:
        return render(self, "shockwave.benchmark.bench_output:text")


# ---------------------------------------------------------------- timed runs


@frozen
class Limits:
    """Limits of a benchmark.

    ``run`` limits the time of one run [s], ``repetitions`` that of all runs at one setting [s], and ``repeats`` their
    number; every ``every``-th setting is run.
    """

    run: float
    repetitions: float
    repeats: int
    every: int = 1


class Answer(NamedTuple):
    """Relative errors by quantity, and the cost reported by the method."""

    errors: Mapping[str, float | None]
    evaluations: int | None = None
    steps: int | None = None


@frozen
class Method:
    """A method that can be run on a problem.

    Attributes
    ----------
    name : str
        Name in rows.
    run : callable
        Called with a value of the setting; returns an `Answer`.
    setting : str
        Name of the setting that is varied; for a single run, its description.
    values : tuple of float
        Values of the setting, cheapest first; None for a single run.
    """

    name: str
    run: Callable[[Any], Answer]
    setting: str = "-"
    values: tuple[float | None, ...] = (None,)

    def text(self, value: float | None) -> str:
        """Name and value of the setting."""
        if value is None:
            return self.setting
        return f"{self.setting} {value:.3g}" if self.setting == "step" else f"{self.setting} {value:.0e}"


#: A problem and its methods.
Experiment: TypeAlias = tuple[Problem, Iterable[Method]]


def measure(problem: Problem, method: Method, limits: Limits) -> Iterator[Row]:
    """A row for each value of the setting; runs that fail or would take too long have rows with the reason.

    A plugin that breaks its contract is not run at further settings.
    """
    last = 0.0
    for value in method.values[:: limits.every]:
        setting = method.text(value)
        row = Row(problem.family, problem.name, method.name, setting, value, reference_error=problem.reference_error)
        if last * _GROWTH > limits.run:
            yield evolve(row, problem=f"left out: would exceed the time limit of {limits.run:g} s for a run")
            continue
        begin = time.perf_counter()
        try:
            row = _time(row, method, limits)
        except PluginError as error:
            yield evolve(row, problem=str(error))
            return
        except Exception as error:  # of a plugin, too
            is_late = time.perf_counter() - begin > limits.run
            reason = f"stopped at the time limit of {limits.run:g} s for a run" if is_late else message_of(error)
            row = evolve(row, problem=reason)
        last = row.seconds or time.perf_counter() - begin
        yield row


def _time(row: Row, method: Method, limits: Limits) -> Row:
    """The row with errors, cost and times; garbage collection is off during the runs."""
    answers: list[Answer] = []
    timer = Timer(lambda: answers.append(method.run(row.value)))
    with time_limit(limits.run):
        warm_up = timer.timeit(number=1)
    repeats = min(limits.repeats, int(limits.repetitions / max(warm_up, 1e-9)))
    # For a slow method the warm-up is the only run.
    seconds = timer.repeat(repeats, number=1) or [warm_up]
    answer = answers[0]
    finite = {name: error for name, error in answer.errors.items() if error is not None and math.isfinite(error)}
    unknown = {name for name, error in answer.errors.items() if error is None}
    return evolve(
        row,
        errors=dict.fromkeys(answer.errors) | finite,
        seconds=statistics.median(seconds),
        least=min(seconds),
        most=max(seconds),
        runs=len(seconds),
        evaluations=answer.evaluations,
        steps=answer.steps,
        problem="" if finite.keys() | unknown == answer.errors.keys() else "not finite",
    )
