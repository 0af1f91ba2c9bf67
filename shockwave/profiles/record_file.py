"""Records in text files with a time and a force column, as oscilloscopes and data loggers write them."""

from __future__ import annotations

import math
import pathlib
import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import NoReturn

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import listed, text_of
from shockwave.files import read_text
from shockwave.profiles.record_format import (
    DECIMALS,
    FORCE_NAMES,
    THOUSANDS,
    TIME_NAMES,
    RecordFormat,
    force_factor,
    time_factor,
)
from shockwave.profiles.record_labels import (
    NARROW_SPACES,
    columns_named,
    name_and_unit,
    names_columns,
    number_in,
    states_units,
)
from shockwave.quadrature import FloatArray

# Largest file [bytes]: a larger one is not a force record, and reading it would exhaust the memory.
_MOST_BYTES = 128 * 2**20
# Longest line [characters], for the same reason.
_LONGEST_LINE = 10_000
# Errors that are reported for one file: more would not help to correct it.
_MOST_FAULTS = 20

_ROW_OF_NUMBERS = re.compile(r'(?i)["\s]*[+-]?(?:[.,]?[0-9]|(?:nan|inf|infinity)\b)')
# A number that may have thousands marks, or a decimal sign and three decimals.
_GROUPED = re.compile(r"[+-]?[1-9][0-9]{0,2}(?:([.,])[0-9]{3})(?:\1[0-9]{3})*")
# The beginning of a comment such as "Columns: time [ms], force [kN]".
_PREFIX = re.compile(r"\A\s*[^\W\d][\w ]*:\s+")

