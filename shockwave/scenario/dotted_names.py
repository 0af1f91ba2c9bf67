"""Values of a scenario by their dotted names, such as ``shock.parameters.decay_exponent``."""

from __future__ import annotations

import re
import typing
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from attrs import frozen

from shockwave.base.errors import InvalidValueError, ShockwaveError, hint_of
from shockwave.base.quantity_fields import text_of
from shockwave.registry.registry import find, load
from shockwave.scenario.block_keys import (
    BLOCKS,
    SHOCK,
    Key,
    has_chain_blocks,
    hint_instead_of,
    parameters_of,
    shock_keys,
)
from shockwave.scenario.value_conversion import convert


@frozen
class Variable:
    """A value of a scenario that can be varied.

    Attributes
    ----------
    name : str
        Its dotted name.
    key : Key
        Its type, unit and range.
    """

    name: str
    key: Key

    @property
    def unit(self) -> str | None:
        """SI unit, empty for a dimensionless number; None for a value that is not a number."""
        if self.key.spec is not None:
            return None if self.key.spec.samples else self.key.spec.unit
        kinds = set(typing.get_args(self.key.annotation)) - {type(None)} or {self.key.annotation}
        return "" if kinds <= {float, int} else None

    @property
    def whole(self) -> bool:
        """Whether it is a whole number."""
        return self.key.annotation is int if self.key.spec is None else self.key.spec.whole

    def convert(self, content: Any) -> Any:
        """``content``, as written in a scenario, converted: a float in SI units if it has a unit."""
        return convert(self.key, content)


def name_in_words(name: str) -> str:
    """Dotted name in words, without brackets: ``granules[1].diameter.to`` is "segment 1 last diameter"."""
    for key, word in (("from", "first"), ("to", "last")):
        name = re.sub(rf"(\w+)\.{key}$", rf"{word} \1", name)
    return re.sub(r"[\[\]._]+", " ", name.replace("granules[", "segment[").replace("parameters.", "")).strip()


def variable(name: str, data: Mapping[str, Any], fits: Callable[[str], bool] = bool) -> Variable:
    """The variable ``name``.

    Parameters
    ----------
    name : str
        Its dotted name.
    data : mapping
        Content of the document, because the parameters of a shock depend on its profile.
    fits : callable
        Whether the caller can use a name; messages list only such names.

    Raises
    ------
    InvalidValueError
        When a scenario has no such key.
    """
    all_variables = variables(data)
    if name not in all_variables:
        names = [other for other in all_variables if fits(other)]
        hint = hint_instead_of(str(name)) or hint_of(str(name), names)
        raise InvalidValueError(f"must be the dotted name of a key (got {text_of(name)}; {hint})")
    return all_variables[name]


def variables(data: Mapping[str, Any], profiles: Sequence[Any] = ()) -> dict[str, Variable]:
    """All variables by their names, including the parameters of further ``profiles``."""
    shock = data.get("shock")
    own = shock.get("profile") if isinstance(shock, Mapping) else None
    of_shock: list[Key] = []
    parameters: list[Key] = []
    for name in (own, *profiles):
        with suppress(ShockwaveError):  # reported at the place of the name
            if isinstance(name, str):
                cls = load("profiles", name)
                of_shock += shock_keys(cls)
                parameters += parameters_of(find("profiles", name).name, cls)
    by_name: dict[str, Variable] = {}
    for block, keys in (BLOCKS | {"shock": (*of_shock, *SHOCK), "shock.parameters": tuple(parameters)}).items():
        for key in keys:
            name = f"{block}.{key.name}"
            by_name.setdefault(name, Variable(name, key))
    del by_name["shock.parameters"]
    if has_chain_blocks(data):
        from shockwave.scenario.chain_blocks import keys_below  # not needed for a shock on equal granules

        by_name |= {name: Variable(name, key) for name, key in keys_below(data)}
    return by_name
