"""The classical Runge-Kutta method."""

from __future__ import annotations

from typing import ClassVar

from attrs import define

from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Acceleration
from shockwave.simulation.one_step import Attempt, OneStep, Scalar


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
