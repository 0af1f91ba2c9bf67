"""Results of a sweep: lines over one axis, a map over two, with the borders of the regimes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from attrs import field, frozen

from shockwave.errors import InvalidValueError
from shockwave.pictures.plane import border, edges_of, hatch, inmost
from shockwave.pictures.style import (
    BLACK,
    COLOURS,
    FIELD,
    GREY,
    LABEL,
    LINES,
    MARKERS,
    SIGNED,
    SMALL,
    decades,
    dress,
    key,
    measure,
    ratio,
    scale,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.quadrature import FloatArray

    Edges: TypeAlias = tuple[FloatArray, FloatArray]

__all__ = ["Along", "Line", "sweep_lines", "sweep_map"]

# A regime that takes fewer cells than this share has no name in the picture.
_ROOM = 0.03
# Values over more than so many decades have colours by their logarithm.
_DECADES = 2.5
# A band narrower than this share of its line is no more than the line.
_VISIBLE = 2e-3
_LOST = "#BDBDBD"
# Names of regimes along a line are so far apart, of its width.
_APART = 0.12
# More names than this would cover each other.
_TICKS = 25


@frozen(eq=False)
class Along:
    """What an axis of a picture stands for.

    Attributes
    ----------
    values : array, shape (p,)
        Ascending, in SI units, for `sweep_lines` with repetitions too; or texts, which stand side by side.
    name, unit : str
        What it is; its SI unit, empty for a number without one.
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
        What it is called; empty for the only line.
    low, high : array, shape (p,), or None
        Between what the value is known to lie; not a number where that is not known, which makes the mark hollow.
    band : str
        What that is called.
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
        if self.low is None:
            return np.zeros(self.values.shape, dtype=bool)
        return np.isfinite(self.values) & np.isnan(self.low)


def sweep_lines(ax: Axes, x: Along, lines: Sequence[Line], name: str, unit: str = "") -> Axes:
    """A quantity over one axis of a sweep, a line for each of a few values of another; marks where places repeat.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    x : Along
        What it is drawn over.
    lines : sequence of Line
        Points without a value are crosses at the bottom.
    name, unit : str
        Of the quantity.

    Raises
    ------
    InvalidValueError
        When there is no line, or one is of another length than ``x``.
    """
    for line in lines or [Line(np.empty(0))]:
        if line.values.shape != x.places.shape:
            raise InvalidValueError.of("lines", f"must be of {len(x.values)} values (got {line.values.shape})")
    known = np.concatenate([line.values for line in lines])
    for at, line in enumerate(lines):
        _line(ax, x, line, COLOURS[at % len(COLOURS)], LINES[at % len(LINES)], MARKERS[at % len(MARKERS)])
    _lost(ax, x, lines)
    _axis(ax, "x", x)
    if len(lines) == 1 and not x.texts and x.apart and x.joined:
        _spans(ax, x, lines[0].regimes)
    _quantity(ax, known, name, unit)
    _key(ax, lines)
    return dress(ax)


def _lost(ax: Axes, x: Along, lines: Sequence[Line]) -> None:
    """Crosses for points without a value."""
    lost = np.isnan(np.stack([line.values for line in lines]))
    if lost.any():
        where = lost.any(axis=0)
        label = f"no value ({int(lost.sum())} of {lost.size})"
        look: dict[str, Any] = {"color": BLACK, "markersize": 4, "transform": ax.get_xaxis_transform()}
        ax.plot(x.places[where], np.full(where.sum(), 0.02), "x", label=label, **look)


