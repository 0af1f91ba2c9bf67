"""Distribution of an uncertain force, with its quantiles and a limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shockwave.base.errors import UnknownNameError
from shockwave.base.text import percent
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import GREY, METHODS, draw_limit, ink
from shockwave.scene.force_limit import SPRING, WALL, WAVE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.studies.uncertainty_result import Uncertainty

# Quantity that a limit applies to, by the description of the transmitted force.
_LIMITED = {WAVE: "peak_force", WALL: "transmitted.peak_force", SPRING: "structure.peak_spring_force"}
# Ends of the shaded interval.
_FEW, _MANY = 0.05, 0.95


def distribution(result: Uncertainty, name: str | None = None, *, ax: Axes | None = None) -> Axes:
    """Draw the distribution of a quantity, with its nominal value, its quantiles, and the limit.

    The shaded interval contains 90 % of the scenes. The legend states the probability that the limit is reached.

    Parameters
    ----------
    result : Uncertainty
        Distribution of forces for uncertain parameters.
    name : str, optional
        Name of the quantity; default: the transmitted force if there is a limit, else the first quantity.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    UnknownNameError
        If there is no such quantity.
    """
    names = [each.name for each in result.quantities]
    limited = _LIMITED.get(result.verdict.force) if result.verdict else None
    name = name or (limited if limited in names else names[0])
    if name not in names:
        raise UnknownNameError.of("quantity", name, names)
    quantity = result.quantities[names.index(name)]
    values = np.sort(result.outputs[name])
    low, high = (quantity.quantiles[share].value for share in (_FEW, _MANY))
    with canvas(ax, result, x=(quantity.label, quantity.unit), y="scenes", from_zero=True) as ax:
        ax.hist(values, bins="auto", color=METHODS["simulation"], label=f"{result.draws} scenes")
        ax.axvspan(low, high, color=GREY, alpha=0.2, linewidth=0, zorder=0, label="90 % of them")
        ax.axvline(quantity.nominal, color=ink(), linewidth=0.9, linestyle=":", label="nominal")
        if name == limited and result.exceedance:
            reached = f"limit, reached with probability {percent(result.exceedance.probability)}"
            draw_limit(ax, result.exceedance.limit, reached, upright=True)
        return ax
