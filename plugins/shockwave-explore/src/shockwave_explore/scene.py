"""The scenario of the explorer as text, and changes to it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import lru_cache
from itertools import accumulate
from pathlib import Path
from typing import Any

import yaml
from attrs import evolve
from shockwave import InvalidValueError, Scenario, ScenarioError, ShockwaveError, load_scenario
from shockwave.base.errors import Fault, steps_of, text_of
from shockwave.base.text import si
from shockwave.scenario.scenario import parse_scenario
from shockwave.scenario.template import template
from shockwave.scenario.yaml_document import Document, parse_document

#: The scenario file in messages.
NAME = "scenario"
#: Choices for the end of a chain; the last one is followed by the material of the wall.
ENDLESS, FREE, WALL = "endless chain", "free end", "wall: "
#: Choices for the contacts of a finite chain.
ELASTIC, PLASTIC = "elastic", "elastic-plastic"
#: Keys of the times of a shock. A further one replaces the last of those that are given.
TIMES = "rise_time", "duration", "duration_ratio"
#: Files of the example scenarios by their names; the page begins with the wall.
PRESETS = {file.stem: file for file in sorted(Path(__file__).with_name("scenes").glob("*.yaml"))}
# Granules of a chain that was endless before.
_GRANULES = 30
# Most granules of a chain that is integrated to its end, and the longest computing time [s].
_MOST_GRANULES = 300
_LONGEST = 3.0
# Keys of a record that act on its samples; the others act on the reading of its file.
_PROCESSING = ("baseline", "low_pass", "crop", "negative")
# Longest text, about 6 000 samples of a record, and deepest brackets: bounds on the time of the parser.
_MOST_CHARACTERS = 2**18
_MOST_NESTED = 50


def text_of_file(path: str | Path) -> str:
    """Text of the scenario in a file; see `scenario_text`, and `load_scenario` for the errors."""
    return scenario_text(load_scenario(path))


def scenario_text(scenario: Scenario) -> str:
    """Text of a scenario, without a sweep or uncertain values, and with the samples of its record."""
    assert scenario.document is not None
    data, text = scenario.document.data, scenario.document.text.removeprefix("\ufeff")
    if {*scenario.files} - {scenario.path}:  # a link contains everything
        motion, shock = scenario.motion, scenario.scene.shock
        if motion is not None:
            record = {"times": list(motion.times), "values": list(motion.values), "quantity": motion.quantity}
            data = data | {"motion": record}
        elif shock is not None:
            profile: Any = shock.profile
            record = {name: getattr(profile, name).tolist() for name in ("times", "forces")}
            record |= {name: value for name, value in data["shock"]["parameters"].items() if name in _PROCESSING}
            data = data | {"shock": data["shock"] | {"parameters": record}}
    elif parse_document(text, NAME).data.keys() == data.keys():
        return text  # with its comments
    return _write({"name": scenario.name} | data)


def titles() -> dict[str, str]:
    """Titles of the examples, in alphabetical order, and their names."""
    names = {str(_parse(text_of_file(file)).data["name"]): name for name, file in PRESETS.items()}
    return {title[:1].upper() + title[1:]: names[title] for title in sorted(names)}


def load_text(text: str) -> Scenario:
    """The scenario in ``text``, which is as untrusted as a link.

    Raises
    ------
    ShockwaveError
        As `load_scenario`; or if it could name a file, is too long, or has more granules than the page can simulate.
    """
    document = _parse(text)
    if document.data.get("sweep") is not None:
        problem = "must be left out here, because the page shows a single case"
        raise ScenarioError(document.place(Fault("sweep", problem)))
    scenario = parse_scenario(document, None)
    count = scenario.chain.count
    if count is not None and count > _MOST_GRANULES and not scenario.chain.is_uniform:
        problem = f"must be at most {_MOST_GRANULES} here (got {count}; `shockwave simulate` takes more)"
        raise ScenarioError(document.place(Fault("chain.granules", problem)))
    timeout = min(scenario.simulate.timeout or _LONGEST, _LONGEST)
    return evolve(scenario, simulate=evolve(scenario.simulate, timeout=timeout))


@lru_cache(maxsize=4)
def _parse(text: str) -> Document:
    """The document in ``text``, parsed once for an answer and the edit that follows it."""
    if len(text) > _MOST_CHARACTERS:
        hint = "shorten its record, or use `shockwave predict` and `shockwave simulate`"
        problem = f"must have at most {_MOST_CHARACTERS} characters here (got {len(text)}; {hint})"
        raise InvalidValueError.of(NAME, problem)
    brackets = (1 if bracket in "[{" else -1 for bracket in re.findall(r"[][{}]", text))
    if max(accumulate(brackets), default=0) > _MOST_NESTED:
        raise InvalidValueError.of(NAME, f"must have at most {_MOST_NESTED} nested brackets (got more)")
    return parse_document(text, NAME, names_files=False)


def edit_text(text: str, edits: Mapping[str, Any]) -> str:
    """``text`` with the values of controls in their places; it need not be a valid scenario.

    Raises
    ------
    ShockwaveError
        If ``text`` is not a document, or a value is neither text nor a number.
    """
    for name, value in edits.items():
        if not steps_of(name) or not isinstance(value, str | int | float):
            rule = "must be text or a number for each name of a control"
            raise InvalidValueError.of("edits", f"{rule} (got {text_of(value)} for {text_of(name)})")
    document = _parse(text)
    for name, value in edits.items():
        for path, new in _list_changes(document, name, value):
            document = document.with_values({path: new})
    return _write(document.data) if edits else text


def _list_changes(document: Document, name: str, value: Any) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Paths and values for the value of a control, which is removed if it is empty; None stands for no value."""
    data = document.data
    if name == "chain.end":
        granules, end = value_at(data, "chain", "granules"), value_at(data, "chain", "end")
        kept = {key: given for key, given in _mapping_of(end).items() if key != "bar"}
        walled = {**kept, "wall": str(value).removeprefix(WALL)}
        yield ("chain", "end"), None if value in (ENDLESS, FREE) else walled
        yield ("chain", "granules"), None if value == ENDLESS else _GRANULES if granules is None else granules
        if value == ENDLESS and value_at(data, "chain", "contact", "model") == PLASTIC:
            yield ("chain", "contact"), None
    elif name == "chain.contact":
        yield ("chain", "contact"), {"model": PLASTIC} if value == PLASTIC else None
    elif name == "shock.profile":
        fresh = parse_document(template(str(value)), NAME).data["shock"]
        old = _mapping_of(data.get("shock"))
        if old and len(fresh.keys() & TIMES) > 1:
            with suppress(ShockwaveError):  # a shock that is not valid has no rise time to keep
                shock = parse_scenario(document, None).shock
                old = {"rise_time": si(shock.rise_time, "s"), "duration": si(shock.duration, "s")} | old
                if "duration_ratio" in old and "rise_time" in data["shock"]:
                    del old["duration"]
        yield ("shock",), _reshape(old, fresh)
    else:
        yield steps_of(name), None if value == "" else value
        times = [time for time in TIMES if value_at(data, "shock", time) is not None]
        if value != "" and times and (time := name.removeprefix("shock.")) in TIMES and time not in times:
            yield ("shock", times[-1]), None
    shortens = name in ("chain.end", "chain.granules") or name.endswith((".count", ".repeat"))
    for key in ("contacts", "sensors"):
        if shortens and value_at(data, "simulate", key):
            yield ("simulate", key), None  # the chain may be too short for them


