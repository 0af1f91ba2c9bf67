"""The controls of the explorer: sliders, fields and lists for the values in a scenario."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import cache
from typing import Any

from attrs import evolve, frozen
from shockwave import Outcome, Scenario
from shockwave.base.errors import dotted_name, steps_of
from shockwave.base.quantity_fields import Declaration
from shockwave.base.text import si
from shockwave.base.units import to_si
from shockwave.registry.registry import entries
from shockwave.scenario.block_keys import RECORD, WALLS, keys_of
from shockwave.scenario.dotted_names import Variable, name_in_words, variables

from .scene import ELASTIC, ENDLESS, FREE, PLASTIC, TIMES, WALL, value_at

# Blocks with controls, and the titles of their groups.
_TITLES = {
    "shock": "Shock",
    "impact": "Impact",
    "motion": "Motion",
    "chain": "Chain",
    "simulate": "Simulation",
    "predict": "Section 4",
}
# Ends of a slider, relative to the value at which it begins.
_SPAN = 10.0
# Least right end of the slider of a number of granules.
_MOST_ON_SLIDER = 100
# Segments of a chain that have controls.
_SEGMENTS = 6
_AS_GIVEN = "as in the text"
# A number and the blanks after it.
_NUMBER = re.compile(r"[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)? *")


@frozen
class Control:
    """A control of the value with the dotted ``name``.

    ``text`` is the value as written, ``choices`` are those of a list. A slider from ``low`` to ``high`` in ``unit``,
    that of the text, stands at ``value``; its steps are equal ratios, or whole numbers if ``whole`` is true. Without
    ``high`` there is none.
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


def list_controls(scenario: Scenario, outcome: Outcome | None = None) -> dict[str, list[Control]]:
    """Controls of a scenario that was loaded from a document, in groups with a title.

    Every value that the document gives has one, and so have times and forces that follow from the others: of the
    shock and, with an ``outcome``, the end of the simulated time.
    """
    assert scenario.document is not None
    data = scenario.document.data
    derived = dict(_derive(scenario, outcome))
    groups: dict[str, list[Control]] = {title: [] for title in _TITLES.values()}
    for variable in variables(data).values():
        given = value_at(data, *steps_of(variable.name))
        block, *rest = steps_of(variable.name)
        if all(isinstance(step, str) or step < _SEGMENTS for step in rest):
            value = derived.get(variable.name) if given is None else given
            groups[_TITLES[str(block)]] += _controls_of(variable, value, data)
    return {title: group for title, group in groups.items() if group}


def _derive(scenario: Scenario, outcome: Outcome | None) -> Iterator[tuple[str, float | str]]:
    """Names and values [SI] of quantities that the document need not give."""
    if (shock := scenario.scene.shock) is not None:
        yield from ((f"shock.{name}", getattr(shock, name)) for name in ("peak_force", "rise_time", "duration"))
        if any(key.name == "duration_ratio" for key in keys_of(type(shock.profile))):
            yield "shock.duration_ratio", float(shock.profile.duration_ratio)
    result = None if outcome is None else outcome.simulated
    if result is not None and (end := result.end or result.recording.times[-1]):
        yield "simulate.until", float(end)
    elif outcome is not None and outcome.reason:
        yield "simulate.until", ""  # a shorter time may have an answer


def _controls_of(variable: Variable, value: Any, data: Any) -> Iterator[Control]:
    """The control of a variable with this value, if it can have one."""
    name, label = variable.name, _label_of(variable.name)
    if name == "shock.profile" and value is not None:
        profiles = (entry.name for entry in entries("profiles") if entry.name != RECORD)
        yield _make_list(name, label, str(value), *profiles)
    elif variable.key.kind == "materials" and name != "chain.end.wall" and value is not None:
        yield _make_list(name, label, _name_of(value), *_list_materials())
    elif value == "":
        yield Control(name, label, "", unit="ms")
    elif (spec := variable.key.spec) is not None and not spec.samples and isinstance(value, str | int | float):
        yield _make_number(name, label, value, _bound(spec, name, data))
    if name == "chain.granules":
        yield _make_end(value, value_at(data, "chain", "end"))
        law = value_at(data, "chain", "contact") or {"model": "hertz"}
        contacts = {"hertz": ELASTIC, PLASTIC: PLASTIC}.get(str(law.get("model")), _AS_GIVEN)
        if value is not None:
            yield _make_list("chain.contact", "contacts", contacts, ELASTIC, PLASTIC)


def _bound(spec: Declaration, name: str, data: Any) -> Declaration:
    """``spec`` with the bound that another time of the shock sets, if that stays when this one changes."""
    shock = value_at(data, "shock") or {}
    if len(shock.keys() & TIMES) > 1 and name == "shock.duration" and "rise_time" in shock:
        return evolve(spec, above=to_si(shock["rise_time"], "s"))
    if len(shock.keys() & TIMES) > 1 and name == "shock.rise_time" and "duration" in shock:
        return evolve(spec, below=to_si(shock["duration"], "s"))
    return spec


def _label_of(name: str) -> str:
    """The keys of a dotted name below its block, as words."""
    return name_in_words(dotted_name(steps_of(name)[1:]))


def _make_end(granules: Any, given: Any) -> Control:
    wall = given.get("wall") if isinstance(given, dict) else None
    end = ENDLESS if granules is None else FREE if given is None else WALL + _name_of(wall) if wall else _AS_GIVEN
    walls = (f"{WALL}{name}" for name in (*WALLS, *_list_materials()))
    return _make_list("chain.end", "end", end, *([FREE] if isinstance(granules, list) else [ENDLESS, FREE]), *walls)


def _name_of(material: Any) -> str:
    return material if isinstance(material, str) else _AS_GIVEN


@cache
def _list_materials() -> tuple[str, ...]:
    return tuple(sorted(entry.name for entry in entries("materials")))


def _make_list(name: str, label: str, value: str, *choices: str) -> Control:
    return Control(name, label, value, tuple(dict.fromkeys((value, *choices))))


def _make_number(name: str, label: str, number: Any, spec: Declaration) -> Control:
    """Control of a number: text with a unit, and a slider around its value, where it has room on both sides."""
    text = number.strip() if isinstance(number, str) else si(number, spec.unit)
    unit = _NUMBER.sub("", text, count=1)
    factor = to_si(f"1 {unit}".strip(), spec.unit)
    value = to_si(text, spec.unit) / factor
    if spec.whole:
        most = 0.0 if ".cell[" in name else max(_MOST_ON_SLIDER, 2 * value)
        return Control(name, label, f"{value:.0f}", (), "", value, min(2, value), most, whole=True)
    low, high = value / _SPAN, value * _SPAN
    for sign, bound in ((sign, bound / factor) for sign, bound in spec.bounds):
        if sign[0] == ">" and low <= bound:
            low = bound + (value - bound) / _SPAN
        elif sign[0] == "<" and high >= bound:
            high = bound - (bound - value) / _SPAN
    low, high = (float(f"{end:.6g}") for end in (low, high))
    return Control(name, label, text, (), unit, value, low, high if 0 < low < high else 0.0)
