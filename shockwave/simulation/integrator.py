"""What an integrator of the equations of motion is."""

from __future__ import annotations

import abc
from collections.abc import Callable, Iterator
from typing import ClassVar, TypeAlias

from attrs import define, field, frozen

from shockwave.quadrature import FloatArray

__all__ = ["Acceleration", "Integrator", "Step"]

Acceleration: TypeAlias = Callable[[float, FloatArray], FloatArray]


@frozen(eq=False)
class Step:
    """One accepted step of x'' = a(t, x).

    ``x``, ``v`` are positions and velocities at its ``end``, shape (granules,); ``interpolate(t)`` gives both
    anywhere within it; ``next_size`` is the step that the method would take next.
    """

    begin: float
    end: float
    x: FloatArray
    v: FloatArray
    interpolate: Callable[[float], tuple[FloatArray, FloatArray]]
    next_size: float


@define
class Integrator(abc.ABC):
    """Base class of integrators.

    Contract for implementers
    -------------------------
    1. ``name`` is the name under which the class is registered; ``order`` the order of its global error in
       the step size; ``adaptive`` and ``symplectic`` are its traits.
    2. ``tolerance`` is the absolute error allowed in a step, in scaled units, in which a granule's displacement
       and velocity are of order one.
    3. ``steps(acceleration, begin, until, x, v, first_size)`` yields accepted steps that join without gaps from
       ``begin`` and end exactly on ``until``. No stage lies outside ``[begin, until]``.
    4. The acceleration depends on time and positions only, and is smooth in time between the two. It is
       continuous in x, but its second derivative jumps where a contact opens.
    5. ``evaluations`` counts the calls of the acceleration since the object was made.
    6. Arrays given are not changed; arrays yielded are not changed afterwards.
    7. ``interpolate`` is as accurate as the step, to within a small factor.
    8. A step that cannot be made raises `NumericalError`, never yields a NaN.
    9. The caller may stop taking steps at any time and start again with other arrays.
    """

    name: ClassVar[str]
    order: ClassVar[int]
    adaptive: ClassVar[bool]
    symplectic: ClassVar[bool]

    tolerance: float = 1e-9
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
