"""What a drawn figure shows."""

from typing import Any

from matplotlib.axes import Axes


def key_of(ax: Axes) -> list[str]:
    legend = ax.get_legend()
    return [text.get_text() for text in legend.get_texts()] if legend else []


def inside(figure: Any) -> bool:
    """Whether the first axes fit the figure, with a pixel of tolerance for the rounding of letters."""
    figure.draw_without_rendering()
    around = figure.axes[0].get_tightbbox()
    return min(around.x0, around.y0) > -1 and (around.max - figure.bbox.size).max() < 1
