"""Shock response spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import METHODS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.simulation.shock_spectrum import ShockSpectrum

_LABELS = {
    "acceleration": ("greatest acceleration", "m/s\N{SUPERSCRIPT TWO}"),
    "pseudo_velocity": ("pseudo-velocity", "m/s"),
}


def shock_spectrum(
    result: ShockSpectrum,
    quantity: Literal["acceleration", "pseudo_velocity"] = "acceleration",
    *,
    ax: Axes | None = None,
) -> Axes:
    """Draw a shock response spectrum; in grey that of the shock without the chain.

    Parameters
    ----------
    result : ShockSpectrum
        The spectrum; frequency in Hz.
    quantity : "acceleration" or "pseudo_velocity"
        Absolute acceleration [m/s^2] or pseudo-velocity [m/s].
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.
    """
    with canvas(ax, result, x=("natural frequency", "Hz"), y=_LABELS[quantity]) as ax:
        alone = getattr(result, f"input_{quantity}")
        if alone is not None:
            ax.plot(result.frequencies, alone, color=METHODS["shock"], linestyle="--", label="shock alone")
        ax.plot(result.frequencies, getattr(result, quantity), color=METHODS["simulation"], label=result.base)
        ax.set(xscale="log", yscale="log", xlim=(result.frequencies[0], result.frequencies[-1]))
        return ax
