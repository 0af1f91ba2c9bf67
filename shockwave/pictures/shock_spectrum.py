"""Shock response spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import METHODS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.simulation.shock_spectrum import ShockSpectrum


def shock_spectrum(result: ShockSpectrum, *, ax: Axes | None = None) -> Axes:
    """Draw the greatest absolute accelerations of a shock response spectrum; in grey without the chain.

    Parameters
    ----------
    result : ShockSpectrum
        The spectrum; frequency in Hz, acceleration in m/s^2.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.
    """
    with canvas(ax, result, x=("natural frequency", "Hz"), y=("greatest acceleration", "m/s^2")) as ax:
        if result.input_acceleration is not None:
            ax.plot(result.frequencies, result.input_acceleration, "--", color=METHODS["shock"], label="shock alone")
        ax.plot(result.frequencies, result.acceleration, color=METHODS["simulation"], label=result.base)
        ax.set(xscale="log", yscale="log", xlim=(result.frequencies[0], result.frequencies[-1]))
        return ax
