"""Guard of plugin profiles: the values of rise and decay are checked where they enter, and results kept if they may be.

The profiles of shockwave are checked by its tests; those of plugins and scripts are checked here, as they are used.
"""

from __future__ import annotations

import os
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any, TypeVar

import attrs
import numpy as np

from shockwave.errors import PluginError, ShockwaveError
from shockwave.quadrature import FloatArray
from shockwave.registry import owner_of

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: How far a value may be off a bound, or from its like: what rounding does to formulas written without much care.
ROUNDING = 1e-9
# Scenes of one shape come in series.
_MOST_KEPT = 256
_LIBRARIES = tuple(str(Path(file).parent) + os.sep for file in (Path(__file__).parent, np.__file__, attrs.__file__))


class ViolationError(PluginError):
    """A violation of the contract of `ShockProfile` by ``profile``, at the time ``s`` if it has one."""

    def __init__(self, profile: object, problem: str, s: float | None = None) -> None:
        at = "" if s is None else f" at s = {s:.6g}"
        self.problem, self.s = problem + at, s
        super().__init__(f"profile {owner_of('profiles', type(profile))}: {self.problem}")


def trusted(profile: object) -> bool:
    """Whether its class is shockwave's own."""
    return type(profile).__module__.startswith("shockwave.")


def is_value(profile: object) -> bool:
    """Whether equal profiles give equal results: with hash and equality that leave out no parameter."""
    if trusted(profile):
        return True
    cls: Any = type(profile)
    try:
        hash(profile)
    except TypeError:
        return False
    fields = attrs.fields(cls) if attrs.has(cls) else ()
    return cls.__eq__ is not object.__eq__ and all(field.eq or not field.init for field in fields)


def kept(function: _Function) -> _Function:
    """A function whose first argument is a profile, with its last results kept for profiles that are values."""
    keeping = lru_cache(maxsize=_MOST_KEPT)(function)

    @wraps(function)
    def called(profile: object, *rest: Any) -> Any:
        return keeping(profile, *rest) if is_value(profile) else function(profile, *rest)

    called.cache_clear = keeping.cache_clear  # type: ignore[attr-defined]
    return called  # type: ignore[return-value]


def guarded(profile: object, name: str, s: FloatArray) -> FloatArray:
    """``profile.rise`` or ``.decay`` at ``s``: finite, from 0 to 1, of the shape of ``s``.

    Raises
    ------
    ViolationError
        When they are not, and the profile is not shockwave's own.
    """
    if trusted(profile):
        values: FloatArray = getattr(profile, name)(s)
        return values
    return checked(profile, name, s)


def checked(profile: object, name: str, s: FloatArray) -> FloatArray:
    """As `guarded`, for whosever profile."""
    values = array_of(profile, name, s)
    wrong = ~((values >= -ROUNDING) & (values <= 1 + ROUNDING))  # NaN is wrong too
    if wrong.any():
        first = np.flatnonzero(wrong)[0]
        value = values.ravel()[first]
        rule = "at least 0 and at most 1" if np.isfinite(value) else "finite"
        raise ViolationError(profile, f"{name}(s) must be {rule} (got {value:.9g})", s.ravel()[first])
    return np.maximum(values, 0.0)


def array_of(profile: object, name: str, s: FloatArray) -> FloatArray:
    """What the method ``name`` gives for ``s``, as an array of the shape of ``s``.

    Raises
    ------
    ViolationError
        When it raises, returns something else, or changes ``s``.
    """
    given = s.copy()
    with blamed(profile, f"{name}(s) must take an array of any shape, and not raise"):
        values = np.asarray(getattr(profile, name)(given))
    if values.shape != s.shape or values.dtype.kind not in "fiub":
        got = f"{values.dtype} of shape {values.shape} for s of shape {s.shape}"
        raise ViolationError(profile, f"{name}(s) must return floats of the shape of s (got {got})")
    if not np.array_equal(given, s):
        raise ViolationError(profile, f"{name}(s) must leave s as it is (it was changed in place)")
    return values.astype(float)


@contextmanager
def blamed(profile: object, rule: str) -> Iterator[None]:
    """Whatever the profile's own code raises breaks ``rule``; the error shows the line of that code."""
    try:
        yield
    except ShockwaveError:
        raise
    except (Exception, SystemExit) as error:
        got = f"got {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        frames = traceback.extract_tb(error.__traceback__)
        own = [frame for frame in frames if not frame.filename.startswith(_LIBRARIES)]
        at = f" in {Path(own[-1].filename).name}, line {own[-1].lineno}: {own[-1].line}" if own else ""
        raise ViolationError(profile, f"{rule} ({got}{at})") from error
