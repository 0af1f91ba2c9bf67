"""Waves along the chain: contact forces, space-time diagram, and peak forces of a train."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from shockwave.base.errors import InvalidValueError
from shockwave.pictures.colour_maps import colour_cells, rows_of
from shockwave.pictures.figure_files import picture
from shockwave.pictures.picture_elements import BLUE, FIELD, GREY, VERMILION, colour_scale, finish, halo, style
from shockwave.scene.shock import Shock
from shockwave.simulation.recording import Recording
from shockwave.simulation.simulation_result import Simulation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.simulation.simulation_result import Simulation


# Most lines of contact forces.
_MOST_LINES = 6
# Most cells of a space-time diagram along the time, as many as a print resolves.
_MOST_CELLS = 480
# Upper limit of the force axis, relative to the greatest contact force.
_HIGHEST = 3.0


def recorded(result: Simulation, kind: str) -> Recording:
    """Return the histories of a result.

    Raises
    ------
    InvalidValueError
        If those of this kind were not recorded.
    """
    if result.recording is None or kind not in result.options.record:
        got = ", ".join(result.options.record) or "nothing"
        raise InvalidValueError.of("record", f"must have {kind} (got {got}; simulate with record=[{kind!r}])")
    return result.recording


def shock_of(result: Simulation) -> Shock | None:
    """Return the shock of a simulation; None if a striker hits the chain."""
    return result.scene.shock


@picture
def contact_forces(ax: Axes, result: Simulation, contacts: Iterable[int] | None = None) -> Axes:
    """Draw the contact force against time, with a line for each contact, and the shock, if there is one, in grey.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    result : Simulation
        Result with ``forces`` recorded; time in s, force in N.
    contacts : iterable of int, optional
        Recorded contacts to draw; default: all, or six at equal distances if there are more.

    Raises
    ------
    InvalidValueError
        If the forces at a contact were not recorded.
    """
    kept, shock = recorded(result, "forces"), shock_of(result)
    forces = np.asarray(kept.forces)
    if contacts is None:
        count = min(len(kept.contacts), _MOST_LINES)
        contacts = [kept.contacts[round(place)] for place in np.linspace(0, len(kept.contacts) - 1, count)]
    if shock is not None:
        inside = np.union1d(kept.times, [shock.rise_time, shock.duration])
        inside = inside[inside <= shock.duration]
        applied = shock.peak_force * shock.profile.force(inside / shock.rise_time)
        ax.plot(inside, applied, color=GREY, linewidth=2.4, alpha=0.5, label="shock")
    for index, contact in enumerate(contacts):
        if contact not in kept.contacts:
            known = ", ".join(map(str, kept.contacts))
            raise InvalidValueError.of("contacts", f"must be recorded contacts, {known} (got {contact!r})")
        own = forces[:, kept.contacts.index(contact)]
        ax.plot(kept.times, own, linewidth=1.1, label=f"contact {contact}", **style(index))
    highest = float(forces.max())
    top = 1.08 * min(max(highest, 0.0 if shock is None else shock.peak_force), _HIGHEST * highest)
    ax.set(xlim=(0, kept.times[-1]), ylim=(0, top or 1.0))
    return finish(ax, ("time", "s"), ("contact force", "N"))


@picture
def space_time(ax: Axes, result: Simulation) -> Axes:
    """Draw a space-time diagram: contact force over contacts and time, with the fronts of the measured waves.

    A front is the straight line with the speed of the steady wave through the contact and the time of its measurement.
    Waves that had not separated have no front. The colours scale as the square root of the force, so that weak
    waves are visible.

    Parameters
    ----------
    ax : Axes
        Axes to draw on; a colour bar is added beside it.
    result : Simulation
        Result with ``forces`` recorded at many contacts; time in s, force in N.

    Raises
    ------
    InvalidValueError
        If no forces were recorded.
    """
    kept = recorded(result, "forces")
    field_of_forces(ax, kept)
    ends = np.asarray(kept.contacts, dtype=float)[[0, -1]]
    settled = [wave for wave in result.waves if wave.error_estimate is not None]
    for number, wave in enumerate(settled, start=1):
        if wave.speed is not None:
            front = wave.arrival_time + (ends - wave.contact) * result.chain.spacing / wave.speed
            look: dict[str, Any] = {"color": BLUE, "linewidth": 0.7, "linestyle": "--", "path_effects": halo()}
            ax.plot(front, ends, label=f"front {number}", **look)
    return finish(ax, ("time", "s"), ("contact", ""), legend=False)


def field_of_forces(ax: Axes, kept: Recording) -> None:
    """Draw contact forces as colours over time and contacts, with a colour bar; grey where none are recorded."""
    from matplotlib.colors import PowerNorm

    # fewer samples in time: the greatest force of each interval
    begins = np.arange(0, len(kept.times), math.ceil(len(kept.times) / _MOST_CELLS))
    forces = np.maximum.reduceat(np.asarray(kept.forces), begins, axis=0)
    edges, rows = rows_of(np.asarray(kept.contacts, dtype=float), forces)
    norm = PowerNorm(0.5, vmin=0.0, vmax=float(forces.max()) or 1.0)
    drawn = colour_cells(ax, (np.append(kept.times[begins], kept.times[-1]), edges), rows, norm=norm, cmap=FIELD)
    ax.locator_params(axis="y", integer=True)
    colour_scale(ax, drawn, "contact force", "N")


@picture
def train(ax: Axes, comparison: Any) -> Axes:
    """Draw the predicted and the simulated peak forces of the waves, and the peak force of the shock.

    Open squares are simulated waves that had not separated.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    comparison : shockwave.Comparison
        Comparison of a prediction and a simulation; force in N.
    """
    predicted = np.array([wave.peak_force for wave in comparison.predicted.section4.waves])
    waves = comparison.simulated.waves
    simulated = np.array([wave.peak_force for wave in waves])
    settled = np.array([wave.error_estimate is not None for wave in waves])
    shock = comparison.simulated.shock.peak_force
    top = 1.12 * max(predicted.max(), simulated.max(), shock)
    ax.axhline(shock, color=GREY, linewidth=1.0, linestyle=":", label="shock")
    places = np.arange(1, len(predicted) + 1) - 0.12
    ax.plot(places, predicted, "o", color=BLUE, markersize=5, label="section 4")
    places = np.arange(1, len(waves) + 1) + 0.12
    look: dict[str, Any] = {"color": VERMILION, "markersize": 4.5}
    ax.plot(places[settled], simulated[settled], "s", label="simulated", **look)
    if not settled.all():
        label = "simulated, not separated"
        ax.plot(places[~settled], simulated[~settled], "s", markerfacecolor="none", label=label, **look)
    last = max(len(predicted), len(waves))
    ax.set(xlim=(0.4, last + 0.6), ylim=(0, top))
    ax.locator_params(axis="x", integer=True, min_n_ticks=1)
    return finish(ax, ("wave", ""), ("peak force", "N"))
