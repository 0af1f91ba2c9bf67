"""What a sweep has written: its header, and the lines of its journal in the order of the points."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterator
from functools import lru_cache
from itertools import chain, islice, product
from pathlib import Path
from typing import Any, BinaryIO, Literal, NamedTuple

import cattrs
import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import FileAccessError, InvalidValueError
from shockwave.fields import text_of
from shockwave.files import lines_of, open_regular, parse_json, read_bytes

__all__ = [
    "FORMAT",
    "HEADER",
    "JOURNAL",
    "LONGEST_LINE",
    "NOTES",
    "NOT_RUN",
    "Chunk",
    "Column",
    "Dimension",
    "Header",
    "Row",
    "Stored",
    "SweepAxis",
    "as_text",
]

HEADER, JOURNAL = "sweep.json", "journal.jsonl"
#: The status of a point that has no line in the journal.
NOT_RUN = "not run"
#: Of the header.
FORMAT = 1
#: Longest line of the journal [bytes].
LONGEST_LINE = 2**24
#: The last column, whose sentences may be others at every point.
NOTES = "notes"
_REMEDY = "give a folder that `shockwave sweep FILE --out FOLDER` has written"
_BEGIN = b'{"index": '
# So many points are held at once.
_CHUNK = 8192
# Further columns of the tables.
_OTHERS = ("status", "problem")
# Largest header [bytes], enough for some hundred thousand values: parsing takes up to 25 times as much memory.
_MOST_BYTES = 2**24
# Most points of a sweep, as in `shockwave.scenario.sweep`: the arrays of a result take some hundred megabytes then.
_MOST_POINTS = 10**7
_STATUSES = ("done", "failed", "crashed")
# What arrays of whole numbers can hold.
_LONGEST = 2**63
_NO_NAME = re.compile(r"[^A-Za-z0-9_]")


@frozen
class Column:
    """A quantity that is known of every point.

    Attributes
    ----------
    name : str
        What it is called.
    unit : str or None
        SI unit, empty for a number without one; None for text.
    kind : "number", "whole" or "text"
        What its values are.
    meaning : str
        One line for people.
    """

    name: str
    unit: str | None
    kind: Literal["number", "whole", "text"]
    meaning: str = ""


@frozen
class SweepAxis:
    """Variables that go through their values together.

    Attributes
    ----------
    names : tuple of str
        Dotted names of the variables: one, unless it comes from ``zip`` or ``points``.
    units : tuple of str or None
        SI unit of each, empty for a number without one; None for what is no number.
    values : tuple of tuple
        For each position the values of the variables.
    """

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    values: tuple[tuple[Any, ...], ...]

    def __len__(self) -> int:
        return len(self.values)

    def along(self, name: str) -> list[Any]:
        """The values of the variable ``name``, position by position."""
        at = self.names.index(name)
        return [position[at] for position in self.values]


@frozen
class Dimension:
    """An axis as files of arrays know it.

    Attributes
    ----------
    name : str
        Letters of ASCII, digits and underscores; the name of the variable where there is one alone.
    coordinates : dict of str to str
        Names of the variables, short ones first, then as a scenario has them.
    """

    name: str
    coordinates: dict[str, str]


@frozen(kw_only=True)
class Header:
    """What stands in ``sweep.json``: everything about a sweep but its results."""

    name: str
    run: str
    axes: tuple[SweepAxis, ...]
    shape: tuple[int, ...]
    points: int
    columns: tuple[Column, ...]
    scenario: Any = None
    versions: dict[str, str]
    earlier_versions: tuple[dict[str, str], ...] = ()
    key: str

    @classmethod
    def read(cls, folder: Path) -> Header:
        """The header in ``folder``.

        Raises
        ------
        FileAccessError
            When there is none that can be read.
        InvalidValueError
            When it is none.
        """
        return cls.with_document(folder)[0]

    @classmethod
    def with_document(cls, folder: Path) -> tuple[Header, dict[str, Any]]:
        """Header in ``folder`` and the document it is read from; raises as `read` does."""
        file = folder / HEADER
        document = parse_json(read_bytes(file, _MOST_BYTES, _REMEDY), str(file), _REMEDY)
        form = document.get("format") if isinstance(document, dict) else None
        if form != FORMAT:
            problem = f"must be of format {FORMAT}, which this shockwave reads (got {text_of(form)}; {_REMEDY})"
            raise InvalidValueError.of(str(file), problem)
        try:
            header = cattrs.structure(document, cls)
        except Exception as error:  # cattrs raises what the values raise, too
            told = "; ".join(cattrs.transform_error(error))
            raise InvalidValueError.of(str(file), f"must be the header of a sweep (got {told[:200]})") from None
        if (rule := header._broken_rule()) is not None:
            raise InvalidValueError.of(str(file), f"{rule}; {_REMEDY})")
        return header, document

    def _broken_rule(self) -> str | None:
        """Rule that the parts of the header break, with the values found; None if the header is consistent."""
        lengths = ({len(axis.names), len(axis.units), *map(len, axis.values)} for axis in self.axes)
        agree = all(len(found) == 1 for found in lengths) and self.shape == tuple(map(len, self.axes))
        if not agree or self.points != math.prod(self.shape):
            return f"must have axes, shape and points that agree (got {self.shape}"
        if not 0 < self.points <= _MOST_POINTS:
            return f"must have 1 to {_MOST_POINTS:g} points (got {self.points}"
        columns = [column.name for column in self.columns]
        for names in ([name for axis in self.axes for name in axis.names], [*columns, *_OTHERS]):
            if len(set(names)) < len(names):
                return f"must have unique names of variables and of columns (got {', '.join(names)[:200]}"
        if all(column.kind == "text" for column in self.columns):
            return f"must have a column of numbers (got {', '.join(columns)[:200]}"
        for column in self.columns:
            if (column.kind == "text") != (column.unit is None):
                return f"must have units for numbers, and none for text (got {column.unit} for {column.name}"
        for axis in self.axes:
            for name, unit in zip(axis.names, axis.units, strict=True):
                if unit is not None and not all(map(_is_number, axis.along(name))):
                    return f"must have numbers for {name} (got {text_of(axis.along(name)[:5])}"
        return None

    @property
    def variables(self) -> dict[str, str | None]:
        """Dotted names of all variables, and their units."""
        return {name: unit for axis in self.axes for name, unit in zip(axis.names, axis.units, strict=True)}

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The axes by names without dots, each once; short where that is no other's."""
        points = ["point", *(f"point_{at + 1}" for at in range(1, len(self.axes)))]
        lasts = [name.rpartition(".")[2] for name in self.variables]
        taken = {column.name for column in self.columns} | {*_OTHERS, *points}
        short: dict[str, str] = {}
        for dotted, last in zip(self.variables, lasts, strict=True):
            name = _NO_NAME.sub("_", last if lasts.count(last) == 1 and last not in taken else dotted)
            while name in taken:
                name += "_"
            taken.add(name)
            short[dotted] = name
        found: list[Dimension] = []
        for axis in self.axes:
            coordinates = {short[dotted]: dotted for dotted in axis.names}
            found.append(Dimension(points.pop(0) if len(coordinates) > 1 else short[axis.names[0]], coordinates))
        return tuple(found)

    def point(self, index: int) -> dict[str, Any]:
        """Dotted names and values of a point, counted from 0."""
        places = np.unravel_index(index, self.shape)
        pairs = zip(self.axes, places, strict=True)
        return {name: value for axis, at in pairs for name, value in zip(axis.names, axis.values[at], strict=True)}


