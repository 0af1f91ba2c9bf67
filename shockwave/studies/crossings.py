"""All zeros of a function of which the turning points are known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

from shockwave.numerics import bracketed_root


def crossings(
    function: Callable[[float], float],
    points: Sequence[float],
    tolerance: Callable[[float], float] = lambda _: 0.0,
) -> list[float]:
    """All x at which ``function`` is zero, ascending.

    Parameters
    ----------
    function : callable
        Of a number, monotone between the points.
    points : sequence of float
        Its ends and turning points, ascending.
    tolerance : callable
        Error of the function at x: a point where it is within this of zero, with no crossing beside it, is one. Of two
        such neighbours the first is.
    """
    heights = [function(x) for x in points]
    found: dict[int, float] = {}
    for index, ((begin, low), (end, high)) in enumerate(pairwise(zip(points, heights, strict=True))):
        if low * high < 0:
            found[index] = bracketed_root(function, begin, end, "crossing")
    touching: dict[int, float] = {}
    for index, (x, height) in enumerate(zip(points, heights, strict=True)):
        alone = index not in found and index - 1 not in found and index - 1 not in touching
        if alone and abs(height) <= tolerance(x):
            touching[index] = x
    return sorted([*found.values(), *touching.values()])
