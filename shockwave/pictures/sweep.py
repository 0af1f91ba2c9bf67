"""Results of a sweep: lines over one axis, a map over two, with the regime borders."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.pictures.colour_maps import colour_cells, colours_of, edges_of, regime_borders
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import Axes, Label, colour_scale, halo, ink, label_axis, literal, series

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

    def scale(self, ax: Axes, axis: Literal["x", "y"]) -> None:
        """Set scale, ticks and label of an axis."""
        if self.texts:
            every = -(-len(self.texts) // _TICKS)
            slanted: dict[str, Any] = {"rotation": 30, "ha": "right"} if axis == "x" else {}
            chosen = ax.xaxis if axis == "x" else ax.yaxis
            chosen.set_ticks(self.places[::every], [literal(text) for text in self.texts[::every]], **slanted)
        elif self.log:
            (ax.set_xscale if axis == "x" else ax.set_yscale)("log")
        label_axis(ax, axis, (self.name, self.unit))


def sweep_lines(x: DrawnAxis, lines: Sequence[tuple[str, FloatArray]], quantity: Label, ax: Axes | None) -> Axes:
    """Draw a quantity over one axis of a sweep, with a line for each of a few values of another axis.

    Parameters
    ----------
    x : DrawnAxis
        The abscissa, as long as each line.
    lines : sequence of (str, array)
        Label and values of each line, at least one; the label of a single line is empty.
    quantity : (str, str)
        Name and unit of the values.
    ax : Axes or None
        Axes to draw on; None: those of a new figure.
    """
    with canvas(ax) as ax:
        for index, (label, values) in enumerate(lines):
            look = series(index, marked=not x.joined or len(x.places) <= _MARKERS)
            look["linestyle"] = look["linestyle"] if x.joined else ""
            ax.plot(x.places, values, label=literal(label) or None, **look)
        if not any(np.isfinite(values).any() for _, values in lines):
            ax.set_xlim(x.places[0], x.places[-1])
        ax.margins(y=0.12)
        if not any((values < 0).any() for _, values in lines):
            ax.set_ylim(bottom=0)
        x.scale(ax, "x")
        label_axis(ax, "y", quantity)
        return ax


def sweep_map(
    x: DrawnAxis,
    y: DrawnAxis,
    values: FloatArray,
    quantity: Label,
    regimes: npt.NDArray[np.str_] | None,
    ax: Axes | None,
) -> Axes:
    """Draw a quantity over two axes of a sweep as colours, with the borders of the regimes.

    A dashed line is at an amplification of 1.

    Parameters
    ----------
    x, y : DrawnAxis
        The axes, of at least two values.
    values : array, shape (x, y)
        Values; NaN, drawn grey, where there is none.
    quantity : (str, str)
        Name and unit of the values. A quantity of both signs has a diverging colour map.
    regimes : array of str, shape (x, y), optional
        Regime of each point; an empty name is no regime.
    ax : Axes or None
        Axes to draw on, beside which a colour bar is added; None: those of a new figure.
    """
    edges = edges_of(x.places, x.log), edges_of(y.places, y.log)
    with canvas(ax, legend=False) as ax:
        drawn = colour_cells(ax, edges, values, **colours_of(values[np.isfinite(values)]))
        x.scale(ax, "x")
        y.scale(ax, "y")
        bar = colour_scale(ax, drawn, quantity)
        if quantity[0] == "amplification" and drawn.norm.vmin < 1 < drawn.norm.vmax:
            ones = ax.contour(x.places, y.places, values.T, [1.0], colors=[ink()], linestyles="--", linewidths=0.9)
            bar.add_lines(ones)
            ones.set(path_effects=halo())
        if regimes is not None:
            regime_borders(ax, edges, regimes)
        return ax
