"""The controls of the explorer: sliders, fields and lists for the values in a scenario."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from attrs import evolve, frozen
from shockwave import Scenario
from shockwave.base.quantity_fields import DIAMETER, Quantity
from shockwave.base.units import to_si
from shockwave.registry.registry import entries, load
from shockwave.scenario.block_keys import CHAIN, RECORD, WALLS, parameters_of, shock_keys

from .scene import ENDLESS, FREE, WALL, value_at

# Unit of the values of a slider, and its value in SI units.
_UNITS = {"N": ("N", 1.0), "s": ("us", 1e-6), "m": ("mm", 1e-3), "m/s": ("m/s", 1.0), "": ("", 1.0)}
# Ends of a slider, relative to the value at which it begins.
_SPAN = 10.0
# Least right end of the slider of a number of granules.
_MOST_ON_SLIDER = 100
# Segments of a chain that have controls.
_SEGMENTS = 6
_VELOCITY = Quantity("m/s", "", above=0)
_AS_GIVEN = "as in the text"


@frozen
class Control:
    """A control of the value with the dotted ``name``.

    ``text`` is the value as written, ``choices`` are those of a list. A slider from ``low`` to ``high`` in ``unit``
    stands at ``value``; its steps are equal ratios, or whole numbers if ``whole`` is true. Without ``high`` there is
    none.
    """

    name: str
    label: str
    text: str
    choices: tuple[str, ...] = ()
    unit: str = ""
    value: float = 0.0
    low: float = 0.0
    high: float = 0.0
    whole: bool = False

    @property
    def position(self) -> float:
        """Place of the value on the slider, from 0 to 1."""
        return math.log(self.value / self.low) / math.log(self.high / self.low)


def controls(scenario: Scenario) -> dict[str, list[Control]]:
    """Controls of a scenario that was loaded from a document, in groups with a title."""
    assert scenario.document is not None
    shock, chain, impact = (scenario.document.data.get(name) or {} for name in ("shock", "chain", "impact"))
    groups = {
        "Pulse": [*_of_shock(shock)],
        "Striker": [*_of_numbers(impact, "impact", {"velocity": _VELOCITY}), *_of_spheres(impact, "impact")],
        "Beads": [*_of_spheres(chain, "chain")],
        "Chain": [*_of_chain(chain)],
    }
    return {title: group for title, group in groups.items() if group}


def _of_shock(shock: dict[str, Any]) -> Iterator[Control]:
    if not shock:
        return
    name = shock["profile"]
    cls = load("profiles", name)
    yield _list("shock.profile", "shape", name, *(entry.name for entry in entries("profiles") if entry.name != RECORD))
    yield from _of_numbers(shock, "shock", {key.name: key.spec for key in shock_keys(cls)})
    parameters = {key.name: key.spec for key in parameters_of(name, cls)}
    yield from _of_numbers(shock.get("parameters") or {}, "shock.parameters", parameters)


def _of_spheres(block: Mapping[str, Any], name: str) -> Iterator[Control]:
    """Controls of material and size."""
    if "material" in block:
        yield _list(f"{name}.material", "material", _named(block["material"]), *_materials())
    yield from _of_numbers(block, name, {"diameter": DIAMETER, "radius": DIAMETER})


def _of_chain(chain: dict[str, Any]) -> Iterator[Control]:
    specs = {key.name: key.spec for key in CHAIN}
    granules, wall = chain.get("granules"), value_at(chain, "end", "wall")
    segments = granules if isinstance(granules, list) else []
    for index, segment in enumerate(segments[:_SEGMENTS]):
        place = f"chain.granules[{index}]"
        counts = _of_numbers(segment, place, dict.fromkeys(("count", "repeat"), specs["granules"]))
        for control in (*counts, *_of_spheres(segment, place)):
            yield evolve(control, label=f"segment {index + 1}: {control.label}")
    yield from _of_numbers(chain, "chain", {"granules": specs["granules"]})
    end = ENDLESS if granules is None else FREE if wall is None else WALL + _named(wall)
    walls = (f"{WALL}{name}" for name in (*WALLS, *_materials()))
    yield _list("chain.end", "end", end, *([FREE] if segments else [ENDLESS, FREE]), *walls)
    yield from _of_numbers(chain, "chain", {name: specs[name] for name in ("precompression", "gravity")})


def _named(material: Any) -> str:
    return material if isinstance(material, str) else _AS_GIVEN


@cache
def _materials() -> tuple[str, ...]:
    return tuple(sorted(entry.name for entry in entries("materials")))


def _list(name: str, label: str, value: str, *choices: str) -> Control:
    return Control(name, label, value, tuple(dict.fromkeys((value, *choices))))


def _of_numbers(block: Mapping[str, Any], name: str, specs: Mapping[str, Quantity | None]) -> Iterator[Control]:
    """Controls of the numbers in ``block`` with a name in ``specs``."""
    for key, spec in specs.items():
        value = block.get(key)
        if spec is not None and not spec.samples and value is not None and not isinstance(value, dict | list):
            yield _number(f"{name}.{key}", key.replace("_", " "), value, spec)


def _number(name: str, label: str, given: Any, spec: Quantity) -> Control:
    """Control of a number: text with a unit, and a slider around its value, where it has room on both sides."""
    unit, factor = _UNITS.get(spec.unit, (spec.unit, 1.0))
    value = to_si(given, spec.unit) / factor
    if spec.whole:
        most = max(_MOST_ON_SLIDER, 2 * value)
        return Control(name, label, f"{value:.0f}", (), "", value, min(2, value), most, whole=True)
    text = f"{value:g} {unit}".rstrip() if isinstance(given, int | float) else str(given)
    low = max([value / _SPAN, *(b / factor + (value - b / factor) / _SPAN for b in (spec.above, spec.at_least) if b)])
    high = min([value * _SPAN, *(b / factor - (b / factor - value) / _SPAN for b in (spec.below, spec.at_most) if b)])
    return Control(name, label, text, (), unit, value, low, high if 0 < low < high else 0.0)
