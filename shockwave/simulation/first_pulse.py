"""The first pulse at a contact or a sensor."""

from __future__ import annotations

from attrs import frozen


@frozen(kw_only=True)
class FirstPulse:
    """First pulse of a force or of the motion of a granule, and its greatest value.

    Attributes
    ----------
    sensor, unit : str
        Name of the sensor or the contact, and its SI unit.
    position : float
        Distance from the struck end of the chain at rest [m].
    peak, time : float or None
        Greatest value of the pulse, less the static force, and when it is first reached [s].
    arrival : float or None
        Last upward crossing of half of the peak before it [s].
    width : float or None
        Time from the arrival to the next fall to half of the peak [s].
    impulse : float or None
        Integral of a force from the beginning to the first minimum after the end or to zero [N s].
    merged : bool or None
        Whether there is a minimum before the end, as of a pulse and its reflection near a wall.
    greatest : float
        Greatest value within the simulated time, with the static force.
    speed : float or None
        Mean speed of the wave from the sensor before in the list to this one, by arrivals [m/s].
    error_estimate : float or None
        Largest of the relative errors of these figures, estimated.
    """

    sensor: str
    unit: str
    position: float
    peak: float | None = None
    time: float | None = None
    arrival: float | None = None
    width: float | None = None
    impulse: float | None = None
    merged: bool | None = None
    greatest: float
    speed: float | None = None
    error_estimate: float | None = None

    @property
    def units(self) -> dict[str, str]:
        """Units of the figures."""
        times, own = dict.fromkeys(("time", "arrival", "width"), "s"), {"greatest": self.unit, "impulse": "N s"}
        return {"peak": self.unit, **times, **own, "speed": "m/s", "position": "m"}

    def speed_from(self, other: FirstPulse) -> float | None:
        """Mean speed of the wave from another sensor to this one, by arrivals [m/s]; None where one has no pulse."""
        if self.arrival is None or other.arrival is None or self.arrival == other.arrival:
            return None
        return (self.position - other.position) / (self.arrival - other.arrival) or None
