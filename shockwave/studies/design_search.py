"""Design: search for all values of one kind that give the primary the target property, or the nearest."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from attrs import asdict, evolve, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.errors import InvalidValueError, ShockwaveError
from shockwave.fields import Quantity, text_of
from shockwave.measurement.simulate import simulate
from shockwave.profiles.shock import Shock
from shockwave.registry import entries, find
from shockwave.scenario.family import Family
from shockwave.scenario.load import Scenario
from shockwave.scenario.variable import Variable, variable
from shockwave.studies import scene_response
from shockwave.studies.design import Design, Option, Simulated, Target
from shockwave.studies.design_line import line_along, solutions, spaced
from shockwave.studies.design_text import why
from shockwave.text import si

__all__ = ["design"]

_MATERIAL = "chain.material"
_POINTS = Quantity("", "number of rows", at_least=2, at_most=1000, whole=True)
_RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
# Names of a scenario that are no numbers with a range.
_UNFIT = ("chain.granules", "shock.profile", "shock.data")
# Points of the line in a picture.
_FINE = 101
# Bisections to find how far an interval may go.
_HALVINGS = 40
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
    scenario, wanted = scene_response.scenario_of(scene, chain), Target.of(target)
    try:
        varied = variable(vary, scene_response.data_of(scenario), fits=_can_be_varied)
    except InvalidValueError as error:
        raise InvalidValueError.of("vary", error.faults[0].problem) from None
    materials = vary == _MATERIAL
    if materials and between is not None:
        raise InvalidValueError.of("between", f"must be left out for {_MATERIAL} (got {text_of(between)})")
    if not materials and among is not None:
        raise InvalidValueError.of("among", f"must be left out: it is for {_MATERIAL} (got {text_of(among)})")
    family = Family(scenario)
    if materials:
        interval, unit = None, ""
        search = _among_materials(family, wanted, among, rtol)
    else:
        interval, unit = _interval(varied, between), varied.unit or ""
        search = _along(varied, family, wanted, interval, int(points), rtol)
    checked, failures = _simulated(search.meeting or [search.nearest], family, vary, wanted)
    met = tuple(one for one in checked if search.meeting and not _misses(one, wanted, rtol))
    nearest = min(checked, key=wanted.distance)
    found = Design(
        scenario=scenario.name,
        vary=vary,
        unit=unit,
        target=wanted,
        between=interval,
        solutions=met,
        nearest=nearest if materials or not met else None,
        least=search.least,
        most=search.most,
        table=(nearest, *search.table[1:]) if materials else search.table,
        warnings=(
            *scene_response.notes_of(scenario, besides="; simulations are of the chain as it is"),
            *search.warnings,
            *failures,
        ),
        line=search.line,
    )
    return evolve(found, why=why(found))


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


@frozen(kw_only=True)
class _Search:
    """The options of a design before simulation: those that meet the target, and the others as of `Design`."""

    meeting: list[Option]
    nearest: Option
    least: Option
    most: Option
    table: tuple[Option, ...]
    warnings: list[str]
    line: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())


def _among_materials(family: Family, target: Target, among: Iterable[str] | None, rtol: float) -> _Search:
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
    ranked = sorted(options, key=target.distance)
    first = ranked[0]
    return _Search(
        meeting=[first] if target.distance(first) <= max(rtol, first.reached_error) else [],
        nearest=first,
        least=min(options, key=lambda one: one.reached),
        most=max(options, key=lambda one: one.reached),
        table=tuple(ranked),
        warnings=left_out,
    )


def _along(
    varied: Variable, family: Family, target: Target, between: tuple[float, float], points: int, rtol: float
) -> _Search:
    """Search along a number."""
    name = varied.name

    def option(value: float) -> Option:
        return _option(value, family.scenario({name: value}), target, rtol, line.reach)

    try:
        _check_durations(family, name, between)
        line = line_along(family.base, name, target, between, rtol)
        least, most = (option(extreme(line.landmarks, key=line.height)) for extreme in (min, max))
        meeting, warnings = [], []
        for value, miss, slope in solutions(line, target):
            found = option(value)
            error = slope * max(found.reached_error, 0.0 if line.reach else rtol)
            meeting.append(evolve(found, value_error=error if math.isfinite(error) else None))
            if abs(miss) > _ROUNDING:
                end = f"{si(value, varied.unit or '')} is an end of the interval or a turning point"
                warnings.append(f"{end}: it misses what is wanted by {miss:+.1e}, no more than the error allowed")
        table = tuple(option(value) for value in spaced(between, points))
    except InvalidValueError as error:
        fault = error.faults[0]
        problem = f"must give scenes that can be: {fault}" if fault.path else fault.problem
        raise InvalidValueError.of("between", f"{problem}: narrow the interval") from None
    range_ = (most.reached - least.reached) / target.value
    if range_ <= max(least.reached_error, most.reached_error, rtol):
        warnings = [f"over the whole interval {target.name} varies by no more than {range_:.0e} of what is wanted"]
    values = spaced(between, _FINE)
    return _Search(
        meeting=meeting,
        nearest=min(least, most, key=target.distance),
        least=least,
        most=most,
        table=table,
        warnings=warnings,
        line=(tuple(values), tuple(math.exp(line.height(value)) for value in values)),
    )


def _check_durations(family: Family, name: str, between: tuple[float, float]) -> None:
    """Refuse ends for which there is no curve, with how far the interval may go."""

    def wrong(value: float) -> InvalidValueError | None:
        return scene_response.too_long(
            np.array([scene_response.duration_of(family.scenario({name: value}))]), {name: np.array([value])}
        )

    errors = [wrong(value) for value in between]
    for error, bad, good in zip(errors, between, reversed(between), strict=True):
        if error is None:
            continue
        if all(errors):
            raise error
        for _ in range(_HALVINGS):
            middle = (good + bad) / 2
            good, bad = (good, middle) if wrong(middle) else (middle, bad)
        raise InvalidValueError.of("", f"{error.faults[0].problem}; it may go to {good:.4g}")


# ---------------------------------------------------------------- options


def _option(value: float | str, scenario: Scenario, target: Target, rtol: float, reach: float = 0.0) -> Option:
    """The option that ``scenario`` is, which has ``value``; by a curve that goes on to n t0/T0 = ``reach``."""
    shock, chain = scenario.shock, scenario.chain
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
    """The options with their simulations, and sentences on those that could not be simulated."""
    checked: list[Option] = []
    failures: list[str] = []
    for option in options:
        scene = family.scenario({name: option.value})
        try:
            result = simulate(scene.shock, scene.chain, rtol=_VERIFIED, waves="primary")
        except ShockwaveError as error:
            checked.append(option)
            failures.append(f"no simulation at {option.value}: {error}")
            continue
        reached = target.reached(result.peak_force, scene)
        simulated = Simulated(reached=reached, peak_force=result.peak_force, error_estimate=result.error_estimate)
        checked.append(evolve(option, simulated=simulated))
    return checked, failures


def _misses(option: Option, target: Target, rtol: float) -> bool:
    """Whether its simulation misses the target by far more than the curve may err."""
    if option.simulated is None:
        return False
    off = abs(option.simulated.reached / target.value - 1)
    return off > _FAR * max(option.reached_error, rtol) + option.simulated.error_estimate
