"""Target properties as functions of one parameter, with their extrema."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from attrs import evolve, frozen

from shockwave.measurement.simulate import simulate
from shockwave.scenario.scenario import Scenario
from shockwave.studies import varied_scenes
from shockwave.studies.chebyshev_fit import evaluated, fitted
from shockwave.studies.design_result import Target
from shockwave.studies.universal_curve import UniversalCurve

# Intervals with a greater ratio of their ends are divided by equal ratios.
_WIDE = 3.0
# Step of a finite difference, over the interval.
_STEP = 1e-5


@frozen
class Line:
    """The target property as a function of one parameter.

    Attributes
    ----------
    height : callable
        Logarithm of the property as a function of the parameter.
    error : float
        Error of this logarithm.
    landmarks : tuple of float
        Ends of the interval and extrema of the property, ascending; it is monotone between them.
    curve : UniversalCurve or None
        The curve of the shape; None if the shape varies.
    """

    height: Callable[[float], float]
    error: float
    landmarks: tuple[float, ...]
    curve: UniversalCurve | None

    def slope(self, value: float) -> float:
        """Absolute derivative of the height with respect to the parameter."""
        low, high = self.landmarks[0], self.landmarks[-1]
        step = _STEP * (high - low)
        begin = max(value - step, low)
        end = min(value + step, high)
        return abs(self.height(end) - self.height(begin)) / (end - begin)


def line_along(scenario: Scenario, name: str, target: Target, between: tuple[float, float], rtol: float) -> Line:
    """The target property as a function of the parameter ``name``, for an endless chain.

    Extrema are those of a piecewise polynomial fitted to ``rtol``.

    Raises
    ------
    InvalidValueError
        If a scene is not possible, or its shock is longer than curves cover.
    NumericalError
        If a simulation fails.
    """
    semi_infinite = evolve(scenario, chain=evolve(scenario.chain, granules=None))
    family = varied_scenes.family_of(semi_infinite, [name])
    ends = [family.scenario({name: value}) for value in between]
    # if there is no curve, the error is raised before the search; this includes parameters of the shape
    curves = [varied_scenes.curve_of(end.shock.profile, rtol, varied_scenes.duration_of(end)) for end in ends]
    curve = max(curves, key=lambda one: one.longest) if varied_scenes.keep_shape([name]) else None

    def height(value: float) -> float:
        scene = family.scenario({name: value})
        if curve is not None:
            amplification = float(curve.amplification(varied_scenes.rise_time_of(scene)))
        else:
            amplification = simulate(scene.shock, scene.chain, rtol=rtol, waves="primary").amplification
        return math.log(target.reached(amplification * scene.shock.peak_force, scene))

    return fitted_line(height, between, target.power(ends[0]) * rtol, curve)


def fitted_line(
    height: Callable[[float], float], between: tuple[float, float], error: float, curve: UniversalCurve | None = None
) -> Line:
    """A piecewise polynomial fitted to ``height``; with a ``curve``, ``height`` itself and the extrema of the fit."""
    into, back = (np.log, np.exp) if _is_wide(between) else (float, float)

    def value_at(x: float) -> float:
        return float(np.clip(back(x), *between))

    pieces = fitted(lambda x: height(value_at(x)), float(into(between[0])), float(into(between[1])), error)
    joints = [piece.end for piece in pieces[:-1]]
    turns = [x for piece in pieces for x in piece.turns(0.0)]
    landmarks = {*between, *(value_at(x) for x in (*joints, *turns))}
    if between[0] < 0 < between[1]:
        landmarks.add(0.0)  # Poisson's ratio enters only through its square
    if curve is None:
        polynomial = partial(evaluated, pieces)
        return Line(lambda value: float(polynomial(np.array(into(value)))), error, tuple(sorted(landmarks)), None)
    return Line(height, error, tuple(sorted(landmarks)), curve)


def spaced(between: tuple[float, float], count: int) -> list[float]:
    """Values that divide an interval evenly, by equal ratios if it is wide; both ends are included."""
    space = np.geomspace if _is_wide(between) else np.linspace
    return list(map(float, space(*between, count)))


def _is_wide(between: tuple[float, float]) -> bool:
    return between[0] > 0 and between[1] > _WIDE * between[0]
