"""Run-time checks of the values that profiles of plugins return, and caches for results of equal profiles.

The built-in profiles are checked by the tests of the package.
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

from shockwave.base.errors import PluginError, ShockwaveError
from shockwave.base.numerics import FloatArray
from shockwave.registry.registry import owner_of

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: Allowed absolute rounding error of a value of rise or decay: more than carelessly written formulas need.
ROUNDING = 1e-9
# Results kept for each cached function: series of scenes often share a few shapes.
_MOST_KEPT = 256
# Folders whose frames are left out when the line of the plugin that failed is sought.
_LIBRARIES = tuple(str(Path(file).parent) + os.sep for file in (Path(__file__).parents[1], np.__file__, attrs.__file__))


class ViolationError(PluginError):
    """A violation of the contract of `ShockProfile` by ``profile``, at the scaled time ``s`` if that is known."""

    def __init__(self, profile: object, problem: str, s: float | None = None) -> None:
        at = "" if s is None else f" at s = {s:.6g}"
        super().__init__(f"profile {owner_of('profiles', type(profile))}: {problem}{at}")


def is_built_in(profile: object) -> bool:
    """Whether the class of ``profile`` is built in."""
    return type(profile).__module__.startswith("shockwave.")


def is_value(profile: object) -> bool:
    """Whether equal profiles give equal results: hash and equality take every parameter into account."""
    cls: Any = type(profile)
    if is_built_in(profile) or not attrs.has(cls):
        return is_built_in(profile)
    try:
        hash(profile)
    except TypeError:
        return False
    return cls.__eq__ is not object.__eq__ and all(field.eq or not field.init for field in attrs.fields(cls))


def memoize(function: _Function) -> _Function:
    """Cache the latest results of a function of a profile, for profiles with `is_value`."""
    keeping = lru_cache(maxsize=_MOST_KEPT)(function)

    @wraps(function)
    def call(profile: object, *rest: Any) -> Any:
        return keeping(profile, *rest) if is_value(profile) else function(profile, *rest)

    call.cache_clear = keeping.cache_clear  # type: ignore[attr-defined]
    return call  # type: ignore[return-value]


def guard(profile: object, name: str, s: FloatArray) -> FloatArray:
    """Values of the method ``name``, rise or decay, at ``s``: finite, from 0 to 1, of the shape of ``s``.

    Raises
    ------
    ViolationError
        If a value of a profile that is not built in violates this.
    """
    if is_built_in(profile):
        return np.asarray(getattr(profile, name)(s))
    values = array_of(profile, name, s)
    wrong = ~((values >= -ROUNDING) & (values <= 1 + ROUNDING))  # true for NaN
    if wrong.any():
        first = np.flatnonzero(wrong)[0]
        value = values.ravel()[first]
        rule = "at least 0 and at most 1" if np.isfinite(value) else "finite"
        raise ViolationError(profile, f"{name}(s) must be {rule} (got {value:.9g})", s.ravel()[first])
    return np.maximum(values, 0.0)


def array_of(profile: object, name: str, s: FloatArray) -> FloatArray:
    """Values of the method ``name`` at ``s``, as a float array of the shape of ``s``.

    Raises
    ------
    ViolationError
        If the method raises or returns anything else.
    """
    with enforce(profile, f"{name}(s) must accept an array of any shape without raising"):
        values = np.asarray(getattr(profile, name)(s.copy()))
    if values.shape != s.shape or values.dtype.kind not in "fiub":
        got = f"{values.dtype} of shape {values.shape} for s of shape {s.shape}"
        raise ViolationError(profile, f"{name}(s) must return floats of the shape of s (got {got})")
    return values.astype(float)


@contextmanager
def enforce(profile: object, rule: str) -> Iterator[None]:
    """Convert an exception of the profile's own code to a violation of ``rule`` that states the line of that code."""
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
