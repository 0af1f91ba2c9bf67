"""Forces along a chain: contact forces, space-time diagram, peak forces of waves and of contacts, force on the wall."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from shockwave.base.errors import InvalidValueError
from shockwave.pictures.colour_maps import colour_cells, reach_of, rows_of
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import (
    GREEN,
    GREY,
    METHODS,
    Axes,
    add_legend,
    busy_end,
    colour_scale,
    draw_limit,
    field_colours,
    filled_and_open,
    halo,
    label_axis,
    series,
)
from shockwave.prediction.section4_outcome import Section4Outcome
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.recording import Recording
from shockwave.simulation.simulate import simulate_scene
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
# Upper limit of the force axis, relative to the greatest contact force.
_HIGHEST = 3.0
# Largest number of borders that are drawn; if a chain has more, as with a repeated cell, none is drawn.
_MOST_BORDERS = 12
# Points of a curve of Hertz's law, and tolerance of the forces with elastic contacts, finer than a line.
_CURVE = 200
_ELASTIC_RTOL = 1e-4
# Height at which a growing impulse ends, below a limit near the top of the axes.
_ENDS = 0.65


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
            ax.plot(histories.times, history, label=f"contact {contact}", **series(index))
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
    It begins where it is behind the fronts of stronger waves. Waves that had not separated have no front. In a finite
    chain, the borders of materials are drawn. The colours scale as the square root of the force, so that weak waves are
    visible.

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
    from matplotlib.colors import PowerNorm

    histories = find_histories(result, "forces")
    # fewer samples in time: the greatest force of each interval
    forces = np.asarray(histories.forces)
    times = histories.times[histories.times <= busy_end(histories.times, forces)]
    begins = np.arange(0, len(times), math.ceil(len(times) / _MOST_CELLS))
    forces = np.maximum.reduceat(forces[: len(times)], begins, axis=0)
    contacts = np.asarray(histories.contacts, dtype=float)
    edges, rows = rows_of(contacts, forces)
    norm = PowerNorm(0.5, vmin=0.0, vmax=float(forces.max()) or 1.0)
    with canvas(ax, result, x="time", y="contact", legend=False) as ax:
        drawn = colour_cells(ax, (np.append(times[begins], times[-1]), edges), rows, norm=norm, cmap=field_colours())
        ax.locator_params(axis="y", integer=True)
        colour_scale(ax, drawn, "contact force")
        look: dict[str, Any] = {"linestyle": "--", "linewidth": 0.8, "path_effects": halo()}
        for border in find_borders(result):
            ax.axhline(border, color=GREY, **look)
        fronts: list[tuple[float, float]] = []  # time at contact 0, time per contact
        for wave in result.waves:
            if wave.error_estimate is not None and wave.speed is not None:
                delay = result.chain.spacing / wave.speed
                start = wave.arrival_time - wave.contact * delay
                overtaken = [(before - start) / (delay - other) for before, other in fronts if other < delay]
                fronts.append((start, delay))
                front = np.array([max([contacts[0], *overtaken]), contacts[-1]])
                if front[0] < front[1]:
                    label = f"front {len(fronts)}"
                    ax.plot(start + front * delay, front, color=METHODS["simulation"], label=label, **look)
        return ax


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
            ax.axhline(shock.peak_force, color=METHODS["shock"], linestyle=":", label="shock")
        draw_limit(ax, getattr(result, "limit", None))
        if len(predicted):
            at = np.arange(1, len(predicted) + 1) - 0.12
            ax.plot(at, predicted, "o", color=METHODS["section 4"], label="section 4", clip_on=False, zorder=3)
        filled_and_open(ax, "s", places, forces, settled, "simulated", "simulated, not separated")
        ax.set_xlim(0.4, max(len(predicted), len(waves)) + 0.6)
        ax.locator_params(axis="x", integer=True, min_n_ticks=1)
        return ax


def sources(result: Any) -> tuple[Simulation | None, Section4Outcome | None]:
    """Return the simulation and the outcome of section 4 in a result; None where there is none."""
    if isinstance(result, Section4Outcome):
        return None, result
    return getattr(result, "simulated", result), getattr(getattr(result, "predicted", result), "section4", None)


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
    marks = ("o" if len(contacts) <= 100 or not joined else "") + ("-" if joined else "")
    static = np.array([peak.static_force for peak in result.contacts])
    with canvas(ax, result, x="contact", y="greatest force", from_zero=True) as ax:
        ax.plot(contacts, forces, marks, markersize=2.5, color=METHODS["simulation"], label="greatest force")
        if result.chain.is_plastic:
            elastic = {peak.contact: peak.peak_force for peak in _simulate_elastic(result).contacts}
            values = [elastic[contact] for contact in contacts.tolist()]
            ax.plot(contacts, values, "--" if joined else "_", color=METHODS["elastic"], label="elastic")
        if static.any():
            ax.plot(contacts, static, ":" if joined else "_", color=GREY, label="static force")
        if result.transmitted is not None:
            wall = result.transmitted
            ax.plot([wall.contact], [wall.peak_force], "s", color=METHODS["simulation"], label=result.chain.end_word)
        if result.structure is not None and result.structure.peak_spring_force:
            spring = result.structure.peak_spring_force
            ax.plot([result.transmitted.contact], [spring], "D", color=GREEN, label="spring behind it")
        draw_limit(ax, result.limit)
        for border in find_borders(result):
            ax.axvline(border, color=GREY, linewidth=0.8, linestyle="--", zorder=0)
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
        closed = overlaps > 0
        ax.plot(overlaps[closed], forces[closed], color=METHODS["simulation"], label="simulation")
        curve = np.linspace(0.0, (forces.max() / k) ** (1 / p), _CURVE)
        ax.plot(curve, k * curve**p, "--", color=METHODS["elastic"], label="elastic")
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
        ax.plot(times, forces, color=METHODS["simulation"], label="force")
        draw_limit(ax, result.limit if result.limit and result.limit.at != "spring" else None)
        ax.set_xlim(0, busy_end(times, forces[:, None]))
        right = ax.twinx()
        right.plot(times, impulse, color=GREEN, linestyle="--", label="impulse")
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
