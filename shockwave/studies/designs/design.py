"""Design: all values of one kind that make the primary what it is to be, or the nearest that there is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from attrs import field, frozen

from shockwave.chain.chain import Chain
from shockwave.errors import InvalidValueError
from shockwave.fields import Quantity, text_of
from shockwave.profiles.shock import Shock
from shockwave.registry import entries, find
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.scenario.variable import Variable, variable
from shockwave.studies.curve.response import data_of, duration_of, notes_of, scenario_of, too_long
from shockwave.studies.designs.lines import Line, spaced
from shockwave.studies.designs.targets import Option, Target
from shockwave.text import printed, si

__all__ = ["Design", "design"]

_MATERIAL = "chain.material"
_POINTS = Quantity("", "number of rows", at_least=2, at_most=1000, whole=True)
_RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
# Names of a scenario that are no numbers with a range.
_UNFIT = ("chain.granules", "shock.profile", "shock.data")
# Of the line in a picture.
_FINE = 301
# To tell how far an interval may go.
_HALVINGS = 40
# A target missed by no more is met but for rounding.
_ROUNDING = 1e-9


@frozen(kw_only=True)
class Design:
    """What a design has found.

    Attributes
    ----------
    scenario : str
        Name of the scenario, if it has one.
    vary, unit : str
        Dotted name of the value that was looked for, and its unit.
    target : Target
        What is wanted of the primary.
    between : tuple of float, or None
        The interval of the value; None for materials.
    solutions : tuple of Option
        All values in the interval that meet the target, ascending; each was simulated. Among them are ends and turning
        points that miss it by no more than the error allowed, which a warning tells. Materials that meet it within
        that are some too.
    nearest : Option or None
        Where none does, the one that comes nearest; for materials always.
    least, most : Option
        Where the target is least and greatest: what can be reached.
    table : tuple of Option
        For a trade-off: values over the interval, ascending; or materials, the nearest first.
    warnings : tuple of str
        What a reader must know.
    line : tuple of (tuple of float, tuple of float)
        Values and targets close together, for a picture; empty for materials.
    """

    scenario: str
    vary: str
    unit: str
    target: Target
    between: tuple[float, float] | None
    solutions: tuple[Option, ...]
    nearest: Option | None
    least: Option
    most: Option
    table: tuple[Option, ...]
    warnings: tuple[str, ...]
    line: tuple[tuple[float, ...], tuple[float, ...]] = field(repr=False)

    @property
    def reachable(self) -> bool:
        """Whether anything meets the target."""
        return bool(self.solutions)

    @property
    def spanned(self) -> bool:
        """Whether the target lies between the least and the greatest, met or not."""
        return self.least.reached <= self.target.value <= self.most.reached

    @property
    def why(self) -> str:
        """Why there is no solution, in a sentence; empty where there is one."""
        from shockwave.studies.designs.design_text import why

        return why(self)

    def to_dict(self) -> dict[str, Any]:
        """What ``design --json`` prints: SI floats."""
        return {
            "scenario": self.scenario,
            "vary": self.vary,
            "unit": self.unit,
            "target": {"name": self.target.name, "value": self.target.value, "unit": self.target.unit},
            "between": None if self.between is None else list(self.between),
            "reachable": self.reachable,
            "why": self.why,
            "solutions": [option.to_dict() for option in self.solutions],
            "nearest": self.nearest.to_dict() if self.nearest else None,
            "least": self.least.to_dict(),
            "most": self.most.to_dict(),
            "table": [option.to_dict() for option in self.table],
            "warnings": list(self.warnings),
        }

    def __str__(self) -> str:
        return printed(self, "shockwave.studies.designs.design_text:design_text")


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
    scenario, wanted = scenario_of(scene, chain), Target.of(target)
    try:
        varied = variable(vary, data_of(scenario), fits=_can_be_varied)
    except InvalidValueError as error:
        raise InvalidValueError.of("vary", error.faults[0].problem) from None
    if vary == _MATERIAL:
        if between is not None:
            raise InvalidValueError.of("between", f"must be left out for {_MATERIAL} (got {text_of(between)})")
        return _of_materials(scenario, wanted, among, rtol)
    if among is not None:
        raise InvalidValueError.of("among", f"must be left out: it is for {_MATERIAL} (got {text_of(among)})")
    return _of_numbers(scenario, varied, wanted, _interval(varied, between), int(points), rtol)


def _can_be_varied(name: str) -> bool:
    return name.startswith(("chain.", "shock.")) and name not in _UNFIT


def _interval(varied: Variable, given: Sequence[Any] | None) -> tuple[float, float]:
    name, spec = varied.name, varied.key.spec
    if name.partition(".")[0] not in ("chain", "shock") or spec is None or spec.samples or spec.whole:
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


def _of_numbers(
    scenario: Scenario, variable: Variable, target: Target, between: tuple[float, float], points: int, rtol: float
) -> Design:
    name, family = variable.name, Family(scenario)

    def option(value: float) -> Option:
        return Option.of(value, family.scenario({name: value}), target, rtol, line.reach)

    try:
        _check_durations(family, variable, between)
        line = Line.of(scenario, name, target, between, rtol)
        least, most = (option(value) for value, _ in line.extremes)
        found = [option(value).known(slope, 0.0 if line.reach else rtol) for value, _, slope in line.solutions]
        rows = tuple(option(value) for value in spaced(between, points))
    except InvalidValueError as error:
        fault = error.faults[0]
        problem = f"must give scenes that can be: {fault}" if fault.path else fault.problem
        raise InvalidValueError.of("between", f"{problem}: narrow the interval") from None
    checked, told = _verified(found or [min(least, most, key=target.distance)], family, name, target)
    solutions = tuple(one for one in checked if found and not one.misses(target, rtol))
    doubts = _doubts(line, least, most, target, rtol, variable.unit or "") if len(solutions) == len(found) else ()
    return Design(
        scenario=scenario.name,
        vary=name,
        unit=variable.unit or "",
        target=target,
        between=between,
        solutions=solutions,
        nearest=None if solutions else min(checked, key=target.distance),
        least=least,
        most=most,
        table=rows,
        warnings=(*_warnings(scenario), *doubts, *told),
        line=line.points(_FINE),
    )


def _check_durations(family: Family, variable: Variable, between: tuple[float, float]) -> None:
    """Refuse ends for which there is no curve, with how far the interval may go."""
    name = variable.name

    def fault(value: float) -> InvalidValueError | None:
        return too_long(np.array([duration_of(family.scenario({name: value}))]), {name: np.array([value])})

    faults = [fault(value) for value in between]
    for wrong, bad, good in zip(faults, between, reversed(between), strict=True):
        if wrong is None:
            continue
        if all(faults):
            raise wrong
        for _ in range(_HALVINGS):
            middle = (good + bad) / 2
            good, bad = (good, middle) if fault(middle) else (middle, bad)
        problem = wrong.faults[0].problem
        raise InvalidValueError.of("", f"{problem}; it may go to {good:.4g}")


def _of_materials(scenario: Scenario, target: Target, among: Iterable[str] | None, rtol: float) -> Design:
    if isinstance(among, str):
        raise InvalidValueError.of("among", f"must be a list of names (got {among!r}; put it in brackets)")
    names = [entry.name for entry in entries("materials")] if among is None else list(among)
    for name in names:
        find("materials", name)
    if not names:
        raise InvalidValueError.of("among", "must be one material or more (got none)")
    family = Family(scenario)
    options: list[Option] = []
    left_out: list[str] = []
    for name in dict.fromkeys(names):
        try:
            options.append(Option.of(name, family.scenario({_MATERIAL: name}), target, rtol))
        except InvalidValueError as error:
            left_out.append(f"{name} is left out: {error}")
    if not options:
        raise InvalidValueError.of("among", f"must have a material for which there is a curve ({left_out[0]})")
    ranked = sorted(options, key=target.distance)
    (first,), told = _verified(ranked[:1], family, _MATERIAL, target)
    met = target.distance(first) <= max(rtol, first.reached_error) and not first.misses(target, rtol)
    return Design(
        scenario=scenario.name,
        vary=_MATERIAL,
        unit="",
        target=target,
        between=None,
        solutions=(first,) if met else (),
        nearest=first,
        least=min(options, key=lambda one: one.reached),
        most=max(options, key=lambda one: one.reached),
        table=(first, *ranked[1:]),
        warnings=(*_warnings(scenario), *left_out, *told),
        line=((), ()),
    )


def _verified(
    options: Iterable[Option], family: Family, name: str, target: Target
) -> tuple[tuple[Option, ...], tuple[str, ...]]:
    """The options simulated, and what there is to say of those that could not be."""
    pairs = [option.verified(family.scenario({name: option.value}), target) for option in options]
    return tuple(option for option, _ in pairs), tuple(problem for _, problem in pairs if problem)


def _warnings(scenario: Scenario) -> tuple[str, ...]:
    return notes_of(scenario, besides="; simulations are of the chain as it is")


def _doubts(line: Line, least: Option, most: Option, target: Target, rtol: float, unit: str) -> Iterator[str]:
    """What there is to say of solutions that are none but for the error of the curve."""
    range_ = (most.reached - least.reached) / target.value
    if range_ <= max(least.reached_error, most.reached_error, rtol):
        yield f"over the whole interval {target.name} varies by no more than {range_:.0e} of what is wanted"
        return
    for value, miss, _ in line.solutions:
        if abs(miss) > _ROUNDING:
            end = f"{si(value, unit)} is an end of the interval or a turning point"
            yield f"{end}: it misses what is wanted by {miss:+.1e}, no more than the error allowed"
