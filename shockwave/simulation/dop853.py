"""DOP853 from SciPy, a solver of first-order systems, as an integrator: the state is (x, v)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np
import scipy.integrate
from attrs import define

from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import LONGEST_STEP, Acceleration, Counted, Integrator, Step

# SciPy's least: the error is to be absolute, in units in which a wave is of order one.
_RELATIVE = 2.3e-14


@define
class Dop853(Integrator):
    """Hairer, Norsett & Wanner's DOP853, of order 8 with dense output of order 7."""

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
        counted = Counted(self, acceleration, until)

        def derivative(time: float, state: FloatArray) -> FloatArray:
            return np.concatenate((state[granules:], counted(time, state[:granules])))

        # Without a first step SciPy looks for one, and never ends where the acceleration is not finite; what is not
        # finite is looked for afterwards.
        first = self._first_size(until - begin, first_size)
        state = np.concatenate((x, v))
        with np.errstate(over="ignore", invalid="ignore"):
            solver = scipy.integrate.DOP853(
                derivative, begin, state, until, LONGEST_STEP, _RELATIVE, self.tolerance, first_step=first
            )
        time = begin
        self._check(solver, time, None)
        while solver.status == "running":
            with np.errstate(over="ignore", invalid="ignore"):
                message = solver.step()
            self._check(solver, time, message)
            dense = solver.dense_output()

            def interpolate(time: float, dense: Any = dense) -> tuple[FloatArray, FloatArray]:
                state = dense(time)
                return state[:granules], state[granules:]

            end, state, rate = float(solver.t), solver.y, solver.f
            yield Step(time, end, state[:granules], state[granules:], rate[granules:], interpolate, solver.h_abs)
            time = end

    def _check(self, solver: Any, time: float, message: str | None) -> None:
        if message is not None or not np.all(np.isfinite((solver.y, solver.f))):
            raise NumericalError(f"{self.name} cannot step beyond t = {time:g} T0 ({message or 'not finite'})")