class Row(NamedTuple):
    """What is known of a point: status, a value for each column, and what went wrong."""

    status: str
    values: list[Any]
    problem: str | None


class Chunk(NamedTuple):
    """Points that follow each other from the one numbered ``begin``: values of the variables, and what is known."""

    begin: int
    points: list[tuple[Any, ...]]
    rows: list[Row]


@frozen(eq=False)
class Stored:
    """A folder with a sweep in it.

    Attributes
    ----------
    folder : pathlib.Path
        The folder.
    header : Header
        What was swept.
    offsets : array of int, shape (points,)
        Where in the journal the last line of each point begins; -1 where there is none.
    size : int
        Bytes of the journal.
    warnings : tuple of str
        What a reader must know.
    """

    folder: Path
    header: Header
    offsets: npt.NDArray[np.int64]
    size: int
    warnings: tuple[str, ...]

    @classmethod
    def read(cls, folder: str | os.PathLike[str]) -> Stored:
        """The sweep in ``folder``; see `Header.read` for what is raised."""
        place = Path(folder)
        header = Header.read(place)
        offsets = np.full(header.points, -1, dtype=np.int64)
        size = broken = 0
        torn = False
        try:
            with open_regular(place / JOURNAL) as file:
                for line in lines_of(file, place / JOURNAL, LONGEST_LINE):
                    torn = not line.endswith(b"}\n")
                    index = None if torn else _index(line)
                    if index is not None and 0 <= index < header.points:
                        offsets[index] = size
                    else:
                        broken += 1
                    size += len(line)
        except FileAccessError as error:
            # a sweep that was killed before its first point has no journal
            if not isinstance(error.__cause__, FileNotFoundError):
                raise
        warnings = _warnings(place / JOURNAL, offsets, broken, torn)
        if header.earlier_versions:
            told = "; ".join(", ".join(map(" ".join, one.items())) for one in header.earlier_versions)
            warnings = (*warnings, f"points may have been run with other versions ({told})")
        return cls(place, header, offsets, size, warnings)

    def chunks(self) -> Iterator[Chunk]:
        """All points in their order, some thousands at a time.

        Raises
        ------
        FileAccessError
            When the journal cannot be read.
        """
        points = map(tuple, map(chain.from_iterable, product(*(axis.values for axis in self.header.axes))))
        if not self.size:
            yield from (self._chunk(begin, points, None) for begin in range(0, self.header.points, _CHUNK))
            return
        try:
            with open_regular(self.folder / JOURNAL) as file:
                for begin in range(0, self.header.points, _CHUNK):
                    yield self._chunk(begin, points, file)
        except OSError as error:
            raise FileAccessError(f"{self.folder / JOURNAL}: cannot be read (got {error.strerror})") from None

    def _chunk(self, begin: int, points: Iterator[tuple[Any, ...]], file: BinaryIO | None) -> Chunk:
        kinds = tuple(column.kind for column in self.header.columns)
        nothing = [None] * len(kinds)
        rows: list[Row] = []
        at = -1
        for offset in self.offsets[begin : begin + _CHUNK].tolist():
            row = None
            if offset >= 0 and file is not None:
                if offset != at:
                    file.seek(offset)
                line = file.readline(LONGEST_LINE)
                at = offset + len(line)
                row = _row(line, kinds, nothing)
            rows.append(row or Row(NOT_RUN, nothing, None))
        return Chunk(begin, list(islice(points, len(rows))), rows)


