"""JSON Schema (draft-07) of the keys of a scenario and their values, for editors.

It is derived from the keys of the loader and accepts everything that the loader accepts. It states the keys, their
meaning, and the types, ranges and names of their values. Which keys are needed, and rules on units and on files, are
left to ``shockwave validate``.
"""

from __future__ import annotations

import math
import re
import types
import typing
from collections.abc import Sequence
from typing import Any, Final, Literal

from shockwave import __version__
from shockwave.base.quantity_fields import Declaration
from shockwave.registry import registry
from shockwave.scenario.block_keys import BLOCKS, CHAIN, SCENARIO, SHOCK, Key, keys_of, parameters_of
from shockwave.scenario.chain_blocks import BAR_END, CELL, END, IMPACT, LAWS, MODEL, MOTION, SEGMENT, models
from shockwave.scenario.sweep_block import SWEEP

_DRAFT = "http://json-schema.org/draft-07/schema#"
_ABOUT = (
    "One shock or impact on one chain of elastic spheres. A bare number is in SI units; a value with a unit,"
    " such as 15 us, is converted."
)
# Beginning of the text of a quantity. Units are not checked: a pattern cannot cover all their spellings.
_NUMBER = "^\\s*[-+\N{MINUS SIGN}]?\\.?[0-9]"

_BOUNDS = {"exclusiveMinimum": "above", "minimum": "at_least", "exclusiveMaximum": "below", "maximum": "at_most"}
Form = dict[str, Any]
# Keys of a sensor at a contact or in a granule.
_SENSOR: Form = {
    "contact": {"type": "integer"},
    "granule": {"type": "integer"},
    "quantity": {"enum": ["force", "velocity", "displacement"]},
}


def schema() -> Form:
    """JSON Schema of a scenario, including installed plugins.

    Returns
    -------
    dict
        Plain data for `json.dumps`, the same for the same installation. A profile that cannot be imported is accepted
        with any parameters.
    """
    forms = {key.name: _value(key) for key in SCENARIO}
    forms["chain"] |= _chain()
    forms["impact"] |= _mapping(IMPACT)
    forms["motion"] |= _mapping(MOTION)
    forms["shock"] |= _mapping(SHOCK)
    forms["shock"]["allOf"] = [_form_where("profile", name, _shock_form(name)) for name in _names("profiles")]
    forms["sweep"] |= _allow_null(_mapping(SWEEP))
    sensor = {"anyOf": [*_names_in_any_case(["wall", "structure"]), {"type": "object", "properties": _SENSOR}]}
    forms["simulate"]["properties"]["sensors"]["items"] = sensor
    for part in ("grid", "zip"):
        forms["sweep"]["properties"][part] |= _dotted()
    forms["sweep"]["properties"]["points"] |= {"type": "array", "minItems": 1, "items": _dotted()}
    forms["uncertainty"] |= _allow_null(_dotted())
    return {
        "$schema": _DRAFT,
        "$comment": f"Written by shockwave {__version__}. Write it again after the installation of a plugin.",
        "title": "shockwave scenario",
        "description": _ABOUT,
        "type": "object",
        "properties": forms,
        "additionalProperties": False,
    }


# ---------------------------------------------------------------- chains beyond equal spheres


def _chain() -> Form:
    """Values of the ``chain`` block."""
    form = _mapping(CHAIN)
    properties = form["properties"]
    cell = _mapping(CELL)
    cell["properties"]["cell"] |= {"type": "array", "minItems": 1, "items": _segment()}
    parts = {"type": "array", "minItems": 1, "items": {"anyOf": [_segment(), cell]}}
    granules = properties["granules"]
    description = {"description": f"{granules.pop('description')}; or a list of segments, struck end first"}
    properties["granules"] = description | {"anyOf": [granules, parts]}
    properties["end"] |= {"anyOf": [*_names_in_any_case(["free"]), _KINDS[type(None)], *map(_mapping, (END, BAR_END))]}
    for block in LAWS:
        properties[block] |= _laws(block)
    return form


def _laws(block: str) -> Form:
    """Contact laws or dampings."""
    laws = [_form_where("model", name, _mapping(_law(name))) for name in models(block)]
    named = {"properties": {"model": {"anyOf": _names_in_any_case(models(block))}}}
    return {"type": ["object", "null"], "allOf": [named, *laws]}


def _segment() -> Form:
    form = _mapping(SEGMENT)
    for block in LAWS:
        form["properties"][block] |= _laws(block)
    return form


def _law(name: str) -> tuple[Key, ...]:
    """Keys of a block that names a contact law; the model alone if its class cannot be imported."""
    try:
        return (MODEL, *keys_of(registry.load("contacts", name)))
    except Exception:  # a plugin's class may be anything
        return (MODEL,)


# ---------------------------------------------------------------- blocks


