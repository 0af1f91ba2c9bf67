"""The journal of a sweep: one line for each finished point, written by one client at a time and read by anyone."""

from __future__ import annotations

import json
import os
import platform
import re
import time
from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO
from itertools import chain, product
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt
from attrs import define, field, frozen
from filelock import FileLock, Timeout

from shockwave.errors import FileAccessError
from shockwave.files import lines_of, not_writable, open_regular, replacing
from shockwave.sweep.header import HEADER, Header, as_text

JOURNAL = "journal.jsonl"
#: The status of a point that has no line in the journal.
NOT_RUN = "not run"
# Longest line of the journal [bytes].
_LONGEST_LINE = 2**24
_LINE = re.compile(rb'\{"index": (\d{1,9}), "key": "([0-9a-f]{64})", "status": "(done|failed|crashed)", .*\}\n')
_TYPES = {"number": (float, int), "whole": (int,), "text": (str,)}


class Line(NamedTuple):
    """A line of the journal: its bytes, and the number, key and status of its point.

    The number is -1 where it is of no point of the sweep, or torn.
    """

    content: bytes
    point: int
    key: str = ""
    status: str = ""

    @classmethod
    def of(cls, content: bytes, points: int) -> Line:
        """The line with this content in the journal of a sweep of so many points."""
        match = _LINE.fullmatch(content)
        if match is None or int(match[1]) >= points:
            return cls(content, -1)
        return cls(content, int(match[1]), match[2].decode(), match[3].decode())

    @property
    def torn(self) -> bool:
        """Whether the line has no end."""
        return not self.content.endswith(b"\n")


def journal_lines(path: Path, points: int) -> Iterator[Line]:
    """The lines of the journal of a sweep of so many points; none if there is no journal yet.

    Raises
    ------
    FileAccessError
        When it cannot be read.
    """
    if path.exists():
        with open_regular(path) as file:
            for content in lines_of(file, path, _LONGEST_LINE):
                yield Line.of(content, points)


# ---------------------------------------------------------------- writing

#: States of a point.
OPEN = 0
DONE = 1
FAILED = 2
CRASHED = 3
_STATES = {"done": DONE, "failed": FAILED, "crashed": CRASHED}
#: The copy of the scenario.
SCENARIO_COPY = "scenario.yaml"
_LOCK = "sweep.lock"
# Seconds between two times that the disk itself is waited for: what a power cut may cost.
_SYNC = 2.0


def line_of(index: int, key: str, status: str, rest: str) -> str:
    """A line of the journal; ``rest`` is JSON of its values or its error."""
    return f'{{"index": {index}, "key": "{key}", "status": "{status}", {rest}}}\n'


@define(eq=False)
class Journal:
    """The journal in ``folder``.

    Attributes
    ----------
    folder : pathlib.Path
        The folder.
    states : bytearray
        One of `OPEN`, `DONE`, `FAILED`, `CRASHED` for each point.
    notes : list of str
        What was found and mended by `read`.
    ends : list of (int, str)
        Points and keys of the first and the last result that `read` has found.
    """

    folder: Path
    states: bytearray
    notes: list[str] = field(factory=list, init=False)
    ends: list[tuple[int, str]] = field(factory=list, init=False)
    _lock: FileLock | None = field(default=None, init=False)
    _file: BinaryIO | None = field(default=None, init=False)
    _synced: float = field(factory=time.monotonic, init=False)

    @property
    def path(self) -> Path:
        """The file."""
        return self.folder / JOURNAL

    def lock(self) -> None:
        """Make the folder if need be, and keep other clients out of it until this one closes it or ends.

        Raises
        ------
        FileAccessError
            When the folder cannot be written, is in use by another client or holds something else.
        """
        file = self.folder / _LOCK
        holder = "another process"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            _refuse_others(self.folder)
            with suppress(OSError, ValueError, KeyError):
                known = json.loads(file.read_text())
                holder = f"process {known['pid']} on {known['host']}"
            self._lock = FileLock(file, timeout=0, thread_local=False)
            self._lock.acquire()
        except Timeout:
            problem = f"must be used by one client at a time (got {holder}; wait for it, or end it)"
            raise FileAccessError(f"{self.folder}: {problem}") from None
        except OSError as error:
            raise not_writable(self.folder, error) from error
        with suppress(OSError):  # Windows keeps even this process from writing a locked file
            file.write_text(json.dumps({"pid": os.getpid(), "host": platform.node()}))

    def read(self, mend: bool = False) -> None:
        """Take note of the finished points; to ``mend`` is to cut off a torn last line and make ready for more.

        Raises
        ------
        FileAccessError
            When it cannot be read.
        """
        if mend:
            self._file = open_regular(self.path, mode="ab", buffering=0)
        size = strange = 0
        for line in journal_lines(self.path, len(self.states)):
            self._note(line)
            if line.torn:
                self.notes.append(f"{self.path}: the last line was torn, and was cut off: its point is run again")
                if mend:
                    os.truncate(self.path, size)
            elif line.point < 0:
                strange += 1
            size += len(line.content)
        if strange:
            self.notes.append(f"{self.path}: lines that are of no point, and were left out: {strange}")

    def _note(self, line: Line) -> None:
        if line.point < 0:
            return
        self.states[line.point] = _STATES[line.status]
        if line.status == "done":
            self.ends = [*self.ends[:1], (line.point, line.key)]

    def add(self, lines: str) -> None:
        """Append whole lines. What the disk has no room for leaves no part of a line behind.

        Raises
        ------
        FileAccessError
            When they cannot be written.
        """
        assert self._file is not None
        left = memoryview(lines.encode())
        before = os.fstat(self._file.fileno()).st_size
        try:
            while left:
                left = left[self._file.write(left) :]
            if time.monotonic() - self._synced > _SYNC:
                os.fsync(self._file.fileno())
                self._synced = time.monotonic()
        except OSError as error:
            os.truncate(self.path, before)
            raise not_writable(self.path, error) from error
        for line in lines.encode().splitlines(keepends=True):
            self._note(Line.of(line, len(self.states)))

    def count(self, *states: int) -> int:
        """How many points are in one of these states."""
        return sum(map(self.states.count, states))

    def open_points(self) -> Iterator[int]:
        """The points that are not finished, in their order; those finished meanwhile are passed over."""
        at = self.states.find(OPEN)
        while at >= 0:
            yield at
            at = self.states.find(OPEN, at + 1)

    def reopen(self) -> None:
        """Take the lines of points that failed or crashed out of the journal."""
        if not self.count(FAILED, CRASHED):
            return
        assert self._file is not None
        self._file.close()
        with replacing(self.path) as new:
            for line in journal_lines(self.path, len(self.states)):
                if line.status == "done":
                    new.write(line.content.decode())
                elif line.point >= 0:
                    self.states[line.point] = OPEN
        self._file = open_regular(self.path, mode="ab", buffering=0)

    def close(self) -> None:
        """Let go of the folder."""
        try:
            if self._file is not None and not self._file.closed:
                os.fsync(self._file.fileno())
                self._file.close()
        except OSError as error:
            raise not_writable(self.path, error) from error
        finally:
            if self._lock is not None:
                self._lock.release()


