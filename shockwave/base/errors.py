"""All errors that shockwave raises deliberately.

A message has the form ``path: must be rule (got value; hint)``. Errors that are found together are raised together, so
that a user can correct a file in one go.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Self, TypeAlias, TypeVar

from attrs import evolve, field, frozen

_Error = TypeVar("_Error", bound=Exception)
#: Path from the top of a scenario to a value: keys of mappings and indices of lists.
Steps: TypeAlias = tuple[str | int, ...]
#: Names that a message lists in full; of a longer list it shows a few.
MOST_NAMES = 20
_FEW_NAMES = 8
# Length of a name that is compared with the known names.
_LONGEST_NAME = 60
_STEP = re.compile(r"([^.\[\]]+)|\[([0-9]{1,9})\]")
_PLAIN_KEY = re.compile(r"[\w-]{1,60}")
# Exit status of the command line for an invalid value.
_INVALID = 3


def dotted_name(path: Steps) -> str:
    """``path`` as messages write it, such as ``shock.parameters.times[3]``."""
    text = ""
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += ("." if text else "") + (step if _PLAIN_KEY.fullmatch(step) else text_of(step))
    return text


def steps_of(name: str | Steps) -> Steps:
    """Path that ``name`` denotes, such as ``chain.granules[1].diameter``; inverse of `dotted_name` for plain keys."""
    if not isinstance(name, str):
        return name
    return tuple(int(index) if index else step for step, index in _STEP.findall(name))


@frozen
class Fault:
    """One error, with its place.

    Attributes
    ----------
    steps : tuple of str and int
        Path of the value: keys of mappings and indices of lists. A dotted name is converted.
    problem : str
        The error.
    location : str
        Place in a file, ``file:line:column``, if the value was read from one.
    at_key : bool
        Whether the key is wrong, not its value.
    exit_code : int
        Exit status of the command line.
    """

    steps: Steps = field(converter=steps_of)
    problem: str
    location: str = ""
    at_key: bool = field(default=False, eq=False, repr=False)
    exit_code: int = field(default=_INVALID, eq=False, repr=False)

    @property
    def path(self) -> str:
        """Dotted name of the value, such as ``chain.material.density``."""
        return dotted_name(self.steps)

    def below(self, *steps: str | int) -> Fault:
        """The fault with ``steps`` before its path, unless it has a place, to which its path belongs."""
        return self if self.location else evolve(self, steps=(*steps, *self.steps))

    def to_dict(self) -> dict[str, str]:
        """The path, the problem and the location, for JSON."""
        return {"path": self.path, "problem": self.problem, "location": self.location}

    def __str__(self) -> str:
        return ": ".join(part for part in (self.location, self.path, self.problem) if part)


class ShockwaveError(Exception):
    """Base class of all errors raised deliberately; ``exit_code`` is the exit status of the command line.

    Its arguments are messages and faults.
    """

    exit_code = 1

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The errors, with their paths and places."""
        return tuple(
            each if isinstance(each, Fault) else Fault((), each, exit_code=self.exit_code) for each in self.args
        )

    def __str__(self) -> str:
        return "\n".join(map(str, self.args))

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and (self.args, vars(self)) == (other.args, vars(other))

    def __hash__(self) -> int:
        return hash((type(self), self.args))


class NumericalError(ShockwaveError):
    """A computation failed or did not reach the requested accuracy."""


class UsageError(ShockwaveError):
    """Wrong usage: an option that does not apply, or a missing argument."""

    exit_code = 2


class InvalidValueError(ShockwaveError, ValueError):
    """A value is out of range or of the wrong type."""

    exit_code = _INVALID

    @classmethod
    def of(cls, path: str | Steps, problem: str, location: str = "") -> Self:
        """Error with a single fault."""
        return cls(Fault(path, problem, location))

    def with_places(self, place: Callable[[Fault], Fault]) -> Self:
        """The error with ``place`` applied to its faults."""
        error = type(self)(*map(place, self.faults))
        vars(error).update(vars(self))  # its notes
        return error


class NotCoveredError(InvalidValueError):
    """A method does not cover a scene; ``faults`` lists the features that it does not cover."""


