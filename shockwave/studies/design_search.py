"""Design: search for all values of one parameter that give the leading wave, or a force, a target value."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from attrs import asdict, evolve, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.layout import mass_and_length
from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.errors import InvalidValueError
from shockwave.fields import Quantity, text_of
from shockwave.measurement.simulate import simulate
from shockwave.numerics import crossings
from shockwave.progress import counted
from shockwave.scenario.block_keys import MATERIALS
from shockwave.scenario.scene_argument import Scene
from shockwave.scenario.scene_family import Family
from shockwave.scenario.uncertainty import is_continuous
from shockwave.studies import varied_scenes
from shockwave.studies.chebyshev_fit import evaluated, fitted
from shockwave.studies.design_result import AnyOption, Design, Option, Simulated, SimulatedOption, Target
from shockwave.studies.quantities import OWN, Sign, contacts_of, parts_of, required
from shockwave.studies.universal_curve import RTOL, UniversalCurve, answer_of
from shockwave.text import si

# Most whole numbers that are tried one by one.
_MOST_WHOLE = 200
_POINTS = Quantity("", "number of rows", at_least=2, at_most=1000, whole=True)
# Bound on the relative error of a mass or a length.
_EXACT = 1e-6
# Relative difference from the target that is rounding.
_ROUNDING = 1e-9
# Tolerance of the simulations of solutions.
_SIMULATION_RTOL = 1e-8
# Greatest difference between a simulation and the curve, over the error of the curve, for a solution: in shorter chains
# the wave has not formed.
_LARGEST_DIFFERENCE = 5.0
# Step of a finite difference, as a fraction of the interval.
_STEP = 1e-5
# Warning on materials of a chain that must be elastic.
_BEYOND = "left out, because a force exceeds first yield or a yield strength is not known: "
# Tolerance of the simulations that are fitted, over that of the fit.
_SIMULATED_SHARE = 0.1


def design(
    scene: Scene,
    chain: Chain | None = None,
    *,
    vary: str,
    target: Mapping[str, Any] | str,
    between: Sequence[Any] | None = None,
    among: str | Iterable[str] | None = None,
    points: int = 9,
    rtol: float = 1e-4,
    sign: Sign = "=",
) -> Design:
    """All values of one parameter of a scene that give the leading wave, or a force in the chain, a target value.

    A number is searched in its interval; materials and whole numbers are tried one by one.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    vary : str
        Dotted name of the parameter: a number or a material of the chain, the shock or the impact, such as
        ``chain.radius`` or ``chain.material``.
    target : mapping or str
        One property and its value, a number in SI units or text: ``{"peak_force": "60 N"}``; or a requirement with its
        relation, such as ``"peak_force <= 60 N"``. The properties of the leading wave are peak_force, amplification,
        momentum, energy, speed, width, granule_velocity. Those of a simulation are transmitted.peak_force,
        transmitted.impulse, greatest_force.peak_force, dissipated_energy, restitution, yield.peak_ratio, and
        contacts[0].peak_force for the first of the reported contacts; those of the chain are chain.mass, chain.length.
    between : pair, optional
        Ends of the interval of a number, in SI units or as text.
    among : str or sequence of str, optional
        Materials to compare; by default, all materials of the library.
    points : int
        Number of rows of the table, 2 to 1000.
    rtol : float
        Allowed relative error of the curve, or of the fit to the simulations, 1e-7 to 1e-2.
    sign : "=", "<=" or ">="
        Relation between property and value if ``target`` is a mapping. For an inequality, all intervals in which it
        holds are found.

    Returns
    -------
    Design
        The solutions, or the nearest option, in SI units.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a name is unknown or a value is out of range.
    NumericalError
        If a simulation fails.
    """
    points, rtol = _POINTS.checked("points", points), RTOL.checked("rtol", rtol)
    if isinstance(target, str):
        name, sign, value = parts_of(target, "target")
        target = {name: value}
    scenario = varied_scenes.scenario_of(scene, chain)
    # curves are those of chains that differ in a number or in the material of all granules
    covered = varied_scenes.is_covered(scenario) and not vary.startswith("chain.granules")
    requested = Target.of(target, covered, contacts_of(scenario), sign)
    varied = varied_scenes.varied(vary, scenario)
    of_material = vary.endswith(MATERIALS)
    unused, given = ("between", between) if of_material else ("among", among)
    if given is not None:
        raise InvalidValueError.of(unused, f"must be omitted for {vary} (got {text_of(given)})")
    search = (_Search if covered and requested.quantity is None else _SimulatedSearch)(
        Family(scenario), vary, requested, rtol
    )
    if of_material:
        return search.among(varied_scenes.materials_of(among))
    if varied.whole and vary.startswith("chain."):
        return search.among(_whole(varied_scenes.interval(varied, between)))
    if not is_continuous(varied):
        raise InvalidValueError.of("vary", f"must be a number or a material of the chain or the shock (got {vary})")
    return search.along(varied.unit or "", varied_scenes.interval(varied, between), points)


def _whole(ends: tuple[float, float]) -> range:
    """All whole numbers of an interval, its ends included."""
    low, high = map(int, ends)
    if high - low >= _MOST_WHOLE:
        problem = f"must have at most {_MOST_WHOLE} whole numbers (got {high - low + 1}; narrow the interval)"
        raise InvalidValueError.of("between", problem)
    return range(low, high + 1)


def _within(error: InvalidValueError) -> InvalidValueError:
    """The error of an interval that contains the scene of an ``error``."""
    if error.faults[0].path in ("target", "chain.granules"):
        return error
    return InvalidValueError.of("between", f"must contain only valid cases ({error.faults[0]})")


@frozen
class _Line:
    """The target property as a function of one parameter.

    Attributes
    ----------
    height : callable
        Logarithm of the ratio of the property to its target value, as a function of the parameter.
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
    curve: UniversalCurve | None = None

    def slope(self, value: float) -> float:
        """Absolute derivative of the height with respect to the parameter."""
        low, high = self.landmarks[0], self.landmarks[-1]
        step = _STEP * (high - low)
        begin = max(value - step, low)
        end = min(value + step, high)
        return abs(self.height(end) - self.height(begin)) / (end - begin)


