"""The contract of `ShockProfile` as a list of clauses, checked when a plugin's profile is used and by the test kit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from numbers import Real
from typing import Any

import attrs
import numpy as np
from attrs import frozen

from shockwave.fields import text_of
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import ROUNDING, ViolationError, array_of, blamed, checked, kept, trusted
from shockwave.quadrature import FloatArray, Integral

#: A closed integral that is further than this from the quadrature, relatively, is not that of the force.
_MISPRINT = 1e-6
# Earlier a table of impulse and path has no digits of its own to lose.
_SMALL = 0.1
_FINAL = ("force", "areas", "running_impulse", "double_integral", "free_path")
_ATTRS_FIELD = type(attrs.field())


@frozen
class Clause:
    """One clause of the contract of `ShockProfile`, by its number there; 0 is what holds beside the numbered ones.

    ``check`` raises a `ViolationError` for a profile that breaks it; ``remedy`` is how to mend the profile.
    """

    number: int
    name: str
    check: Callable[[ShockProfile], None]
    remedy: str

    def problem(self, profile: ShockProfile) -> str:
        """How the profile breaks the clause; empty if it does not."""
        try:
            self.check(profile)
        except ViolationError as error:
            return error.problem
        return ""

    def __str__(self) -> str:
        return f"clause {self.number}, {self.name}" if self.number else self.name


def examine(profile: ShockProfile) -> None:
    """Check the contract of a profile that is not shockwave's own, before it is used.

    Raises
    ------
    ViolationError
        When it breaks the contract.
    """
    if not trusted(profile):
        _examined(profile)


@kept
def _examined(profile: ShockProfile) -> None:
    for clause in CLAUSES:
        clause.check(profile)


@cache
def _shares() -> FloatArray:
    """Shares of rise and decay at which they are looked at: regular, irregular, and close to both ends."""
    golden = np.arange(1, 234) * ((5**0.5 - 1) / 2) % 1.0
    near = 10.0 ** np.arange(-12.0, -1.0)
    return np.unique(np.concatenate((np.linspace(0, 1, 17), golden, near, 1.0 - near)))


def _branches(profile: ShockProfile) -> tuple[tuple[str, FloatArray], ...]:
    """Rise and decay with the times at which they are looked at."""
    n = float(profile.duration_ratio)
    return ("rise", _shares()), ("decay", np.append(1.0 + _shares()[:-1] * (n - 1), n))


def _require(holds: object, profile: ShockProfile, problem: str, s: float | None = None) -> None:
    if not holds:
        raise ViolationError(profile, problem, s)


def _value(profile: ShockProfile, name: str) -> Any:
    with blamed(profile, f"{name} must be a property or a field, and not raise"):
        return getattr(profile, name)


def _numbers(profile: ShockProfile, name: str) -> Sequence[float]:
    found: Sequence[float] = _value(profile, name)
    good = isinstance(found, tuple | list) and all(isinstance(point, Real) for point in found)
    _require(good, profile, f"{name} must be a tuple of numbers (got {text_of(found)})")
    return found


def _is_positive(value: object, least: float = 0.0) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and least < float(value) < float("inf")


# ---------------------------------------------------------------- the clauses


def _check_class(profile: ShockProfile) -> None:
    cls = type(profile)
    loose = [name for base in cls.__mro__ for name, value in vars(base).items() if isinstance(value, _ATTRS_FIELD)]
    _require(not loose, profile, f"@attrs.frozen must stand before the class, for it declares the fields {loose}")
    for name in _FINAL:
        own = getattr(cls, name) is not getattr(ShockProfile, name)
        _require(not own, profile, f"{name} must be left to ShockProfile (it is written anew)")


def _check_duration_ratio(profile: ShockProfile) -> None:
    n = _value(profile, "duration_ratio")
    _require(_is_positive(n, 1.0), profile, f"duration_ratio must be a finite number > 1 (got {text_of(n)})")


def _check_points(profile: ShockProfile) -> None:
    n, points = float(profile.duration_ratio), _numbers(profile, "breakpoints")
    good = len(points) > 2 and points[0] == 0 and points[-1] == n and 1 in points and bool((np.diff(points) > 0).all())
    rule = f"breakpoints must ascend from 0 to n = {n:g} and contain 1"
    _require(good, profile, f"{rule} (got {text_of(points)})")


def _check_singular_points(profile: ShockProfile) -> None:
    points, singular = profile.breakpoints, _numbers(profile, "singular_points")
    among = set(singular) <= set(points)
    _require(among, profile, f"singular_points must be among the breakpoints (got {text_of(singular)})")


def _check_shapes(profile: ShockProfile) -> None:
    for name, s in _branches(profile):
        row = array_of(profile, name, s)
        array_of(profile, name, s[:0])
        few = np.arange(6) * (s.size // 6)
        for places in (few.reshape(2, 3), few[:1], few[4]):
            off = np.abs(array_of(profile, name, np.asarray(s[places])) - row[places])
            rule = f"{name}(s) must depend on s alone, not on the array that it stands in"
            _require(not (off > ROUNDING).any(), profile, rule, np.ravel(s[places])[off.argmax()])


def _check_purity(profile: ShockProfile) -> None:
    for name, s in _branches(profile):
        values, again = (array_of(profile, name, s) for _ in range(2))
        same = np.array_equal(values, again, equal_nan=True)
        at = s[np.argmax(values != again)]
        _require(same, profile, f"{name}(s) must give the same value for the same s (got another)", at)


def _check_values(profile: ShockProfile) -> None:
    for name, s in _branches(profile):
        values = checked(profile, name, s)
        peak = values[-1 if name == "rise" else 0]
        _require(abs(peak - 1) <= ROUNDING, profile, f"{name}(1) must be 1, the peak (got {peak:.9g})", 1.0)


def check_closed_integrals(
    profile: ShockProfile, error: float = _MISPRINT, shares: Sequence[float] = (0.3, 1.0)
) -> None:
    """Raise a `ViolationError` where a closed form is further than ``error``, relatively, from the quadrature.

    ``shares`` are those of rise and decay up to which the integrals are compared.
    """
    with blamed(profile, "closed_areas() must return a1 and a2, and not raise"):
        closed = profile.closed_areas()
        areas = profile.areas("gauss-legendre")
        pairs = [] if closed is None else list(zip(closed, (areas.rise, areas.decay), strict=True))
        for name, (value, area) in zip(("rise", "decay"), pairs, strict=False):
            rule = f"closed_areas() must give the area under the {name}, {area.value:.12g} by quadrature"
            _require(_is_near(value, area, error * area.value), profile, f"{rule} (got {value!r})")
    s = np.array([*shares, *(1.0 + (profile.duration_ratio - 1) * share for share in shares)])
    for method, moment in (("closed_running_impulse", False), ("closed_double_integral", True)):
        with blamed(profile, f"{method}(s) must take an array of any shape, and not raise"):
            absent = getattr(profile, method)(s.copy()) is None
        if not absent:
            array_of(profile, method, s[:0])
            array_of(profile, method, np.asarray(s[0]))
            _check_integral(profile, f"{method}(s)", moment, s, array_of(profile, method, s), error)
    late = s[s >= _SMALL]
    with blamed(profile, "closed_free_path() must return a FreePath, and not raise"):
        table = profile.closed_free_path()
        columns = () if table is None else np.transpose([table.at(end) for end in late.tolist()])
    for column, moment, what in zip(columns, (True, False), ("path", "impulse"), strict=False):
        _check_integral(profile, f"{what} of closed_free_path()", moment, late, column, error)


def _check_integral(
    profile: ShockProfile, what: str, moment: bool, s: FloatArray, values: FloatArray, error: float
) -> None:
    known = [profile.integral_to(end, "gauss-legendre", moment) for end in s.tolist()]
    for end, value, right in zip(s.tolist(), values.tolist(), known, strict=True):
        # Near 0 no digit need be lost; in the decay, and in a table, what is added up is as great as the whole.
        scale = right.value if end <= 1 and what.startswith("closed") else known[-1].value
        rule = f"{what} must be {right.value:.12g}, by quadrature (got {value!r})"
        _require(_is_near(value, right, error * scale), profile, rule, end)


def _is_near(value: float, right: Integral, allowed: float) -> bool:
    return abs(value - right.value) <= allowed + right.error


def _check_records(profile: ShockProfile) -> None:
    for name in ("recorded_peak_force", "recorded_rise_time"):
        value = _value(profile, name)
        good = value is None or _is_positive(value)
        _require(good, profile, f"{name} must be None, or finite and > 0 (got {text_of(value)})")


def _check_notes(profile: ShockProfile) -> None:
    notes = _value(profile, "notes")
    good = isinstance(notes, tuple) and all(isinstance(note, str) and note.strip() for note in notes)
    _require(good, profile, f"notes must be a tuple of sentences (got {text_of(notes)})")


#: Every clause that is checked when a profile is first used; each may rely on those before it.
CLAUSES = (
    Clause(0, "class", _check_class, "write rise, decay and closed forms alone; decorate a class that has fields"),
    Clause(1, "duration ratio", _check_duration_ratio, "return the whole duration over the rise time"),
    Clause(5, "breakpoints", _check_points, "return floats (0.0, ..., 1.0, ..., self.duration_ratio) that ascend"),
    Clause(6, "singular points", _check_singular_points, "return those breakpoints at which the slope is unbounded"),
    Clause(
        2,
        "shapes",
        _check_shapes,
        "s is an array: compute element by element with numpy functions alone, numpy.sin in place of math.sin,"
        " numpy.where(s < 1, one, other) in place of if s < 1, and 0 * s + 1 for a constant",
    ),
    Clause(4, "purity", _check_purity, "compute from s and the fields alone: no counters, no random numbers"),
    Clause(3, "values", _check_values, "divide the force by its peak; take numpy.maximum(..., 0.0) against rounding"),
    Clause(7, "closed forms", check_closed_integrals, "check the formula; return None to have it by quadrature"),
    Clause(8, "recorded values", _check_records, "return newtons or seconds, or None where nothing was measured"),
    Clause(9, "notes", _check_notes, 'return a tuple of texts, ("the baseline was taken off",), or ()'),
)
