"""The reader: YAML text to plain data, each value with its line and column.

Only what a scenario needs of YAML is accepted: one document, a mapping of names; scalars as the core schema of
YAML 1.2 understands them; no anchors, aliases, merge keys or tags. The tree is built from parser events, so that
limits hold before anything large exists.
"""

from __future__ import annotations

import os
import re
import reprlib
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeAlias

import yaml
from attrs import Factory, define, frozen
from yaml import events

from shockwave.errors import Fault, FileAccessError, ScenarioError

__all__ = ["MOST_FAULTS", "Document", "Steps", "dotted", "parse_document", "read_document"]

#: The way from the top of a document to a value: keys of mappings and indices of lists.
Steps: TypeAlias = tuple[str | int, ...]
_Place: TypeAlias = tuple[int, int]

#: After so many faults in one file, the rest is not looked for.
MOST_FAULTS = 100
_MOST_BYTES = 2**20
_DEEPEST = 32
_MOST_NODES = 100_000
_LONGEST_INTEGER = 400

_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_WORDS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
# What breaks lines for some readers and not for others counts as unprintable, so that lines count the same for all.
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_BREAK = re.compile(r"\r\n|\r|\n")
_PLAIN_KEY = re.compile(r"[\w-]{1,60}")
_HINTS = {
    r"'\t'": "indent with spaces",
    "cannot start any token": "put text that begins with this character in quotes",
    "mapping values are not allowed here": "indent keys alike; put text that holds ': ' in quotes",
}


class _NotFiniteError(ValueError):
    """A plain scalar is a number that no float holds."""


class _StopReadingError(Exception):
    """What was found makes it useless or unsafe to read on."""


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
    _values: dict[Steps, _Place] = Factory(dict)
    _keys: dict[Steps, _Place] = Factory(dict)

    def locate(self, path: Steps, key: bool = False) -> str:
        """``file:line:column`` of the value at ``path``, or of its key; of the nearest that exists above it."""
        line, column = self.place(path, key)
        return f"{self.name}:{line}:{column}"

    def place(self, path: Steps, key: bool = False) -> tuple[int, int]:
        """Line and column, counted from 1, of what `locate` names."""
        for end in range(len(path), -1, -1):
            if key and path[:end] in self._keys:
                return self._keys[path[:end]]
            if path[:end] in self._values:
                return self._values[path[:end]]
        return (1, 1)


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
        When its text is not valid.
    """
    name = os.fspath(path)
    data = _bytes(name)
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
    bad = _UNPRINTABLE.search(text)
    if bad:
        line, column = _line_and_column(text[: bad.start()])
        problem = f"must be printable text (got the character U+{ord(bad[0]):04X}; delete it)"
        raise ScenarioError([Fault("", problem, f"{name}:{line}:{column}")])
    builder = _Builder(name)
    try:
        for event in _events(text, builder):
            builder.take(event)
        data = builder.result()
    except _StopReadingError:
        raise ScenarioError(builder.faults) from None
    if faults is None and builder.faults:
        raise ScenarioError(builder.faults)
    if faults is not None:
        faults.extend(builder.faults)
    return Document(name, data, frozenset(builder.unreadable), builder.values, builder.keys)


def dotted(path: Steps) -> str:
    """``path`` as messages write it, such as ``shock.parameters.times[3]``."""
    text = ""
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += ("." if text else "") + (step if _PLAIN_KEY.fullmatch(step) else reprlib.repr(step))
    return text


def _bytes(name: str) -> bytes:
    path = Path(name)
    try:
        if not stat.S_ISREG(path.stat().st_mode):  # reading a pipe or a device may never end
            raise FileAccessError(f"{name}: is not a file (give the path of a scenario file)")
        with path.open("rb") as file:
            return file.read(_MOST_BYTES + 1)
    except OSError as error:
        raise FileAccessError(f"{name}: cannot be read (got {error.strerror or error})") from None
    except ValueError as error:  # a NUL character in the path
        raise FileAccessError(f"{name!r}: is no path (got {error})") from None


def _too_large(name: str) -> ScenarioError:
    problem = "must be at most 1 MiB (put a long record in a CSV file, and name it under `file`)"
    return ScenarioError([Fault("", problem, f"{name}:1:1")])


def _line_and_column(before: str) -> _Place:
    lines = _BREAK.split(before)
    return len(lines), len(lines[-1]) + 1


def _events(text: str, builder: _Builder) -> Iterator[yaml.Event]:
    """The parser's events; a syntax error becomes the last fault."""
    loader = _Loader(text)
    try:
        while loader.check_event():
            yield loader.get_event()
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


