"""Numbers and formulae as text of a page: one function for each filter of the template."""

from __future__ import annotations

import math
import re
from html import escape

from markupsafe import Markup

from shockwave.pictures.drawing import si_label

_MINUS = "\N{MINUS SIGN}"
_BLANK = "\N{NO-BREAK SPACE}"
_POWER = re.compile(r"e\+?(-?)0*([0-9]+)")
# Symbols of the paper as they are written in statements, after escaping.
_SYMBOLS = (
    (r"\balphaF0\b", "\N{GREEK SMALL LETTER ALPHA}"),
    (r"\^\(-([0-9/]+)\)", rf"<sup>{_MINUS}\1</sup>"),
    (r"\b([Fta])([012])\b", r"<i>\1</i><sub>\2</sub>"),
    (r"\bA(?= <i>F)", "<i>A</i>"),
    (r"\bn(?= <i>t|-1\))", "<i>n</i>"),
    (r"&gt;=", "\N{GREATER-THAN OR EQUAL TO}"),
    (r"&lt;=", "\N{LESS-THAN OR EQUAL TO}"),
    (r"-1\)", f"{_MINUS}1)"),
)
# Of a figure at least, and what a float holds at most.
_LEAST_DIGITS = 3
_MOST_DIGITS = 15


def number(text: str) -> Markup:
    """A formatted number with a proper minus sign and raised powers of ten."""
    raised = f"{_BLANK}\N{MULTIPLICATION SIGN}{_BLANK}10<sup>\\1\\2</sup>"
    return Markup(_POWER.sub(raised, text).replace("-", _MINUS))


def quantity(value: float, unit: str = "", digits: int = 5) -> Markup:
    """``value`` with an SI prefix, kept on one line; a number without a unit has no prefix."""
    if not unit:
        return number(f"{value:.{digits}g}")
    figure, _, prefixed = si_label(value, unit, digits).partition(" ")
    return number(figure) + _BLANK + prefixed.replace(" ", _BLANK)


def small(value: float) -> Markup:
    """A share or an error, to one digit."""
    return number(f"{value:.1g}")


def percent(value: float, digits: int = 1) -> Markup:
    """A relative difference in percent, with its sign."""
    return number(f"{100 * value:+.{digits}f}" if abs(value) < 1e3 else f"{100 * value:+.1e}") + f"{_BLANK}%"


def formula(statement: str) -> Markup:
    """A statement with the symbols of the paper set as such."""
    text = escape(statement)
    for pattern, replacement in _SYMBOLS:
        text = re.sub(pattern, replacement, text)
    return Markup(text)


def digits_of(error_estimate: float | None) -> int:
    """Digits that a figure of this relative error has, and one more."""
    if error_estimate is None or not 0 < error_estimate < 1:
        return _LEAST_DIGITS
    return min(max(1 - math.floor(math.log10(error_estimate)), _LEAST_DIGITS), _MOST_DIGITS)
