"""A target as a function of one value, with all its turning points, and the values at which it is met."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from attrs import evolve, frozen

from shockwave.errors import NumericalError
from shockwave.numerics import crossings
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.studies import scene_response
from shockwave.studies.chebyshev_fit import evaluated, fitted
from shockwave.studies.design import Target
from shockwave.studies.scaling_exponents import POWERS

_POISSON = "chain.material.poisson_ratio"
_MODULUS = "chain.material.youngs_modulus"
# Values that span more than this factor are spaced by equal ratios.
_WIDE = 3.0
# Step of a difference, over the whole line.
_STEP = 1e-5


@frozen
class Line:
    """The target as a function of one value.

    Attributes
    ----------
    height : callable
        Logarithm of the target at a value.
    error : callable
        Error of that logarithm; where it may exceed the tolerance, the tolerance: a target missed by more is not met.
    landmarks : tuple of float
        Ends of the interval and all values at which the target turns, ascending: it is monotone between them.
    reach : float
        The longest duration n t0/T0 for which one curve has to hold; 0 where there is a curve for each value.
    """

    height: Callable[[float], float]
    error: Callable[[float], float]
    landmarks: tuple[float, ...]
    reach: float

    def slope(self, value: float) -> float:
        """Change of the height over the value, without its sign."""
        low, high = self.landmarks[0], self.landmarks[-1]
        step = _STEP * (value * math.log(high / low) if low > 0 else high - low)
        begin = max(value - step, low)
        end = min(value + step, high)
        return abs(self.height(end) - self.height(begin)) / (end - begin)


def line_along(scenario: Scenario, name: str, target: Target, between: tuple[float, float], rtol: float) -> Line:
    """The line of the value called ``name``, of a chain without end.

    Raises
    ------
    InvalidValueError
        When there is a value without a scene, or a shock longer than curves reach.
    NumericalError
        When a simulation fails.
    """
    endless = evolve(scenario, chain=evolve(scenario.chain, granules=None))
    family = scene_response.family_of(endless, [name])
    durations = [scene_response.duration_of(family.scenario({name: value})) for value in between]
    scene_response.check_durations(np.array(durations), {name: np.array(between)})
    if scene_response.keep_shape([name]):
        return _on_curve(family, name, target, between, rtol, max(durations))
    return _of_simulations(family, name, target, between, rtol)


def solutions(line: Line, target: Target) -> dict[float, float]:
    """Values at which the target is met, ascending -> the share by which an end or a turning point misses it."""
    wanted = math.log(target.value)

    def off(value: float) -> float:
        return line.height(value) - wanted

    met = crossings(off, line.landmarks, line.error)
    return {value: math.expm1(off(value)) if value in line.landmarks else 0.0 for value in met}


def spaced(between: tuple[float, float], count: int) -> list[float]:
    """Values between two, both included; by equal ratios where they span a wide range."""
    space = np.geomspace if _is_wide(between) else np.linspace
    inner: list[float] = space(*between, count)[1:-1].tolist()
    return [between[0], *inner, between[1]]


def _is_wide(between: tuple[float, float]) -> bool:
    return between[0] > 0 and between[1] > _WIDE * between[0]


def _on_curve(
    family: Family, name: str, target: Target, between: tuple[float, float], rtol: float, reach: float
) -> Line:
    """By the curve of the shape, which has all turning points of (F/F0) (t0/T0)^s.

    With x the value, t0/T0 ~ x^e, and the target ~ (F/F0)^q x^p, s is p/(q e).
    """
    curve = scene_response.curve_of(family.base.shock.profile, rtol, reach)

    def ratio(value: float) -> float:
        # rounding must not put the end beyond the range
        return min(scene_response.rise_time_of(family.scenario({name: value})), curve.longest_rise_time)

    def height(value: float) -> float:
        scene = family.scenario({name: value})
        force = float(curve.amplification(ratio(value))) * scene.shock.peak_force
        return math.log(target.reached(force, scene))

    def error(value: float) -> float:
        return abs(q) * min(float(curve.error(ratio(value))), rtol)

    # Poisson's ratio enters by the modulus E/(1 - nu^2) alone
    varied = _MODULUS if name == _POISSON else name
    here = scene_response.value_of(family.base, varied)
    base, doubled = (family.scenario({varied: factor * here}) for factor in (1, 2))
    at_base, at_doubled = (target.reached(scene.shock.peak_force, scene) for scene in (base, doubled))
    p = math.log2(at_doubled / at_base)
    q = target.power(base)
    e = POWERS[varied]
    corners = {*between, 0.0} if name == _POISSON and between[0] < 0 < between[1] else {*between}
    ratios = [ratio(value) for value in corners]
    landmarks = set(corners)
    for turn in curve.turns(round(p / (q * e), 12), min(ratios), max(ratios)):
        factor = (turn / ratio(between[0])) ** (1 / e)
        values = [between[0] * factor]
        if name == _POISSON:
            root = math.sqrt(max(1 - (1 - between[0] ** 2) / factor, 0.0))
            values = [-root, root]
        landmarks |= {value for value in values if between[0] < value < between[1]}
    return Line(height, error, tuple(sorted(landmarks)), reach)


def _of_simulations(family: Family, name: str, target: Target, between: tuple[float, float], rtol: float) -> Line:
    """By a piecewise polynomial through simulations: the curves of other shapes are others."""
    ends = [family.scenario({name: value}) for value in between]
    for end in ends:  # the table has their curves too; where there is none, this is reported before the search
        scene_response.curve_of(end.shock.profile, rtol, scene_response.duration_of(end))
    into, back = (np.log, np.exp) if _is_wide(between) else (float, float)

    def value_at(x: float) -> float:
        return float(np.clip(back(x), *between))

    def simulated(x: float) -> float:
        value = value_at(x)
        (amplification,), (force,), (error,) = scene_response.primaries(family.base, {name: np.array([value])}, rtol)
        if error >= 1:
            problem = f"the primary at {name} = {value:.4g} cannot be told from what follows"
            raise NumericalError(f"{problem} (its simulation does not say how good it is; shorten the shock)")
        return math.log(target.reached(float(amplification * force), family.scenario({name: value})))

    pieces = fitted(simulated, float(into(between[0])), float(into(between[1])), rtol)
    joints = [piece.end for piece in pieces[:-1]]
    turns = [x for piece in pieces for x in piece.turns(0.0)]
    landmarks = {*between, *(value_at(x) for x in (*joints, *turns))}
    error = abs(target.power(ends[0])) * rtol
    return Line(
        height=lambda value: float(evaluated(pieces, np.array(into(value)))),
        error=lambda _: error,
        landmarks=tuple(sorted(landmarks)),
        reach=0.0,
    )