def _fitted_line(height: Callable[[float], float], between: tuple[float, float], error: float) -> _Line:
    """A piecewise polynomial fitted to ``height``."""
    into, back = (np.log, np.exp) if varied_scenes.is_wide(between) else (float, float)

    def value_at(x: float) -> float:
        return float(np.clip(back(x), *between))

    pieces = fitted(lambda x: height(value_at(x)), float(into(between[0])), float(into(between[1])), error)
    joints = [piece.end for piece in pieces[:-1]]
    turns = [x for piece in pieces for x in piece.turns(0.0)]
    landmarks = {*between, *(value_at(x) for x in (*joints, *turns))}
    if between[0] < 0 < between[1]:
        landmarks.add(0.0)  # Poisson's ratio enters only through its square
    return _Line(lambda value: float(evaluated(pieces, np.array(into(value)))), error, tuple(sorted(landmarks)))


@frozen
class _Search:
    """Options with different values of one parameter, each from the curve of its shape."""

    family: Family
    name: str
    target: Target
    rtol: float

    @property
    def notes(self) -> tuple[str, ...]:
        """Limits of the options."""
        return varied_scenes.notes_of(self.family.base)

    def line(self, between: tuple[float, float]) -> _Line:
        """The target property as a function of the parameter, for an endless chain."""
        base = self.family.base
        family = varied_scenes.family_of(evolve(base, chain=evolve(base.chain, granules=None)), [self.name])
        ends = [family.scenario({self.name: value}) for value in between]
        # raises the error before the search if there is no curve, also where parameters of the shape vary
        curves = [varied_scenes.curve_of(end.shock.profile, self.rtol, varied_scenes.duration_of(end)) for end in ends]
        curve = max(curves, key=lambda one: one.longest) if varied_scenes.keep_shape([self.name]) else None

        def height(value: float) -> float:
            scene = family.scenario({self.name: value})
            if curve is not None:
                amplification = float(curve.amplification(varied_scenes.rise_time_of(scene)))
            else:
                amplification = simulate(scene.shock, scene.chain, rtol=self.rtol, waves="primary").amplification
            return math.log(self.target.reached(amplification * scene.shock.peak_force, scene) / self.target.value)

        line = _fitted_line(height, between, self.target.power(ends[0]) * self.rtol)
        return evolve(line, height=height, curve=curve) if curve is not None else line

    def among(self, compared: Sequence[str | int]) -> Design:
        """Rank materials or whole numbers by their distance from the target.

        The nearest and those that meet the target are simulated.
        """
        options: list[AnyOption] = []
        beyond: dict[str | int, InvalidValueError] = {}
        for name in counted("whole numbers" if isinstance(compared, range) else "materials", compared):
            try:
                options.append(self.option(name))
            except InvalidValueError as error:
                if error.faults[0].path != "chain.elastic_only":
                    raise (_within(error) if isinstance(name, int) else error) from None
                beyond[name] = error
        if not options:
            raise beyond[compared[0]]
        first, *others = sorted(options, key=self.target.distance)
        ranked = [self.simulated(first), *(self.simulated(one) if self.fits(one) else one for one in others)]
        # whole numbers ascend; materials have no other order
        rows = sorted(ranked, key=lambda one: 0.0 if isinstance(one.value, str) else one.value)
        return Design(
            scenario=self.family.base.name,
            vary=self.name,
            target=self.target,
            solutions=tuple(one for one in rows if self.fits(one) and self.meets(one)),
            nearest=ranked[0],
            least=min(options, key=lambda one: one.reached),
            most=max(options, key=lambda one: one.reached),
            table=tuple(rows),
            warnings=(*self.notes, *[_BEYOND + ", ".join(map(str, beyond))] * bool(beyond)),
        )

    def along(self, unit: str, between: tuple[float, float], points: int) -> Design:
        """Find all values in the interval that meet the target."""
        try:
            line = self.line(between)
            least = self.option(min(line.landmarks, key=line.height), line.curve)
            most = self.option(max(line.landmarks, key=line.height), line.curve)
            met = crossings(line.height, line.landmarks, lambda _: line.error)
            found = [self.solution(value, line) for value in met]
            spaced = (np.geomspace if varied_scenes.is_wide(between) else np.linspace)(*between, points).tolist()
            table = tuple(self.option(value, line.curve) for value in counted("rows", spaced))
            intervals = self.intervals(line, met)
        except InvalidValueError as error:
            raise _within(error) from None
        to_simulate = found or [min(least, most, key=self.target.distance)]
        checked = [self.simulated(one) for one in counted("simulations", to_simulate)]
        solutions = tuple(one for one in checked if found and self.meets(one))
        near_misses = [
            f"{si(value, unit)} is an end or an extremum: it misses the target by {miss:+.0e}, within the error"
            for value, one in zip(met, found, strict=True)
            if value in line.landmarks and abs(miss := one.reached / self.target.value - 1) > _ROUNDING
        ]
        return Design(
            scenario=self.family.base.name,
            vary=self.name,
            unit=unit,
            target=self.target,
            between=between,
            solutions=solutions,
            intervals=intervals,
            nearest=None if solutions or intervals else min(checked, key=self.target.distance),
            least=least,
            most=most,
            table=table,
            warnings=(*self.notes, *near_misses),
        )

    def intervals(self, line: _Line, met: Sequence[float]) -> tuple[tuple[float, float], ...]:
        """Intervals between values at which the property equals the target, in which an inequality holds."""
        spans = pairwise(sorted({line.landmarks[0], *met, line.landmarks[-1]}))
        joined = groupby(spans, lambda span: self.target.holds(line.height(sum(span) / 2)))
        groups = [list(group) for holds, group in joined if holds]
        found = [(group[0][0], group[-1][1]) for group in groups]
        # at an end or an extremum an inequality may hold with equality alone
        alone = [value for value in met if not any(low <= value <= high for low, high in found)]
        return tuple(sorted(found + [(value, value) for value in alone if self.target.sign != "="]))

    def solution(self, value: float, line: _Line) -> AnyOption:
        """The option with this value and its error."""
        option = self.option(value, line.curve)
        slope = line.slope(value)
        # if the shape varies, each simulation has the error of the line
        error = max(option.reached_error, 0.0 if line.curve else line.error)
        return evolve(option, value_error=error / slope if slope else None)

    def option(self, value: float | str, curve: UniversalCurve | None = None) -> AnyOption:
        """The option with this value, from ``curve`` or from the curve of its shape."""
        scenario = self.family.scenario({self.name: value})
        shock, chain = scenario.shock, scenario.chain
        if curve is None:
            curve = varied_scenes.curve_of(shock.profile, self.rtol, varied_scenes.duration_of(scenario))
        answer = answer_of(curve, shock, chain)
        known = asdict(SolitaryWave.of(answer.peak_force, chain)) | asdict(answer)
        return Option(
            value=value,
            reached=self.target.reached(answer.peak_force, scenario),
            reached_error=self.target.power(scenario) * answer.error,
            **known,
            granule_mass=chain.granule_mass,
            mass_per_length=chain.granule_mass / (2 * chain.radius),
            chain_mass=None if chain.count is None else chain.count * chain.granule_mass,
            exponents=varied_scenes.exponents_of(scenario, curve),
        )

    def simulated(self, option: AnyOption) -> AnyOption:
        """The option with the simulation of its scene."""
        scene = self.family.scenario({self.name: option.value})
        result = simulate(scene.shock, scene.chain, rtol=_SIMULATION_RTOL, waves="primary")
        reached = self.target.reached(result.peak_force, scene)
        simulated = Simulated(reached=reached, peak_force=result.peak_force, error_estimate=result.error_estimate)
        return evolve(option, simulated=simulated)

    def fits(self, option: AnyOption) -> bool:
        """Whether the option meets the target within the error of its curve, or satisfies the inequality."""
        near = self.target.distance(option) <= max(option.reached_error, self.rtol)
        return near or self.target.holds(option.reached - self.target.value)

    def meets(self, option: AnyOption) -> bool:
        """Whether the simulation meets the target within the errors of curve and simulation, or its inequality."""
        assert option.simulated is not None
        if self.target.holds(option.simulated.reached - self.target.value):
            return True
        difference = abs(option.simulated.reached / self.target.value - 1)
        curve_error = max(option.reached_error, self.rtol)
        return difference <= _LARGEST_DIFFERENCE * curve_error + option.simulated.error_estimate


