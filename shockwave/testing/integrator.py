"""The contract of an integrator, clause by clause, and that of a method of one step beside it."""

from __future__ import annotations

import inspect
import math
from collections.abc import Sequence
from contextlib import suppress
from itertools import islice
from typing import Any, ClassVar

import numpy as np
import pytest

from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray
from shockwave.registry import find
from shockwave.simulation.integrator import Integrator, Step
from shockwave.simulation.one_step import Attempt, OneStep
from shockwave.testing import motion
from shockwave.testing.contract import Contract, after
from shockwave.testing.faults import remedy, told
from shockwave.testing.motion import Watched, coupled, hertz, path

__all__ = ["IntegratorContract"]

# How far a slope may be off the order, of equal steps; of those that a method has chosen by an estimate. From
# order 9 on the error sinks into rounding before its next term is gone.
_SLOPE, _CHOSEN_SLOPE, _HIGH_SLOPE, _HIGH_ORDER = 0.25, 0.75, 1.25, 9
# The errors of some ten steps add up.
_TOLERANCES, _ADDED = (1e-4, 1e-7, 1e-10), 30.0
_STEP, _ROUNDING = 0.02, 1e-12
# A dense output of lower order may be some ten times worse than the steps.
_DENSE = 30.0
# Symplectic methods keep the form of `motion.form_defect` to 1e-9, others of order 12 to 1e-5.
_KEPT = 1e-7
# Where contacts open the force is smooth once only: fixed steps of 0.01 and tolerances of 1e-8 are better than this.
_OPENING = 2e-3


