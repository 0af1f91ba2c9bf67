"""Histories of a chain at equal time intervals, and the check of what is requested."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import asdict, frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.numerics import FloatArray
from shockwave.base.result import Result, fields_of
from shockwave.base.text import si
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions

if TYPE_CHECKING:  # a result that is only printed does not need it
    from shockwave.base.result_tables import Table

#: Largest number of contacts that are reported unless they are requested.
MOST_REPORTED = 1000
# Default number of samples per characteristic time of the wave.
_SAMPLES = 10
#: Default end of the histories after the passage of the last contact, in characteristic times.
AFTER = 5.0
# Least simulated time over the rise time: earlier, the free-particle displacement loses its digits in rounding.
_LEAST_TIME = 0.01
#: Largest number of values in the histories, to limit the memory.
MOST_NUMBERS = 20_000_000
# Values in a sample for each sensor, of up to two contacts or bodies.
_VALUES = 10


@frozen(eq=False)
class SensorHistory:
    """History of a sensor: its name, its SI unit, and its values at the times of the recording."""

    name: str
    unit: str
    values: FloatArray


@frozen(kw_only=True, eq=False, repr=False)
class Recording(Result):
    """Histories at equal time intervals, in SI units; histories that were not requested are None.

    Two recordings are equal if contacts and all values are equal.

    Attributes
    ----------
    times : array, shape (k,)
        Times [s].
    contacts : tuple of int
        Contacts of the columns of ``forces``.
    forces : array, shape (k, n_contacts), or None
        Contact forces [N].
    displacements, velocities : array, shape (k, n_granules), or None
        Displacements [m] and velocities [m/s] of all granules that have moved by the end.
    kinetic_energy, contact_energy : array, shape (k,), or None
        Kinetic energy and contact energy of the chain [J], the latter counted from the static state, both with those
        of a movable wall and its spring.
    wall_force : array, shape (k,), or None
        Force on the wall [N]; None without a wall or ``forces``.
    applied_force : array, shape (k,), or None
        Force that a prescribed motion of the first granule takes [N]; None without one or ``forces``.
    sensors : tuple of SensorHistory
        Histories of the sensors, in their order; those of a movable end are four.
    """

    times: FloatArray
    contacts: tuple[int, ...]
    forces: FloatArray | Any = None
    displacements: FloatArray | Any = None
    velocities: FloatArray | Any = None
    kinetic_energy: FloatArray | Any = None
    contact_energy: FloatArray | Any = None
    wall_force: FloatArray | Any = None
    applied_force: FloatArray | Any = None
    sensors: tuple[SensorHistory, ...] = ()

    _picture = "shockwave.pictures.histories:draw_histories"
    _tables = (("histories", "time"),)

    def __repr__(self) -> str:
        shapes = (f"{name} {kept.shape}" for name, kept in self._arrays.items())
        span = f"{len(self.times)} times to {self.times[-1]:g} s, {len(self.contacts)} contacts"
        return f"Recording({span}; {', '.join(shapes)})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Recording):
            return NotImplemented
        here, there = self._arrays, other._arrays
        same = self.contacts == other.contacts and here.keys() == there.keys()
        return same and all(np.array_equal(here[name], there[name]) for name in here)

    __hash__ = None  # type: ignore[assignment]

    @property
    def _arrays(self) -> dict[str, FloatArray]:
        arrays = {name: kept for name, kept in asdict(self, recurse=False).items() if isinstance(kept, np.ndarray)}
        return arrays | {each.name: each.values for each in self.sensors}

    def _table(self, name: str) -> Table:
        from shockwave.base.result_tables import column, coordinate

        table, units = coordinate("time", self.times), {each.name: each.unit for each in self.sensors}
        for name, kept in self._arrays.items():
            if name != "times":
                second = "contact" if name == "forces" else "granule"
                places = self.contacts if name == "forces" else range(kept.shape[-1])
                table |= coordinate(second, places) if kept.ndim > 1 else {}
                table |= column(name, kept, *("time", second)[: kept.ndim], unit=units.get(name))
        return table

    def to_dict(self) -> dict[str, Any]:
        """Attributes by name, with arrays as lists of SI floats."""
        return fields_of(self)


def check_requests(options: SimulateOptions, shock: Shock, chain: Chain, scales: Scales) -> None:
    """Refuse contacts that the chain does not have, and histories that have too many values in any case."""
    if options.contacts and chain.count is not None:
        select_contacts(options, chain.count - 1)
    if chain.count is not None:
        check_end(options, shock)
    elif "forces" in options.record and not options.contacts:
        raise InvalidValueError.of("contacts", "must be given if record includes forces (got none)")
    if options.record:
        until = AFTER if options.until is None else options.until / scales.time
        sample_times(options, scales, until, until)


def check_end(options: SimulateOptions, excitation: object) -> None:
    """Refuse an end of the simulated time that is too early in the rise of a shock."""
    if isinstance(excitation, Shock) and options.until is not None:
        least = _LEAST_TIME * excitation.rise_time
        if options.until < least:
            rule = f"must be at least {si(least, 's')}, a hundredth of the rise time"
            problem = f"{rule} (got {si(options.until, 's', 9)})"
            raise InvalidValueError.of("until", problem)


def check_contact(chain: Chain, contact: int) -> int:
    """Check that ``contact`` is a contact of the chain."""
    granules = chain.count
    whole = isinstance(contact, int | np.integer) and not isinstance(contact, bool)
    if not whole or contact < 0 or (granules is not None and contact > granules - 2):
        most = "" if granules is None else f" and at most {granules - 2}, the last of this chain"
        raise InvalidValueError.of("contact", f"must be a whole number of at least 0{most} (got {contact!r})")
    return int(contact)


def select_contacts(options: SimulateOptions, contacts: int) -> tuple[int, ...]:
    """The requested contacts; by default all ``contacts`` of the chain or, in a long chain, evenly spaced ones.

    Raises
    ------
    InvalidValueError
        If the chain does not have a requested contact.
    """
    if not options.contacts:
        if contacts <= MOST_REPORTED:
            return tuple(range(contacts))
        return tuple(np.round(np.linspace(0, contacts - 1, MOST_REPORTED)).astype(int).tolist())
    if options.contacts[-1] >= contacts:
        problem = f"must be at most {contacts - 1}, the last contact of this chain (got {options.contacts[-1]})"
        raise InvalidValueError.of("contacts", problem)
    return options.contacts


def sample_times(
    options: SimulateOptions, scales: Scales, until: float, granules: float, unit: float | None = None
) -> FloatArray:
    """Scaled times of the samples of ``granules`` granules; raise if the histories have too many values.

    Their default interval is a tenth of the ``unit``, the characteristic time of the wave [s], or that of ``scales``.
    """
    interval = (options.interval or (unit or scales.time) / _SAMPLES) / scales.time
    count = int(until / interval * (1 + 1e-12)) + 1
    values: float = _VALUES * len(options.sensors)
    if options.record:
        values += (len(options.contacts) or min(granules, MOST_REPORTED)) + 2 * granules
    if count * values > MOST_NUMBERS:
        most = int(MOST_NUMBERS / values)
        word = "got" if options.interval else "by default"
        got = f"{word} {interval * scales.time:g} s for {until * scales.time:g} s; alternatively give an earlier until"
        problem = f"must be longer, because the histories would have {count} samples, more than {most} ({got})"
        raise InvalidValueError.of("interval", problem)
    # the last multiple of the interval can exceed the end by a rounding error
    return np.asarray(np.minimum(interval * np.arange(count), until))
