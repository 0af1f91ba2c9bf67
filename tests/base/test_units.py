"""Units: numbers and text become SI numbers, by the usual units alone or by pint."""

import subprocess
import sys
from decimal import Decimal

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
    ("2 /s", "1/s", 2.0), ("2 1/ms", "1/s", 2000.0), ("2 g/cm³", "kg/m³", 2000.0), ("2 (N*s)/m", "N*s/m", 2.0),
    ("2 N ** 2/(N*s)", "N/s", 2.0),
    ("\N{MINUS SIGN}15 us", "s", -15e-6), ("\N{MINUS SIGN}1.5e\N{MINUS SIGN}5", "s", -15e-6),
    ("-15\N{NO-BREAK SPACE}us", "s", -15e-6),
    ("2 atm", "Pa", 202650.0), ("2 BTU/(ft*s)", "N/s", 2 * 1055.056 / 0.3048),
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


# Spellings of the field, with that of pint; each is read without it.
SPELLINGS = [
    ("N/mm2", "Pa", "newton / millimeter ** 2"), ("N/mm²", "Pa", "newton / millimeter ** 2"),
    ("kgf/cm2", "Pa", "kilogram_force / centimeter ** 2"), ("psig", "Pa", "pound_force / inch ** 2"),
    ("daN", "N", "10 newton"), ("mil", "m", "inch / 1000"), ("\N{MICRO SIGN}m", "m", "micrometer"),
    ("\N{GREEK SMALL LETTER MU}s", "s", "microsecond"), ("mm/s2", "m/s**2", "millimeter / second ** 2"),
    ("m s-2", "m/s**2", "meter / second ** 2"), ("m·s⁻²", "m/s**2", "meter / second ** 2"),
    *((name, "m/s**2", "standard_gravity") for name in ("g0", "gee", "g", "gn", "G")),
    ("mg", "m/s**2", "standard_gravity / 1000"), ("mg", "kg", "milligram"),
    ("kg/m³", "kg/m**3", "kilogram / meter ** 3"),
    ("g/cm3", "kg/m**3", "gram / centimeter ** 3"), ("lb/in^3", "kg/m**3", "pound / inch ** 3"),
    ("Ns/m", "N*s/m", "newton * second / meter"), ("N·s", "N*s", "newton * second"), ("N⋅s", "N*s", "newton * second"),
    ("lbf·s/in", "N*s/m", "pound_force * second / inch"), ("kHz", "1/s", "1000 / second"), ("in²", "m**2", "inch ** 2"),
]  # fmt: skip


@pytest.mark.parametrize(("spelling", "unit", "of_pint"), SPELLINGS, ids=[" of ".join(row[:2]) for row in SPELLINGS])
def test_spellings_of_the_field_are_read_without_pint(
    spelling: str, unit: str, of_pint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(units, "_registry", lambda: pytest.fail("pint was used"))
    assert to_si(f"3 {spelling}", unit) == pytest.approx(3 * REGISTRY(of_pint).m_as(unit), rel=1e-14)


REGISTRY = pint.get_application_registry()
# Usual units that pint lacks or takes for others; the test above has them.
OWN = {"mil", "psig", "lbm", "Ns", "Msi", *(name for name in units._UNITS if name.endswith("gee"))}


@pytest.mark.parametrize("name", [*units._BASES, *sorted(units._UNITS.keys() - OWN)])
def test_the_usual_units_are_those_of_pint(name: str) -> None:
    value, dimension = units._measure(name)
    by_pint = REGISTRY.Quantity(1.0, name).to_root_units()
    # floats lose a few units in the last place
    assert float(value) == pytest.approx(by_pint.magnitude, rel=1e-14)
    assert dimension == {each: Decimal(number) for each, number in by_pint.dimensionality.items()}


SLIPS = [
    ("1 KN", "N", "unknown unit; did you mean 'kN'"), ("1 kn", "N", "did you mean 'kN'"),
    ("3/8 in", "m", "; write 0.375 in"), ("1 kg", "N", "did you mean 'kgf'"), ("60 lb", "N", "did you mean 'lbf'"),
    ("1 Mpa", "Pa", "unknown unit; did you mean 'MPa' or 'mPa'"), ("3 KN/m", "N/m", "did you mean 'kN'"),
    ("20 g", "N", "as a weight, 1 g is 0.00980665 N"), ("20 lbm", "N", "did you mean 'lbf'"),
    ("1/2.3 in", "m", "; write 0.434783 in"), ("1/2/2026", "", r"\(got '1/2/2026'\)"),
    ("1/2.3.4", "", r"\(got '1/2.3.4'\)"), ("1/0.0", "", r"\(got '1/0.0'\)"),
    ("2.3 mV/N", "", "as a scale, 1/sensitivity, write 434.783 for N per V or 0.434783 for N per mV"),
    ("4 pC/N", "", "0.25 for N per pC"), ("0.01 V / kN", "", "write 100 for kN per V[)]"),
    ("20 lb/in^2", "Pa", "as a weight, 1 lb/in.2 is 6894.76 Pa"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "unit", "advice"), SLIPS, ids=[row[0] for row in SLIPS])
def test_a_slip_in_a_unit_is_refused_with_the_unit_that_was_meant(text: str, unit: str, advice: str) -> None:
    with pytest.raises(ValueError, match=advice):
        to_si(text, unit)


def test_pint_is_imported_for_an_unusual_unit_only() -> None:
    code = (
        "import sys; from shockwave.base.units import to_si; to_si('15 us', 's'); to_si('60 lbf', 'N');"
        "assert 'pint' not in sys.modules; to_si('1 atm', 'Pa'); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
