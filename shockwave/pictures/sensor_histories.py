"""Histories of sensors, with their first pulses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shockwave.base.errors import InvalidValueError, text_of
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import series
from shockwave.simulation.recording import Recording
from shockwave.simulation.simulation_result import Simulation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Names of the axes.
_NAMES = {"N": "force", "m": "displacement", "m/s": "velocity", "m/s^2": "acceleration"}


def sensors(result: Simulation | Recording, unit: str | None = None, *, ax: Axes | None = None) -> Axes:
    """Draw the histories of sensors against time, with a line for each sensor.

    Parameters
    ----------
    result : Simulation or Recording
        Result with ``sensors``.
    unit : str, optional
        Unit of the sensors to draw, such as ``N``; default: that of the first sensor.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    InvalidValueError
        If there are no sensors with this unit.
    """
    histories = result if isinstance(result, Recording) else result.recording
    units = units_of(histories)
    if not units:
        raise InvalidValueError.of("sensors", "must be requested (got none; simulate with sensors=['wall'])")
    if unit not in (None, *units):
        raise InvalidValueError.of("unit", f"must be {', '.join(units)} (got {text_of(unit)})")
    unit = unit or units[0]
    with canvas(ax, result, x="time", y=(_NAMES[unit], unit)) as ax:
        for index, each in enumerate(each for each in histories.sensors if each.unit == unit):
            label = each.name.replace("_", " ")
            ax.plot(histories.times, each.values, linewidth=1.1, label=label, **series(index))
        ax.set_xlim(0, histories.times[-1])
        return ax


def units_of(histories: Recording | None) -> list[str]:
    """Return the units of the sensors."""
    return list(dict.fromkeys(each.unit for each in histories.sensors)) if histories else []
