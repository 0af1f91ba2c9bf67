"""The tree: plain data built from the events of a YAML parser, within limits, every value with its place."""

from __future__ import annotations

import math
import re
import reprlib
from typing import Any, TypeAlias

import yaml
from attrs import Factory, define
from yaml import events

from shockwave.errors import Fault

__all__ = ["MOST_FAULTS", "UNPRINTABLE", "Place", "Steps", "StopReadingError", "TreeBuilder", "dotted"]

#: The way from the top of a document to a value: keys of mappings and indices of lists.
Steps: TypeAlias = tuple[str | int, ...]
Place: TypeAlias = tuple[int, int]

#: After so many faults in one file, the rest is not looked for.
MOST_FAULTS = 100
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
# What breaks lines for some programs and not for others is unprintable too, so that all count the same lines.
UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_PLAIN_KEY = re.compile(r"[\w-]{1,60}")


class _NotFiniteError(ValueError):
    """A plain scalar is a number that no float holds."""


class StopReadingError(Exception):
    """What was found makes it useless or unsafe to read on."""


def dotted(path: Steps) -> str:
    """``path`` as messages write it, such as ``shock.parameters.times[3]``."""
    text = ""
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += ("." if text else "") + (step if _PLAIN_KEY.fullmatch(step) else reprlib.repr(step))
    return text


def _scalar(text: str) -> Any:
    """A plain scalar by the core schema of YAML 1.2."""
    if text in _WORDS:
        return _WORDS[text]
    if _NOT_FINITE.fullmatch(text):
        raise _NotFiniteError
    number: int | float
    if _INTEGER.fullmatch(text):
        if len(text) > _LONGEST_INTEGER:
            raise _NotFiniteError
        number = int(text, 0 if text.startswith(("0o", "0x")) else 10)
    elif _FLOAT.fullmatch(text):
        number = float(text)
    else:
        return text
    try:
        finite = math.isfinite(number)
    except OverflowError:
        finite = False
    if not finite:
        raise _NotFiniteError
    return number


def _place(event: yaml.Event) -> Place:
    mark: Any = event.start_mark
    return mark.line + 1, mark.column + 1


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
class TreeBuilder:
    """Builds the data from events and gathers faults."""

    name: str
    faults: list[Fault] = Factory(list)
    unreadable: set[Steps] = Factory(set)
    values: dict[Steps, Place] = Factory(dict)
    keys: dict[Steps, Place] = Factory(dict)
    _stack: list[_Frame] = Factory(list)
    _data: Any = None
    _nodes: int = 0
    _documents: int = 0

    def result(self) -> dict[str, Any]:
        if not isinstance(self._data, dict):
            line, column = self.values.get((), (1, 1))
            got = "nothing" if self._data is None else reprlib.repr(self._data)
            self._add((), f"must be a mapping, 'key: value' on each line (got {got})", line, column)
            raise StopReadingError
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
        raise StopReadingError

    def _add(self, path: Steps, problem: str, line: int, column: int) -> None:
        self.faults.append(Fault(dotted(path), problem, f"{self.name}:{line}:{column}"))
        if len(self.faults) >= MOST_FAULTS:
            raise StopReadingError

    def _fault(self, path: Steps, problem: str, event: yaml.Event) -> None:
        self._add(path, problem, *_place(event))

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
            self.values[path] = _place(event)
        else:  # the path is that of the parent
            self.unreadable.discard(path)
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
            bad = UNPRINTABLE.search(text)
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
            self._fault(path, f"must be a value (got the alias *{str(event.anchor)[:40]}; write the value out)", event)
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
                self.keys[path] = _place(event)
