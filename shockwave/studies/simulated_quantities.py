"""Quantities of simulations, by their names in the document that ``simulate --json`` prints."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from shockwave.errors import InvalidValueError, NumericalError, ShockwaveError, hint_of
from shockwave.fields import text_of
from shockwave.measurement.simulate import simulate_many
from shockwave.quadrature import FloatArray
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.scenario.yaml_document import steps_of

# Name -> SI unit and label. The name of a contact has its place in the list of the reported contacts.
_QUANTITIES = {
    "greatest_force.peak_force": ("N", "greatest force"),
    "transmitted.peak_force": ("N", "wall force"),
    "transmitted.impulse": ("N*s", "wall impulse"),
    "peak_force": ("N", "peak force"),
    "amplification": ("", "amplification"),
    "restitution": ("", "restitution"),
    "dissipated_energy": ("J", "dissipated energy"),
}
_CONTACT = re.compile(r"contacts\[(\d+)\]\.peak_force")


class Quantity(NamedTuple):
    """A quantity of a simulation: its name, SI unit, and label in printed form."""

    name: str
    unit: str
    label: str

    @classmethod
    def named(cls, name: str, contacts: Sequence[int] = (), others: Iterable[str] = ()) -> Quantity:
        """The quantity of this name, for a scenario that reports these contacts.

        Raises
        ------
        InvalidValueError
            If there is none; the message lists the names, and ``others`` before them.
        """
        if name in _QUANTITIES:
            return cls(name, *_QUANTITIES[name])
        place = _CONTACT.fullmatch(str(name))
        if place and int(place[1]) < len(contacts):
            return cls(name, "N", f"force at contact {contacts[int(place[1])]}")
        if place:
            rule = "must count from 0 in the list simulate.contacts of the scenario"
            got = f"got {text_of(name)}; the list has {len(contacts)}"
            raise InvalidValueError.of("target", f"{rule} ({got})")
        known = [*others, *_QUANTITIES, *(f"contacts[{index}].peak_force" for index in range(len(contacts)))]
        hint = hint_of(str(name), known)
        raise InvalidValueError.of("target", f"must be a property of the result (got {text_of(name)}; {hint})")

    def read(self, result: Any) -> tuple[float, float] | None:
        """Value and estimated relative error in the result of a simulation; None where the result has no value.

        The error estimate of the nearest forces stands for quantities without one of their own.
        """
        value, error = result, result.error_estimate
        for step in steps_of(self.name):
            error = getattr(value, f"{step}_error", error)
            if isinstance(step, int):
                value = value[step] if step < len(value) else None
            else:
                value = getattr(value, step, None)
            error = getattr(value, "error_estimate", error)
        return None if value is None else (float(value), float(error))


def required(quantity: Quantity, result: Any, values: Mapping[str, Any]) -> tuple[float, float]:
    """Value and estimated relative error of a quantity in the simulation of a scene with these parameters.

    Raises
    ------
    InvalidValueError
        If the result has no value; the message lists the quantities that it has.
    """
    found = quantity.read(result)
    if found is None:
        place = " and ".join(f"{name} is {one if isinstance(one, str) else f'{one:g}'}" for name, one in values.items())
        known = ", ".join(name for name in _QUANTITIES if Quantity.named(name).read(result) is not None)
        rule = "must be a quantity that the simulation of every scene has"
        raise InvalidValueError.of(
            "target", f"{rule} (got {quantity.name}, which is null where {place}; known: {known})"
        )
    return found


def quantities_of(scenario: Scenario, result: Any) -> list[Quantity]:
    """Quantities that a simulation of the scenario reports and that are not zero; contacts only if requested."""
    contacts = scenario.simulate.contacts
    names = [*_QUANTITIES, *(f"contacts[{index}].peak_force" for index in range(len(contacts)))]
    known = [Quantity.named(name, contacts) for name in names]
    return [one for one in known if (one.read(result) or (0.0,))[0]]


def scenes_of(family: Family, values: Mapping[str, FloatArray]) -> list[Scenario]:
    """Scenes of a family, for arrays of shape (n,) by the names of their parameters."""
    rows = zip(*(given.tolist() for given in values.values()), strict=True)
    return [family.scenario(dict(zip(values, row, strict=True))) for row in rows]


def simulations(scenes: Sequence[Scenario], rtol: float) -> list[Any]:
    """Results of scenes that differ in shock, impact and chain.

    Raises
    ------
    InvalidValueError
        If a scene is not valid, such as a chain that must be elastic with forces beyond first yield.
    NumericalError
        If a simulation fails.
    """
    found = simulated(scenes, rtol)
    failed = [result for result in found if isinstance(result, ShockwaveError)]
    if failed and isinstance(failed[0], InvalidValueError):
        raise failed[0]
    if failed:
        raise NumericalError(f"{len(failed)} of {len(found)} simulations failed; the first: {failed[0]}")
    return found


def simulated(scenes: Sequence[Scenario], rtol: float) -> list[Any]:
    """Results of scenes that differ in shock, impact and chain, or their errors."""
    options = scenes[0].simulate
    return simulate_many(
        [scene.excitation for scene in scenes],
        [scene.chain for scene in scenes],
        rtol,
        waves="primary",
        backend=options.backend,
        contacts=options.contacts,
        until=options.until,
    )