def _key(ax: Axes, lines: Sequence[Line]) -> None:
    """What lines and marks are; what several lines have in common once, and grey."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles, labels = ax.get_legend_handles_labels()
    entries = dict(zip(labels, handles, strict=True))
    unknown = sum(int(line.unknown.sum()) for line in lines)
    if unknown:
        mark = Line2D([], [], linestyle="", marker="o", markersize=3, color=GREY, markerfacecolor="white")
        entries[f"error not known ({unknown} of {sum(line.values.size for line in lines)})"] = mark
    if len(lines) > 1 and entries.pop(lines[0].band, None):
        entries[lines[0].band] = Patch(color=GREY, alpha=0.2, linewidth=0)
    key(ax, entries.values(), entries)


def _line(ax: Axes, x: Along, line: Line, colour: str, style: Any, marker: str) -> None:
    joined = x.apart and x.joined and not x.texts
    ax.plot(
        x.places,
        line.values,
        linestyle=style if joined else "",
        marker="" if joined and len(x.values) > 30 else marker,
        color=colour,
        linewidth=1.2,
        markersize=3,
        label=_literal(line.label) or None,
    )
    if line.low is None or line.high is None:
        return
    unknown = line.unknown
    if unknown.any():
        hollow: dict[str, Any] = {"linestyle": "", "marker": marker, "markersize": 3, "markerfacecolor": "white"}
        ax.plot(x.places[unknown], line.values[unknown], color=colour, **hollow)
    if (line.high - line.low > _VISIBLE * np.abs(line.values)).any():
        known = np.isfinite(line.low) & np.isfinite(line.high)
        beside = np.pad(known, 1)
        alone = known & ~(joined & (beside[:-2] | beside[2:]))
        if (known & ~alone).any():
            ax.fill_between(x.places, line.low, line.high, color=colour, alpha=0.2, linewidth=0, label=line.band)
        if alone.any():
            # the shade of a place without neighbours would be of no width
            bounds = line.low[alone], line.high[alone]
            ax.vlines(x.places[alone], *bounds, color=colour, alpha=0.2, linewidth=3, label=line.band)


def _quantity(ax: Axes, known: FloatArray, name: str, unit: str) -> None:
    found = known[np.isfinite(known)]
    if found.size and found.min() > 0 and found.max() > 10**_DECADES * found.min():
        decades(ax, "y")
    elif found.size and found.min() >= 0:
        # marks are not cut
        ax.set_ylim(0.0, max(ax.get_ylim()[1], 1.05 * float(found.max())))
    if unit:
        measure(ax, "y", float(np.abs(found).max(initial=0.0)), unit, name)
    else:
        ratio(ax, "y", name)


def _spans(ax: Axes, x: Along, regimes: Mapping[str, FloatArray]) -> None:
    """Where regimes begin and end, and their names at the top."""
    from matplotlib.patheffects import withStroke

    at = np.log(x.places) if x.log else x.places
    taken: list[float] = []
    for name, inside in regimes.items():
        turns = np.flatnonzero(np.diff(np.signbit(inside)))
        ends = at[turns] + (at[turns + 1] - at[turns]) * inside[turns] / (inside[turns] - inside[turns + 1])
        for end in ends.tolist():
            ax.axvline(np.exp(end) if x.log else end, color=GREY, linewidth=0.8, linestyle="--")
        own = inside < 0
        middle = float(x.places[inmost(own[:, None])[0]]) if own.any() else 0.0
        shown = float(ax.get_xaxis_transform().transform((middle, 0.0))[0] / ax.bbox.width)
        if own.mean() > _ROOM * 3 and all(abs(shown - other) > _APART for other in taken):
            taken.append(shown)
            halo = [withStroke(linewidth=2.0, foreground="white")]
            top: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": SMALL, "path_effects": halo}
            ax.text(middle, 0.985, name, transform=ax.get_xaxis_transform(), **top)


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
    field, inside = np.asarray(values, dtype=float), {n: np.asarray(r, dtype=float) for n, r in (regimes or {}).items()}
    for what, array in (("values", field), *inside.items()):
        if array.shape != (len(x.values), len(y.values)) or min(array.shape) < 2:
            rule = f"must have the shape (x, y) = ({len(x.values)}, {len(y.values)}), two at least along both"
            raise InvalidValueError.of(what, f"{rule} (got {array.shape})")
    lost = np.isnan(field)
    edges = edges_of(x.places, x.log), edges_of(y.places, y.log)
    ax.set_facecolor(_LOST)
    masked = np.ma.masked_invalid(field)
    drawn = ax.pcolormesh(*edges, masked.T, rasterized=True, shading="flat", **_colours(field))
    _axis(ax, "x", x, edges[0])
    _axis(ax, "y", y, edges[1])
    bar = scale(ax, drawn)
    if unit:
        _, largest = drawn.get_clim()
        measure(bar.ax, "y", largest, unit, name)
    else:
        bar.set_label(name)
    bar.ax.yaxis.label.set_fontsize(LABEL)
    # between names there is nothing to draw a line through
    if not (lost.all() or x.texts or y.texts):
        levels = [level for level in bar.get_ticks() if np.nanmin(field) < level < np.nanmax(field)]
        if levels:
            ax.contour(x.places, y.places, masked.T, levels=levels, colors=[GREY], linewidths=0.5)
    _borders(ax, x, y, edges, inside)
    looks = [hatch(ax, edges, lost, "no value", "//////", _LOST)]
    if unknown is not None:
        looks.append(hatch(ax, edges, unknown & ~lost, "error not known", "....", "none"))
    handles = [look for look in looks if look is not None]
    key(ax, handles, [str(look.get_label()) for look in handles])
    return dress(ax, grid=False)


def _colours(values: FloatArray) -> dict[str, Any]:
    """How values become colours."""
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
    if least > 0 and most > 10**_DECADES * least:
        return {"norm": LogNorm(least, most), "cmap": FIELD}
    return {"norm": Normalize(least, most), "cmap": FIELD}


def _borders(ax: Axes, x: Along, y: Along, edges: Edges, regimes: Mapping[str, FloatArray]) -> None:
    """Borders of regimes, and their names."""
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.2, foreground="white")]
    shares = {name: float(np.mean(inside < 0)) for name, inside in regimes.items()}
    # the borders of all but one are those of that one, too: of the narrowest, which would come out worst
    spare = min(shares, key=lambda name: shares[name], default="")
    for name, inside in regimes.items():
        if 0 < shares[name] < 1 and (name != spare or len(regimes) == 1):
            if x.texts or y.texts:
                border(ax, edges, inside < 0)
            else:
                ax.contour(x.places, y.places, inside.T, levels=[0.0], colors=[BLACK], linewidths=1.2)
    for name, inside in regimes.items():
        if not shares[name]:
            continue
        i, j = inmost(inside < 0)
        look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": SMALL, "path_effects": halo, "zorder": 5}
        if shares[name] >= _ROOM:
            ax.text(x.places[i], y.places[j], name, **look)
        else:  # its name stands beside it, on the side where there is more room
            side = -1 if 2 * i > len(x.places) else 1
            arrow = {"arrowstyle": "-", "linewidth": 0.6, "shrinkA": 1, "shrinkB": 0}
            place: Any = (x.places[i], y.places[j])
            ax.annotate(name, place, (side * 34, -14), textcoords="offset points", arrowprops=arrow, **look)


def _axis(ax: Axes, axis: Literal["x", "y"], of: Along, edges: FloatArray | None = None) -> None:
    """Scale, limits, ticks and label of an axis."""
    if edges is not None:
        (ax.set_xlim if axis == "x" else ax.set_ylim)(float(edges[0]), float(edges[-1]))
    if of.texts:
        every = -(-len(of.values) // _TICKS)
        places, texts = of.places[::every], [_literal(str(value)) for value in of.values[::every]]
        if axis == "x":
            ax.set_xticks(places, texts, rotation=30, ha="right")
        else:
            ax.set_yticks(places, texts)
    elif of.log:
        decades(ax, axis)
    if of.unit:
        measure(ax, axis, float(np.abs(of.places).max()), of.unit, of.name)
    else:
        ratio(ax, axis, of.name)


def _literal(text: str) -> str:
    """A user's words, which are no mathematics."""
    return text.replace("$", r"\$")