def _scalar(text: str) -> Any:
    """A plain scalar by the core schema of YAML 1.2."""
    if text in _WORDS:
        return _WORDS[text]
    if _NOT_FINITE.fullmatch(text):
        raise _NotFiniteError
    if _INTEGER.fullmatch(text):
        if len(text) > _LONGEST_INTEGER:
            raise _NotFiniteError
        whole = int(text, 0 if text.startswith(("0o", "0x")) else 10)
        return whole if abs(whole) < 2**1023 else _finite(text)
    return _finite(text) if _FLOAT.fullmatch(text) else text


def _finite(text: str) -> float:
    number = float(text)
    if abs(number) == float("inf"):
        raise _NotFiniteError
    return number


_DISCARDED = object()


@define(eq=False)
class _Frame:
    """A collection that is being filled; ``key`` is None while a mapping waits for its next key."""

    path: Steps
    container: dict[str, Any] | list[Any]
    kept: bool = True
    key: Any = None

    def next_path(self) -> Steps:
        if isinstance(self.container, list):
            return (*self.path, len(self.container))
        return self.path if self.key is _DISCARDED else (*self.path, self.key)

    def put(self, value: Any) -> bool:
        """Store ``value``; whether it becomes part of the document."""
        if isinstance(self.container, list):
            self.container.append(value)
            return self.kept
        key, self.key = self.key, None
        if key is not _DISCARDED:
            self.container[key] = value
        return self.kept and key is not _DISCARDED


