"""The test kit for plugins finds broken integrators by the clause that they break."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
import pytest

from selection import thinned
from shockwave.errors import NumericalError
from shockwave.hooks import Entry
from shockwave.quadrature import FloatArray
from shockwave.simulation.fixed_step import Rk4, Verlet
from shockwave.simulation.integrator import Integrator, Step
from shockwave.simulation.nystroem import Rkn64, Rkn1210
from shockwave.simulation.one_step import Attempt
from shockwave.testing import IntegratorContract


class Plain(Integrator):
    """Velocity Verlet as no method of one step, which keeps its contract; parts of it can be others."""

    name: ClassVar[str] = "plain"
    order: ClassVar[int] = 2
    adaptive: ClassVar[bool] = False
    symplectic: ClassVar[bool] = True

    def times(self, begin: float, until: float) -> list[float]:
        count = math.ceil((until - begin) / self.size * (1 - 1e-9))
        return [*(begin + (until - begin) * k / count for k in range(count)), until]

    def called(self, acceleration: Any, time: float, x: FloatArray, before: FloatArray | None) -> FloatArray:
        return acceleration(time, x)

    def between(self, step: tuple[float, float], old: Any, new: Any) -> Callable[[float], Any]:
        """Hermite's cubic of the positions, and of the velocities."""
        size = step[1] - step[0]

        def interpolate(time: float) -> Any:
            u = (time - step[0]) / size
            weights = (1 - u) ** 2 * (1 + 2 * u), size * u * (1 - u) ** 2, u * u * (3 - 2 * u), size * u * u * (u - 1)
            return tuple(
                weights[0] * old[i] + weights[1] * old[i + 1] + weights[2] * new[i] + weights[3] * new[i + 1]
                for i in (0, 1)
            )

        return interpolate

    def checked(self, time: float, *arrays: FloatArray) -> None:
        if not all(np.isfinite(array).all() for array in arrays):
            raise NumericalError(f"plain cannot step beyond t = {time:g} T0")

    def steps(self, acceleration, begin, until, x, v, first_size) -> Iterator[Step]:  # type: ignore[no-untyped-def]
        counted = self._counted(acceleration, until)
        x, v = x.copy(), v.copy()
        a = self.called(counted, begin, x, None)
        for time, end in pairwise(self.times(begin, until)):
            size = end - time
            half = v + size / 2 * a
            new_x = x + size * half
            new_a = self.called(counted, end, new_x, a)
            new_v = half + size / 2 * new_a
            self.checked(time, new_x, new_v, new_a)
            between = self.between((time, end), (x, v, a), (new_x, new_v, new_a))
            yield Step(time, end, new_x, new_v, new_a, between, size)
            x, v, a = new_x, new_v, new_a


def other(base: type[Any], **parts: Any) -> type[Any]:
    """A method of which some parts are others."""
    return type("Broken", (base,), parts)


class Wiping(Plain):
    """Accelerations are wiped out as soon as the next step is asked for."""

    def steps(self, *arguments: Any) -> Iterator[Step]:
        for step in Plain.steps(self, *arguments):
            a = step.a.copy()
            yield Step(step.begin, step.end, step.x, step.v, a, step.interpolate, step.next_size)
            a[:] = 0


class Forgetful(Plain):
    """The count begins anew with each run."""

    def steps(self, *arguments: Any) -> Iterator[Step]:
        self.evaluations = 0
        yield from Plain.steps(self, *arguments)


class Remembering(Plain):
    """A run goes on from where the last one was left, if there was one."""

    def steps(self, acceleration: Any, begin: float, until: float, x: FloatArray, v: FloatArray, first: Any) -> Any:
        before = getattr(self, "before", x)
        for step in Plain.steps(self, acceleration, begin, until, before[: x.size], v, first):
            self.before = step.x
            yield step


def early(self: Plain, begin: float, until: float) -> list[float]:
    return [*Plain.times(self, begin, until)[:-1], until - 1e-9]


def longer(self: Plain, begin: float, until: float) -> list[float]:
    return other(Plain)(size=2 * self.size).times(begin, until)


def unmoved(_: Plain, acceleration: Any, time: float, x: FloatArray, before: FloatArray | None) -> FloatArray:
    """Granules that nothing moves are taken to stay so."""
    return acceleration(time, x) if before is None else np.where(before == 0, 0.0, acceleration(time, x))


def crooked(_: Plain, step: tuple[float, float], old: Any, new: Any) -> Any:
    def interpolate(time: float) -> Any:
        u = ((time - step[0]) / (step[1] - step[0])) ** 2
        return tuple((1 - u) * old[i] + u * new[i] for i in (0, 1))

    return interpolate


def column(_: Plain, acceleration: Any, time: float, x: FloatArray, before: FloatArray | None) -> FloatArray:
    return acceleration(time, x[:, None]).ravel()


class Optimist(Rkn64):
    """Errors are taken for less than they are."""

    def attempt(self, *arguments: Any) -> Attempt:
        tried = Rkn64.attempt(self, *arguments)
        return tried._replace(error=tried.error / 1e6)


