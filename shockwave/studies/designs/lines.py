"""Lines: a target along a value that is a number, with all its turning points, and where it has what is wanted."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np
from attrs import frozen

from shockwave.chain.chain import Scales
from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.studies.curve.crossings import Landmarks, crossings, landmarks, tilted
from shockwave.studies.curve.fit import fitted
from shockwave.studies.curve.response import POWERS, Response, curve_of, duration_of
from shockwave.studies.designs.targets import Target

__all__ = ["Line"]

_POISSON, _MODULUS = "chain.material.poisson_ratio", "chain.material.youngs_modulus"
# Values that span more than this factor are spaced by equal ratios.
_WIDE = 3.0
# Poisson's ratios nearer to 0 than this, or to the ends of the interval, are these.
_ROUNDING = 1e-7
# Step of a difference, over the whole line.
_STEP = 1e-5
# A value that is an end of the interval but for this is that end.
_END = 1e-9


@frozen
class Line:
    """A target as a function of one number, written in variables in which it is easy to solve for.

    Attributes
    ----------
    known : Landmarks
        Ends and turning points, ascending in the inner variable.
    values : callable
        The values that stand behind an inner variable: one, or two of Poisson's ratio.
    reached : callable
        The targets behind inner variables.
    solutions : tuple of (float, float, float)
        Values at which it is as wanted, ascending, by what share of that an end or a turning point misses it, and the
        change of the value over the share by which the target changes.
    reach : float
        The longest duration n t0/T0 for which one curve has to hold; 0 where there is a curve for each value.
    """

    known: tuple[float, ...]
    values: Callable[[float], list[float]]
    reached: Callable[[FloatArray], FloatArray]
    solutions: tuple[tuple[float, float, float], ...]
    reach: float

    @property
    def extremes(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Where the target is least and greatest, each as (value, target)."""
        points = list(zip(*self._at(np.array(self.known)), strict=True))
        return min(points, key=_height), max(points, key=_height)

    def points(self, count: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Values and targets along it, ascending."""
        return self._at(np.linspace(self.known[0], self.known[-1], count))

    def _at(self, inner: FloatArray) -> tuple[tuple[float, ...], tuple[float, ...]]:
        heights = zip(inner.tolist(), self.reached(inner).tolist(), strict=True)
        pairs = sorted((value, height) for x, height in heights for value in self.values(x))
        return tuple(value for value, _ in pairs), tuple(height for _, height in pairs)

    @classmethod
    def of(cls, scenario: Scenario, name: str, target: Target, between: tuple[float, float], rtol: float) -> Line:
        """The line of the value called ``name``.

        Raises
        ------
        InvalidValueError
            When there is a value without a scene, or a shock longer than curves reach.
        NumericalError
            When a simulation fails.
        """
        response = Response.of(scenario, [name], rtol)
        make = _by_curve if response.keeps_shape else _by_simulation
        return make(response, name, target, between)


def _height(point: tuple[float, float]) -> float:
    return point[1]


def spaced(between: tuple[float, float], count: int) -> list[float]:
    """Values between two, both included; by equal ratios where they span a wide range."""
    wide = between[0] > 0 and between[1] > _WIDE * between[0]
    found: list[float] = (np.geomspace if wide else np.linspace)(*between, count).tolist()
    return [between[0], *found[1:-1], between[1]]


# ---------------------------------------------------------------- one shape


def _by_curve(response: Response, name: str, target: Target, between: tuple[float, float]) -> Line:
    """On the curve: with y = ln (t0/T0), x the value, t0/T0 ~ x^e, and the target ~ (F/F0)^q x^p,

    ln target = q (ln (F/F0) + p y / (q e)) + constant, of which the curve knows all turning points.
    """
    family = Family(response.scenario)
    varied = _MODULUS if name == _POISSON else name
    ends = [family.scenario({name: value}) for value in between]
    base = ends[0]
    doubled = family.scenario({name: between[0], varied: 2 * _of(base, varied, between[0])})
    e, p, q = POWERS[varied], target.power_of(base, doubled), target.power(base)
    slope = round(p / (q * e), 12)
    longest = max(map(duration_of, ends))
    curve = curve_of(base.shock.profile, response.rtol, longest)
    begin, *others = (math.log(_ratio(scene)) for scene in ends)
    if name == _POISSON and between[0] < 0 < between[1]:
        # the modulus E/(1 - nu^2) is least there
        others.append(math.log(_ratio(family.scenario({name: 0.0}))))
    reach = math.log(curve.longest_rise_time)
    least, most = min(begin, *others), min(max(begin, *others), reach)
    function = tilted(curve, slope)
    start = math.log(target.reached(float(curve.amplification(_ratio(base))) * base.shock.peak_force, base))
    here = float(function(begin))
    known = landmarks(curve, slope, least, most)

    def values(y: float) -> list[float]:
        return _behind(name, between, math.exp((y - begin) / e))

    def reached(y: FloatArray) -> FloatArray:
        return np.asarray(np.exp(start + q * (function(y) - here)))

    wanted = (math.log(target.value) - start) / q + here

    def tolerance(y: float) -> float:
        # of the longest shocks the error may be more than was asked for: a target missed by that is not met
        return min(float(curve.error(math.exp(y))), response.rtol)

    found = crossings(function, known, wanted, tolerance)
    solutions = _solutions(found, known, values, lambda y: q * (float(function(y)) - wanted))
    return Line(tuple(y for y, _ in known), values, reached, solutions, longest)


def _solutions(
    found: Iterable[float],
    known: Landmarks,
    values: Callable[[float], list[float]],
    height: Callable[[float], float],
) -> tuple[tuple[float, float, float], ...]:
    """The values behind what was found; ``height`` is the logarithm of the target over what is wanted."""
    heights, step = dict(known), _STEP * (known[-1][0] - known[0][0])
    told: dict[float, tuple[float, float]] = {}
    for x in found:
        miss = math.expm1(height(x)) if x in heights else 0.0
        ends = max(x - step, known[0][0]), min(x + step, known[-1][0])
        rise = abs(height(ends[1]) - height(ends[0]))
        behind = [values(end) for end in ends]
        for number, value in enumerate(values(x)):
            reach = [each[min(number, len(each) - 1)] for each in behind]
            told[value] = miss, abs(reach[1] - reach[0]) / rise if rise else math.inf
    return tuple((value, *rest) for value, rest in sorted(told.items()))


def _of(scenario: Scenario, name: str, value: float) -> float:
    return scenario.chain.material.youngs_modulus if name == _MODULUS else value


def _ratio(scenario: Scenario) -> float:
    return Scales.of(scenario.chain, scenario.shock.peak_force).rise_time(scenario.shock.rise_time)


def _behind(name: str, between: tuple[float, float], factor: float) -> list[float]:
    """The values that are ``factor`` times the first one; those of Poisson's ratio that make E/(1 - nu^2) so."""
    low, high = between
    if name != _POISSON:
        return [_inside(low * factor, between)]
    square = 1 - (1 - low**2) / factor
    root = math.sqrt(square) if square > _ROUNDING**2 else 0.0
    roots = (nu for nu in (0.0 - root, root) if low - _ROUNDING <= nu <= high + _ROUNDING)
    return sorted({_inside(nu, between, _ROUNDING) for nu in roots})


def _inside(value: float, between: tuple[float, float], near: float = 0.0) -> float:
    """``value``; an end of the interval where it is that but for rounding."""
    for end in between:
        if math.isclose(value, end, rel_tol=_END, abs_tol=near):
            return end
    return min(max(value, between[0]), between[1])


# ---------------------------------------------------------------- other shapes


def _by_simulation(response: Response, name: str, target: Target, between: tuple[float, float]) -> Line:
    """By a piecewise polynomial through simulations: the curves of other shapes are others."""
    family = response.family
    for value in between:  # the table has their curves too; where there is none, this is told before the line is made
        end = family.scenario({name: value})
        curve_of(end.shock.profile, response.rtol, duration_of(end))
    wide = between[0] > 0 and between[1] > _WIDE * between[0]
    first, last = map(math.log, between) if wide else between

    def values(x: float) -> list[float]:
        return [_inside(math.exp(x) if wide else x, between)]

    def simulated(x: float) -> float:
        (value,) = values(x)
        amplification, force, error = response({name: np.array([value])})
        if error[0] >= 1:
            problem = f"the primary at {name} = {value:.4g} cannot be told from what follows"
            raise NumericalError(f"{problem} (its simulation does not say how good it is; shorten the shock)")
        return math.log(target.reached(float(amplification[0] * force[0]), family.scenario({name: value})))

    series = fitted(simulated, first, last, response.rtol)

    def function(x: float) -> float:
        return float(series(np.array([x]))[0])

    known: Landmarks = series.landmarks(0.0)
    base = family.scenario({name: between[0]})
    wanted = math.log(target.value)
    found = crossings(function, known, wanted, lambda x: abs(target.power(base)) * response.rtol)
    solutions = _solutions(found, known, values, lambda x: function(x) - wanted)
    return Line(tuple(x for x, _ in known), values, lambda x: np.exp(series(x)), solutions, 0.0)
