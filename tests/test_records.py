"""Force records as text files: separators, units, headers, errors with their lines."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shockwave.errors import FileAccessError, InvalidValueError, ShockwaveError
from shockwave.profiles.record_file import Record, read_record
from shockwave.profiles.record_format import RecordFormat

pytestmark = pytest.mark.numerical

TIMES = [0.0, 0.5, 1.0, 2.5]
FORCES = [0.0, 2.0, 1.25, 0.0]


@pytest.fixture
def read(tmp_path):
    def read_text(text: str | bytes) -> Record:
        path = tmp_path / "pulse.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_record(path)

    return read_text


def rows(separator=",", decimal=".", end="\n"):
    pairs = zip(TIMES, FORCES, strict=True)
    return end.join(f"{t}{separator}{f}".replace(".", decimal) for t, f in pairs) + end


def assert_pulse(record, time_unit=1.0, force_unit=1.0):
    # One multiplication by the size of the unit, so one rounding.
    np.testing.assert_allclose(record.times, np.multiply(TIMES, time_unit), rtol=3e-16)
    np.testing.assert_allclose(record.forces, np.multiply(FORCES, force_unit), rtol=3e-16)


def faults_of(read, text):
    with pytest.raises(InvalidValueError) as caught:
        read(text)
    return [str(fault).partition("pulse.csv")[2] for fault in caught.value.faults]


# ---------------------------------------------------------------- layout


@pytest.mark.parametrize(
    ("separator", "decimal"),
    [(", ", "."), (";", "."), ("\t", "."), ("   ", "."), (";", ","), ("\t", ",")],
    ids=["comma", "semicolon", "tab", "blanks", "semicolon-decimal", "tab-decimal"],
)
def test_every_separator_is_found(read, separator, decimal):
    record = read("time [s], force [N]\n" + rows(separator, decimal))
    assert_pulse(record)
    assert record.notes == ()


@pytest.mark.parametrize("mark", ["#", "%", "//", "  # "], ids=["hash", "percent", "slashes", "inset"])
def test_comments_and_blank_lines_are_allowed_anywhere(read, mark):
    lines = rows().splitlines()
    text = f"{mark} made in 1.5 h\n\ntime [s], force [N]\n{lines[0]}\n{mark} x\n \t\n" + "\n".join(lines[1:]) + "\n\n"
    record = read(text)
    assert_pulse(record)
    assert record.lines.tolist() == [4, 7, 8, 9]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"], ids=["lf", "crlf", "cr"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"], ids=["plain", "byte-order-mark"])
def test_line_ends_and_byte_order_marks_do_not_matter(read, end, mark):
    assert_pulse(read(mark + f"ms,N{end}{rows(end=end)}".encode()), 1e-3)
    assert_pulse(read(mark + rows(end=end).encode()))


# ---------------------------------------------------------------- header


@pytest.mark.parametrize(
    ("header", "separator", "time_unit", "force_unit"),
    [
        ("time [us], force [kN]", ",", 1e-6, 1e3),
        ("Time/us, Load/lbf", ",", 1e-6, 4.4482216152605),
        ("time [ms]  force [mN]", " ", 1e-3, 1e-3),
        ("t / ms  F / N", " ", 1e-3, 1.0),
        ("time_ms,force_kN", ",", 1e-3, 1e3),
        ("Time (Seconds),Force (kg*m/s^2)", ",", 1.0, 1.0),
        ("ms,N", ",", 1e-3, 1.0),
    ],
    ids=lambda value: value if isinstance(value, str) and len(value) > 1 else "",
)
def test_units_of_the_header_are_converted(read, header, separator, time_unit, force_unit):
    record = read(f"{header}\n{rows(separator)}")
    assert_pulse(record, time_unit, force_unit)
    assert record.notes == ()


COMMA = rows()
SWAPPED = "".join(f"{f},{t}\n" for t, f in zip(TIMES, FORCES, strict=True))
MANY = "".join(f"1,{t},20,{f}\n" for t, f in zip(TIMES, FORCES, strict=True))
NO_TIME = (
    "The time column has no unit: seconds are assumed. A header such as 'time [s]', or time_unit, states the unit."
)
NO_FORCE = "The force column has no unit: newtons are assumed. A header such as 'force [N]', or unit, states the unit."
NOTED: dict[str, tuple[str, list[str]]] = {
    "no-header": (COMMA, [NO_TIME, NO_FORCE]),
    "comment": (
        f"# hammer\n# time [s], force [N]\n{COMMA}",
        ["The column names were read from the comment in line 2."],
    ),
    "swapped": (f"force [N],time [s]\n{SWAPPED}", ["The time column is 'time', the force column 'force'."]),
    "many": (f"no,Time [s],K,Load cell [N]\n{MANY}", ["The time column is 'Time', the force column 'Load cell'."]),
    "names": (f"A [s],B [N]\n{COMMA}", ["The time column is 'A', the force column 'B'."]),
    "quotes": ('"time [s]","force [N]",\n"0","0",\n"0.5","2",\n"1","1.25",\n"2.5","0",\n', []),
    "empty-last-cells": ("time [s]\tforce [N]\tComment\n" + rows("\t").replace("\n", "\t\n"), []),
    "one-separator-at-an-end": ("time [s],force [N]\n" + COMMA.replace("1.25", "1.25,"), []),
}


@pytest.mark.parametrize(("text", "notes"), NOTED.values(), ids=NOTED)
def test_assumptions_are_noted(read, text, notes):
    record = read(text)
    assert_pulse(record)
    assert list(record.notes) == notes


#: Text above the numbers whose units are in a comment, and the separator of the rows.
COMMENTED = {
    "further-comment": ("# time [ms], force [kN]\n# recorded 2024", ","),
    "units-alone": ("# ms, kN", ","),
    "unknown-name": ("# time [ms], signal [kN]", ","),
    "list": ("# Columns: time [ms] force [kN]", " "),
    "below-the-header": ("time;force\n# ms;kN", ";"),
    "above-the-header": ("# time [ms], force [kN]\nt,F", ","),
    "one-unit": ("time [ms],force\n# ms,kN", ","),
}


@pytest.mark.parametrize(("head", "separator"), COMMENTED.values(), ids=COMMENTED)
def test_units_in_a_comment_are_used(read, head, separator):
    record = read(f"{head}\n{rows(separator)}")
    assert_pulse(record, 1e-3, 1e3)
    assert any("read from the comment in line" in note for note in record.notes)


#: Comments that state units of other quantities, or of columns that cannot be assigned, and a word of the error.
UNUSABLE = {
    "# time_ms, acceleration_g": "set mass",
    "# t/ms; pressure/kPa": "set area",
    "# time [ms]  voltage [V]": "set unit",
    "#,Force [kN]": "set unit and time_unit",
    "#,Force [N]": "set unit and time_unit",
    "# time [ms], force [kN], remark": "set unit and time_unit",
    "# ms;kN;-": "set unit and time_unit",
    "# units: kN": "set unit and time_unit",
    "# force in kN": "set unit and time_unit",
    "time,force\n# blow, force [kN]": "set unit and time_unit",
    "force,time\n# time [ms], force [kN]": "set time_unit",
}


@pytest.mark.parametrize("head", UNUSABLE)
def test_a_comment_that_states_a_unit_is_never_ignored(read, head):
    assert UNUSABLE[head] in faults_of(read, f"{head}\n{COMMA}")[0]


def test_stated_units_settle_a_comment(tmp_path):
    path = tmp_path / "pulse.csv"
    path.write_text(f"# no, force [kN]\n{COMMA}")
    assert_pulse(read_record(path, RecordFormat(time_unit="ms", unit="N")), 1e-3)


@pytest.mark.parametrize(
    "comment",
    [
        "recorded 2024-03-01, hammer 2",
        "load cell 3, channel B",
        "peak 850 N, rise 48 us",
        "sensitivity 2.3 mV/N",
        "sampling: 10 us, max: 5 kN",
        "max force 5 kN",
        "5 ms to 6 ms, 5 kN",
        "1e-6 s, 100 kS/s",
        "force in N",
        "0, 0.5",
        "low-pass filter (10 kHz)",
        "",
        ",",
    ],
)
def test_an_ordinary_comment_is_ignored(read, comment):
    record = read(f"# {comment}\n# end\n{COMMA}")
    assert_pulse(record)
    assert record.notes == (NO_TIME, NO_FORCE)


#: Headers of columns that are not known to be seconds and newtons, and the key that the error names.
DOUBTFUL = {
    "time_ms,overpressure_kPa": "set area",
    "time [s],p [bar]": "set area",
    "time [s],Überdruck": "set area",
    "time [ms],a [m/s²]": "set mass",
    "t_ms,acc_g": "set mass",
    "time [s],Beschleunigung": "set mass",
    "time [s],CH1": "set unit",
    "time [s],CH1 [V]": "set unit",
    "time [s],load_tonnes": "set unit",
    "time [s],force [kg]": "set unit",
    "time_usec,force [N]": "set time_unit",
    "displacement_mm,force_kN": "set time_unit",
}


@pytest.mark.parametrize("header", DOUBTFUL)
def test_a_column_of_another_quantity_is_never_read_as_seconds_or_newtons(read, header):
    (fault,) = faults_of(read, f"{header}\n{COMMA}")
    assert fault.startswith(":1: unit of ")
    assert DOUBTFUL[header] in fault


@pytest.mark.parametrize(
    ("header", "key", "value"),
    [("time [s],p [kPa]", "mass", 2.0), ("time [s],force [N]", "area", 1e-3), ("time [s],a [g]", "unit", "N")],
    ids=["pressure-as-acceleration", "force-as-pressure", "acceleration-as-newtons"],
)
def test_a_key_that_contradicts_the_header_is_refused(tmp_path, header, key, value):
    path = tmp_path / "pulse.csv"
    path.write_text(f"{header}\n{COMMA}")
    with pytest.raises(InvalidValueError, match="must be that of a"):
        read_record(path, RecordFormat(**{key: value}))


@pytest.mark.parametrize(
    ("header", "unit", "got"),
    [
        ("time [s],p [kPa]", "N", r"got 'kPa' in the header, although unit is N; set area"),
        ("time [s],force [N]", "kPa", "got unit kPa; set area"),
    ],
    ids=["header", "key"],
)
def test_a_pressure_beside_a_unit_of_force_needs_the_area(tmp_path, header, unit, got):
    path = tmp_path / "pulse.csv"
    path.write_text(f"{header}\n{COMMA}")
    with pytest.raises(InvalidValueError, match=got):
        read_record(path, RecordFormat(unit=unit))


@pytest.mark.parametrize(("header", "volts"), [("us;V", 1.0), ("(us);(mV)", 1e-3), ("us;Volt", 1.0)])
def test_a_scale_is_per_volt(tmp_path, header, volts):
    path = tmp_path / "pulse.csv"
    path.write_text(f"{header}\n{rows(';')}")
    record = read_record(path, RecordFormat(unit="N", scale=450))
    np.testing.assert_allclose(record.forces, np.multiply(FORCES, 450 * volts), rtol=1e-15)
    assert any("converted to volts" in note for note in record.notes) == (volts != 1)
    with pytest.raises(InvalidValueError, match="set scale, the number of N per V"):
        read_record(path, RecordFormat(unit="N"))


def test_a_thousands_group_does_not_begin_with_zero(tmp_path):
    path = tmp_path / "pulse.csv"
    path.write_text('"0,000","0,000"\n"0,050","0,156"\n"0,060","0,000"\n')
    for form in (RecordFormat(), RecordFormat(thousands=",")):
        with pytest.raises(InvalidValueError, match=r"got '0,050'; set decimal: ','\)"):
            read_record(path, form)
    assert read_record(path, RecordFormat(decimal=",")).forces.tolist() == [0.0, 0.156, 0.0]
    path.write_text('"0","0"\n"1","1,156"\n"2","0"\n')
    with pytest.raises(InvalidValueError, match=r"set decimal: ',' or thousands: ',' if it is a thousands mark"):
        read_record(path)
    assert read_record(path, RecordFormat(thousands=",")).forces.tolist() == [0.0, 1156.0, 0.0]


def test_a_skipped_header_is_not_replaced_by_assumptions(tmp_path):
    path = tmp_path / "pulse.csv"
    path.write_text(f"Points,3\ntime [ms],force [kN]\n{COMMA}")
    assert not read_record(path, RecordFormat(skip_rows=1)).notes
    with pytest.raises(InvalidValueError) as refused:
        read_record(path, RecordFormat(skip_rows=2))
    assert [fault.path for fault in refused.value.faults] == ["unit of time", "unit of force"]
    assert "skip fewer, or set time_unit" in str(refused.value)
    assert read_record(path, RecordFormat(skip_rows=2, time_unit="ms", unit="kN")).notes == ()


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"area": 1.0, "mass": 1.0}, "mass: must be left out if area is given"),
        ({"decimal": ",", "thousands": ","}, "thousands: must not be the decimal sign"),
        ({"sign": 2}, "sign: must be 1 or -1"),
        ({"columns": [1]}, "columns: must be two names or numbers"),
        ({"encoding": "ebcdic"}, "encoding: must be None, utf-8, utf-16, cp1252 or latin-1"),
        ({"unit": 5}, "unit: must be a unit in quotes"),
        ({"time_unit": 5}, "time_unit: must be a unit in quotes"),
    ],
    ids=["area-and-mass", "marks", "sign", "one-column", "encoding", "unit", "time-unit"],
)
def test_settings_that_are_wrong_are_refused(settings, sentence):
    with pytest.raises(InvalidValueError, match=f"^{sentence}"):
        RecordFormat(**settings)


def test_numbers_can_stand_behind_settings(tmp_path):
    path = tmp_path / "pulse.csv"
    lines = rows().splitlines()
    path.write_text(f"Record Length,4,,{lines[0]}\n# 1,2,3,4,5\nUnit,s,,{lines[1]}\n,,,{lines[2]}\n,,,{lines[3]}\n")
    assert_pulse(read_record(path, RecordFormat(columns=[4, 5])))


def test_an_encoding_is_known_in_any_case():
    assert RecordFormat(encoding="UTF-8").encoding == "utf-8"


NUMBER = "must be a finite number of"
#: The text, and how each error begins after the name of the file.
REFUSED: dict[str, tuple[str, list[str]]] = {
    "dimensions": (f"#\ntime [N],force [s]\n{COMMA}", [":2: unit of time: ", ":2: unit of force: "]),
    "volts": (f"time [ms],force [V]\n{COMMA}", [":1: unit of force: must be a unit of force (got 'V'"]),
    "hostile": (f"time [9**9**9**9],force [N]\n{COMMA}", [":1: unit of time: must be a unit of time (got '9**9"]),
    "three-names": (f"time,force,x\n{COMMA}", [":1: header: must name every column (got 3 names; line 2 has 2"]),
    "number": (f"time,5\n{COMMA}", [":1: row: must be either column names or numbers, not both (got 'time,5')"]),
    "preamble": (f"made by A. Smith\ntime,force\n{COMMA}", [":2: row: must be numbers: only one header line"]),
    "two-times": (
        f"time,t\n{COMMA}",
        [":2: columns: must include one time and one force column (got 2 columns: 'time', 't'"],
    ),
    "no-header": (
        "0,1,2\n1,2,3\n",
        [":1: columns: must include one time and one force column (got 3 columns: no header"],
    ),
    "thousands-or-decimals": (
        "t [s];F [N]\n0;0\n1;1.250\n2;0\n",
        [":3: decimal: must be given, because all numbers have three digits after their marks (got '1.250'; set"],
    ),
    "thousands": ("0;0\n0,5;1.250,5\n", [f":2: force: {NUMBER} N (got '1.250,5'; set thousands: '.'"]),
    "unknown-unit": (f"time [s],[V]\n{COMMA}", [":1: unit of force: must be a unit of force (got 'V'; set unit"]),
    "metadata": (
        f"Model,X\nPoints,4\nt [s],F [N]\n{COMMA}",
        [":2: row: must be numbers: only one header line is allowed (got 'Points,4'; to skip what is above it set"],
    ),
    "decimal-comma": (
        "0,5 1,5\n",
        [":1: columns: must include one time and one force column (got 3 columns: no header"],
    ),
    "two-decimal-signs": ("0;0\n0,5;1\n1;1.0\n", [f":3: force: {NUMBER} N (got '1.0'; set decimal"]),
    "long-line": ("0,0\n" + "1," * 20_000, [":2: row: must have at most 10000 characters (got 40000)"]),
    "empty": ("", [": rows: must be numbers, with a time and a force"]),
    "word": ("# c\n\n0,0\n1,x\n", [f":4: force: {NUMBER} N (got 'x'; correct or delete the row)"]),
    "short": ("0,0\n1\n", [":2: row: must have 2 columns (got 1: '1'"]),
    "long": (
        "0,0\n0,001,5\n",
        [":2: row: must have 2 columns (got 3: '0,001,5'; if the comma is the decimal separator"],
    ),
    "nan": ("0,0\nnan,1\n", [f":2: time: {NUMBER} s (got 'nan'; "]),
    "overflow": ("0,0\n1,1e999\n", [f":2: force: {NUMBER} N (got '1e999'; "]),
    "underscore": ("0,0\n1_0,1\n", [f":2: time: {NUMBER} s (got '1_0'; "]),
    "every-kind": ("0,0\nx,1\n2\n3,y\n4,0\n", [":2: time: ", ":3: row: ", ":4: force: "]),
}


@pytest.mark.parametrize(("text", "faults"), REFUSED.values(), ids=REFUSED)
def test_every_error_is_named_with_its_line(read, text, faults):
    found = faults_of(read, text)
    assert len(found) == len(faults)
    assert all(fault.startswith(expected) for fault, expected in zip(found, faults, strict=True))


def test_at_most_twenty_bad_rows_are_listed(read):
    assert len(faults_of(read, "0,0\n" + "x,y\n" * 1000)) == 20


# ---------------------------------------------------------------- files


@pytest.mark.parametrize(("name", "sentence"), [("none.csv", "cannot be read"), ("", "is not a file")])
def test_a_path_that_cannot_be_read_is_reported(tmp_path, name, sentence):
    with pytest.raises(FileAccessError, match=sentence):
        read_record(tmp_path / name)


def test_a_file_in_no_known_encoding_names_byte_and_line(read):
    with pytest.raises(FileAccessError, match="got the byte 0x81 in line 2; set encoding, or save it as UTF-8"):
        read(b"# c\ntime [\x81s], force [N]\n0,0\n")


# ---------------------------------------------------------------- anything at all


WORDS = ["time", "force", "t", "F", "[us]", "(kN)", "s^9", "0", "1.5", "1,5", "-2", "nan", "1e999", "٣", "//"]
PIECES = st.sampled_from([*WORDS, *'/,;\t \n\r#%"[)_µ\x00\x85\u2028\ufeff'])


@settings(derandomize=True, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.binary(max_size=200) | st.lists(PIECES, max_size=40).map(lambda words: "".join(words).encode()))
def test_any_bytes_give_a_record_or_an_error_of_our_own(read, data):
    with suppress(ShockwaveError):
        record = read(data)
        assert record.times.shape == record.forces.shape == record.lines.shape
        assert np.isfinite(record.times).all()
        assert np.isfinite(record.forces).all()
