"""The reader: YAML text to plain data, each value with its line and column.

Only what a scenario needs of YAML is accepted: one document, a mapping of names; scalars as the core schema
of YAML 1.2 understands them; no anchors, aliases, merge keys or tags. The tree is built from parser events,
so that limits hold before anything large exists.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from typing import Any

import yaml
from attrs import Factory, frozen

from shockwave.errors import Fault, ScenarioError
from shockwave.files import open_regular
from shockwave.scenario.yaml_tree import (
    MOST_FAULTS,
    UNPRINTABLE,
    Place,
    Steps,
    StopReadingError,
    TreeBuilder,
    dotted,
)

__all__ = ["MOST_FAULTS", "Document", "Steps", "dotted", "parse_document", "read_document"]

_MOST_BYTES = 2**20
_BREAK = re.compile(r"\r\n|\r|\n")
_HINTS = {
    r"'\t'": "indent with spaces",
    "cannot start any token": "put text that begins with this character in quotes",
    "mapping values are not allowed here": "indent keys alike; put text that holds ': ' in quotes",
}


class _Loader(yaml.SafeLoader):
    """The parser in Python: unlike libyaml's it is the same wherever this runs, in its messages too."""

    def scan_to_next_token(self) -> None:
        # As in YAML 1.2 a tab may stand between tokens, before a comment too, but never indents.
        while True:
            super().scan_to_next_token()
            if self.peek() != "\t" or not (self.flow_level or not self.allow_simple_key):
                return
            while self.peek() in " \t":
                self.forward()


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

    def place(self, path: Steps, key: bool = False) -> tuple[int, int]:
        """Line and column, counted from 1, of what `locate` names."""
        for end in range(len(path), -1, -1):
            if key and path[:end] in self._keys:
                return self._keys[path[:end]]
            if path[:end] in self._values:
                return self._values[path[:end]]
        return (1, 1)

    def having(self, values: Mapping[Steps, Any], places: Mapping[Steps, Place] | None = None) -> Document:
        """The document with other ``values`` at their paths; mappings on the way are made where there is nothing.

        A value below something else than a mapping is left out: what is wrong there is found without it. ``places`` are
        where they stand, if they are to be located elsewhere than what is above them.
        """
        data = dict(self.data)
        for path, value in values.items():
            block: Any = data
            for step in path[:-1]:
                inner = block.get(str(step))
                if inner is not None and not isinstance(inner, dict):
                    break
                block[str(step)] = dict(inner or {})
                block = block[str(step)]
            else:
                block[str(path[-1])] = value
        places = places or {}
        changed = {path: place for path, place in self._values.items() if path not in values} | dict(places)
        return Document(self.name, data, self.unreadable, changed, {**self._keys, **places})


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
        When the file cannot be read, or exceeds 1 MiB.
    ScenarioError
        When its text is not valid.
    """
    name = os.fspath(path)
    with open_regular(name) as file:
        data = file.read(_MOST_BYTES + 1)
    if len(data) > _MOST_BYTES:
        raise _too_large(name)
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        line, column = _line_and_column(data[: error.start].decode("utf-8"))
        got = f"got the byte 0x{data[error.start]:02x}; save the file as UTF-8"
        raise ScenarioError([Fault("", f"must be UTF-8 text ({got})", f"{name}:{line}:{column}")]) from None
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
    if len(text) > _MOST_BYTES:
        raise _too_large(name)
    text = text.removeprefix("\ufeff")
    bad = UNPRINTABLE.search(text)
    if bad:
        line, column = _line_and_column(text[: bad.start()])
        problem = f"must be printable text (got the character U+{ord(bad[0]):04X}; delete it)"
        raise ScenarioError([Fault("", problem, f"{name}:{line}:{column}")])
    builder = TreeBuilder(name)
    try:
        for event in _events(text, builder):
            builder.take(event)
        data = builder.result()
    except StopReadingError:
        raise ScenarioError(builder.faults) from None
    if faults is None and builder.faults:
        raise ScenarioError(builder.faults)
    if faults is not None:
        faults.extend(builder.faults)
    return Document(name, data, frozenset(builder.unreadable), builder.values, builder.keys)


def _too_large(name: str) -> ScenarioError:
    problem = "must be at most 1 MiB (put a long record in a CSV file, and name it under `file`)"
    return ScenarioError([Fault("", problem, f"{name}:1:1")])


def _line_and_column(before: str) -> Place:
    lines = _BREAK.split(before)
    return len(lines), len(lines[-1]) + 1


def _events(text: str, builder: TreeBuilder) -> Iterator[yaml.Event]:
    """The parser's events; a syntax error becomes the last fault."""
    loader = _Loader(text)
    try:
        while loader.check_event():
            yield loader.get_event()  # type: ignore[no-untyped-call]
    except yaml.MarkedYAMLError as error:
        problem = error.problem or error.context or "something else"
        hint = next((f"; {hint}" for part, hint in _HINTS.items() if part in problem), "")
        mark = error.problem_mark or error.context_mark or loader.get_mark()
        builder.stop((), f"must be YAML (got: {problem}{hint})", mark)
    except (ValueError, OverflowError):
        # PyYAML makes characters of escapes, and numbers of versions, without asking whether there are such.
        builder.stop((), "must be YAML (got: an escape or a version that does not exist)", loader.get_mark())
    finally:
        loader.dispose()
