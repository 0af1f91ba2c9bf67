"""Journal of a sweep: one line for each finished point, written by one client and readable by all; and its tables."""

from __future__ import annotations

import csv
import json
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from itertools import chain, product
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np

from shockwave.base.errors import FileAccessError
from shockwave.base.files import not_writable, open_regular, refuse_link, replace_file
from shockwave.base.progress import report_progress
from shockwave.base.text import replace_unfit
from shockwave.sweep.definition import DEFINITION, NOTES, Column, SweepDefinition, as_text, warnings_in

JOURNAL = "journal.jsonl"
#: Status of a point without a line in the journal.
NOT_RUN = "not run"
# The state of a point is the index of its status.
_STATUSES = (NOT_RUN, "done", "failed", "crashed")
_LOCK = "sweep.lock"
_LINE = re.compile(rb'\{"index": (\d{1,9}), "status": "(done|failed|crashed)", .*\}\n')
# Exceptions that a damaged line raises.
_DAMAGES = (ValueError, KeyError, TypeError, RecursionError)


def line_of(index: int, status: str, **content: object) -> str:
    """Return a line of the journal, with the ``values`` of the point or its ``error``."""
    return json.dumps({"index": index, "status": status, **content}) + "\n"


class Row(NamedTuple):
    """A point: number, values of the variables, status, values of the columns, and error."""

    number: int
    point: tuple[Any, ...]
    status: str
    values: list[Any]
    problem: str | None


