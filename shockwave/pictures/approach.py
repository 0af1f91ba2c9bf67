"""How the primary comes to its limit along the chain."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from shockwave.errors import NumericalError
from shockwave.pictures.style import BLUE, GREY, VERMILION, dress, key, ratio

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.measurement.result import SimulationResult

__all__ = ["approach"]

# How many contacts are looked at, and how far below the error of the limit the picture goes.
_CONTACTS, _DEEP = 30, 30.0


def approach(ax: Axes, result: SimulationResult, contacts: Iterable[int] | None = None) -> Axes:
    """How far the primary's peak force is from its limit, contact by contact.

    Below the error estimate of the limit, shaded, a distance says nothing. Contacts at which the front has no peak of
    its own, and those from which on it is the exact wave, are left out.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    result : SimulationResult
        Of any simulation; each contact is integrated up to once more.
    contacts : iterable of int, optional
        Where to look. Left out, thirty at most, up to where the primary was read.

    Raises
    ------
    InvalidValueError
        When the chain has no such contact.
    """
    last = result.primary.contact
    if contacts is None:
        contacts = range(0, last + 1, -(-(last + 1) // _CONTACTS))
    above: list[tuple[int, float]] = []
    below: list[tuple[int, float]] = []
    for contact in contacts:
        try:
            passage = result.passage(contact)
        except NumericalError:
            continue
        distance = passage.peak_force / result.peak_force - 1
        if distance and contact != last and not passage.exact:
            (above if distance > 0 else below).append((contact, abs(distance)))
    for points, marker, colour, name in ((below, "o", BLUE, "below"), (above, "^", VERMILION, "above")):
        if points:
            x, y = zip(*points, strict=True)
            ax.plot(x, y, marker, color=colour, markersize=4, label=f"{name} the limit")
    floor = result.error_estimate
    distances = [distance for _, distance in above + below]
    bottom, top = max(min([floor, *distances]) / 5, floor / _DEEP), max([floor, *distances]) * 4
    ax.set_yscale("log")
    ax.set_ylim(bottom, top)
    ax.set_xlim(-0.5, last + 1.5)
    ax.axhspan(bottom, floor, color=GREY, alpha=0.2, linewidth=0, label="error of the limit")
    ax.axvline(last, color=GREY, linewidth=1.0, linestyle=":", label="where it was read")
    ratio(ax, "x", "contact")
    ratio(ax, "y", "relative distance to the limit")
    key(ax)
    return dress(ax)
