"""Blocks: what the mappings of a scenario may hold.

A key is declared once: by the attrs field of the class that the block describes. From that field come its
type, unit, range and meaning, for the built-in classes and for those of plugins alike.
"""

from __future__ import annotations

import inspect
import typing
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, Final, Literal

import attrs
from attrs import frozen

from shockwave.chain.chain import Chain
from shockwave.fields import Quantity, quantity, quantity_of
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import DURATION, Shock
from shockwave.registry import load

__all__ = [
    "CHAIN",
    "RECORD",
    "SCENARIO",
    "SHOCK",
    "UNSTATED",
    "Key",
    "Published",
    "keys_of",
    "parameters_of",
    "profile_class",
    "shock_keys",
]

#: The default of a key that has none, or one that a factory makes.
UNSTATED: Final = object()
#: The profile whose samples may stand in a file.
RECORD = "tabulated"
_RATIO = Quantity("", "n, whole duration over rise time", above=1)


@frozen
class Key:
    """A key of a block.

    ``annotation`` counts where there is no ``spec``; ``default`` is what the class has, if that is a value.
    """

    name: str
    required: bool = False
    spec: Quantity | None = None
    annotation: Any = Any
    default: Any = UNSTATED
    meaning: str = ""

    @property
    def purpose(self) -> str:
        """What the key is for, in words: meaning and range."""
        if self.spec is None:
            return self.meaning
        return f"{self.spec.meaning}, {self.spec.rule}" if not self.spec.samples else self.spec.meaning


# ---------------------------------------------------------------- what the blocks are


@frozen(kw_only=True)
class Published:
    """Figures printed in a source for the same scene, to be shown beside ours.

    Parameters
    ----------
    source : str
        Where they are printed.
    relation : "less", "equal" or "greater", optional
        Primary's peak force against the shock's.
    virtual_rise_time : float, optional
        [s].
    error : float, optional
        Relative error of the peak force.
    """

    source: str
    relation: Literal["less", "equal", "greater"] | None = None
    virtual_rise_time: float | None = quantity("s", "virtual rise time", above=0, optional=True, default=None)
    error: float | None = quantity("", "relative error of the peak force", optional=True, default=None)


def keys_of(cls: type, *, optional: bool = False, leave_out: Sequence[str] = ()) -> tuple[Key, ...]:
    """What a constructor takes: the fields of an attrs class, or else the parameters of the call.

    ``optional`` makes every key so; the keys in ``leave_out`` are left out.
    """
    # A class that writes a constructor of its own has no fields, even where its base has.
    maker: Any = next(base for base in cls.__mro__ if "__init__" in vars(base))
    fields = _fields(cls) if "__attrs_attrs__" in vars(maker) else _parameters(cls, maker)
    keys = (key for key in fields if key.name not in leave_out)
    return tuple(attrs.evolve(key, required=False) if optional else key for key in keys)


def _fields(cls: type) -> Iterator[Key]:
    hints = _hints(cls)
    for attribute in attrs.fields(cls):
        if attribute.init:
            spec, default = quantity_of(attribute), attribute.default
            if spec is None and attribute.name == "duration_ratio":
                spec = _RATIO
            required = default is attrs.NOTHING
            known = not required and not isinstance(default, attrs.Factory)  # type: ignore[arg-type]
            annotation = hints.get(attribute.name, Any)
            yield Key(attribute.alias or attribute.name, required, spec, annotation, default if known else UNSTATED)


def _parameters(cls: type, maker: type) -> Iterator[Key]:
    hints = _hints(vars(maker)["__init__"])
    for name, parameter in inspect.signature(cls).parameters.items():
        if parameter.kind in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY):
            required = parameter.default is parameter.empty
            spec = _RATIO if name == "duration_ratio" else None
            yield Key(name, required, spec, hints.get(name, Any), UNSTATED if required else parameter.default)


@lru_cache(maxsize=128)
def _hints(source: Any) -> dict[str, Any]:
    try:
        return typing.get_type_hints(source)
    except Exception:  # an annotation may name what is imported for type checkers alone
        return {}


def _key(cls: type, name: str, needed: bool = False) -> Key:
    """The key of a field of ``cls``; ``needed``, where the field admits None and the key does not."""
    spec = quantity_of(attrs.fields_dict(cls)[name])
    return Key(name, spec=attrs.evolve(spec, optional=False) if spec is not None and needed else spec)


_DIAMETER = Quantity("m", "diameter 2 R of the granules", above=0)

#: Keys of the blocks. What depends on the profile is added when it is known.
SCENARIO = (
    Key("name", annotation=str, meaning="what the scenario is called"),
    Key("chain", required=True, meaning="a mapping of material, diameter, granules"),
    Key(
        "shock",
        required=True,
        meaning="a mapping of profile, peak_force, rise_time or duration, duration_ratio, parameters",
    ),
    Key("predict"),
    Key("simulate"),
    Key("requires", annotation=list[str], meaning="distributions that must be installed"),
    Key("published"),
    Key("sweep", meaning="a mapping of grid, zip or points: the scenario stands for many"),
    Key("uncertainty", meaning="a mapping of dotted names to how well these values are known"),
)
CHAIN = (
    Key("material", required=True, meaning="a name of the material library, or a mapping"),
    Key("diameter", spec=_DIAMETER),
    _key(Chain, "radius"),
    _key(Chain, "granules"),
)
SHOCK = (
    Key("profile", required=True, annotation=str, meaning="a name of the profile registry"),
    _key(Shock, "peak_force", needed=True),
    _key(Shock, "rise_time", needed=True),
    Key("duration", spec=DURATION),
    Key("duration_ratio", spec=_RATIO),
    Key("parameters"),
)


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


def shock_keys(cls: type[ShockProfile] | None) -> tuple[Key, ...]:
    """Keys of the block ``shock`` for profiles of ``cls``; None stands for an unknown profile.

    What may come from a record, or may be a profile's own, is optional.
    """
    if cls is None:
        return SHOCK
    own = {key.name: key for key in keys_of(cls) if key.name == "duration_ratio"}
    for name in ("peak_force", "rise_time"):
        recorded = f"recorded_{name}"
        if getattr(cls, recorded) is getattr(ShockProfile, recorded):
            own[name] = attrs.evolve(_key(Shock, name, needed=True), required=True)
    return tuple(own.get(key.name, key) for key in SHOCK)


def parameters_of(profile: str, cls: type[ShockProfile]) -> tuple[Key, ...]:
    """Keys of the block ``parameters``: all that the class takes besides ``duration_ratio``."""
    if profile != RECORD:
        return keys_of(cls, leave_out=["duration_ratio"])
    file = Key("file", annotation=str, meaning="a CSV file with a time and a force column")
    return (file, *keys_of(cls, optional=True, leave_out=["duration_ratio"]))
