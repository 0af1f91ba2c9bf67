"""Results of a sweep: lines over one axis, a map over two, with the borders of the regimes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
from attrs import field, frozen

from shockwave.pictures.axes import decades, dress, key, label_axis, named, scale
from shockwave.pictures.cells import NAMED, NO_VALUE, check_shapes, edges_of, hatch, inmost, regions
from shockwave.pictures.style import COLOURS, FIELD, GREY, LINES, MARKERS, SIGNED, literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.quadrature import FloatArray


# Values over more decades than this have a logarithmic scale.
_DECADES = 2.5
# A band narrower than this share of its line is no more than the line.
_VISIBLE = 2e-3
# Names of regimes along a line are so far apart, as a share of its width.
_APART = 0.12
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
    def places(self) -> FloatArray:
        """Where the values are drawn."""
        return np.arange(len(self.values), dtype=float) if self.texts else np.asarray(self.values, dtype=float)

    @property
    def texts(self) -> bool:
        """Whether the values are texts."""
        return self.values.dtype.kind not in "fiu"

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
        steps, factors = np.diff(at), np.diff(np.log(at))
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
    band : str
        The name of the bounds.
    regimes : mapping of str to array, shape (p,)
        As for `sweep_map`; drawn for the only line.
    """

    values: FloatArray
    label: str = ""
    low: FloatArray | None = None
    high: FloatArray | None = None
    band: str = "expected"
    regimes: Mapping[str, FloatArray] = field(factory=dict)

    @property
    def unknown(self) -> npt.NDArray[np.bool_]:
        """Where the value has no bounds, though others have."""
        return np.isfinite(self.values) & np.isnan(self.values if self.low is None else self.low)


def sweep_lines(ax: Axes, x: Along, lines: Sequence[Line], name: str, unit: str = "") -> Axes:
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
    """
    for index, line in enumerate(lines):
        _line(ax, x, line, index)
    values = np.stack([line.values for line in lines])
    lost = np.isnan(values)
    if lost.any():
        where, label = lost.any(axis=0), f"no value ({int(lost.sum())} of {lost.size})"
        bottom = np.full(int(where.sum()), 0.02)
        ax.plot(x.places[where], bottom, "kx", markersize=4, label=label, transform=ax.get_xaxis_transform())
    _axis(ax, "x", x)
    if len(lines) == 1 and x.line:
        _spans(ax, x, lines[0].regimes)
    found = values[np.isfinite(values)]
    if found.size and found.min() > 0 and found.max() > 10**_DECADES * found.min():
        decades(ax, "y")
    elif found.size and found.min() >= 0:
        # marks are not cut
        ax.set_ylim(0.0, max(ax.get_ylim()[1], 1.05 * float(found.max())))
    label_axis(ax, "y", name, unit, float(np.abs(found).max(initial=0.0)))
    _key(ax, lines)
    return dress(ax)


def _line(ax: Axes, x: Along, line: Line, index: int) -> None:
    colour, marker = COLOURS[index % len(COLOURS)], MARKERS[index % len(MARKERS)]
    ax.plot(
        x.places,
        line.values,
        linestyle=LINES[index % len(LINES)] if x.line else "",
        marker="" if x.line and len(x.values) > _MARKS else marker,
        color=colour,
        linewidth=1.2,
        markersize=3,
        label=literal(line.label) or None,
    )
    if line.low is None or line.high is None:
        return
    unknown = line.unknown
    if unknown.any():
        at = x.places[unknown], line.values[unknown]
        ax.plot(*at, linestyle="", marker=marker, markersize=3, markerfacecolor="white", color=colour)
    if (line.high - line.low > _VISIBLE * np.abs(line.values)).any():
        _band(ax, x, line, colour)


def _band(ax: Axes, x: Along, line: Line, colour: str) -> None:
    """The bounds of a line as a shade; as a stroke at places without neighbours, where a shade has no width."""
    low, high = np.asarray(line.low), np.asarray(line.high)
    known = np.isfinite(low) & np.isfinite(high)
    beside = np.pad(known, 1)
    shaded = known & x.line & (beside[:-2] | beside[2:])
    alone = known & ~shaded
    if shaded.any():
        ax.fill_between(x.places, low, high, color=colour, alpha=0.2, linewidth=0, label=line.band)
    if alone.any():
        ax.vlines(x.places[alone], low[alone], high[alone], color=colour, alpha=0.2, linewidth=3, label=line.band)


def _key(ax: Axes, lines: Sequence[Line]) -> None:
    """The meaning of lines and marks; what several lines have in common once, and grey."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles, labels = ax.get_legend_handles_labels()
    entries = dict(zip(labels, handles, strict=True))
    unknown = sum(int(line.unknown.sum()) for line in lines if line.low is not None)
    if unknown:
        mark = Line2D([], [], linestyle="", marker="o", markersize=3, color=GREY, markerfacecolor="white")
        entries[f"error not known ({unknown} of {sum(line.values.size for line in lines)})"] = mark
    if len(lines) > 1 and entries.pop(lines[0].band, None):
        entries[lines[0].band] = Patch(color=GREY, alpha=0.2, linewidth=0)
    key(ax, entries.values(), entries)


