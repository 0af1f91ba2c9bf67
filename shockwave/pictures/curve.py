"""The universal curve of a shape: amplification against rise time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from shockwave.errors import InvalidValueError
from shockwave.pictures.axes import finish
from shockwave.pictures.style import BLACK, COLOURS, GREY, LINES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.quadrature import FloatArray


_POINTS = 600
# Least rise time over the longest.
_SHORTEST = 1e-3
# A band narrower than this share of the amplification is no more than the line.
_VISIBLE = 2e-3


class Curve(Protocol):
    """The drawn part of a `shockwave.UniversalCurve`."""

    @property
    def longest_rise_time(self) -> float: ...

    @property
    def highest(self) -> tuple[float, float]: ...

    def amplification(self, rise_time: npt.ArrayLike) -> FloatArray: ...

    def error(self, rise_time: npt.ArrayLike) -> FloatArray: ...


def curve(
    ax: Axes,
    curves: Curve | Sequence[Curve],
    *,
    labels: Sequence[str] | None = None,
    mark: float | None = None,
) -> Axes:
    """Amplification of the primary against t0/T0, for one shape or several; errors that would show are bands.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    curves : UniversalCurve or sequence of them
        One line each.
    labels : sequence of str, optional
        Their names; left out, none for one curve, and numbers for several.
    mark : float, optional
        A t0/T0 of one's own, marked by a line.

    Raises
    ------
    InvalidValueError
        When there is no curve, or labels are not one each.
    """
    drawn = list(curves) if isinstance(curves, Sequence) else [curves]
    if not drawn:
        raise InvalidValueError.of("curves", "must be one curve or more (got none)")
    if labels is None:
        labels = ["universal curve"] if len(drawn) == 1 else [str(number + 1) for number in range(len(drawn))]
    if len(labels) != len(drawn):
        raise InvalidValueError.of("labels", f"must be one for each of {len(drawn)} curves (got {len(labels)})")
    reach = [one.longest_rise_time for one in drawn]
    least = _SHORTEST * max(reach)
    for index, (one, label) in enumerate(zip(drawn, labels, strict=True)):
        _line(ax, one, label, least, index)
    ax.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    if mark is not None and least <= mark <= max(reach):
        ax.axvline(mark, color=BLACK, linewidth=0.9, linestyle="-.", label="this shock")
    highest = max(one.highest[1] for one in drawn)
    ax.set(xscale="log", xlim=(least, max(reach)), ylim=(0, 1.08 * highest))
    return finish(ax, "rise time over characteristic time, $t_0/T_0$", "amplification")


def _line(ax: Axes, one: Curve, label: str, least: float, index: int) -> None:
    # rounding must not put the last beyond the range
    x = np.geomspace(least, one.longest_rise_time, _POINTS).clip(max=one.longest_rise_time)
    values, errors = one.amplification(x), one.error(x)
    colour, style = COLOURS[index % len(COLOURS)], LINES[index % len(LINES)]
    ax.plot(x, values, linestyle=style, color=colour, linewidth=1.2, label=label)
    if _VISIBLE < float(errors.max()) < math.inf:
        ax.fill_between(x, values * (1 - errors), values * (1 + errors), color=colour, alpha=0.35, linewidth=0)