class IntegratorContract(Contract):
    """Tests of integrators against the contract of `Integrator`, and of `OneStep` where it is one.

    ::

        from shockwave.testing import IntegratorContract
        from my_pulses.leapfrog import Leapfrog

        class TestLeapfrog(IntegratorContract):
            integrators = [Leapfrog]

    Attributes
    ----------
    integrators : list of type
        Classes, registered by an installed distribution.
    leave_out : dict of str
        Clauses that are left out, each with the reason: ``{"clause 7": "linear between the steps, for pictures"}``,
        ``{"one-step clause 2": "..."}``. They are shown as skipped. A test that is no clause goes by its name.
    """

    integrators: ClassVar[Sequence[type[Integrator]]]

    _list = "integrators"
    _member = "integrator"
    _example = "integrators = [MyMethod]"
    _signed: ClassVar[dict[str, type]] = {"": Integrator, "one-step": OneStep}

    def _problem(self, member: object) -> str:
        if not (isinstance(member, type) and issubclass(member, Integrator)):
            return "a class, a subclass of Integrator or OneStep"
        missing = ", ".join(sorted(member.__abstractmethods__)) if inspect.isabstract(member) else ""
        return f"a class that writes {missing}" if missing else ""

    def _shown(self, member: Any) -> str:
        return str(member.__name__)

    # ---------------------------------------------------------------- the clauses

    @after()
    def test_clause_1_name_order_and_traits_are_declared(self, integrator: type[Integrator]) -> None:
        for name, kind in (("order", int), ("adaptive", bool), ("symplectic", bool)):
            value = getattr(integrator, name, None)
            if type(value) is not kind or (kind is int and value < 1):
                mend = f"write  {name} = ...  in the class: a {kind.__name__}" + (" above 0" if kind is int else "")
                self._broken("clause 1", integrator, f"{name} is {value!r}", mend)
        self._check_name(integrator)

    @after("clause_1_name")
    def test_clause_1_it_is_registered_under_its_name(self, integrator: type[Integrator]) -> None:
        self._check_registered("integrators", integrator)
        takes, setting = find("integrators", integrator.name).takes, "rtol" if integrator.adaptive else "step"
        if takes and setting not in takes.split():
            mend = f'write  takes="{setting}"  in the Entry, or change adaptive'
            self._broken("clause 1", integrator, f"adaptive is {integrator.adaptive}, and takes {takes!r}", mend)

    @after("clause_3")
    def test_clause_1_order_is_that_of_the_error(self, integrator: type[Integrator]) -> None:
        slope, allowed = _slope(integrator)
        if not abs(slope - integrator.order) <= allowed:
            what = (
                f"the error of smooth motion goes with the step to the power {slope:.2f}, order is {integrator.order}"
            )
            self._broken("clause 1", integrator, what, "check the coefficients, or declare the order that it has")

    @after("clause_1_order")
    def test_clause_1_symplectic_is_true(self, integrator: type[Integrator]) -> None:
        # Steps that are chosen by the state lose what each keeps; and steps of a size cannot be had of every method.
        if integrator.adaptive and not (integrator.symplectic and issubclass(integrator, OneStep)):
            return
        defect = motion.form_defect(integrator)
        if integrator.symplectic == (defect <= _KEPT):
            return
        does = "keeps" if defect <= _KEPT else "does not keep"
        what = (
            f"symplectic is {integrator.symplectic}, and a step {does} the symplectic form: M^T J M - J is"
            f" {defect:.1e}, where M is the derivative of a step of size 1 by positions and velocities"
        )
        mend = f"write  symplectic = {not integrator.symplectic}" + (
            ", or check the coefficients" if integrator.symplectic else ""
        )
        self._broken("clause 1", integrator, what, mend)

    @after("one_step_clause_3")
    def test_clause_2_the_setting_of_its_kind_is_used_and_the_other_ignored(self, integrator: type[Integrator]) -> None:
        if not integrator.adaptive:
            plain, other = (motion.ends(integrator(size=0.05, tolerance=t), 0.3) for t in (1e-9, 1e-3))
            self._check_ignored(integrator, "tolerance", plain, other)
            halved = motion.ends(integrator(size=0.025), 0.3)
            longest = float(max(np.diff([0.0, *halved])))
            if not longest <= 0.025 * (1 + _ROUNDING):
                what = f"with size = 0.025 the longest step is {longest:.9g}"
                self._broken("clause 2", integrator, what, "take no step longer than self.size")
            return
        plain, other = (motion.ends(integrator(size=size), 1.0) for size in (0.05, 0.3))
        self._check_ignored(integrator, "size", plain, other)
        for tolerance in _TOLERANCES:
            error = motion.off(motion.taken(integrator(tolerance=tolerance), until=3.0)[-1])
            if not error <= _ADDED * tolerance:
                what = f"with tolerance = {tolerance:g} the error at t = 3 is {error:.1e}"
                mend = "keep the estimate of each step's error, of positions and velocities, below self.tolerance"
                self._broken("clause 2", integrator, what, mend)

    @after("clause_1_name", "one_step_clause_1", "clause_4_positions")
    def test_clause_3_steps_join_from_begin_to_until(self, integrator: type[Integrator]) -> None:
        # A length that is no multiple of any step; and 0.7 + (2.82 - 0.7) is a rounding error beyond 2.82.
        for begin, until, size in ((0.1, 2.0 + 1 / 3, 0.05), (0.7, 2.82, 3.0)):
            watched = Watched(coupled)
            taken = motion.taken(integrator(size=size), watched, until, *path(begin), begin=begin)
            times = [begin, *(step.end for step in taken)]
            mend = "let each step begin where the last has ended, and the last end on until itself"
            gap = next((pair for pair in zip(taken, times, strict=False) if pair[0].begin != pair[1]), None)
            if gap is not None:
                what = f"a step begins at {gap[0].begin!r}, the one before has ended at {gap[1]!r}"
                self._broken("clause 3", integrator, what, mend)
            if times[-1] != until:
                what = f"the last step ends at {times[-1]!r}, and until is {until!r}"
                self._broken("clause 3", integrator, what, mend)
            if not begin <= min(watched.times) <= max(watched.times) <= until:
                what = f"a stage lies at t = {max(watched.times)!r} or {min(watched.times)!r}"
                mend = f"call the acceleration from begin = {begin!r} to until = {until!r} only; mind rounding"
                self._broken("clause 3", integrator, what, mend)
            sizes = np.diff(times)
            if not integrator.adaptive and not np.allclose(sizes, sizes[0], rtol=1e-9, atol=0):
                what = f"steps of fixed size range from {min(sizes):.9g} to {max(sizes):.9g}"
                self._broken("clause 3", integrator, what, "divide the interval into equal steps")

    @after("clause_1_name")
    def test_clause_4_positions_are_given_whole(self, integrator: type[Integrator]) -> None:
        watched, (x, v) = Watched(hertz), motion.STRUCK
        with suppress(Exception):  # what is raised for other reasons is told of elsewhere
            motion.taken(integrator(), watched, 0.2, x, v)
        shapes = set(watched.shapes) - {x.shape}
        if shapes:
            what = f"the acceleration is called with positions of shape {shapes.pop()}, the chain has {x.shape}"
            self._broken("clause 4", integrator, what, "give it the positions of all granules, and nothing else")

    @after("clause_1_order")
    def test_clause_4_contacts_that_open_are_borne(self, integrator: type[Integrator]) -> None:
        method = integrator(tolerance=1e-8, size=_STEP / 2)
        step = motion.taken(method, hertz, motion.STRUCK_UNTIL, *motion.STRUCK)[-1]
        error = float(np.max(np.abs(np.subtract((step.x, step.v), motion.struck()))))
        if not error <= _OPENING:
            what = f"five granules that come apart are off by {error:.1e}, {_OPENING:g} is allowed"
            mend = "do not rely on second derivatives; call the acceleration anew rather than change what it returned"
            self._broken("clause 4", integrator, what, mend)

    @after("clause_3")
    def test_clause_5_evaluations_are_counted(self, integrator: type[Integrator]) -> None:
        method, watched = integrator(), Watched(coupled)
        for until in (1.0, 2.0):
            for step in motion.taken(method, watched, until):
                step.interpolate((step.begin + step.end) / 2)
        if method.evaluations != len(watched.times):
            what = f"evaluations is {method.evaluations}, the acceleration was called {len(watched.times)} times"
            mend = "call what self._counted(acceleration, until) returns, in interpolate too, and never set it back"
            self._broken("clause 5", integrator, what, mend)

    @after("clause_3")
    def test_clause_6_arrays_stay_as_they_were(self, integrator: type[Integrator]) -> None:
        x, v = path(0.0)
        kept: list[tuple[Step, list[FloatArray]]] = []
        for step in motion.limited(integrator().steps(coupled, 0.0, 1.0, x, v, None)):
            step.interpolate((step.begin + step.end) / 2)
            kept.append((step, [array.copy() for array in (step.x, step.v, step.a)]))
        if not np.array_equal((x, v), path(0.0)):
            self._broken("clause 6", integrator, "the arrays x, v that were given were changed", "work on copies")
        for step, arrays in kept:
            if not all(map(np.array_equal, (step.x, step.v, step.a), arrays)):
                what = f"x, v or a of the step that ends at t = {step.end!r} was changed after it was yielded"
                self._broken("clause 6", integrator, what, "yield a new array for each step")

    @after("clause_1_order")
    def test_clause_7_interpolation_is_as_accurate_as_the_step(self, integrator: type[Integrator]) -> None:
        before = path(0.0)
        taken = motion.taken(integrator(tolerance=1e-7, size=_STEP), until=3.0)
        allowed = _DENSE * max(1e-7, *map(motion.off, taken))
        mend = "interpolate from what the step itself holds, with a polynomial of its order or by a shorter step"
        for step in taken:
            for time, state in ((step.begin, before), (step.end, (step.x, step.v))):
                off = float(np.max(np.abs(np.subtract(step.interpolate(time), state))))
                if not off <= _ROUNDING:
                    what = f"interpolate({time!r}) is off the end of the step by {off:.1e}"
                    self._broken("clause 7", integrator, what, mend)
            for share in (0.2, 0.5, 0.8):
                time = step.begin + share * (step.end - step.begin)
                off = float(np.max(np.abs(np.subtract(step.interpolate(time), path(time)))))
                if not off <= allowed:
                    what = f"interpolate({time!r}), within a step, is off by {off:.1e}; {allowed:.1e} is allowed"
                    self._broken("clause 7", integrator, what, mend)
            before = step.x, step.v

    @after("clause_3")
    def test_clause_8_what_is_not_finite_is_an_error(self, integrator: type[Integrator]) -> None:
        mend = 'raise NumericalError(f"{self.name} cannot step beyond t = {time:g} T0 (not finite)")'
        for since, value in ((0.0, math.nan), (1.0, math.nan), (1.0, math.inf)):
            case = f"for an acceleration of {value} from t = {since:g} on"
            try:
                taken = motion.taken(integrator(), motion.broken(since, value), 3.0)
            except NumericalError:
                continue
            except Exception as error:
                self._broken("clause 8", integrator, f"{told(error)} is raised {case}", mend)
            bad = next((step for step in taken if not np.all(np.isfinite((step.x, step.v, step.a)))), None)
            what = "no error is raised" if bad is None else f"the step that ends at {bad.end!r} is not finite"
            self._broken("clause 8", integrator, f"{what} {case}", mend)

    @after("clause_3")
    def test_clause_9_it_may_be_left_and_started_again(self, integrator: type[Integrator]) -> None:
        used = integrator()
        try:
            for left in islice(used.steps(hertz, 0.0, 3.0, np.linspace(0.5, 0.0, 12), np.ones(12), None), 2):
                left.interpolate(left.end)
            again, fresh = motion.taken(used), motion.taken(integrator())
        except Exception as error:
            what = f"{told(error)} is raised when it is left after two steps and started with fewer granules"
            self._broken("clause 9", integrator, what, "keep what belongs to a run in local variables of steps")
        if [[step.end, *step.x] for step in again] != [[step.end, *step.x] for step in fresh]:
            what = "an object that was left after two steps takes other steps than a new one"
            self._broken("clause 9", integrator, what, "keep what belongs to a run in local variables of steps")

    # ---------------------------------------------------------------- the clauses of one step

    @after("clause_1_name")
    def test_one_step_clause_1_attempt_stays_within_the_step(self, integrator: type[Integrator]) -> None:
        method, watched = _one_step(integrator)(), Watched(coupled)
        (x, v), time, size = path(0.3), 0.3, 0.1
        given = x, v, coupled(time, x)
        before = [array.copy() for array in given]
        tried = method.attempt(watched, time, size, *given)
        if not isinstance(tried, Attempt):
            what = f"attempt returns a {type(tried).__name__}"
            self._broken("one-step clause 1", integrator, what, "return Attempt(x, v, a, error)")
        mend = "call the acceleration from time to time + size, and return new arrays"
        if not time <= min(watched.times) <= max(watched.times) <= (time + size) * (1 + _ROUNDING):
            what = f"for time = 0.3, size = 0.1 a stage lies at {min(watched.times)!r} or {max(watched.times)!r}"
            self._broken("one-step clause 1", integrator, what, mend)
        if method.evaluations:
            what = f"attempt counts {method.evaluations} evaluations"
            self._broken("one-step clause 1", integrator, what, "leave evaluations to the caller, who counts them")
        shared = any(np.shares_memory(new, old) for new in tried[:3] for old in given)
        if shared or not all(map(np.array_equal, given, before)):
            self._broken("one-step clause 1", integrator, "it changes the arrays x, v, a given, or returns one", mend)
        if not np.allclose(tried.a, coupled(time + size, tried.x), rtol=0, atol=_ROUNDING):
            what = "the acceleration that it returns is not that at the end of the step"
            self._broken("one-step clause 1", integrator, what, "return acceleration(time + size, x) as a")
        try:
            with np.errstate(all="ignore"):
                method.attempt(motion.broken(0.0, math.nan), time, size, *given)
        except Exception as error:
            what = f"{told(error)} is raised for an acceleration that is not finite"
            self._broken("one-step clause 1", integrator, what, "leave it to the caller to look for such numbers")

    @after("one_step_clause_1")
    def test_one_step_clause_2_a_batch_is_its_chains_side_by_side(self, integrator: type[Integrator]) -> None:
        method = _one_step(integrator)()
        times, sizes = np.array([0.0, 0.3, 1.1]), np.array([0.1, 0.25, 0.0])
        x, v = path(times)
        mend = "compute element by element: x, v, a may have a second axis, and time and size be arrays of its length"
        try:
            batch = method.attempt(coupled, times, sizes, x, v, coupled(times, x))
        except Exception as error:
            what = f"{told(error)} is raised for x of shape {x.shape}"
            self._broken("one-step clause 2", integrator, what, remedy(error, otherwise=mend))
        for lane, (time, size) in enumerate(zip(times.tolist(), sizes.tolist(), strict=True)):
            x, v = path(time)
            alone = method.attempt(coupled, time, size, x, v, coupled(time, x))
            for name, several, one in zip(("x", "v", "a"), batch, alone, strict=False):
                off = float(np.max(np.abs(np.asarray(several)[:, lane] - one)))
                if not off <= _ROUNDING:
                    what = f"{name} of chain {lane} of a batch is off by {off:.1e} from what it is alone"
                    self._broken("one-step clause 2", integrator, f"{what} (time {time}, size {size})", mend)
            if size == 0 and not np.allclose((alone.x, alone.v), (x, v), rtol=0, atol=_ROUNDING):
                what = "a step of size 0 moves the granules"
                self._broken("one-step clause 2", integrator, what, "let every change be a multiple of size")

    @after("clause_1_order")
    def test_one_step_clause_3_the_estimate_shows_the_order_declared(self, integrator: type[Integrator]) -> None:
        cls = _one_step(integrator)
        if not cls.adaptive:
            if cls.error_order:
                what = f"error_order is {cls.error_order}, and adaptive is False"
                self._broken("one-step clause 3", integrator, what, "leave error_order out")
            return
        slope = motion.slope(lambda size: motion.estimate(cls(), size))
        if not abs(slope - cls.error_order - 1) <= _SLOPE:
            what = f"the estimate goes with the step to the power {slope:.2f}, error_order is {cls.error_order}"
            mend = "declare the order of the embedded method: the power less 1"
            self._broken("one-step clause 3", integrator, what, mend)

    # ---------------------------------------------------------------- beside the clauses

    @after("clause", "one_step_clause")
    def test_it_simulates_a_chain(self, integrator: type[Integrator]) -> None:
        own, best = motion.peak_with(integrator(tolerance=1e-8, size=_STEP)), motion.reference_peak()
        # Steps of 0.02 of a method of order 2 are some 1e-4 off.
        if not abs(own / best - 1) <= 1e-3:
            what = f"the peak force behind a triangular shock is {own:.9g}, by the default method {best:.9g}"
            self._broken("simulation", integrator, what, "see to the clauses first")

    # ---------------------------------------------------------------- for the clauses

    def _check_ignored(self, integrator: type[Integrator], name: str, ends: list[float], others: list[float]) -> None:
        if ends != others:
            what = f"another {name} gives other steps, {len(others)} in place of {len(ends)}"
            kind = "adaptive" if integrator.adaptive else "of fixed step"
            self._broken("clause 2", integrator, what, f"do not read self.{name}: the method is {kind}")


def _one_step(integrator: type[Integrator]) -> type[OneStep]:
    if not issubclass(integrator, OneStep):
        pytest.skip(f"{integrator.__name__} is an Integrator, and no OneStep")
    return integrator


def _slope(integrator: type[Integrator]) -> tuple[float, float]:
    """The power of the step with which the error goes, and how far the order may be off it."""
    allowed = _SLOPE if integrator.order < _HIGH_ORDER else _HIGH_SLOPE
    if issubclass(integrator, OneStep):
        return motion.slope(lambda size: motion.error_of_attempts(integrator(), size)), allowed
    if not integrator.adaptive:
        return motion.slope(
            lambda size: motion.off(motion.taken(integrator(size=size), until=motion.SPAN)[-1])
        ), allowed
    loose, tight = (motion.taken(integrator(tolerance=tolerance), until=20.0) for tolerance in (1e-6, 1e-9))
    more = max(len(tight) / len(loose), 1 + _ROUNDING)
    return math.log(motion.off(loose[-1]) / motion.off(tight[-1])) / math.log(more), _CHOSEN_SLOPE
