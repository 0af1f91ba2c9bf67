"""Tests of integrators against each clause of the contracts of `Integrator` and `OneStep`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import islice
from typing import ClassVar

import numpy as np
import pytest

import shockwave.testing.known_motions as motion
from shockwave.base.errors import NumericalError
from shockwave.engine.integrator import Integrator
from shockwave.engine.nystroem_integrators import Rkn1210
from shockwave.engine.one_step import Attempt, OneStep
from shockwave.testing.contract import Contract, check_registered
from shockwave.testing.known_motions import Watched, distance, hertz, smooth_force, smooth_motion

# Largest difference between the slope of the error and the order.
_SLOPE = 0.75
# The same for orders of at least 9, whose errors reach rounding before the asymptotic range.
_HIGH_SLOPE = 1.25
# Granules of mixed chains before a wall, and those of which the errors under a static load are in the asymptotic range.
_GRANULES = (1, 2, 5, 40)
_ASYMPTOTIC = 5
_TOLERANCES = (1e-4, 1e-7, 1e-10)
# Largest error of a run in units of the tolerance; the errors of about ten steps add up.
_ADDED = 30.0
# Size of fixed steps, in characteristic times.
_STEP = 0.02
_ROUNDING = 1e-12
# Largest error of the interpolation in units of that of the steps; a dense output of lower order is about ten times
# less accurate.
_DENSE = 30.0
# Largest error of a peak force; a method of order 2 with steps of 0.02 has about 1e-4.
_PEAK = 1e-3


class IntegratorContract(Contract):
    """Tests of integrators against the contracts of `Integrator` and, for its subclasses, `OneStep`.

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
        Omitted clauses, with the reasons: ``{"clause 7": "linear between the steps, for pictures"}``,
        ``{"one-step clause 2": "..."}``. They are shown as skipped. Tests that are not clauses are given by name.
    """

    integrators: ClassVar[Sequence[type[Integrator]]]

    _member = "integrator"

    def test_clause_1_name_order_and_traits_are_declared(self, integrator: type[Integrator]) -> None:
        check_registered("integrators", integrator)
        order = getattr(integrator, "order", None)
        assert isinstance(order, int), f"order must be a whole number (got {order!r})"
        assert isinstance(getattr(integrator, "adaptive", None), bool), "adaptive must be True or False"

    @pytest.mark.parametrize("granules", [0, *_GRANULES], ids=["smooth", *map(str, _GRANULES)])
    def test_clause_1_order_is_that_of_the_error(self, integrator: type[Integrator], granules: int) -> None:
        slope = motion.mixed_slope(integrator, granules) if granules else motion.slope(integrator)
        allowed = _SLOPE if integrator.order < 9 else _HIGH_SLOPE
        message = f"order is {integrator.order}, and the error scales as the step to the power {slope:.2f}"
        assert slope >= integrator.order - allowed, message
        # between the tolerances the errors of other loaded chains decrease faster than in the asymptotic range
        assert slope <= integrator.order + allowed or (integrator.adaptive and granules not in (0, _ASYMPTOTIC)), (
            message
        )

    def test_clause_2_the_setting_of_its_kind_is_used(self, integrator: type[Integrator]) -> None:
        if integrator.adaptive:
            for tolerance in _TOLERANCES:
                error = motion.step_error(motion.all_steps(integrator(tolerance=tolerance))[-1])
                assert error <= _ADDED * tolerance, f"with tolerance = {tolerance:g} the error at t = 3 is {error:.1e}"
        else:
            steps = motion.all_steps(integrator(size=0.025), until=1.0)
            longest = max(step.end - step.begin for step in steps)
            assert longest <= 0.025 * (1 + _ROUNDING), f"with size = 0.025 the longest step is {longest:.9g}"

    # A length that is not a multiple of any step; and 0.7 + (2.82 - 0.7) exceeds 2.82 by a rounding error.
    @pytest.mark.parametrize(("begin", "until", "size"), [(0.1, 2.0 + 1 / 3, 0.05), (0.7, 2.82, 3.0)])
    def test_clause_3_steps_join_from_begin_to_until(
        self, integrator: type[Integrator], begin: float, until: float, size: float
    ) -> None:
        watched = Watched(smooth_force)
        steps = motion.all_steps(integrator(size=size), watched, until, begin=begin)
        ends = [begin, *(step.end for step in steps)]
        for step, end in zip(steps, ends, strict=False):
            assert step.begin == end, f"a step begins at {step.begin!r}, and the one before ends at {end!r}"
        assert ends[-1] == until, f"the last step must end at until = {until!r} (got {ends[-1]!r})"
        watched.check_within(begin, until)
        sizes = np.diff(ends)
        equal = integrator.adaptive or np.allclose(sizes, sizes[0], rtol=1e-9, atol=0)
        assert equal, f"steps of fixed size range from {min(sizes):.9g} to {max(sizes):.9g}"

    def test_clause_4_positions_are_given_whole(self, integrator: type[Integrator]) -> None:
        watched = Watched(hertz)
        motion.all_steps(integrator(), watched, 0.2, motion.STRUCK)
        shapes = set(watched.shapes)
        assert shapes == {(5,)}, f"the acceleration is called with positions of shape {shapes} instead of (5,)"

    @pytest.mark.parametrize("granules", _GRANULES)
    def test_clause_4_contacts_may_open(self, integrator: type[Integrator], granules: int) -> None:
        forces = motion.mixed_forces(integrator, granules, 1e-6 if integrator.adaptive else _STEP)
        error = motion.distance(forces, motion.mixed_forces(Rkn1210, granules, 1e-12))
        message = f"the error of the greatest forces at the contacts of {granules} granules, which open, is {error:.1e}"
        assert error <= _PEAK, f"{message}: use neither second derivatives of the force nor arrays from earlier calls"

    def test_clause_5_evaluations_are_counted(self, integrator: type[Integrator]) -> None:
        method, watched = integrator(), Watched(smooth_force)
        for until in (1.0, 2.0):
            for step in motion.all_steps(method, watched, until):
                step.interpolate((step.begin + step.end) / 2)
        count = len(watched.times)
        message = f"evaluations is {method.evaluations}, but the acceleration was called {count} times (use Counted)"
        assert method.evaluations == count, message

    def test_clause_6_arrays_stay_as_they_were(self, integrator: type[Integrator]) -> None:
        x, v = smooth_motion(0.0)
        copies = []
        for step in integrator().steps(smooth_force, 0.0, 1.0, x, v, None):
            step.interpolate((step.begin + step.end) / 2)
            copies.append((step, np.array((step.x, step.v, step.a))))
        assert np.array_equal((x, v), smooth_motion(0.0)), "the input arrays x, v were changed"
        for step, arrays in copies:
            same = np.array_equal((step.x, step.v, step.a), arrays)
            assert same, f"x, v or a of the step that ends at t = {step.end!r} was changed after it was yielded"

    def test_clause_7_interpolation_is_as_accurate_as_the_step(self, integrator: type[Integrator]) -> None:
        steps = motion.all_steps(integrator(tolerance=1e-7, size=_STEP))
        within = _DENSE * max(1e-7, *map(motion.step_error, steps))
        before = smooth_motion(0.0)
        for step in steps:
            between = [step.begin + share * (step.end - step.begin) for share in (0.2, 0.5, 0.8)]
            cases = [(time, smooth_motion(time), within) for time in between]
            cases += [(step.begin, before, _ROUNDING), (step.end, (step.x, step.v), _ROUNDING)]
            for time, state, allowed in cases:
                error = distance(step.interpolate(time), state)
                assert error <= allowed, f"the error of interpolate({time!r}) is {error:.1e} (limit {allowed:.1e})"
            before = step.x, step.v

    @pytest.mark.parametrize(("since", "value"), [(0.0, math.nan), (1.0, math.nan), (1.0, math.inf)])
    def test_clause_8_not_finite_is_an_error(self, integrator: type[Integrator], since: float, value: float) -> None:
        with pytest.raises(NumericalError):
            motion.all_steps(integrator(), motion.broken_acceleration(since, value))

    def test_clause_9_it_may_be_left_and_started_again(self, integrator: type[Integrator]) -> None:
        used = integrator()
        for left in islice(used.steps(hertz, 0.0, 3.0, np.linspace(0.5, 0.0, 12), np.ones(12), None), 2):
            left.interpolate(left.end)
        again, fresh = ([[step.end, *step.x] for step in motion.all_steps(method)] for method in (used, integrator()))
        assert again == fresh, "an object that was used for two steps takes different steps than a new one"

    def test_one_step_clause_1_attempt_stays_within_the_step(self, integrator: type[Integrator]) -> None:
        method, watched = _one_step(integrator)(), Watched(smooth_force)
        x, v = smooth_motion(0.3)
        start = np.array((x, v, smooth_force(0.3, x)))
        before = start.copy()
        tried = method.attempt(watched, 0.3, 0.1, *start)
        assert isinstance(tried, Attempt), f"attempt must return an Attempt (got a {type(tried).__name__})"
        watched.check_within(0.3, 0.4 + _ROUNDING)
        assert not method.evaluations, f"attempt must not count evaluations (got {method.evaluations})"
        new = np.array_equal(start, before) and not any(np.shares_memory(array, start) for array in tried[:3])
        assert new, "attempt changes or returns the input arrays x, v, a"
        error = distance(tried.a, smooth_force(0.4, tried.x))
        assert error <= _ROUNDING, "the returned acceleration is not that at the end of the step"
        with np.errstate(all="ignore"):  # the caller checks for such numbers
            method.attempt(motion.broken_acceleration(0.0, math.nan), 0.3, 0.1, *start)

    def test_one_step_clause_2_a_batch_is_its_chains_side_by_side(self, integrator: type[Integrator]) -> None:
        method = _one_step(integrator)()
        times, sizes = np.array([0.0, 0.3, 1.1]), np.array([0.1, 0.25, 0.0])
        x, v = smooth_motion(times)
        batch = method.attempt(smooth_force, times, sizes, x, v, smooth_force(times, x))
        for chain, (time, size) in enumerate(zip(times.tolist(), sizes.tolist(), strict=True)):
            x, v = smooth_motion(time)
            alone = method.attempt(smooth_force, time, size, x, v, smooth_force(time, x))
            error = distance(np.array(batch[:3])[..., chain], alone[:3])
            assert error <= _ROUNDING, f"chain {chain} of a batch differs by {error:.1e} from the same chain alone"
            still = size > 0 or distance((alone.x, alone.v), (x, v)) <= _ROUNDING
            assert still, "a step of size 0 moves the granules"

    def test_one_step_clause_3_the_estimate_shows_the_order_declared(self, integrator: type[Integrator]) -> None:
        cls = _one_step(integrator)
        if not cls.adaptive:
            assert not cls.error_order, f"error_order must be 0 if adaptive is False (got {cls.error_order})"
            return
        slope = motion.slope_of_estimate(cls)
        message = f"error_order is {cls.error_order}, and the estimate scales as the step to the power {slope:.2f}"
        assert abs(slope - cls.error_order - 1) <= _SLOPE, message

    def test_it_simulates_a_chain(self, integrator: type[Integrator]) -> None:
        own = motion.peak_with(integrator(tolerance=1e-8, size=_STEP))
        assert own == pytest.approx(motion.best_peak(), rel=_PEAK), "the peak force of the leading wave is wrong"


def _one_step(integrator: type[Integrator]) -> type[OneStep]:
    if not issubclass(integrator, OneStep):
        pytest.skip(f"{integrator.__name__} is not a OneStep")
    return integrator
