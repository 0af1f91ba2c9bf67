"""What all pictures are made of: labelled axes, scales of colours, keys, names, areas."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from shockwave.pictures.style import LABEL, MINUS, SMALL, thousandths

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.quadrature import FloatArray


# Over a wider range whole decades alone have ticks.
_FEW_DECADES = 2000.0


# The key stands above the picture, close to it.
_KEY: dict[str, Any] = {
    "loc": "lower left",
    "bbox_to_anchor": (0.0, 1.0),
    "borderpad": 0.0,
    "columnspacing": 1.2,
    "fontsize": SMALL,
    "frameon": False,
}
# An Axes is so many times wider after the layout than before, at least.
_WIDER = 1.1


def label_axis(ax: Axes, axis: Literal["x", "y"], name: str, unit: str = "", largest: float = 0.0) -> None:
    """Label an axis ``name (unit)``, with the SI prefix that suits ``largest`` in label and ticks; data stay in SI."""
    chosen = ax.xaxis if axis == "x" else ax.yaxis
    if not unit:
        chosen.set_label_text(name)
        return
    from matplotlib.ticker import FuncFormatter

    factor, prefixed = 1.0, unit
    if 0 < largest < math.inf:
        number, _, prefixed = thousandths(largest, unit, 9).partition(" ")
        factor = 10.0 ** round(math.log10(largest / float(number)))
    chosen.set_label_text(f"{name} ({prefixed})")
    chosen.set_major_formatter(FuncFormatter(lambda value, _: f"{value / factor:.6g}".replace("-", MINUS)))


def decades(ax: Axes, axis: Literal["x", "y"]) -> None:
    """Make an axis logarithmic, with plain numbers at its ticks; call after the limits, before `label_axis`."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    chosen = ax.xaxis if axis == "x" else ax.yaxis
    (ax.set_xscale if axis == "x" else ax.set_yscale)("log")
    least, most = ax.get_xlim() if axis == "x" else ax.get_ylim()
    chosen.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if most < _FEW_DECADES * least else (1.0,)))
    chosen.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    chosen.set_minor_formatter(NullFormatter())


def scale(ax: Axes, drawn: Any, name: str, unit: str = "", **options: Any) -> Any:
    """The labelled scale of the colours of ``drawn``, close to the right of ``ax``."""
    figure = ax.get_figure()
    assert figure is not None
    # within the Axes, so that neighbours of other widths do not part the two
    bar = figure.colorbar(drawn, cax=ax.inset_axes((1.03, 0.0, 0.04, 1.0)), **options)
    label_axis(bar.ax, "y", name, unit, drawn.get_clim()[1])
    bar.ax.yaxis.label.set_fontsize(LABEL)
    bar.ax.tick_params(which="both", labelsize=SMALL, width=0.6)
    bar.outline.set_linewidth(0.6)
    return bar


def dress(ax: Axes, grid: bool = True) -> Axes:
    """Give an Axes the letters and the frame of all pictures; the last step of a picture."""
    ax.tick_params(which="both", labelsize=SMALL, width=0.6)
    ax.xaxis.label.set_fontsize(LABEL)
    ax.yaxis.label.set_fontsize(LABEL)
    for side, spine in ax.spines.items():
        spine.set_linewidth(0.6)
        spine.set_visible(side in ("left", "bottom") or not grid)
    if grid:
        ax.grid(True, color="#D9D9D9", linewidth=0.4)
        ax.set_axisbelow(True)
    return ax


def finish(ax: Axes, x: str | tuple[str, str, float], y: str | tuple[str, str, float]) -> Axes:
    """Label both axes, each a name or a name, a unit and the largest value; put the key above the picture; dress."""
    label_axis(ax, "x", *([x] if isinstance(x, str) else x))
    label_axis(ax, "y", *([y] if isinstance(y, str) else y))
    key(ax)
    return dress(ax)


def key(ax: Axes, handles: Iterable[Any] | None = None, labels: Iterable[str] | None = None) -> None:
    """The meaning of the lines, above the picture, where nothing is hidden by it, in as many columns as fit."""
    if handles is None:
        handles, labels = ax.get_legend_handles_labels()
    handles, labels = list(handles), list(labels or ())
    for columns in range(len(handles), 0, -1):
        legend = ax.legend(handles, labels, ncols=columns, **_KEY)
        if legend.get_window_extent().width <= _WIDER * ax.bbox.width:
            return


def named(ax: Axes, x: float, y: float, text: str, shift: tuple[int, int] = (0, 0), **look: Any) -> None:
    """A word within a picture, with a white border; at ``shift`` [pt] from its place, with a line to there."""
    arrow = {"arrowstyle": "-", "linewidth": 0.6, "shrinkA": 1, "shrinkB": 0} if any(shift) else None
    look = {"ha": "center", "va": "center", "fontsize": SMALL, "path_effects": halo(), "zorder": 5, **look}
    ax.annotate(text, (x, y), shift, textcoords="offset points", arrowprops=arrow, **look)


def halo() -> list[Any]:
    """The white border of words and lines within a picture."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=2.0, foreground="white")]


def area(ax: Axes, x: Any, low: Any, high: Any, colour: str, hatch: str, label: str) -> None:
    """A shaded area; hatches distinguish areas without colours."""
    look: dict[str, Any] = {"facecolor": colour, "alpha": 0.6, "hatch": hatch, "edgecolor": "white", "linewidth": 0}
    ax.fill_between(x, low, high, label=label, **look)


def thinned(x: npt.ArrayLike, y: npt.ArrayLike, most: int = 800) -> tuple[FloatArray, FloatArray]:
    """A line of many points by at most ``most``: the least and the greatest of each stretch, and both ends."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if len(x) <= most:
        return x, y
    chosen = [0, len(x) - 1]
    for begin, end in pairwise(np.linspace(0, len(x), most // 2, dtype=int).tolist()):
        chosen += [begin + int(np.argmin(y[begin:end])), begin + int(np.argmax(y[begin:end]))]
    kept = np.unique(chosen)
    return x[kept], y[kept]
