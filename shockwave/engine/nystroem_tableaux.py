"""Coefficients of the one-step methods, as those of general Nystroem methods for x'' = a(t, x, x').

A Runge-Kutta method (A, b, c) for x' = v, v' = a is a Nystroem method with the coefficients A^2 and b A of the
positions; the stages of the velocity use A. Methods for x'' = a(t, x) have none of these.
"""

from __future__ import annotations

import json
import math
from fractions import Fraction
from functools import cache, cached_property
from pathlib import Path

import numpy as np
from attrs import evolve, frozen

from shockwave.base.numerics import FloatArray
from shockwave.scene.chain import HERTZ

#: Exact coefficients by name of the method: nodes ``c``, rows ``a`` of the stages, weights ``b_prime`` of the velocity,
#: and ``error_b_prime``, their difference from those of the embedded method, if there is one.
_EXACT = json.loads((Path(__file__).parent / "tableaux.json").read_text(encoding="utf-8"))


@frozen(eq=False, slots=False)
class Tableau:
    """Coefficients in double precision, for s stages.

    Attributes
    ----------
    nodes : array, shape (s,)
        c of each stage, in units of the step.
    positions, velocities : array, shape (s, s)
        Strictly lower triangular; ``velocities`` is zero in a method for forces that do not depend on the velocity.
        If the node of stage 1 is zero, that is the derivative of the acceleration at the beginning, times the step.
    weights : array, shape (6, s)
        Weights of position and velocity, and the differences of both from those of one or two embedded methods; those
        of a method that there is not are zero.
    error_order : int
        The error estimate scales as the step to the power ``error_order + 1``; 0 if there is none.
    damped : bool
        Whether there are stages of the velocity.
    last_is_first : bool
        Whether the last stage is the acceleration at the end of the step, and so the first stage of the next step.
    """

    nodes: FloatArray
    positions: FloatArray
    velocities: FloatArray
    weights: FloatArray
    error_order: int
    damped: bool = False
    last_is_first: bool = False

    @classmethod
    def of(cls, name: str, error_order: int = 0) -> Tableau:
        """A published method for x'' = a(t, x); its weights of the position are b_i = b'_i (1 - c_i).

        Without rows it is symplectic: a_ij = b'_j (c_i - c_j).
        """
        exact = _EXACT[name]
        nodes, velocity = _fractions(exact["c"]), _fractions(exact["b_prime"])
        excess = _fractions(exact.get("error_b_prime", ["0"] * len(nodes)))
        positions = np.tril(velocity * (nodes[:, None] - nodes), -1)
        for row, texts in enumerate(exact.get("a", ())):
            positions[row, : len(texts)] = _fractions(texts)
        rest = 1 - nodes
        weights = [velocity * rest, velocity, excess * rest, excess, 0 * excess, 0 * excess]
        last_is_first = bool(np.array_equal(positions[-1], weights[0]))
        c, a, all_weights = (np.array(each, dtype=float) for each in (nodes, positions, weights))
        return cls(c, a, np.zeros_like(a), all_weights, error_order, last_is_first=last_is_first)

    @property
    def adaptive(self) -> bool:
        """Whether there is an error estimate; without one, the steps have a fixed size."""
        return self.error_order > 0

    @property
    def extends_to_velocities(self) -> bool:
        """Whether `with_velocities` gives a tableau that the engine can use."""
        return self.adaptive and self.last_is_first

    @property
    def evaluations(self) -> int:
        """Number of evaluations of the forces per step, excluding that at its beginning."""
        return len(self.nodes) - self.last_is_first - self.has_jerk

    @property
    def has_jerk(self) -> bool:
        """Whether stage 1 is the derivative of the acceleration at the beginning."""
        return bool(self.nodes[1] == 0)

    @cached_property
    def columns(self) -> tuple[FloatArray, ...]:
        """The nodes and 1, and for each stage its coefficients in the sums to which it contributes, each shape (n, 1).

        The sums are those of the positions, and velocities if there are stages of them, in the later stages, and of the
        weights, unless these are zero.
        """
        used = (self.positions, self.velocities)[: 1 + self.damped]
        weights = self.weights if self.weights[4:].any() else self.weights[:4]
        sums = np.concatenate((np.stack(used, axis=1)[1:].reshape(-1, len(self.nodes)), weights))
        stages = [sums[len(used) * stage :, stage, None].copy() for stage in range(len(self.nodes))]
        return np.append(self.nodes, 1.0)[:, None], *stages

    @cached_property
    def packed(self) -> FloatArray:
        """One-dimensional array for the compiled code of mixed chains."""
        head = [len(self.nodes), self.error_order, self.damped, self.last_is_first]
        # the end of a step is another stage
        stages = np.append(self.nodes, 1.0), np.vstack((self.positions, self.weights[0]))
        parts = (*stages, np.vstack((self.velocities, self.weights[1])), self.weights[2:])
        return np.concatenate([np.array(head, dtype=float), *(part.ravel() for part in parts)])

    @cached_property
    def _packed_alone(self) -> FloatArray:
        head = [len(self.nodes), self.error_order, self.last_is_first]
        return np.concatenate([head, self.nodes, self.positions.ravel(), self.weights[:4].ravel()])

    def pack_for(self, exponent: float) -> FloatArray:
        """One-dimensional array for the compiled code of equal chains, with the exponent of the contact force unless
        that is Hertz's.
        """
        return self._packed_alone if exponent == HERTZ else np.append(self._packed_alone, exponent)


