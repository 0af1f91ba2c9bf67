"""Record files of known blows in the styles of instruments, spreadsheets and other sensors."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from attrs import field, frozen

#: Peak force [N], rise time [s] and duration [s] of the blows.
PEAK, RISE, DURATION = 100.0, 100e-6, 200e-6
# Sample times [us], 50 of them before the blow.
_TIMES = np.arange(-50, 400)


@frozen
class Style:
    """A file and what its user knows beyond it.

    ``keys`` are those whose values no message can propose, such as the sensitivity of a sensor. ``clipped`` files have
    lost the top of the blow.
    """

    content: bytes
    keys: dict[str, Any] = field(factory=dict)
    clipped: bool = False


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
    settings = "Modell;RTB-4\nAbtastrate;1 MHz\nTastkopf;1:1\n"
    many = [_texts(range(_TIMES.size), "{}"), us, _texts(20 + 0 * forces), newtons]
    return {
        "plain": Style(f"time [us],force [N]\n{plain}".encode()),
        "tabs": Style(("Time [ms]\tForce [N]\n" + _rows([ms, newtons], "\t")).encode()),
        "semicolons": Style(("t (ms);F (N)\n" + _rows([ms, newtons], ";")).encode()),
        "blanks": Style(("time (us)  load (N)\n" + _rows([us, newtons], "   ")).encode()),
        "german": Style(("Zeit [ms];Kraft [N]\n" + _rows([ms, newtons], ";", _comma)).encode()),
        "german-settings": Style((settings + "Zeit [ms];Kraft [N]\n" + _rows([ms, newtons], ";", _comma)).encode()),
        "decimal-commas-and-blanks": Style(("t[ms] F[N]\n" + _rows([ms, newtons], " ", _comma)).encode()),
        "quotes": Style(
            ('"time [us]","force [N]"\n' + _rows([us, newtons], '","').replace("\n", '"\n"'))[:-1].encode()
        ),
        "empty-last-cells": Style(("time [us],force [N],remark\n" + plain.replace("\n", ",\n")).encode()),
        "comments": Style(f"# hammer 2\n% 5 kN\ntime [us],force [N]\n\n{plain}".encode()),
        "header-in-comment": Style(f"# time [us], force [N]\n{plain}".encode()),
        "range-1": Style(f"Full scale,5 kN\n{plain}".encode()),
        "range-3": Style(f"Model,X\nFull scale,5 kN\n{plain}".encode()),
        "range-8": Style(f"Interval: 1 us,Range: 5 kN\n{plain}".encode()),
        "unit-of-a-range": Style(f"Range,kN\n{plain}".encode()),
        "settings-and-header": Style(f"Model,X\nPoints,450\ntime [us],force [N]\n{plain}".encode()),
        "swapped": Style(("force [N],time [us]\n" + _rows([newtons, us])).encode()),
        "many-columns": Style(("no,Time [us],T,Load cell [N]\n" + _rows(many)).encode()),
        "many-columns-without-units": Style(
            ("no,time,T,load\n" + _rows(many)).encode(), {"columns": ["time", "load"], "time_unit": "us"}
        ),
        "one-column": Style(("force [N]\n" + _rows([newtons])).encode(), {"interval": "1 us"}),
        "utf-16": Style(f"time [us],force [N]\n{plain}".encode("utf-16")),
        "utf-16-without-mark": Style(f"time [us],force [N]\n{plain}".encode("utf-16-le")),
        "cp1252": Style(f"Zeit [µs],Kraft [N]\n{plain}".encode("cp1252")),
        "unicode-minus": Style(f"time [us],force [N]\n{plain}".replace("-", "\N{MINUS SIGN}").encode()),
        "nan-at-the-start": Style(("time [us],force [N]\n" + "nan,nan\n" * 7 + plain).encode()),
        "tektronix": Style(_tektronix("V").encode(), {"scale": 100}),
        "tektronix-in-newtons": Style(_tektronix("N", 1).encode()),
    }


def _tektronix(unit: str, per_unit: float = 100) -> str:
    names = ["Record Length,450", "Sample Interval,1e-06", "Source,CH1", f"Vertical Units,{unit}", "Horizontal Units,s"]
    settings = [*names, *["," for _ in range(_TIMES.size - len(names))]]
    cells = [_texts(1e-6 * _TIMES, "{:.12f}"), _texts(smooth(_TIMES) / per_unit, "{:.6f}")]
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
        "no-header-milliseconds": _file("", 1e-3 * _TIMES, forces),
        "no-header-microseconds": _file("", _TIMES, forces),
        "no-header-nanoseconds": _file("", 1e3 * _TIMES, forces),
        "names-without-units": _file("time,force\n", _TIMES, forces),
        "kilonewtons-without-unit": _with(_file("time [us],CH1\n", _TIMES, 1e-3 * forces, "{:.7f}"), unit="kN"),
        "epoch-nanoseconds": Style(("time [ns],force [N]\n" + _rows([epoch, _texts(forces)])).encode()),
        "epoch-seconds": Style(("time [s],force [N]\n" + _rows([seconds, _texts(forces)])).encode()),
        "missing-digits": _file("time [us],force [N]\n", np.round(slow), slow_forces),
    }


def _sensors() -> dict[str, Style]:
    forces = smooth(_TIMES)
    return {
        "volts": _with(_file("time [us],CH2 [V]\n", _TIMES, forces / 500, "{:.7f}"), scale=500),
        "millivolts": _with(_file("time [us],CH2 [mV]\n", _TIMES, 2 * forces), scale=500),
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
        "small-offset": _file(head, _TIMES, forces + noise + 0.7),
        "offset-behind-only": _file(head, _TIMES[50:], forces[50:] + noise[50:] + 3),
        "hum": _file(head, long, sharp(long) + hum + quiet),
        "long-noisy-tail": _file(head, long, sharp(long) + rng.normal(0, 0.3, long.size)),
        "long-residual": _file(head, long, sharp(long) + quiet + 1.1 * (long > 200)),
        "exact-lead-of-0.1-percent": _file(head, _TIMES, forces + 0.1),
        "eight-bit": _file(head, _TIMES, np.round((forces + noise + 12) / 0.4) * 0.4),
        "swing": _file(head, _TIMES, forces + swing),
        "clipped": evolved(_file(head, _TIMES, np.minimum(smooth(_TIMES), 60))),
        "clipped-noise": evolved(_file(head, _TIMES, np.minimum(forces + 10 * noise, 80).clip(0))),
    }


def evolved(style: Style) -> Style:
    return Style(style.content, style.keys, clipped=True)
