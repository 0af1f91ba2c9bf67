"""The result of a design: parameters, options, and the solutions among them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from attrs import asdict, evolve, field, frozen

from shockwave.base.quantities import Quantity
from shockwave.base.result import VERSION, Result
from shockwave.base.result_tables import Table, along
from shockwave.base.text import percent, render, si
from shockwave.studies.quantities import Requirement

# Positive intervals whose ends have a larger ratio are divided logarithmically.
_WIDE = 3.0
# Smallest relative error in printed form: seven digits are enough for people.
_FINEST = 1e-6


@frozen(kw_only=True)
class VariedParameter:
    """A parameter of a scene that a design varies.

    Attributes
    ----------
    name, unit : str
        Dotted name, and unit of a number.
    whole : bool
        Whether it is a whole number.
    between : tuple of float, or None
        Ends of the interval of a number.
    among : tuple of str
        Names of materials.
    """

    name: str
    unit: str = ""
    whole: bool = False
    between: tuple[float, float] | None = None
    among: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """The last part of the name in printed form; for an end of a taper, the last two."""
        *_, whole, last = self.name.split(".")
        return f"{whole} {last}" if last in ("from", "to") else last.replace("_", " ")

    @property
    def is_wide(self) -> bool:
        """Whether the interval is divided logarithmically."""
        return self.between is not None and 0 < _WIDE * self.between[0] < self.between[1]

    def at(self, share: float) -> float:
        """Value at a share of the interval, from 0 to 1."""
        assert self.between is not None
        low, high = self.between
        share = min(max(share, 0.0), 1.0)
        value = low * (high / low) ** share if self.is_wide else low + share * (high - low)
        return float(round(value)) if self.whole else min(max(value, low), high)

    def format(self, value: float | str, error: float | None = None) -> str:
        """A value in printed form, with its absolute error if it is known."""
        if isinstance(value, str):
            return value
        unit = self.unit.replace("*", " ")
        if error is None:
            return si(value, unit, 6)
        relative = max(error / abs(value), _FINEST) if value else 1.0
        return f"{si(value, unit, error=relative)} +- {si(relative * abs(value) or error, unit, error=0.99)}"


@frozen(kw_only=True)
class Option:
    """A scene with other values of the parameters.

    Attributes
    ----------
    values : tuple of float or str
        Values of the parameters, in SI units or names, in their order.
    quantities, errors : mapping of str to float
        Quantities of the design in SI units and their estimated relative errors, by their names.
    violation : float
        Largest relative violation of a requirement, which holds if it is not above 0.
    verified : bool
        Whether the scene was simulated at a tolerance of 1e-8.
    value_error : float or None
        Error of the only value, in its unit; None if it is not known.
    warnings : tuple of str
        Warnings of the simulation.
    """

    values: tuple[float | str, ...]
    quantities: Mapping[str, float] = field(hash=False)
    errors: Mapping[str, float] = field(hash=False)
    violation: float
    verified: bool = False
    value_error: float | None = None
    warnings: tuple[str, ...] = ()

    @property
    def value(self) -> float | str:
        """Value of the first parameter."""
        return self.values[0]

    @property
    def reached(self) -> float:
        """Value of the first required quantity."""
        return next(iter(self.quantities.values()))

    @property
    def reached_error(self) -> float:
        """Estimated relative error of `reached`."""
        return next(iter(self.errors.values()))


@frozen(kw_only=True, repr=False)
class Design(Result):
    """Values of parameters that meet requirements.

    Attributes
    ----------
    scenario : str
        Name of the scenario, if it has one.
    parameters : tuple of VariedParameter
        The varied parameters.
    requirements : tuple of Requirement
        The requirements, targets first.
    quantities : tuple of Quantity
        Quantities of the options: the required ones first.
    least : str or None
        Name of the quantity that is minimised; None where all solutions are found.
    solutions : tuple of Option
        For one parameter all values that meet an equality, or the limits of the intervals that meet an inequality,
        ascending; materials and whole numbers that meet the target. Otherwise the best option alone. Ends and extrema
        that miss the target by no more than the tolerance are included; `reached` states it.
    intervals : tuple of (float, float)
        For an inequality of one number, all intervals of values that meet it, ascending.
    nearest : Option or None
        Option nearest to the target, or with the smallest violation, if there is no solution.
    table : tuple of Option
        Trade-off of one number over its interval; materials, the nearest first; whole numbers; or the best option
        of each combination of materials, best first.
    tried : tuple of Option
        All options that were simulated.
    warnings : tuple of str
        Limits of the result, in sentences: the warnings of the simulations of the solutions, and how many of all
        simulated scenes have others.
    """

    scenario: str
    parameters: tuple[VariedParameter, ...]
    requirements: tuple[Requirement, ...]
    quantities: tuple[Quantity, ...]
    least: str | None = None
    solutions: tuple[Option, ...]
    intervals: tuple[tuple[float, float], ...] = ()
    nearest: Option | None
    table: tuple[Option, ...]
    tried: tuple[Option, ...] = field(repr=False)
    warnings: tuple[str, ...]

    _brief = ("scenario", "varied", "required", "solutions", "tried")
    _picture = "shockwave.pictures.studies:draw_design"
    _tables = (("table", "option"), ("tried", "option"))

    @property
    def best(self) -> Option | None:
        """The best option, or the first solution; None if there is none."""
        return self.solutions[0] if self.reachable and self.solutions else None

    @property
    def lowest(self) -> Option:
        """Option with the least value of the first required quantity."""
        return min(self.tried, key=lambda option: option.reached)

    @property
    def highest(self) -> Option:
        """Option with the greatest value of the first required quantity."""
        return max(self.tried, key=lambda option: option.reached)

    @property
    def is_ranked(self) -> bool:
        """Whether the table ranks materials or lists whole numbers."""
        return any(each.among or (each.whole and self.least is None) for each in self.parameters)

    @property
    def reachable(self) -> bool:
        """Whether there is a solution."""
        limits_alone = self.requirements[0].sign != "=" and self.least is None and not self.is_ranked
        return bool(self.intervals or (self.solutions and not limits_alone))

    @property
    def spanned(self) -> bool:
        """Whether the first target lies between the least and the greatest value of its quantity."""
        return self.lowest.reached <= self.requirements[0].value <= self.highest.reached

    @property
    def why(self) -> str:
        """The reason why there is no solution, in a sentence; empty if there is one."""
        if self.reachable:
            return ""
        target = self.requirements[0]
        bound = si(target.value, target.quantity.unit, 6)
        if self.least is not None:
            return self._violation_text()
        if self.spanned and self.is_ranked:
            return f"no {self.varied} gives {bound}, although it is within the reachable range"
        if self.spanned:
            return f"no value gives {bound} exactly, although it is within the reachable range: it jumps there"
        below = target.sign == "<=" or (target.sign == "=" and target.value < self.lowest.reached)
        name, option = ("least", self.lowest) if below else ("greatest", self.highest)
        nearest = f"{self.format(option, target.quantity)} at {self.value_text(option)}"
        return f"{bound} is out of reach: the {name} value found is {nearest}"

    def _violation_text(self) -> str:
        """The requirements that the nearest option violates."""
        nearest = self.nearest
        assert nearest is not None
        excess = {
            each: each.violation(nearest.quantities[each.quantity.name], nearest.errors[each.quantity.name])
            for each in self.requirements
        }
        missed = {each: by + each.tolerance for each, by in excess.items() if by > 0}
        most = max(missed.values(), default=nearest.violation)
        return f"no option meets {' and '.join(map(str, missed))}; the nearest misses by {percent(most)}"

    def front(self, requirement: Requirement) -> list[Option]:
        """Options that no other one surpasses in both the minimised quantity and the required one (Pareto front)."""
        name, sense = requirement.quantity.name, -1.0 if requirement.sign == ">=" else 1.0
        least = self.least or name
        front: list[Option] = []
        for option in sorted(self.tried, key=lambda each: (each.quantities[least], sense * each.quantities[name])):
            if not front or sense * option.quantities[name] < sense * front[-1].quantities[name]:
                front.append(option)
        return front

    def _table(self, name: str) -> Table | None:
        options: tuple[Option, ...] = getattr(self, name)
        if not options:
            return None
        units = {each.name: each.unit for each in self.parameters if not each.among}
        units |= {each.name: each.unit for each in self.quantities}
        columns: dict[str, Any] = {
            each.name: [option.values[index] for option in options] for index, each in enumerate(self.parameters)
        }
        columns |= {each.name: [option.quantities[each.name] for option in options] for each in self.quantities}
        return along("option", range(len(options)), columns, units)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``design --json`` prints: SI floats."""
        document = asdict(evolve(self, tried=(), requirements=(), quantities=()))
        del document["tried"], document["quantities"]
        document["requirements"] = [
            {"quantity": each.quantity.name, "unit": each.quantity.unit, "sign": each.sign, "value": each.value}
            for each in self.requirements
        ]
        return {**VERSION, **document, "evaluations": len(self.tried), "reachable": self.reachable, "why": self.why}

    def __str__(self) -> str:
        return render(self, "shockwave.studies.design_text:text_of_design")

    @property
    def varied(self) -> str:
        """The parameters in printed form; the whole name beside an equally named quantity."""
        labels = {each.label for each in self.quantities}
        names = [
            each.name.replace(".", " ").replace("_", " ") if each.label in labels else each.label
            for each in self.parameters
        ]
        return ", ".join(names)

    @property
    def required(self) -> str:
        """The requirements in printed form."""
        return " and ".join(map(str, self.requirements))

    def value_text(self, option: Option) -> str:
        """The values of an option in printed form, the only one with its error."""
        pairs = zip(self.parameters, option.values, strict=True)
        return ", ".join(each.format(value, option.value_error) for each, value in pairs)

    def format(self, option: Option, quantity: Quantity) -> str:
        """A quantity of an option in printed form, with the digits that its error leaves."""
        value, error = option.quantities[quantity.name], max(option.errors[quantity.name], _FINEST)
        if quantity.unit == "kg":
            return si(1e3 * value, "g", 5)
        return si(value, quantity.unit, error=error if math.isfinite(error) else 1.0)
