"""Schema: what a scenario may hold, as JSON Schema (draft-07), for editors.

It is derived from the keys that the loader reads, and admits whatever the loader does. What a schema cannot express
is left to the loader: units, files, and rules over several values.
"""

from __future__ import annotations

import math
import re
import types
import typing
from collections.abc import Sequence
from typing import Any, Final, Literal

from shockwave import registry
from shockwave.chain.material import Material
from shockwave.fields import Quantity
from shockwave.prediction.predictor import MOMENTUM_COEFFICIENT, MOMENTUM_COEFFICIENTS
from shockwave.scenario import keys
from shockwave.scenario.keys import Key, keys_of
from shockwave.scenario.loader import DISTRIBUTION
from shockwave.scenario.scenario import Published
from shockwave.scenario.sweep import SWEEP
from shockwave.scenario.uncertainty import FORMS, TWINS

_DRAFT = "http://json-schema.org/draft-07/schema#"
_ABOUT = (
    "One shock on one chain of equal elastic spheres. A bare number is in SI units; text is a number with a unit"
    " of the same dimension, such as 15 us."
)
# How the text of a quantity begins. A unit is not looked at: there are more spellings than a pattern can hold.
_POSITIVE = r"^\s*\+?[0.]*[1-9]"
_ANY_SIGN = r"^\s*[-+]?\.?[0-9]"
# `$` would also match before a line break at the end.
_END = r"(?![\s\S])"
_LINE = rf"^[^\n]*\S[^\n]*{_END}"
_FILE = rf"^(?!/)[\s\S]*\S[\s\S]*{_END}"

Form = dict[str, Any]
_SPACING: Form = {"type": "array", "minItems": 3, "maxItems": 3, "description": "first, last, number"}
_OWN_RATIO: Form = {"not": {}, "description": "to be left out, as the profile has its own"}


def schema() -> Form:
    """The JSON Schema of a scenario with what is installed, plugins included.

    Returns
    -------
    dict
        Plain data for `json.dumps`, the same for the same installation. A profile that cannot be imported may be
        named in a scenario, with any parameters.
    """
    forms = {key.name: _value(key) for key in keys.SCENARIO}
    forms["name"]["pattern"] = _LINE
    forms["requires"]["items"]["pattern"] = f"^(?:{DISTRIBUTION.pattern}){_END}"
    forms["chain"] |= _mapping(keys.CHAIN)
    material = forms["chain"]["properties"]["material"]
    named = {name: material.pop(name) for name in ("type", "enum")}
    material["anyOf"] = [named, _mapping(keys_of(Material))]
    profiles = {name: _of_profile(name) for name in _names("profiles")}
    forms["shock"] |= _mapping(keys.SHOCK)
    forms["shock"]["allOf"] = [_where_profile(name, form) for name, (form, _) in profiles.items()]
    forms["predict"] |= _or_null(_mapping(keys.BLOCKS["predict"]))
    forms["simulate"] |= _or_null(_mapping(keys.BLOCKS["simulate"]))
    forms["published"] |= _or_null(_mapping(keys_of(Published)) | _required(keys_of(Published)))
    forms["sweep"] |= _sweep()
    forms["uncertainty"] |= _uncertainty()
    return {
        "$schema": _DRAFT,
        "$comment": _installed(),
        "title": "Scenario of shockwave",
        "description": _ABOUT,
        "type": "object",
        "properties": forms,
        "additionalProperties": False,
        # the scenes of a sweep may have from it what is missing here
        "if": {"properties": {"sweep": {"type": "object"}}, "required": ["sweep"]},
        "else": _complete([_where_profile(name, needed) for name, (_, needed) in profiles.items()]),
    }


def _complete(of_profiles: list[Form]) -> Form:
    """What a scenario of a single scene must have."""
    chain = _required(keys.CHAIN)
    chain["properties"] = {"material": {"if": {"type": "object"}, "then": _required(keys_of(Material))}}
    shock = _required(keys.SHOCK) | {"allOf": of_profiles}
    return _required(keys.SCENARIO) | {"properties": {"chain": chain, "shock": shock}}


def _installed() -> str:
    from shockwave import __version__

    named = [f"{plugin.distribution} {plugin.version}".rstrip() for plugin in registry.plugins() if plugin.entries]
    plugins = f", with {', '.join(named)}" if named else ""
    return f"Of shockwave {__version__}{plugins}. To be written anew when another plugin is installed."


# ---------------------------------------------------------------- blocks


def _mapping(own: Sequence[Key]) -> Form:
    """A mapping of these keys and nothing else."""
    form: Form = {
        "type": "object",
        "properties": {key.name: _value(key) for key in own},
        "additionalProperties": False,
    }
    doubled = [{"required": [key.name, other]} for key in own for other in key.instead_of]
    return form | {"not": {"anyOf": doubled}} if doubled else form


def _required(own: Sequence[Key]) -> Form:
    """What a mapping of these keys must have; empty where that is nothing."""
    substitutes = {name: key.name for key in own for name in key.instead_of}
    names = [key.name for key in own if key.required]
    either = [
        {"anyOf": [{"required": [name]}, {"required": [substitutes[name]]}]} for name in names if name in substitutes
    ]
    form: Form = {"required": [name for name in names if name not in substitutes], "allOf": either}
    return {rule: content for rule, content in form.items() if content}


def _where_profile(name: str, form: Form) -> Form:
    return {"if": {"properties": {"profile": {"const": name}}, "required": ["profile"]}, "then": form}


