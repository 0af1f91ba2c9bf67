"""Small numerical tools that every floor above may use."""

from __future__ import annotations

import math
from collections.abc import Callable

from shockwave.errors import NumericalError

__all__ = ["bracketed_root"]

_MOST_ITERATIONS = 200


def bracketed_root(function: Callable[[float], float], lower: float, upper: float, what: str) -> float:
    """The root of ``function`` between ``lower`` and ``upper``, to the last digits.

    Bisection speeded up by regula falsi (the Illinois variant): once the signs differ the bracket always shrinks,
    around any root but a multiple one at zero. ``what`` names the quantity in the error.

    Raises
    ------
    NumericalError
        When the ends are not in order or have the same sign, or the bracket has not closed after 200 iterations.
    """
    if not lower < upper:
        raise NumericalError(f"{what}: no bracket (got {lower:g} and {upper:g})")
    at_lower, at_upper = function(lower), function(upper)
    if at_lower == 0:
        return lower
    if at_upper == 0:
        return upper
    if (at_lower > 0) == (at_upper > 0):
        raise NumericalError(f"{what}: no change of sign between {lower:g} and {upper:g}")
    for count in range(_MOST_ITERATIONS):
        middle = (lower * at_upper - upper * at_lower) / (at_upper - at_lower)
        # Every third step is a bisection: regula falsi alone can creep.
        if count % 3 == 2 or not lower < middle < upper:
            # By the geometric mean where the bracket spans powers of ten.
            wide = 0 < 4 * lower < upper
            middle = math.sqrt(lower) * math.sqrt(upper) if wide else 0.5 * (lower + upper)
        if middle in (lower, upper):
            return middle
        at_middle = function(middle)
        if at_middle == 0:
            return middle
        if (at_middle > 0) == (at_upper > 0):
            upper, at_upper = middle, at_middle
            at_lower *= 0.5 if count % 3 != 2 else 1.0
        else:
            lower, at_lower = middle, at_middle
            at_upper *= 0.5 if count % 3 != 2 else 1.0
        if upper - lower <= 4e-16 * max(abs(lower), abs(upper)):
            return 0.5 * (lower + upper)
    raise NumericalError(f"{what}: not found in {_MOST_ITERATIONS} steps between {lower:g} and {upper:g}")
