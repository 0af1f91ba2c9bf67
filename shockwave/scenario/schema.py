"""Schema: what a scenario may hold, as JSON Schema (draft-07), for editors.

It is derived from the declarations that the loader reads, and admits whatever the loader does. What a schema
cannot express is left to the loader: units, files, and rules over several values.
"""

from __future__ import annotations

import json
import math
import types
import typing
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final, Literal

from shockwave import OWN_DISTRIBUTION, registry
from shockwave.chain.material import Material
from shockwave.errors import InvalidValueError, ShockwaveError
from shockwave.fields import Quantity
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import MOMENTUM_COEFFICIENT, MOMENTUM_COEFFICIENTS, Predictor
from shockwave.scenario.blocks import (
    CHAIN,
    RECORD,
    SCENARIO,
    SHOCK,
    UNSTATED,
    Key,
    Published,
    keys_of,
    parameters_of,
    profile_class,
    shock_keys,
)
from shockwave.scenario.load import DISTRIBUTION
from shockwave.scenario.schema_dotted import parted, sweep, uncertainty
from shockwave.scenario.template import purpose_of, within

__all__ = ["schema"]

_DRAFT = "http://json-schema.org/draft-07/schema#"
_ABOUT = (
    "One shock on one chain of equal elastic spheres. A bare number is in SI units; text is a number with a unit"
    " of the same dimension, such as 15 us."
)
#: Keys whose value is a name -> where it is registered.
_REGISTRIES = {singular: kind for kind, singular in registry.KINDS.items()}
_OWN_RATIO: Final = {"not": {}, "description": "to be left out, as the profile has its own"}
#: Stands for a name that is left out.
_LEFT_OUT: Final = None

# A unit is not looked at: there are more spellings than a pattern can hold.
_NUMBER_PATTERN = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]{1,4})?"
_UNIT_START = r"(?:1\s*)?/|[(A-Za-zµμ°%Ω_]"
_ANY_SIGN, _POSITIVE = "[-+]?", r"\+?(?=[0.]*[1-9])"
# `$` would also match before a line break at the end.
_END = r"(?![\s\S])"
_LINE = rf"^[^\n]*\S[^\n]*{_END}"
_FILE = rf"^(?!/)[\s\S]*\S[\s\S]*{_END}"

Form = dict[str, Any]


def schema() -> Form:
    """The JSON Schema of a scenario with what is installed, plugins included.

    Returns
    -------
    dict
        Plain data for `json.dumps`, the same for the same installation. A profile that cannot be imported may be
        named in a scenario, with any parameters.
    """
    keys = SCENARIO
    blocks = {
        "name": {"pattern": _LINE},
        "chain": _chain(),
        "shock": _shock(),
        "predict": _options(Predictor),
        "simulate": _options(SimulateOptions),
        "requires": {"items": {"type": "string", "pattern": f"^(?:{DISTRIBUTION.pattern}){_END}"}},
        "published": _mapping(keys_of(Published)),
        "sweep": sweep(),
        "uncertainty": uncertainty(),
    }
    forms = {key.name: {**_value(key), **blocks[key.name]} for key in keys}
    # An optional block that holds nothing is taken for one that is left out.
    spare = [key.name for key in keys if not key.required and key.annotation is not str]
    forms |= {name: _or_null(forms[name]) for name in spare}
    brought = {name: parted(forms[name]) for name in ("chain", "shock")}
    needed = _mapping(keys)["required"]
    return {
        "$schema": _DRAFT,
        "$comment": _installed(),
        "title": "Scenario of shockwave",
        "description": _ABOUT,
        "type": "object",
        "properties": forms | {name: rest for name, (rest, _) in brought.items()},
        "additionalProperties": False,
        # the scenes of a sweep may have from it what is missing here
        "if": {"properties": {"sweep": {"type": "object"}}, "required": ["sweep"]},
        "else": {"required": needed, "properties": {name: needs for name, (_, needs) in brought.items()}},
    }


def _installed() -> str:
    from shockwave import __version__

    named = [f"{plugin.distribution} {plugin.version}".rstrip() for plugin in registry.plugins() if plugin.entries]
    plugins = f", with {', '.join(named)}" if named else ""
    return f"Of shockwave {__version__}{plugins}. To be written anew when another plugin is installed."


# ---------------------------------------------------------------- blocks


def _mapping(keys: Sequence[Key], properties: Mapping[str, Form] | None = None) -> Form:
    """A mapping of ``keys`` and nothing else; ``properties`` take the place of what is declared of them."""
    forms = properties if properties is not None else {key.name: _value(key) for key in keys}
    required = [key.name for key in keys if key.required]
    form: Form = {"type": "object", "properties": dict(forms), "additionalProperties": False}
    return {**form, "required": required} if required else form


def _chain() -> Form:
    forms = {key.name: _value(key) for key in CHAIN}
    forms["material"] = {
        "description": forms["material"]["description"],
        "anyOf": [_names("materials"), _mapping(keys_of(Material))],
    }
    return {**_mapping(CHAIN, forms), "oneOf": [{"required": ["diameter"]}, {"required": ["radius"]}]}


