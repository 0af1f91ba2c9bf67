"""Force records as an oscilloscope or a load cell writes them: text with a time and a force column."""

from __future__ import annotations

import math
import pathlib
import re
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from typing import Any, NoReturn

import attrs
import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import Fault, FileAccessError, InvalidValueError
from shockwave.fields import text_of
from shockwave.files import read_text
from shockwave.quadrature import FloatArray

__all__ = ["Record", "read_record"]

# Beyond these a file is no force record, and reading it would only exhaust memory.
_MOST_BYTES = 128 * 2**20
_MOST_LINES = 5_000_000
_LONGEST_LINE = 10_000
_MOST_FAULTS = 20

_NUMBER = re.compile(r"(?i)[+-]?(?:(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:e[+-]?[0-9]+)?)")
_ROW_OF_NUMBERS = re.compile(r'(?i)["\s]*[+-]?(?:[.,]?[0-9]|(?:nan|inf|infinity)\b)')
# Products and single-digit powers of words only: a longer expression could keep a parser busy for ever.
_FACTOR = r"[A-Za-zµμ]{1,20}(?:(?:\*\*|\^)-?[0-9])?"
_UNIT = re.compile(rf"{_FACTOR}(?: ?[*·/] ?{_FACTOR}){{0,4}}")

_TIME_NAMES = frozenset({"time", "t", "zeit", "temps", "tempo", "tiempo"})
_FORCE_NAMES = frozenset({"force", "f", "load", "kraft", "forza", "fuerza"})
# Units that are known as such even without brackets around them.
_BARE_UNITS = frozenset({"s", "ms", "us", "µs", "μs", "ns", "N", "mN", "kN", "MN", "lbf", "kgf"})
_SI_UNITS = (("s", "time", "seconds"), ("N", "force", "newtons"))

_same = attrs.cmp_using(eq=np.array_equal)


@frozen
class Record:
    """A force record in SI units.

    Attributes
    ----------
    times : array of float, shape (k,)
        Sample times [s], finite, in the order of the file.
    forces : array of float, shape (k,)
        Forces [N], finite.
    notes : tuple of str
        What was assumed about the file, in sentences.
    lines : array of int, shape (k,)
        Line of the file, counted from 1, on which each sample stands.
    """

    times: FloatArray = attrs.field(eq=_same)
    forces: FloatArray = attrs.field(eq=_same)
    notes: tuple[str, ...] = ()
    lines: npt.NDArray[np.int64] = attrs.field(
        eq=_same, factory=lambda: np.empty(0, dtype=np.int64), repr=False, kw_only=True
    )


@frozen
class _Text:
    """The lines of a file, the separator of its columns, and where its numbers begin."""

    path: pathlib.Path
    lines: list[str]
    separator: str
    first: int

    def cells(self, line: str, separator: str | None = None) -> list[str]:
        """The cells of a line, without quotes; an empty one that a separator at the end leaves is kept."""
        separator = self.separator if separator is None else separator
        cells = line.strip().split(separator) if separator else line.split()
        return [cell.strip().strip("\"'").strip() for cell in cells]

    def kept(self, start: int, stop: int) -> list[int]:
        """Indices of the lines in ``[start, stop)`` that are neither blank nor a comment."""
        # A semicolon begins a comment only where it does not separate columns.
        marks = ("#", "%", "//") if self.separator == ";" else ("#", "%", "//", ";")
        lines = enumerate(self.lines[start:stop], start)
        kept = [index for index, line in lines if (row := line.strip()) and not row.startswith(marks)]
        # The patterns and splits below are meant for lines of a sane length.
        for index in kept:
            if len(self.lines[index]) > _LONGEST_LINE:
                problem = f"must have at most {_LONGEST_LINE} characters (got {len(self.lines[index])})"
                self.refuse(index, "row", problem)
        return kept

    def fault(self, index: int, name: str, problem: str) -> Fault:
        """A fault of the line ``index``, counted from 0."""
        return Fault(name, problem, location=f"{self.path}:{index + 1}")

    def refuse(self, index: int, name: str, problem: str) -> NoReturn:
        """Raise the one fault of the line ``index``, counted from 0."""
        raise InvalidValueError([self.fault(index, name, problem)])


