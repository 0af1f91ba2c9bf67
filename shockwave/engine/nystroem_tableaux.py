"""Coefficients of the one-step methods for chains of mixed granules, x'' = a(t, x, x').

A Runge-Kutta method (A, b, c) for x' = v, v' = a is a Nystroem method with the coefficients A^2 and b A of the
positions; the stages of the velocity use A. The pairs for x'' = a(t, x) have none of these.
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
from shockwave.engine.nystroem_integrators import Nystroem


@frozen(eq=False, slots=False)
class GeneralTableau:
    """Coefficients in double precision, for s stages.

    Attributes
    ----------
    nodes : array, shape (s,)
    positions, velocities : array, shape (s, s)
        Strictly lower triangular; ``velocities`` is zero in a method for forces that do not depend on the velocity.
        If the node of stage 1 is zero, that is the derivative of the acceleration at the beginning, times the step.
    weights : array, shape (6, s)
        Weights of position and velocity, and the differences of both from those of one or two embedded methods; those
        of the second are zero if there is only one.
    error_order : int
        The error estimate scales as the step to the power ``error_order + 1``.
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
    damped: bool
    last_is_first: bool = False

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
        """One-dimensional array for the compiled code."""
        head = [len(self.nodes), self.error_order, self.damped, self.last_is_first]
        # the end of a step is another stage
        stages = np.append(self.nodes, 1.0), np.vstack((self.positions, self.weights[0]))
        parts = (*stages, np.vstack((self.velocities, self.weights[1])), self.weights[2:])
        return np.concatenate([np.array(head, dtype=float), *(part.ravel() for part in parts)])


@cache
def of_nystroem(method: type[Nystroem]) -> GeneralTableau:
    """The tableau of a pair for x'' = a(t, x)."""
    tableau = method.tableau
    weights = np.concatenate((tableau.weights, np.zeros_like(tableau.weights[:2])))
    nodes = np.append(0.0, tableau.nodes)
    none = np.zeros_like(tableau.stages)
    last = tableau.last_is_first
    return GeneralTableau(nodes, tableau.stages, none, weights, method.error_order, damped=False, last_is_first=last)


@cache
def with_velocities(method: type[Nystroem]) -> GeneralTableau:
    """The tableau of a pair for x'' = a(t, x) for forces that depend weakly on the velocities.

    The velocity of a stage is the integral of the polynomial with the accelerations so far, and with their derivative
    at the beginning, which takes the place of stage 1.
    """
    pair = of_nystroem(method)
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
def dop853() -> GeneralTableau:
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
    return GeneralTableau(c, positions, velocities, weights, error_order=7, damped=True)


def scaled_error(first: float, second: float = 0.0) -> float:
    """Error of a step from those of one or two embedded methods (Hairer, Norsett & Wanner, eq. II.10.17)."""
    rough = 0.01 * second * second
    return first if rough == 0 else first * first / math.sqrt(first * first + rough)
