"""Base class of the integrators of the equations of motion, and the steps that they yield."""

from __future__ import annotations

import abc
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, TypeAlias

from attrs import define, field, frozen

from shockwave.quadrature import FloatArray

# The time is a number; it is an array, shape (batch,), only where a method is asked to try a batch at once.
Acceleration: TypeAlias = Callable[[Any, FloatArray], FloatArray]

#: A granule is passed by a wave in about one unit of time; longer steps only provoke rejections.
LONGEST_STEP = 1.0
# The first step is short, for nothing is known yet; an adaptive method soon makes up for it.
_FIRST_STEP = 0.05
_FIRST_SHARE = 1e-3  # of the interval, at most


@frozen(eq=False)
class Step:
    """One accepted step of x'' = a(t, x).

    ``x``, ``v``, ``a`` are positions, velocities and accelerations at its ``end``, shape (granules,);
    ``interpolate(t)`` gives positions and velocities anywhere within it; ``next_size`` is the step that the method
    would take next.
    """

    begin: float
    end: float
    x: FloatArray
    v: FloatArray
    a: FloatArray
    interpolate: Callable[[float], tuple[FloatArray, FloatArray]]
    next_size: float


@define
class Integrator(abc.ABC):
    """Base class of integrators.

    Contract for implementers
    -------------------------
    1. ``name`` is the name under which the class is registered; ``order`` the order of its global error in
       the step size; ``adaptive`` and ``symplectic`` are its traits.
    2. An adaptive method uses ``tolerance``: the absolute error allowed in a step, in scaled units, in which a
       granule's displacement and velocity are of order one. A method of fixed step uses ``size`` instead: the longest
       step, in scaled units of time. Each ignores the other's setting; ``first_size`` is a hint for adaptive methods.
    3. ``steps(acceleration, begin, until, x, v, first_size)`` yields accepted steps that join without gaps from
       ``begin`` and end exactly on ``until``. No stage lies outside ``[begin, until]``. Steps of fixed size are equal.
    4. The acceleration depends on time and positions only, and is smooth in time between the two. It is
       continuous in x, but its second derivative jumps where a contact opens. A granule's acceleration depends on
       the positions of itself and its two neighbours. The array it returns is new at every call.
    5. ``evaluations`` counts the calls of the acceleration since the object was made.
    6. Arrays given are not changed; arrays yielded are not changed afterwards, neither by the method nor by the caller.
    7. ``interpolate`` is as accurate as the step, to within a small factor, and holds for as long as the step is kept.
    8. A step that cannot be made raises `NumericalError`, never yields a NaN.
    9. The caller may stop taking steps at any time and start again with other arrays.

    A method that can try a step of any size from any state is a `OneStep`, which keeps most of this by itself.
    """

    name: ClassVar[str]
    order: ClassVar[int]
    adaptive: ClassVar[bool]
    symplectic: ClassVar[bool]

    tolerance: float = 1e-9
    size: float = 0.05
    evaluations: int = field(default=0, init=False)

    @abc.abstractmethod
    def steps(
        self,
        acceleration: Acceleration,
        begin: float,
        until: float,
        x: FloatArray,
        v: FloatArray,
        first_size: float | None,
    ) -> Iterator[Step]:
        """Accepted steps from ``begin`` to ``until``; see the contract."""

    @staticmethod
    def _first_size(interval: float, hint: float | None) -> float:
        """The first step of an adaptive method."""
        return min(_FIRST_STEP, _FIRST_SHARE * interval) if hint is None else min(hint, LONGEST_STEP, interval)


@frozen(eq=False)
class Counted:
    """An acceleration whose calls are counted; for a method that has its own code for it, ``acceleration`` itself."""

    integrator: Integrator
    acceleration: Acceleration
    until: float

    def __call__(self, time: float, x: FloatArray) -> FloatArray:
        self.integrator.evaluations += 1
        # begin + (until - begin) may be a rounding error beyond
        return self.acceleration(min(time, self.until), x)
