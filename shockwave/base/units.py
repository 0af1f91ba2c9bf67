"""Conversion of a number, or of text such as ``15 us``, to a float in SI units."""

from __future__ import annotations

import math
import re
from decimal import Context, Decimal, localcontext
from functools import cache, lru_cache
from typing import Any

from shockwave.base.errors import InvalidValueError, text_of

#: Hint for a decimal comma.
COMMA = "; numbers have a decimal point and no comma"
# Characters of a quantity.
_LONGEST = 80
_NUMBER = r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]{1,4})?"
# Exponents are short numbers and apply to units only: a parser can spend forever on 9**9**9.
_FACTOR = r"[A-Za-zµμ°%Ω_]{1,30}(?: ?(?:\*\*|\^) ?-?[0-9]{1,2}(?:\.[0-9]{1,2})?|⁻?[¹²³⁴⁵⁶])?"
_BY = r"(?: ?[*/·] ?| )"
_TERM = rf"(?:{_FACTOR}|\( ?{_FACTOR}(?:{_BY}{_FACTOR})* ?\))"
_QUANTITY = rf"({_NUMBER}) ?((?:1? ?/ ?)?{_TERM}(?:{_BY}{_TERM})*)?"

_NAMES = {
    "": "a number, such as 5 or '3 %'",
    "s": "a time, such as '15 us'",
    "N": "a force, such as '100 N'",
    "m": "a length, such as '9.5 mm'",
    "Pa": "a stress, such as '193 GPa'",
    "kg/m**3": "a density, such as '7958 kg/m**3'",
}

# Common units, with the values of pint: most scenarios then need no import of pint, which takes longer than the rest.
_USUAL = {
    "": {"%": "0.01"},
    "s": {"s": "1", "ms": "1e-3", "us": "1e-6", "µs": "1e-6", "μs": "1e-6", "ns": "1e-9"},
    "N": {"N": "1", "mN": "1e-3", "kN": "1e3", "MN": "1e6"},
    "m": {"m": "1", "cm": "1e-2", "mm": "1e-3", "um": "1e-6", "µm": "1e-6", "μm": "1e-6"},
    "Pa": {"Pa": "1", "kPa": "1e3", "MPa": "1e6", "GPa": "1e9"},
    "kg/m**3": {"kg/m**3": "1", "kg/m^3": "1", "g/cm**3": "1e3", "g/cm^3": "1e3"},
}


def to_si(value: Any, unit: str) -> float:
    """``value`` in the SI unit ``unit``.

    Parameters
    ----------
    value : int, float, str or pint.Quantity
        A bare number is in SI units. Text is a number, or a number with a unit of the same dimension.
    unit : str
        SI unit in the spelling of pint; empty for a dimensionless number, where ``5 %`` is 0.05.

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
        plain = _of_pint(value, unit) if hasattr(value, "to_base_units") else value
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


def _from_text(text: str, unit: str) -> float:
    """Number in ``text``; raises ValueError, with a reason if there is one."""
    if len(text) > _LONGEST:  # the pattern must not process a long text
        raise ValueError
    number, _, of_unit = text.partition(" ")
    usual = _USUAL.get(unit, {}).get(of_unit)
    if not (usual and re.fullmatch(_NUMBER, number)):  # compiling the long pattern takes milliseconds
        match = re.fullmatch(_QUANTITY, " ".join(text.split()))
        if match is None:
            raise ValueError(COMMA if re.search("[0-9],[0-9]", text) else "")
        number, of_unit = match.groups()
        if of_unit is None:
            return float(number)
        usual = _USUAL.get(unit, {}).get(of_unit)
    with localcontext(Context(prec=40)):
        return float(Decimal(number) * (Decimal(usual) if usual else _factor(of_unit, unit)))


def _of_pint(value: Any, unit: str) -> float:
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
    """One ``of_unit`` in ``unit``."""
    registry = _registry()
    spelling = "1" + of_unit if of_unit.startswith("/") else of_unit
    try:
        # a product of one with a zero point of its own, such as degC, raises
        return Decimal((1 * registry.Quantity(Decimal(1), spelling)).to(unit or "dimensionless").magnitude)
    except Exception as error:  # whatever pint raises, the text is not a unit
        undefined = type(error).__name__ == "UndefinedUnitError"
        raise ValueError("; unknown unit" if undefined else "") from None


@cache
def _registry() -> Any:
    import pint  # needed only for units that are not in _USUAL

    # Decimal factors: with floats 15 us would not be 15e-6, nor 7.958 g/cm**3 be 7958 kg/m**3.
    return pint.UnitRegistry(non_int_type=Decimal)
