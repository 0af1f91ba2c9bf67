"""Contact force in scaled units, a power of the overlap, for floats and for arrays."""

from __future__ import annotations

import math

import numpy as np

from shockwave.base.numerics import FloatArray, elementwise
from shockwave.scene.chain import HERTZ


def stiffening(overlap: float, exponent: float) -> float:
    """Overlap to the power p - 1; for Hertz's p the square root, which every processor rounds correctly."""
    return math.sqrt(overlap) if exponent == HERTZ else math.pow(overlap, exponent - 1)


def stiffenings(overlap: FloatArray, exponent: float) -> FloatArray:
    """Overlaps, zero or positive, to the power p - 1."""
    if exponent == HERTZ:
        return np.asarray(np.sqrt(overlap))
    # as in the compiled code: the steps amplify a difference in the last digit
    return elementwise(lambda each: math.pow(each, exponent - 1), overlap)


def power_force(overlap: FloatArray, exponent: float = HERTZ) -> FloatArray:
    """Contact forces at these overlaps, zero or positive."""
    return np.asarray(overlap * stiffenings(overlap, exponent))


def contact_force(overlap: float, exponent: float) -> float:
    """Contact force at an overlap, in scaled units."""
    return overlap * stiffening(overlap, exponent) if overlap > 0 else 0.0
