"""Variables: values of a scenario by their dotted names, such as ``shock.parameters.decay_exponent``."""

from __future__ import annotations

import typing
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from attrs import frozen

from shockwave.errors import Fault, InvalidValueError, ShockwaveError, nearest
from shockwave.fields import text_of
from shockwave.scenario.keys import BLOCKS, Key, parameters_of, profile_class, shock_keys
from shockwave.scenario.value_conversion import WrongsError, converted
from shockwave.scenario.yaml_document import Steps


@frozen
class Variable:
    """A value of a scenario that may be another in another scene.

    Attributes
    ----------
    name : str
        Its dotted name.
    key : Key
        What it may be.
    others : tuple of Key
        What else, where other profiles have a parameter of this name too.
    """

    name: str
    key: Key
    others: tuple[Key, ...] = ()

    @property
    def steps(self) -> Steps:
        """The way to it in a document."""
        return tuple(self.name.split("."))

    @property
    def unit(self) -> str | None:
        """SI unit, empty for a number without one; None for what is no number."""
        if self.key.spec is not None:
            return None if self.key.spec.samples else self.key.spec.unit
        kinds = set(typing.get_args(self.key.annotation)) - {type(None)} or {self.key.annotation}
        return "" if kinds <= {float, int} else None

    @property
    def whole(self) -> bool:
        """Whether it is a whole number."""
        return self.key.annotation is int if self.key.spec is None else self.key.spec.whole

    def value(self, given: Any) -> Any:
        """What ``given``, as a scenario would write it, stands for: a float in SI units where there is a unit.

        Raises
        ------
        InvalidValueError
            When it is of another dimension or kind, or out of range.
        UnknownNameError
            When nothing has that name.
        """
        try:
            return self.converted(given)
        except WrongsError as error:
            raise InvalidValueError(Fault(self.name, str(wrong.problem)) for wrong in error.wrongs) from None
        except ValueError as error:
            raise InvalidValueError.of(self.name, str(error)) from None

    def converted(self, given: Any) -> Any:
        """As `value`; raises ValueError, or `WrongsError`, for a wrong one."""
        for key in self.others:
            with suppress(ValueError):
                return converted(key, given)
        return converted(self.key, given)


def variable(
    name: Any, data: Mapping[str, Any], profiles: Sequence[Any] = (), fits: Callable[[str], bool] = bool
) -> Variable:
    """The variable called ``name``.

    Parameters
    ----------
    name : str
        Its dotted name.
    data : mapping
        What the document holds: which parameters a shock has depends on its profile.
    profiles : sequence of str
        Other profiles whose parameters it may be.
    fits : callable
        Which names are of use to who asks: a message lists these.

    Raises
    ------
    InvalidValueError
        When a scenario has no such key.
    """
    known = variables(data, profiles)
    if not isinstance(name, str) or name not in known:
        listed = [other for other in known if fits(other)]
        hint = nearest(name[:60], listed) if isinstance(name, str) else ""
        remedy = f"{hint}known: {', '.join(listed)}"
        raise InvalidValueError.of("", f"must be the dotted name of a key (got {text_of(name)}; {remedy})")
    return known[name]


def variables(data: Mapping[str, Any], profiles: Sequence[Any] = ()) -> dict[str, Variable]:
    """All variables by their names; see `variable` for the parameters."""
    shock = data.get("shock")
    given = shock if isinstance(shock, Mapping) else {}
    keys: list[Key] = []
    parameters: list[Key] = []
    for name in (given.get("profile"), *profiles):
        try:
            cls = profile_class(name) if isinstance(name, str) else None
        except ShockwaveError:  # reported where the name stands
            cls = None
        keys += (key for key in shock_keys(cls) if key.name != "parameters")
        parameters += parameters_of(name, cls) if cls is not None else ()
    blocks: dict[str, Sequence[Key]] = BLOCKS | {"shock": keys, "shock.parameters": parameters}
    found: dict[str, list[Key]] = {}
    for block, own in blocks.items():
        for key in own:
            alike = found.setdefault(f"{block}.{key.name}", [])
            # ranges of several profiles: at its point each value is held against that of its own
            if key not in alike:
                alike.append(key)
    return {name: Variable(name, key, tuple(others)) for name, (key, *others) in found.items()}
