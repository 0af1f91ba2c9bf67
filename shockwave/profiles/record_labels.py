"""Labels of columns in headers and comments: names, units and values."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from shockwave.profiles.record_format import BARE_UNITS, FORCE_NAMES, TIME_NAMES, is_unit, measured

# time [us], time (us), time_us, time/us, us or time
_LABEL = re.compile(rf"(.*?)\s*(?:\[([^\[]*)\]|\(([^(]*)\)|(?:^|[_ ])({BARE_UNITS})|/([^\[(]*))?")
# The name in a cell such as "range 5 kN" or "gain 2.3 mV/N", which states a value.
_VALUE = re.compile(rf"(?:.*\W)?[0-9][0-9.,]*(?:e[+-]?[0-9]+)?\s*(?:{BARE_UNITS})?")
# Words that name a column of any quantity but time.
_QUANTITIES = frozenset[str]().union(*FORCE_NAMES.values())

#: Characters that some programs write for a blank.
NARROW_SPACES = str.maketrans("\xa0\u202f", "  ")


def number_in(cell: str, decimal: str = ".", thousands: str | None = None) -> float:
    """The number in a cell; NaN if the cell is not a number."""
    if thousands:
        cell = cell.translate(NARROW_SPACES)
        mark = re.escape(thousands)
        if re.match(rf"[+-]?[1-9][0-9]{{0,2}}(?:{mark}[0-9]{{3}})+(?![0-9{mark}])", cell):
            cell = cell.replace(thousands, "")
    if "_" in cell or (decimal == "," and "." in cell):
        return math.nan
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return math.nan


def names_columns(cells: Sequence[str], count: int, directly_above: bool) -> bool:
    """Whether the cells of a comment are names or units of a time, another quantity and all other columns."""
    if len(cells) != count or not all(cells) or any(map(_is_value, cells)):
        return False
    names, units = zip(*map(name_and_unit, cells), strict=True)
    kinds = [measured(unit) for unit in units]
    times = {*columns_named(names, TIME_NAMES), *(i for i, kind in enumerate(kinds) if kind == "time")}
    others = {*columns_named(names, _QUANTITIES), *(i for i, kind in enumerate(kinds) if kind not in (None, "time"))}
    return bool(times and others and len(times | others) > 1 and (any(units) or directly_above))


def states_units(cells: Sequence[str], title: str, count: int) -> bool:
    """Whether a comment states units other than seconds and newtons, or names the columns but the first."""
    if any(math.isfinite(number_in(cell)) for cell in cells):
        return False
    found = [cell for cell in cells if measured(_split(cell)[1]) and not _is_value(cell)]
    sure = [
        cell
        for cell in found
        if cell.endswith(("]", ")")) or columns_named([_split(cell)[0]], _QUANTITIES | TIME_NAMES)
    ]
    name, unit = _split(title)
    if not _is_value(title) and measured(unit) and (not name or columns_named([name], _QUANTITIES | TIME_NAMES)):
        sure.append(title)
    if len(cells) == count and not cells[0] and sure:
        return True
    return any(_split(cell)[1] not in ("s", "N") for cell in sure or found[: len(found) * (len(found) > 1)])


def _is_value(cell: str) -> bool:
    """Whether a cell is a number, or one with a unit that is not in brackets."""
    name, unit = _split(cell)
    return math.isfinite(number_in(cell)) or bool(unit and cell[-1] not in "])" and _VALUE.fullmatch(name))


def _split(cell: str) -> tuple[str, str]:
    # the time of the search grows with the square of the number of blanks
    name, *units = _LABEL.fullmatch(" ".join(cell.split())).groups("")  # type: ignore[union-attr]
    return name, "".join(units).strip()


def name_and_unit(cell: str) -> tuple[str, str]:
    name, unit = _split(cell)
    return ("", name) if not unit and is_unit(name) else (name, unit)  # a label may be a unit alone, such as Volt


def columns_named(names: Sequence[str], known: frozenset[str]) -> list[int]:
    """Indices of the columns whose name contains one of the ``known`` words."""
    return [i for i, name in enumerate(names) if known.intersection(re.findall(r"[^\W\d_]+", name.lower()))]
