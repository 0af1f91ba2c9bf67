"""Figures with a common style, and reproducible SVG, PNG and PDF files."""

from __future__ import annotations

import io
import re
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast
from weakref import WeakSet

from shockwave.base.errors import InvalidValueError
from shockwave.base.files import write_file
from shockwave.base.result_tables import library
from shockwave.base.text import replace_unfit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_Draw = TypeVar("_Draw", bound=Callable[..., Any])

# Widths of a column and a page in print [in].
_WIDTHS = {"column": 3.4, "page": 7.0}
# Height of a row [in].
_HEIGHT = 2.6
# Resolution of PNG files and rasterised maps [dots per inch].
_DOTS = 200
#: Points per inch; a point is the unit of SVG files.
POINTS = 72
_FORMATS = ("svg", "png", "pdf")
# Start of an SVG picture in a page.
_BEGIN = '<svg role="img"'
#: Held while a picture is drawn: matplotlib's settings are those of the process, not of a thread.
DRAWING = threading.RLock()
# Colour of the mark of warnings: the vermilion of the other colours.
_ALARM = "#D55E00"
#: Size of small text [pt], legible in a column.
SMALL = 7.0
_STYLE: Any = {
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "grid.color": "#D9D9D9",
    "grid.linewidth": 0.4,
    "xtick.labelsize": SMALL,
    "xtick.major.width": 0.6,
    "ytick.labelsize": SMALL,
    "ytick.major.width": 0.6,
}
#: Figures made by `figure`: all of their parts have its settings, not those of the user's matplotlibrc.
_FIGURES: WeakSet[Any] = WeakSet()


@contextmanager
def settings_of(figure: Any, changes: Any = ()) -> Iterator[None]:
    """Use, within the context, the settings of ``figure``, or of a new one if it is None, with ``changes``."""
    from matplotlib import rc_context, rcdefaults, rcParams

    with DRAWING, rc_context():
        if figure is None or figure in _FIGURES:
            rcdefaults()
            rcParams.update(_STYLE)
        rcParams.update(changes)
        yield


def picture(draw: _Draw) -> _Draw:
    """Decorate a function that draws on axes: it uses the settings of their figure, and marks warnings of results."""

    @wraps(draw)
    def drawn(ax: Axes, *arguments: Any, **options: Any) -> Any:
        with settings_of(ax.get_figure()):
            drawn = draw(ax, *arguments, **options)
            mark_warnings(ax, arguments)
            return drawn

    return cast(_Draw, drawn)


def mark_warnings(ax: Axes, results: Iterable[Any]) -> None:
    """Mark a picture of ``results`` with the number of their warnings, if they have some."""
    if count := len({warning for result in results for warning in getattr(result, "warnings", ())}):
        mark(ax, f"! {count} warning{'s' * (count > 1)}")


def mark(ax: Axes, text: str) -> None:
    """Write ``text`` in the upper right corner of the axes."""
    from matplotlib.patheffects import withStroke

    look: dict[str, Any] = {"fontsize": SMALL, "color": _ALARM, "ha": "right", "va": "top", "zorder": 6}
    outline = [withStroke(linewidth=2.0, foreground="white")]
    ax.text(0.99, 0.98, text, transform=ax.transAxes, path_effects=outline, **look)


def figure(
    rows: int = 1, columns: int = 1, size: str | tuple[float, float] = "column"
) -> tuple[Figure, tuple[Axes, ...]]:
    """Make a figure with ``rows`` times ``columns`` axes.

    Parameters
    ----------
    rows, columns : int
        Numbers of rows and columns, at least 1.
    size : "column", "page" or (float, float)
        Width of a column (3.4 in) or a page (7 in) in print, with a height for the rows; or width and height [in].

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

    with settings_of(None):
        drawn = Figure(figsize=size, layout="constrained")
        FigureCanvasSVG(drawn)  # text is measured as it is written
        places: Any = drawn.subplots(rows, columns, squeeze=False)
    _FIGURES.add(drawn)
    return drawn, tuple(places.flat)


def svg(figure: Figure, name: str = "picture", description: str = "") -> str:
    """Return the figure as an ``<svg>`` element for a web page, reproducible to the byte.

    Parameters
    ----------
    figure : Figure
        The figure.
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
    unsigned = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    # without a salt, the names of shared shapes differ from run to run
    with settings_of(figure, {"svg.hashsalt": "shockwave", "svg.fonttype": "path"}):
        figure.savefig(written, format="svg", dpi=_DOTS, metadata=unsigned)
    text = re.sub(r"\s*<!--.*?-->", "", written.getvalue().partition("<svg ")[2], flags=re.DOTALL)
    text = re.sub(r'( id="|href="#|url\(#)', rf"\1{name}-", text)
    return described(f"{_BEGIN} {text}", description)


def described(picture: str, description: str) -> str:
    """Return a picture of `svg` with a description for readers who cannot see it; unchanged if it is empty."""
    label = f' aria-label="{escape(replace_unfit(description))}"' if description else ""
    return f"{_BEGIN}{label}{picture.removeprefix(_BEGIN)}"


def save(figure: Figure, file: str | Path) -> None:
    """Write the figure to ``file`` in the format of its extension: svg, png or pdf.

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
    with settings_of(figure):
        figure.savefig(drawn, format=kind, metadata={"CreationDate" if kind == "pdf" else "Software": None}, dpi=_DOTS)
    write_file(file, drawn.getvalue())