def _spans(ax: Axes, x: Along, regimes: Mapping[str, FloatArray]) -> None:
    """Where regimes begin and end, and their names at the top."""
    at = np.log(x.places) if x.log else x.places
    taken: list[float] = []
    for name, inside in regimes.items():
        turns = np.flatnonzero(np.diff(np.signbit(inside)))
        ends = at[turns] + (at[turns + 1] - at[turns]) * inside[turns] / (inside[turns] - inside[turns + 1])
        for end in ends.tolist():
            ax.axvline(math.exp(end) if x.log else end, color=GREY, linewidth=0.8, linestyle="--")
        own = inside < 0
        if own.mean() <= 3 * NAMED:
            continue
        middle = float(x.places[inmost(own[:, None])[0]])
        shown = float(ax.get_xaxis_transform().transform((middle, 0.0))[0] / ax.bbox.width)
        if all(abs(shown - other) > _APART for other in taken):
            taken.append(shown)
            named(ax, middle, 0.985, name, va="top", xycoords=ax.get_xaxis_transform())


# ---------------------------------------------------------------- maps


def sweep_map(
    ax: Axes,
    x: Along,
    y: Along,
    values: npt.ArrayLike,
    name: str,
    unit: str = "",
    regimes: Mapping[str, npt.ArrayLike] | None = None,
    unknown: npt.NDArray[np.bool_] | None = None,
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
    regimes : mapping of str to array, shape (x, y), optional
        Names, and numbers that are below 0 within that regime and above outside.
    unknown : array of bool, shape (x, y), optional
        Where the error of the value is not known, which is dotted.

    Raises
    ------
    InvalidValueError
        When shapes do not fit, or there are not two values or more along each axis.
    """
    field = np.asarray(values, dtype=float)
    inside = {regime: np.asarray(numbers, dtype=float) for regime, numbers in (regimes or {}).items()}
    check_shapes({"values": field, **inside}, x.places, y.places)
    lost = np.isnan(field)
    edges = edges_of(x.places, x.log), edges_of(y.places, y.log)
    ax.set_facecolor(NO_VALUE)
    masked = np.ma.masked_invalid(field)
    drawn = ax.pcolormesh(*edges, masked.T, rasterized=True, shading="flat", **_colours(field))
    ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
    _axis(ax, "x", x)
    _axis(ax, "y", y)
    bar = scale(ax, drawn, name, unit)
    # between names there is nothing to draw a line through
    if not (lost.all() or x.texts or y.texts):
        levels = [level for level in bar.get_ticks() if np.nanmin(field) < level < np.nanmax(field)]
        if levels:
            ax.contour(x.places, y.places, masked.T, levels=levels, colors=[GREY], linewidths=0.5)
    regions(ax, x.places, y.places, inside, edges if x.texts or y.texts else None)
    handles = hatch(ax, edges, lost, "no value", "//////", NO_VALUE)
    if unknown is not None:
        handles += hatch(ax, edges, unknown & ~lost, "error not known", "....")
    key(ax, handles, [str(handle.get_label()) for handle in handles])
    return dress(ax, grid=False)


def _colours(values: FloatArray) -> dict[str, Any]:
    """Map and norm of the colours of values."""
    from matplotlib.colors import LogNorm, Normalize, SymLogNorm

    known = values[np.isfinite(values)]
    least, most = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    if least < 0 < most:
        limit, usual = max(-least, most), float(np.median(np.abs(known)))
        if 0 < usual * 10**_DECADES < limit * 10:
            norm: Any = SymLogNorm(10.0 ** round(math.log10(usual)), vmin=-limit, vmax=limit)
        else:
            norm = Normalize(-limit, limit)
        return {"norm": norm, "cmap": SIGNED}
    wide = least > 0 and most > 10**_DECADES * least
    return {"norm": (LogNorm if wide else Normalize)(least, most), "cmap": FIELD}


def _axis(ax: Axes, axis: Literal["x", "y"], of: Along) -> None:
    """Scale, ticks and label of an axis."""
    if of.texts:
        every = -(-len(of.values) // _TICKS)
        texts = [literal(str(value)) for value in of.values[::every]]
        if axis == "x":
            ax.set_xticks(of.places[::every], texts, rotation=30, ha="right")
        else:
            ax.set_yticks(of.places[::every], texts)
    elif of.log:
        decades(ax, axis)
    label_axis(ax, axis, of.name, of.unit, float(np.abs(of.places).max()))