def _shock() -> Form:
    forms = {key.name: _value(key) for key in SHOCK}
    # These two depend on the profile.
    forms |= {name: {"description": forms[name]["description"]} for name in ("duration_ratio", "parameters")}
    forms["profile"] |= _names("profiles")
    return {
        **_mapping(SHOCK, forms),
        "not": {"required": ["rise_time", "duration"]},
        "allOf": [
            {"if": {"properties": {"profile": {"const": name}}, "required": ["profile"]}, "then": _of_profile(name)}
            for name in _summaries("profiles")
        ],
    }


def _of_profile(name: str) -> Form:
    """What the block ``shock`` must hold besides for the profile called ``name``."""
    try:
        cls = profile_class(name)
        keys, own = {key.name: key for key in shock_keys(cls)}, keys_of(cls)
        parameters = _parameters(name, parameters_of(name, cls), own)
    except Exception as error:  # a plugin's class may be anything
        unknown = f"parameters of {name}, which are not known ({' '.join(str(error).split())})"
        return {"properties": {"parameters": {"type": ["object", "null"], "description": unknown}}}
    has_ratio = any(key.name == "duration_ratio" for key in own)
    ratio = _value(keys["duration_ratio"]) if has_ratio else _OWN_RATIO
    needed = [key for key in ("peak_force", "duration_ratio") if keys[key].required]
    needed += ["parameters"] if "null" not in parameters["type"] else []
    form: Form = {"properties": {"duration_ratio": ratio, "parameters": parameters}, "required": needed}
    if keys["rise_time"].required:
        form["anyOf"] = [{"required": ["rise_time"]}, {"required": ["duration"]}]
    return form


def _parameters(profile: str, keys: Sequence[Key], own: Sequence[Key]) -> Form:
    """The block ``parameters``, which may be empty where nothing is required."""
    form = _mapping(keys, {key.name: _value(key, own=False) for key in keys})
    if profile != RECORD:
        return form if "required" in form else _or_null(form)
    form["properties"]["file"] |= {"pattern": _FILE}
    samples = [key.name for key in own if key.required]
    beside = {"anyOf": [{"required": [name]} for name in samples]}
    return {
        **form,
        "oneOf": [{"required": ["file"], "not": beside}, {"required": samples, "not": {"required": ["file"]}}],
    }


# ---------------------------------------------------------------- options


def _options(cls: type) -> Form:
    """A block of options, each as far as it goes with the name of a method that stands beside it."""
    keys = keys_of(cls)
    forms = {key.name: _value(key) for key in keys}
    if "momentum_coefficient" in forms:
        forms["momentum_coefficient"] |= {
            "anyOf": [{"enum": list(MOMENTUM_COEFFICIENTS)}, _quantity(MOMENTUM_COEFFICIENT)]
        }
    rules: list[Form] = []
    for key in keys:
        if key.name in _REGISTRIES:
            rules += _rules(cls, key, keys, forms)
    form = _mapping(keys, forms)
    return {**form, "allOf": rules} if rules else form


def _rules(cls: type, method: Key, keys: Sequence[Key], forms: dict[str, Form]) -> Iterator[Form]:
    """What the other settings may be for each name of ``method``, as the constructor of ``cls`` has it.

    A setting that fits no name at all is changed in ``forms``.
    """
    choices = [_LEFT_OUT, *_summaries(_REGISTRIES[method.name])]
    several = any(key.name in _REGISTRIES for key in keys if key is not method)
    for key in keys:
        if key.name == method.name or key.name in _REGISTRIES:
            continue
        groups: dict[str, tuple[Form, list[str | None]]] = {}
        for choice in choices:
            narrowed = _narrowed(cls, {} if choice is _LEFT_OUT else {method.name: choice}, key)
            if narrowed:
                groups.setdefault(json.dumps(narrowed), (narrowed, []))[1].append(choice)
        for narrowed, named in groups.values():
            if named == choices:
                if several:  # it goes with the other one
                    continue
                forms[key.name] = {**narrowed, "description": forms[key.name]["description"]}
                continue
            test: Form = {"properties": {method.name: {"enum": named}}}
            if _LEFT_OUT not in named:
                test["required"] = [method.name]
            yield {"if": test, "then": {"properties": {key.name: narrowed}}}


def _narrowed(cls: type, beside: Mapping[str, Any], key: Key) -> Form:
    """What is left of the values of ``key`` beside these settings; nothing, where all of them are."""
    choices = _choices(key.annotation)
    values = choices or _numbers(key)
    refused = [value for value in values if _refuses(cls, beside, key.name, value)]
    if not refused or (not choices and len(refused) < len(values)):
        return {}
    left = [value for value in values if value not in refused]
    return {"enum": left} if left else {"type": "null", "description": "to be left out, as it would have no effect"}


