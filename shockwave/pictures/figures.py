"""Figures to draw on, with the look of all pictures, and SVG, PNG and PDF files that are the same on every run."""

from __future__ import annotations

import io
import re
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shockwave import OWN_DISTRIBUTION
from shockwave.errors import InvalidValueError, UsageError
from shockwave.files import write_file
from shockwave.text import admitted

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Widths of a column and of a page in print [in], and a height that suits one row.
_WIDTHS = {"column": 3.4, "page": 7.0}
_HEIGHT = 2.6
_DOTS = 200
_FORMATS = ("svg", "png", "pdf")
#: Size of small letters [pt], readable in a column.
SMALL = 7.0
_LOOK: Any = {
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


def figure(
    rows: int = 1, columns: int = 1, size: str | tuple[float, float] = "column"
) -> tuple[Figure, tuple[Axes, ...]]:
    """A figure with ``rows`` times ``columns`` places to draw on.

    Parameters
    ----------
    rows, columns : int
        How many, at least 1.
    size : "column", "page" or (float, float)
        As wide as a column or a page in print, 3.4 and 7 in, and as high as the rows need; or width and height [in].

    Returns
    -------
    Figure, tuple of Axes
        The places row by row, from the left.

    Raises
    ------
    InvalidValueError
        When the size is none of these.
    UsageError
        When matplotlib is not installed.
    """
    if isinstance(size, str):
        if size not in _WIDTHS:
            raise InvalidValueError.of("size", f"must be column, page or width and height in inches (got {size!r})")
        size = (_WIDTHS[size], _HEIGHT * rows)
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError as missing:
        raise UsageError(f"pictures need matplotlib: pip install '{OWN_DISTRIBUTION}[plot]'") from missing
    with rc_context(_LOOK):
        drawn = Figure(figsize=size, layout="constrained")
        places: Any = drawn.subplots(rows, columns, squeeze=False)
    return drawn, tuple(places.flat)


def svg(figure: Figure, name: str = "picture", description: str = "") -> str:
    """The figure as an ``<svg>`` element that can stand in a page, the same to the byte on every run.

    Parameters
    ----------
    figure : Figure
        The drawn figure.
    name : str
        Letters, digits and hyphens; begins all names within, so that several pictures can stand in one page.
    description : str
        For readers who cannot see the picture.

    Raises
    ------
    InvalidValueError
        When the name holds anything else.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9-]*", name):
        raise InvalidValueError.of("name", f"must be a letter, then letters, digits and hyphens (got {name!r})")
    from matplotlib import rc_context

    figure.draw_without_rendering()  # the last digits of the layout settle at its second pass
    written = io.StringIO()
    # without a salt of their own, the names of shared shapes differ from run to run
    unsigned = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    with rc_context({"svg.hashsalt": "shockwave", "svg.fonttype": "path"}):
        figure.savefig(written, format="svg", metadata=unsigned, dpi=_DOTS)
    text = re.sub(r"\s*<!--.*?-->", "", written.getvalue().partition("<svg ")[2], flags=re.DOTALL)
    # only names that are referred to are the same on every run
    referred = set(re.findall(r'(?:href="|url\()#([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda found: found[0] if found[1] in referred else "", text)
    text = re.sub(r'( id="|href="#|url\(#)', rf"\1{name}-", text)
    label = f' aria-label="{escape(admitted(description))}"' if description else ""
    return f'<svg role="img"{label} {text}'


def save(figure: Figure, file: str | Path) -> None:
    """Write the figure to ``file`` in the format of its ending: svg, png or pdf.

    Raises
    ------
    FileAccessError
        When the file cannot be written.
    InvalidValueError
        When the ending is another.
    """
    file = Path(file)
    kind = file.suffix.removeprefix(".").lower()
    if kind not in _FORMATS:
        raise InvalidValueError.of("file", f"must end in .{', .'.join(_FORMATS)} (got {file.name!r})")
    if kind == "svg":
        write_file(file, '<?xml version="1.0" encoding="utf-8"?>\n' + svg(figure))
        return
    drawn = io.BytesIO()
    figure.savefig(drawn, format=kind, metadata={"CreationDate" if kind == "pdf" else "Software": None}, dpi=_DOTS)
    write_file(file, drawn.getvalue())
