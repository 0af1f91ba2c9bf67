"""Embedded Runge-Kutta-Nystroem methods, which integrate x'' = a(t, x) directly."""

from __future__ import annotations

import json
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from types import ModuleType
from typing import ClassVar, Literal

import numpy as np
from attrs import define, field, frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.force_law import stiffening
from shockwave.engine.integrator import Acceleration
from shockwave.engine.one_step import Attempt, OneStep, Scalar
from shockwave.engine.scaled_problem import ChainAcceleration, overlaps
from shockwave.scene.chain import HERTZ

_NONE = np.empty(0)
# Error of a step in which a contact opens or closes, over its length and the force at the change of the overlap.
_KINK = 0.03
#: Exact coefficients by name of the method: nodes ``c``, rows ``a`` of the stages, weights ``b_prime`` of the velocity,
#: and ``error_b_prime``, their difference from those of the embedded method.
_EXACT = json.loads((Path(__file__).parent / "tableaux.json").read_text(encoding="utf-8"))


@frozen(eq=False)
class Tableau:
    """Coefficients in double precision.

    Attributes
    ----------
    nodes : array, shape (stages - 1,)
        c of each stage after the first, in units of the step; the last one is 1.
    stages : array, shape (stages, stages)
        a_ij, strictly lower triangular.
    weights : array, shape (4, stages)
        b and b' of position and velocity, and their differences from those of the embedded method.
    last_is_first : bool
        Whether the last stage is the acceleration at the end of the step, and so the first stage of the next step.
    columns : tuple of arrays, each of shape (n, 1)
        The nodes, and for each stage its coefficients in the sums to which it contributes: in later stages, in the
        position at the end if that is not the last stage, and in the other weights.
    packed : array
        One-dimensional array for the compiled code: number of stages, order of the embedded method, last_is_first, c,
        the square matrix a, and the weights.
    """

    nodes: FloatArray
    stages: FloatArray
    weights: FloatArray
    last_is_first: bool
    columns: tuple[FloatArray, ...]
    packed: FloatArray

    @property
    def evaluations(self) -> int:
        """Number of acceleration evaluations per step, excluding the one at its start."""
        return len(self.nodes) + (not self.last_is_first)

    def packed_for(self, exponent: float) -> FloatArray:
        """``packed``, followed by the exponent of the contact force if that is not Hertz's."""
        return self.packed if exponent == HERTZ else np.append(self.packed, exponent)

    @classmethod
    def of(cls, name: str, error_order: int) -> Tableau:
        """The tableau of a published method; its weights of the position are b_i = b'_i (1 - c_i)."""
        exact = _EXACT[name]
        nodes, velocity, excess = (_fractions(exact[key]) for key in ("c", "b_prime", "error_b_prime"))
        weights = np.array([velocity * (1 - nodes), velocity, excess * (1 - nodes), excess], dtype=float)
        c = nodes.astype(float)
        square = np.zeros((len(c), len(c)))
        for row, texts in enumerate(exact["a"]):
            square[row, : len(texts)] = _fractions(texts)
        last_is_first = bool(np.array_equal(square[-1], weights[0]))
        packed = np.concatenate([[len(c), error_order, last_is_first], c, square.ravel(), weights.ravel()])
        sums = np.concatenate((square[1:], weights[last_is_first:]))
        columns = [c[1:, None], *(sums[stage:, stage, None].copy() for stage in range(len(c)))]
        return cls(c[1:], square, weights, last_is_first, tuple(columns), packed)


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


def _fractions(texts: list[str]) -> np.ndarray:
    """Array of exact fractions."""
    return np.array([Fraction(text) for text in texts])


@define
class Nystroem(OneStep):
    """Base class of the embedded pairs.

    With step h and stages k_i at x_i = x + c_i h v + h^2 sum_j a_ij k_j, the new state is x + h v + h^2 sum_i b_i k_i
    and v + h sum_i b'_i k_i.
    """

    adaptive: ClassVar[bool] = True
    chains: ClassVar[Literal["equal", "conservative", "any"]] = "conservative"
    tableau: ClassVar[Tableau]
    #: Ratio of the tolerance of a step to the requested relative error of a peak force.
    caution: ClassVar[float] = 1.0

    #: The compiled module, or None for NumPy.
    compiled: ModuleType | None = field(default=None, repr=False)

    def attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        tried = self._attempt(acceleration, time, size, x, v, a)
        chain = getattr(acceleration, "acceleration", None)
        # the waves of an endless chain forget what happens to the granules behind them
        if not isinstance(chain, ChainAcceleration) or chain.problem.granules is None:
            return tried
        paths = [chain.problem.free(float(each))[0] if chain.driven else 0.0 for each in (time, time + size)]
        exponent = chain.problem.exponent
        error = kink(x, tried.x, paths, float(size), exponent) / self.tolerance
        # both velocity and length of the step make the change of the overlap
        limited = self.tolerance * error ** (1 / (exponent + 1) * (self.error_order + 1)) if error > 1 else 0.0
        return tried._replace(error=max(float(tried.error), limited))

    def _attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        chain = getattr(acceleration, "acceleration", None)
        if self.compiled is not None and isinstance(chain, ChainAcceleration):
            return self._compiled_attempt(self.compiled, chain, float(time), float(size), np.concatenate((x, v, a)))
        tableau = self.tableau
        columns = tableau.columns if x.ndim == 1 else [column[..., None] for column in tableau.columns]
        nodes, first, *later = columns
        square = size * size
        stages, rows = len(nodes), len(nodes) + len(first)
        work = np.empty((rows + len(first), *x.shape))
        coasting, sums, terms = work[:stages], work[stages:rows], work[rows:]
        np.multiply(nodes * size, v, out=coasting)
        coasting += x
        # Each acceleration is added to all sums that contain it, in the same order as in the compiled code: the results
        # are identical to the last bit.
        np.multiply(first, a, out=sums)
        for row, (node, column) in enumerate(zip(tableau.nodes.tolist(), later, strict=True)):
            end = square * sums[row]
            end += coasting[row]
            a = acceleration(time + node * size, end)
            left = sums[row + 1 :]
            left += np.multiply(column, a, out=terms[row + 1 :])
        if not tableau.last_is_first:
            end = coasting[-1] + square * sums[-4]
            a = acceleration(time + size, end)
        error_x, error_v = np.maximum.reduce(np.abs(sums[-2:]), axis=1)
        error = np.maximum(square * error_x, size * error_v)
        return Attempt(end, v + size * sums[-3], a, error)

    def _compiled_attempt(
        self, compiled: ModuleType, chain: ChainAcceleration, time: float, size: float, state: FloatArray
    ) -> Attempt:
        """`attempt` by compiled code, from a one-dimensional ``state`` of positions, velocities and accelerations."""
        problem = chain.problem
        tables = (problem.path.rows, problem.path.coefficients) if chain.driven else (_NONE, _NONE)
        after = np.empty_like(state)
        method = self.tableau.packed_for(problem.exponent)
        error = compiled.attempt(method, *tables, state, after, time, size, problem.rise_time, problem.peak_force)
        self.evaluations += self.tableau.evaluations
        x, v, a = after.reshape(3, -1)
        return Attempt(x, v, a, error)


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
