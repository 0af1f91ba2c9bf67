"""Chains beyond equal spheres: peak force along the chain, space-time diagram with borders, force on the wall."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from shockwave.base.errors import InvalidValueError
from shockwave.pictures.colour_maps import reach_of
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import (
    GREEN,
    GREY,
    METHODS,
    Axes,
    add_legend,
    busy_end,
    draw_limit,
    halo,
    label_axis,
)
from shockwave.pictures.waves import field_of_forces, find_histories
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.simulate import simulate_scene
from shockwave.simulation.simulation_result import Simulation

# Most borders of a picture; of a chain with more, such as a repeated cell, none is drawn.
_MOST_BORDERS = 12
# Points of a curve of Hertz's law, and tolerance of the forces with elastic contacts, finer than a line.
_CURVE = 200
_ELASTIC_RTOL = 1e-4
# Height at which a growing impulse ends, below a limit near the top of the axes.
_ENDS = 0.65


def peak_forces(result: Simulation, *, ax: Axes | None = None) -> Axes:
    """Draw the greatest force at the reported contacts along the chain, with the borders of materials.

    Parameters
    ----------
    result : Simulation
        Result of a simulation; force in N. A static force is a dotted line, the force on a wall a square. Contacts that
        are far apart are not connected. A limit is that of the transmitted force. Of a chain with elastic-plastic
        contacts, the forces with elastic ones are shown, too, which are simulated here.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

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
    look: dict[str, Any] = {"color": METHODS["simulation"], "linewidth": 1.1}
    static = np.array([peak.static_force for peak in result.contacts])
    with canvas(ax, result, x="contact", y="greatest force", from_zero=True) as ax:
        ax.plot(contacts, forces, marker + ("-" if joined else ""), markersize=2.5, label="greatest force", **look)
        if result.chain.is_plastic:
            elastic = {peak.contact: peak.peak_force for peak in _simulate_elastic(result).contacts}
            values = [elastic[contact] for contact in contacts.tolist()]
            ax.plot(contacts, values, "--" if joined else "_", color=METHODS["elastic"], linewidth=1.1, label="elastic")
        if static.any():
            ax.plot(contacts, static, ":" if joined else "_", color=GREY, linewidth=1.0, label="static force")
        if result.transmitted is not None:
            wall = result.transmitted
            ax.plot([wall.contact], [wall.peak_force], "s", markersize=4.5, label=result.chain.end_word, **look)
        if result.structure is not None and result.structure.peak_spring_force:
            spring = result.structure.peak_spring_force
            ax.plot([result.transmitted.contact], [spring], "D", markersize=4, color=GREEN, label="spring behind it")
        draw_limit(ax, result.limit)
        _borders(ax, result, vertical=True)
        ax.set_xlim(-0.5, (result.scene.contact_count or len(contacts)) - 0.5)
        ax.locator_params(axis="x", integer=True)
        return ax


def force_overlap(result: Simulation, contact: int, *, ax: Axes | None = None) -> Axes:
    """Draw the force at a contact against its overlap, with Hertz's law.

    Parameters
    ----------
    result : Simulation
        Result of a finite chain with ``forces`` and ``field`` recorded; overlap in m, force in N.
    contact : int
        The contact; its force must be recorded.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    InvalidValueError
        If the forces or the displacements were not recorded, or the contact is none of those recorded.
    """
    histories = find_histories(find_histories(result, "forces"), "field")
    if result.chain.count is None or contact not in histories.contacts:
        got = f"got {contact}; recorded are {', '.join(map(str, histories.contacts)) or 'none'}"
        raise InvalidValueError.of("contact", f"must be a recorded contact of a finite chain ({got})")
    layout, x = result.scene.layout, np.asarray(histories.displacements)
    behind = x[:, contact + 1] if contact + 1 < x.shape[1] else 0.0
    overlaps = layout.overlaps[contact] + x[:, contact] - behind
    forces = np.asarray(histories.forces)[:, histories.contacts.index(contact)]
    k, p = layout.pairs.stiffnesses[contact], layout.pairs.exponents[contact]
    with canvas(ax, result, x="overlap", y="contact force", from_zero=True) as ax:
        look: dict[str, Any] = {"color": METHODS["simulation"], "linewidth": 1.1, "label": "simulation"}
        ax.plot(overlaps[overlaps > 0], forces[overlaps > 0], **look)
        curve = np.linspace(0.0, (forces.max() / k) ** (1 / p), _CURVE)
        ax.plot(curve, k * curve**p, "--", color=METHODS["elastic"], linewidth=1.1, label="elastic")
        return ax


