"""Clauses of the contract of `ShockProfile`, checked by the test kit and when a profile of a plugin is used."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from inspect import isfunction
from numbers import Real
from typing import Any

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import Declaration, text_of
from shockwave.profiles.quadrature import Integral
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.registry.plugin_check import ROUNDING, ViolationError, array_of, enforce, guard, is_built_in, memoize

# Largest relative difference between a closed form and the quadrature; a larger one is an error in the formula.
_MISPRINT = 1e-6
_QUADRATURE = "gauss-legendre"
_RATIO = Declaration("", "n", above=1)
_RECORDED = Declaration("", "newtons or seconds", above=0, optional=True)


@memoize
def examine(profile: ShockProfile) -> None:
    """Check the contract of a profile that is not built in, before it is used.

    Raises
    ------
    ViolationError
        If the profile violates the contract.
    """
    if not is_built_in(profile):
        for check in CLAUSES.values():
            check(profile)


@cache
def _shares() -> FloatArray:
    """Fractions of rise and decay at which values are checked: regular, irregular, and close to both ends."""
    golden = np.arange(1, 234) * ((5**0.5 - 1) / 2) % 1.0
    near = 10.0 ** np.arange(-12.0, -1.0)
    return np.unique(np.concatenate((np.linspace(0, 1, 17), golden, near, 1.0 - near)))


def _branches(profile: ShockProfile) -> tuple[tuple[str, FloatArray], ...]:
    """Names of rise and decay with the times s at which values are checked."""
    n = float(profile.duration_ratio)
    return ("rise", _shares()), ("decay", np.append(1.0 + _shares()[:-1] * (n - 1), n))


def _require(holds: object, profile: ShockProfile, problem: str, s: float | None = None) -> None:
    if not holds:
        raise ViolationError(profile, problem, s)


def _value(profile: ShockProfile, name: str) -> Any:
    with enforce(profile, f"{name} must be a property or a field that does not raise"):
        return getattr(profile, name)


# ---------------------------------------------------------------- clauses


def _check_methods(profile: ShockProfile) -> None:
    fields = getattr(profile, "__dict__", ())
    for name, member in vars(ShockProfile).items():
        if isfunction(member) and not name.startswith("_"):
            hidden = name in fields or not callable(getattr(type(profile), name))
            _require(not hidden, profile, f"{name} must be a method (got a field of this name; rename the field)")


def _check_duration_ratio(profile: ShockProfile) -> None:
    problem = _RATIO.problem(_value(profile, "duration_ratio"))
    _require(not problem, profile, f"duration_ratio {problem}")


def _check_points(profile: ShockProfile) -> None:
    n, points = float(profile.duration_ratio), _value(profile, "breakpoints")
    numbers = isinstance(points, tuple | list) and all(isinstance(point, Real) for point in points)
    good = numbers and 1 in points and [points[0], points[-1]] == [0, n] and bool((np.diff(points) > 0).all())
    rule = f"breakpoints must be numbers that ascend from 0 to n = {n:g} and contain 1"
    _require(good, profile, f"{rule} (got {text_of(points)})")


def _check_vectorised(profile: ShockProfile) -> None:
    for name, s in _branches(profile):
        row = array_of(profile, name, s)
        few = np.arange(6) * (s.size // 6)
        for places in (np.arange(s.size), few.reshape(2, 3), few[:1], few[4], few[:0]):
            values = array_of(profile, name, np.asarray(s[places]))
            same = np.allclose(values, row[places], rtol=0, atol=ROUNDING, equal_nan=True)
            _require(same, profile, f"{name}(s) must depend on s only, not on the rest of the array")


def _check_values(profile: ShockProfile) -> None:
    for name, s in _branches(profile):
        values = guard(profile, name, s)
        peak = values[-1 if name == "rise" else 0]
        _require(abs(peak - 1) <= ROUNDING, profile, f"{name}(1) must be 1, the peak (got {peak:.9g})", 1.0)


def check_closed_integrals(
    profile: ShockProfile, error: float = _MISPRINT, shares: Sequence[float] = (0.3, 1.0)
) -> None:
    """Raise a `ViolationError` if a closed form differs from the quadrature by more than ``error``, relatively.

    The integrals are compared at the fractions ``shares`` of rise and decay.
    """
    exact = profile.areas(_QUADRATURE)
    with enforce(profile, "closed_areas() must return a1 and a2 without raising"):
        areas = profile.areas()
    for name, area, right in (("rise", areas.rise, exact.rise), ("decay", areas.decay, exact.decay)):
        _require_near(profile, f"closed_areas(): area under the {name}", area.value, right, error * right.value)
    s = np.array([*shares, *(1.0 + (profile.duration_ratio - 1) * share for share in shares)])
    with enforce(profile, "closed_free_path() must return a FreePath without raising"):
        table = profile.closed_free_path()
        if table is not None:
            table.check()
        columns = () if table is None else np.transpose([table.at(end) for end in s.tolist()])
    with enforce(profile, "closed_running_impulse(s) must accept an array of any shape without raising"):
        impulses = np.append(profile.running_impulse(s[:-1]), profile.running_impulse(s[-1]))
    for end, impulse in zip(s.tolist(), impulses.tolist(), strict=True):
        right = profile.integral(0.0, end, _QUADRATURE)
        # The decay involves differences of integrals over the whole pulse; near 0 no digits need be lost.
        allowed = error * (right.value if end <= 1 else areas.total)
        _require_near(profile, "closed_running_impulse(s)", impulse, right, allowed, end)
    for name, column in zip(("displacement", "impulse"), columns, strict=False):
        integrals = [profile.integral(0.0, end, _QUADRATURE, name == "displacement") for end in s.tolist()]
        for end, value, right in zip(s.tolist(), column, integrals, strict=True):
            _require_near(profile, f"closed_free_path(): {name}", value, right, error * integrals[-1].value, end)


def _require_near(
    profile: ShockProfile, name: str, value: float, right: Integral, allowed: float, s: float | None = None
) -> None:
    near = abs(value - right.value) <= allowed + right.error
    _require(near, profile, f"{name} must be {right.value:.12g}, the value by quadrature (got {float(value)!r})", s)


def _check_records(profile: ShockProfile) -> None:
    for name in ("recorded_peak_force", "recorded_rise_time"):
        problem = _RECORDED.problem(_value(profile, name))
        _require(not problem, profile, f"{name} {problem}")


def _check_notes(profile: ShockProfile) -> None:
    notes = _value(profile, "notes")
    good = isinstance(notes, tuple) and all(isinstance(note, str) for note in notes)
    _require(good, profile, f"notes must be a tuple of sentences (got {text_of(notes)})")


#: Checks in the order in which they run when a profile is first used; each may rely on the preceding ones.
CLAUSES: dict[str, Callable[[ShockProfile], None]] = {
    "clause 2, methods": _check_methods,
    "clause 1, duration ratio": _check_duration_ratio,
    "clause 4, breakpoints": _check_points,
    "clause 2, vectorised": _check_vectorised,
    "clause 3, values": _check_values,
    "clause 5, closed forms": check_closed_integrals,
    "clause 6, recorded values": _check_records,
    "clause 7, notes": _check_notes,
}
