"""Waves along the chain: contact forces, their map over contacts and time, and the peak forces of a train."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from shockwave.errors import InvalidValueError
from shockwave.pictures.axes import decades, dress, finish, halo, label_axis, named, scale, thinned
from shockwave.pictures.cells import edges_of
from shockwave.pictures.style import BLACK, BLUE, COLOURS, FIELD, GREY, LINES, VERMILION, thousandths

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.measurement.recording import Recording
    from shockwave.measurement.result import SimulationResult
    from shockwave.prediction.outcome import Outcome
    from shockwave.quadrature import FloatArray


# More lines than this are not distinguished.
_MOST_LINES = 6
# Tiles of a map along either side; more than a print resolves.
_MOST_TILES = 480
# Numbers in a map stand so far apart, as a share of it.
_APART = 0.07
# So many waves have a tick each.
_TICKED = 12
# Peak forces that differ by more are drawn on a logarithmic axis; a shock so much above the forces that it makes does
# not set the height of their picture.
_WIDE = 20.0


class Comparison(Protocol):
    """The drawn part of a `shockwave.Comparison`."""

    @property
    def predicted(self) -> Outcome: ...

    @property
    def simulated(self) -> SimulationResult: ...


def recorded(result: SimulationResult, *kinds: str) -> Recording:
    """The histories of a result, one of ``kinds`` at least among them.

    Raises
    ------
    InvalidValueError
        When none of them was kept.
    """
    kept = result.recording
    if kept is None or not set(kinds) & set(result.options.record):
        asked = ", ".join(result.options.record) or "nothing"
        contacts = ", contacts=[...]" if kinds[0] == "forces" else ""
        remedy = f"simulate with record=[{kinds[0]!r}]{contacts}"
        raise InvalidValueError.of("record", f"must have {' or '.join(kinds)} (got {asked}; {remedy})")
    return kept


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
    forces, shock, end = np.asarray(kept.forces), result.shock, float(kept.times[-1])
    if contacts is None:
        places = np.linspace(0, len(kept.contacts) - 1, min(len(kept.contacts), _MOST_LINES))
        contacts = [kept.contacts[place] for place in places.round().astype(int)]
    inside = np.union1d(kept.times, [shock.rise_time, shock.duration])
    inside = inside[inside <= shock.duration]
    highest = float(forces.max())
    far = shock.peak_force > _WIDE * highest > 0
    label = f"shock, up to {thousandths(shock.peak_force, 'N')}" if far else "shock"
    applied = shock.peak_force * shock.profile.force(inside / shock.rise_time)
    ax.plot(*thinned(inside, applied), color=GREY, linewidth=2.4, alpha=0.5, label=label)
    for index, contact in enumerate(contacts):
        if contact not in kept.contacts:
            known = ", ".join(map(str, kept.contacts[:12])) + (", ..." if len(kept.contacts) > 12 else "")
            raise InvalidValueError.of("contacts", f"must be among those recorded, {known} (got {contact!r})")
        look = {"color": COLOURS[index % len(COLOURS)], "linestyle": LINES[index % len(LINES)], "linewidth": 1.1}
        ax.plot(*thinned(kept.times, forces[:, kept.contacts.index(contact)]), label=f"contact {contact}", **look)
    top = 1.08 * (highest if far else max(highest, shock.peak_force))
    ax.set(xlim=(0, end), ylim=(0, top))
    return finish(ax, ("time", "s", end), ("contact force", "N", top))


# ---------------------------------------------------------------- map


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
        With ``forces`` recorded at many contacts, or the ``field``; time in s, force in N.

    Raises
    ------
    InvalidValueError
        When neither was recorded.
    """
    from matplotlib.colors import PowerNorm

    kept = recorded(result, "forces", "field")
    contacts, forces = _field(kept, result)
    times, tiles = _tiles(kept.times, forces)
    stride = -(-len(contacts) // _MOST_TILES)
    contacts, tiles = contacts[::stride], tiles[:, ::stride]
    norm = PowerNorm(0.5, vmin=0.0, vmax=float(tiles.max()) or 1.0)
    edges = edges_of(times), edges_of(contacts)
    drawn = ax.pcolormesh(*edges, tiles.T, norm=norm, cmap=FIELD, rasterized=True, shading="flat")
    scale(ax, drawn, "contact force", "N")
    ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
    _fronts(ax, result, float(edges[0][-1]), contacts)
    label_axis(ax, "x", "time", "s", float(times[-1]))
    label_axis(ax, "y", "contact")
    return dress(ax, grid=False)


def _field(kept: Recording, result: SimulationResult) -> tuple[FloatArray, FloatArray]:
    """Numbers of contacts, and forces of shape (samples, contacts) [N]."""
    if kept.forces is not None and (len(kept.contacts) > 1 or kept.displacements is None):
        return np.asarray(kept.contacts, dtype=float), kept.forces
    moved = np.asarray(kept.displacements)
    if moved.shape[1] != result.chain.granules:
        # the granule ahead of the last that has moved is at rest
        moved = np.hstack((moved, np.zeros((len(moved), 1))))
    overlap = np.maximum(moved[:, :-1] - moved[:, 1:], 0.0)
    return np.arange(overlap.shape[1], dtype=float), result.chain.contact_stiffness * overlap * np.sqrt(overlap)


def _tiles(times: FloatArray, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fewer samples in time: the greatest force of each stretch."""
    stride = -(-len(times) // _MOST_TILES)
    begins = np.arange(0, len(times), stride)
    ends = np.minimum(begins + stride, len(times)) - 1
    return (times[begins] + times[ends]) / 2, np.maximum.reduceat(forces, begins, axis=0)


def _fronts(ax: Axes, result: SimulationResult, end: float, contacts: FloatArray) -> None:
    """Dashed lines of the settled waves, with their numbers where they leave the picture, as far as there is room."""
    ends = np.array([contacts[0], contacts[-1]])
    numbered: list[FloatArray] = []
    settled = [wave for wave in result.waves if wave.error_estimate is not None]
    for number, wave in enumerate(settled, start=1):
        if wave.speed is None:
            continue
        times = wave.arrival_time + (ends - wave.contact) * 2 * result.chain.radius / wave.speed
        ax.plot(times, ends, color=BLUE, linewidth=0.7, linestyle="--", path_effects=halo(), label=f"front {number}")
        leaving = min(float(times[1]), end)
        place = np.array([leaving, np.interp(leaving, times, ends)]) / (end, ends[1] or 1.0)
        if min(place) > 0 and all(np.abs(place - other).max() > _APART for other in numbered):
            numbered.append(place)
            named(ax, float(place[0]), float(place[1]), str(number), ha="right", va="top", xycoords="axes fraction")


# ---------------------------------------------------------------- train


def train(ax: Axes, comparison: Comparison) -> Axes:
    """Peak forces of the waves, predicted beside simulated, and that of the shock.

    The bar at the first wave is where the simulated peak is expected, by the errors measured for such shocks;
    there is none where no range is known. Open squares are simulated waves that had not settled.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    comparison : Comparison
        Of a prediction and a simulation; force in N.
    """
    predicted = {place - 0.12: wave.peak_force for place, wave in enumerate(comparison.predicted.waves, start=1)}
    waves = list(enumerate(comparison.simulated.waves, start=1))
    settled = {place + 0.12: wave.peak_force for place, wave in waves if wave.error_estimate is not None}
    others = {place + 0.12: wave.peak_force for place, wave in waves if wave.error_estimate is None}
    forces = [*predicted.values(), *settled.values(), *others.values()]
    shock = comparison.simulated.shock.peak_force
    top = max(*forces, shock)
    ax.axhline(shock, color=GREY, linewidth=1.0, linestyle=":", label="shock")
    _expected(ax, comparison.predicted, top)
    square: dict[str, Any] = {"linestyle": "none", "marker": "s", "markersize": 4.5, "color": VERMILION}
    ax.plot(list(predicted), list(predicted.values()), "o", color=BLUE, markersize=5, label="predicted")
    if settled:
        ax.plot(list(settled), list(settled.values()), label="simulated", **square)
    if others:
        label = "simulated, not settled"
        ax.plot(list(others), list(others.values()), label=label, markerfacecolor="none", **square)
    count = max(len(predicted), len(waves))
    ax.set(xlim=(0.4, count + 0.6), xticks=range(1, count + 1, math.ceil(count / _TICKED)))
    if max(forces) > _WIDE * min(forces):
        ax.set_ylim(min(forces) / 1.4, 1.4 * top)
        decades(ax, "y")
    else:
        ax.set_ylim(0, 1.12 * top)
    return finish(ax, "wave", ("peak force", "N", top))


def _expected(ax: Axes, predicted: Outcome, top: float) -> None:
    """The range of the true peak force, f/(1 + high) to f/(1 + low); an arrow where it has no upper end."""
    if predicted.expected_error is None:
        return
    low, high = predicted.expected_error
    least = predicted.peak_force / (1 + high)
    greatest = predicted.peak_force / (1 + low) if low > -1 else math.inf
    reach = min(greatest, 1.06 * top)
    ax.plot([1, 1], [least, reach], color=BLACK, linewidth=0.9, label="expected", marker="none")
    ax.plot([1], [least], marker="_", color=BLACK, markersize=7)
    ax.plot([1], [reach], marker="_" if reach == greatest else "^", color=BLACK, markersize=5)
