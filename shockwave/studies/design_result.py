"""The result of a design: target, options, the outcome, and its text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from attrs import asdict, frozen

from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.errors import InvalidValueError, nearest
from shockwave.fields import Quantity, text_of
from shockwave.scenario.block_keys import Key
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.value_conversion import converted
from shockwave.studies.scaling_exponents import Exponents
from shockwave.text import notes, si, table

#: Properties of the primary that a design can ask for -> SI unit.
TARGETS = {
    "peak_force": "N",
    "amplification": "",
    "momentum": "N*s",
    "energy": "J",
    "speed": "m/s",
    "width": "s",
    "granule_velocity": "m/s",
}


@frozen
class Target:
    """A property of the primary and its wanted value.

    Attributes
    ----------
    name : str
        One of `TARGETS`.
    value : float
        In its SI unit.
    """

    name: str
    value: float

    @classmethod
    def of(cls, given: Any) -> Target:
        """Convert a mapping of one name to a number or a text with a unit.

        Raises
        ------
        InvalidValueError
            When the name is unknown or the value is not above 0.
        """
        if not isinstance(given, Mapping) or len(given) != 1:
            rule = 'must be one quantity and its value, {"peak_force": "60 N"}'
            raise InvalidValueError.of("target", f"{rule} (got {text_of(given)})")
        ((name, value),) = given.items()
        if name not in TARGETS:
            hint = nearest(str(name), TARGETS)
            rule = "must be a quantity of the primary"
            raise InvalidValueError.of("target", f"{rule} (got {text_of(name)}; {hint}known: {', '.join(TARGETS)})")
        key = Key(name, spec=Quantity(TARGETS[name], "", above=0))
        try:
            return cls(name, converted(key, value))
        except ValueError as error:
            raise InvalidValueError.of(f"target.{name}", str(error)) from None

    @property
    def unit(self) -> str:
        """The unit in printed form."""
        return TARGETS[self.name].replace("*", " ")

    def reached(self, peak_force: float, scenario: Scenario) -> float:
        """The property in a scene whose primary has this peak force [N]."""
        if self.name == "amplification":
            return peak_force / scenario.shock.peak_force
        return float(getattr(SolitaryWave.of(peak_force, scenario.chain), self.name))

    def distance(self, option: Option) -> float:
        """Absolute logarithm of the ratio of reached to wanted value."""
        return abs(math.log(option.reached / self.value))

    def power(self, scenario: Scenario) -> float:
        """Power of the peak force of the primary with which the property scales."""
        return abs(math.log2(self.reached(2.0, scenario) / self.reached(1.0, scenario)))


@frozen(kw_only=True)
class Simulated:
    """Simulation of the scene of an option.

    Attributes
    ----------
    reached : float
        The target property.
    peak_force : float
        Of the primary [N].
    error_estimate : float
        Relative, of the peak force.
    """

    reached: float
    peak_force: float
    error_estimate: float


@frozen(kw_only=True)
class Option:
    """A scene that differs from the scenario in one value.

    Attributes
    ----------
    value : float or str
        That value: in SI units, or the name of a material.
    reached : float
        The target property.
    peak_force, amplification : float
        Of the primary [N], and over that of the shock.
    error, reached_error : float
        Bounds on the relative error of these two, and of ``reached``.
    momentum, energy, speed, width, granule_velocity : float
        Of the primary [N s], [J], [m/s], [s], [m/s]; as of `SolitaryWave`.
    rise_time : float
        t0/T0, of the shock over the characteristic time of the chain.
    granule_mass, mass_per_length : float
        Of one granule [kg], of the chain [kg/m].
    chain_mass : float or None
        Of all granules [kg], if their number is given.
    exponents : Exponents
        Powers with which the peak force scales with what makes the scene.
    simulated : Simulated or None
        Of the scene itself, for solutions and for the nearest.
    value_error : float or None
        Error of ``value`` in its unit, for numeric solutions; None where it is unknown.
    """

    value: float | str
    reached: float
    peak_force: float
    amplification: float
    error: float
    reached_error: float
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
    simulated: Simulated | None = None
    value_error: float | None = None


@frozen(kw_only=True)
class Design:
    """The outcome of a design.

    Attributes
    ----------
    scenario : str
        Name of the scenario, if it has one.
    vary, unit : str
        Dotted name of the varied value, and its unit.
    target : Target
        The wanted property of the primary.
    between : tuple of float, or None
        The interval of the value; None for materials.
    solutions : tuple of Option
        All values in the interval that meet the target, ascending; each was simulated. Ends and turning points that
        miss it by no more than the allowed error are included, with a warning. Materials count within that error too,
        the nearest first.
    nearest : Option or None
        The option nearest to the target where there is no solution; for materials always.
    least, most : Option
        Where the target property is least and greatest: what can be reached.
    table : tuple of Option
        For a trade-off: values over the interval, ascending; or materials, the nearest first.
    warnings : tuple of str
        Limits of the answer, in sentences.
    """

    scenario: str
    vary: str
    unit: str = ""
    target: Target
    between: tuple[float, float] | None = None
    solutions: tuple[Option, ...]
    nearest: Option | None
    least: Option
    most: Option
    table: tuple[Option, ...]
    warnings: tuple[str, ...]

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
        if self.reachable:
            return ""
        wanted = _si(self.target.value, self.target.unit)
        if self.spanned and self.between is None:
            return f"no material meets {wanted}, which lies between the least and the greatest"
        if self.spanned and self.nearest and self.nearest.simulated:
            made = _si(self.nearest.simulated.reached, self.target.unit)
            rule = f"{wanted} is met by a chain without end alone; simulated as it is, the chain makes {made}"
            return f"{rule} at {self._shown(self.nearest)} (it is too short for this search)"
        if self.target.value < self.least.reached:
            return f"{wanted} is out of reach: the least is {self._at(self.least)}"
        return f"{wanted} is out of reach: the most is {self._at(self.most)}"

    def to_dict(self) -> dict[str, Any]:
        """The document that ``design --json`` prints: SI floats."""
        document = asdict(self)
        document["target"]["unit"] = self.target.unit
        return {**document, "reachable": self.reachable, "why": self.why}

    def __str__(self) -> str:
        wanted = f"{self.target.name.replace('_', ' ')} {_si(self.target.value, self.target.unit)}"
        of = f" of {self.scenario}" if self.scenario else ""
        # materials are in the table already
        found = () if self.between is None else self.solutions or filter(None, [self.nearest])
        rows = [self._row(option) for option in (*found, *self.table)]
        lines = [
            f"design{of}: {self.vary} for {wanted}",
            f"  reachable         {self._at(self.least)} to {self._at(self.most)}",
            f"  solutions         {len(self.solutions) or f'none: {self.why}'}",
        ]
        if not self.solutions and self.nearest is not None:
            lines.append(f"  nearest           {self._at(self.nearest)}")
        lines += [
            "",
            table(list(rows[0]), [list(row.values()) for row in rows]),
            "  (within: error of the value; error: relative bound of the curve; simulated: relative difference)",
        ]
        return "\n".join(lines + notes(self.warnings))

    def _shown(self, option: Option, digits: int = 5) -> str:
        return option.value if isinstance(option.value, str) else _si(option.value, self.unit, digits)

    def _at(self, option: Option) -> str:
        return f"{_si(option.reached, self.target.unit, 5)} at {self._shown(option)}"

    def _row(self, option: Option) -> dict[str, str]:
        """The columns of an option."""
        known = option.simulated
        error = option.value_error
        mass = f"{si(1e3 * option.mass_per_length, 'g', 4)}/m"
        if option.chain_mass is not None:
            mass = si(1e3 * option.chain_mass, "g", 4)
        return {
            self.vary.rpartition(".")[2]: self._shown(option, 8),
            "within": "-" if error is None else _si(float(f"{error:.0e}"), self.unit, 3),
            self.target.name.replace("_", " "): _si(option.reached, self.target.unit),
            "error": f"{option.reached_error:.0e}",
            "simulated": "-" if known is None else f"{known.reached / option.reached - 1:+.0e}",
            "peak force": si(option.peak_force, "N", 6),
            "amplification": f"{option.amplification:.5g}",
            "speed": si(option.speed, "m/s"),
            "width": si(option.width, "s"),
            "granule": si(1e3 * option.granule_mass, "g", 4),
            "chain": mass,
        }


def _si(value: float, unit: str, digits: int = 6) -> str:
    """``value`` with an SI prefix, or bare where there is no unit."""
    return si(value, unit, digits) if unit else f"{value:.{digits}g}"
