"""Records in text files with a time and a force column, as oscilloscopes and data loggers write them."""

from __future__ import annotations

import csv
import io
import math
import pathlib
import re
from collections.abc import Sequence
from contextlib import suppress
from decimal import Decimal
from typing import NoReturn

import numpy as np
import numpy.typing as npt
from attrs import evolve, frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.files import read_text
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import join, text_of
from shockwave.records.record_format import Label, RecordFormat, factors, kind_of_unit, labels_of

#: Largest file [bytes]: a larger one is not a force record, and reading it would exhaust the memory.
MOST_BYTES = 128 * 2**20
# Longest line [characters], for the same reason.
_LONGEST_LINE = 10_000
# Columns that an error lists, and rows in which it looks for them.
_MOST_LISTED = 12
# Distance of neighbouring floats at the greatest time, over the mean sampling interval, that loses digits.
_COARSE = 1e-6

_NUMBER = re.compile(r"(?i)[+-]?(?:[.,]?[0-9]|(?:nan|inf|infinity)\b)")
# Numbers whose point or comma is no thousands mark, and a number that may have one.
_DECIMALS = re.compile(r"(?i)\b0[.,][0-9]|[0-9][.,](?:[0-9]{1,2}(?![0-9])|[0-9]{4})|[0-9]e")
_THOUSANDS = re.compile(r"\b[1-9][0-9]{0,2}(?:[.,' ][0-9]{3})+(?![0-9])")
# Dates and times of day.
_DATE = re.compile(r"[0-9]+[-./:](?:[0-9]+|[A-Za-z]{3,})[-./:][0-9]")
# Rows with a decimal comma whose columns are separated by commas or blanks.
_PADDED = re.compile(",[+-]?0[0-9]+(?![0-9.])|[0-9] +[+-]?[0-9]")
# Signs that stand for a minus and for blanks.
_SIGNS = str.maketrans({"\N{MINUS SIGN}": "-", "\xa0": " ", "\u202f": " "})


@frozen(eq=False)
class Record:
    """A force record in SI units.

    Attributes
    ----------
    times : array of float, shape (k,)
        Sample times [s], finite, in the order of the file.
    forces : array of float, shape (k,)
        Forces [N], finite.
    notes : tuple of str
        Sentences on how the values of the file were converted.
    lines : array of int, shape (k,)
        Line of the file, counted from 1, on which each sample stands.
    """

    times: FloatArray
    forces: FloatArray
    notes: tuple[str, ...]
    lines: npt.NDArray[np.int64]


# Number, counted from 1, and text of a line.
_Line = tuple[int, str]


@frozen
class _Table:
    """A file: lines above the numbers, lines of numbers (blank ones and comments omitted), and the column separator."""

    path: pathlib.Path
    form: RecordFormat
    head: list[_Line]
    body: list[_Line]
    separator: str

    def refuse(self, number: int, key: str, problem: str) -> NoReturn:
        """Raise an error in a line that names the key to set."""
        raise InvalidValueError.of(key, problem, f"{self.path}:{number}")


def read_record(path: pathlib.Path, form: RecordFormat | None = None, quantity: str = "force") -> Record:
    """Read a time column and a force column, or one of another quantity.

    Nothing is guessed: if neither the header nor ``form`` states a property, an error names its key.

    Parameters
    ----------
    path : pathlib.Path
        Text. Columns are separated by commas, semicolons, tabs or spaces. One header line can name the columns and, in
        brackets or after a slash, their units. Blank lines and comments (``#``, ``%``, ``//``) are ignored.
    form : RecordFormat, optional
        What the file does not state.
    quantity : str
        ``force``, or ``acceleration``, ``velocity`` or ``displacement``, whose SI values are then the forces.

    Returns
    -------
    Record
        Times [s] and forces [N], with notes on what was done.

    Raises
    ------
    FileAccessError
        If the file is missing, not a regular file, not text, or larger than 128 MiB.
    InvalidValueError
        If the file does not have a time and a force column of finite numbers, their units are not stated, or the force
        column is a record of another quantity; each error states its line.
    """
    table = _table(pathlib.Path(path), form or RecordFormat())
    labels = _labels(table, quantity)
    picks = _picks(table, labels, quantity)
    numbers, notes = _numbers(table, picks, len(labels)), list[str]()
    place = f"{path}:{table.head[-1][0] if table.head else table.body[0][0]}"
    per_time, per_force = factors(table.form, [labels[pick] for pick in picks], numbers, place, notes, quantity)
    times = _times(table, picks[0], numbers[:, 0], per_time, notes)
    return Record(times, numbers[:, 1] * per_force, tuple(notes), np.array([number for number, _ in table.body]))


