"""Format of a record file: its layout, and the units and quantities of its columns."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from typing import Any, Literal

import attrs
from attrs import frozen

from shockwave.errors import InvalidValueError
from shockwave.fields import one_of, quantity, text_of

#: Units that are recognised without brackets.
BARE_UNITS = (
    r"s|ms|us|µs|μs|ns|N|mN|kN|MN|lbf|kgf|Pa|hPa|kPa|MPa|GPa|mbar|bar|psi|ksi"
    r"|g|gn|m/s2|m/s²|m/s\^2|m/s\*\*2|V|mV|uV|µV|pC"
)
#: Words that name a time column.
TIME_NAMES = frozenset({"time", "t", "zeit", "temps", "tempo", "tiempo"})
#: Words that name a column of each quantity.
FORCE_NAMES = {
    "force": frozenset({"force", "f", "load", "kraft", "forza", "fuerza"}),
    "pressure": frozenset({"pressure", "overpressure", "druck", "überdruck", "pression", "pressione", "presión"}),
    "acceleration": frozenset({"acceleration", "accel", "acc", "beschleunigung", "accélération", "accelerazione"}),
}
#: Decimal signs, thousands marks and encodings.
DECIMALS = (".", ",")
THOUSANDS = (".", ",", "'", " ")
_ENCODINGS = ("utf-8", "utf-16", "cp1252", "latin-1")
# SI unit of each quantity.
_UNITS = {"force": "N", "pressure": "Pa", "acceleration": "m/s**2"}
# Key that turns a record of the quantity into one of the force.
_KEYS = {"pressure": "area, the loaded area", "acceleration": "mass, the moving mass"}

# Least length of a label that can be the name of a unit: shorter ones are names or symbols.
_SHORTEST = 4

# Only products and single-digit powers of words: parsing a longer expression could take unbounded time.
_FACTOR = r"[A-Za-zµμ]{1,20}(?:(?:\*\*|\^)-?[0-9])?"
_UNIT = re.compile(rf"{_FACTOR}(?: ?[*·/] ?{_FACTOR}){{0,4}}")
# Spellings that pint does not know, or knows as something else: g is a gram there.
_SPELLINGS = {"m/s2": "m/s^2", "g": "g_0", "gn": "g_0"}


def _columns(value: Any) -> Any:
    """A pair of names and numbers as a tuple."""
    if value is None:
        return None
    pair = tuple(value) if isinstance(value, list | tuple) else ()
    if len(pair) != 2 or not all(type(one) in (int, str) for one in pair):
        rule = "must be two names or numbers, of the time column and the force column"
        raise InvalidValueError.of("columns", f"{rule} (got {text_of(value)})")
    return pair


def _choice(*known: str) -> Any:
    """An optional attrs field that holds one of the texts ``known``."""
    return attrs.field(default=None, validator=one_of(None, *known))


def _lower(value: Any) -> Any:
    return value.lower() if isinstance(value, str) else value


def _unit_name(_: object, attribute: attrs.Attribute[Any], value: object) -> None:
    if not isinstance(value, str | None):
        raise InvalidValueError.of(
            attribute.name, f"must be a unit in quotes, such as 'ms' or 'kN' (got {text_of(value)})"
        )


@frozen(kw_only=True)
class RecordFormat:
    """Format and quantity of a record file; what is left out is found in the file.

    Parameters
    ----------
    columns : list of int or str, optional
        Numbers, from 1, or names of the time column and the force column.
    skip_rows : int
        Number of lines at the beginning of the file to skip.
    encoding : "utf-8", "utf-16", "cp1252" or "latin-1", optional
        Encoding of the file.
    decimal : "." or ",", optional
        Decimal sign.
    thousands : ".", ",", "'" or " ", optional
        Thousands mark.
    time_unit : str, optional
        Unit of the times, in place of that in the header.
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

    columns: list[int | str] = attrs.field(default=None, converter=_columns)
    skip_rows: int = quantity("", "lines at the beginning to skip", at_least=0, whole=True, default=0)
    encoding: Literal["utf-8", "utf-16", "cp1252", "latin-1"] | None = attrs.field(
        default=None, converter=_lower, validator=one_of(None, *_ENCODINGS)
    )
    decimal: Literal[".", ","] | None = _choice(*DECIMALS)
    thousands: Literal[".", ",", "'", " "] | None = _choice(*THOUSANDS)
    time_unit: str | None = attrs.field(default=None, validator=_unit_name)
    unit: str | None = attrs.field(default=None, validator=_unit_name)
    sign: Literal[1, -1] = attrs.field(default=1, validator=one_of(1, -1))
    scale: float | None = quantity("", "factor of the values, such as newtons per volt", above=0, default=None)
    area: float | None = quantity("m**2", "loaded area, for a pressure", above=0, default=None, example="1 cm**2")
    mass: float | None = quantity("kg", "moving mass, for an acceleration", above=0, default=None, example="0.3 kg")

    def __attrs_post_init__(self) -> None:
        if self.area is not None and self.mass is not None:
            raise InvalidValueError.of("mass", "must be left out if area is given (got both; delete one)")
        if self.decimal is not None and self.decimal == self.thousands:
            raise InvalidValueError.of("thousands", f"must not be the decimal sign (got {self.thousands!r} for both)")

    @property
    def kind(self) -> str:
        """Quantity of the record, which is force, pressure or acceleration."""
        return "pressure" if self.area is not None else "acceleration" if self.mass is not None else "force"


