"""Cells of a plane: where they end, how regions of them are drawn, and where the name of one stands."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from shockwave.pictures.style import BLACK, GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

    from shockwave.quadrature import FloatArray

    Edges: TypeAlias = tuple[FloatArray, FloatArray]

__all__ = ["border", "edges_of", "hatch", "inmost"]


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


def border(ax: Axes, edges: Edges, own: npt.NDArray[np.bool_]) -> None:
    """The border of some cells, along the cells."""
    from matplotlib.collections import LineCollection

    x, y = edges
    upright = [[(x[i + 1], y[j]), (x[i + 1], y[j + 1])] for i, j in np.argwhere(own[1:] != own[:-1])]
    level = [[(x[i], y[j + 1]), (x[i + 1], y[j + 1])] for i, j in np.argwhere(own[:, 1:] != own[:, :-1])]
    ax.add_collection(LineCollection(upright + level, colors=[BLACK], linewidths=1.2), autolim=False)


def hatch(ax: Axes, edges: Edges, own: npt.NDArray[np.bool_], name: str, pattern: str, colour: str) -> Patch | None:
    """Hatch some cells; for the key, what they look like and how many they are, or None for none."""
    from matplotlib.patches import Patch, PathPatch
    from matplotlib.path import Path

    if not own.any():
        return None
    x, y = edges
    i, j = np.nonzero(own)
    corners = [(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])]
    # one path: a hatch for each of some thousand cells takes minutes
    path = Path.make_compound_path_from_polys(np.stack([np.stack(corner, axis=-1) for corner in corners], axis=1))
    # over colours, a grey that is seen on light and dark ones
    ink = GREY if colour == "none" else "#404040"
    look: dict[str, Any] = {"facecolor": colour, "edgecolor": ink, "linewidth": 0.0, "hatch": pattern}
    ax.add_artist(PathPatch(path, **look))
    return Patch(label=f"{name} ({int(own.sum())} of {own.size})", **look)
