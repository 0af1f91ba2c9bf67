"""Difference of argument and sine, for integrals of pulses, without cancellation."""

from __future__ import annotations

import numpy as np
from shockwave.hooks import FloatArray

__all__ = ["less_sine"]

# Below this argument x - sin(x) is computed by its series, because the difference loses digits.
_SMALL = 1.0
# Terms of this series, for an error below rounding at x = _SMALL.
_TERMS = 8


def less_sine(x: FloatArray) -> FloatArray:
    """x - sin(x) for x >= 0, accurate to rounding; same shape as ``x``."""
    small = np.minimum(x, _SMALL)
    series = np.ones_like(small)
    for k in reversed(range(2, _TERMS + 2)):
        series = 1.0 - small**2 / (2 * k * (2 * k + 1)) * series
    return np.where(x < _SMALL, small**3 / 6 * series, x - np.sin(x))
