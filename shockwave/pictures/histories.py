"""Histories of sensors with their first pulses, records with their keys, and shock response spectra."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from shockwave.base.errors import InvalidValueError, text_of
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import (
    GREEN,
    GREY,
    METHODS,
    SKY,
    Axes,
    busy_end,
    draw_limit,
    ink,
    literal,
    series,
    si_label,
    thin,
)
from shockwave.pictures.waves import contact_forces, peak_forces, sources, train
from shockwave.profiles.tabulated import Tabulated
from shockwave.simulation.recording import Recording
from shockwave.simulation.simulation_result import Simulation

if TYPE_CHECKING:
    from shockwave.simulation.shock_spectrum import ShockSpectrum
    from shockwave.studies.record_keys import RecordKeys

# Names of the axes.
_NAMES = {"N": "force", "m": "displacement", "m/s": "velocity", "m/s^2": "acceleration"}


def sensors(result: Simulation | Recording, unit: str | None = None, *, ax: Axes | None = None) -> Axes:
    """Draw the histories of sensors against time, with the widths of the first pulses at half of their peaks.

    The speeds in the legend are mean speeds of the wave from the preceding sensor of the same kind in the list. A limit
    is drawn with the forces.

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
        shown = [each for each in histories.sensors if each.unit == unit]
        for index, each in enumerate(shown):
            label, pulse = each.name.replace("_", " "), pulses.get(each.name)
            if pulse is not None and pulse.peak and pulse.arrival is not None and pulse.width is not None:
                label += f", width {si_label(pulse.width, 's', pulse.digits_of('width', 3))}"
                label += f", {si_label(pulse.speed, 'm/s', pulse.digits_of('speed', 3))}" if pulse.speed else ""
                half = float(each.values[0]) + pulse.peak / 2  # the history begins with the static force
                ax.hlines(half, pulse.arrival, pulse.arrival + pulse.width, color=ink(), linewidth=0.8, zorder=3)
            ax.plot(histories.times, each.values, label=label, **series(index))
        limit = result.limit if unit == "N" and isinstance(result, Simulation) else None
        drawn = any(each.name.endswith("spring_force") for each in histories.sensors)
        draw_limit(ax, limit if limit is None or limit.at != "spring" or drawn else None)
        ax.set_xlim(0, busy_end(histories.times, np.column_stack([each.values for each in shown])))
        return ax


def units_of(histories: Recording | None) -> list[str]:
    """Return the units of the sensors."""
    return list(dict.fromkeys(each.unit for each in histories.sensors)) if histories else []


# ---------------------------------------------------------------- the picture of a scene


def draw_scene(result: Any, *, ax: Axes | None) -> Axes:
    """Draw the histories of sensors or contacts, or the greatest forces along a chain, or those of the waves."""
    simulated, _ = sources(result)
    if simulated is not None and (simulated.options.sensors or "forces" in simulated.options.record):
        return draw_histories(simulated, ax=ax)
    if simulated is not None and simulated.contacts:
        return peak_forces(simulated, ax=ax)
    return train(result, ax=ax)


def draw_histories(result: Any, *, ax: Axes | None) -> Axes:
    """Draw the histories of sensors or, without them, contact forces."""
    return (sensors if getattr(result, "options", result).sensors else contact_forces)(result, ax=ax)


# ---------------------------------------------------------------- records


def record_keys(result: RecordKeys, *, ax: Axes | None = None) -> Axes:
    """Draw a record, the windows of baseline and crop, and the pulse from its start to its end, with its peak.

    Parameters
    ----------
    result : RecordKeys
        Keys with which the record is a pulse; time in s, force in N.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    InvalidValueError
        If the record is refused with these keys.
    """
    if result.pulse is None:
        raise InvalidValueError.of("result", "must have keys that are not refused (got none; see its problem)")
    profile, record = Tabulated.from_file(result.file, **result.parameters), result.record
    x, y = f"time {result.time_condition}".rstrip(), f"force {result.force_condition}".rstrip()
    with canvas(ax, result, x=(literal(x), "s"), y=(literal(y), "N")) as ax:
        for window, colour, label in ((profile.baseline, GREEN, "baseline"), (profile.crop, SKY, "crop")):
            if window is not None:
                ax.axvspan(*window, color=colour, alpha=0.25, linewidth=0, label=label)
        shown = thin(record.forces)
        ax.plot(record.times[shown], record.forces[shown], color=GREY, label="record")
        first, last = profile.crop or (-np.inf, np.inf)
        inside = np.where((record.times >= first) & (record.times <= last), record.forces, -np.inf)
        peak = float(record.times[inside.argmax()])
        knots, values = profile.corners
        times, forces = peak + (knots - 1) * profile.recorded_rise_time, values * profile.recorded_peak_force
        ax.plot(times, forces, color=METHODS["simulation"], label="pulse")
        ax.plot([peak], [profile.recorded_peak_force], "o", color=METHODS["simulation"])
        return ax


# ---------------------------------------------------------------- spectra


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