_COMMENTS = ("#", "%", "//")


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
        Assumptions about the file, in sentences.
    lines : array of int, shape (k,)
        Line of the file, counted from 1, on which each sample stands.
    """

    times: FloatArray
    forces: FloatArray
    notes: tuple[str, ...]
    lines: npt.NDArray[np.int64]


@frozen
class _Text:
    """The lines of a file, its format, the column separator, and the index of the first row of numbers."""

    path: pathlib.Path
    lines: list[str]
    form: RecordFormat
    separator: str
    first: int

    def kept(self, start: int, stop: int) -> list[int]:
        """Indices of the lines in ``[start, stop)`` that are neither blank nor a comment."""
        rows = enumerate(map(str.strip, self.lines[start:stop]), start)
        return [index for index, row in rows if row and not row.startswith(_COMMENTS)]

    def fault(self, index: int, name: str, problem: str) -> Fault:
        """Error in the line ``index``, counted from 0."""
        return Fault(name, problem, location=f"{self.path}:{index + 1}")

    def refuse(self, index: int, name: str, problem: str) -> NoReturn:
        """Raise an error in the line ``index``, counted from 0."""
        raise InvalidValueError([self.fault(index, name, problem)])

    @property
    def comma_hint(self) -> str:
        """Hint for a wrong number of columns."""
        hint = "; if the comma is the decimal separator, separate the columns by semicolons or set decimal: ','"
        return hint if self.separator == "," else ""


def read_record(path: pathlib.Path, form: RecordFormat | None = None) -> Record:
    """Read a time column and a force column.

    Parameters
    ----------
    path : pathlib.Path
        Text. Columns are separated by commas, semicolons, tabs or spaces; with semicolons or tabs the decimal
        sign can be a comma. A header line can name the columns and, in brackets or after a slash, their units. Blank
        lines and comments (``#``, ``%``, ``//``) are ignored.
    form : RecordFormat, optional
        What the file does not state.

    Returns
    -------
    Record
        Times [s] and forces [N], with notes that state the assumptions.

    Raises
    ------
    FileAccessError
        If the file is missing, not a regular file, not text, or larger than 128 MiB.
    InvalidValueError
        If the file does not have a time and a force column of finite numbers, or the force column is a record of
        another quantity; each error states its line.
    """
    notes: list[str] = []
    text = _text(pathlib.Path(path), form or RecordFormat(), notes)
    header, labels = _header(text, notes)
    names, units = zip(*map(name_and_unit, labels), strict=True)
    picks = _picks(text, labels, names, notes)
    if header != text.first:
        units = _with_comment(text, units, picks, notes)
    factors = _factors(text, header, [names[pick] for pick in picks], [units[pick] for pick in picks], notes)
    rows = text.kept(text.first, len(text.lines))
    table = _numbers(text, rows, len(names), picks) * factors
    return Record(table[:, 0].copy(), table[:, 1].copy(), tuple(notes), np.array(rows) + 1)


def _text(path: pathlib.Path, form: RecordFormat, notes: list[str]) -> _Text:
    """Read the file and find its first row of numbers and its column separator."""
    whole, encoding = read_text(path, _MOST_BYTES, form.encoding)
    if encoding == "cp1252" and form.encoding is None:
        notes.append("The file is not UTF-8 and was read as cp1252.")
    lines = whole.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    numbers = (index for index, line in enumerate(lines) if index >= form.skip_rows and _is_row(line, form.columns))
    first = next(numbers, None)
    if first is None:
        problem = "must be numbers, with a time and a force in each row (got no row of numbers)"
        raise InvalidValueError([Fault("rows", problem, str(path))])
    row = re.sub(r'"[^"]*"', "", lines[first].strip())
    comma = [] if "," in (form.decimal, form.thousands) and '"' not in lines[first] else [","]
    separator = next((mark for mark in (";", "\t", *comma) if mark in row), "")
    text = _Text(path, lines, form, separator, first)
    long = next((index for index, line in enumerate(lines) if len(line) > _LONGEST_LINE), None)
    if long is not None:
        text.refuse(long, "row", f"must have at most {_LONGEST_LINE} characters (got {len(lines[long])})")
    return text


def _is_row(line: str, columns: Sequence[int | str] | None) -> bool:
    """Whether a line begins with a number, or has numbers in the given columns behind settings of an instrument."""
    if _ROW_OF_NUMBERS.match(line) or columns is None or line.lstrip().startswith(_COMMENTS):
        return bool(_ROW_OF_NUMBERS.match(line))
    cells = dict(enumerate(line.split(next((mark for mark in ";\t," if mark in line), None)), 1))
    return all(isinstance(column, int) and _ROW_OF_NUMBERS.match(cells.get(column, "")) for column in columns)


def _cells(line: str, separator: str, count: int = 0) -> list[str]:
    """Cells of a line, without quotes and, unless they are ``count``, without an empty one behind a last separator."""
    if separator and '"' in line:  # a separator between quotes belongs to the cell
        line = re.sub(r'"[^"]*"', lambda quoted: quoted[0].replace(separator, "\0"), line)
    cells = [cell.strip("\"' \t").replace("\0", separator) for cell in line.strip(" \n").split(separator or None)]
    return cells[:-1] if len(cells) not in (1, count) and not cells[-1] else cells


# ---------------------------------------------------------------- header


def _header(text: _Text, notes: list[str]) -> tuple[int, list[str]]:
    """Index of the header line, counted from 0, and its cells, empty if there is none."""
    headers = text.kept(text.form.skip_rows, text.first)
    count = len(_cells(text.lines[text.first], text.separator))
    if len(headers) > 1:
        got = f"got {text_of(text.lines[headers[1]])}; to skip what is above it set skip_rows: {headers[-1]}"
        text.refuse(headers[1], "row", f"must be numbers: only one header line is allowed ({got})")
    if not headers:
        settled = bool(text.form.time_unit and text.form.unit)
        headers = _header_in_comment(text, count, settled, unnamed=True)
        notes += [f"The column names were read from the comment in line {index + 1}." for index in headers]
    if not headers:
        return text.first, [""] * count
    (index,) = headers
    cells = _labels(text, index)
    if any(math.isfinite(number_in(cell)) for cell in cells):
        got = text_of(text.lines[index])
        text.refuse(index, "row", f"must be either column names or numbers, not both (got {got})")
    if len(cells) != len(_cells(text.lines[text.first], text.separator, len(cells))):
        got = f"got {len(cells)} names; line {text.first + 1} has {count}{text.comma_hint}"
        text.refuse(index, "header", f"must name every column ({got}; skip_rows skips lines)")
    return index, cells


def _labels(text: _Text, index: int) -> list[str]:
    """Cells of a header line, whose separator can differ from that of the numbers."""
    line = _title(text, index)
    mark = next((mark for mark in (text.separator, ";", "\t", ",") if mark and mark in line), "")
    if not mark:  # spaces separate the columns, but not a name from its unit
        line = re.sub(r"\s+(?=[\[(/])|(?<=/)\s+", "", " ".join(line.split()))
    return _cells(line, mark)


def _title(text: _Text, index: int) -> str:
    line = text.lines[index].strip()
    return _PREFIX.sub("", line.lstrip("#%/;"), count=1).strip() if line.startswith(_COMMENTS) else line


def _header_in_comment(text: _Text, count: int, settled: bool, unnamed: bool) -> list[int]:
    """The comment over the numbers that names the columns or their units, as in files written by NumPy.

    If the columns are ``unnamed``, the last line above the numbers may name them without units. Unless the units are
    ``settled``, a comment that states units and cannot be used is an error.
    """
    lines = [index for index in range(text.form.skip_rows, text.first) if text.lines[index].strip()]
    comments = [index for index in lines if text.lines[index].strip().startswith(_COMMENTS)]
    for index in reversed(comments):
        if names_columns(_labels(text, index), count, unnamed and index == lines[-1]):
            return [index]
    for index in comments:
        if not settled and states_units(_labels(text, index), _title(text, index), count):
            got = f"got {text_of(text.lines[index])}; set unit and time_unit"
            hint = f"with one name and unit for each of the {count} columns, such as # time [ms], force [kN]"
            text.refuse(index, "comment", f"must be a header {hint}, because it states a unit ({got})")
    return []


def _with_comment(text: _Text, units: tuple[str, ...], picks: Sequence[int], notes: list[str]) -> tuple[str, ...]:
    """Units of the header, and those of a comment for the columns for which it has none."""
    stated = zip((text.form.time_unit, text.form.unit), picks, strict=True)
    if all(key or units[pick] for key, pick in stated):
        return units
    for index in _header_in_comment(text, len(units), settled=False, unnamed=False):
        notes.append(f"The units were read from the comment in line {index + 1}.")
        pairs = zip(units, _labels(text, index), strict=True)
        return tuple(unit or name_and_unit(cell)[1] for unit, cell in pairs)
    return units


def _picks(text: _Text, labels: Sequence[str], names: Sequence[str], notes: list[str]) -> list[int]:
    """Columns of time and force: those of the format, by their names, or in this order if there are only two."""
    if text.form.columns is not None:
        return [_column(text, column, labels, names) for column in text.form.columns]
    times = columns_named(names, TIME_NAMES)
    forces = columns_named(names, FORCE_NAMES[text.form.kind])
    plain = (times, forces) == ([0], [1])
    if len(names) == 2 and len(times + forces) < 2:
        times = times or [1 - force for force in forces] or [0]
        forces = [1 - times[0]]
    if not len(times) == len(forces) == 1 or times == forces:
        shown = ", ".join(map(text_of, names[:12])) if any(names) else "no header"
        hint = f"set columns, such as [1, 2], or name them 'time [s]' and 'force [N]' in a header{text.comma_hint}"
        problem = f"must include one time and one force column (got {len(names)} columns: {shown}; {hint})"
        text.refuse(text.first, "columns", problem)
    if any(names) and not plain:
        notes.append(f"The time column is {names[times[0]]!r}, the force column {names[forces[0]]!r}.")
    return times + forces


def _column(text: _Text, column: int | str, labels: Sequence[str], names: Sequence[str]) -> int:
    """Index of a column that the format gives by its number, its name, or its name with the unit."""
    if isinstance(column, int):
        found = [column - 1] if 1 <= column <= len(names) else []
    else:
        pairs = enumerate(zip(labels, names, strict=True))
        found = [index for index, known in pairs if column.casefold() in map(str.casefold, known)]
    if len(found) != 1:
        known = listed([f"{number} ({label})" if label else number for number, label in enumerate(labels, 1)][:12])
        text.refuse(text.first, "columns", f"must be columns of the file (got {column!r}; they are {known})")
    return found[0]


def _factors(text: _Text, header: int, names: Sequence[str], units: Sequence[str], notes: list[str]) -> list[float]:
    """Factors that convert the two columns to SI units; errors in both are raised together."""
    form, factors, faults = text.form, [], []
    for find, name, unit in zip((time_factor, force_factor), names, units, strict=True):
        try:
            factors.append(find(form, name, unit, notes))
        except InvalidValueError as error:
            faults += [text.fault(header, fault.path, fault.problem) for fault in error.faults]
    if faults:
        raise InvalidValueError(faults)
    return factors


# ---------------------------------------------------------------- body


def _numbers(text: _Text, rows: Sequence[int], count: int, picks: Sequence[int]) -> FloatArray:
    """Time and force columns of the lines ``rows``, shape (k, 2), finite."""
    form, decimal = text.form, text.form.decimal
    if (decimal or form.thousands) is None and text.separator != ",":
        _check_marks(text, rows, picks)
    # Plain numbers are read at once; anything else line by line, so that errors state their line.
    with suppress(ValueError):
        lines = [text.lines[index] for index in rows]
        plain = np.loadtxt(lines, comments=None, delimiter=text.separator or None, ndmin=2)
        if decimal != "," and not form.thousands and plain.shape[1] == count and np.isfinite(plain[:, picks]).all():
            return plain[:, picks]
    semicolons = text.separator in (";", "\t") and any("," in text.lines[index] for index in rows)
    decimal = decimal or ("," if form.thousands == "." or (semicolons and form.thousands != ",") else ".")
    table = []
    faults = []
    for index in rows:
        cells = _cells(text.lines[index], text.separator, count)
        if len(cells) != count:
            got = f"got {len(cells)}: {text_of(text.lines[index])}{text.comma_hint}"
            faults.append(text.fault(index, "row", f"must have {count} columns ({got})"))
            continue
        values = [number_in(cells[pick], decimal, form.thousands) for pick in picks]
        table.append(values)
        if all(map(math.isfinite, values)):
            continue
        for value, pick, (unit, name) in zip(values, picks, (("s", "time"), ("N", "force")), strict=True):
            if not math.isfinite(value):
                got = f"got {text_of(cells[pick])}; {_remedy(cells[pick], decimal, index == text.first)}"
                faults.append(text.fault(index, name, f"must be a finite number of {unit} ({got})"))
    if faults:
        raise InvalidValueError(faults[:_MOST_FAULTS])
    return np.array(table)


def _remedy(cell: str, decimal: str, first: bool) -> str:
    """Advice for a cell that is not a finite number."""
    marks = [f"decimal: {mark!r}" for mark in DECIMALS if math.isfinite(number_in(cell, mark))]
    spaced = cell.translate(NARROW_SPACES)
    thousands = [mark for mark in THOUSANDS if mark in spaced and math.isfinite(number_in(cell, decimal, mark))]
    marks += [f"thousands: {mark!r} if it is a thousands mark" for mark in thousands]
    if marks:
        return f"set {' or '.join(marks)}"
    if any(math.isfinite(number_in(cell, other, mark)) for other in DECIMALS for mark in (None, *THOUSANDS)):
        return "set decimal and, if there are thousands marks, thousands"
    return "set skip_rows to skip it" if first else "correct or delete the row"


def _check_marks(text: _Text, rows: Iterable[int], picks: Sequence[int]) -> None:
    """Refuse numbers such as 1.234 or 1,234, unless another number shows that the mark is a decimal sign."""
    seen = None
    for index in rows:
        line = text.lines[index]
        if "." in line or "," in line:
            cells = _cells(line, text.separator)
            for cell in [cells[pick] for pick in picks if pick < len(cells)]:
                if not ("." in cell or "," in cell):
                    continue
                if not _GROUPED.fullmatch(cell):
                    return
                seen = seen or (index, cell, "," if "," in cell else ".")
    if seen is not None:
        index, cell, mark = seen
        rule = "must be given, because all numbers have three digits after their marks"
        text.refuse(index, "decimal", f"{rule} (got {cell!r}; set decimal: {mark!r} or thousands: {mark!r})")
