"""Blocks of a scenario for chains beyond equal spheres: segments, end, damping, contact law and impact."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from attrs import evolve

from shockwave.base.errors import Fault, InvalidValueError, ShockwaveError, UnknownNameError, nearest, refuse
from shockwave.base.quantity_fields import Declaration, join, text_of
from shockwave.records.record_format import RecordFormat
from shockwave.registry.registry import blame, entries, load
from shockwave.scenario.block_keys import BLOCKS, GRANULES, MATERIAL, WALLS, Key, keys_of, name_of_material
from shockwave.scenario.value_conversion import Parser, convert, items, structure
from shockwave.scene.chain_end import Bar, Wall
from shockwave.scene.contact_law import PowerContact
from shockwave.scene.impact import Impact
from shockwave.scene.material import SIZES
from shockwave.scene.motion import Motion
from shockwave.scene.segments import Cell, Segment, Taper


def _keys(cls: type) -> dict[str, Key]:
    return {key.name: key for key in keys_of(cls)}


_MATERIAL = evolve(MATERIAL, meaning="a name or a mapping; by default that of the chain")
_DIAMETER = Declaration("m", "diameter of the granules", **SIZES)
#: Keys of a taper, which replaces a single size.
TAPER = (
    Key("from", required=True, spec=_keys(Taper)["first"].spec),
    Key("to", required=True, spec=_keys(Taper)["last"].spec),
    evolve(_keys(Taper)["spacing"], meaning="linear (equal differences, default) or geometric (equal ratios)"),
)


def _taper(**values: Any) -> Taper:
    return Taper(first=values.pop("from"), last=values.pop("to"), **values)


_TAPERED: dict[str, Any] = {"keys": TAPER, "make": _taper}
#: Keys of a segment.
SEGMENT = (
    *(_keys(Segment)["count"], _MATERIAL, Key("diameter", spec=_DIAMETER, **_TAPERED)),
    *(evolve(_keys(Segment)["radius"], instead_of=("diameter",), **_TAPERED), _keys(Segment)["gap"]),
    Key("contact", default=None, meaning="law of the contacts behind its granules, by default that of the chain"),
    Key("damping", default=None, meaning="damping at these contacts, by default that of the chain"),
)
# Keys of a motion that a record replaces.
_CONSTANT = ("velocity", "until", "times", "values")
#: Keys of a repeated cell.
CELL = (_keys(Cell)["repeat"], Key("cell", required=True, meaning="a list of the segments of a cell"))
#: Keys of an end with a wall.
END = (
    evolve(
        MATERIAL, name="wall", required=True, also=WALLS, meaning="same (as the last granule), rigid, or a material"
    ),
    *(_keys(Wall)[name] for name in ("mass", "stiffness", "damping")),
)
#: Keys of a bar in place of a wall.
BAR = (
    evolve(MATERIAL, required=True),
    Key("diameter", required=True, spec=evolve(_DIAMETER, meaning="diameter of the bar")),
    *(evolve(_keys(Bar)[name], instead_of=("diameter",)) for name in ("radius", "impedance")),
)
#: Key of an end with a bar.
BAR_END = (Key("bar", required=True, meaning="a bar in place of a wall", keys=BAR, make=Bar),)
#: Keys of the ``impact`` block.
IMPACT = (
    evolve(_keys(Impact)["velocity"], required=True),
    evolve(_keys(Impact)["drop_height"], instead_of=("velocity",)),
    Key("diameter", spec=evolve(_DIAMETER, meaning="diameter of the striker, by default that of the chain")),
    evolve(_keys(Impact)["radius"], instead_of=("diameter",)),
    _MATERIAL,
)
_RECORD = tuple(key for key in keys_of(RecordFormat) if key.name not in ("area", "mass"))
#: Keys of the ``motion`` block: a constant velocity, or a record with its format.
MOTION = (
    *(_keys(Motion)[name] for name in ("velocity", "until", "quantity")),
    Key("file", annotation=str, meaning="a record with a time column and one of the quantity", plain=False),
    Key("times", spec=Declaration("s", "sample times", samples=True)),
    Key("values", spec=Declaration("", "values in SI units", samples=True)),
    *_RECORD,
)
#: Key of a block that names a contact law or a damping.
MODEL = Key("model", required=True, annotation=str, meaning="a name from `shockwave list contacts`")
# It is not needed for a power law.
_MODEL_OR_POWER = evolve(MODEL, required=False, instead_of=("exponent", "stiffness"))
#: Block -> value of ``takes`` of the registry entries that it accepts.
LAWS = {"damping": "damping", "contact": ""}


def granules(content: Any) -> Any:
    """Segments, or the number of equal granules."""
    if not isinstance(content, list):
        return convert(GRANULES, content)
    if not content:
        raise InvalidValueError("must be a list of one or more segments, or a whole number (got [])")
    return tuple(items(content, _part))


def _part(content: Any) -> Segment | Cell:
    if isinstance(content, dict) and not {"repeat", "cell"}.isdisjoint(content):
        return Cell(**structure(content, CELL, {"cell": _cell}))
    return _segment(content)


def _cell(content: Any) -> list[Segment]:
    if not isinstance(content, list) or not content:
        raise InvalidValueError(f"must be a list of one or more segments (got {text_of(content)})")
    return items(content, _segment)


def _segment(content: Any) -> Segment:
    if content is None:
        raise InvalidValueError(f"must be a mapping of {', '.join(key.name for key in SEGMENT)} (got nothing)")
    return Segment(**structure(content, SEGMENT, _LAW_PARSERS))


def end(content: Any) -> Wall | Bar | None:
    """The wall; None for a free end."""
    if content is None or (isinstance(content, str) and content.lower() == "free"):
        return None
    if not isinstance(content, dict):
        keys = ", ".join(key.name for key in END)
        raise InvalidValueError(
            f"must be free, or a mapping of {keys} (got {text_of(content)}; for a wall, {{wall: same}})"
        )
    if content.keys() == {"bar"}:
        bar: Bar = structure(content, BAR_END)["bar"]
        return bar
    values = structure(content, END)
    return Wall(material=values.pop("wall"), **values)


def law(block: str, content: Any) -> Any:
    """Contact law or damping of the ``block`` damping or contact; None for an empty block."""
    if content is None:
        return None
    names = models(block)
    if not isinstance(content, dict):
        raise InvalidValueError(f"must be a mapping such as {{model: {names[0]}}} (got {text_of(content)})")
    if block == "contact" and "model" not in content:
        return PowerContact(**structure(content, (_MODEL_OR_POWER, *keys_of(PowerContact)), _PARSERS[PowerContact]))
    # the other keys are those of the model
    named = {key: value for key, value in content.items() if key == "model"}
    cls = structure(named, (MODEL,), {"model": partial(_model, names)})["model"]
    values = structure(content, (MODEL, *keys_of(cls)), _PARSERS.get(cls))
    del values["model"]
    with blame("contacts", cls):
        return cls(**values)


def _model(names: Sequence[str], value: Any) -> Any:
    """Class of a model that is one of those ``names``."""
    name: str = convert(MODEL, value)
    with suppress(UnknownNameError):
        cls = load("contacts", name)
        if name.lower() in map(str.lower, names):
            return cls
    raise InvalidValueError(f"must be {join(names)} (got {text_of(name)}; {nearest(name, names)}".rstrip("; ") + ")")


def _stiffness(content: Any) -> Any:
    if isinstance(content, str) and not re.fullmatch(r"[-+.\deE]+", content.strip()):
        raise InvalidValueError(f"must be a bare number, in N/m^p (got {text_of(content)})")
    return convert(_keys(PowerContact)["stiffness"], content)


# Conversions of the parameters of a law, where they differ from those of their declarations.
_PARSERS: dict[Any, Mapping[str, Parser]] = {PowerContact: {"stiffness": _stiffness}}


def models(block: str) -> list[str]:
    """Names that the ``block`` damping or contact accepts."""
    return [entry.name for entry in entries("contacts") if entry.takes == LAWS[block]]


def impact(content: Any) -> Impact:
    """The impact."""
    return Impact(**structure(content, IMPACT))


def motion(find: Callable[[str, str], Path], content: Any) -> Motion:
    """The motion; ``find`` returns the place of a file, and names its key in messages."""
    values = structure(content, MOTION)
    if "file" not in values:
        rule = "must be left out without file"
        refuse([Fault(key.name, rule, at_key=True) for key in _RECORD if key.name in values])
        return Motion(**values)
    file, quantity = find(values.pop("file"), "file"), values.pop("quantity", None)
    refuse([Fault("quantity", "must be given with file (got nothing)")] if quantity is None else [])
    refuse([Fault(name, "must be left out for a file", at_key=True) for name in _CONSTANT if name in values])
    return Motion.from_file(file, quantity, **values)


_LAW_PARSERS: dict[str, Parser] = {block: partial(law, block) for block in LAWS}
#: Key of the ``chain`` block -> its parser.
PARSERS: Mapping[str, Parser] = {
    "granules": granules,
    "end": end,
    **_LAW_PARSERS,
}


# ---------------------------------------------------------------- dotted names


def keys_below(data: Mapping[str, Any]) -> Iterator[tuple[str, Key]]:
    """Dotted name and key of every value below ``impact`` and the blocks of ``chain`` in a document."""
    chain = _mapping(data.get("chain"))
    parts = chain.get("granules")
    for index, part in enumerate(parts if isinstance(parts, list) else ()):
        place, block_content = f"chain.granules[{index}]", _mapping(part)
        if "cell" in block_content:
            yield f"{place}.repeat", CELL[0]
            for inner, segment in enumerate(block_content["cell"] if isinstance(block_content["cell"], list) else ()):
                yield from _keys_of_block(f"{place}.cell[{inner}]", SEGMENT, _mapping(segment))
        else:
            yield from _keys_of_block(place, SEGMENT, block_content)
    if isinstance(chain.get("end"), dict):
        yield from _keys_of_block("chain.end", END, chain["end"])
        if "bar" in chain["end"]:
            yield from _keys_of_block("chain.end.bar", BAR, _mapping(chain["end"]["bar"]))
    for block in LAWS:
        yield from _keys_of_law("chain", block, chain)
    motion_block, motion_keys = _mapping(data.get("motion")), MOTION[:2]
    if "file" in motion_block or "times" in motion_block:
        motion_keys = tuple(key for key in _RECORD if key.spec is not None and "file" in motion_block)
    for block, keys in (("impact", IMPACT), ("motion", motion_keys)):
        if block in data:
            yield from _keys_of_block(block, keys, _mapping(data[block]))


def _mapping(content: Any) -> dict[str, Any]:
    return content if isinstance(content, dict) else {}


def _keys_of_law(place: str, block: str, content: Mapping[str, Any]) -> Iterator[tuple[str, Key]]:
    values = _mapping(content.get(block))
    with suppress(ShockwaveError):  # reported at the place of the name
        name = values.get("model", "power-law" if block == "contact" and values else None)
        if isinstance(name, str):
            yield from _keys_of_block(f"{place}.{block}", keys_of(load("contacts", name)), values)


def _keys_of_block(place: str, keys: Sequence[Key], content: Mapping[str, Any]) -> Iterator[tuple[str, Key]]:
    for key in keys:
        name = f"{place}.{key.name}"
        if key.kind == "materials":
            yield name, name_of_material(key)
            if str(content.get(key.name)).lower() not in WALLS:
                yield from ((f"{name}.{own.name}", own) for own in BLOCKS["chain.material"])
        elif tapers := [each for each in ("diameter", "radius") if key.keys and isinstance(content.get(each), dict)]:
            yield from ((f"{place}.{tapers[0]}.{end.name}", end) for end in TAPER[:2])
        elif key.name in LAWS:
            yield from _keys_of_law(place, key.name, content)
        else:
            yield name, key
