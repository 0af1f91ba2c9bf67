"""Guard: what a profile of someone else's returns is checked where it enters.

The profiles of shockwave are checked by its tests; those of plugins and scripts are checked here, as they are used. A
violation of the contract of `ShockProfile` is a `PluginError` that names the profile, the time and the value.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any

import numpy as np

from shockwave.errors import PluginError, ShockwaveError
from shockwave.fields import text_of
from shockwave.quadrature import FloatArray
from shockwave.registry import owner_of

if TYPE_CHECKING:
    from shockwave.profiles.base import ShockProfile

__all__ = ["examine", "guarded", "is_value", "trusted"]

#: How far a value may be off a bound, or its like: what rounding does to formulas written without much care.
_ROUNDING = 1e-9
_SAMPLES = 65
#: A closed area that is further than this from what a quadrature finds is another one's.
_AREA_ERROR = 1e-6
_FINAL = ("force", "areas", "running_impulse", "double_integral", "free_path")
_MOST_KNOWN = 256
_known: OrderedDict[Hashable, None] = OrderedDict()


class _ViolationError(PluginError):
    """A value that breaks the contract, at the time ``s``."""

    def __init__(self, problem: str, s: float) -> None:
        super().__init__(problem)
        self.s = s


def trusted(profile: ShockProfile) -> bool:
    """Whether its class is shockwave's own."""
    return type(profile).__module__.startswith("shockwave.")


def guarded(profile: ShockProfile, name: str, s: FloatArray) -> FloatArray:
    """``profile.rise`` or ``.decay`` at ``s``: finite, from 0 to 1, of the shape of ``s``.

    Raises
    ------
    PluginError
        When they are not, and the profile is not shockwave's own.
    """
    if trusted(profile):
        values: FloatArray = getattr(profile, name)(s)
        return values
    values = _array(profile, name, s)
    wrong = ~((values >= -_ROUNDING) & (values <= 1 + _ROUNDING))  # NaN is wrong too
    if wrong.any():
        first = np.flatnonzero(wrong)[0]
        value = values.ravel()[first]
        rule = "at least 0 and at most 1" if np.isfinite(value) else "finite"
        raise _violation(profile, f"{name}(s) must be {rule}", value, np.ravel(s)[first])
    return np.maximum(values, 0.0)


def _array(profile: ShockProfile, name: str, s: FloatArray) -> FloatArray:
    """What the method ``name`` gives for ``s``, as an array of the shape of ``s``."""
    given = s.copy()
    returned = _called(profile, f"{name}(s)", lambda: getattr(profile, name)(given))
    values = np.asarray(returned)
    if values.shape != s.shape or values.dtype.kind not in "fiub":
        got = f"{values.dtype} of shape {values.shape} for s of shape {s.shape}"
        raise _fault(profile, f"{name}(s) must return floats of the shape of s (got {got})")
    if not np.array_equal(given, s):
        raise _fault(profile, f"{name}(s) must leave s as it is (it was changed in place)")
    return values.astype(float)


def _called(profile: ShockProfile, what: str, call: Callable[[], Any]) -> Any:
    try:
        return call()
    except ShockwaveError:
        raise
    except Exception as error:
        got = f"{type(error).__name__}: {text_of(str(error), 200)}"
        raise _fault(profile, f"{what} must take an array of any shape, and not raise (got {got})") from error


def examine(profile: ShockProfile, rise_time: float) -> None:
    """Check the contract of a profile that is not shockwave's own, before it is used.

    Parameters
    ----------
    profile : ShockProfile
        One that is equal to one examined before is not examined again.
    rise_time : float
        t0 [s], to tell times in seconds.

    Raises
    ------
    PluginError
        When it breaks the contract.
    """
    if trusted(profile):
        return
    if is_value(profile) and profile in _known:
        return
    try:
        _examine(profile)
    except _ViolationError as error:
        raise PluginError(f"{error}, t = {error.s * rise_time:.6g} s") from error
    if is_value(profile):
        _known[profile] = None
        while len(_known) > _MOST_KNOWN:
            _known.popitem(last=False)


def is_value(profile: ShockProfile) -> bool:
    """Whether it has a hash and an equality that work, so that what is known of it can be kept."""
    try:
        return bool(profile == profile) and isinstance(hash(profile), int)
    except Exception:  # of its own making
        return False


def _examine(profile: ShockProfile) -> None:
    for name in _FINAL:
        home = next(base for base in type(profile).__mro__ if name in vars(base))
        if not home.__module__.startswith("shockwave."):
            raise _fault(profile, f"{name} must be left to ShockProfile (it is written anew)")
    _check_points(profile)
    _check_values(profile)
    _check_closed(profile)


