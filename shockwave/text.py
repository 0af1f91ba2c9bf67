"""Numbers and tables as text for people, and text that documents admit."""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Iterable, Sequence

# Characters that HTML does not admit, and those that turn the direction of the text behind them.
_UNFIT = re.compile(
    "[^\t\n\x20-\x7e\xa0-\u2029\u202f-\u2065\u206a-\ud7ff\ue000-\ufdcf\ufdf0-\ufffd\U00010000-\U0010fffd]"
)
_PREFIXES = {-12: "p", -9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


def si(value: float, unit: str, digits: int = 5) -> str:
    """``value`` with an SI prefix, if ``unit`` takes one: ``si(1.5e-5, "s")`` is ``15 us``."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    exponent = 3 * math.floor(math.log10(abs(value) * (1 + 1e-12)) / 3)
    if exponent not in _PREFIXES or unit.startswith("kg") or "**" in unit:
        return f"{value:.{digits}g} {unit}"
    return f"{value / 10**exponent:.{digits}g} {_PREFIXES[exponent]}{unit}"


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Columns under a ruled header, as wide as they need to be."""
    lines = [list(header), *(list(row) for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(header))]
    text = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines]
    return "\n".join([text[0], "  ".join("-" * width for width in widths), *text[1:]])


def range_text(bounds: tuple[float, float] | None) -> str:
    """A range of relative errors, in percent unless it is far below, or that it is not known."""
    if bounds is None:
        return "not known"
    # more digits where these would show nothing
    form = "+.1%" if max(map(abs, bounds)) >= 5e-4 else "+.1e"
    return f"{bounds[0]:{form}} to {bounds[1]:{form}}"


def indent(text: str) -> str:
    """``text`` moved in by two blanks."""
    return "\n".join(f"  {line}" for line in text.splitlines())


def notes(warnings: Iterable[str]) -> list[str]:
    """Lines for ``warnings``, after a blank one; none for none."""
    lines = [f"  note: {warning}" for warning in warnings]
    return ["", *lines] if lines else []


def printed(result: object, writer: str) -> str:
    """Text of ``result`` by the function at the address ``writer``, imported when it is used: results know no text."""
    module, _, name = writer.partition(":")
    text: str = getattr(importlib.import_module(module), name)(result)
    return text


def admitted(text: str) -> str:
    """``text`` with a replacement sign for each character that HTML does not admit or that turns its direction."""
    return _UNFIT.sub("\N{REPLACEMENT CHARACTER}", text)