@frozen
class _Columns:
    """What the header says: how many columns, which two hold time and force, and their SI factors."""

    count: int
    picks: tuple[int, int]
    factors: tuple[float, float]
    notes: tuple[str, ...]


def read_record(path: pathlib.Path) -> Record:
    """Read a time column and a force column.

    Parameters
    ----------
    path : pathlib.Path
        UTF-8 text. Columns are separated by commas, semicolons, tabs or blanks; with semicolons or tabs a
        decimal comma is understood. A header line may name the columns and, in brackets, after a slash or
        in a line of its own, their units. Blank lines and comments (``#``, ``%``, ``//``, ``;``) may stand
        anywhere.

    Returns
    -------
    Record
        Times [s] and forces [N], with notes on what was assumed.

    Raises
    ------
    FileAccessError
        When the file is missing, no regular file, not UTF-8, or larger than 128 MiB or 5 000 000 lines.
    InvalidValueError
        When it holds no two columns of finite numbers in units of time and force; each fault names its line.
    """
    path = pathlib.Path(path)
    lines = _lines(path)
    text = _text(path, lines)
    kept = text.kept(text.first, len(lines))
    columns = _columns(text)
    table = _numbers(text, columns, kept)
    return Record(table[:, 0].copy(), table[:, 1].copy(), columns.notes, lines=np.array(kept) + 1)


def _lines(path: pathlib.Path) -> list[str]:
    text = read_text(path, _MOST_BYTES)
    lines = text.replace("\r\n", "\n").replace("\r", "\n")
    if lines.count("\n") > _MOST_LINES:
        raise FileAccessError(f"{path}: has more than {_MOST_LINES} lines (keep only the pulse)")
    return lines.split("\n")


def _text(path: pathlib.Path, lines: list[str]) -> _Text:
    """Find the first row of numbers, and in it the separator."""
    first = next((index for index, line in enumerate(lines) if _ROW_OF_NUMBERS.match(line)), None)
    if first is None:
        raise InvalidValueError(
            [Fault("rows", "must be numbers, a time and a force in each (got no row of numbers)", str(path))]
        )
    row = lines[first].strip()
    separator = next((mark for mark in (";", "\t", ",") if mark in row), "")
    return _Text(path, lines, separator, first)


# ---------------------------------------------------------------- header


def _columns(text: _Text) -> _Columns:
    """Which columns hold time and force, and what turns them into SI."""
    headers = text.kept(0, text.first)
    if len(headers) > 2:
        problem = "must be numbers, after at most two header lines (got {}; put # before text)"
        text.refuse(headers[2], "row", problem.format(text_of(text.lines[headers[2]])))
    row = text.cells(text.lines[text.first])
    trimmed = len(row) - (row[-1] == "")
    notes: list[str] = []
    if not headers and (index := _header_in_comment(text, trimmed)) is not None:
        headers = [index]
        notes.append(f"the header was read from the comment in line {index + 1}")
    labels = [_labels(text, index) for index in headers]
    count = len(row) if labels and len(labels[0]) == len(row) else trimmed
    for index, cells in zip(headers, labels, strict=True):
        _check_header(text, index, cells, count)
    names = [_name_and_unit(cell) for cell in labels[0]] if labels else [("", "")] * count
    lines = [headers[0] if headers else text.first] * count
    if len(labels) == 1 and all(cell in _BARE_UNITS for cell in labels[0]):
        names = [("", cell) for cell in labels[0]]
    if len(labels) == 2:  # the second line holds the units
        for column, cell in enumerate(labels[1]):
            if not names[column][1]:
                names[column] = (names[column][0], cell.strip("[]()").strip())
                lines[column] = headers[1]
    picks = _picks(text, [name for name, _ in names], notes)
    factors = _factors(text, [names[pick][1] for pick in picks], [lines[pick] for pick in picks], notes)
    return _Columns(count, picks, factors, tuple(notes))


