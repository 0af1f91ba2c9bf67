"""Where a function is not smooth: jumps, kinks and unbounded slopes are distinguished from what is merely steep."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.polynomial.chebyshev import chebinterpolate

from shockwave.quadrature import FloatArray, Integrand

_DEGREE = 32
# So many of the last coefficients show what a polynomial misses. A jump moves each; fewer may vanish by symmetry.
_TAIL = 6
# What is missing counts above this share of 1.
_LEAST = 1e-12
# It counts above so many roundings of the abscissae.
_ROUNDINGS = 100.0
# Panels are wider than so many spacings of numbers.
_NARROWEST = 4096.0
# Panels that are followed, the worst first.
_FOLLOWED = 64
# No simple fractions: a corner in the middle of a piece shall not fall between two panels; nor in both of two searches.
_CUTS = (0.4563, 0.5311)
# A smooth function's tail plunges once a panel is as narrow as its layer, ever faster from panel to panel; that of a
# jump stays, that of a kink halves, that of a jump of derivative p falls as 2^-p.
_PLUNGE = 2.0**-4.5
# So many panels in a row decide.
_ROW = 4
# Slopes next to a breakpoint: widths halve so often.
_HALVINGS = 34
# Over four of them in a row the slope of s^0.96 grows by 1.117.
_GROWTH = 1.1
_PERSISTENT = 0.6


def roughness(function: Integrand, points: Sequence[float]) -> str | None:
    """A place between ``points`` where ``function``, of order 1, is not smooth, in words; None where none is found.

    Panels are divided where the function is no polynomial of degree 32, and their tails compared from one to the next.
    Panels that touch one of the points are divided, too, and not judged.
    """
    return _searched(function, points, _CUTS[0]) or _searched(function, points, _CUTS[1])


def _searched(function: Integrand, points: Sequence[float], cut: float) -> str | None:
    # Each panel with its tail, followed by those of its ancestors, the nearest first.
    panels = [(begin, end, [_tail(function, begin, end)]) for begin, end in pairwise(points)]
    while panels:
        parts = []
        for begin, end, tails in sorted(panels, key=lambda panel: -panel[2][0])[:_FOLLOWED]:
            between = begin + cut * (end - begin)
            wide = end - begin > _NARROWEST * np.spacing(end)
            halves = [(begin, between), (between, end)] if wide else []
            divided = [(*half, [_tail(function, *half), *tails]) for half in halves]
            rough = [part for part in divided if part[2][0] > 0]
            if not rough and begin not in points and end not in points and _is_slow(tails):
                return f"{_kind(tails)} at s = {(begin + end) / 2:.9g} (between {begin!r} and {end!r})"
            parts += rough
        panels = parts
    return None


def _tail(function: Integrand, begin: float, end: float) -> float:
    """What the polynomial of a panel misses; 0 where that may be rounding."""
    half = 0.5 * (end - begin)
    coefficients = chebinterpolate(lambda z: function(begin + half + half * z), _DEGREE)  # type: ignore[type-var]
    missing = float(np.abs(coefficients[-_TAIL:]).sum())
    steepness = float(np.abs(coefficients[1:]).sum()) / half
    return missing if missing > max(_LEAST, _ROUNDINGS * np.spacing(end) * steepness) else 0.0


def _is_slow(tails: Sequence[float]) -> bool:
    """Whether what is missing has fallen no faster than next to a jump of a derivative, time after time."""
    return len(tails) > _ROW and all(tails[i] >= _PLUNGE * tails[i + 1] for i in range(_ROW))


def _kind(tails: Sequence[float]) -> str:
    fall = np.log2(tails[_ROW] / tails[0]) / _ROW
    return "a jump" if fall < 0.5 else "a kink" if fall < 1.5 else "a jump of a higher derivative"


def steepening(function: Integrand, point: float, other: float) -> float | None:
    """The slope of ``function`` next to ``point``, towards ``other``, if it grows without end; else None."""
    least = max(2.0**-_HALVINGS, _NARROWEST * float(np.spacing(abs(point))) / abs(other - point))
    shares = 0.5 ** np.arange(1, int(-np.log2(least)) + 1)
    values = function(point + (other - point) * np.append(shares, shares[-1] / 2))
    rises: FloatArray = np.abs(np.diff(values))
    if rises.size < 9 or min(rises[-9:]) <= 10 * _ROUNDINGS * np.finfo(float).eps * np.abs(values).max():
        return None
    slopes = rises / (abs(other - point) * shares / 2)
    last, before = slopes[-1] / slopes[-5], slopes[-5] / slopes[-9]
    # The slope of a layer that is merely steep grows ever less as its width is passed.
    endless = last >= _GROWTH and np.log(last) >= _PERSISTENT * np.log(before)
    return float(slopes[-1]) if endless else None