@frozen
class _SimulatedSearch(_Search):
    """Options with different values of one parameter, each from a simulation."""

    @property
    def notes(self) -> tuple[str, ...]:
        shock = self.family.base.shock
        return () if shock is None else tuple(shock.profile.notes)

    def line(self, between: tuple[float, float]) -> _Line:
        """The property on a scale of the inverse hyperbolic sine, finite even if no force arrives."""

        def height(value: float) -> float:
            return math.asinh(self.read(value, _SIMULATED_SHARE * self.rtol)[1] / self.target.value) - math.asinh(1.0)

        # a fit to simulations may be rough: its extrema divide the interval, and crossings are those of simulations
        return evolve(_fitted_line(height, between, self.rtol), height=height)

    def read(self, value: float | str, rtol: float) -> tuple[Any, float, float]:
        """Simulation of the scene with this value; the target quantity and its relative error."""
        scene = self.family.scenario({self.name: value})
        assert self.target.quantity is not None
        if self.target.name in OWN:
            own = dict(zip(OWN, mass_and_length(scene.chain), strict=True))
            return None, own[self.target.name], _EXACT
        (result,) = varied_scenes.simulations([scene], rtol)
        return result, *required(self.target.quantity, result, {self.name: value})

    def option(self, value: float | str, curve: UniversalCurve | None = None) -> AnyOption:
        result, reached, error = self.read(value, _SIMULATED_SHARE * self.rtol)
        top, wall = (None, None) if result is None else (result.greatest_force, result.transmitted)
        return SimulatedOption(
            value=value,
            reached=reached,
            reached_error=error,
            greatest_force=top and top.peak_force,
            transmitted_force=wall and wall.peak_force,
            transmitted_impulse=wall and wall.impulse,
        )

    def simulated(self, option: AnyOption) -> AnyOption:
        _, reached, error = self.read(option.value, _SIMULATION_RTOL)
        return evolve(option, simulated=Simulated(reached=reached, peak_force=None, error_estimate=error))
