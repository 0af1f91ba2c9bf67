"""Options of a simulation, declared once for Python, scenario files and the command line."""

from __future__ import annotations

import functools
import typing
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import attrs
from attrs import field, frozen

from shockwave.base.arguments import unknown_arguments
from shockwave.base.errors import Fault, InvalidValueError, refuse
from shockwave.base.quantity_fields import (
    MAGNITUDES,
    PLAIN,
    SI,
    Converted,
    Declaration,
    Value,
    join,
    one_of,
    quantity,
    text_of,
    tuple_repr,
)
from shockwave.registry.registry import find

if TYPE_CHECKING:
    from shockwave.scene.sensors import Sensor
else:  # most simulations have none
    Sensor = Any

Waves = Literal["train", "primary"]
Backend = Literal["auto", "compiled", "numpy"]
Recorded = Literal["forces", "field", "energies"]
#: A sensor as a scenario states it, such as ``wall``, ``{granule: 10}`` or ``{granule: 3, quantity: velocity}``.
SensorArgument: TypeAlias = Literal["wall", "structure"] | Mapping[str, int | str]

# Numbers up to far beyond any chain that can be simulated.
_CONTACT = Declaration("", "contacts, counted from 0", whole=True, at_least=0, at_most=10**12, samples=True)
_SENSORS = "wall, structure, {contact: N}, {granule: N} or {granule: N, quantity: velocity or displacement}"


def _convert_items(name: str, values: Any, rule: str, convert: Callable[[Any], Any]) -> list[Any]:
    """Items of a list, converted; raises an `InvalidValueError` with all for which ``convert`` returns None."""
    if isinstance(values, tuple) and not values:
        return []  # without the cost of the checks
    if isinstance(values, str | Mapping) or not isinstance(values, Iterable):
        raise InvalidValueError.of(name, f"must be a list (got {text_of(values)})")
    items = [(value, convert(value)) for value in values]
    wrong = ((index, value) for index, (value, item) in enumerate(items) if item is None)
    refuse(Fault((name, index), f"must be {rule} (got {text_of(value)})") for index, value in wrong)
    return [item for _, item in items]


def _contacts(values: Any) -> tuple[int, ...]:
    """Ascending numbers of contacts."""

    def number(value: Any) -> int | None:
        return None if isinstance(value, float) or _CONTACT.problem(value) else int(value)

    return tuple(sorted(set(_convert_items("contacts", values, _CONTACT.rule, number))))


def _record(values: Any) -> tuple[Any, ...]:
    known = typing.get_args(Recorded)
    return tuple(_convert_items("record", values, join(known), lambda name: name if name in known else None))


def _sensors(values: Any) -> tuple[Any, ...]:
    def sensor(value: Any) -> Any:
        from shockwave.scene.sensors import sensor_of  # most simulations have none

        return sensor_of(value)

    return tuple(_convert_items("sensors", values, _SENSORS, sensor))


