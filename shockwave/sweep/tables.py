"""Tables of a sweep's results: CSV and JSON Lines."""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

from attrs import frozen

from shockwave.files import replacing
from shockwave.sweep.header import Header, as_text
from shockwave.sweep.journal import JOURNAL, Row, SweepFolder

# Characters that start a formula in a spreadsheet.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def write_tables(folder: str | os.PathLike[str]) -> list[Path]:
    """Write the tables of the sweep in ``folder``, unless they are newer than the journal.

    Parameters
    ----------
    folder : path-like
        With ``sweep.json`` and ``journal.jsonl``.

    Returns
    -------
    list of pathlib.Path
        What was written: ``results.csv`` and ``results.jsonl``, or nothing.

    Raises
    ------
    FileAccessError
        When a file cannot be read or written; a table that was there is left as it was.
    InvalidValueError
        When the header is none.
    """
    files = [Path(folder) / name for name in _TABLES]
    journal = Path(folder) / JOURNAL
    changed = journal.stat().st_mtime_ns if journal.exists() else math.inf
    if all(file.exists() and file.stat().st_mtime_ns > changed for file in files):
        return []
    swept = SweepFolder.read(folder)
    with ExitStack() as stack:
        writers = [_TABLES[file.name](stack.enter_context(replacing(file)), swept.header) for file in files]
        for row in swept.rows():
            for write in writers:
                write(row)
    return files


# Takes one point after the other; memory does not grow with their number.
_Write = Callable[[Row], object]


def _csv(file: IO[Any], header: Header) -> _Write:
    """One row for each point, in their order: variables, columns, status, problem."""
    writer = csv.writer(_LineFeeds(file))
    units = header.variables | {column.name: column.unit for column in header.columns}
    names = [f"{name} [{unit}]" if unit else name for name, unit in units.items()]
    writer.writerow(map(_cell, [*names, "status", "problem"]))

    return lambda row: writer.writerow(map(_cell, (*row.point, *row.values, row.status, row.problem)))


@frozen
class _LineFeeds:
    """Ends rows by LF in place of the CR LF of a csv writer, which has to end rows by CR LF to quote every CR."""

    file: IO[str]

    def write(self, row: str) -> int:
        return self.file.write(row.removesuffix("\r\n") + "\n")


def _cell(value: Any) -> Any:
    """Value as a cell; an apostrophe precedes text that a spreadsheet would evaluate as a formula."""
    if isinstance(value, float):  # the writer gives floats all their digits
        return value
    text = as_text(value)
    return f"'{text}" if isinstance(value, str) and text is not None and text.startswith(_FORMULA) else text


def _json_lines(file: IO[Any], header: Header) -> _Write:
    """One object for each point, in their order."""
    names = ["index", *header.variables, *(column.name for column in header.columns), "status", "problem"]

    def write(row: Row) -> None:
        values = (row.number, *row.point, *row.values, row.status, row.problem)
        file.write(json.dumps(dict(zip(names, values, strict=True))) + "\n")

    return write


_TABLES: dict[str, Callable[[IO[Any], Header], _Write]] = {"results.csv": _csv, "results.jsonl": _json_lines}
