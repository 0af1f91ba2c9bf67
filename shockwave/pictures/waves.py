"""Waves along the chain: contact forces, their map over contacts and time, and the peak forces of a train."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from shockwave.errors import InvalidValueError
from shockwave.measurement.result import Recording, SimulationResult
from shockwave.pictures.drawing import (
    BLACK,
    BLUE,
    COLOURS,
    FIELD,
    GREY,
    LINES,
    VERMILION,
    colour_scale,
    finish,
    halo,
    label_axis,
)
from shockwave.pictures.maps import colour_cells, edges_of
from shockwave.prediction.outcome import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# More lines than this are not distinguished.
_MOST_LINES = 6
# Tiles of a map in time; more than a print resolves.
_MOST_TILES = 480
# A shock is drawn up to so many times the greatest contact force.
_HIGHEST = 3.0


def recorded(result: SimulationResult, kind: str) -> Recording:
    """The histories of a result.

    Raises
    ------
    InvalidValueError
        When those of this kind were not kept.
    """
    if result.recording is None or kind not in result.options.record:
        asked = ", ".join(result.options.record) or "nothing"
        raise InvalidValueError.of("record", f"must have {kind} (got {asked}; simulate with record=[{kind!r}])")
    return result.recording


def contact_forces(ax: Axes, result: SimulationResult, contacts: Iterable[int] | None = None) -> Axes:
    """Contact force against time, a line for each contact, with the force on the first granule in grey.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    result : SimulationResult
        With ``forces`` recorded; time in s, force in N.
    contacts : iterable of int, optional
        Of those recorded. Left out, all; of more than six, six from the first to the last.

    Raises
    ------
    InvalidValueError
        When no forces were recorded, or not those of a contact.
    """
    kept = recorded(result, "forces")
    forces = np.asarray(kept.forces)
    shock = result.shock
    highest = float(forces.max())
    if contacts is None:
        count = min(len(kept.contacts), _MOST_LINES)
        places = np.linspace(0, len(kept.contacts) - 1, count).round().astype(int)
        contacts = [kept.contacts[place] for place in places]
    inside = np.union1d(kept.times, [shock.rise_time, shock.duration])
    inside = inside[inside <= shock.duration]
    applied = shock.peak_force * shock.profile.force(inside / shock.rise_time)
    ax.plot(inside, applied, color=GREY, linewidth=2.4, alpha=0.5, label="shock")
    for index, contact in enumerate(contacts):
        if contact not in kept.contacts:
            known = ", ".join(map(str, kept.contacts))
            raise InvalidValueError.of("contacts", f"must be among those recorded, {known} (got {contact!r})")
        own = forces[:, kept.contacts.index(contact)]
        colour = COLOURS[index % len(COLOURS)]
        line = LINES[index % len(LINES)]
        ax.plot(kept.times, own, color=colour, linestyle=line, linewidth=1.1, label=f"contact {contact}")
    top = 1.08 * min(max(highest, shock.peak_force), _HIGHEST * highest)
    ax.set(xlim=(0, kept.times[-1]), ylim=(0, top))
    return finish(ax, ("time", "s"), ("contact force", "N"))


def space_time(ax: Axes, result: SimulationResult) -> Axes:
    """Contact force over contacts and time, with the fronts of the measured waves.

    A front is the straight line of the wave's speed through the contact and the time at which it was read: the wave
    joins it as it takes its final form. Waves that had not settled have none. The colours scale as the square root of
    the force, so that weak waves show.

    Parameters
    ----------
    ax : Axes
        Where to draw; a scale of colours is put beside it.
    result : SimulationResult
        With ``forces`` recorded at many contacts; time in s, force in N.

    Raises
    ------
    InvalidValueError
        When no forces were recorded.
    """
    from matplotlib.colors import PowerNorm

    kept = recorded(result, "forces")
    contacts = np.asarray(kept.contacts, dtype=float)
    # fewer samples in time: the greatest force of each stretch
    begins = np.arange(0, len(kept.times), math.ceil(len(kept.times) / _MOST_TILES))
    forces = np.maximum.reduceat(np.asarray(kept.forces), begins, axis=0)
    edges = np.append(kept.times[begins], kept.times[-1]), edges_of(contacts)
    norm = PowerNorm(0.5, vmin=0.0, vmax=float(forces.max()) or 1.0)
    drawn = colour_cells(ax, edges, forces, norm=norm, cmap=FIELD)
    colour_scale(ax, drawn, "contact force", "N")
    ends = contacts[[0, -1]]
    settled = [wave for wave in result.waves if wave.error_estimate is not None]
    for number, wave in enumerate(settled, start=1):
        if wave.speed is not None:
            front = wave.arrival_time + (ends - wave.contact) * 2 * result.chain.radius / wave.speed
            look: dict[str, Any] = {"color": BLUE, "linewidth": 0.7, "linestyle": "--", "path_effects": halo()}
            ax.plot(front, ends, label=f"front {number}", **look)
    label_axis(ax, "x", "time", "s")
    label_axis(ax, "y", "contact")
    return ax


def train(ax: Axes, comparison: Any) -> Axes:
    """Peak forces of the waves, predicted beside simulated, and that of the shock.

    The bar at the first wave is where the simulated peak is expected, by the errors measured for such shocks;
    there is none where no range is known. Open squares are simulated waves that had not settled.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    comparison : shockwave.Comparison
        Of a prediction and a simulation; force in N.
    """
    predicted = np.array([wave.peak_force for wave in comparison.predicted.waves])
    waves = comparison.simulated.waves
    simulated = np.array([wave.peak_force for wave in waves])
    settled = np.array([wave.error_estimate is not None for wave in waves])
    shock = comparison.simulated.shock.peak_force
    top = 1.12 * max(predicted.max(), simulated.max(), shock)
    ax.axhline(shock, color=GREY, linewidth=1.0, linestyle=":", label="shock")
    _expected(ax, comparison.predicted, top)
    places = np.arange(1, len(predicted) + 1) - 0.12
    ax.plot(places, predicted, "o", color=BLUE, markersize=5, label="predicted")
    places = np.arange(1, len(waves) + 1) + 0.12
    look: dict[str, Any] = {"color": VERMILION, "markersize": 4.5}
    ax.plot(places[settled], simulated[settled], "s", label="simulated", **look)
    if not settled.all():
        label = "simulated, not settled"
        ax.plot(places[~settled], simulated[~settled], "s", markerfacecolor="none", label=label, **look)
    last = max(len(predicted), len(waves))
    ax.set(xlim=(0.4, last + 0.6), ylim=(0, top))
    ax.locator_params(axis="x", integer=True)
    return finish(ax, ("wave", ""), ("peak force", "N"))


def _expected(ax: Axes, predicted: Outcome, top: float) -> None:
    """The range of the true peak force, f/(1 + high) to f/(1 + low), up to the top of the picture at most."""
    if predicted.expected_error is None:
        return
    low, high = predicted.expected_error
    least = predicted.peak_force / (1 + high)
    greatest = predicted.peak_force / (1 + low) if low > -1 else math.inf
    ax.plot([1, 1], [least, min(greatest, top)], color=BLACK, linewidth=0.9, marker="_", label="expected")
