"""Scenarios to start from: short ones, those with every key and its meaning, and examples.

The blocks are in ``short_template.yaml`` and ``full_template.yaml``; the lines that depend on the profile are written
from its keys. The examples are in the folder ``examples``.
"""

from __future__ import annotations

import json
import re
import string
import typing
from collections.abc import Iterator
from importlib import resources
from typing import Any, Literal

from shockwave import OWN_DISTRIBUTION
from shockwave.base.quantity_fields import Declaration
from shockwave.base.text import wrap
from shockwave.registry.registry import find, load
from shockwave.scenario.block_keys import RECORD, Key, keys_of, parameters_of, shock_keys

_SAMPLES_EXAMPLE = {"times": "[0 s, 15 us, 60 us]", "forces": "[0 N, 30 N, 0 N]"}
_RECORD_EXAMPLES = _SAMPLES_EXAMPLE | {"file": "pulse.csv", "columns": "[1, 2]", "time_unit": "ms", "unit": "kN"}
_BY_KIND: dict[Any, Any] = {bool: False, int: 1, float: 1, str: "text", list: [], tuple: []}
# Columns of a line, and least columns of a comment.
_WIDTH = 80
_NARROW = 20
# A line with a comment behind a value, and a line that is a comment.
_COMMENTED = re.compile(r"( *(?:# *)?[^#]*?  # |# )(.+)")
# A sign and the blank before its number, which a line does not end with.
_BOUND = re.compile(r"([<>]=?) ")
_PLAIN = re.compile(r"(?!(?i:true|false|null)\Z)[A-Za-z_][A-Za-z0-9_-]*")


def template(profile: str | None = None, full: bool = False) -> str:
    """Text of a scenario with initial values.

    Parameters
    ----------
    profile : str, optional
        Name of a registered profile, which may come from a plugin. Default: ``half-sine``, or ``power-law`` in full.
    full : bool
        Whether it has every key and its meaning; those that may be omitted are comments.

    Raises
    ------
    UnknownNameError
        When no profile has the name.
    PluginError
        When the plugin that registers it is faulty.
    """
    entry = find("profiles", profile or ("power-law" if full else "half-sine"))
    name, owner, cls = entry.name, entry.distribution, load("profiles", entry.name)
    file = resources.files(__package__).joinpath(f"{'full' if full else 'short'}_template.yaml")
    filled = string.Template(file.read_text(encoding="utf-8")).substitute(
        profile=_text(name),
        shock="\n".join([*_sizes(cls), *_parameters(name, cls)]),
        distribution=_text(owner),
        comment="# " if owner == OWN_DISTRIBUTION else "",
        time=_time(cls),
    )
    if not full:
        head, key, rest = filled.partition("\nname:")
        filled = head + key + re.sub(r"\n *#.*|\n  parameters:(?=(\n +#.*)*(\n\S|$))", "", rest)
    return "".join(f"{part}\n" for line in filled.splitlines() for part in _wrap(line))


def example(name: str) -> dict[str, str]:
    """Text of each file of an example, a scenario and the data that it needs, by the name of the file."""
    files = resources.files(__package__).joinpath("examples").iterdir()
    return {file.name: file.read_text(encoding="utf-8") for file in files if file.name.startswith(f"{name}.")}


def _wrap(line: str) -> list[str]:
    """``line`` with a long comment continued below itself."""
    match = _COMMENTED.fullmatch(line)
    if len(line) <= _WIDTH or match is None:
        return [line]
    first, *rest = wrap(_BOUND.sub("\\1\xa0", match[2]), max(_WIDTH - len(match[1]), _NARROW))
    comment = " " * (len(match[1]) - 2) + "# "
    return [part.replace("\xa0", " ") for part in (match[1] + first, *(comment + part for part in rest))]


def _sizes(cls: Any) -> Iterator[str]:
    """Lines of peak force, rise time, duration and duration ratio, as far as the profile takes them."""
    parameter_keys, keys = keys_of(cls), shock_keys(cls)
    # A profile that can define its own force and time, but does not with its defaults.
    brings_none = not any(key.required for key in (*keys[1:], *parameter_keys)) and cls().recorded_rise_time is None
    needed = {key.name for key in keys if key.required} | ({"peak_force", "rise_time"} if brings_none else set())
    if "rise_time" in needed:
        needed = needed - {"rise_time"} | {_time(cls)}
    for key in keys[1:-1]:
        if key.name != "duration_ratio" or key in parameter_keys:
            yield _line("  ", key.name in needed, key, _example(key))


def _time(cls: Any) -> str:
    """Key of the time of a shock: the total duration if the profile has its own duration ratio."""
    return "rise_time" if any(key.name == "duration_ratio" for key in keys_of(cls)) else "duration"


def _parameters(name: str, cls: Any) -> list[str]:
    """Lines of the ``parameters`` block."""
    keys = parameters_of(name, cls)
    examples = {key.name: _example(key) for key in keys} | (_RECORD_EXAMPLES if name == RECORD else {})
    # those of a file are comments
    live = {key.name for key in keys_of(cls) if key.required or _has_printable_default(key)}
    lines = [_line("    ", key.name in live, key, examples[key.name]) for key in keys]
    return ["  parameters:", *lines] if lines else []


def _line(indent: str, live: bool, key: Key, value: str) -> str:
    purpose = f"  # {' '.join(key.purpose.split())}" if key.purpose else ""
    return f"{indent}{'' if live else '# '}{key.name}: {value}{purpose}"


def _has_printable_default(key: Key) -> bool:
    """Whether ``key`` has a default that can be written."""
    return isinstance(key.default, bool | int | float | str) and "inf" not in repr(key.default)


def _example(key: Key) -> str:
    """A value that ``key`` accepts, as YAML: its default, its example, or any other."""
    if _has_printable_default(key):
        return _text(key.default)
    if key.spec is not None:
        fit = key.spec.example or f"{_example_number(key.spec):g}"
        return f"[{fit}]" if key.spec.samples else fit
    # of a union, the first type
    kind = next((one for one in typing.get_args(key.annotation) if typing.get_origin(one) is Literal), key.annotation)
    origin = typing.get_origin(kind) or kind
    return _text(typing.get_args(kind)[0] if origin is Literal else _BY_KIND.get(origin, 1))


def _example_number(spec: Declaration) -> float:
    """A number in the range of ``spec``."""
    middle = sum(bound for _, bound in spec.bounds) / max(len(spec.bounds), 1)
    return next(number for number in (1.0, 10.0, middle, middle + 1, middle - 1) if spec.problem(number) is None)


def _text(value: Any) -> str:
    """``value`` in YAML, which includes JSON; names need no quotes."""
    if isinstance(value, str) and _PLAIN.fullmatch(value):
        return value
    if isinstance(value, float) and abs(value) < 1e6 and value == int(value):
        return str(int(value))
    return json.dumps(value, ensure_ascii=False)
