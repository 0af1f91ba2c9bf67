"""The profile of a force record, linear between samples."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Iterable, Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Literal

import attrs
import numpy as np
from attrs import frozen

from shockwave.base.arguments import unknown_arguments
from shockwave.base.errors import Fault, InvalidValueError, collect_faults, first_of, locate, refuse
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import SI, Declaration, Value, declaration_of, one_of, quantity, text_of
from shockwave.base.units import to_si
from shockwave.profiles.piecewise_linear import PiecewiseLinear
from shockwave.records.record_file import Record, read_record
from shockwave.records.record_format import RecordFormat
from shockwave.records.record_processing import CHANGE_SIGNS, Processing, Pulse, pulse_of, pulse_warnings

if TYPE_CHECKING:
    from typing import Unpack

    from shockwave.arguments import RecordArguments


def _convert_samples(value: Any, attribute: attrs.Attribute[Any]) -> FloatArray:
    """A read-only copy as floats in SI units."""
    spec = declaration_of(attribute)
    assert spec is not None
    try:
        # numpy would strip the unit of a quantity of pint
        array = np.array(value.to(spec.unit).magnitude if hasattr(value, "to_base_units") else value, dtype=float)
    except (TypeError, ValueError):
        array = _convert_quantities(value, attribute.name, spec.unit)
    if array.ndim != 1:
        raise InvalidValueError.of(attribute.name, f"must be a sequence of numbers (got {text_of(value)})")
    array.setflags(write=False)
    return array


def _convert_quantities(values: Any, name: str, unit: str) -> FloatArray:
    """Samples given as text or quantities of pint; a zero-dimensional array if they are no sequence."""
    faults, numbers = list[Fault](), list[float]()
    if isinstance(values, str) or not isinstance(values, Iterable):
        return np.zeros(())
    for index, value in enumerate(values):
        with collect_faults(faults, name, index):
            numbers.append(to_si(value, unit))
    if faults:
        raise first_of(faults)
    return np.array(numbers)


def _declare_samples(unit: str, meaning: str) -> Any:
    """An attrs field that holds samples."""
    return attrs.field(
        converter=attrs.Converter(_convert_samples, takes_field=True),
        eq=attrs.cmp_using(eq=np.array_equal),
        repr=partial(np.array2string, separator=", ", threshold=8, precision=4, max_line_width=200),
        metadata=Declaration(unit, meaning, samples=True).metadata,
    )


def _convert_window(value: Any, attribute: attrs.Attribute[Any]) -> tuple[float, float] | None:
    """Two times in ascending order, or None."""
    if value is None:
        return None
    spec = Declaration("s", "")
    times = [spec.check(attribute.name, time) for time in value] if isinstance(value, list | tuple) else []
    if len(times) != 2 or not times[0] < times[1]:
        raise InvalidValueError.of(attribute.name, f"must be two times, the earlier one first (got {text_of(value)})")
    return times[0], times[1]


def _declare_window(meaning: str, example: str) -> Any:
    """An attrs field that holds a time window of the record."""
    metadata = Declaration("s", meaning, samples=True, optional=True, example=example).metadata
    return attrs.field(default=None, converter=attrs.Converter(_convert_window, takes_field=True), metadata=metadata)


@frozen(slots=False)
class Tabulated(PiecewiseLinear, Value, kw_only=False):
    """A force record, linear between its samples, with its own peak force, rise time and duration ratio n.

    The rise ends at the first sample with the highest force; a plateau is part of the decay. The samples are used as
    given, except for zeros at the ends and the steps below, which are applied in the order baseline, low-pass filter,
    crop, negative forces; `notes` state effects on peak force, rise time and impulse. `alarms` propose steps for a
    record that seems to have an offset, or to be longer than its pulse.

    Parameters
    ----------
    times : array_like of float, shape (k,)
        Sample times [s], ascending; at least three.
    forces : array_like of float, shape (k,)
        Forces [N]; the highest is above zero, and neither the first nor the last.
    duration_ratio : float, optional
        n of eq. (2), above 1, to which the decay is stretched in time. By default n is that of the record.
    baseline : (float, float), optional
        Time window of the record [s] whose mean force is subtracted.
    low_pass : float, optional
        Cut-off frequency [Hz] of a Butterworth filter of order 4 that is applied forwards and backwards, so that it
        does not shift the pulse; evenly sampled records only.
    crop : (float, float), optional
        Time window of the record [s] that is kept.
    negative : "keep" or "zero", optional
        Whether negative forces pull the first granule, which only simulations cover, or are set to zero. By default
        they are refused.

    Raises
    ------
    InvalidValueError
        If the samples are not a pulse; each error states its sample.

    Examples
    --------
    >>> import shockwave as sw
    >>> record = sw.Tabulated(times=[0, 1e-5, 4e-5, 1e-4], forces=[0, 30, 20, 0])
    >>> shock = sw.Shock(profile=record)
    >>> f"{shock.peak_force:g} N, {1e6 * shock.duration:g} us"
    '30 N, 100 us'
    """

    times: Any = _declare_samples("s", "sample times, ascending")  # noqa: RUF009
    forces: Any = _declare_samples("N", "forces at these times")  # noqa: RUF009
    duration_ratio: SI[float] = quantity(
        "", "total duration over rise time; the decay is stretched to fit", above=1.0, optional=True, default=None
    )
    baseline: Any = _declare_window("window whose mean force is subtracted", "-50 us, 0 us")  # noqa: RUF009
    low_pass: SI[float | None] = quantity("Hz", "cut-off of a low-pass filter", above=0, default=None, example="20 kHz")
    crop: Any = _declare_window("window that is kept", "0 us, 200 us")  # noqa: RUF009
    negative: Literal["keep", "zero"] | None = attrs.field(default=None, validator=one_of(None, "keep", "zero"))
    _stretch: float | None = attrs.field(init=False, repr=False, eq=False)
    _pulse: Pulse = attrs.field(init=False, repr=False, eq=False)
    _assumed: tuple[str, ...] = attrs.field(init=False, repr=False, eq=False, default=())

    def __attrs_post_init__(self) -> None:
        object.__setattr__(self, "_stretch", self.duration_ratio)
        pulse = pulse_of(self.times, self.forces, self._stretch, self._steps)
        object.__setattr__(self, "_pulse", pulse)
        object.__setattr__(self, "duration_ratio", float(pulse.knots[-1]))

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], **settings: Unpack[RecordArguments]) -> Tabulated:
        """Read the profile from a text file with a time and a force column; see `read_record`.

        Parameters
        ----------
        path : path-like
            The file; its header can state units.
        **settings
            Parameters of the class, and those of `RecordFormat`, which state what the file does not.

        Raises
        ------
        FileAccessError
            If the file cannot be read.
        InvalidValueError
            If the file does not contain a pulse; each error states its line.
        """
        format_names = [field.name for field in attrs.fields(RecordFormat) if field.init]
        names = [field.name for field in attrs.fields(cls) if field.init]
        parameters: dict[str, Any] = {**settings}
        refuse(unknown_arguments(parameters, format_names + names))
        format_settings = {name: parameters.pop(name) for name in format_names if name in parameters}
        record = read_record(pathlib.Path(path), RecordFormat(**format_settings))
        with locate(partial(_place, path, record)):
            profile = cls(record.times, record.forces, **parameters)
        object.__setattr__(profile, "_assumed", record.notes)
        return profile

    def __hash__(self) -> int:
        return hash((self.times.size, self.duration_ratio, self.recorded_peak_force, self.recorded_rise_time))

    @property
    def corners(self) -> tuple[FloatArray, FloatArray]:
        return self._pulse.knots, self._pulse.values

    @property
    def recorded_peak_force(self) -> float:
        return self._pulse.peak_force

    @property
    def recorded_rise_time(self) -> float:
        return self._pulse.rise_time

    @property
    def figures(self) -> Mapping[str, float]:
        """Peak force [N], rise time [s] and impulse [N s], with the decay as recorded."""
        return self._pulse.figures

    @property
    def notes(self) -> tuple[str, ...]:
        return self._assumed + self._pulse.notes

    @cached_property
    def alarms(self) -> tuple[str, ...]:
        """Warnings about the pulse, with the keys to set."""
        return tuple(pulse_warnings(self.times, self.forces, self._stretch, self._steps, self._pulse))

    @property
    def _steps(self) -> Processing:
        return {name: getattr(self, name) for name in ("baseline", "low_pass", "crop", "negative")}

    @cached_property
    def pulls(self) -> bool:
        return bool((self._pulse.values < 0).any())


def _place(path: str | os.PathLike[str], record: Record, fault: Fault) -> Fault:
    """``fault`` with advice for a file, and with the line of the sample that it concerns, if it concerns one."""
    fault = attrs.evolve(fault, problem=fault.problem.replace(CHANGE_SIGNS, "set sign: -1"))
    if {"times", "forces"}.isdisjoint(fault.steps):
        return fault
    index = fault.steps[-1] if isinstance(fault.steps[-1], int) else 0
    return attrs.evolve(fault, location=f"{path}:{record.lines[index]}")
