"""What runs along the chain: contact forces, their map over contacts and time, and the waves of a train."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from shockwave.errors import InvalidValueError
from shockwave.pictures.style import (
    BLACK,
    BLUE,
    COLOURS,
    FIELD,
    GREY,
    LABEL,
    LINES,
    SMALL,
    VERMILION,
    decades,
    dress,
    key,
    measure,
    ratio,
    scale,
    thinned,
    thousandths,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.measurement.recording import Recording
    from shockwave.measurement.result import SimulationResult
    from shockwave.quadrature import FloatArray
    from shockwave.studies.comparison import Comparison

__all__ = ["contact_forces", "recorded", "space_time", "train"]

# More lines than this are not told apart.
_MOST_LINES = 6
# Tiles of a map along either side; more than a print resolves.
_MOST_TILES = 480
# How far apart numbers in a map stand, as a share of it, and how many waves have a tick each.
_APART, _TICKED = 0.07, 12
# Peak forces that differ by more are drawn on a logarithmic axis; a shock so much above the forces that it makes does
# not set the height of their picture.
_WIDE = 20.0


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
        listed = " or ".join(kinds)
        contacts = ", contacts=[...]" if kinds[0] == "forces" else ""
        problem = f"must have {listed} (got {asked}; simulate with record=[{kinds[0]!r}]{contacts})"
        raise InvalidValueError.of("record", problem)
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
    assert kept.forces is not None
    wanted = tuple(contacts) if contacts is not None else _some(kept.contacts)
    for contact in wanted:
        if contact not in kept.contacts:
            had = ", ".join(map(str, kept.contacts[:12])) + (", ..." if len(kept.contacts) > 12 else "")
            raise InvalidValueError.of("contacts", f"must be among those recorded, {had} (got {contact!r})")
    shock, times = result.shock, kept.times
    inside = np.union1d(times[times <= shock.duration], np.multiply(shock.rise_time, [0.0, 1.0]))
    inside = np.append(inside, shock.duration) if shock.duration < times[-1] else inside
    applied = shock.peak_force * shock.profile.force(inside / shock.rise_time)
    highest = float(kept.forces.max())
    far = shock.peak_force > _WIDE * highest > 0
    label = f"shock, up to {thousandths(shock.peak_force, 'N')}" if far else "shock"
    ax.plot(*thinned(inside, applied), color=GREY, linewidth=2.4, alpha=0.5, label=label)
    for index, contact in enumerate(wanted):
        force = kept.forces[:, kept.contacts.index(contact)]
        line, colour = LINES[index % len(LINES)], COLOURS[index % len(COLOURS)]
        ax.plot(*thinned(times, force), color=colour, linestyle=line, linewidth=1.1, label=f"contact {contact}")
    ax.set_xlim(0, float(times[-1]))
    ax.set_ylim(0, 1.08 * (highest if far else max(highest, shock.peak_force)))
    measure(ax, "x", float(times[-1]), "s", "time")
    measure(ax, "y", ax.get_ylim()[1], "N", "contact force")
    key(ax)
    return dress(ax)


def _some(contacts: tuple[int, ...]) -> tuple[int, ...]:
    if len(contacts) <= _MOST_LINES:
        return contacts
    places = np.linspace(0, len(contacts) - 1, _MOST_LINES).round().astype(int)
    return tuple(contacts[place] for place in places)


# ---------------------------------------------------------------- map


def space_time(ax: Axes, result: SimulationResult) -> Axes:
    """Contact force over contacts and time, with the fronts of the measured waves.

    A front is the straight line of the wave's speed through the contact and the time at which it was read: the wave
    joins it as it takes its final form. Waves that had not settled have none. The colours go with the square root of
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
    drawn = ax.pcolormesh(
        _edges(times), _edges(contacts), tiles.T, norm=norm, cmap=FIELD, rasterized=True, shading="flat"
    )
    bar = scale(ax, drawn)
    measure(bar.ax, "y", float(tiles.max()), "N", "contact force")
    bar.ax.yaxis.label.set_fontsize(LABEL)
    limits = ax.get_xlim(), ax.get_ylim()
    _fronts(ax, result, limits[0][1], contacts)
    ax.set_xlim(*limits[0])
    ax.set_ylim(*limits[1])
    measure(ax, "x", float(times[-1]), "s", "time")
    ratio(ax, "y", "contact")
    return dress(ax, grid=False)


