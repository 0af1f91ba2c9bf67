"""Numbers, tables and paragraphs for people, laid out for a screen, and text that documents admit."""

from __future__ import annotations

import importlib
import math
import os
import re
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from enum import IntEnum
from functools import cache
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

from attrs import evolve, frozen

if TYPE_CHECKING:
    from jinja2 import Template

# Characters that HTML does not admit, and those that turn the direction of the text behind them.
_UNFIT = "[^\t\n\x20-\x7e\xa0-\u2029\u202f-\u2065\u206a-\ud7ff\ue000-\ufdcf\ufdf0-\ufffd\U00010000-\U0010fffd]"
# Share above which the digits are counted from the part that is missing from 100 %.
_NEARLY_ALL = 0.99
_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T", 15: "P"}
# Columns of a label and of the text's indent in `facts`.
_LABEL = 20
# Least width of a column of wrapped text.
_NARROW = 12
# Width of the text about columns that are left out, besides their names.
_REMEDY = 42
# Width to which the first column, of names, is wrapped before others are left out.
_NAME = 24
# Blanks between a number and its unit, and in a unit.
_UNITS = re.compile(r"(?<=\d) (?=%|[fpnumkMGT]?(?:N|m|s|g|kg|J|Pa|Hz)\b)|(?<=N) (?=s\b)")
_STYLE = re.compile("\x1b\\[[0-9;]*m")
# Codes of terminals for bold, and for bold and red.
_STRONG = "1"
_ALARM = "1;31"
#: Most lines of the short text of one scene.
MOST_LINES = 14
# Lines of facts that stay in it, however many warnings there are.
_LEAST_FACTS = 5
# Lines of warnings that stay: first yield, and the forces beyond it.
_LEAST_WARNINGS = 6
# Narrowest terminal that text is laid out for.
_LEAST_COLUMNS = 40


class Detail(IntEnum):
    """How much of a result its text shows: at most `MOST_LINES` lines, the decision as well, or everything."""

    SHORT = 0
    EXPLAIN = 1
    VERBOSE = 2


@frozen
class Screen:
    """Where text is shown: ``columns`` wide, in ``colour`` or not; with ``wide``, tables keep all columns."""

    columns: int = 80
    colour: bool = False
    wide: bool = False
    detail: Detail = Detail.SHORT


#: The screen of text that is made elsewhere than in a command: the same everywhere.
_PLAIN = Screen()
_screen: ContextVar[Screen] = ContextVar("screen", default=_PLAIN)


@contextmanager
def on_stdout(wide: bool = False, detail: Detail = Detail.SHORT) -> Iterator[None]:
    """Lay text out for stdout meanwhile: as wide as the terminal; 80 columns and no colour where there is none.

    NO_COLOR, or a terminal that is dumb, turns colour off.
    """
    shown = Screen(wide=wide, detail=detail)
    if sys.stdout.isatty():
        colour = not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
        shown = Screen(max(_LEAST_COLUMNS, shutil.get_terminal_size().columns), colour, wide, detail)
    token = _screen.set(shown)
    try:
        yield
    finally:
        _screen.reset(token)


def is_wide() -> bool:
    """Whether tables keep all columns and rows."""
    return _screen.get().wide


def detail() -> Detail:
    """How much of a result is shown."""
    return _screen.get().detail


def brief(answer: Iterable[str], warnings: Iterable[str], rest: Iterable[str], requested: Sequence[str] = ()) -> str:
    """At most `MOST_LINES` lines, unless more is asked for: the answer, its warnings, and as much as fits.

    The ``requested`` lines are shown however many they are.
    """
    head, others = [line for part in answer for line in part.split("\n")], [*rest]
    between = [""] * bool(requested and others)
    tail = [*requested, *between, *others]
    if detail() is Detail.VERBOSE:
        return "\n".join([*head, *limits(warnings), *tail])
    warning_lines = [limits([warning]) for warning in dict.fromkeys(warnings)]
    room, count = MOST_LINES - len(head) - 1, len(warning_lines)
    while warning_lines and sum(map(len, warning_lines)) > max(
        room - max(len(requested), min(len(tail), _LEAST_FACTS)), _LEAST_WARNINGS
    ):
        warning_lines.pop()
    lines = [*head, *(line for part in warning_lines for line in part)]
    if len(warning_lines) < count:
        lines += limits([f"{count - len(warning_lines)} more; --verbose shows all"])
    if detail() is not Detail.EXPLAIN and len(tail) > (room := max(MOST_LINES - len(lines), 0)):
        kept = tail[len(requested) + len(between) : max(room - 1, 0)]
        kept = kept[: kept.index("")] if "" in kept else kept  # no part of a table without its rest
        tail = [*requested, *[""] * bool(requested and kept), *kept, *["  (--verbose shows more)"] * bool(others)]
    return "\n".join([*lines, *tail])


