"""Common elements of pictures: colours, axis labels, legends, colour bars, shaded areas, regime names."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from shockwave.base.text import si
from shockwave.pictures.figure_files import POINTS, SMALL

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.base.numerics import FloatArray


# Okabe and Ito, "Color universal design" (2008), without yellow, which is hard to see on white.
BLACK = "#000000"
BLUE = "#0072B2"
VERMILION = "#D55E00"
GREEN = "#009E73"
ORANGE = "#E69F00"
SKY = "#56B4E9"
PURPLE = "#CC79A7"
GREY = "#767676"
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
#: Line styles and markers distinguish lines without colour.
LINES: tuple[Any, ...] = ("-", "--", "-.", (0, (1, 1)), (0, (5, 1, 1, 1, 1, 1)), (0, (7, 2)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*")
#: Colour maps for quantities of one sign and of both signs; monotonic in lightness on each side of zero.
FIELD = "magma_r"
SIGNED = "RdBu_r"
MINUS = "\N{MINUS SIGN}"
# Ratio of the limits of a logarithmic axis above which its ticks are powers of ten.
_FEW_DECADES = 2000.0
# The legend is placed directly above the axes.
_LEGEND: dict[str, Any] = {
    "loc": "lower left",
    "bbox_to_anchor": (0.0, 1.0),
    "borderpad": 0.0,
    "columnspacing": 1.2,
    "fontsize": SMALL,
    "frameon": False,
    "handlelength": 2.0,
    "handletextpad": 0.8,
}
# Most points of a drawn line or area.
_MOST_POINTS = 800
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def si_label(value: float, unit: str, digits: int = 3, error: float | None = None) -> str:
    """Return ``value`` with an SI prefix like `si`, but with the micro sign."""
    return si(value, unit, digits, error).replace(f" u{unit}", f" \N{MICRO SIGN}{unit}")


def style(index: int, marked: bool = False) -> dict[str, Any]:
    """Return colour, line style and, if it is ``marked``, marker of one line among others."""
    marker = MARKERS[index % len(MARKERS)] if marked else ""
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": LINES[index % len(LINES)], "marker": marker}


def power_of_ten(exponent: int) -> str:
    """Return 10 to this power with a raised exponent."""
    return "10" + str(exponent).translate(_RAISED)


def literal(text: str) -> str:
    """Return ``text`` as a label in which a dollar sign does not begin a formula."""
    return text.replace("$", r"\$")


def label_axis(ax: Axes, axis: Literal["x", "y"], name: str, unit: str = "") -> None:
    """Label an axis ``name (unit)``, with an SI prefix in label and ticks; scale and limits must be final."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    chosen = ax.xaxis if axis == "x" else ax.yaxis
    low, high = ax.get_xlim() if axis == "x" else ax.get_ylim()
    logarithmic = chosen.get_scale() == "log"
    few = logarithmic and high < _FEW_DECADES * low
    factor = 1.0
    chosen.set_minor_locator(NullLocator())  # more lines than a column can hold, each as expensive as a label
    if few:
        chosen.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    elif logarithmic:  # a formula for each tick would take longer than the rest of the axis
        chosen.set_major_formatter(FuncFormatter(lambda value, _: power_of_ten(round(math.log10(value)))))
    if few or (unit and not logarithmic):
        largest = max(abs(low), abs(high))
        number, _, unit = si_label(largest, unit, 9).partition(" ")
        factor = 10.0 ** round(math.log10(largest / float(number)))
        chosen.set_major_formatter(FuncFormatter(lambda value, _: f"{value / factor:.6g}".replace("-", MINUS)))
    chosen.set_label_text(f"{name} ({unit})" if unit else name)


def finish(ax: Axes, x: tuple[str, str], y: tuple[str, str], legend: bool = True) -> Axes:
    """Label both axes with a name and a unit, and add the legend."""
    label_axis(ax, "x", *x)
    label_axis(ax, "y", *y)
    if legend:
        add_legend(ax, ax.get_legend_handles_labels()[0])
    return ax


def add_legend(ax: Axes, entries: Iterable[Any]) -> None:
    """Add a legend above the axes, in as many columns as fit."""
    from matplotlib.cbook import is_math_text
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    handles, font, figure = list(entries), FontProperties(size=SMALL), ax.get_figure()
    if not handles or figure is None:
        return
    labels = [str(handle.get_label()) for handle in handles]
    texts = [text_to_path.get_text_width_height_descent(label, font, is_math_text(label))[0] for label in labels]
    widths = np.array(texts) + SMALL * (_LEGEND["handlelength"] + _LEGEND["handletextpad"] + _LEGEND["columnspacing"])
    room = POINTS * ax.bbox.width / figure.dpi + SMALL * _LEGEND["columnspacing"]
    fitting = (n for n in range(len(handles), 1, -1) if sum(map(max, np.array_split(widths, n))) <= room)
    ax.legend(handles=handles, ncols=next(fitting, 1), **_LEGEND)


def colour_scale(ax: Axes, drawn: Any, name: str, unit: str = "", **options: Any) -> Any:
    """Add a labelled colour bar for ``drawn`` at the right of ``ax``."""
    figure = ax.get_figure()
    assert figure is not None
    # an inset, so that the layout keeps it next to its axes
    bar = figure.colorbar(drawn, cax=ax.inset_axes((1.03, 0.0, 0.04, 1.0)), **options)
    label_axis(bar.ax, "y", name, unit)
    bar.ax.yaxis.label.set_fontsize(ax.yaxis.label.get_fontsize())
    bar.ax.tick_params(which="both", labelsize=SMALL)
    return bar


def place_name(ax: Axes, x: float, y: float, text: str) -> None:
    """Write text with a white outline on the axes."""
    ax.text(x, y, text, ha="center", va="center", fontsize=SMALL, path_effects=halo(), zorder=5)


def halo() -> list[Any]:
    """Return the white outline of text and lines on coloured areas."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=2.0, foreground="white")]


def thinned(y: FloatArray) -> npt.NDArray[np.intp]:
    """Return the indices at which a line is drawn: both ends, and the minimum and maximum of each section."""
    if len(y) <= _MOST_POINTS:
        return np.arange(len(y))
    stretches = np.array_split(np.arange(len(y)), _MOST_POINTS // 2)
    extremes = [part[pick(y[part])] for part in stretches for pick in (np.argmin, np.argmax)]
    return np.unique([0, *extremes, len(y) - 1])


def area(ax: Axes, x: FloatArray, low: Any, high: FloatArray, colour: str, hatch: str, label: str) -> None:
    """Shade an area; hatches distinguish areas without colour."""
    kept = thinned(high)
    look: dict[str, Any] = {"facecolor": colour, "alpha": 0.6, "hatch": hatch, "edgecolor": "white", "linewidth": 0}
    bottom = np.broadcast_to(low, x.shape)[kept]
    ax.fill_between(x[kept], bottom, high[kept], label=label, **look)
