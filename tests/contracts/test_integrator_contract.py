"""The test kit for plugins identifies broken integrators by the clause that they violate."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
import pytest

from shockwave.base.errors import NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.engine.integrator import Counted, Integrator, Step
from shockwave.engine.nystroem_integrators import Rkn64, Verlet
from shockwave.engine.one_step import Attempt
from shockwave.testing import IntegratorContract
from support.slow_cases import thinned


class Plain(Integrator):
    """Velocity Verlet as a subclass of `Integrator` that fulfils the contract; parts of it can be replaced."""

    name: ClassVar[str] = "plain"
    order: ClassVar[int] = 2
    adaptive: ClassVar[bool] = False

    def times(self, begin: float, until: float) -> list[float]:
        count = math.ceil((until - begin) / self.size * (1 - 1e-9))
        return [*(begin + (until - begin) * k / count for k in range(count)), until]

    def positions(self, x: FloatArray) -> FloatArray:
        """Positions for which the acceleration is called."""
        return x

    def shares(self, u: float, size: float) -> tuple[float, ...]:
        """Weights of the old and new value and slope: Hermite's cubic."""
        return (1 - u) ** 2 * (1 + 2 * u), size * u * (1 - u) ** 2, u * u * (3 - 2 * u), size * u * u * (u - 1)

    def checked(self, *arrays: FloatArray) -> None:
        if not np.isfinite(arrays).all():
            raise NumericalError("plain cannot step")

    def steps(self, acceleration, begin, until, x, v, first_size) -> Iterator[Step]:  # type: ignore[no-untyped-def]
        counted = Counted(self, acceleration, until)
        old = x.copy(), v.copy(), counted(begin, self.positions(x)).ravel()
        for time, end in pairwise(self.times(begin, until)):
            size = end - time
            half = old[1] + size / 2 * old[2]
            x = old[0] + size * half
            a = counted(end, self.positions(x)).ravel()
            new = x, half + size / 2 * a, a
            self.checked(*new)

            def interpolate(at: float, time: float = time, size: float = size, old: Any = old, new: Any = new) -> Any:
                weights = self.shares((at - time) / size, size)
                parts = (old[:2], old[1:], new[:2], new[1:])
                return sum(weight * np.array(part) for weight, part in zip(weights, parts, strict=True))

            yield Step(time, end, *new, interpolate, size)
            old = new


def other(base: type[Any], **parts: Any) -> type[Any]:
    """A subclass with replaced parts."""
    return type("Broken", (base,), parts)


class Wiping(Plain):
    """Sets the accelerations to zero when the next step is requested."""

    def steps(self, *arguments: Any) -> Iterator[Step]:
        for step in Plain.steps(self, *arguments):
            a = step.a.copy()
            yield Step(step.begin, step.end, step.x, step.v, a, step.interpolate, step.next_size)
            a[:] = 0


class Forgetful(Plain):
    """Resets the number of evaluations at each run."""

    def steps(self, *arguments: Any) -> Iterator[Step]:
        self.evaluations = 0
        yield from Plain.steps(self, *arguments)


class Remembering(Plain):
    """Continues from the last state of the previous run."""

    def steps(self, acceleration: Any, begin: float, until: float, x: FloatArray, v: FloatArray, first: Any) -> Any:
        before = getattr(self, "before", x)
        for step in Plain.steps(self, acceleration, begin, until, before[: x.size], v, first):
            self.before = step.x
            yield step


def early(self: Plain, begin: float, until: float) -> list[float]:
    return [*Plain.times(self, begin, until)[:-1], until - 1e-9]


def longer(self: Plain, begin: float, until: float) -> list[float]:
    return other(Plain)(size=2 * self.size).times(begin, until)


class Optimist(Rkn64):
    """Underestimates the errors."""

    def attempt(self, *arguments: Any) -> Attempt:
        tried = Rkn64.attempt(self, *arguments)
        return tried._replace(error=tried.error / 1e6)


def beyond(self: Verlet, acceleration: Any, time: Any, size: Any, x: Any, v: Any, a: Any) -> Attempt:
    acceleration(time + 1.1 * size, x)
    return Verlet.attempt(self, acceleration, time, size, x, v, a)


