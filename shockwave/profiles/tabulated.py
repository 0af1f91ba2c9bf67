"""Tabulated: the shape of a recorded force, piecewise linear between its samples."""

from __future__ import annotations

import os
import pathlib
import re
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from attrs import frozen

from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import Quantity, quantity
from shockwave.numerics import running_sums
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.record import Record, read_record
from shockwave.profiles.record_cleaning import Pulse, pulse_of
from shockwave.quadrature import FloatArray

if TYPE_CHECKING:
    from shockwave.profiles.free_path import FreePath


_TIMES = {"shockwave": Quantity("s", "sample times, ascending", samples=True)}
_FORCES = {"shockwave": Quantity("N", "forces at these times", samples=True)}
_same = attrs.cmp_using(eq=np.array_equal)
_shown = partial(np.array2string, separator=", ", threshold=8, precision=4, max_line_width=200)


def _read_only(value: Any) -> Any:
    """A read-only copy as floats; what is no row of numbers is left alone, for the check to report."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        return value
    if array.ndim != 1:
        return value
    array.setflags(write=False)
    return array


@frozen(slots=False)
class Tabulated(ShockProfile):
    """A force record, linear between its samples; peak force, rise time and n are read off it.

    The rise ends at the first sample of the highest force; a plateau belongs to the decay. A baseline,
    forces below zero and the quiet before and after the pulse are removed, as `notes` state.

    Parameters
    ----------
    times : array_like of float, shape (k,)
        Sample times [s], ascending; at least three.
    forces : array_like of float, shape (k,)
        Forces [N]; the highest is above zero, and neither the first nor the last.
    duration_ratio : float, optional
        n of eq. (2), > 1: the decay is stretched in time to have it. Left out, n is the record's.

    Raises
    ------
    InvalidValueError
        When the samples are no pulse; each fault names its sample.
    """

    times: FloatArray = attrs.field(converter=_read_only, eq=_same, repr=_shown, metadata=_TIMES)
    forces: FloatArray = attrs.field(converter=_read_only, eq=_same, repr=_shown, metadata=_FORCES)
    duration_ratio: float = quantity(
        "", "whole duration over rise time, stretches the decay", above=1.0, optional=True, default=None
    )
    _pulse: Pulse = attrs.field(init=False, repr=False, eq=False)
    _assumed: tuple[str, ...] = attrs.field(init=False, repr=False, eq=False, default=())

    def __attrs_post_init__(self) -> None:
        pulse = pulse_of(self.times, self.forces, self.duration_ratio)
        object.__setattr__(self, "_pulse", pulse)
        object.__setattr__(self, "duration_ratio", float(pulse.knots[-1]))

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], duration_ratio: float | None = None) -> Tabulated:
        """The profile of a record in a text file with a time and a force column; see `read_record`.

        Parameters
        ----------
        path : path-like
            The file. Its header may name units; without any, seconds and newtons are assumed.
        duration_ratio : float, optional
            As for the class.

        Raises
        ------
        FileAccessError
            When the file cannot be read.
        InvalidValueError
            When it holds no pulse; each fault names its line.
        """
        record = read_record(pathlib.Path(path))
        try:
            profile = cls(record.times, record.forces, duration_ratio)  # type: ignore[arg-type]
        except InvalidValueError as error:
            raise InvalidValueError([_placed(fault, path, record) for fault in error.faults]) from None
        object.__setattr__(profile, "_assumed", record.notes)
        return profile

    def __hash__(self) -> int:
        return hash((self.times.size, self.duration_ratio, self.recorded_peak_force, self.recorded_rise_time))

    @cached_property
    def breakpoints(self) -> tuple[float, ...]:
        return tuple(self._pulse.knots.tolist())

    @property
    def recorded_peak_force(self) -> float:
        return self._pulse.peak_force

    @property
    def recorded_rise_time(self) -> float:
        return self._pulse.rise_time

    @property
    def notes(self) -> tuple[str, ...]:
        return self._assumed + self._pulse.notes

    def rise(self, s: FloatArray) -> FloatArray:
        return np.asarray(self._at(s)[2])

    def decay(self, s: FloatArray) -> FloatArray:
        return np.asarray(self._at(s)[2])

    def closed_areas(self) -> tuple[float, float]:
        return self._sums[2]

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        before, step, force = self._at(s)
        return np.asarray(self._sums[0][before] + 0.5 * step * (self._pulse.values[before] + force))

    def closed_double_integral(self, s: FloatArray) -> FloatArray:
        before, step, force = self._at(s)
        rest = step * (2.0 * self._pulse.values[before] + force) / 6.0
        return np.asarray(self._sums[1][before] + step * (self._sums[0][before] + rest))

    def closed_free_path(self) -> FreePath:
        return self._free_path

    @cached_property
    def _sums(self) -> tuple[FloatArray, FloatArray, tuple[float, float]]:
        """Running impulse and double integral at the samples; a1 and a2."""
        widths = np.diff(self._pulse.knots)
        left, right = self._pulse.values[:-1], self._pulse.values[1:]
        areas = 0.5 * widths * (left + right)
        impulses = running_sums(areas)
        paths = running_sums(widths * (impulses[:-1] + widths * (2.0 * left + right) / 6.0))
        peak = int(np.argmax(self._pulse.values))
        # The decay is summed for itself: the difference of two sums would lose digits of a short one.
        return impulses, paths, (float(impulses[peak]), float(running_sums(areas[peak:])[-1]))

    @cached_property
    def _free_path(self) -> FreePath:
        from shockwave.profiles.free_path import of_samples

        return of_samples(self._pulse.knots, self._pulse.values, *self._sums[:2])

    def _at(self, s: FloatArray) -> tuple[Any, Any, Any]:
        """Index of the sample before ``s``, distance from it, and the force at ``s``."""
        knots, values = self._pulse.knots, self._pulse.values
        before = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, knots.size - 2)
        step = s - knots[before]
        left, right = values[before], values[before + 1]
        # A share of the step, not a slope: it stays finite however close two samples are.
        return before, step, left + step / (knots[before + 1] - knots[before]) * (right - left)


def _placed(fault: Fault, path: str | os.PathLike[str], record: Record) -> Fault:
    """The fault of a sample with the line on which the sample stands."""
    index = re.search(r"\[(\d+)\]", fault.path)
    line = record.lines[int(index[1])] if index else record.lines[0]
    return attrs.evolve(fault, location=f"{path}:{line}")
