"""Reading of sweep folders: the lines of the journal in the order of the points."""

from __future__ import annotations

import json
import os
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
#: Longest line of the journal [bytes].
LONGEST_LINE = 2**24
#: The status of a point that has no line in the journal.
NOT_RUN = "not run"
_TYPES = {"number": (float, int), "whole": (int,), "text": (str,)}


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
    def read(cls, folder: str | os.PathLike[str]) -> SweepFolder:
        """The sweep in ``folder``; see `Header.read` for what is raised."""
        place = Path(folder)
        header = Header.read(place)
        offsets = np.full(header.points, -1, dtype=np.int64)
        size = strange = 0
        line = b"\n"
        # a sweep that was killed before its first point has no journal
        if (place / JOURNAL).exists():
            with open_regular(place / JOURNAL) as file:
                for line in lines_of(file, place / JOURNAL, LONGEST_LINE):
                    index = _index(line)
                    if 0 <= index < header.points:
                        offsets[index] = size
                    else:
                        strange += 1
                    size += len(line)
        torn = not line.endswith(b"\n")
        lacking = int(np.count_nonzero(offsets < 0))
        found = {
            f"the last line of {JOURNAL} is torn, and was left out: run the sweep again to mend it": torn,
            f"lines of {JOURNAL} that are of no point, and were left out: {strange - torn}": strange > torn,
            f"{lacking} of {len(offsets)} points are not done: run the sweep again to resume it": lacking > 0,
            header.version_note: bool(header.version_note),
        }
        return cls(place, header, offsets, size, tuple(text for text, holds in found.items() if holds))

    def rows(self) -> Iterator[Row]:
        """All points in their order, one at a time.

        Raises
        ------
        FileAccessError
            When the journal cannot be read.
        """
        axes = (axis.values for axis in self.header.axes)
        journal = open_regular(self.folder / JOURNAL) if self.size else BytesIO()
        with journal as file:
            for index, (offset, positions) in enumerate(zip(self.offsets.tolist(), product(*axes), strict=True)):
                line = b""
                try:
                    if offset >= 0:
                        file.seek(offset)
                        line = file.readline(LONGEST_LINE)
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


def _index(line: bytes) -> int:
    """The number of the point of a line of the journal; -1 if it has none, or is torn."""
    begin = b'{"index": '
    if not (line.startswith(begin) and line.endswith(b"}\n")):
        return -1
    number = line[len(begin) : line.find(b",")]
    return int(number) if number.isdigit() and len(number) < 10 else -1
