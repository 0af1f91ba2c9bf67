"""Record files of one known blow in the styles of instruments, spreadsheets and other sensors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from attrs import field, frozen

#: The blow: 850 sin^2 N up to 48 us, then 850 cos^2 N up to 160 us.
PEAK, RISE, DURATION = 850.0, 48e-6, 160e-6
IMPULSE = PEAK * DURATION / 2
#: Impulse of the negative phase of the style that has one, over that of the blow.
NEGATIVE = 0.2

_MICROSECONDS = np.arange(-60, 341)


def blow(times: np.ndarray) -> np.ndarray:
    """Force [N] at times [s]."""
    decay = np.pi / 2 * np.clip((times - RISE) / (DURATION - RISE), 0, 1)
    return PEAK * np.where(times < RISE, np.sin(np.pi / 2 * np.clip(times / RISE, 0, 1)), np.cos(decay)) ** 2


_FORCES = blow(1e-6 * _MICROSECONDS)


@frozen
class Style:
    """A file, the keys with which it states the blow, and words of the errors for each key that is left out.

    ``spread`` is the relative error that noise and rounding leave in the peak force.
    """

    content: bytes
    keys: dict[str, Any] = field(factory=dict)
    spread: float = 1e-3
    impulse: float = IMPULSE


def _rows(separator: str, *columns: Any, end: str = "\n") -> str:
    """Rows of formatted columns."""
    return "".join(separator.join(row) + end for row in zip(*columns, strict=True))


def _texts(values: Any, form: str = "{:.6g}", change: Callable[[str], str] = str) -> list[str]:
    return [change(form.format(value)) for value in values]


def _comma(text: str) -> str:
    return text.replace(".", ",")


def _german(text: str) -> str:
    """1,234.5 as 1.234,5."""
    return text.translate(str.maketrans(",.", ".,"))


def styles() -> dict[str, Style]:
    """All styles by their names."""
    seconds, ms, us = _texts(1e-6 * _MICROSECONDS), _texts(1e-3 * _MICROSECONDS), _texts(_MICROSECONDS)
    newtons, kilonewtons = _texts(_FORCES, "{:.4f}"), _texts(1e-3 * _FORCES, "{:.7f}")
    noise = np.random.default_rng(7).normal(0, 4.0, _FORCES.size)
    swing = np.where(_MICROSECONDS > 160, np.sin(np.pi * (_MICROSECONDS - 160) / 180), 0)
    swing *= NEGATIVE * IMPULSE / (1e-6 * swing.sum())
    metadata = 'Model,"DSO-X 3014T"\nRecord Length,401\nSample Interval,1e-06\nProbe,10,X\nsecond,Volt\n'
    thousands = _texts(1e3 * _FORCES, "{:,.1f}", _german)
    return {
        "oscilloscope": Style(
            (metadata + _rows(",", seconds, _texts(_FORCES / 100, "{:.6f}"))).encode(),
            {"skip_rows": 4, "unit": "N", "scale": 100},
        ),
        "german": Style(
            (
                "Zeit [ms];Kraft [N]\n"
                + _rows(";", _texts(1e-3 * _MICROSECONDS, "{:.3f}", _comma), map(_comma, newtons))
            ).encode()
        ),
        "utf16": Style(("Time [ms]\tForce [N]\r\n" + _rows("\t", ms, newtons, end="\r\n")).encode("utf-16")),
        "utf16-without-mark": Style(("Time [ms]\tForce [N]\n" + _rows("\t", ms, newtons)).encode("utf-16-le")),
        "cp1252": Style(("Zeit [µs];Kraft [kN]; für Nr. 3\n" + _rows(";", us, kilonewtons, us)).encode("cp1252")),
        "thousands": Style(("Zeit [us];Kraft [mN]\n" + _rows(";", us, thousands)).encode(), {"thousands": "."}),
        "thousands-in-quotes": Style(
            ('"time [us]","force [mN]"\n' + _rows(",", us, _texts(1e3 * _FORCES, '"{:,.1f}"'))).encode(),
            {"thousands": ","},
        ),
        "no-decimals": Style(
            ("Zeit [us];Kraft [mN]\n" + _rows(";", us, _texts(1e3 * _FORCES, "{:,.0f}", _german))).encode(),
            {"thousands": "."},
        ),
        "pressure": Style(
            ("time_ms,overpressure_kPa\n" + _rows(",", ms, _texts(_FORCES / 2, "{:.4f}"))).encode(),
            {"area": "2e-3 m**2"},
        ),
        "acceleration": Style(
            ("Time (ms),Acc (g)\n" + _rows(",", ms, _texts(_FORCES / (0.25 * 9.80665), "{:.5f}"))).encode(),
            {"mass": "250 g"},
        ),
        "inverted": Style(
            ("time [s],force [N]\n" + _rows(",", seconds, _texts(2.5 - _FORCES, "{:.4f}"))).encode(), {"sign": -1}
        ),
        "noisy": Style(
            ("# trigger at 0\ntime [us] force [N]\n" + _rows(" ", us, _texts(_FORCES + noise, "{:.3f}"))).encode(),
            spread=4 * 4.0 / PEAK,  # the largest of a dozen samples near the top
        ),
        "columns": Style(
            ("Kanal 3 [N];Nr;Temp [C];Uhr [ms]\n" + _rows(";", newtons, us, us, ms)).encode(),
            {"columns": ["Uhr", "Kanal 3"]},
        ),
        "column-numbers": Style(_rows(",", us, newtons, us, ms).encode(), {"columns": [4, 2], "time_unit": "ms"}),
        "header-units": Style(("t/ms,F/kN\n" + _rows(",", ms, kilonewtons)).encode()),
        "negative": Style(
            ("time [us],force [N]\n" + _rows(",", us, _texts(_FORCES - swing, "{:.4f}"))).encode(), {"negative": "zero"}
        ),
        "pulling": Style(
            ("time [us],force [N]\n" + _rows(",", us, _texts(_FORCES - swing, "{:.4f}"))).encode(),
            {"negative": "keep"},
            impulse=(1 - NEGATIVE) * IMPULSE,
        ),
    }
