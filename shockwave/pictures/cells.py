"""Cells of a map: their edges, the borders, names and hatches of regions of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from shockwave.errors import InvalidValueError
from shockwave.pictures.axes import named
from shockwave.pictures.style import BLACK, GREY

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

    from shockwave.quadrature import FloatArray

    Edges: TypeAlias = tuple[FloatArray, FloatArray]


#: A region that takes fewer cells than this share has no room for its name.
NAMED = 0.03
#: Colour of cells without a value.
NO_VALUE = "#BDBDBD"


def check_shapes(arrays: Mapping[str, npt.NDArray[Any]], x: FloatArray, y: FloatArray) -> None:
    """Raise `InvalidValueError` unless all arrays have the shape (x, y), two at least along both."""
    for name, array in arrays.items():
        if array.shape != (len(x), len(y)) or min(array.shape) < 2:
            rule = f"must have the shape ({len(x)}, {len(y)}) of the axes, two at least along both"
            raise InvalidValueError.of(name, f"{rule} (got {array.shape})")


def edges_of(centres: FloatArray, log: bool = False) -> FloatArray:
    """Edges of cells around ascending ``centres``, halfway between them on the axis as drawn."""
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    at = np.log(centres) if log else np.asarray(centres, dtype=float)
    middles = (at[1:] + at[:-1]) / 2
    edges = np.concatenate(([2 * at[0] - middles[0]], middles, [2 * at[-1] - middles[-1]]))
    return np.exp(edges) if log else edges


def _inmost(own: npt.NDArray[np.bool_]) -> tuple[int, int]:
    """The cell that is farthest from the border of its region, and of those the nearest to their middle."""
    from scipy.ndimage import distance_transform_cdt

    depth = distance_transform_cdt(np.pad(own, 1), "taxicab")[1:-1, 1:-1]
    cells = np.argwhere(depth == depth.max())
    i, j = cells[np.argmin(((cells - cells.mean(axis=0)) ** 2).sum(axis=1))]
    return int(i), int(j)


def regions(ax: Axes, x: FloatArray, y: FloatArray, regimes: Mapping[str, FloatArray]) -> None:
    """Borders and names of regimes.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    x, y : array
        Centres of the cells.
    regimes : mapping of str to array, shape (x, y)
        Numbers that are below 0 within the regime and above outside.
    """
    shares = {name: float(np.mean(inside < 0)) for name, inside in regimes.items()}
    # the borders of all but one are those of that one, too: of the narrowest, which would come out worst
    spare = min(shares, key=lambda name: shares[name]) if len(shares) > 1 else None
    for name, share in shares.items():
        if share == 0:
            continue
        if share < 1 and name != spare:
            ax.contour(x, y, regimes[name].T, levels=[0.0], colors=[BLACK], linewidths=1.2)
        i, j = _inmost(regimes[name] < 0)
        # where there is no room, the name stands beside the regime, on the side where there is more
        shift = (0, 0) if share >= NAMED else (-34 if 2 * i > len(x) else 34, -14)
        named(ax, x[i], y[j], name, shift)


def hatch(
    ax: Axes, edges: Edges, own: npt.NDArray[np.bool_], name: str, pattern: str, colour: str = "none"
) -> list[Patch]:
    """Hatch some cells; the entry of the key, with their number, or none without any."""
    from matplotlib.patches import Patch, PathPatch
    from matplotlib.path import Path

    if not own.any():
        return []
    x, y = edges
    i, j = np.nonzero(own)
    corners = np.array([[x[i], y[j]], [x[i + 1], y[j]], [x[i + 1], y[j + 1]], [x[i], y[j + 1]]])
    # one path: a hatch for each of some thousand cells takes minutes
    path = Path.make_compound_path_from_polys(corners.transpose(2, 0, 1))
    # over colours, a grey that is seen on light and dark ones
    ink = GREY if colour == "none" else "#404040"
    look: dict[str, Any] = {"facecolor": colour, "edgecolor": ink, "linewidth": 0.0, "hatch": pattern}
    ax.add_artist(PathPatch(path, **look))
    return [Patch(label=f"{name} ({int(own.sum())} of {own.size})", **look)]
