"""Sensors at contacts, in granules, on a wall and at a movable end, and their places in a chain."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

from shockwave.base.errors import Fault
from shockwave.scene.chain import Chain

#: Quantities of a granule that a sensor measures, with their SI units.
UNITS = {"force": "N", "velocity": "m/s", "displacement": "m"}
QUANTITIES = tuple(UNITS)
#: Sensors at the end of a chain: the force on the wall, and the motion of a movable end.
WALL, STRUCTURE = "wall", "structure"
# Greatest number of a granule: far beyond any chain that can be simulated.
_MOST = 10**12


class Sensor(NamedTuple):
    """A sensor.

    Attributes
    ----------
    place : str
        ``contact``, ``granule``, ``wall`` or ``structure``.
    number : int
        Number of the contact or of the granule.
    quantity : str
        One of `QUANTITIES`; the force in a granule is the mean of its two contact forces.
    """

    place: str
    number: int = 0
    quantity: str = "force"

    @property
    def name(self) -> str:
        """Name of its column, such as ``granule_10`` or ``granule_3_velocity``."""
        number = f"_{self.number}" if self.place in ("contact", "granule") else ""
        return self.place + number + ("" if self.quantity == "force" else f"_{self.quantity}")

    @property
    def unit(self) -> str:
        """SI unit of what it measures; of a movable end, of the spring force."""
        return UNITS[self.quantity]

    @property
    def contacts(self) -> tuple[int, ...]:
        """Contacts with numbers whose forces it measures."""
        if self.quantity != "force" or self.place in (WALL, STRUCTURE):
            return ()
        return (self.number,) if self.place == "contact" else (self.number - 1, self.number)


def sensor_of(value: Any) -> Sensor | None:
    """Sensor from text or a mapping, as a scenario states it; None if it has another form."""
    if isinstance(value, Sensor) or not isinstance(value, Mapping):
        return value if isinstance(value, Sensor) else Sensor(value) if value in (WALL, STRUCTURE) else None
    quantity = value.get("quantity", "force")
    with suppress(TypeError):  # a number that is none
        for place, known in (("contact", QUANTITIES[:1]), ("granule", QUANTITIES)):
            if value.keys() <= {place, "quantity"} and quantity in known:
                number = operator.index(value.get(place, -1))
                return Sensor(place, number, quantity) if 0 <= number <= _MOST else None
    return None


def sensor_faults(sensors: Iterable[Sensor], chain: Chain, struck: bool) -> Iterator[Fault]:
    """Errors of sensors where the chain, which is ``struck`` by a sphere or not, has no such place."""
    end = chain.end
    granules = None if chain.count is None else chain.count + struck
    contacts = None if granules is None else granules - (end is None)
    for index, (place, number, quantity) in enumerate(sensors):
        where: tuple[str | int, ...] = ("sensors", index)
        if place in (WALL, STRUCTURE):
            if end is None:
                yield Fault(where, f"must be a place in the chain (got {place} at a free end; state chain.end)")
            elif place == STRUCTURE and end.mass is None:
                yield Fault(where, "must be a place in the chain (got structure at a fixed wall; state its mass)")
            continue
        first, last = 0, contacts if place == "contact" else granules
        if place == "granule" and quantity == "force":
            first, last = 1, contacts  # it has a contact on either side
        if number < first or (last is not None and number >= last):
            most = f"at least {first}" if last is None else f"{first} to {last - 1} in this chain"
            hint = "" if number or not first else "; on its only contact, {contact: 0}"
            yield Fault((*where, place), f"must be {most} (got {number}{hint})")
