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
    notes: tuple[str, ...]
    lines: npt.NDArray[np.int64] = attrs.field(eq=_same, repr=False)


@frozen
class _Text:
    """The lines of a file, the separator of its columns, and where its numbers begin."""

    path: pathlib.Path
    lines: list[str]
    separator: str
    first: int

    def kept(self, start: int, stop: int) -> list[int]:
        """Indices of the lines in ``[start, stop)`` that are neither blank nor a comment."""
        # A semicolon begins a comment only where it does not separate columns.
        marks = ("#", "%", "//") if self.separator == ";" else ("#", "%", "//", ";")
        rows = enumerate(map(str.strip, self.lines[start:stop]), start)
        return [index for index, row in rows if row and not row.startswith(marks)]

    def fault(self, index: int, name: str, problem: str) -> Fault:
        """A fault of the line ``index``, counted from 0."""
        return Fault(name, problem, location=f"{self.path}:{index + 1}")

    def refuse(self, index: int, name: str, problem: str) -> NoReturn:
        """Raise the one fault of the line ``index``, counted from 0."""
        raise InvalidValueError([self.fault(index, name, problem)])

    @property
    def comma_hint(self) -> str:
        """What may be wrong with the number of columns."""
        hint = "; if the comma is the decimal sign, separate the columns by semicolons"
        return hint if self.separator == "," else ""


@frozen
class _Column:
    """The name and unit of a column, and the line on which the unit stands, counted from 0."""

    name: str
    unit: str
    line: int


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
    text = _text(path)
    kept = text.kept(text.first, len(text.lines))
    notes: list[str] = []
    columns = _columns(text, notes)
    picks = _picks(text, columns, notes)
    factors = _factors(text, [columns[pick] for pick in picks], notes)
    table = _numbers(text, len(columns), picks, factors, kept)
    return Record(table[:, 0].copy(), table[:, 1].copy(), tuple(notes), np.array(kept) + 1)


def _text(path: pathlib.Path) -> _Text:
    """Find the first row of numbers, and in it the separator."""
    lines = read_text(path, _MOST_BYTES).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if len(lines) > _MOST_LINES:
        raise FileAccessError(f"{path}: has more than {_MOST_LINES} lines (keep only the pulse)")
    first = next((index for index, line in enumerate(lines) if _ROW_OF_NUMBERS.match(line)), None)
    if first is None:
        problem = "must be numbers, a time and a force in each (got no row of numbers)"
        raise InvalidValueError([Fault("rows", problem, str(path))])
    separator = next((mark for mark in (";", "\t", ",") if mark in lines[first].strip()), "")
    text = _Text(path, lines, separator, first)
    long = next((index for index, line in enumerate(lines) if len(line) > _LONGEST_LINE), None)
    if long is not None:
        text.refuse(long, "row", f"must have at most {_LONGEST_LINE} characters (got {len(lines[long])})")
    return text


# ---------------------------------------------------------------- header


def _columns(text: _Text, notes: list[str]) -> list[_Column]:
    """The columns, as the header names them."""
    headers = text.kept(0, text.first)
    row = _cells(text.lines[text.first], text.separator)
    trimmed = len(row) - (row[-1] == "")
    if len(headers) > 2:
        got = f"got {text_of(text.lines[headers[2]])}; put # before text"
        text.refuse(headers[2], "row", f"must be numbers, after at most two header lines ({got})")
    if not headers:
        headers = _header_in_comment(text, trimmed)
        notes += [f"the header was read from the comment in line {index + 1}" for index in headers]
    labels = [_labels(text, index) for index in headers]
    count = len(row) if labels and len(labels[0]) == len(row) else trimmed
    for index, cells in zip(headers, labels, strict=True):
        if any(_NUMBER.fullmatch(cell.replace(",", ".")) for cell in cells):
            got = text_of(text.lines[index])
            text.refuse(index, "row", f"must be names of columns, or numbers alone (got {got})")
        if len(cells) != count:
            got = f"got {len(cells)} names; line {text.first + 1} has {count}{text.comma_hint}"
            text.refuse(index, "header", f"must name every column ({got})")
    if not labels:
        return [_Column("", "", text.first)] * count
    columns = [_Column(*_name_and_unit(cell), headers[0]) for cell in labels[0]]
    if len(labels) == 1 and all(cell in _BARE_UNITS for cell in labels[0]):
        return [_Column("", cell, headers[0]) for cell in labels[0]]
    if len(labels) == 2:  # the second line holds the units
        units = [cell.strip("[]()").strip() for cell in labels[1]]
        pairs = zip(columns, units, strict=True)
        return [column if column.unit else _Column(column.name, unit, headers[1]) for column, unit in pairs]
    return columns


