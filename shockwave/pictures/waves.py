"""Waves along the chain: contact forces, space-time diagram, and peak forces of a train."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from shockwave.base.errors import InvalidValueError
from shockwave.pictures.colour_maps import colour_cells, rows_of
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import (
    METHODS,
    Axes,
    busy_end,
    colour_scale,
    draw_limit,
    field_colours,
    halo,
    series,
)
from shockwave.prediction.section4_outcome import Section4Outcome
from shockwave.simulation.recording import Recording
from shockwave.simulation.simulation_result import Simulation

if TYPE_CHECKING:
    from shockwave.prediction.outcome import Outcome
    from shockwave.studies.comparison import Comparison


# Part of a recording that shows whether histories of a kind were recorded.
_PARTS = {"forces": "forces", "field": "velocities", "energies": "kinetic_energy"}
# Most lines of contact forces.
_MOST_LINES = 6
# Most cells of a space-time diagram along the time, as many as a print resolves.
_MOST_CELLS = 480
# Markers on an axis are in front of it.
_WHOLE: dict[str, Any] = {"clip_on": False, "zorder": 3}
# Upper limit of the force axis, relative to the greatest contact force.
_HIGHEST = 3.0


def find_histories(result: Simulation | Recording, kind: str) -> Recording:
    """Return the histories of a result.

    Raises
    ------
    InvalidValueError
        If those of this kind were not recorded.
    """
    histories = result if isinstance(result, Recording) else result.recording
    kinds = [name for name, part in _PARTS.items() if getattr(histories, part, None) is not None]
    if kind not in kinds:
        got = ", ".join(kinds) or "nothing"
        raise InvalidValueError.of("record", f"must have {kind} (got {got}; simulate with record=[{kind!r}])")
    return histories


def contact_forces(
    result: Simulation | Recording, contacts: Iterable[int] | None = None, *, ax: Axes | None = None
) -> Axes:
    """Draw the contact force against time, with a line for each contact, and the shock, if there is one, in grey.

    Parameters
    ----------
    result : Simulation or Recording
        Result with ``forces`` recorded; time in s, force in N. A recording alone has no shock.
    contacts : iterable of int, optional
        Recorded contacts to draw; default: all, or six at equal distances if there are more.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    InvalidValueError
        If the forces at a contact were not recorded.
    """
    histories, shock = find_histories(result, "forces"), getattr(result, "shock", None)
    forces = np.asarray(histories.forces)
    if contacts is None:
        count = min(len(histories.contacts), _MOST_LINES)
        contacts = [histories.contacts[round(place)] for place in np.linspace(0, len(histories.contacts) - 1, count)]
    contacts = list(contacts)
    if missing := [contact for contact in contacts if contact not in histories.contacts]:
        names = ", ".join(map(str, histories.contacts))
        raise InvalidValueError.of("contacts", f"must be recorded contacts, {names} (got {missing[0]!r})")
    with canvas(ax, result, x="time", y="contact force") as ax:
        if shock is not None:
            times = np.union1d(histories.times, [shock.rise_time, shock.duration])
            times = times[times <= shock.duration]
            applied = shock.peak_force * shock.profile.force(times / shock.rise_time)
            ax.plot(times, applied, color=METHODS["shock"], linewidth=2.4, alpha=0.5, label="shock")
        for index, contact in enumerate(contacts):
            history = forces[:, histories.contacts.index(contact)]
            ax.plot(histories.times, history, linewidth=1.1, label=f"contact {contact}", **series(index))
        highest = float(forces.max())
        top = 1.12 * min(max(highest, 0.0 if shock is None else shock.peak_force), _HIGHEST * highest)
        if limit := getattr(result, "limit", None):
            draw_limit(ax, limit)
            top = max(top, 1.12 * limit.force)
        columns = [histories.contacts.index(contact) for contact in contacts]
        end = max(busy_end(histories.times, forces[:, columns]), shock.duration if shock else 0.0)
        ax.set(xlim=(0, end), ylim=(0, top or 1.0))
        return ax


def space_time(result: Simulation, *, ax: Axes | None = None) -> Axes:
    """Draw a space-time diagram: contact force over contacts and time, with the fronts of the measured waves.

    A front is the straight line with the speed of the steady wave through the contact and the time of its measurement.
    It begins where it is behind the fronts of stronger waves. Waves that had not separated have no front. The colours
    scale as the square root of the force, so that weak waves are visible.

    Parameters
    ----------
    result : Simulation
        Result with ``forces`` recorded at many contacts; time in s, force in N.
    ax : Axes, optional
        Axes to draw on, by default those of a new figure; a colour bar is added beside them.

    Raises
    ------
    InvalidValueError
        If no forces were recorded.
    """
    histories = find_histories(result, "forces")
    ends = np.asarray(histories.contacts, dtype=float)[[0, -1]]
    with canvas(ax, result, x="time", y="contact", legend=False) as ax:
        field_of_forces(ax, histories)
        settled = [wave for wave in result.waves if wave.error_estimate is not None]
        fronts: list[tuple[float, float]] = []  # time at contact 0, time per contact
        for number, wave in enumerate(settled, start=1):
            if wave.speed is not None:
                delay = result.chain.spacing / wave.speed
                start = wave.arrival_time - wave.contact * delay
                overtaken = [(before - start) / (delay - other) for before, other in fronts if other < delay]
                fronts.append((start, delay))
                drawn = np.array([max([ends[0], *overtaken]), ends[1]])
                if drawn[0] < drawn[1]:
                    look: dict[str, Any] = {"linewidth": 0.7, "linestyle": "--", "path_effects": halo()}
                    ax.plot(start + drawn * delay, drawn, color=METHODS["simulation"], label=f"front {number}", **look)
        return ax


def field_of_forces(ax: Axes, histories: Recording) -> None:
    """Draw contact forces as colours over time and contacts, with a colour bar; grey where none are recorded."""
    from matplotlib.colors import PowerNorm

    # fewer samples in time: the greatest force of each interval
    forces = np.asarray(histories.forces)
    times = histories.times[histories.times <= busy_end(histories.times, forces)]
    begins = np.arange(0, len(times), math.ceil(len(times) / _MOST_CELLS))
    forces = np.maximum.reduceat(forces[: len(times)], begins, axis=0)
    edges, rows = rows_of(np.asarray(histories.contacts, dtype=float), forces)
    norm = PowerNorm(0.5, vmin=0.0, vmax=float(forces.max()) or 1.0)
    drawn = colour_cells(ax, (np.append(times[begins], times[-1]), edges), rows, norm=norm, cmap=field_colours())
    ax.locator_params(axis="y", integer=True)
    colour_scale(ax, drawn, "contact force")


def train(result: Comparison | Outcome | Simulation | Section4Outcome, *, ax: Axes | None = None) -> Axes:
    """Draw the peak forces of the waves, simulated and by section 4, with that of the shock and a limit.

    Open squares are simulated waves that had not separated.

    Parameters
    ----------
    result : Comparison, Outcome, Simulation or Section4Outcome
        Result with waves, of a simulation or of section 4 or of both; force in N.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    InvalidValueError
        If it has no waves.
    """
    simulated, paper = sources(result)
    waves = () if simulated is None else simulated.waves
    forces = np.array([wave.peak_force for wave in waves])
    settled = np.array([wave.error_estimate is not None for wave in waves], dtype=bool)
    predicted = np.array([wave.peak_force for wave in paper.waves] if paper else [])
    if not len(forces) + len(predicted):
        raise InvalidValueError.of(
            "result", "must have waves (got none; pictures.peak_forces draws forces at contacts)"
        )
    places = np.arange(1, len(waves) + 1) + 0.12
    with canvas(ax, result, simulated, x="wave", y="peak force", from_zero=True) as ax:
        shock = getattr(result if simulated is None else simulated, "shock", None)
        if shock is not None:
            ax.axhline(shock.peak_force, color=METHODS["shock"], linewidth=1.0, linestyle=":", label="shock")
        draw_limit(ax, getattr(result, "limit", None))
        if len(predicted):
            at = np.arange(1, len(predicted) + 1) - 0.12
            ax.plot(at, predicted, "o", color=METHODS["section 4"], markersize=5, label="section 4", **_WHOLE)
        for which, face, label in (
            (settled, METHODS["simulation"], "simulated"),
            (~settled, "none", "simulated, not separated"),
        ):
            if which.any():
                look: dict[str, Any] = {"color": METHODS["simulation"], "markerfacecolor": face, "markersize": 4.5}
                ax.plot(places[which], forces[which], "s", label=label, **look, **_WHOLE)
        ax.set_xlim(0.4, max(len(predicted), len(waves)) + 0.6)
        ax.locator_params(axis="x", integer=True, min_n_ticks=1)
        return ax


def sources(result: Any) -> tuple[Simulation | None, Section4Outcome | None]:
    """Return the simulation and the outcome of section 4 in a result; None where there is none."""
    if isinstance(result, Section4Outcome):
        return None, result
    return getattr(result, "simulated", result), getattr(getattr(result, "predicted", result), "section4", None)
