"""Maximum of a sampled history."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def sampled_peak(force: NDArray[np.floating[Any]], step: float) -> tuple[float, float]:
    """Maximum of a sampled force and its time, from a polynomial through nine samples."""
    highest = int(force.argmax())
    curve = np.polynomial.Polynomial.fit(np.arange(-4, 5), force[highest - 4 : highest + 5], 8, domain=[-4, 4])
    offset, slope = 0.0, curve.deriv()
    for _ in range(6):
        offset -= slope(offset) / slope.deriv()(offset)
    return float(curve(offset)), (highest + offset) * step
