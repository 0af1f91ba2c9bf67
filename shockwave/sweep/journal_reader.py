"""Reading of sweep folders: the lines of the journal in the order of the points."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from io import BytesIO
from itertools import chain, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import FileAccessError
from shockwave.files import lines_of, open_regular
from shockwave.sweep.header import Header, as_text

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
    index: int
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
            if line.index >= 0:
                offsets[line.index] = size
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