def _check_header(text: _Text, index: int, cells: list[str], count: int) -> None:
    for cell in cells:
        if _NUMBER.fullmatch(cell.replace(",", ".")):
            problem = f"must be names of columns, or numbers alone (got {text_of(text.lines[index])})"
            text.refuse(index, "row", problem)
    if len(cells) != count:
        hint = f"line {text.first + 1} has {count}{_comma_hint(text)}"
        text.refuse(index, "header", f"must name every column (got {len(cells)} names; {hint})")


def _labels(text: _Text, index: int) -> list[str]:
    """The cells of a header line, which may use another separator than the numbers do."""
    line = text.lines[index].strip().lstrip("#%/;")
    mark = next((mark for mark in (text.separator, ";", "\t", ",") if mark and mark in line), "")
    if not mark:  # blanks separate the columns, but not a name from its unit
        line = " ".join(line.split()).replace(" [", "[").replace(" (", "(").replace(" / ", "/")
    cells = text.cells(line, mark)
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells


def _header_in_comment(text: _Text, count: int) -> int | None:
    """The comment right above the numbers, where it names a time and a force: NumPy writes such headers."""
    above = next((index for index in range(text.first - 1, -1, -1) if text.lines[index].strip()), None)
    if above is None or len(text.lines[above]) > _LONGEST_LINE:
        return None
    names = [_name_and_unit(cell)[0] for cell in _labels(text, above)]
    times, forces = (_named(names, known) for known in (_TIME_NAMES, _FORCE_NAMES))
    return above if len(names) == count and len(times) == len(forces) == 1 else None


def _name_and_unit(cell: str) -> tuple[str, str]:
    """Name and unit of ``time [us]``, ``time (us)``, ``time/us``, ``time_us`` or ``time``."""
    for opening, closing in ("[]", "()"):
        if cell.endswith(closing) and opening in cell:
            name, _, unit = cell[:-1].rpartition(opening)
            return name.strip(), unit.strip()
    name, slash, unit = cell.partition("/")
    if slash:
        return name.strip(), unit.strip()
    name, _, unit = cell.replace("_", " ").rpartition(" ")
    return (name, unit) if name and unit in _BARE_UNITS else (cell, "")


def _named(names: Sequence[str], known: frozenset[str]) -> list[int]:
    """Columns in whose name one of the known words occurs."""
    return [i for i, name in enumerate(names) if known.intersection(re.findall(r"[^\W\d_]+", name.lower()))]


def _picks(text: _Text, names: list[str], notes: list[str]) -> tuple[int, int]:
    """The columns of time and force: by their names, or in this order where there are but two."""
    times, forces = (_named(names, known) for known in (_TIME_NAMES, _FORCE_NAMES))
    if len(names) == 2 and len(times) <= 1 and len(forces) <= 1 and times != forces:
        time = times[0] if times else 1 - forces[0]
        picks = (time, 1 - time)
    elif len(names) == 2 and not times and not forces:
        picks = (0, 1)
        if any(names):
            notes.append(f"the columns {names[0]!r} and {names[1]!r} were taken as time and force")
    elif len(times) == len(forces) == 1 and times != forces:
        picks = (times[0], forces[0])
    else:
        shown = ", ".join(text_of(name) for name in names[:12]) if any(names) else "no header"
        problem = f"must be one column of time and one of force (got {len(names)}: {shown}; "
        hint = f"write a header such as 'time [s]' and 'force [N]' over those two{_comma_hint(text)})"
        text.refuse(text.first, "columns", problem + hint)
    if picks != (0, 1):
        which = f"column {picks[0] + 1}, {names[picks[0]]!r}, and column {picks[1] + 1}, {names[picks[1]]!r}"
        notes.append(f"time and force were found by their names: {which}")
    elif len(names) > 2:
        notes.append(f"of {len(names)} columns only {names[0]!r} and {names[1]!r} were read")
    return picks


def _comma_hint(text: _Text) -> str:
    decimal = "; if the comma is the decimal sign, separate the columns by semicolons"
    return decimal if text.separator == "," else ""


