"""Figures with a common style, and reproducible SVG, PNG and PDF files."""

from __future__ import annotations

import io
import re
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakSet

from shockwave.base.errors import InvalidValueError, text_of
from shockwave.base.files import write_file
from shockwave.base.result_tables import library
from shockwave.base.text import replace_unfit
from shockwave.pictures.picture_elements import BLACK, Axes, Label, add_legend, label_axis, mark_warnings, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Widths of a column and a page in print [in].
_WIDTHS = {"column": 3.4, "page": 7.0}
# Height of a row [in].
_HEIGHT = 2.6
# Resolution of PNG files and rasterised maps [dots per inch].
_DOTS = 200
_FORMATS = ("svg", "png", "pdf")
# Start of an SVG picture in a page.
_BEGIN = '<svg role="img"'
#: Held while a picture is drawn: matplotlib's settings are those of the process, not of a thread.
DRAWING = threading.RLock()
# Luminance of the background below which text is light: there, black and white have the same contrast.
_DARK = 0.18
# Settings that make no picture more legible, and the sizes of lines and markers [pt].
_PLAIN = {"text.usetex": False, "lines.linestyle": "-", "lines.marker": "None"}
_PLAIN |= {"lines.linewidth": 1.1, "lines.markersize": 4}
#: Figures made here: all of their parts have the settings of `style`, not those of the user's matplotlibrc.
_FIGURES: WeakSet[Any] = WeakSet()
#: Figures beside which the warnings stand, so that no mark refers to them.
UNMARKED: WeakSet[Any] = WeakSet()


def is_dark(colours: Sequence[Any]) -> bool:
    """Whether the first of these colours that is not transparent is dark."""
    from matplotlib.colors import to_rgba

    red, green, blue = next((each[:3] for each in map(to_rgba, colours) if each[3]), (1.0, 1.0, 1.0))
    return bool(0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 < _DARK)


@contextmanager
def use_settings(figure: Any, changes: Any = (), dark: bool = False) -> Iterator[None]:
    """Use, within the context, the settings of ``figure``, or of a new one if it is None, with ``changes``."""
    from matplotlib import rc_context, rcdefaults, rcParams

    with DRAWING, rc_context():
        if figure is None or figure in _FIGURES:
            rcdefaults()
            rcParams.update(style(dark if figure is None else is_dark([figure.get_facecolor()])))
        rcParams.update(changes)
        yield


@contextmanager
def canvas(
    ax: Axes | None,
    *results: Any,
    x: Label = "",
    y: Label = "",
    from_zero: bool = False,
    legend: bool = True,
    size: tuple[float, float] = (_WIDTHS["column"], _HEIGHT),
) -> Iterator[Axes]:
    """Draw, within the context, on ``ax`` or, if it is None, on the axes of a new figure of pyplot of this ``size``.

    Text and outlines are visible on the background of the axes. At the end the ordinate begins at zero if it is to, the
    axes get their labels, ``x`` and ``y``, and a legend, and the number of warnings of ``results`` is marked.
    """
    library("matplotlib", "plot")
    from matplotlib.axes import Axes

    if ax is None:
        from matplotlib import pyplot, rcParams

        with use_settings(None, dark=is_dark([rcParams["figure.facecolor"]])):
            sheet, ax = pyplot.subplots(figsize=size, layout="constrained")
        _FIGURES.add(sheet)
    if not isinstance(ax, Axes):
        got = f"got {text_of(ax)}; figure() returns a figure and a tuple of Axes"
        raise InvalidValueError.of("ax", f"must be Axes of matplotlib ({got})")
    figure = ax.get_figure()
    back = [ax.get_facecolor(), *([figure.get_facecolor()] if figure else [])]
    colours = {"text.color": "white" if is_dark(back) else BLACK, "axes.facecolor": ax.get_facecolor()}
    with use_settings(figure, _PLAIN | colours):
        yield ax
        if from_zero:
            ax.set_ylim(0, 1.12 * max(ax.dataLim.y1, 0.0) or 1.0)  # with room for a mark
        if x:
            label_axis(ax, "x", x)
        if y:
            label_axis(ax, "y", y)
        if legend:
            add_legend(ax, ax.get_legend_handles_labels()[0])
        if figure not in UNMARKED:
            mark_warnings(ax, results)


