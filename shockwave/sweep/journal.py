"""Journal of a sweep: a database with a row for each finished point, written by one client; and its tables."""

from __future__ import annotations

import csv
import json
import os
import sqlite3
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from itertools import chain, product
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from shockwave.base.errors import FileAccessError
from shockwave.base.files import not_writable, open_regular, replace_file
from shockwave.base.progress import report_progress
from shockwave.base.text import replace_unfit
from shockwave.sweep.definition import DEFINITION, NOTES, SweepDefinition, as_text, warnings_in

JOURNAL = "journal.sqlite"
#: Status of a point without a row in the journal.
NOT_RUN = "not run"
#: Status of points that can be run again.
FAILED = ("failed", "crashed")
#: Number of a finished point, its status, and the values of the columns as JSON or its error.
Entry: TypeAlias = tuple[int, str, str | None, str | None]
_LOCK = "sweep.lock"
_TABLE = "points (number INTEGER PRIMARY KEY, status TEXT NOT NULL, results TEXT, problem TEXT)"
# Time to wait for another process that reads or writes [s].
_TIMEOUT = 60.0


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
        # a sweep that was killed at its beginning has no journal
        self._mode = "rw" if os.path.exists(self.path) else "memory"
        self._counts = Counter({NOT_RUN: points})

    def count(self, *statuses: str) -> int:
        """Return the number of points with one of these statuses."""
        return sum(self._counts[status] for status in statuses)

    @contextmanager
    def _connect(self) -> Iterator[sqlite3.Connection]:
        """Connect to the database for one transaction; raises `FileAccessError` if it cannot be used."""
        if self._mode == "rw":
            open_regular(self.path).close()  # opening a pipe would block
        try:
            name = f"{self.path.absolute().as_uri()}?mode={self._mode}"
            with closing(sqlite3.connect(name, _TIMEOUT, uri=True)) as database, database:
                database.execute("PRAGMA journal_mode = TRUNCATE")  # ten times as fast as the default
                database.execute(f"CREATE TABLE IF NOT EXISTS {_TABLE}")
                # no views or triggers of a folder from another source, which could run without end
                if database.execute("SELECT sql FROM sqlite_master").fetchall() != [(f"CREATE TABLE {_TABLE}",)]:
                    raise sqlite3.DatabaseError("it must contain the table of points alone")
                yield database
        except sqlite3.Error as error:
            raise FileAccessError(f"{self.path}: cannot be read or written as a journal ({error})") from error

    # ---------------------------------------------------------------- reading

    def read(self) -> None:
        """Read how many points are finished; raises `FileAccessError` if the journal cannot be read."""
        with self._connect() as database:
            self._counts = Counter(dict(database.execute("SELECT status, count(*) FROM points GROUP BY status")))
        self._counts[NOT_RUN] = self.points - self._counts.total()

    def open_points(self) -> list[int]:
        """Return the numbers of the unfinished points in ascending order."""
        with self._connect() as database:
            finished = {number for (number,) in database.execute("SELECT number FROM points")}
        return [number for number in range(self.points) if number not in finished]

    def rows(self, definition: SweepDefinition) -> Iterator[Row]:
        """Yield all points in their order; raises `FileAccessError` if the journal cannot be read."""
        places = product(*(axis.values for axis in definition.axes))
        nothing = [None] * len(definition.columns)
        query = "SELECT status, results, problem FROM points WHERE number = ?"
        with self._connect() as database:
            for number, positions in enumerate(places):
                status, results, problem = database.execute(query, (number,)).fetchone() or (NOT_RUN, None, None)
                values = json.loads(results) if results else nothing
                yield Row(number, tuple(chain(*positions)), status, values, problem)

    # ---------------------------------------------------------------- writing

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Create the folder if necessary, and lock it against other clients.

        Raises
        ------
        FileAccessError
            If the folder cannot be written, is in use by another client, or holds other files.
        """
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            _refuse_others(self.folder)
        except (OSError, ValueError) as error:  # a ValueError for a NUL character in the path
            raise not_writable(self.folder, error) from error
        open_regular(self.folder / _LOCK, mode="ab").close()
        with closing(sqlite3.connect(self.folder / _LOCK, timeout=0)) as lock:
            try:
                lock.execute("BEGIN EXCLUSIVE")
            except sqlite3.Error as error:
                rule = "must be used by one client at a time"
                raise FileAccessError(f"{self.folder}: {rule} (got: {error}; wait until it ends, or stop it)") from None
            yield

    def begin(self, retry_failed: bool) -> None:
        """Read the journal, or create it; if ``retry_failed``, remove the points that failed or crashed."""
        open_regular(self.path, mode="ab").close()
        self._mode = "rw"
        if retry_failed:
            with self._connect() as database:
                database.execute("DELETE FROM points WHERE status IN (?, ?)", FAILED)
        self.read()

    def add(self, entries: Sequence[Entry]) -> None:
        """Add finished points, all or none; raises `FileAccessError` if they cannot be written."""
        with self._connect() as database:
            database.executemany("INSERT INTO points VALUES (?, ?, ?, ?)", entries)
        self._counts.update(status for _, status, *_ in entries)
        self._counts[NOT_RUN] -= len(entries)


def _refuse_others(folder: Path) -> None:
    """Refuse a folder that holds files but no sweep."""
    names = {file.name for file in folder.iterdir()}
    strange = sorted(name for name in names if not (name.startswith(_LOCK) or name.endswith(".part")))
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
