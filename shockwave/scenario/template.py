"""Templates: a scenario to begin with, every key with its meaning.

The blocks are in ``template.yaml``; what depends on the profile is written from its keys.
"""

from __future__ import annotations

import json
import math
import re
import string
import typing
from collections.abc import Iterator
from importlib import resources
from typing import Any, Literal

from shockwave import OWN_DISTRIBUTION
from shockwave.registry import find
from shockwave.scenario.keys import RECORD, UNSTATED, Key, keys_of, parameters_of, profile_class, shock_keys
from shockwave.scenario.units import to_si

_EXAMPLES = {"peak_force": "100 N", "rise_time": "15 us", "duration": "150 us", "duration_ratio": "10"}
_RECORD_EXAMPLES = {"file": "pulse.csv", "times": "[0 s, 15 us, 150 us]", "forces": "[0 N, 100 N, 0 N]"}
#: Sizes that are met in chains of spheres, where no example is declared.
_BY_UNIT = {
    "s": ("10 us", "1 ms", "1 s"),
    "m": ("5 mm", "1 m"),
    "N": ("100 N",),
    "kg": ("1 g", "1 kg"),
    "Pa": ("200 GPa", "1 MPa"),
    "m/s": ("1 m/s",),
}
_BY_KIND: dict[Any, Any] = {bool: False, int: 1, float: 1, str: "text", list: [], tuple: []}
_PLAIN = re.compile(r"(?!(?i:true|false|null)\Z)[A-Za-z_][A-Za-z0-9_-]*")


def template(profile: str | None = None) -> str:
    """The text of a scenario with every key, its meaning, and a value to begin with.

    Parameters
    ----------
    profile : str, optional
        Name of a registered profile, of a plugin too. Left out: ``power-law``.

    Raises
    ------
    UnknownNameError
        When no profile has the name.
    PluginError
        When the plugin that has it is at fault.
    """
    name = profile or "power-law"
    cls = profile_class(name)
    owner = find("profiles", name).distribution
    text = resources.files(__package__).joinpath("template.yaml").read_text(encoding="utf-8")
    return string.Template(text).substitute(
        profile=_text(name),
        shock="\n".join([*_sizes(cls), *_parameters(name, cls)]),
        distribution=_text(owner),
        comment="# " if owner == OWN_DISTRIBUTION else "",
    )


def _sizes(cls: Any) -> Iterator[str]:
    """Lines of peak force, rise time, duration and their ratio, where the profile takes them."""
    own, keys = keys_of(cls), shock_keys(cls)
    # One that can bring its own force and time, but does not as it stands here.
    brings_none = not any(key.required for key in (*keys[1:], *own)) and cls().recorded_rise_time is None
    for key in keys:
        if key.name not in _EXAMPLES or (key.name == "duration_ratio" and key.name not in {one.name for one in own}):
            continue
        needed = key.required or (key.name in ("peak_force", "rise_time") and brings_none)
        fits = key.spec is None or key.spec.problem(10) is None
        yield _line("  ", needed, key, _EXAMPLES[key.name] if fits else _example(key))


def _parameters(name: str, cls: Any) -> list[str]:
    """Lines of the block ``parameters``."""
    keys = parameters_of(name, cls)
    examples = _RECORD_EXAMPLES if name == RECORD else {key.name: _example(key) for key in keys}
    lines = [_line("    ", key.required or _stated(key), key, examples[key.name]) for key in keys]
    if not lines:
        return []
    comment = "# " if all(line.lstrip().startswith("#") for line in lines) else ""
    return [f"  {comment}parameters:", *lines]


def _line(indent: str, live: bool, key: Key, value: str) -> str:
    kind = key.annotation.__name__ if isinstance(key.annotation, type) else str(key.annotation).replace("typing.", "")
    purpose = " ".join((key.purpose or kind).split())
    return f"{indent}{'' if live else '# '}{_text(key.name)}: {value}  # {purpose}"


def _stated(key: Key) -> bool:
    """Whether ``key`` has a default that can be written."""
    try:
        return key.default not in (None, UNSTATED) and bool(_text(key.default))
    except (TypeError, ValueError):
        return False


def _example(key: Key) -> str:
    """A value that ``key`` takes, as YAML: its default, an example, or else any."""
    spec = key.spec
    if _stated(key):
        return _text(key.default)
    if spec is None:
        origin = typing.get_origin(key.annotation) or key.annotation
        return _text(typing.get_args(key.annotation)[0] if origin is Literal else _BY_KIND.get(origin, 1))
    if spec.example:
        return spec.example
    ends = [
        end for end in (spec.above, spec.at_least, spec.below, spec.at_most) if end not in (None, math.inf, -math.inf)
    ]
    numbers: list[float] = [1, 2, 10, 0.5, 0, -1, sum(ends) / max(len(ends), 1)]
    for end in ends:
        numbers += [end, end + 1, end - 1, 2 * end, end / 2]
    usual = _BY_UNIT.get(spec.unit, ())
    fit = [text for text in (*usual, *map(_text, numbers)) if spec.problem(to_si(text, spec.unit)) is None]
    return f"[{fit[0]}]" if spec.samples else fit[0]


def _text(value: Any) -> str:
    """``value`` in YAML, of which JSON is a part; names need no quotes."""
    if isinstance(value, str) and _PLAIN.fullmatch(value):
        return value
    if isinstance(value, float) and abs(value) < 1e6 and value == int(value):
        return str(int(value))
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
