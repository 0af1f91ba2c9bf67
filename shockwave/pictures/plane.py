"""Cells of a plane: where they end, and where in a region of them its name stands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from shockwave.quadrature import FloatArray

__all__ = ["edges_of", "inmost"]


def edges_of(centres: FloatArray, log: bool) -> FloatArray:
    """Borders of cells around ``centres``, two or more and ascending, halfway between them on the axis as drawn."""
    at = np.log(centres) if log else np.asarray(centres, dtype=float)
    middles = (at[1:] + at[:-1]) / 2
    edges = np.concatenate(([2 * at[0] - middles[0]], middles, [2 * at[-1] - middles[-1]]))
    return np.exp(edges) if log else edges


def inmost(own: npt.NDArray[np.bool_]) -> tuple[int, int]:
    """The cell that is farthest from the border of its region, and of those the nearest to their middle."""
    depth, layer = np.zeros(own.shape, dtype=int), own.copy()
    while layer.any():
        depth += layer
        ringed = np.pad(layer, 1)
        layer = layer & ringed[:-2, 1:-1] & ringed[2:, 1:-1] & ringed[1:-1, :-2] & ringed[1:-1, 2:]
    cells = np.argwhere(depth == depth.max())
    i, j = cells[np.argmin(((cells - cells.mean(axis=0)) ** 2).sum(axis=1))]
    return int(i), int(j)
