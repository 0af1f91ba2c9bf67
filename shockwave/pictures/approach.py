"""How the peak force of the primary approaches its limit along the chain."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from typing import TYPE_CHECKING

from shockwave.errors import NumericalError
from shockwave.pictures.axes import finish
from shockwave.pictures.style import BLUE, GREY, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.measurement.result import SimulationResult


_CONTACTS = 30
# The picture goes as far below the error of the limit.
_DEEP = 30.0


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
    last, floor = result.primary.contact, result.error_estimate
    if contacts is None:
        contacts = range(0, last + 1, -(-(last + 1) // _CONTACTS))
    distances: dict[int, float] = {}
    for contact in contacts:
        with contextlib.suppress(NumericalError):
            passage = result.passage(contact)
            if contact != last and not passage.exact:
                distances[contact] = passage.peak_force / result.peak_force - 1
    for sign, marker, colour, name in ((-1, "o", BLUE, "below"), (1, "^", VERMILION, "above")):
        own = {contact: sign * distance for contact, distance in distances.items() if sign * distance > 0}
        if own:
            ax.plot(list(own), list(own.values()), marker, color=colour, markersize=4, label=f"{name} the limit")
    sizes = [floor, *(abs(distance) for distance in distances.values() if distance)]
    bottom = max(min(sizes) / 5, floor / _DEEP)
    ax.set(yscale="log", ylim=(bottom, 4 * max(sizes)), xlim=(-0.5, last + 1.5))
    ax.axhspan(bottom, floor, color=GREY, alpha=0.2, linewidth=0, label="error of the limit")
    ax.axvline(last, color=GREY, linewidth=1.0, linestyle=":", label="where it was read")
    return finish(ax, "contact", "relative distance to the limit")
