"""Force records as text files: headers, units, errors with their lines; `test_record_styles` has whole files."""

from __future__ import annotations

import re
import time
import tracemalloc
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shockwave.base.errors import FileAccessError, InvalidValueError, ShockwaveError
from shockwave.records.record_file import Record, read_record
from shockwave.records.record_format import RecordFormat

TIMES = [0.0, 0.5, 1.0, 2.5]
FORCES = [0.0, 2.0, 1.25, 0.0]


@pytest.fixture
def read(tmp_path):
    def read_text(text: str | bytes, **keys: object) -> Record:
        path = tmp_path / "pulse.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_record(path, RecordFormat(**keys))

    return read_text


def rows(separator=",", decimal=".", end="\n"):
    pairs = zip(TIMES, FORCES, strict=True)
    return end.join(f"{t}{separator}{f}".replace(".", decimal) for t, f in pairs) + end


def assert_pulse(record, time_unit=1.0, force_unit=1.0):
    # One multiplication by the size of the unit, so one rounding.
    np.testing.assert_allclose(record.times, np.multiply(TIMES, time_unit), rtol=3e-16)
    np.testing.assert_allclose(record.forces, np.multiply(FORCES, force_unit), rtol=3e-16)


def faults_of(read, text, **keys):
    with pytest.raises(InvalidValueError) as caught:
        read(text, **keys)
    return [str(fault).partition("pulse.csv")[2] for fault in caught.value.faults]


# ---------------------------------------------------------------- layout


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
    assert_pulse(read(mark + rows(end=end).encode(), unit="N", time_unit="s"))


# ---------------------------------------------------------------- header


@pytest.mark.parametrize(
    ("header", "separator", "time_unit", "force_unit"),
    [
        ("(s),F (filtered) [kN]", ",", 1.0, 1e3),
        ("Time/us, Load/lbf", ",", 1e-6, 4.4482216152605),
        ("t / ms  F / N", " ", 1e-3, 1.0),
        ("Time (Seconds),Force (kg*m/s^2)", ",", 1.0, 1.0),
    ],
    ids=lambda value: value if isinstance(value, str) and len(value) > 1 else "",
)
def test_units_of_the_header_are_converted(read, header, separator, time_unit, force_unit):
    record = read(f"{header}\n{rows(separator)}")
    assert_pulse(record, time_unit, force_unit)
    assert record.notes == ()


COMMA = rows()
HEADER = "time [s],force [N]\n"
MANY = "".join(f"1,{t},20,{f}\n" for t, f in zip(TIMES, FORCES, strict=True))
LAYOUTS = {
    "comments": f"# hammer\n# time [ms], force [kN]\n{HEADER}{COMMA}",
    "many": f"no,Time [s],T [K],Load cell [N]\n{MANY}",
    "one-separator-at-an-end": HEADER + COMMA.replace("1.25", "1.25,"),
    "no-break-space": "time [s],force\xa0[N]\n" + COMMA,
}


@pytest.mark.parametrize("text", LAYOUTS.values(), ids=LAYOUTS)
def test_a_header_that_states_both_units_needs_no_key(read, text):
    record = read(text)
    assert_pulse(record)
    assert record.notes == ()


def test_an_error_shows_the_columns_that_can_be_chosen_with_their_names(read):
    (fault,) = faults_of(read, "t [s],Fx [N],x [mm],Fz [N]\n0,0,0,0\n")
    assert "columns: [1, 2] Fx [N] or columns: [1, 4] Fz [N]" in fault
    (fault,) = faults_of(read, "t [s],Fx [N],Fz [N]\n0,0,0\n", interval=1.0)
    assert "columns: [2] Fx [N] or columns: [3] Fz [N]" in fault


