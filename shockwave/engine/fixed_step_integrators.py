"""Methods with a fixed step size: velocity Verlet, PEFRL and the classical Runge-Kutta method."""

from __future__ import annotations

from typing import ClassVar

from attrs import define

from shockwave.base.numerics import FloatArray
from shockwave.engine.integrator import Acceleration
from shockwave.engine.one_step import Attempt, OneStep, Scalar

# Coefficients of PEFRL (Omelyan, Mryglod & Folk 2002, eq. 20), dimensionless.
_XI = 0.1786178958448091
_LAMBDA = -0.2123418310626054
_CHI = -0.06626458266981849
# Fractions of the step in the alternating drifts and kicks; the method is symmetric. The last kick is zero: it only
# evaluates the acceleration at the end of the step.
_DRIFTS = (_XI, _CHI, 1 - 2 * (_CHI + _XI), _CHI, _XI)
_KICKS = (0.5 - _LAMBDA, _LAMBDA, _LAMBDA, 0.5 - _LAMBDA, 0.0)


@define
class Verlet(OneStep):
    """Velocity Verlet (Stoermer's method), as used in molecular dynamics and discrete element codes.

    x + h v + h^2 a / 2, then v + h (a + a_end) / 2. One evaluation per step.
    """

    name: ClassVar[str] = "verlet"
    order: ClassVar[int] = 2
    adaptive: ClassVar[bool] = False

    def attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        half = v + size / 2 * a
        x = x + size * half
        a = acceleration(time + size, x)
        return Attempt(x, half + size / 2 * a, a, 0.0)


@define
class Pefrl(OneStep):
    """Position-extended Forest-Ruth-like method of Omelyan, Mryglod & Folk, Comput. Phys. Commun. 146 (2002) 188.

    Alternating drifts and kicks; one more kick than in the method of Forest & Ruth makes the error much smaller. Four
    evaluations per step, and one for the acceleration at its end.
    """

    name: ClassVar[str] = "pefrl"
    order: ClassVar[int] = 4
    adaptive: ClassVar[bool] = False

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
    """Classical Runge-Kutta method for x' = v, v' = a(t, x), with explicit stages of x. Four evaluations per step."""

    name: ClassVar[str] = "rk4"
    order: ClassVar[int] = 4
    adaptive: ClassVar[bool] = False

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
