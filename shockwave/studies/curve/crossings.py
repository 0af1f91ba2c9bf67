"""Crossings: every place where a response has a wanted value, from its turning points, between which it is monotone."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.polynomial import polynomial

from shockwave.numerics import bracketed_root
from shockwave.prediction.short_shock_law import CORRECTION
from shockwave.quadrature import FloatArray
from shockwave.studies.curve.universal import UniversalCurve

__all__ = ["Landmarks", "crossings", "landmarks", "tilted"]

#: Ends and turning points of a function, ascending, as (x, value).
Landmarks = Sequence[tuple[float, float]]
# A root of a polynomial is real if its imaginary part is rounding.
_REAL = 1e-9


def tilted(curve: UniversalCurve, slope: float) -> Callable[[npt.ArrayLike], FloatArray]:
    """The function ln (F/F0) + ``slope`` x of x = ln (t0/T0)."""

    def function(x: npt.ArrayLike) -> FloatArray:
        # rounding must not put the end beyond the range
        ratios = np.minimum(np.exp(x), curve.longest_rise_time)
        return np.asarray(np.log(curve.amplification(ratios)) + slope * np.asarray(x))

    return function


def landmarks(curve: UniversalCurve, slope: float, least: float, most: float) -> Landmarks:
    """Ends and turning points of `tilted` between ``least`` and ``most``, which are logarithms of t0/T0."""
    start = math.log(curve.shape.duration_ratio)
    whole = 1.2 + slope
    points = [x - start for x in _joints_and_turns(curve, whole)]
    # for short shocks its derivative is a quadratic in (t0/T0)^3
    leaving = CORRECTION * curve.shape.correction
    roots = polynomial.polyroots(np.trim_zeros(np.array([whole, -3 * leaving, 6 * curve.second_correction]), "b"))
    cubes = roots.real[(np.abs(roots.imag) < _REAL) & (roots.real > 0)]
    points += [x for x in (np.log(cubes) / 3).tolist() if x < curve.short_end - start]
    whole_line = [least, *sorted(x for x in points if least < x < most), most]
    return list(zip(whole_line, tilted(curve, slope)(whole_line).tolist(), strict=True))


def _joints_and_turns(curve: UniversalCurve, slope: float) -> list[float]:
    pieces = curve.series.pieces if curve.series is not None else ()
    return [curve.short_end, *(x for piece in pieces for x in (*piece.turns(slope), piece.end))]


def crossings(
    function: Callable[[float], Any], known: Landmarks, value: float, tolerance: Callable[[float], float]
) -> list[float]:
    """All x at which ``function`` has ``value``, ascending.

    Parameters
    ----------
    function : callable
        Of a number, monotone between the landmarks.
    known : Landmarks
        Its ends and turning points.
    value : float
        What is wanted.
    tolerance : callable
        Error of the function at x: a landmark that is within it of the value, with no crossing beside it, is one.
    """
    found: dict[int, float] = {}

    def off(x: float) -> float:
        return float(function(x)) - value

    for index, ((begin, low), (end, high)) in enumerate(pairwise(known)):
        if (low - value) * (high - value) < 0:
            sides = off(begin), off(end)
            # in the jump where two polynomials join rounding may have put it on the other side
            jump = sides[0] * sides[1] >= 0
            nearest = begin if abs(sides[0]) <= abs(sides[1]) else end
            found[index] = nearest if jump else bracketed_root(off, begin, end, "crossing")
    touching: list[int] = []
    for index, (x, height) in enumerate(known):
        alone = index not in found and index - 1 not in found and index - 1 not in touching
        if alone and abs(height - value) <= tolerance(x):
            touching.append(index)
    return sorted([*found.values(), *(known[index][0] for index in touching)])