@pytest.mark.parametrize(
    ("text", "keys", "columns"),
    [
        ("ch1 [N],ch2 [N]\n0,0\n", {"interval": 1.0}, "[2]"),
        ("ch1 [N],ch2\n0,0\n", {"interval": 1.0}, "[2]"),
        ("0,0\n", {"interval": 1.0, "unit": "N"}, "[2]"),
        ("time [us],preload [N],force\n0,0,0\n", {}, "[1, 3]"),
        ("time [us],force,preload [N]\n0,0,0\n", {}, "[1, 3]"),
    ],
    ids=["units", "one-unit", "no-header", "plain-last", "plain-before"],
)
def test_one_of_several_columns_of_values_is_never_chosen_silently(read, text, keys, columns):
    (fault,) = faults_of(read, text, **keys)
    assert "columns: must be the columns" in fault
    assert f"columns: {columns}" in fault


@pytest.mark.parametrize("label", ["F [N] (kN)", "F [N, mean]"])
def test_a_label_without_one_unit_states_none(read, label):
    assert "unit: N makes the greatest value 2 N" in faults_of(read, f"t [s];{label}\n{rows(';')}")[0]
    assert_pulse(read(f"t [s];{label}\n{rows(';')}", unit="N"))


@pytest.mark.parametrize("label", ["T [Nm]", "F [%]", "F [kg]"])
def test_a_unit_of_another_dimension_needs_a_scale_per_that_unit(read, label):
    text, of = f"t [s];{label}\n{rows(';')}", re.split(r"[\[(\])]", label)[1]
    assert f"set unit: N, and scale to the N per {of})" in faults_of(read, text, unit="N")[0]
    record = read(text, unit="N", scale=0.1)
    assert_pulse(record, 1.0, 0.1)
    assert f"scale, 0.1 N per {of}." in record.notes[-1]


@pytest.mark.parametrize(("label", "unit"), [("F [KN]", "kN"), ("F [Mn]", "MN"), ("F [foo]", "N")])
def test_a_unit_in_the_wrong_case_is_proposed_as_it_is_spelt(read, label, unit):
    with pytest.raises(InvalidValueError, match=f"unit: {unit} makes the greatest value 3 {unit};"):
        read(f"t [us],{label}\n0,0\n1,3\n2,0\n")


def test_a_unit_in_place_of_that_of_the_header_is_a_note(read):
    notes = read(f"time [us],F [kN]\n{COMMA}", time_unit="ms", unit="N").notes
    assert [note.startswith("The file states the unit ") for note in notes] == [True, True]


#: Files whose units are not stated, and the keys that the errors propose.
UNSTATED = {
    "no-header": (COMMA, ["time_unit: ms makes the record 2.5 ms long", "unit: N"]),
    "one-unit": (f"time [s],CH1\n{COMMA}", ["unit: N makes the greatest value 2 N"]),
    "microseconds": ("t,F [N]\n0,0\n300,2\n700,0\n", ["time_unit: us makes the record 700 us long"]),
}


@pytest.mark.parametrize(("text", "proposals"), UNSTATED.values(), ids=UNSTATED)
def test_a_unit_that_the_header_does_not_state_is_asked_for_with_a_proposal(read, text, proposals):
    faults = faults_of(read, text)
    assert len(faults) == len(proposals)
    assert all(proposal in fault for proposal, fault in zip(proposals, faults, strict=True))


#: Headers of columns that are not known to be seconds and newtons, and the key that the error names.
DOUBTFUL = {
    "time_ms,overpressure_kPa": "set area",
    "time [s],Überdruck": "unit: N",
    "time [ms],a [m/s²]": "set mass",
    "t_ms,acc_g": "set mass",
    "time [s],CH1 [V]": "set unit: N, and scale to the N per V",
    "time [s],load_tonnes": "unit: N makes",
    "displacement_mm,force_kN": "time_unit: ms",
    "time [mS],force_kN": "time_unit: ms",
}


@pytest.mark.parametrize("header", DOUBTFUL)
def test_a_column_of_another_quantity_is_never_read_as_seconds_or_newtons(read, header):
    (fault,) = faults_of(read, f"{header}\n{COMMA}")
    assert fault.startswith((":1: unit: ", ":1: time_unit: "))
    assert DOUBTFUL[header] in fault