class ScenarioError(ShockwaveError):
    """A scenario file is not valid; ``faults`` lists all of its errors."""

    exit_code = _INVALID


class UnknownNameError(ShockwaveError, LookupError):
    """A name is not registered."""

    exit_code = _INVALID

    @classmethod
    def of(cls, kind: str, name: str, known: Iterable[str], hint: str = "", likely: str = "") -> Self:
        """Error of a ``name`` of some ``kind``, perhaps for a ``likely`` one; ``hint`` is further advice."""
        return cls(f"unknown {kind} (got {name!r}; {hint_of(likely or name, [*known])}{f'; {hint}' * bool(hint)})")


class PluginError(ShockwaveError):
    """An installed plugin is faulty."""

    exit_code = 4


class FileAccessError(ShockwaveError):
    """A file cannot be read or written."""

    exit_code = 5


def refuse(faults: Iterable[Fault]) -> None:
    """Raise an `InvalidValueError` with all ``faults``, if there are any."""
    if faults := [*faults]:
        raise InvalidValueError(*faults)


def first_of(faults: Sequence[Fault]) -> InvalidValueError:
    """Error with the first fault of a column and their number, because most are the same mistake."""
    problem = faults[0].problem.removesuffix(")") + f"; one of {len(faults)})"
    return InvalidValueError(faults[0] if len(faults) == 1 else evolve(faults[0], problem=problem))


@contextmanager
def collect_faults(faults: list[Fault], *steps: str | int) -> Iterator[None]:
    """Add the faults of an error that is raised meanwhile to ``faults``, with ``steps`` before their paths."""
    try:
        yield
    except ShockwaveError as error:
        faults += (fault.below(*steps) for fault in error.faults)


@contextmanager
def locate(place: Callable[[Fault], Fault]) -> Iterator[None]:
    """Apply ``place`` to the faults of an invalid value that is reported meanwhile."""
    try:
        yield
    except InvalidValueError as error:
        raise error.with_places(place) from None


def below(*steps: str | int) -> AbstractContextManager[None]:
    """Put ``steps`` before the paths of the faults of an invalid value that is reported meanwhile."""
    return locate(lambda fault: fault.below(*steps))


def detach(error: _Error) -> _Error:
    """``error`` prepared for storage: without its traceback, whose frames hold scenes and arrays.

    That of a plugin is kept, because its author needs the cause.
    """
    if not isinstance(error, PluginError):
        error.__traceback__ = error.__context__ = error.__cause__ = None
    return error


def message_of(error: BaseException) -> str:
    """Message of an error; for an error of other packages, with its type."""
    return str(error) if isinstance(error, ShockwaveError) else f"{type(error).__name__}: {error}"


def nearest(name: str, names: Iterable[str]) -> str:
    """``"did you mean 'x'? "`` for the names with all words of ``name`` or the most similar one, or an empty string."""
    from difflib import get_close_matches  # rarely needed

    names = list(names)
    words = set(re.split("[-_ ]", str(name).lower()))
    matches = [each for each in names if words <= set(each.split("-"))]
    matches = matches or get_close_matches(str(name)[:_LONGEST_NAME], names, n=1)
    if not matches:
        return ""
    *most, last = map(repr, matches)
    return f"did you mean {', '.join(most)}{' or ' * bool(most)}{last}? "


def text_of(value: object, limit: int = 60) -> str:
    """``value`` for a message: its repr, shortened to fit a line."""
    return shorten(repr(value), limit)


def shorten(text: str, limit: int = 60) -> str:
    """The beginning of ``text``, with dots if it is longer than ``limit``."""
    return text if len(text) <= limit else text[: limit - 3] + "..."


def hint_of(name: str, names: Sequence[str], most: int = MOST_NAMES) -> str:
    """The nearest known name, and all known names or, if there are many, those most similar to ``name``."""
    if len(names) <= most:
        return f"{nearest(name, names)}known: {', '.join(names)}"
    from difflib import get_close_matches  # rarely needed

    similar = get_close_matches(str(name)[:_LONGEST_NAME], names, n=_FEW_NAMES, cutoff=0.0)
    return f"{nearest(name, names)}known: {', '.join(similar)}, ..."
