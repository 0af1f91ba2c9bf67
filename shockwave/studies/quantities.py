"""Quantities of results by their names in the document that ``simulate --json`` prints, and requirements on them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, cast

from attrs import frozen

from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.chain.yielding import UNJUDGED
from shockwave.errors import InvalidValueError, hint_of
from shockwave.fields import Quantity as Number
from shockwave.fields import text_of
from shockwave.measurement.recording import reported_contacts
from shockwave.scenario.block_keys import Key
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.value_conversion import converted
from shockwave.scenario.yaml_document import steps_of
from shockwave.tables import unit_of
from shockwave.text import si

# Name -> SI unit and label. A contact is named by its index in the list of the reported contacts.
_QUANTITIES = {
    "greatest_force.peak_force": ("N", "greatest force"),
    "transmitted.peak_force": ("N", "wall force"),
    "transmitted.impulse": ("N*s", "wall impulse"),
    "peak_force": ("N", "peak force"),
    "amplification": ("", "amplification"),
    "restitution": ("", "restitution"),
    "dissipated_energy": ("J", "dissipated energy"),
}
_CONTACT = re.compile(r"contacts\[\d+\]\.peak_force")
# Properties of the leading wave that follow from its peak force.
_OF_WAVE = ("momentum", "energy", "speed", "width", "granule_velocity")
#: Properties of the leading wave that can be the target.
TARGETS = ("peak_force", "amplification", *_OF_WAVE)
# Further quantities of a design, which `uncertainty` does not list.
_OF_DESIGNS = {"yield.peak_ratio": ("", "ratio to first yield")} | {
    name: (unit_of(name).replace(" ", "*"), name.replace("_", " ")) for name in _OF_WAVE
}
# No property of the leading wave grows faster than the square of its peak force.
_LARGEST_POWER = 2.0
Sign = Literal["<=", ">=", "="]
_REQUIREMENT = re.compile(r"\s*([\w.\[\]]+)\s*(<=|>=|=)(?![<>=])\s*(.*\S)\s*")
# Relative tolerance of an equality, and of any requirement for rounding, as of a sum of diameters.
_EQUAL = 1e-3
_ROUNDING = 1e-12


def contacts_of(scenario: Scenario) -> tuple[int, ...]:
    """Numbers of the contacts that a simulation of the scenario reports."""
    count = scenario.chain.count
    if count is None:
        return scenario.simulate.contacts
    contacts = count - 1 + (scenario.impact is not None) + (scenario.chain.end is not None)
    return reported_contacts(scenario.simulate, contacts)


class Quantity(NamedTuple):
    """A quantity of a simulation: its name, SI unit, and label in printed form."""

    name: str
    unit: str
    label: str

    @classmethod
    def named(cls, name: str, contacts: Sequence[int], others: Iterable[str], kind: str) -> Quantity:
        """The quantity of this name, for a scenario that reports these contacts; ``kind`` names it in messages.

        Raises
        ------
        InvalidValueError
            If there is none; the message lists the names, and ``others`` before them.
        """
        known = _known(contacts)
        if str(name) in known:
            return known[str(name)]
        if _CONTACT.fullmatch(str(name)):
            rule = "must count from 0 in the list of the reported contacts, which simulate.contacts sets"
            raise InvalidValueError.of(kind, f"{rule} (got {text_of(name)}; the list has {len(contacts)})")
        hint = hint_of(str(name), list(dict.fromkeys((*others, *_known(contacts[:1])))))
        raise InvalidValueError.of(kind, f"must be a property of the result (got {text_of(name)}; {hint})")

    def read(self, result: Any) -> tuple[float, float] | None:
        """Value and estimated relative error in the result of a simulation; None where the result has no value.

        A quantity without an error estimate takes that of the innermost part of the result that has one.
        """
        if self.name.startswith("yield") and any(each.startswith(UNJUDGED) for each in result.warnings):
            return None  # other contacts may yield first
        value, error = result, result.error_estimate
        if self.name in _OF_WAVE:
            wave = None if result.peak_force is None else SolitaryWave.of(result.peak_force, result.chain)
            return None if wave is None else (float(getattr(wave, self.name)), _LARGEST_POWER * error)
        for step in steps_of(self.name):
            error = getattr(value, f"{step}_error", error)
            if isinstance(step, int):
                value = value[step] if step < len(value) else None
            else:
                value = getattr(value, "yielding" if step == "yield" else step, None)
            error = getattr(value, "error_estimate", error)
        return None if value is None else (float(value), float(error))


#: Quantities of the chain, which need no simulation.
OWN = {
    one.name: one for one in (Quantity("chain.mass", "kg", "chain mass"), Quantity("chain.length", "m", "chain length"))
}


def label_of(name: str) -> str:
    """A quantity of a simulation, or another property of the leading wave or the chain, in printed form."""
    return (_QUANTITIES | _OF_DESIGNS).get(name, ("", name.removeprefix("chain.").replace("_", " ")))[1]


def _known(contacts: Sequence[int]) -> dict[str, Quantity]:
    """Quantities by their names, for a scenario that reports these contacts."""
    forces = {f"contacts[{i}].peak_force": ("N", f"force at contact {contact}") for i, contact in enumerate(contacts)}
    return {name: Quantity(name, *about) for name, about in (_QUANTITIES | _OF_DESIGNS | forces).items()}


def required(quantity: Quantity, result: Any, values: Mapping[str, Any], kind: str = "target") -> tuple[float, float]:
    """Value and estimated relative error of a quantity in the simulation of a scene with these parameters.

    ``kind`` names the quantity in messages.

    Raises
    ------
    InvalidValueError
        If the result has no value, and the message lists the quantities that it has; or if the simulated time ends
        before the wave reaches the wall.
    """
    found = quantity.read(result)
    place = " and ".join(f"{name} is {one if isinstance(one, str) else f'{one:g}'}" for name, one in values.items())
    if quantity.name.startswith("transmitted.") and found and result.options.until and result.arrival_time is None:
        rule = "must be later than the arrival of the wave at the wall"
        got = f"got {result.options.until:g} s, too early where {place}"
        raise InvalidValueError.of("simulate.until", f"{rule} ({got})")
    if found is None:
        known = ", ".join(name for name, one in _known(()).items() if one.read(result) is not None)
        rule = "must be a quantity that the simulation of every scene has"
        raise InvalidValueError.of(kind, f"{rule} (got {quantity.name}, which is null where {place}; known: {known})")
    return found


def quantities_of(scenario: Scenario, result: Any) -> list[Quantity]:
    """Quantities that a simulation of the scenario reports and that are not zero; contacts only if requested."""
    known = [one for name, one in _known(scenario.simulate.contacts).items() if name not in _OF_DESIGNS]
    return [one for one in known if (one.read(result) or (0.0,))[0]]


# ---------------------------------------------------------------- requirements


def parts_of(text: object, kind: str) -> tuple[str, Sign, str]:
    """Name, sign and value of text such as ``transmitted.peak_force <= 60 N``; ``kind`` names it in messages.

    Raises
    ------
    InvalidValueError
        If it has another form.
    """
    parts = _REQUIREMENT.fullmatch(str(text))
    if parts is None:
        rule = "must be a quantity, <=, >= or =, and a value, such as 'transmitted.peak_force <= 60 N'"
        raise InvalidValueError.of(kind, f"{rule} (got {text_of(text)})")
    name, sign, value = parts.groups()
    return name, cast(Sign, sign), value


def positive(name: str, unit: str, given: object) -> float:
    """A value above 0, given as a number in SI units or as text with a unit; ``name`` names it in messages.

    Raises
    ------
    InvalidValueError
        If it is something else.
    """
    try:
        return float(converted(Key(name, spec=Number(unit, "", above=0)), given))
    except ValueError as error:
        raise InvalidValueError.of(name, str(error)) from None


@frozen
class Requirement:
    """A quantity that must be below or above a value, or equal to it within a thousandth.

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
    def of(cls, text: str, kind: str, quantity: Callable[[str, str], Quantity]) -> Requirement:
        """Convert text such as ``transmitted.peak_force <= 60 N``; ``kind`` names the argument in messages.

        Raises
        ------
        InvalidValueError
            If it has another form, the quantity is unknown, or the value is not above 0.
        """
        name, sign, given = parts_of(text, kind)
        found = quantity(name, kind)
        return cls(found, sign, positive(f"{kind}.{name}", found.unit, given), kind)

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
        return f"{self.sign} {si(self.value, self.quantity.unit.replace('*', ' '))}"

    def __str__(self) -> str:
        return f"{self.quantity.label} {self.bound}"
