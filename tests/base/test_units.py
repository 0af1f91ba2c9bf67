"""Units: numbers and text become SI numbers, by the usual units alone or by pint."""

import subprocess
import sys

import pint
import pytest

from shockwave.base import units
from shockwave.base.units import to_si

QUANTITIES = [
    (15, "s", 15.0), (1.5e-5, "s", 1.5e-5), ("15", "s", 15.0), ("1.5e-5", "s", 1.5e-5), ("15us", "s", 15e-6),
    ("  15   µs ", "s", 15e-6), ("15 microsecond", "s", 15e-6), (".5 ms", "s", 0.5e-3), ("2 min", "s", 120.0),
    ("9.5 mm", "m", 9.5e-3), ("1 in", "m", 0.0254), ("193 GPa", "Pa", 193e9), ("2 N/mm^2", "Pa", 2e6),
    ("2 kg/(m*s**2)", "Pa", 2.0), ("7.958 g/cm^3", "kg/m**3", 7958.0), ("7958 kg m^-3", "kg/m**3", 7958.0),
    ("7958 kg·m⁻³", "kg/m**3", 7958.0), ("-3 kN", "N", -3000.0), ("5%", "", 0.05), ("3.0 %", "", 0.03),
    ("2 /s", "1/s", 2.0), ("2 1/ms", "1/s", 2000.0),
]  # fmt: skip


@pytest.mark.parametrize(("value", "unit", "si"), QUANTITIES, ids=[str(row[0]) for row in QUANTITIES])
def test_quantities_become_the_nearest_si_float(value: float | str, unit: str, si: float) -> None:
    assert to_si(value, unit) == si


WRONG = [
    ("15 kg", "s", r"must be a time, such as '15 us' \(got '15 kg'\)"), ("15 uss", "s", "unknown unit"),
    ("us", "s", "must be a time"), ("abc", "N", "must be a force"), ("10 degC", "K", "must be a quantity in K"),
    ("1e999", "s", "must be finite"), ("inf", "s", "must be a time"), (float("nan"), "s", "must be finite"),
    (10**400, "s", "must be finite"), (True, "s", "must be a time"), (None, "s", r"\(got nothing\)"),
    ([1], "s", "must be a time"), ("9**9**9**9 s", "s", "must be a time"),
    ("1 (((s**99)**99)**99)**99", "s", "must be a time"), ("1 " + "s*" * 60 + "s", "s", "must be a time"),
    ("3 __import__('os')", "s", "must be a time"), ("3 N", "furlong", "must be a quantity in furlong"),
]  # fmt: skip


@pytest.mark.parametrize(("value", "unit", "message"), WRONG, ids=[str(row[0])[:30] for row in WRONG])
def test_other_values_are_refused(value: object, unit: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        to_si(value, unit)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("unit", "usual", "factor"), [(u, k, f) for u, of in units._USUAL.items() for k, f in of.items()]
)
def test_the_usual_units_are_those_of_pint(unit: str, usual: str, factor: str) -> None:
    # Relative: with floats pint loses a few units in the last place.
    registry = pint.application_registry
    assert registry.Quantity(1.0, usual).to(unit or "dimensionless").magnitude == pytest.approx(
        float(factor), rel=1e-14
    )


def test_pint_is_imported_for_an_unusual_unit_only() -> None:
    code = (
        "import sys; from shockwave.base.units import to_si; to_si('15 us', 's'); to_si('3', 'm');"
        "assert 'pint' not in sys.modules; to_si('1 lbf', 'N'); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
