"""The scenario of the explorer: its text, changes to it, and the controls that make them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from functools import cache, lru_cache
from itertools import accumulate
from pathlib import Path
from typing import Any

import yaml
from attrs import evolve, frozen

from shockwave.errors import InvalidValueError, ScenarioError
from shockwave.fields import DIAMETER, Quantity
from shockwave.profiles.shock import Shock
from shockwave.registry import entries, load
from shockwave.scenario.block_keys import CHAIN, RECORD, WALLS, parameters_of, shock_keys
from shockwave.scenario.loader import load_scenario, scenario_of
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.template import template
from shockwave.scenario.yaml_document import Document, parse_document, steps_of
from shockwave.units import to_si

#: The scenario file in messages.
NAME = "scenario"
# Scenario files that are installed with the package, and those of a source tree.
_FOLDERS = (Path(__file__).with_name("presets"), Path(__file__).resolve().parents[2] / "profiles")
_KINDS = ("examples", "chains", "paper", "validation")
# Unit of the values of a slider, and its value in SI units.
_UNITS = {"N": ("N", 1.0), "s": ("us", 1e-6), "m": ("mm", 1e-3), "m/s": ("m/s", 1.0), "": ("", 1.0)}
# Ends of a slider, relative to the value at which it begins.
_SPAN = 10.0
# Granules of a chain that was endless before, and the least right end of the slider.
_GRANULES = 30
_MOST_ON_SLIDER = 100
# Most granules that are simulated while a slider moves, and the longest computing time [s].
_MOST_GRANULES = 1000
_LONGEST = 3.0
# Segments of a chain that have controls.
_SEGMENTS = 6
# Keys of a record that act on its samples; the others act on the reading of its file.
_PROCESSING = ("clean", "baseline", "low_pass", "crop", "negative")
# Longest text, about 6 000 samples of a record, and deepest brackets: bounds on the time of the parser.
_MOST_CHARACTERS = 2**18
_MOST_NESTED = 50
_ENDLESS, _FREE, _WALL = "endless chain", "free end", "wall: "
_AS_GIVEN = "as in the text"


# ---------------------------------------------------------------- text


def presets() -> dict[str, Path]:
    """Scenario files of the package by their names, such as ``chains/wall``."""
    folder = next(filter(Path.is_dir, _FOLDERS), _FOLDERS[0])
    files = [file for kind in _KINDS for file in sorted((folder / kind).glob("*.yaml"))]
    return {file.relative_to(folder).with_suffix("").as_posix(): file for file in files}


def text_of_file(path: str | Path) -> str:
    """Text of the scenario in a file, without a sweep or uncertain values, and with the samples of its record.

    Raises
    ------
    ShockwaveError
        As `load_scenario`.
    """
    scenario = load_scenario(path)
    assert scenario.document is not None
    data = scenario.document.data
    whole = Path(path).read_text(encoding="utf-8-sig")
    if len(scenario.files) > 1:  # a link contains everything
        profile: Any = scenario.shock.profile
        record = {name: getattr(profile, name).tolist() for name in ("times", "forces")}
        record |= {name: value for name, value in data["shock"]["parameters"].items() if name in _PROCESSING}
        data = data | {"shock": data["shock"] | {"parameters": record}}
    elif parse_document(whole, NAME).data.keys() == data.keys():
        return whole  # with its comments
    return _written({"name": scenario.name} | data)


def loaded(text: str) -> Scenario:
    """The scenario in ``text``, which is as untrusted as a link.

    Raises
    ------
    ShockwaveError
        As `load_scenario`; or if it names a file, is too long, or has more granules than the page can simulate.
    """
    document = _parsed(text)
    if _at(document.data, ("shock", "parameters", "file")) is not None:
        hint = "run `shockwave explore FILE` with a scenario that names it"
        problem = f"must be left out here, because a link must not read files ({hint})"
        raise ScenarioError([document.fault(("shock", "parameters", "file"), problem)])
    scenario = scenario_of(document, None)
    if scenario.sweep is not None:
        raise ScenarioError([document.fault(("sweep",), "must be left out here, because the page shows a single case")])
    count = scenario.chain.count
    if count is not None and count > _MOST_GRANULES and not scenario.chain.is_uniform:
        problem = f"must be at most {_MOST_GRANULES} here (got {count}; `shockwave simulate` takes more)"
        raise ScenarioError([document.fault(("chain", "granules"), problem)])
    timeout = min(scenario.simulate.timeout or _LONGEST, _LONGEST)
    return evolve(scenario, simulate=evolve(scenario.simulate, timeout=timeout))


@lru_cache(maxsize=4)
def _parsed(text: str) -> Document:
    """The document in ``text``, parsed once for an answer and the edit that follows it."""
    if len(text) > _MOST_CHARACTERS:
        hint = "shorten its record, or use `shockwave predict` and `shockwave simulate`"
        problem = f"must have at most {_MOST_CHARACTERS} characters here (got {len(text)}; {hint})"
        raise InvalidValueError.of(NAME, problem)
    brackets = (1 if bracket in "[{" else -1 for bracket in re.findall(r"[][{}]", text))
    if max(accumulate(brackets), default=0) > _MOST_NESTED:
        raise InvalidValueError.of(NAME, f"must have at most {_MOST_NESTED} nested brackets (got more)")
    return parse_document(text, NAME)


def edited(text: str, edits: Mapping[str, Any]) -> str:
    """``text`` with the values of controls in their places; it need not be a valid scenario.

    Raises
    ------
    ShockwaveError
        If ``text`` is not a document.
    """
    document = _parsed(text)
    for name, value in edits.items():
        for path, new in _changes(document.data, name, value):
            document = document.having({path: new})
    return _written(document.data) if edits else text


def _changes(data: dict[str, Any], name: str, value: Any) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Paths and values for the value of a control; None stands for no value."""
    chain = data.get("chain")
    chain = chain if isinstance(chain, dict) else {}
    if name == "chain.end":
        end = chain["end"] if isinstance(chain.get("end"), dict) else {}
        finite = chain.get("granules") is not None
        yield ("chain", "end"), None if value in (_ENDLESS, _FREE) else {**end, "wall": str(value).removeprefix(_WALL)}
        yield ("chain", "granules"), None if value == _ENDLESS else chain["granules"] if finite else _GRANULES
    elif name == "shock.profile":
        fresh = parse_document(template(str(value)), NAME).data["shock"]
        old = data.get("shock") or {}
        kept = {key: old[key] for key in fresh.keys() & old.keys() - {"profile", "parameters"}}
        if "rise_time" in fresh and "duration" in old and "rise_time" not in old:
            kept["duration"] = old["duration"]
            del fresh["rise_time"]
        yield ("shock",), {**fresh, **kept}
    else:
        yield steps_of(name), value
        if name == "shock.duration" and _at(data, ("shock", "duration")) is None:
            yield ("shock", "rise_time"), None
    if name.startswith(("chain.end", "chain.granules")) and _at(data, ("simulate", "contacts")):
        yield ("simulate", "contacts"), None  # the chain may be too short for them


