"""Methods that can try a step of any size from any state: step-size control and interpolation for all of them."""

from __future__ import annotations

import abc
import math
from collections.abc import Iterator
from functools import partial
from typing import ClassVar, NamedTuple, TypeAlias, final

import numpy as np
from attrs import define

from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import LONGEST_STEP, Acceleration, Counted, Integrator, Step

#: A number, or an array of shape (batch,) with one for each chain of a batch.
Scalar: TypeAlias = "float | FloatArray"

_SAFETY = 0.9
_LEAST_FACTOR = 0.2
_MOST_FACTOR = 5.0
# Below this share of the time (or of its unit) a step is lost in rounding.
_LEAST_STEP = 1e-14
# A whole number of steps stays so, whatever the rounding of their sum.
_SLACK = 1 - 1e-9
# Stands for an error of nothing, which asks for the greatest factor.
_NO_ERROR = 1e-300


class Attempt(NamedTuple):
    """A step that was tried: the state at its end and an estimate of its error.

    ``error`` is the greatest absolute error of any position or velocity, 0 where the method has no estimate;
    a number, or shape (batch,).
    """

    x: FloatArray
    v: FloatArray
    a: FloatArray
    error: Scalar


@define
class OneStep(Integrator):
    """Base class of methods of one step: a subclass writes ``attempt`` and nothing else.

    Contract for implementers, beside that of `Integrator`
    -------------------------------------------------------
    1. ``attempt(acceleration, time, size, x, v, a)`` tries a step of ``size`` from the state ``x, v`` at ``time``, at
       which the acceleration is known to be ``a``. It calls ``acceleration`` within the step alone, and leaves
       counting, step-size control and numbers that are not finite to the caller. Arrays that it returns are new.
    2. ``x``, ``v``, ``a`` are of shape (granules,), or (granules, batch) with ``time`` and ``size`` numbers or of shape
       (batch,): the last axis is a batch of chains, each with a step of its own. ``size`` may be 0: nothing moves.
    3. ``error_order`` is the order of the embedded method: the estimate scales as the step to the power of it plus 1.
       A method of fixed step leaves it out.
    """

    error_order: ClassVar[int] = 0

    @abc.abstractmethod
    def attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        """One step, tried; see the contract."""

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
        size = self._first_size(until - begin, first_size) if self.adaptive else self.size
        while time < until:
            least = _LEAST_STEP * max(1.0, abs(time))
            end = self._end(time, until, max(size, least))
            tried = self._try(counted, time, end - time, x, v, a)
            good = _finite(tried)
            if self.adaptive:
                size = self._next_size(end - time, float(tried.error), good)
            if good and (not self.adaptive or tried.error <= self.tolerance):
                interpolate = partial(self._interpolate, counted, time, x, v, a)
                yield Step(time, end, tried.x, tried.v, tried.a, interpolate, size)
                time, x, v, a = end, tried.x, tried.v, tried.a
            elif not self.adaptive or size < least:
                reason = "its error stays above the tolerance" if good else "not finite"
                hint = "" if self.adaptive else "; give a smaller step"
                raise NumericalError(f"{self.name} cannot step beyond t = {time:g} T0 ({reason}{hint})")

    def _next_size(self, size: float, error: float, good: bool) -> float:
        if not good:
            return _LEAST_FACTOR * size
        factor: float = _SAFETY * (self.tolerance / max(error, _NO_ERROR)) ** (1 / (self.error_order + 1))
        return min(size * min(max(factor, _LEAST_FACTOR), _MOST_FACTOR), LONGEST_STEP)

    def _end(self, time: float, until: float, size: float) -> float:
        """Where a step of at most ``size`` ends: steps of fixed size are equal, others leave no sliver at the end."""
        left = until - time
        count = math.ceil(left / size * _SLACK)
        if count <= 1:
            return until
        return time + (left / count if count == 2 or not self.adaptive else size)

    def _try(
        self, acceleration: Acceleration, time: float, size: float, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        # A trial step may lead anywhere; what is not finite is looked for afterwards.
        with np.errstate(over="ignore", invalid="ignore"):
            return self.attempt(acceleration, time, size, x, v, a)

    def _interpolate(
        self, acceleration: Acceleration, begin: float, x: FloatArray, v: FloatArray, a: FloatArray, time: float
    ) -> tuple[FloatArray, FloatArray]:
        return self._try(acceleration, begin, time - begin, x, v, a)[:2]


def _finite(tried: Attempt) -> bool:
    # A sum of squares is finite if all of them are, at a fraction of the cost of asking each.
    arrays = (tried.x, tried.v, tried.a)
    return math.isfinite(float(tried.error)) and all(math.isfinite(np.vdot(array, array)) for array in arrays)
