"""Base class of integrators of the equations of motion, and the steps that they yield."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, TypeAlias

import numpy as np
from attrs import define, field, frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.nystroem_tableaux import Tableau

# The time is a number, or an array of shape (batch,) if a method attempts a batch of steps.
Acceleration: TypeAlias = Callable[[Any, FloatArray], FloatArray]

#: In units of the characteristic time. A wave passes a granule in about one; longer steps would be rejected.
LONGEST_STEP = 1.0
# First step of an adaptive method, in characteristic times, and its largest fraction of the interval.
_FIRST_STEP = 0.05
_FIRST_SHARE = 1e-3


@frozen(eq=False)
class Step:
    """One accepted step of x'' = a(t, x).

    ``x``, ``v``, ``a`` are positions, velocities and accelerations at its ``end``, shape (granules,).
    ``interpolate(t)`` returns positions and velocities at any time in the step; ``next_size`` is the proposed size of
    the next step.
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
    1. ``name`` is the registered name of the class, ``order`` the order of its global error in the step size;
       ``adaptive`` states whether it chooses its steps.
    2. An adaptive method uses ``tolerance``, the absolute error allowed in a step, in scaled units, in which
       displacements and velocities are of order one. A method with a fixed step uses ``size`` instead, the longest
       step in scaled units of time. Each ignores the setting of the other; ``first_size`` is a hint for adaptive
       methods.
    3. ``steps(acceleration, begin, until, x, v, first_size)`` yields accepted steps without gaps, from ``begin`` to
       exactly ``until``. No stage lies outside ``[begin, until]``. Fixed steps have equal sizes.
    4. The acceleration depends on time and positions only, and is smooth in time between ``begin`` and ``until``. It
       is continuous in x, but its second derivative jumps where a contact opens. The acceleration of a granule depends
       on the positions of the granule and its two neighbours. Every call returns a new array.
    5. ``evaluations`` counts the calls of the acceleration since the object was created.
    6. Input arrays are not changed; yielded arrays are not changed afterwards, neither by the method nor by the caller.
    7. ``interpolate`` is as accurate as the step, within a small factor, and remains valid as long as the step exists.
    8. A step that cannot be computed raises `NumericalError`; no step contains a NaN.
    9. The caller may abandon the iteration at any time and start again with other arrays.

    A method that can attempt a step of any size from any state is a `OneStep`, which fulfils most of this contract.
    """

    name: ClassVar[str]
    order: ClassVar[int]
    adaptive: ClassVar[bool]
    #: Coefficients that describe the method entirely, with which the engine takes the steps itself: these can end where
    #: contacts begin to flow and, if the coefficients include velocities, damping is possible.
    tableau: ClassVar[Tableau | None] = None

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

    @classmethod
    def coefficients(cls) -> Tableau | None:
        """The ``tableau`` of the class itself: one that is derived from it may step otherwise."""
        tableau: Tableau | None = vars(cls).get("tableau")
        return tableau

    @classmethod
    def refusal(cls, damped: bool, plastic: bool, rate: bool) -> str:
        """Reason why the method cannot integrate a chain with these kinds of forces; empty if it can.

        ``damped`` states whether forces depend on velocities at all times, ``rate`` whether they do in plastic flow.
        """
        tableau, got = cls.coefficients(), f"(got {cls.name!r}, "
        only = f"{got}which is only for forces that do not depend on velocities)"
        if damped and not (tableau and tableau.damped):
            kind = "with damping, a dashpot or a bar at its end, or a contact law of a plugin"
            return f"must be dop853 for a chain {kind} {only}"
        if rate and not (tableau and (tableau.damped or tableau.extends_to_velocities)):
            return f"must be rkn64, rkn86 or dop853 for a chain with rate-dependent plastic flow {only}"
        if plastic and not tableau:
            known = "rkn64, rkn86, rkn1210, verlet, pefrl, rk4 or dop853 for elastic-plastic contacts"
            return f"must be {known} {got}whose steps do not end where plastic flow begins)"
        return ""

    @staticmethod
    def first_size(interval: float, hint: float | None) -> float:
        """Size of the first step of an adaptive method."""
        return min(_FIRST_STEP, _FIRST_SHARE * interval) if hint is None else min(hint, LONGEST_STEP, interval)


@frozen(eq=False)
class Counted:
    """An acceleration that counts its calls."""

    integrator: Integrator
    acceleration: Acceleration
    until: float

    def __call__(self, time: float, x: FloatArray) -> FloatArray:
        self.integrator.evaluations += 1
        # begin + (until - begin) may exceed until by a rounding error; arithmetic with NumPy's scalars is slow
        return self.acceleration(min(float(time), self.until), x)


def finite(*arrays: FloatArray) -> bool:
    """Whether all values and their sums of squares are finite."""
    # faster than np.isfinite for each value
    return all(map(math.isfinite, [np.vdot(array, array) for array in arrays]))
