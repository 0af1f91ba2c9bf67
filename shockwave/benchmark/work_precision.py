"""Work-precision data and how it is measured: methods at setting after setting on a problem, each run timed."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from timeit import Timer
from typing import Any, NamedTuple, TypeAlias

from attrs import asdict, evolve, field, frozen

from shockwave.errors import NumericalError, PluginError, ShockwaveError
from shockwave.text import printed

# A finer setting takes about twice as long as the one before.
_GROWTH = 2.0


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


@frozen(kw_only=True)
class WorkPrecision:
    """Results of a round: where it was run, problems, and rows."""

    provenance: dict[str, str]
    problems: tuple[Problem, ...]
    rows: tuple[Row, ...]

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


# ---------------------------------------------------------------- timed runs


class TooSlowError(NumericalError):
    """A run was stopped because it took longer than it may."""


@frozen
class Limits:
    """Time limits of a round.

    ``run`` is the time of one run and ``repetitions`` of all at one setting [s], ``repeats`` their number; each
    ``every``-th of the settings is run.
    """

    run: float
    repetitions: float
    repeats: int
    every: int = 1


class Clock:
    """Stops a run after ``seconds`` [s], wherever the run checks it."""

    def __init__(self, seconds: float = math.inf) -> None:
        self.seconds = seconds
        self.end = time.perf_counter() + seconds

    def check(self) -> None:
        """Raise `TooSlowError` when the time of the run is up."""
        if time.perf_counter() > self.end:
            raise TooSlowError(f"stopped: a run may take {self.seconds:g} s")


class Answer(NamedTuple):
    """Relative errors by quantity, and the cost that the method reports."""

    errors: Mapping[str, float | None]
    evaluations: int | None = None
    steps: int | None = None


@frozen
class Method:
    """A method of a problem, ready to run.

    Attributes
    ----------
    name : str
        Its name in rows.
    run : callable
        From a value of the setting and a `Clock` to an `Answer`.
    setting : str
        The name of what is varied; the whole text of the setting where there is one run only.
    values : tuple of float
        Cheapest first; None for a single run.
    """

    name: str
    run: Callable[[Any, Clock], Answer]
    setting: str = "-"
    values: tuple[float | None, ...] = (None,)

    def text(self, value: float | None) -> str:
        """The setting as text: steps as they are, tolerances as powers of ten."""
        if value is None:
            return self.setting
        return f"{self.setting} {value:.3g}" if self.setting == "step" else f"{self.setting} {value:.0e}"


#: A problem and its methods.
Experiment: TypeAlias = tuple[Problem, Iterable[Method]]


def measured(problem: Problem, method: Method, limits: Limits) -> Iterator[Row]:
    """A row for each value of the setting; a run that fails, or would take too long, has a row with the reason.

    A plugin at fault is not run at further settings.
    """
    last = 0.0
    for value in method.values[:: limits.every]:
        row = Row(problem.family, problem.name, method.name, method.text(value), value)
        row = evolve(row, reference_error=problem.reference_error)
        if last * _GROWTH > limits.run:
            yield evolve(row, problem=f"left out: it would take longer than the {limits.run:g} s that a run may")
            continue
        begin = time.perf_counter()
        try:
            row = _timed(row, method, limits)
        except PluginError as error:
            yield evolve(row, problem=str(error))
            return
        except ShockwaveError as error:
            row = evolve(row, problem=str(error))
        except Exception as error:  # of a plugin
            row = evolve(row, problem=f"{type(error).__name__}: {error}")
        last = row.seconds or time.perf_counter() - begin
        yield row


def _timed(row: Row, method: Method, limits: Limits) -> Row:
    """The row with errors, cost and times; no garbage is collected during runs."""
    answers: list[Answer] = []
    timer = Timer(lambda: answers.append(method.run(row.value, Clock(limits.run))))
    warm_up = timer.timeit(number=1)
    repeats = min(limits.repeats, int(limits.repetitions / max(warm_up, 1e-9)))
    # The one run of a slow method is worth more than none.
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
