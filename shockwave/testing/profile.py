"""The contract of a profile, clause by clause."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, ClassVar

import attrs
import numpy as np

from shockwave.fields import quantity_of
from shockwave.measurement.simulate import simulate
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.quadrature import FloatArray
from shockwave.testing.contract import Contract, after, guarded
from shockwave.testing.faults import remedy, told
from shockwave.testing.pulses import CHAIN, MANY, are_numbers, branches, integral, is_unit, sampled, shock
from shockwave.testing.smoothness import roughness, steepening

__all__ = ["ProfileContract"]

# What is written for one number fails for several, so they come first.
_SHAPES: tuple[tuple[int, ...], ...] = ((5,), (2, 3), (), (0,))
# Vectorised functions may round differently from those of one number.
_SAME = 1e-12
# A quotient of exponentials may round up next to its peak, and a sine may round down next to its end.
_ROUNDING = 4 * float(np.finfo(float).eps)
# "Good to a few units in the last place", as far as a quadrature can tell.
_CLOSED = 3e-12
# Numbers near the least have fewer digits.
_LEAST = 1e-300
# Shares of rise and decay at which running integrals are compared, and those for a profile of many breakpoints.
_SHARES, _FEW_SHARES = (1e-6, 1e-3, 0.1, 0.45, 0.8, 0.999, 1.0), (0.3, 1.0)
_FINAL = ("force", "areas", "running_impulse", "double_integral", "free_path")


class ProfileContract(Contract):
    """Tests of profiles against the contract of `shockwave.ShockProfile`; a subclass lists them.

    ::

        from shockwave.testing import ProfileContract
        from my_pulses.trapezoid import Trapezoid

        class TestTrapezoid(ProfileContract):
            profiles = [Trapezoid(plateau=2, duration_ratio=5)]

    Attributes
    ----------
    profiles : list of ShockProfile
        Objects, not classes: take the parameters at the ends of their ranges, too.
    leave_out : dict of str
        Clauses that are left out, each with the reason: ``{"clause 7": "the closed form is good to 1e-9"}``. They
        are shown as skipped. A test that is no clause goes by its name.
    """

    profiles: ClassVar[Sequence[ShockProfile]]

    _list = "profiles"
    _member = "profile"
    _example = "profiles = [MyProfile(duration_ratio=3)]"
    _signed: ClassVar[dict[str, type]] = {"": ShockProfile}

    def _problem(self, member: object) -> str:
        if isinstance(member, type):
            return "an object, not its class"
        return "" if isinstance(member, ShockProfile) else "a ShockProfile"

    # ---------------------------------------------------------------- the clauses

    @after()
    def test_clause_1_duration_ratio_is_a_float_above_1(self, profile: ShockProfile) -> None:
        n: object = getattr(profile, "duration_ratio", None)
        if not isinstance(n, float) or not 1 < n < math.inf:
            mend = "return a finite float above 1: the whole duration over the rise time"
            self._broken("clause 1", profile, f"duration_ratio is {n!r}", mend)

    @after()
    def test_clause_1_fields_are_parameters_with_unit_and_meaning(self, profile: ShockProfile) -> None:
        cls: type = type(profile)
        for field in attrs.fields(cls) if attrs.has(cls) else ():
            spec = quantity_of(field) if field.init else None
            if spec is None:
                continue
            if not is_unit(spec.unit):
                what = f"the field {field.name} has the unit {spec.unit!r}, and there is no such unit"
                mend = 'write the symbol of an SI unit, "s", "N", "m", "kg", "m/s", or "" where there is no dimension'
                self._broken("clause 1", profile, what, mend)
            if not spec.meaning:
                mend = f'write  {field.name}: float = quantity({spec.unit!r}, "what it means", ...)'
                what = f"the field {field.name} has no meaning: it is {spec.meaning!r}"
                self._broken("clause 1", profile, what, mend)

    @after("clause_1_duration_ratio")
    def test_clause_2_rise_and_decay_keep_the_shape_of_their_argument(self, profile: ShockProfile) -> None:
        for name, shape_of, lower, upper in branches(profile):
            row = np.linspace(lower, upper, 6)[[3, 0, 5, 1, 4, 2]]
            arrays = []
            for shape in _SHAPES:
                got = self._called("clause 2", profile, name, shape_of, np.resize(row, shape))
                if np.shape(got) != shape or np.asarray(got).dtype != np.dtype(float):
                    found = f"shape {np.shape(got)} of {np.asarray(got).dtype}"
                    what = f"{name}(s) for an s of shape {shape} of floats has {found}"
                    mend = "compute with numpy functions alone from the array that is given; 0 * s + 1 is a constant 1"
                    self._broken("clause 2", profile, what, mend)
                arrays.append((shape, np.ravel(got).tolist()))
            self._check_elements(profile, name, shape_of, row, arrays)

    @after("clause_4", "clause_5_breakpoints_ascend")
    def test_clause_3_values_are_finite_between_0_and_1_and_1_at_the_peak(self, profile: ShockProfile) -> None:
        for name, shape_of, lower, upper in branches(profile):
            s = sampled(profile, lower, upper)
            values = np.asarray(shape_of(s.copy()), dtype=float)
            wrong = np.flatnonzero(~((values >= -_ROUNDING) & (values <= 1 + _ROUNDING)))
            if wrong.size:
                at, value = float(s[wrong[0]]), float(values[wrong[0]])
                mend = "divide the force by its peak; take np.maximum(..., 0.0) where rounding leaves less than 0"
                what = f"{name}(s) at s = {at!r} is {value!r}, and must be finite, at least 0, at most 1"
                self._broken("clause 3", profile, what, mend)
        mend = "let rise and decay meet at the peak, s = 1, where the force over its peak is 1"
        for name, shape_of, *_ in branches(profile):
            peak = float(shape_of(np.array([1.0]))[0])
            if not abs(peak - 1) <= _SAME:
                self._broken("clause 3", profile, f"{name}(s) at s = 1.0 is {peak!r}, and must be 1", mend)

    @after("clause_2")
    def test_clause_4_rise_and_decay_are_pure(self, profile: ShockProfile) -> None:
        mend = "compute from s and the fields alone: no counters, no random numbers, no arithmetic in place on s"
        twin = guarded(
            lambda: copy.deepcopy(profile),
            lambda error: self._broken("clause 4", profile, f"it cannot be copied ({told(error)})", mend),
        )
        for name, shape_of, lower, upper in branches(profile):
            s = np.linspace(lower, upper, 101)
            given = s.copy()
            first = np.array(shape_of(given))
            if not np.array_equal(given, s):
                at = int(np.flatnonzero(given != s)[0])
                what = (
                    f"{name}(s) writes to the array that it is given: s = {float(s[at])!r} became {float(given[at])!r}"
                )
                self._broken("clause 4", profile, what, mend)
            given.setflags(write=False)
            shape_of(np.linspace(lower, upper, 7))
            again = np.array(self._called("clause 4", profile, name, shape_of, given))
            for how, values in (("when called again", again), ("of a copy of it", np.array(getattr(twin, name)(s)))):
                other = np.flatnonzero(~((values == first) | (np.isnan(values) & np.isnan(first))))
                if other.size:
                    at = int(other[0])
                    what = f"{name}(s) at s = {float(s[at])!r} is {float(first[at])!r}, and {float(values[at])!r} {how}"
                    self._broken("clause 4", profile, what, mend)

    @after("clause_1_duration_ratio")
    def test_clause_5_breakpoints_ascend_from_0_to_n_and_hold_1(self, profile: ShockProfile) -> None:
        points, n = profile.breakpoints, float(profile.duration_ratio)
        mend = "return a tuple of floats (0.0, ..., 1.0, ..., self.duration_ratio) that ascends"
        if not are_numbers(points):
            self._broken("clause 5", profile, f"breakpoints is {points!r}", mend)
        for former, latter in pairwise(points):
            if not former < latter:
                self._broken("clause 5", profile, f"{latter!r} follows {former!r} in breakpoints", mend)
        if not points or (points[0], points[-1]) != (0, n) or 1 not in points:
            what = f"breakpoints must begin with 0, hold 1 and end with duration_ratio, {n!r} (got {points!r})"
            self._broken("clause 5", profile, what, mend)

    @after("clause_3")
    def test_clause_5_breakpoints_tell_every_jump_and_kink(self, profile: ShockProfile) -> None:
        points = profile.breakpoints
        for name, shape_of, lower, upper in branches(profile):
            inside = tuple(float(point) for point in points if lower <= point <= upper)
            rough = roughness(shape_of, inside)
            if rough is not None:
                what = (
                    f"{name}(s) has {rough.kind} at s = {rough.at:.9g} (between {rough.begin!r} and {rough.end!r}),"
                    " which is not among the breakpoints"
                )
                mend = f"add the exact s to breakpoints, which holds {inside!r} there"
                self._broken("clause 5", profile, what, mend)

    @after("clause_5")
    def test_clause_6_singular_points_are_the_breakpoints_of_unbounded_slope(self, profile: ShockProfile) -> None:
        points, singular = profile.breakpoints, profile.singular_points
        mend = "return a tuple of those members of breakpoints next to which the slope grows without end"
        if not are_numbers(singular):
            self._broken("clause 6", profile, f"singular_points is {singular!r}", mend)
        for point in singular:
            if point not in points:
                what = f"{point!r} is in singular_points, and not in breakpoints"
                self._broken("clause 6", profile, what, mend)
        for name, shape_of, lower, upper in branches(profile):
            inside = [point for point in points if lower <= point <= upper]
            for point, other in [*pairwise(inside), *pairwise(reversed(inside))]:
                slope = steepening(shape_of, point, other) if point not in singular else None
                if slope is not None:
                    what = f"the slope of {name}(s) next to s = {point!r} grows without end, {slope:.3g} and more"
                    self._broken("clause 6", profile, what, mend)

    @after("clause_5")
    def test_clause_7_closed_forms_agree_with_quadrature(self, profile: ShockProfile) -> None:
        n, mend = float(profile.duration_ratio), "check the formula; return None to have the integral by quadrature"
        self._check_areas(profile, n, mend)
        shares = _SHARES if len(profile.breakpoints) <= MANY else _FEW_SHARES
        times = np.array([*shares, *(1 + (n - 1) * share for share in shares)])
        for name in ("closed_running_impulse", "closed_double_integral"):
            self._check_closed(profile, name, times, mend)
        path = profile.closed_free_path()
        if path is not None:
            for what, index in (("path", 0), ("impulse", 1)):
                whole = integral(profile, 0.0, n, moment=index == 0).value
                for s in times.tolist():
                    got, taken = path.at(s)[index], integral(profile, 0.0, s, moment=index == 0)
                    if not abs(got - taken.value) <= (_CLOSED + path.error) * whole + taken.error:
                        found = f"{got!r}, quadrature {taken.value:.12g} +- {taken.error:.1e}"
                        what = f"closed_free_path() gives the {what} at s = {s!r} as {found}"
                        self._broken("clause 7", profile, what, mend)

    @after()
    def test_clause_8_recorded_values_are_positive_or_none(self, profile: ShockProfile) -> None:
        for name, unit in (("recorded_peak_force", "newtons"), ("recorded_rise_time", "seconds")):
            value = getattr(profile, name)
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if value is not None and not (number and 0 < value < math.inf):
                mend = f"return {unit} as a float above 0, or None where nothing was measured"
                self._broken("clause 8", profile, f"{name} is {value!r}", mend)

    @after()
    def test_clause_9_notes_are_sentences(self, profile: ShockProfile) -> None:
        notes: object = profile.notes
        if not isinstance(notes, tuple) or not all(isinstance(note, str) and note.strip() for note in notes):
            mend = 'return a tuple of texts, ("the baseline was taken off",), or () where nothing was changed'
            self._broken("clause 9", profile, f"notes is {notes!r}", mend)

    # ---------------------------------------------------------------- beside the clauses

    @after()
    def test_other_methods_are_left_alone(self, profile: ShockProfile) -> None:
        for name in _FINAL:
            if getattr(type(profile), name) is not getattr(ShockProfile, name):
                mend = "write rise and decay, and the closed forms, and leave this method to ShockProfile"
                self._broken("the last sentence", profile, f"its class writes a {name} of its own", mend)

    @after("clause_4")
    def test_it_is_a_value(self, profile: ShockProfile) -> None:
        mend = "make the class with  @attrs.frozen ; fields of arrays take  eq=attrs.cmp_using(eq=numpy.array_equal)"
        cls = type(profile)
        if cls.__hash__ is None:
            self._broken("being a value", profile, "it cannot be hashed", mend)
        if cls.__eq__ is object.__eq__:
            return
        twin = copy.deepcopy(profile)
        same = guarded(
            lambda: bool(twin == profile) and hash(twin) == hash(profile),
            lambda error: self._broken(
                "being a value", profile, f"it cannot be compared and hashed ({told(error)})", mend
            ),
        )
        if not same:
            self._broken("being a value", profile, "a copy of it is not equal to it, or has another hash", mend)

    @after("clause", "other_methods")
    def test_it_is_predicted(self, profile: ShockProfile) -> None:
        outcome = Predictor().predict(shock(profile), CHAIN)
        if not 0 < outcome.peak_force < math.inf:
            mend = "see to the clauses first"
            self._broken("prediction", profile, f"the peak force predicted is {outcome.peak_force!r} N", mend)

    @after("it_is_predicted")
    def test_it_is_simulated(self, profile: ShockProfile) -> None:
        result = simulate(shock(profile), CHAIN, rtol=1e-3, waves="primary")
        if not result.error_estimate <= 1e-3:
            mend = "see to the clauses first; most often a breakpoint is missing"
            self._broken("simulation", profile, f"the peak force is known to {result.error_estimate:.1e} only", mend)

    # ---------------------------------------------------------------- for the clauses

    def _called(
        self, label: str, profile: ShockProfile, name: str, function: Callable[[FloatArray], Any], s: FloatArray
    ) -> Any:
        """What ``function`` gives at ``s``; an error of its own fails the test."""
        given = f"an s of shape {s.shape}" + ("" if s.flags.writeable else " that must not be written to")
        mend = "compute with numpy functions alone, element by element, and return a new array"
        return guarded(
            lambda: function(s),
            lambda error: self._broken(
                label, profile, f"{name}(s) raises {told(error)} for {given}", remedy(error, otherwise=mend)
            ),
        )

    def _check_elements(
        self,
        profile: ShockProfile,
        name: str,
        function: Callable[[FloatArray], Any],
        row: FloatArray,
        arrays: Sequence[tuple[tuple[int, ...], list[float]]],
    ) -> None:
        """Fail clause 2 where the values of ``arrays``, which begin with those of ``row``, depend on what is beside."""
        first, again = (
            [float(np.ravel(self._called("clause 2", profile, name, function, np.array([s])))[0]) for s in row]
            for _ in range(2)
        )
        if not np.array_equal(first, again, equal_nan=True):
            return  # values that change from call to call break clause 4
        for shape, values in arrays:
            for at, value, alone in zip(row.tolist(), values, first, strict=False):
                if not (abs(value - alone) <= _SAME or value == alone or math.isnan(value)):
                    within = f"in an array of shape {shape}" if shape else "as a number without axes, of shape (),"
                    what = f"{name}(s) at s = {at!r} is {alone!r} in an array of one, and {value!r} {within}"
                    mend = "compute each element from itself: no sum, maximum or length of s, no count of calls"
                    self._broken("clause 2", profile, what, mend)

    def _check_areas(self, profile: ShockProfile, n: float, mend: str) -> None:
        areas: object = profile.closed_areas()
        if areas is None:
            return
        if not (isinstance(areas, tuple | list) and are_numbers(areas) and len(areas) == 2):
            self._broken(
                "clause 7", profile, f"closed_areas() gives {areas!r}", "return a tuple of two floats, a1 and a2"
            )
        for name, closed, ends in (("a1", areas[0], (0.0, 1.0)), ("a2", areas[1], (1.0, n))):
            taken = integral(profile, *ends)
            if not abs(closed - taken.value) <= _CLOSED * abs(taken.value) + taken.error:
                what = (
                    f"closed_areas() gives {name} = {closed:.12g}, quadrature {taken.value:.12g} +- {taken.error:.1e}"
                )
                self._broken("clause 7", profile, what, mend)

    def _check_closed(self, profile: ShockProfile, name: str, ends: FloatArray, mend: str) -> None:
        function = getattr(profile, name)
        closed = self._called("clause 7", profile, name, function, ends.copy())
        if closed is None:
            return
        for shape in _SHAPES:
            got = np.shape(self._called("clause 7", profile, name, function, np.resize(ends, shape)))
            if got != shape:
                what = f"{name}(s) for an s of shape {shape} has shape {got}"
                self._broken("clause 7", profile, what, "return an array of the shape of s")
        moment = name == "closed_double_integral"
        whole = integral(profile, 0.0, float(profile.duration_ratio), moment).value
        for s, value in zip(ends.tolist(), np.asarray(closed).tolist(), strict=True):
            taken = integral(profile, 0.0, s, moment)
            # Near 0 no digit need be lost; in the decay, what is added up is as great as the whole.
            scale = abs(taken.value) if s <= 1 else whole
            if not abs(value - taken.value) <= _CLOSED * scale + taken.error + _LEAST:
                what = f"{name}(s) at s = {s!r} is {value!r}, quadrature gives {taken.value:.12g} +- {taken.error:.1e}"
                self._broken("clause 7", profile, what, mend + "; near 0, mind differences of nearly equal numbers")