def attempt(change: Callable[..., Any]) -> Callable[..., Any]:
    """Verlet's attempt, before which something is done to its arguments."""

    def changed(self: Verlet, acceleration: Any, time: Any, size: Any, x: Any, v: Any, a: Any) -> Attempt:
        change(self, acceleration, time, size, x)
        return Verlet.attempt(self, acceleration, time, size, x, v, a)

    return changed


def restless(self: Verlet, acceleration: Any, time: Any, size: Any, x: Any, v: Any, a: Any) -> Attempt:
    tried = Verlet.attempt(self, acceleration, time, size, x, v, a)
    return tried._replace(x=tried.x + (1e-9 if np.ndim(size) else 0.0) * (np.asarray(size) == 0))


def own_arrays(self: Verlet, *arguments: Any) -> Attempt:
    tried, x = Verlet.attempt(self, *arguments), arguments[3]
    if np.ndim(arguments[1]) == 0 and arguments[1:3] == (0.3, 0.1):
        return tried._replace(x=np.add(tried.x, 0.0, out=x), a=tried.a)
    return tried


#: The method, the clause, and what is said of it; an error of the method's own is shown by pytest.
INTEGRATORS: dict[str, tuple[type[Any], str, str]] = {
    "order": (other(Plain, order=3), "clause_1", "order is 3, and the error scales as the step to the power 2.00"),
    "order-no-number": (other(Plain, order="2"), "clause_1", "order must be a whole number (got '2')"),
    "not-symplectic": (
        other(Rk4, symplectic=True),
        "clause_1",
        "symplectic is True, and a step keeps",
    ),
    "nearly-symplectic": (other(Rkn1210, symplectic=True), "clause_1_symplectic", "symplectic is True, and a step"),
    "no-name": (other(Plain, name=None), "clause_1", "name must be a text (got None)"),
    "longer-steps": (other(Plain, times=longer), "clause_2", "with size = 0.025 the longest step is 0.05"),
    "optimist": (Optimist, "clause_2", "with tolerance = 1e-07 the error at t = 3 is"),
    "early": (other(Plain, times=early), "clause_3", "the last step ends at 2.3333333323333"),
    "column": (other(Plain, called=column), "clause_4", "positions of shape {(5, 1)}, the chain has (5,)"),
    "unmoved": (other(Plain, called=unmoved), "clause_4", "granules that come apart are off by"),
    "uncounted": (Forgetful, "clause_5", "evaluations is 41, the acceleration was called 62 times"),
    "wiping": (Wiping, "clause_6", "was changed after it was yielded"),
    "crooked": (other(Plain, between=crooked), "clause_7", "is off by"),
    "remembering": (Remembering, "clause_9", "takes other steps than a new one"),
    "beyond-the-step": (
        # The last step of a run does not show it: the caller keeps times within the run.
        other(Verlet, attempt=attempt(lambda _, acceleration, time, size, x: acceleration(time + 1.1 * size, x))),
        "one_step_clause_1",
        "a stage lies at t = 0.4 or 0.41",
    ),
    "own-arrays": (other(Verlet, attempt=own_arrays), "one_step_clause_1", "it changes the arrays x, v, a given"),
    "restless": (other(Verlet, attempt=restless), "one_step_clause_2", "chain 2 of a batch is off by 1.0e-09"),
    "error-order": (other(Rkn64, error_order=5), "one_step_clause_3", "error_order is 5, and the estimate scales as"),
}


@pytest.fixture
def register(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Registers a class, as the hook of a plugin does."""

    def registered(cls: type[Any], takes: str = "") -> None:
        entry = Entry("it", "here:There", "", takes=takes)
        monkeypatch.setattr("shockwave.testing.contract.load", lambda kind, name: cls)
        monkeypatch.setattr("shockwave.testing.integrator.find", lambda kind, name: entry)

    return registered


def failures(method: type[Any], name: str) -> list[str]:
    """Messages of the tests of a clause that fail for the method."""
    found = []
    for test in (test for test in dir(IntegratorContract) if test.startswith(f"test_{name}")):
        function = getattr(IntegratorContract(), test)
        marks = [mark for mark in getattr(function, "pytestmark", ()) if mark.name == "parametrize"]
        for case in marks[0].args[1] if marks else [()]:
            try:
                function(method, *case)
            except pytest.skip.Exception:
                pass
            except (pytest.fail.Exception, Exception) as failure:
                found.append(str(failure))
    return found


def test_an_integrator_that_keeps_its_contract_fails_no_test(register: Any) -> None:
    register(Plain)
    assert failures(Plain, "") == []


@pytest.mark.parametrize("broken", thinned(INTEGRATORS, 3))
def test_a_broken_integrator_fails_the_test_of_its_clause(broken: str, register: Any) -> None:
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
def test_an_integrator_that_is_not_registered_is_found(method: type[Any], message: str) -> None:
    assert message in failures(method, "clause_1_name")[0]


def test_a_setting_that_the_method_does_not_take_is_found(register: Any) -> None:
    register(Plain, takes="rtol")
    assert failures(Plain, "clause_1_name") == ["the Entry must have takes='step' (got 'rtol')"]
