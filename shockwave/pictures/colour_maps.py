"""Maps: cells and their colours, and borders of regimes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from shockwave.base.numerics import FloatArray
from shockwave.pictures.picture_elements import SIGNED, SMALL, Axes, field_colours, halo, ink, paper

if TYPE_CHECKING:
    Edges: TypeAlias = tuple[FloatArray, FloatArray]


# Colour of cells without a value.
_NO_VALUE = "#BDBDBD"
# Contacts that are further apart than this fraction of the drawn part of the chain do not stand for those between them.
_RESOLVED = 1 / 40
# Ratio of greatest and least value above which colours are logarithmic.
_WIDE = 300.0
# Shares of the values below and above which they are few.
_TAILS = 0.1, 0.9


def edges_of(centres: FloatArray, log: bool = False) -> FloatArray:
    """Return the edges of cells around ascending ``centres``: the midpoints on the drawn axis."""
    at = np.log(centres) if log else centres
    middles = (at[1:] + at[:-1]) / 2
    edges = np.concatenate(([2 * at[0] - middles[0]], middles, [2 * at[-1] - middles[-1]]))
    return np.exp(edges) if log else edges


def reach_of(contacts: FloatArray) -> float:
    """Return the largest distance of neighbours in ascending ``contacts`` between which values may be interpolated."""
    return max(1.0, _RESOLVED * float(contacts[-1] - contacts[0]))


def rows_of(contacts: FloatArray, values: FloatArray) -> Edges:
    """Return the edges of rows and their values, of shape (k, rows): NaN between contacts that are far apart."""
    halves = np.minimum(np.pad(np.diff(contacts), 1, constant_values=1.0), reach_of(contacts)) / 2
    edges = np.column_stack([contacts - halves[:-1], contacts + halves[1:]]).ravel()
    rows = np.full((len(values), len(edges) - 1), np.nan)
    rows[:, ::2] = values
    kept = np.diff(edges) > 0
    return np.append(edges[:-1][kept], edges[-1]), rows[:, kept]


def colour_cells(ax: Axes, edges: Edges, values: FloatArray, **colours: Any) -> Any:
    """Draw a map of ``values``, of shape (x, y); cells without a value are grey."""
    ax.set_facecolor(_NO_VALUE)
    masked = np.ma.masked_invalid(values).T
    drawn = ax.pcolormesh(*edges, masked, rasterized=True, shading="flat", **colours)
    ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
    ax.grid(False)
    ax.spines[:].set_visible(True)
    return drawn


def colours_of(values: FloatArray) -> dict[str, Any]:
    """Return colour map and norm for these values, which are finite."""
    from matplotlib.colors import AsinhNorm, LogNorm, Normalize, TwoSlopeNorm

    least, most = (values.min(), values.max()) if values.size else (0.0, 1.0)
    if least < 0 < most:
        limit = max(-least, most)
        usual = np.median(np.abs(values)) / 10
        return {"norm": AsinhNorm(usual or limit, vmin=-limit, vmax=limit), "cmap": SIGNED}
    norm: Any = (LogNorm if 0 < _WIDE * least < most else Normalize)(least, most)
    few, many = np.quantile(values, _TAILS).tolist() if values.size else (least, most)
    # where most values are in one half of the range, they have half of the colours
    crowd = few if 2 * few > least + most else many if 2 * many < least + most else least
    if type(norm) is Normalize and least < crowd < most:
        norm = TwoSlopeNorm(crowd, least, most)
    return {"norm": norm, "cmap": field_colours()}


def regime_borders(ax: Axes, edges: Edges, regimes: npt.NDArray[np.str_]) -> None:
    """Draw the borders between cells of different regimes, and label the regimes; an empty name is no regime."""
    x, y = edges
    across = np.nonzero(regimes[1:] != regimes[:-1])
    up = np.nonzero(regimes[:, 1:] != regimes[:, :-1])
    # with an outline, to be visible on all colours
    for colour, width in ((paper(), 2.6), (ink(), 1.2)):
        i, j = across
        ax.vlines(x[i + 1], y[j], y[j + 1], color=colour, linewidth=width)
        i, j = up
        ax.hlines(y[j + 1], x[i], x[i + 1], color=colour, linewidth=width)
    for name in sorted(set(regimes.ravel().tolist()) - {""}):
        cells = np.argwhere(regimes == name)
        off = cells - cells.mean(axis=0)
        i, j = cells[np.argmin((off**2).sum(axis=1))]
        look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": SMALL, "path_effects": halo(), "zorder": 5}
        ax.text((x[i] + x[i + 1]) / 2, (y[j] + y[j + 1]) / 2, name, **look)
