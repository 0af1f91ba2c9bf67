"""Methods of fixed step: velocity Verlet, PEFRL and the classical Runge-Kutta method."""

from __future__ import annotations

from typing import ClassVar

from attrs import define

from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Acceleration
from shockwave.simulation.one_step import Attempt, OneStep, Scalar

_XI = 0.1786178958448091
_LAMBDA = -0.2123418310626054
_CHI = -0.06626458266981849
# Shares of the step, in turn of the path and of the velocity; the method is its own mirror image. The last kick
# is none: the acceleration there is that at the end.
_DRIFTS = (_XI, _CHI, 1 - 2 * (_CHI + _XI), _CHI, _XI)
_KICKS = (0.5 - _LAMBDA, _LAMBDA, _LAMBDA, 0.5 - _LAMBDA, 0.0)


@define
class Verlet(OneStep):
    """Velocity Verlet (Stoermer's method, leapfrog), the method of molecular dynamics and of discrete elements.

    x + h v + h^2 a / 2, then v + h (a + a_end) / 2: one evaluation a step.
    """

    name: ClassVar[str] = "verlet"
    order: ClassVar[int] = 2
    adaptive: ClassVar[bool] = False
    symplectic: ClassVar[bool] = True

    def attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        half = v + size / 2 * a
        x = x + size * half
        a = acceleration(time + size, x)
        return Attempt(x, half + size / 2 * a, a, 0.0)


@define
class Pefrl(OneStep):
    """The position-extended Forest-Ruth-like method of Omelyan, Mryglod & Folk, Comput. Phys. Commun. 146 (2002) 188.

    Drifts and kicks in turn: one kick more than Forest & Ruth's method, for a far smaller error. Four evaluations a
    step, and one for the acceleration at its end.
    """

    name: ClassVar[str] = "pefrl"
    order: ClassVar[int] = 4
    adaptive: ClassVar[bool] = False
    symplectic: ClassVar[bool] = True

    def attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        passed = 0.0
        for drift, kick in zip(_DRIFTS, _KICKS, strict=True):
            passed += drift
            x = x + drift * size * v
            a = acceleration(time + passed * size, x)
            v = v + kick * size * a
        return Attempt(x, v, a, 0.0)


@define
class Rk4(OneStep):
    """Kutta's method for x' = v, v' = a(t, x), with the stages of x' = v written out: four evaluations a step."""

    name: ClassVar[str] = "rk4"
    order: ClassVar[int] = 4
    adaptive: ClassVar[bool] = False
    symplectic: ClassVar[bool] = False

    def attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        middle, half = time + size / 2, x + size / 2 * v
        a2 = acceleration(middle, half)
        a3 = acceleration(middle, half + size**2 / 4 * a)
        a4 = acceleration(time + size, x + size * v + size**2 / 2 * a2)
        x = x + size * v + size**2 / 6 * (a + a2 + a3)
        v = v + size / 6 * (a + 2 * a2 + 2 * a3 + a4)
        return Attempt(x, v, acceleration(time + size, x), 0.0)
