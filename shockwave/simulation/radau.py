"""The implicit Radau IIA method of order 5, from SciPy."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

from attrs import define
from scipy.integrate import Radau as SciPyRadau
from scipy.sparse import block_array, diags_array

from shockwave.simulation.scipy_solver import ScipySolver

__all__ = ["Radau"]


@define
class Radau(ScipySolver):
    """Hairer & Wanner's Radau IIA, for stiff equations; forces between neighbours make its Jacobian sparse."""

    name: ClassVar[str] = "radau"
    order: ClassVar[int] = 5

    def _solver(self, granules: int) -> Callable[..., Any]:
        shape = (granules, granules)
        velocities = diags_array([1.0], offsets=[0], shape=shape)
        neighbours = diags_array([1.0, 1.0, 1.0], offsets=[-1, 0, 1], shape=shape)
        return partial(SciPyRadau, jac_sparsity=block_array([[None, velocities], [neighbours, None]], format="csc"))
