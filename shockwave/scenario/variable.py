"""Variables: values of a scenario by their dotted names, such as ``shock.parameters.decay_exponent``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from attrs import evolve, frozen

from shockwave.chain.material import Material
from shockwave.document.reader import Steps
from shockwave.errors import Fault, InvalidValueError, ShockwaveError, nearest
from shockwave.fields import text_of
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.scenario.blocks import CHAIN, Key, keys_of, parameters_of, profile_class, shock_keys
from shockwave.scenario.values import structure

__all__ = ["Variable", "variable"]


@frozen
class Variable:
    """A value of a scenario that may be another in another scene.

    Attributes
    ----------
    name : str
        Its dotted name.
    key : Key
        What it may be.
    """

    name: str
    key: Key

    @property
    def steps(self) -> Steps:
        """The way to it in a document."""
        return tuple(self.name.split("."))

    @property
    def unit(self) -> str | None:
        """SI unit, empty for a number without one; None for what is no number."""
        return None if self.key.spec is None or self.key.spec.samples else self.key.spec.unit

    def value(self, given: Any) -> Any:
        """What ``given``, as a scenario would write it, stands for: a float in SI units where there is a unit.

        Raises
        ------
        InvalidValueError
            When it is of another dimension or kind, or out of range.
        """
        values, wrongs = structure({self.key.name: given}, [evolve(self.key, required=False)])
        if wrongs:
            raise InvalidValueError(Fault(self.name, wrong.problem) for wrong in wrongs)
        return values[self.key.name]


def variable(name: Any, data: Mapping[str, Any], profiles: Sequence[Any] = ()) -> Variable:
    """The variable called ``name``.

    Parameters
    ----------
    name : str
        Its dotted name.
    data : mapping
        What the document holds: which parameters a shock has depends on its profile.
    profiles : sequence of str
        Other profiles whose parameters it may be.

    Raises
    ------
    InvalidValueError
        When a scenario has no such key.
    """
    known = _known(data, profiles)
    key = known.get(name) if isinstance(name, str) else None
    if key is None:
        hint = nearest(name[:60], known) if isinstance(name, str) else ""
        remedy = f"{hint}known: {', '.join(known)}"
        raise InvalidValueError.of("", f"must be the dotted name of a key (got {text_of(name)}; {remedy})")
    return Variable(name, key)


def _known(data: Mapping[str, Any], profiles: Sequence[Any]) -> dict[str, Key]:
    shock = data.get("shock")
    given = shock if isinstance(shock, Mapping) else {}
    blocks: dict[str, Sequence[Key]] = {
        "chain": CHAIN,
        "chain.material": keys_of(Material, leave_out=["name", "source"]),
    }
    keys: list[Key] = []
    parameters: list[Key] = []
    for name in (given.get("profile"), *profiles):
        try:
            cls = profile_class(name) if isinstance(name, str) else None
        except ShockwaveError:  # reported where the name stands
            cls = None
        keys += shock_keys(cls)
        parameters += parameters_of(name, cls) if cls is not None else ()
    blocks |= {"shock": keys, "shock.parameters": parameters}
    blocks |= {"predict": keys_of(Predictor), "simulate": keys_of(SimulateOptions)}
    found = {f"{block}.{key.name}": key for block, keys in blocks.items() for key in keys}
    del found["shock.parameters"]
    return found
