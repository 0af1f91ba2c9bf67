"""Keys of all blocks of a scenario, described once for the loader, the schema and the template.

A key is declared by an attrs field of the class that its block describes. The field gives its type, unit, range and
meaning, for built-in classes and for those of plugins alike.
"""

from __future__ import annotations

import inspect
import re
import typing
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Literal

import attrs
from attrs import evolve, frozen

from shockwave.base.quantity_fields import Converted, Declaration, declaration_of, is_plain_text
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.scenario.published_results import Published
from shockwave.scene.chain import Chain, Packing
from shockwave.scene.force_limit import Limit
from shockwave.scene.material import DIAMETER, Material
from shockwave.scene.material import WALLS as WALLS
from shockwave.scene.shock import DURATION, Shock
from shockwave.scene.simulate_options import SimulateOptions

#: The profile whose samples may come from a file.
RECORD = "tabulated"
_RATIO = Declaration("", "n, total duration over rise time", above=1, example="4")


@frozen
class Key:
    """A key of a block.

    ``annotation`` is the type of a key without a ``spec``; ``default`` is that of the constructor; ``kind`` is the
    registry whose names are its values, and ``also`` are further ones. The key may replace those in ``instead_of``, or
    one of those in ``one_of``. If it is not ``plain``, like any parameter of a plugin, its text may name a file. In
    place of another value it may be a mapping of ``keys``, the arguments of ``make``.
    """

    name: str
    required: bool = False
    spec: Declaration | None = None
    annotation: Any = Any
    default: Any = inspect.Parameter.empty
    meaning: str = ""
    kind: str = ""
    instead_of: tuple[str, ...] = ()
    one_of: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    plain: bool = True
    keys: tuple[Key, ...] = ()
    make: Callable[..., Any] = dict

    @property
    def purpose(self) -> str:
        """Meaning and range."""
        if self.spec is None:
            return self.meaning
        return f"{self.spec.meaning}, {'each ' if self.spec.samples else ''}{self.spec.rule}"

    @property
    def may_be_none(self) -> bool:
        """Whether a file may contain it without a value."""
        return self.default is None if self.spec is None else self.spec.optional


# ---------------------------------------------------------------- keys of classes


@cache
def keys_of(cls: type) -> tuple[Key, ...]:
    """Parameters of the constructor of ``cls``; for an attrs class, its fields."""
    fields = attrs.fields(cls) if attrs.has(cls) else ()
    specs = {field.alias: declaration_of(field) for field in fields}
    plain = {field.alias for field in fields if is_plain_text(field)}
    hints, meanings, keys = _hints(cls), _meanings(cls), []
    for name, parameter in inspect.signature(cls).parameters.items():
        if parameter.kind in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY):
            spec = specs.get(name) or (_RATIO if name == "duration_ratio" else None)
            default, meaning = parameter.default, meanings.get(name, "")
            key = Key(name, default is parameter.empty, spec, hints.get(name, Any), default, meaning)
            keys.append(evolve(key, plain=name in plain))
    return tuple(keys)


def _hints(cls: Any) -> dict[str, Any]:
    try:
        hints = typing.get_type_hints(cls if "__attrs_attrs__" in vars(cls) else cls.__init__)
    except Exception:  # an annotation may use a name that is imported for type checkers only
        return {}
    of_value = {name: typing.get_args(hint)[0] for name, hint in hints.items() if typing.get_origin(hint) is Converted}
    return hints | of_value


def _meanings(cls: type) -> dict[str, str]:
    """Descriptions of parameters in the numpydoc docstring of a class."""
    entries = re.findall(r"^(\w+(?:, \w+)*) : .*\n((?: {4}.*\n?)+)", inspect.getdoc(cls) or "", re.MULTILINE)
    return {name: " ".join(text.split()).rstrip(".") for names, text in entries for name in names.split(", ")}


def _key_of_field(name: str, example: str) -> Key:
    """Key of a field of `Shock` that may come from the profile; in a file it is a number."""
    spec = declaration_of(attrs.fields_dict(Shock)[name])
    assert spec is not None
    return Key(name, spec=evolve(spec, optional=False, example=example))


def _optional(name: str, cls: type, meaning: str) -> Key:
    """Key of an optional block, which describes an instance of ``cls``."""
    kinds = {"quadrature": "quadratures", "integrator": "integrators"}
    keys = tuple(evolve(key, kind=kinds.get(key.name, "")) for key in keys_of(cls))
    return Key(name, default=None, meaning=meaning, keys=keys, make=cls)


def name_of_material(key: Key) -> Key:
    """The key of a material whose value is a name."""
    return evolve(key, annotation=str, keys=())


def has_chain_blocks(data: Mapping[str, Any]) -> bool:
    """Whether a document has blocks for chains beyond equal spheres."""
    chain = data.get("chain")
    block = chain if isinstance(chain, dict) else {}
    return (
        not data.keys().isdisjoint(("impact", "motion"))
        or isinstance(block.get("granules"), list)
        or not block.keys().isdisjoint(CHAIN_BLOCKS)
    )


# ---------------------------------------------------------------- keys of blocks