def _table(path: pathlib.Path, form: RecordFormat) -> _Table:
    """Read the file and find its first row of numbers and its column separator."""
    text = read_text(path, MOST_BYTES, form.encoding).translate(_SIGNS).replace("\r\n", "\n").replace("\r", "\n")
    lines = list[_Line]()
    for number, line in enumerate(io.StringIO(text, newline="\n"), 1):  # one by one, as most lines may be blank
        if len(line) > _LONGEST_LINE:
            problem = f"must have lines of at most {_LONGEST_LINE} characters (got more)"
            raise InvalidValueError.of((), problem, str(path))
        stripped = line.strip("\n ")
        if number > form.skip_rows and stripped.strip() and not stripped.startswith(("#", "%", "//")):
            lines.append((number, stripped))
    columns = set((form.columns or [])[-1 if form.interval else 0 :])
    for at, (_, line) in enumerate(lines):
        numeric = _numeric(line, separator := _separator(line, form))
        if 1 in numeric or (columns and columns <= numeric):
            return _Table(path, form, lines[:at], lines[at:], separator)
    rows = [_numeric(line, _separator(line, form)) for _, line in lines[-_MOST_LISTED:]]
    # settings of an instrument, or dates, stand beside the numbers
    numeric = set.intersection(*rows) if rows else set()
    got = f"columns: {sorted(numeric)} are numbers" if numeric else "got no line that begins with a number"
    raise InvalidValueError.of("columns", f"must be a time and a force in each row ({got})", str(path))


def _separator(line: str, form: RecordFormat) -> str:
    """The separator of the columns of a row, empty for blanks."""
    comma = "" if form.decimal == "," and '"' not in line else ","
    return next((mark for mark in (";", "\t", comma) if mark and mark in line), "")


def _cells(line: str, separator: str) -> list[str]:
    """Cells of a line, without empty ones at its end; a separator between quotes belongs to its cell."""
    line = line.rstrip(f"{separator} ")
    cells = next(csv.reader([line], delimiter=separator or " ")) if '"' in line else line.split(separator or None)
    return [cell.strip() for cell in cells] or [""]


def _numeric(line: str, separator: str) -> set[int]:
    """Columns of a line, counted from 1, that are numbers."""
    return {at for at, cell in enumerate(_cells(line, separator), 1) if _NUMBER.match(cell)}


# ---------------------------------------------------------------- header


def _labels(table: _Table, quantity: str) -> list[Label]:
    """Labels of all columns, which are empty without a header."""
    (first, line), (last, above) = table.body[0], (table.head or table.body)[-1]
    # blanks separate columns, but not a name from its unit
    above = above if table.separator else re.sub(r" (?=[\[(/])|(?<=/) ", "", " ".join(above.split()))
    width = len(_cells(line, table.separator))
    labels = labels_of(_cells(above, table.separator), width, quantity) if table.head else []
    few, units = len(labels) < width, any(label.unit for label in labels)
    commas = few and table.separator == "," and not table.form.decimal and '"' not in line
    if commas and (units or any(_PADDED.search(row) for _, row in table.body)):
        hint = "write the file anew with semicolons, or set decimal: ',' if blanks separate the columns"
        table.refuse(first, "decimal", f"must not be a comma if commas separate columns (got {text_of(line)}; {hint})")
    if table.head and (few or len(table.head) > 1):
        number, line = table.head[0]
        hint = f"name all columns in line {last}" if few and units else f"skip_rows: {(last, first)[few] - 1} skips it"
        rule = f"must leave one line with a name for each column, {width} in all"
        table.refuse(number, "skip_rows", f"{rule} (got {text_of(line)}; {hint})")
    return labels or [Label()] * width


