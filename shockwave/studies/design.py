"""The results of a design: targets, the scenes that may meet one, and all values that do."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from attrs import asdict, field, frozen

from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.errors import InvalidValueError, nearest
from shockwave.fields import Quantity, text_of
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.units import to_si
from shockwave.studies.scaling_exponents import Exponents
from shockwave.text import printed

#: Properties of the primary that may be asked for -> its SI unit.
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
    """A quantity of the primary and the value that it is to have.

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
        """The target of a mapping of one name to a number or to text with a unit.

        Raises
        ------
        InvalidValueError
            When the name is unknown or the value is none above 0.
        """
        if not isinstance(given, Mapping) or len(given) != 1:
            rule = 'must be one quantity and its value, {"peak_force": "60 N"}'
            raise InvalidValueError.of("target", f"{rule} (got {text_of(given)})")
        ((name, value),) = given.items()
        if name not in TARGETS:
            hint = nearest(str(name)[:60], TARGETS)
            problem = f"must be a quantity of the primary (got {text_of(name)}; {hint}known: {', '.join(TARGETS)})"
            raise InvalidValueError.of("target", problem)
        path = f"target.{name}"
        try:
            number = to_si(value, TARGETS[name])
        except ValueError as error:
            raise InvalidValueError.of(path, str(error)) from None
        if wrong := Quantity(TARGETS[name], "", above=0).problem(number):
            raise InvalidValueError.of(path, wrong)
        return cls(name, number)

    @property
    def unit(self) -> str:
        """As people write it."""
        return TARGETS[self.name].replace("*", " ")

    def reached(self, peak_force: float, scenario: Scenario) -> float:
        """The quantity in a scene whose primary has this peak force [N]."""
        if self.name == "amplification":
            return peak_force / scenario.shock.peak_force
        return float(getattr(SolitaryWave.of(peak_force, scenario.chain), self.name))

    def distance(self, option: Option) -> float:
        """How far ``option`` is from it: the logarithm of their ratio, without its sign."""
        return abs(math.log(option.reached) - math.log(self.value))

    def power(self, scenario: Scenario) -> float:
        """The power with which it scales with the peak force of the primary alone."""
        # it is a small fraction: what is more is rounding
        return round(math.log2(self.reached(2.0, scenario) / self.reached(1.0, scenario)), 12)


@frozen(kw_only=True)
class Simulated:
    """The outcome of a simulation of the scene itself.

    Attributes
    ----------
    reached : float
        The quantity that is the target.
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
        The quantity that is the target.
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
        Of all granules [kg], if their number is known.
    exponents : Exponents
        Powers with which the peak force scales with what makes the scene.
    simulated : Simulated or None
        Of the scene itself, for solutions and for the nearest.
    value_error : float or None
        Of solutions that are numbers: by how much ``value`` may be off, in its unit; None where that is not known.
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
        Dotted name of the value that was varied, and its unit.
    target : Target
        The property wanted of the primary.
    between : tuple of float, or None
        The interval of the value; None for materials.
    solutions : tuple of Option
        All values in the interval that meet the target, ascending; each was simulated. Among them are ends and turning
        points that miss it by no more than the error allowed, which a warning reports. Materials that meet it within
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
        return printed(self, "shockwave.studies.design_text:why")

    def to_dict(self) -> dict[str, Any]:
        """The document that ``design --json`` prints: SI floats."""
        document = asdict(self, filter=lambda attribute, _: attribute.name != "line")
        target = {"name": self.target.name, "value": self.target.value, "unit": self.target.unit}
        return {**document, "target": target, "reachable": self.reachable, "why": self.why}

    def __str__(self) -> str:
        return printed(self, "shockwave.studies.design_text:design_text")
