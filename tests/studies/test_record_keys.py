"""Proposed keys of record files: those of exports of instruments, what stays a guess, and what the command writes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot

import shockwave as sw
from shockwave.cli import main
from shockwave.studies.record_keys import propose_keys
from support.command_line import unwrapped
from support.record_styles import IMPULSE, PEAK, RISE, sharp, styles

#: Files that keys can make right; a load in grams is taken for an acceleration.
STYLES = {name: style for name, style in styles().items() if not (style.lost or style.remedy) and name != "grams"}


@pytest.mark.parametrize("name", STYLES)
def test_the_record_is_right_once_guesses_are_replaced(tmp_path: Path, name: str) -> None:
    style, file = STYLES[name], tmp_path / "pulse.csv"
    file.write_bytes(style.content)
    keys = propose_keys(file).parameters | style.keys
    pulse = sw.Tabulated.from_file(file, **keys)
    assert list(pulse.figures.values()) == pytest.approx([PEAK, RISE, IMPULSE], rel=0.01)


#: Times [s] and values of a blow, one for 100 N, on an offset and noise.
TIMES = 1e-6 * np.arange(-50, 350)
VALUES = sharp(1e6 * TIMES) / PEAK + 0.02 + np.random.default_rng(3).normal(0, 2e-4, TIMES.size)


def rows(form: str, values: object = VALUES, times: object = TIMES) -> str:
    return "".join(form.format(*row) + "\n" for row in zip(times, values, strict=True))  # type: ignore[call-overload]


def comma(text: str) -> str:
    return text.replace(".", ",")


TEK = ["Record Length,4.0e+02", "Sample Interval,1e-06", "Trigger Point,5e+01", ",", "Source,CH1", "Vertical Units,V"]
LVM = "LabVIEW Measurement\t\nSeparator\tTab\nDate\t2024/11/05\n***End_of_Header***\t\nDelta_X\t1.0E-6\t\n"
#: Exports, and the keys that stay guesses.
EXPORTS: dict[str, tuple[str, set[str]]] = {
    "tektronix-mso": (
        "Model,MSO24\nSample Interval,1e-06\nVertical Units,V\nLabel,\nTIME,CH1\n" + rows("{:.6e},{:.5f}"),
        {"time_unit", "unit"},
    ),
    "tektronix-tds": (
        "".join(
            f"{TEK[at] if at < len(TEK) else ','},,{time:017.12f},{value:10.5f},\n"
            for at, (time, value) in enumerate(zip(TIMES, VALUES, strict=True))
        ),
        {"time_unit", "unit"},
    ),
    "lecroy": (
        "LECROYWS3024,52345,Waveform\nSegments,1,SegmentSize,400\nSegment,TrigTime,TimeSinceSegment1\n"
        "#1,05-Nov-2024 10:12:11,0\nTime,Ampl\n" + rows("{:.6e},{:.5f}"),
        {"time_unit", "unit"},
    ),
    "rigol-ds1000": (
        "X,CH1,Start,Increment,\nSequence,Volt,-5.0e-05,1.0e-06\n" + rows("{},{:.5f},,", times=range(TIMES.size)),
        {"columns", "unit"},
    ),
    "rigol-mso5000": ("CH1V,t0 =-5.00e-05, tInc = 1.00e-06,\n" + rows("{1:.5e},"), {"unit"}),
    "keysight": ("x-axis,1\nsecond,Volt\n" + rows("{:.6e},{:.5f}"), {"scale"}),
    "picoscope": ("Time,Channel A\n(us),(mV)\n\n" + rows("{:.6f},{:.4f}", 1e3 * VALUES, 1e6 * TIMES), {"scale"}),
    "picoscope-german": ("Zeit;Kanal A\n(ms);(V)\n\n" + comma(rows("{:.6f};{:.5f}", times=1e3 * TIMES)), {"scale"}),
    "siglent": ("Record Length,Analog:400\nSource,CH1\nSecond,Volt\n" + rows("{:.6e},{:.5f}"), {"scale"}),
    "inverted": ("Modell;RTB-4\nZeit [s];Kanal 2 [V]\n" + comma(rows("{:.6e};{:.5f}", -VALUES)), {"scale"}),
    "labview": (
        f"{LVM}***End_of_Header***\t\t\nX_Value\tForce\tComment\n" + rows("{:.6f}\t{:.5f}"),
        {"time_unit", "unit"},
    ),
    "catman": ("Datei: a.bin\nZeit  1 - Standardmessrate [s]\tKraft [N]\n" + comma(rows("{:.6f}\t{:.5f}")), set()),
    "second-blow": (
        "t [us];F [N]\n"
        + rows("{:.0f};{:.4f}", np.concatenate([VALUES, 0.5 * VALUES]), np.arange(-50, 2 * TIMES.size - 50)),
        set(),
    ),
}


@pytest.mark.parametrize("name", EXPORTS)
def test_exports_of_instruments_are_read_but_for_what_they_do_not_state(tmp_path: Path, name: str) -> None:
    text, guesses = EXPORTS[name]
    (tmp_path / "pulse.csv").write_text(text)
    keys = propose_keys(tmp_path / "pulse.csv")
    assert keys.guesses.keys() == guesses
    assert keys.pulse is not None
    peak, rise, impulse = keys.pulse.values()
    # the millivolts of a file count as newtons
    unit = 1000 if name == "picoscope" else 1
    assert (peak / unit, rise, impulse / unit) == pytest.approx((1, RISE, IMPULSE / PEAK), rel=0.02)


#: Files that no key makes right, and what the message asks for.
REFUSED: dict[str, tuple[Callable[[list[str]], list[str]], str]] = {
    "nan": (
        lambda lines: [*lines[:99], "9.9e-05;NaN", *lines[100:]],
        "(got '9.9e-05;NaN', one of 1; correct or delete",
    ),
    "two-records": (lambda lines: lines + lines, "a second record begins here: keep one of them"),
    "words": (lambda lines: ["no", "numbers"], "got no line that begins with a number"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_no_key_makes_right_is_the_error_of_loading(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    change, message = REFUSED[name]
    lines = change(rows("{:.6e};{:.5f}").splitlines())
    (tmp_path / "pulse.csv").write_text("\n".join(["t [s];F [N]", *lines]))
    assert main(["record", str(tmp_path / "pulse.csv")]) == 3
    assert message in unwrapped(capsys.readouterr().out)


def test_the_effect_of_a_key_is_the_change_that_it_makes(tmp_path: Path) -> None:
    (tmp_path / "pulse.csv").write_text(EXPORTS["second-blow"][0])
    proposed = propose_keys(tmp_path / "pulse.csv")
    others = {"negative": "zero"} | {key: value for key, value in proposed.parameters.items() if key != "crop"}
    without = sw.Tabulated.from_file(tmp_path / "pulse.csv", **others).figures
    assert proposed.pulse is not None
    change = proposed.pulse["impulse"] / without["impulse"] - 1
    assert change < -0.2
    (line,) = [line for line in str(proposed).splitlines() if "crop:" in line]
    assert f"impulse {100 * change:+.2g} %" in line


def test_the_command_writes_a_scenario_and_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "records").mkdir()
    (tmp_path / "records" / "pulse.csv").write_text(EXPORTS["inverted"][0])
    assert main(["record", "records/pulse.csv", "-o", "scene.yaml", "--picture", "pulse.svg"]) == 0
    assert "scale: 1  # a guess: state the N per" in capsys.readouterr().out
    scene = sw.load_scenario("scene.yaml")
    assert scene.shock.peak_force == pytest.approx(1, rel=0.02)
    # results hold under the guess, and say so first
    assert str(sw.predict(scene)).startswith("scene, if 1 V is 1 N: ")
    assert (tmp_path / "pulse.svg").read_text().startswith("<?xml")
    # an existing scenario stays as it is, and one can name only files beside or below it
    assert main(["record", "records/pulse.csv", "-o", "scene.yaml"]) == 5
    assert main(["record", "records/pulse.csv", "-o", "elsewhere/scene.yaml"]) == 2


GUESSES = {
    "voltage": ("t [us],F [V]\n", "if 1 V is 1 N", "force if 1 V is 1 N (N)", "time (µs)"),
    "no-units": ("", "if their unit is N, if times are in", "force if their unit is N (N)", None),
    "area": ("t [us],p [MPa]\n", "if the area is 1 cm**2", "force if the area is 1 cm**2 (N)", "time (µs)"),
    "none": ("t [us],F [N]\n", None, "force (N)", "time (µs)"),
}


@pytest.mark.parametrize("name", GUESSES)
def test_guesses_are_conditions_of_the_figures_and_of_the_picture(tmp_path: Path, name: str) -> None:
    head, condition, force, time = GUESSES[name]
    (tmp_path / "pulse.csv").write_text(head + rows("{:.6e},{:.5f}", times=1e6 * TIMES))
    proposed = propose_keys(tmp_path / "pulse.csv")
    first = "".join(str(proposed).partition("\n\n")[0].split())  # a long path breaks its line anywhere
    expected = f"pulse.csv, {condition}" if condition else "pulse.csv: peak"
    assert expected.replace(" ", "") in first
    ax = proposed.plot()
    assert ax.get_ylabel().replace("(mN)", "(N)") == force
    assert time is None or ax.get_xlabel() == time
    pyplot.close(ax.figure)
