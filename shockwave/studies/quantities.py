"""Quantities that designs and uncertainties read from simulations, and requirements on them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, Literal, cast

from attrs import frozen

from shockwave.base import quantities as table
from shockwave.base.errors import Fault, InvalidValueError, hint_of, locate
from shockwave.base.quantities import Quantity, contact_forces
from shockwave.base.quantity_fields import Declaration, text_of
from shockwave.base.text import si
from shockwave.scenario.block_keys import Key
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.value_conversion import convert
from shockwave.scene.force_limit import BAR, SPRING, WALL, WAVE
from shockwave.scene.layout import mass_and_length
from shockwave.scene.solitary_wave import SolitaryWave
from shockwave.scene.yielding import UNJUDGED
from shockwave.simulation.recording import select_contacts

_LISTED = re.compile(r"(contacts|sensors)\[(\d+)\]\.(peak_force|peak|arrival|width|impulse|speed|greatest)")
_LISTS = {"contacts": "the reported contacts, which simulate.contacts sets", "sensors": "sensors, simulate.sensors"}
_OF_LIMIT = table.LEADING_WAVE[:2]
_OF_FORCES = (table.FORCES[0], *table.WALL, *table.STRUCTURE, *table.STRIKER, *table.DISSIPATED)
#: Name of the quantity that a limit applies to, by the description of the transmitted force.
LIMITED = {WAVE: _OF_LIMIT[0].name, SPRING: table.STRUCTURE[2].name}
LIMITED |= dict.fromkeys((WALL, BAR), table.WALL[0].name)
# Hint in the error for the mass of an endless chain.
_OR_LEAST = "; or state another quantity to minimise, --least of the command or least in Python"
# Reason in the error for a speed from one sensor to the next; see `FirstPulse.speed_from`.
_NO_SPEED = ": one of the two first pulses is missing or merged with another"
# No property of the leading wave grows faster than the square of its peak force.
_LARGEST_POWER = 2.0
Sign = Literal["<=", ">=", "="]
_REQUIREMENT = re.compile(r"\s*([\w.\[\]][\w.\[\] ]*?(?:\s*/\s*[\w.\[\]]+)?)\s*(<=|>=|=)(?![<>=])\s*(.*\S)\s*")
_FORM = "must be a quantity, <=, >= or =, and a value, such as 'transmitted.peak_force <= 60 N'"
# Least likeness of a name to the one that is suggested for it.
_LIKE = 0.5
# Relative tolerance of an equality of several parameters.
_EQUAL = 1e-3
# Relative tolerance of any requirement for rounding, as of a sum of diameters.
_ROUNDING = 1e-12


def list_reported(scenario: Scenario) -> tuple[Quantity, ...]:
    """Quantities of the contacts and the sensors that a simulation of the scenario reports."""
    count, options = scenario.scene.contact_count, scenario.simulate
    contacts = options.contacts if count is None else select_contacts(options, count)
    return (*contact_forces(contacts), *table.sensor_figures(options.sensors))


def find_target(name: object, reported: Sequence[Quantity], kind: str) -> Quantity:
    """The quantity of this name, or a ratio of two, for a scenario that reports these besides those of all scenarios.

    ``kind`` names it in messages.

    Raises
    ------
    InvalidValueError
        If there is none; the message lists the names.
    """
    targets = targets_of(reported)
    name = next((each.name for each in targets.values() if each.label == name), name)  # a printed name
    if (quantity := table.find_quantity(str(name), targets)) is not None:
        return quantity
    for part in map(str.strip, str(name).split("/")):
        if part not in targets and (listed := _LISTED.fullmatch(part)):
            count = len({each.name.partition("]")[0] for each in reported if each.name.startswith(listed[1])})
            if int(listed[2]) < count:  # it lacks this figure alone
                continue
            rule = f"must count from 0 in the list of {_LISTS[listed[1]]}"
            raise InvalidValueError.of(kind, f"{rule} (got {text_of(name)}; the list has {count})")
    # columns of sweeps and printed names, too, lead to a name; of a list, the first with a figure is named
    distinct = targets_of([*{each.name.rpartition(".")[2]: each for each in reversed(reported)}.values()])
    others = {other: each for each, quantity in distinct.items() for other in (each, quantity.column, quantity.label)}
    likely = next(
        (others[other] for other in get_close_matches(str(name).replace("_", " "), others, 1, _LIKE)), str(name)
    )
    hint = hint_of(likely, list(distinct))
    raise InvalidValueError.of(kind, f"must be a property of the result (got {text_of(name)}; {hint})")


def figures_of(quantity: Quantity, result: Any) -> tuple[float, float] | None:
    """Value and estimated relative error in the result of a simulation; None where the result has no value."""
    if quantity in table.YIELD and any(each.startswith(UNJUDGED) for each in result.first_warnings):
        return None  # other contacts may yield first
    if quantity in table.STEADY_WAVE:
        wave = None if result.peak_force is None else SolitaryWave.of(result.peak_force, result.chain)
        return None if wave is None else (getattr(wave, quantity.name), _LARGEST_POWER * result.error_estimate)
    return quantity.figures(result)


def figures_of_scene(
    quantity: Quantity, scene: Scenario, result: Any, values: Mapping[str, Any], kind: str
) -> tuple[float, float]:
    """Value and relative error in a scene, from the chain or the ``result`` of its simulation.

    ``values`` are those of the varied parameters; ``kind`` names the quantity in messages.

    Raises
    ------
    InvalidValueError
        If the scene has no value, and the message lists the quantities that it has; or if the simulated time ends
        before the wave reaches the wall.
    """
    if quantity in table.GRANULES:
        return mass_and_length(scene.chain, _OR_LEAST * (kind == "least"))[table.GRANULES.index(quantity)], 0.0
    figures = figures_of(quantity, result)
    place = " and ".join(f"{name} is {each if isinstance(each, str) else f'{each:g}'}" for name, each in values.items())
    if quantity in table.WALL and figures and result.options.until and result.arrival_time is None:
        rule = "must be later than the arrival of the wave at the wall"
        until = f"got {result.options.until:g} s, too early where {place}"
        raise InvalidValueError.of("simulate.until", f"{rule} ({until})")
    if figures is None:
        names = ", ".join(
            name for name, each in targets_of(()).items() if each not in table.GRANULES and figures_of(each, result)
        )
        rule = "must be a quantity that the simulation of every scene has"
        why = _NO_SPEED if ".speed" in quantity.name else ""
        got = f"got {quantity.name}, which is null where {place}{why}; known: {names}"
        raise InvalidValueError.of(kind, f"{rule} ({got})")
    return figures


def targets_of(reported: Sequence[Quantity]) -> dict[str, Quantity]:
    """Quantities by their names, for a scenario that reports these besides those of all scenarios."""
    targets = (*table.GRANULES, *_OF_LIMIT, *_OF_FORCES, *table.YIELD, *table.PLASTIC, *table.STEADY_WAVE)
    return {each.name: each for each in (*targets, *reported)}


def quantities_of(scenario: Scenario, result: Any) -> list[Quantity]:
    """Quantities of an uncertainty that a simulation of the scenario reports and that are not zero.

    Where the leading wave has a limit, these are its peak force and amplification, else the forces in the chain; and
    the forces at the contacts and the figures of the sensors that the scenario requests. That of a `Limit` is first.
    """
    limit, judged = scenario.limit, None
    if limit is not None:
        judged = LIMITED.get(limit.force_of(result.leaving).name)
    about = _OF_FORCES if result.peak_force is None else _OF_LIMIT
    options = scenario.simulate
    quantities = (*about, *contact_forces(options.contacts), *table.sensor_figures(options.sensors))
    named = [quantity for quantity in quantities if (figures_of(quantity, result) or (0.0,))[0]]
    return sorted(named, key=lambda quantity: quantity.name != judged)


# ---------------------------------------------------------------- requirements


def split_requirement(text: object, kind: str) -> tuple[str, Sign, str]:
    """Name, sign and value of text such as ``transmitted.peak_force <= 60 N``; ``kind`` names it in messages.

    Raises
    ------
    InvalidValueError
        If it has another form.
    """
    parts = _REQUIREMENT.fullmatch(str(text))
    if parts is None:
        raise InvalidValueError.of(kind, f"{_FORM} (got {text_of(text)})")
    name, sign, value = parts.groups()
    return name, cast(Sign, sign), value


@frozen
class Requirement:
    """A quantity that must be below or above a value, or equal to it.

    Attributes
    ----------
    quantity : Quantity
        The quantity.
    sign : "<=", ">=" or "="
        The relation.
    value : float
        The value [SI unit of the quantity], above 0.
    kind : "target" or "budget"
        Argument that states it.
    """

    quantity: Quantity
    sign: Sign
    value: float
    kind: str = "target"

    @classmethod
    def of(cls, name: str, sign: Sign, value: object, reported: Sequence[Quantity], kind: str) -> Requirement:
        """Convert a name and a value, a number in SI units or text; ``kind`` names the argument in messages.

        Raises
        ------
        InvalidValueError
            If the quantity is unknown, or the value is not above 0.
        """
        quantity = find_target(name, reported, kind)
        with locate(lambda fault: Fault((kind,), f"{quantity.name} {fault.problem}")):
            number = float(convert(Key(name, spec=Declaration(quantity.unit.replace(" ", "*"), "", above=0)), value))
        return cls(quantity, sign, number, kind)

    def violation(self, value: float, error: float, margin: float = 0.0) -> float:
        """Relative violation by a ``value`` of this relative ``error``; the requirement holds if it is not above 0.

        The ``margin`` is added to the error of a simulated value.
        """
        ratio, wide = value / self.value, error + margin if error else 0.0
        if self.sign == "=":
            return abs(ratio - 1) + wide - _EQUAL
        excess = ratio * (1 + wide) - 1 if self.sign == "<=" else 1 - ratio * (1 - wide)
        return excess if excess > _ROUNDING else min(excess, 0.0)

    @property
    def tolerance(self) -> float:
        """Relative deviation from the value with which the requirement still holds."""
        return _EQUAL if self.sign == "=" else 0.0

    @property
    def bound(self) -> str:
        """The relation and the value in printed form."""
        return f"{self.sign} {si(self.value, self.quantity.unit or '', 6)}"

    def __str__(self) -> str:
        return f"{self.quantity.label} {self.bound}"