class Journal:
    """Journal in ``folder`` of a sweep with ``points`` points."""

    def __init__(self, folder: Path, points: int) -> None:
        self.folder = folder
        self.path = folder / JOURNAL
        self.points = points
        self._states = bytearray(points)
        # Offset of the last line of each point [bytes].
        self._offsets = np.zeros(points, dtype=np.int64)
        self._size = 0
        self._file: IO[bytes] | None = None

    def count(self, *statuses: str) -> int:
        """Return the number of points with one of these statuses."""
        return sum(self._states.count(_STATUSES.index(status)) for status in statuses)

    def open_points(self) -> list[int]:
        """Return the numbers of the unfinished points in ascending order."""
        return [index for index, state in enumerate(self._states) if state == 0]

    def reopen(self) -> None:
        """Treat points that failed or crashed as not run."""
        for status in ("failed", "crashed"):
            self._states = self._states.replace(bytes([_STATUSES.index(status)]), b"\0")

    # ---------------------------------------------------------------- reading

    def read(self, columns: Sequence[Column]) -> list[str]:
        """Read which points are finished, and return warnings about ignored lines.

        Raises
        ------
        FileAccessError
            If the journal cannot be read.
        """
        warnings = []
        ignored = 0
        with self._open() as file:
            for number, line in enumerate(file):
                report_progress("reading the journal", min(number, self.points - 1), self.points)
                if line.endswith(b"\n"):
                    ignored += not self._record(line, len(columns))
                else:
                    warnings.append(f"the last line of {JOURNAL} is incomplete and was ignored: its point is run again")
        report_progress("reading the journal", self.points, self.points)
        if ignored:
            warnings.append(f"ignored lines of {JOURNAL} that are damaged or belong to no point: {ignored}")
        return warnings

    def _open(self) -> IO[bytes]:
        # a sweep that was killed before its first point has no journal
        return open_regular(self.path) if self.path.exists() else BytesIO()

    def _record(self, line: bytes, columns: int | None = None) -> bool:
        """Record the next line, and return whether it belongs to a point and has a value for each of the columns."""
        place, self._size = self._size, self._size + len(line)
        match = _LINE.fullmatch(line)
        index = int(match[1]) if match else self.points
        if match is None or index >= self.points:
            return False
        if columns is not None:
            try:
                _content(line, columns, index)
            except _DAMAGES:
                return False
        self._states[index] = _STATUSES.index(match[2].decode())
        self._offsets[index] = place
        return True

    def rows(self, definition: SweepDefinition) -> Iterator[Row]:
        """Yield all points in their order.

        Raises
        ------
        FileAccessError
            If the journal cannot be read, or was changed since `read`.
        """
        places = product(*(axis.values for axis in definition.axes))
        nothing = [None] * len(definition.columns)
        with self._open() as file:
            for index, positions in enumerate(places):
                point = tuple(chain(*positions))
                status = _STATUSES[self._states[index]]
                values = problem = None
                if status != NOT_RUN:
                    file.seek(self._offsets[index])
                    try:
                        values, problem = _content(file.readline(), len(nothing), index)
                    except _DAMAGES:
                        raise self._change_error(f"no line of point {index} where it was") from None
                yield Row(index, point, status, values or nothing, problem)

    # ---------------------------------------------------------------- writing

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Create the folder if necessary, and lock it against other clients.

        Raises
        ------
        FileAccessError
            If the folder cannot be written, is in use by another client, or holds other files.
        """
        from filelock import FileLock, Timeout  # workers do not need it, and it is slow to import

        lock = FileLock(self.folder / _LOCK, timeout=0, thread_local=False)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            _refuse_others(self.folder)
            refuse_link(self.folder / _LOCK)
            lock.acquire()
        except Timeout:
            problem = "must be used by one client at a time (got another one; wait until it ends, or stop it)"
            raise FileAccessError(f"{self.folder}: {problem}") from None
        except (OSError, ValueError) as error:  # a ValueError for a NUL character in the path
            raise not_writable(self.folder, error) from error
        try:
            yield
        finally:
            if self._file is not None:
                self._file.close()
                self._file = None
            lock.release()

    def add(self, lines: str) -> None:
        """Append complete lines; on a full disk no part of a line remains.

        Raises
        ------
        FileAccessError
            If the lines cannot be written, or others have changed the journal.
        """
        content = lines.encode()
        size = os.path.getsize(self.path) if os.path.exists(self.path) else 0
        if size < self._size or (self._file is not None and size > self._size):
            raise self._change_error(f"{size} of {self._size} bytes")
        if self._file is None:
            self._file = open_regular(self.path, mode="a+b", buffering=0)
            self._file.truncate(self._size)  # removes an incomplete last line
        remaining = memoryview(content)
        try:
            while remaining:
                remaining = remaining[self._file.write(remaining) :]
        except OSError as error:
            self._file.truncate(self._size)
            raise not_writable(self.path, error) from error
        for line in content.splitlines(keepends=True):
            self._record(line)

    def _change_error(self, got: str) -> FileAccessError:
        remedy = "run the same command to run the lost points again"
        return FileAccessError(f"{self.path}: must not be changed by others during a sweep (got {got}; {remedy})")


def _content(line: bytes, columns: int, index: int) -> tuple[list[Any] | None, str | None]:
    """Values or error of the line of a point; raises one of `_DAMAGES` if it is not such a line."""
    entry = json.loads(line)
    if entry["index"] != index:
        raise ValueError
    if entry["status"] != "done":
        return None, str(entry["error"])
    values: list[Any] = entry["values"]
    if len(values) != columns:
        raise ValueError
    return values, None


def _refuse_others(folder: Path) -> None:
    """Refuse a folder that holds files but no sweep."""
    names = {file.name for file in folder.iterdir()}
    strange = sorted(name for name in names - {_LOCK} if not name.endswith(".part"))
    if strange and DEFINITION not in names:
        got = f"got a folder with {strange[0]}; choose another"
        raise FileAccessError(f"{folder}: must be a new folder or hold a sweep ({got})")


# ---------------------------------------------------------------- tables

# First characters of a cell that a spreadsheet may run as a formula.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def write_tables(definition: SweepDefinition, journal: Journal) -> tuple[tuple[Path, ...], int]:
    """Write ``results.csv`` and ``results.jsonl``, with a row or an object for each point in the order of the points.

    Returns
    -------
    tuple of pathlib.Path, int
        The files, and the number of points with warnings.

    Raises
    ------
    FileAccessError
        If a file cannot be read or written. An existing table is then left unchanged.
    """
    files = (journal.folder / "results.csv", journal.folder / "results.jsonl")
    units = definition.units
    heads = [f"{name} [{unit}]" if unit else name for name, unit in units.items()]
    keys = ("index", *units, "status", "problem")
    warned = 0
    with replace_file(files[0]) as table, replace_file(files[1]) as objects:
        writer = csv.writer(table, lineterminator="\n")
        writer.writerow((*heads, "status", "problem"))
        # point by point, so that memory does not grow with their number
        for row in journal.rows(definition):
            values = [*row.point, *row.values, row.status, row.problem]
            writer.writerow([_cell(value) for value in values])
            named = dict(zip(keys, (row.number, *values), strict=True))
            warned += bool(warnings_in(named.get(NOTES)))
            objects.write(json.dumps(named) + "\n")
            report_progress("writing tables", row.number + 1, journal.points)
    return files, warned


def _cell(value: Any) -> Any:
    """The value in CSV; text that a spreadsheet could run as a formula begins with an apostrophe."""
    if isinstance(value, float):
        return value
    text = as_text(value)
    if isinstance(value, str) and value.startswith(_FORMULA):
        try:
            float(value)
        except ValueError:
            text = f"'{value}"
    # not all versions of Python quote a carriage return; a terminal that shows the file would obey control characters
    return text and replace_unfit(text.replace("\r", "\n"))