def _at(data: Any, path: tuple[str | int, ...]) -> Any:
    """The value at ``path``; None if there is none."""
    for step in path:
        try:
            data = data[step]
        except (TypeError, LookupError):
            return None
    return data


def _written(data: Any) -> str:
    """``data`` as YAML, without keys that have no value."""
    return yaml.safe_dump(_present(data), sort_keys=False, allow_unicode=True, default_flow_style=None, width=88)


def _present(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: new for key, own in value.items() if (new := _present(own)) not in (None, {})}
    return [_present(own) for own in value] if isinstance(value, list) else value


# ---------------------------------------------------------------- controls


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
    data = scenario.document.data
    shock, chain, impact = (data.get(name) or {} for name in ("shock", "chain", "impact"))
    groups = {"Pulse": list(_of_shock(shock, scenario.shock)), "Striker": list(_of_spheres(impact, "impact"))}
    if "velocity" in impact:
        speed = _number("impact.velocity", "velocity", impact["velocity"], Quantity("m/s", "", above=0))
        groups["Striker"].insert(0, speed)
    groups["Beads"] = list(_of_spheres(chain, "chain"))
    groups["Chain"] = list(_of_chain(chain))
    return {title: group for title, group in groups.items() if group}


def _of_shock(shock: dict[str, Any], made: Shock) -> Iterator[Control]:
    if not shock:
        return
    name = shock["profile"]
    cls = load("profiles", name)
    others = (entry.name for entry in entries("profiles") if entry.name != RECORD)
    yield Control("shock.profile", "shape", name, tuple(dict.fromkeys((name, *others))))
    times = {"rise_time", "duration", "duration_ratio"} & shock.keys()
    if times == {"rise_time"} and made.profile.recorded_rise_time is None:
        # shock tests specify the duration of a shape with a fixed ratio
        shock = {**shock, "rise_time": None, "duration": made.duration}
    for prefix, given, keys in (
        ("shock", shock, shock_keys(cls)),
        ("shock.parameters", shock.get("parameters") or {}, parameters_of(name, cls)),
    ):
        for key in keys:
            if given.get(key.name) is not None and key.spec is not None and not key.spec.samples:
                label = "duration / rise time" if key.name == "duration_ratio" else key.name.replace("_", " ")
                yield _number(f"{prefix}.{key.name}", label, given[key.name], key.spec)