def time_factor(form: RecordFormat, name: str, unit: str, notes: list[str]) -> float:
    """Seconds per unit of the time column, whose header states ``name`` and ``unit``.

    Raises
    ------
    InvalidValueError
        If it is not a unit of time.
    """
    if not (form.time_unit or unit) and _words(name) <= TIME_NAMES:
        _check_header(form, name, "unit of time", "time_unit")
        hint = "A header such as 'time [s]', or time_unit, states the unit."
        notes.append(f"The time column has no unit: seconds are assumed. {hint}")
        return 1.0
    factor = _factor(form.time_unit or unit, "s")
    if math.isnan(factor):
        got = f"got {text_of(form.time_unit or unit or name)}; set time_unit, or write [s] in the header"
        raise InvalidValueError.of("unit of time", f"must be a unit of time ({got})")
    return factor


def force_factor(form: RecordFormat, name: str, unit: str, notes: list[str]) -> float:
    """Newtons per unit of the force column, whose header states ``name`` and ``unit``.

    Raises
    ------
    InvalidValueError
        If the column is a record of another quantity than the format states, or its unit is not known.
    """
    kind, words = form.kind, _words(name)
    base, path = _UNITS[kind], f"unit of {kind}"
    named = next((each for each in (kind, *_UNITS) if FORCE_NAMES[each] & words), None)
    stated = measured(unit) if unit else named
    for got, found in ((text_of(unit or name), stated), (f"unit {form.unit}", measured(form.unit or ""))):
        if found in _UNITS and found != kind:
            remedy = f"set {_KEYS[found]}" if kind == "force" else f"delete {_KEYS[kind].partition(',')[0]}"
            if form.unit and found == stated:
                got = f"{got} in the header, although unit is {form.unit}"
            wanted, other = (f"{'an' if each.startswith('a') else 'a'} {each}" for each in (kind, found))
            problem = f"must be that of {wanted}, not of {other} (got {got}; {remedy})"
            raise InvalidValueError.of(path, problem)
    if not (form.unit or unit) and kind == "force" and words <= FORCE_NAMES[kind]:
        _check_header(form, name, path, "unit")
        hint = "A header such as 'force [N]', or unit, states the unit."
        notes.append(f"The force column has no unit: newtons are assumed. {hint}")
        factor = 1.0
    else:
        factor = _factor(form.unit or unit, base)
    if math.isnan(factor):
        got = f"got {text_of(form.unit or unit or name)}; set unit, such as {base}, and scale for a sensitivity"
        raise InvalidValueError.of(path, f"must be a unit of {kind} ({got})")
    if form.unit and unit and stated not in _UNITS and form.scale is None:
        got = f"got {unit!r} in the header; set scale, the number of {form.unit} per {'V' if stated else unit}"
        raise InvalidValueError.of(path, f"must be a unit of {kind} ({got})")
    volts = _factor(unit, "V") if form.scale is not None and stated == "voltage" else 1.0
    if volts != 1:
        factor *= volts
        notes.append(f"The values, in {unit}, were converted to volts: scale is per volt.")
    elif form.unit and unit and form.unit != unit:
        notes.append(f"The header states the unit {unit!r}; {form.unit!r} was used.")
    for key, value, si in (("area", form.area, "m^2"), ("mass", form.mass, "kg")):
        if value is not None:
            notes.append(f"The force is the {kind} times the {key} of {value:.6g} {si}.")
            factor *= value
    if form.scale is not None or form.sign < 0:
        notes.append(f"The values were multiplied by {(form.scale or 1.0) * form.sign:g}.")
    return factor * (form.scale or 1.0) * form.sign


def _check_header(form: RecordFormat, name: str, path: str, key: str) -> None:
    """Refuse a column without a header below skipped lines, one of which may be the header."""
    if form.skip_rows and not name:
        got = f"got no header below {form.skip_rows} skipped lines; skip fewer, or set {key}"
        raise InvalidValueError.of(path, f"must be stated ({got})")


def measured(unit: str) -> str | None:
    """The quantity that is measured in a unit: time, force, pressure, acceleration or voltage; None if unknown."""
    bases = {"time": "s", **_UNITS, "voltage": "V"}
    return next((each for each, base in bases.items() if unit and not math.isnan(_factor(unit, base))), None)


def is_unit(name: str) -> bool:
    """Whether a label of a column is the name of a unit, and none of those of a time or a force column."""
    if len(name) < _SHORTEST or _words(name) & TIME_NAMES.union(*FORCE_NAMES.values()):
        return False
    return any(not math.isnan(_factor(name, base)) for base in ("s", "V", *_UNITS.values()))


def _words(name: str) -> frozenset[str]:
    return frozenset(re.findall(r"[^\W\d_]+", name.lower()))


def _factor(unit: str, base: str) -> float:
    """SI value of ``unit``; NaN if it is not a unit of the dimension of ``base``."""
    if unit == base:
        return 1.0
    unit = _SPELLINGS.get(unit, unit.replace("²", "^2"))
    if unit == "g_0" or (len(unit) <= 40 and _UNIT.fullmatch(unit)):
        import pint  # needed only for units other than s and N

        # A unit such as 'Seconds' or 'Sec' is recognised in lower case.
        for spelling in (unit, unit.lower()):
            with suppress(AttributeError, TypeError, ValueError):  # unknown unit, or wrong dimension
                return float(pint.Quantity(1.0, spelling).to(base).magnitude)
    return math.nan