def _mapping(keys: Sequence[Key]) -> Form:
    """A mapping with these keys only."""
    return {"type": "object", "properties": {key.name: _value(key) for key in keys}, "additionalProperties": False}


def _form_where(key: str, name: str, form: Form) -> Form:
    """``form`` for mappings in which ``key`` has this name."""
    condition = {"type": "object", "properties": {key: _names_in_any_case([name])[1]}, "required": [key]}
    return {"if": condition, "then": form}


def _shock_form(name: str) -> Form:
    """Values that the ``shock`` block admits for a profile."""
    try:
        cls = registry.load("profiles", name)
        ratios = [key for key in keys_of(cls) if key.name == "duration_ratio"]
        parameters = _allow_null(_mapping(parameters_of(name, cls)))
        return {
            "properties": {"duration_ratio": _value(ratios[0]) if ratios else {"not": {}}, "parameters": parameters}
        }
    except Exception as error:  # a plugin's class may be anything
        unknown = f"parameters of {name}, which are unknown ({' '.join(str(error).split())})"
        return {"properties": {"parameters": {"type": ["object", "null"], "description": unknown}}}


def _dotted() -> Form:
    """A mapping of dotted names."""
    blocks = "|".join(map(re.escape, (*BLOCKS, "shock.parameters")))
    place = rf"({blocks}|impact|motion|chain\.({'|'.join(LAWS)}|end)|chain\.granules\[[0-9]+\](\.cell\[[0-9]+\])?)"
    # a material or a taper may be a mapping
    return {"type": "object", "propertyNames": {"pattern": rf"^{place}\.\w+$|^{place}\.(\w+)\.\w+$"}}


# ---------------------------------------------------------------- values


def _value(key: Key) -> Form:
    """Values of ``key``, its meaning and its default."""
    spec = key.spec
    if spec is not None:
        form: Form = {"type": "array", "items": _quantity(spec)} if spec.samples else _quantity(spec)
    elif key.kind:
        form = {"anyOf": _names_in_any_case([*key.also, *_names(key.kind)])}
    else:
        form = _kind_form(key.annotation)
    mappings = [_mapping(key.keys)] if key.keys else []
    form = form or (mappings.pop() if mappings else {})
    if key.may_be_none:
        form = _allow_null(form)
    if mappings:
        form = {"anyOf": [*form.get("anyOf", [form]), *mappings]}
    if key.purpose:
        form = {"description": key.purpose} | form
    stated = isinstance(key.default, str | int | float) and key.default not in (math.inf, -math.inf)
    return form | {"default": key.default} if stated else form


def _names_in_any_case(names: list[str]) -> list[Form]:
    """These names, which an editor proposes, or the same in another case."""
    spelt = ("".join(f"[{c.lower()}{c.upper()}]" if c.isalpha() else re.escape(c) for c in name) for name in names)
    return [{"enum": names}, {"type": "string", "pattern": f"^({'|'.join(spelt)})$"}]


def _quantity(spec: Declaration) -> Form:
    """A number in the range of ``spec``, or text that begins with a number; bounds apply to numbers only."""
    bounds = {name: getattr(spec, bound) for name, bound in _BOUNDS.items()}
    form: Form = {name: bound for name, bound in bounds.items() if bound is not None}
    return form | {"type": ["integer" if spec.whole else "number", "string"], "pattern": _NUMBER}


_KINDS: Final[dict[Any, Form]] = {
    bool: {"type": "boolean"},
    float: _quantity(Declaration("", "")),
    int: _quantity(Declaration("", "", whole=True)),
    str: {"type": "string"},
    type(None): {"type": "null"},
}


def _kind_form(annotation: Any) -> Form:
    """Values that the loader accepts for an annotated type; any value if it leaves the check to the constructor."""
    origin = typing.get_origin(annotation) or annotation
    members = typing.get_args(annotation)
    if origin is Literal:
        names = [member for member in members if isinstance(member, str)]
        return {"anyOf": _names_in_any_case(names)} if names else {"enum": list(members)}
    if origin in (list, tuple, Sequence):
        return {"type": "array", "items": _kind_form(members[0]) if members else {}}
    if origin in (typing.Union, types.UnionType):
        forms = [_kind_form(member) for member in members]
        return {"anyOf": forms} if all(forms) else {}
    return dict(_KINDS.get(origin, {}))


def _allow_null(form: Form) -> Form:
    """``form``, or nothing."""
    kinds = form.get("type")
    if kinds is None:
        return {"anyOf": [form, _KINDS[type(None)]]} if form else {}
    return form | {"type": [*([kinds] if isinstance(kinds, str) else kinds), "null"]}


def _names(kind: str) -> list[str]:
    """Names of a registry, without repetition."""
    return list(dict.fromkeys(entry.name for entry in registry.entries(kind)))
