"""Values: from what a document holds to what constructors take, with every fault at once."""

from __future__ import annotations

import types
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, lru_cache
from typing import Any, Literal

import attrs
from attrs import field, frozen
from cattrs import BaseValidationError, Converter
from cattrs.errors import ForbiddenExtraKeysError, StructureHandlerNotFoundError
from cattrs.gen import make_dict_structure_fn, override

from shockwave.errors import nearest
from shockwave.fields import Quantity, text_of
from shockwave.scenario.blocks import Key
from shockwave.scenario.units import to_si
from shockwave.scenario.yaml_document import Steps

__all__ = ["Wrong", "missing", "structure"]

_MOST_FAULTS = 20


@frozen
class Wrong:
    """What is wrong with a block: ``problem`` at ``path`` below it; ``at_key`` where the key is at fault."""

    path: Steps
    problem: str
    at_key: bool = False


class _WrongError(ValueError):
    """Raised by the hooks below; cattrs gathers them."""

    def __init__(self, *wrongs: Wrong) -> None:
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
        Values of the keys that were given, none when anything is wrong; and the list of what is wrong.
    """
    if data is None:
        data = {}
    if not isinstance(data, dict):
        names = ", ".join(key.name for key in keys)
        return {}, [Wrong((), f"must be a mapping of {names or 'nothing'} (got {text_of(data)})")]
    form, hook = _form_of(tuple(keys))
    try:
        block = hook(data, form)
    except BaseValidationError as error:
        return {}, list(_wrongs(error, {key.name: key for key in keys}))
    return {name: getattr(block, name) for name in data}, []


@cache
def _converter() -> Converter:
    converter = Converter(detailed_validation=True, forbid_extra_keys=True)
    converter.register_structure_hook(float, lambda value, _: _number(value))
    converter.register_structure_hook(int, lambda value, _: _whole(value))
    converter.register_structure_hook(str, lambda value, _: _text(value))
    converter.register_structure_hook(bool, lambda value, _: _truth(value))
    converter.register_structure_hook_func(lambda kind: _origin(kind) is Literal, _one_of)
    converter.register_structure_hook_func(lambda kind: _origin(kind) in (typing.Union, types.UnionType), _any_of)
    converter.register_structure_hook_func(lambda kind: _origin(kind) in (list, tuple, Sequence), _items)
    return converter


def _form_of(keys: tuple[Key, ...]) -> tuple[type, Callable[[Mapping[str, Any], Any], Any]]:
    """As `_form`, which takes most of the time of loading and is therefore done once for the same keys."""
    try:
        return _form(keys)
    except TypeError:  # the default of a plugin's parameter may have no hash
        return _form.__wrapped__(keys)


@lru_cache(maxsize=128)
def _form(keys: tuple[Key, ...]) -> tuple[type, Callable[[Mapping[str, Any], Any], Any]]:
    """A class with one attribute for each key, and the function that fills it and finds every fault."""
    attributes = {key.name: field() if key.required else field(default=None) for key in sorted(keys, key=_order)}
    form = attrs.make_class("Block", attributes, frozen=True)
    overrides = {key.name: override(struct_hook=_hook(key)) for key in keys}
    made: Any = make_dict_structure_fn
    return form, made(form, _converter(), _cattrs_use_linecache=False, **overrides)


def _order(key: Key) -> bool:
    return not key.required  # attrs wants those with a default last


def _hook(key: Key) -> Callable[[Any, Any], Any]:
    """What turns the value of ``key`` into what the constructor takes, or raises `_WrongError`."""

    def structured(value: Any, _: Any) -> Any:
        if key.spec is not None:
            return _samples(value, key.spec) if key.spec.samples else _quantity(value, key.spec)
        if value is None and key.default is None:
            return None
        try:
            return _converter().structure(value, key.annotation)
        except (_WrongError, BaseValidationError):
            raise
        except StructureHandlerNotFoundError:
            return value  # a type of the class's own: its constructor judges
        except Exception:
            wanted = getattr(key.annotation, "__name__", str(key.annotation))
            raise _wrong(f"must be of the kind {wanted} (got {_shown(value)})") from None

    return structured


def _wrongs(error: BaseValidationError, keys: Mapping[str, Key], path: Steps = ()) -> Iterator[Wrong]:
    """What cattrs gathered."""
    for part in error.exceptions:
        step = next((step for note in getattr(part, "__notes__", ()) if (step := _step(note)) is not None), None)
        below = path if step is None else (*path, step)
        if isinstance(part, BaseValidationError):
            yield from _wrongs(part, {}, below)
        elif isinstance(part, _WrongError):
            yield from (attrs.evolve(wrong, path=(*below, *wrong.path)) for wrong in part.wrongs)
        elif isinstance(part, ForbiddenExtraKeysError):
            known = list(keys) or [attribute.name for attribute in attrs.fields(part.cl)]
            yield from (_unknown(path, name, known) for name in sorted(part.extra_fields)[:_MOST_FAULTS])
        elif isinstance(part, KeyError):
            key = keys.get(str(step))
            yield missing(below, key.purpose if key is not None else "")
        else:
            yield Wrong(below, f"must be a value of its kind (got {text_of(str(part))})")


def _step(note: object) -> str | int | None:
    """The attribute or index that a note of cattrs names."""
    step = getattr(note, "name", getattr(note, "index", None))
    return step if isinstance(step, str | int) else None


def missing(path: Steps, purpose: str) -> Wrong:
    """The fault of a key that is not there."""
    return Wrong(path, f"must be given (got nothing{'; ' if purpose else ''}{purpose})", at_key=True)


def _unknown(path: Steps, name: str, known: Sequence[str]) -> Wrong:
    if not known:
        return Wrong((*path, name), f"unknown key (got {text_of(name)}; there are none here)", at_key=True)
    hint = f"{nearest(name[:60], known)}known: {', '.join(known)}"
    return Wrong((*path, name), f"unknown key (got {text_of(name)}; {hint})", at_key=True)


def _shown(value: Any) -> str:
    return "nothing" if value is None else text_of(value)


def _wrong(problem: str) -> _WrongError:
    return _WrongError(Wrong((), problem))


def _si(value: Any, unit: str) -> float:
    try:
        return to_si(value, unit)
    except ValueError as error:
        raise _wrong(str(error)) from None


def _quantity(value: Any, spec: Quantity) -> Any:
    if value is None and spec.optional:
        return None
    # A whole number stays one: a float would round a large one.
    si = value if spec.whole and type(value) is int else _si(value, spec.unit)
    if spec.problem(si) is not None:
        raise _wrong(f"must be {spec.rule} (got {_shown(value)})")
    return spec.convert(si)


def _samples(value: Any, spec: Quantity) -> list[float] | None:
    if value is None and spec.optional:
        return None
    if not isinstance(value, list):
        raise _wrong(f"must be a list of numbers or quantities (got {_shown(value)})")
    return _gather(value, lambda sample: _quantity(sample, spec))


def _gather(values: Sequence[Any], convert: Callable[[Any], Any]) -> list[Any]:
    """All values converted, or the faults of the first few that cannot be."""
    converted, wrongs = [], []
    for index, value in enumerate(values):
        try:
            converted.append(convert(value))
        except _WrongError as error:
            wrongs += [attrs.evolve(wrong, path=(index, *wrong.path)) for wrong in error.wrongs]
        if len(wrongs) >= _MOST_FAULTS:
            break
    if wrongs:
        raise _WrongError(*wrongs)
    return converted


def _number(value: Any) -> float:
    return _si(value, "")


def _whole(value: Any) -> int:
    number = value if type(value) is int else _number(value)
    if number != int(number):
        raise _wrong(f"must be a whole number (got {_shown(value)})")
    return int(number)


def _text(value: Any) -> str:
    if isinstance(value, str):
        return value
    hint = _shown(value) if value is None else f"{_shown(value)}; put it in quotes if it is text"
    raise _wrong(f"must be text (got {hint})")


def _truth(value: Any) -> bool:
    if isinstance(value, bool):
        return value
    raise _wrong(f"must be true or false (got {_shown(value)})")


def _one_of(value: Any, choice: Any) -> Any:
    known = typing.get_args(choice)
    if type(value) in (str, int, bool) and value in known:
        return value
    *most, last = (repr(name) for name in known)
    listed = f"{', '.join(most)} or {last}" if most else last
    raise _wrong(f"must be {listed} (got {_shown(value)}{_hint(value, known)})")


def _hint(value: Any, known: Sequence[Any]) -> str:
    hint = nearest(value[:60], [str(name) for name in known]) if isinstance(value, str) else ""
    return f"; {hint.strip()}" if hint else ""


def _any_of(value: Any, union: Any) -> Any:
    """A value of a union: text is taken as text only where it is no number."""
    members = typing.get_args(union)
    if value is None and type(None) in members:
        return None
    rest = sorted((member for member in members if member is not type(None)), key=lambda member: member is str)
    errors = []
    for member in rest:
        try:
            return _converter().structure(value, member)
        except _WrongError as error:
            errors.append(error)
        except StructureHandlerNotFoundError:
            return value
        except Exception:
            continue
    if len(rest) == 1 and errors:
        raise errors[0]
    raise _wrong(f"must be of the kind {str(union).replace('typing.', '')} (got {_shown(value)})")


def _origin(annotation: Any) -> Any:
    return typing.get_origin(annotation) or annotation


def _items(value: Any, annotation: Any) -> Any:
    if not isinstance(value, list | tuple):  # a tuple is one that was converted before
        raise _wrong(f"must be a list (got {_shown(value)})")
    item = next(iter(typing.get_args(annotation)), Any)
    items = _gather(value, lambda one: _converter().structure(one, item))
    return tuple(items) if _origin(annotation) is tuple else items