def chain_map(result: Simulation, *, ax: Axes | None = None) -> Axes:
    """Draw a space-time diagram: contact force over contacts and time, with the borders of materials.

    The colours scale as the square root of the force, so that weak waves are visible.

    Parameters
    ----------
    result : Simulation
        Result with ``forces`` recorded at many contacts; time in s, force in N. Contacts without a force are grey.
    ax : Axes, optional
        Axes to draw on, by default those of a new figure; a colour bar is added beside them.

    Raises
    ------
    InvalidValueError
        If no forces were recorded.
    """
    histories = find_histories(result, "forces")
    with canvas(ax, result, x="time", y="contact", legend=False) as ax:
        field_of_forces(ax, histories)
        _borders(ax, result, vertical=False)
        return ax


def wall_force(result: Simulation, *, ax: Axes | None = None) -> Axes:
    """Draw the force on the wall against time and, on a second axis, its impulse.

    Parameters
    ----------
    result : Simulation
        Result of a chain with a wall, with ``forces`` recorded; force in N, impulse in N s. A limit of the force of
        the spring behind it is not drawn.
    ax : Axes, optional
        Axes to draw on, by default those of a new figure; an axis of the impulse is added at the right.

    Raises
    ------
    InvalidValueError
        If no forces were recorded, or the end of the chain is free.
    """
    histories = find_histories(result, "forces")
    if histories.wall_force is None or result.transmitted is None:
        raise InvalidValueError.of("chain.end", "must be a wall (got a free end)")
    times, forces = np.asarray(histories.times), np.asarray(histories.wall_force)
    excess = forces - result.transmitted.static_force
    impulse = np.append(0.0, np.cumsum(np.diff(times) * (excess[1:] + excess[:-1]) / 2))
    low, high = min(0.0, float(impulse.min())), max(float(impulse.max()), result.transmitted.impulse)
    force = f"force on the {result.chain.end_word}", "N"
    with canvas(ax, result, x="time", y=force, from_zero=True, legend=False) as ax:
        ax.plot(times, forces, color=METHODS["simulation"], linewidth=1.1, label="force")
        draw_limit(ax, result.limit if result.limit and result.limit.at != "spring" else None)
        ax.set_xlim(0, busy_end(times, forces[:, None]))
        right = ax.twinx()
        right.plot(times, impulse, color=GREEN, linewidth=1.1, linestyle="--", label="impulse")
        right.grid(False)
        right.spines["right"].set_visible(True)
        top = max(1.12 * high, result.transmitted.impulse / _ENDS)
        right.set_ylim(1.12 * low, top if high > low else 1.0)
        static = " beyond the static force" if result.transmitted.static_force else ""
        label_axis(right, "y", (f"impulse{static}", "N s"))
        right.yaxis.label.set_fontsize(ax.yaxis.label.get_fontsize())
        add_legend(ax, [*ax.get_legend_handles_labels()[0], *right.get_legend_handles_labels()[0]])
        return ax


def _simulate_elastic(result: Simulation) -> Simulation:
    """Result of the same scene with elastic contacts."""
    from shockwave.scene.layout import elastic_chain

    scene = Scene(excitation=result.scene.excitation, chain=elastic_chain(result.chain))
    options = result.options
    return simulate_scene(scene, SimulateOptions(rtol=_ELASTIC_RTOL, until=options.until, contacts=options.contacts))


def find_borders(result: Simulation) -> list[int]:
    """Contacts between granules of different materials; none if they are too many to be drawn."""
    if result.chain.count is None:
        return []
    materials = result.scene.layout.materials
    borders = [contact for contact, (one, other) in enumerate(pairwise(materials)) if one != other]
    return borders if len(borders) <= _MOST_BORDERS else []


def _borders(ax: Axes, result: Simulation, vertical: bool) -> None:
    """Lines at the contacts between granules of different materials."""
    look: dict[str, Any] = {"color": GREY, "linewidth": 0.8, "linestyle": "--"}
    for border in find_borders(result):
        if vertical:
            ax.axvline(border, zorder=0, **look)
        else:
            ax.axhline(border, path_effects=halo(), **look)
