"""The test kit for plugins finds broken integrators, each by the clause that it breaks alone."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
import pytest

from selection import thinned
from shockwave.errors import NumericalError
from shockwave.hooks import Entry
from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Integrator, Step
from shockwave.simulation.nystroem import Rkn64
from shockwave.simulation.one_step import Attempt
from shockwave.simulation.rk4 import Rk4
from shockwave.simulation.verlet import Verlet
from shockwave.testing import IntegratorContract
from test_testing_broken import _nothing_known, broken_clauses, check, outcomes  # noqa: F401

# ---------------------------------------------------------------- integrators


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


class Shifted(Plain):
    """Steps that overlap by a little."""

    def steps(self, *arguments: Any) -> Iterator[Step]:
        for step in Plain.steps(self, *arguments):
            begin = step.begin - 1e-14 if step.begin > 0.5 else step.begin
            yield Step(begin, step.end, step.x, step.v, step.a, step.interpolate, step.next_size)


class InPlace(Plain):
    """The arrays given are worked on."""

    def steps(self, acceleration: Any, begin: float, until: float, x: FloatArray, v: FloatArray, first: Any) -> Any:
        for step in Plain.steps(self, acceleration, begin, until, x, v, first):
            x[:] = step.x
            yield step


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


def uneven(self: Plain, begin: float, until: float) -> list[float]:
    times = Plain.times(self, begin, until)
    return [*times[:1], times[0] + 0.3 * (times[1] - times[0]), *times[1:]]


def longer(self: Plain, begin: float, until: float) -> list[float]:
    return other(Plain)(size=2 * self.size).times(begin, until)


def by_tolerance(self: Plain, begin: float, until: float) -> list[float]:
    return other(Plain)(size=self.size if self.tolerance < 1e-4 else self.size / 2).times(begin, until)


def unmoved(_: Plain, acceleration: Any, time: float, x: FloatArray, before: FloatArray | None) -> FloatArray:
    """Granules that nothing moves are taken to stay so."""
    return acceleration(time, x) if before is None else np.where(before == 0, 0.0, acceleration(time, x))


def beyond(self: Plain, acceleration: Any, time: float, x: FloatArray, _: FloatArray | None) -> FloatArray:
    acceleration.acceleration(time + 1e-6, x)
    self.evaluations += 1
    return acceleration(time, x)


def crooked(_: Plain, step: tuple[float, float], old: Any, new: Any) -> Any:
    def interpolate(time: float) -> Any:
        u = ((time - step[0]) / (step[1] - step[0])) ** 2
        return tuple((1 - u) * old[i] + u * new[i] for i in (0, 1))

    return interpolate


def wrong_error(_: Plain, time: float, *arrays: FloatArray) -> None:
    if not all(np.isfinite(array).all() for array in arrays):
        raise ValueError("not finite")


def twisted(self: Plain, acceleration: Any, time: float, x: FloatArray, before: FloatArray | None) -> FloatArray:
    """A force that no potential has, too small for the order to show it."""
    return acceleration(time, x) + 0.01 * self.size**2 * np.roll(x, 1)


class Timid(Rkn64):
    """Steps are chosen by the tolerance, and no longer than those of fixed size."""

    def _next_size(self, size: float, error: float, good: bool) -> float:
        return min(Rkn64._next_size(self, size, error, good), self.size)


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


def misread(_: Verlet, acceleration: Any, time: Any, size: Any, x: Any, v: Any, a: Any) -> Attempt:
    """A third in place of a half."""
    new_x = x + size * v + size * size / 3 * a
    new_a = acceleration(time + size, new_x)
    return Attempt(new_x, v + size / 2 * (a + new_a), new_a, 0.0 * np.asarray(size))


def raising(*_: Any) -> Attempt:
    raise ZeroDivisionError("division by zero")


def own_arrays(self: Verlet, *arguments: Any) -> Attempt:
    tried, x = Verlet.attempt(self, *arguments), arguments[3]
    if np.ndim(arguments[1]) == 0 and arguments[1:3] == (0.3, 0.1):
        return tried._replace(x=np.add(tried.x, 0.0, out=x), a=tried.a)
    return tried


INTEGRATORS: dict[str, tuple[type[Any], str, str]] = {
    "order": (other(Plain, order=3), "1", "goes with the step to the power 2.00, order is 3"),
    "order-of-one-step": (other(Rk4, order=5), "1", "goes with the step to the power 4.00, order is 5"),
    "order-no-number": (other(Plain, order="2"), "1", "order is '2'"),
    "trait": (other(Plain, adaptive=0), "1", "adaptive is 0"),
    "not-symplectic": (other(Rk4, symplectic=True), "1", "symplectic is True, and a step does not keep the symplectic"),
    "symplectic-of-steps": (other(Plain, symplectic=False), "1", "symplectic is False, and a step keeps the"),
    "twisted": (other(Plain, called=twisted), "1", "symplectic is True, and a step does not keep"),
    "coefficients": (other(Verlet, attempt=misread), "1", "goes with the step to the power"),
    "no-name": (other(Plain, name=""), "1", "name is ''"),
    "no-name-of-one-step": (other(Verlet, name=None), "1", "name is None"),
    "raising": (other(Verlet, attempt=raising), "one-step 1", "ZeroDivisionError('division by zero') (in test_testing"),
    "no-attempt": (other(Verlet, attempt=lambda _, *a: a[3:]), "one-step 1", "attempt returns a tuple"),
    "longer-steps": (other(Plain, times=longer), "2", "with size = 0.025 the longest step is 0.05"),
    "by-tolerance": (other(Plain, times=by_tolerance), "2", "another tolerance gives other steps, 12 in place of 6"),
    "timid": (Timid, "2", "another size gives other steps"),
    "gap": (Shifted, "3", "the one before has ended at"),
    "early": (other(Plain, times=early), "3", "the last step ends at 2.3333333323333"),
    "uneven": (other(Plain, times=uneven), "3", "steps of fixed size range from"),
    "beyond": (other(Plain, called=beyond), "3", "a stage lies at t = 2.33333"),
    "unmoved": (other(Plain, called=unmoved), "4", "five granules that come apart are off by"),
    "uncounted": (Forgetful, "5", "evaluations is 41, the acceleration was called 62 times"),
    "in-place": (InPlace, "6", "the arrays x, v that were given were changed"),
    "wiping": (Wiping, "6", "was changed after it was yielded"),
    "crooked": (other(Plain, between=crooked), "7", "within a step, is off by"),
    "not-checked": (other(Plain, checked=lambda *_: None), "8", "is not finite for an acceleration of nan"),
    "wrong-error": (
        other(Plain, checked=wrong_error),
        "8",
        "ValueError('not finite') (in test_testing_methods.py, line",
    ),
    "remembering": (Remembering, "9", "takes other steps than a new one"),
    "beyond-the-step": (
        # The last step of a run does not show it: the caller keeps times within the run.
        other(Verlet, attempt=attempt(lambda _, acceleration, time, size, x: acceleration(time + 1.1 * size, x))),
        "one-step 1",
        "for time = 0.3, size = 0.1 a stage lies at 0.4 or 0.41",
    ),
    "own-arrays": (other(Verlet, attempt=own_arrays), "one-step 1", "it changes the arrays x, v, a given"),
    "numbers-only": (
        other(Verlet, attempt=attempt(lambda _, acceleration, time, size, x: float(size))),
        "one-step 2",
        "is raised for x of shape (5, 3)",
    ),
    "restless": (other(Verlet, attempt=restless), "one-step 2", "x of chain 2 of a batch is off by 1.0e-09"),
    "error-order": (other(Rkn64, error_order=5), "one-step 3", "to the power 5.00, error_order is 5"),
    "needless-order": (other(Verlet, error_order=1), "one-step 3", "error_order is 1, and adaptive is False"),
}


@pytest.fixture
def registered(monkeypatch: pytest.MonkeyPatch) -> Callable[[type[Any]], None]:
    """Registers a class, as the hook of a plugin does."""

    def register(cls: type[Any], takes: str = "") -> None:
        monkeypatch.setattr("shockwave.testing.contract.load", lambda kind, name: cls)
        for module in ("contract", "integrator"):
            entry = Entry(getattr(cls, "name", ""), "here:There", "", takes=takes)
            monkeypatch.setattr(f"shockwave.testing.{module}.find", lambda kind, name, entry=entry: entry)

    return register


def test_an_integrator_that_keeps_its_contract_breaks_no_clause(registered: Any) -> None:
    registered(Plain)
    assert broken_clauses(IntegratorContract, Plain) == {}


@pytest.mark.parametrize("broken", thinned(INTEGRATORS, 3))
def test_a_broken_integrator_is_found_by_its_clause_alone(broken: str, registered: Any) -> None:
    method, clause, message = INTEGRATORS[broken]
    registered(method)
    check(IntegratorContract, method, f"does not hold for {method.__name__} ", clause, message)


def test_errors_beyond_the_tolerance_are_found() -> None:
    with pytest.raises(pytest.fail.Exception, match=r"with tolerance = 1e-07 the error at\s+t = 3 is"):
        IntegratorContract().test_clause_2_the_setting_of_its_kind_is_used_and_the_other_ignored(Optimist)


def test_positions_of_another_shape_are_found(registered: Any) -> None:
    column = other(Plain, called=lambda _, acceleration, time, x, before: acceleration(time, x[:, None]).ravel())
    registered(column)
    message = "positions of shape (5, 1), the chain has (5,)"
    check(IntegratorContract, column, "does not hold for Broken ", "4", message)


def test_an_integrator_that_nobody_registered_is_found_and_so_is_its_order() -> None:
    failed, _ = outcomes(IntegratorContract, other(Plain, order=3))
    assert "no integrator is registered as 'plain'" in failed.pop("test_clause_1_it_is_registered_under_its_name")
    assert "to the power 2.00, order is 3" in failed.pop("test_clause_1_order_is_that_of_the_error")
    assert failed == {}


def test_the_name_of_another_is_found() -> None:
    with pytest.raises(pytest.fail.Exception, match="'verlet' is registered for another class"):
        IntegratorContract().test_clause_1_it_is_registered_under_its_name(other(Verlet))


def test_what_stands_on_a_broken_order_is_skipped(registered: Any) -> None:
    method = other(Verlet, attempt=misread)
    registered(method)
    _, skipped = outcomes(IntegratorContract, method)
    assert set(skipped.values()) == {"see clause 1 first (test_clause_1_order_is_that_of_the_error)"}
    assert {re.sub(r"(clause_\d+)_.*", r"\1", name) for name in skipped} == {
        "test_clause_1",
        "test_clause_2",
        "test_clause_4",
        "test_clause_7",
        "test_one_step_clause_3",
        "test_it_simulates_a_chain",
    }


def test_a_setting_that_the_method_does_not_take_is_found(registered: Any) -> None:
    registered(Plain, takes="rtol")
    with pytest.raises(pytest.fail.Exception, match="adaptive is False, and takes 'rtol'"):
        IntegratorContract().test_clause_1_it_is_registered_under_its_name(Plain)
