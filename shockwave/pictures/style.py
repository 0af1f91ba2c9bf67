"""The look of all pictures: colours, lines, letters, numbers with units."""

from __future__ import annotations

from typing import Any

from shockwave.text import si

# Okabe and Ito, "Color universal design" (2008); its yellow is left out, which is not seen on white.
BLACK = "#000000"
BLUE = "#0072B2"
VERMILION = "#D55E00"
GREEN = "#009E73"
ORANGE = "#E69F00"
SKY = "#56B4E9"
PURPLE = "#CC79A7"
GREY = "#767676"
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
#: In grey, lines are distinguished by dashes and marks.
LINES: tuple[Any, ...] = ("-", "--", "-.", (0, (1, 1)), (0, (5, 1, 1, 1, 1, 1)), (0, (7, 2)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*")
#: Colour maps of a quantity without and with a sign; both are monotonic in lightness.
FIELD = "magma_r"
SIGNED = "RdBu_r"
#: Sizes of letters [pt], readable in a column.
LABEL = 8.0
SMALL = 7.0
MINUS = "\N{MINUS SIGN}"


def thousandths(value: float, unit: str, digits: int = 3) -> str:
    """``value`` with its unit as a label: as `si`, with the sign for a millionth."""
    number, _, prefixed = si(value, unit, digits).partition(" ")
    return f"{number} \N{MICRO SIGN}{unit}" if prefixed == f"u{unit}" else f"{number} {prefixed}"


def literal(text: str) -> str:
    """Somebody's words as a label: a dollar in them begins no formula."""
    return text.replace("$", r"\$")
