"""Where section 4 can be trusted: its error over the plane of duration and duration ratio."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from shockwave.errors import InvalidValueError
from shockwave.pictures.plane import edges_of, inmost
from shockwave.pictures.style import BLACK, LABEL, SIGNED, SMALL, decades, dress, ratio, scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.quadrature import FloatArray

__all__ = ["trust_map"]

# Bounds of the colours; errors have no upper bound, and none is below -1.
_BOUNDS = (-1.0, -0.5, -0.2, -0.1, -0.05, -0.02, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
# A regime that takes fewer cells than this share has no name in the picture.
_ROOM = 0.03


def trust_map(
    ax: Axes,
    x: npt.ArrayLike,
    n: npt.ArrayLike,
    error: npt.ArrayLike,
    regime: npt.ArrayLike,
    holds: npt.ArrayLike | None = None,
) -> Axes:
    """Error of the predicted peak force over the plane (n t0/T0, n), with the borders of the regimes.

    Parameters
    ----------
    ax : Axes
        Where to draw; a scale of colours is put beside it.
    x : array, shape (p,)
        n t0/T0, ascending, above 0.
    n : array, shape (q,)
        Duration ratios, ascending, above 1.
    error : array, shape (p, q)
        Relative error, prediction over simulation less one; not a number where there is none, which is left grey.
    regime : array of str, shape (p, q)
        Of the prediction; an empty one is none.
    holds : array of bool, shape (p, q), optional
        Whether the conditions (3) are met; where not, it is hatched.

    Raises
    ------
    InvalidValueError
        When shapes do not fit, or there are not two values or more along each axis.
    """
    across, up = np.asarray(x, dtype=float), np.asarray(n, dtype=float)
    errors, names = np.asarray(error, dtype=float), np.asarray(regime, dtype=str)
    met = np.ones(errors.shape, dtype=bool) if holds is None else np.asarray(holds, dtype=bool)
    for name, array in (("error", errors), ("regime", names), ("holds", met)):
        if array.shape != (len(across), len(up)) or min(array.shape) < 2:
            rule = f"must have the shape (x, n) = ({len(across)}, {len(up)}), two at least along both"
            raise InvalidValueError.of(name, f"{rule} (got {array.shape})")
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm

    colours = colormaps[SIGNED]
    norm = BoundaryNorm(_BOUNDS, colours.N, extend="max")
    ax.set_facecolor("#BDBDBD")
    ax.set_xscale("log")
    ax.set_yscale("log")
    edges = edges_of(across, log=True), edges_of(up, log=True)
    drawn = ax.pcolormesh(
        *edges, np.ma.masked_invalid(errors).T, norm=norm, cmap=colours, rasterized=True, shading="flat"
    )
    _borders(ax, across, up, names)
    if not met.all():
        hatched = ax.contourf(across, up, (~met).T.astype(float), levels=[0.5, 1.5], colors="none", hatches=["////"])
        hatched.set_edgecolor("#404040")
        hatched.set_linewidth(0.0)
    _percent(ax, drawn)
    ax.set_xlim(edges[0][0], edges[0][-1])
    ax.set_ylim(edges[1][0], edges[1][-1])
    decades(ax, "x")
    decades(ax, "y")
    ratio(ax, "x", "duration over natural time, $n t_0/T_0$")
    ratio(ax, "y", "duration over rise time, $n$")
    return dress(ax, grid=False)


def _percent(ax: Axes, drawn: Any) -> None:
    bar = scale(ax, drawn, spacing="uniform", ticks=_BOUNDS)
    bar.ax.set_yticklabels([f"{100 * bound:+.0f}".replace("-", "\N{MINUS SIGN}") for bound in _BOUNDS])
    bar.set_label("error (%)", fontsize=LABEL)


def _borders(ax: Axes, across: FloatArray, up: FloatArray, names: npt.NDArray[np.str_]) -> None:
    from matplotlib.patheffects import withStroke

    for name in sorted(set(names.ravel()) - {""}):
        own = names == name
        if not own.all():
            ax.contour(across, up, own.T.astype(float), levels=[0.5], colors=[BLACK], linewidths=1.0)
        if own.mean() < _ROOM:
            continue
        i, j = inmost(own)
        halo = [withStroke(linewidth=2.0, foreground="white")]
        ax.text(across[i], up[j], name, ha="center", va="center", fontsize=SMALL, path_effects=halo)
