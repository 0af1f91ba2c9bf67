"""A prescribed motion of the first granule, as of a base on a shaker, in place of a shock or a striker."""

from __future__ import annotations

import os
import pathlib
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Self, get_args

import numpy as np
from attrs import field, frozen

from shockwave.base.errors import Fault, InvalidValueError, refuse
from shockwave.base.quantity_fields import SI, Converted, Value, one_of, quantity, text_of

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

MotionQuantity = Literal["displacement", "velocity", "acceleration"]
# Fewest samples of a record; those of a spline.
_FEWEST = {"displacement": 4, "velocity": 2, "acceleration": 2}


def _convert_samples(value: Any) -> tuple[float, ...] | None:
    try:
        return None if value is None else tuple(np.array(value, dtype=float).tolist())
    except (TypeError, ValueError):
        raise InvalidValueError(f"must be a list of numbers (got {text_of(value)})") from None


@frozen(kw_only=True, slots=False)
class Motion(Value):
    """A prescribed motion of the first granule of a finite chain, which flies free afterwards.

    It is a constant velocity, or a record. Before its first sample the granule is at rest at 0; the end of the record
    is that of the motion. An acceleration is linear between its samples. A velocity is interpolated by a monotone cubic
    (PCHIP), so that the acceleration is continuous, and a displacement by a cubic spline that begins with zero slope.

    Parameters
    ----------
    velocity, until : float, optional
        A constant velocity [m/s] and the time until which it lasts [s].
    times, values : array_like of float, shape (k,), optional
        Samples of a record, times ascending [s], and values in SI units.
    quantity : "displacement", "velocity" or "acceleration", optional
        What the record contains.

    Raises
    ------
    InvalidValueError
        If a value is out of range, neither a velocity nor a record is given, or both are.

    Examples
    --------
    >>> import shockwave as sw
    >>> row = sw.Chain(material="delrin", diameter="9.5 mm", granules=20)
    >>> piston = sw.Motion(velocity="0.2 m/s", until="200 us")
    >>> result = sw.simulate(piston, row, contacts=[10])
    >>> f"{result.contacts[0].peak_force:.3f} N"
    '5.626 N'
    """

    velocity: SI[float | None] = quantity(
        "m/s", "constant velocity", at_least=1e-20, at_most=299_792_458.0, default=None
    )
    until: SI[float | None] = quantity("s", "end of the constant velocity", above=0, default=None)
    times: Converted[tuple[float, ...] | Any, Any] = field(default=None, converter=_convert_samples)
    values: Converted[tuple[float, ...] | Any, Any] = field(default=None, converter=_convert_samples)
    quantity: MotionQuantity | None = field(default=None, validator=one_of(None, *get_args(MotionQuantity)))

    def __attrs_post_init__(self) -> None:
        pairs = ("velocity", "until"), ("times", "values", "quantity")
        constant, record = ([name for name in names if getattr(self, name) is not None] for names in pairs)
        if not constant and not record:
            raise InvalidValueError.of(
                "velocity", "must be given with until, or a record with its quantity (got nothing)"
            )
        given, missing = (constant, pairs[0]) if constant else (record, pairs[1])
        faults = [Fault(name, f"must be given with {given[0]} (got nothing)") for name in missing if name not in given]
        faults += [Fault(name, "must be left out for a constant velocity") for name in record if constant]
        refuse(faults or ([] if constant else self._sample_faults()))

    def _sample_faults(self) -> list[Fault]:
        """Errors of the samples."""
        times, values, least = np.array(self.times), np.array(self.values), _FEWEST[str(self.quantity)]
        if times.ndim != 1 or times.shape != values.shape or times.size < least:
            return [Fault("times", f"must be {least} or more, as many as values (got {times.size} and {values.size})")]
        if not (np.isfinite(times).all() and np.isfinite(values).all() and (np.diff(times) > 0).all()):
            return [Fault("times", "must be finite and ascending, and the values finite")]
        if self.quantity == "displacement" and values[0]:
            return [Fault("values", f"must begin with a displacement of 0 (got {values[0]:g} m)")]
        return [] if values.any() else [Fault("values", "must not all be 0")]

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], quantity: MotionQuantity, **settings: Any) -> Self:
        """Read the motion from a text file with a time column and one of the ``quantity``; see `read_record`.

        Parameters
        ----------
        path : path-like
            The file; its header can state units.
        quantity : "displacement", "velocity" or "acceleration"
            What the second column contains.
        **settings
            Parameters of `RecordFormat`, which state what the file does not.

        Raises
        ------
        FileAccessError
            If the file cannot be read.
        InvalidValueError
            If it does not contain such a record.
        """
        from shockwave.records.record_file import read_record
        from shockwave.records.record_format import RecordFormat

        record = read_record(pathlib.Path(path), RecordFormat(**settings), quantity)
        return cls(times=record.times, values=record.forces, quantity=quantity)

    @cached_property
    def course(self) -> PPoly:
        """Displacement [m] over the time since the beginning [s], a piecewise polynomial."""
        from scipy.interpolate import CubicSpline, PchipInterpolator, PPoly

        if self.velocity is not None:
            return PPoly([[self.velocity], [0.0]], np.array([0.0, self.until], dtype=float))
        times, values = np.array(self.times) - self.times[0], np.array(self.values)
        if self.quantity == "displacement":
            ends: Any = (1, 0.0), "not-a-knot"
            return CubicSpline(times, values, bc_type=ends)
        if self.quantity == "velocity":
            return PchipInterpolator(times, values).antiderivative()
        return PPoly([np.diff(values) / np.diff(times), values[:-1]], times).antiderivative(2)

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return float(self.course.x[-1])

    @cached_property
    def top_speed(self) -> float:
        """Greatest speed, to about a per cent [m/s]."""
        shares = np.linspace(0, 1, 9)[:, None]
        edges = self.course.x
        return float(np.abs(self.course(edges[:-1] + shares * np.diff(edges), 1)).max())
