"""Conversion of a number, or of text such as ``15 us``, to a float in SI units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from decimal import Context, Decimal, localcontext
from functools import cache, lru_cache
from typing import Any, TypeAlias

from shockwave.base.errors import InvalidValueError, nearest, text_of

#: Standard acceleration of gravity [m/s^2].
STANDARD_GRAVITY = 9.80665
#: Hint for a decimal comma.
COMMA = "; numbers have a decimal point and no comma"
# Characters of a quantity.
_LONGEST = 80
_NUMBER = r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]{1,4})?"
# A factor of a unit, such as *mm^2, *mm2 or /s^-1. Exponents are short: a parser can spend forever on 9**9**9.
_FACTOR = r"([*/])(g_?0|[A-Za-zµμ°%Ω_]{1,30})(?:\^(-?[0-9]{1,2}(?:\.[0-9]{1,2})?)|(-?[1-9]))?"
# Signs that stand for others: a minus, products and raised digits.
_SIGNS = str.maketrans("\N{MINUS SIGN}·⋅⁻¹²³⁴⁵⁶", "-**-123456")
_INVERSE = str.maketrans("*/", "/*")

_NAMES = {
    "": "a number, such as 5 or '3 %'",
    "s": "a time, such as '15 us'",
    "N": "a force, such as '100 N'",
    "m": "a length, such as '9.5 mm'",
    "Pa": "a stress, such as '193 GPa'",
    "kg/m**3": "a density, such as '7958 kg/m**3'",
}

# Usual units by quantity, with the values of pint: most scenarios then need no import of pint, which takes longer than
# the rest. For pint, mil is an angle. A gauge pressure, psig, is the difference that loads a body.
_UNITS = (
    {"%": "0.01"}
    | {"sec": "1 s", "Hz": "1 /s"}
    | {"in": "0.0254 m", "ft": "12 in", "mil": "1e-3 in"}
    | {"lb": "0.45359237 kg", "lbm": "1 lb", "t": "1000 kg"}
    | {"N": "1 kg*m/s^2", "kgf": "9.80665 N", "lbf": "4.4482216152605 N", "kip": "1000 lbf", "Ns": "1 N*s"}
    | {"Pa": "1 N/m^2", "bar": "1e5 Pa", "mbar": "100 Pa"}
    | {"psi": "1 lbf/in^2", "psig": "1 psi", "ksi": "1000 psi", "Msi": "1e6 psi"}
    | {"gee": "9.80665 m/s^2", "g0": "1 gee"}
    | {"J": "1 N*m", "C": "1 A*s", "V": "1 J/C"}
)
_METRIC = ("m", "g", "s", "A", "N", "Pa", "J", "C", "V", "Hz", "gee")
_PREFIXES = {"da": 1, "h": 2, "k": 3, "M": 6, "G": 9, "c": -2, "m": -3, "u": -6, "µ": -6, "μ": -6, "n": -9, "p": -12}
_UNITS |= {prefix + name: f"1e{power} {name}" for name in _METRIC for prefix, power in _PREFIXES.items()}
# Their base units, and the dimensions in the names of pint.
_BASES = {"m": "[length]", "g": "[mass]", "s": "[time]", "A": "[current]"}
# The acceleration of gravity where an acceleration is read; else a gram, a milligram or a gauss.
_GRAVITY = "([munµμ]?)(?:gn?|G)"

# More digits than a float has.
_CONTEXT = Context(prec=40)
# Value in base units, and exponents of the dimensions.
_Measure: TypeAlias = tuple[Decimal, Mapping[str, Decimal]]


def to_si(value: Any, unit: str = "") -> float:
    """``value`` in the SI unit ``unit``.

    Parameters
    ----------
    value : int, float, str or pint.Quantity
        A bare number is in SI units. Text is a number, or a number with a unit of the same dimension.
    unit : str, optional
        SI unit in the spelling of pint; none for a dimensionless number, where ``5 %`` is 0.05.

    Returns
    -------
    float
        The float nearest to the exact value: ``15 us`` and ``15e-6`` are the same number.

    Raises
    ------
    InvalidValueError
        When it is not such a quantity, or not finite. The message begins with ``must be``.
    """
    try:
        plain = _from_pint(value, unit) if hasattr(value, "to_base_units") else value
        if isinstance(plain, bool) or not isinstance(plain, int | float | str):
            raise ValueError
        number = _from_text(plain, unit) if isinstance(plain, str) else float(plain)
    except OverflowError:
        number = math.inf
    except ValueError as error:
        rule = _NAMES.get(unit, f"a quantity in {unit}, such as '2 {unit}'")
        got = "nothing" if value is None else text_of(value)
        raise InvalidValueError(f"must be {rule} (got {got}{error})") from None
    if not math.isfinite(number):
        raise InvalidValueError(f"must be finite (got {text_of(value)})")
    return number


def is_si(unit: str) -> bool:
    """Whether ``unit`` is a unit of the SI without a factor, such as ``N*s/m``, or empty."""
    try:
        value, dimension = _measure(unit)
    except ValueError:
        return False
    # measures are in grams
    return value == Decimal(1000) ** dimension.get("[mass]", Decimal(0))


def _from_text(text: str, unit: str) -> float:
    """Number in ``text``; raises ValueError, with a reason if there is one."""
    if len(text) > _LONGEST:  # the patterns must not process a long text
        raise ValueError
    text = " ".join(text.translate(_SIGNS).split())
    match = re.match(_NUMBER, text)
    if match is None or "," in text:
        raise ValueError(COMMA if re.search("[0-9],[0-9]", text) else "")
    number, of_unit = match[0], text[match.end() :].removeprefix(" ")
    if not of_unit:
        return float(number)
    fraction = re.match(rf"/ ?({_NUMBER})(?! ?[0-9./])", of_unit)
    if fraction and float(fraction[1]):
        raise ValueError(f"; write {float(number) / float(fraction[1]):.6g}{of_unit[fraction.end() :]}")
    if not unit and (sensitivity := re.fullmatch(r"(\w?([VC])) ?/ ?(.+)", of_unit)) and float(number):
        raise ValueError(_scale_hint(float(number), *sensitivity.groups()))
    with localcontext(_CONTEXT):
        return float(Decimal(number) * _factor(of_unit, unit))


def _scale_hint(sensitivity: float, unit: str, base: str, measured: str) -> str:
    """Advice for a ``sensitivity`` in ``unit``, such as mV, per unit of the ``measured`` quantity."""
    scales = {base: _factor(base, unit), unit: Decimal(1)}
    texts = (f"{float(factor) / sensitivity:.6g} for {measured} per {name}" for name, factor in scales.items())
    return f"; as a scale, 1/sensitivity, write {' or '.join(texts)}"


def _from_pint(value: Any, unit: str) -> float:
    """Number in a quantity of pint; raises ValueError for another dimension."""
    try:
        converted = float(value.to(unit or "dimensionless").magnitude)
    except Exception as error:  # whatever pint raises, the quantity is of another dimension or no scalar
        raise ValueError from error
    try:  # without the rounding errors of the units
        exact = _from_text(f"{float(value.magnitude)!r} {value.units}", unit)
    except ValueError:  # a unit of the caller's own
        return converted
    return exact if math.isclose(exact, converted) else converted


@lru_cache(maxsize=1024)
def _factor(of_unit: str, unit: str) -> Decimal:
    """Value of one ``of_unit`` in ``unit``; raises ValueError, with advice, if it is not a unit of this dimension."""
    if unit == "m/s**2" and (match := re.fullmatch(_GRAVITY, of_unit)):
        of_unit = f"{match[1]}gee"
    base, dimension = _measure(unit)
    value, dimension_of_unit = _measure(of_unit)
    if dimension_of_unit != dimension:
        weight, dimension_of_weight = _measure(f"{of_unit}*gee")
        as_weight = f"; as a weight, 1 {of_unit} is {weight / base:.6g} {unit}"
        raise ValueError(_advice(of_unit, unit) or as_weight * (dimension_of_weight == dimension))
    return value / base


def _advice(name: str, unit: str | None) -> str:
    same = " or ".join(map(repr, in_other_case(name, unit)))
    advice = f"did you mean {same}?" if same else nearest(name, _usual_units(unit)).strip()
    return f"; {advice}" if advice else ""


def in_other_case(name: str, unit: str | None) -> list[str]:
    """The usual units of the dimension of ``unit``, or of any, that differ from ``name`` in case alone."""
    return [each for each in _usual_units(unit) if each.lower() == name.lower()]


@cache
def _usual_units(unit: str | None) -> list[str]:
    with localcontext(_CONTEXT):
        dimension = None if unit is None else _measure(unit)[1]
        return [name for name in (*_BASES, *_UNITS) if dimension in (None, _measure_name(name)[1])]


def _measure(text: str) -> _Measure:
    """Measure of a product of units; raises ValueError, with advice, for other text."""
    if text.isalpha():
        return _measure_name(text)
    text = text.translate(_SIGNS).replace("**", "^").removeprefix("1")
    product = re.sub(" ?([*/^]) ?| ", lambda match: match[1] or "*", text)
    product = re.sub(
        r"(/?)\(([^()]+)\)", lambda match: match[1] + (match[2].translate(_INVERSE) if match[1] else match[2]), product
    )
    product = product if product.startswith("/") or not product else f"*{product}"
    if re.sub(_FACTOR, "", product):
        raise ValueError
    value, exponents = Decimal(1), dict[str, Decimal]()
    for sign, name, power, digit in re.findall(_FACTOR, product):
        factor, dimension = _measure_name(name)
        exponent = Decimal(power or digit or 1) * (1 if sign == "*" else -1)
        value *= factor**exponent
        exponents |= {each: exponents.get(each, 0) + number * exponent for each, number in dimension.items()}
    return value, {each: number for each, number in exponents.items() if number}


@cache
def _measure_name(name: str) -> _Measure:
    """Measure of a single unit, as `_measure`."""
    if name in _BASES:
        return Decimal(1), {_BASES[name]: Decimal(1)}
    if name in _UNITS:
        number, _, of_unit = _UNITS[name].partition(" ")
        value, dimension = _measure(of_unit)
        return Decimal(number) * value, dimension
    try:
        # a product of one with a zero point of its own, such as degC, raises
        quantity = (1 * _registry().Quantity(Decimal(1), name)).to_root_units()
    except Exception as error:  # whatever pint raises, the text is not a unit
        undefined = type(error).__name__ == "UndefinedUnitError"
        raise ValueError(f"; unknown unit{_advice(name, None)}" if undefined else "") from None
    return Decimal(quantity.magnitude), {each: Decimal(number) for each, number in quantity.dimensionality.items()}


@cache
def _registry() -> Any:
    import pint  # needed only for units that are not in _UNITS

    # Decimal factors: with floats 15 us would not be 15e-6, nor 7.958 g/cm**3 be 7958 kg/m**3.
    return pint.UnitRegistry(non_int_type=Decimal)
