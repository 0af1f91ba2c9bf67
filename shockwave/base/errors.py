"""All errors that shockwave raises deliberately.

A message has the form ``path: must be rule (got value; hint)``. Errors that are found together are raised together, so
that a user can correct a file in one go.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

from attrs import frozen

_Error = TypeVar("_Error", bound=Exception)
#: Names that a message lists in full; of a longer list it shows a few.
MOST_NAMES = 20
_FEW_NAMES = 8
# Length of a name that is compared with the known names.
_LONGEST_NAME = 60


@frozen
class Fault:
    """One error, with its place.

    ``path`` is the dotted name of the value (``chain.material.density``); ``location`` is the place in a file
    (``file:line:column``), if the value was read from one.
    """

    path: str
    problem: str
    location: str = ""

    def __str__(self) -> str:
        return ": ".join(part for part in (self.location, self.path, self.problem) if part)


class ShockwaveError(Exception):
    """Base class of all errors raised deliberately; ``exit_code`` is the exit status of the command line."""

    exit_code = 1


class NumericalError(ShockwaveError):
    """A computation failed or did not reach the requested accuracy."""


class UsageError(ShockwaveError):
    """Wrong usage: an option that does not apply, or a missing argument."""

    exit_code = 2


class _FaultsError(ShockwaveError):
    exit_code = 3

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


class InvalidValueError(_FaultsError, ValueError):
    """A value is out of range or of the wrong type."""

    @classmethod
    def of(cls, path: str, problem: str) -> InvalidValueError:
        """Error with a single fault."""
        return cls([Fault(path, problem)])


class NotCoveredError(InvalidValueError):
    """A method does not cover a scene; ``faults`` lists the features that it does not cover."""


class ScenarioError(_FaultsError):
    """A scenario file is not valid; ``faults`` lists all of its errors."""


class UnknownNameError(ShockwaveError, LookupError):
    """A name is not registered; ``hint`` is further advice."""

    exit_code = 3

    def __init__(self, kind: str, name: str, known: Iterable[str], hint: str = "") -> None:
        names = list(known)
        shown = ", ".join(names if len(names) <= MOST_NAMES else [*names[:_FEW_NAMES], "..."])
        more = f"; {hint}" if hint else ""
        super().__init__(f"unknown {kind} (got {name!r}; {nearest(name, names)}known: {shown}{more})")


class PluginError(ShockwaveError):
    """An installed plugin is faulty; ``faults`` are the places of a scenario that use it."""

    exit_code = 4

    def __init__(self, problem: str, faults: Iterable[Fault] = ()) -> None:
        self.faults = tuple(faults)
        super().__init__(problem)


class FileAccessError(ShockwaveError):
    """A file cannot be read or written."""

    exit_code = 5


def detached(error: _Error) -> _Error:
    """``error`` prepared for storage: without its traceback, whose frames hold scenes and arrays.

    That of a plugin is kept, because its author needs the cause.
    """
    if not isinstance(error, PluginError):
        error.__traceback__ = error.__context__ = error.__cause__ = None
    return error


def message_of(error: BaseException) -> str:
    """Message of an error; for an error of other packages, with its type."""
    return str(error) if isinstance(error, ShockwaveError) else f"{type(error).__name__}: {error}"


def nearest(name: str, known: Iterable[str]) -> str:
    """``"did you mean 'x'? "`` for the known name that is most similar to ``name``, or an empty string."""
    from difflib import get_close_matches  # rarely needed

    matches = get_close_matches(str(name)[:_LONGEST_NAME], list(known), n=1)
    return f"did you mean {matches[0]!r}? " if matches else ""


def text_of(value: object, limit: int = 60) -> str:
    """``value`` for a message: its repr, shortened to fit a line."""
    return shortened(repr(value), limit)


def shortened(text: str, limit: int = 60) -> str:
    """The beginning of ``text``, with dots if it is longer than ``limit``."""
    return text if len(text) <= limit else text[: limit - 3] + "..."


def hint_of(name: str, known: Sequence[str]) -> str:
    """The nearest known name, and all known names or, if there are many, those most similar to ``name``."""
    if len(known) <= MOST_NAMES:
        return f"{nearest(name, known)}known: {', '.join(known)}"
    from difflib import get_close_matches  # rarely needed

    similar = get_close_matches(str(name)[:_LONGEST_NAME], known, n=_FEW_NAMES, cutoff=0.0)
    return f"{nearest(name, known)}known: {', '.join(similar)}, ..."
