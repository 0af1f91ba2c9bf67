"""The elastic, perfectly plastic contact of Thornton."""

from __future__ import annotations

import math

import numpy as np
from attrs import frozen
from shockwave import ContactLaw, quantity
from shockwave.hooks import FloatArray, Pairs


@frozen(kw_only=True)
class Thornton(ContactLaw):
    """Hertz's contact up to first yield, then a constant pressure in the growing part of the contact area.

    C. Thornton, J. Appl. Mech. 64 (1997) 383. The pressure at the centre of the contact is limited to
    ``yield_pressure`` p. It is reached at the overlap d_y = (pi p / (2 E*))^2 R* and the force
    F_y = pi^3 p^3 R*^2 / (6 E*^2). Beyond it

        F = F_y + pi p R* (d - d_y).

    Unloading from the greatest force F_m, and reloading, is Hertzian with the radius R_m = 4 E* a^3 / (3 F_m)
    of the flattened contact, where a^2 = (2 F_m + F_y) / (2 pi p):

        F = 4/3 E* sqrt(R_m) (d - d_m + a^2/R_m)^(3/2).

    The state of a contact is its greatest overlap d_m.

    Parameters
    ----------
    yield_pressure : float
        Greatest contact pressure p [Pa], above 0; 1.6 times the yield strength of the softer body is usual,
        and 2.8 times agrees better with finite elements.
    """

    states = 1

    yield_pressure: float = quantity(
        "Pa", "greatest contact pressure, 1.6 to 2.8 times the yield strength", above=0
    )

    def force(
        self, overlap: FloatArray, closing_velocity: FloatArray, state: FloatArray, pairs: Pairs
    ) -> FloatArray:
        """Forces on the curve of loading, or of unloading below the greatest overlap."""
        greatest = np.maximum(overlap, state[0])
        loading = self._loading(greatest, pairs)
        yields, first = self.first_yield(pairs)
        plastic = np.maximum(loading, first)
        area = (2 * plastic + first) / (2 * math.pi * self.yield_pressure)
        radius = 4 * pairs.moduli * area * np.sqrt(area) / (3 * plastic)
        elastic = np.maximum(overlap - greatest + area / radius, 0.0)
        unloading = 4 / 3 * pairs.moduli * np.sqrt(radius) * elastic * np.sqrt(elastic)
        hertz = 4 / 3 * pairs.moduli * np.sqrt(pairs.radii) * np.maximum(overlap, 0.0) ** 1.5
        below = np.where(greatest > yields, unloading, hertz)
        return np.where(overlap < greatest, below, loading)

    def update(
        self, overlap: FloatArray, closing_velocity: FloatArray, state: FloatArray, pairs: Pairs
    ) -> FloatArray:
        """The greatest overlaps so far."""
        return np.maximum(state, overlap)

    def first_yield(self, pairs: Pairs) -> tuple[FloatArray, FloatArray]:
        """Overlap d_y [m] and force F_y [N] at first yield."""
        ratio = math.pi * self.yield_pressure / (2 * pairs.moduli)
        overlap = ratio * ratio * pairs.radii
        return overlap, 4 / 3 * pairs.moduli * pairs.radii * pairs.radii * ratio**3

    def _loading(self, overlap: FloatArray, pairs: Pairs) -> FloatArray:
        """Forces of a first loading."""
        yields, _ = self.first_yield(pairs)
        closed = np.maximum(overlap, 0.0)
        hertz = 4 / 3 * pairs.moduli * np.sqrt(pairs.radii) * np.minimum(closed, yields) ** 1.5
        return hertz + math.pi * self.yield_pressure * pairs.radii * np.maximum(closed - yields, 0.0)