def _cells(line: str, separator: str) -> list[str]:
    """The cells of a line, without quotes; an empty one that a separator at the end leaves is kept."""
    cells = line.strip().split(separator) if separator else line.split()
    return [cell.strip().strip("\"'").strip() for cell in cells]


def _labels(text: _Text, index: int) -> list[str]:
    """The cells of a header line, which may use another separator than the numbers do."""
    line = text.lines[index].strip().lstrip("#%/;")
    mark = next((mark for mark in (text.separator, ";", "\t", ",") if mark and mark in line), "")
    if not mark:  # blanks separate the columns, but not a name from its unit
        line = " ".join(line.split()).replace(" [", "[").replace(" (", "(").replace(" / ", "/")
    cells = _cells(line, mark)
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells


def _header_in_comment(text: _Text, count: int) -> list[int]:
    """The comment right above the numbers, where it names a time and a force: NumPy writes such headers."""
    above = [index for index in range(text.first) if text.lines[index].strip()][-1:]
    names = [_name_and_unit(cell)[0] for index in above for cell in _labels(text, index)]
    found = len(_named(names, _TIME_NAMES)) == len(_named(names, _FORCE_NAMES)) == 1
    return above if found and len(names) == count else []


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


def _picks(text: _Text, columns: Sequence[_Column], notes: list[str]) -> tuple[int, int]:
    """The columns of time and force: by their names, or in this order where there are but two."""
    names = [column.name for column in columns]
    times, forces = _named(names, _TIME_NAMES), _named(names, _FORCE_NAMES)
    if len(names) == 2 and len(times) <= 1 and len(forces) <= 1 and (times != forces or not times):
        first = times[0] if times else 1 - forces[0] if forces else 0
        times, forces = [first], [1 - first]
        if not _named(names, _TIME_NAMES | _FORCE_NAMES) and any(names):
            notes.append(f"the columns {names[0]!r} and {names[1]!r} were taken as time and force")
    if not len(times) == len(forces) == 1 or times == forces:
        shown = ", ".join(map(text_of, names[:12])) if any(names) else "no header"
        hint = f"write a header such as 'time [s]' and 'force [N]' over those two{text.comma_hint}"
        problem = f"must be one column of time and one of force (got {len(names)}: {shown}; {hint})"
        text.refuse(text.first, "columns", problem)
    picks = times[0], forces[0]
    if picks != (0, 1):
        which = f"column {picks[0] + 1}, {names[picks[0]]!r}, and column {picks[1] + 1}, {names[picks[1]]!r}"
        notes.append(f"time and force were found by their names: {which}")
    elif len(names) > 2:
        notes.append(f"of {len(names)} columns only {names[0]!r} and {names[1]!r} were read")
    return picks