def _numbers(key: Key) -> tuple[float, ...]:
    if key.spec is not None:
        return (within(key.spec),)
    # Without a range there is no telling which would be taken: several are tried.
    return (1e-6, 0.5, 1.0, 10.0) if float in typing.get_args(key.annotation) else ()


def _refuses(cls: Any, beside: Mapping[str, Any], name: str, value: Any) -> bool:
    try:
        cls(**beside, **{name: value})
    except InvalidValueError as error:
        return any(fault.path == name for fault in error.faults)
    except ShockwaveError:  # two plugins claim the name beside it
        return False
    return False


# ---------------------------------------------------------------- names


def _summaries(kind: str) -> dict[str, str]:
    """Names of a registry, each with what is said of it; one that two plugins claim stands once."""
    found: dict[str, str] = {}
    for entry in registry.entries(kind):
        own = entry.distribution == OWN_DISTRIBUTION
        found.setdefault(entry.name, entry.summary if own else f"{entry.summary} (from {entry.distribution})".strip())
    return found


def _names(kind: str) -> Form:
    found = _summaries(kind)
    return {"type": "string", "enum": list(found), "enumDescriptions": list(found.values())}


# ---------------------------------------------------------------- values


def _value(key: Key, own: bool = True) -> Form:
    """What ``key`` may be; ``own`` is False for parameters of profiles."""
    spec = key.spec
    if spec is not None:
        form = _samples(spec) if spec.samples else _quantity(spec)
    else:
        form = _names(_REGISTRIES[key.name]) if own and key.name in _REGISTRIES else _of_kind(key.annotation)
        form = _or_null(form) if key.default is None else form
    told = {"description": purpose_of(key, own)}
    return {**told, **form, **_default(key)} if told["description"] else {**form, **_default(key)}


def _default(key: Key) -> Form:
    if key.required or key.default is None or key.default is UNSTATED:
        return {}
    try:
        return {"default": json.loads(json.dumps(key.default, allow_nan=False))}
    except (TypeError, ValueError):  # a plugin's default may be anything
        return {}


def _quantity(spec: Quantity) -> Form:
    """A number in the range of ``spec``, or text that begins with one; bounds count for numbers alone."""
    positive = (spec.above is not None and spec.above >= 0) or (spec.at_least is not None and spec.at_least > 0)
    sign = _POSITIVE if positive else _ANY_SIGN
    bounds = {
        "exclusiveMinimum": spec.above,
        "minimum": spec.at_least,
        "exclusiveMaximum": spec.below,
        "maximum": spec.at_most,
    }
    form: Form = {
        "type": ["integer" if spec.whole else "number", "string"],
        **{name: bound for name, bound in bounds.items() if bound is not None and math.isfinite(bound)},
        "pattern": rf"^\s*{sign}{_NUMBER_PATTERN}\s*(?:{_UNIT_START}|{_END})",
    }
    return _or_null(form) if spec.optional else form


def _samples(spec: Quantity) -> Form:
    form: Form = {"type": "array", "items": _quantity(spec)}
    return _or_null(form) if spec.optional else form


_KINDS: Final[dict[Any, Form]] = {
    bool: {"type": "boolean"},
    float: _quantity(Quantity("", "")),
    int: _quantity(Quantity("", "", whole=True)),
    str: {"type": "string"},
}


def _of_kind(annotation: Any) -> Form:
    """What the loader takes for an annotated type; anything for one that it leaves to the constructor."""
    origin, members = typing.get_origin(annotation) or annotation, typing.get_args(annotation)
    if origin is Literal:
        return {"enum": list(_choices(annotation))}
    if origin in (list, tuple, Sequence):
        return {"type": "array", "items": _of_kind(members[0]) if members else {}}
    if origin in (typing.Union, types.UnionType):
        return _any_of(members)
    return dict(_KINDS.get(origin, {}))


def _any_of(members: Iterable[Any]) -> Form:
    forms = [_of_kind(member) for member in members if member is not type(None)]
    if not all(forms):
        return {}
    form = forms[0] if len(forms) == 1 else {"anyOf": forms}
    return _or_null(form) if type(None) in members else form


def _choices(annotation: Any) -> tuple[Any, ...]:
    """The values of an annotated choice, optional or not."""
    if typing.get_origin(annotation) is Literal:
        return typing.get_args(annotation)
    return next(filter(None, map(_choices, typing.get_args(annotation))), ()) if _is_union(annotation) else ()


def _is_union(annotation: Any) -> bool:
    return typing.get_origin(annotation) in (typing.Union, types.UnionType)


def _or_null(form: Form) -> Form:
    """``form``, or nothing."""
    form = dict(form)
    if "type" in form:
        kinds = form["type"] if isinstance(form["type"], list) else [form["type"]]
        form["type"] = [*kinds, *(["null"] if "null" not in kinds else [])]
    for choices, nothing in (("enum", None), ("enumDescriptions", "left out"), ("anyOf", {"type": "null"})):
        if choices in form and nothing not in form[choices]:
            form[choices] = [*form[choices], nothing]
    return form
