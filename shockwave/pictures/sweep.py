"""Results of a sweep: lines over one axis, a map over two, with the borders of the regimes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.pictures.axes import decades, dress, key, label_axis, named, scale
from shockwave.pictures.cells import NAMED, NO_VALUE, edges_of, hatch, regions
from shockwave.pictures.style import COLOURS, FIELD, GREY, LINES, MARKERS, SIGNED, literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.quadrature import FloatArray


# Values over more decades than this have a logarithmic scale.
_DECADES = 2.5
# More names than this along an axis would cover each other.
_TICKS = 25
# A line of more points has no marks.
_MARKS = 30


@frozen(eq=False)
class Along:
    """An axis of a picture.

    Attributes
    ----------
    values : array, shape (p,)
        Ascending, in SI units, for `sweep_lines` with repetitions too; or texts, which stand side by side.
    name, unit : str
        Its label; its SI unit, empty for a number without one.
    joined : bool
        Whether a line between two values means anything.
    """

    values: npt.NDArray[Any]
    name: str
    unit: str = ""
    joined: bool = True

    @property
    def texts(self) -> bool:
        """Whether the values are texts."""
        return self.values.dtype.kind not in "fiu"

    @property
    def places(self) -> FloatArray:
        """Where the values are drawn."""
        return np.arange(len(self.values), dtype=float) if self.texts else np.asarray(self.values, dtype=float)

    @property
    def apart(self) -> bool:
        """Whether no two stand at the same place."""
        return bool((np.diff(self.places) > 0).all())

    @property
    def line(self) -> bool:
        """Whether the values can be joined by a line."""
        return self.apart and self.joined and not self.texts

    @property
    def log(self) -> bool:
        """Whether the values lie more evenly on a logarithmic axis."""
        at = np.unique(self.places)
        if len(at) < 3 or at[0] <= 0 or at[-1] < 3 * at[0]:
            return False
        steps = np.diff(at)
        factors = np.diff(np.log(at))
        return bool(factors.max() / factors.min() < steps.max() / steps.min())


@frozen(eq=False)
class Line:
    """A line of `sweep_lines`.

    Attributes
    ----------
    values : array, shape (p,)
        Not a number where there is none.
    label : str
        Its name; empty for the only line.
    low, high : array, shape (p,), or None
        Bounds of the true value; not a number where they are not known, which makes the mark hollow.
    """

    values: FloatArray
    label: str = ""
    low: FloatArray | None = None
    high: FloatArray | None = None


def sweep_lines(
    ax: Axes,
    x: Along,
    lines: Sequence[Line],
    name: str,
    unit: str = "",
    band: str = "",
    regimes: Mapping[str, FloatArray] | None = None,
) -> Axes:
    """A quantity over one axis of a sweep, a line for each of a few values of another; marks where places repeat.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    x : Along
        The axis, as long as each line.
    lines : sequence of Line
        One at least. Points without a value are crosses at the bottom.
    name, unit : str
        Of the quantity.
    band : str
        The name of the bounds.
    regimes : mapping of str to array, shape (p,), optional
        As for `sweep_map`.
    """
    for index, line in enumerate(lines):
        _line(ax, x, line, index, band)
    values = np.stack([line.values for line in lines])
    lost = np.isnan(values)
    if lost.any():
        where = lost.any(axis=0)
        label = f"no value ({int(lost.sum())} of {lost.size})"
        bottom = np.full(int(where.sum()), 0.02)
        ax.plot(x.places[where], bottom, "kx", markersize=4, label=label, transform=ax.get_xaxis_transform())
    _axis(ax, "x", x)
    if regimes:
        _borders(ax, x, regimes)
    found = values[~lost]
    if found.size and found.min() > 0 and found.max() > 10**_DECADES * found.min():
        decades(ax, "y")
    elif found.size and found.min() >= 0:
        # marks are not cut
        ax.set_ylim(0.0, max(ax.get_ylim()[1], 1.05 * float(found.max())))
    label_axis(ax, "y", name, unit, float(np.abs(found).max(initial=0.0)))
    handles, labels = ax.get_legend_handles_labels()
    # what several lines have in common stands once
    entries = dict(zip(reversed(labels), reversed(handles), strict=True))
    key(ax, reversed(entries.values()), reversed(entries))
    return dress(ax)


def _line(ax: Axes, x: Along, line: Line, index: int, band: str) -> None:
    """A line with its marks, hollow where bounds are not known, and its bounds as a shade, or as strokes."""
    colour = COLOURS[index % len(COLOURS)]
    marker = MARKERS[index % len(MARKERS)]
    look: dict[str, Any] = {"color": colour, "markersize": 3}
    style = LINES[index % len(LINES)] if x.line else ""
    marked = "" if x.line and len(x.values) > _MARKS else marker
    label = literal(line.label) or None
    ax.plot(x.places, line.values, linestyle=style, marker=marked, linewidth=1.2, label=label, **look)
    if line.low is None or line.high is None:
        return
    unknown = np.isfinite(line.values) & np.isnan(line.low)
    band = band if np.isfinite(line.low).any() else "_"  # left out of the key
    if x.line:
        ax.fill_between(x.places, line.low, line.high, color=colour, alpha=0.2, linewidth=0, label=band)
    else:
        ax.vlines(x.places, line.low, line.high, color=colour, alpha=0.2, linewidth=3, label=band)
    if unknown.any():
        places = x.places[unknown]
        values = line.values[unknown]
        ax.plot(places, values, marker, markerfacecolor="white", label="error not known", **look)


def _borders(ax: Axes, x: Along, regimes: Mapping[str, FloatArray]) -> None:
    """Where regimes begin and end, and the names of those that have room for it at the top."""
    at = np.log(x.places) if x.log else x.places
    for name, inside in regimes.items():
        turns = np.flatnonzero(np.diff(np.signbit(inside)))
        ends = at[turns] + np.diff(at)[turns] * inside[turns] / (inside[turns] - inside[turns + 1])
        for end in np.exp(ends) if x.log else ends:
            ax.axvline(end, color=GREY, linewidth=0.8, linestyle="--")
        own = np.flatnonzero(inside < 0)
        if len(own) > 3 * NAMED * len(inside):
            named(ax, x.places[own[len(own) // 2]], 0.985, name, va="top", xycoords=ax.get_xaxis_transform())


# ---------------------------------------------------------------- maps


def sweep_map(
    ax: Axes,
    x: Along,
    y: Along,
    values: FloatArray,
    name: str,
    unit: str,
    regimes: Mapping[str, FloatArray],
    unknown: npt.NDArray[np.bool_] | None,
) -> Axes:
    """A quantity over two axes of a sweep: colours, lines of equal value, and borders of regimes.

    Parameters
    ----------
    ax : Axes
        Where to draw; a scale of colours is put beside it.
    x, y : Along
        The axes, of two values or more.
    values : array, shape (x, y)
        Not a number where there is none, which is left grey and hatched.
    name, unit : str
        Of the quantity. One that takes both signs has colours on both sides of white.
    regimes : mapping of str to array, shape (x, y)
        Names, and numbers that are below 0 within that regime and above outside.
    unknown : array of bool, shape (x, y), optional
        Where the error of the value is not known, which is dotted.
    """
    lost = np.isnan(values)
    edges = edges_of(x.places, x.log), edges_of(y.places, y.log)
    ax.set_facecolor(NO_VALUE)
    masked = np.ma.masked_invalid(values)
    drawn = ax.pcolormesh(*edges, masked.T, rasterized=True, shading="flat", **_colours(values[~lost]))
    ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
    _axis(ax, "x", x)
    _axis(ax, "y", y)
    bar = scale(ax, drawn, name, unit)
    # between names there is nothing to draw a line through
    if not (lost.all() or x.texts or y.texts):
        levels = [level for level in bar.get_ticks() if masked.min() < level < masked.max()]
        if levels:
            ax.contour(x.places, y.places, masked.T, levels=levels, colors=[GREY], linewidths=0.5)
    places = []
    for axis, of in enumerate((x, y)):
        at = of.places
        if of.texts:  # borders run along the cells of names
            at = np.ravel([at - 0.499, at + 0.499], order="F")
            regimes = {regime: inside.repeat(2, axis) for regime, inside in regimes.items()}
        places.append(at)
    regions(ax, places[0], places[1], regimes)
    handles = hatch(ax, edges, lost, "no value", "//////", NO_VALUE)
    if unknown is not None:
        handles += hatch(ax, edges, unknown & ~lost, "error not known", "....")
    key(ax, handles, [str(handle.get_label()) for handle in handles])
    return dress(ax, grid=False)


def _colours(known: FloatArray) -> dict[str, Any]:
    """Map and norm of the colours of values."""
    from matplotlib.colors import LogNorm, Normalize, SymLogNorm

    least, most = (known.min(), known.max()) if known.size else (0.0, 1.0)
    if least < 0 < most:
        limit = max(-least, most)
        usual = np.median(np.abs(known))
        if 0 < usual * 10**_DECADES < limit * 10:
            return {"norm": SymLogNorm(10.0 ** round(math.log10(usual)), vmin=-limit, vmax=limit), "cmap": SIGNED}
        return {"norm": Normalize(-limit, limit), "cmap": SIGNED}
    wide = least > 0 and most > 10**_DECADES * least
    return {"norm": (LogNorm if wide else Normalize)(least, most), "cmap": FIELD}


def _axis(ax: Axes, axis: Literal["x", "y"], of: Along) -> None:
    """Scale, ticks and label of an axis."""
    if of.texts:
        every = -(-len(of.values) // _TICKS)
        chosen = ax.xaxis if axis == "x" else ax.yaxis
        slanted: dict[str, Any] = {"rotation": 30, "ha": "right"} if axis == "x" else {}
        chosen.set_ticks(of.places[::every], [literal(str(value)) for value in of.values[::every]], **slanted)
    elif of.log:
        decades(ax, axis)
    label_axis(ax, axis, of.name, of.unit, float(np.abs(of.places).max()))
