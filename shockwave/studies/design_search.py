"""Design: search for all values of one kind that give the primary the target property, or the nearest."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from attrs import asdict, evolve, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.errors import InvalidValueError
from shockwave.fields import Quantity, text_of
from shockwave.measurement.simulate import simulate
from shockwave.numerics import crossings
from shockwave.profiles.shock import Shock
from shockwave.registry import entries, find
from shockwave.scenario.dotted_names import Variable, variable
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.scenario.uncertainty import ends_of, is_continuous
from shockwave.scenario.value_conversion import WrongsError, gathered
from shockwave.studies import varied_scenes
from shockwave.studies.chebyshev_fit import evaluated, fitted
from shockwave.studies.design_result import Design, Option, Simulated, Target
from shockwave.studies.universal_curve import UniversalCurve
from shockwave.text import si

_MATERIAL = "chain.material"
_POINTS = Quantity("", "number of rows", at_least=2, at_most=1000, whole=True)
_RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
# A target missed by less is met: rounding.
_ROUNDING = 1e-9
# Tolerance of the simulations of solutions.
_VERIFIED = 1e-8
# A simulation that differs from the curve by more than this many errors is of a chain too short for the curve.
_FAR = 5.0
# Values that span more than this factor are spaced by equal ratios.
_WIDE = 3.0
# Step of a difference, over the whole interval.
_STEP = 1e-5


def design(
    scene: Scenario | Shock,
    chain: Chain | None = None,
    *,
    vary: str,
    target: Mapping[str, Any],
    between: Sequence[Any] | None = None,
    among: Iterable[str] | None = None,
    points: int = 9,
    rtol: float = 1e-4,
) -> Design:
    """Every value of a scene that gives the primary the target property; all other values are kept.

    Parameters
    ----------
    scene : Scenario or Shock
        A scenario, or the shock on ``chain``.
    chain : Chain, optional
        Where ``scene`` is a shock.
    vary : str
        Dotted name of the value: a number of the chain or the shock, such as ``chain.radius``, or ``chain.material``.
    target : mapping
        One property of the primary and its value, a number in SI units or text: ``{"peak_force": "60 N"}``. The
        properties are peak_force, amplification, momentum, energy, speed, width, granule_velocity.
    between : pair, optional
        The interval of a number: its ends in SI units, or as text.
    among : sequence of str, optional
        Materials to be compared; left out, all of the library.
    points : int
        Rows of the table, 2 to 1000.
    rtol : float
        Relative error allowed of the curve, 1e-7 to 1e-2.

    Returns
    -------
    Design
        In SI units.

    Raises
    ------
    InvalidValueError, UnknownNameError
        When a name is unknown or a value out of range.
    NumericalError
        When a simulation fails.
    """
    for name, spec, value in (("points", _POINTS, points), ("rtol", _RTOL, rtol)):
        if problem := spec.problem(value):
            raise InvalidValueError.of(name, problem)
    scenario = varied_scenes.scenario_of(scene, chain)
    wanted = Target.of(target)
    try:
        varied = variable(
            vary, varied_scenes.data_of(scenario), fits=lambda name: name.startswith(("chain.", "shock."))
        )
    except InvalidValueError as error:
        raise InvalidValueError.of("vary", error.faults[0].problem) from None
    unused, given = ("between", between) if vary == _MATERIAL else ("among", among)
    if given is not None:
        raise InvalidValueError.of(unused, f"must be left out for {vary} (got {text_of(given)})")
    search = _Search(Family(scenario), vary, wanted, rtol)
    if vary == _MATERIAL:
        return search.among(among)
    return search.along(varied.unit or "", _interval(varied, between), int(points))


def _interval(varied: Variable, given: Sequence[Any] | None) -> tuple[float, float]:
    if not is_continuous(varied):
        rule = f"must be a value of the chain or shock with a range, or {_MATERIAL}"
        raise InvalidValueError.of("vary", f"{rule} (got {varied.name})")
    if given is None:
        raise InvalidValueError.of("between", "must be the least and the greatest value (got nothing)")
    try:
        ((low, high),) = gathered([("between", given)], {"between": partial(ends_of, varied)}).values()
    except WrongsError as error:
        raise InvalidValueError.of("between", str(error.wrongs[0].problem)) from None
    return low, high


@frozen
class Line:
    """The target property as a function of one value.

    Attributes
    ----------
    height : callable
        Logarithm of the property at a value.
    error : float
        Error of that logarithm.
    landmarks : tuple of float
        Ends of the interval and values at which the property turns, ascending; it is monotone between them.
    curve : UniversalCurve or None
        The curve for the whole line; None where the shape varies.
    """

    height: Callable[[float], float]
    error: float
    landmarks: tuple[float, ...]
    curve: UniversalCurve | None

    def slope(self, value: float) -> float:
        """Absolute change of the height over the value."""
        low, high = self.landmarks[0], self.landmarks[-1]
        step = _STEP * (high - low)
        begin = max(value - step, low)
        end = min(value + step, high)
        return abs(self.height(end) - self.height(begin)) / (end - begin)


def line_along(scenario: Scenario, name: str, target: Target, between: tuple[float, float], rtol: float) -> Line:
    """The line of the value called ``name``, for an endless chain.

    Turning points are those of a piecewise polynomial that follows the line to ``rtol``.

    Raises
    ------
    InvalidValueError
        When a value makes no scene, or a shock longer than curves reach.
    NumericalError
        When a simulation fails.
    """
    endless = evolve(scenario, chain=evolve(scenario.chain, granules=None))
    family = varied_scenes.family_of(endless, [name])
    ends = [family.scenario({name: value}) for value in between]
    # where a curve fails, along the shape too, this is found before the search
    curves = [varied_scenes.curve_of(end.shock.profile, rtol, varied_scenes.duration_of(end)) for end in ends]
    curve = max(curves, key=lambda one: one.longest) if varied_scenes.keep_shape([name]) else None

    def height(value: float) -> float:
        scene = family.scenario({name: value})
        if curve is not None:
            amplification = float(curve.amplification(varied_scenes.rise_time_of(scene)))
        else:
            amplification = simulate(scene.shock, scene.chain, rtol=rtol, waves="primary").amplification
        return math.log(target.reached(amplification * scene.shock.peak_force, scene))

    into, back = (np.log, np.exp) if _is_wide(between) else (float, float)

    def value_at(x: float) -> float:
        return float(np.clip(back(x), *between))

    error = target.power(ends[0]) * rtol
    pieces = fitted(lambda x: height(value_at(x)), float(into(between[0])), float(into(between[1])), error)
    joints = [piece.end for piece in pieces[:-1]]
    turns = [x for piece in pieces for x in piece.turns(0.0)]
    landmarks = {*between, *(value_at(x) for x in (*joints, *turns))}
    if between[0] < 0 < between[1]:
        landmarks.add(0.0)  # Poisson's ratio enters by its square
    if curve is None:
        polynomial = partial(evaluated, pieces)
        return Line(lambda value: float(polynomial(np.array(into(value)))), error, tuple(sorted(landmarks)), None)
    return Line(height, error, tuple(sorted(landmarks)), curve)


def _spaced(between: tuple[float, float], count: int) -> list[float]:
    """Values between two, both included; by equal ratios where they span a wide range."""
    space = np.geomspace if _is_wide(between) else np.linspace
    values: list[float] = space(*between, count).tolist()
    return values


def _is_wide(between: tuple[float, float]) -> bool:
    return between[0] > 0 and between[1] > _WIDE * between[0]


@frozen
class _Search:
    """The options of one value, each by the curve of its shape."""

    family: Family
    name: str
    target: Target
    rtol: float

    def among(self, names: Iterable[str] | None) -> Design:
        """Rank materials by their distance from the target; simulate the nearest and all that meet it."""
        known = list(names or [entry.name for entry in entries("materials")])
        for name in known:
            find("materials", name)
        options = [self.option(name) for name in dict.fromkeys(known)]
        first, *others = sorted(options, key=self.target.distance)
        ranked = [self.simulated(first), *(self.simulated(one) if self.near(one) else one for one in others)]
        return Design(
            scenario=self.family.base.name,
            vary=self.name,
            target=self.target,
            solutions=tuple(one for one in ranked if self.near(one) and self.meets(one)),
            nearest=ranked[0],
            least=min(options, key=lambda one: one.reached),
            most=max(options, key=lambda one: one.reached),
            table=tuple(ranked),
            warnings=varied_scenes.notes_of(self.family.base),
        )

    def along(self, unit: str, between: tuple[float, float], points: int) -> Design:
        """Find all values in the interval that meet the target."""
        wanted = math.log(self.target.value)
        try:
            line = line_along(self.family.base, self.name, self.target, between, self.rtol)
            least = self.option(min(line.landmarks, key=line.height), line.curve)
            most = self.option(max(line.landmarks, key=line.height), line.curve)
            met = crossings(lambda value: line.height(value) - wanted, line.landmarks, lambda _: line.error)
            found = [self.solution(value, line) for value in met]
            table = tuple(self.option(value, line.curve) for value in _spaced(between, points))
        except InvalidValueError as error:
            raise InvalidValueError.of("between", f"must give possible scenes ({error.faults[0]})") from None
        checked = [self.simulated(one) for one in found or [min(least, most, key=self.target.distance)]]
        solutions = tuple(one for one in checked if found and self.meets(one))
        near_misses = [
            f"{si(value, unit)} is an end or a turning point: it misses the target by {miss:+.1e}, within the error"
            for value in met
            if value in line.landmarks and abs(miss := math.expm1(line.height(value) - wanted)) > _ROUNDING
        ]
        return Design(
            scenario=self.family.base.name,
            vary=self.name,
            unit=unit,
            target=self.target,
            between=between,
            solutions=solutions,
            nearest=None if solutions else min(checked, key=self.target.distance),
            least=least,
            most=most,
            table=table,
            warnings=(*varied_scenes.notes_of(self.family.base), *near_misses),
        )

    def solution(self, value: float, line: Line) -> Option:
        """The option with this value, and the error of the value."""
        option = self.option(value, line.curve)
        slope = line.slope(value)
        # where the shape varies each simulation has the error of the line
        error = max(option.reached_error, 0.0 if line.curve else line.error)
        return evolve(option, value_error=error / slope if slope else None)

    def option(self, value: float | str, curve: UniversalCurve | None = None) -> Option:
        """The option with this value, by ``curve`` or that of its own shape."""
        scenario = self.family.scenario({self.name: value})
        shock = scenario.shock
        chain = scenario.chain
        if curve is None:
            curve = varied_scenes.curve_of(shock.profile, self.rtol, varied_scenes.duration_of(scenario))
        ratio = varied_scenes.rise_time_of(scenario)
        amplification = float(curve.amplification(ratio))
        peak_force = amplification * shock.peak_force
        error = float(curve.error(ratio))
        return Option(
            value=value,
            reached=self.target.reached(peak_force, scenario),
            reached_error=self.target.power(scenario) * error,
            amplification=amplification,
            error=error,
            **asdict(SolitaryWave.of(peak_force, chain)),
            rise_time=ratio,
            granule_mass=chain.granule_mass,
            mass_per_length=chain.granule_mass / (2 * chain.radius),
            chain_mass=None if chain.granules is None else chain.granules * chain.granule_mass,
            exponents=varied_scenes.exponents_of(scenario, curve),
        )

    def simulated(self, option: Option) -> Option:
        """The option with the simulation of its scene."""
        scene = self.family.scenario({self.name: option.value})
        result = simulate(scene.shock, scene.chain, rtol=_VERIFIED, waves="primary")
        reached = self.target.reached(result.peak_force, scene)
        known = Simulated(reached=reached, peak_force=result.peak_force, error_estimate=result.error_estimate)
        return evolve(option, simulated=known)

    def near(self, option: Option) -> bool:
        """Whether the option meets the target but for the error of its curve."""
        return self.target.distance(option) <= max(option.reached_error, self.rtol)

    def meets(self, option: Option) -> bool:
        """Whether the simulation meets the target but for the errors of curve and simulation."""
        assert option.simulated is not None
        off = abs(option.simulated.reached / self.target.value - 1)
        return off <= _FAR * max(option.reached_error, self.rtol) + option.simulated.error_estimate
