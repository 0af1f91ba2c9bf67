"""Chains beyond equal spheres: peak force along the chain, space-time diagram with borders, force on the wall."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from shockwave.base.errors import InvalidValueError
from shockwave.pictures.colour_maps import reach_of
from shockwave.pictures.figure_files import SMALL, picture
from shockwave.pictures.picture_elements import BLUE, GREY, VERMILION, add_legend, finish, halo, label_axis
from shockwave.pictures.waves import field_of_forces, recorded
from shockwave.simulation.simulation_result import Simulation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Most borders of a picture; of a chain with more, such as a repeated cell, none is drawn.
_MOST_BORDERS = 12


@picture
def peak_forces(ax: Axes, result: Simulation) -> Axes:
    """Draw the greatest force at the reported contacts along the chain, with the borders of materials.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    result : Simulation
        Result of a simulation; force in N. A static force is a dotted line, the force on a wall a square. Contacts that
        are far apart are not connected.

    Raises
    ------
    InvalidValueError
        If the chain is endless.
    """
    if not result.contacts:
        raise InvalidValueError.of("chain.granules", "must be given (got an endless chain, which has no last contact)")
    contacts = np.array([peak.contact for peak in result.contacts])
    forces = np.array([peak.peak_force for peak in result.contacts])
    joined = np.diff(contacts).max(initial=1) <= reach_of(contacts)  # no line through contacts without a value
    marker = "o" if len(contacts) <= 100 or not joined else ""
    form = marker + ("-" if joined else "")
    ax.plot(contacts, forces, form, color=BLUE, linewidth=1.1, markersize=2.5, label="greatest force")
    static = np.array([peak.static_force for peak in result.contacts])
    if static.any():
        ax.plot(contacts, static, ":" if joined else "_", color=GREY, linewidth=1.0, label="static force")
    if result.transmitted is not None:
        wall = result.transmitted
        ax.plot([wall.contact], [wall.peak_force], "s", color=VERMILION, markersize=4.5, label="wall")
    _borders(ax, result, vertical=True)
    last = max(contacts[-1], (getattr(result, "contact_count", None) or 0) - 1)
    ax.set(xlim=(-0.5, last + 0.5), ylim=(0, 1.08 * float(forces.max()) or 1.0))
    ax.locator_params(axis="x", integer=True)
    return finish(ax, ("contact", ""), ("greatest force", "N"))


@picture
def chain_map(ax: Axes, result: Simulation) -> Axes:
    """Draw a space-time diagram: contact force over contacts and time, with the borders of materials.

    Parameters
    ----------
    ax : Axes
        Axes to draw on; a colour bar is added beside it.
    result : Simulation
        Result with ``forces`` recorded at many contacts; time in s, force in N. Contacts without a force are grey.

    Raises
    ------
    InvalidValueError
        If no forces were recorded.
    """
    field_of_forces(ax, recorded(result, "forces"))
    _borders(ax, result, vertical=False)
    return finish(ax, ("time", "s"), ("contact", ""), legend=False)


@picture
def wall_force(ax: Axes, result: Simulation) -> Axes:
    """Draw the force on the wall against time and, on a second axis, its impulse.

    Parameters
    ----------
    ax : Axes
        Axes to draw on; an axis of the impulse is added at the right.
    result : Simulation
        Result of a chain with a wall, with ``forces`` recorded; force in N, impulse in N s.

    Raises
    ------
    InvalidValueError
        If no forces were recorded, or the end of the chain is free.
    """
    kept = recorded(result, "forces")
    if kept.wall_force is None or result.transmitted is None:
        raise InvalidValueError.of("chain.end", "must be a wall (got a free end)")
    times, forces = np.asarray(kept.times), np.asarray(kept.wall_force)
    excess = forces - result.transmitted.static_force
    impulse = np.append(0.0, np.cumsum(np.diff(times) * (excess[1:] + excess[:-1]) / 2))
    ax.plot(times, forces, color=BLUE, linewidth=1.1, label="force")
    ax.set(xlim=(0, times[-1]), ylim=(0, 1.08 * max(float(forces.max()), result.transmitted.peak_force) or 1.0))
    right = ax.twinx()
    right.plot(times, impulse, color=VERMILION, linewidth=1.1, linestyle="--", label="impulse")
    right.grid(False)
    right.tick_params(labelsize=SMALL)
    right.spines["right"].set_visible(True)
    low, high = min(0.0, float(impulse.min())), max(float(impulse.max()), result.transmitted.impulse)
    right.set_ylim(1.08 * low, 1.08 * high if high > low else 1.0)
    label_axis(right, "y", "impulse", "N s")
    right.yaxis.label.set_fontsize(ax.yaxis.label.get_fontsize())
    label_axis(ax, "x", "time", "s")
    label_axis(ax, "y", "force on the wall", "N")
    handles = [*ax.get_legend_handles_labels()[0], *right.get_legend_handles_labels()[0]]
    add_legend(ax, handles)
    return ax


def _borders(ax: Axes, result: Simulation, vertical: bool) -> None:
    """Lines at the contacts between granules of different materials."""
    if result.chain.count is None:
        return
    materials = result.scene.layout.materials
    borders = [contact for contact, (one, other) in enumerate(pairwise(materials)) if one != other]
    if len(borders) > _MOST_BORDERS:
        return
    look: dict[str, Any] = {"color": GREY, "linewidth": 0.8, "linestyle": "--"}
    for border in borders:
        if vertical:
            ax.axvline(border, zorder=0, **look)
        else:
            ax.axhline(border, path_effects=halo(), **look)
