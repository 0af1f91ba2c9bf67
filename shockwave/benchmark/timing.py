"""Runs that are timed: a warm-up, repetitions, and a cap on each."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

from attrs import frozen

from shockwave.errors import NumericalError

__all__ = ["Clock", "Limits", "TooSlowError", "Tried", "tried"]

Result = TypeVar("Result")
Setting = TypeVar("Setting")

# What somebody else's code may do; only the user's own interrupt passes.
_FAULTS = (Exception, SystemExit)
# A finer setting takes some twice as long as the one before.
_GROWTH = 2.0


class TooSlowError(NumericalError):
    """A run was stopped because it took longer than it may."""


@frozen
class Limits:
    """How long things may take.

    ``run`` is the longest run [s], ``method`` what repetitions of a method at one setting may take together [s],
    ``repeats`` the most repetitions.
    """

    run: float
    method: float
    repeats: int


@frozen
class Clock:
    """Stops a run that takes too long, wherever the run asks it."""

    limits: Limits
    begun: float

    def check(self) -> None:
        """Raise `TooSlowError` when the time of the run is up."""
        if time.perf_counter() - self.begun > self.limits.run:
            raise TooSlowError(f"stopped: a run may take {self.limits.run:g} s")


@frozen(eq=False)
class Tried(Generic[Setting, Result]):
    """A setting, what came of it, and what it took: None and "" where there is nothing.

    ``seconds`` is the median of ``runs`` runs, ``least`` and ``most`` the shortest and the longest of them.
    """

    setting: Setting
    result: Result | None = None
    seconds: float | None = None
    least: float | None = None
    most: float | None = None
    runs: int = 0
    problem: str = ""


def tried(
    settings: Iterable[Setting], run: Callable[[Setting, Clock], Result], limits: Limits
) -> Iterator[Tried[Setting, Result]]:
    """Each setting, cheapest first, run and timed; what fails, or would take too long, says so."""
    last = 0.0
    for setting in settings:
        if last * _GROWTH > limits.run:
            yield Tried(setting, problem=f"left out: it would take longer than the {limits.run:g} s that a run may")
            continue
        try:
            found: Tried[Setting, Result] = _timed(setting, run, limits)
        except TooSlowError as error:
            last = limits.run
            found = Tried(setting, problem=str(error))
        except _FAULTS as error:
            found = Tried(setting, problem=_words(error))
        else:
            last = found.seconds or 0.0
        yield found


def _timed(setting: Setting, run: Callable[[Setting, Clock], Result], limits: Limits) -> Tried[Setting, Result]:
    def once() -> tuple[Result, float]:
        begin = time.perf_counter()
        result = run(setting, Clock(limits, begin))
        return result, time.perf_counter() - begin

    with _no_collection():
        result, warm_up = once()
        count = min(limits.repeats, int(limits.method / max(warm_up, 1e-9)))
        # The one run of a slow method is worth more than none.
        seconds = [once()[1] for _ in range(count)] or [warm_up]
    return Tried(setting, result, statistics.median(seconds), min(seconds), max(seconds), len(seconds))


@contextmanager
def _no_collection() -> Iterator[None]:
    """Garbage is not collected meanwhile: it would fall into one run and not into another."""
    enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _words(error: BaseException) -> str:
    text = " ".join(str(error).split()) or "no message"
    return text if isinstance(error, NumericalError) else f"{type(error).__name__}: {text}"[:200]
