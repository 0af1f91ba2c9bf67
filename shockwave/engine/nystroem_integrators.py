"""Runge-Kutta-Nystroem methods, which integrate x'' = a(t, x) directly: embedded pairs, and some with a fixed step."""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType
from typing import ClassVar

import numpy as np
from attrs import define, field

from shockwave.base.numerics import FloatArray
from shockwave.engine.force_law import stiffening
from shockwave.engine.integrator import Acceleration
from shockwave.engine.nystroem_tableaux import Tableau
from shockwave.engine.one_step import Attempt, OneStep, Scalar
from shockwave.engine.scaled_problem import overlaps

# Error of a step in which a contact opens or closes, over its length and the force at the change of the overlap.
_KINK = 0.03


def kink(x: FloatArray, end: FloatArray, paths: Sequence[float], size: float, exponent: float) -> float:
    """Error of a step from ``x`` to ``end`` due to contacts that open or close.

    The force has no second derivative there, which the embedded method may not detect. ``paths`` are the free-particle
    displacements of the first granule at both ends.
    """
    before, after = overlaps(x), overlaps(end)
    before[0] += paths[0]
    after[0] += paths[1]
    change = float(np.abs(after - before)[before * after < 0].max(initial=0.0))
    return _KINK * change * stiffening(change, exponent) * size


@define
class Nystroem(OneStep):
    """Base class; a subclass declares its ``tableau``.

    With step h and stages k_i at x_i = x + c_i h v + h^2 sum_j a_ij k_j, the new state is x + h v + h^2 sum_i b_i k_i
    and v + h sum_i b'_i k_i.
    """

    adaptive: ClassVar[bool] = True
    tableau: ClassVar[Tableau]
    #: Ratio of the tolerance of a step to the requested relative error of a peak force.
    caution: ClassVar[float] = 1.0

    #: The compiled module, or None for NumPy.
    compiled: ModuleType | None = field(default=None, repr=False)

    def attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        tableau = self.tableau
        columns = tableau.columns if x.ndim == 1 else [column[..., None] for column in tableau.columns]
        nodes, first, *later = columns
        square = size * size
        rows = len(first)
        work = np.empty((len(nodes) + 2 * rows, *x.shape))
        coasting, sums, terms = work[: len(nodes)], work[len(nodes) : -rows], work[-rows:]
        np.multiply(nodes * size, v, out=coasting)
        coasting += x
        # Each acceleration is added to all sums that contain it, in the same order as in the compiled code: the results
        # are identical to the last bit.
        np.multiply(first, a, out=sums)
        for row, (node, column) in enumerate(zip(tableau.nodes[1:].tolist(), later, strict=True)):
            end = square * sums[row]
            end += coasting[row + 1]
            a = acceleration(time + node * size, end)
            left = sums[row + 1 :]
            left += np.multiply(column, a, out=terms[row + 1 :])
        if not tableau.last_is_first:
            end = coasting[-1] + square * sums[-4]
            a = acceleration(time + size, end)
        error_x, error_v = np.maximum.reduce(np.abs(sums[-2:]), axis=1)
        error = np.maximum(square * error_x, size * error_v)
        return Attempt(end, v + size * sums[-3], a, error)


@define
class Rkn64(Nystroem):
    """RKN6(4)6FM of Dormand & Prince; five evaluations per step."""

    name: ClassVar[str] = "rkn64"
    order: ClassVar[int] = 6
    error_order: ClassVar[int] = 4
    tableau: ClassVar[Tableau] = Tableau.of(name, error_order)
    caution: ClassVar[float] = 0.2


@define
class Rkn86(Nystroem):
    """RKN8(6)9FM of Dormand, El-Mikkawy & Prince; eight evaluations per step."""

    name: ClassVar[str] = "rkn86"
    order: ClassVar[int] = 8
    error_order: ClassVar[int] = 6
    tableau: ClassVar[Tableau] = Tableau.of(name, error_order)


@define
class Rkn1210(Nystroem):
    """RKN12(10)17M of Dormand, El-Mikkawy & Prince, for tight tolerances; seventeen evaluations per step."""

    name: ClassVar[str] = "rkn1210"
    order: ClassVar[int] = 12
    error_order: ClassVar[int] = 10
    tableau: ClassVar[Tableau] = Tableau.of(name, error_order)
    caution: ClassVar[float] = 0.2


@define
class Verlet(Nystroem):
    """Velocity Verlet (Stoermer's method), as used in molecular dynamics and discrete element codes.

    x + h v + h^2 a / 2, then v + h (a + a_end) / 2. One evaluation per step.
    """

    name: ClassVar[str] = "verlet"
    order: ClassVar[int] = 2
    adaptive: ClassVar[bool] = False
    tableau: ClassVar[Tableau] = Tableau.of(name)


@define
class Pefrl(Nystroem):
    """Position-extended Forest-Ruth-like method of Omelyan, Mryglod & Folk, Comput. Phys. Commun. 146 (2002) 188.

    Alternating drifts and kicks; one more kick than in the method of Forest & Ruth makes the error much smaller. Four
    evaluations per step, and one for the acceleration at its end.
    """

    name: ClassVar[str] = "pefrl"
    order: ClassVar[int] = 4
    adaptive: ClassVar[bool] = False
    tableau: ClassVar[Tableau] = Tableau.of(name)


@define
class Rk4(Nystroem):
    """Classical Runge-Kutta method for x' = v, v' = a(t, x), with explicit stages of x. Four evaluations per step."""

    name: ClassVar[str] = "rk4"
    order: ClassVar[int] = 4
    adaptive: ClassVar[bool] = False
    tableau: ClassVar[Tableau] = Tableau.of(name)