def _picks(table: _Table, labels: Sequence[Label], quantity: str) -> list[int]:
    """Columns of time and force: those of the format, or by their units, or in this order if there are just these.

    With a sampling interval, the column of the force stands for both.
    """
    every, fewest = range(1, len(labels) + 1), 1 if table.form.interval else 2
    kinds = [kind_of_unit(label.unit, quantity) for label in labels]
    times = [at for at in every if kinds[at - 1] == "time"]
    # numbers without a unit may be forces, but for those before columns with units: they count samples or are dates
    plain = {at for at in _numeric(table.body[0][1], table.separator) if not labels[at - 1].unit}
    plain -= {1} if len(plain) < len(labels) else set()
    values = [at for at in every if kinds[at - 1] not in (None, "time") or at in plain]
    columns = table.form.columns or list(every)
    if not table.form.columns and len(values) == 1 and len(times) in (1, fewest - 1):
        columns = [*times[: fewest - 1], *values]
    if not fewest <= len(columns) <= (2 if table.form.columns else fewest) or not set(columns) <= set(every):
        pairs = [[(*times, 1)[0], at][-fewest:] for at in values or every]
        hints = [f"columns: {pair} {labels[pair[-1] - 1].text}".rstrip() for pair in pairs if len({*pair}) == fewest]
        hint = join(hints[:_MOST_LISTED] or ["without times, set interval"])
        problem = f"must be the columns of time and force, of {len(labels)} (got {table.form.columns}; {hint})"
        table.refuse(table.body[0][0], "columns", problem)
    return [columns[-fewest] - 1, columns[-1] - 1]


# ---------------------------------------------------------------- body


def _numbers(table: _Table, picks: Sequence[int], width: int) -> FloatArray:
    """Time and force columns, shape (k, 2), finite; one error states the first wrong row and how many there are."""
    body = "\n".join([line for _, line in table.body])
    marked = _THOUSANDS.search(body) if table.separator != "," or '"' in body else None
    if marked and not table.form.decimal and not _DECIMALS.search(body):
        rule = "must be stated if all numbers have three digits after the point or commas"
        table.refuse(table.body[0][0], "decimal", f"{rule} (got {marked[0]}; remove thousands marks)")
    with suppress(ValueError):  # plain numbers are read at once, anything else line by line
        plain = np.loadtxt(body.split("\n"), comments=None, delimiter=table.separator or None, ndmin=2)
        if table.form.decimal != "," and max(picks) < plain.shape[1] <= width and np.isfinite(plain[:, picks]).all():
            return plain[:, picks]
    numbers = np.array([_pair(_cells(line, table.separator), picks, width, table.form) for _, line in table.body])
    right = np.isfinite(numbers).all(axis=1)
    if not right.all():
        at = int(np.argmin(right))
        number, line = table.body[at]
        behind = table.body[np.argmax(right)][0] - 1
        hint = "correct or delete them"
        if np.isfinite(_pair(_cells(line, table.separator), picks, width, evolve(table.form, decimal=","))).all():
            hint = "set decimal: ','"
        elif _DATE.search(line) or _THOUSANDS.search(line):
            hint = "dates and thousands separators are not read: set interval in place of dates, remove thousands marks"
        elif behind >= number:
            hint = f"delete lines {number} to {behind}" if table.head else f"skip_rows: {behind} skips the first"
        got = f"got {text_of(line)}, one of {np.count_nonzero(~right)}; {hint}"
        table.refuse(number, "row", f"must be finite numbers, in at most {width} columns ({got})")
    return numbers


def _pair(cells: Sequence[str], picks: Sequence[int], width: int, form: RecordFormat) -> list[float]:
    """Time and force of a row; NaN if they are not numbers, or it has too many or too few cells."""
    try:
        return [float(form.plain(cells[pick])) for pick in picks] if len(cells) <= width else [math.nan, math.nan]
    except (ValueError, IndexError):
        return [math.nan, math.nan]


def _times(table: _Table, pick: int, times: FloatArray, factor: float, notes: list[str]) -> FloatArray:
    """Times [s], counted from the first sample if floats cannot hold their digits."""
    if table.form.interval is not None:
        return table.form.interval * np.arange(times.size, dtype=float)
    if np.spacing(np.abs(times).max()) * times.size > _COARSE * np.ptp(times):
        first, *_ = exact = [Decimal(table.form.plain(_cells(line, table.separator)[pick])) for _, line in table.body]
        times = np.array([float(time - first) for time in exact])
        notes.append(f"The times count from the first sample, at {first} in the unit of the file.")
    return times * factor