def strong(text: str) -> str:
    """``text``, bold where the screen has colour, and wrapped: the answer."""
    lines = wrap(text, _screen.get().columns, "  ")
    return "\n".join(_style(line, _STRONG) for line in lines)


def alarm(text: str) -> str:
    """``text``, red where the screen has colour: a failed condition, an error."""
    return _style(text, _ALARM)


def _style(text: str, style: str) -> str:
    return f"\x1b[{style}m{text}\x1b[0m" if _screen.get().colour else text


def si(value: float, unit: str, digits: int = 5, error: float | None = None) -> str:
    """``value`` with an SI prefix, if ``unit`` takes one: ``si(1.5e-5, "s")`` is ``15 us``, ``si(1.5e-5, "")`` 1.5e-05.

    With the relative ``error`` of the value, in `significant_digits`.
    """
    if error is not None:
        digits = significant_digits(value, error)
    plain = f"{value:.{digits}g} {unit.replace('**', '^')}".rstrip()
    if not unit or unit.startswith("kg") or "**" in unit or not 0 < abs(value) < math.inf:
        return plain
    # rounding may carry over into the next prefix
    exponent = 3 * math.floor(math.log10(abs(float(f"{value:.{digits}g}")) * (1 + 1e-12)) / 3)
    if exponent not in _PREFIXES:
        return plain
    scaled = float(f"{value / 10**exponent:.{digits}g}")
    if error is None:
        return f"{scaled:.{max(digits, 3)}g} {_PREFIXES[exponent]}{unit}"
    decimals = max(digits - 1 - _place(scaled), 0)  # known digits are shown, zeros too
    return f"{scaled:.{decimals}f} {_PREFIXES[exponent]}{unit}"


def round_digits(value: float, digits: int = 2) -> str:
    """``value`` to ``digits`` digits, without a power of ten unless it is tiny or huge."""
    return f"{float(f'{value:.{digits}g}'):.15g}"


def round_bound(value: float, up: bool, digits: int = 3) -> float:
    """``value`` to ``digits`` digits, rounded outwards: an upper bound ``up``, a lower one down."""
    if not 0 < abs(value) < math.inf:
        return value
    rounded, towards = float(f"{value:.{digits}g}"), math.inf if up else -math.inf
    if (rounded < value) if up else (rounded > value):
        # less than one unit of the last digit away
        unit = 10.0 ** (_place(value) - digits + 1)
        rounded = float(f"{rounded + math.copysign(unit, towards):.{digits}g}")
    return rounded


def percent(share: float, sign: str = "") -> str:
    """``share`` in percent, to two digits; a little less than all of it, to two digits of what is missing."""
    rest = 1 - share if _NEARLY_ALL < share < 1 else 0.0
    value = 100 - float(f"{100 * rest:.2g}") if rest else float(f"{100 * share:.2g}")
    return f"{value:{sign}.15g} %"


def significant_digits(value: float, error: float) -> int:
    """Digits of ``value`` that its relative ``error`` supports, 1 to 15.

    Down to the first digit of the error, or to its second where the first is 1 or 2.
    """
    if not 0 < abs(value) < math.inf or not error < 1:
        return 1
    if error <= 0:
        return 15
    # the last digit stands for 0.1 with an error of 2.9, for 1 with one of 3.1
    return min(max(_place(value) - _place(value * error / 3) + 1, 1), 15)


def _place(value: float) -> int:
    return math.floor(math.log10(abs(value)) + 1e-12)


def table(header: Sequence[str], rows: Iterable[Sequence[str]], spare: Sequence[str] = (), margin: int = 2) -> str:
    """Columns under a ruled header, ``margin`` blanks from the left.

    Where the screen is too narrow, the columns ``spare`` are left out, the last named first, and a line under the
    table names as many of them as it has room for; then the widest column is wrapped.
    """
    lines = [list(header), *(list(row) for row in rows)]
    screen = _screen.get()
    room = sys.maxsize if screen.wide else screen.columns - margin
    shown = list(range(len(header)))
    left = [name for name in spare if name in header]
    widths, over = _fit_columns(lines, room)
    while left and over > 0:
        name = left.pop()
        column = max(place for place, each in enumerate(lines[0]) if each == name)
        del shown[column]
        lines = [line[:column] + line[column + 1 :] for line in lines]
        widths, over = _fit_columns(lines, room)
    while over > 0 and max(widths) > _NARROW:
        widest = widths.index(max(widths))
        widths[widest] -= 1
        over -= 1
    text_lines = [*_cells(lines[0], widths), "  ".join("-" * width for width in widths)]
    for line in lines[1:]:
        text_lines += _cells(line, widths)
    omitted = [name for place, name in enumerate(header) if place not in shown]
    if omitted:
        names = textwrap.shorten(", ".join(omitted), max(room - _REMEDY, _NARROW), placeholder=" ...")
        text_lines += wrap(f"(not shown: {names}; --wide shows all columns)", room)
    return "\n".join(" " * margin + line for line in text_lines)


