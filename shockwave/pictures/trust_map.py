"""The error of section 4 over the plane of duration and duration ratio."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from shockwave.pictures.axes import decades, dress, label_axis, scale
from shockwave.pictures.cells import NO_VALUE, check_shapes, edges_of, hatch, regions
from shockwave.pictures.style import MINUS, SIGNED

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Bounds of the colours; errors have no upper bound, and none is below -1.
_BOUNDS = (-1.0, -0.5, -0.2, -0.1, -0.05, -0.02, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)


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
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm

    across, up = np.asarray(x, dtype=float), np.asarray(n, dtype=float)
    errors, regimes = np.asarray(error, dtype=float), np.asarray(regime, dtype=str)
    met = np.ones(errors.shape, dtype=bool) if holds is None else np.asarray(holds, dtype=bool)
    check_shapes({"error": errors, "regime": regimes, "holds": met}, across, up)
    colours = colormaps[SIGNED]
    norm = BoundaryNorm(_BOUNDS, colours.N, extend="max")
    ax.set_facecolor(NO_VALUE)
    masked = np.ma.masked_invalid(errors)
    edges = edges_of(across, log=True), edges_of(up, log=True)
    drawn = ax.pcolormesh(*edges, masked.T, norm=norm, cmap=colours, rasterized=True, shading="flat")
    names = sorted(set(regimes.ravel()) - {""})
    regions(ax, across, up, {name: np.where(regimes == name, -0.5, 0.5) for name in names})
    hatch(ax, edges, ~met, "conditions (3) not met", "////")
    bar = scale(ax, drawn, "error (%)", spacing="uniform", ticks=_BOUNDS)
    bar.ax.set_yticklabels([f"{100 * bound:+.0f}".replace("-", MINUS) for bound in _BOUNDS])
    ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
    decades(ax, "x")
    decades(ax, "y")
    label_axis(ax, "x", "duration over characteristic time, $n t_0/T_0$")
    label_axis(ax, "y", "duration over rise time, $n$")
    return dress(ax, grid=False)
