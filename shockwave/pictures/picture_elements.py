"""Common elements of pictures: colours, settings, axis labels, legends, colour bars, shaded areas, names, marks."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from shockwave.base.numerics import FloatArray
from shockwave.base.text import si

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
else:  # what draws nothing does not need matplotlib
    Axes = Any


# Okabe and Ito, "Color universal design" (2008), without yellow, and with darker hues of orange and of sky blue.
BLACK = "#000000"
BLUE = "#0072B2"
VERMILION = "#D55E00"
GREEN = "#009E73"
OCHRE = "#AB8C4D"
SKY = "#4A95F7"
PURPLE = "#CC79A7"
GREY = "#767676"
COLOURS = (BLUE, GREEN, PURPLE, OCHRE, SKY, VERMILION, GREY)
#: Colour of a number by its origin, the same in every picture. They are distinct under deuteranopia, protanopia and
#: tritanopia, and their contrast to white and to black is at least 3. A limit has the colour of the text.
METHODS: Mapping[str, str] = MappingProxyType(
    {"simulation": BLUE, "section 4": VERMILION, "shock": GREY, "warning": "#C0002A", "elastic": "#9030F0"}
)
# Colour of a warning on a dark background.
_LIGHT_RED = "#FF7A7A"
#: Points per inch; a point is the unit of SVG files.
POINTS = 72
#: Size of small text [pt], legible in a column.
SMALL = 7.0
#: Name and unit of a number along an axis; a name alone has its usual unit.
Label: TypeAlias = str | tuple[str, str]
# Units of numbers along an axis, by their names.
_UNITS = {
    **dict.fromkeys(("time", "run time"), "s"),
    **dict.fromkeys(("force", "contact force", "greatest force", "peak force"), "N"),
    "overlap": "m",
    "energy": "J",
}
#: Line styles and markers distinguish lines without colour.
LINES: tuple[Any, ...] = ("-", "--", "-.", (0, (1, 1)), (0, (5, 1, 1, 1, 1, 1)), (0, (7, 2)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*")
#: Colour maps for quantities of one sign and of both signs; monotonic in lightness on each side of zero.
FIELD = "magma_r"
SIGNED = "RdBu_r"
MINUS = "\N{MINUS SIGN}"
# Ratio of the limits of a logarithmic axis above which its ticks are powers of ten.
_FEW_DECADES = 2000.0
# Limits of a logarithmic axis without a unit whose ticks are plain numbers in any case.
_PLAIN = 1e-3, 1e3
# Fewest labelled ticks of a logarithmic axis.
_FEWEST_TICKS = 3
# The legend is placed directly above the axes.
_LEGEND: dict[str, Any] = {
    "loc": "lower left",
    "bbox_to_anchor": (0.0, 1.0),
    "borderpad": 0.0,
    "columnspacing": 1.2,
    "frameon": False,
    "handlelength": 2.0,
    "handletextpad": 0.8,
}
# Most points of a drawn line or area.
_MOST_POINTS = 800
# Least visible deviation from the last value, over the range of all curves; end of the time axis over the time of the
# last visible deviation; the axis is cut only if it then ends before this share of the whole time.
_SEEN = 0.01
_MARGIN = 1.2
_MOSTLY = 0.6
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def si_label(value: float, unit: str, digits: int = 3, error: float | None = None) -> str:
    """Return ``value`` with an SI prefix like `si`, but with the micro sign and raised exponents."""
    text = si(value, unit, digits, error).replace(f" u{unit}", f" \N{MICRO SIGN}{unit}")
    return re.sub(r"(?:\^|\*\*)(-?\d)", lambda power: power[1].translate(_RAISED), text)


def style(dark: bool = False) -> dict[Any, Any]:
    """Return the settings of matplotlib that all pictures of this package use.

    Other pictures use them within ``matplotlib.style.context(["default", pictures.style()])``.

    Parameters
    ----------
    dark : bool
        Whether the background is dark.
    """
    paper, ink, grid = ("#121212", "#F2F2F2", "#4A4A4A") if dark else ("#FFFFFF", BLACK, "#D9D9D9")
    return {
        "axes.axisbelow": True,
        "axes.grid": True,
        "axes.prop_cycle": f"cycler('color', {[colour.removeprefix('#') for colour in COLOURS]})",
        "grid.color": grid,
        "grid.linewidth": 0.4,
        "legend.fontsize": SMALL,
        "legend.frameon": False,
        **dict.fromkeys(("axes.spines.right", "axes.spines.top"), False),
        **dict.fromkeys(("axes.facecolor", "figure.facecolor"), paper),
        **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "text.color", "xtick.color", "ytick.color"), ink),
        **dict.fromkeys(("axes.linewidth", "xtick.major.width", "ytick.major.width"), 0.6),
        **dict.fromkeys(("axes.labelsize", "axes.titlesize"), 8.0),
        **dict.fromkeys(("font.size", "xtick.labelsize", "ytick.labelsize"), SMALL),
    }


def ink() -> str:
    """Return the colour of text and of outlines: black, or a light one in a dark picture."""
    from matplotlib import rcParams

    return str(rcParams["text.color"])


def field_colours() -> str:
    """Return the colour map of a quantity of one sign: zero has nearly the colour of the background."""
    return FIELD if ink() == BLACK else FIELD.removesuffix("_r")


def paper() -> Any:
    """Return the colour of the background."""
    from matplotlib import rcParams

    return rcParams["axes.facecolor"]


def series(index: int, marked: bool = False) -> dict[str, Any]:
    """Return colour, line style and, if it is ``marked``, marker of one line among others."""
    marker = MARKERS[index % len(MARKERS)] if marked else ""
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": LINES[index % len(LINES)], "marker": marker}


def literal(text: str) -> str:
    """Return ``text`` as a label in which a dollar sign does not begin a formula."""
    return text.replace("$", r"\$")


def label_axis(ax: Axes, axis: Literal["x", "y"], label: Label) -> None:
    """Label an axis with its name and unit, with an SI prefix in label and ticks; scale and limits must be final."""
    from matplotlib.text import Text
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator, ScalarFormatter

    name, unit = (label, _UNITS.get(label, "")) if isinstance(label, str) else label
    chosen = ax.xaxis if axis == "x" else ax.yaxis
    low, high = ax.get_xlim() if axis == "x" else ax.get_ylim()
    logarithmic = chosen.get_scale() == "log"
    few = logarithmic and (high < _FEW_DECADES * low or (not unit and _PLAIN[0] <= low < high <= _PLAIN[1]))
    factor = 1.0
    chosen.set_minor_locator(NullLocator())  # more lines than a column can hold, each as expensive as a label
    if few:
        fit = 3 * math.log10(high / low) <= chosen.get_tick_space()
        locator = LogLocator(subs=(1.0, 2.0, 5.0) if fit else (1.0,))
        ticks = np.asarray(locator.tick_values(low, high))
        enough = np.count_nonzero((ticks >= low) & (ticks <= high)) >= _FEWEST_TICKS
        chosen.set_major_locator(locator if enough else MaxNLocator(_FEWEST_TICKS + 1, steps=[1, 2, 5, 10]))
    elif logarithmic:  # a formula for each tick would take longer than the rest of the axis
        raised = FuncFormatter(lambda value, _: "10" + str(round(math.log10(value))).translate(_RAISED))
        chosen.set_major_formatter(raised)
    if few or isinstance(chosen.get_major_formatter(), ScalarFormatter):
        largest = max(abs(low), abs(high))
        number, _, unit = si_label(largest, unit, 9).partition(" ")
        factor = 10.0 ** round(math.log10(largest / float(number)))
        chosen.set_major_formatter(FuncFormatter(lambda value, _: f"{value / factor:.6g}".replace("-", MINUS)))
    chosen.set_label_text(f"{name} ({unit})" if unit else name)
    for text in chosen.findobj(Text):  # LaTeX does not know all characters; new ticks are copies of the first
        text.set_usetex(False)


def add_legend(ax: Axes, entries: Iterable[Any]) -> None:
    """Add a legend above the axes, in as many columns as fit; inside if no layout engine makes room for it."""
    from matplotlib import rcParams
    from matplotlib.cbook import is_math_text
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    handles, font, figure = list(entries), FontProperties(size=rcParams["legend.fontsize"]), ax.get_figure()
    if not handles or figure is None:
        return
    if figure.get_layout_engine() is None:
        ax.legend(handles=handles)
        return
    size = font.get_size_in_points()
    labels = [str(handle.get_label()) for handle in handles]
    texts = [text_to_path.get_text_width_height_descent(label, font, is_math_text(label))[0] for label in labels]
    widths = np.array(texts) + size * (_LEGEND["handlelength"] + _LEGEND["handletextpad"] + _LEGEND["columnspacing"])
    room = POINTS * ax.bbox.width / figure.dpi + size * _LEGEND["columnspacing"]
    fitting = (n for n in range(len(handles), 1, -1) if sum(map(max, np.array_split(widths, n))) <= room)
    _keep_above(ax, ax.legend(handles=handles, ncols=next(fitting, 1), **_LEGEND))


def _keep_above(ax: Axes, artist: Any) -> None:
    """Keep a title of ``ax`` above an artist, which has axes of its own: matplotlib moves titles above such axes."""
    from matplotlib.axes import Axes

    room = Axes(ax.figure, (0, 0, 1, 1))
    room.set_axis_off()
    back = ax.figure.transSubfigure.inverted
    room.set_axes_locator(lambda _, renderer: artist.get_window_extent(renderer).transformed(back()))
    ax.add_child_axes(room)


def colour_scale(ax: Axes, drawn: Any, label: Label) -> Any:
    """Return a new labelled colour bar for ``drawn`` at the right of ``ax``."""
    from matplotlib.colors import TwoSlopeNorm
    from matplotlib.ticker import MaxNLocator

    figure = ax.get_figure()
    assert figure is not None
    # an inset, so that a layout engine keeps it next to its axes; without one, it takes room from them
    inset = ax.inset_axes((1.03, 0.0, 0.04, 1.0)) if figure.get_layout_engine() else None
    bar = figure.colorbar(drawn, cax=inset, ax=ax)
    label_axis(bar.ax, "y", label)
    if isinstance(drawn.norm, TwoSlopeNorm):  # round numbers in both halves
        locator, ends = MaxNLocator(_FEWEST_TICKS + 1), [float(drawn.norm.inverse(at)) for at in (0, 0.5, 1)]
        halves = pairwise(ends)
        bar.set_ticks([at for low, high in halves for at in locator.tick_values(low, high) if low <= at <= high])
    bar.ax.yaxis.label.set_fontsize(ax.yaxis.label.get_fontsize())
    return bar


def halo() -> list[Any]:
    """Return the outline of text and lines on coloured areas."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=2.0, foreground=paper())]