@pytest.mark.parametrize(
    ("header", "keys", "remedy"),
    [
        ("time [s],p [kPa]", {"mass": 2.0}, "delete mass"),
        ("time [s],force [N]", {"area": 1e-3}, "delete area"),
        ("time [s],a [g]", {"unit": "N"}, "set mass"),
        ("time [s],force [N]", {"unit": "kPa"}, "set area"),
        ("force [N],time", {"time_unit": "s"}, "must be a unit of time (got 'force [N]' and 's'"),
        ("time [s],CH1 [V]", {"scale": 2.0}, "set unit: N, and scale"),
    ],
    ids=lambda value: value if isinstance(value, str) else "-".join(value),
)
def test_a_key_that_contradicts_the_header_is_refused(read, header, keys, remedy):
    columns = {"columns": [1, 2]} if "time_unit" in keys else {}
    assert remedy in faults_of(read, f"{header}\n{COMMA}", **keys, **columns)[0]


@pytest.mark.parametrize("header", ["us;V", "t (us);CH1 (mV)", "us;Volt"])
def test_a_scale_is_per_unit_of_the_header(read, header):
    record = read(f"{header}\n{rows(';')}", unit="N", scale=450)
    np.testing.assert_allclose(record.forces, np.multiply(FORCES, 450), rtol=1e-15)


def test_three_digits_behind_every_point_may_be_thousands(read):
    text = "t [s] F [N]\n0 0\n1 1.250\n2 0\n"
    (fault,) = faults_of(read, text)
    assert fault.startswith(":2: decimal: must be stated")
    assert "decimal: '" not in fault
    assert read(text, decimal=".").forces.max() == read(text.replace("1.250", "1.25")).forces.max() == 1.25


def test_a_comma_in_quotes_is_part_of_its_number(read):
    text = 'time [s],force [N]\n"0,0","0,0"\n"0,5","1,5"\n"1","0"\n'
    assert "set decimal: ','" in faults_of(read, text)[0]
    assert read(text, decimal=",").forces.tolist() == [0.0, 1.5, 0.0]


def test_times_that_floats_cannot_hold_are_counted_from_the_first_sample(read):
    ns = [1_599_999_999_999_999_000 + 1000 * step for step in range(4)]
    record = read("time [ns],force [N]\n" + "".join(f"{t},{f}\n" for t, f in zip(ns, FORCES, strict=True)))
    # one multiplication by the unit
    assert record.times.tolist() == pytest.approx([0, 1e-6, 2e-6, 3e-6], rel=1e-15)
    assert "count from the first sample" in record.notes[0]
    seconds = "time [s];force [N]\n1600000000,000001;0\n1600000000,000002;1\n1600000000,000004;0\n"
    assert read(seconds, decimal=",").times.tolist() == pytest.approx([0, 1e-6, 3e-6], rel=1e-15)


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"area": 1.0, "mass": 1.0}, "mass: must be left out if area is given"),
        ({"sign": 2}, "sign: must be 1 or -1"),
        ({"encoding": "ebcdic"}, "encoding: must be None, utf-8, utf-16 or cp1252"),
        ({"interval": 0}, "interval: must be > 0 s"),
    ],
    ids=["area-and-mass", "sign", "encoding", "interval"],
)
def test_settings_that_are_wrong_are_refused(settings, sentence):
    with pytest.raises(InvalidValueError, match=f"^{sentence}"):
        RecordFormat(**settings)


