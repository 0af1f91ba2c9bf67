"""Integrators that use SciPy solvers of first-order systems, with the state (x, v)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, ClassVar

import numpy as np
import scipy.integrate
from attrs import define

from shockwave.base.errors import NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.engine.integrator import LONGEST_STEP, Acceleration, Counted, Integrator, Step, finite
from shockwave.engine.nystroem_tableaux import Tableau, dop853

# Smallest relative tolerance that SciPy accepts; the absolute tolerance controls the error.
_RELATIVE = 2.3e-14


@define
class ScipySolver(Integrator):
    """Base class; a subclass defines the solver and its order."""

    adaptive: ClassVar[bool] = True

    #: The class of `scipy.integrate.OdeSolver`.
    solver: ClassVar[Any]

    def _settings(self, granules: int) -> dict[str, Any]:
        """Additional arguments of the solver for this number of granules."""
        return {}

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

        # Without a first step SciPy searches for one, endlessly if the acceleration is not finite. Values are checked
        # after each step.
        with np.errstate(over="ignore", invalid="ignore"):
            solver = self.solver(
                derivative,
                begin,
                np.concatenate((x, v)),
                until,
                rtol=_RELATIVE,
                atol=self.tolerance,
                max_step=LONGEST_STEP,
                first_step=self.first_size(until - begin, first_size),
                **self._settings(granules),
            )
        solver.fun = derivative  # without the wrapper that counts calls and converts the result
        time = begin
        self._check(solver, time, None)
        while solver.status == "running":
            with np.errstate(over="ignore", invalid="ignore"):
                message = solver.step()
            self._check(solver, time, message)
            end, after, rate = float(solver.t), solver.y, solver.f
            interpolate = partial(_state_at, solver.dense_output())
            yield Step(time, end, after[:granules], after[granules:], rate[granules:], interpolate, solver.h_abs)
            time = end

    def _check(self, solver: Any, time: float, message: str | None) -> None:
        if message is not None or not finite(solver.y, solver.f):
            reason = message or "values are not finite"
            raise NumericalError(f"{self.name} cannot step beyond t = {time:g} T0 ({reason})")


def _state_at(interpolant: Callable[[float], FloatArray], time: float) -> tuple[FloatArray, FloatArray]:
    x, v = np.split(interpolant(time), 2)
    return x, v


@define
class Dop853(ScipySolver):
    """DOP853 of Hairer, Norsett & Wanner, of order 8 with dense output of order 7."""

    name: ClassVar[str] = "dop853"
    order: ClassVar[int] = 8
    tableau: ClassVar[Tableau | None] = dop853()
    solver = scipy.integrate.DOP853


@define
class Radau(ScipySolver):
    """Radau IIA of Hairer & Wanner, for stiff equations, with the sparse Jacobian of forces between neighbours."""

    name: ClassVar[str] = "radau"
    order: ClassVar[int] = 5
    solver = scipy.integrate.Radau

    def _settings(self, granules: int) -> dict[str, Any]:
        from scipy.sparse import block_array, diags_array

        shape = (granules, granules)
        velocities = diags_array([1.0], offsets=[0], shape=shape)
        neighbours = diags_array([1.0, 1.0, 1.0], offsets=[-1, 0, 1], shape=shape)
        return {"jac_sparsity": block_array([[None, velocities], [neighbours, None]], format="csc")}