def _field(kept: Recording, result: SimulationResult) -> tuple[FloatArray, FloatArray]:
    """Numbers of contacts, and forces of shape (samples, contacts) [N]."""
    if kept.forces is not None and (len(kept.contacts) > 1 or kept.displacements is None):
        return np.asarray(kept.contacts, dtype=float), kept.forces
    assert kept.displacements is not None
    moved = kept.displacements
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


def _edges(centres: FloatArray) -> FloatArray:
    if len(centres) == 1:
        half = 0.5 if centres[0] == 0 else abs(centres[0]) / 2
        return np.array([centres[0] - half, centres[0] + half])
    middles = (centres[1:] + centres[:-1]) / 2
    return np.concatenate(([2 * centres[0] - middles[0]], middles, [2 * centres[-1] - middles[-1]]))


def _fronts(ax: Axes, result: SimulationResult, end: float, contacts: FloatArray) -> None:
    from matplotlib.patheffects import withStroke

    spacing = 2 * result.chain.radius
    ends = np.array([contacts[0], contacts[-1]])
    halo = [withStroke(linewidth=1.8, foreground="white")]
    numbered: list[FloatArray] = []
    settled = [wave for wave in result.waves if wave.error_estimate is not None]
    for number, wave in enumerate(settled, start=1):
        if wave.speed is None:
            continue
        times = wave.arrival_time + (ends - wave.contact) * spacing / wave.speed
        ax.plot(times, ends, color=BLUE, linewidth=0.7, linestyle="--", path_effects=halo, label=f"front {number}")
        # the number stands where the front leaves the picture
        leaving = min(float(times[1]), end)
        at = np.array([leaving, np.interp(leaving, times, ends)])
        place = at / (end, ends[1])
        if leaving > 0 and at[1] > ends[0] and all(np.abs(place - other).max() > _APART for other in numbered):
            numbered.append(place)
            ax.annotate(
                str(number),
                (at[0], at[1]),
                (-9, -4),
                textcoords="offset points",
                ha="right",
                va="top",
                fontsize=SMALL,
                path_effects=halo,
            )


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
    predicted = [wave.peak_force for wave in comparison.predicted.waves]
    waves = comparison.simulated.waves
    simulated = [wave.peak_force for wave in waves]
    settled = [wave.error_estimate is not None for wave in waves]
    every = [*predicted, *simulated]
    shock = comparison.simulated.shock.peak_force
    wide = max(every) > _WIDE * min(every)
    ax.axhline(shock, color=GREY, linewidth=1.0, linestyle=":", label="shock")
    _expected(ax, comparison, max(*every, shock))
    own = np.arange(1, len(predicted) + 1) - 0.12
    ax.plot(own, predicted, "o", color=BLUE, markersize=5, label="predicted")
    places = np.arange(1, len(simulated) + 1) + 0.12
    for sure, label in ((True, "simulated"), (False, "simulated, not settled")):
        x = [place for place, known in zip(places, settled, strict=True) if known is sure]
        y = [force for force, known in zip(simulated, settled, strict=True) if known is sure]
        if x:
            fill = VERMILION if sure else "none"
            ax.plot(x, y, "s", color=VERMILION, markerfacecolor=fill, markersize=4.5, linestyle="none", label=label)
    count = max(len(predicted), len(simulated))
    ax.set_xlim(0.4, count + 0.6)
    step = max(1, math.ceil(count / _TICKED))
    ax.set_xticks(range(1, count + 1, step))
    if wide:
        ax.set_ylim(min(every) / 1.4, 1.4 * max(*every, shock))
        decades(ax, "y")
    else:
        ax.set_ylim(0, 1.12 * max(*every, shock))
    measure(ax, "y", max(*every, shock), "N", "peak force")
    ratio(ax, "x", "wave")
    key(ax)
    return dress(ax)


def _expected(ax: Axes, comparison: Comparison, top: float) -> None:
    """The range of the true peak force, f/(1 + high) to f/(1 + low); an arrow where it has no upper end."""
    bounds, force = comparison.predicted.expected_error, comparison.predicted.peak_force
    if bounds is None:
        return
    low, high = force / (1 + bounds[1]), force / (1 + bounds[0]) if bounds[0] > -1 else math.inf
    reach = min(high, 1.06 * top)
    ax.plot([1, 1], [low, reach], color=BLACK, linewidth=0.9, label="expected", marker="none")
    ax.plot([1], [low], marker="_", color=BLACK, markersize=7)
    ax.plot([1], [reach], marker="_" if reach == high else "^", color=BLACK, markersize=7 if reach == high else 4)
