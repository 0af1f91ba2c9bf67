"""Printed numbers: as many digits as their errors leave, and rows of long tables."""

import math
import re

import pytest

from shockwave.base.result_tables import evenly
from shockwave.base.text import error_text, paragraph, percent, render_on_screen, round_bound, round_digits, si, table
from shockwave.pictures.picture_elements import si_label


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (1e-4, "1.23457 kN"),  # an error of 0.12 N, to its second digit
        (2.4e-4, "1.23457 kN"),  # of 0.29 N, likewise
        (2.5e-4, "1.2346 kN"),  # of 0.31 N, to its first digit
        (0.9, "1.2 kN"),
        (1.0, "1 kN"),
        (math.inf, "1 kN"),
        (math.nan, "1 kN"),
        (0.0, "1.23456789000000 kN"),
    ],
)
def test_a_number_has_the_digits_that_its_error_leaves(error: float, text: str) -> None:
    assert si(1234.56789, "N", error=error) == text


@pytest.mark.parametrize(
    ("value", "unit", "text", "label"),
    [
        (9.81, "m/s**2", "9.81 m/s^2", "9.81 m/s²"),
        (2500.0, "m/s^2", "2.5 km/s^2", "2.5 km/s²"),
        (7800.0, "kg/m**3", "7800 kg/m^3", "7800 kg/m³"),
        (1.5e-5, "s", "15 us", "15 µs"),
    ],
)
def test_powers_of_units_have_one_spelling_in_text_and_one_in_pictures(
    value: float, unit: str, text: str, label: str
) -> None:
    assert (si(value, unit), si_label(value, unit, 4)) == (text, label)


@pytest.mark.parametrize(("count", "most", "rows"), [(3, 10, [0, 1, 2]), (10, 4, [0, 3, 6, 9]), (1, 5, [0])])
def test_rows_of_a_long_table_are_evenly_chosen_with_both_ends(count: int, most: int, rows: list[int]) -> None:
    assert evenly(count, most).tolist() == rows


@pytest.mark.parametrize(
    ("share", "shown"),
    [(4.38, "440 %"), (0.00196, "0.2 %"), (1.0, "100 %"), (0.9996, "99.96 %"), (0.0, "0 %"), (1e-9, "1e-07 %")],
)
def test_percentages_have_two_digits_near_the_whole_of_what_is_missing_and_no_power_of_ten(
    share: float, shown: str
) -> None:
    assert percent(share) == shown
    assert percent(share, sign="+") == f"+{shown}"


@pytest.mark.parametrize(("value", "down", "up"), [(595.13, 595, 596), (0.07996, 0.0799, 0.08), (4.0, 4.0, 4.0)])
def test_bounds_are_rounded_outwards(value: float, down: float, up: float) -> None:
    assert (round_bound(value, up=False), round_bound(value, up=True)) == (down, up)
    assert (round_bound(-value, up=False), round_bound(-value, up=True)) == (-up, -down)


def test_long_runs_and_large_ratios_are_printed_without_a_power_of_ten() -> None:
    assert (round_digits(123.4), round_digits(1234.5, 3), round_digits(0.057)) == ("120", "1230", "0.057")


class _Wide:
    """A table of many columns, two of which have the same name."""

    def __str__(self) -> str:
        names = ["case", "force", *(f"quantity {index}" for index in range(40)), "force"]
        return table(names, [["first", "1 N", *("5" for _ in range(40)), "2 N"]], names[1:])


def test_the_columns_without_room_are_named_in_one_line() -> None:
    *_, row, last = render_on_screen(_Wide(), columns=80).splitlines()
    assert "1 N" in row
    assert re.fullmatch(r"  \(not shown: quantity \d, .* \.\.\.; --wide shows all columns\)", last)
    assert len(last) <= 80


@pytest.mark.parametrize("part", ["11.6 N", "13.5 us", "5.2 mN s", "83 %", "7810 kg/m^3", "1.896 GPa"])
def test_a_number_and_its_unit_stay_on_one_line(part: str) -> None:
    assert all(part in "\n".join(paragraph("", f"{'x' * length} {part}")) for length in range(60, 80))


@pytest.mark.parametrize("label", ["", "  note: ", "  ! a long label "])
@pytest.mark.parametrize("indent", [0, 2, 12])
def test_no_line_of_a_paragraph_is_wider_than_the_screen(label: str, indent: int) -> None:
    text = "/a/path/" + 120 * "x" + " " + 40 * "word "
    first, *others = paragraph(label, text, indent)
    assert first.startswith(f"{label}/a/path/")
    assert {line[: indent + 1].rstrip("xword") for line in others} == {" " * indent}
    assert max(map(len, (first, *others))) == 80


@pytest.mark.parametrize(
    ("error", "shown"),
    [
        (None, "-"),
        (2e-4, "+2.0e-04"),
        (-0.1234, "-12.3 %"),
        (9.99, "+999.0 %"),
        (12.4, "factor 13"),
        (1305.76, "factor 1300"),
    ],
)
def test_relative_errors_above_ten_are_factors(error: float | None, shown: str) -> None:
    assert error_text(error) == shown
