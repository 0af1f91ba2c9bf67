"""Errors of wrong arguments of public functions and constructors, stated as those of wrong values are."""

from __future__ import annotations

import inspect
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from functools import wraps
from typing import Any, TypeVar, cast

import attrs

from shockwave.base.errors import Fault, InvalidValueError, UnknownNameError, collect_faults, hint_of, text_of

_Function = TypeVar("_Function")
_VARIADIC = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


def explain_arguments(function: _Function, of: Any = None) -> _Function:
    """``function``, which raises `InvalidValueError` where Python raises TypeError for its arguments.

    If ``function`` is the constructor of the attrs class ``of``, the error lists the faults of all fields.
    """

    @wraps(cast(Any, function))
    def call(*values: Any, **named: Any) -> Any:
        try:
            return cast(Any, function)(*values, **named)
        except TypeError as error:
            faults = _misfits(function, values, named)
            if not faults:
                raise
            raise InvalidValueError(*faults, *_faults_of_fields(of, named)) from error
        except (InvalidValueError, UnknownNameError) as error:
            others = [fault for fault in _faults_of_fields(of, named) if fault not in error.faults]
            if not others:
                raise
            raise InvalidValueError(*error.faults, *others) from None

    return cast(_Function, call)


def _misfits(function: Any, values: Sequence[Any], keywords: Mapping[str, Any]) -> list[Fault]:
    """Errors of a call; none if the function takes its arguments."""
    signature = inspect.signature(function)
    try:
        signature.bind(*values, **keywords)
    except TypeError as error:
        first = [*signature.parameters][: len(values)]
        taken = {name: each for name, each in signature.parameters.items() if name != "self"}
        required = [name for name, each in taken.items() if each.default is each.empty and each.kind not in _VARIADIC]
        missing = [Fault(name, "must be given (got nothing)") for name in required if name not in {*first, *keywords}]
        other = Fault("arguments", f"must match the signature (got {error}; known: {', '.join(taken)})")
        return unknown_arguments(keywords, taken) or missing or [other]
    return []


def explain_types(function: _Function) -> _Function:
    """``function``, which raises `InvalidValueError` for an argument that lacks an attribute."""

    @wraps(cast(Any, function))
    def call(*values: Any, **named: Any) -> Any:
        try:
            return cast(Any, function)(*values, **named)
        except AttributeError as error:
            signature = inspect.signature(cast(Any, function))
            for name, value in signature.bind(*values, **named).arguments.items():
                if value is error.obj:
                    kind = signature.parameters[name].annotation.replace(" | ", " or ")
                    raise InvalidValueError.of(name, f"must be {kind} (got {text_of(value)})") from error
            raise

    return cast(_Function, call)


def _faults_of_fields(of: Any, keywords: Mapping[str, Any]) -> list[Fault]:
    """Faults of the values of the fields of an attrs class."""
    faults: list[Fault] = []
    for each in () if of is None else attrs.fields(of):
        if each.alias in keywords:
            # a validator may read the instance, which is incomplete
            with suppress(AttributeError), collect_faults(faults):
                value, convert = keywords[each.alias], cast(Any, each.converter)
                if isinstance(each.converter, attrs.Converter):
                    value = convert.converter(value, *[None] * convert.takes_self, *[each] * convert.takes_field)
                elif convert is not None:
                    value = convert(value)
                if each.validator is not None:
                    each.validator(None, each, value)
    return faults


def unknown_arguments(keywords: Mapping[str, object], parameters: Collection[str]) -> list[Fault]:
    """Errors of keyword arguments that are not ``parameters``."""
    names = [name for name in keywords if name not in parameters]
    hints = {name: hint_of(name, [*parameters]) if parameters else "there are no arguments" for name in names}
    return [Fault(name, f"unknown argument (got {name!r}; {hint})") for name, hint in hints.items()]


class Explained:
    """Base class of attrs classes whose constructors explain their arguments, with those that plugins derive."""

    __slots__ = ()

    @classmethod
    def __attrs_init_subclass__(cls) -> None:
        if "__init__" in vars(cls):
            cls.__init__ = explain_arguments(cls.__init__, cls)  # type: ignore[method-assign]
