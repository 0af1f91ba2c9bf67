"""First yield of a contact between two spheres, or a sphere and a flat."""

from __future__ import annotations

import math
from typing import TypeVar

from shockwave.quadrature import FloatArray

_Number = TypeVar("_Number", float, FloatArray)
# Pressure at the centre of the contact at first yield, over the yield strength: 1.6 for a Poisson ratio of 0.3
# (Johnson, Contact Mechanics, section 6.1).
_PRESSURE = 1.6


def first_yield_force(radius: _Number, modulus: _Number, strength: _Number) -> _Number:
    """F_y = pi^3 R*^2 (1.6 sigma_y)^3 / (6 E*^2) [N], for the yield strength of the softer body.

    ``radius`` R* [m], ``modulus`` E* [Pa] and ``strength`` sigma_y [Pa] are numbers, or arrays of the same shape.
    """
    pressure = _PRESSURE * strength
    size = radius / modulus
    return math.pi**3 / 6 * size * size * pressure * pressure * pressure
