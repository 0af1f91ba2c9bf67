"""Error against run time, a line for each method."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Protocol

from shockwave.pictures.axes import finish
from shockwave.pictures.style import BLACK, COLOURS, LINES, MARKERS, SMALL, literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Marks without a place on the axis of errors stand so many times below the least, and above the greatest error, at
# least; else by this power of their range.
_APART = 8.0
_POWER = 0.12


class Row(Protocol):
    """One run of a method: its relative error and its time [s]; ``problem`` says why it failed."""

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
        The quantity that the error belongs to.
    """
    methods: dict[str, list[tuple[float | None, float]]] = {}
    for row in rows:
        failed = row.problem or row.error is None or not math.isfinite(row.error)
        error = None if failed else abs(row.error or 0.0)
        methods.setdefault(row.method, []).append((error, row.seconds or math.nan))
    runs = [run for own in methods.values() for run in own]
    errors = [error for error, _ in runs if error] or [1e-16, 1.0]
    times = [time for _, time in runs if time > 0] or [1.0]
    apart = max(_APART, (max(errors) / min(errors)) ** _POWER)
    bottom, top = min(errors) / apart, max(errors) * apart
    for index, (method, own) in enumerate(methods.items()):
        colour, marker = COLOURS[index % len(COLOURS)], MARKERS[index % len(MARKERS)]
        failed_times = [time for error, time in own if error is None]
        lost = [time for time in failed_times if time > 0]
        exact = [time for error, time in own if error == 0]
        line = [(time, error) for error, time in own if error]
        label = literal(method) + (f" ({len(failed_times)} failed)" if failed_times else "")
        look = {"linestyle": LINES[index % len(LINES)], "linewidth": 1.0, "marker": marker, "markersize": 3.5}
        ax.plot([time for time, _ in line], [error for _, error in line], color=colour, label=label, **look)
        ax.plot(exact, [bottom] * len(exact), "v", color=colour, markersize=5)
        ax.plot(lost, [top] * len(lost), "x", color=colour, markersize=5, markeredgewidth=1.2)
    if any(error is None for error, _ in runs):
        ax.axhline(top / math.sqrt(apart), color=BLACK, linewidth=0.6, linestyle=":")
        ax.text(0.99, top, "failed", transform=ax.get_yaxis_transform(), ha="right", va="center", fontsize=SMALL)
    # at the right, room for the word
    wider = (max(times) / min(times)) ** _POWER
    ax.set(xscale="log", yscale="log", ylim=(bottom / apart**0.4, top * apart**0.4))
    ax.set_xlim(min(times) / 1.8, max(times) * wider * 1.8)
    # the prefix of the middle of a logarithmic axis
    return finish(ax, ("time", "s", math.sqrt(min(times) * max(times))), literal(name))
