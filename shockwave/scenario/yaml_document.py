"""The reader: YAML text to plain data, each value with its line and column.

Only what a scenario needs of YAML is accepted: one document, a mapping of names; scalars as the core schema
of YAML 1.2 understands them; no anchors, aliases or tags.
"""

from __future__ import annotations

import math
import os
import re
import reprlib
from collections.abc import Mapping
from typing import Any, ClassVar, TypeAlias

import yaml
from attrs import Factory, define, frozen

from shockwave.errors import Fault, ScenarioError
from shockwave.files import open_regular

#: The way from the top of a document to a value: keys of mappings and indices of lists.
Steps: TypeAlias = tuple[str | int, ...]
Place: TypeAlias = tuple[int, int]

_MOST_BYTES = 2**20
_MOST_VALUES = 100_000
_DEEPEST = 32
_HINTS = {
    r"'\t'": "indent with spaces",
    "cannot start any token": "put text that begins with this character in quotes",
    "mapping values are not allowed here": "indent keys alike; put text that holds ': ' in quotes",
    "found another document": "put each scenario in its own file",
    "recursion": f"nest at most {_DEEPEST} levels deep",
}
_BREAK = re.compile(r"\r\n|\r|\n")
# In YAML a tab may stand between tokens, which PyYAML refuses, but never indents.
_TAB_BETWEEN = re.compile(r"(?<=\S) *\t[ \t]*")
# What breaks lines for some programs and not for others is unprintable too, so that all count the same lines.
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_PLAIN_KEY = re.compile(r"[\w-]{1,60}")


def dotted(path: Steps) -> str:
    """``path`` as messages write it, such as ``shock.parameters.times[3]``."""
    text = ""
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += ("." if text else "") + (step if _PLAIN_KEY.fullmatch(step) else reprlib.repr(step))
    return text


@frozen(eq=False)
class Document:
    """A document that was read.

    Attributes
    ----------
    name : str
        What the file is called in messages.
    data : dict
        Plain mappings, lists, text, numbers, truth values and None.
    unreadable : frozenset
        Where a value could not be read, a fault was reported, and None stands in its place.
    """

    name: str
    data: dict[str, Any]
    unreadable: frozenset[Steps] = frozenset()
    _values: dict[Steps, Place] = Factory(dict)
    _keys: dict[Steps, Place] = Factory(dict)

    def locate(self, path: Steps, key: bool = False) -> str:
        """``file:line:column`` of the value at ``path``, or of its key; else of the nearest above it."""
        line, column = self.place(path, key)
        return f"{self.name}:{line}:{column}"

    def holds(self, path: Steps) -> bool:
        """Whether there is a value at ``path``."""
        return path in self._values

    def place(self, path: Steps, key: bool = False) -> Place:
        """Line and column, counted from 1, of what `locate` names."""
        for end in range(len(path), -1, -1):
            if key and path[:end] in self._keys:
                return self._keys[path[:end]]
            if path[:end] in self._values:
                return self._values[path[:end]]
        return (1, 1)

    def having(self, values: Mapping[Steps, Any], place: Place | None = None) -> Document:
        """The document with other ``values`` at their paths; mappings on the way are made where there is nothing.

        A value below something else than a mapping is left out: what is wrong there is found without it. ``place`` is
        where the values stand, if not where what is above them does.
        """
        data = dict(self.data)
        for path, value in values.items():
            block: Any = data
            for step in path[:-1]:
                inner = block.get(step)
                if inner is not None and not isinstance(inner, dict):
                    break
                block[step] = dict(inner or {})
                block = block[step]
            else:
                block[path[-1]] = value
        places = dict.fromkeys(values, place) if place is not None else {}
        kept = {path: own for path, own in self._values.items() if path not in values}
        return Document(self.name, data, self.unreadable, kept | places, self._keys | places)


def read_document(path: str | os.PathLike[str], faults: list[Fault] | None = None) -> Document:
    """The document in a file.

    Parameters
    ----------
    path : path-like
        A regular file of UTF-8 text, at most 1 MiB; messages call it by this name.
    faults : list, optional
        As for `parse_document`.

    Raises
    ------
    FileAccessError
        When the file cannot be read.
    ScenarioError
        When it is larger, or its text is not valid.
    """
    name = os.fspath(path)
    with open_regular(path) as file:
        data = file.read(_MOST_BYTES + 1)
    if len(data) > _MOST_BYTES:
        problem = "must be at most 1 MiB (put a long record in a CSV file, and name it under `file`)"
        raise ScenarioError([Fault("", problem, f"{name}:1:1")])
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        *lines, last = data[: error.start].decode().split("\n")
        problem = f"must be UTF-8 text (got the byte 0x{data[error.start]:02x}; save the file as UTF-8)"
        raise ScenarioError([Fault("", problem, f"{name}:{len(lines) + 1}:{len(last) + 1}")]) from None
    return parse_document(text, name, faults)


def parse_document(text: str, name: str, faults: list[Fault] | None = None) -> Document:
    """The document in ``text``.

    Parameters
    ----------
    text : str
        YAML.
    name : str
        What messages call the document.
    faults : list, optional
        Takes up the faults that leave the rest readable; left out, they are raised too.

    Raises
    ------
    ScenarioError
        With all faults found, in their order in the text.
    """
    if bad := _UNPRINTABLE.search(text):
        lines = _BREAK.split(text[: bad.start()])
        problem = f"must be printable text (got the character U+{ord(bad[0]):04X}; delete it)"
        raise ScenarioError([Fault("", problem, f"{name}:{len(lines)}:{len(lines[-1]) + 1}")])
    root = _composed(text, name)
    walk = _Walk(name)
    data = walk.value(root, ())
    if not isinstance(data, dict):
        got = "nothing" if data is None else reprlib.repr(data)
        walk.fault((), f"must be a mapping, 'key: value' on each line (got {got})", root.start_mark)
    if walk.faults and (faults is None or not isinstance(data, dict)):
        raise ScenarioError(walk.faults)
    if faults is not None:
        faults += walk.faults
    return Document(name, data, frozenset(walk.unreadable), walk.values, walk.keys)