def figure(
    rows: int = 1, columns: int = 1, size: str | tuple[float, float] = "column", dark: bool = False
) -> tuple[Figure, tuple[Axes, ...]]:
    """Make a figure with ``rows`` times ``columns`` axes.

    Parameters
    ----------
    rows, columns : int
        Numbers of rows and columns, at least 1.
    size : "column", "page" or (float, float)
        Width of a column (3.4 in) or a page (7 in) in print, with a height for the rows; or width and height [in].
    dark : bool
        Whether the background is dark.

    Returns
    -------
    Figure, tuple of Axes
        The figure, and its axes row by row.

    Raises
    ------
    InvalidValueError
        If there is no such size.
    UsageError
        If matplotlib is not installed.
    """
    if isinstance(size, str):
        if size not in _WIDTHS:
            raise InvalidValueError.of("size", f"must be column, page or width and height in inches (got {size!r})")
        size = (_WIDTHS[size], _HEIGHT * rows)
    library("matplotlib", "plot")
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with use_settings(None, dark=dark):
        drawn = Figure(figsize=size, layout="constrained")
        FigureCanvasSVG(drawn)  # text is measured as it is written
        places: Any = drawn.subplots(rows, columns, squeeze=False)
    _FIGURES.add(drawn)
    return drawn, tuple(places.flat)


def svg(figure: Figure | Axes, name: str = "picture", description: str = "") -> str:
    """Return the figure as an ``<svg>`` element for a web page, reproducible to the byte.

    Parameters
    ----------
    figure : Figure or Axes
        The figure, or axes on it.
    name : str
        Prefix of all names in the element, unique in a page: a letter, then letters, digits and hyphens.
    description : str
        Description for readers who cannot see the picture.

    Raises
    ------
    InvalidValueError
        If the name has other characters.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9-]*", name):
        raise InvalidValueError.of("name", f"must be a letter, then letters, digits and hyphens (got {name!r})")
    written = io.StringIO()
    sheet = _sheet_of(figure)
    unsigned = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    # without a salt, the names of shared shapes differ from run to run
    with use_settings(sheet, {"svg.hashsalt": "shockwave", "svg.fonttype": "path"}):
        sheet.savefig(written, format="svg", dpi=_DOTS, metadata=unsigned)
    text = re.sub(r"\s*<!--.*?-->", "", written.getvalue().partition("<svg ")[2], flags=re.DOTALL)
    text = re.sub(r'( id="|href="#|url\(#)', rf"\1{name}-", text)
    return add_description(f"{_BEGIN} {text}", description)


def _sheet_of(figure: Any) -> Any:
    """The figure that ``figure`` is, or is on; raises InvalidValueError for something else."""
    try:
        return figure.figure.figure
    except AttributeError:
        rule = f"must be a Figure or Axes of matplotlib (got {text_of(figure)})"
        raise InvalidValueError.of("figure", rule) from None


def add_description(picture: str, description: str) -> str:
    """Return a picture of `svg` with a description for readers who cannot see it; unchanged if it is empty."""
    label = f' aria-label="{escape(replace_unfit(description))}"' if description else ""
    return f"{_BEGIN}{label}{picture.removeprefix(_BEGIN)}"


def save(figure: Figure | Axes, file: str | Path) -> None:
    """Write the figure, or that of the axes, to ``file`` in the format of its extension: svg, png or pdf.

    Raises
    ------
    FileAccessError
        If the file cannot be written.
    InvalidValueError
        If the extension is another one.
    """
    file = Path(file)
    kind = file.suffix.removeprefix(".").lower()
    if kind not in _FORMATS:
        raise InvalidValueError.of("file", f"must end in .{', .'.join(_FORMATS)} (got {file.name!r})")
    if kind == "svg":
        write_file(file, '<?xml version="1.0" encoding="utf-8"?>\n' + svg(figure))
        return
    drawn = io.BytesIO()
    sheet = _sheet_of(figure)
    with use_settings(sheet):
        sheet.savefig(drawn, format=kind, metadata={"CreationDate" if kind == "pdf" else "Software": None}, dpi=_DOTS)
    write_file(file, drawn.getvalue())
