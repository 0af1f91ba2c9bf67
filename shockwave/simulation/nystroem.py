"""Embedded Runge-Kutta-Nystroem methods: x'' = a(t, x) is taken as it stands, no stage is spent on x' = v."""

from __future__ import annotations

from types import ModuleType
from typing import ClassVar

import numpy as np
from attrs import define, field, frozen

from shockwave.quadrature import FloatArray
from shockwave.simulation.integrator import Acceleration
from shockwave.simulation.one_step import Attempt, OneStep, Scalar
from shockwave.simulation.problem import ChainAcceleration
from shockwave.simulation.tableaux import RKN64, RKN86, RKN1210, Fractions

_NONE = np.empty(0)


@frozen(eq=False)
class Tableau:
    """Coefficients in double precision.

    Attributes
    ----------
    nodes : array, shape (stages - 1,)
        c of each stage after the first, in units of the step; the last is 1.
    stages : tuple of arrays
        a_i1, ..., a_i,i-1 of each stage after the first.
    weights : array, shape (4, stages)
        b and b' of position and velocity, and their excess over those of the embedded method.
    last_is_first : bool
        Whether the last stage is the acceleration at the end, hence the first stage of the next step.
    packed : array
        All of it in a row, for the compiled code: number of stages, order of the embedded method, last_is_first, c, a
        as a square, the weights.
    """

    nodes: FloatArray
    stages: tuple[FloatArray, ...]
    weights: FloatArray
    last_is_first: bool
    packed: FloatArray

    @property
    def evaluations(self) -> int:
        """Evaluations of the acceleration in a step, that at its begin not counted."""
        return len(self.nodes) + (not self.last_is_first)

    @classmethod
    def of(cls, exact: Fractions, error_order: int) -> Tableau:
        """The tableau of exact fractions."""
        nodes = np.array(_numbers(exact.c))
        stages = [np.array(_numbers(row)) for row in exact.a]
        velocity = np.array([_numbers(text) for text in (exact.b_prime, exact.error_b_prime)])
        position = np.array([_numbers(text, exact.c) for text in (exact.b_prime, exact.error_b_prime)])
        weights = np.stack((position, velocity), axis=1).reshape(4, -1)
        last_is_first = bool(np.array_equal([*stages[-1], 0.0], weights[0]))
        square = np.zeros((len(nodes), len(nodes)))
        for row, stage in enumerate(stages):
            square[row, : len(stage)] = stage
        packed = np.concatenate([[len(nodes), error_order, last_is_first], nodes, square.ravel(), weights.ravel()])
        return cls(nodes[1:], tuple(stages[1:]), weights, last_is_first, packed)


def _numbers(text: str, remaining: str = "") -> list[float]:
    """Fractions in double precision; each b is multiplied with 1 - c where the nodes c are given as ``remaining``."""
    numbers = _fractions(text)
    if remaining:
        nodes = _fractions(remaining)
        numbers = [(n * (below - above), d * below) for (n, d), (above, below) in zip(numbers, nodes, strict=True)]
    # A quotient of Python's integers, however long, is rounded once.
    return [numerator / denominator for numerator, denominator in numbers]


def _fractions(text: str) -> list[tuple[int, int]]:
    parts = (number.partition("/") for number in text.split())
    return [(int(above), int(below or 1)) for above, _, below in parts]


@define
class Nystroem(OneStep):
    """Base class of the embedded pairs; with step h and stages k_i at x_i = x + c_i h v + h^2 sum_j a_ij k_j,

    they lead to x + h v + h^2 sum_i b_i k_i and v + h sum_i b'_i k_i.
    """

    adaptive: ClassVar[bool] = True
    symplectic: ClassVar[bool] = False
    tableau: ClassVar[Tableau]
    #: Tolerance of a step over the relative error that is asked of a peak force.
    caution: ClassVar[float] = 1.0

    #: The compiled module, to step a chain with, or None.
    compiled: ModuleType | None = field(default=None, repr=False)
    _work: FloatArray = field(factory=lambda: np.empty(0), init=False, repr=False)

    def attempt(
        self, acceleration: Acceleration, time: Scalar, size: Scalar, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        chain = getattr(acceleration, "acceleration", None)
        if self.compiled is not None and isinstance(chain, ChainAcceleration):
            return self._compiled_attempt(chain, float(time), float(size), x, v, a)
        tableau = self.tableau
        shape = (len(tableau.nodes) + 1, *x.shape)
        if self._work.shape != (2, *shape):
            self._work = np.empty((2, *shape))
        rates, terms = self._work
        column = (-1,) + (1,) * x.ndim
        square = size * size
        # Sums run term after term, as in the compiled code: the two agree to the last bit.
        coasting = x + tableau.nodes.reshape(column) * size * v
        rates[0] = a
        for row, weights in enumerate(tableau.stages, start=1):
            np.multiply(rates[:row], weights.reshape(column), out=terms[:row])
            end = np.add.reduce(terms[:row], axis=0)
            end *= square
            end += coasting[row - 1]
            a = rates[row] = acceleration(time + tableau.nodes[row - 1] * size, end)
        position, velocity, error_x, error_v = np.add.reduce(tableau.weights.reshape(4, *column) * rates, axis=1)
        end = coasting[-1] + square * position
        if not tableau.last_is_first:
            a = acceleration(time + size, end)
        error = np.maximum(np.abs(square * error_x), np.abs(size * error_v)).max(axis=0)
        return Attempt(end, v + size * velocity, a, error)

    def _compiled_attempt(
        self, chain: ChainAcceleration, time: float, size: float, x: FloatArray, v: FloatArray, a: FloatArray
    ) -> Attempt:
        self.evaluations += self.tableau.evaluations
        problem = chain.problem
        state = np.concatenate((x, v, a))
        after = np.empty_like(state)
        rows, coefficients = (problem.path.rows, problem.path.coefficients) if chain.driven else (_NONE, _NONE)
        assert self.compiled is not None
        error = self.compiled.attempt(
            self.tableau.packed, rows, coefficients, state, after, time, size, problem.rise_time, problem.peak_force
        )
        x, v, a = after.reshape(3, -1)
        return Attempt(x, v, a, error)


@define
class Rkn64(Nystroem):
    """RKN6(4)6FM of Dormand & Prince: five evaluations a step."""

    name: ClassVar[str] = "rkn64"
    order: ClassVar[int] = 6
    error_order: ClassVar[int] = 4
    tableau: ClassVar[Tableau] = Tableau.of(RKN64, error_order)
    caution: ClassVar[float] = 0.2


@define
class Rkn86(Nystroem):
    """RKN8(6)9FM of Dormand, El-Mikkawy & Prince: eight evaluations a step."""

    name: ClassVar[str] = "rkn86"
    order: ClassVar[int] = 8
    error_order: ClassVar[int] = 6
    tableau: ClassVar[Tableau] = Tableau.of(RKN86, error_order)


@define
class Rkn1210(Nystroem):
    """RKN12(10)17M of Dormand, El-Mikkawy & Prince: seventeen evaluations a step, for tight tolerances."""

    name: ClassVar[str] = "rkn1210"
    order: ClassVar[int] = 12
    error_order: ClassVar[int] = 10
    tableau: ClassVar[Tableau] = Tableau.of(RKN1210, error_order)
    caution: ClassVar[float] = 0.2
