"""Every error that shockwave raises on purpose, and the one shape of its messages.

A message reads ``path: must be rule (got value; hint)``. Faults found together are raised
together, so that a user mends a file once.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from attrs import frozen


@frozen
class Fault:
    """One thing that is wrong, where it stands, and how to mend it.

    ``path`` is the dotted name of the value (``chain.material.density``), ``location`` the place in
    a file (``file:line:column``) when the value was read from one.
    """

    path: str
    problem: str
    location: str = ""

    def __str__(self) -> str:
        return ": ".join(part for part in (self.location, self.path, self.problem) if part)


class ShockwaveError(Exception):
    """Base of all errors raised on purpose; ``exit_code`` is what the command line ends with."""

    exit_code = 1


class NumericalError(ShockwaveError):
    """A computation could not reach what was asked of it."""


class UsageError(ShockwaveError):
    """The call itself is wrong: an option that does not apply, a missing argument."""

    exit_code = 2


class _FaultsError(ShockwaveError):
    exit_code = 3

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


class InvalidValueError(_FaultsError, ValueError):
    """A value lies outside its range, or is of the wrong kind."""

    @classmethod
    def of(cls, path: str, problem: str) -> InvalidValueError:
        """The error of a single fault."""
        return cls([Fault(path, problem)])


class ScenarioError(_FaultsError):
    """A scenario file is not valid; ``faults`` lists everything that is wrong with it."""


class UnknownNameError(ShockwaveError, LookupError):
    """A name is not in its registry; ``hint`` is what else may help."""

    exit_code = 3

    def __init__(self, kind: str, name: str, known: Iterable[str], hint: str = "") -> None:
        names = list(known)
        more = f"; {hint}" if hint else ""
        super().__init__(f"unknown {kind} (got {name!r}; {nearest(name, names)}known: {', '.join(names)}{more})")


class PluginError(ShockwaveError):
    """An installed plugin is at fault, not the user's input; ``faults`` are the places where it shows in a scenario."""

    exit_code = 4

    def __init__(self, problem: str, faults: Iterable[Fault] = ()) -> None:
        self.faults = tuple(faults)
        super().__init__(problem)


class FileAccessError(ShockwaveError):
    """A file cannot be read or written."""

    exit_code = 5


def nearest(name: str, known: Iterable[str]) -> str:
    """``"did you mean 'x'? "`` for the known name most like ``name``, else an empty string."""
    matches = get_close_matches(str(name), list(known), n=1)
    return f"did you mean {matches[0]!r}? " if matches else ""
