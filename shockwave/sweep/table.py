"""Tables of a sweep's results: CSV and JSON Lines always, and the files of arrays beside them."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager, contextmanager
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from typing import IO, Any, TypeAlias

from attrs import frozen

from shockwave.errors import FileAccessError, ShockwaveError
from shockwave.files import open_new, parse_json, read_bytes
from shockwave.sweep.stored import Chunk, Header, Stored, as_text

__all__ = ["RECORD", "Take", "write_all"]

#: Which tables were written, and of which state of the journal.
RECORD = "tables.json"
# Its largest size [bytes].
_MOST_RECORD = 2**20
# Characters that start a formula in a spreadsheet.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
# Names and units of the columns after those of the sweep.
_LAST = (("status", None), ("problem", None))

#: Takes points, which follow those before; memory does not grow with their number.
Take: TypeAlias = Callable[[Chunk], None]


@contextmanager
def _csv(file: IO[Any], header: Header) -> Iterator[Take]:
    """One row for each point, in their order: variables, columns, status, problem."""
    writer = csv.writer(_Lines(file))
    units = header.variables | {column.name: column.unit for column in header.columns}
    writer.writerow([_cell(f"{name} [{unit}]" if unit else name) for name, unit in (*units.items(), *_LAST)])

    def take(chunk: Chunk) -> None:
        # the writer gives floats all their digits, and leaves the cell of None empty
        writer.writerows(
            [*map(_cell, (*point, *values)), status, _cell(problem)]
            for point, (status, values, problem) in zip(chunk.points, chunk.rows, strict=True)
        )

    yield take


@frozen
class _Lines:
    """Replace the CR LF that a csv writer puts at the end of each row by LF.

    The writer quotes a cell that contains a character of its line end, so CR LF makes it quote every CR; an unquoted CR
    would end a row too.
    """

    file: IO[str]

    def write(self, row: str) -> int:
        return self.file.write(row.removesuffix("\r\n") + "\n")


def _cell(value: Any) -> Any:
    """Value as a cell; an apostrophe precedes text that a spreadsheet would evaluate as a formula."""
    if isinstance(value, float):
        return value
    text = as_text(value)
    return f"'{text}" if isinstance(value, str) and text is not None and text.startswith(_FORMULA) else text


@contextmanager
def _json_lines(file: IO[Any], header: Header) -> Iterator[Take]:
    """One object for each point, in their order."""
    names = ["index", *header.variables, *(column.name for column in header.columns), "status", "problem"]

    def take(chunk: Chunk) -> None:
        pairs = zip(chunk.points, chunk.rows, strict=True)
        file.writelines(
            json.dumps(dict(zip(names, (index, *point, *values, status, problem), strict=True))) + "\n"
            for index, (point, (status, values, problem)) in enumerate(pairs, start=chunk.begin)
        )

    yield take


# Who has no use for the other tables waits for no library of theirs.
def _net_cdf(file: IO[Any], header: Header) -> AbstractContextManager[Take]:
    from shockwave.sweep.netcdf import net_cdf

    return net_cdf(file, header)


def _parquet(file: IO[Any], header: Header) -> AbstractContextManager[Take]:
    from shockwave.sweep.parquet import parquet

    return parquet(file, header)


_TABLES: dict[str, Callable[[IO[Any], Header], AbstractContextManager[Take]]] = {
    "results.csv": _csv,
    "results.jsonl": _json_lines,
    "results.nc": _net_cdf,
    "results.parquet": _parquet,
}


def write_all(folder: str | os.PathLike[str]) -> list[Path]:
    """Write all tables of the sweep in ``folder`` that are not there as the journal now stands.

    Parameters
    ----------
    folder : path-like
        With ``sweep.json`` and ``journal.jsonl``.

    Returns
    -------
    list of pathlib.Path
        What was written: ``results.csv``, ``results.jsonl``, ``results.nc``, and with pyarrow ``results.parquet``;
        none if all were there.

    Raises
    ------
    FileAccessError
        When a file cannot be read or written; a table that was there is left as it was, and the others are written.
    InvalidValueError
        When the header is none.
    """
    stored = Stored.read(folder)
    place = stored.folder
    wanted = [name for name in _TABLES if name != "results.parquet" or find_spec("pyarrow") is not None]
    state = {"key": stored.header.key, "journal_bytes": stored.size}
    known = _recorded(place / RECORD)
    same = known[0] == state
    due = [name for name in wanted if not (same and name in known[1] and (place / name).exists())]
    if not due:
        return []
    problems = _fill({place / name: _table(place / name, stored.header) for name in due}, stored.chunks())
    written = [place / name for name in due if place / name not in problems]
    kept = [place / name for name in known[1] if same]
    record = {**state, "files": [name for name in _TABLES if place / name in (*written, *kept)]}
    try:
        with _replacing(place / RECORD, "x") as file:
            file.write(json.dumps(record) + "\n")
    except OSError as error:
        problems[place / RECORD] = error
    if problems:
        told = [f"{file}: cannot be written (got {_reason(error)})" for file, error in problems.items()]
        raise FileAccessError("\n".join(told)) from next(iter(problems.values()))
    return written


def _fill(tables: dict[Path, Generator[None, Chunk | None]], chunks: Iterator[Chunk]) -> dict[Path, Exception]:
    """Give all tables all points; what kept one from being written costs no other."""
    problems: dict[Path, Exception] = {}
    try:
        for chunk in chain([None], chunks, [None]):
            for file, table in tables.items():
                try:
                    table.send(chunk)
                except StopIteration:
                    pass  # it is whole, or has failed before
                except Exception as error:  # a library raises what it will
                    problems[file] = error
    finally:
        for table in tables.values():
            table.close()
    return problems


def _reason(error: Exception) -> str:
    return (isinstance(error, OSError) and error.strerror) or f"{type(error).__name__}: {error}"


def _recorded(file: Path) -> tuple[dict[str, Any], list[str]]:
    """The state of which tables were written, and their names."""
    try:
        record = parse_json(read_bytes(file, _MOST_RECORD), str(file))
    except ShockwaveError:
        return {}, []
    files = record.pop("files", None) if isinstance(record, dict) else None
    return (record, [name for name in _TABLES if name in files]) if isinstance(files, list) else ({}, [])


def _table(file: Path, header: Header) -> Generator[None, Chunk | None]:
    """Takes the points for a table, begun and ended by None; the table is there when it has ended."""
    mode = "x" if file.suffix in (".csv", ".jsonl") else "xb"
    with _replacing(file, mode) as opened, _TABLES[file.name](opened, header) as write:
        while (chunk := (yield)) is not None:
            write(chunk)


@contextmanager
def _replacing(file: Path, mode: str) -> Iterator[IO[Any]]:
    """A new file, which takes the place of ``file`` when it is whole, and is deleted when it is not."""
    part = file.with_name(f"{file.name}.part")
    text: dict[str, Any] = {} if "b" in mode else {"encoding": "utf-8", "errors": "backslashreplace", "newline": ""}
    opened = open_new(part, mode, **text)
    try:
        yield opened
        opened.close()
        part.replace(file)
    except BaseException:
        _discard(opened, part)
        raise


def _discard(opened: IO[Any], part: Path) -> None:
    try:
        opened.close()
    except OSError:  # what was not yet written has no room either
        pass
    finally:
        part.unlink(missing_ok=True)