def _fractions(texts: list[str]) -> np.ndarray:
    """Array of exact fractions."""
    return np.array([Fraction(text) for text in texts])


@cache
def with_velocities(pair: Tableau) -> Tableau:
    """The tableau of a pair for x'' = a(t, x) for forces that depend weakly on the velocities.

    The velocity of a stage is the integral of the polynomial with the accelerations so far, and with their derivative
    at the beginning, which takes the place of stage 1.
    """
    nodes, weights = np.insert(pair.nodes, 1, 0.0), np.insert(pair.weights, 1, 0.0, axis=1)
    positions = np.insert(np.insert(pair.positions, 1, 0.0, axis=0), 1, 0.0, axis=1)
    velocities = np.zeros_like(positions)
    for stage in range(2, len(nodes) - 1):
        powers = np.arange(stage)
        conditions = nodes[:stage] ** powers[:, None]
        conditions[:, 1] = powers == 1
        velocities[stage, :stage] = np.linalg.solve(conditions, nodes[stage] ** (powers + 1) / (powers + 1))
    velocities[-1] = weights[1]
    return evolve(pair, nodes=nodes, positions=positions, velocities=velocities, weights=weights, damped=True)


@cache
def dop853() -> Tableau:
    """The method of order 8 of Dormand & Prince with the error estimates of Hairer, Norsett & Wanner."""
    exact = json.loads((Path(__file__).parent / "dop853.json").read_text(encoding="utf-8"))
    nodes, b, b3, error5 = ([Fraction(text) for text in exact[key]] for key in ("c", "b", "b3", "error_b5"))
    stages = range(len(nodes))
    a = [[Fraction(text) for text in row] + [Fraction(0)] * (len(nodes) - len(row)) for row in exact["a"]]
    error3 = [one - other for one, other in zip(b, b3, strict=True)]

    def times_a(row: list[Fraction]) -> list[Fraction]:
        return [sum((row[k] * a[k][j] for k in stages), Fraction(0)) for j in stages]

    rows = [times_a(b), b, times_a(error5), error5, times_a(error3), error3]
    squared = [times_a(row) for row in a]
    c, positions, velocities, weights = (np.array(each, dtype=float) for each in (nodes, squared, a, rows))
    return Tableau(c, positions, velocities, weights, error_order=7, damped=True)


def scaled_error(first: float, second: float = 0.0) -> float:
    """Error of a step from those of one or two embedded methods (Hairer, Norsett & Wanner, eq. II.10.17)."""
    rough = 0.01 * second * second
    return first if rough == 0 else first * first / math.sqrt(first * first + rough)