@define(eq=False)
class _Builder:
    """Builds the data from events and gathers faults."""

    name: str
    faults: list[Fault] = Factory(list)
    unreadable: set[Steps] = Factory(set)
    values: dict[Steps, _Place] = Factory(dict)
    keys: dict[Steps, _Place] = Factory(dict)
    _stack: list[_Frame] = Factory(list)
    _data: Any = None
    _nodes: int = 0
    _documents: int = 0

    def result(self) -> dict[str, Any]:
        if not isinstance(self._data, dict):
            line, column = self.values.get((), (1, 1))
            got = "nothing" if self._data is None else reprlib.repr(self._data)
            self._add((), f"must be a mapping, 'key: value' on each line (got {got})", line, column)
            raise _StopReadingError
        return self._data

    def take(self, event: yaml.Event) -> None:
        if isinstance(event, events.DocumentStartEvent):
            self._documents += 1
            if self._documents > 1:
                self.stop(
                    (),
                    "must be one document (got a second; put each scenario in its own file)",
                    event.start_mark,
                )
        elif isinstance(event, events.CollectionEndEvent):
            self._stack.pop()
        elif isinstance(event, events.NodeEvent):
            self._nodes += 1
            if self._nodes > _MOST_NODES:
                self.stop(
                    (),
                    f"must have at most {_MOST_NODES} values (put a long record in a CSV file)",
                    event.start_mark,
                )
            self._node(event)

    def stop(self, path: Steps, problem: str, mark: Any) -> None:
        """Add a last fault, and stop."""
        self._add(path, problem, mark.line + 1, mark.column + 1)
        raise _StopReadingError

    def _add(self, path: Steps, problem: str, line: int, column: int) -> None:
        self.faults.append(Fault(dotted(path), problem, f"{self.name}:{line}:{column}"))
        if len(self.faults) >= MOST_FAULTS:
            raise _StopReadingError

    def _fault(self, path: Steps, problem: str, event: yaml.Event) -> None:
        self._add(path, problem, event.start_mark.line + 1, event.start_mark.column + 1)

    def _node(self, event: events.NodeEvent) -> None:
        frame = self._stack[-1] if self._stack else None
        if frame is not None and isinstance(frame.container, dict) and frame.key is None:
            self._key(frame, event)
            return
        path = frame.next_path() if frame else ()
        value = self._value(event, path)
        kept = frame.put(value) if frame else True
        if frame is None:
            self._data = value
        if kept:
            self.values[path] = (event.start_mark.line + 1, event.start_mark.column + 1)
        self._open(event, value, path, kept)

    def _open(self, event: events.NodeEvent, value: Any, path: Steps, kept: bool) -> None:
        if not isinstance(event, events.CollectionStartEvent):
            return
        self._stack.append(_Frame(path, value, kept))
        if len(self._stack) > _DEEPEST:
            self.stop((), f"must be nested at most {_DEEPEST} levels deep (got more)", event.start_mark)

    def _value(self, event: events.NodeEvent, path: Steps) -> Any:
        self._refuse_extras(event, path)
        if isinstance(event, events.MappingStartEvent):
            return {}
        if isinstance(event, events.SequenceStartEvent):
            return []
        if isinstance(event, events.ScalarEvent):
            text: str = event.value
            bad = _UNPRINTABLE.search(text)
            if bad:
                self._fault(path, f"must be printable text (got the character U+{ord(bad[0]):04X})", event)
            elif event.style is not None or event.tag is not None:
                return text
            else:
                try:
                    return _scalar(text)
                except _NotFiniteError:
                    self._fault(path, f"must be finite (got {reprlib.repr(text)[1:-1]})", event)
        self.unreadable.add(path)
        return None

    def _refuse_extras(self, event: events.NodeEvent, path: Steps) -> None:
        """Anchors, aliases and tags: a scenario is plain data."""
        if isinstance(event, events.AliasEvent):
            self._fault(
                path, f"must be a value (got the alias *{event.anchor[:40]}; write the value out)", event
            )
        elif event.anchor is not None:
            self._fault(path, f"must have no anchor (got &{event.anchor[:40]}; delete it)", event)
        tag = getattr(event, "tag", None)
        if tag is not None:
            shown = reprlib.repr(tag.replace("tag:yaml.org,2002:", "!!"))
            self._fault(path, f"must have no tag (got {shown}; delete it)", event)

    def _key(self, frame: _Frame, event: events.NodeEvent) -> None:
        frame.key = _DISCARDED
        if not isinstance(event, events.ScalarEvent):
            kind = "an alias" if isinstance(event, events.AliasEvent) else "a list or mapping"
            self._fault(frame.path, f"must have names as keys (got {kind})", event)
            self._open(event, {} if isinstance(event, events.MappingStartEvent) else [], frame.path, False)
            return
        unread = len(self.unreadable)
        key = self._value(event, frame.path)
        if len(self.unreadable) > unread:
            self.unreadable.discard(frame.path)
            return
        path = (*frame.path, key)
        if not isinstance(key, str):
            got = (
                f"got {reprlib.repr(event.value)[1:-1]}; put it in quotes if it is one"
                if event.value
                else "got nothing"
            )
            self._fault(frame.path, f"must have names as keys ({got})", event)
        elif key == "<<" and event.style is None:
            self._fault(path, "must not be merged (got a merge key; write the keys out)", event)
        elif key in frame.container:
            first = self.keys.get(path)
            where = f"first in line {first[0]}; " if first else ""
            self._fault(path, f"must be given once (got it again; {where}delete one)", event)
        else:
            frame.key = key
            if frame.kept:
                self.keys[path] = (event.start_mark.line + 1, event.start_mark.column + 1)
