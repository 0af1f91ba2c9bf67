"""Format of a record file: its layout, and the units and quantities of its columns."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from typing import Literal

import attrs
import numpy as np
from attrs import frozen

from shockwave.base.errors import Fault, InvalidValueError, refuse
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import one_of, quantity
from shockwave.base.units import in_other_case, to_si

_ENCODINGS = (None, "utf-8", "utf-16", "cp1252")
# SI unit of each quantity that a column can have.
_UNITS = {"time": "s", "force": "N", "pressure": "Pa", "acceleration": "m/s**2", "voltage": "V"}
# The same of quantities that only a record of a motion has.
_OF_MOTION = {"velocity": "m/s", "displacement": "m"}
# Key that turns a record of the quantity into one of the force.
_KEYS = {"pressure": "area, the loaded area", "acceleration": "mass, the moving mass"}

# Units that are recognised without brackets.
_BARE = r"[mun]?s|[µμ]s|[mkM]?N|lbf|kgf|[hkMG]?Pa|m?bar|psi|ksi|gn?|m/s(?:2|²|\^2|\*\*2)|[munµ]?V|pC"
# time [us] or time (us); 10 mV/N and N, filtered are no units
_BRACKETS = re.compile(r"\[([^]\d,;:][^],;:]*)\]|\(([^)\d,;:][^),;:]*)\)")
# time/us, time_us or time us
_SUFFIX = re.compile(rf"^[^[(]+?(?:/ ?([^\W\d][^[(]*)|[_ ]({_BARE}))$")
# A number, or a setting such as "range: 5 kN": no name of a column.
_VALUE = re.compile(
    rf"(?:.*[ :=])?[+-]?[0-9][0-9.,]*(?:e[+-]?[0-9]+)? ?(?:{_BARE})|(?:.*[:=] *)?[+-]?[0-9.,]+(?:e[+-]?[0-9]+)?", re.I
)
# Longest label of a column [characters]; longer text is none.
_LONGEST_LABEL = 100


@frozen(kw_only=True)
class RecordFormat:
    """Properties that a record file does not state: layout, units and quantity.

    Parameters
    ----------
    columns : list of int, optional
        Numbers, from 1, of the time column and the force column; with ``interval`` the last is the force column.
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
        Unit of the forces, pressures or accelerations, in place of an unknown one in the header.
    sign : 1 or -1
        Factor of the values, -1 where compression is negative.
    scale : float, optional
        ``unit`` per unit of the header, such as the newtons per millivolt of a column in mV.
    area : float, optional
        Loaded area [m^2], for a record of the pressure.
    mass : float, optional
        Moving mass [kg], for a record of the acceleration.

    Raises
    ------
    InvalidValueError
        If a value is out of range, or both ``area`` and ``mass`` are given.
    """

    columns: list[int] = attrs.field(default=None)
    skip_rows: int = quantity("", "lines at the beginning to skip", at_least=0, whole=True, default=0)
    encoding: Literal["utf-8", "utf-16", "cp1252"] | None = attrs.field(default=None, validator=one_of(*_ENCODINGS))
    decimal: Literal[".", ","] | None = attrs.field(default=None, validator=one_of(None, ".", ","))
    time_unit: str | None = None
    interval: float | None = quantity("s", "sampling interval", above=0, default=None, example="1 us")
    unit: str | None = None
    sign: Literal[1, -1] = attrs.field(default=1, validator=one_of(1, -1))
    scale: float | None = quantity("", "unit per unit of the header, such as N per mV", above=0, default=None)
    area: float | None = quantity("m**2", "loaded area, for a pressure", above=0, default=None, example="1 cm**2")
    mass: float | None = quantity("kg", "moving mass, for an acceleration", above=0, default=None, example="0.3 kg")

    def __attrs_post_init__(self) -> None:
        if self.area is not None and self.mass is not None:
            raise InvalidValueError.of("mass", "must be left out if area is given (got both; delete one)")

    def plain(self, cell: str) -> str:
        """``cell`` in the form that `float` and `Decimal` read; with the other decimal separator, not a number."""
        if self.decimal == ",":
            cell = cell.replace(".", "_.").replace(",", ".")
        return cell.replace("_", "__")  # float reads 1_0 as 10


# ---------------------------------------------------------------- units


@frozen
class Label:
    """Unit of a column, empty where the header states none or several, and its text there."""

    unit: str = ""
    text: str = ""


def labels_of(cells: Sequence[str], width: int, quantity: str = "force") -> list[Label]:
    """Labels in the cells of a header; none if one of the first ``width`` is a value, such as in ``range,5 kN``.

    A line of units alone, such as ``us,N``, is a header.
    """
    cells = [" ".join(cell.split()) for cell in cells]
    cells = cells[:width] + [cell for cell in cells[width:] if not _VALUE.fullmatch(cell)]
    if any(len(cell) > _LONGEST_LABEL or _VALUE.fullmatch(cell) for cell in cells):
        return []
    units = [cell.strip("()[] ") for cell in cells]
    if not all(kind_of_unit(unit, quantity) for unit in units):
        units = [_unit(cell) for cell in cells]
    return [Label(unit, cell) for unit, cell in zip(units, cells, strict=True)]


def _unit(cell: str) -> str:
    """The unit in a label: of several brackets that in which values are measured, if there is one."""
    inside = ["".join(groups).strip() for groups in _BRACKETS.findall(cell) or _SUFFIX.findall(cell)]
    units = [each for each in inside if kind_of_unit(each)] or inside[:1]
    return units[0] if len(set(units)) == 1 else ""


@cache
def kind_of_unit(unit: str | None, quantity: str = "force") -> str | None:
    """The kind of a unit: time, force, pressure, acceleration, voltage or the ``quantity`` of a record; else None."""
    units = _UNITS if quantity in _UNITS else {quantity: _OF_MOTION[quantity], **_UNITS}
    return next((kind for kind, base in units.items() if not math.isnan(_factor(unit or "", base))), None)


def _is_unit(text: str) -> bool:
    """Whether ``text`` is a unit of any dimension."""
    try:
        return to_si(f"1 {text}", "kg") > 0 and bool(text)
    except ValueError as error:
        return "unknown unit" not in str(error)


def _factor(unit: str, base: str) -> float:
    """SI value of ``unit``; NaN if it is not a unit of the dimension of ``base``."""
    # longer units may be written in capitals, such as Sec: of shorter ones mS and ms are different
    for spelling in (unit, unit.lower())[: 1 + (len(unit) > 2)] if unit else ():
        with suppress(ValueError):
            return to_si(f"1 {spelling}", base)
    return math.nan


def factors(
    form: RecordFormat,
    labels: Sequence[Label],
    numbers: FloatArray,
    place: str,
    notes: list[str],
    quantity: str = "force",
) -> list[float]:
    """Seconds per unit of the time column and newtons per unit of the force column.

    Parameters
    ----------
    form : RecordFormat
        What the header does not state.
    labels : sequence of Label
        Labels of the two columns.
    numbers : array of float, shape (k, 2)
        The two columns in the units of the file, from which units are proposed.
    place : str
        Place of the header, for errors.
    notes : list of str
        List to which sentences on the conversion are appended.
    quantity : str
        Quantity of the record, if neither area nor mass make it a force.

    Raises
    ------
    InvalidValueError
        If a unit is not stated, with a proposal, or a column is a record of another quantity than the format states.
    """
    (time, force), faults = labels, []
    kind = "pressure" if form.area is not None else "acceleration" if form.mass is not None else quantity
    base, unit = (_UNITS | _OF_MOTION)[kind], form.unit or force.unit
    per_time, per_force = _factor(form.time_unit or time.unit, "s"), _factor(unit, base)
    if form.interval is None and (math.isnan(per_time) or kind_of_unit(time.unit) not in (None, "time")):
        faults.append(_fault("time_unit", "time", (time.text, form.time_unit), _time_hint(numbers[:, 0]), place))
    # a load in kg and lbs, or in g, which is else an acceleration, is one in kgf, lbf and gf
    is_weight = form.unit in (f"{force.unit}f", f"{force.unit[:-1]}f")
    stated = "force" if is_weight else kind_of_unit(force.unit, quantity)
    kinds = (stated, kind_of_unit(form.unit, quantity))
    other = next((each for each in kinds if each in (*_KEYS, "force") and each != kind), None)
    likely = next(iter(in_other_case(unit, base)), base)
    hint = f"unit: {likely} makes the greatest value {np.abs(numbers[:, 1]).max():.4g} {likely}; a voltage needs scale"
    if other is not None:
        per_force, hint = math.nan, f"set {_KEYS[other]}" if kind == "force" else f"delete {_KEYS.get(kind, 'unit')}"
        hint = hint if quantity == "force" else "set columns or another quantity"
    elif stated != kind and (stated or _is_unit(force.unit)) and None in (form.unit, form.scale):
        product = form.unit or base
        per_force, hint = math.nan, f"set unit: {product}, and scale to the {product} per {force.unit}"
    if math.isnan(per_force):
        faults.append(_fault("unit", kind, (force.text, form.unit), hint, place))
    refuse(faults)
    for stated, used in ((time.unit, form.time_unit), (force.unit, unit)):
        if stated and used not in (None, stated):
            notes.append(f"The file states the unit {stated!r}; {used!r} was used.")
    for key in ("area", "mass", "scale", "sign"):
        if (value := getattr(form, key)) not in (None, 1):
            per_force *= value
            size = f"{value:.6g} {unit} per {force.unit}" if key == "scale" and force.unit else f"{value:.6g}"
            notes.append(f"The values were multiplied by the {key}, {size}.")
    return [per_time, per_force]


def _fault(key: str, kind: str, texts: Sequence[str | None], hint: str, place: str) -> Fault:
    got = " and ".join(map(repr, filter(None, texts))) or "none"
    return Fault(key, f"must be a unit of {kind} (got {got}; {hint})", place)


def _time_hint(times: FloatArray) -> str:
    """The key for times whose unit is not stated: blows last about a millisecond."""
    if times[0] in (0, 1) and (np.diff(times) == 1).all():
        return "set interval, the sampling interval, because the column counts samples"
    length = max(float(np.ptp(times)), 1e-99)
    likely = min(("s", "ms", "us", "ns"), key=lambda unit: abs(math.log(length * _factor(unit, "ms"))))
    return f"time_unit: {likely} makes the record {length:.4g} {likely} long, or set columns or interval"
