"""Waves, passages, trains and histories as plain data."""

from __future__ import annotations

from typing import Any

from attrs import asdict, evolve, field, frozen

from shockwave.chain.chain import Scales
from shockwave.quadrature import FloatArray

__all__ = ["Cost", "MeasuredWave", "Passage", "Recording", "Train"]

#: Quantity of a wave -> its unit among `Scales`.
_UNITS = {
    "peak_force": "force",
    "momentum": "momentum",
    "energy": "energy",
    "speed": "wave_speed",
    "width": "time",
    "granule_velocity": "velocity",
    "arrival_time": "time",
}


@frozen(kw_only=True)
class MeasuredWave:
    """One wave as it passed a contact, in SI units (in scaled ones before the result is made).

    Attributes
    ----------
    peak_force, momentum, energy, width, granule_velocity : float
        As in `SolitaryWave`, measured from the history of the contact force. Width and granule velocity of a primary
        that was followed alone are those of the exact wave of its peak force.
    speed : float or None
        Of the peak along the chain [m/s]; None where only one contact was passed.
    contact : int
        Where it was read, counted from 0: contact i lies between granules i and i + 1.
    arrival_time : float
        Of its peak there [s].
    error_estimate : float or None
        Relative, of ``peak_force`` as the limit far along the chain; None for a wave that had not settled, or that
        was found in one of the two runs only.
    foot : float
        Force left between the wave and its neighbours, over its peak: momentum, energy, width and granule velocity
        are the wave's own to about as much.
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
        """This wave, so far in scaled units, in SI units and with its error estimate."""
        known = {name: getattr(self, name) for name in _UNITS if getattr(self, name) is not None}
        values = {name: value * getattr(scales, _UNITS[name]) for name, value in known.items()}
        return evolve(self, error_estimate=error_estimate, **values)


@frozen(kw_only=True)
class Passage:
    """The primary at a contact, in SI units.

    ``exact`` says that the wave had come to its limit before: it is the exact solitary wave from there on, and was
    not integrated further. ``error_estimate`` is relative, of time and peak force alike.
    """

    contact: int
    arrival_time: float
    peak_force: float
    exact: bool
    error_estimate: float


@frozen(kw_only=True)
class Cost:
    """Work that a result took; ``seconds`` vary from run to run and are left out of comparisons."""

    steps: int
    force_evaluations: int
    seconds: float = field(eq=False)

    def __add__(self, other: Cost) -> Cost:
        return Cost(
            steps=self.steps + other.steps,
            force_evaluations=self.force_evaluations + other.force_evaluations,
            seconds=self.seconds + other.seconds,
        )


@frozen(kw_only=True)
class Train:
    """All waves, and the granules that leave the ends.

    Attributes
    ----------
    waves : tuple of MeasuredWave
        Strongest first; weaker than ``wave_threshold`` times the primary are not counted.
    recoil_momentum, recoil_error : float
        Of the granules that fly backwards [N s], zero or negative; and an estimate of its error [N s], with what
        granules hold that had not come apart for good.
    recoil_velocities : tuple of float
        Of the ejected granules [m/s], first granule first: those that fly backwards faster than a thousandth of the
        granules in the primary.
    spall_velocities : tuple of float or None
        Of the granules that fly off the free end [m/s], last granule first; None in a chain without end, or one whose
        end the waves had not reached.
    cost : Cost
        Of the two runs.
    warnings : tuple of str
        Notes to read before using the figures.
    """

    waves: tuple[MeasuredWave, ...]
    recoil_momentum: float
    recoil_error: float
    recoil_velocities: tuple[float, ...]
    spall_velocities: tuple[float, ...] | None
    cost: Cost
    warnings: tuple[str, ...]


@frozen(kw_only=True, eq=False)
class Recording:
    """Histories at equal intervals, in SI units; what was not asked for is None.

    Attributes
    ----------
    times : array, shape (k,)
        [s]
    contacts : tuple of int
        Of ``forces``.
    forces : array, shape (k, contacts), or None
        Contact forces [N].
    displacements, velocities : array, shape (k, granules), or None
        Of all granules that have moved by the end [m], [m/s].
    kinetic_energy, contact_energy : array, shape (k,), or None
        Of the chain [J].
    """

    times: FloatArray
    contacts: tuple[int, ...]
    forces: FloatArray | None = None
    displacements: FloatArray | None = None
    velocities: FloatArray | None = None
    kinetic_energy: FloatArray | None = None
    contact_energy: FloatArray | None = None

    def to_dict(self) -> dict[str, Any]:
        """Lists of SI floats."""
        arrays = asdict(self, filter=lambda attribute, _: attribute.name != "contacts")
        lists = {name: None if array is None else array.tolist() for name, array in arrays.items()}
        return {"contacts": list(self.contacts), **lists}
