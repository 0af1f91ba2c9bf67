"""Force records in text files with a time and a force column, as oscilloscopes and data loggers write them."""

from __future__ import annotations

import math
import pathlib
import re
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import text_of
from shockwave.files import read_text
from shockwave.quadrature import FloatArray

# Largest file [bytes]: a larger one is not a force record, and reading it would exhaust the memory.
_MOST_BYTES = 128 * 2**20
# Longest line [characters], for the same reason.
_LONGEST_LINE = 10_000
# Errors that are reported for one file: more would not help to correct it.
_MOST_FAULTS = 20

_ROW_OF_NUMBERS = re.compile(r'(?i)["\s]*[+-]?(?:[.,]?[0-9]|(?:nan|inf|infinity)\b)')
# Only products and single-digit powers of words: parsing a longer expression could take unbounded time.
_FACTOR = r"[A-Za-zµμ]{1,20}(?:(?:\*\*|\^)-?[0-9])?"
_UNIT = re.compile(rf"{_FACTOR}(?: ?[*·/] ?{_FACTOR}){{0,4}}")
# Units that are recognised without brackets.
_BARE_UNITS = "s|ms|us|µs|μs|ns|N|mN|kN|MN|lbf|kgf"
# time [us], time (us), time/us, time_us, us or time
_LABEL = re.compile(rf"(.*?)\s*(?:\[([^\[]*)\]|\(([^(]*)\)|/([^\[(]*)|(?:^|[_ ])({_BARE_UNITS}))?")

_TIME_NAMES = frozenset({"time", "t", "zeit", "temps", "tempo", "tiempo"})
_FORCE_NAMES = frozenset({"force", "f", "load", "kraft", "forza", "fuerza"})
_SI_UNITS = (("s", "time", "seconds"), ("N", "force", "newtons"))

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
    """The lines of a file, the column separator, and the index of the first row of numbers."""

    path: pathlib.Path
    lines: list[str]
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
        hint = "; if the comma is the decimal separator, separate the columns by semicolons"
        return hint if self.separator == "," else ""


def read_record(path: pathlib.Path) -> Record:
    """Read a time column and a force column.

    Parameters
    ----------
    path : pathlib.Path
        UTF-8 text. Columns are separated by commas, semicolons, tabs or spaces; with semicolons or tabs the decimal
        sign can be a comma. A header line can name the columns and, in brackets or after a slash, their units. Blank
        lines and comments (``#``, ``%``, ``//``) are ignored.

    Returns
    -------
    Record
        Times [s] and forces [N], with notes that state the assumptions.

    Raises
    ------
    FileAccessError
        If the file is missing, not a regular file, not UTF-8, or larger than 128 MiB.
    InvalidValueError
        If the file does not have a time and a force column of finite numbers; each error states its line.
    """
    text = _text(pathlib.Path(path))
    notes: list[str] = []
    header, names, units = _header(text, notes)
    picks = _picks(text, names, notes)
    factors = _factors(text, header, [units[pick] for pick in picks], notes)
    rows = text.kept(text.first, len(text.lines))
    table = _numbers(text, rows, len(names), picks) * factors
    return Record(table[:, 0].copy(), table[:, 1].copy(), tuple(notes), np.array(rows) + 1)


def _text(path: pathlib.Path) -> _Text:
    """Read the file and find its first row of numbers and its column separator."""
    lines = read_text(path, _MOST_BYTES).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    first = next((index for index, line in enumerate(lines) if _ROW_OF_NUMBERS.match(line)), None)
    if first is None:
        problem = "must be numbers, with a time and a force in each row (got no row of numbers)"
        raise InvalidValueError([Fault("rows", problem, str(path))])
    separator = next((mark for mark in (";", "\t", ",") if mark in lines[first].strip()), "")
    text = _Text(path, lines, separator, first)
    long = next((index for index, line in enumerate(lines) if len(line) > _LONGEST_LINE), None)
    if long is not None:
        text.refuse(long, "row", f"must have at most {_LONGEST_LINE} characters (got {len(lines[long])})")
    return text


def _cells(line: str, separator: str) -> list[str]:
    """Cells of a line, without quotes and without the empty cell after a trailing separator."""
    cells = [cell.strip("\"' \t") for cell in line.strip().split(separator or None)]
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells


def _number(cell: str, decimal: str = ".") -> float:
    """The number in a cell; NaN if the cell is not a number."""
    if "_" in cell or (decimal == "," and "." in cell):
        return math.nan
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return math.nan


# ---------------------------------------------------------------- header


def _header(text: _Text, notes: list[str]) -> tuple[int, list[str], list[str]]:
    """Index of the header line, counted from 0, with names and units of the columns, empty if not given."""
    headers = text.kept(0, text.first)
    count = len(_cells(text.lines[text.first], text.separator))
    if len(headers) > 1:
        got = f"got {text_of(text.lines[headers[1]])}; put # before text"
        text.refuse(headers[1], "row", f"must be numbers: only one header line is allowed ({got})")
    if not headers:
        headers = _header_in_comment(text, count)
        notes += [f"The column names were read from the comment in line {index + 1}." for index in headers]
    if not headers:
        return text.first, [""] * count, [""] * count
    (index,) = headers
    cells = _labels(text, index)
    if any(math.isfinite(_number(cell)) for cell in cells):
        got = text_of(text.lines[index])
        text.refuse(index, "row", f"must be either column names or numbers, not both (got {got})")
    if len(cells) != count:
        got = f"got {len(cells)} names; line {text.first + 1} has {count}{text.comma_hint}"
        text.refuse(index, "header", f"must name every column ({got})")
    names, units = zip(*map(_name_and_unit, cells), strict=True)
    return index, list(names), list(units)


