"""What accuracy costs: error against time, a line for each method."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Protocol

from shockwave.pictures.style import BLACK, COLOURS, LINES, MARKERS, SMALL, dress, key, measure, ratio

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Row", "work_precision"]

# Errors and times beyond these stand at them: nobody tells them apart, and an axis needs room beyond.
_LEAST, _GREATEST = 1e-100, 1e100
# How far below the least error, and above the greatest, a mark stands that has no place on a logarithmic axis: so many
# times at least, and this power of the range of errors.
_APART, _POWER = 8.0, 0.12


class Row(Protocol):
    """One run of a method: what it erred by, relatively, and how long it took [s]; ``problem`` says why it failed."""

    @property
    def method(self) -> str: ...
    @property
    def error(self) -> float | None: ...
    @property
    def seconds(self) -> float | None: ...
    @property
    def problem(self) -> str: ...


def work_precision(ax: Axes, rows: Iterable[Row], name: str = "relative error") -> Axes:
    """Error against time, both logarithmic, a line for each method in the order of its rows.

    A run that failed, or whose error is not a number, is a cross at the top, at the time that it took; without a time
    it is counted in the key alone. A run without any error is a triangle that points down, at the bottom.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    rows : iterable of Row
        Methods in their order, and the runs of each in the order in which a line joins them; time in s.
    name : str
        What the error is of.
    """
    methods: dict[str, list[Row]] = {}
    for row in rows:
        methods.setdefault(row.method, []).append(row)
    runs = [row for own in methods.values() for row in own]
    errors = [_error(row) for row in runs if _error(row) > 0]
    times = [_time(row) for row in runs if _time(row) > 0]
    apart = max(_APART, (max(errors) / min(errors)) ** _POWER) if errors else _APART
    bottom, top = (min(errors) / apart, max(errors) * apart) if errors else (1e-16, 1.0)
    ax.set_xscale("log")
    ax.set_yscale("log")
    for index, (method, own) in enumerate(methods.items()):
        _method(ax, index, method, own, (bottom, top))
    if any(_error(row) < 0 for row in runs):
        ax.axhline(top / math.sqrt(apart), color=BLACK, linewidth=0.6, linestyle=":")
        ax.text(0.99, top, "failed", transform=ax.get_yaxis_transform(), ha="right", va="center", fontsize=SMALL)
    else:
        top /= math.sqrt(apart)
    ax.set_ylim(bottom / apart**0.4, top * apart**0.4)
    if times:
        # room for the word at the right
        ax.set_xlim(min(times) / 1.8, max(times) * (max(times) / min(times)) ** 0.12 * 1.8)
    # the prefix of the middle of a logarithmic axis
    measure(ax, "x", math.sqrt(min(times) * max(times)) if times else 1.0, "s", "time")
    ratio(ax, "y", name)
    key(ax)
    _literally(ax)
    return dress(ax)


def _literally(ax: Axes) -> None:
    """Names are anybody's: a dollar in them is a dollar, and begins no formula."""
    ax.yaxis.label.set_parse_math(False)
    legend = ax.get_legend()
    for text in () if legend is None else legend.get_texts():
        text.set_parse_math(False)


def _method(ax: Axes, index: int, method: str, own: Sequence[Row], ends: tuple[float, float]) -> None:
    """Line and marks of one method; ``ends`` are where runs without an error and failed ones stand."""
    colour, marker = COLOURS[index % len(COLOURS)], MARKERS[index % len(MARKERS)]
    points = [(_time(row), _error(row)) for row in own if _error(row) > 0 and _time(row) > 0]
    failed = [row for row in own if _error(row) < 0]
    ax.plot(
        [time for time, _ in points],
        [error for _, error in points],
        color=colour,
        marker=marker,
        markersize=3.5,
        linewidth=1.0,
        linestyle=LINES[index % len(LINES)],
        label=method + (f" ({len(failed)} failed)" if failed else ""),
    )
    exact = [_time(row) for row in own if _error(row) == 0 and _time(row) > 0]
    ax.plot(exact, [ends[0]] * len(exact), "v", color=colour, markersize=5)
    lost = [_time(row) for row in failed if _time(row) > 0]
    ax.plot(lost, [ends[1]] * len(lost), "x", color=colour, markersize=5, markeredgewidth=1.2)


def _error(row: Row) -> float:
    """Of a run, its size; -1 of one that failed."""
    return -1.0 if row.problem or row.error is None or not math.isfinite(row.error) else _drawn(abs(row.error))


def _time(row: Row) -> float:
    """Of a run; 0 where none was taken."""
    return 0.0 if row.seconds is None or not math.isfinite(row.seconds) else _drawn(row.seconds)


def _drawn(value: float) -> float:
    """Where it stands on its axis; 0 has no place there."""
    return min(max(value, _LEAST), _GREATEST) if value > 0 else 0.0
