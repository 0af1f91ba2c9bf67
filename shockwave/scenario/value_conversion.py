"""Conversion of the values of a block to arguments of constructors, with all errors."""

from __future__ import annotations

import math
import types
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from contextvars import ContextVar
from functools import partial
from typing import Any, Literal

from shockwave.base.errors import Fault, InvalidValueError, ShockwaveError, first_of, hint_of, nearest, refuse
from shockwave.base.quantity_fields import Declaration, join, text_of
from shockwave.base.units import COMMA, to_si
from shockwave.registry.registry import find, load
from shockwave.scenario.block_keys import Key, hint_instead_of, paths_of

#: Conversion of a value of a document.
Parser = Callable[[Any], Any]
#: Whether text that is converted may name a file, as in a scenario of the user's own, but not in one from a network.
names_files: ContextVar[bool] = ContextVar("names_files", default=True)
# Unknown keys of a block for which similar keys are sought, which takes a millisecond each.
_MOST_HINTS = 100
_NUMBERS = {int: Declaration("", "", whole=True), float: Declaration("", "")}


def values_of(
    data: Any, keys: Sequence[Key], parsers: Mapping[str, Parser] | None = None
) -> tuple[dict[str, Any], list[Fault]]:
    """Valid values of a block, converted to arguments of constructors, and all of its errors.

    Parameters
    ----------
    data : object
        Content of the block. None stands for an empty block.
    keys : sequence of Key
        Its keys.
    parsers : mapping, optional
        Conversions of keys whose values are blocks themselves.
    """
    content = {} if data is None else data
    if not isinstance(content, dict):
        names = ", ".join(key.name for key in keys) or "nothing"
        return {}, [Fault((), f"must be a mapping of {names} (got {text_of(content)})")]
    converters = {key.name: partial(convert, key) for key in keys} | dict(parsers or {})
    values, faults = _each(content.items(), converters)
    return values, [*faults, *_key_faults(content, keys)]


def structure(data: Any, keys: Sequence[Key], parsers: Mapping[str, Parser] | None = None) -> dict[str, Any]:
    """Values of a block as `values_of`, if all are valid; raises an `InvalidValueError` with all errors."""
    values, faults = values_of(data, keys, parsers)
    refuse(faults)
    return values


def _key_faults(content: Mapping[str, Any], keys: Sequence[Key]) -> Iterator[Fault]:
    """Errors of missing keys, and of values given twice under different keys."""
    substitutes = [(name, key.name) for key in keys for name in key.instead_of]
    for name, other in substitutes:
        if name in content and other in content:
            yield Fault((other,), f"must be left out if {name} is given (got both; delete one)", at_key=True)
    for key in keys:
        if not key.one_of:
            continue
        if content.keys() >= {key.name, *key.one_of}:
            problem = f"must be left out if {join(key.one_of, 'and')} are given (got all; delete one)"
            yield Fault((key.name,), problem, at_key=True)
        missing = [other.name for other in keys if other.required and other.name in {*key.one_of}.difference(content)]
        substitutes += [(name, key.name) for name in missing if key.name not in content or len(missing) == 1]
    for key in keys:
        if not key.required or key.name in content:
            continue
        others = [other for name, other in substitutes if name == key.name]
        if content.keys().isdisjoint(others):
            words = filter(None, ("got nothing", key.purpose, f"or give {join(others)}" if others else ""))
            yield Fault((key.name,), f"must be given ({'; '.join(words)})")


def _each(pairs: Iterable[tuple[Any, Any]], converters: Mapping[Any, Parser]) -> tuple[dict[Any, Any], list[Fault]]:
    """Values, each converted by the function of its key or index, and the errors of the others."""
    values: dict[Any, Any] = {}
    faults: list[Fault] = []
    for step, value in pairs:
        if step not in converters:
            faults.append(_unknown_key(step, list(converters), len(faults) < _MOST_HINTS))
            continue
        try:
            values[step] = converters[step](value)
        except ShockwaveError as error:
            faults += (fault.below(step) for fault in error.faults)
    return values, faults


def gather(
    pairs: Iterable[tuple[Any, Any]], converters: Mapping[Any, Parser], others: Iterable[Fault] = ()
) -> dict[Any, Any]:
    """Values, each converted by the function of its key or index.

    Raises
    ------
    InvalidValueError
        When conversions fail or there are ``others``; it contains all errors.
    """
    values, faults = _each(pairs, converters)
    refuse([*faults, *others])
    return values


def items(values: Sequence[Any], convert: Parser) -> list[Any]:
    """All values, converted; raises an `InvalidValueError` with all errors."""
    found = gather(enumerate(values), dict.fromkeys(range(len(values)), convert))
    return list(found.values())