def _labels(text: _Text, index: int) -> list[str]:
    """Cells of a header line, whose separator can differ from that of the numbers."""
    line = text.lines[index].strip().lstrip("#%/;")
    mark = next((mark for mark in (text.separator, ";", "\t", ",") if mark and mark in line), "")
    if not mark:  # spaces separate the columns, but not a name from its unit
        line = re.sub(r"\s+(?=[\[(/])|(?<=/)\s+", "", line)
    return _cells(line, mark)


def _header_in_comment(text: _Text, count: int) -> list[int]:
    """The comment directly above the numbers if it names a time and a force column, as in files written by NumPy."""
    above = [index for index in range(text.first) if text.lines[index].strip()][-1:]
    names = [_name_and_unit(cell)[0] for index in above for cell in _labels(text, index)]
    found = len(_named(names, _TIME_NAMES)) == len(_named(names, _FORCE_NAMES)) == 1
    return above if found and len(names) == count else []


def _name_and_unit(cell: str) -> tuple[str, str]:
    name, *units = _LABEL.fullmatch(cell).groups("")  # type: ignore[union-attr]
    return name, "".join(units).strip()


def _named(names: Sequence[str], known: frozenset[str]) -> list[int]:
    """Indices of the columns whose name contains one of the ``known`` words."""
    return [i for i, name in enumerate(names) if known.intersection(re.findall(r"[^\W\d_]+", name.lower()))]


def _picks(text: _Text, names: Sequence[str], notes: list[str]) -> list[int]:
    """Columns of time and force: by their names, or in this order if there are only two."""
    times = _named(names, _TIME_NAMES)
    forces = _named(names, _FORCE_NAMES)
    plain = (times, forces) == ([0], [1])
    if len(names) == 2 and len(times + forces) < 2:
        times = times or [1 - force for force in forces] or [0]
        forces = [1 - times[0]]
    if not len(times) == len(forces) == 1 or times == forces:
        shown = ", ".join(map(text_of, names[:12])) if any(names) else "no header"
        hint = f"name these columns in a header, such as 'time [s]' and 'force [N]'{text.comma_hint}"
        problem = f"must include one time and one force column (got {len(names)} columns: {shown}; {hint})"
        text.refuse(text.first, "columns", problem)
    if any(names) and not plain:
        notes.append(f"The time column is {names[times[0]]!r}, the force column {names[forces[0]]!r}.")
    return times + forces


def _factors(text: _Text, header: int, units: Sequence[str], notes: list[str]) -> list[float]:
    """Factors that convert the two columns to SI units; errors in both are raised together."""
    factors = []
    faults = []
    for unit, (base, name, assumed) in zip(units, _SI_UNITS, strict=True):
        if not unit:
            hint = f"A header such as '{name} [{base}]' states the unit."
            notes.append(f"The {name} column has no unit: {assumed} are assumed. {hint}")
        factors.append(_factor(unit or base, base))
        if math.isnan(factors[-1]):
            problem = f"must be a unit of {name} (got {text_of(unit)}; for example, write [{base}])"
            faults.append(text.fault(header, f"unit of {name}", problem))
    if faults:
        raise InvalidValueError(faults)
    return factors


def _factor(unit: str, base: str) -> float:
    """SI value of ``unit``; NaN if it is not a unit of the dimension of ``base``."""
    if unit == base:
        return 1.0
    if len(unit) <= 40 and _UNIT.fullmatch(unit):
        import pint  # needed only for units other than s and N

        # A unit such as 'Seconds' or 'Sec' is recognised in lower case.
        for spelling in (unit, unit.lower()):
            with suppress(AttributeError, TypeError, ValueError):  # unknown unit, or wrong dimension
                return float(pint.Quantity(1.0, spelling).to(base).magnitude)
    return math.nan


# ---------------------------------------------------------------- body


def _numbers(text: _Text, rows: Sequence[int], count: int, picks: Sequence[int]) -> FloatArray:
    """Time and force columns of the lines ``rows``, shape (k, 2), finite."""
    # Plain numbers are read at once; anything else line by line, so that errors state their line.
    with suppress(ValueError):
        lines = [text.lines[index] for index in rows]
        plain = np.loadtxt(lines, comments=None, delimiter=text.separator or None, ndmin=2)
        if plain.shape[1] == count and np.isfinite(plain[:, picks]).all():
            return plain[:, picks]
    comma = text.separator in (";", "\t") and any("," in text.lines[index] for index in rows)
    decimal = "," if comma else "."
    remedy = "use the decimal comma as in the other rows" if comma else "correct or delete the row"
    table = []
    faults = []
    for index in rows:
        cells = _cells(text.lines[index], text.separator)
        if len(cells) != count:
            got = f"got {len(cells)}: {text_of(text.lines[index])}{text.comma_hint}"
            faults.append(text.fault(index, "row", f"must have {count} columns ({got})"))
            continue
        values = [_number(cells[pick], decimal) for pick in picks]
        table.append(values)
        if all(map(math.isfinite, values)):
            continue
        for value, pick, (unit, name, _) in zip(values, picks, _SI_UNITS, strict=True):
            if not math.isfinite(value):
                got = f"got {text_of(cells[pick])}; {remedy}"
                faults.append(text.fault(index, name, f"must be a finite number of {unit} ({got})"))
    if faults:
        raise InvalidValueError(faults[:_MOST_FAULTS])
    return np.array(table)
