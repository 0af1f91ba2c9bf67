"""Guard: what a profile of someone else's returns is checked where it enters.

The profiles of shockwave are checked by its tests; those of plugins and scripts are checked here, as they are used. A
violation of the contract of `ShockProfile` is a `PluginError` that names the profile, the time and the value.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from shockwave.errors import PluginError, ShockwaveError
from shockwave.fields import text_of
from shockwave.quadrature import FloatArray
from shockwave.registry import owner_of

if TYPE_CHECKING:
    from shockwave.profiles.base import ShockProfile

__all__ = ["ViolationError", "examine", "guarded", "is_value", "trusted"]

#: How far a value may be off a bound, or its like: what rounding does to formulas written without much care.
_ROUNDING = 1e-9
_SAMPLES = 233
#: A closed integral that is further than this from what a quadrature finds, relatively, is another one's.
_CLOSED_ERROR = 1e-6
_FINAL = ("force", "areas", "running_impulse", "double_integral", "free_path")
_MOST_KNOWN = 256
_known: OrderedDict[Hashable, None] = OrderedDict()


class ViolationError(PluginError):
    """A value that breaks the contract, at the time ``s``."""

    def __init__(self, problem: str, s: float) -> None:
        super().__init__(problem)
        self.s = s


def trusted(profile: ShockProfile) -> bool:
    """Whether its class is shockwave's own."""
    return trusted_class(type(profile))


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
    except (Exception, SystemExit) as error:
        if isinstance(error, TypeError) and "'method' object" in str(error):
            rule = "must be a property or a field"
        else:
            rule = "must take an array of any shape, and not raise" if what.endswith("(s)") else "must not raise"
        raise _fault(profile, f"{what} {rule} (got {type(error).__name__}: {_text(error)})") from error


def _text(error: BaseException) -> str:
    try:
        return text_of(str(error), 200)
    except Exception:
        return "with a text that cannot be made"


def examine(profile: ShockProfile) -> None:
    """Check the contract of a profile that is not shockwave's own, before it is used.

    One that is equal to one examined before is not examined again.

    Raises
    ------
    PluginError
        When it breaks the contract; a `ViolationError` when that is at a time.
    """
    if trusted(profile) or (is_value(profile) and profile in _known):
        return
    for name in _FINAL:
        home = next(base for base in type(profile).__mro__ if name in vars(base))
        if not home.__module__.startswith("shockwave."):
            raise _fault(profile, f"{name} must be left to ShockProfile (it is written anew)")
    _check_points(profile)
    _check_values(profile)
    _check_closed(profile)
    if is_value(profile):
        _known[profile] = None
        while len(_known) > _MOST_KNOWN:
            _known.popitem(last=False)


def is_value(profile: ShockProfile) -> bool:
    """Whether nothing of it can change and all of it counts for equality, so that what is known of it can be kept."""
    if not _of_values(type(profile)):
        return False
    try:
        return isinstance(hash(profile), int)
    except Exception:  # of a field that is a list, or that its constructor has left out
        return False


@cache
def _of_values(cls: type) -> bool:
    """Whether instances are frozen by attrs, with an equality made by attrs from every field."""
    frozen = getattr(cls.__setattr__, "__module__", "").startswith("attr") or trusted_class(cls)
    code = getattr(cls.__eq__, "__code__", None)
    made = code is not None and code.co_filename.startswith("<attrs generated")
    fields = attrs.fields(cls) if attrs.has(cls) else ()
    whole = all((field.eq and field.hash is not False) or not field.init for field in fields)
    return frozen and whole and (made or trusted_class(cls))


def trusted_class(cls: type) -> bool:
    """Whether it is shockwave's own."""
    return cls.__module__.startswith("shockwave.")


def _check_points(profile: ShockProfile) -> None:
    n = _called(profile, "duration_ratio", lambda: profile.duration_ratio)
    if not (_is_number(n) and 1 < n < float("inf")):
        raise _fault(profile, f"duration_ratio must be a finite number > 1 (got {text_of(n)})")
    points = _numbers(profile, "breakpoints")
    if len(points) < 3 or points[0] != 0 or points[-1] != n or 1.0 not in points or not (np.diff(points) > 0).all():
        rule = f"must ascend from 0 to n = {n:g} and contain 1"
        raise _fault(profile, f"breakpoints {rule} (got {text_of(points)})")
    singular = _numbers(profile, "singular_points")
    if not set(singular) <= set(points):
        raise _fault(profile, f"singular_points must be among the breakpoints (got {text_of(singular)})")
    for name in ("recorded_peak_force", "recorded_rise_time"):
        value = _called(profile, name, partial(getattr, profile, name))
        if value is not None and not (_is_number(value) and 0 < value < float("inf")):
            raise _fault(profile, f"{name} must be None, or finite and > 0 (got {text_of(value)})")
    notes = _called(profile, "notes", lambda: profile.notes)
    if not isinstance(notes, tuple) or not all(isinstance(note, str) for note in notes):
        raise _fault(profile, f"notes must be a tuple of sentences (got {text_of(notes)})")