def restless(self: Verlet, acceleration: Any, time: Any, size: Any, x: Any, v: Any, a: Any) -> Attempt:
    tried = Verlet.attempt(self, acceleration, time, size, x, v, a)
    return tried._replace(x=tried.x + (1e-9 if np.ndim(size) else 0.0) * (np.asarray(size) == 0))


#: Method, clause and message.
INTEGRATORS: dict[str, tuple[type[Any], str, str]] = {
    "order": (other(Plain, order=3), "clause_1", "order is 3, and the error scales as the step to the power 2.00"),
    "single-granule": (
        other(Plain, positions=lambda _, x: x * (1.01 if x.size == 1 else 1)),
        "clause_1",
        "order is 2, and the error scales as the step to the power 0.",
    ),
    "no-name": (other(Plain, name=None), "clause_1", "name must be a string (got None)"),
    "longer-steps": (other(Plain, times=longer), "clause_2", "with size = 0.025 the longest step is 0.05"),
    "optimist": (Optimist, "clause_2", "with tolerance = 1e-07 the error at t = 3 is"),
    "early": (other(Plain, times=early), "clause_3", "until = 2.3333333333333335 (got 2.3333333323333"),
    "column": (other(Plain, positions=lambda _, x: x[:, None]), "clause_4", "positions of shape {(5, 1)}"),
    "uncounted": (Forgetful, "clause_5", "evaluations is 41, but the acceleration was called 62 times"),
    "wiping": (Wiping, "clause_6", "was changed after it was yielded"),
    "crooked": (
        other(Plain, shares=lambda _, u, __: (1 - u * u, 0, u * u, 0)),
        "clause_7",
        "the error of interpolate(",
    ),
    "not-finite": (other(Plain, checked=lambda *_: None), "clause_8", "DID NOT RAISE"),
    "remembering": (Remembering, "clause_9", "takes different steps than a new one"),
    # Not visible in the last step of a run, where the caller limits the times.
    "beyond-the-step": (other(Verlet, attempt=beyond), "one_step_clause_1", "a stage lies at t = 0.4 or 0.41"),
    "restless": (other(Verlet, attempt=restless), "one_step_clause_2", "chain 2 of a batch differs by 1.0e-09"),
    "error-order": (other(Rkn64, error_order=5), "one_step_clause_3", "error_order is 5, and the estimate scales as"),
}


@pytest.fixture
def register(monkeypatch: pytest.MonkeyPatch) -> Callable[[type[Any]], None]:
    """Registers a class like the hook of a plugin."""
    return lambda cls: monkeypatch.setattr("shockwave.testing.contract.load", lambda kind, name: cls)


def failures(method: type[Any], name: str) -> list[str]:
    """Messages of the failed tests of a clause."""
    found = []
    for test in (test for test in dir(IntegratorContract) if test.startswith(f"test_{name}")):
        function = getattr(IntegratorContract(), test)
        marks = [mark for mark in getattr(function, "pytestmark", ()) if mark.name == "parametrize"]
        for case in marks[0].args[1] if marks else [()]:
            try:
                function(method, *(case if isinstance(case, tuple) else (case,)))
            except pytest.skip.Exception:
                pass
            except (pytest.fail.Exception, Exception) as failure:
                found.append(str(failure))
    return found


def test_correct_integrator_passes_all_tests(register: Any) -> None:
    register(Plain)
    assert failures(Plain, "") == []


@pytest.mark.parametrize("broken", thinned(INTEGRATORS, 3))
def test_broken_integrator_fails_the_test_of_its_clause(broken: str, register: Any) -> None:
    method, clause, message = INTEGRATORS[broken]
    register(method)
    assert message in " ".join(failures(method, clause))


@pytest.mark.parametrize(
    ("method", "message"),
    [
        (other(Plain), "no integrator is registered as 'plain'"),
        (other(Verlet), "'verlet' is registered for another class"),
    ],
    ids=["nobody", "another"],
)
def test_integrator_that_is_not_registered_is_reported(method: type[Any], message: str) -> None:
    assert message in failures(method, "clause_1_name")[0]
