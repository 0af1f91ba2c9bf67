"""Design: search for all values of one kind that give the primary the target property, or the nearest."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from attrs import asdict, evolve

from shockwave.chain.chain import Chain
from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.errors import InvalidValueError, ShockwaveError
from shockwave.fields import Quantity, text_of
from shockwave.measurement.simulate import simulate
from shockwave.profiles.shock import Shock
from shockwave.registry import entries, find
from shockwave.scenario.dotted_names import Variable, variable
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.studies import scene_response
from shockwave.studies.design import Design, Option, Simulated, Target
from shockwave.studies.target_along_value import line_along, solutions, spaced
from shockwave.text import si

_MATERIAL = "chain.material"
_POINTS = Quantity("", "number of rows", at_least=2, at_most=1000, whole=True)
_RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
# Names of a scenario that are no numbers with a range.
_UNFIT = ("chain.granules", "shock.profile", "shock.data")
# Points of the line in a picture.
_FINE = 101
# A target missed by no more is met but for rounding.
_ROUNDING = 1e-9
# Tolerance of the simulations of solutions.
_VERIFIED = 1e-8
# A simulation that differs from the curve by so many times its error is of another scene: of a chain too short for it.
_FAR = 5.0


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
    """Every value of a scene at which the primary is as wanted, the others kept.

    Parameters
    ----------
    scene : Scenario or Shock
        A scenario, or the shock on ``chain``.
    chain : Chain, optional
        Where ``scene`` is a shock.
    vary : str
        Dotted name of the value: a number of the chain or the shock, such as ``chain.radius``, or ``chain.material``.
    target : mapping
        One quantity of the primary and its value, a number in SI units or text: ``{"peak_force": "60 N"}``. Known are
        peak_force, amplification, momentum, energy, speed, width, granule_velocity.
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
        When a simulation that the curve needs fails.
    """
    for name, spec, value in (("points", _POINTS, points), ("rtol", _RTOL, rtol)):
        if problem := spec.problem(value):
            raise InvalidValueError.of(name, problem)
    scenario = scene_response.scenario_of(scene, chain)
    wanted = Target.of(target)
    try:
        varied = variable(vary, scene_response.data_of(scenario), fits=_can_be_varied)
    except InvalidValueError as error:
        raise InvalidValueError.of("vary", error.faults[0].problem) from None
    if vary == _MATERIAL:
        if between is not None:
            raise InvalidValueError.of("between", f"must be left out for {_MATERIAL} (got {text_of(between)})")
        return _among_materials(Family(scenario), wanted, among, rtol)
    if among is not None:
        raise InvalidValueError.of("among", f"must be left out: it is for {_MATERIAL} (got {text_of(among)})")
    return _along(varied, Family(scenario), wanted, _interval(varied, between), int(points), rtol)


def _can_be_varied(name: str) -> bool:
    return name.startswith(("chain.", "shock.")) and name not in _UNFIT


def _interval(varied: Variable, given: Sequence[Any] | None) -> tuple[float, float]:
    name, spec = varied.name, varied.key.spec
    if not _can_be_varied(name) or spec is None or spec.samples or spec.whole:
        remedy = f"or {_MATERIAL}; {name} is none"
        raise InvalidValueError.of("vary", f"must be a value of the chain or shock with a range, {remedy}")
    if not isinstance(given, list | tuple) or len(given) != 2:
        got = "nothing" if given is None else text_of(given)
        raise InvalidValueError.of("between", f"must be the least and the greatest {name} (got {got})")
    try:
        low, high = (varied.value(one) for one in given)
    except InvalidValueError as error:
        raise InvalidValueError.of("between", error.faults[0].problem) from None
    if not low < high:
        raise InvalidValueError.of("between", f"must ascend (got {low:g} and {high:g})")
    return low, high


def _among_materials(family: Family, target: Target, among: Iterable[str] | None, rtol: float) -> Design:
    if isinstance(among, str):
        raise InvalidValueError.of("among", f"must be a list of names (got {among!r}; put it in brackets)")
    names = [entry.name for entry in entries("materials")] if among is None else list(among)
    for name in names:
        find("materials", name)
    if not names:
        raise InvalidValueError.of("among", "must be one material or more (got none)")
    options: list[Option] = []
    left_out: list[str] = []
    for name in dict.fromkeys(names):
        try:
            options.append(_option(name, family.scenario({_MATERIAL: name}), target, rtol))
        except InvalidValueError as error:
            left_out.append(f"{name} is left out: {error}")
    if not options:
        raise InvalidValueError.of("among", f"must have a material for which there is a curve ({left_out[0]})")
    first, *others = sorted(options, key=target.distance)
    (nearest,), failures = _simulated([first], family, _MATERIAL, target)
    met = target.distance(first) <= max(rtol, first.reached_error) and not _misses(nearest, target, rtol)
    return Design(
        scenario=family.base.name,
        vary=_MATERIAL,
        unit="",
        target=target,
        between=None,
        solutions=(nearest,) if met else (),
        nearest=nearest,
        least=min(options, key=lambda one: one.reached),
        most=max(options, key=lambda one: one.reached),
        table=(nearest, *others),
        warnings=(*_notes(family), *left_out, *failures),
        line=((), ()),
    )


def _along(
    varied: Variable, family: Family, target: Target, between: tuple[float, float], points: int, rtol: float
) -> Design:
    name = varied.name
    unit = varied.unit or ""

    def option(value: float) -> Option:
        return _option(value, family.scenario({name: value}), target, rtol, line.reach)

    try:
        line = line_along(family.base, name, target, between, rtol)
        least = option(min(line.landmarks, key=line.height))
        most = option(max(line.landmarks, key=line.height))
        met = solutions(line, target)
        found = [option(value) for value in met]
        table = tuple(option(value) for value in spaced(between, points))
    except InvalidValueError as error:
        problem = f"{scene_response.impossible(error, 'give')}: narrow the interval"
        raise InvalidValueError.of("between", problem) from None
    # along the shape each simulation may be off by the tolerance
    least_error = 0.0 if line.reach else rtol
    found = [_with_error(one, line.slope(float(one.value)), least_error) for one in found]
    checked, failures = _simulated(found or [min(least, most, key=target.distance)], family, name, target)
    hits = tuple(one for one in checked if found and not _misses(one, target, rtol))
    values = spaced(between, _FINE)
    return Design(
        scenario=family.base.name,
        vary=name,
        unit=unit,
        target=target,
        between=between,
        solutions=hits,
        nearest=None if hits else min(checked, key=target.distance),
        least=least,
        most=most,
        table=table,
        warnings=(*_notes(family), *_doubts(met, least, most, target, rtol, unit), *failures),
        line=(tuple(values), tuple(math.exp(line.height(value)) for value in values)),
    )


def _notes(family: Family) -> tuple[str, ...]:
    return scene_response.notes_of(family.base, besides="; simulations are of the chain as it is")


def _with_error(option: Option, slope: float, least: float) -> Option:
    """With the error of its value, at which the logarithm of the target changes by ``slope`` over the value."""
    error = max(option.reached_error, least) / slope if slope else math.inf
    return evolve(option, value_error=error if math.isfinite(error) else None)


def _doubts(
    met: Mapping[float, float], least: Option, most: Option, target: Target, rtol: float, unit: str
) -> list[str]:
    """Warnings of solutions that are none but for the error of the curve."""
    range_ = (most.reached - least.reached) / target.value
    if range_ <= max(least.reached_error, most.reached_error, rtol):
        return [f"over the whole interval {target.name} varies by no more than {range_:.0e} of what is wanted"]
    return [
        f"{si(value, unit)} is an end of the interval or a turning point: it misses what is wanted by"
        f" {miss:+.1e}, no more than the error allowed"
        for value, miss in met.items()
        if abs(miss) > _ROUNDING
    ]


def _option(value: float | str, scenario: Scenario, target: Target, rtol: float, reach: float = 0.0) -> Option:
    """The option that ``scenario`` is, which has ``value``; by a curve that goes on to n t0/T0 = ``reach``."""
    shock = scenario.shock
    chain = scenario.chain
    curve = scene_response.curve_of(shock.profile, rtol, max(scene_response.duration_of(scenario), reach))
    answer = curve.answer(shock, chain)
    return Option(
        value=value,
        reached=target.reached(answer.peak_force, scenario),
        reached_error=abs(target.power(scenario)) * answer.error,
        amplification=answer.amplification,
        error=answer.error,
        **asdict(SolitaryWave.of(answer.peak_force, chain)),
        rise_time=answer.rise_time,
        granule_mass=chain.granule_mass,
        mass_per_length=chain.granule_mass / (2 * chain.radius),
        chain_mass=None if chain.granules is None else chain.granules * chain.granule_mass,
        exponents=scene_response.exponents_of(scenario, curve),
    )


def _simulated(options: Iterable[Option], family: Family, name: str, target: Target) -> tuple[list[Option], list[str]]:
    """The options with the simulations of their scenes, and why some have none."""
    checked: list[Option] = []
    failures: list[str] = []
    for option in options:
        scene = family.scenario({name: option.value})
        try:
            result = simulate(scene.shock, scene.chain, rtol=_VERIFIED, waves="primary")
        except ShockwaveError as error:
            checked.append(option)
            failures.append(f"no simulation at {option.value}: {error}")
        else:
            reached = target.reached(result.peak_force, scene)
            known = Simulated(reached=reached, peak_force=result.peak_force, error_estimate=result.error_estimate)
            checked.append(evolve(option, simulated=known))
    return checked, failures


def _misses(option: Option, target: Target, rtol: float) -> bool:
    """Whether its simulation misses the target by far more than the curve may err."""
    if option.simulated is None:
        return False
    off = abs(option.simulated.reached / target.value - 1)
    return off > _FAR * max(option.reached_error, rtol) + option.simulated.error_estimate