def _is_number(value: object) -> bool:
    return isinstance(value, float | int | np.floating | np.integer) and not isinstance(value, bool)


def _numbers(profile: ShockProfile, name: str) -> tuple[float, ...]:
    found = _called(profile, name, partial(getattr, profile, name))
    if not isinstance(found, tuple | list) or not all(map(_is_number, found)):
        raise _fault(profile, f"{name} must be a tuple of numbers (got {text_of(found)})")
    return tuple(float(point) for point in found)


def _check_values(profile: ShockProfile) -> None:
    n = float(profile.duration_ratio)
    for name, begin, end in (("rise", 0.0, 1.0), ("decay", 1.0, n)):
        s = np.sort(np.append(_shares() * (end - begin), [0.0, end - begin])) + begin
        s[-1] = end
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


@cache
def _shares() -> FloatArray:
    """Where rise and decay are looked at: irregular, so that nothing regular hides, and close to both ends."""
    spread = np.arange(1, _SAMPLES + 1) * ((5**0.5 - 1) / 2) % 1.0
    near = 10.0 ** np.arange(-12.0, -1.0)
    return np.concatenate((spread, near, 1.0 - near))


def _check_shapes(profile: ShockProfile, name: str, s: FloatArray, values: FloatArray) -> None:
    """Whether a value depends on s alone, not on what else is in the array."""
    guarded(profile, name, s[:0])
    few, middle = np.arange(0, s.size - 1, s.size // 8)[:8], s.size // 2
    square = guarded(profile, name, s[few].reshape(2, -1)).ravel()
    places = np.append(few, middle)
    alone = np.append(square, guarded(profile, name, s[middle, None]))
    off = np.abs(alone - values[places])
    if (off > _ROUNDING).any():
        index = int(np.argmax(off))
        rule = f"{name}(s) must depend on s alone, not on the array that it stands in"
        raise _violation(profile, rule, alone[index], s[places[index]])


def _check_closed(profile: ShockProfile) -> None:
    """Whether integrals in closed form are those of the force, by quadrature, to what a misprint is larger than."""
    n = float(profile.duration_ratio)
    given = _called(profile, "closed_areas()", profile.closed_areas)
    if given is not None:
        closed = _called(profile, "closed_areas()", lambda: [float(area) for area in given])
        if len(closed) != 2 or isinstance(given, str):
            raise _fault(profile, f"closed_areas() must return a1 and a2 (got {text_of(given)})")
        areas = profile.areas("gauss-legendre")
        for name, value, area in zip(("rise", "decay"), closed, (areas.rise, areas.decay), strict=True):
            if not abs(value - area.value) <= _CLOSED_ERROR * area.value + area.error:
                rule = f"closed_areas() must give the area under the {name}, {area.value:.9g} by quadrature"
                raise _fault(profile, f"{rule} (got {value!r})")
    s = np.array([0.0, 0.3, 0.9, 1.0, 1.0 + 0.1 * (n - 1), 1.0 + 0.6 * (n - 1), n])
    for name, right in (("running_impulse", profile.running_impulse), ("double_integral", profile.double_integral)):
        method = f"closed_{name}"
        if _called(profile, f"{method}(s)", lambda method=method: getattr(profile, method)(s)) is not None:  # type: ignore[misc]
            _check_integral(profile, f"{method}(s)", s, _array(profile, method, s), right)
    path = _called(profile, "closed_free_path()", profile.closed_free_path)
    if path is not None:
        if type(path).__name__ != "FreePath" or not trusted_class(type(path)):
            raise _fault(profile, f"closed_free_path() must return a FreePath (got {text_of(path)})")
        at = _called(profile, "closed_free_path()", lambda: np.array([path.at(float(one)) for one in s]))
        _check_integral(profile, "path of closed_free_path()", s, at[:, 0], profile.double_integral)
        _check_integral(profile, "impulse of closed_free_path()", s, at[:, 1], profile.running_impulse)


def _check_integral(
    profile: ShockProfile, what: str, s: FloatArray, values: FloatArray, right: Callable[..., FloatArray]
) -> None:
    known = right(s, "gauss-legendre")
    off = ~(np.abs(values - known) <= _CLOSED_ERROR * (known + known[-1] * (s > 1)) + _ROUNDING * known[-1])
    if off.any():
        index = int(np.flatnonzero(off)[0])
        raise _violation(profile, f"{what} must be {known[index]:.9g}, by quadrature", values[index], s[index])


def _fault(profile: ShockProfile, problem: str) -> PluginError:
    return PluginError(f"profile {owner_of('profiles', type(profile))}: {problem}")


def _violation(profile: ShockProfile, rule: str, value: float, s: float) -> ViolationError:
    return ViolationError(f"{_fault(profile, rule)} (got {float(value):.9g}) at s = {float(s):.6g}", float(s))
