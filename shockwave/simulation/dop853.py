"""The Dormand-Prince method of order 8 with its dense output of order 7, from SciPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from attrs import define
from scipy.integrate import DOP853

from shockwave.simulation.scipy_solver import ScipySolver

__all__ = ["Dop853"]


@define
class Dop853(ScipySolver):
    """Hairer, Norsett & Wanner's DOP853; the equations are taken as a first-order system."""

    name: ClassVar[str] = "dop853"
    order: ClassVar[int] = 8

    def _solver(self, granules: int) -> Callable[..., Any]:
        return DOP853