def _index(line: bytes) -> int | None:
    """Of which point a line of the journal tells."""
    try:
        if line.startswith(_BEGIN):
            return int(line[len(_BEGIN) : line.index(b",")])
        index = json.loads(line)["index"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return index if isinstance(index, int) else None


def _row(line: bytes, kinds: tuple[str, ...], nothing: list[Any]) -> Row | None:
    """What a line of the journal tells; None if it tells nothing."""
    try:
        entry = json.loads(line)
        status, values = entry["status"], entry.get("values")
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    if status not in _STATUSES:
        return None
    if status != "done":
        return Row(status, nothing, as_text(str(entry.get("error") or "")))
    if not isinstance(values, list) or not _fit(tuple(map(type, values)), kinds):
        return None
    if not all(isinstance(value, str) or _is_number(value) for value in values):
        return None
    return Row(status, values, None)


_TYPES: dict[str, tuple[type, ...]] = {"number": (float, int), "whole": (int,), "text": (str,)}


def _is_number(value: Any) -> bool:
    """Whether ``value`` is a number that arrays can hold, or None, which stands for a missing value."""
    if type(value) is float:
        return math.isfinite(value)
    return value is None or (type(value) is int and abs(value) < _LONGEST)


# Most lines are of the same few types.
@lru_cache(maxsize=256)
def _fit(types: tuple[type, ...], kinds: tuple[str, ...]) -> bool:
    """Whether values of ``types`` can be those of columns of ``kinds``; None can be any."""
    fits = (one is type(None) or one in _TYPES[kind] for one, kind in zip(types, kinds, strict=False))
    return len(types) == len(kinds) and all(fits)


def as_text(value: Any) -> str | None:
    """A value that is no number as text that any file takes; None for none."""
    if value is None:
        return None
    text = value if isinstance(value, str) else json.dumps(value)
    # a file name may contain bytes that are not text; arrays of text lose a trailing NUL
    return text.encode(errors="backslashreplace").decode().replace("\0", "\\x00")


def _warnings(journal: Path, offsets: npt.NDArray[np.int64], broken: int, torn: bool) -> tuple[str, ...]:
    found = []
    if torn:
        found.append(f"the last line of {journal.name} is torn, and was left out: run the sweep again to mend it")
    if broken - torn:
        found.append(f"lines of {journal.name} that tell of no point, and were left out: {broken - torn}")
    if lacking := int(np.count_nonzero(offsets < 0)):
        found.append(f"{lacking} of {len(offsets)} points are not done: run the sweep again to go on with it")
    return tuple(found)