def mark_warnings(ax: Axes, results: Iterable[Any]) -> None:
    """Mark a picture of ``results`` with the number of their warnings, if they have some."""
    if count := len({warning for result in results for warning in getattr(result, "warnings", ())}):
        mark(ax, f"! {count} warning{'s' * (count > 1)}")


def mark(ax: Axes, text: str) -> None:
    """Write a warning above the axes, at the right, and above a legend there."""
    from matplotlib import rcParams

    legend, outside = ax.get_legend(), getattr(ax.get_figure(), "get_layout_engine", lambda: None)()
    below: Any = legend if legend is not None and outside else "axes fraction"
    look: dict[str, Any] = {"fontsize": rcParams["legend.fontsize"], "ha": "right"}
    look["color"] = METHODS["warning"] if ink() == BLACK else _LIGHT_RED
    place: Any = {"xycoords": ("axes fraction", below), "xytext": (0, 3), "textcoords": "offset points"}
    _keep_above(ax, ax.annotate(text, (1.0, 1.0), annotation_clip=False, **look, **place))


def draw_limit(ax: Axes, limit: Any, label: str = "limit", upright: bool = False) -> None:
    """Draw a line at a `Limit` or a number, in the colour of the text; none if it is None."""
    if limit is not None:
        draw = ax.axvline if upright else ax.axhline
        label = "limit of the spring" if getattr(limit, "at", "chain") == "spring" else label
        draw(getattr(limit, "force", limit), color=ink(), linestyle="-.", label=label)


