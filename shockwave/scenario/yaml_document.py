"""Reader of YAML text: plain data, with the line and column of each value.

Only the part of YAML that a scenario needs is accepted: one document, which is a mapping of names; scalars are text,
decimal numbers, truth values and null; anchors, aliases and tags are errors.
"""

from __future__ import annotations

import os
import re
import sys
from collections import ChainMap
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, ClassVar

import yaml
from attrs import Factory, define, evolve

from shockwave.base.errors import Fault, ScenarioError, Steps, UsageError
from shockwave.base.files import open_regular
from shockwave.base.quantity_fields import text_of
from shockwave.base.units import COMMA

#: Name of standard input in messages.
STDIN = "<stdin>"
# Size of a file [bytes]; longer records belong in a CSV file.
_MOST_BYTES = 2**20
# Values in a document: a bound on the time of the parser.
_MOST_VALUES = 100_000
# Levels of nested values, more than any block has.
_MOST_LEVELS = 50
# Digits of a whole number; a longer one is a float.
_MOST_DIGITS = 300
_HINTS = {
    r"'\t'": "use spaces",
    "cannot start any token": "put text that begins with this character in quotes",
    "mapping values are not allowed here": "indent keys alike; put text that holds ': ' in quotes",
    "but got '['": "put text that holds brackets in quotes, and a comma between values",
    "found another document": "put each scenario in its own file",
    "recursion": "nest fewer levels",
}
_BREAK = re.compile(r"\r\n|\r|\n")
# Characters that only some programs treat as line breaks count as unprintable: line numbers are then unambiguous.
_UNPRINTABLE = "[^\t\n\r\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
_ASCII_UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e]")


@define(eq=False)
class Document:
    """A document in YAML.

    Attributes
    ----------
    name : str
        Name of the file in messages.
    data : dict
        Plain mappings, lists, text, numbers, truth values and None.
    faults : list of Fault
        Errors that leave the rest readable, in their order in the text.
    values, keys : dict
        Places at which the values and the keys begin: marks in the text, or options that give them.
    names_files : bool
        Whether it may name files: false for text that came from elsewhere, such as over a network.
    folder : pathlib.Path
        Folder of these files, unless the document is a file itself.
    source : str or dict
        Its text, or all of its data if options have changed them.
    """

    name: str
    data: dict[str, Any]
    faults: list[Fault] = Factory(list)
    values: dict[Steps, yaml.Mark | str] = Factory(dict)
    keys: dict[Steps, yaml.Mark | str] = Factory(dict)
    names_files: bool = True
    folder: Path = Path()
    source: str | dict[str, Any] = ""

    @property
    def text(self) -> str:
        """The document as YAML; empty for one that was made from a mapping."""
        if isinstance(self.source, str):
            return self.source
        return str(yaml.safe_dump(self.source, sort_keys=False, allow_unicode=True, default_flow_style=None, width=88))

    def place(self, fault: Fault) -> Fault:
        """``fault`` with the place of its value or key, or of the nearest key above, unless it has a place."""
        if fault.location:  # in a record, a file of its own
            return fault
        at_key = fault.at_key or fault.steps not in self.values
        marks = ChainMap(self.keys, self.values) if at_key else self.values
        blocks = (fault.steps[:end] for end in range(len(fault.steps), -1, -1))
        mark = next((marks[block] for block in blocks if block in marks), None)
        if isinstance(mark, str):
            invalid = fault.exit_code == ScenarioError.exit_code
            return evolve(fault, location=mark, exit_code=UsageError.exit_code if invalid else fault.exit_code)
        return evolve(fault, location=_location(self.name, mark) if mark else self.name and f"{self.name}:1:1")

    def with_values(self, values: Mapping[Steps, Any], place: yaml.Mark | str | None = None) -> Document:
        """The document with other ``values`` at their paths; missing mappings along the paths are created.

        A value of None deletes its key.

        A value below something that is not a mapping, or beyond the end of a list, is ignored, because the loader
        reports an error there anyway.
        ``place`` is the place of the values; by default it is that of the block above them.
        """
        data = self.data
        for path, value in values.items():
            data = _replace_value(data, path, value)
        placed = dict.fromkeys(values, place) if place is not None else {}
        kept = {path: own for path, own in self.values.items() if path not in values}
        return evolve(self, data=data, values=kept | placed, keys=self.keys | placed)


