"""Velocity Verlet (Stoermer's method, leapfrog), the method of molecular dynamics and of discrete elements."""

from __future__ import annotations

from typing import ClassVar

from attrs import define

from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Acceleration
from shockwave.simulation.one_step import Attempt, OneStep, Scalar


@define
class Verlet(OneStep):
    """x + h v + h^2 a / 2, then v + h (a + a_end) / 2: one evaluation a step."""

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
