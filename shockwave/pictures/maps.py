"""Maps: cells and their colours, regime borders, hatches, and the map of the errors of section 4."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from shockwave.pictures.drawing import BLACK, FIELD, GREY, MINUS, SIGNED, colour_scale, finish, place_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

    from shockwave.quadrature import FloatArray

    Edges: TypeAlias = tuple[FloatArray, FloatArray]


#: Colour of cells without a value.
NO_VALUE = "#BDBDBD"
# Ratio of greatest and least value above which colours are logarithmic.
_WIDE = 300.0
# Bounds of the colours of relative errors, which are at least -1 and have no upper bound.
_BOUNDS = (-1.0, -0.5, -0.2, -0.1, -0.05, -0.02, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)


def edges_of(centres: FloatArray, log: bool = False) -> FloatArray:
    """Return the edges of cells around ascending ``centres``: the midpoints on the drawn axis."""
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    at = np.log(centres) if log else centres
    middles = (at[1:] + at[:-1]) / 2
    edges = np.concatenate(([2 * at[0] - middles[0]], middles, [2 * at[-1] - middles[-1]]))
    return np.exp(edges) if log else edges


def colour_cells(ax: Axes, edges: Edges, values: FloatArray, **colours: Any) -> Any:
    """Draw a map of ``values``, of shape (x, y); cells without a value are grey."""
    ax.set_facecolor(NO_VALUE)
    masked = np.ma.masked_invalid(values).T
    drawn = ax.pcolormesh(*edges, masked, rasterized=True, shading="flat", **colours)
    ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
    ax.grid(False)
    ax.spines[:].set_visible(True)
    return drawn


def colours_of(known: FloatArray) -> dict[str, Any]:
    """Return colour map and norm for these values, which are finite."""
    from matplotlib.colors import AsinhNorm, LogNorm, Normalize

    least, most = (known.min(), known.max()) if known.size else (0.0, 1.0)
    if least < 0 < most:
        limit = max(-least, most)
        usual = np.median(np.abs(known)) / 10
        return {"norm": AsinhNorm(usual or limit, vmin=-limit, vmax=limit), "cmap": SIGNED}
    wide = 0 < _WIDE * least < most
    return {"norm": (LogNorm if wide else Normalize)(least, most), "cmap": FIELD}


def regime_borders(ax: Axes, edges: Edges, regimes: npt.NDArray[np.str_]) -> None:
    """Draw the borders between cells of different regimes, and label the regimes; an empty name is no regime."""
    x, y = edges
    across = np.nonzero(regimes[1:] != regimes[:-1])
    up = np.nonzero(regimes[:, 1:] != regimes[:, :-1])
    # with a white outline, to be visible on dark colours
    for colour, width in (("white", 2.6), (BLACK, 1.2)):
        i, j = across
        ax.vlines(x[i + 1], y[j], y[j + 1], color=colour, linewidth=width)
        i, j = up
        ax.hlines(y[j + 1], x[i], x[i + 1], color=colour, linewidth=width)
    for name in sorted(set(regimes.ravel().tolist()) - {""}):
        cells = np.argwhere(regimes == name)
        off = cells - cells.mean(axis=0)
        i, j = cells[np.argmin((off**2).sum(axis=1))]
        place_name(ax, (x[i] + x[i + 1]) / 2, (y[j] + y[j + 1]) / 2, name)


def hatch(
    ax: Axes, edges: Edges, own: npt.NDArray[np.bool_], name: str, pattern: str, colour: str = "none"
) -> list[Patch]:
    """Hatch some cells, and return the legend entry with their number, if there are any."""
    from matplotlib.patches import Patch, PathPatch
    from matplotlib.path import Path

    if not own.any():
        return []
    x, y = edges
    i, j = np.nonzero(own)
    corners = np.array([[x[i], y[j]], [x[i + 1], y[j]], [x[i + 1], y[j + 1]], [x[i], y[j + 1]]])
    # a single path: thousands of hatched cells would take minutes
    path = Path.make_compound_path_from_polys(corners.transpose(2, 0, 1))
    look: dict[str, Any] = {"facecolor": colour, "edgecolor": GREY, "linewidth": 0.0, "hatch": pattern}
    ax.add_artist(PathPatch(path, **look))
    return [Patch(label=f"{name} ({int(own.sum())} of {own.size})", **look)]


def trust_map(
    ax: Axes,
    x: npt.ArrayLike,
    n: npt.ArrayLike,
    error: npt.ArrayLike,
    regime: npt.ArrayLike,
    holds: npt.ArrayLike | None = None,
) -> Axes:
    """Draw the error of the predicted peak force over the plane (n t0/T0, n), with the regime borders.

    Parameters
    ----------
    ax : Axes
        Axes to draw on; a colour bar is added beside it.
    x : array, shape (p,)
        n t0/T0, ascending, above 0.
    n : array, shape (q,)
        Duration ratios, ascending, above 1.
    error : array, shape (p, q)
        Relative error, prediction / simulation - 1; NaN, drawn grey, where there is none.
    regime : array of str, shape (p, q)
        Predicted regime; empty where there is none.
    holds : array of bool, shape (p, q), optional
        Whether the conditions (3) hold; the other cells are hatched.
    """
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm

    edges = edges_of(np.asarray(x, dtype=float), log=True), edges_of(np.asarray(n, dtype=float), log=True)
    colours = colormaps[SIGNED]
    norm = BoundaryNorm(_BOUNDS, colours.N, extend="max")
    ax.set(xscale="log", yscale="log")
    drawn = colour_cells(ax, edges, np.asarray(error, dtype=float), norm=norm, cmap=colours)
    regime_borders(ax, edges, np.asarray(regime, dtype=str))
    if holds is not None:
        hatch(ax, edges, ~np.asarray(holds, dtype=bool), "conditions (3) fail", "////")
    bar = colour_scale(ax, drawn, "error (%)", spacing="uniform", ticks=_BOUNDS)
    bar.ax.set_yticklabels([f"{100 * bound:+.0f}".replace("-", MINUS) for bound in _BOUNDS])
    x_label, y_label = ("duration / characteristic time, n t₀/T₀", ""), ("duration ratio, n", "")
    return finish(ax, x_label, y_label, legend=False)