@frozen(kw_only=True)
class SimulateOptions(Value):
    """Options of a simulation.

    Parameters
    ----------
    integrator : str, optional
        Name of a registered integrator. Default: rkn86, or rkn1210 for a tolerance below 1e-7.
    rtol : float, optional
        Relative tolerance of the peak force of the leading wave, 1e-13 to 1e-2, for adaptive methods. Default: 1e-6.
    step : float, optional
        Step size in units of the characteristic time of the wave, up to 1, for fixed-step methods. Default: 0.02.
    wave_threshold : float
        Weakest wave that counts, relative to the leading wave, 1e-3 to below 1.
    waves : "train" or "primary"
        All waves and the rebounding granules, or the leading wave alone.
    backend : "auto", "compiled" or "numpy"
        Code that integrates the chain. ``auto`` is the compiled code if it was built.
    contacts : sequence of int
        Contacts, counted from 0, at which the passage of the leading wave or, in a finite chain, the greatest force is
        reported. Default: none in an endless chain, all in a finite one, evenly spaced beyond 1000.
    record : sequence of "forces", "field", "energies"
        Histories to record: forces at ``contacts``, positions and velocities of all granules, energies.
    sensors : sequence of str or mapping
        Sensors whose histories and first pulses are computed: ``wall``, ``structure``, ``{contact: N}``,
        ``{granule: N}`` (the mean of its two contact forces), also with ``quantity: velocity`` or ``displacement``.
        Default: none.
    interval, until : float, optional
        Sampling interval of the histories and their end [s]. Default: a tenth of the characteristic time of the wave,
        and shortly after the leading wave has passed the last of ``contacts`` or was measured; with ``sensors``, the
        duration of the shock plus three times the time at which it arrives at the end of the chain or the last of them.
    timeout : float, optional
        Maximum computing time [s]. If the leading wave has not been found by then, the simulation fails; anything else
        still missing is omitted with a warning. Default: no limit.

    Raises
    ------
    InvalidValueError, UnknownNameError
        When a value is out of range or the name is unknown.
    """

    integrator: str | None = None
    rtol: SI[float | None] = quantity(
        "", "relative tolerance of the peak force, 1e-6 if omitted", default=None, at_least=1e-13, at_most=1e-2
    )
    step: SI[float | None] = quantity(
        "", "step of a fixed-step method, in characteristic times", default=None, above=0, at_most=1
    )
    # below a thousandth, peaks are not separable from the residual motion of the chain
    wave_threshold: SI[float] = quantity(
        "", "weakest wave that counts, relative to the leading wave", at_least=1e-3, below=1, default=5e-3
    )
    waves: Waves = field(default="train", validator=one_of(*typing.get_args(Waves)))
    backend: Backend = field(default="auto", validator=one_of(*typing.get_args(Backend)))
    contacts: Converted[tuple[int, ...], Iterable[int]] = field(
        default=(), converter=_contacts, repr=tuple_repr, metadata=_CONTACT.metadata
    )
    record: Converted[tuple[Recorded, ...], Iterable[Recorded]] = field(default=(), converter=_record)
    sensors: Converted[tuple[Sensor, ...], Iterable[SensorArgument]] = field(
        default=(), converter=_sensors, metadata={PLAIN: True}
    )
    interval: SI[float | None] = quantity("s", "sampling interval of the histories", within=MAGNITUDES, default=None)
    until: SI[float | None] = quantity("s", "end of the histories", within=MAGNITUDES, default=None)
    timeout: SI[float | None] = quantity("s", "maximum computing time", above=0, default=None)

    def __attrs_post_init__(self) -> None:
        if self.interval is not None and not self.is_recorded:
            problem = f"must be left out without record or sensors (got {self.interval:g} s; list what to record)"
            raise InvalidValueError.of("interval", problem)
        takes = "rtol backend"
        if self.integrator is not None:
            method = find("integrators", self.integrator)
            takes = method.takes
            object.__setattr__(self, "integrator", method.name)  # which may differ in case
        if takes:
            self.check(self.integrator or "the default integrator", takes.split())

    @property
    def is_recorded(self) -> bool:
        """Whether histories are requested."""
        return bool(self.record or self.sensors)

    @property
    def wanted_backend(self) -> Backend:
        """The backend, or ``auto`` if the integrator takes none."""
        takes = "backend" if self.integrator is None else find("integrators", self.integrator).takes
        return self.backend if "backend" in takes.split() else "auto"

    def check(self, name: str, takes: Collection[str]) -> None:
        """Refuse a setting that the method ``name`` does not use; ``takes`` are those that it uses."""
        other = "rtol" if "rtol" in takes else "step"
        why = "chooses its own steps" if other == "rtol" else "has a fixed step size"
        for setting in {"rtol", "step"} - set(takes):
            value = getattr(self, setting)
            if value is not None:
                raise InvalidValueError.of(setting, f"must be left out: {name} {why} (got {value:g}; give {other})")
        if self.backend == "compiled" and "backend" not in takes:
            problem = f"must be auto or numpy: {name} is compiled for some chains only, if at all (got 'compiled')"
            raise InvalidValueError.of("backend", problem)


# Plain options are cached, so that repeated ones are not checked again; typed, because 1 == True.
_kept_options = functools.lru_cache(maxsize=64, typed=True)(SimulateOptions)


def options_of(arguments: dict[str, Any], other: str = "limit") -> SimulateOptions:
    """Options from keyword arguments of a function with an ``other``; raises InvalidValueError for an unknown name."""
    refuse(unknown_arguments(arguments, [other, *attrs.fields_dict(SimulateOptions)]))
    plain = all(value is None or isinstance(value, str | int | float) for value in arguments.values())
    return (_kept_options if plain else SimulateOptions)(**arguments)
