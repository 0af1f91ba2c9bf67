"""Values inside chains and impacts by their dotted names, such as ``chain.granules[1].diameter``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from attrs import evolve

from shockwave.chain.chain import Chain
from shockwave.chain.impact import Impact
from shockwave.chain.material import Material
from shockwave.errors import Fault, InvalidValueError
from shockwave.registry import load
from shockwave.scenario.block_keys import MATERIALS, WALLS
from shockwave.scenario.yaml_document import Steps, steps_of

# Key -> attribute, where they differ.
_ATTRIBUTES = {"diameter": "radius", "wall": "material", "from": "first", "to": "last"}


def replaced(chain: Chain, impact: Impact | None, values: Mapping[str, Any]) -> tuple[Chain, Impact | None]:
    """Chain and impact with other values of the same kind.

    Parameters
    ----------
    chain, impact : Chain, Impact or None
        Chain and impact.
    values : mapping
        Dotted names to values, in SI units; those of materials may be names or mappings.

    Raises
    ------
    InvalidValueError
        If a value gives no valid chain or impact, or does not exist in them.
    """
    found: dict[str, Any] = {"chain": chain, "impact": impact}
    # a material before its constants
    for name in sorted(values, key=len):
        try:
            found = _replaced(found, steps_of(name), values[name], found["chain"])
        except InvalidValueError as error:
            raise InvalidValueError(Fault(name, fault.problem) for fault in error.faults) from None
    return found["chain"], found["impact"]


def value_at(chain: Chain, impact: Impact | None, name: str) -> Any:
    """Value of a dotted name in a chain or an impact; a number in SI units, or a material.

    Raises
    ------
    InvalidValueError
        If it does not exist.
    """
    part: Any = {"chain": chain, "impact": impact}
    steps = steps_of(name)
    for step in steps:
        part = _inner(part, step, chain)
    return 2 * part if "diameter" in steps else part


def _replaced(part: Any, steps: Steps, value: Any, chain: Chain) -> Any:
    """``part`` with another value at a path below it."""
    step, rest = steps[0], steps[1:]
    if rest:
        halved = value / 2 if step == "diameter" else value
        value = _replaced(_inner(part, step, chain), rest, halved, chain)
    elif step == "diameter":
        value = value / 2
    elif step in MATERIALS:
        value = _material(value)
    if isinstance(part, dict):
        return part | {step: value}
    if isinstance(part, tuple):
        return tuple(value if index == step else one for index, one in enumerate(part))
    # other constants make another material
    own = {"name": "", "source": ""} if isinstance(part, Material) else {}
    return evolve(part, **own, **{_ATTRIBUTES.get(str(step), str(step)): value})


def _inner(part: Any, step: str | int, chain: Chain) -> Any:
    """The part at ``step``; for a size or a material that is not given, that of the chain."""
    try:
        if isinstance(part, dict):
            return part[step]
        if isinstance(part, tuple):
            return part[int(step)]
        name = _ATTRIBUTES.get(str(step), str(step))
        found = getattr(part, name)
        return getattr(chain, name) if found is None and name in ("material", "radius") else found
    except (LookupError, ValueError, AttributeError):
        raise InvalidValueError.of("", "must be a value of the chain or the impact (got none here)") from None


def _material(value: Any) -> Any:
    if isinstance(value, Mapping):
        return Material(**value)
    return load("materials", value) if isinstance(value, str) and value not in WALLS else value