def _reshape(old: Mapping[str, Any], fresh: Mapping[str, Any]) -> dict[str, Any]:
    """The shock ``fresh`` with the peak force of ``old``, and with as many of its times as it needs."""
    kept = [time for time in ("duration", "rise_time", "duration_ratio") if time in old]
    own = [time for time in ("duration_ratio", "rise_time", "duration") if time in fresh]
    fitting = [*(time for time in kept if time in fresh or time != "duration_ratio"), *own]
    times = list(dict.fromkeys(fitting))[: len(fresh.keys() & TIMES)]
    rest = {key: value for key, value in fresh.items() if key not in TIMES}
    forces = {key: value for key, value in old.items() if key == "peak_force"}
    return rest | forces | {time: old.get(time, fresh.get(time)) for time in times}


def _mapping_of(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def value_at(data: Any, *path: str | int) -> Any:
    """The value at ``path``; None if there is none."""
    for step in path:
        try:
            data = data[step]
        except (TypeError, LookupError):
            return None
    return data


def _write(data: Any) -> str:
    """``data`` as YAML, without keys that have no value."""
    return yaml.safe_dump(_drop_empty(data), sort_keys=False, allow_unicode=True, default_flow_style=None, width=88)


def _drop_empty(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: new for key, old in value.items() if (new := _drop_empty(old)) not in (None, {})}
    return [_drop_empty(item) for item in value] if isinstance(value, list) else value