def _factors(text: _Text, units: list[str], lines: list[int], notes: list[str]) -> tuple[float, float]:
    """What turns the two columns into SI; faults of both are raised together."""
    factors, faults = [1.0, 1.0], []
    for i, (unit, line, (base, name, assumed)) in enumerate(zip(units, lines, _SI_UNITS, strict=True)):
        if not unit:
            notes.append(f"the {name} has no unit: {assumed} are assumed")
        elif unit != base:
            try:
                factors[i] = _factor(unit, base)
            except ValueError:
                problem = f"must be a unit of {name} (got {text_of(unit)}; write [{base}], for example)"
                faults.append(text.fault(line, f"unit of {name}", problem))
    if faults:
        raise InvalidValueError(faults)
    return factors[0], factors[1]


def _factor(unit: str, base: str) -> float:
    """The size of ``unit`` in SI; ValueError when it is no unit of that dimension."""
    if len(unit) > 40 or not _UNIT.fullmatch(unit):
        raise ValueError(unit)
    # A unit that is not known as written may be known without its capitals: 'Seconds', 'Sec'.
    for spelling in (unit, unit.lower()):
        with suppress(AttributeError, TypeError, ValueError):  # unknown, wrong dimension, no unit at all
            return float(_units().Quantity(1.0, spelling).to(base).magnitude)
    raise ValueError(unit)


@cache
def _units() -> Any:
    import pint  # only a header with other units than s and N needs it

    return pint.UnitRegistry()


# ---------------------------------------------------------------- body


def _numbers(text: _Text, columns: _Columns, kept: list[int]) -> FloatArray:
    """The time and the force column of the lines ``kept``, shape (k, 2), in SI units, finite."""
    rows = [text.lines[index].strip() for index in kept]
    body = "\n".join(rows).replace('"', "")
    if text.separator in (";", "\t") and "," in body:
        if "." in body:
            _refuse_two_decimal_signs(text, kept, rows)
        body = body.replace(",", ".")
    if text.separator and len(text.cells(rows[0])) > columns.count:  # every row ends with a separator
        body = f"{body}\n".replace(f"{text.separator}\n", "\n").removesuffix("\n")
    plain = body.split("\n")
    with suppress(ValueError):  # which does not tell enough of the fault
        table = np.loadtxt(plain, delimiter=text.separator or None, comments=None, ndmin=2)
        if table.shape == (len(rows), columns.count):
            with np.errstate(over="ignore"):
                table = table[:, list(columns.picks)] * columns.factors
            if np.isfinite(table).all():
                return table
    return _numbers_one_by_one(text, columns, kept, plain)


def _refuse_two_decimal_signs(text: _Text, kept: list[int], rows: list[str]) -> NoReturn:
    comma = next(row for row, line in enumerate(rows) if "," in line)
    point = next(row for row, line in enumerate(rows) if "." in line)
    early, late = kept[min(comma, point)], kept[max(comma, point)]
    got = f"got {text_of(text.lines[late])} after {text_of(text.lines[early])}"
    hint = "use the point or the comma alone, and no thousands sign"
    text.refuse(late, "row", f"must have one decimal sign ({got}; {hint})")


def _numbers_one_by_one(text: _Text, columns: _Columns, kept: list[int], rows: list[str]) -> FloatArray:
    """The two columns, cell by cell: finds the faults, and copes with words in other columns."""
    table: list[list[float]] = []
    faults: list[Fault] = []
    for index, row in zip(kept, rows, strict=True):
        cells = text.cells(row)
        if len(cells) == columns.count + 1 and not cells[-1]:
            cells.pop()
        if len(cells) != columns.count:
            got = f"got {len(cells)}: {text_of(text.lines[index])}{_comma_hint(text)}"
            faults.append(text.fault(index, "row", f"must have {columns.count} columns ({got})"))
        else:
            pair = []
            for pick, factor, (unit, name, _) in zip(columns.picks, columns.factors, _SI_UNITS, strict=True):
                cell = cells[pick]
                pair.append(float(cell) * factor if _NUMBER.fullmatch(cell) else math.nan)
                if not math.isfinite(pair[-1]):
                    problem = f"must be a finite number of {unit} (got {text_of(cell)}; mend or delete the row)"
                    faults.append(text.fault(index, name, problem))
            table.append(pair)
        if len(faults) >= _MOST_FAULTS:
            break
    if faults:
        raise InvalidValueError(faults[:_MOST_FAULTS])
    return np.array(table)