_Version = Literal[1]
#: Versions of the format of scenarios that are read; a scenario without the key has the first one.
VERSIONS: tuple[int, ...] = typing.get_args(_Version)
SCENARIO = (
    Key("version", annotation=_Version, default=VERSIONS[0], meaning="version of the format of scenarios"),
    Key("name", annotation=str, meaning="name of the scenario; if omitted, the name of the file"),
    Key("chain", required=True, meaning="a mapping of material, diameter, granules, and further features"),
    Key("shock", required=True, meaning="a mapping of profile, peak_force, rise_time, duration_ratio, parameters"),
    Key("impact", meaning="a striker: a mapping of velocity, diameter, material", instead_of=("shock",)),
    Key("motion", meaning="a prescribed motion of the first granule", instead_of=("shock", "impact")),
    _optional("predict", Predictor, "settings of the prediction"),
    _optional("simulate", SimulateOptions, "settings of the simulation"),
    _optional("limit", Limit, "a mapping of force: the limit on the transmitted force"),
    Key("requires", annotation=list[str], default=None, meaning="Python packages that must be installed"),
    _optional("published", Published, "results printed in a source, shown beside those of shockwave"),
    Key("sweep", default=None, meaning="a mapping of grid, zip or points, for many cases"),
    Key("uncertainty", default=None, meaning="a mapping of dotted names to probability distributions"),
)
#: Key of a material: a name, or a mapping of its constants.
MATERIAL = Key("material", kind="materials", meaning="a name or a mapping", keys=keys_of(Material), make=Material)
_CHAIN = {key.name: key for key in keys_of(Chain)}
GRANULES = _CHAIN["granules"]
CHAIN = (
    evolve(MATERIAL, required=True, meaning="a name from `shockwave list materials`, or a mapping"),
    Key("diameter", required=True, spec=DIAMETER),
    evolve(_CHAIN["radius"], required=False, instead_of=("diameter",)),
    GRANULES,
    Key("end", default="free", meaning="free, or a mapping of wall, mass, stiffness, damping"),
    _CHAIN["precompression"],
    _CHAIN["gravity"],
    Key("damping", default=None, meaning="a mapping of model and its parameters"),
    evolve(_CHAIN["packing"], annotation=Packing, meaning="packing in which a plane wave travels"),
    Key("contact", default=None, meaning="exponent and stiffness, or model and its parameters; if omitted, Hertz's"),
    evolve(_CHAIN["elastic_only"], annotation=bool),
)
#: Keys of the ``chain`` block that have blocks of their own; ``granules`` has one if it is a list.
CHAIN_BLOCKS = ("end", "damping", "contact")
#: Last parts of the dotted names of materials.
MATERIALS = ("material", "wall")
#: Keys for an unknown profile; `shock_keys` gives those for a known one.
SHOCK = (
    Key("profile", required=True, annotation=str, kind="profiles", meaning="a name from `shockwave list profiles`"),
    _key_of_field("peak_force", "30 N"),
    _key_of_field("rise_time", "15 us"),
    Key("duration", spec=evolve(DURATION, example="60 us"), one_of=("rise_time", "duration_ratio")),
    Key("duration_ratio", spec=_RATIO),
    Key("parameters", default=None, meaning="parameters of the profile"),
)
#: Blocks whose values have dotted names, without the parameters of the profile.
BLOCKS = {
    "chain": (name_of_material(CHAIN[0]), *(key for key in CHAIN[1:] if key.name not in CHAIN_BLOCKS)),
    "chain.material": tuple(key for key in keys_of(Material) if key.spec is not None),
    "shock": SHOCK,
    **{key.name: key.keys for key in SCENARIO if key.name in ("predict", "simulate")},
}


# Advice on other words for keys.
_INSTEAD = dict.fromkeys(("beads", "balls", "spheres", "particles"), "did you mean 'granules'?")
_INSTEAD |= dict.fromkeys(("striker", "impactor", "projectile"), "did you mean 'impact'?")
_INSTEAD["mass"] = "give density of the material, and diameter or radius"


def paths_of(name: str) -> list[str]:
    """Dotted names of the keys of this name."""
    return [f"{block}.{name}" for block, keys in BLOCKS.items() for key in keys if key.name == name]


def hint_instead_of(name: str) -> str:
    """Advice on a name that is no key but is often taken for one; else empty."""
    if name.endswith((".contact.model", ".damping.model")):
        return "the model of a block cannot be varied; run a scenario with each"
    if name.startswith(("motion.times", "motion.values", "motion.scale")):
        return "samples in the scenario cannot be varied; state a file of them, and vary motion.scale"
    return _INSTEAD.get(name, "")


@cache
def shock_keys(cls: type[ShockProfile] | None) -> tuple[Key, ...]:
    """Keys of the ``shock`` block for profiles of the class ``cls``, or for an unknown profile if it is None.

    A value that the profile may define itself, as a record does, is optional.
    """
    if cls is None:
        return SHOCK
    replaced = {key.name: key for key in keys_of(cls) if key.name == "duration_ratio"}
    for key in SHOCK:
        recorded = f"recorded_{key.name}"
        if hasattr(ShockProfile, recorded) and getattr(cls, recorded) is getattr(ShockProfile, recorded):
            replaced[key.name] = evolve(key, required=True)
    return tuple(replaced.get(key.name, key) for key in SHOCK)


@cache
def parameters_of(profile: str, cls: type[ShockProfile]) -> tuple[Key, ...]:
    """Keys of the ``parameters`` block: the parameters of ``cls`` except ``duration_ratio``."""
    keys = tuple(key for key in keys_of(cls) if key.name != "duration_ratio")
    if profile != RECORD:
        return keys
    from shockwave.records.record_format import RecordFormat  # a scenario without a record does not need it

    meaning = "a CSV file with a time and a force column"
    file = Key("file", annotation=str, meaning=meaning, instead_of=("times", "forces"), plain=False)
    return (file, *keys_of(RecordFormat), *keys)