def _factors(text: _Text, columns: Sequence[_Column], notes: list[str]) -> tuple[float, ...]:
    """What turns the two columns into SI; faults of both are raised together."""
    factors, faults = [], []
    for column, (base, name, assumed) in zip(columns, _SI_UNITS, strict=True):
        factor = 1.0 if column.unit in ("", base) else _factor(column.unit, base)
        factors.append(factor)
        if not column.unit:
            notes.append(f"the {name} has no unit: {assumed} are assumed")
        if factor is None:
            problem = f"must be a unit of {name} (got {text_of(column.unit)}; write [{base}], for example)"
            faults.append(text.fault(column.line, f"unit of {name}", problem))
    if faults:
        raise InvalidValueError(faults)
    return tuple(factors)


def _factor(unit: str, base: str) -> Any:
    """The size of ``unit`` in SI; None when it is no unit of that dimension."""
    if len(unit) <= 40 and _UNIT.fullmatch(unit):
        # A unit that is not known as written may be known without its capitals: 'Seconds', 'Sec'.
        for spelling in (unit, unit.lower()):
            with suppress(AttributeError, TypeError, ValueError):  # unknown, wrong dimension, no unit at all
                return float(_units().Quantity(1.0, spelling).to(base).magnitude)
    return None


@cache
def _units() -> Any:
    import pint  # only a header with other units than s and N needs it

    return pint.UnitRegistry()


# ---------------------------------------------------------------- body


def _numbers(
    text: _Text, count: int, picks: Sequence[int], factors: Sequence[float], kept: Sequence[int]
) -> FloatArray:
    """The time and the force column of the lines ``kept``, shape (k, 2), in SI units, finite."""
    rows = [text.lines[index].strip().replace('"', "") for index in kept]
    if text.separator in (";", "\t"):
        rows = _with_points(text, kept, rows)
    if text.separator:
        rows = [row.removesuffix(text.separator) if row.count(text.separator) == count else row for row in rows]
    with suppress(ValueError):  # whose message lacks line and column
        table = np.loadtxt(rows, delimiter=text.separator or None, comments=None, ndmin=2)
        if table.shape == (len(rows), count):
            with np.errstate(over="ignore"):
                table = table[:, list(picks)] * factors
            if np.isfinite(table).all():
                return table
    return _numbers_one_by_one(text, count, picks, factors, kept, rows)


def _with_points(text: _Text, kept: Sequence[int], rows: Sequence[str]) -> list[str]:
    """The rows with points for decimal commas; a file with both is refused at the later one."""
    comma, point = (next((at for at, row in enumerate(rows) if mark in row), None) for mark in ",.")
    if comma is not None and point is not None:
        early, late = sorted((kept[comma], kept[point]))
        got = f"got {text_of(text.lines[late])} after {text_of(text.lines[early])}"
        hint = "use the point or the comma alone, and no thousands sign"
        text.refuse(late, "row", f"must have one decimal sign ({got}; {hint})")
    return [row.replace(",", ".") for row in rows]


def _numbers_one_by_one(
    text: _Text, count: int, picks: Sequence[int], factors: Sequence[float], kept: Sequence[int], rows: Sequence[str]
) -> FloatArray:
    """The two columns, cell by cell: finds the faults, and copes with words in other columns."""
    table: list[list[float]] = []
    faults: list[Fault] = []
    for index, row in zip(kept, rows, strict=True):
        cells = _cells(row, text.separator)
        if len(cells) != count:
            got = f"got {len(cells)}: {text_of(text.lines[index])}{text.comma_hint}"
            faults.append(text.fault(index, "row", f"must have {count} columns ({got})"))
            continue
        chosen = [cells[pick] for pick in picks]
        table.append([float(cell) if _NUMBER.fullmatch(cell) else math.nan for cell in chosen])
        for value, factor, cell, (unit, name, _) in zip(table[-1], factors, chosen, _SI_UNITS, strict=True):
            if not math.isfinite(value * factor):
                problem = f"must be a finite number of {unit} (got {text_of(cell)}; mend or delete the row)"
                faults.append(text.fault(index, name, problem))
        if len(faults) >= _MOST_FAULTS:
            break
    if faults:
        raise InvalidValueError(faults[:_MOST_FAULTS])
    return np.array(table) * factors
