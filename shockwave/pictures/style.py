"""How all pictures look: colours, lines, letters, units on axes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from shockwave.text import si

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.quadrature import FloatArray

__all__ = [
    "BLACK",
    "BLUE",
    "COLOURS",
    "FIELD",
    "GREEN",
    "GREY",
    "LABEL",
    "LINES",
    "MARKERS",
    "ORANGE",
    "PURPLE",
    "SIGNED",
    "SKY",
    "SMALL",
    "VERMILION",
    "decades",
    "dress",
    "key",
    "measure",
    "ratio",
    "scale",
    "thinned",
    "thousandths",
]

# Okabe and Ito, "Color universal design" (2008); its yellow is left out, which is not seen on white.
BLACK, BLUE, VERMILION, GREEN = "#000000", "#0072B2", "#D55E00", "#009E73"
ORANGE, SKY, PURPLE, GREY = "#E69F00", "#56B4E9", "#CC79A7", "#767676"
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
#: In grey, lines are told apart by dashes and marks.
LINES: tuple[Any, ...] = ("-", "--", "-.", (0, (1, 1)), (0, (5, 1, 1, 1, 1, 1)), (0, (7, 2)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*")
#: Maps of a quantity without and with a sign; both go on getting lighter or darker.
FIELD, SIGNED = "magma_r", "RdBu_r"
#: Sizes of letters [pt], readable in a column.
LABEL, SMALL = 8.0, 7.0

# Over a wider range whole decades alone have ticks.
_FEW_DECADES = 2000.0
# Width of a letter over its size, of the mark before an entry of the key, and what the axes' labels take [in].
_LETTER, _MARK, _MARGIN = 0.55, 4.2, 0.6
_DECADE = 10.0


def measure(ax: Axes, axis: Literal["x", "y"], largest: float, unit: str, name: str) -> None:
    """Label an axis ``name (unit)`` and its ticks in the unit whose SI prefix suits ``largest``; data stay in SI."""
    from matplotlib.ticker import FuncFormatter

    factor, prefixed = _prefixed(largest, unit)
    chosen = ax.xaxis if axis == "x" else ax.yaxis
    chosen.set_label_text(f"{name} ({prefixed})")

    def prefixed_text(value: float, _: object) -> str:
        return f"{value / factor:.6g}".replace("-", "\N{MINUS SIGN}")

    def between(value: float, _: object) -> str:
        low, high = chosen.get_view_interval()
        return prefixed_text(value, _) if high < _DECADE * low else ""

    chosen.set_major_formatter(FuncFormatter(prefixed_text))
    if chosen.get_scale() == "log":
        # Of the small ticks only those are told without which an axis might tell none.
        chosen.set_minor_formatter(FuncFormatter(between))


def thousandths(value: float, unit: str, digits: int = 3) -> str:
    """``value`` with its unit as a label: as `si`, with the sign for a millionth."""
    number, _, prefixed = si(value, unit, digits).partition(" ")
    return f"{number} {_micro(prefixed, unit)}"


def _prefixed(largest: float, unit: str) -> tuple[float, str]:
    if largest <= 0 or not math.isfinite(largest):
        return 1.0, unit
    number, _, prefixed = si(largest, unit, 9).partition(" ")
    return 10.0 ** round(math.log10(largest / float(number))), _micro(prefixed, unit)


def _micro(prefixed: str, unit: str) -> str:
    return f"\N{MICRO SIGN}{unit}" if prefixed == f"u{unit}" else prefixed


def ratio(ax: Axes, axis: Literal["x", "y"], name: str) -> None:
    """Label an axis of a number without a unit."""
    (ax.xaxis if axis == "x" else ax.yaxis).set_label_text(name)


def decades(ax: Axes, axis: Literal["x", "y"]) -> None:
    """Make an axis logarithmic, with plain numbers at its ticks; call before `measure`, after the limits are set."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    chosen = ax.xaxis if axis == "x" else ax.yaxis
    (ax.set_xscale if axis == "x" else ax.set_yscale)("log")
    least, most = ax.get_xlim() if axis == "x" else ax.get_ylim()
    chosen.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if most < _FEW_DECADES * least else (1.0,)))
    chosen.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    chosen.set_minor_formatter(NullFormatter())


def scale(ax: Axes, drawn: Any, **options: Any) -> Any:
    """The scale of the colours of ``drawn``, close to the right of ``ax``."""
    figure = ax.get_figure()
    assert figure is not None
    # within the Axes, so that neighbours of other widths do not part the two
    bar = figure.colorbar(drawn, cax=ax.inset_axes((1.03, 0.0, 0.04, 1.0)), **options)
    bar.ax.tick_params(which="both", labelsize=SMALL, width=0.6)
    bar.outline.set_linewidth(0.6)
    return bar


def dress(ax: Axes, grid: bool = True) -> Axes:
    """Give an Axes the letters and the frame of all pictures; the last that a picture does."""
    ax.tick_params(which="both", labelsize=SMALL, width=0.6)
    ax.xaxis.label.set_fontsize(LABEL)
    ax.yaxis.label.set_fontsize(LABEL)
    ax.xaxis.get_offset_text().set_fontsize(SMALL)
    ax.yaxis.get_offset_text().set_fontsize(SMALL)
    for side, spine in ax.spines.items():
        spine.set_linewidth(0.6)
        spine.set_visible(side in ("left", "bottom") or not grid)
    if grid:
        ax.grid(True, color="#D9D9D9", linewidth=0.4)
        ax.set_axisbelow(True)
    return ax


def key(ax: Axes, handles: Iterable[Any] | None = None, labels: Iterable[str] | None = None) -> None:
    """What the lines are, above the picture, where nothing is hidden by it, in as many columns as find room."""
    if handles is None:
        handles, labels = ax.get_legend_handles_labels()
    handles, labels = list(handles), list(labels or ())
    if not handles:
        return
    own = ax.get_subplotspec()
    share = 1.0 if own is None else own.get_gridspec().ncols / (own.colspan.stop - own.colspan.start)
    figure = ax.get_figure()
    width = (figure.bbox.width / figure.dpi if figure is not None else 0.0) / share - _MARGIN
    entries = [(_LETTER * _letters(label) + _MARK) * SMALL / 72 for label in labels]
    ax.legend(
        handles,
        labels,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        borderaxespad=0.3,
        ncols=_columns(entries, width),
        fontsize=SMALL,
        frameon=False,
        handlelength=2.2,
        columnspacing=1.2,
        labelspacing=0.3,
        borderpad=0.0,
    )


def _columns(entries: list[float], width: float) -> int:
    """In how many columns entries of these widths fit; they fill one column after the other."""
    for columns in range(len(entries), 1, -1):
        if sum(max(column) for column in np.array_split(entries, columns)) <= width:
            return columns
    return 1


def _letters(label: str) -> int:
    """About how many letters a label takes; signs of mathematics do not show."""
    return len([letter for letter in label if letter not in "$\\{}_^"])


def thinned(x: npt.ArrayLike, y: npt.ArrayLike, most: int = 800) -> tuple[FloatArray, FloatArray]:
    """A line of many points by at most ``most``: the least and the greatest of each stretch, and both ends."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if len(x) <= most:
        return x, y
    edges = np.linspace(0, len(x), most // 2, dtype=int)
    chosen = [0, len(x) - 1]
    chosen += [int(a + place(y[a:b])) for a, b in pairwise(edges) for place in (np.argmin, np.argmax)]
    kept = np.unique(chosen)
    return x[kept], y[kept]
