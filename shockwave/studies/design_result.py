"""The result of a design: target, options, solutions, and their text."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, get_args

from attrs import asdict, frozen

from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.errors import InvalidValueError
from shockwave.fields import listed, text_of
from shockwave.result_base import VERSION, Result
from shockwave.scenario.scenario import Scenario
from shockwave.studies.quantities import OWN, TARGETS, Quantity, Sign, positive
from shockwave.studies.scaling_exponents import Exponents
from shockwave.tables import unit_of
from shockwave.text import facts, limits, paragraph, si, strong, table

# Columns of the table that a narrow screen leaves out, the last named first.
_SPARE = ("peak force", "chain", "speed", "width", "amplification", "granule", "simulated")
_LEGEND = (
    "(+-: error of the value; error: bound on the relative error of the target property by the curve; simulated: "
    "relative difference of the simulation from the curve; granule, chain: masses)"
)
_SIMULATED_LEGEND = (
    "(+-: error of the value; error: estimated relative error of the target quantity in this simulation; simulated: "
    "relative difference of a more accurate simulation)"
)


@frozen
class Target:
    """Target property of the leading wave and its value.

    Attributes
    ----------
    name : str
        One of `TARGETS`, or the name of a quantity of a simulation.
    value : float
        Value in the SI unit.
    quantity : Quantity or None
        Quantity of a simulation; None for a property of the leading wave.
    sign : "=", "<=" or ">="
        Relation of the property to the value.
    """

    name: str
    value: float
    quantity: Quantity | None = None
    sign: Sign = "="

    @classmethod
    def of(cls, given: Any, covered: bool = True, contacts: Sequence[int] = (), sign: Sign = "=") -> Target:
        """Convert a mapping of one name to a number or to text with a unit.

        ``covered`` is whether the scene has a leading wave in equal granules; ``contacts`` are those that it reports.

        Raises
        ------
        InvalidValueError
            If the name or the relation is unknown or the value is not above 0.
        """
        if not isinstance(given, Mapping) or len(given) != 1:
            rule = 'must be one property and its value, such as {"peak_force": "60 N"}'
            raise InvalidValueError.of("target", f"{rule} (got {text_of(given)})")
        ((name, value),) = given.items()
        if sign not in get_args(Sign):
            raise InvalidValueError.of("sign", f"must be {listed(get_args(Sign))} (got {text_of(sign)})")
        others = TARGETS if covered else ()
        quantity = OWN.get(name)
        if quantity is None and name not in others:
            quantity = Quantity.named(name, contacts, (*OWN, *others), "target")
        unit = unit_of(name).replace(" ", "*") if quantity is None else quantity.unit
        return cls(name, positive(f"target.{name}", unit, value), quantity, sign)

    @property
    def unit(self) -> str:
        """The unit in printed form."""
        return unit_of(self.name) if self.quantity is None else self.quantity.unit.replace("*", " ")

    @property
    def label(self) -> str:
        """The name in printed form."""
        return self.name.replace("_", " ") if self.quantity is None else self.quantity.label

    def __str__(self) -> str:
        return si(self.value, self.unit, 6)

    def holds(self, excess: float) -> bool:
        """Whether the relation holds for a property that exceeds the value by ``excess``, or falls short of it."""
        return excess <= 0 if self.sign == "<=" else excess >= 0 and self.sign == ">="

    def reached(self, peak_force: float, scenario: Scenario) -> float:
        """The property in a scene whose leading wave has this peak force [N]."""
        if self.name == "amplification":
            return peak_force / scenario.shock.peak_force
        return float(getattr(SolitaryWave.of(peak_force, scenario.chain), self.name))

    def distance(self, option: AnyOption) -> float:
        """Absolute logarithm of the ratio of the reached value to the target value."""
        return abs(math.log(option.reached / self.value)) if option.reached > 0 else math.inf

    def power(self, scenario: Scenario) -> float:
        """Power of the peak force of the leading wave with which the property scales."""
        return abs(math.log2(self.reached(2.0, scenario) / self.reached(1.0, scenario)))


@frozen(kw_only=True)
class Simulated:
    """Simulation of the scene of an option.

    Attributes
    ----------
    reached : float
        Value of the target property.
    peak_force : float or None
        Peak force of the leading wave [N]; None for a quantity of the simulation itself.
    error_estimate : float
        Estimate of the relative error of the peak force, or of this quantity.
    """

    reached: float
    peak_force: float | None
    error_estimate: float


@frozen(kw_only=True)
class AnyOption:
    """A scene that differs from the scenario in one parameter.

    Attributes
    ----------
    value : float or str
        Value of the parameter in SI units, or the name of a material.
    reached, reached_error : float
        Value of the target property, and a bound on its relative error or, for a simulation, its estimate.
    simulated : Simulated or None
        More accurate simulation of the scene, for solutions and for the nearest option.
    value_error : float or None
        Error of ``value`` in its unit, for numeric solutions; None if it is unknown.
    """

    value: float | str
    reached: float
    reached_error: float
    simulated: Simulated | None = None
    value_error: float | None = None

    @property
    def columns(self) -> dict[str, str]:
        """Columns of its other properties."""
        raise NotImplementedError


@frozen(kw_only=True)
class Option(AnyOption):
    """An option by the curve of its shape. It has the attributes of `AnyOption` and the following ones.

    Attributes
    ----------
    peak_force, amplification : float
        Peak force of the leading wave [N], and its ratio to that of the shock.
    error : float
        Bound on the relative error of the peak force.
    momentum, energy, speed, width, granule_velocity : float
        Properties of the leading wave [N s], [J], [m/s], [s], [m/s]; see `SolitaryWave`.
    rise_time : float
        t0/T0, rise time of the shock over the characteristic time of the chain.
    granule_mass, mass_per_length : float
        Mass of one granule [kg], mass of the chain over its length [kg/m].
    chain_mass : float or None
        Mass of all granules [kg], if their number is given.
    exponents : scaling_exponents.Exponents
        Exponents of the peak force with respect to the parameters of the chain and the shock.
    """

    peak_force: float
    amplification: float
    error: float
    momentum: float
    energy: float
    speed: float
    width: float
    granule_velocity: float
    rise_time: float
    granule_mass: float
    mass_per_length: float
    chain_mass: float | None
    exponents: Exponents

    @property
    def columns(self) -> dict[str, str]:
        """Columns of the leading wave and the masses."""
        mass = self.chain_mass
        of_wave = ("peak_force", "amplification", "speed", "width")
        return {
            **{name.replace("_", " "): si(getattr(self, name), unit_of(name), error=self.error) for name in of_wave},
            "granule": si(1e3 * self.granule_mass, "g", 4),
            "chain": f"{si(1e3 * self.mass_per_length, 'g', 4)}/m" if mass is None else si(1e3 * mass, "g", 4),
        }


@frozen(kw_only=True)
class SimulatedOption(AnyOption):
    """An option by a simulation. It has the attributes of `AnyOption` and the following ones.

    Attributes
    ----------
    greatest_force : float or None
        Greatest force at all contacts [N], in a finite chain.
    transmitted_force, transmitted_impulse : float or None
        Greatest force and impulse on a wall [N, N s].
    """

    greatest_force: float | None
    transmitted_force: float | None
    transmitted_impulse: float | None

    @property
    def columns(self) -> dict[str, str]:
        """Columns of the forces."""
        forces = {
            "greatest force": (self.greatest_force, "N"),
            "wall force": (self.transmitted_force, "N"),
            "wall impulse": (self.transmitted_impulse, "N s"),
        }
        return {name: si(force, unit) for name, (force, unit) in forces.items() if force is not None}


@frozen(kw_only=True, repr=False)
class Design(Result):
    """The result of a design.

    Attributes
    ----------
    scenario : str
        Name of the scenario, if it has one.
    vary, unit : str
        Dotted name of the varied parameter, and its unit.
    target : Target
        Target property of the leading wave.
    between : tuple of float, or None
        Interval of the parameter; None for materials and whole numbers.
    solutions : tuple of Option
        All values in the interval that meet the target, ascending; each was simulated. Ends and extrema that miss the
        target by no more than the allowed error are included, with a warning. Materials are solutions within this error
        too, the nearest first.
    intervals : tuple of (float, float)
        For an inequality, all intervals of values that meet it, ascending; their inner ends are ``solutions``.
    nearest : Option or None
        Option nearest to the target, if there is no solution; always given for materials and whole numbers.
    least, most : Option
        Options with the least and the greatest value of the target property: the reachable range.
    table : tuple of Option
        Trade-off: values over the interval, ascending; or materials, the nearest first.
    warnings : tuple of str
        Limits of the result, in sentences.
    """

    scenario: str
    vary: str
    unit: str = ""
    target: Target
    between: tuple[float, float] | None = None
    solutions: tuple[AnyOption, ...]
    intervals: tuple[tuple[float, float], ...] = ()
    nearest: AnyOption | None
    least: AnyOption
    most: AnyOption
    table: tuple[AnyOption, ...]
    warnings: tuple[str, ...]

    @property
    def reachable(self) -> bool:
        """Whether there is a solution."""
        return bool(self.intervals or (self.solutions if self.target.sign == "=" or self.between is None else ()))

    @property
    def spanned(self) -> bool:
        """Whether the target lies in the reachable range."""
        return self.least.reached <= self.target.value <= self.most.reached

    @property
    def why(self) -> str:
        """The reason why there is no solution, in a sentence; empty if there is one."""
        if self.reachable:
            return ""
        if self.spanned and self.between is None:
            return f"no {self.varied} gives {self.target}, although it is within the reachable range"
        if self.spanned and self.target.quantity is not None:
            return f"no value gives {self.target} exactly, although it is within the reachable range: it jumps there"
        if self.spanned and self.nearest:
            simulated = f"its simulation gives {self._simulated(self.nearest)} at {self._value(self.nearest)}"
            return f"{self.target} needs an endless chain; this chain is too short for the search: {simulated}"
        below = self.target.sign == "<=" or (self.target.sign == "=" and self.target.value < self.least.reached)
        limit = f"the minimum is {self._at(self.least)}" if below else f"the maximum is {self._at(self.most)}"
        return f"{self.target} is out of reach: {limit}"

    _brief = ("scenario", "vary", "target.name", "target", "solutions", "table")
    _tables = (("table", "value"),)

    @property
    def _units(self) -> dict[str, str]:
        return {"value": self.unit, "reached": self.target.unit}

    def to_dict(self) -> dict[str, Any]:
        """The document that ``design --json`` prints: SI floats."""
        document = asdict(self)
        own = ("name", "sign", "value", "unit")
        document["target"] = {name: getattr(self.target, name) for name in own}
        return {**VERSION, **document, "reachable": self.reachable, "why": self.why}

    def __str__(self) -> str:
        # materials are in the table already
        first = {} if self.between is None else {option.value: option for option in self._found}
        options = first | {option.value: option for option in self.table} | first
        rows = [self._row(option) for option in options.values()]
        spare = [name for name in _SPARE if name != self.target.label]
        reachable = f"{self._at(self.least)} to {self._at(self.most)}"
        decided = (("reason", self.why), ("reachable", reachable), ("scenario", self.scenario))
        lines = [
            *map(strong, paragraph("", self._answer, 2)),
            *limits(self.warnings),
            *facts(pair for pair in decided if pair[1]),
            "",
            table(list(rows[0]), [list(row.values()) for row in rows], spare),
            *paragraph("  ", _LEGEND if self.target.quantity is None else _SIMULATED_LEGEND, 2),
        ]
        return "\n".join(lines)

    @property
    def _found(self) -> tuple[AnyOption, ...]:
        """The solutions, or else the nearest option."""
        return self.solutions or tuple(filter(None, [self.nearest]))

    @property
    def _answer(self) -> str:
        values = " or ".join(map(self._value, self._found))
        simulated = f"(simulated {', '.join(map(self._simulated, self._found))})"
        article = "an" if self.target.label.startswith(("a", "e")) else "a"
        relation = "of" if self.target.sign == "=" else self.target.sign
        wanted = f"{article} {self.target.label} {relation} {self.target}"
        if self.intervals:
            ends = [[si(end, self.unit, 6) for end in dict.fromkeys(both)] for both in self.intervals]
            spans = [" to ".join(both) for both in ends]
            limit = f" (limits {values}, simulated {', '.join(map(self._simulated, self._found))})" if values else ""
            return f"{self.varied} {' or '.join(spans)} gives {wanted}{limit}"
        if self.reachable:
            return f"{self.varied} {values} gives {wanted} {simulated}"
        return f"no {self.varied} gives {wanted}; nearest {values} {simulated}"

    @property
    def varied(self) -> str:
        """The last part of the name of the varied parameter in printed form, or all of it beside an equal target."""
        last = self.vary.rpartition(".")[2].replace("_", " ")
        return last if last != self.target.label else self.vary.replace(".", " ").replace("_", " ")

    def _value(self, option: AnyOption) -> str:
        """The value of an option with its error."""
        if isinstance(option.value, str):
            return option.value
        if option.value_error is None:
            return si(option.value, self.unit, 6)
        relative = option.value_error / abs(option.value) if option.value else 1.0
        # the error has as many decimals as the value
        return f"{si(option.value, self.unit, error=relative)} +- {si(option.value_error, self.unit, error=0.99)}"

    def _simulated(self, option: AnyOption) -> str:
        """The simulated target property and peak force of an option, as accurate as its curve."""
        assert option.simulated is not None  # a solution, or the nearest option
        reached = si(option.simulated.reached, self.target.unit, error=option.reached_error)
        if self.target.name == "peak_force" or option.simulated.peak_force is None:
            return reached
        error = getattr(option, "error", option.reached_error)
        return f"{reached}, peak force {si(option.simulated.peak_force, 'N', error=error)}"

    def _at(self, option: AnyOption) -> str:
        return f"{self._reached(option)} at {self._value(option)}"

    def _reached(self, option: AnyOption) -> str:
        return si(option.reached, self.target.unit, error=option.reached_error)

    def _row(self, option: AnyOption) -> dict[str, str]:
        """The columns of an option."""
        value, _, error = self._value(option).partition(" +- ")
        simulated = option.simulated
        return {
            self.varied: value,
            **({} if self.between is None else {"+-": error or "-"}),
            self.target.label: self._reached(option),
            "error": f"{option.reached_error:.0e}",
            "simulated": "-" if simulated is None else f"{simulated.reached / option.reached - 1:+.0e}",
            **option.columns,
        }
