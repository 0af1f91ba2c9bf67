"""Keys for a record file: those that loading asks for, as far as the file shows their values, and their effects."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from attrs import asdict, fields, frozen

from shockwave.base.errors import ShockwaveError
from shockwave.base.files import read_bytes
from shockwave.base.result import VERSION, Result
from shockwave.base.text import limits, si, strong
from shockwave.profiles.tabulated import Tabulated
from shockwave.records.record_file import MOST_BYTES, Record, read_record
from shockwave.records.record_format import RecordFormat
from shockwave.records.record_processing import changes

# Messages of loading propose values as a scenario states them, or name keys whose values no file shows.
_PROPOSAL = re.compile(r"\b([a-z]+(?:_[a-z]+)?): (\[[^]]*\]|'[^']*'|-?[\w./*-]+(?: [mun]?s\b)?)")
_QUESTION = re.compile(r"\bset (?:unit: \S+, and )?(scale|area|mass|interval)\b|\b((?:time_)?unit): \S+ makes")
# Placeholders for these.
_PLACEHOLDERS = {"scale": "1", "area": "1 cm**2", "mass": "1 kg", "interval": "1 us"}
# What the user must state in place of a guess.
_QUESTIONS = {
    "scale": "newtons per unit of the file",
    "area": "loaded area",
    "mass": "moving mass",
    "interval": "sampling interval",
    "unit": "unit of the column, with scale for a voltage",
    "time_unit": "unit of the times",
    "columns": "columns of time and force",
}
# Conditions on the forces and the times under which the figures hold, for each guess.
_FORCE_CONDITIONS = {
    "scale": "1 {measured} is {scale} {unit}",
    "unit": "their unit is {unit}",
    "area": "the area is {area}",
    "mass": "the mass is {mass}",
}
_TIME_CONDITIONS = {"time_unit": "times are in {time_unit}", "interval": "the interval is {interval}"}
# Meaning of a scale, in a message.
_SCALE = re.compile(r"scale to the (\S+ per [^;)]+)")
_FORMAT = [field.name for field in fields(RecordFormat) if field.init]
_KEYS = [*_FORMAT, "baseline", "crop", "negative"]
# A sampling interval [s] among the settings of an instrument: in the line of its name, or below it as the last cell.
_INTERVAL = re.compile(rb"(?i)(?:interval|increment|t ?inc|delta_x)\W+(?:[^\n]*[,;\t])?([0-9.]+(?:e[-+]?[0-9]+)?)\W*\n")
# Rounds of proposals; each message proposes one key or more.
_ROUNDS = 12


@frozen(kw_only=True, eq=False)
class RecordKeys(Result):
    """Proposed keys for a record file.

    Attributes
    ----------
    file : str
        The record.
    keys : dict of str to str
        Values as a scenario states them, by the names of the keys.
    guesses : dict of str to str
        What the user must state in place of a guess, because the file does not show it, by the names of the keys.
    without : dict of str to (dict of str to float)
        Peak force [N], rise time [s] and impulse [N s] without a step of the processing, and negative forces set to
        zero, by the names of the keys.
    pulse : dict of str to float, or None
        These figures with all keys; None if the record is refused.
    problem : str
        The error that is left then.
    warnings : tuple of str
        What is unusual in the record.
    """

    file: str
    keys: dict[str, str]
    guesses: dict[str, str]
    without: dict[str, Mapping[str, float]]
    pulse: Mapping[str, float] | None
    problem: str
    warnings: tuple[str, ...]

    _brief = ("file", "problem")
    _picture = "shockwave.pictures.histories:record_keys"

    @property
    def parameters(self) -> dict[str, Any]:
        """Values by their keys, as `Tabulated.from_file` takes them."""
        return _values(self.keys)

    @property
    def record(self) -> Record:
        """The samples in newtons, with the sign, and without baseline and crop."""
        return _read(self.file, self.keys)

    @property
    def force_condition(self) -> str:
        """The guesses on which the forces rest, such as ``if 1 V is 1 N``; empty without them."""
        return self._condition(_FORCE_CONDITIONS)

    @property
    def time_condition(self) -> str:
        """The guesses on which the times rest, such as ``if times are in s``; empty without them."""
        return self._condition(_TIME_CONDITIONS)

    def _condition(self, conditions: Mapping[str, str]) -> str:
        names = {"unit": "N", "measured": self.guesses.get("scale", "").rpartition(" per ")[2], **self.keys}
        texts = [text.format_map(names) for key, text in conditions.items() if key in self.guesses]
        return f"if {' and '.join(texts)}" if texts else ""

    def shock(self, folder: str | None = None) -> str:
        """The block of a scenario, which lies in a folder, with the keys, and the effect of each as a comment."""
        name = self.file if folder is None else os.path.relpath(self.file, folder or os.curdir)
        comments = {key: f"a guess: state the {question}" for key, question in self.guesses.items()}
        if self.pulse is not None:
            comments |= {key: changes(figures, self.pulse) for key, figures in self.without.items()}
        lines = [f"file: {name}"]
        for key, value in self.keys.items():
            lines.append(f"{key}: {value}  # {comments[key]}" if comments.get(key) else f"{key}: {value}")
        return "shock:\n  profile: tabulated\n  parameters:\n" + "".join(f"    {line}\n" for line in lines)

    def to_dict(self) -> dict[str, Any]:
        """Document printed by ``shockwave record --json``."""
        return {**VERSION, **asdict(self), "keys": self.parameters}

    def __str__(self) -> str:
        answer = "no pulse with these keys"
        if self.pulse is not None:
            units = {"peak_force": "N", "rise_time": "s", "impulse": "N s"}
            answer = ", ".join(f"{name.replace('_', ' ')} {si(self.pulse[name], units[name])}" for name in units)
        warnings = limits([*filter(None, [self.problem]), *self.warnings])
        subject = ", ".join(filter(None, [self.file, self.force_condition, self.time_condition]))
        return "\n".join([strong(f"{subject}: {answer}"), *warnings, "", self.shock().rstrip()])


def propose_keys(file: str | os.PathLike[str]) -> RecordKeys:
    """Propose keys for a record file, by following the messages of loading it.

    Raises
    ------
    FileAccessError
        If the file cannot be read.
    """
    path, keys, guesses, problem, pulse = os.fspath(file), dict[str, str](), set[str](), "", None
    questions = dict(_QUESTIONS)
    content = read_bytes(Path(path), MOST_BYTES)
    for _ in range(_ROUNDS):
        try:
            pulse = Tabulated.from_file(path, **_values(keys))
            problem, messages = "", "\n".join(pulse.alarms)
        except ShockwaveError as error:
            pulse, problem = None, str(error)
            messages = "\n".join(fault.problem for fault in error.faults)
        if scale := _SCALE.search(messages):
            questions["scale"] = scale[1]
        more = _proposals(messages, path, keys, guesses, content)
        if not more:
            break
        keys |= more
    without = {}
    for omitted in {"baseline", "crop"} & keys.keys():
        others = {"negative": "zero"} | {key: value for key, value in keys.items() if key != omitted}
        with suppress(ShockwaveError):
            without[omitted] = Tabulated.from_file(path, **_values(others)).figures
    return RecordKeys(
        file=path,
        keys={key: keys[key] for key in _KEYS if key in keys},
        guesses={key: questions[key] for key in _KEYS if key in guesses},
        without=without,
        pulse=pulse.figures if pulse else None,
        problem=problem,
        warnings=pulse.alarms if pulse else (),
    )


def _proposals(messages: str, path: str, keys: dict[str, str], guesses: set[str], content: bytes) -> dict[str, str]:
    """Keys in messages that are not among ``keys``; those that are guesses are added to these."""
    pairs = [(key, value) for key, value in _PROPOSAL.findall(messages) if key in _KEYS and key not in keys]
    proposals = dict(pairs)
    for key in filter(None, chain(*_QUESTION.findall(messages))):
        guesses.add(key)
        proposals.setdefault(key, _PLACEHOLDERS.get(key, keys.get(key, "")))
    if "interval" in proposals and (stated := _INTERVAL.search(content)):
        proposals["interval"] = f"{float(stated[1]):g} s"
        guesses.remove("interval")
    if len(choices := [value for key, value in pairs if key == "columns"]) > 1:
        guesses.add("columns")
        proposals["columns"] = max(choices, key=lambda columns: _range(path, keys | {"columns": columns}))
    if proposals.keys() & {"sign", "baseline", "crop", "negative"}:  # windows depend on the sign
        forces = _read(path, keys).forces
        falls = np.median(forces) - forces.min() > forces.max() - np.median(forces)
        proposals.pop("sign", None)
        if falls:
            proposals = {"sign": "-1"} if "sign" not in keys else {}
    return {key: value for key, value in proposals.items() if key not in keys}


def _range(path: str, keys: dict[str, str]) -> float:
    """Range of the values in a column, whatever their unit; 0 for numbers of samples and columns without numbers."""
    with suppress(ShockwaveError):
        forces = _read(path, {"time_unit": "s"} | keys | {"unit": "N", "scale": "1"}).forces
        return 0.0 if (np.diff(forces) > 0).all() else float(np.ptp(forces))
    return -1.0


def _values(keys: dict[str, str]) -> dict[str, Any]:
    return {key: yaml.safe_load(value) for key, value in keys.items()}


def _read(path: str, keys: dict[str, str]) -> Record:
    values = _values(keys)
    return read_record(Path(path), RecordFormat(**{key: values[key] for key in _FORMAT if key in values}))