def _unknown_key(name: str, known: Sequence[str], helpful: bool) -> Fault:
    hint = "no keys are allowed here" if not known else hint_of(name, known) if helpful else "see the first errors"
    if known and (advice := hint_instead_of(name)):
        hint = advice
    elif paths := paths_of(name):
        hint = f"did you mean {paths[0]!r}?"
    comma = COMMA if name[:1].isdigit() else ""  # {diameter: 9,5 mm} in YAML
    return Fault((name,), f"unknown key (got {text_of(name)}{comma}; {hint})", at_key=True)


# ---------------------------------------------------------------- one value


def convert(key: Key, value: Any) -> Any:
    """Value of ``key`` as an argument of the constructor, if it is valid."""
    spec = key.spec
    if value is None and key.may_be_none:
        return None
    if key.keys and (not isinstance(value, str | int) if key.kind else spec is None or isinstance(value, dict)):
        return key.make(**structure(value, key.keys))
    if spec is None:
        if key.kind and str(value).lower() in key.also:
            return value.lower()
        if key.keys:
            return load(key.kind, str(value))  # a number, such as 52100, is the name of a grade of a material
        if key.kind and isinstance(value, str):
            value = find(key.kind, value).name
        return _convert_to_kind(value, key.annotation, key.plain or bool(key.kind) or names_files.get())
    if not spec.samples:
        return _quantity(value, spec)
    try:
        return _list(value, lambda sample: _quantity(sample, spec))
    except InvalidValueError as error:
        raise error if spec.whole else first_of(error.faults) from None


def _quantity(value: Any, spec: Declaration) -> int | float:
    try:
        # a float would round a large whole number
        si = value if spec.whole and type(value) is int else to_si(value, spec.unit)
    except InvalidValueError:
        if not spec.whole:
            raise
        si = math.nan
    if spec.problem(si) is not None:
        raise InvalidValueError(f"must be {spec.rule} (got {_text_or_nothing(value)})")
    return int(si) if spec.whole else si


def _convert_to_kind(value: Any, annotation: Any, text: bool) -> Any:
    """``value`` as an annotated type; unchanged if the type is unknown here, because the constructor then checks it.

    Unless ``text`` is true, the only text that is allowed is a fixed choice of the type.
    """
    origin = typing.get_origin(annotation) or annotation
    members = typing.get_args(annotation)
    if origin in _NUMBERS:
        return _quantity(value, _NUMBERS[origin])
    if origin in (typing.Union, types.UnionType):
        return _convert_to_any(value, members, text)
    if origin in (list, tuple, Sequence):
        found = _list(value, lambda item: _convert_to_kind(item, members[0] if members else Any, text))
        return tuple(found) if origin is tuple else found
    if origin is Literal:
        same = [one for one in members if one == value or str(one).lower() == str(value).lower()]
        if not same:
            hint = nearest(str(value), map(str, members)).strip()
            raise InvalidValueError(
                f"must be {join(map(repr, members))} (got {_text_or_nothing(value)}{hint and '; '}{hint})"
            )
        return same[0]
    if origin is bool and not isinstance(value, bool):
        raise InvalidValueError(f"must be true or false (got {_text_or_nothing(value)})")
    if origin is str and not isinstance(value, str):
        hint = "" if value is None or isinstance(value, list | dict) else "; put it in quotes if it is text"
        raise InvalidValueError(f"must be text (got {_text_or_nothing(value)}{hint})")
    if text:
        return value
    if isinstance(value, str | dict):
        hint = "load the scenario from a file of your own"
        raise InvalidValueError(f"must not be text here, because it could name a file (got {text_of(value)}; {hint})")
    return _list(value, lambda item: _convert_to_kind(item, Any, text)) if isinstance(value, list) else value


def _list(value: Any, convert: Parser) -> list[Any]:
    if not isinstance(value, list | tuple):  # a tuple was converted before
        raise InvalidValueError(f"must be a list (got {_text_or_nothing(value)})")
    return items(value, convert)


def _convert_to_any(value: Any, members: Sequence[Any], text: bool) -> Any:
    """Value of a union; text counts as text only if it is not a number."""
    if value is None and type(None) in members:
        return None
    rest = [member for member in members if member is not type(None)]
    *first, last = sorted(rest, key=lambda member: member is str)
    for member in first:
        with suppress(InvalidValueError):
            return _convert_to_kind(value, member, text)
    return _convert_to_kind(value, last, text)


def _text_or_nothing(value: Any) -> str:
    return "nothing" if value is None else text_of(value)
