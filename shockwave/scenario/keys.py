"""Keys: what the mappings of a scenario may hold, in one description for loader, schema and template.

A key is declared once: by the attrs field of the class that the block describes. From that field come its
type, unit, range and meaning, for the built-in classes and for those of plugins alike.
"""

from __future__ import annotations

import inspect
import re
import typing
from functools import cache
from typing import Any, Final

import attrs
from attrs import evolve, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.material import Material
from shockwave.fields import Quantity, quantity_of
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import DURATION, Shock
from shockwave.registry import load

#: The default of a key that has none, or one that a factory makes.
UNSTATED: Final = object()
#: The profile whose samples may stand in a file.
RECORD = "tabulated"
_RATIO = Quantity("", "n, whole duration over rise time", above=1)
_DIAMETER = Quantity("m", "diameter 2 R of the granules", above=0)


@frozen
class Key:
    """A key of a block.

    ``annotation`` counts where there is no ``spec``; ``default`` is what the class has, if that is a value; ``kind``
    is that of the registry whose names are its values. The key may stand in place of those that it is ``instead_of``.
    """

    name: str
    required: bool = False
    spec: Quantity | None = None
    annotation: Any = Any
    default: Any = UNSTATED
    meaning: str = ""
    kind: str = ""
    instead_of: tuple[str, ...] = ()

    @property
    def purpose(self) -> str:
        """What the key is for, in words: meaning and range."""
        spec = self.spec
        if spec is None:
            return self.meaning
        if not spec.samples:
            return f"{spec.meaning}, {spec.rule}"
        bounded = any(bound is not None for bound in (spec.above, spec.at_least, spec.below, spec.at_most))
        return f"{spec.meaning}, each {spec.rule}" if bounded else f"{spec.meaning}, {spec.unit}".rstrip(", ")


# ---------------------------------------------------------------- keys of classes


@cache
def keys_of(cls: type) -> tuple[Key, ...]:
    """What a constructor takes: the fields of an attrs class, or else the parameters of the call."""
    # A class that writes a constructor of its own has no fields, even where its base has.
    maker: Any = next(base for base in cls.__mro__ if "__init__" in vars(base))
    fields = attrs.fields(cls) if "__attrs_attrs__" in vars(maker) else ()
    specs = {field.alias: quantity_of(field) for field in fields}
    hints, meanings, keys = _hints(cls if fields else maker.__init__), _meanings(cls), []
    for name, parameter in inspect.signature(cls).parameters.items():
        if parameter.kind in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY):
            spec = specs.get(name) or (_RATIO if name == "duration_ratio" else None)
            required = parameter.default is parameter.empty
            stated = not required and parameter.default is not attrs.NOTHING
            default = parameter.default if stated else UNSTATED
            keys.append(Key(name, required, spec, hints.get(name, Any), default, meanings.get(name, "")))
    return tuple(keys)


def _hints(source: Any) -> dict[str, Any]:
    try:
        return typing.get_type_hints(source)
    except Exception:  # an annotation may name what is imported for type checkers alone
        return {}


def _meanings(cls: type) -> dict[str, str]:
    """What the numpydoc docstring of a class says of its parameters."""
    entries = re.findall(r"^(\w+(?:, \w+)*) : .*\n((?: {4}.*\n?)+)", inspect.getdoc(cls) or "", re.MULTILINE)
    return {name: " ".join(text.split()).rstrip(".") for names, text in entries for name in names.split(", ")}


def _key(cls: type, name: str, **changes: Any) -> Key:
    return evolve(next(key for key in keys_of(cls) if key.name == name), **changes)


def _needed(name: str) -> Key:
    """The key of a field of `Shock` that may come from the profile; as a value of a file it is a number."""
    spec = quantity_of(attrs.fields_dict(Shock)[name])
    assert spec is not None
    return Key(name, spec=evolve(spec, optional=False))


def _settings(cls: type) -> tuple[Key, ...]:
    kinds = {"model": "models", "quadrature": "quadratures", "integrator": "integrators"}
    return tuple(evolve(key, kind=kinds.get(key.name, "")) for key in keys_of(cls))


# ---------------------------------------------------------------- what the blocks are

SCENARIO = (
    Key("name", annotation=str, meaning="what the scenario is called; left out, the name of the file"),
    Key("chain", required=True, meaning="a mapping of material, diameter, granules"),
    Key(
        "shock",
        required=True,
        meaning="a mapping of profile, peak_force, rise_time or duration, duration_ratio, parameters",
    ),
    Key("predict", default=None, meaning="how the waves are to be predicted"),
    Key("simulate", default=None, meaning="how the scene is to be simulated"),
    Key("requires", annotation=list[str], default=None, meaning="distributions that must be installed"),
    Key("published", default=None, meaning="figures printed in a source, shown beside ours"),
    Key("sweep", default=None, meaning="a mapping of grid, zip or points: the scenario stands for many"),
    Key("uncertainty", default=None, meaning="a mapping of dotted names to how well these values are known"),
)
CHAIN = (
    Key("material", required=True, kind="materials", meaning="a name of the material library, or a mapping"),
    Key("diameter", required=True, spec=_DIAMETER),
    _key(Chain, "radius", required=False, instead_of=("diameter",)),
    _key(Chain, "granules"),
)
#: What depends on the profile is added when it is known.
SHOCK = (
    Key("profile", required=True, annotation=str, kind="profiles", meaning="a name of the profile registry"),
    _needed("peak_force"),
    _needed("rise_time"),
    Key("duration", spec=DURATION, instead_of=("rise_time",)),
    Key("duration_ratio", spec=_RATIO),
    Key("parameters", default=None, meaning="what the profile takes besides"),
)
#: Blocks whose values have dotted names, but for the parameters of the profile.
BLOCKS = {
    "chain": CHAIN,
    "chain.material": tuple(key for key in keys_of(Material) if key.spec is not None),
    "shock": SHOCK,
    "predict": _settings(Predictor),
    "simulate": _settings(SimulateOptions),
}


def profile_class(name: str) -> type[ShockProfile]:
    """The class of the profile called ``name``.

    Raises
    ------
    UnknownNameError
        When there is none.
    PluginError
        When what is registered is no complete profile class.
    """
    cls: type[ShockProfile] = load("profiles", name)
    return cls


@cache
def shock_keys(cls: type[ShockProfile] | None) -> tuple[Key, ...]:
    """Keys of the block ``shock`` for profiles of ``cls``; None stands for an unknown profile.

    What may come from a record, or may be a profile's own, is optional.
    """
    if cls is None:
        return SHOCK
    own = {key.name: key for key in keys_of(cls) if key.name == "duration_ratio"}
    for key in SHOCK:
        brought = f"recorded_{key.name}"
        if hasattr(ShockProfile, brought) and getattr(cls, brought) is getattr(ShockProfile, brought):
            own[key.name] = evolve(key, required=True)
    return tuple(own.get(key.name, key) for key in SHOCK)


@cache
def parameters_of(profile: str, cls: type[ShockProfile]) -> tuple[Key, ...]:
    """Keys of the block ``parameters``: all that the class takes besides ``duration_ratio``."""
    keys = tuple(key for key in keys_of(cls) if key.name != "duration_ratio")
    if profile != RECORD:
        return keys
    meaning = "a CSV file with a time and a force column"
    return (Key("file", annotation=str, meaning=meaning, instead_of=("times", "forces")), *keys)
