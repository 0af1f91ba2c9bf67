"""The universal curve of a shape: amplification against rise time, and the simulations that it stands for."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from shockwave.errors import InvalidValueError
from shockwave.pictures.style import BLACK, BLUE, COLOURS, GREY, LINES, SKY, VERMILION, dress, key, ratio

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.quadrature import FloatArray

    class Curve(Protocol):
        """What is drawn of a `shockwave.UniversalCurve`."""

        @property
        def longest_rise_time(self) -> float: ...

        @property
        def highest(self) -> tuple[float, float]: ...

        def amplification(self, rise_time: npt.ArrayLike) -> FloatArray: ...

        def error(self, rise_time: npt.ArrayLike) -> FloatArray: ...


__all__ = ["curve"]

_POINTS, _DECADES = 600, 3.0
# A band narrower than this share of the amplification is no more than the line.
_VISIBLE = 2e-3


def curve(
    ax: Axes,
    curves: Curve | Sequence[Curve],
    *,
    labels: Sequence[str] | None = None,
    simulated: Iterable[tuple[float, float]] = (),
    shortest: float | None = None,
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
    simulated : iterable of (float, float)
        t0/T0 and amplification of simulations to be marked beside.
    shortest : float, optional
        Least t0/T0; left out, a thousandth of the longest.
    mark : float, optional
        A t0/T0 of one's own, marked by a line.

    Raises
    ------
    InvalidValueError
        When there is no curve, labels are not one each, or ``shortest`` is out of range.
    """
    drawn = list(curves) if isinstance(curves, Sequence) else [curves]
    names = _names(drawn, labels)
    least, longest = _range(drawn, shortest)
    for index, (one, name) in enumerate(zip(drawn, names, strict=True)):
        _line(ax, one, name, least, index if len(drawn) > 1 else None)
    points = sorted((float(x), float(y)) for x, y in simulated)
    if points:
        ax.plot([x for x, _ in points], [y for _, y in points], "s", color=VERMILION, markersize=3, label="simulated")
    ax.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    if mark is not None and least <= mark <= longest:
        ax.axvline(mark, color=BLACK, linewidth=0.9, linestyle="-.", label="this shock")
    ax.set_xscale("log")
    ax.set(xlim=(least, longest), ylim=(0, 1.08 * max([*(one.highest[1] for one in drawn), *(y for _, y in points)])))
    ratio(ax, "x", "rise time over natural time, $t_0/T_0$")
    ratio(ax, "y", "amplification")
    key(ax)
    return dress(ax)


def _names(curves: Sequence[Curve], labels: Sequence[str] | None) -> Sequence[str]:
    if not curves:
        raise InvalidValueError.of("curves", "must be one curve or more (got none)")
    if labels is None:
        return ["universal curve"] if len(curves) == 1 else [str(number) for number in range(1, len(curves) + 1)]
    if len(labels) != len(curves):
        raise InvalidValueError.of("labels", f"must be one for each of {len(curves)} curves (got {len(labels)})")
    return labels


def _range(curves: Sequence[Curve], shortest: float | None) -> tuple[float, float]:
    """Least and greatest t0/T0 of the picture."""
    reach = [one.longest_rise_time for one in curves]
    least = max(reach) / 10**_DECADES if shortest is None else float(shortest)
    if not 0 < least < min(reach):
        raise InvalidValueError.of("shortest", f"must be > 0 and shorter than every curve reaches (got {least:g})")
    return least, max(reach)


def _line(ax: Axes, one: Curve, name: str, least: float, index: int | None) -> None:
    x = np.geomspace(least, one.longest_rise_time, _POINTS)
    # rounding must not put the last beyond the range
    x[-1] = one.longest_rise_time
    values, errors = one.amplification(x), one.error(x)
    colour = BLUE if index is None else COLOURS[index % len(COLOURS)]
    style = "-" if index is None else LINES[index % len(LINES)]
    ax.plot(x, values, linestyle=style, color=colour, linewidth=1.2, label=name)
    if math.isfinite(worst := float(errors.max())) and worst > _VISIBLE:
        shade = SKY if index is None else colour
        ax.fill_between(x, values * (1 - errors), values * (1 + errors), color=shade, alpha=0.35, linewidth=0)
