"""The journal of a sweep: one line for each finished point, in a folder that one client at a time writes."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from attrs import define, field
from filelock import FileLock, Timeout

from shockwave.errors import FileAccessError
from shockwave.files import open_regular
from shockwave.sweep.header import HEADER
from shockwave.sweep.journal_reader import JOURNAL, Line, journal_lines
from shockwave.sweep.replacing import not_writable, replacing

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
            elif line.index < 0:
                strange += 1
            size += len(line.content)
        if strange:
            self.notes.append(f"{self.path}: lines that are of no point, and were left out: {strange}")

    def _note(self, line: Line) -> None:
        if line.index < 0:
            return
        self.states[line.index] = _STATES[line.status]
        if line.status == "done":
            self.ends = [*self.ends[:1], (line.index, line.key)]

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
                elif line.index >= 0:
                    self.states[line.index] = OPEN
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
