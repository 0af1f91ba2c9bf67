"""What lies behind an error, in the words of its author's code: the line that raised it, a decorator forgotten."""

from __future__ import annotations

import inspect
import os
import sysconfig
import traceback
from pathlib import Path

import attrs
import numpy as np

import shockwave
from shockwave.profiles.base import ShockProfile

__all__ = ["loose_field", "remedy", "told"]

_FOLDERS = tuple(str(Path(inspect.getfile(thing)).parent) + os.sep for thing in (shockwave, np, attrs.field))
_LIBRARY, _INSTALLED = sysconfig.get_paths()["stdlib"], ("site-packages", "dist-packages")
# What attrs puts in a class for each field, until its decorator takes it out.
_FIELD = type(attrs.field())

# What is raised by code that is written for one number, and by what to replace it.
_REMEDIES = {
    "truth value of a": "s is an array: write  numpy.where(s < 1, one, other)  in place of  if s < 1",
    "to Python scalars": "s is an array: take numpy.sin, numpy.exp, ... in place of those of math, and no float(s)",
    "to a scalar": "s is an array: take numpy.sin, numpy.exp, ... in place of those of math, and no float(s)",
}


def told(error: Exception) -> str:
    """The error, and the last line of the author's own code on the way to it."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if _is_authors(frame.filename)]
    if not frames:
        return repr(error)
    return f"{error!r} (in {Path(frames[-1].filename).name}, line {frames[-1].lineno}, `{frames[-1].line}`)"


def remedy(error: Exception, otherwise: str) -> str:
    """How to mend what raised the error, where that is known of old."""
    return next((mend for words, mend in _REMEDIES.items() if words in str(error)), otherwise)


def loose_field(cls: type) -> str:
    """What to mend where ``cls`` declares fields of attrs and was not made by it; else nothing."""
    loose = [name for base in cls.__mro__ for name, value in vars(base).items() if isinstance(value, _FIELD)]
    if not loose:
        return ""
    decorator = "@attrs.frozen" if issubclass(cls, ShockProfile) else "@attrs.define"
    return (
        f"{cls.__name__} declares the field {loose[0]}, and lacks its decorator: write  {decorator}  in the line before"
        f"  class {cls.__name__}"
    )


def _is_authors(file: str) -> bool:
    installed = any(part in file for part in _INSTALLED)
    return not (file.startswith(("<", *_FOLDERS)) or (file.startswith(_LIBRARY) and not installed))
