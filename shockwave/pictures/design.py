"""A design: the target along the varied value, the wanted level, and where it is met."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from shockwave.pictures.axes import decades, dress, key, label_axis
from shockwave.pictures.style import BLUE, GREY, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# A range of more than this factor is drawn by equal ratios.
_WIDE = 3.0
_AXES: tuple[Literal["x", "y"], ...] = ("x", "y")


def design(
    ax: Axes,
    values: Sequence[float],
    reached: Sequence[float],
    wanted: float,
    solutions: Sequence[float] = (),
    *,
    labels: tuple[str, str] = ("value", "target"),
    units: tuple[str, str] = ("", ""),
) -> Axes:
    """The target against the value, with the wanted level, and the solutions on it.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    values, reached : sequence of float
        The line, by ascending values.
    wanted : float
        The level.
    solutions : sequence of float
        Values at which the line has it.
    labels, units : (str, str)
        Of the two axes; a unit is empty for a number without one.
    """
    ax.plot(values, reached, color=BLUE, linewidth=1.2, label="along the interval")
    ax.axhline(wanted, color=GREY, linewidth=0.9, linestyle="--", label="wanted")
    if solutions:
        ax.plot(solutions, [wanted] * len(solutions), "o", color=VERMILION, markersize=4, label="solutions")
    ax.set_xlim(values[0], values[-1])
    for axis, numbers, label, unit in zip(_AXES, (values, reached), labels, units, strict=True):
        if min(numbers) > 0 and max(numbers) > _WIDE * min(numbers):
            decades(ax, axis)
        label_axis(ax, axis, label, unit, max(numbers))
    key(ax)
    return dress(ax)
