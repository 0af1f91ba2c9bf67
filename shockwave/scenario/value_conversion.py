"""Conversion of the values of a block to what constructors take, with everything that is wrong with them."""

from __future__ import annotations

import types
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, Literal, NamedTuple

from shockwave.errors import PluginError, UnknownNameError, nearest
from shockwave.fields import Quantity, text_of
from shockwave.registry import find
from shockwave.scenario.keys import Key
from shockwave.scenario.units import to_si
from shockwave.scenario.yaml_document import Steps

#: After so many faults in one file, the rest is not looked for.
MOST_FAULTS = 100


class Wrong(NamedTuple):
    """What is wrong with a block: ``problem`` at ``path`` below it.

    ``at_key`` says that the key is at fault, ``plugin`` that a plugin is.
    """

    path: Steps
    problem: str
    at_key: bool = False
    plugin: bool = False


class WrongsError(ValueError):
    """Several things are wrong with a value."""

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
    if data is None:
        data = {}
    if not isinstance(data, dict):
        names = ", ".join(key.name for key in keys) or "nothing"
        return {}, [Wrong((), f"must be a mapping of {names} (got {text_of(data)})")]
    values, wrongs = gathered(data.items(), {key.name: partial(converted, key) for key in keys})
    absent = [key for key in keys if key.required and key.name not in data]
    return values, [*wrongs, *(missing((key.name,), key.purpose) for key in absent)]


def gathered(
    pairs: Iterable[tuple[Any, Any]], converters: Mapping[Any, Callable[[Any], Any]]
) -> tuple[dict[Any, Any], list[Wrong]]:
    """Values converted each by the function of its key or index, without those at fault; and what is wrong."""
    values: dict[Any, Any] = {}
    wrongs: list[Wrong] = []
    for step, value in pairs:
        if step not in converters:
            wrongs.append(_unknown(step, list(converters)))
            continue
        try:
            values[step] = converters[step](value)
        except WrongsError as error:
            wrongs += (wrong._replace(path=(step, *wrong.path)) for wrong in error.wrongs)
        except (ValueError, UnknownNameError, PluginError) as error:
            plugin = getattr(error, "exit_code", 0) == PluginError.exit_code
            wrongs.append(Wrong((step,), str(error), plugin=plugin))
    return values, wrongs


def all_sound(found: tuple[dict[Any, Any], list[Wrong]]) -> dict[Any, Any]:
    """What was `gathered`; raises `WrongsError` where anything is wrong."""
    values, wrongs = found
    if wrongs:
        raise WrongsError(wrongs)
    return values


def items(values: Sequence[Any], convert: Callable[[Any], Any]) -> list[Any]:
    """All values converted; raises `WrongsError` where some cannot be."""
    return list(all_sound(gathered(enumerate(values), dict.fromkeys(range(len(values)), convert))).values())


def missing(path: Steps, purpose: str) -> Wrong:
    """The fault of a key that is not there."""
    return Wrong(path, f"must be given (got nothing{'; ' if purpose else ''}{purpose})", at_key=True)


def _unknown(name: str, known: Sequence[str]) -> Wrong:
    hint = f"{nearest(name[:60], known)}known: {', '.join(known)}" if known else "there are none here"
    return Wrong((name,), f"unknown key (got {text_of(name)}; {hint})", at_key=True)


def converted(key: Key, value: Any) -> Any:
    """The value of ``key`` as the constructor takes it; raises ValueError or UnknownNameError for a wrong one."""
    spec = key.spec
    if value is None and (key.default is None if spec is None else spec.optional):
        return None
    if spec is not None and not spec.samples:
        return _quantity(value, spec)
    if spec is not None:
        if not isinstance(value, list):
            raise ValueError(f"must be a list of numbers or quantities (got {_shown(value)})")
        return items(value, lambda sample: _quantity(sample, spec))
    if key.kind and isinstance(value, str):
        find(key.kind, value)
    return _of_kind(value, key.annotation)


def _quantity(value: Any, spec: Quantity) -> int | float:
    # A whole number stays one: a float would round a large one.
    si = value if spec.whole and type(value) is int else to_si(value, spec.unit)
    if spec.problem(si) is not None:
        raise ValueError(f"must be {spec.rule} (got {_shown(value)})")
    return int(si) if spec.whole else si


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
        found = items(value, lambda item: _of_kind(item, members[0] if members else Any))
        return tuple(found) if origin is tuple else found
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