def _replace_value(block: Any, path: Steps, value: Any) -> Any:
    """A copy of ``block``, which other documents share, with ``value`` at ``path``; None if nothing is in it."""
    step, inner_path = path[0], path[1:]
    copy: Any
    if isinstance(block, list) and isinstance(step, int) and step < len(block):
        copy = [*block]
        copy[step] = _replace_value(block[step], inner_path, value) if inner_path else value
        return copy
    if not isinstance(block, dict | None) or not isinstance(step, str):
        return block
    copy = dict(block or {})
    inner = _replace_value(copy.get(step), inner_path, value) if inner_path else value
    if inner is not None:
        copy[step] = inner
    else:
        copy.pop(step, None)
    return copy if copy or block is not None else None


def read_document(path: str | os.PathLike[str]) -> Document:
    """Document in a file.

    Parameters
    ----------
    path : path-like
        A regular file of UTF-8 text, at most 1 MiB; messages use this name.

    Raises
    ------
    FileAccessError
        When the file cannot be read.
    ScenarioError
        When it is larger, or when its text is not a mapping in YAML.
    """
    with open_regular(path) as file:
        return _read(file, os.fspath(path))


def read_standard_input() -> Document:
    """Document on standard input; the errors are those of `read_document`."""
    return _read(sys.stdin.buffer, STDIN)


def _read(file: IO[bytes], name: str) -> Document:
    data = file.read(_MOST_BYTES + 1)
    if len(data) > _MOST_BYTES:
        hint = "put a long record into a CSV file and give its name as `file`"
        raise _error(name, "", f"must be at most 1 MiB (got more; {hint})")
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        before = data[: error.start].decode()
        problem = f"must be UTF-8 text (got the byte 0x{data[error.start]:02x}; save the file as UTF-8)"
        raise _error(name, before, problem) from None
    return parse_document(text, name)


def parse_document(text: str, name: str, names_files: bool = True, folder: str | os.PathLike[str] = "") -> Document:
    """Document in ``text``; messages use ``name`` for it, and the other arguments are as in `Document`.

    Raises
    ------
    ScenarioError
        When the text is not a mapping in YAML.
    """
    document = Document(name, {}, names_files=names_files, folder=Path(folder), source=text)
    data = _data(document, text)
    if not isinstance(data, dict):
        got = "nothing" if data is None else text_of(data)
        problem = f"must be a mapping, 'key: value' on each line (got {got})"
        raise ScenarioError(*document.faults, document.place(Fault((), problem)))
    document.data = data
    return document


def parse_value(text: str, name: str) -> Any:
    """Value of the option ``name``, written as in a scenario; raises a `UsageError` if it is not YAML."""
    document = Document(name, {})
    try:
        value = _data(document, text)
        if document.faults:
            raise ScenarioError(*document.faults)
    except ScenarioError as error:
        raise UsageError(f"{name}: {error.faults[0].problem}") from None
    return value


def _data(document: Document, text: str) -> Any:
    """Data of ``text``; places and errors are added to ``document``."""
    if bad := _unprintable(text):
        problem = f"must be printable text (got the character U+{ord(bad[0]):04X}; delete it)"
        raise _error(document.name, text[: bad.start()], problem)
    node = _compose(text, document.name)
    return None if node is None else _value(document, node, ())


def make_document(data: Mapping[str, Any], folder: str | os.PathLike[str] = "") -> Document:
    """Document with the content of a mapping, without places; ``folder`` is as in `Document`.

    Raises
    ------
    ScenarioError
        When it is not a mapping.
    """
    if not isinstance(data, Mapping):
        raise ScenarioError(Fault((), f"must be a mapping of blocks (got {text_of(data)})"))
    return Document("", _plain(data), folder=Path(folder))


