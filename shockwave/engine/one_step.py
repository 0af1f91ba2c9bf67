"""Base class of one-step methods, with step-size control and interpolation."""

from __future__ import annotations

import abc
import math
from collections.abc import Iterator
from functools import partial
from typing import ClassVar, NamedTuple, TypeAlias, final

import numpy as np
from attrs import define

from shockwave.base.errors import NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.engine.integrator import LONGEST_STEP, Acceleration, Counted, Integrator, Step, finite

#: A number, or an array of shape (batch,) with a number for each chain of a batch.
Scalar: TypeAlias = "float | FloatArray"

# Safety factor and limits of the ratio of consecutive step sizes (Hairer, Norsett & Wanner, section II.4).
_SAFETY = 0.9
_MIN_FACTOR = 0.2
_MAX_FACTOR = 3.0
# Smallest step relative to the time, or to its unit: shorter steps are lost in rounding.
_MIN_STEP = 1e-14
# Allows for rounding where the interval is a whole number of steps.
_SLACK = 1 - 1e-9
# Least error over the tolerance: smaller ones lead to the largest factor.
_NO_ERROR = 1e-12


class Attempt(NamedTuple):
    """A trial step: the state at its end and an error estimate.

    ``error`` is the largest absolute error of any position or velocity, 0 if the method has no error estimate;
    a number or an array of shape (batch,).
    """

    x: FloatArray
    v: FloatArray
    a: FloatArray
    error: Scalar


@define
class OneStep(Integrator):
    """Base class of one-step methods; a subclass only defines ``attempt``.

    Contract for implementers, in addition to that of `Integrator`
    ---------------------------------------------------------------
    1. ``attempt(acceleration, time, size, x, v, a)`` computes a step of ``size`` from the state ``x, v`` at ``time``,
       where the acceleration is ``a``. It calls ``acceleration`` only at times within the step, and leaves the count
       of evaluations, step-size control and the check for finite numbers to the caller. It returns new arrays.
    2. ``x``, ``v``, ``a`` have shape (granules,), or (granules, batch); then ``time`` and ``size`` are numbers or have
       shape (batch,). The last axis is a batch of chains, each with its own step. A step of ``size`` 0 changes
       nothing.
    3. ``error_order`` is the order of the embedded method: the error estimate scales as the step to the power
       ``error_order + 1``. Methods with a fixed step do not set it.
    """

    error_order: ClassVar[int] = 0

    @abc.abstractmethod
    def attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        """One trial step; see the contract."""

    @final
    def steps(
        self,
        acceleration: Acceleration,
        begin: float,
        until: float,
        x: FloatArray,
        v: FloatArray,
        first_size: float | None,
    ) -> Iterator[Step]:
        counted = Counted(self, acceleration, until)
        time, x, v = begin, np.array(x, dtype=float), np.array(v, dtype=float)
        a = counted(time, x)
        size = (first_size or self.first_size(until - begin, None)) if self.adaptive else self.size
        rejected = False
        while time < until:
            smallest = _MIN_STEP * max(1.0, abs(time))
            end = self._end(time, until, max(size, smallest))
            tried = self._try(counted, time, end - time, x, v, a)
            good = math.isfinite(float(tried.error)) and finite(tried.x, tried.v, tried.a)
            accepted = good and (not self.adaptive or float(tried.error) <= self.tolerance)
            if self.adaptive:
                factor = self._factor(float(tried.error) / self.tolerance) if good else _MIN_FACTOR
                following = min((end - time) * min(factor, 1.0 if rejected else _MAX_FACTOR), LONGEST_STEP)
                # a step that was shortened to end here does not shorten the next one
                size = max(size, following) if accepted and end == until else following
                rejected = not accepted
            if accepted:
                interpolate = partial(self._interpolate, counted, time, x, v, a)
                yield Step(time, end, tried.x, tried.v, tried.a, interpolate, size)
                time, x, v, a = end, tried.x, tried.v, tried.a
            elif not self.adaptive or size < smallest:
                reason = "the error remains above the tolerance" if good else "values are not finite"
                hint = "" if self.adaptive else "; use a smaller step"
                raise NumericalError(f"{self.name} cannot step beyond t = {time:g} T0 ({reason}{hint})")

    def _factor(self, error: float) -> float:
        """Ratio of the next step to the last, from its error over the tolerance; less than 1 after a rejection."""
        factor: float = _SAFETY * max(error, _NO_ERROR) ** (-1 / (self.error_order + 1))
        return factor if error <= 1 or _MIN_FACTOR < factor < 1 else _MIN_FACTOR

    def _end(self, time: float, until: float, size: float) -> float:
        """End of a step of at most ``size``; fixed steps are equal, others do not leave a very short last step."""
        left = until - time
        count = math.ceil(left / size * _SLACK)
        if count <= 1:
            return until
        return time + (left / count if count == 2 or not self.adaptive else size)

    def _try(
        self, acceleration: Acceleration, time: float, size: float, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        # A trial step may overflow; the caller checks for finite values.
        with np.errstate(over="ignore", invalid="ignore"):
            return self.attempt(acceleration, time, size, x, v, a)

    def _interpolate(
        self, acceleration: Acceleration, begin: float, x: FloatArray, v: FloatArray, a: FloatArray, time: float
    ) -> tuple[FloatArray, FloatArray]:
        return self._try(acceleration, begin, time - begin, x, v, a)[:2]