def _fit_columns(lines: Sequence[Sequence[str]], room: int) -> tuple[list[int], int]:
    """Widths of the columns, the first one narrowed as far as need and `_NAME` go, and what is still too wide."""
    widths = [max(map(_width, column)) for column in zip(*lines, strict=True)]
    over = sum(widths) + 2 * (len(widths) - 1) - room
    saved = min(max(over, 0), max(widths[0] - _NAME, 0))
    widths[0] -= saved
    return widths, over - saved


def _cells(line: Sequence[str], widths: Sequence[int]) -> list[str]:
    """The lines of a row: cells that are too wide are wrapped."""
    parts = [[cell] if _width(cell) <= width else wrap(cell, width) for cell, width in zip(line, widths, strict=True)]
    text_lines = []
    for cells in zip_longest(*parts, fillvalue=""):
        padded = [cell + " " * (width - _width(cell)) for cell, width in zip(cells, widths, strict=True)]
        text_lines.append("  ".join(padded).rstrip())
    return text_lines


def _width(cell: str) -> int:
    return len(_STYLE.sub("", cell))


def wrap(text: str, width: int, rest: str = "", first: str = "") -> list[str]:
    """Lines of ``text`` of at most ``width`` columns, if its words are no longer; ``rest`` begins all but the first."""
    joined = _UNITS.sub("\xa0", text)  # a number and its unit stay together
    lines = textwrap.wrap(joined, width, initial_indent=first, subsequent_indent=rest, break_on_hyphens=False)
    return [line.replace("\xa0", " ") for line in lines] or [first]


def facts(pairs: Iterable[tuple[str, str]]) -> list[str]:
    """Lines of labels and texts, the texts below one another."""
    return [line for label, text in pairs for line in paragraph(f"  {label:<{_LABEL - 3}} ", text, _LABEL)]


def paragraph(label: str, text: str, indent: int = 0) -> list[str]:
    """Lines of ``text`` behind ``label``, all but the first moved in by ``indent``; as wide as the screen."""
    return wrap(text, max(_screen.get().columns, len(label) + _NARROW), " " * indent, label)


def notes(warnings: Iterable[str]) -> list[str]:
    """Lines for ``warnings``, after a blank one; none for none."""
    lines = [line for warning in warnings for line in paragraph("  note: ", warning, 4)]
    return ["", *lines] if lines else []


def limits(warnings: Iterable[str]) -> list[str]:
    """Lines for ``warnings`` that limit an answer; they stand under it."""
    return [alarm(line) for warning in warnings for line in paragraph("  ! ", warning, 4)]


def error_text(error: float | None) -> str:
    """A relative error, to a tenth of a per cent, or as a factor from ten times on; a dash for None."""
    if error is None:
        return "-"
    if error >= 10:
        return f"factor {round_digits(1 + error, 2)}"
    if abs(error) < 5e-4:
        return f"{error:+.1e}"
    return f"{100 * error:+.1f} %"


def render(result: object, writer: str) -> str:
    """Text of ``result`` by the function at the address ``writer``, imported when it is used: results know no text."""
    return str(function_at(writer)(result))


def function_at(address: str) -> Any:
    """The function at ``module:name``."""
    module, _, name = address.partition(":")
    return getattr(importlib.import_module(module), name)


def render_on_screen(result: object, **changes: Any) -> str:
    """The text of a result on the present screen with these changes of its fields."""
    token = _screen.set(evolve(_screen.get(), **changes))
    try:
        return str(result)
    finally:
        _screen.reset(token)


def html_of(template: Path, filters: Iterable[Callable[..., object]] = (), **values: object) -> str:
    """A Jinja template, filled in with ``values``, which are escaped."""
    return _template(template, tuple(filters)).render(values).lstrip() + "\n"


@cache
def _template(file: Path, filters: tuple[Callable[..., object], ...]) -> Template:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(file.parent),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=lambda value: replace_unfit(value) if type(value) is str else value,
        trim_blocks=True,
        lstrip_blocks=True,
        optimized=False,  # compiling takes longer than rendering
    )
    environment.filters |= {function.__name__: function for function in filters}
    return environment.get_template(file.name)


def replace_unfit(text: str) -> str:
    """``text`` with a replacement sign for each character that HTML does not admit or that turns its direction."""
    return re.sub(_UNFIT, "\N{REPLACEMENT CHARACTER}", text)
