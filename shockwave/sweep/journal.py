"""The journal of a sweep: one line for each finished point, in a folder that one client at a time writes."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from attrs import define, field

from shockwave.errors import FileAccessError
from shockwave.files import lines_of, open_new, open_regular
from shockwave.sweep.lock import locked
from shockwave.sweep.stored import HEADER, JOURNAL, LONGEST_LINE, Header

__all__ = ["COPY", "CRASHED", "DONE", "FAILED", "OPEN", "Journal", "header_in", "written"]

#: What is known of a point.
OPEN, DONE, FAILED, CRASHED = range(4)
_STATES = {b"done": DONE, b"failed": FAILED, b"crashed": CRASHED}
_LINE = re.compile(rb'\{"index": (\d{1,9}), "key": "([0-9a-f]{64})", "status": "(done|failed|crashed)", ".*\}\n')
LOCK, COPY = "sweep.lock", "scenario.yaml"
# Seconds between two times that the disk itself is waited for: what a power cut may cost.
_SYNC = 2.0


@define(eq=False)
class Journal:
    """The journal in ``folder``, open for more lines; made by `Journal.opened`.

    Attributes
    ----------
    states : bytearray
        One of `OPEN`, `DONE`, `FAILED`, `CRASHED` for each point.
    notes : list of str
        What was found and mended on opening.
    ends : list of (int, str)
        Points and keys of the first and the last result that were there.
    """

    folder: Path
    states: bytearray
    notes: list[str]
    ends: list[tuple[int, str]]
    _lock: BinaryIO | None
    _file: BinaryIO | None = field(init=False, default=None)
    _synced: float = field(init=False, factory=time.monotonic)

    @classmethod
    def opened(cls, folder: Path, points: int) -> Journal:
        """The journal in ``folder``, which is made if need be; nothing is read before `begin`.

        Raises
        ------
        FileAccessError
            When the folder cannot be written, is in use by another client or holds something else.
        """
        _check(folder)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _refused(folder, error) from error
        return cls(folder, bytearray(points), [], [], locked(folder / LOCK))

    def begin(self) -> None:
        """Read what is there, of which a torn last line is cut off, and make ready for more.

        Raises
        ------
        FileAccessError
            When it cannot be read, or a line tells of no point of the sweep, or of one told before.
        """
        self.read()
        self._file = open_regular(self.path, mode="ab", buffering=0)

    @property
    def path(self) -> Path:
        """The file."""
        return self.folder / JOURNAL

    def read(self, mend: bool = True) -> None:
        """Take note of the points that are finished, and cut a torn last line off if it is to be mended."""
        if not self.path.exists():
            return
        size = 0
        with open_regular(self.path, mode="r+b" if mend else "rb") as file:
            for number, line in enumerate(lines_of(file, self.path, LONGEST_LINE), start=1):
                match = _LINE.fullmatch(line)
                index = int(match[1]) if match else -1
                if match is None or index >= len(self.states) or self.states[index]:
                    if line.endswith(b"\n"):
                        rule = "must tell of a point of this sweep that no line before tells of"
                        got = f"got {line[:60]!r}; delete the line: what it told is run again"
                        raise FileAccessError(f"{self.path}:{number}: {rule} ({got})")
                    if mend:
                        file.truncate(size)
                    self.notes.append(f"{self.path}: the last line was torn, and was cut off: its point is run again")
                    break
                self.states[index] = _STATES[match[3]]
                if match[3] == b"done":
                    self.ends = [*self.ends[:1], (index, match[2].decode())]
                size += len(line)

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
            self._sync(self._file)
        except OSError as error:
            os.truncate(self.path, before)
            raise _refused(self.path, error) from error

    def _sync(self, file: BinaryIO, at_once: bool = False) -> None:
        """Wait for the disk, if that was not done lately."""
        if at_once or time.monotonic() - self._synced > _SYNC:
            os.fsync(file.fileno())
            self._synced = time.monotonic()

    def count(self, *states: int) -> int:
        """How many points are in one of these states."""
        return sum(self.states.count(state) for state in states)

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
        if self._file is not None:
            self._file.close()
        part = self.path.with_suffix(".part")
        try:
            with open_regular(self.path) as old, open_new(part) as new:
                for line in lines_of(old, self.path, LONGEST_LINE):
                    match = _LINE.fullmatch(line)
                    if match and self.states[int(match[1])] != DONE:
                        self.states[int(match[1])] = OPEN
                    else:
                        new.write(line)
                new.flush()
                os.fsync(new.fileno())
            part.replace(self.path)
        except OSError as error:
            raise _refused(self.path, error) from error
        self._file = open_regular(self.path, mode="ab", buffering=0)

    def close(self) -> None:
        """Let go of the folder."""
        try:
            if self._file is not None and not self._file.closed:
                self._sync(self._file, at_once=True)
                self._file.close()
        except OSError as error:
            raise _refused(self.path, error) from error
        finally:
            if self._lock is not None:
                self._lock.close()


def written(file: Path, content: bytes) -> None:
    """Write a file so that it is there as a whole or not at all."""
    part = file.with_name(f"{file.name}.part")
    try:
        with open_new(part) as opened:
            opened.write(content)
            opened.flush()
            os.fsync(opened.fileno())
        part.replace(file)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise _refused(file, error) from error


def header_in(folder: Path) -> dict[str, Any] | None:
    """Header of the sweep in ``folder``; None if there is none. Raises as `Header.read` does."""
    return Header.with_document(folder)[1] if (folder / HEADER).exists() else None


def _check(folder: Path) -> None:
    """Refuse a folder that holds something else."""
    try:
        there = {file.name for file in folder.iterdir()} if folder.exists() else set()
    except OSError as error:
        raise _refused(folder, error) from error
    strange = sorted(there - {LOCK, COPY, f"{COPY}.part", f"{HEADER}.part"})
    if strange and HEADER not in there:
        got = f"got a folder with {strange[0]} in it; choose another"
        raise FileAccessError(f"{folder}: must be new, or hold a sweep ({got})")


def _refused(file: Path, error: OSError) -> FileAccessError:
    return FileAccessError(f"{file}: cannot be written (got {error.strerror or error})")
