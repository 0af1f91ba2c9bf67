"""Histories of sensors, with their first pulses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shockwave.base.errors import InvalidValueError, text_of
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import draw_limit, ink, series, si_label
from shockwave.simulation.recording import Recording
from shockwave.simulation.simulation_result import Simulation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Names of the axes.
_NAMES = {"N": "force", "m": "displacement", "m/s": "velocity", "m/s^2": "acceleration"}


def sensors(result: Simulation | Recording, unit: str | None = None, *, ax: Axes | None = None) -> Axes:
    """Draw the histories of sensors against time, with the widths of the first pulses at half of their peaks.

    The speeds in the legend are mean speeds of the wave from the sensor before in the list. A limit is drawn with the
    forces.

    Parameters
    ----------
    result : Simulation or Recording
        Result with ``sensors``; a recording alone has no first pulses.
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
    pulses = {} if isinstance(result, Recording) else {each.sensor: each for each in result.sensors}
    with canvas(ax, result, x="time", y=(_NAMES[unit], unit)) as ax:
        for index, each in enumerate(each for each in histories.sensors if each.unit == unit):
            label, pulse = each.name.replace("_", " "), pulses.get(each.name)
            if pulse is not None and pulse.peak and pulse.arrival is not None and pulse.width is not None:
                label += f", width {si_label(pulse.width, 's')}"
                label += f", {si_label(pulse.speed, 'm/s')}" if pulse.speed else ""
                half = float(each.values[0]) + pulse.peak / 2  # the history begins with the static force
                ax.hlines(half, pulse.arrival, pulse.arrival + pulse.width, color=ink(), linewidth=0.8, zorder=3)
            ax.plot(histories.times, each.values, linewidth=1.1, label=label, **series(index))
        draw_limit(ax, result.limit if unit == "N" and isinstance(result, Simulation) else None)
        ax.set_xlim(0, histories.times[-1])
        return ax


def units_of(histories: Recording | None) -> list[str]:
    """Return the units of the sensors."""
    return list(dict.fromkeys(each.unit for each in histories.sensors)) if histories else []