def _refuse_others(folder: Path) -> None:
    """Refuse a folder that holds something else."""
    names = {file.name for file in folder.iterdir()}
    strange = sorted(names - {_LOCK, SCENARIO_COPY, f"{SCENARIO_COPY}.part", f"{HEADER}.part"})
    if strange and HEADER not in names:
        got = f"got a folder with {strange[0]} in it; choose another"
        raise FileAccessError(f"{folder}: must be new, or hold a sweep ({got})")


# ---------------------------------------------------------------- reading


class Row(NamedTuple):
    """A point: its number, the values of its variables, its status, a value for each column, and the error."""

    number: int
    point: tuple[Any, ...]
    status: str
    values: list[Any]
    problem: str | None


@frozen(eq=False)
class SweepFolder:
    """A folder with a sweep in it.

    Attributes
    ----------
    folder : pathlib.Path
        The folder.
    header : Header
        What was swept.
    offsets : array of int, shape (points,)
        Where in the journal the last line of each point begins; -1 where there is none.
    warnings : tuple of str
        What a reader must know.
    """

    folder: Path
    header: Header
    offsets: npt.NDArray[np.int64]
    warnings: tuple[str, ...]

    @classmethod
    def read(cls, folder: str | os.PathLike[str]) -> SweepFolder:
        """The sweep in ``folder``; see `Header.read` for what is raised."""
        place = Path(folder)
        header = Header.read(place)
        offsets = np.full(header.points, -1, dtype=np.int64)
        size = strange = 0
        warnings = []
        for line in journal_lines(place / JOURNAL, header.points):
            if line.point >= 0:
                offsets[line.point] = size
            elif line.torn:
                warnings.append(f"the last line of {JOURNAL} is torn, and was left out: run the sweep again to mend it")
            else:
                strange += 1
            size += len(line.content)
        if strange:
            warnings.append(f"lines of {JOURNAL} that are of no point, and were left out: {strange}")
        lacking = int(np.count_nonzero(offsets < 0))
        if lacking:
            warnings.append(f"{lacking} of {len(offsets)} points are not done: run the sweep again to resume it")
        if header.version_note:
            warnings.append(header.version_note)
        return cls(place, header, offsets, tuple(warnings))

    def rows(self) -> Iterator[Row]:
        """All points in their order, one at a time.

        Raises
        ------
        FileAccessError
            When the journal cannot be read.
        """
        axes = (axis.values for axis in self.header.axes)
        # a sweep that was killed before its first point has no journal
        journal = open_regular(self.folder / JOURNAL) if (self.folder / JOURNAL).exists() else BytesIO()
        with journal as file:
            for index, (offset, positions) in enumerate(zip(self.offsets.tolist(), product(*axes), strict=True)):
                line = b""
                try:
                    if offset >= 0:
                        file.seek(offset)
                        line = file.readline(_LONGEST_LINE)
                except OSError as error:
                    raise FileAccessError(f"{self.folder / JOURNAL}: cannot be read (got {error.strerror})") from None
                yield Row(index, tuple(chain(*positions)), *self._content(line))

    def _content(self, line: bytes) -> tuple[str, list[Any], str | None]:
        """Status, values and error of a line of the journal; of a point that was not run if it cannot be read."""
        columns = self.header.columns
        nothing = [None] * len(columns)
        try:
            entry = json.loads(line)
            status, values = entry["status"], entry.get("values")
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            return NOT_RUN, nothing, None
        if status in ("failed", "crashed"):
            return status, nothing, as_text(str(entry.get("error") or ""))
        if status != "done" or not isinstance(values, list) or len(values) != len(columns):
            return NOT_RUN, nothing, None
        pairs = zip(values, columns, strict=True)
        fit = all(value is None or type(value) in _TYPES[column.kind] for value, column in pairs)
        return ("done", values, None) if fit else (NOT_RUN, nothing, None)
