"""Materials ranked by a target property, or by the quantity that a design minimises."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from shockwave.pictures.drawing import BLUE, GREY, VERMILION, add_legend, label_axis, literal
from shockwave.pictures.figures import figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Height of the axes with their labels and legend, and of each row [in].
_LEAST_HEIGHT = 1.0
_ROW_HEIGHT = 0.17
# Width of axes with the names of materials [in].
_WIDTH = 4.6


def materials(ax: Axes, design: Any) -> Axes:
    """Draw a ranking of materials, the best one at the top, with bars for the errors.

    A row is a material and the required quantity that it gives; or a combination of materials and the minimised
    quantity of its best option.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    design : shockwave.Design
        Design in which a material varies, or a whole number.
    """
    target = design.requirements[0]
    quantity = next((each for each in design.quantities if each.name == design.least), target.quantity)
    if design.least is None:
        ax.axvline(target.value, color=GREY, linewidth=0.9, linestyle="--", label=f"target {target.sign}")
    rows = [
        (
            ", ".join(str(value) for value in option.values if isinstance(value, str) or design.least is None),
            option.quantities[quantity.name],
            option.errors[quantity.name],
            option.violation <= 0 if design.least else option in design.solutions,
        )
        for option in design.table
    ]
    labels, values, errors, met = (np.array(column) for column in zip(*rows, strict=True))
    places = np.arange(len(rows))
    ax.errorbar(values, places, xerr=errors * values, fmt="none", ecolor=GREY, elinewidth=0.9, capsize=2)
    for which, face, colour, label in ((met, BLUE, BLUE, "meets all"), (~met, "white", VERMILION, "does not")):
        ax.plot(values[which], places[which], "o", color=colour, markerfacecolor=face, markersize=4, label=label)
    ax.set_yticks(places, [literal(label) for label in labels.tolist()])
    ax.set_ylim(len(rows) - 0.5, -0.5)
    label_axis(ax, "x", quantity.label, quantity.printed_unit)
    add_legend(ax, ax.get_legend_handles_labels()[0])
    return ax


def ranked_figure(count: int, columns: int = 1) -> tuple[Figure, tuple[Axes, ...]]:
    """Make a figure for a ranking of ``count`` rows, with ``columns`` axes side by side; see `figure`."""
    return figure(1, columns, (columns * _WIDTH, max(2 * _LEAST_HEIGHT, _LEAST_HEIGHT + _ROW_HEIGHT * count)))
