"""The Dormand-Prince method of order 8 with its dense output of order 7, from SciPy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from attrs import define
from scipy.integrate import DOP853

from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Acceleration, Integrator, Step

__all__ = ["Dop853"]

# SciPy's least: the error is to be absolute, in units in which a wave is of order one.
_RELATIVE = 2.3e-14
# A granule is passed by a wave in about one unit of time; longer steps only provoke rejections.
_LONGEST_STEP = 1.0


@define
class Dop853(Integrator):
    """Hairer, Norsett & Wanner's DOP853, adaptive; the equations are taken as a first-order system."""

    name: ClassVar[str] = "dop853"
    order: ClassVar[int] = 8
    adaptive: ClassVar[bool] = True
    symplectic: ClassVar[bool] = False

    def steps(
        self,
        acceleration: Acceleration,
        begin: float,
        until: float,
        x: FloatArray,
        v: FloatArray,
        first_size: float | None,
    ) -> Iterator[Step]:
        granules = len(x)

        def derivative(time: float, state: FloatArray) -> FloatArray:
            self.evaluations += 1
            return np.concatenate((state[granules:], acceleration(time, state[:granules])))

        solver = DOP853(
            derivative,
            begin,
            np.concatenate((x, v)),
            until,
            rtol=_RELATIVE,
            atol=self.tolerance,
            max_step=_LONGEST_STEP,
            first_step=None if first_size is None else min(first_size, until - begin),
        )
        while solver.status == "running":
            message = solver.step()
            if message is not None or not np.all(np.isfinite(solver.y)):
                raise NumericalError(f"{self.name} cannot step beyond t = {solver.t:g} T0 ({message or 'not finite'})")
            dense = solver.dense_output()

            def interpolate(time: float, dense: object = dense) -> tuple[FloatArray, FloatArray]:
                state = dense(time)  # type: ignore[operator]
                return state[:granules], state[granules:]

            state = solver.y
            yield Step(
                float(solver.t_old or begin),
                float(solver.t),
                state[:granules],
                state[granules:],
                interpolate,
                solver.h_abs,
            )
