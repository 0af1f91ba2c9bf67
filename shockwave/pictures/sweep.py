"""Results of a sweep: lines over one axis, a map over two, with the regime borders."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.pictures.drawing import GREY, add_legend, colour_scale, label_axis, literal, regime_spans, style
from shockwave.pictures.maps import NO_VALUE, colour_cells, colours_of, edges_of, hatch, regime_borders

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.quadrature import FloatArray


# Greatest value on a logarithmic axis, whose ticks may lie decades beyond its values.
_MOST_DRAWN = 1e150
# Most tick labels with names along an axis.
_TICKS = 25
# Most points of a line with markers.
_MARKERS = 30


@frozen(eq=False)
class DrawnAxis:
    """An axis of a picture.

    Attributes
    ----------
    name, unit : str
        Label, and SI unit, empty for a dimensionless number.
    places : array, shape (p,)
        Coordinates of the values, ascending.
    texts : sequence of str
        Names of the values, if they are not numbers.
    joined : bool
        Whether values are connected by a line.
    """

    name: str
    unit: str
    places: FloatArray
    texts: Sequence[str] = ()
    joined: bool = True

    @property
    def log(self) -> bool:
        """Whether the values are spaced more evenly on a logarithmic axis."""
        low, middle, high = self.places[[0, len(self.places) // 2, -1]].tolist()
        if self.texts or not 0 < 3 * low < high < _MOST_DRAWN:
            return False
        return bool(abs(middle - (low * high) ** 0.5) < abs(middle - (low + high) / 2))

    @property
    def edges(self) -> FloatArray:
        """Edges of the cells around the values."""
        return edges_of(self.places, self.log)


@frozen(eq=False)
class Line:
    """A line of `sweep_lines`.

    Attributes
    ----------
    label : str
        Label; empty for a single line.
    values, low, high : array, shape (p,)
        Values, and bounds of the true values; NaN where there is none.
    """

    label: str
    values: FloatArray
    low: FloatArray
    high: FloatArray


def sweep_lines(
    ax: Axes,
    x: DrawnAxis,
    lines: Sequence[Line],
    quantity: tuple[str, str],
    band: str,
    regimes: npt.NDArray[np.str_] | None,
) -> Axes:
    """Draw a quantity over one axis of a sweep, with a line and a band for each of a few values of another axis.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    x : DrawnAxis
        The abscissa, as long as each line.
    lines : sequence of Line
        At least one line.
    quantity : (str, str)
        Name and unit of the values.
    band : str
        Label of the band between the bounds.
    regimes : array of str, shape (p,), optional
        Regime at each point of a single line.
    """
    for index, line in enumerate(lines):
        look = style(index, marked=not x.joined or len(x.places) <= _MARKERS)
        look["linestyle"] = look["linestyle"] if x.joined else ""
        ax.plot(x.places, line.values, linewidth=1.2, markersize=3, label=literal(line.label) or None, **look)
        if np.isfinite(line.low).any():
            shade: Any = ax.fill_between if x.joined else ax.vlines
            shown = shade(x.places, line.low, line.high, color=look["color"], alpha=0.2, linewidth=0 if x.joined else 3)
            shown.set_label("" if index else band)
    if regimes is not None:
        regime_spans(ax, x.edges, regimes)
    ax.margins(y=0.12)
    if not any((line.values < 0).any() for line in lines):
        ax.set_ylim(bottom=0)
    _scale_axis(ax, "x", x)
    label_axis(ax, "y", *quantity)
    add_legend(ax, ax.get_legend_handles_labels()[0])
    return ax


def sweep_map(
    ax: Axes,
    x: DrawnAxis,
    y: DrawnAxis,
    values: FloatArray,
    quantity: tuple[str, str],
    regimes: npt.NDArray[np.str_] | None,
) -> Axes:
    """Draw a quantity over two axes of a sweep: colours, contour lines, and regime borders.

    Parameters
    ----------
    ax : Axes
        Axes to draw on; a colour bar is added beside it.
    x, y : DrawnAxis
        The axes, of at least two values.
    values : array, shape (x, y)
        Values; NaN, drawn grey and hatched, where there is none.
    quantity : (str, str)
        Name and unit of the values. A quantity of both signs has a diverging colour map.
    regimes : array of str, shape (x, y), optional
        Regime of each point; an empty name is no regime.
    """
    lost = np.isnan(values)
    edges = x.edges, y.edges
    drawn = colour_cells(ax, edges, values, **colours_of(values[~lost]))
    _scale_axis(ax, "x", x)
    _scale_axis(ax, "y", y)
    bar = colour_scale(ax, drawn, *quantity)
    # no contour lines between names
    if not (lost.all() or x.texts or y.texts):
        levels = [level for level in bar.get_ticks() if np.nanmin(values) < level < np.nanmax(values)]
        ax.contour(x.places, y.places, values.T, levels=levels, colors=[GREY], linewidths=0.5)
    if regimes is not None:
        regime_borders(ax, edges, regimes)
    add_legend(ax, hatch(ax, edges, lost, "no value", "//////", NO_VALUE))
    return ax


def _scale_axis(ax: Axes, axis: Literal["x", "y"], of: DrawnAxis) -> None:
    """Set scale, ticks and label of an axis."""
    if of.texts:
        every = -(-len(of.texts) // _TICKS)
        slanted: dict[str, Any] = {"rotation": 30, "ha": "right"} if axis == "x" else {}
        chosen = ax.xaxis if axis == "x" else ax.yaxis
        chosen.set_ticks(of.places[::every], [literal(text) for text in of.texts[::every]], **slanted)
    elif of.log:
        (ax.set_xscale if axis == "x" else ax.set_yscale)("log")
    label_axis(ax, axis, of.name, of.unit)