def _check_points(profile: ShockProfile) -> None:
    n = _called(profile, "duration_ratio", lambda: float(profile.duration_ratio))
    if not 1 < n < float("inf"):
        raise _fault(profile, f"duration_ratio must be finite and > 1 (got {profile.duration_ratio!r})")
    points = _called(profile, "breakpoints", lambda: [float(point) for point in profile.breakpoints])
    if len(points) < 3 or points[0] != 0 or points[-1] != n or 1.0 not in points or (np.diff(points) <= 0).any():
        rule = f"must ascend from 0 to n = {n:g} and contain 1"
        raise _fault(profile, f"breakpoints {rule} (got {text_of(tuple(points))})")
    singular = _called(profile, "singular_points", lambda: [float(point) for point in profile.singular_points])
    if not set(singular) <= set(points):
        raise _fault(profile, f"singular_points must be among the breakpoints (got {text_of(tuple(singular))})")
    for name in ("recorded_peak_force", "recorded_rise_time"):
        value = _called(profile, name, lambda name=name: getattr(profile, name))  # type: ignore[misc]
        if value is not None and not (isinstance(value, float | int) and 0 < value < float("inf")):
            raise _fault(profile, f"{name} must be None, or finite and > 0 (got {value!r})")
    notes = _called(profile, "notes", lambda: tuple(profile.notes))
    if isinstance(profile.notes, str) or not all(isinstance(note, str) for note in notes):
        raise _fault(profile, f"notes must be a tuple of sentences (got {text_of(profile.notes)})")


def _check_values(profile: ShockProfile) -> None:
    n = float(profile.duration_ratio)
    for name, begin, end in (("rise", 0.0, 1.0), ("decay", 1.0, n)):
        s = np.linspace(begin, end, _SAMPLES)
        values = guarded(profile, name, s)
        again = guarded(profile, name, s)
        if not np.array_equal(values, again):
            index = int(np.flatnonzero(values != again)[0])
            rule = f"{name}(s) must give the same value for the same s, {values[index]:.9g} as before"
            raise _violation(profile, rule, again[index], s[index])
        _check_shapes(profile, name, s, values)
        peak = values[-1 if name == "rise" else 0]
        if abs(peak - 1) > _ROUNDING:
            raise _violation(profile, f"{name}(1) must be 1, the peak", peak, 1.0)


def _check_shapes(profile: ShockProfile, name: str, s: FloatArray, values: FloatArray) -> None:
    """Whether a value depends on s alone, not on what else is in the array."""
    guarded(profile, name, s[:0])
    square = guarded(profile, name, s[:-1].reshape(8, -1)).ravel()
    middle = _SAMPLES // 2
    alone = np.append(square, guarded(profile, name, s[middle, None]))
    off = np.abs(alone - np.append(values[:-1], values[middle]))
    if (off > _ROUNDING).any():
        index = int(np.argmax(off))
        rule = f"{name}(s) must depend on s alone, not on the array that it stands in"
        raise _violation(profile, rule, alone[index], s[min(index, middle) if index == len(square) else index])


def _check_closed(profile: ShockProfile) -> None:
    given = _called(profile, "closed_areas()", profile.closed_areas)
    if given is not None:
        closed = _called(profile, "closed_areas()", lambda: [float(area) for area in given])
        if len(closed) != 2:
            raise _fault(profile, f"closed_areas() must return a1 and a2 (got {text_of(given)})")
        areas = profile.areas("gauss-legendre")
        for name, value, area in zip(("rise", "decay"), closed, (areas.rise, areas.decay), strict=True):
            if not abs(value - area.value) <= _AREA_ERROR * area.value + area.error:
                rule = f"closed_areas() must give the area under the {name}, {area.value:.9g} by quadrature"
                raise _fault(profile, f"{rule} (got {value!r})")
    s = np.linspace(0.0, float(profile.duration_ratio), _SAMPLES)
    for name in ("closed_running_impulse", "closed_double_integral"):
        if _called(profile, f"{name}(s)", lambda name=name: getattr(profile, name)(s)) is None:  # type: ignore[misc]
            continue
        values = _array(profile, name, s)
        if not np.isfinite(values).all():
            index = int(np.flatnonzero(~np.isfinite(values))[0])
            raise _violation(profile, f"{name}(s) must be finite", values[index], s[index])


def _fault(profile: ShockProfile, problem: str) -> PluginError:
    return PluginError(f"profile {owner_of('profiles', type(profile))}: {problem}")


def _violation(profile: ShockProfile, rule: str, value: float, s: float) -> _ViolationError:
    return _ViolationError(f"{_fault(profile, rule)} (got {float(value):.9g}) at s = {float(s):.6g}", float(s))
