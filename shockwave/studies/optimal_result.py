"""The result of an optimal design: requirements, options, the best one, and their text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from attrs import asdict, field, frozen

from shockwave.result_base import VERSION, Result
from shockwave.studies.quantities import Requirement, label_of
from shockwave.tables import Table, along
from shockwave.text import facts, notes, si, strong, table

# Relative error shown for quantities of the chain itself.
_EXACT = 1e-5


@frozen(kw_only=True)
class OptimalOption:
    """A scene with other values of the parameters.

    Attributes
    ----------
    values : tuple of float or str
        Values of the parameters, in SI units or names, in their order.
    quantities, errors : mapping of str to float
        Required quantities in SI units and their estimated relative errors, by their names.
    least : float
        Value of the quantity that is minimised.
    violation : float
        Largest relative violation of a requirement, which holds if it is not above 0.
    verified : bool
        Whether the option was simulated at a tolerance of 1e-8.
    """

    values: tuple[float | str, ...]
    quantities: Mapping[str, float] = field(hash=False)
    errors: Mapping[str, float] = field(hash=False)
    least: float
    violation: float
    verified: bool = False


@frozen(kw_only=True, repr=False)
class OptimalDesign(Result):
    """Option that meets all requirements with the least of a quantity.

    Attributes
    ----------
    scenario : str
        Name of the scenario.
    vary, units : tuple of str
        Names of the parameters and their units.
    requirements : tuple of Requirement
        The requirements.
    least, least_unit : str
        Name of the quantity that is minimised, and its unit.
    best : OptimalOption or None
        Best option; None if none meets all requirements.
    nearest : OptimalOption or None
        Option with the smallest violation, if there is no best one; otherwise None.
    ranking : tuple of OptimalOption
        Best option of each combination of materials, best first; empty if no material varies.
    tried : tuple of OptimalOption
        All options of the search.
    evaluations : int
        Number of simulated scenes.
    warnings : tuple of str
        Sentences on the limits of the result.
    """

    scenario: str
    vary: tuple[str, ...]
    units: tuple[str, ...]
    requirements: tuple[Requirement, ...]
    least: str
    least_unit: str
    best: OptimalOption | None
    nearest: OptimalOption | None
    ranking: tuple[OptimalOption, ...]
    tried: tuple[OptimalOption, ...] = field(repr=False)
    evaluations: int
    warnings: tuple[str, ...]

    @property
    def why(self) -> str:
        """Reason why there is no best option; empty if there is one."""
        nearest = self.nearest
        if nearest is None:
            return ""
        figures = {name: (value, nearest.errors[name]) for name, value in nearest.quantities.items()}
        missed = {one: one.violation(*figures[one.quantity.name]) for one in self.requirements}
        missed = {one: by + one.tolerance for one, by in missed.items() if by > 0}
        most = max(missed.values(), default=nearest.violation)
        return f"no option meets {' and '.join(map(str, missed))}; the nearest misses by {most:.1%}"

    def front(self, requirement: Requirement) -> list[OptimalOption]:
        """Options that no other one surpasses in both the minimised quantity and the required one (Pareto front)."""
        name, sense = requirement.quantity.name, -1.0 if requirement.sign == ">=" else 1.0
        chosen: list[OptimalOption] = []
        for one in sorted(self.tried, key=lambda option: (option.least, sense * option.quantities[name])):
            if not chosen or sense * one.quantities[name] < sense * chosen[-1].quantities[name]:
                chosen.append(one)
        return chosen

    _brief = ("scenario", "vary", "least", "best.least", "tried")
    _tables = (("tried", "option"),)

    def _table(self, name: str) -> Table:
        units = {self.least: self.least_unit, **dict(zip(self.vary, self.units, strict=True))}
        columns: dict[str, Any] = {self.least: [one.least for one in self.tried]}
        columns |= zip(self.vary, zip(*(one.values for one in self.tried), strict=True), strict=True)
        for name, unit in ((one.quantity.name, one.quantity.unit) for one in self.requirements):
            units[name], columns[name] = unit, [one.quantities[name] for one in self.tried]
        return along("option", range(len(self.tried)), columns, units)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``design --json`` prints: SI floats."""
        document = asdict(self, filter=lambda attribute, _: attribute.name not in ("tried", "requirements"))
        document["requirements"] = [
            {"quantity": one.quantity.name, "sign": one.sign, "value": one.value} for one in self.requirements
        ]
        return {**VERSION, **document, "why": self.why}

    def __str__(self) -> str:
        shown = self.best or self.nearest
        assert shown is not None
        lines = [strong(f"{self.scenario or 'design'}: {self.why or self._values(shown)}")]
        details = [("nearest", self._values(shown))] if self.best is None else []
        for one in self.requirements:
            value, error = shown.quantities[one.quantity.name], shown.errors[one.quantity.name]
            reached = si(value, one.quantity.unit.replace("*", " "), error=max(error, _EXACT))
            details.append((one.quantity.label, f"{reached}, required {one.bound}"))
        details += [
            ("minimised", self.least_label),
            ("simulations", f"{self.evaluations}, the answer verified at 1e-8"),
        ]
        lines += facts(details)
        if self.ranking:
            header = (*(name.rpartition(".")[2] for name in self.vary), self.least_label, "")
            lines += ["", table(header, [self._row(one) for one in self.ranking])]
        return "\n".join([*lines, *notes(self.warnings)])

    @property
    def least_label(self) -> str:
        """The quantity that is minimised in printed form."""
        return label_of(self.least)

    def _least(self, option: OptimalOption) -> str:
        if self.least == "chain.mass":
            return si(1e3 * option.least, "g", 4)
        return si(option.least, self.least_unit.replace("*", " "), 4)

    def _values(self, option: OptimalOption) -> str:
        pairs = zip(self.vary, self._texts(option), strict=True)
        values = ", ".join(f"{name.removeprefix('chain.')} {text}" for name, text in pairs)
        return f"{self.least_label} {self._least(option)} with {values}"

    def _texts(self, option: OptimalOption) -> list[str]:
        pairs = zip(option.values, self.units, strict=True)
        return [value if isinstance(value, str) else si(value, unit.replace("*", " "), 5) for value, unit in pairs]

    def _row(self, option: OptimalOption) -> tuple[str, ...]:
        state = "meets all" if option.violation <= 0 else f"misses by {option.violation:.1%}"
        return (*self._texts(option), self._least(option), state)
