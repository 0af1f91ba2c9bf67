"""A measured wave, and the passage of the leading wave at a contact."""

from __future__ import annotations

from attrs import evolve, frozen

from shockwave.scene.chain import Scales

# Attribute of a wave -> attribute of `Scales` that is its unit.
_UNITS = {
    "peak_force": "contact_force",
    "momentum": "momentum",
    "energy": "energy",
    "speed": "wave_speed",
    "width": "time",
    "granule_velocity": "velocity",
    "arrival_time": "time",
}


@frozen(kw_only=True)
class MeasuredWave:
    """A wave measured at a contact, in SI units (in scaled units until the result is complete).

    Attributes
    ----------
    peak_force, momentum, energy, width, granule_velocity : float
        As in `SolitaryWave`, measured from the history of the contact force. If only the leading wave was followed, its
        width and granule velocity are those of the exact wave of the same peak force.
    speed : float or None
        Speed of the peak along the chain [m/s]; None if only one contact was passed.
    contact : int
        Contact at which the wave was measured, counted from 0; contact i lies between granules i and i + 1.
    arrival_time : float
        Time of the peak at this contact [s].
    error_estimate : float or None
        Relative error estimate of ``peak_force`` as the limit far along the chain; None for a wave that had not
        settled, or that was found in only one of the two runs.
    foot : float
        Residual force between the wave and its neighbours, over its peak force; approximately the relative error of
        momentum, energy, width and granule velocity.
    """

    peak_force: float
    momentum: float
    energy: float
    speed: float | None
    width: float
    granule_velocity: float
    contact: int
    arrival_time: float
    error_estimate: float | None
    foot: float

    def in_si(self, scales: Scales, error_estimate: float | None) -> MeasuredWave:
        """Convert a wave in scaled units to SI units, with its error estimate."""
        known = {name: getattr(self, name) for name in _UNITS if getattr(self, name) is not None}
        values = {name: value * getattr(scales, _UNITS[name]) for name, value in known.items()}
        return evolve(self, error_estimate=error_estimate, **values)


@frozen(kw_only=True)
class Passage:
    """The leading wave at a contact, in SI units.

    Attributes
    ----------
    contact : int
        The contact, counted from 0.
    arrival_time : float
        Time of the peak [s].
    peak_force : float
        Peak contact force [N].
    exact : bool
        Whether the wave had settled before this contact, so that the values follow from the exact solitary wave.
    error_estimate : float
        Relative error estimate of both time and peak force.
    """

    contact: int
    arrival_time: float
    peak_force: float
    exact: bool
    error_estimate: float

    @classmethod
    def of(cls, contact: int, time: float, force: float, error: float, exact: bool = False) -> Passage:
        """A passage in scaled units."""
        return cls(contact=contact, arrival_time=time, peak_force=force, exact=exact, error_estimate=error)

    def in_si(self, scales: Scales) -> Passage:
        """Convert a passage in scaled units to SI units."""
        time, force = self.arrival_time * scales.time, self.peak_force * scales.contact_force
        return evolve(self, arrival_time=time, peak_force=force)
