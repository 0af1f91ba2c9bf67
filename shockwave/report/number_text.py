"""Numbers and formulae of a page: one function for each filter of the template."""

from __future__ import annotations

import re
from html import escape

from markupsafe import Markup

from shockwave.pictures.picture_elements import si_label

# Relative difference below which a percentage would show no digit.
_TINY = 5e-4
_MINUS = "\N{MINUS SIGN}"
_BLANK = "\N{NO-BREAK SPACE}"
# Numbers with a power of ten or a unit with the prefix micro, in sentences.
_IN_SENTENCES = re.compile(r"(?<!\w)-?\b[0-9.]+(?:e[+-]?[0-9]+)?(?: u(?=[smNJ]\b))?")
# Symbols of constants before their values.
_CONSTANTS = {"E": "E", "nu": "\N{GREEK SMALL LETTER NU}", "rho": "\N{GREEK SMALL LETTER RHO}", "n": "n"}
_POWER = re.compile(r"e\+?(-?)0*([0-9]+)")
# Symbols of the paper in statements, after escaping.
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


def number(text: str) -> Markup:
    """Return a formatted number with a minus sign and superscript powers of ten."""
    raised = f"{_BLANK}\N{MULTIPLICATION SIGN}{_BLANK}10<sup>\\1\\2</sup>"
    return Markup(_POWER.sub(raised, text).replace("-", _MINUS))


def typeset(sentence: object) -> Markup:
    """Return a sentence with its numbers as in `number`, and the micro sign in its units."""

    def replace_number(match: re.Match[str]) -> str:
        return number(match[0]).replace(" u", f"{_BLANK}\N{MICRO SIGN}")

    typed = _IN_SENTENCES.sub(replace_number, escape(str(sentence)))
    typed = re.sub(r"\b(E|nu|rho|n)(?= (?:= )?[0-9])", lambda name: f"<i>{_CONSTANTS[name[0]]}</i>", typed)
    return Markup(re.sub(r"\^([0-9])\b", r"<sup>\1</sup>", typed))


def quantity(value: float, unit: str = "", digits: int = 5, error: float | None = None) -> Markup:
    """Return ``value`` with an SI prefix if it has a unit, with the digits that its relative ``error`` supports."""
    figure, blank, prefixed = si_label(value, unit, digits, error).partition(" ")
    return number(figure) + (blank + prefixed).replace(" ", _BLANK)


def small(value: float) -> Markup:
    """Return a ratio or an error to one digit."""
    return number(f"{value:.1g}")


def percent(value: float) -> Markup:
    """Return a relative difference in percent, with its sign; a tiny one as a power of ten."""
    if 0 < abs(value) < _TINY:
        return number(f"{value:+.1e}")
    return number(f"{100 * value:+.1f}" if abs(value) < 1e3 else f"{100 * value:+.1e}") + f"{_BLANK}%"


def formula(statement: str) -> Markup:
    """Return a statement with the symbols of the paper typeset."""
    text = escape(statement)
    for pattern, replacement in _SYMBOLS:
        text = re.sub(pattern, replacement, text)
    return Markup(text)
