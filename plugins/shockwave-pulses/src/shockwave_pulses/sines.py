"""Differences of sines that pulses are integrated with, to rounding."""

from __future__ import annotations

import numpy as np
from shockwave.quadrature import FloatArray

__all__ = ["less_sine"]

# Below this argument x - sin(x) loses digits, and so many terms of its series are exact to rounding.
_SMALL = 1.0
_TERMS = 8


def less_sine(x: FloatArray) -> FloatArray:
    """x - sin(x) for x >= 0, to rounding; same shape as ``x``."""
    small = np.minimum(x, _SMALL)
    series = np.ones_like(small)
    for k in reversed(range(2, _TERMS + 2)):
        series = 1.0 - small**2 / (2 * k * (2 * k + 1)) * series
    return np.where(x < _SMALL, small**3 / 6 * series, x - np.sin(x))