NUMBERS = "row: must be finite numbers, in at most 2 columns (got"
#: The text, and how the error begins after the name of the file, with its remedy.
REFUSED: dict[str, tuple[str, str, str]] = {
    "hostile": (f"time [9**9**9**9],force [N]\n{COMMA}", ":1: time_unit: must be a unit of time (got 'time [9**9", ""),
    "names-and-numbers": (f"time,5\n{COMMA}", ":1: skip_rows: must leave one line", "skip_rows: 1 skips it"),
    "few-names": (f"time [s]\n{rows(';')}", ":1: skip_rows: must leave one line", "name all columns in line 1"),
    "no-header": ("0,1,2\n1,2,3\n", ":1: columns: must be the columns", "columns: [1, 2]"),
    "decimal-comma": ("0,5 1,5\n", ":1: decimal: must not be a comma", "set decimal: ','"),
    "decimal-commas": (f"{HEADER.replace(',', ';')}0,5;1,5\n", f":2: {NUMBERS} '0,5;1,5'", "set decimal: ','"),
    "long-line": (f"{HEADER}0,0\n" + "1," * 20_000, ": must have lines of at most 10000 characters", ""),
    "empty": ("", ": columns: must be a time and a force in each row", ""),
    "word": (f"# c\n\n{HEADER}0,0\n1,x\n", f":5: {NUMBERS} '1,x', one of 1;", "correct or delete"),
    "short": (f"{HEADER}0,0\n1\n", f":3: {NUMBERS} '1'", "correct or delete"),
    "long": (f"{HEADER}0,0\n0,001,5\n", f":3: {NUMBERS} '0,001,5'", "correct or delete"),
    "nan-first": (f"{HEADER}nan,1\nnan,1\n0,0\n", f":2: {NUMBERS} 'nan,1', one of 2;", "delete lines 2 to 3"),
    "overflow": (f"{HEADER}0,0\n1,1e999\n", f":3: {NUMBERS} '1,1e999'", "correct or delete"),
    "underscore": (f"{HEADER}0,0\n1_0,1\n", f":3: {NUMBERS} '1_0,1'", "correct or delete"),
}


@pytest.mark.parametrize(("text", "error", "remedy"), REFUSED.values(), ids=REFUSED)
def test_one_error_names_the_first_wrong_line_and_a_remedy(read, text, error, remedy):
    fault, *others = faults_of(read, text)
    assert fault.startswith(error)
    assert remedy in fault
    assert not others or error.startswith(":1: time_unit")


def test_many_wrong_rows_are_one_error_in_seconds(read):
    start = time.process_time()
    (fault,) = faults_of(read, HEADER + "0,0\n" + "x,y\n" * 30_000)
    assert "one of 30000;" in fault
    # 0.2 s; with an error for each row two
    assert time.process_time() - start < 1


def test_long_comments_and_labels_take_no_time(read):
    start = time.process_time()
    comments = ("# " + "a [" * 3_000 + "\n") * 300
    assert_pulse(read(comments + HEADER + COMMA))
    faults_of(read, f"time [s],{'a ' * 4_000}[N]\n{COMMA}")
    faults_of(read, f"time{' ' * 9_900}force\n{rows(' ')}")
    # milliseconds; with a search for labels of any length minutes
    assert time.process_time() - start < 5


def test_blank_lines_take_no_memory(read):
    tracemalloc.start()
    faults_of(read, "\n" * 2**19)
    # the buffer of the largest file, 128 MiB; a list of all lines would take 100 bytes for each
    assert tracemalloc.get_traced_memory()[1] < 160 * 2**20
    tracemalloc.stop()


# ---------------------------------------------------------------- files


@pytest.mark.parametrize(("name", "sentence"), [("none.csv", "cannot be read"), ("", "is not a file")])
def test_a_path_that_cannot_be_read_is_reported(tmp_path, name, sentence):
    with pytest.raises(FileAccessError, match=sentence):
        read_record(tmp_path / name)


def test_a_file_in_no_known_encoding_names_byte_and_line(read):
    with pytest.raises(FileAccessError, match="got the byte 0x81 in line 2; many instruments need encoding: cp1252"):
        read(b"# c\ntime [\x81s], force [N]\n0,0\n")
    with pytest.raises(FileAccessError, match="got a zero byte; encoding: utf-16 has them"):
        read((HEADER + COMMA).encode("utf-16-le"))


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