def _of_profile(name: str) -> tuple[Form, Form]:
    """What the block ``shock`` may hold for a profile, and what it must."""
    try:
        cls = keys.profile_class(name)
        own = keys.parameters_of(name, cls)
        has_ratio = any(key.name == "duration_ratio" for key in keys_of(cls))
    except Exception as error:  # a plugin's class may be anything
        unknown = f"parameters of {name}, which are not known ({' '.join(str(error).split())})"
        return {"properties": {"parameters": {"type": ["object", "null"], "description": unknown}}}, {}
    form, needs = _mapping(own), _required(own)
    if name == keys.RECORD:
        form["properties"]["file"]["pattern"] = _FILE
    needed = _required(keys.shock_keys(cls))
    if needs:
        needed["properties"] = {"parameters": needs}
        needed["required"] = [*needed["required"], "parameters"]
    else:
        form = _or_null(form)
    (ratio,) = (key for key in keys.shock_keys(cls) if key.name == "duration_ratio")
    return {"properties": {"duration_ratio": _value(ratio) if has_ratio else _OWN_RATIO, "parameters": form}}, needed


def _dotted(values: Form) -> Form:
    """A mapping of dotted names to ``values``."""
    names = [f"{block}.{key.name}" for block, own in keys.BLOCKS.items() for key in own]
    names.remove("shock.parameters")
    pattern = "|".join((*map(re.escape, names), r"shock\.parameters\.\w+"))
    return {
        "type": "object",
        "minProperties": 1,
        "propertyNames": {"pattern": f"^(?:{pattern}){_END}"},
        "additionalProperties": values,
    }


def _sweep() -> Form:
    form = _mapping(SWEEP)
    values = {
        "type": ["array", "object"],
        "minItems": 1,
        "properties": dict.fromkeys(("linspace", "logspace"), _SPACING),
        "additionalProperties": False,
    }
    form["properties"]["grid"] |= _dotted(values)
    form["properties"]["zip"] |= _dotted(values)
    form["properties"]["points"] |= {"type": "array", "minItems": 1, "items": _dotted({})}
    return _or_null(form) | {"anyOf": [{"required": [name]} for name in ("grid", "zip", "points")]}


def _uncertainty() -> Form:
    forms = {name: {"description": meaning} for name, meaning in FORMS.items()}
    spread = {"type": ["string", "object"], "pattern": "%", "properties": forms, "additionalProperties": False}
    # `required` accepts every value that is not a mapping
    twins = {"type": "object", "anyOf": [{"required": list(pair)} for pair in TWINS]}
    return _or_null(_dotted(spread)) | {"not": twins}


# ---------------------------------------------------------------- values


def _value(key: Key) -> Form:
    """What ``key`` may be, what it is for, and its default."""
    spec = key.spec
    if key.name == "momentum_coefficient":
        form: Form = {"anyOf": [{"enum": list(MOMENTUM_COEFFICIENTS)}, _quantity(MOMENTUM_COEFFICIENT)]}
    elif spec is not None:
        form = {"type": "array", "items": _quantity(spec)} if spec.samples else _quantity(spec)
    elif key.kind:
        form = {"type": "string", "enum": _names(key.kind)}
    else:
        form = _of_kind(key.annotation)
    if key.default is None if spec is None else spec.optional:
        form = _or_null(form)
    if key.purpose:
        form = {"description": key.purpose} | form
    stated = isinstance(key.default, str | int | float) and key.default not in (math.inf, -math.inf)
    return form | {"default": key.default} if stated else form


def _quantity(spec: Quantity) -> Form:
    """A number in the range of ``spec``, or text that begins with one; bounds count for numbers alone."""
    bounds = {
        "exclusiveMinimum": spec.above,
        "minimum": spec.at_least,
        "exclusiveMaximum": spec.below,
        "maximum": spec.at_most,
    }
    form = {name: bound for name, bound in bounds.items() if bound is not None and math.isfinite(bound)}
    positive = form.get("exclusiveMinimum", -1) >= 0 or form.get("minimum", 0) > 0
    return form | {
        "type": ["integer" if spec.whole else "number", "string"],
        "pattern": _POSITIVE if positive else _ANY_SIGN,
    }


_KINDS: Final[dict[Any, Form]] = {
    bool: {"type": "boolean"},
    float: _quantity(Quantity("", "")),
    int: _quantity(Quantity("", "", whole=True)),
    str: {"type": "string"},
}


def _of_kind(annotation: Any) -> Form:
    """What the loader takes for an annotated type; anything for one that it leaves to the constructor."""
    origin = typing.get_origin(annotation) or annotation
    members = typing.get_args(annotation)
    if origin is Literal:
        return {"enum": list(members)}
    if origin in (list, tuple, Sequence):
        return {"type": "array", "items": _of_kind(members[0]) if members else {}}
    if origin in (typing.Union, types.UnionType):
        forms = [_of_kind(member) for member in members if member is not type(None)]
        form = (forms[0] if len(forms) == 1 else {"anyOf": forms}) if all(forms) else {}
        return _or_null(form) if type(None) in members else form
    return dict(_KINDS.get(origin, {}))


def _or_null(form: Form) -> Form:
    """``form``, or nothing."""
    form = dict(form)
    kinds = form.get("type", [])
    if isinstance(kinds, str):
        kinds = [kinds]
    if kinds and "null" not in kinds:
        form["type"] = [*kinds, "null"]
    if "enum" in form and None not in form["enum"]:
        form["enum"] = [*form["enum"], None]
    if "anyOf" in form:
        form["anyOf"] = [*form["anyOf"], {"type": "null"}]
    return form


def _names(kind: str) -> list[str]:
    """Names of a registry; one that two plugins claim stands once."""
    return list(dict.fromkeys(entry.name for entry in registry.entries(kind)))
