"""A record with the keys that are proposed for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shockwave.base.errors import InvalidValueError
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import GREEN, GREY, METHODS, SKY, literal, thin
from shockwave.profiles.tabulated import Tabulated

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.studies.record_keys import RecordKeys


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
        ax.plot(record.times[shown], record.forces[shown], color=GREY, linewidth=0.9, label="record")
        first, last = profile.crop or (-np.inf, np.inf)
        inside = np.where((record.times >= first) & (record.times <= last), record.forces, -np.inf)
        peak = float(record.times[inside.argmax()])
        knots, values = profile.corners
        times, forces = peak + (knots - 1) * profile.recorded_rise_time, values * profile.recorded_peak_force
        ax.plot(times, forces, color=METHODS["simulation"], linewidth=1.3, label="pulse")
        ax.plot([peak], [profile.recorded_peak_force], "o", color=METHODS["simulation"], markersize=4)
        return ax
