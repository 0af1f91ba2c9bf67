"""Velocity Verlet with Richardson extrapolation, after Stoermer, Gragg, Bulirsch & Stoer."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import prod
from typing import ClassVar

import numpy as np
from attrs import define
from shockwave.hooks import Acceleration, Attempt, FloatArray, OneStep

__all__ = ["VerletRichardson", "extrapolation"]


def extrapolation(counts: Sequence[int]) -> tuple[Fraction, ...]:
    """Weights of the results with n_j substeps, for the extrapolation to substeps of length 0.

    They follow from the scheme of Aitken and Neville for a polynomial in h^2:

        w_j = product over i != j of n_j^2 / (n_j^2 - n_i^2).

    Parameters
    ----------
    counts : sequence of int
        The n_j, positive and distinct.
    """
    squares = [Fraction(count**2) for count in counts]
    return tuple(prod((n / (n - m) for m in squares if m != n), start=Fraction(1)) for n in squares)


_COUNTS = (1, 2, 3, 4)
_WEIGHTS = tuple(map(float, extrapolation(_COUNTS)))
# Weights of the error estimate T_44 - T_43.
_ERRORS = tuple(
    float(all_four - three)
    for all_four, three in zip(
        extrapolation(_COUNTS), (Fraction(0), *extrapolation(_COUNTS[1:])), strict=True
    )
)


@define
class VerletRichardson(OneStep):
    """Verlet with 1, 2, 3 and 4 substeps, extrapolated to substeps of length 0: order 8, 11 evaluations.

    Verlet is time-symmetric, so the errors of positions and velocities are series in h^2, and each result
    adds two orders. The error estimate is the difference from the extrapolation without the undivided step,
    which has order 6.

    References
    ----------
    Hairer, E., Norsett, S. P. & Wanner, G. (1993). Solving Ordinary Differential Equations I, 2nd ed.,
    sections II.9 and II.14. Springer.
    """

    name: ClassVar[str] = "verlet-richardson"
    order: ClassVar[int] = 8
    error_order: ClassVar[int] = 6
    adaptive: ClassVar[bool] = True

    def attempt(
        self,
        acceleration: Acceleration,
        time: float | FloatArray,
        size: float | FloatArray,
        x: FloatArray,
        v: FloatArray,
        a: FloatArray,
    ) -> Attempt:
        moved, error = np.zeros_like([x, v]), np.zeros_like([x, v])
        for count, weight, change in zip(_COUNTS, _WEIGHTS, _ERRORS, strict=True):
            move = _moved(acceleration, time, size, count, x, v, a)
            moved += weight * move
            error += change * move
        x, v = x + moved[0], v + moved[1]
        return Attempt(x, v, acceleration(time + size, x), np.abs(error).max(axis=(0, 1)))


def _moved(
    acceleration: Acceleration,
    time: float | FloatArray,
    size: float | FloatArray,
    count: int,
    x: FloatArray,
    v: FloatArray,
    a: FloatArray,
) -> FloatArray:
    """Change of positions and velocities by ``count`` steps of Verlet, shape (2, *x.shape)."""
    part = size / count
    # the changes are summed separately, so that the weights do not amplify rounding of the state
    path, gain = np.zeros_like(x), part / 2 * a
    for index in range(1, count + 1):
        path = path + part * (v + gain)
        a = acceleration(time + index / count * size, x + path)
        gain = gain + (part / 2 if index == count else part) * a
    return np.stack((path, gain))