def _plain(value: Any) -> Any:
    """``value`` as YAML would give it: mappings, lists, text and numbers."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if hasattr(value, "to_base_units"):  # a quantity of pint
        return f"{value.magnitude!r} {value.units}"
    plain = value.tolist() if hasattr(value, "tolist") else value
    return [_plain(inner) for inner in plain] if isinstance(plain, list | tuple) else plain


def _unprintable(text: str) -> re.Match[str] | None:
    # the long pattern takes longer to compile than a file to read
    return _ASCII_UNPRINTABLE.search(text) and re.search(_UNPRINTABLE, text)


def _location(name: str, mark: yaml.Mark) -> str:
    return f"{name}:{mark.line + 1}:{mark.column + 1}"


def _error(name: str, before: str, problem: str) -> ScenarioError:
    """Error with one fault, which follows the text ``before``."""
    *lines, last = _BREAK.split(before)
    return ScenarioError(Fault((), problem, f"{name}:{len(lines) + 1}:{len(last) + 1}"))


# ---------------------------------------------------------------- text to nodes


class _Loader(yaml.SafeLoader):
    """The parser written in Python; unlike libyaml's, it gives the same messages on all systems."""

    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}  # type: ignore[misc]

    def _refuse(self) -> None:
        problem = "an anchor, an alias or a tag; write the value out"
        raise yaml.MarkedYAMLError(problem=problem, problem_mark=self.get_mark())

    fetch_anchor = fetch_alias = fetch_tag = _refuse


_TEXT = _Loader.DEFAULT_SCALAR_TAG
for _tag, _pattern, _first in (
    ("number", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", "-+.0123456789"),
    ("truth", "true|True|TRUE|false|False|FALSE", "tTfF"),
    ("nothing", "|~|null|Null|NULL", ["", *"~nN"]),
):
    _Loader.add_implicit_resolver(_tag, re.compile(rf"({_pattern})\Z"), list(_first))


def _compose(text: str, name: str) -> yaml.Node | None:
    """Node at the top of the document, if there is one."""
    loader = _Loader(text)
    try:
        if text.count(",") + text.count("\n") > _MOST_VALUES:  # nearly every value is followed by one of these
            raise ValueError(f"more than {_MOST_VALUES} values; put a long record into a CSV file")
        found: yaml.Node | None = loader.get_single_node()
        return found
    # PyYAML recurses without a limit, and converts escape sequences without checking that the character exists.
    except (yaml.MarkedYAMLError, RecursionError, ValueError, OverflowError) as error:
        got = str(getattr(error, "problem", None) or error).removeprefix("but ")
        hint = next((f"; {hint}" for part, hint in _HINTS.items() if part in got), "")
        mark = getattr(error, "problem_mark", None) or loader.get_mark()
        raise ScenarioError(Fault((), f"must be YAML (got: {got}{hint})", _location(name, mark))) from None


# ---------------------------------------------------------------- nodes to data


def _value(document: Document, node: yaml.Node, path: Steps) -> Any:
    """Data of a node; its places are added to ``document``."""
    document.values[path] = node.start_mark
    if len(path) > _MOST_LEVELS:
        problem = f"must have at most {_MOST_LEVELS} nested levels (got more)"
        raise ScenarioError(Fault((), problem, _location(document.name, node.start_mark)))
    if isinstance(node, yaml.SequenceNode):
        return [_value(document, inner, (*path, index)) for index, inner in enumerate(node.value)]
    if isinstance(node, yaml.MappingNode):
        return _mapping(document, node, path)
    if node.tag == _TEXT and not node.value.isprintable() and _unprintable(node.value):
        problem = "must be printable text (got the escape sequence of an unprintable character)"
        document.faults.append(document.place(Fault(path, problem)))
        return ""
    return _scalar(node.tag, node.value)


def _mapping(document: Document, node: yaml.Node, path: Steps) -> dict[str, Any]:
    data: dict[str, Any] = {}
    first: dict[Steps, int] = {}
    for key, inner in node.value:
        where = (*path, key.value)
        if key.tag != _TEXT:
            scalar = isinstance(key, yaml.ScalarNode)
            comma = COMMA if scalar and key.value[:1].isdigit() else ""
            got = text_of(key.value) if scalar else "a list or a mapping"
            problem = f"must have names as keys (got {got}{comma or '; put it in quotes if it is a name'})"
            where = path
        elif key.value in data:
            problem = f"must be given once (got it twice, first in line {first[where]}; delete one)"
        else:
            document.keys[where] = key.start_mark
            first[where] = key.start_mark.line + 1
            data[key.value] = _value(document, inner, where)
            continue
        document.faults.append(Fault(where, problem, _location(document.name, key.start_mark)))
    return data


def _scalar(tag: str, text: str) -> Any:
    if tag == "nothing":
        return None
    if tag == "truth":
        return text.lower() == "true"
    if tag == "number":
        whole = text.lstrip("+-").isdigit() and len(text) < _MOST_DIGITS
        return int(text) if whole else float(text)
    return text
