"""Format of a record file: its layout, and the units and quantities of its columns."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from typing import Literal

import attrs
from attrs import frozen

from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import one_of, quantity
from shockwave.units import to_si

_ENCODINGS = (None, "utf-8", "utf-16", "cp1252")
# SI unit of each quantity that a column can have.
_UNITS = {"time": "s", "force": "N", "pressure": "Pa", "acceleration": "m/s**2", "voltage": "V"}
# Key that turns a record of the quantity into one of the force.
_KEYS = {"pressure": "area, the loaded area", "acceleration": "mass, the moving mass"}
# Units of pint that records write in other ways: g is a gram there.
_SPELLINGS = {"m/s2": "m/s^2", "g": "standard_gravity", "gn": "standard_gravity"}
# Shortest unit that may be written in capitals, such as Sec: of shorter ones mS and ms are different units.
_SHORTEST_WORD = 3

# Units that are recognised without brackets.
_BARE = r"[mun]?s|[µμ]s|[mkM]?N|lbf|kgf|[hkMG]?Pa|m?bar|psi|ksi|gn?|m/s(?:2|²|\^2|\*\*2)|[munµ]?V|pC"
# time [us], time (us), time/us, time_us or time us
_LABEL = re.compile(rf"(.+?) ?(?:\[(.*)\]|\((.*)\)|/ ?([^\W\d].*)|[_ ]({_BARE}))")
# A number, or a setting such as "range: 5 kN": no name of a column.
_VALUE = re.compile(
    rf"(?:.*[ :=])?[+-]?[0-9][0-9.,]*(?:e[+-]?[0-9]+)? ?(?:{_BARE})|[+-]?[0-9.,]+(?:e[+-]?[0-9]+)?", re.I
)
# Longest label of a column [characters]; longer text is none.
_LONGEST_LABEL = 100


@frozen(kw_only=True)
class RecordFormat:
    """What a record file does not state: its layout, units and quantity.

    Parameters
    ----------
    columns : list of int or str, optional
        Numbers, from 1, or names of the time column and the force column.
    skip_rows : int
        Number of lines at the beginning of the file to skip.
    encoding : "utf-8", "utf-16" or "cp1252", optional
        Encoding of the file; by default UTF-8, or UTF-16 if the file has its byte order mark.
    decimal : "." or ",", optional
        Decimal sign; by default the point.
    time_unit : str, optional
        Unit of the times, in place of that in the header.
    interval : float, optional
        Sampling interval [s], in place of the times of the file.
    unit : str, optional
        Unit of the forces, pressures or accelerations, in place of that in the header.
    sign : 1 or -1
        Factor of the values, -1 where compression is negative.
    scale : float, optional
        Factor of the values, such as the newtons per volt; ``unit`` is then that of the product.
    area : float, optional
        Loaded area [m^2], for a record of the pressure.
    mass : float, optional
        Moving mass [kg], for a record of the acceleration.

    Raises
    ------
    InvalidValueError
        If a value is out of range, or both ``area`` and ``mass`` are given.
    """

    columns: list[int | str] = attrs.field(default=None)
    skip_rows: int = quantity("", "lines at the beginning to skip", at_least=0, whole=True, default=0)
    encoding: Literal["utf-8", "utf-16", "cp1252"] | None = attrs.field(default=None, validator=one_of(*_ENCODINGS))
    decimal: Literal[".", ","] | None = attrs.field(default=None, validator=one_of(None, ".", ","))
    time_unit: str | None = None
    interval: float | None = quantity(
        "s", "sampling interval, in place of times", above=0, default=None, example="1 us"
    )
    unit: str | None = None
    sign: Literal[1, -1] = attrs.field(default=1, validator=one_of(1, -1))
    scale: float | None = quantity("", "factor of the values, such as newtons per volt", above=0, default=None)
    area: float | None = quantity("m**2", "loaded area, for a pressure", above=0, default=None, example="1 cm**2")
    mass: float | None = quantity("kg", "moving mass, for an acceleration", above=0, default=None, example="0.3 kg")

    def __attrs_post_init__(self) -> None:
        if self.area is not None and self.mass is not None:
            raise InvalidValueError.of("mass", "must be left out if area is given (got both; delete one)")

    @property
    def kind(self) -> str:
        """Quantity of the record, which is force, pressure or acceleration."""
        return "pressure" if self.area is not None else "acceleration" if self.mass is not None else "force"

    def plain(self, cell: str) -> str:
        """``cell`` as `float` and `Decimal` read it, so that another decimal sign is no number."""
        if self.decimal == ",":
            cell = cell.replace(".", "_.").replace(",", ".")
        return cell.replace("_", "__")  # float reads 1_0 as 10


# ---------------------------------------------------------------- units


@frozen
class Label:
    """Name and unit of a column, empty where the header states none, and their text there."""

    name: str = ""
    unit: str = ""
    text: str = ""


def labels_of(cells: Sequence[str]) -> list[Label]:
    """Labels in the cells of a header; none if the line is no header.

    A line of units alone, such as ``us,N``, is a header; a line with a value, such as ``range,5 kN``, is none.
    """
    cells = [" ".join(cell.split()) for cell in cells]
    if any(len(cell) > _LONGEST_LABEL or _VALUE.fullmatch(cell) for cell in cells):
        return []
    if all(map(measured, cells)):
        return [Label("", cell, cell) for cell in cells]
    parts = [(match.groups("") if (match := _LABEL.fullmatch(cell)) else (cell,), cell) for cell in cells]
    return [Label(name, "".join(units).strip(), cell) for (name, *units), cell in parts]


@cache
def measured(unit: str | None) -> str | None:
    """The quantity that is measured in a unit: time, force, pressure, acceleration or voltage; None if unknown."""
    return next((kind for kind, base in _UNITS.items() if not math.isnan(_factor(unit or "", base))), None)


def _factor(unit: str, base: str) -> float:
    """SI value of ``unit``; NaN if it is not a unit of the dimension of ``base``."""
    unit = _SPELLINGS.get(unit, str(unit))
    for spelling in (unit, unit.lower())[: 1 + (len(unit) >= _SHORTEST_WORD)] if unit else ():
        with suppress(ValueError):
            return to_si(f"1 {spelling}", base)
    return math.nan


def factors(
    form: RecordFormat, labels: Sequence[Label], extents: Sequence[float], place: str, notes: list[str]
) -> list[float]:
    """Seconds per unit of the time column and newtons per unit of the force column.

    Parameters
    ----------
    form : RecordFormat
        What the header does not state.
    labels : sequence of Label
        Labels of the two columns.
    extents : sequence of float
        Length of the record and greatest value in the units of the file, from which units are proposed.
    place : str
        Place of the header, for errors.
    notes : list of str
        Gains what was done.

    Raises
    ------
    InvalidValueError
        If a unit is not stated, with a proposal, or a column is a record of another quantity than the format states.
    """
    (time, force), faults = labels, []
    kind, base, unit, stated = form.kind, _UNITS[form.kind], form.unit or force.unit, measured(force.unit)
    per_time, per_force = _factor(form.time_unit or time.unit, "s"), _factor(unit, base)
    if form.interval is None and (math.isnan(per_time) or measured(time.unit) not in (None, "time")):
        # blows last about a millisecond
        sizes = {unit: abs(math.log(max(extents[0], 1e-99) * _factor(unit, "ms"))) for unit in ("s", "ms", "us", "ns")}
        likely = min(sizes, key=sizes.__getitem__)
        hint = f"time_unit: {likely} makes the record {extents[0]:.4g} {likely} long; columns states the order"
        got = " and ".join(map(repr, filter(None, (time.text, form.time_unit)))) or "none"
        faults.append(Fault("time_unit", f"must be a unit of time (got {got}; {hint})", place))
    other = next((each for each in (stated, measured(form.unit)) if each in (*_KEYS, "force") and each != kind), None)
    hint = f"unit: {base} makes the greatest value {extents[1]:.4g} {base}"
    if other is not None:
        per_force, hint = math.nan, f"set {_KEYS[other]}" if kind == "force" else f"delete {_KEYS[kind]}"
    elif force.unit and stated != kind and (form.unit is None or form.scale is None):
        per_force, hint = math.nan, f"set unit: {form.unit or base}, and scale to the {base} per {force.unit}"
    if math.isnan(per_force):
        got = " and ".join(map(repr, filter(None, (force.text, form.unit)))) or "none"
        faults.append(Fault("unit", f"must be a unit of {kind} (got {got}; {hint})", place))
    if faults:
        raise InvalidValueError(faults)
    if stated == "voltage":
        per_force *= _factor(force.unit, "V")
        notes.append(f"The file states values in {force.unit}; scale is per volt.")
    elif force.unit not in ("", unit):
        notes.append(f"The file states the unit {force.unit!r}; {unit!r} was used.")
    for key in ("area", "mass", "scale", "sign"):
        if (value := getattr(form, key)) not in (None, 1):
            per_force *= value
            notes.append(f"The values were multiplied by the {key}, {value:.6g}.")
    return [per_time, per_force]
