"""Conversion of the values of a block to what constructors take, with everything that is wrong with them."""

from __future__ import annotations

import types
import typing
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Literal, NamedTuple

from shockwave.errors import nearest
from shockwave.fields import Quantity, text_of
from shockwave.scenario.keys import Key
from shockwave.scenario.units import to_si
from shockwave.scenario.yaml_document import Steps

__all__ = ["Wrong", "missing", "structure"]

_MOST_FAULTS = 20


class Wrong(NamedTuple):
    """What is wrong with a block: ``problem`` at ``path`` below it; ``at_key`` where the key is at fault."""

    path: Steps
    problem: str
    at_key: bool = False


class _ItemsError(ValueError):
    """Wrong items of a list."""

    def __init__(self, wrongs: list[Wrong]) -> None:
        super().__init__()
        self.wrongs = wrongs


def structure(data: Any, keys: Sequence[Key]) -> tuple[dict[str, Any], list[Wrong]]:
    """The values of a block, converted to what constructors take, and everything that is wrong with it.

    Parameters
    ----------
    data : object
        What the document holds. None stands for an empty block.
    keys : sequence of Key
        What it may hold.

    Returns
    -------
    tuple
        Values of the keys that were given, without those at fault; and the list of what is wrong.
    """
    names = [key.name for key in keys]
    if data is None:
        data = {}
    if not isinstance(data, dict):
        return {}, [Wrong((), f"must be a mapping of {', '.join(names) or 'nothing'} (got {text_of(data)})")]
    values: dict[str, Any] = {}
    wrongs: list[Wrong] = []
    for key in keys:
        if key.name in data:
            try:
                values[key.name] = _converted(data[key.name], key)
            except ValueError as error:
                wrongs += _below(key.name, error)
        elif key.required:
            wrongs.append(missing((key.name,), key.purpose))
    unknown = [name for name in data if name not in names]
    return values, [*wrongs, *(_unknown(name, names) for name in unknown[:_MOST_FAULTS])]


def missing(path: Steps, purpose: str) -> Wrong:
    """The fault of a key that is not there."""
    return Wrong(path, f"must be given (got nothing{'; ' if purpose else ''}{purpose})", at_key=True)


def _unknown(name: str, known: Sequence[str]) -> Wrong:
    hint = f"{nearest(name[:60], known)}known: {', '.join(known)}" if known else "there are none here"
    return Wrong((name,), f"unknown key (got {text_of(name)}; {hint})", at_key=True)


def _below(step: str | int, error: ValueError) -> Iterator[Wrong]:
    inner = error.wrongs if isinstance(error, _ItemsError) else [Wrong((), str(error))]
    return (Wrong((step, *wrong.path), wrong.problem) for wrong in inner)


def _converted(value: Any, key: Key) -> Any:
    """The value of ``key`` as the constructor takes it; raises ValueError, with what it must be."""
    spec = key.spec
    if value is None and (key.default is None if spec is None else spec.optional):
        return None
    if spec is None:
        return _of_kind(value, key.annotation)
    if not spec.samples:
        return _quantity(value, spec)
    if not isinstance(value, list):
        raise ValueError(f"must be a list of numbers or quantities (got {_shown(value)})")
    return _items(value, lambda sample: _quantity(sample, spec))


def _quantity(value: Any, spec: Quantity) -> int | float:
    # A whole number stays one: a float would round a large one.
    si = value if spec.whole and type(value) is int else to_si(value, spec.unit)
    if spec.problem(si) is not None:
        raise ValueError(f"must be {spec.rule} (got {_shown(value)})")
    return int(si) if spec.whole else si


def _items(values: Sequence[Any], convert: Callable[[Any], Any]) -> list[Any]:
    """All values converted, or the faults of the first few that cannot be."""
    converted: list[Any] = []
    wrongs: list[Wrong] = []
    for index, value in enumerate(values):
        try:
            converted.append(convert(value))
        except ValueError as error:
            wrongs += _below(index, error)
        if len(wrongs) >= _MOST_FAULTS:
            break
    if wrongs:
        raise _ItemsError(wrongs)
    return converted


def _of_kind(value: Any, annotation: Any) -> Any:
    """``value`` as an annotated type; as it is, where the type is the class's own: its constructor judges."""
    origin, members = typing.get_origin(annotation) or annotation, typing.get_args(annotation)
    if origin in (typing.Union, types.UnionType):
        return _any_of(value, members, annotation)
    if origin is Literal:
        return _choice(value, members)
    if origin in (list, tuple, Sequence):
        if not isinstance(value, list | tuple):  # a tuple is one that was converted before
            raise ValueError(f"must be a list (got {_shown(value)})")
        items = _items(value, lambda item: _of_kind(item, members[0] if members else Any))
        return tuple(items) if origin is tuple else items
    if origin is bool and not isinstance(value, bool):
        raise ValueError(f"must be true or false (got {_shown(value)})")
    if origin is str and not isinstance(value, str):
        hint = "" if value is None else "; put it in quotes if it is text"
        raise ValueError(f"must be text (got {_shown(value)}{hint})")
    if origin not in (int, float):
        return value
    number = value if origin is int and type(value) is int else to_si(value, "")
    if origin is int and number != int(number):
        raise ValueError(f"must be a whole number (got {_shown(value)})")
    return origin(number)


def _choice(value: Any, known: Sequence[Any]) -> Any:
    if type(value) in (str, int, bool) and value in known:
        return value
    *most, last = map(repr, known)
    listed = f"{', '.join(most)} or {last}" if most else last
    hint = nearest(value[:60], map(str, known)).strip() if isinstance(value, str) else ""
    raise ValueError(f"must be {listed} (got {_shown(value)}{'; ' if hint else ''}{hint})")


def _any_of(value: Any, members: Sequence[Any], annotation: Any) -> Any:
    """A value of a union: text is taken as text only where it is no number."""
    if value is None and type(None) in members:
        return None
    rest = sorted((member for member in members if member is not type(None)), key=lambda member: member is str)
    for member in rest:
        try:
            return _of_kind(value, member)
        except ValueError:
            if len(rest) == 1:
                raise
    raise ValueError(f"must be of the kind {str(annotation).replace('typing.', '')} (got {_shown(value)})")


def _shown(value: Any) -> str:
    return "nothing" if value is None else text_of(value)