def _of_spheres(block: Mapping[str, Any], name: str) -> Iterator[Control]:
    """Controls of material and size."""
    if "material" in block:
        own = _named(block["material"])
        yield Control(f"{name}.material", "material", own, tuple(dict.fromkeys((own, *_materials()))))
    for size in ("diameter", "radius"):
        if size in block and not isinstance(block[size], dict):
            yield _number(f"{name}.{size}", size, block[size], DIAMETER)


def _of_chain(chain: dict[str, Any]) -> Iterator[Control]:
    granules, end = chain.get("granules"), chain.get("end")
    whole = next(key.spec for key in CHAIN if key.name == "granules")
    assert whole is not None
    if isinstance(granules, list):
        for index, segment in enumerate(granules[:_SEGMENTS]):
            place = f"chain.granules[{index}]"
            for number in ("count", "repeat"):
                if number in segment:
                    yield _number(f"{place}.{number}", f"segment {index + 1}: {number}", segment[number], whole)
            for control in _of_spheres(segment, place):
                yield evolve(control, label=f"segment {index + 1}: {control.label}")
    elif granules is not None:
        yield _number("chain.granules", "granules", granules, whole)
    wall = end.get("wall") if isinstance(end, dict) else None
    given = _ENDLESS if granules is None else _FREE if wall is None else _WALL + _named(wall)
    ends = (_FREE,) if isinstance(granules, list) else (_ENDLESS, _FREE)
    walls = (f"{_WALL}{name}" for name in (*WALLS, *_materials()))
    yield Control("chain.end", "end", given, tuple(dict.fromkeys((*ends, given, *walls))))
    for key in CHAIN:
        if key.name in ("precompression", "gravity") and key.name in chain and key.spec is not None:
            yield _number(f"chain.{key.name}", key.name, chain[key.name], key.spec)
    for name, value in (chain.get("damping") or {}).items():
        if name != "model":
            yield Control(f"chain.damping.{name}", f"damping: {name}", str(value))


def _named(material: Any) -> str:
    return material if isinstance(material, str) else _AS_GIVEN


@cache
def _materials() -> tuple[str, ...]:
    return tuple(sorted(entry.name for entry in entries("materials")))


def _number(name: str, label: str, given: Any, spec: Quantity) -> Control:
    """Control of a number: text with a unit, and a slider around its value, where it has room on both sides."""
    text = str(given)
    unit, factor = _UNITS.get(spec.unit, (spec.unit, 1.0))
    value = to_si(given, spec.unit) / factor
    if isinstance(given, int | float):
        text = f"{value:g} {unit}".rstrip()
    if spec.whole:
        most = max(_MOST_ON_SLIDER, 2 * value)
        return Control(name, label, f"{value:.0f}", (), "", value, min(2, value), most, whole=True)
    low = max([value / _SPAN, *(b / factor + (value - b / factor) / _SPAN for b in (spec.above, spec.at_least) if b)])
    high = min([value * _SPAN, *(b / factor - (b / factor - value) / _SPAN for b in (spec.below, spec.at_most) if b)])
    return Control(name, label, text, (), unit, value, low, high if 0 < low < high else 0.0)