# ---------------------------------------------------------------- text to nodes


class _Loader(yaml.SafeLoader):
    """The parser in Python: unlike libyaml's it is the same wherever this runs, in its messages too."""

    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}  # type: ignore[misc]

    def _refuse(self) -> None:
        problem = "an anchor, an alias or a tag; write the value out"
        raise yaml.MarkedYAMLError(problem=problem, problem_mark=self.get_mark())

    fetch_anchor = fetch_alias = fetch_tag = _refuse


_TEXT = _Loader.DEFAULT_SCALAR_TAG
_NUMBER = r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|0o[0-7]+|0x[0-9a-fA-F]+"
_NOT_FINITE = r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)"
for _tag, _pattern, _first in (
    ("number", f"{_NUMBER}|{_NOT_FINITE}", "-+.0123456789"),
    ("truth", "true|True|TRUE|false|False|FALSE", "tTfF"),
    ("nothing", "|~|null|Null|NULL", ["", *"~nN"]),
):
    _Loader.add_implicit_resolver(_tag, re.compile(rf"({_pattern})\Z"), list(_first))


def _composed(text: str, name: str) -> yaml.Node:
    """The node at the top; an empty scalar where there is none."""
    loader = _Loader(_TAB_BETWEEN.sub(lambda found: " " * len(found[0]), text))
    start = loader.get_mark()
    try:
        if text.count(",") + text.count("\n") > _MOST_VALUES:  # one of these stands behind nearly every value
            raise ValueError(f"more than {_MOST_VALUES} values; put a long record in a CSV file")
        found: yaml.Node | None = loader.get_single_node()
        return found or yaml.ScalarNode("nothing", "", start)
    # PyYAML recurses without a limit, and makes characters of escapes without asking whether there are such.
    except (yaml.MarkedYAMLError, RecursionError, ValueError, OverflowError) as error:
        got = str(getattr(error, "problem", None) or error)
        hint = next((f"; {hint}" for part, hint in _HINTS.items() if part in got), "")
        mark = getattr(error, "problem_mark", None) or loader.get_mark()
        problem = f"must be YAML (got: {got}{hint})"
        raise ScenarioError([Fault("", problem, f"{name}:{mark.line + 1}:{mark.column + 1}")]) from None


# ---------------------------------------------------------------- nodes to data


def _number(text: str) -> int | float:
    """A finite number; raises ValueError or OverflowError for one that no float holds."""
    kind = float if text.lstrip("+-").strip("0123456789") else int
    number = int(text, 0) if text.startswith(("0o", "0x")) else kind(text)
    if not math.isfinite(number):
        raise OverflowError
    return number


@define(eq=False)
class _Walk:
    """Turns nodes into plain data and gathers places and faults."""

    name: str
    faults: list[Fault] = Factory(list)
    unreadable: set[Steps] = Factory(set)
    values: dict[Steps, Place] = Factory(dict)
    keys: dict[Steps, Place] = Factory(dict)

    def value(self, node: yaml.Node, path: Steps) -> Any:
        """The data of a node; None where it could not be read."""
        self.values[path] = node.start_mark.line + 1, node.start_mark.column + 1
        if isinstance(node, yaml.ScalarNode):
            return self._scalar(node, path)
        if len(path) >= _DEEPEST:
            self.unreadable.add(path)
            self.fault(path, f"must be nested at most {_DEEPEST} levels deep (got more)", node.start_mark)
            return None
        if isinstance(node, yaml.SequenceNode):
            return [self.value(inner, (*path, index)) for index, inner in enumerate(node.value)]
        data: dict[str, Any] = {}
        for key, inner in node.value:
            below = (*path, key.value)
            if key.tag != _TEXT or _UNPRINTABLE.search(key.value):
                got = f"{reprlib.repr(key.value)[1:-1]}; put it in quotes if it is one" if key.value else "nothing"
                self.fault(path, f"must have names as keys (got {got})", key.start_mark)
            elif key.value in data:
                got = f"got it again; first in line {self.keys[below][0]}; delete one"
                self.fault(below, f"must be given once ({got})", key.start_mark)
            else:
                self.keys[below] = key.start_mark.line + 1, key.start_mark.column + 1
                data[key.value] = self.value(inner, below)
        return data

    def _scalar(self, node: yaml.ScalarNode, path: Steps) -> Any:
        text: str = node.value
        if node.tag == "nothing":
            return None
        if node.tag == "truth":
            return text.lower() == "true"
        try:
            if node.tag == "number":
                return _number(text)
            if not _UNPRINTABLE.search(text):
                return text
            problem = "must be printable text (got an escape of a character that is not)"
        except (ValueError, OverflowError):
            problem = f"must be finite (got {reprlib.repr(text)[1:-1]})"
        self.unreadable.add(path)
        self.fault(path, problem, node.start_mark)
        return None

    def fault(self, path: Steps, problem: str, mark: yaml.Mark) -> None:
        """Add what is wrong at ``path``."""
        self.faults.append(Fault(dotted(path), problem, f"{self.name}:{mark.line + 1}:{mark.column + 1}"))
