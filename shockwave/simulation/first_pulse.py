"""The first pulse at a contact or a sensor."""

from __future__ import annotations

from attrs import field, frozen

from shockwave.base.text import significant_digits

# Most digits of a figure in texts and pictures.
_MOST_DIGITS = 4


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
        Mean speed of the wave from the preceding sensor of the same kind in the list [m/s]; see `speed_from`.
    error_estimate : float or None
        Largest of the relative errors of these figures, estimated.
    kind : str
        What is measured, the same at each place along the chain; empty at an end that reflects the wave.
    worst : str
        Name of the figure with this error.
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
    kind: str = field(default="", repr=False)
    worst: str = field(default="", repr=False)

    @property
    def units(self) -> dict[str, str]:
        """Units of the figures."""
        times, others = dict.fromkeys(("time", "arrival", "width"), "s"), {"greatest": self.unit, "impulse": "N s"}
        return {"peak": self.unit, **times, **others, "speed": "m/s", "position": "m"}

    def speed_from(self, other: FirstPulse) -> float | None:
        """Mean speed of the wave from another sensor to this one, by arrivals [m/s].

        None where a pulse is missing or merged with another, at an end that reflects the wave, between sensors of
        different kinds, and where the farther one is not reached later.
        """
        if self.arrival is None or other.arrival is None or self.merged or other.merged:
            return None
        distance, delay = self.position - other.position, self.arrival - other.arrival
        return distance / delay if self.kind and self.kind == other.kind and distance * delay > 0 else None

    def digits_of(self, name: str, most: int = _MOST_DIGITS) -> int:
        """Digits of a figure down to the first digit of its error, at most so many."""
        return min(most, significant_digits(getattr(self, name), 3 * (self.error_estimate or 0.0)))
