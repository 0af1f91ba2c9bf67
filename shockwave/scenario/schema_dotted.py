"""Schema of the blocks whose keys are dotted names of other keys, and of what may then be left to them."""

from __future__ import annotations

import re
from typing import Any

from shockwave.chain.material import Material
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.scenario.blocks import CHAIN, SHOCK, keys_of
from shockwave.scenario.sweep import RUNS, SWEEP
from shockwave.scenario.uncertainty import FORMS, TWINS

__all__ = ["parted", "sweep", "uncertainty"]

Form = dict[str, Any]
_BLOCKS = {
    "chain": CHAIN,
    "chain.material": keys_of(Material, leave_out=["name", "source"]),
    "shock": [key for key in SHOCK if key.name != "parameters"],
    "predict": keys_of(Predictor),
    "simulate": keys_of(SimulateOptions),
}
_NAMES = [re.escape(f"{block}.{key.name}") for block, keys in _BLOCKS.items() for key in keys]
_END = r"(?![\s\S])"


def dotted(values: Form) -> Form:
    """A mapping of dotted names to ``values``."""
    names = "|".join((*_NAMES, r"shock\.parameters\.\w+"))
    return {
        "type": "object",
        "minProperties": 1,
        "propertyNames": {"pattern": f"^(?:{names}){_END}"},
        "additionalProperties": values,
    }


def sweep() -> Form:
    """The block ``sweep``."""
    ends: Form = {"type": ["number", "string"]}
    spaced: Form = {
        "type": "array",
        "items": [ends, ends, {"type": "integer", "minimum": 1}],
        "minItems": 3,
        "maxItems": 3,
    }
    values: Form = {
        "anyOf": [
            {"type": "array", "minItems": 1},
            {
                "type": "object",
                "properties": {
                    "linspace": {"description": "first, last, number", **spaced},
                    "logspace": {"description": "first, last, number: equal ratios between them", **spaced},
                },
                "additionalProperties": False,
                "minProperties": 1,
                "maxProperties": 1,
            },
        ]
    }
    forms: dict[str, Form] = {
        "run": {"enum": list(RUNS)},
        "grid": dotted(values),
        "zip": dotted(values),
        "points": {"type": "array", "minItems": 1, "items": dotted({})},
    }
    return {
        "type": ["object", "null"],
        "properties": {key.name: {"description": key.meaning, **forms[key.name]} for key in SWEEP},
        "additionalProperties": False,
        "anyOf": [{"required": [name]} for name in ("grid", "zip", "points")],
    }


def uncertainty() -> Form:
    """The block ``uncertainty``."""
    number: Form = {"type": ["number", "string"]}
    forms: dict[str, Form] = dict.fromkeys(FORMS, number)
    forms["between"] = {"type": "array", "items": number, "minItems": 2, "maxItems": 2}
    mapping = {
        "type": "object",
        "properties": {name: {"description": meaning, **forms[name]} for name, meaning in FORMS.items()},
        "additionalProperties": False,
        "minProperties": 1,
        "maxProperties": 1,
    }
    percent = {"type": "string", "pattern": rf"%\s*{_END}", "description": "standard deviation over the value"}
    return {
        **dotted({"anyOf": [percent, mapping]}),
        "type": ["object", "null"],
        # `required` accepts every value that is not a mapping
        "not": {"type": "object", "anyOf": [{"required": list(pair)} for pair in TWINS]},
    }


def parted(form: Form) -> tuple[Form, Form]:
    """``form`` without what it requires, which a sweep may bring; and that alone."""
    rest: Form = {}
    needs: Form = {}
    for name, inner in form.items():
        if name == "required" or (name in ("anyOf", "oneOf") and all("required" in one for one in inner)):
            needs[name] = inner
        elif name == "anyOf":
            both = [parted(one) for one in inner]
            rest[name] = [form for form, _ in both]
            if any(own for _, own in both):
                # what needs nothing is told from the others by its type
                pairs = zip(inner, both, strict=True)
                needs[name] = [own or {key: one[key] for key in ("type",) if key in one} for one, (_, own) in pairs]
        elif name in ("properties", "allOf", "then"):
            rest[name], needs[name] = _parted(inner)
        else:
            rest[name] = inner
    needs = {name: inner for name, inner in needs.items() if inner}
    if "if" in form and needs:
        needs["if"] = form["if"]
    return rest, needs


def _parted(inner: Any) -> tuple[Any, Any]:
    if isinstance(inner, list):
        both = [parted(one) for one in inner]
        return [rest for rest, _ in both], [needs for _, needs in both if needs]
    if all(isinstance(one, dict) for one in inner.values()) and "properties" not in inner:
        found = {name: parted(one) for name, one in inner.items()}
        return {name: rest for name, (rest, _) in found.items()}, {n: needs for n, (_, needs) in found.items() if needs}
    return parted(inner)
