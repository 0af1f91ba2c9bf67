"""A target as a function of one value, with all its turning points, and the values at which it is met."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np
from attrs import evolve, frozen

from shockwave.errors import NumericalError
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.studies import scene_response
from shockwave.studies.chebyshev_fit import evaluated, fitted
from shockwave.studies.crossings import crossings
from shockwave.studies.design import Target
from shockwave.studies.scaling_exponents import POWERS

_POISSON = "chain.material.poisson_ratio"
_MODULUS = "chain.material.youngs_modulus"
# Values that span more than this factor are spaced by equal ratios.
_WIDE = 3.0
# A value that is an end of the interval but for this is that end; Poisson's ratios enter by their squares.
_END = 1e-9
_END_OF_POISSON = 1e-7
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
    make = _on_curve if scene_response.keep_shape([name]) else _of_simulations
    return make(endless, name, target, between, rtol)


def solutions(line: Line, target: Target) -> Iterator[tuple[float, float, float]]:
    """Values at which the target is met, ascending, the share by which an end or a turning point misses it, and the
    change of the value over the share by which the target changes."""
    wanted = math.log(target.value)
    low, high = line.landmarks[0], line.landmarks[-1]
    for root in crossings(lambda value: line.height(value) - wanted, line.landmarks, line.error):
        value = _snapped(root, (low, high))
        miss = math.expm1(line.height(value) - wanted) if value in line.landmarks else 0.0
        step = _STEP * (value * math.log(high / low) if low > 0 else high - low)
        begin, end = max(value - step, low), min(value + step, high)
        rise = abs(line.height(end) - line.height(begin))
        yield value, miss, (end - begin) / rise if rise else math.inf


def _snapped(value: float, ends: Iterable[float], near: float = 0.0) -> float:
    """``value``, or the end that it is but for rounding."""
    return next((end for end in ends if math.isclose(value, end, rel_tol=_END, abs_tol=near)), value)


def spaced(between: tuple[float, float], count: int) -> list[float]:
    """Values between two, both included; by equal ratios where they span a wide range."""
    found: list[float] = (np.geomspace if _is_wide(between) else np.linspace)(*between, count).tolist()
    return [between[0], *found[1:-1], between[1]]


def _is_wide(between: tuple[float, float]) -> bool:
    return between[0] > 0 and between[1] > _WIDE * between[0]


def _on_curve(scenario: Scenario, name: str, target: Target, between: tuple[float, float], rtol: float) -> Line:
    """By the curve of the shape, which has all turning points of (F/F0) (t0/T0)^s.

    With x the value, t0/T0 ~ x^e, and the target ~ (F/F0)^q x^p, s is p/(q e).
    """
    family = Family(scenario)
    ends = [family.scenario({name: value}) for value in between]
    base, longest = ends[0], max(map(scene_response.duration_of, ends))
    curve = scene_response.curve_of(base.shock.profile, rtol, longest)

    def ratio(scene: Scenario) -> float:
        # rounding must not put the end beyond the range
        return min(scene_response.rise_time_of(scene), curve.longest_rise_time)

    def height(value: float) -> float:
        scene = family.scenario({name: value})
        force = float(curve.amplification(ratio(scene))) * scene.shock.peak_force
        return math.log(target.reached(force, scene))

    # Poisson's ratio enters by the modulus E/(1 - nu^2) alone
    varied = _MODULUS if name == _POISSON else name
    here = base.chain.material.youngs_modulus if name == _POISSON else between[0]
    doubled = family.scenario({name: between[0], varied: 2 * here})
    forces = base.shock.peak_force, doubled.shock.peak_force
    p = math.log2(target.reached(forces[1], doubled) / target.reached(forces[0], base))
    e, q = POWERS[varied], target.power(base)
    corners = (*between, 0.0) if name == _POISSON and between[0] < 0 < between[1] else between
    ratios = [ratio(family.scenario({name: value})) for value in corners]
    landmarks = set(corners)
    for turn in curve.turns(round(p / (q * e), 12), min(ratios), max(ratios)):
        factor = (turn / ratios[0]) ** (1 / e)
        values = [between[0] * factor]
        if name == _POISSON:
            root = math.sqrt(max(1 - (1 - between[0] ** 2) / factor, 0.0))
            values = [-root, root]
        near = _END_OF_POISSON if name == _POISSON else 0.0
        landmarks |= {_snapped(value, corners, near) for value in values if between[0] <= value <= between[1]}

    def error(value: float) -> float:
        return abs(q) * min(float(curve.error(ratio(family.scenario({name: value})))), rtol)

    return Line(height, error, tuple(sorted(landmarks)), longest)


def _of_simulations(scenario: Scenario, name: str, target: Target, between: tuple[float, float], rtol: float) -> Line:
    """By a piecewise polynomial through simulations: the curves of other shapes are others."""
    family = scene_response.family_of(scenario, [name])
    for value in between:  # the table has their curves too; where there is none, this is reported before the search
        end = family.scenario({name: value})
        scene_response.curve_of(end.shock.profile, rtol, scene_response.duration_of(end))
    into, back = (math.log, math.exp) if _is_wide(between) else (float, float)

    def value_at(x: float) -> float:
        return min(max(_snapped(back(x), between), between[0]), between[1])

    def simulated(x: float) -> float:
        value = value_at(x)
        amplification, force, error = scene_response.primaries(scenario, {name: np.array([value])}, rtol)
        if error[0] >= 1:
            problem = f"the primary at {name} = {value:.4g} cannot be told from what follows"
            raise NumericalError(f"{problem} (its simulation does not say how good it is; shorten the shock)")
        return math.log(target.reached(float(amplification[0] * force[0]), family.scenario({name: value})))

    pieces = fitted(simulated, into(between[0]), into(between[1]), rtol)
    turns = {value_at(x) for piece in pieces for x in (piece.begin, *piece.turns(0.0), piece.end)}
    error = abs(target.power(family.scenario({name: between[0]}))) * rtol
    return Line(
        lambda value: float(evaluated(pieces, np.array(into(value)))), lambda _: error, tuple(sorted(turns)), 0.0
    )