def filled_and_open(ax: Axes, marker: str, x: Any, y: Any, is_filled: Any, *labels: str) -> None:
    """Draw simulated points with filled markers and, with the second of the labels, the others with open ones."""
    colour = METHODS["simulation"]
    for which, face, label in zip((is_filled, ~is_filled), (colour, "none"), labels, strict=True):
        if which.any():
            look: dict[str, Any] = {"color": colour, "markerfacecolor": face, "clip_on": False, "zorder": 3}
            ax.plot(x[which], y[which], marker, label=label, **look)


def busy_end(times: FloatArray, curves: FloatArray) -> float:
    """Return the time soon after the last change that is seen in the columns of ``curves``, or else the last time."""
    stray = (np.abs(curves - curves[-1]) > _SEEN * np.ptp(curves)).any(axis=1)
    end = _MARGIN * float(times[stray].max(initial=0.0))
    return end if 0 < end < _MOSTLY * times[-1] else float(times[-1])


def thin(y: FloatArray) -> npt.NDArray[np.intp]:
    """Return the indices at which a line is drawn: both ends, and the minimum and maximum of each section."""
    if len(y) <= _MOST_POINTS:
        return np.arange(len(y))
    stretches = np.array_split(np.arange(len(y)), _MOST_POINTS // 2)
    extremes = [part[pick(y[part])] for part in stretches for pick in (np.argmin, np.argmax)]
    return np.unique([0, *extremes, len(y) - 1])


def area(ax: Axes, x: FloatArray, low: Any, high: FloatArray, colour: str, hatch: str, label: str) -> None:
    """Shade an area; hatches distinguish areas without colour."""
    chosen = thin(high)
    look: dict[str, Any] = {"facecolor": colour, "alpha": 0.6, "hatch": hatch, "edgecolor": paper(), "linewidth": 0}
    bottom = np.broadcast_to(low, x.shape)[chosen]
    ax.fill_between(x[chosen], bottom, high[chosen], label=label, **look)
