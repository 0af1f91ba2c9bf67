"""Record files of known blows in the styles of instruments, spreadsheets and other sensors."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from attrs import field, frozen

#: Peak force [N], rise time [s] and duration [s] of the blows.
PEAK, RISE, DURATION = 100.0, 100e-6, 200e-6
# Sample times [us], 50 of them before the blow.
_TIMES = np.arange(-50, 400)
#: Times [s] and forces [N] of a blow of 100 N on a baseline of 5 N, with 20 quiet samples on either side.
MICROSECONDS = 1e-6 * np.arange(81)
BLOW = 5 + 100 * np.sin(np.pi / 40 * np.clip(np.arange(81) - 20, 0, 40))


@frozen
class Style:
    """A file and what its user knows beyond it.

    ``keys`` are those whose values no message can propose, such as the sensitivity of a sensor. ``lost`` is the warning
    of a file that no key can make right. ``mended`` is the file after the correction that the message ``remedy`` asks
    for.
    """

    content: bytes
    keys: dict[str, Any] = field(factory=dict)
    lost: str = ""
    remedy: str = ""
    mended: bytes = b""


def smooth(times: np.ndarray) -> np.ndarray:
    """100 sin^2 N at times [us]."""
    return PEAK * np.where((times > 0) & (times < 200), np.sin(np.pi * times / 200) ** 2, 0)


def sharp(times: np.ndarray) -> np.ndarray:
    """A triangle, whose start and peak noise does not move."""
    return PEAK * np.clip(1 - np.abs(times - 100) / 100, 0, 1)


#: Impulse of both blows [N s].
IMPULSE = PEAK * DURATION / 2


def _rows(columns: Iterable[Iterable[str]], separator: str = ",", change: Callable[[str], str] = str) -> str:
    return "".join(separator.join(map(change, row)) + "\n" for row in zip(*columns, strict=True))


def _texts(values: Any, form: str = "{:.4f}") -> list[str]:
    return [form.format(value) for value in values]


def _comma(text: str) -> str:
    return text.replace(".", ",")


def _file(head: str, times: Any, forces: Any, form: str = "{:.4f}", of_times: str = "{:.9g}") -> Style:
    return Style((head + _rows([_texts(times, of_times), _texts(forces, form)])).encode())


def _with(style: Style, **keys: Any) -> Style:
    return Style(style.content, keys)


def styles() -> dict[str, Style]:
    """All styles by their names."""
    return {**_layouts(), **_units(), **_sensors(), **_signals()}


def _layouts() -> dict[str, Style]:
    forces, us = smooth(_TIMES), _texts(_TIMES, "{:d}")
    newtons = _texts(forces)
    plain = _rows([us, newtons])
    ms = _texts(1e-3 * _TIMES, "{:.3f}")
    many = [_texts(range(_TIMES.size), "{}"), us, _texts(20 + 0 * forces), newtons]
    return {
        "plain": Style(f"time [us],force [N]\n{plain}".encode()),
        "tabs": Style(("Time [ms]\tForce [N]\n" + _rows([ms, newtons], "\t")).encode()),
        "semicolons": Style(("t (ms);F (N)\n" + _rows([ms, newtons], ";")).encode()),
        "blanks": Style(("time (us)  load (N)\n" + _rows([us, newtons], "   ")).encode()),
        "german": Style(("Zeit [ms];Kraft [N]\n" + _rows([ms, newtons], ";", _comma)).encode()),
        "decimal-commas-and-blanks": Style(("t[ms] F[N]\n" + _rows([ms, newtons], " ", _comma)).encode()),
        "quotes": Style(
            ('"time [us]","force [N]"\n"' + _rows([us, newtons], '","').replace("\n", '"\n"'))[:-1].encode()
        ),
        "empty-last-cells": Style(("time [us],force [N],remark\n" + plain.replace("\n", ",\n")).encode()),
        "comments": Style(f"# hammer 2\n% 5 kN\ntime [us],force [N]\n\n{plain}".encode()),
        "header-in-comment": Style(f"# time [us], force [N]\n{plain}".encode()),
        "range-1": Style(f"Full scale,5 kN\n{plain}".encode()),
        "unit-of-a-range": Style(f"Range,kN\n{plain}".encode()),
        "settings-and-header": Style(f"Model,X\nPoints,450\ntime [us],force [N]\n{plain}".encode()),
        "swapped": Style(("force [N],time [us]\n" + _rows([newtons, us])).encode()),
        "many-columns": Style(("no,Time [us],T,Load cell [N]\n" + _rows(many)).encode()),
        "many-columns-without-units": Style(
            ("no,time,T,load\n" + _rows(many)).encode(), {"columns": [2, 4], "time_unit": "us"}
        ),
        "one-column": Style(("force [N]\n" + _rows([newtons])).encode(), {"interval": "1 us"}),
        "utf-16": Style(f"time [us],force [N]\n{plain}".encode("utf-16")),
        "utf-16-without-mark": Style(f"time [us],force [N]\n{plain}".encode("utf-16-le")),
        "cp1252": Style(f"Zeit [µs],Kraft [N]\n{plain}".encode("cp1252")),
        "unicode-minus": Style(f"time [us],force [N]\n{plain}".replace("-", "\N{MINUS SIGN}").encode()),
        "nan-at-the-start": Style(
            ("time [us],force [N]\n" + "nan,nan\n" * 7 + plain).encode(),
            remedy="delete lines 2 to 8",
            mended=f"time [us],force [N]\n{plain}".encode(),
        ),
        "several-forces": Style(
            (
                "t [us];Fx [N];Fy [N];Fz [N]\n" + _rows([us, _texts(0 * forces), _texts(0.1 * forces), newtons], ";")
            ).encode(),
            {"columns": [1, 4]},
        ),
        "sequence": Style(
            (
                "X,CH1,Start,Increment,\nSequence,Volt,-5e-05,1e-06,\n"
                + _rows([_texts(range(450), "{}"), newtons], ",", _cut)
            ).encode(),
            {"interval": "1 us"},
        ),
        "clock": Style(
            ("Time [HH:MM:SS];F [N]\n" + _rows([_texts(1 + 1e-6 * _TIMES, "00:00:{:09.6f}"), newtons], ";")).encode(),
            {"interval": "1 us"},
        ),
        "names-below-settings": Style(f"LeCroy,1\nSegments,1\nTime,Ampl\n{plain}".encode()),
        "pico": Style(
            (
                "Time;Channel A;Channel B\n(us);(mV);(mV)\n"
                + _rows([us, _texts(10 * forces), _texts(0 * forces)], ";", _comma)
            ).encode(),
            {"columns": [1, 2], "scale": 0.1},
        ),
        **_commas(us, ms, forces),
        "tektronix": Style(_tektronix().encode(), {"scale": 100}),
    }


def _cut(text: str) -> str:
    return f"{text},," if "." in text else text


def _commas(us: list[str], ms: list[str], forces: np.ndarray) -> dict[str, Style]:
    """Decimal commas between commas, and thousands marks, neither of which can be read."""
    head, newtons, milli = "t [ms],F [N]\n", _texts(forces, "{:.3f}"), 1e3 * forces
    mended = (head.replace(",", ";") + _rows([ms, newtons], ";")).encode()
    anew = {"remedy": "write the file anew with semicolons", "mended": mended}
    marked = {mark: [text.replace(",", mark) for text in _texts(milli, "{:,.0f}")] for mark in (".", ",")}
    plain = ("t [us];F [mN]\n" + _rows([us, _texts(milli, "{:.0f}")], ";")).encode()
    unmarked = {"remedy": "remove thousands marks", "mended": plain}
    tenths = [text.translate(str.maketrans(",.", ".,")) for text in _texts(milli, "{:,.1f}")]
    return {
        "comma-twice": Style((head + _rows([ms, newtons], ",", _comma)).encode(), **anew),
        "comma-twice-in-one-column": Style(
            (head + _rows([ms, _texts(np.round(forces), "{:.0f}")], ",", _comma)).encode(), **anew
        ),
        "thousands-points": Style(("t [us];F [mN]\n" + _rows([us, marked["."]], ";")).encode(), **unmarked),
        "thousands-in-quotes": Style(
            ("t [us],F [mN]\n" + _rows([us, [f'"{text}"' for text in marked[","]]])).encode(), **unmarked
        ),
        "thousands-and-decimals": Style(
            ("t [us];F [mN]\n" + _rows([us, tenths], ";")).encode(), remedy=unmarked["remedy"], mended=plain
        ),
    }


def _tektronix() -> str:
    names = ["Record Length,450", "Sample Interval,1e-06", "Source,CH1", "Vertical Units,V", "Horizontal Units,s"]
    settings = [*names, *["," for _ in range(_TIMES.size - len(names))]]
    cells = [_texts(1e-6 * _TIMES, "{:.12f}"), _texts(smooth(_TIMES) / 100, "{:.6f}")]
    return "".join(f"{setting},, {time}, {value},\n" for setting, time, value in zip(settings, *cells, strict=True))


def _units() -> dict[str, Style]:
    forces = smooth(_TIMES)
    epoch = [f"{1_600_000_000_000_000_000 + 1000 * int(time)}" for time in _TIMES]
    seconds = [f"1600000000.{1000 + int(time):06d}" for time in _TIMES]
    slow, slow_forces = np.arange(-50, 4000) / 10, smooth(np.arange(-50, 4000) / 10)
    return {
        "slashes": _file("t/ms,F/kN\n", 1e-3 * _TIMES, 1e-3 * forces, "{:.7f}"),
        "underscores": _file("time_us,force_N\n", _TIMES, forces),
        "units-alone": _file("us,N\n", _TIMES, forces),
        "words": _file("Time (Seconds),Force (Newton)\n", 1e-6 * _TIMES, forces),
        "nanoseconds": _file("time [ns],force [mN]\n", 1e3 * _TIMES, 1e3 * forces),
        "no-header-seconds": _file("", 1e-6 * _TIMES, forces),
        "no-header-microseconds": _file("", _TIMES, forces),
        "names-without-units": _file("time,force\n", _TIMES, forces),
        "kilonewtons-without-unit": _with(_file("time [us],CH1\n", _TIMES, 1e-3 * forces, "{:.7f}"), unit="kN"),
        "epoch-nanoseconds": Style(("time [ns],force [N]\n" + _rows([epoch, _texts(forces)])).encode()),
        "epoch-seconds": Style(("time [s],force [N]\n" + _rows([seconds, _texts(forces)])).encode()),
        "missing-digits": _with(_file("time [us],force [N]\n", np.round(slow), slow_forces), interval="0.1 us"),
        "no-digits": _with(_file("t [s],F [N]\n", 1e-6 * _TIMES, forces, of_times="{:.2f}"), interval="1 us"),
        "one-time-twice": Style(
            _file("t [us],F [N]\n", np.insert(_TIMES, 100, 49), np.insert(forces, 100, forces[99])).content,
            remedy=":102: times[100]: must be greater than the one before (got 4.9e-05, one of 1; delete it",
            mended=_file("t [us],F [N]\n", _TIMES, forces).content,
        ),
        "unknown-unit": _with(_file("t[us],F[KN]\n", _TIMES, 1e-3 * forces, "{:.7f}"), unit="kN"),
        "pounds": _with(_file("t [us],F [lbs]\n", _TIMES, forces / 4.4482216), unit="lbf"),
        "grams": _with(_file("t [us],Load [g]\n", _TIMES, 1e3 * forces / 9.80665), unit="gf"),
        "filtered": _file("t [us],F [N] (filtered)\n", _TIMES, forces),
        "sensitivity": _file("t [us],F [N] @ 10 mV/N\n", _TIMES, forces),
        "ambiguous": _with(_file("t [us],F [N] (kN)\n", _TIMES, forces), unit="N"),
    }


def _sensors() -> dict[str, Style]:
    forces = smooth(_TIMES)
    return {
        "volts": _with(_file("time [us],CH2 [V]\n", _TIMES, forces / 500, "{:.7f}"), scale=500),
        "millivolts": _with(_file("time [us],CH2 [mV]\n", _TIMES, 10 * forces), scale=0.1),
        "millivolts-with-sensitivity": _with(_file("t [us],CH1 [mV] (10 mV/N)\n", _TIMES, 10 * forces), scale=0.1),
        "charge": _with(_file("t [us],Charge (pC)\n", _TIMES, 4 * forces), scale=0.25),
        "accelerometer-in-millivolts": _with(
            _file("t [us],CH1 [mV]\n", _TIMES, 100 * forces / (0.25 * 9.80665)), scale=0.01, unit="g", mass="250 g"
        ),
        "milli-g": _with(_file("t [us],acc [mg]\n", _TIMES, 1e3 * forces / (0.25 * 9.80665)), mass="250 g"),
        "keysight": _with(_file("second,Volt\n", 1e-6 * _TIMES, forces / 500, "{:.7f}"), scale=500),
        "pressure": _with(_file("time [us],p [kPa]\n", _TIMES, forces / 2), area="2e-3 m**2"),
        "acceleration": _with(_file("time [us],Acc (g)\n", _TIMES, forces / (0.25 * 9.80665)), mass="250 g"),
        "inverted": _with(_file("time [us],force [N]\n", _TIMES, -forces), sign=-1),
    }


def _signals() -> dict[str, Style]:
    rng, head, forces = np.random.default_rng(11), "time [us],force [N]\n", sharp(_TIMES)
    noise = rng.normal(0, 0.05, _TIMES.size)
    long = np.arange(-500, 4500) * 2
    hum, quiet = np.sin(2 * np.pi * long / 20_000 + 1), rng.normal(0, 0.05, long.size)
    swing = np.where((_TIMES > 200) & (_TIMES < 300), -20 * np.sin(np.pi * (_TIMES - 200) / 100), 0)
    return {
        "noise": _file(head, _TIMES, forces + noise),
        "offset": _file(head, _TIMES, forces + noise + 5),
        "exact-offset": _file(head, _TIMES, smooth(_TIMES) + 26),
        "negative-offset": _file(head, _TIMES, forces + noise - 8),
        "offset-behind-only": _file(head, _TIMES[50:], forces[50:] + noise[50:] + 3),
        "hum": _file(head, long, sharp(long) + hum + quiet),
        "long-noisy-tail": _file(head, long, sharp(long) + rng.normal(0, 0.3, long.size)),
        "long-residual": _file(head, long, sharp(long) + quiet + 1.1 * (long > 200)),
        "exact-lead-of-0.1-percent": _file(head, _TIMES, forces + 0.1),
        "eight-bit": _file(head, _TIMES, np.round((forces + noise + 12) / 0.4) * 0.4),
        "swing": _file(head, _TIMES, forces + swing),
        "decaying-tail": _file(head, long, smooth(long) + 0.5 * np.exp(-(long - 200) / 6000) * (long > 200)),
        "decaying-tail-and-noise": _file(head, long, sharp(long) + np.exp(-(long - 200) / 3000) * (long > 200) + quiet),
        "second-blow": _file(head, long, smooth(long) + 0.4 * smooth(long - 1500)),
        "blow-before": _file(head, long, smooth(long) + 0.4 * smooth(long + 600)),
        "second-blow-and-noise": _file(head, long, sharp(long) + 0.4 * sharp(long - 1500) + quiet),
        "clipped": lost(_file(head, _TIMES, np.minimum(smooth(_TIMES), 60)), "saturated"),
        "clipped-noise": lost(_file(head, _TIMES, np.minimum(forces + 10 * noise, 80).clip(0)), "saturated"),
        "clipped-before-noise": lost(
            _file(head, _TIMES, np.minimum(smooth(_TIMES), 80) + noise * (smooth(_TIMES) > 1)), "saturated"
        ),
        "lost-block": lost(
            _file(head, np.delete(_TIMES, range(80, 140)), np.delete(forces, range(80, 140))), "lost: 60"
        ),
        "spike": lost(_file(head, _TIMES, np.where(_TIMES == 160, 9000, forces)), "9000 N at 160 us"),
        "dropout": lost(_file(head, _TIMES, np.where(_TIMES == 60, 0, forces)), "0 N at 60 us"),
    }


def lost(style: Style, warning: str) -> Style:
    return Style(style.content, style.keys, lost=warning)
